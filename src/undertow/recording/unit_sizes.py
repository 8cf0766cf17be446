"""Sizes of the units that recordings usually have, so that reading one does not wait for a parser of units.

Belongs here: what pint says of these spellings, to the last digit (a test compares them). Does not belong here: which
spelling fits which channel (units.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Size(NamedTuple):
    """A unit: how many of its SI base units it is, and those in words, which name its dimension."""

    value: float
    base: str


_BY_BASE: Mapping[str, Mapping[str, float]] = {
    "s": {"s": 1.0, "second": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0},
    "1 / s": {"Hz": 1.0, "kHz": 1e3},
    "m": {
        "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "micrometer": 1e-6, "in": 0.0254, "ft": 0.30479999999999996,
    },
    "rad": {"rad": 1.0, "mrad": 1e-3, "deg": 0.017453292519943295, "degree": 0.017453292519943295},
    "m / s": {
        "m/s": 1.0, "meter/second": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "millimeter/second": 1e-3, "in/s": 0.0254,
        "ft/s": 0.30479999999999996,
    },
    "rad / s": {
        "rad/s": 1.0, "radian/second": 1.0, "deg/s": 0.017453292519943295, "degree/second": 0.017453292519943295,
        "rpm": 0.10471975511965977,
    },
    "m / s ** 2": {
        "m/s**2": 1.0, "meter/second**2": 1.0, "mm/s**2": 1e-3, "millimeter/second**2": 1e-3,
        "ft/s**2": 0.30479999999999996, "standard_gravity": 9.80665, "millistandard_gravity": 0.00980665,
        "galileo": 1e-2, "milligalileo": 1e-5,
    },
    "rad / s ** 2": {"rad/s**2": 1.0, "radian/second**2": 1.0, "deg/s**2": 0.017453292519943295},
    "kg * m / s ** 2": {
        "N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "kgf": 9.80665, "lbf": 4.4482216152605005,
        "metric_ton*standard_gravity": 9806.65,
    },
    "kg * m ** 2 / s ** 2": {
        "N m": 1.0, "newton*meter": 1.0, "kN m": 1e3, "kN*m": 1e3, "kilonewton*meter": 1e3, "N mm": 1e-3,
        "newton*millimeter": 1e-3, "millinewton*meter": 1e-3,
    },
}  # fmt: skip

SIZES: Mapping[str, Size] = MappingProxyType(
    {unit: Size(value, base) for base, units in _BY_BASE.items() for unit, value in units.items()}
)
"""Spelling, as pint reads it -> its size. A spelling that is not here is pint's to read."""
