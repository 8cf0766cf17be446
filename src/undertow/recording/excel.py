"""Excel workbooks as tables, through openpyxl: values as they were last calculated, never formulas.

Belongs here: sheets, rows, cells. Does not belong here: which column means what (catalogue.py).
"""

from __future__ import annotations

import datetime
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from undertow.errors import MisnamedError, RecordingError
from undertow.recording.foreign import parsing
from undertow.recording.layout import DECIMALS, Column, FileFormat, pick
from undertow.recording.limits import LIMITS, Limits
from undertow.recording.stamps import STAMPED
from undertow.recording.text import must_be_units
from undertow.recording.vectors import chosen_table

EXCEL = (".xlsx", ".xlsm")
"""Suffixes of workbooks."""

_STAMPS = (datetime.datetime, datetime.time, datetime.timedelta)

ROWS_LOOKED_AT = 200
"""Rows below the skipped ones in which header and data must begin."""

MOST_ROWS = 1_048_576
"""Rows of a sheet, at most: Excel has no more."""

MISSING = ("", "#N/A", "#N/A N/A", "#NA", "NA", "NaN", "nan", "-")
"""Texts of a cell that holds no value: Excel's own #N/A and what loggers write."""

_ADVICE = "open it in Excel and save it again as .xlsx"
_DECLARED = 4096  # bytes of an XML part in which a document type would be declared

Row = Sequence[Any]


def read_excel(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The asked columns (all but those of texts where None) of a sheet as float64; empty cells and #N/A are NaN, blank
    rows at the end do not count. ``layout.variable`` names the sheet; None: the first.

    Dates and times of day become seconds since the first row, durations seconds.

    Raises RecordingError where the file is damaged or too large, the sheet or a column is missing, or a cell is a text.
    """
    with parsing(path, "Excel workbook", _ADVICE, cycles=True), _sheet(path, layout) as sheet:
        above, width, first = _head(path, sheet, layout)
        named = _texts(above[0], width) if layout.header else []
        names: list[Column] = list(named) if layout.header else list(range(width))
        layout.limits.allow_columns(path, width)
        if layout.header and all(isinstance(cell, int | float) for cell in above[0] if cell is not None):
            shown = ", ".join(named[:4])
            raise RecordingError(f"{path}: the header row holds numbers ({shown}); set header: none, columns by number")
        chosen = [at for at in pick(path, names, columns) if columns is not None or names[at] != ""]
        cells = _columns(path, sheet, first, chosen, layout.limits)
    if columns is None and (able := [at for at in chosen if not _all_texts(cells[at])]):
        chosen = able
    frame = pd.DataFrame({names[at]: _numbers(path, names[at], cells[at], layout, first) for at in chosen})
    frame.attrs[STAMPED] = tuple(names[at] for at in chosen if any(isinstance(cell, _STAMPS) for cell in cells[at]))
    if layout.unit_row:
        units = _texts(above[-1], width)
        must_be_units(path, units)
        frame.attrs["units"] = {names[at]: units[at] for at in chosen}
    return frame


def excel_tables(path: Path) -> tuple[str, ...]:
    """Names of the sheets that hold cells."""
    with parsing(path, "Excel workbook", _ADVICE, cycles=True), _workbook(path, LIMITS) as book:
        return tuple(sheet.title for sheet in book.worksheets)


def first_rows(path: Path, layout: FileFormat) -> list[Row]:
    """The first rows of a sheet with their values, empty ones among them, for a guess at its layout."""
    with parsing(path, "Excel workbook", _ADVICE, cycles=True), _sheet(path, layout) as sheet:
        rows = sheet.iter_rows(values_only=True, max_row=ROWS_LOOKED_AT, max_col=layout.limits.columns)
        return [tuple(row) for row in rows]


def text_rows(path: Path, limits: Limits) -> list[list[str]]:
    """All rows of the first sheet as texts, empty ones among them: whole numbers without a point, others with the 15
    digits that Excel shows, dates as ISO 8601, cells without a value empty.

    Raises RecordingError where the file is damaged or too large.
    """
    texts: list[list[str]] = []
    with parsing(path, "Excel workbook", _ADVICE, cycles=True), _sheet(path, FileFormat(limits=limits)) as sheet:
        width = 0
        # without max_col: rows are not filled up to it, and a damaged row number asks for a million empty ones
        for rows, row in enumerate(sheet.iter_rows(values_only=True, max_row=MOST_ROWS + 1), 1):
            if rows > MOST_ROWS:
                raise RecordingError(f"{path}: a row lies below row {MOST_ROWS}, the last of any workbook; {_ADVICE}")
            filled = _trimmed(row)
            width = max(width, len(filled))
            limits.allow_columns(path, width)
            limits.allow_bytes(path, 8.0 * rows * max(width, 1), f"sheet {sheet.title!r}")
            texts.append([_text(cell) for cell in filled])
    return texts


def _text(cell: Any) -> str:
    if cell is None or (isinstance(cell, str) and cell.strip() in MISSING[:3]):
        return ""
    if isinstance(cell, float):
        return f"{cell:.15g}"
    return " ".join(str(cell).split())


@contextmanager
def _workbook(path: Path, limits: Limits) -> Iterator[Any]:
    """An open workbook whose parts are no larger than allowed and declare no document type of their own."""
    import openpyxl

    with zipfile.ZipFile(path) as parts:
        limits.allow_bytes(path, sum(part.file_size for part in parts.infolist()), "its sheets")
        for part in parts.infolist():
            if part.filename.endswith((".xml", ".rels")):
                with parts.open(part) as stream:
                    if b"<!DOCTYPE" in stream.read(_DECLARED):
                        raise RecordingError(
                            f"{path}: its part {part.filename!r} declares a document type, which no spreadsheet does; "
                            "it is not read"
                        )
    with path.open("rb") as stream:
        book = openpyxl.load_workbook(stream, read_only=True, data_only=True, keep_links=False)
        try:
            yield book
        finally:
            book.close()


@contextmanager
def _sheet(path: Path, layout: FileFormat) -> Iterator[Any]:
    with _workbook(path, layout.limits) as book:
        titles = [sheet.title for sheet in book.worksheets]
        if not titles:
            raise MisnamedError(f"{path} holds no sheet with cells; is it a recording?")
        title = titles[0] if layout.variable is None else chosen_table(path, titles, layout.variable, "sheet")
        sheet = next(one for one in book.worksheets if one.title == title)
        sheet.reset_dimensions()  # as stated they may be wrong or a million columns wide
        yield sheet


def _head(path: Path, sheet: Any, layout: FileFormat) -> tuple[list[Row], int, int]:
    """The rows above the data, the table's width, and the first row of data counted from 1."""
    rows_above = (1 if layout.header else 0) + (1 if layout.unit_row else 0)
    above: list[Row] = []
    start = layout.skip_rows + 1
    rows = sheet.iter_rows(
        values_only=True, min_row=start, max_row=start + ROWS_LOOKED_AT, max_col=layout.limits.columns + 1
    )
    for at, row in enumerate(rows, start):
        filled = _trimmed(row)
        if not filled:
            continue
        if len(above) == rows_above:
            return above, max(len(filled), *(len(_trimmed(one)) for one in above), 0), at
        above.append(row)
    raise RecordingError(
        f"{path}: sheet {sheet.title!r} has {len(above)} rows after {layout.skip_rows} skipped ones, and no data among "
        "them; check skip_rows, header and recordings.variable"
    )


def _trimmed(row: Row) -> Row:
    """A row without the empty cells at its end."""
    end = next((at for at in range(len(row), 0, -1) if row[at - 1] not in (None, "")), 0)
    return row[:end]


def _texts(row: Row, width: int) -> list[str]:
    cells = ["" if cell is None else str(cell).strip().lstrip("#").strip() for cell in row[:width]]
    return cells + [""] * (width - len(cells))


def _columns(path: Path, sheet: Any, first: int, chosen: Sequence[int], limits: Limits) -> dict[int, list[Any]]:
    """Values of the chosen columns from the first row of data to the last that holds one."""
    width = max(chosen, default=0) + 1
    cells: dict[int, list[Any]] = {at: [] for at in chosen}
    last = 0
    for rows, row in enumerate(sheet.iter_rows(values_only=True, min_row=first, max_col=width), 1):
        limits.allow_bytes(path, 8.0 * rows * width, f"sheet {sheet.title!r}")
        for at, values in cells.items():
            value = row[at] if at < len(row) else None
            values.append(value)
            if value is not None:
                last = rows
    return {at: values[:last] for at, values in cells.items()}


def _all_texts(cells: Sequence[Any]) -> bool:
    """Whether a column has a text and no number, with whatever decimal mark, date or time."""
    there = [cell for cell in cells if cell is not None and not isinstance(cell, bool)]
    numbers = (isinstance(c, _STAMPS) or any(_number(c, mark, None) is not None for mark in DECIMALS) for c in there)
    return len(there) > 0 and not any(numbers)


def _numbers(path: Path, name: Column, cells: Sequence[Any], layout: FileFormat, first: int) -> Any:
    """A column as float64 (n,); RecordingError at the first text in it, or where it has no value at all."""
    if not any(cell is not None for cell in cells):
        raise RecordingError(
            f"{path}: column {name!r} has no values; where it holds formulas, open it in Excel and save it"
        )
    start = next((cell for cell in cells if isinstance(cell, datetime.datetime)), None)
    values = np.empty(len(cells))
    for at, cell in enumerate(cells):
        value = _number(cell, layout.decimal, start)
        if value is None:
            text = str(cell)[:40]
            raise RecordingError(
                f"{path}: column {name!r}, row {first + at}: {text!r} is not a number; repair the file, or skip the "
                "rows above its data"
            )
        values[at] = value
    return values


def _number(cell: Any, decimal: str, start: datetime.datetime | None) -> float | None:
    """A cell as a number, seconds for dates and times; nan where it is empty, None where it is a text."""
    if isinstance(cell, bool):
        return None
    if isinstance(cell, int | float):
        return float(cell)
    if cell is None or (isinstance(cell, str) and cell.strip() in MISSING):
        return float("nan")
    if isinstance(cell, datetime.datetime) and start is not None:
        return (cell - start).total_seconds()
    if isinstance(cell, datetime.timedelta):
        return cell.total_seconds()
    if isinstance(cell, datetime.time):
        return 3600.0 * cell.hour + 60.0 * cell.minute + cell.second + 1e-6 * cell.microsecond
    try:
        return float(str(cell).strip().replace(decimal, "."))
    except ValueError:
        return None
