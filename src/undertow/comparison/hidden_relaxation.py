"""Whether a relaxation is carried along too: a Maxwell element or fluid memory, which a swing forgets without a beat.

    F = z,  z' = k_r x' - z / tau

On one swing it looks like stiffness and damping; what gives it away is the start, when nothing is remembered yet, and
the swing's harmonics. Both are judged on trajectories, beside every static law at once and the oscillators found.

Belongs here: the test for one relaxation and its numbers. Does not belong here: oscillators (hidden_search.py,
hidden_fit.py), relaxations as rivals of oscillators (hidden_search.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.hidden_fit import HiddenFit, as_fit, discover_hidden, hidden_problem
from undertow.comparison.hidden_search import EQUATION_15, RIVALS
from undertow.conditioning.motion import Motion
from undertow.equation.hidden import Relaxation
from undertow.equation.kernel import SLOT
from undertow.equation.structure import AsymmetricFriction
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood import output_error
from undertow.likelihood.output_error import Solution
from undertow.methods.library import label
from undertow.quantities import Estimate
from undertow.uncertainty.intervals import noise_covariance, noise_factors

Array = NDArray[np.float64]

STATIC_RIVALS: tuple[Term, ...] = (*(term for term in RIVALS if term.kind == "force"), AsymmetricFriction())
"""Laws without memory that a relaxation must not stand in for."""

START_ANGLES = (0.3, 1.0, 3.0)
"""Times tried first, in radians of the body's motion: below, a relaxation is damping, above, stiffness."""

START_SHARE = 0.02
"""Stiffness tried first, as a share of the body's."""

ANGLE_RANGE = (0.05, 50.0)
"""Widest times, in radians of the body's motion."""

CRITICAL_GAIN = 25.0
"""Drop of the squared residuals, over how much the residual's slow part exceeds its noise, that a relaxation must bring
beside all rivals."""

AT_BOUND = 1e-2
"""A time within this share of a bound ran into it."""


@dataclass(frozen=True)
class HiddenRelaxation:
    """A relaxation beside the equation and its oscillators, over the inertia that moves with the body.

    ``stiffness`` in N/m / kg and ``time_s``; ``share`` its stiffness over the body's; ``gain`` the drop of the squared
    residuals beside all rivals (without them where that is too little already), in units of noise as it is; ``kept``
    whether it is called a hidden state, ``because`` why or why not; ``fit`` equation and oscillators with it.
    """

    stiffness: Estimate
    time_s: Estimate
    share: float
    gain: float
    kept: bool
    because: str
    fit: HiddenFit


@dataclass(frozen=True)
class HiddenStates:
    """All hidden states found: ``fit`` holds the equation and the oscillators (with the relaxation where one is kept),
    ``relaxation`` the verdict on one; None where a trial begins in motion, for then nothing can be said."""

    fit: HiddenFit
    relaxation: HiddenRelaxation | None

    @property
    def count(self) -> int:
        """Oscillators and relaxations kept."""
        return self.fit.count + int(self.relaxation is not None and self.relaxation.kept)

    def why(self) -> tuple[str, ...]:
        """A sentence for every hidden state tried."""
        return (*self.fit.search.why(), *([] if self.relaxation is None else [self.relaxation.because]))

    def theta(self) -> Array:
        """The integrator's parameter vector over the moving inertia (its mass is 1), x0 and v0 zero."""
        vector = self.fit.theta()
        if self.relaxation is not None and self.relaxation.kept:
            vector[SLOT["rk1"]], vector[SLOT["rt1"]] = self.relaxation.stiffness.value, self.relaxation.time_s.value
        return vector


def discover_states(motions: Sequence[Motion], terms: Sequence[Term] = EQUATION_15) -> HiddenStates:
    """Hidden oscillators (`discover_hidden`), then a relaxation beside them; raises as both do."""
    fit = discover_hidden(motions, terms)
    if not all(motion.window.held for motion in motions):
        return HiddenStates(fit, None)
    relaxation = find_relaxation(motions, fit)
    return HiddenStates(relaxation.fit if relaxation.kept else fit, relaxation)


def find_relaxation(
    motions: Sequence[Motion], fit: HiddenFit, critical_gain: float = CRITICAL_GAIN
) -> HiddenRelaxation:
    """A relaxation beside what ``fit`` found in the same ``motions``, whether kept or not.

    Raises IdentificationError without a stiffness among the terms, and for a trial that begins in motion: what it
    remembers then is not known.
    """
    moving = [motion.name for motion in motions if not motion.window.held]
    if moving or "stiffness" not in fit.coefficients:
        have = ", ".join(fit.coefficients)
        raise IdentificationError(
            f"no relaxation can be looked for in {len(motions)} trials, {len(moving)} of them in motion at the start "
            f"({', '.join(moving) or 'none'}), with the terms {have}; give releases from rest and a stiffness"
        )
    body = float(fit.coefficients["stiffness"].value)
    w = math.sqrt(max(body, np.finfo(float).tiny))
    numbers = np.array([fit.coefficients[label(term)].value for term in fit.terms])
    starts = [(START_SHARE * body, angle / w) for angle in START_ANGLES]
    found = min((_solved(motions, fit, fit.terms, numbers, start) for start in starts), key=lambda one: one.cost)
    gain = (fit.solution.cost - found.cost) / _slow(found)
    if gain >= critical_gain:
        gain = _gain_beside_rivals(motions, fit, found)
    return _judged(motions, fit, found, gain, critical_gain)


def _solved(
    motions: Sequence[Motion], fit: HiddenFit, terms: Sequence[Term], numbers: Array,
    relaxation: tuple[float, float] | None,
) -> Solution:  # fmt: skip
    """Output error of ``terms`` from ``numbers``, the fit's oscillators and a relaxation."""
    oscillators = [
        (w.value, z.value, r.value) for r, w, z in zip(fit.ratios, fit.frequencies, fit.dampings, strict=True)
    ]
    w = math.sqrt(fit.coefficients["stiffness"].value)
    limits = (ANGLE_RANGE[0] / w, ANGLE_RANGE[1] / w)
    problem = hidden_problem(motions, terms, numbers, oscillators, relaxation, limits)
    return output_error.fit(problem, growing=False)


def _slow(solution: Solution) -> float:
    """By how much the residual's slow part exceeds the noise, as variances; at least 1."""
    return float(np.mean([np.mean(factors) for factors in noise_factors(solution)]))


def _gain_beside_rivals(motions: Sequence[Motion], fit: HiddenFit, found: Solution) -> float:
    """What the relaxation still explains where every static rival stands beside the equation."""
    have = {label(term) for term in fit.terms}
    every = (*fit.terms, *(rival for rival in STATIC_RIVALS if label(rival) not in have))
    own, numbers = len(fit.terms), np.zeros(len(every))
    numbers[:own] = [found.value(label(term)) for term in fit.terms]
    start = (max(found.value(Relaxation.name), np.finfo(float).tiny), found.value("relaxation_time"))
    beside = _solved(motions, fit, every, numbers, start)
    numbers[:own] = [fit.coefficients[label(term)].value for term in fit.terms]
    without = _solved(motions, fit, every, numbers, None)
    return (without.cost - beside.cost) / _slow(beside)


def _judged(
    motions: Sequence[Motion], fit: HiddenFit, found: Solution, gain: float, critical_gain: float
) -> HiddenRelaxation:
    """The verdict on the best relaxation."""
    strength, time = _estimate(found, Relaxation.name, "N/m / kg"), _estimate(found, "relaxation_time", "s")
    body = found.value("stiffness")
    share = strength.value / body if body > 0.0 else math.inf
    angle, objection = math.sqrt(fit.coefficients["stiffness"].value) * time.value, ""
    if gain < critical_gain:
        objection = f"the squares fall by {gain:.1f}, less than {critical_gain:g}"
    elif not ANGLE_RANGE[0] * (1.0 + AT_BOUND) < angle < ANGLE_RANGE[1] * (1.0 - AT_BOUND):
        objection = f"its time ran to the bound {time.value:.3g} s"
    text = f"a relaxation of {100.0 * share:.3g} % of the stiffness over {time.value:.3g} s "
    text += f"is refused: {objection}" if objection else f"is kept: beside the rivals the squares fall by {gain:.0f}"
    joint = as_fit(motions, fit.terms, fit.search, found)
    return HiddenRelaxation(strength, time, share, gain, objection == "", text, joint)


def _estimate(solution: Solution, name: str, unit: str) -> Estimate:
    """An unknown with the residual's own noise in its error."""
    place = solution.problem.names.index(name)
    error = math.sqrt(max(float(noise_covariance(solution)[place, place]), 0.0))
    return Estimate(float(solution.values[place]), error, unit=unit, source="hidden")
