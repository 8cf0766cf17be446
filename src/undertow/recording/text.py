"""A text file's bytes as a table of numbers: compression, encoding, separator, header, decimal comma.

Belongs here: everything a CSV or TXT file can do wrong. Does not belong here: which column means what (catalogue.py).
"""

from __future__ import annotations

import csv
import gzip
import io
import re
import zlib
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.layout import Column, FileFormat, pick

_SEPARATORS = (";", "\t", "|", ",")
_WHITESPACE = r"\s+"
_SNIFFED_LINES = 20
_DECIMAL_COMMA = re.compile(r"^\s*[+-]?\d+,\d+([eE][+-]?\d+)?\s*$")


def text_of(path: Path) -> str:
    """A file's text, unzipped where it ends in .gz; UTF-8, UTF-16 with its mark, or else Latin-1.

    Raises RecordingError where the file cannot be read, is empty, cut short or not text.
    """
    try:
        raw = path.read_bytes()
        if path.suffix.lower() == ".gz":
            raw = gzip.decompress(raw)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise RecordingError(f"{path} is not a whole gzip file ({error}); copy it again") from error
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror or error}; check its rights") from error
    if not raw.strip():
        raise RecordingError(f"{path} is empty ({len(raw)} bytes); copy it again or take it out of the campaign")
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return raw.decode("utf-16", errors="replace")
    control = sum(raw[:4096].count(byte) for byte in range(32) if byte not in (9, 10, 12, 13))
    if control:
        raise RecordingError(f"{path} is not text: {control} control bytes at its beginning; is its suffix right?")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def sniff(lines: Sequence[str], decimal: str) -> str:
    """The separator that gives each of the lines the same number of fields; a comma where there is only one column.

    >>> sniff(["1.0;2.0", "3.0;4.0"], "."), sniff(["1.0  2.0", "3.0 4.0"], ".")
    (';', '\\\\s+')
    """
    for separator in _SEPARATORS:
        if separator == decimal:
            continue
        fewest, most = _extremes([line.count(separator) for line in lines])
        if fewest > 0 and fewest == most:
            return separator
    fewest, _ = _extremes([len(line.split()) for line in lines])
    return _WHITESPACE if fewest > 1 else (";" if decimal == "," else ",")


def read_text(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The asked columns (all where None) of a text table as float64; names are 0, 1, ... without a header.

    ``frame.attrs["units"]`` holds the unit row, if the layout says that there is one.

    Raises RecordingError naming file, column, line number and text where a number cannot be read.
    """
    lines = text_of(path).splitlines()[layout.skip_rows :]
    numbered = [(n, line) for n, line in enumerate(lines, layout.skip_rows + 1) if line.strip()]
    above = (1 if layout.header else 0) + (1 if layout.unit_row else 0)
    data = numbered[above:]
    if not data:
        raise RecordingError(
            f"{path} has {len(numbered)} lines after {layout.skip_rows} skipped ones, and no data among them; "
            "check skip_rows and header"
        )
    separator = layout.separator or sniff([line for _, line in data[:_SNIFFED_LINES]], layout.decimal)
    width = len(_fields(data[0][1], separator))
    head = _fields(numbered[0][1], separator) if layout.header else []
    names: list[Column] = list(head) if layout.header else list(range(width))
    _check_header(path, head, layout)
    chosen = pick(path, names, columns)
    frame = _parse(path, [line for _, line in data], separator, layout, max(len(names), width))
    table = pd.DataFrame({names[at]: _numbers(path, names[at], frame[at], [n for n, _ in data]) for at in chosen})
    if layout.unit_row:
        units = _fields(numbered[1 if layout.header else 0][1], separator)
        table.attrs["units"] = {names[at]: units[at] for at in chosen if at < len(units)}
    return table


def _extremes(counts: Sequence[int]) -> tuple[int, int]:
    """Smallest count, and largest of those that are not single exceptions (a cut last line)."""
    common = [count for count, times in Counter(counts).items() if times > 1 or len(counts) < 3]
    return (min(common), max(common)) if common else (0, 1)


def _fields(line: str, separator: str) -> list[str]:
    if separator == _WHITESPACE:
        return line.lstrip("#").split()
    try:
        row = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    except csv.Error as error:
        raise RecordingError(f"line {line[:40]!r}... is no row of a table ({error}); is it a recording?") from error
    return [field.strip().lstrip("#").strip() for field in row]


def _check_header(path: Path, head: Sequence[str], layout: FileFormat) -> None:
    """A header of numbers is a first row of data: taking it for names would lose a sample silently."""
    if head and all(_is_number(field, layout.decimal) for field in head if field):
        raise RecordingError(
            f"{path}: the header line holds numbers ({', '.join(head[:4])}); set header: none, columns by number"
        )


def _is_number(text: str, decimal: str) -> bool:
    try:
        float(text.replace(decimal, "."))
    except ValueError:
        return False
    return True


def _parse(path: Path, lines: Sequence[str], separator: str, layout: FileFormat, width: int) -> pd.DataFrame:
    try:
        return pd.read_csv(
            io.StringIO("\n".join(lines)), sep=separator, decimal=layout.decimal, header=None, names=range(width),
            index_col=False, engine="c", low_memory=False, skipinitialspace=True,
        )  # fmt: skip
    except (pd.errors.ParserError, pd.errors.EmptyDataError, ValueError) as error:
        raise RecordingError(
            f"{path} is no table with separator {separator!r}: {str(error).strip()}; give recordings.separator"
        ) from error


def _numbers(path: Path, name: Column, column: pd.Series, numbers: Sequence[int]) -> pd.Series:
    """A column as float64; the first text in it is the error."""
    if column.dtype.kind in "fiu":
        return column.astype("float64")
    converted = pd.to_numeric(column, errors="coerce")
    wrong = converted.isna() & column.notna()
    if column.dtype.kind == "b":
        wrong = column.notna()
    elif not wrong.any():
        return converted.astype("float64")  # whole numbers too long for 64 bits
    at = int(wrong.to_numpy().argmax())
    text = str(column.iloc[at])
    advice = "set decimal: ','" if _DECIMAL_COMMA.match(text) else "repair the file, or skip the lines above its data"
    raise RecordingError(f"{path}: column {name!r}, line {numbers[at]}: {text!r} is not a number; {advice}")
