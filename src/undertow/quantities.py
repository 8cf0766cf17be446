"""A number with its unit and its error.

Belongs here: `Parameter` (what a number means) and `Estimate` (what it turned out to be, and how sure), and
what a measured input is; what keeps them from change.
Does not belong here: how it was found.
"""

from __future__ import annotations

import copyreg
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Literal, cast

OK = "ok"
_PLAIN_BELOW, _WRITTEN_OUT_BELOW = 1e7, 1e9
"""A number without an error is written without a power of ten below this."""


LARGEST_SCATTER = 0.5
"""Relative standard deviation of a number from trial to trial that is still one of a body's: more was meant in per
cent, or of bodies that are not the same."""

Hold = Literal["zero", "first", "band_limited"]
"""What a measured input is between its samples."""
Mover = Literal["force", "base", "water"]
"""What a measured input is: a force, or the motion of what the body stands on or in."""
MovingQuantity = Literal[
    "base_displacement", "base_velocity", "base_acceleration", "water_velocity", "water_acceleration"
]
"""Measured inputs that are motion."""


def read_only_mapping(values: Mapping[Any, Any]) -> MappingProxyType[Any, Any]:
    """A copy that nobody can change, and that goes into a pickle, which Python's own read-only mapping does not.

    >>> read_only_mapping({"k": 1.0})["k"]
    1.0
    """
    return MappingProxyType(dict(values))


copyreg.pickle(MappingProxyType, lambda mapping: (read_only_mapping, (dict(mapping),)))


def mover_of(quantity: str) -> Mover:
    """What an input of that quantity is: a force, or motion of the base or of the water.

    >>> mover_of("water_velocity"), mover_of("force")
    ('water', 'force')
    """
    return cast("Mover", quantity.partition("_")[0])


@dataclass(frozen=True)
class Parameter:
    """A named number of an equation: its unit, its symbol, and the range in which it has a meaning.

    >>> Parameter("stiffness", "N/m", "k", lower=0.0).unit
    'N/m'
    """

    name: str
    unit: str
    symbol: str
    lower: float = -math.inf
    upper: float = math.inf


@dataclass(frozen=True)
class Estimate:
    """A value with its unit, its statistical and its systematic standard error (1 sigma each).

    ``stderr`` comes from the noise of the trials used, ``systematic`` from what was held fixed
    (k, c, mu from the dry trials, areas, volumes, clocks). ``outcome`` is ``"ok"`` or a sentence. ``freedom`` is the
    degrees of freedom behind the errors (inf: many); errors from few are widened, so that value +- 1.645 errors is a
    90 % interval all the same.

    >>> print(Estimate(1271.43, 12.2, 8.0, unit="kg"))
    1271 ± 12 (noise) ± 8 (systematic) kg
    """

    value: float
    stderr: float = math.nan
    systematic: float = 0.0
    unit: str = ""
    source: str = ""
    outcome: str = OK
    freedom: float = math.inf

    @property
    def total_stderr(self) -> float:
        """Both parts in quadrature: sqrt(stderr^2 + systematic^2), in the estimate's unit."""
        return math.hypot(self.stderr, self.systematic)

    def scaled(self, factor: float, unit: str) -> Estimate:
        """The same estimate times an exact factor, in another unit."""
        size = abs(factor)
        return replace(
            self, value=self.value * factor, stderr=self.stderr * size, systematic=self.systematic * size, unit=unit
        )

    def in_rotation(self) -> Estimate:
        """The same estimate with the unit that it has where an angle is the coordinate.

        >>> print(Estimate(2.0, 0.1, unit="N s/m").in_rotation())
        2.00 ± 0.10 N m s/rad
        """
        return replace(self, unit=unit_in_rotation(self.unit))

    def __str__(self) -> str:
        return format_estimate(self)


def or_nan(value: float | None) -> float:
    """A number as JSON has it; nan for null."""
    return math.nan if value is None else float(value)


_OF_ROTATION = re.compile(r"\brad\b|\bN m\b|\bkg m\b")
"""What the unit of a rotation has and none of a translation."""


def unit_in_rotation(unit: str) -> str:
    """The unit of a quantity of translation as it is where an angle is the coordinate; a unit that is one of a
    rotation already stays.

    >>> unit_in_rotation("N s^2/m^2"), unit_in_rotation("kg"), unit_in_rotation("N per kg")
    ('N m s^2/rad^2', 'kg m^2', 'N m per kg m^2')
    >>> unit_in_rotation("N m/rad"), unit_in_rotation("kg m^2"), unit_in_rotation("rad/s")
    ('N m/rad', 'kg m^2', 'rad/s')
    """
    if _OF_ROTATION.search(unit):
        return unit
    turned = re.sub(r"\bm\b", "rad", unit)
    return re.sub(r"\bkg\b", "kg m^2", re.sub(r"\bN\b", "N m", turned))


def significant_decimals(error: float) -> int | None:
    """Decimals (may be negative) that keep two digits of an error below 30 and one above; None without an error.

    >>> significant_decimals(12.2), significant_decimals(0.044)
    (0, 2)
    """
    if not math.isfinite(error) or error <= 0.0:
        return None
    exponent = math.floor(math.log10(error))
    leading = error / 10.0**exponent
    return -exponent + (1 if leading < 3.0 else 0)


DIGITS_AT_MOST = 10
"""Significant digits printed at most, however small an error is said to be."""


def format_number(value: float, error: float = math.nan) -> str:
    """A number with as many digits as its error allows (five significant digits where there is none).

    >>> format_number(1271.43, 12.2), format_number(0.66172, 0.0044), format_number(109600.0)
    ('1271', '0.662', '109600')
    >>> format_number(-0.0001, 0.5)
    '0.0'
    """
    if not math.isfinite(value):
        return "not finite" if math.isinf(value) else "-"
    decimals = significant_decimals(error)
    if decimals is None:
        short = f"{value:.5g}"
        return f"{float(short):.0f}" if "e+" in short and abs(value) < _PLAIN_BELOW else short
    if abs(value) > error * 10.0**DIGITS_AT_MOST:
        return f"{value:.{DIGITS_AT_MOST}g}"
    rounded = round(value, decimals) + 0.0  # a zero has no sign
    return f"{rounded:.{max(decimals, 0)}f}"


NEGLIGIBLE = 1e-6
"""Share of the systematic error below which noise is not written."""


def format_estimate(estimate: Estimate) -> str:
    """``value ± noise (noise) ± systematic (systematic) unit``, digits as the larger error allows; a pure number has
    no unit, one that was held where it is (an error of rounding alone) no noise; from a milliard on a power of ten.

    >>> print(Estimate(2.16e12, 1.7e11, unit="N/m^5"))
    (2.16 ± 0.17) × 10^12 N/m^5
    """
    if estimate.unit not in ("", "1") and _WRITTEN_OUT_BELOW <= abs(estimate.value) < math.inf:
        power = math.floor(math.log10(abs(estimate.value)))
        text = format_estimate(estimate.scaled(10.0**-power, ""))
        return f"{f'({text})' if '±' in text else text} × 10^{power} {estimate.unit}"
    fixed = 0.0 < estimate.stderr < abs(estimate.value) / 10.0**DIGITS_AT_MOST
    errors = (math.nan if fixed else estimate.stderr, estimate.systematic)
    text = format_number(estimate.value, max((e for e in errors if math.isfinite(e)), default=math.nan))
    held = 0.0 < estimate.stderr < NEGLIGIBLE * estimate.systematic  # taken over from another fit: its error alone
    if math.isfinite(errors[0]) and not held:
        text += f" ± {format_number(estimate.stderr, estimate.stderr)}"
        if estimate.systematic > 0.0:
            text += f" (noise) ± {format_number(estimate.systematic, estimate.systematic)} (systematic)"
    elif estimate.systematic > 0.0:
        text += f" ± {format_number(estimate.systematic, estimate.systematic)} (systematic)"
    if estimate.unit not in ("", "1"):
        text += f" {estimate.unit}"
    return text
