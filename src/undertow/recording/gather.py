"""The list of a campaign's trials, from an index or from file names.

Belongs here: names, paths, conditions, what patterns say of a trial. Does not belong here: the index as a table
(index.py), reading samples (catalogue.py).
"""

from __future__ import annotations

import glob
import os
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from types import MappingProxyType

from undertow.errors import ConfigError, RecordingError
from undertow.recording.catalogue import Catalogue, Entry, TimeWindow
from undertow.recording.conditions import condition, written
from undertow.recording.expressions import found_in
from undertow.recording.index import Index, read_index
from undertow.recording.links import refused
from undertow.recording.patterns import Patterns, patterns_of
from undertow.recording.readers import count_trials, trial_name
from undertow.recording.recording import Condition
from undertow.recording.run_files import is_of_a_run

NAMES_SHOWN = 8
"""File names in a message at most."""

NAME_SHOWN = 200
"""Characters of one in a message at most; a file system takes some 255 bytes."""

DEEP_AT_MOST = 2
"""``**`` in a glob: with each further one, a folder is looked at as often as it has folders above it."""

_FIELD = re.compile(r"\{(\w+)\}")
_Known = dict[tuple[tuple[str, Condition], ...], Mapping[str, Condition]]


def gather(catalogue: Catalogue) -> tuple[Entry, ...]:
    """Every trial of a campaign, in the index's or the names' order.

    A file that the index names and that is not there (or lies outside the index's folder) is an entry with a
    ``problem``: it must not stop the others.

    Raises ConfigError where the index or its column is missing, a pattern is wrong, or no trial is left.
    """
    return listing(catalogue)[0]


def listing(catalogue: Catalogue) -> tuple[tuple[Entry, ...], tuple[Entry, ...]]:
    """Every trial of a campaign, and those that ``exclude`` leaves out; raises as `gather`."""
    if (catalogue.index is None) == (catalogue.files is None):
        raise ConfigError(
            f"recordings has index {catalogue.index!r} and files {catalogue.files!r}; give exactly one of them"
        )
    entries = _from_index(catalogue) if catalogue.index is not None else _from_names(catalogue)
    left_out = Patterns(catalogue.exclude)
    entries, files = _parted(entries, left_out)
    entries = [trial for entry in _unique(entries, catalogue.folder) for trial in _trials(entry, catalogue)]
    _must_differ(entries)
    entries, trials = _parted(entries, left_out)  # one trial of a file with several
    if not entries:
        raise ConfigError(f"recordings.exclude {list(catalogue.exclude)} leaves no trial; take a pattern out of it")
    said = _PatternsSaid(catalogue)
    return tuple(said.of(entry) for entry in entries), tuple(said.of(entry) for entry in (*files, *trials))


def _parted(entries: Sequence[Entry], patterns: Patterns) -> tuple[list[Entry], list[Entry]]:
    """Entries that no pattern fits, and the others."""
    kept: list[Entry] = []
    fitting: list[Entry] = []
    for entry in entries:
        (fitting if patterns.fit(entry.name, str(entry.file)) else kept).append(entry)
    return kept, fitting


def _from_index(catalogue: Catalogue) -> list[Entry]:
    path = catalogue.folder / str(catalogue.index)
    index = read_index(path, catalogue.index_separator, catalogue.index_decimal)
    rows = index.rows()
    first = next(rows, None)
    if first is None:
        raise ConfigError(f"recordings.index {path} has no rows below its header; give it one row a trial")
    needed = _FIELD.findall(catalogue.file) if catalogue.file else [catalogue.index_column]
    for column in needed:
        if column not in first:
            keys = "index_column or file" if len(first) > 1 else "index_separator, index_column or file"
            raise ConfigError(
                f"recordings.index {path} has no column {column!r}; it has {', '.join(first)}: set recordings.{keys}"
            )
    known: _Known = {}
    return [_row_entry(row, catalogue, index, known) for row in chain((first,), rows)]


def _row_entry(row: Mapping[str, str], catalogue: Catalogue, index: Index, known: _Known) -> Entry:
    """The trial of one row; its conditions are those of an earlier trial where they are the same."""
    folder = index.path.parent
    name = row.get(catalogue.index_column, "") if catalogue.file is None else _filled(catalogue.file, row)
    conditions = {
        key: index.value(key, value)
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
    if link := refused(entry.file, folder):
        return replace(entry, problem=f"the index names {name!r}, {link}")
    if not os.path.isfile(entry.path):  # also where no file system takes the name
        where = name if len(name) <= NAME_SHOWN else f"{name[:NAME_SHOWN]}..."
        there = f"{entry.path if where == name else 'such a file'} is not there"
        return replace(entry, problem=f"the index names {where!r}, but {there}; copy it or drop the row")
    return entry


def _filled(pattern: str, row: Mapping[str, str]) -> str:
    """A file name with the row's values in place of ``{column}``."""
    return _FIELD.sub(lambda match: row.get(match.group(1), ""), pattern)


def _escapes(name: str) -> bool:
    """Whether a name from an index leads out of the index's folder (absolute, a drive, or ``..``)."""
    plain = name.replace("\\", "/")
    return not plain or plain.startswith(("/", "~")) or ".." in plain.split("/") or bool(re.match(r"^[A-Za-z]:", plain))


def _from_names(catalogue: Catalogue) -> list[Entry]:
    given = (catalogue.files,) if isinstance(catalogue.files, str) else tuple(catalogue.files or ())
    found: dict[str, str] = {}
    for one in given:
        pattern = str(catalogue.folder / _plainer(one))
        fitting = [path for path in glob.glob(pattern, recursive=True) if os.path.isfile(path)]
        fitting = [path for path in fitting if not is_of_a_run(path)]  # a run in the recordings' own folder
        if not fitting:
            raise ConfigError(f"recordings.files {one!r} fits no file ({pattern}); correct the glob")
        home = _folder_of(pattern)
        found.update((path, refused(path, home)) for path in fitting)
    paths = [Path(path) for path in sorted(found)]
    if not catalogue.pattern:
        return [_name_entry(path, found[str(path)]) for path in paths]
    named = found_in(catalogue.pattern, tuple(path.name for path in paths)).by_name
    if all(groups is None for groups in named):
        shown = ", ".join(path.name for path in paths[:NAMES_SHOWN])
        raise ConfigError(
            f"recordings.pattern {catalogue.pattern!r} fits none of {len(paths)} file names ({shown}); correct it"
        )
    pairs = zip(paths, named, strict=True)
    return [_patterned(_name_entry(path, found[str(path)]), groups, catalogue.pattern) for path, groups in pairs]


def _plainer(files: str) -> str:
    """A glob that looks at no folder again and again: no ``..`` below a wildcard, no ``**`` after ``**``.

    Raises ConfigError where one goes up from a wildcard or has more than `DEEP_AT_MOST` ``**``.
    """
    parts = [part for part in files.split("/") if part not in ("", ".")]
    kept = [part for at, part in enumerate(parts) if part != "**" or parts[at - 1 : at] != ["**"]]
    wild = next((at for at, part in enumerate(kept) if glob.has_magic(part)), len(kept))
    if ".." in kept[wild:]:
        raise ConfigError(f"recordings.files {files!r} goes up (..) from a wildcard; give each folder its own glob")
    if kept.count("**") > DEEP_AT_MOST:
        raise ConfigError(f"recordings.files {files!r} has {kept.count('**')} times **; {DEEP_AT_MOST} are allowed")
    return ("/" if files.startswith("/") else "") + "/".join(kept)


def _folder_of(pattern: str) -> Path:
    """The folder that a glob names before its first wildcard."""
    parts = Path(pattern).parts[:-1]
    fixed = next((at for at, part in enumerate(parts) if glob.has_magic(part)), len(parts))
    return Path(*parts[:fixed])


def _name_entry(path: Path, link: str) -> Entry:
    return Entry(trial_name(path), path, problem=f"{path.name} is {link}" if link else "")


def _patterned(entry: Entry, groups: Mapping[str, str | None] | None, pattern: str) -> Entry:
    """The entry with the named groups of ``pattern`` as its conditions; not fitting is its problem."""
    if entry.problem:
        return entry
    if groups is None:
        problem = f"its name does not fit recordings.pattern {pattern!r}; narrow recordings.files"
        return replace(entry, problem=problem)
    return replace(entry, conditions={key: condition(value) for key, value in groups.items() if value is not None})


def _unique(entries: Sequence[Entry], folder: Path) -> list[Entry]:
    """Trials of one name in several folders carry the folder in their names; an index that repeats one is refused."""
    times = Counter(entry.name for entry in entries)
    named = [
        entry if times[entry.name] == 1 else replace(entry, name=f"{entry.path.parent.name}/{entry.path.name}")
        for entry in entries
    ]
    twice = [name for name, count in Counter(entry.name for entry in named).items() if count > 1]
    if twice:
        raise ConfigError(
            f"trial {twice[0]!r} is listed {times.get(twice[0], 2)} times under {folder}; list it once (of several "
            "releases in one recording, recordings.releases has the part of each)"
        )
    return named


def _must_differ(entries: Sequence[Entry]) -> None:
    """ConfigError where a trial within a file has the name of another file's."""
    by_name: dict[str, Entry] = {}
    for entry in entries:
        other = by_name.setdefault(entry.name, entry)
        if other is not entry:
            files = " and ".join(one.path.name for one in (other, entry))
            raise ConfigError(f"{files} both have a trial called {entry.name!r}; rename one of the files")


def _trials(entry: Entry, catalogue: Catalogue) -> list[Entry]:
    """The trials of one file: itself, or one a row of its cell array, ``file_1``, ..., with the condition ``trial``;
    each again one a release, where the catalogue says its parts."""
    return [part for trial in _rows(entry, catalogue) for part in _said_parts(trial, catalogue)]


def by_release(entry: Entry, parts: Sequence[TimeWindow]) -> list[Entry]:
    """A trial for each part of a recording: ``name_1``, ``name_2``, ..., with the condition ``release``."""
    return [
        replace(entry, name=f"{entry.name}_{at}", part=part, conditions={**entry.conditions, "release": float(at)})
        for at, part in enumerate(parts, start=1)
    ]


def _said_parts(entry: Entry, catalogue: Catalogue) -> list[Entry]:
    fitting = patterns_of(tuple(catalogue.releases)).fitting(entry.name, str(entry.file))
    return by_release(entry, catalogue.releases[fitting[-1]]) if fitting else [entry]


def _rows(entry: Entry, catalogue: Catalogue) -> list[Entry]:
    layout = catalogue.for_entry(entry).layout
    if layout.cells is None or entry.problem:
        return [entry]
    try:
        count = count_trials(entry.path, layout)
    except RecordingError as error:
        return [replace(entry, problem=str(error))]
    return [
        replace(entry, name=f"{entry.name}_{at + 1}", trial=at, conditions={**entry.conditions, "trial": at + 1.0})
        for at in range(count)
    ]


class _PatternsSaid:
    """What a catalogue's patterns say of a trial: further conditions, its window, the doubts accepted of it, and the
    files beside its own."""

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self._conditions, self._windows, self._accept = (
            Patterns(said) for said in (catalogue.conditions, catalogue.windows, catalogue.accept)
        )

    def of(self, entry: Entry) -> Entry:
        """The entry with everything that fits it; of windows and of each condition the last that fits wins."""
        if not (self._conditions or self._windows or self._accept):
            return _with_files_beside(entry, self._catalogue)
        said, trial = self._catalogue, (entry.name, str(entry.file))
        conditions = dict(entry.conditions)
        for pattern in self._conditions.fitting(*trial):
            conditions.update(said.conditions[pattern])
        window = next((said.windows[pattern] for pattern in reversed(self._windows.fitting(*trial))), TimeWindow())
        accepted = dict.fromkeys(kind for pattern in self._accept.fitting(*trial) for kind in said.accept[pattern])
        entry = replace(entry, conditions=conditions, window=window, accepted=tuple(accepted))
        return _with_files_beside(entry, said)


def _as_spelt(path: Path, pattern: str, known: Mapping[str, Condition]) -> str:
    """The file, or where there is none the only one beside it whose name writes the same numbers otherwise: 50 may be
    050 in it."""
    base = pattern.replace("\\", "/").rpartition("/")[2]
    if not _FIELD.search(base) or os.path.isfile(path) or not os.path.isdir(path.parent):
        return str(path)
    parts = _FIELD.split(base)  # text, field, text, ...
    spelt = re.compile("".join(_spelling(known[one]) if at % 2 else re.escape(one) for at, one in enumerate(parts)))
    found = [name for name in os.listdir(path.parent) if spelt.fullmatch(name)]
    return str(path.parent / found[0]) if len(found) == 1 else str(path)


def _spelling(value: Condition) -> str:
    """A pattern of the texts that write a condition: a number with zeros around it, and either decimal mark."""
    whole, _, part = written(value).partition(".")
    if isinstance(value, str):
        return re.escape(value)
    return f"0*{re.escape(whole)}{f'[.,]{re.escape(part)}0*' if part else '(?:[.,]0+)?'}"


def _with_files_beside(entry: Entry, catalogue: Catalogue) -> Entry:
    """The entry with the paths of the files beside its own that its channels lie in.

    A name that needs a condition the trial does not have, or leads out of its folder, is the entry's problem.
    """
    names = catalogue.for_entry(entry).beside
    if entry.problem or not names:
        return entry
    known: dict[str, Condition] = {"stem": trial_name(entry.path), **entry.conditions}
    paths = {}
    for name in names:
        lacking = next((key for key in _FIELD.findall(name) if key not in known), None)
        if lacking is not None:
            have = ", ".join(known)
            return replace(
                entry, problem=f"its channels' file {name!r} needs {lacking!r}, which it lacks; it has {have}"
            )
        filled = _filled(name, {key: written(value) for key, value in known.items()})
        if _escapes(filled):
            problem = f"its channels' file {filled!r} must lie in the trial's folder; correct recordings.channels"
            return replace(entry, problem=problem)
        paths[name] = _as_spelt(entry.path.parent / filled, name, known)
        if link := refused(paths[name], entry.path.parent):
            return replace(entry, problem=f"its channels' file {filled!r} is {link}")
    return replace(entry, beside=paths)
