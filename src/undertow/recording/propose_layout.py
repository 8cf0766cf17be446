"""A guess at how a text file or a sheet is laid out, from the file alone, for a person to confirm.

Belongs here: lines above the data, header, unit row, decimal mark. Does not belong here: what columns mean
(propose.py), anything that a run relies on.
"""

from __future__ import annotations

import csv
import datetime
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from undertow.errors import RecordingError
from undertow.recording.excel import EXCEL, MISSING, first_rows
from undertow.recording.layout import DECIMALS, FileFormat
from undertow.recording.propose import is_unit
from undertow.recording.readers import suffix_of
from undertow.recording.text import is_number, sniff, text_of
from undertow.recording.thousands import parted

LINES_LOOKED_AT = 200
"""Lines from the beginning in which the data must have begun."""

FEWEST_NUMBERS = 2
"""Columns of numbers that make a table of rows with texts: a time and a channel."""

FEWEST_ROWS = 3
"""Rows of numbers in a row that make a table: two may be a header's own numbers."""

NO_TABLE = "no table of numbers begins in its first"
"""How the reason of a file without a table begins: it may be a text that was never to be read."""

_DATE = re.compile(r"[0-9]{1,4}([-./])[0-9]{1,2}\1[0-9]{1,4}")
_SHOWN = 40  # characters of a cell in a message


@dataclass(frozen=True)
class _Row:
    """A row that is not empty: its number from 1 and its cells as texts, those of numbers among them."""

    number: int
    cells: Sequence[str]


def propose_layout(path: Path, variable: str | None = None) -> FileFormat:
    """Where the table of a text file or of a sheet (``variable``) begins: skip_rows, header, unit_row, decimal.

    The table is the last run of rows of numbers with one width among the first `LINES_LOOKED_AT` lines, or where there
    is none of rows with texts beside at least `FEWEST_NUMBERS` columns of numbers; a row of as many texts above it is
    its header, with a row of units between them where there is one.

    Raises RecordingError where the file cannot be read or no such table begins there.
    """
    excel = suffix_of(path) in EXCEL
    rows = _sheet_rows(path, variable) if excel else _text_rows(path)
    heads = {decimal: rows(decimal) for decimal in DECIMALS}
    for decimal, head in heads.items():
        start = _table(head, decimal, excel)
        if start is not None:
            return replace(_layout(head, start, decimal), variable=variable)
    beside = [found for decimal, head in heads.items() if (found := _beside_texts(head, decimal, excel)) is not None]
    if beside:
        return replace(max(beside, key=lambda found: (found[0], found[1].header))[1], variable=variable)
    told = _thousands(heads["."])
    if told:
        raise RecordingError(f"{path}: {told}")
    looked_at = max((head[-1].number for head in heads.values() if head), default=0)
    raise RecordingError(
        f"{path}: {NO_TABLE} {looked_at} lines; is it a recording? set "
        f"recordings.skip_rows where its data begin later; fewer than {FEWEST_ROWS} rows are no table"
        + _about_the_last(heads)
    )


def _thousands(rows: Sequence[_Row]) -> str:
    """That the last row has a number with parted thousands, in a sentence; empty where it has none."""
    cells, line = (rows[-1].cells, rows[-1].number) if len(rows) > FEWEST_ROWS else ((), 0)
    found = ((cell, parted(cell)) for cell in cells)
    return next((f"{cell!r} in line {line} is read as no number: {said}" for cell, said in found if said), "")


def _about_the_last(heads: Mapping[str, Sequence[_Row]]) -> str:
    """What is no number in the last row: a date alone, which a text file's reader does not take, a text with digits, or
    marks of which one parts thousands."""
    rows = heads["."]
    cells, line = (rows[-1].cells, rows[-1].number) if len(rows) > FEWEST_ROWS else ((), 0)
    date = next((cell[:_SHOWN] for cell in cells if _DATE.match(cell)), None)
    if date is not None:
        return (
            f"; {date!r} in line {line} is a date without a time of day in its column: write "
            "recordings.channels by hand, with time: {rate_hz: ...}, or save seconds"
        )
    cells = next((known[-1].cells for known in heads.values() if known and len(known[-1].cells) > 1), cells)
    marked = {mark: [c for c in cells if mark in c and is_number(c, mark)] for mark in DECIMALS}
    if all(marked.values()):
        one, other = (found[0][:_SHOWN] for found in marked.values())
        return f"; {one!r} and {other!r} in line {line}: one mark parts thousands; save the file without it"
    texts = [cell for cell in cells if not any(is_number(cell, mark) for mark in DECIMALS)]
    odd = next((text[:_SHOWN] for text in texts if text.lstrip("+-")[:1].isdigit()), None)
    return "" if odd is None else f"; {odd!r} in line {line} is no number: save such cells as plain numbers"


def _text_rows(path: Path) -> Callable[[str], list[_Row]]:
    """The first lines of a text file, split as a decimal mark suggests."""
    lines = text_of(path).splitlines()[:LINES_LOOKED_AT]
    written = [(number, text) for number, text in enumerate(lines, 1) if text.strip()]

    def split(decimal: str) -> list[_Row]:
        separator = sniff([text for _, text in written[-20:]], decimal)
        return [_Row(number, _split(text, separator)) for number, text in written]

    return split


def _sheet_rows(path: Path, variable: str | None) -> Callable[[str], list[_Row]]:
    """The first rows of a sheet without the empty cells at their ends."""
    found = []
    for number, row in enumerate(first_rows(path, FileFormat(variable=variable)), 1):
        cells = [_shown(cell) for cell in row]
        while cells and not cells[-1]:
            cells.pop()
        if cells:
            found.append(_Row(number, cells))
    return lambda decimal: found


def _shown(cell: object) -> str:
    """A cell as a text; dates and times are numbers, which they become when they are read."""
    if isinstance(cell, datetime.datetime | datetime.time | datetime.timedelta):
        return "0"
    text = "" if cell is None else str(cell).strip()
    return "" if text in MISSING else text


def _table(rows: Sequence[_Row], decimal: str, ragged: bool, numeric: Sequence[int] | None = None) -> int | None:
    """Index of the first row of numbers (of ``numeric`` columns alone, where given) of the table that goes on to the
    end of what is looked at.

    The very last line may be cut and does not count where there are others; ``ragged`` rows may end early. Rows in
    which a cell is no number do not end a table that goes on above them: whoever reads it says which cell that is.
    """
    if numeric is not None and len(numeric) < FEWEST_NUMBERS:
        return None
    last = start = _end(rows)
    width = len(rows[last - 1].cells) if rows else 0

    def holds(row: _Row) -> bool:
        cells = row.cells if numeric is None else [row.cells[at] for at in numeric if at < len(row.cells)]
        return _are_numbers(cells, decimal) and (ragged or len(row.cells) == width)

    while start > 0:
        above = start
        while above > 0 and not holds(rows[above - 1]) and _has_a_number(rows[above - 1], width, decimal):
            above -= 1
        asked = FEWEST_ROWS if above < start else 1  # rows of numbers above those that are not
        if above < asked or not all(holds(row) for row in rows[above - asked : above]):
            break
        start = above - 1
    return start if last - start >= FEWEST_ROWS else None


def _has_a_number(row: _Row, width: int, decimal: str) -> bool:
    """Whether a row is as wide as the table and holds a number beside what is none."""
    return len(row.cells) == width and any(is_number(cell, decimal) for cell in row.cells)


def _beside_texts(rows: Sequence[_Row], decimal: str, ragged: bool) -> tuple[int, FileFormat] | None:
    """The layout of a table with columns of texts beside those of numbers, and the number of these."""
    numeric = _numeric(rows, decimal)
    start = _table(rows, decimal, ragged, numeric)
    return None if start is None else (len(numeric), _layout(rows, start, decimal))


def _numeric(rows: Sequence[_Row], decimal: str) -> list[int]:
    """Columns that hold a number in the last row that counts."""
    last = rows[_end(rows) - 1].cells if rows else ()
    return [at for at, cell in enumerate(last) if is_number(cell, decimal)]


def _end(rows: Sequence[_Row]) -> int:
    """Number of rows that count: without the very last one, which may be cut, where there are others."""
    return len(rows) - 1 if len(rows) > FEWEST_ROWS else len(rows)


def _layout(rows: Sequence[_Row], start: int, decimal: str) -> FileFormat:
    width = max(len(row.cells) for row in rows[start:])
    texts = 0  # rows of names and units above the data
    while texts < min(2, start):
        above = rows[start - 1 - texts].cells
        if len(above) != width or any(is_number(field, decimal) for field in above):
            break
        texts += 1
    if texts == 2 and not all(is_unit(text) for text in rows[start - 1].cells if text):
        texts = 1
    first = rows[start - texts].number
    return FileFormat(decimal=decimal, header=texts > 0, skip_rows=first - 1, unit_row=texts == 2)


def _split(text: str, separator: str) -> list[str]:
    plain = text.lstrip("#").strip()
    if len(separator) > 1:
        return plain.split()
    try:
        fields = next(csv.reader([plain], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:  # a field longer than any in a table
        fields = plain.split(separator)
    return [field.strip() for field in fields]


def _are_numbers(fields: Sequence[str], decimal: str) -> bool:
    """Whether a row holds numbers alone; some of them may be missing."""
    filled = [field for field in fields if field]
    return bool(filled) and all(is_number(field, decimal) for field in filled)
