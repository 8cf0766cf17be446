"""Numbers whose thousands are parted by a mark: 1.234,5 and 1,234.5, and 40.013 where forty thousand are meant.

Belongs here: how such texts look, and what is said of them. Does not belong here: reading a table (text.py), where it
begins (propose_layout.py).
"""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from undertow.recording.recording import Array

FEWEST = 20
"""Cells with a mark before three digits from which on a column is looked at: fewer may all have three decimals."""

_SIGNS = ",.'\u2019 \u00a0\u202f"
_PARTED = re.compile(rf"([+-]?[0-9]{{1,3}}(?:([{_SIGNS}])[0-9]{{3}})(?:\2[0-9]{{3}})*)(?:([.,])([0-9]+))?")
_WHOLE = re.compile(r"[+-]?[0-9]{1,3}")


def parted(text: str) -> str:
    """What is to be said of a cell that surely parts thousands; empty where it does not, or may be a decimal.

    >>> parted("1.234,5")
    "it parts thousands with '.'; save the file without that mark, as 1234,5"
    >>> parted("1,234,567"), parted("1.234"), parted("12,5")
    ("it parts thousands with ','; save the file without that mark, as 1234567", '', '')
    """
    found = _PARTED.fullmatch(text.strip())
    if found is None or found[2] == found[3]:
        return ""
    whole, mark, decimal, rest = found.groups()
    if decimal is None and mark in ".," and whole.count(mark) == 1:
        return ""
    plain = whole.replace(mark, "") + (f"{decimal}{rest}" if decimal else "")
    return f"it parts thousands with {mark!r}; save the file without that mark, as {plain}"


def may_be_parted(values: Array) -> bool:
    """Whether numbers (n,) that were read with decimals may be whole ones with parted thousands: none of them lies
    between 0 and 1, all have three decimals at most, and some have none."""
    known = np.abs(values[np.isfinite(values)])
    broken = known[known != np.round(known)]
    if broken.size < FEWEST or broken.size == known.size or broken.min() < 1.0 or broken.max() >= 1000.0:
        return False
    return bool(np.all(np.abs(1e3 * broken - np.round(1e3 * broken)) < 1e-6))


def first_parted(texts: Iterable[str], decimal: str) -> int | None:
    """Place of the first cell with a mark, in a column whose cells have three digits behind the decimal mark or no mark
    at all, never fewer: so thousands are written. None of another column.

    >>> first_parted(["987", *["1.012"] * 20], "."), first_parted(["987.000", *["1.012"] * 20], ".")
    (1, None)
    """
    marked, plain = [], 0
    for at, text in enumerate(texts):
        if _WHOLE.fullmatch(text):
            plain += 1
        elif (found := _PARTED.fullmatch(text)) and found[2] == decimal and not found[3]:
            marked.append(at)
        else:
            return None
    return marked[0] if plain and len(marked) >= FEWEST else None
