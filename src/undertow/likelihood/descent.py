"""The one Levenberg-Marquardt: damped Gauss-Newton steps between bounds, for whatever has a sum of squares.

Belongs here: steps, damping and when to stop. Does not belong here: residuals (residuals.py, of trajectories;
methods/variable_projection.py, of columns) and where a search starts. The compiled twin for Eq. 15 is eq15_search.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from undertow.recording.recording import Array

LEAST_DIAGONAL = 1e-300
"""Floor of the normal matrix' diagonal: an unknown that moves nothing has a standard error of 1e150."""

LEAST_PIVOT = 1e-30
"""Floor of the scaled diagonal that damping multiplies."""

BESIDE_SINGULAR = 1e-9
"""Damping added where the scaled normal matrix is singular to the last digit."""

ROUNDING = 1e-14
"""Share by which a cost may rise and still be the same."""

LEAST_RELATIVE_GAIN = 1e-10
"""A step that lowers the cost by less than this share of it ends the search."""

LEAST_DAMPING = 1e-15
RAISED_DAMPING = 1e-6
"""What damping is raised to, at least, after a step that led up."""

SHORTENED = 0.5
"""A step that led up is followed by one at most so long, in standard errors: from where it was nothing, damping has to
grow a thousandfold before it is felt, and each time in between would be the same step once more."""

POORLY_FORETOLD = 0.25
WELL_FORETOLD = 0.75
"""Shares of the gain that the normal equations foretell, below which damping grows for the next step, and above which
it becomes less (Marquardt's rule, as in More 1978, doi:10.1007/BFb0067700)."""

HELD_BACK = 4.0
"""By what damping grows there."""

MOST_DAMPING = 1e12
"""Damping at which no step leads down any more: rounding is all that is left."""


class Normals(Protocol):
    """What is known at one set of values: normal matrix (p, p), gradient (p,), half the slope of ``cost``."""

    @property
    def normal(self) -> Array:
        """Normal matrix, (p, p)."""

    @property
    def gradient(self) -> Array:
        """Half the slope of the cost, (p,)."""

    @property
    def cost(self) -> float:
        """What the search makes small."""


P = TypeVar("P", bound=Normals)


@dataclass(frozen=True)
class Rule:
    """How a search goes on and when it ends.

    It ends where no unknown moves by more than ``stop``: in its own standard errors, or, ``in_own_unit``, as it is.
    ``damping`` is the first, relative to the diagonal; a step that leads down multiplies it by ``lower``, another by
    ``higher``. ``farthest`` is the most that any unknown moves at once. The last step, shorter than ``stop``, is taken
    and looked at where the end is to be ``proved``; else the search ends before it.
    """

    iterations: int
    stop: float
    damping: float = 1e-6
    lower: float = 0.1
    higher: float = 8.0
    farthest: float = np.inf
    in_own_unit: bool = False
    proved: bool = True


@dataclass(frozen=True)
class Descent(Generic[P]):
    """Where a search ended: ``values`` (p,), what is known there, iterations, and whether it came to rest."""

    values: Array
    place: P
    iterations: int
    converged: bool


def descend(
    evaluate: Callable[[Array, float], P | None],
    values: Array,
    place: P,
    bounds: tuple[Array, Array],
    rule: Rule,
    widened: Callable[[P], float] | None = None,
) -> Descent[P]:
    """Levenberg-Marquardt from ``values`` (p,) within ``bounds``, where ``place`` is known.

    ``evaluate`` gives the place of other values, or None where there is none or as soon as its cost is known to be
    above the number given. An unknown on a bound stays there while the gradient points outwards. ``widened`` says how
    much larger the unknowns' variances are at a place than its normal matrix has them: ``rule.stop`` is of those, and
    the search also ends with a step that gains less than one of that length would. One as short that gains what a whole
    standard error would was cut short by damping, and the search goes on.
    """
    lower, upper = bounds
    damping = rule.damping
    for iteration in range(1, rule.iterations + 1):
        scale = 1.0 / np.sqrt(np.maximum(np.diag(place.normal), LEAST_DIAGONAL))
        free = ~(((values <= lower) & (place.gradient > 0.0)) | ((values >= upper) & (place.gradient < 0.0)))
        step = damped_step(place, damping, free, scale)
        ahead = np.clip(values + np.clip(step, -rule.farthest, rule.farthest), lower, upper)
        moved = float(np.max(np.abs(ahead - values) / (1.0 if rule.in_own_unit else scale)))
        wide = widened(place) if widened else 1.0
        still = moved < rule.stop * math.sqrt(wide)
        if still and not rule.proved and damping <= rule.damping:
            return Descent(values, place, iteration, True)
        candidate = evaluate(ahead, place.cost * (1.0 + ROUNDING))
        if candidate is not None:
            gained = place.cost - candidate.cost
            damping = _after_a_gain(damping, gained, _foretold(place, ahead - values), rule)
            values, place = ahead, candidate
            least = max(LEAST_RELATIVE_GAIN * place.cost, wide * rule.stop**2 if widened else 0.0)
            cut_short = widened is not None and gained > wide  # by damping: a step of one standard error gains as much
            if gained < least or (still and not cut_short):
                return Descent(values, place, iteration, True)
        else:
            damping = _after_a_loss(place, damping, free, scale, step, rule)
            if still or damping > MOST_DAMPING:
                return Descent(values, place, iteration, True)
    return Descent(values, place, rule.iterations, False)


def _foretold(place: Normals, step: Array) -> float:
    """By how much the cost should fall with a step, were it the parabola that it touches at a place."""
    return -float(step @ (2.0 * place.gradient + place.normal @ step))


def _after_a_gain(damping: float, gained: float, foretold: float, rule: Rule) -> float:
    """Damping after a step that led down."""
    if gained < POORLY_FORETOLD * foretold:
        return damping * HELD_BACK
    return max(damping * rule.lower, LEAST_DAMPING) if gained >= WELL_FORETOLD * foretold else damping


def _after_a_loss(
    place: Normals, damping: float, free: np.ndarray, scale: Array, step: Array, rule: Rule
) -> float:
    """Damping after a step that led up: the next one is at most `SHORTENED` of it."""
    length = float(np.linalg.norm(step / scale))
    while damping <= MOST_DAMPING:
        damping = max(damping * rule.higher, RAISED_DAMPING)
        if np.linalg.norm(damped_step(place, damping, free, scale) / scale) <= SHORTENED * length:
            break
    return damping


def damped_step(place: Normals, damping: float, free: np.ndarray, scale: Array) -> Array:
    """Damped Gauss-Newton step (p,) of the unknowns that are ``free`` to move, solved in units of ``scale`` (p,)."""
    step = np.zeros(place.gradient.size)
    index = np.flatnonzero(free)
    s = scale[index]
    a = place.normal[index[:, None], index] * (s[:, None] * s)
    diagonal = np.maximum(np.diag(a), LEAST_PIVOT)
    a[np.diag_indices(index.size)] += damping * diagonal
    try:
        step[index] = -s * np.linalg.solve(a, s * place.gradient[index])
    except np.linalg.LinAlgError:
        a[np.diag_indices(index.size)] += BESIDE_SINGULAR * diagonal
        step[index] = -s * np.linalg.lstsq(a, s * place.gradient[index], rcond=None)[0]
    return step
