"""A trial's conditions as values: what is a number, in which decimal notation, and when two conditions are equal.

Belongs here: single values. Does not belong here: where they stand (index.py, gather.py).
"""

from __future__ import annotations

import math
import re

from undertow.recording.recording import Condition

EQUAL_WITHIN = 1e-6
"""Conditions that are numbers are equal within this part of the larger one (a depth of 2.36 m, read from two files)."""

_NUMBER = re.compile(r"[+-]?([0-9]+([.,][0-9]*)?|[.,][0-9]+)([eE][+-]?[0-9]+)?")


def number(value: Condition | None) -> float | None:
    """A condition as a number, its decimal mark a point or a comma; None where it is a text.

    >>> number("1,63"), number(" 1.630 "), number(1.63), number("1_63"), number("1,234.5"), number("nan")
    (1.63, 1.63, 1.63, None, None, None)
    """
    if isinstance(value, str):
        text = value.strip()
        value = float(text.replace(",", ".")) if _NUMBER.fullmatch(text) else None
    return float(value) if value is not None and math.isfinite(value) else None


def condition(text: str) -> Condition:
    """A condition as a number where it is written like one, else as a text without blanks around it.

    >>> condition("2.36"), condition("1,63"), condition("long"), condition("nan"), condition("1_63")
    (2.36, 1.63, 'long', 'nan', '1_63')
    """
    found = number(text)
    return text.strip() if found is None else found


def same_condition(a: Condition | None, b: Condition | None) -> bool:
    """Whether two conditions are equal: numbers within `EQUAL_WITHIN` in either notation, texts exactly.

    >>> same_condition(2.36, "2.360"), same_condition("1,63", 1.63), same_condition("long", "short")
    (True, True, False)
    """
    if a is None or b is None:
        return False
    one, other = number(a), number(b)
    if one is not None and other is not None:
        return math.isclose(one, other, rel_tol=EQUAL_WITHIN)
    return str(a).strip() == str(b).strip()


def written(value: Condition) -> str:
    """A value as a sentence gives it: numbers without needless digits.

    >>> written(2.0), written("long"), written(109592.0)
    ('2', 'long', '109592')
    """
    return value if isinstance(value, str) else f"{value:.10g}"
