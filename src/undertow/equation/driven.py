"""Where an equation takes a driven body, with its sensitivities: one call from a parameter vector to a motion.

Belongs here: the step that an equation and its motion need, the message of a motion without bounds. Does not belong
here: the compiled integrator (driven_kernel.py), holds of the input (input.py), fits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from undertow.equation.algebra import MAX_HIDDEN
from undertow.equation.base_motion import seen_from_earth
from undertow.equation.columns import fading, most_damped, stiffest
from undertow.equation.driven_slots import DRIVEN_SLOT, LUGRE, MOVING
from undertow.equation.input import Drive, MotionSize
from undertow.equation.term import Array
from undertow.errors import IdentificationError

STEPS_PER_PERIOD = 12
"""Largest step of a driven motion, a part of its fastest mode's period (error under 1e-5 of the motion, on Silverbox
6e-6); steps also end at every sample and every knot of the input."""

NO_MOTION = 1e3
"""A displacement this many times the recorded range is no motion of the body any more."""

MOST_STEPS_A_SAMPLE = 200.0
"""Steps a sample beyond which a body is too stiff for its record: its fastest mode would have some 17 periods in a
sample. A search that tries a mass of nearly nothing would else integrate for hours."""

STABLE = 5.0
"""Rate, over the one that its steps are made for, up to which a fourth-order step stays stable with twelve a period."""

MOST_STIFF = 50.0
"""Bristles that follow this many times faster than the body swings are sliding friction; steps get no shorter."""

MOST_BENDS_A_SAMPLE = 50.0
"""Ways over which LuGre's bristles bend, g / sigma0, that a body at its largest speed may go in a sample: beyond them
bristles are dry friction, and steps would follow what no record shows."""


def compiled_integrator() -> Callable[..., Any]:
    """The integrator of driven bodies, compiled where one is asked for first: no campaign of decays waits for it."""
    from undertow.equation.driven_kernel import drive

    return drive


@dataclass(frozen=True)
class DrivenMotion:
    """x, v, a, each (n, 1 + p): the motion and its derivatives by p slots; hidden states (n, q); steps taken.

    Relative to the base, but for the outputs that the drive calls absolute.
    """

    x: Array
    v: Array
    a: Array
    hidden: Array
    steps: int


def fastest_rate(theta: Array, extent: MotionSize) -> float:
    """Fastest rate of a driven equation, rad/s or 1/s, over a motion of that extent; 0 for a free body."""

    def slot(name: str) -> float:
        """Size of a slot's number."""
        return abs(float(theta[DRIVEN_SLOT[name]]))

    size, speed, mass = extent.size, extent.speed, float(theta[DRIVEN_SLOT["mass"]])
    stiffness = stiffest(slot, size) + slot("bw_a")
    damping = most_damped(slot, size, speed) + slot("lg_m")
    damping += slot("wc") + 2.0 * slot("wq") * speed + 3.0 * slot("wc3") * speed**2
    swing = math.sqrt(stiffness / mass)
    rates = [swing, damping / mass / STABLE * 2.0 * math.pi, slot("omega"), *fading(slot)]
    for i in range(1, MAX_HIDDEN + 1):
        rates.append(slot(f"hw{i}") * math.sqrt(1.0 + slot(f"hm{i}") / mass))
    if slot("fb") > 0.0:
        rates.append(min(slot("kb") * speed / slot("fb") / STABLE, MOST_STIFF * swing))
    return max(rates)


def driven_motion(
    theta: Array,
    active: np.ndarray,
    drive_in: Drive,
    times: Array,
    extent: MotionSize,
    steps_per_period: int = STEPS_PER_PERIOD,
) -> DrivenMotion:
    """The motion of a parameter vector (driven_slots.DRIVEN_SLOTS) from times[0], with its sensitivities.

    ``active`` (p,) slots, ``times`` (n,) s, rising. Raises IdentificationError where the mass is not positive, the
    motion leaves every bound, or the body is so stiff that it takes over `MOST_STEPS_A_SAMPLE`.
    """
    mass = float(theta[DRIVEN_SLOT["mass"]])
    if not mass > 0.0 or not np.all(np.isfinite(theta)):
        raise IdentificationError(f"a driven motion needs a positive mass and finite parameters, got {mass:g} kg")
    if theta[DRIVEN_SLOT["ge"]] != 0.0:
        raise IdentificationError(
            f"delayed_echo of gain {theta[DRIVEN_SLOT['ge']]:g} N s/m beside an input is not integrated; leave it out"
        )
    rate = fastest_rate(theta, extent)
    longest = float(times[-1] - times[0]) or 1.0
    step = 2.0 * math.pi / rate / steps_per_period if rate > 0.0 else longest
    if longest > MOST_STEPS_A_SAMPLE * step * times.size:
        raise IdentificationError(
            f"a driven motion of mass {mass:.3g} kg goes at {rate:.3g} rad/s at its fastest and would take "
            f"{longest / step / times.size:.3g} steps a sample, above {MOST_STEPS_A_SAMPLE:g}; give the mass a start "
            "value, or record at a higher rate"
        )
    if theta[DRIVEN_SLOT["memory"]] == LUGRE:
        _must_bend(theta, extent, longest / times.size)
    instants = np.ascontiguousarray(times, dtype=np.float64)
    theta = np.array(theta, dtype=np.float64)
    theta[DRIVEN_SLOT["moving"]] = MOVING[drive_in.mover]
    if drive_in.velocity is not None:
        theta[DRIVEN_SLOT["base_v0"]] = drive_in.velocity_at(instants[:1] - theta[DRIVEN_SLOT["delay"]])[0]
    x, v, a, hidden, count = compiled_integrator()(
        theta, np.ascontiguousarray(active, dtype=np.int64), drive_in.knots, drive_in.pieces,
        drive_in.broken, instants, min(step, longest), NO_MOTION * extent.size,
    )  # fmt: skip
    if count < 0:
        raise IdentificationError(
            f"the driven motion leaves every bound after {-count} steps; a coefficient has the wrong sign"
        )
    return DrivenMotion(*seen_from_earth(theta, active, drive_in, instants, (x, v, a)), hidden, int(count))


def _must_bend(theta: Array, extent: MotionSize, sample_s: float) -> None:
    """IdentificationError where LuGre's bristles are so stiff that no sample sees them bend."""
    stiffness, friction = (float(theta[DRIVEN_SLOT[slot]]) for slot in ("bw_a", "lg_c"))
    bends = extent.speed * sample_s * stiffness / friction
    if bends > MOST_BENDS_A_SAMPLE:
        raise IdentificationError(
            f"lugre with sigma0 {stiffness:.3g} N/m bends over {friction / stiffness:.3g} m, and the body goes "
            f"{bends:.3g} times as far in a sample, above {MOST_BENDS_A_SAMPLE:g}: its friction is dry; use "
            "coulomb_friction, or record at a higher rate"
        )
