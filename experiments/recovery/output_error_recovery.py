"""How well output error, all four trials of a level together, gives back a planted Eq. 15: 100 seeds a level and noise.

    python -m experiments recovery.output_error_recovery        # six minutes

writes output_error_recovery.csv (a row a campaign) and output_error_recovery.md (p90 of the errors beside limits and
bounds) here. Starts are the same for all: 500 kg, 500 N s/m, mu 0.006, C_d 5.

Belongs here: that fit and its table. Does not belong here: recordings (releases.py), the bound (bound.py).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.motion import Floats
from experiments.files import write_rows
from experiments.recovery.bound import bound
from experiments.recovery.releases import LARGEST_DRIFT, NOISE, Truth, plant, record_group
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.likelihood import multistart as blind
from undertow.likelihood.problem import Link, ProblemBuilder, TrialOptions
from undertow.uncertainty.intervals import noise_covariance

IN_MINUTES = "--seeds 2 --out {}"
FOLDER = Path(__file__).resolve().parent
SEEDS = 100
LEVELS = (("long", 2.57), ("short", 2.36))
LIMITS = {"N1": (0.1, 1.0, 0.3, 0.8), "N3": (0.2, 3.0, 0.7, 2.5), "N4": (1.0, 10.0, 2.5, 10.0)}
"""Largest p90 of |error|: m_a in kg, c, mu and C_d in per cent; or 1.3 times the bound where that is larger."""

BOUND_SHARE = 1.3
QUANTITIES = ("added_mass_kg", "c_percent", "mu_percent", "drag_percent")
STARTS = (500.0, 500.0, 0.006, 5.0)
OPTIONS = {
    "with a straight drift": TrialOptions(drift_std=LARGEST_DRIFT["displacement"]),
    "without": TrialOptions(),
}
"""The recordings drift by up to 0.2 mm: with and without an unknown for the line that the fit can take out."""


@dataclass(frozen=True)
class Recovery:
    """One campaign: ``errors`` (4,) in the units of `QUANTITIES`, ``z`` (4,) errors over reported standard errors."""

    errors: Floats
    z: Floats


def recover(truth: Truth, motions: Sequence[Motion], options: TrialOptions) -> Recovery:
    """m_a, c, mu, C_d of a level from all its trials, k known."""
    builder = ProblemBuilder()
    for name, start in zip(QUANTITIES, STARTS, strict=True):
        builder.unknown(name, start)
    base = np.zeros(N_SLOTS)
    base[SLOT["mass"]], base[SLOT["k1"]] = tables.STRUCTURE_MASS_KG, truth.k_N_per_m
    drag = 0.5 * tables.WATER_DENSITY_KG_PER_M3 * tables.REFERENCE_AREA_M2
    factors = (("mass", 1.0), ("c1", 1.0), ("fc", truth.normal_force_N), ("q", drag))
    links = tuple(Link(SLOT[slot], i, factor) for i, (slot, factor) in enumerate(factors))
    for motion in motions:
        builder.trial(motion, base, links, options)
    solution = blind.fit(builder.build())
    away = solution.values[:4] - truth.unknowns
    scale = np.array([1.0, *(truth.unknowns[1:] / 100.0)])
    return Recovery(away / scale, away / np.sqrt(np.diag(noise_covariance(solution))[:4]))


def ninetieth(recoveries: Sequence[Recovery]) -> Floats:
    """p90 of |error| (4,) over the campaigns."""
    p90: Floats = np.quantile([np.abs(one.errors) for one in recoveries], 0.9, axis=0)
    return p90


def limit(noise: str, lowest: Floats) -> Floats:
    """What the p90 may be (4,): the stated number or 1.3 times the bound."""
    return np.maximum(LIMITS[noise], BOUND_SHARE * lowest)


def study(truth: Truth, noise: str, seeds: int) -> dict[str, list[Recovery]]:
    """All campaigns of one level and noise, by how the fit treats drift."""
    out: dict[str, list[Recovery]] = {name: [] for name in OPTIONS}
    for seed in range(seeds):
        motions = [condition(recording) for recording in record_group(truth, noise, seed)]
        for name, options in OPTIONS.items():
            out[name].append(recover(truth, motions, options))
    return out


def line(truth: Truth, noise: str, how: str, recoveries: Sequence[Recovery]) -> str:
    """A row of the table: every cell p90 / limit (bound), bold over the limit; then rms error over stderr."""
    lowest = bound(truth, noise)
    cells = []
    for value, most, least in zip(ninetieth(recoveries), limit(noise, lowest), lowest, strict=True):
        mark = "**" if value > most else ""
        cells.append(f"{mark}{value:.2g}{mark} / {most:.2g} ({least:.2g})")
    ratio = np.sqrt(np.mean([one.z**2 for one in recoveries], axis=0))
    cells.append(", ".join(f"{value:.1f}" for value in ratio))
    return f"| {truth.spring} {truth.water_depth_m:g} m | {noise} | {how} | {' | '.join(cells)} |"


HEADER = """# Recovery of Eq. 15 by output error

p90 of |error| over {seeds} seeds / limit (p90 of the Cramer-Rao bound); bold where it is over the limit. Four trials a
level, 1000 Hz, k known, k, c, mu equal in all trials; noise on x and a: N1 0.05 mm, 0.02 m/s2; N3 0.2 mm, 0.1 m/s2;
N4 1 mm, 0.1 m/s2; drift up to 0.2 mm and 0.02 m/s2, free offsets, 14 bits. The bound takes a straight line and a
parabola of drift in both sensors for unknown, which is more than the fits do: they can lie below it. The last column is
the root mean square of error over reported standard error.

| level | noise | drift | m_a, kg | c, % | mu, % | C_d, % | rms error / stderr |
|---|---|---|---|---|---|---|---|
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the study and write its rows and its table."""
    parser = argparse.ArgumentParser(description="Recovery of Eq. 15 by output error.")
    parser.add_argument("--seeds", type=int, default=SEEDS)
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args(arguments)
    lines, rows = [], []
    for spring, depth in LEVELS:
        truth = plant(spring, depth)
        for noise in NOISE:
            for how, recoveries in study(truth, noise, options.seeds).items():
                lines.append(line(truth, noise, how, recoveries))
                print(lines[-1], file=sys.stderr, flush=True)
                for seed, one in enumerate(recoveries):
                    rows.append([spring, depth, noise, how, seed, *(f"{error:.4f}" for error in one.errors)])
    header = ("spring", "water_depth_m", "noise", "drift", "seed", *QUANTITIES)
    write_rows(options.out / "output_error_recovery.csv", header, rows)
    page = HEADER.format(seeds=options.seeds) + "\n".join(lines) + "\n"
    (options.out / "output_error_recovery.md").write_text(page)
    return 0
