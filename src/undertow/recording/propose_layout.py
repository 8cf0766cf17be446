"""A guess at how a text file is laid out, from the file alone, for a person to confirm.

Belongs here: lines above the data, header, unit row, decimal mark. Does not belong here: what columns mean
(propose.py), anything that a run relies on.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from undertow.errors import RecordingError
from undertow.recording.layout import FileFormat
from undertow.recording.propose import is_unit
from undertow.recording.text import sniff, text_of

LINES_LOOKED_AT = 200
"""Lines from the beginning in which the data must have begun."""

FEWEST_ROWS = 3
"""Rows of numbers in a row that make a table: two may be a header's own numbers."""


@dataclass(frozen=True)
class _Line:
    """A line that is not empty: its number from 1 and its text."""

    number: int
    text: str


def propose_layout(path: Path) -> FileFormat:
    """Where the table of a text file begins: skip_rows, header, unit_row, decimal.

    The table is the last run of rows of numbers with one width among the first `LINES_LOOKED_AT` lines; a row of as
    many texts above it is its header, with a row of units between them where there is one.

    Raises RecordingError where the file cannot be read or no such table begins there.
    """
    lines = text_of(path).splitlines()
    head = [_Line(n, text) for n, text in enumerate(lines[:LINES_LOOKED_AT], 1) if text.strip()]
    for decimal in (".", ","):
        separator = sniff([line.text for line in head[-20:]], decimal)
        found = _table(head, separator, decimal)
        if found is not None:
            return _layout(head, found, separator, decimal)
    raise RecordingError(
        f"{path}: no table of numbers begins in its first {min(len(lines), LINES_LOOKED_AT)} lines; is it a recording? "
        "set recordings.skip_rows where its data begin later"
    )


def _table(head: Sequence[_Line], separator: str, decimal: str) -> int | None:
    """Index of the first row of numbers of the table that goes on to the end of what is looked at.

    The very last line may be cut and does not count where there are others.
    """
    rows = [_split(line.text, separator) for line in head]
    last = len(rows) - 1 if len(rows) > FEWEST_ROWS else len(rows)
    start = last
    while start > 0 and _are_numbers(rows[start - 1], decimal) and len(rows[start - 1]) == len(rows[last - 1]):
        start -= 1
    return start if last - start >= FEWEST_ROWS else None


def _layout(head: Sequence[_Line], start: int, separator: str, decimal: str) -> FileFormat:
    width = len(_split(head[start].text, separator))
    above = [_split(line.text, separator) for line in head[:start]]
    texts = 0  # rows of names and units above the data
    while texts < 2 and texts < start and len(above[-1 - texts]) == width and _are_names(above[-1 - texts], decimal):
        texts += 1
    if texts == 2 and not all(is_unit(text) for text in above[-1] if text):
        texts = 1
    first = head[start - texts].number
    return FileFormat(decimal=decimal, header=texts > 0, skip_rows=first - 1, unit_row=texts == 2)


def _split(text: str, separator: str) -> list[str]:
    plain = text.lstrip("#").strip()
    if len(separator) > 1:
        return plain.split()
    return [field.strip() for field in next(csv.reader([plain], delimiter=separator, skipinitialspace=True), [])]


def _are_numbers(fields: Sequence[str], decimal: str) -> bool:
    """Whether a row holds numbers alone; some of them may be missing."""
    filled = [field for field in fields if field]
    return bool(filled) and all(_is_number(field, decimal) for field in filled)


def _are_names(fields: Sequence[str], decimal: str) -> bool:
    return not any(_is_number(field, decimal) for field in fields)


def _is_number(text: str, decimal: str) -> bool:
    try:
        float(text.replace(decimal, ".") if decimal != "." else text)
    except ValueError:
        return False
    return True
