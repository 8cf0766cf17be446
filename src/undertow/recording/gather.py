"""The list of a campaign's trials, from an index or from file names.

Belongs here: names, paths, conditions. Does not belong here: reading samples (catalogue.py).
"""

from __future__ import annotations

import csv
import glob
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatch
from itertools import chain
from pathlib import Path
from types import MappingProxyType

from undertow.errors import ConfigError, RecordingError
from undertow.recording.catalogue import Catalogue, Entry, Window
from undertow.recording.readers import count_trials, trial_name
from undertow.recording.recording import Condition
from undertow.recording.text import sniff, text_of

_FIELD = re.compile(r"\{(\w+)\}")
_Known = dict[tuple[tuple[str, Condition], ...], Mapping[str, Condition]]


def condition(text: str) -> Condition:
    """A condition as a number where it looks like one.

    >>> condition("2.36"), condition("long"), condition("nan")
    (2.36, 'long', 'nan')
    """
    try:
        number = float(text)
    except ValueError:
        return text.strip()
    return number if math.isfinite(number) else text.strip()


def gather(catalogue: Catalogue) -> tuple[Entry, ...]:
    """Every trial of a campaign, in the index's or the names' order.

    A file that the index names and that is not there (or lies outside the index's folder) is an entry with a
    ``problem``: it must not stop the others.

    Raises ConfigError where the index or its column is missing, a pattern is wrong, or no trial is left.
    """
    if (catalogue.index is None) == (catalogue.files is None):
        raise ConfigError(
            f"recordings has index {catalogue.index!r} and files {catalogue.files!r}; give exactly one of them"
        )
    entries = _from_index(catalogue) if catalogue.index is not None else _from_names(catalogue)
    entries = [entry for entry in entries if not any(fits(entry, pattern) for pattern in catalogue.exclude)]
    if not entries:
        raise ConfigError(f"recordings.exclude {list(catalogue.exclude)} leaves no trial; take a pattern out of it")
    entries = [trial for entry in _unique(entries, catalogue.folder) for trial in _trials(entry, catalogue)]
    return tuple(_with_patterns(entry, catalogue) for entry in entries)


def fits(entry: Entry, pattern: str) -> bool:
    """Whether a file name pattern fits a trial: its file's name, its path's end, or its own name.

    >>> fits(Entry("t_01", Path("a/t_01.txt")), "*_01.txt")
    True
    """
    return any(fnmatch(name, pattern) for name in (entry.path.name, entry.path.as_posix(), entry.name))


def read_index(path: Path) -> Iterator[dict[str, str]]:
    """Rows of an index as text, by column, one at a time; separators as in recordings. ConfigError where there is none.
    """
    if not path.is_file():
        raise ConfigError(f"recordings.index {path} is not there; paths are relative to the config's folder")
    try:
        lines = [line for line in text_of(path).splitlines() if line.strip()]
    except RecordingError as error:
        raise ConfigError(f"recordings.index: {error}") from error
    separator = sniff(lines[:1], ".")
    try:
        rows = csv.reader(lines, delimiter="," if len(separator) > 1 else separator, skipinitialspace=True)
        head = [name.strip() for name in next(rows, [])]
        for row in rows:
            yield dict(zip(head, (cell.strip() for cell in row), strict=False))
    except csv.Error as error:
        raise ConfigError(f"recordings.index {path} is no table ({error}); save it as CSV") from error


def _from_index(catalogue: Catalogue) -> list[Entry]:
    index = catalogue.folder / str(catalogue.index)
    rows = read_index(index)
    first = next(rows, None)
    if first is None:
        raise ConfigError(f"recordings.index {index} has no rows below its header; give it one row a trial")
    needed = _FIELD.findall(catalogue.file) if catalogue.file else [catalogue.index_column]
    for column in needed:
        if column not in first:
            raise ConfigError(
                f"recordings.index {index} has no column {column!r}; it has {', '.join(first)}: "
                "set recordings.index_column or recordings.file"
            )
    known: _Known = {}
    return [_row_entry(row, catalogue, index.parent, known) for row in chain((first,), rows)]


def _row_entry(row: Mapping[str, str], catalogue: Catalogue, folder: Path, known: _Known) -> Entry:
    """The trial of one row; its conditions are those of an earlier trial where they are the same."""
    name = row.get(catalogue.index_column, "") if catalogue.file is None else _filled(catalogue.file, row)
    conditions = {
        key: condition(value)
        for key, value in row.items()
        if value and value.lower() != "nan" and (catalogue.file is not None or key != catalogue.index_column)
    }
    shared = known.setdefault(tuple(conditions.items()), MappingProxyType(conditions))
    entry = Entry(trial_name(Path(name)), folder / name, shared)
    parts = [row.get(key, "") for key in _FIELD.findall(catalogue.file)] if catalogue.file else [name]
    if not name or any(_escapes(part) for part in parts):
        path = folder / (Path(name).name or "unnamed")
        problem = f"the index names the file {name!r}; it must lie in the index's folder {folder}"
        return replace(entry, file=path, name=trial_name(path), problem=problem)
    if not entry.path.is_file():
        return replace(
            entry, problem=f"the index names {name!r}, but {entry.path} is not there; copy it or drop the row"
        )
    return entry


def _filled(pattern: str, row: Mapping[str, str]) -> str:
    """A file name with the row's values in place of ``{column}``."""
    return _FIELD.sub(lambda match: row.get(match.group(1), ""), pattern)


def _escapes(name: str) -> bool:
    """Whether a name from an index leads out of the index's folder (absolute, a drive, or ``..``)."""
    plain = name.replace("\\", "/")
    return not plain or plain.startswith(("/", "~")) or ".." in plain.split("/") or bool(re.match(r"^[A-Za-z]:", plain))


def _from_names(catalogue: Catalogue) -> list[Entry]:
    pattern = str(catalogue.folder / str(catalogue.files))
    paths = [Path(path) for path in sorted(glob.glob(pattern, recursive=True)) if Path(path).is_file()]
    if not paths:
        raise ConfigError(f"recordings.files {catalogue.files!r} fits no file ({pattern}); correct the glob")
    try:
        expression = re.compile(catalogue.pattern) if catalogue.pattern else None
    except re.error as error:
        raise ConfigError(f"recordings.pattern {catalogue.pattern!r} is no regular expression: {error}") from error
    return [_name_entry(path, expression) for path in paths]


def _name_entry(path: Path, expression: re.Pattern[str] | None) -> Entry:
    entry = Entry(trial_name(path), path)
    if expression is None:
        return entry
    match = expression.search(path.name)
    if match is None:
        problem = f"its name does not fit recordings.pattern {expression.pattern!r}; narrow recordings.files"
        return replace(entry, problem=problem)
    found = {key: condition(value) for key, value in match.groupdict().items() if value is not None}
    return replace(entry, conditions=found)


def _unique(entries: Sequence[Entry], folder: Path) -> list[Entry]:
    """Trials of one name in several folders carry the folder in their names; an index that repeats one is refused."""
    times = Counter(entry.name for entry in entries)
    named = [
        entry if times[entry.name] == 1 else replace(entry, name=f"{entry.path.parent.name}/{entry.path.name}")
        for entry in entries
    ]
    twice = [name for name, count in Counter(entry.name for entry in named).items() if count > 1]
    if twice:
        raise ConfigError(f"trial {twice[0]!r} is listed {times.get(twice[0], 2)} times under {folder}; list it once")
    return named


def _trials(entry: Entry, catalogue: Catalogue) -> list[Entry]:
    """The trials of one file: itself, or one a row of its cell array, ``file_1``, ..., with the condition ``trial``."""
    if catalogue.layout.cells is None or entry.problem:
        return [entry]
    try:
        count = count_trials(entry.path, catalogue.layout)
    except RecordingError as error:
        return [replace(entry, problem=str(error))]
    return [
        replace(entry, name=f"{entry.name}_{at + 1}", trial=at, conditions={**entry.conditions, "trial": at + 1.0})
        for at in range(count)
    ]


def _with_patterns(entry: Entry, catalogue: Catalogue) -> Entry:
    """Conditions and window of every pattern that fits."""
    if not catalogue.conditions and not catalogue.windows:
        return entry
    conditions = dict(entry.conditions)
    window = Window()
    for pattern, more in catalogue.conditions.items():
        if fits(entry, pattern):
            conditions.update(more)
    for pattern, part in catalogue.windows.items():
        if fits(entry, pattern):
            window = part
    return replace(entry, conditions=conditions, window=window)
