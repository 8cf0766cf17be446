"""Pairs of channels that kinematics or a stated specimen ties together, and how far each is from what must be.

    acceleration = x'',  velocity = x',  spring force = k x,  spring force = -(m + m_a) x'',  k = (m + m_a) w^2

The first three hold for any motion; the added mass m_a of the last two is open in water.

Belongs here: those laws, with their limits. Does not belong here: what is wrong where one does not hold (remedies.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from types import MappingProxyType

from undertow.conditioning.band import ORDERS, Band, Relation
from undertow.quantities import format_number
from undertow.recording.units import ARBITRARY_LENGTHS

Limits = tuple[float, float]

TIGHT: Limits = (1.0 / 1.03, 1.03)
"""Two sensors of one motion agree within 3 %: calibrations keep half a per cent, mountings a few."""

CONTRADICTS: Limits = (1.0 / 1.3, 1.3)
"""No calibration is 30 % off: another unit, another column, another body."""

STATED: Limits = (1.0 / 1.1, 1.1)
"""A stated stiffness is seldom better than 10 %."""

DRY: tuple[Limits, Limits] = ((1.0 / 1.3, 1.3), (1.0 / 1.5, 1.5))
"""Moving mass by force or period over the stated one in air: springs and fixtures move along; half as much
again is another body, or half of the load cells."""

WET: tuple[Limits, Limits] = ((0.5, 10.0), (0.3, 30.0))
"""The same in water: a light body carries ten times its mass along, sloshing water below resonance takes some off."""

STIFFNESS, MASS = "specimen.stiffness_N_per_m", "specimen.mass_kg"
"""What is stated of the specimen, beside channels among what a law ties."""

SAMPLED_SHARE = 0.25
"""Friction turns the acceleration over between two samples: relative error of a factor, times samples' share of a
period (4 % at 12 samples a period and friction that stops the body after eight swings)."""


@dataclass(frozen=True)
class Stated:
    """What the config says that channels are held against; nan and empty where it says nothing.

    ``units`` is channel (or "time") -> unit as written there, "rate" for a time from a constant rate; ``wet`` whether
    water may move along.
    """

    units: Mapping[str, str] = field(default_factory=dict)
    mass_kg: float = math.nan
    stiffness_N_per_m: float = math.nan
    wet: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "units", MappingProxyType(dict(self.units)))

    def uncalibrated(self, channel: str) -> bool:
        """Whether a channel is in a scale that is no unit (per cent, pixels)."""
        return self.units.get(channel, "").partition("/")[0].strip() in ARBITRARY_LENGTHS


@dataclass(frozen=True)
class Pair:
    """One law between two channels: ``value`` is what was found over what must be, complex, with relative ``stderr``.

    ``powers``: where a channel (or "time", `MASS`, `STIFFNESS`) is multiplied by c, the value is by c to that power.
    ``agrees`` and ``allowed`` are limits of doubt and of contradiction; ``says`` puts the value in words. ``turns`` is
    False where the law has no sign or clock, ``sized`` False where it has no size.
    """

    first: str
    second: str
    value: complex
    stderr: float
    coherence: float
    loudness: float
    powers: Mapping[str, int]
    agrees: Limits
    allowed: Limits
    says: str
    turns: bool = True
    sized: bool = True

    @property
    def size(self) -> float:
        """How many times too large the first channel is against the second one."""
        return abs(self.value)

    @property
    def negative(self) -> bool:
        """Whether the two go against each other where they must go together."""
        return self.turns and self.value.real < 0.0

    @property
    def clock(self) -> float:
        """Angle by which the first channel is later than the second, rad of the motion, signs apart."""
        turned = -self.value if self.value.real < 0.0 else self.value
        return math.atan2(turned.imag, turned.real) if self.turns else 0.0

    def outside(self, limits: Limits, errors: float) -> bool:
        """Whether the size lies outside limits by more than so many standard errors."""
        if not self.sized:
            return False
        room = errors * self.stderr
        return self.size + room < limits[0] or self.size - room > limits[1]

    @property
    def measured(self) -> str:
        """What was found, in words."""
        sign = "-" if self.negative else ""
        return self.says.format(sign + three_digits(self.size))


def three_digits(value: float) -> str:
    """A number with three digits, without a power of ten where it is short.

    >>> three_digits(1002.3), three_digits(0.10197), three_digits(1e-6)
    ('1000', '0.102', '1e-06')
    """
    return format_number(float(f"{value:.3g}"))


def pairs_of(band: Band, stated: Stated) -> tuple[Pair, ...]:
    """Every law that the channels of one trial and the stated specimen can be held against."""
    motion = [name for name in ("displacement", "velocity", "acceleration") if name in band.channels]
    found = [_kinematic(band, first, second, stated) for second, first in combinations(motion, 2)]
    place = next((name for name in ("displacement", "velocity") if name in motion), "")
    if place and "spring_force" in band.channels:
        found += _of_force(band, place, stated)
    period = _of_period(band, stated) if "displacement" in motion else None
    return (*found, period) if period is not None else tuple(found)


def _kinematic(band: Band, first: str, second: str, stated: Stated) -> Pair:
    apart = ORDERS[second] - ORDERS[first]
    times = "second derivative" if apart == 2 else "derivative"
    sized = not stated.uncalibrated(first) and not stated.uncalibrated(second)
    return _pair(
        band, band.relation(first, second), 1.0, (first, second, {first: 1, second: -1, "time": apart}),
        (TIGHT, CONTRADICTS), f"{first} is {{}} times the {times} of the {second}", sized=sized,
    )  # fmt: skip


def _of_force(band: Band, place: str, stated: Stated) -> list[Pair]:
    """The load cells against k x, and against (m + m_a) x'' where no k is stated."""
    late = 1 if place == "velocity" else 0
    by_place = band.relation("spring_force", place, (late, 0))
    k, m = stated.stiffness_N_per_m, stated.mass_kg
    has_k, has_m = math.isfinite(k) and k > 0.0, math.isfinite(m) and m > 0.0
    sized = not stated.uncalibrated(place)
    moved = "displacement" if not late else "displacement (by the velocity)"
    names = ("spring_force", place)
    says = f"spring_force is {{}} times the stated stiffness times the {moved}" if has_k else (
        f"spring_force goes against the {moved} (factor {{}})")  # fmt: skip
    found = [
        _pair(
            band, by_place, k if has_k else by_place.size or 1.0,
            (*names, {"spring_force": 1, place: -1, "time": -late, STIFFNESS: -1}), (STATED, CONTRADICTS), says,
            sized=has_k and sized,
        )
    ]  # fmt: skip
    if has_m and not has_k and sized:
        by_bend = band.relation("spring_force", place, (late, 2))
        powers = {"spring_force": 1, place: -1, "time": 2 - late, MASS: -1}
        says = "spring_force is {} times the stated mass times the deceleration of the " + place
        found.append(_pair(band, by_bend, -m, (*names, powers), WET if stated.wet else DRY, says, turns=False))
    return found


def _of_period(band: Band, stated: Stated) -> Pair | None:
    """Stated stiffness and mass against the motion's own frequency."""
    k, m = stated.stiffness_N_per_m, stated.mass_kg
    if not (math.isfinite(k) and math.isfinite(m) and k > 0.0 and m > 0.0):
        return None
    turning = band.relation("displacement", "displacement", (2, 0))
    if turning.factor.real >= 0.0:
        return None
    rate = math.sqrt(-turning.factor.real)
    inverse = Relation(-k / m / turning.factor, k / m * turning.stderr / rate**4, turning.coherence, turning.loudness)
    says = (
        "stated stiffness over stated mass is {} times the square of the motion's own frequency of "
        f"{rate / (2.0 * math.pi):.3g} Hz"
    )
    return _pair(
        band, inverse, 1.0, ("time", "specimen", {"time": 2, STIFFNESS: 1, MASS: -1}), WET if stated.wet else DRY, says,
        turns=False,
    )


def _pair(
    band: Band,
    relation: Relation,
    expected: float,
    named: tuple[str, str, Mapping[str, int]],
    limits: tuple[Limits, Limits],
    says: str,
    turns: bool = True,
    sized: bool = True,
) -> Pair:
    value = relation.factor / expected
    error = math.hypot(relation.stderr / abs(expected), abs(value) * SAMPLED_SHARE * band.step_s / band.period_s)
    first, second, powers = named
    return Pair(
        first, second, value, error, relation.coherence, relation.loudness, powers, *limits, says, turns, sized
    )
