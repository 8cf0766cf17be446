"""Where a decay's energy goes, cycle by cycle: what every law of an equation takes along the measured motion.

    stored(x_n) - stored(x_n+1) = sum_i integral coefficient_i force_i v dt + unexplained

between turning points two apart, where the body stands still and all it holds is the energy of its springs. A hidden
state that oscillates gives energy back in some cycles: what it takes is then negative.

Belongs here: those sums. Does not belong here: their figure (report/), the force itself (residual.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from undertow.conditioning.cycles import find_cycles
from undertow.conditioning.motion import Motion
from undertow.discrepancy.residual import EvenMotion, even_motion, term_force
from undertow.equation.equation import Equation
from undertow.equation.term import Array
from undertow.errors import UndertowError

FAINT = 0.1
"""After the last turning point above this share of the first nothing is reckoned: a hundredth of the energy is left."""

FEWEST_CYCLES = 2
"""Cycles below which there is no budget."""

STEPS = 200
"""Steps of displacement over which a spring's force is summed to its energy."""


@dataclass(frozen=True)
class EnergyBudget:
    """Energy of one trial by full cycle, (n,) each, in J (J/kg where the equation is per mass).

    ``time`` s after the release at which a cycle begins, ``stored`` what the springs hold then, ``lost`` how much less
    they hold a cycle later; ``taken`` what each law takes, by term name; ``error`` one standard error of ``lost``.
    """

    time: Array
    stored: Array
    lost: Array
    taken: Mapping[str, Array]
    error: Array

    @property
    def unexplained(self) -> Array:
        """What is lost and no law takes, (n,)."""
        return np.asarray(self.lost - sum(self.taken.values(), np.zeros_like(self.lost)), dtype=np.float64)

    def share(self, name: str) -> float:
        """What a law takes of all that is lost over the cycles shown; "unexplained" for the rest.

        >>> one = np.ones(2)
        >>> EnergyBudget(one, 4.0 * one, one, {"quadratic_drag": 0.75 * one}, 0.0 * one).share("unexplained")
        0.25
        """
        part = self.unexplained if name == "unexplained" else self.taken[name]
        return float(np.sum(part) / np.sum(self.lost))


def energy_budget(motion: Motion, equation: Equation) -> EnergyBudget | None:
    """The budget of one trial under an equation with its numbers; None where it has fewer than two clear cycles, no
    displacement, or a law that has no force along the measured motion (uneven steps, a force with its own clock)."""
    if "displacement" not in motion.recording.channels:
        return None
    try:
        even = even_motion(motion)
        taken: dict[str, Array] = {}
        for term, coefficient in zip(equation.terms, equation.coefficients, strict=True):
            if coefficient and not term.is_inertia:
                taken[term.name] = taken.get(term.name, 0.0) + coefficient * term_force(term, even)
        at = even.inside
        cycles = find_cycles(even.t[at], even.x[at], even.v[at], even.x_std[at])
    except UndertowError:
        return None
    if not all(np.all(np.isfinite(force)) for force in taken.values()):
        return None
    sizes = np.abs(cycles.position)
    clear = int(np.flatnonzero(sizes > FAINT * sizes[0])[-1]) + 1  # a beat may pass through nothing and come back
    turns = np.arange(0, clear, 2)
    if turns.size <= FEWEST_CYCLES:
        return None
    held = {name for name in taken if _is_spring(equation, name)}
    stored = np.array([_stored(equation, held, x) for x in cycles.position[turns]])
    pull = np.array([_pull(equation, held, x) for x in cycles.position[turns]])
    slope, rest = pull * cycles.position_std[turns], np.diff(pull) * motion.equilibrium.total_stderr
    work = {name: _between(even, force, cycles.time[turns]) for name, force in taken.items() if name not in held}
    error = np.sqrt(slope[:-1] ** 2 + slope[1:] ** 2 + np.nan_to_num(rest) ** 2)
    return EnergyBudget(cycles.time[turns[:-1]], stored[:-1], -np.diff(stored), work, error)


def _is_spring(equation: Equation, name: str) -> bool:
    """Whether a law holds a body that stands still, and gives back all that it takes."""
    term = next(t for t in equation.terms if t.name == name)
    if term.kind != "force":
        return False
    x, none, v = np.array([-1.0, 1.0]), np.zeros(2), np.array([1.0, -1.0])
    still, moving = term.force(x, none, none, none), term.force(x, v, none, none)
    return bool(np.any(still != 0.0) and np.allclose(still, moving))


def _pull(equation: Equation, held: set[str], x: float) -> float:
    """Force of the springs at rest at x, N."""
    one, none = np.array([x]), np.zeros(1)
    pairs = zip(equation.terms, equation.coefficients, strict=True)
    return float(sum(c * t.force(one, none, none, none)[0] for t, c in pairs if t.name in held))


def _stored(equation: Equation, held: set[str], x: float) -> float:
    """Energy of the springs at x, J."""
    grid, none = np.linspace(0.0, x, STEPS + 1), np.zeros(STEPS + 1)
    pairs = zip(equation.terms, equation.coefficients, strict=True)
    force = sum((c * t.force(grid, none, none, none) for t, c in pairs if t.name in held), none)
    return float(np.trapezoid(force, grid))


def _between(even: EvenMotion, force: Array, turns: Array) -> Array:
    """Work of a force (n,) along the motion between instants ``turns`` (m,), (m - 1,), in J."""
    power = force * even.v
    done = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(even.t))])
    return np.asarray(np.diff(np.interp(turns, even.t, done)), dtype=np.float64)
