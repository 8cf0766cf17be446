"""Whether an estimate depends on the sampling rate: one motion with one noise at 100, 250 and 1000 Hz.

    python -m experiments efficiency.rates       # four minutes; writes rates.md beside this file
    python -m experiments efficiency.rates --first 10 --to experiments/efficiency/rates_fresh.md

A slower record of the same motion and noise is made from the 1 kHz one in two ways: means of 4 and of 10 samples, as a
logger that averages gives them, and single samples of the motion that carry the mean noise of their neighbours, as a
logger with a clean sampler would. Both hold the 1 kHz record's information; samples thinned with their own noise would
not, and scatter by a standard error whatever the fit. All go through conditioning and a fit of the package, once over
the same stretch of motion, once over the window that the package chooses, which starts up to 20 ms later at 100 Hz.
Differences are in standard errors as the package reports them.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.eq15_campaign.motion import simulate
from experiments.recovery.releases import HOLD_S, Truth, plant, record
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.likelihood import multistart as blind
from undertow.likelihood.problem import Link, Problem, ProblemBuilder, TrialOptions
from undertow.recording.recording import Recording
from undertow.uncertainty.intervals import noise_covariance

IN_MINUTES = "--seeds 1 --to {}/rates.md"
HERE = Path(__file__).parent
MEANS_OF = {1000: 1, 250: 4, 100: 10}
LIMIT_STDERR = 0.3
RELEASES_M = {"long": 0.064, "short": 0.033}
STRETCH_S = {"long": (0.04, 7.1), "short": (0.04, 5.3)}
"""Motion that every rate has in its window, s after the release."""

NAMES = ("m_a", "C_d", "c", "mu")
DRAG_UNIT = 485.0
"""rho A / 2 with the report's 0.97 m2, N s2/m2."""


@dataclass(frozen=True)
class Estimate:
    """Values (4,) of m_a, C_d, c, mu and their standard errors as reported, at one rate."""

    values: np.ndarray
    stderr: np.ndarray


def thinned(recording: Recording, count: int) -> Recording:
    """Means of ``count`` samples."""
    n = recording.time.size // count

    def means(values: np.ndarray) -> np.ndarray:
        return np.asarray(values[: n * count].reshape(n, count).mean(axis=1))

    channels = {name: means(values) for name, values in recording.channels.items()}
    return replace(recording, time=means(recording.time), channels=channels)


def picked(recording: Recording, truth: Truth, x0_m: float, early_s: float, count: int) -> Recording:
    """Single samples of the motion, one in ``count``, with the mean of what the sensors added to its neighbours."""
    exact = held_and_moved(recording, truth, x0_m, early_s)
    clean = replace(recording, channels=exact)
    means, mean_motion = thinned(recording, count), thinned(clean, count)
    middle = slice(count // 2, None, count)
    n = means.time.size
    time = recording.time[middle][:n]
    channels = {
        name: exact[name][middle][:n] + values - mean_motion.channels[name] for name, values in means.channels.items()
    }
    return replace(recording, time=time, channels=channels)


def held_and_moved(recording: Recording, truth: Truth, x0_m: float, early_s: float) -> dict[str, np.ndarray]:
    """Exact x and a at a 1 kHz recording's samples."""
    held = recording.time < HOLD_S - 1e-9
    moved = simulate(truth.body, x0_m, recording.time[~held] - HOLD_S + early_s)
    return {
        "displacement": np.concatenate([np.full(np.count_nonzero(held), x0_m), moved.x]),
        "acceleration": np.concatenate([np.zeros(np.count_nonzero(held)), moved.a]),
    }


def problem(truth: Truth, motion: Motion) -> Problem:
    """m_a, C_d, c, mu of one trial with its nuisances, k known."""
    builder = ProblemBuilder()
    for name, start in zip(NAMES, (500.0, 5.0, 500.0, 0.006), strict=True):
        builder.unknown(name, start)
    base = np.zeros(N_SLOTS)
    base[SLOT["mass"]], base[SLOT["k1"]] = 2637.4, truth.k_N_per_m
    factors = (("mass", 1.0), ("q", DRAG_UNIT), ("c1", 1.0), ("fc", truth.normal_force_N))
    links = tuple(Link(SLOT[slot], i, factor) for i, (slot, factor) in enumerate(factors))
    builder.trial(motion, base, links, TrialOptions())
    return builder.build()


def estimate(truth: Truth, motion: Motion) -> Estimate:
    """m_a, C_d, c, mu of one trial."""
    solution = blind.fit(problem(truth, motion))
    return Estimate(solution.values[:4], np.sqrt(np.diag(noise_covariance(solution))[:4]))


def stretch(motion: Motion, first_s: float, last_s: float) -> Motion:
    """The motion with its window cut to ``first_s`` to ``last_s`` after the release."""
    return replace(motion, inside=motion.inside & (motion.t >= first_s) & (motion.t <= last_s))


def records(truth: Truth, noise: str, seed: int) -> dict[str, Recording]:
    """One release at 1000 Hz, at 250 and 100 Hz as means and as single samples."""
    x0 = RELEASES_M[truth.spring]
    full = record(truth, x0, noise, np.random.default_rng(seed), truth.spring)
    early_s = np.random.default_rng(seed).integers(0, 10) / 1e4  # the first draw of `record`
    out = {"1000": full}
    for rate, count in MEANS_OF.items():
        if count > 1:
            out[f"{rate} means"] = thinned(full, count)
            out[f"{rate} samples"] = picked(full, truth, x0, early_s, count)
    return out


def differences(spring: str, depth: float, noise: str, seed: int) -> dict[tuple[str, bool], np.ndarray]:
    """(estimate - that at 1 kHz) / stderr, (4,), by record, and whether over the same stretch of motion."""
    truth = plant(spring, depth)
    motions = {name: condition(recording) for name, recording in records(truth, noise, seed).items()}
    out = {}
    for same in (True, False):
        found: Mapping[str, Estimate] = {
            name: estimate(truth, stretch(motion, *STRETCH_S[spring]) if same else motion)
            for name, motion in motions.items()
        }
        full = found["1000"]
        out |= {(name, same): (e.values - full.values) / full.stderr for name, e in found.items() if name != "1000"}
    return out


def main() -> None:
    """Run ten seeds a level and noise, write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--to", type=Path, default=HERE / "rates.md")
    given = parser.parse_args()
    kinds = [f"{rate} {how}" for rate in (250, 100) for how in ("means", "samples")]
    lines = [
        "# Estimates at 100, 250 and 1000 Hz", "",
        "|difference from 1 kHz| of m_a, C_d, c, mu in reported standard errors, median and largest of",
        f"{4 * given.seeds} (seeds from {given.first} on); the limit is {LIMIT_STDERR}. Made by "
        "`python -m experiments efficiency.rates`.",
    ]  # fmt: skip
    seeds = range(given.first, given.first + given.seeds)
    found = {
        (spring, depth, noise): [differences(spring, depth, noise, seed) for seed in seeds]
        for spring, depth in (("long", 2.57), ("short", 2.36))
        for noise in ("N1", "N3")
    }
    for same, title in ((True, "The same stretch of motion"), (False, "The windows that the package chooses")):
        lines += ["", f"## {title}", "", f"| level | noise | {' | '.join(kinds)} |", "|---|---|" + "---|" * len(kinds)]
        for (spring, depth, noise), rows in found.items():
            away = [np.abs([row[kind, same] for row in rows]) for kind in kinds]
            cells = " | ".join(f"{np.median(a):.2f}, {a.max():.2f}" for a in away)
            lines.append(f"| {spring} {depth:g} m | {noise} | {cells} |")
        every = np.abs([row[kind, same] for rows in found.values() for row in rows for kind in kinds])
        lines += ["", f"{np.count_nonzero(every > LIMIT_STDERR)} of {every.size} are beyond the limit."]
    given.to.write_text("\n".join(lines) + "\n")
    print("\n".join(lines))
