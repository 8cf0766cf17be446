"""Units at the door: what a laboratory writes becomes SI, checked by dimension.

Belongs here: spellings, the one pint registry, conversion. Does not belong here: columns and files (catalogue.py).
"""

from __future__ import annotations

import difflib
import math
import re
import tokenize
from collections.abc import Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from undertow.errors import RecordingError
from undertow.recording.recording import BESIDE, CHANNELS, INPUTS, Array, Coordinate
from undertow.recording.unit_sizes import SIZES, Size

SPELLINGS: Mapping[str, str] = MappingProxyType(
    {
        "°": "degree", "º": "degree", "degs": "degree", "Nm": "newton*meter", "kNm": "kilonewton*meter",
        "mNm": "millinewton*meter", "Nmm": "newton*millimeter", "mps": "meter/second", "mmps": "millimeter/second",
        "mps2": "meter/second**2", "mmps2": "millimeter/second**2", "dps": "degree/second", "rps": "radian/second",
        "radps": "radian/second", "radps2": "radian/second**2", "seconds": "second", "secs": "second",
        "micron": "micrometer", "tf": "metric_ton*standard_gravity", "mil": "thou", "mils": "thou",
    }
)  # fmt: skip
"""Whole spellings that pint does not read, or reads as something else."""

ACCELERATION_SPELLINGS: Mapping[str, str] = MappingProxyType(
    {
        "g": "standard_gravity", "G": "standard_gravity", "gn": "standard_gravity", "g0": "standard_gravity",
        "g_n": "standard_gravity", "mg": "millistandard_gravity", "gal": "galileo", "Gal": "galileo",
        "mGal": "milligalileo", "mgal": "milligalileo",
    }
)  # fmt: skip
"""For an acceleration only: pint would read ``g`` as gram, ``G`` as gauss and ``gal`` as gallon."""

ARBITRARY_LENGTHS = ("%", "percent", "px", "pixel", "pixels", "counts", "1", "V", "mV")
"""Scales of a displacement that nobody calibrated. Kept as they are: 'm' then stands for one of them."""

KNOWN: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "time": ("s", "ms", "us", "min", "h"),
        "displacement": ("m", "mm", "cm", "um", "in", "ft", "rad", "mrad", "deg", "°", *ARBITRARY_LENGTHS),
        "velocity": ("m/s", "mm/s", "cm/s", "in/s", "ft/s", "rad/s", "deg/s", "°/s", "rpm", "%/s", "px/s"),
        "acceleration": ("m/s^2", "mm/s^2", "g", "mg", "Gal", "ft/s^2", "rad/s^2", "deg/s^2"),
        "spring_force": ("N", "kN", "MN", "mN", "kgf", "tf", "lbf", "N m", "kN m", "kN-m", "N mm"),
        "normal_force": ("N", "kN", "MN", "mN", "kgf", "tf", "lbf"),
        "force": ("N", "kN", "MN", "mN", "kgf", "tf", "lbf", "N m", "kN m", "V", "A"),
        "base_displacement": ("m", "mm", "cm", "um", "in", "ft", "rad", "mrad", "deg", "°"),
        "base_velocity": ("m/s", "mm/s", "cm/s", "in/s", "ft/s", "rad/s", "deg/s", "°/s"),
        "base_acceleration": ("m/s^2", "mm/s^2", "g", "mg", "Gal", "ft/s^2", "rad/s^2", "deg/s^2"),
        "water_velocity": ("m/s", "mm/s", "cm/s", "in/s", "ft/s", "rad/s", "deg/s"),
        "water_acceleration": ("m/s^2", "mm/s^2", "g", "mg", "Gal", "ft/s^2", "rad/s^2", "deg/s^2"),
    }
)
"""Spellings offered when one is not understood."""

ELECTRICAL = ("V", "mV", "A", "mA")
"""Units of a force that a drive's signal stands for: kept as they are, a gain makes newtons of them."""

_TOWER = re.compile(r"\*\*\s*-?(\d{2}|\(|\d+\s*\*\*)")  # exponents that take an evaluator for ever
_SIGNS = re.compile(r"[\w %*/^().+\-]*")  # an evaluator drops what it does not know: m:=1 would be m
_LONGEST_UNIT = 40  # characters: no laboratory writes a longer one, and a parser should not be fed a page


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


def si_unit(channel: str, coordinate: Coordinate) -> str:
    """SI unit of a channel (or of ``time``) in translation or rotation.

    >>> si_unit("spring_force", "rotation")
    'N m'
    """
    return "s" if channel == "time" else {**CHANNELS, **INPUTS, **BESIDE}[channel][1 if coordinate == "rotation" else 0]


def spelled(unit: str, channel: str) -> str:
    """A laboratory's spelling as pint reads it: ``mm/s2``, ``m/s²``, ``m s-2``, ``kN-m``, ``N·m``, ``°/s``, ``g``.

    >>> spelled("mm/s2", "acceleration"), spelled("kN-m", "spring_force")
    ('mm/s**2', 'kN*m')
    """
    text = unit.strip().strip("[]() ")
    if channel.endswith("acceleration") and text in ACCELERATION_SPELLINGS:
        return ACCELERATION_SPELLINGS[text]
    if text in SPELLINGS:
        return SPELLINGS[text]
    text = text.replace("μ", "u").replace("µ", "u").replace("°", "deg").replace("º", "deg")
    text = text.translate(str.maketrans("·⋅⁻²¹", "**-21")).replace("^", "**")
    text = re.sub(r"(?<=[A-Za-z])[-.](?=[A-Za-z])", "*", text)
    text = re.sub(r"(?<=[A-Za-z])(-?\d)", r"**\1", text)
    return re.sub(r"\bsecs?\b", "s", text)


def factor_to_si(unit: str, channel: str, coordinate: Coordinate = "translation") -> tuple[float, str]:
    """What one ``unit`` is in SI, and the unit the values then have.

    A displacement in translation may be in an uncalibrated scale (`ARBITRARY_LENGTHS`): it stays as it is,
    with factor 1, and the returned unit says so (``%``; ``%/s`` for a velocity). Coefficients that are per metre are
    then per that unit; frequencies, damping ratios and everything per mass and linear stay true.

    Raises RecordingError where the unit is not known or has another dimension than the channel.

    >>> factor_to_si("kN", "spring_force"), factor_to_si("%", "displacement")
    ((1000.0, 'N'), (1.0, '%'))
    """
    target = si_unit(channel, coordinate)
    text = unit.strip().strip("[]() ")
    if coordinate == "translation" and channel in ("displacement", "velocity", "acceleration"):
        scale, _, per = text.partition("/")
        expected = {"displacement": "", "velocity": "s", "acceleration": "s2"}[channel]
        if scale.strip() in ARBITRARY_LENGTHS and per.strip().replace("^", "").replace("²", "2") == expected:
            return 1.0, text
    if channel in BESIDE or (channel == "force" and text in ELECTRICAL):
        return 1.0, text
    size, wanted = _size(unit, channel), _size(target, channel)
    if size.base != wanted.base:
        raise RecordingError(
            f"{channel} is said to be in {unit!r}, which is {size.base} in SI base units, but a {coordinate}'s "
            f"{channel} is in {target}; {_remedy(unit, channel, coordinate)}"
        )
    return size.value / wanted.value, target


def is_unit_of(unit: str, channel: str, coordinate: Coordinate) -> bool:
    """Whether a unit is one of a channel (or of ``time``) in translation or rotation.

    >>> is_unit_of("deg", "displacement", "translation"), is_unit_of("deg", "displacement", "rotation")
    (False, True)
    """
    try:
        factor_to_si(unit, channel, coordinate)
    except RecordingError:
        return False
    return True


def to_si(values: ArrayLike, unit: str, channel: str, coordinate: Coordinate = "translation") -> tuple[Array, str]:
    """Values (n,) in ``unit`` as float64 in SI, and the SI unit (see `factor_to_si`, also for what is raised).

    >>> to_si([1.0, 2.0], "g", "acceleration")
    (array([ 9.80665, 19.6133 ]), 'm/s^2')
    """
    factor, target = factor_to_si(unit, channel, coordinate)
    return np.asarray(values, dtype=np.float64) * factor, target


def rate_factor(unit: str) -> float:
    """What one ``unit`` of a frequency is in rad/s; RecordingError where it is none.

    >>> round(rate_factor("Hz"), 4), rate_factor("rad/s")
    (6.2832, 1.0)
    """
    return _one_of(unit, "frequency", {"1 / s": 2.0 * math.pi, "rad / s": 1.0}, "Hz, kHz, rad/s, rpm")


def phase_factor(unit: str) -> float:
    """What one ``unit`` of a phase is in rad; RecordingError where it is none."""
    return _one_of(unit, "phase", {"rad": 1.0}, "deg, rad")


def _one_of(unit: str, quantity: str, bases: Mapping[str, float], known: str) -> float:
    """A unit's size times that of its dimension, which must be one of ``bases``."""
    try:
        size = _size(unit, "time")
    except RecordingError as error:
        raise RecordingError(f"{quantity}: unit {unit[:_LONGEST_UNIT]!r} is not known; it may be {known}") from error
    if size.base not in bases:
        raise RecordingError(
            f"{quantity} is said to be in {unit!r}, which is {size.base or 'a plain number'} in SI base units; it may "
            f"be in {known}"
        )
    return size.value * bases[size.base]


def _size(unit: str, channel: str) -> Size:
    """One ``unit`` in SI base units; RecordingError where it cannot be read."""
    text = spelled(unit[: _LONGEST_UNIT + 1], channel)
    return SIZES[text] if text in SIZES else _parsed(unit, text, channel)


def _parsed(unit: str, text: str, channel: str) -> Size:
    """The same by pint, whose import and table take a second."""
    import pint

    unreadable = (pint.PintError, AssertionError, AttributeError, LookupError, ValueError, TypeError, ArithmeticError,
                  SyntaxError, tokenize.TokenError)  # fmt: skip
    try:
        if not text or len(unit) > _LONGEST_UNIT or not _SIGNS.fullmatch(text) or _TOWER.search(text):
            raise ValueError(unit)
        base = _registry().Quantity(1.0, _registry().parse_units(text)).to_base_units()
        return Size(float(base.magnitude), f"{base.units:~}")
    except unreadable as error:
        raise RecordingError(
            f"{channel}: unit {unit[:_LONGEST_UNIT]!r} is not known; {_remedy(unit, channel, None)}"
        ) from error


def _remedy(unit: str, channel: str, coordinate: Coordinate | None) -> str:
    """What to write instead: the nearest spelling of the channel, a coordinate, or a force for a mass."""
    text = unit.strip()
    if channel.endswith("force") and text in ("kg", "t", "lb", "g"):
        return f"a load cell that reads {text} reads a force: write {({'kg': 'kgf', 't': 'tf'}).get(text, 'lbf')!r}"
    if coordinate is not None and channel in CHANNELS:
        other: Coordinate = "rotation" if coordinate == "translation" else "translation"
        if _size(unit, channel).base == _size(si_unit(channel, other), channel).base:
            return f"set equation.coordinate to {other}, or correct the unit"
    known = [one for one in KNOWN[channel] if coordinate is None or _fits(one, channel, coordinate)]
    near = nearest_spelling(text, known)
    nearest = f"the nearest known spelling is {near!r}; " if near else ""
    return f"{nearest}it may be {', '.join(known)}"


def nearest_spelling(text: str, known: Sequence[str]) -> str:
    """The known spelling that a text was probably meant to be, empty where none is near: one with another letter in one
    place, the first letter least of all, before one that is longer or shorter.

    >>> nearest_spelling("mn", ["m", "mm", "cm", "in"]), nearest_spelling("mn", ["N", "kN", "MN", "mN"])
    ('mm', 'mN')
    >>> nearest_spelling("milimeter", ["m", "mm"]), nearest_spelling("xyz", ["m", "mm"])
    ('mm', '')
    """
    typed = [one for one in known if len(one) == len(text) and sum(map(str.__ne__, one, text)) == 1]
    if typed and len(text) > 1:
        return min(typed, key=lambda one: one[0] != text[0])
    return next(iter(difflib.get_close_matches(text, known, n=1, cutoff=0.3)), "")


def _fits(unit: str, channel: str, coordinate: Coordinate) -> bool:
    """Whether a known spelling has the dimension of the channel."""
    if unit in ELECTRICAL:
        return True
    if unit.partition("/")[0] in ARBITRARY_LENGTHS:
        return coordinate == "translation"
    return _size(unit, channel).base == _size(si_unit(channel, coordinate), channel).base
