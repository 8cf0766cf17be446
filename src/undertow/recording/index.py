"""The index of a campaign: a table of texts with one row a trial, its own separator and its own decimal mark; in a file
of text or on the first sheet of an Excel workbook.

A column's numbers are read with one decimal mark. Found by itself ("auto") it is a comma where a column has numbers
with commas and none with points; in a table parted by commas (cells like "1,63" then stand in quotes) every cell of the
column must be a number besides. Where commas may as well part thousands, that is said and nothing is guessed.

Belongs here: rows and cells. Does not belong here: which column names the file (gather.py).
"""

from __future__ import annotations

import csv
import difflib
import io
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from undertow.errors import ConfigError, RecordingError
from undertow.recording.conditions import condition, number
from undertow.recording.excel import EXCEL, text_rows
from undertow.recording.limits import LIMITS
from undertow.recording.links import refused
from undertow.recording.recording import Condition
from undertow.recording.text import sniff, text_of

SEPARATORS = {"tab": "\t", "space": " "}
"""Separators that have a name in a config."""

_SAVED_AGAIN = (".xls", ".xlsb", ".ods", ".numbers")
_SNIFFED_LINES = 20
_SPACES = r"\s+"  # as a table's separator is written that stands for any number of blanks
_COMMA = re.compile(r"[+-]?([0-9]*,[0-9]+|[0-9]+,)([eE][+-]?[0-9]+)?")
_POINT = re.compile(r"[+-]?([0-9]*\.[0-9]+|[0-9]+\.)([eE][+-]?[0-9]+)?")
_THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2},[0-9]{3}")


@dataclass(frozen=True)
class Index:
    """An index as text: ``columns``, and ``commas``, those of them whose numbers have a decimal comma."""

    path: Path
    columns: tuple[str, ...]
    separator: str
    commas: frozenset[str] = frozenset()
    lines: Sequence[str] = field(default=(), repr=False)

    def rows(self) -> Iterator[dict[str, str]]:
        """The rows below the header, by column, one at a time; empty ones are left out.

        Raises ConfigError where a row has more cells than the header has columns: its values stand in wrong columns.
        """
        for line, cells in _cells(self.lines, self.separator, self.path, above=1):
            if any(cells[len(self.columns) :]):
                advice = "name its column, or clear the cell"
                if not _is_workbook(self.path):
                    mark = _named(self.separator)
                    advice = f"put a cell with a {mark} in it into quotes, or set recordings.index_separator"
                raise ConfigError(
                    f"recordings.index {self.path.name} line {line} has {len(cells)} cells but the header has "
                    f"{len(self.columns)}; {advice}"
                )
            yield dict(zip(self.columns, cells, strict=False))

    def value(self, column: str, text: str) -> Condition:
        """A cell as a condition, with its column's decimal mark; a number with the other mark stays a text."""
        other = _POINT if column in self.commas else _COMMA
        return text.strip() if other.fullmatch(text.strip()) else condition(text)


def is_separator(text: str) -> bool:
    r"""Whether a text can part the cells of a line: one character that ends no line and opens no quotation, or ``\s+``.

    >>> is_separator("|"), is_separator("(("), is_separator("\n")
    (True, False, False)
    """
    return text == _SPACES or (len(text) == 1 and text not in '\n\r"')


def read_index(path: Path, separator: str = "auto", decimal: str = "auto") -> Index:
    """An index; ``separator`` is a character, tab, space or auto, ``decimal`` ".", "," or auto.

    Raises ConfigError where there is none, it is no table, has a column twice, or its commas may part thousands.
    """
    if os.path.isdir(path):
        raise ConfigError(f"recordings.index {path} is a folder; give the table that lists the trials, as index.csv")
    if not os.path.isfile(path):
        beside = [one.name for one in path.parent.iterdir()] if os.path.isdir(path.parent) else []
        near = difflib.get_close_matches(path.name, beside, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise ConfigError(f"recordings.index {path} is not there; paths are relative to the config's folder{hint}")
    if link := refused(path, path.parent):
        raise ConfigError(f"recordings.index {path} is {link}")
    workbook = _is_workbook(path)
    if workbook and separator != "auto":
        raise ConfigError(f"recordings.index_separator is {separator!r}, but {path.name} is a workbook; leave it out")
    if path.suffix.lower() in _SAVED_AGAIN:
        raise ConfigError(f"recordings.index {path} is an old or foreign spreadsheet; save it as .xlsx or CSV")
    try:
        lines = _sheet_lines(path) if workbook else text_of(path).splitlines()
    except RecordingError as error:
        raise ConfigError(f"recordings.index: {error}") from error
    found = "," if workbook else _found_separator(lines)
    parted = found if separator == "auto" else SEPARATORS.get(separator, separator)
    _, head = next(_cells(lines, parted, path), (1, []))
    twice = next((name for name in head if name and head.count(name) > 1), None)
    if twice is not None:
        raise ConfigError(f"recordings.index {path} has {head.count(twice)} columns named {twice!r}; keep one")
    index = Index(path, tuple(head), parted, frozenset(), lines)
    commas = _comma_columns(index) if decimal == "auto" else frozenset(head if decimal == "," else ())
    return Index(path, tuple(head), parted, commas, lines)


def _is_workbook(path: Path) -> bool:
    return path.suffix.lower() in EXCEL


def _sheet_lines(path: Path) -> list[str]:
    """The rows of a workbook's first sheet as lines of CSV, none shorter than the header."""
    rows, lines = text_rows(path, LIMITS), []
    width = next((len(row) for row in rows if row), 0)
    for row in rows:
        line = io.StringIO()
        csv.writer(line, lineterminator="").writerow([*row, *[""] * (width - len(row))])
        lines.append(line.getvalue())
    return lines


def _found_separator(lines: Sequence[str]) -> str:
    """The separator that the first lines share, else the header's; a comma where there is none."""
    written = [line for line in lines if line.strip()][:_SNIFFED_LINES]
    for some in (written, written[:1]):
        found = sniff(some, ".")
        if len(found) == 1:
            return found
    return ","


def _cells(lines: Iterable[str], separator: str, path: Path, above: int = 0) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of the rows that are not empty, after ``above`` of them."""
    if separator == " ":
        rows: Iterator[tuple[int, list[str]]] = ((at, text.split()) for at, text in enumerate(lines, 1))
    else:
        reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
        rows = ((reader.line_num, row) for row in reader)
    try:
        for line, row in rows:
            cells = [cell.strip() for cell in row]
            if any(cells):
                above -= 1
                if above < 0:
                    yield line, cells
    except csv.Error as error:
        raise ConfigError(f"recordings.index {path} is no table ({error}); save it as CSV") from error


def _comma_columns(index: Index) -> frozenset[str]:
    """Columns whose numbers have a decimal comma. ConfigError where a comma may part thousands."""
    mark = '"' if index.separator == "," else ","
    if not any(mark in line for line in index.lines):
        return frozenset()
    seen = {name: _Column() for name in index.columns}
    for row in index.rows():
        for name, text in row.items():
            seen[name].add(text)
    strict = index.separator == ","
    sure = [name for name, one in seen.items() if one.decimal(strict) and not one.thousands]
    points = any(one.points and not one.texts for one in seen.values())
    for name, one in seen.items():
        both = bool(one.commas and one.points and not one.texts)
        if both or (one.decimal(strict) and one.thousands and not sure and (strict or points)):
            example = f"{one.commas} and {one.points}" if both else one.commas
            raise ConfigError(
                f"recordings.index {index.path.name}: column {name!r} has {example}, where a comma may be a decimal "
                "mark or part thousands; set recordings.index_decimal to ',' or '.', and leave thousands unmarked"
            )
    return frozenset(name for name, one in seen.items() if one.decimal(strict))


@dataclass
class _Column:
    """What the cells of one column look like: an example each of numbers with a comma and a point, and of texts."""

    commas: str = ""
    points: str = ""
    texts: str = ""
    thousands: bool = True

    def add(self, text: str) -> None:
        """One more cell."""
        if not text or text.lower() == "nan":
            return
        if _COMMA.fullmatch(text):
            self.commas = self.commas or text
            self.thousands = self.thousands and bool(_THOUSANDS.fullmatch(text))
        elif _POINT.fullmatch(text):
            self.points = self.points or text
        elif number(text) is None:
            self.texts = self.texts or text

    def decimal(self, strict: bool) -> bool:
        """Whether its numbers have a decimal comma; ``strict``: texts beside them speak against it."""
        return bool(self.commas) and not self.points and not (strict and self.texts)


def _named(separator: str) -> str:
    return {",": "comma", ";": "semicolon", "\t": "tab", " ": "blank", "|": "bar"}.get(separator, repr(separator))
