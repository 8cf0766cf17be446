"""What the search makes of synthetic harmonic sets that lack a law, or nothing.

    python -m experiments harmonic_set.additions [SEEDS]        # prints the table of docs/driven_measured.md

A body of 2 kg is swept up and down under 1 N in 27 steps each, with 1 mm of noise on both parts of the motion; its
equation is given whole, or without the law that the row names. The last column counts sets in which the law alone was
added, with or without rivals, and its 90 % interval holds the truth. Seeds begin at 100.
"""

from __future__ import annotations

import sys

import numpy as np

import undertow
from undertow.comparison.response_search import discover_response
from undertow.conditioning.harmonic import HarmonicSet
from undertow.equation.driven_laws import find_driven
from undertow.equation.steady_state import SteadyState

INTERVAL_90 = 1.645
"""Standard errors either side that hold 90 % of a Gaussian."""
FREQUENCIES_HZ, NOISE_M, FIRST_SEED = np.linspace(0.55, 1.2, 27), 1e-3, 100
LINEAR = {"stiffness": 50.0, "viscous_damping": 0.6}
BODIES = {
    "": LINEAR,
    "cubic_stiffness": {**LINEAR, "cubic_stiffness": 400.0},
    "quadratic_drag": {**LINEAR, "viscous_damping": 0.3, "quadratic_drag": 3.0},
    "coulomb_friction": {**LINEAR, "coulomb_friction": 0.2},
}
"""Laws of each body by the name of the one that is left out of its equation."""


def states_of(laws: dict[str, float]) -> list[SteadyState]:
    """Both sweeps, up first."""
    ways = ("up", "down")
    found = [undertow.frequency_response(laws, FREQUENCIES_HZ, force=1.0, sweep=w, mass_kg=2.0) for w in ways]  # type: ignore[arg-type]
    return [state for one in found for state in one.states]


def noisy(states: list[SteadyState], seed: int) -> HarmonicSet:
    """The states as measured."""
    noise = NOISE_M * np.random.default_rng(seed).standard_normal((2, len(states)))
    cosine, sine = np.array([(s.cosine, s.sine) for s in states]).T + noise
    rate = 2.0 * np.pi * np.tile(FREQUENCIES_HZ, 2)
    return HarmonicSet(rate, np.ones(rate.size), np.hypot(cosine, sine), np.arctan2(-sine, cosine))


def main() -> None:
    """Print the table, row by row."""
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    n = FREQUENCIES_HZ.size
    along = [np.arange(n), n + np.arange(n)]
    print("| body has | equation lacks | sets | named alone | with rivals | nothing added | another added | in 90 % |")
    print("|---|---|---|---|---|---|---|---|")
    for missing, laws in BODIES.items():
        states = states_of(laws)
        for lacks in ("", *([missing] if missing else [])):
            counts = dict.fromkeys(("alone", "rivals", "nothing", "other", "inside"), 0)
            for seed in range(FIRST_SEED, FIRST_SEED + seeds):
                terms = [find_driven(name) for name in laws if name != lacks]
                found = discover_response(noisy(states, seed), along, terms, {})
                right = found.added == (lacks,)
                rival = not right and len(found.added) == 1 and (found.added[0], lacks) in found.alternatives
                kind = "nothing" if not found.added else "rivals" if rival or (right and found.alternatives) else ""
                counts[kind or ("alone" if right else "other")] += 1
                if right:
                    number = found.best.numbers[f"{lacks}.{find_driven(lacks).coefficient.name}"]
                    counts["inside"] += abs(number.value - laws[lacks]) < INTERVAL_90 * number.stderr
            cells = [missing or "linear laws", lacks or "nothing", str(seeds), *map(str, counts.values())]
            cells[-1] = cells[-1] if lacks else "-"
            print(f"| {' | '.join(cells)} |", flush=True)
