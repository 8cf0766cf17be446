"""How a file is laid out, in plain words that every reader understands.

Belongs here: `FileFormat`, `CellLayout` and the search for a column. Does not belong here: reading.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from undertow.errors import MisnamedError, RecordingError
from undertow.recording.limits import LIMITS, Limits

Column = str | int
"""A column's name, or its number from 0 where there is no header."""


DECIMALS = (".", ",")
"""Decimal marks of texts."""


@dataclass(frozen=True)
class CellLayout:
    """Several trials in one file: a cell array ``variable`` with a trial a row (or a column).

    ``positions`` says which cell of a trial holds which channel (``time`` among them), counted from 0.
    """

    variable: str
    trial: Literal["row", "column"] = "row"
    positions: Mapping[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", MappingProxyType(dict(self.positions)))


@dataclass(frozen=True)
class FileFormat:
    """Layout of a recording's file. ``separator`` None is found from the data; ``header`` False means that columns are
    numbers; ``skip_rows`` lines stand above the header; ``unit_row`` says that units stand below it. ``variable`` is
    the table in a file that may hold several: an array or structure of a MATLAB file (dots lead into structures), an
    HDF5 group or dataset, a sheet, a TDMS group, an MDF channel group. ``cells`` are several trials in one file.
    ``encoding`` None is found from the bytes; ``limits`` say how much a recording may take.
    """

    separator: str | None = None
    decimal: str = "."
    header: bool = True
    skip_rows: int = 0
    unit_row: bool = False
    variable: str | None = None
    cells: CellLayout | None = None
    encoding: str | None = None
    limits: Limits = LIMITS


def pick(path: Path, names: Sequence[Column], wanted: Sequence[Column] | None) -> list[int]:
    """Places of the wanted columns among ``names``; all of them where None.

    Raises RecordingError where one is missing (with what there is, and the nearest) or its name stands there twice.
    """
    return list(range(len(names))) if wanted is None else [_place(path, names, column) for column in wanted]


def _place(path: Path, names: Sequence[Column], column: Column) -> int:
    found = [at for at, name in enumerate(names) if name == column]
    if len(found) > 1:
        raise RecordingError(
            f"{path} has {len(found)} columns named {column!r}; rename all but one, or set header: none, skip one row "
            "more, and give its number"
        )
    if found:
        return found[0]
    have = ", ".join(str(name)[:40] for name in names[:30])
    near = difflib.get_close_matches(str(column), [str(name) for name in names], n=1)
    hint = f"; did you mean {near[0]!r}?" if near else "; correct recordings.channels"
    raise MisnamedError(f"{path} has no column {column!r}; it has {have}{hint}")
