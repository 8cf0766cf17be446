"""Where a body settles under a harmonic force F cos(w t), or on a base that moves so: the periodic motion, its
fundamental, its sensitivities.

A state (x, v) that one period brings back to itself is found by Newton's method on the period's map (shooting), whose
derivatives the integrator carries along; friction and its events stay exact. With M the map's derivative by the state
and D that by a parameter, the state moves by (I - M)^-1 D with that parameter, and the motion with both. The motion is
stable where no eigenvalue of M is larger than one and their product is smaller.

What a sweep meets is found as a laboratory does: the body goes on from where it was at the frequency before, and only
what it is drawn to is followed, so that the branches of a fold depend on the direction.

Belongs here: steady states of one parameter vector. Does not belong here: their fit (methods/harmonic_set.py), laws
that carry a state of their own from period to period, which are refused there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from undertow.equation.driven import driven_motion
from undertow.equation.driven_slots import DRIVEN_SLOT
from undertow.equation.input import MotionSize, harmonic
from undertow.equation.term import Array
from undertow.errors import IdentificationError
from undertow.quantities import Mover

SAMPLES = 64
"""Samples a period from which a fundamental is summed: of a smooth motion it has then no error but rounding."""

NEWTON_STEPS = 25
CLOSED = 1e-9
"""A period brings the state back to within this share of the motion."""

KEPT = 1e-5
"""A motion of which a period keeps all but this share draws nothing to it: the integrator is no better."""

SETTLING_PERIODS = 40
"""Periods that a sweep gives the body at a frequency before its steady state is looked for."""

MOST_SETTLING = 6
"""So many times more of them where none is found; then there is none of the force's own period."""

NEAR = 0.5
"""A steady motion whose state is further than this share of the motion from the body's is not what it is drawn to."""

NOTHING = np.zeros(0, dtype=np.int64)
_STATE = (DRIVEN_SLOT["x0"], DRIVEN_SLOT["v0"])


@dataclass(frozen=True)
class SteadyState:
    """x = cosine cos(w t) + sine sin(w t) + overtones under F cos(w t): ``rate`` w in rad/s, ``state`` x and v at
    t = 0, ``slopes`` (2, p) the derivatives of cosine and sine by the slots that were asked for."""

    rate: float
    cosine: float
    sine: float
    state: Array
    stable: bool
    slopes: Array

    @property
    def amplitude(self) -> float:
        """Amplitude of the fundamental."""
        return math.hypot(self.cosine, self.sine)

    @property
    def phase(self) -> float:
        """Phase of the fundamental before the force's, rad: negative, x lags."""
        return math.atan2(-self.sine, self.cosine)


def closed_orbit(
    theta: Array, force: float, rate: float, guess: Array, extent: MotionSize, active: np.ndarray = NOTHING,
    mover: Mover = "force",
) -> SteadyState | None:  # fmt: skip
    """The periodic motion next to a ``guess`` of its state (2,) under ``force`` (N) at ``rate`` (rad/s), stable or not;
    None where Newton's method ends at none. ``theta`` are driven_slots.DRIVEN_SLOTS, ``active`` (p,) slots. Where the
    base moves (``mover``), ``force`` is the amplitude of its acceleration, m/s^2, and x is relative to it."""
    period = 2.0 * math.pi / rate
    input_force, times = harmonic(force, rate, 1, mover), np.linspace(0.0, period, SAMPLES + 1)
    slots = np.array([*active, *_STATE], dtype=np.int64)
    theta, state = theta.copy(), np.array(guess, dtype=np.float64)
    size = np.array([extent.size, extent.speed])
    for _ in range(NEWTON_STEPS):
        theta[list(_STATE)] = state
        try:
            motion = driven_motion(theta, slots, input_force, times, extent)
        except IdentificationError:
            return None
        end = np.array([motion.x[-1], motion.v[-1]])
        there, back = end[:, -2:], end[:, 0] - state
        open_part = np.eye(2) - there
        if np.max(np.abs(back) / size) < CLOSED:
            moved = np.linalg.pinv(open_part) @ end[:, 1 : 1 + active.size]
            x = motion.x[:-1]
            slopes = x[:, 1 : 1 + active.size] + x[:, -2:] @ moved
            waves = np.array([np.cos(rate * times[:-1]), np.sin(rate * times[:-1])]) * (2.0 / SAMPLES)
            cosine, sine = waves @ x[:, 0]
            drawn = abs(float(np.linalg.det(there))) < 1.0 - KEPT  # a body that sticks has eigenvalues one and zero
            stable = drawn and bool(np.max(np.abs(np.linalg.eigvals(there))) < 1.0 + CLOSED)
            return SteadyState(rate, float(cosine), float(sine), state, stable, np.asarray(waves @ slopes))
        state = state + np.linalg.pinv(open_part) @ back
        if not np.all(np.isfinite(state)) or np.max(np.abs(state) / size) > 1e3:
            return None
    return None


def settled(
    theta: Array, force: float, rate: float, state: Array, extent: MotionSize, mover: Mover = "force"
) -> SteadyState:
    """The stable motion of the force's period to which the body is drawn from a ``state`` (2,); see `closed_orbit`.

    Raises IdentificationError where it is drawn to none: its motion has another period, none, or no bounds.
    """
    theta, period = theta.copy(), 2.0 * math.pi / rate
    for _ in range(MOST_SETTLING):
        theta[list(_STATE)] = state
        times = np.linspace(0.0, SETTLING_PERIODS * period, SETTLING_PERIODS * 4 + 1)
        motion = driven_motion(theta, NOTHING, harmonic(force, rate, SETTLING_PERIODS, mover), times, extent)
        state = np.array([motion.x[-1, 0], motion.v[-1, 0]])
        late = float(np.max(np.abs(motion.x[-9:, 0]))) or extent.size
        own = MotionSize(late, max(late * rate, float(np.max(np.abs(motion.v[-9:, 0])))))
        found = closed_orbit(theta, force, rate, state, own, NOTHING, mover)
        near = found is not None and np.all(np.abs(found.state - state) < NEAR * np.array([own.size, own.speed]))
        if found is not None and found.stable and near:
            return found
    drive = f"{force:g} {'N' if mover == 'force' else 'm/s^2 of its base'} at {rate / (2.0 * math.pi):.6g} Hz"
    raise IdentificationError(
        f"under {drive} the body comes to no motion of the force's period within {MOST_SETTLING * SETTLING_PERIODS} "
        "periods; leave that frequency out, or change the force"
    )


def swept(
    theta: Array, forces: Array, rates: Array, extent: MotionSize, mover: Mover = "force"
) -> list[SteadyState]:  # fmt: skip
    """Steady states at one frequency after the other, the body going on from the one before, at rest before the
    first; see `closed_orbit`."""
    state = np.zeros(2)
    out = []
    for force, rate in zip(forces, rates, strict=True):
        out.append(settled(theta, float(force), float(rate), state, extent, mover))
        state = out[-1].state
    return out
