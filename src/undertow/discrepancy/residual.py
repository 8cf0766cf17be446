"""The force that an equation leaves over along a measured motion, with its error band.

    r(t) = M a + sum_i coefficient_i force_i(x, v, a, t),    zero where the equation is complete

on the smoothed x, v, a of one trial, which come from one estimate and belong together. The measured motion need not be
integrated: what is missing is seen where it acts, and not, as in a free run, in everything that comes after.

Belongs here: that force, trial by trial. Does not belong here: what it is made of (shares.py), the free run's residual
(place.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.equation.equation import Equation
from undertow.equation.term import Array, Term
from undertow.errors import IdentificationError

FEWEST_SAMPLES = 20
"""Samples in the window below which a residual force says nothing."""


@dataclass(frozen=True)
class EvenMotion:
    """One trial's smoothed motion from the release on, evenly spaced, about its rest position.

    ``t`` (n,) s after the release; ``x``, ``v``, ``a`` (n,) and their standard errors; ``inside`` (n,) True in the
    motion window. Hidden states need even steps and the whole past.
    """

    name: str
    t: Array
    x: Array
    v: Array
    a: Array
    x_std: Array
    v_std: Array
    a_std: Array
    inside: np.ndarray
    amplitude: float


@dataclass(frozen=True)
class ResidualForce:
    """Residual force of one trial inside its motion window.

    ``t``, ``x``, ``v`` (n,) about the rest position, SI; ``force`` (n,) in N (Nm; per kg where the equation is
    per mass) and its standard error ``force_std`` (n,) from the smoothed motion's.
    """

    t: Array
    x: Array
    v: Array
    force: Array
    force_std: Array

    @property
    def noise(self) -> float:
        """RMS of its standard error."""
        return float(np.sqrt(np.mean(self.force_std**2)))


def even_motion(motion: Motion) -> EvenMotion:
    """A trial's smoothed motion about its rest position on even steps of its own median step."""
    step = motion.step_s
    t = np.arange(motion.t[0], motion.t[-1] + 0.5 * step, step)

    def even(values: Array) -> Array:
        return np.asarray(np.interp(t, motion.t, values), dtype=np.float64)

    start, end = motion.windowed("t")[[0, -1]]
    inside = (t >= start - 0.5 * step) & (t <= end + 0.5 * step)
    x = even(motion.x) - motion.equilibrium.value
    errors = (even(motion.x_std), even(motion.v_std), even(motion.a_std))
    return EvenMotion(motion.name, t, x, even(motion.v), even(motion.a), *errors, inside, motion.amplitude)


def residual_force(motion: Motion, equation: Equation) -> ResidualForce:
    """The force r(t) of one trial against an equation with its numbers, in N.

    The band is first order: each of x, v, a moved by its own standard error, the three in quadrature; a friction's
    jump counts in it where the velocity is not distinct from zero. A constant is not significant: the equation's rest
    position is the motion's own.

    Raises IdentificationError where fewer than 20 samples lie in the window, or a term is not finite along the motion.
    """
    even = even_motion(motion)
    count = int(np.count_nonzero(even.inside))
    if count < FEWEST_SAMPLES:
        raise IdentificationError(
            f"trial {motion.name}: {count} even samples in the motion window; a residual force needs {FEWEST_SAMPLES}: "
            "widen trials.window"
        )
    force = _force(equation, even.x, even.v, even.a, even.t, motion.name)
    band = np.square(_slope(equation, even, "x")) + np.square(_slope(equation, even, "v"))
    band = np.sqrt(band + np.square(equation.total_mass_kg * even.a_std))
    at = even.inside
    return ResidualForce(even.t[at], even.x[at], even.v[at], force[at], band[at])


def term_force(term: Term, even: EvenMotion) -> Array:
    """Force per unit coefficient of one term along an even motion, (n,), from the release on."""
    return np.asarray(term.force(even.x, even.v, even.a, even.t), dtype=np.float64)


def _force(equation: Equation, x: Array, v: Array, a: Array, t: Array, trial: str) -> Array:
    """M a + sum of the terms, added mass being part of M."""
    total = equation.total_mass_kg * a
    for term, coefficient in zip(equation.terms, equation.coefficients, strict=True):
        if term.is_inertia:
            continue
        part = coefficient * term.force(x, v, a, t)
        bad = int(np.count_nonzero(~np.isfinite(part)))
        if bad:
            raise IdentificationError(
                f"trial {trial}: the force of {term.name} is not finite at {bad} of {t.size} samples; look at its "
                f"coefficient {coefficient:g} {term.coefficient.unit} and at the motion"
            )
        total = total + part
    return total


def _slope(equation: Equation, even: EvenMotion, channel: str) -> Array:
    """What a standard error of x or v makes of the algebraic terms' force, (n,)."""
    terms: Sequence[tuple[Term, float]] = [
        (term, c) for term, c in zip(equation.terms, equation.coefficients, strict=True) if term.kind == "force"
    ]
    moved = []
    for side in (1.0, -1.0):
        x = even.x + side * even.x_std if channel == "x" else even.x
        v = even.v + side * even.v_std if channel == "v" else even.v
        moved.append(sum((c * t.force(x, v, even.a, even.t) for t, c in terms if not t.is_inertia), 0.0 * even.x))
    return np.asarray(0.5 * (moved[0] - moved[1]), dtype=np.float64)
