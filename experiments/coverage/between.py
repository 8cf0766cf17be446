"""Do nominal 90 % intervals hold the truth where trials differ by more than their errors, and where they are alike?

    python -m experiments coverage.between          # 600 simulated campaigns, some minutes; writes between.csv, .md

Campaigns of 2, 3, 4 or 6 decays of one body with linear and quadratic damping, noise, no dry trials; the linear damping
of every trial is the body's own times 1 + scatter z. All trials are fitted together, then each alone, and the joint
errors grown as `undertow.fit` and `undertow run` do (uncertainty/disagreement.py). Belongs here: that count, and the
same for single numbers with known errors, on which the test's level was chosen.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
from scipy.stats import chi2

import undertow
from experiments.files import write_rows
from undertow.conditioning.motion import Motion
from undertow.likelihood.fit import Specimen
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import fit_alone, fit_group, group_model, terms_by_name
from undertow.quantities import Estimate
from undertow.uncertainty import disagreement

RESULTS = Path(__file__).with_name("between.csv")
PAGE = Path(__file__).with_name("between.md")
TERMS = terms_by_name(("stiffness", "viscous_damping", "quadratic_drag"))
LAW = {"stiffness": 400.0, "viscous_damping": 2.0, "quadratic_drag": 8.0}
MASS_KG, NOISE_M, FIRST_SEED = 4.0, 3e-4, 7000
NAMES = {"k_N_per_m": 400.0, "c_Ns_per_m": 2.0, "drag_Ns2_per_m2": 8.0}
COUNTS, SCATTERS = (2, 3, 4, 6), (0.0, 0.03, 0.2)
NORMAL_90 = 1.6449

LEVELS = (0.05, 0.32, 1.0)
"""Levels of the test that were compared; at 1 errors always grow."""

RATIOS = (0.0, 0.5, 1.0, 2.0, 5.0)
"""Scatter between trials over a trial's own error, in the numbers on which the level was chosen."""


def trials_of(seed: int, count: int, scatter: float) -> tuple[Motion, ...]:
    """One campaign's decays."""
    rng = np.random.default_rng(seed)
    recordings = []
    for i in range(count):
        own = LAW | {"viscous_damping": LAW["viscous_damping"] * (1.0 + scatter * rng.standard_normal())}
        run = undertow.simulate(own, x0=0.05 + 0.02 * i, mass_kg=MASS_KG, rate_hz=100.0, duration_s=8.0)
        recordings.append(run.recorded(noise_m=NOISE_M, seed=int(rng.integers(2**31)), name=f"r{i}"))
    return tuple(undertow.read(recordings))


def campaign(seed: int, count: int, scatter: float) -> Iterator[tuple[str, Estimate, Estimate]]:
    """Every number of a campaign with the joint fit's own error and with the grown one."""
    motions = trials_of(seed, count, scatter)
    model = group_model(TERMS, motions, Specimen(mass_kg=MASS_KG), None, dry=False, anchored=True)
    options = TrialOptions()
    joint = fit_group(model, motions, options)
    alone = [fit_alone(joint, motion, options).estimates for motion in motions]
    after, _ = disagreement.grown(joint.estimates, alone)
    for name in NAMES:
        yield name, joint.estimates[name], after[name]


def holds(estimate: Estimate, truth: float) -> bool:
    """Whether the nominal 90 % interval holds the truth."""
    return abs(estimate.value - truth) < NORMAL_90 * estimate.stderr


def numbers(draws: int) -> Iterator[tuple[int, float, dict[float, float]]]:
    """Coverage (%) of 90 % intervals of a mean of numbers with known errors, by the level of the test."""
    rng = np.random.default_rng(0)
    for count, ratio in product(COUNTS, RATIOS):
        held = dict.fromkeys(LEVELS, 0)
        for _ in range(draws):
            noise = np.exp(rng.normal(0.0, 0.3, count))
            values = rng.normal(0.0, np.sqrt(noise**2 + ratio**2))
            weights = noise**-2.0
            mean = float(weights @ values / np.sum(weights))
            joint = {"x": Estimate(mean, float(np.sum(weights)) ** -0.5)}
            chance = float(chi2.sf(weights @ (values - mean) ** 2, count - 1))
            after = disagreement.grown_whatever(joint["x"], values, noise)
            for level in LEVELS:
                held[level] += holds(after if chance < level else joint["x"], 0.0)
        yield count, ratio, {level: 100.0 * n / draws for level, n in held.items()}


def table(rows: list[dict[str, object]], draws: int) -> str:
    """The two tables of between.md."""
    out = [
        "# Trials that differ: coverage of nominal 90 % intervals", "",
        "    python -m experiments coverage.between", "",
        "Decays: the joint fit's own errors and the grown ones; c differs from trial to trial, k and drag do not.", "",
        "| trials | scatter of c | c: own, % | c: grown, % | k: own, grown | drag: own, grown | c's error, times |",
        "|---|---|---|---|---|---|---|",
    ]  # fmt: skip
    for count, scatter in product(COUNTS, SCATTERS):
        mine = [r for r in rows if r["trials"] == count and r["scatter"] == scatter]

        def share(name: str, key: str, mine: list[dict[str, object]] = mine) -> str:
            own = [r[key] for r in mine if r["parameter"] == name]
            return f"{100.0 * float(np.mean(np.array(own, dtype=float))):.0f}"

        c = [float(str(r["stderr_grown"])) / float(str(r["stderr"])) for r in mine if r["parameter"] == "c_Ns_per_m"]
        others = [f"{share(n, 'own')}, {share(n, 'grown')}" for n in ("k_N_per_m", "drag_Ns2_per_m2")]
        out.append(
            f"| {count} | {100 * scatter:g} % | {share('c_Ns_per_m', 'own')} | {share('c_Ns_per_m', 'grown')} | "
            f"{' | '.join(others)} | {np.median(c):.2g} |"
        )
    said = f"Single numbers with known errors ({draws} draws a row): coverage by the chance below which errors grow, %"
    out += ["", said, "", "| trials | scatter over error | 0.05 | 0.32 | always |", "|---|---|---|---|---|"]
    for count, ratio, held in numbers(draws):
        out.append(f"| {count} | {ratio:g} | " + " | ".join(f"{held[level]:.0f}" for level in LEVELS) + " |")
    return "\n".join(out) + "\n"


def main() -> None:
    """Count, write between.csv and between.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--campaigns", type=int, default=50, help="a number of trials and scatter")
    parser.add_argument("--draws", type=int, default=500)
    asked = parser.parse_args()
    rows: list[dict[str, object]] = []
    for (count, scatter), i in product(product(COUNTS, SCATTERS), range(asked.campaigns)):
        for name, before, after in campaign(FIRST_SEED + i, count, scatter):
            rows.append({
                "trials": count, "scatter": scatter, "seed": FIRST_SEED + i, "parameter": name,
                "value": f"{before.value:.6g}", "stderr": f"{before.stderr:.4g}", "stderr_grown": f"{after.stderr:.4g}",
                "own": int(holds(before, NAMES[name])), "grown": int(holds(after, NAMES[name])),
            })  # fmt: skip
    write_rows(RESULTS, rows[0], rows)
    PAGE.write_text(table(rows, asked.draws), encoding="utf-8")
