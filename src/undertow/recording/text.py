"""A text file's bytes as a table of numbers: compression, encoding, separator, header, decimal comma.

Belongs here: everything a CSV or TXT file can do wrong. Does not belong here: which column means what (catalogue.py).
"""

from __future__ import annotations

import csv
import gzip
import io
import re
import warnings
import zlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.layout import DECIMALS, Column, FileFormat, pick
from undertow.recording.limits import LIMITS, LONGEST_LINE, Limits
from undertow.recording.stamps import STAMPED, is_stamp, seconds_of_texts
from undertow.recording.thousands import first_parted, may_be_parted, parted

_SEPARATORS = (";", "\t", "|", ",")
_WHITESPACE = r"\s+"
_SNIFFED_LINES = 20
_DECIMAL_COMMA = re.compile(r"^\s*[+-]?\d+,\d+([eE][+-]?\d+)?\s*$")
_THOUSANDS = re.compile(r"^\s*[+-]?\d{1,3},\d{3}\s*$")
_LINE_END = re.compile(rb"\r\n|\n|\r")
_MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
_NO_TABLE = (pd.errors.ParserError, pd.errors.ParserWarning, pd.errors.EmptyDataError)
_SHOWN = 40  # characters of a cell or line in a message


def text_of(path: Path, limits: Limits = LIMITS, encoding: str | None = None) -> str:
    """A file's text, unzipped where it ends in .gz; in ``encoding``, or UTF-8, UTF-16 with its mark, or else Latin-1.

    Raises RecordingError where the file cannot be read, is too large, empty, cut short or not text.
    """
    return _utf8(path, limits, encoding).decode("utf-8", errors="replace")


def _utf8(path: Path, limits: Limits, encoding: str | None) -> bytes:
    """A text file's content in UTF-8, without a mark."""
    raw = _unpacked(path, limits)
    if not raw or raw.isspace():
        raise RecordingError(f"{path} is empty ({len(raw)} bytes); copy it again or take it out of the campaign")
    found = encoding or next((name for mark, name in _MARKS.items() if raw.startswith(mark)), None)
    if found is not None:
        try:
            return raw.decode(found, errors="strict" if encoding else "replace").encode("utf-8", errors="replace")
        except (UnicodeError, LookupError) as error:
            raise RecordingError(
                f"{path} is not in encoding {found!r} ({error}); correct recordings.encoding"
            ) from error
    control = sum(raw[:4096].count(byte) for byte in range(32) if byte not in (9, 10, 12, 13))
    if control:
        raise RecordingError(f"{path} is not text: {control} control bytes at its beginning; is its suffix right?")
    try:
        raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1").encode("utf-8")
    return raw


def _unpacked(path: Path, limits: Limits) -> bytes:
    """A file's bytes, unzipped where it ends in .gz; never more than the limit and one byte are read."""
    most = limits.bytes
    try:
        if path.suffix.lower() == ".gz":
            with gzip.open(path) as stream:
                raw = stream.read(most + 1)
        else:
            limits.allow_bytes(path, path.stat().st_size, "its text")
            with path.open("rb") as stream:
                raw = stream.read(most + 1)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise RecordingError(f"{path} is not a whole gzip file ({error}); copy it again") from error
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror or error}; check its rights") from error
    limits.allow_unfolded(path, 0, len(raw))
    return raw


def sniff(lines: Sequence[str], decimal: str) -> str:
    """The separator that gives each of the lines the same number of fields; a comma where there is only one column.

    >>> sniff(["1.0;2.0", "3.0;4.0"], "."), sniff(["1.0  2.0", "3.0 4.0"], ".")
    (';', '\\\\s+')
    """
    for separator in _SEPARATORS:
        if separator == decimal and not all('","' in line for line in lines):
            continue
        fewest, most = _extremes([line.count(separator) for line in lines])
        if fewest > 0 and fewest == most:
            return separator
    fewest, _ = _extremes([len(line.split()) for line in lines])
    return _WHITESPACE if fewest > 1 else (";" if decimal == "," else ",")


@dataclass(frozen=True)
class _Head:
    """Beginning of a table: its rows above the data (names, units), a few rows of data, where these begin."""

    above: Sequence[str]
    data: Sequence[str]
    offset: int
    line: int


def read_text(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The asked columns (all but those of texts where None) of a text table as float64; names are 0, 1, ... without a
    header. Dates with times, and times of day, become seconds since the first row.

    ``frame.attrs["units"]`` holds the unit row, if the layout says that there is one.

    Raises RecordingError naming file, column, line number and text where a number cannot be read.
    """
    return table_of(path, _utf8(path, layout.limits, layout.encoding), layout, columns)


def table_of(path: Path, content: bytes, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The table that a text (UTF-8) holds; as `read_text`, which it is the second half of."""
    head = _head(path, content, layout)
    separator = layout.separator or sniff(head.data, layout.decimal)
    width = len(_fields(path, head.data[0], separator))
    named = _fields(path, head.above[0], separator) if layout.header else []
    names: list[Column] = list(named) if layout.header else list(range(width))
    layout.limits.allow_columns(path, max(len(names), width))
    _check_header(path, named, layout)
    chosen = pick(path, names, columns)
    frame = _parse(path, content, head, separator, layout, max(len(names), width))
    if columns is None and (able := [at for at in chosen if not _all_texts(frame[at])]):
        chosen = able
    mark = layout.decimal
    for at in chosen:
        if frame[at].dtype.kind == "f" and may_be_parted(frame[at].to_numpy()):
            texts = _parse(path, content, head, separator, layout, frame.shape[1], texts=True)[at]
            _must_not_part_thousands(path, names[at], texts, content, head, mark)
    table = pd.DataFrame({names[at]: _numbers(path, names[at], frame[at], content, head, mark) for at in chosen})
    table.attrs[STAMPED] = tuple(names[at] for at in chosen if _holds_stamps(frame[at]))
    if layout.unit_row:
        units = _fields(path, head.above[-1], separator)
        must_be_units(path, units, mark)
        table.attrs["units"] = {names[at]: units[at] for at in chosen if at < len(units)}
    return table


def _head(path: Path, content: bytes, layout: FileFormat) -> _Head:
    """The lines above the data and the first of it; blank lines below the skipped ones do not count."""
    rows_above = (1 if layout.header else 0) + (1 if layout.unit_row else 0)
    above: list[str] = []
    data: list[str] = []
    offset, first = len(content), 0
    for number, start, line in _lines(path, content, layout.skip_rows):
        if len(above) < rows_above:
            above.append(line)
            continue
        if not data:
            offset, first = start, number
        data.append(line)
        if len(data) == _SNIFFED_LINES:
            break
    if not data:
        raise RecordingError(
            f"{path} has {len(above)} lines after {layout.skip_rows} skipped ones, and no data among them; "
            "check skip_rows and header"
        )
    return _Head(above, data, offset, first)


def _lines(path: Path, content: bytes, skipped: int = 0, offset: int = 0) -> Iterator[tuple[int, int, str]]:
    """Number from 1, offset and text of the lines that are not blank, from an offset on and after skipped ones."""
    number = 0
    while offset < len(content):
        number += 1
        end = _LINE_END.search(content, offset, offset + LONGEST_LINE)
        if end is None and len(content) - offset > LONGEST_LINE:
            raise RecordingError(
                f"{path}: line {number} has more than {LONGEST_LINE} characters; is it a recording with rows?"
            )
        stop, after = (end.start(), end.end()) if end else (len(content), len(content))
        line = content[offset:stop]
        if number > skipped and line.strip():
            yield number, offset, line.decode("utf-8", errors="replace")
        offset = after


def _extremes(counts: Sequence[int]) -> tuple[int, int]:
    """Smallest count, and largest of those that are not single exceptions (a cut last line)."""
    common = [count for count, times in Counter(counts).items() if times > 1 or len(counts) < 3]
    return (min(common), max(common)) if common else (0, 1)


def _fields(path: Path, line: str, separator: str) -> list[str]:
    if separator == _WHITESPACE:
        return line.lstrip("#").split()
    try:
        row = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    except csv.Error as error:
        raise RecordingError(
            f"{path}: line {line[:_SHOWN]!r}... is no row of a table ({error}); is it a recording?"
        ) from error
    return [field.strip().lstrip("#").strip() for field in row]


def _check_header(path: Path, head: Sequence[str], layout: FileFormat) -> None:
    """A header of numbers is a first row of data: taking it for names would lose a sample silently."""
    if head and all(is_number(field, layout.decimal) for field in head if field):
        raise RecordingError(
            f"{path}: the header line holds numbers ({', '.join(head[:4])}); set header: none, columns by number"
        )


def must_be_units(path: Path, units: Sequence[str], decimal: str = ".") -> None:
    """A row of units that holds numbers is one of data: taking it for units would lose a sample silently."""
    if any(units) and all(is_number(unit, decimal) for unit in units if unit):
        raise RecordingError(
            f"{path}: the row of units holds numbers ({', '.join(units[:4])}); set unit_row: false, or skip_rows so "
            "that the row of names is the first"
        )


def is_number(text: str, decimal: str) -> bool:
    """Whether a cell is a number with that decimal mark, or a stamp, which becomes one."""
    if decimal != "." and "." in text:
        return is_stamp(text)
    try:
        float(text.replace(decimal, "."))
    except ValueError:
        return is_stamp(text)
    return True


def _parse(
    path: Path, content: bytes, head: _Head, separator: str, layout: FileFormat, width: int, texts: bool = False
) -> pd.DataFrame:
    """The table's cells: numbers where all of a column's are, or ``texts`` as they are written."""
    stream = io.BytesIO(content)
    stream.seek(head.offset)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)  # a row with more cells than there are columns
            return pd.read_csv(
                stream, sep=separator, decimal=layout.decimal, header=None, names=range(width), encoding="utf-8",
                encoding_errors="replace", index_col=False, engine="c", low_memory=False, skipinitialspace=True,
                dtype=str if texts else None,
            )  # fmt: skip
    except (*_NO_TABLE, ValueError, OverflowError) as error:
        raise RecordingError(
            f"{path} is no table with separator {separator!r}: {str(error).strip()}; give recordings.separator"
        ) from error


def _must_not_part_thousands(
    path: Path, name: Column, written: pd.Series, content: bytes, head: _Head, decimal: str
) -> None:
    """RecordingError where a column's decimals are thousands: as written, which numbers no longer show."""
    cells = written.dropna().str.strip()
    at = first_parted(cells, decimal)
    if at is None:
        return
    row, text = int(cells.index[at]), str(cells.iloc[at])
    raise RecordingError(
        f"{path}: column {name!r}, line {_line_of(path, content, head, row)}: {text!r} seems to be "
        f"{text.replace(decimal, '')} with parted thousands: every number of the column has three digits behind "
        "the mark or no mark, and none lies between 0 and 1; save the file without that mark, or with all decimals"
    )


def _numbers(path: Path, name: Column, column: pd.Series, content: bytes, head: _Head, decimal: str) -> pd.Series:
    """A column as float64; the first text in it is the error, but for stamps, and so is a point beside a decimal comma:
    it may part thousands."""
    if column.dtype.kind in "fiu":
        return column.astype("float64")
    if _holds_stamps(column):
        return _seconds(path, name, column, content, head)
    try:
        converted = pd.to_numeric(column, errors="coerce")
    except OverflowError:
        converted = column.map(_float)
    wrong = converted.isna() & column.notna()
    if decimal != ".":
        wrong |= column.astype(str).str.contains(".", regex=False)
    if column.dtype.kind == "b":
        wrong = column.notna()
    elif not wrong.any():
        return converted.astype("float64")  # whole numbers too long for 64 bits
    at = int(wrong.to_numpy().argmax())
    text = str(column.iloc[at])
    advice = "set decimal: ','" if _DECIMAL_COMMA.match(text) else "repair the file, or skip the lines above its data"
    advice += ", or save the file without the comma if it parts thousands" if _THOUSANDS.match(text) else ""
    if said := parted(text):
        advice = said
    elif decimal != "." and "." in text:
        advice = f"the decimal mark is {decimal!r}: if the point parts thousands, save the file without it"
    text = text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."
    line = _line_of(path, content, head, at)
    raise RecordingError(f"{path}: column {name!r}, line {line}: {text!r} is not a number; {advice}")


def _all_texts(column: pd.Series) -> bool:
    """Whether no cell of a column is a number, with whatever marks, or a stamp, and one is there."""
    cells = column.dropna()
    if not cells.size or cells.dtype.kind in "fiub":
        return False
    return not any(parted(text) or any(is_number(text, mark) for mark in DECIMALS) for text in map(str, cells))


def _holds_stamps(column: pd.Series) -> bool:
    """Whether a column's first cell that is not empty is a stamp."""
    first = None if column.dtype.kind in "fiub" else column.first_valid_index()
    return first is not None and is_stamp(str(column.loc[first]))


def _seconds(path: Path, name: Column, column: pd.Series, content: bytes, head: _Head) -> pd.Series:
    """A column of stamps as seconds since its first; the first that is none, or of another zone, is the error."""
    try:
        return pd.Series(seconds_of_texts(column), column.index)
    except ValueError as error:
        at = int(error.args[0])
        line, text = _line_of(path, content, head, at), str(column.iloc[at])[:_SHOWN]
        raise RecordingError(
            f"{path}: column {name!r}, line {line}: {text!r} is no time stamp like the first, "
            f"{column.dropna().iloc[0]!r}; repair the file"
        ) from error


def _float(value: object) -> float:
    """A cell as a number, infinite where it is too large; nan for a text."""
    try:
        return float(str(value))
    except ValueError:
        return float("nan")


def _line_of(path: Path, content: bytes, head: _Head, row: int) -> int:
    """Line from 1 in which a row of data stands."""
    for at, (number, _, _) in enumerate(_lines(path, content, offset=head.offset)):
        if at == row:
            return head.line + number - 1
    return head.line + row
