"""Structures of real recordings: the building that carries a damper, the pendulum, the ship.

    python -m experiments.hidden_states.real

writes real.json here, which the page takes its last section from. The recordings are those of `configs/recordings`,
read and conditioned by these configs; they are not part of the project, and without them the command says so.

Belongs here: what is asked of each recording, and the answers as plain values. Does not belong here: how a structure
or an oscillator is found.
"""

from __future__ import annotations

import itertools
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.config import load
from undertow.campaign.run import read_and_condition
from undertow.comparison.hidden_modes import coupled_modes
from undertow.comparison.hidden_search import EQUATION_15
from undertow.comparison.hidden_trajectories import (
    LINEAR,
    Hypothesis,
    TrajectoryChoice,
    discover_hidden_on_trajectories,
    effective_values,
    fit_equation,
    weigh,
)
from undertow.conditioning.motion import Motion
from undertow.equation.hydrodynamics import CubicDamping, QuadraticDrag
from undertow.equation.structure import (
    CoulombFriction,
    CubicStiffness,
    QuinticStiffness,
    SineRestoring,
    Stiffness,
    ViscousDamping,
)
from undertow.equation.term import Term
from undertow.likelihood.output_error import Solution
from undertow.uncertainty.intervals import noise_covariance

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = ROOT / "configs" / "recordings"
RECORDINGS = ROOT / ".." / "shared" / "recordings"
RESULT = Path(__file__).resolve().parent / "real.json"

BUILDING = "tmd_two_sensors"
PENDULUM = "rotary_pendulum"
SHIP = "kvlcc2"
PENDULUM_RESTORING: tuple[tuple[Term, ...], ...] = ((SineRestoring(),), (Stiffness(),))
SHIP_RESTORING: tuple[tuple[Term, ...], ...] = (
    (Stiffness(),), (Stiffness(), CubicStiffness()), (Stiffness(), CubicStiffness(), QuinticStiffness()),
)  # fmt: skip
DAMPING: tuple[Term, ...] = (ViscousDamping(), CoulombFriction(), QuadraticDrag(), CubicDamping())


def motions_of(config: str) -> list[Motion]:
    """The conditioned trials of a config."""
    return list(read_and_condition(load(CONFIGS / f"{config}.yaml")).motions)


def building(motions: Sequence[Motion], terms: Sequence[Term]) -> dict[str, Any]:
    """Candidates with their misfits, the oscillator, and the modes that it and the building make together."""
    choice = discover_hidden_on_trajectories(motions, terms)
    fit = choice.fit
    out: dict[str, Any] = {
        "terms": [term.name for term in terms],
        "candidates": [[one.name, one.misfit, one.parameters, one.criterion] for one in choice.candidates],
        "why": list(fit.search.why()),
        "count": fit.count,
        "backed": fit.backed,
    }
    for name in ("ratios", "frequencies", "dampings"):
        out[name] = [[one.value, one.stderr] for one in getattr(fit, name)]
    stiffness = fit.coefficients["stiffness"].value
    found = [(w[0], z[0], r[0]) for r, w, z in zip(out["ratios"], out["frequencies"], out["dampings"], strict=True)]
    out["modes_hz"] = [w / (2.0 * math.pi) for w, _ in coupled_modes(math.sqrt(stiffness), found)]
    out["nrmse"] = _misfit_share(choice)
    return out


def _misfit_share(choice: TrajectoryChoice) -> dict[str, float]:
    """RMS residual over RMS of the displacement's cells, each candidate."""
    spread = float(choice.candidates[0].solution.problem.trials[0].channels[0].values.std())
    return {one.name: rms(one) / spread for one in choice.candidates}


def compare(motion: Motion, restoring: Sequence[tuple[Term, ...]], damping: Sequence[Term]) -> dict[str, Any]:
    """Every restoring law with every subset of damping laws, by output error and the criterion; the best first.

    Equations whose damping feeds the motion are left out.
    """
    solutions: dict[tuple[str, ...], Solution] = {}
    for stiffness in restoring:
        for count in range(1, len(damping) + 1):
            for laws in itertools.combinations(damping, count):
                terms = (*stiffness, *laws)
                solutions[tuple(term.name for term in terms)] = fit_equation([motion], terms)
    n_effective = effective_values(min(solutions.values(), key=lambda one: one.chi2))
    weighed = [
        (names, weigh(" ".join(names), one, n_effective)) for names, one in solutions.items() if not _feeds(one)
    ]
    weighed.sort(key=lambda pair: pair[1].criterion)
    best = weighed[0][1]
    errors = np.sqrt(np.diag(noise_covariance(best.solution)))
    return {
        "trial": motion.name,
        "n_effective": n_effective,
        "numbers": {
            name: [best.solution.value(name), float(errors[best.solution.problem.names.index(name)])]
            for name in weighed[0][0]
        },
        "candidates": [
            [list(names), one.criterion - best.criterion, rms(one), one.solution.outcome] for names, one in weighed
        ],
    }


def _feeds(solution: Solution) -> bool:
    """Whether a damping law has a negative coefficient: it would feed the motion, which no damping does."""
    names = {term.name for term in DAMPING}
    return any(
        value < 0.0 for name, value in zip(solution.problem.names, solution.values, strict=True) if name in names
    )


def rms(candidate: Hypothesis) -> float:
    """RMS of the displacement's residual, in its SI unit."""
    trial = candidate.solution.problem.trials[0]
    return float(np.sqrt(np.mean(candidate.solution.residuals[0][: trial.t.size] ** 2))) * trial.channels[0].sigma


def main() -> int:
    """Run all three and write real.json; 1 where the recordings are absent."""
    if not RECORDINGS.exists():
        print(f"no recordings at {RECORDINGS}; the configs in {CONFIGS} expect them there", file=sys.stderr)
        return 1
    building_motions = motions_of(BUILDING)
    result: dict[str, Any] = {"building": [building(building_motions, LINEAR), building(building_motions, EQUATION_15)]}
    result["pendulum"] = [compare(motion, PENDULUM_RESTORING, DAMPING) for motion in motions_of(PENDULUM)]
    result["ship"] = [compare(motion, SHIP_RESTORING, DAMPING) for motion in motions_of(SHIP)]
    RESULT.write_text(json.dumps(result, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
