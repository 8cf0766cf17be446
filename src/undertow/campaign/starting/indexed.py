"""A folder's own index: the table that names its recordings, what its columns mean.

Belongs here: which table that is, its column of files, the conditions that groups share. Does not belong here: an index
as a table (recording/index.py), conditions in file names (names.py).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from undertow.campaign.proposing import plain
from undertow.campaign.starting.names import DRY, MOST_LEVELS, SPRING, WATER, WET, Named, begins
from undertow.errors import ConfigError
from undertow.recording.conditions import number
from undertow.recording.index import Index, read_index
from undertow.recording.links import refused
from undertow.recording.readers import suffix_of
from undertow.recording.recording import Condition

TABLES = frozenset({".csv", ".txt", ".tsv", ".dat", ".xlsx"})
"""Suffixes of files that may be an index."""

LARGEST = 262_144
"""Bytes of an index at most: some thousand rows. A larger table is a recording."""

NAMED = 0.5
"""Share of a table's rows that name a recording from which on it is the folder's index."""

RIG = (
    "spring", "stiffness", "config", "setup", "rig", "feder", "aufbau", "ressort", "muelle", "resorte", "molla",
)  # fmt: skip
"""The same of columns that say which spring or set-up."""

@dataclass(frozen=True)
class Indexed:
    """The index ``name`` in the folder, its config's key for the file of a row (``key``, ``value``), the recordings it
    ``listed``, what its columns say of them, and of which it does not say what groups share (``lacking``, why)."""

    name: str
    key: str
    value: str
    listed: frozenset[str]
    named: Named
    lacking: Mapping[str, str] = field(default_factory=dict)

    @property
    def lines(self) -> list[str]:
        """Its keys in a config's recordings."""
        own = [] if (self.key, self.value) == ("index_column", "file") else [f"{self.key}: {plain(self.value)}"]
        return [f"index: {plain(self.name)}", *own]


def find_index(folder: Path, files: Sequence[str]) -> Indexed | None:
    """The table in a folder whose rows name most of ``files`` (paths from the folder); None where no table does."""
    found = [one for name in files if (one := _as_index(folder, name, files)) is not None]
    return max(found, key=lambda one: len(one.listed), default=None)


def _as_index(folder: Path, name: str, files: Sequence[str]) -> Indexed | None:
    path = folder / name
    small = "/" not in name and path.suffix.lower() in TABLES and path.stat().st_size <= LARGEST
    if not small or refused(path, folder):
        return None
    try:
        index = read_index(path)
        rows = list(index.rows())
    except ConfigError:
        return None
    others = {one for one in files if one != name}
    for column in index.columns:
        cells = [row.get(column, "") for row in rows]
        for ending in ("", *sorted({suffix_of(Path(one)) for one in others})):
            listed = {cell + ending for cell in cells if cell} & others
            if len(listed) > 1 and len(listed) >= NAMED * len(rows):
                key, value = ("file", f"{{{column}}}{ending}") if ending else ("index_column", column)
                if not ending or re.fullmatch(r"\w+", column):
                    pairs = ((cell + ending, row) for row, cell in zip(rows, cells, strict=True))
                    used = {file: row for file, row in pairs if file in others}
                    named = _meaning(index, column, list(used.values()))
                    return Indexed(name, key, value, frozenset(listed), named, _lacking(name, named, used))
    return None


def _lacking(index: str, named: Named, rows: Mapping[str, Mapping[str, str]]) -> dict[str, str]:
    """Recordings whose row leaves empty what groups share, each with the cell to fill in."""
    return {
        file: f"{index} has no {name} for it; fill that cell in, and take the file out of recordings.exclude"
        for file, row in rows.items()
        for name in named.group_by
        if not row.get(name, "").strip()
    }


def _meaning(index: Index, column: str, rows: Sequence[Mapping[str, str]]) -> Named:
    """What the other columns say: which of them groups share, and which trials are dry; a column with more empty cells
    than others says nothing."""
    conditions = [name for name in index.columns if name and name != column]
    values = {
        name: [index.value(name, row[name]) for row in rows if row.get(name, "").strip()] for name in conditions
    }
    several = {name: known for name, known in values.items() if len(set(known)) > 1 and 2 * len(known) > len(rows)}
    shared = tuple(name for name, known in several.items() if _is_water(name, known) or _is_rig(name, known))
    dry = next((found for name in shared if (found := _dry(name, several[name])) is not None), None)
    few = [n for n, known in several.items() if n not in shared and len(set(known)) <= MOST_LEVELS * len(known)]
    beside = f"{', '.join(few)} differ{'s' * (len(few) == 1)} among trials; no group goes by it" if few else ""
    return Named(group_by=shared, dry=dry, wet=dry is not None, beside=beside)


def _is_water(name: str, values: Sequence[Condition]) -> bool:
    return begins(name, WATER) or _all_words(values, DRY | WET)


def _is_rig(name: str, values: Sequence[Condition]) -> bool:
    return begins(name, RIG) or _all_words(values, SPRING)


def _all_words(values: Sequence[Condition], words: frozenset[str]) -> bool:
    return all(isinstance(value, str) and value.lower() in words for value in values)


def _dry(name: str, values: Sequence[Condition]) -> tuple[str, Condition] | None:
    """The column and the value of trials without water: a word for it, or no depth."""
    for value in values:
        if isinstance(value, str) and value.lower() in DRY:
            return name, value
        if begins(name, WATER) and number(value) == 0.0:
            return name, value
    return None
