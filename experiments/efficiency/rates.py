"""Whether an estimate depends on the sampling rate: one motion with one noise at 100, 250 and 1000 Hz.

    python -m experiments.efficiency.rates       # writes rates.md beside this file

The 1 kHz samples of x and a, noise included, are thinned to 250 Hz and 100 Hz by taking means of 4 and of 10, as a
logger with an ideal low-pass does, and go through conditioning and the group fit of the package.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.recovery.releases import Truth, plant, record
from undertow.conditioning.condition import condition
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.identification import blind
from undertow.identification.problem import Link, ProblemBuilder, TrialOptions
from undertow.recording.recording import Recording

HERE = Path(__file__).parent
MEANS_OF = {1000: 1, 250: 4, 100: 10}
LIMIT_STDERR = 0.3
RELEASES_M = {"long": 0.064, "short": 0.033}
NAMES = ("m_a", "C_d", "c", "mu")
DRAG_UNIT = 485.0
"""rho A / 2 with the report's 0.97 m2, N s2/m2."""


@dataclass(frozen=True)
class Estimate:
    """Values (4,) of m_a, C_d, c, mu and their standard errors at one rate."""

    values: np.ndarray
    stderr: np.ndarray


def thinned(recording: Recording, count: int) -> Recording:
    """Means of ``count`` samples."""
    n = recording.time.size // count

    def means(values: np.ndarray) -> np.ndarray:
        return np.asarray(values[: n * count].reshape(n, count).mean(axis=1))

    channels = {name: means(values) for name, values in recording.channels.items()}
    return replace(recording, time=means(recording.time), channels=channels)


def estimate(truth: Truth, recording: Recording) -> Estimate:
    """m_a, C_d, c, mu of one trial with its nuisances, k known."""
    motion = condition(recording)
    builder = ProblemBuilder()
    for name, start in zip(NAMES, (500.0, 5.0, 500.0, 0.006), strict=True):
        builder.unknown(name, start)
    base = np.zeros(N_SLOTS)
    base[SLOT["mass"]], base[SLOT["k1"]] = 2637.4, truth.k_N_per_m
    factors = (("mass", 1.0), ("q", DRAG_UNIT), ("c1", 1.0), ("fc", truth.normal_force_N))
    links = tuple(Link(SLOT[slot], i, factor) for i, (slot, factor) in enumerate(factors))
    builder.trial(motion, base, links, TrialOptions())
    solution = blind.fit(builder.build())
    return Estimate(solution.values[:4], np.sqrt(np.diag(solution.covariance)[:4]))


def differences(spring: str, depth: float, noise: str, seed: int) -> dict[int, np.ndarray]:
    """(estimate - that at 1 kHz) / stderr, (4,), by rate."""
    truth = plant(spring, depth)
    full = record(truth, RELEASES_M[spring], noise, np.random.default_rng(seed), spring)
    found = {rate: estimate(truth, thinned(full, count)) for rate, count in MEANS_OF.items()}
    return {rate: (e.values - found[1000].values) / found[1000].stderr for rate, e in found.items()}


def main() -> None:
    """Run ten seeds a level and noise, write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--to", type=Path, default=HERE / "rates.md")
    given = parser.parse_args()
    lines = [
        "# Estimates at 100, 250 and 1000 Hz", "",
        f"Largest and median |difference from 1 kHz| in standard errors of m_a, C_d, c, mu; {given.seeds} seeds; the",
        f"limit is {LIMIT_STDERR}. Made by `python -m experiments.efficiency.rates`.", "",
        "| level | noise | 250 Hz: median, largest | 100 Hz: median, largest |", "|---|---|---|---|",
    ]  # fmt: skip
    for spring, depth in (("long", 2.57), ("short", 2.36)):
        for noise in ("N1", "N3"):
            found = [differences(spring, depth, noise, seed) for seed in range(given.seeds)]
            cells = []
            for rate in (250, 100):
                away = np.abs([f[rate] for f in found])
                cells.append(f"{np.median(away):.2f}, {away.max():.2f}")
            lines.append(f"| {spring} {depth:g} m | {noise} | {' | '.join(cells)} |")
    given.to.write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
