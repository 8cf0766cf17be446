"""Where the numbers of an equation can lie, whatever found them: friction, drag, masses, stiffness, damping.

Belongs here: ranges, and a sentence about a number outside its own. Does not belong here: what trials and channels say
beside it (plausible.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from undertow.conditioning.motion import Motion
from undertow.discrepancy.words import percent
from undertow.likelihood.fit import Specimen
from undertow.quantities import Estimate, format_number

ERRORS = 3.0
"""A number is doubted where it lies so many standard errors outside its range."""

STIFFNESS_OFF = 0.1
"""Relative difference between an identified and a stated stiffness that is doubted."""

MOST_DAMPING_RATIO = 0.5
"""A body with more damping does not swing twice."""


@dataclass(frozen=True)
class Plausible:
    """Where a number can lie, and what to look at where it does not."""

    lower: float
    upper: float
    words: str
    look_at: str


RANGES: Mapping[str, Plausible] = {
    "mu": Plausible(1e-4, 2.0, "friction coefficient", "the unit of the displacement, mass, gravity and buoyancy"),
    "drag_coefficient": Plausible(0.01, 100.0, "drag coefficient", "the unit of the displacement, area and density"),
}
"""Numbers without a unit: a roller bearing has 1e-4, rubber 2; a streamlined body 0.01, a plate in small motion 100."""

BESIDE = frozenset({"acceleration", "velocity", "spring_force"})
"""Channels that a displacement in a wrong unit contradicts."""

ON_AIR = 1e-7
"""Smallest friction coefficient of what floats on air or a knife's edge, where the displacement's unit is shown by a
second channel or by a drag coefficient as bodies have it."""

ORDINARY_DRAG = (0.1, 30.0)
"""Drag coefficients that no displacement a thousand times too large or small leaves."""

NEGATIVE = "the damping and friction of the dry trials, which it may make up for"
"""What to look at where a number that only takes energy gives it: no unit turns a sign."""

ADDED_MASS = Plausible(
    -0.5, 20.0, "added mass over stated mass", "mass, stiffness, the dry trials and the unit of time"
)
"""Sloshing water below the body's frequency takes some off; a light plate carries many times its mass."""

MASS = Plausible(
    0.9, 1.3, "moving mass over stated mass, in an equation without added mass,",
    "specimen.mass_kg and specimen.stiffness_N_per_m, the load cells, the unit of time, and at water that moves along",
)
"""Springs and fixtures move along and take nothing off."""


def out_of_range(
    numbers: Mapping[str, Estimate], specimen: Specimen, motions: Sequence[Motion], lacks: bool = False
) -> list[str]:
    """Numbers that surely lie where no body's do, a sentence each: coefficients without a unit, masses over the stated
    one. Where the equation ``lacks`` something a coefficient may stand for that."""
    ranges = {**RANGES, "mu": _friction(motions, numbers)}
    found = [_outside(one, numbers[name], lacks) for name, one in ranges.items() if name in numbers]
    stated = specimen.mass_kg
    if "added_mass_kg" in numbers and math.isfinite(stated) and stated > 0.0:
        found.append(_outside(ADDED_MASS, numbers["added_mass_kg"].scaled(1.0 / stated, "1")))
    elif "total_mass_kg" in numbers and math.isfinite(stated) and stated > 0.0:
        found.append(_outside(MASS, numbers["total_mass_kg"].scaled(1.0 / stated, "1")))
    return [text for text in found if text]


def _friction(motions: Sequence[Motion], numbers: Mapping[str, Estimate]) -> Plausible:
    """The range of a friction coefficient: nothing is too small where something else shows the displacement's unit."""
    drag = numbers.get("drag_coefficient")
    low, high = ORDINARY_DRAG
    ordinary = drag is not None and low < drag.value - ERRORS * drag.total_stderr
    shown = drag is not None and ordinary and drag.value + ERRORS * drag.total_stderr < high
    beside = motions and all(BESIDE & set(m.recording.channels) for m in motions)
    return replace(RANGES["mu"], lower=ON_AIR) if shown or beside else RANGES["mu"]


def _outside(allowed: Plausible, found: Estimate, lacks: bool = False) -> str:
    """That a number lies surely outside its range; a number that may be zero is none that is too small. Where the
    equation ``lacks`` something the number stands for that, and no unit turns its sign."""
    error = found.total_stderr
    if not math.isfinite(found.value) or not math.isfinite(error):
        return ""
    low, high = found.value - ERRORS * error, found.value + ERRORS * error
    if not (high < allowed.lower or low > allowed.upper) or (allowed.lower > 0.0 and low <= 0.0 <= high):
        return ""
    negative = allowed.lower > 0.0 and high < 0.0
    where = NEGATIVE if negative else allowed.look_at
    more = ", and at what the equation lacks" if negative else ""
    why = f"what the equation lacks may stand in it; else look at {where}" if lacks else f"look at {where}{more}"
    return (
        f"{allowed.words} {format_number(found.value, error)} +- {format_number(error, error)} lies outside "
        f"{allowed.lower:g} to {allowed.upper:g}: {why}"
    )


def damped(numbers: Mapping[str, Estimate]) -> str:
    """That the damping is too strong for a decay."""
    ratio = math.nan
    if "c_Ns_per_m" in numbers and "k_N_per_m" in numbers and "total_mass_kg" in numbers:
        ratio = _ratio(numbers["c_Ns_per_m"].value, numbers["k_N_per_m"].value, numbers["total_mass_kg"].value)
    elif "viscous_damping_per_mass" in numbers and "stiffness_per_mass" in numbers:
        ratio = _ratio(numbers["viscous_damping_per_mass"].value, numbers["stiffness_per_mass"].value, 1.0)
    if not ratio > MOST_DAMPING_RATIO:
        return ""
    return (
        f"damping ratio {ratio:.2g} is over {MOST_DAMPING_RATIO:g}, and such a body does not swing twice: look at the "
        "window (trials.window), at the unit of time, and at trials that stop at once"
    )


def _ratio(c: float, k: float, m: float) -> float:
    return c / (2.0 * math.sqrt(k * m)) if k > 0.0 and m > 0.0 else math.nan


def stiffness_off(
    found: Estimate | None, specimen: Specimen, limit: float = STIFFNESS_OFF, verb: str = "doubted"
) -> str:
    """That the identified stiffness is surely another one than the stated one, by more than a share."""
    stated = specimen.stiffness_N_per_m
    if found is None or not math.isfinite(stated) or not math.isfinite(found.value) or stated <= 0.0:
        return ""
    off, error, unit = found.value / stated - 1.0, found.total_stderr / stated, specimen.unit("N/m")
    room = ERRORS * error if math.isfinite(error) else 0.0
    if abs(off) - room <= limit:
        return ""
    return (
        f"stiffness {format_number(found.value, found.total_stderr)} {unit} is {percent(abs(off))} "
        f"{'above' if off > 0.0 else 'below'} the stated {format_number(stated)} {unit}, and more than "
        f"{100.0 * limit:.0f} % is {verb}: look at specimen.stiffness_N_per_m, mass and the unit of time"
    )
