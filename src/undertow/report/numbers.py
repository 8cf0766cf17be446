"""How a number and its unit are printed for a reader: digits, powers of ten, raised exponents.

Belongs here: single numbers and units. Does not belong here: a number with its error (`wording.estimate_text`), names.
"""

from __future__ import annotations

import math
import re

PLAIN_BELOW = 5
"""Powers of ten up to which, and down to which, a number stands without one."""

_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def power_of_ten(power: int) -> str:
    """A power of ten as it is printed.

    >>> power_of_ten(-6)
    '10⁻⁶'
    """
    return f"10{str(power).translate(_SUPERSCRIPTS)}"


def with_powers_raised(text: str) -> str:
    """A text whose exponents behind a ^ are raised.

    >>> with_powers_raised("odds of 10^151 to 1, m^-2")
    'odds of 10¹⁵¹ to 1, m⁻²'
    """
    return re.sub(r"\^(-?\d+)", lambda found: found.group(1).translate(_SUPERSCRIPTS), text)


def printed_unit(unit: str) -> str:
    """A unit with raised exponents; empty for a pure number.

    >>> printed_unit("N s^2/m^2"), printed_unit("1")
    ('N s²/m²', '')
    """
    return "" if unit == "1" else with_powers_raised(unit)


def plain_number(value: float, digits: int = 5) -> str:
    """So many digits, without an exponent while it is below PLAIN_BELOW, else with a raised one.

    >>> plain_number(974.0, 2), plain_number(3e11, 2), plain_number(2.5e-5, 2)
    ('970', '3 × 10¹¹', '0.000025')
    """
    short = f"{value:.{digits}g}"
    mantissa, marked, exponent = f"{float(short):.{digits - 1}e}".partition("e")
    if not math.isfinite(value) or value == 0.0 or abs(int(exponent)) <= PLAIN_BELOW:
        return f"{float(short):.{max(digits - 1 - int(exponent or 0), 0)}f}" if marked else short
    return f"{float(mantissa):g} × {power_of_ten(int(exponent))}"


def short_number(value: float, digits: int = 3) -> str:
    """At most so many digits, never with an "e".

    >>> short_number(8.0), short_number(2031.7), short_number(2.66e6), short_number(1e-6), short_number(1e-5)
    ('8', '2030', '2.66 × 10⁶', '1 × 10⁻⁶', '0.00001')
    """
    short = f"{value:.{digits}g}"
    if "e" not in short:
        return short
    text = plain_number(value, digits)
    return text.rstrip("0").rstrip(".") if "." in text and "×" not in text else text
