"""MATLAB files as tables, through pymatreader (both the old format and 7.3).

Only the variables that are asked for are read: what else a file holds (texts, functions, objects) does not matter.

Belongs here: variables, structures and cell arrays. Does not belong here: sizes (mat_sizes.py), which column means what
(catalogue.py).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from undertow.errors import MisnamedError, RecordingError
from undertow.recording.foreign import parsing
from undertow.recording.layout import CellLayout, Column, FileFormat, pick
from undertow.recording.limits import LIMITS, Limits
from undertow.recording.mat_sizes import allow
from undertow.recording.vectors import alike, is_vector, matrix_columns, numeric, table

_ADVICE = "save it again with -v7"


def read_matlab(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """A matrix (columns 0, 1, ...; its longer side is time), a structure of vectors, or the file's own vectors (columns
    by name), as float64. All columns are those of one length, where the vectors differ in it.

    Raises RecordingError where the file is no MATLAB file or too large, the variable is missing, or a column is no
    vector of numbers; objects and functions are refused.
    """
    if layout.variable is None:
        asked = None if columns is None else [str(column) for column in columns]
        found: Any = _content(path, layout.limits, asked)
        if asked is not None and any(name not in found for name in asked):
            found = dict.fromkeys(_names(path), np.zeros(2)) | found
    else:
        content = _content(path, layout.limits, [layout.variable.partition(".")[0]])
        found = _variable(path, content or dict.fromkeys(_names(path)), layout.variable)
    if isinstance(found, Mapping):
        vectors: dict[Column, Any] = {str(key): value for key, value in found.items() if is_vector(value)}
        if columns is None:
            vectors = alike(vectors)
        names: list[Column] = list(vectors)
        layout.limits.allow_columns(path, len(names) if columns is None else len(columns))
        chosen = [names[at] for at in pick(path, names, columns)]
        return table(path, {name: vectors[name] for name in chosen})
    matrix = matrix_columns(path, layout.variable or "", found, layout.limits)
    return table(path, {at: matrix[at] for at in pick(path, list(matrix), columns)})


def read_cells(path: Path, cells: CellLayout, limits: Limits = LIMITS) -> tuple[pd.DataFrame, ...]:
    """One table a trial of a cell array, each with columns 0, 1, ... in the array's order.

    Raises RecordingError where the variable is no cell array or a trial's cells differ in length.
    """
    content = _content(path, limits, [cells.variable.partition(".")[0]])
    rows = _variable(path, content or dict.fromkeys(_names(path)), cells.variable)
    if not isinstance(rows, list) or not rows or not all(isinstance(row, list) for row in rows):
        raise RecordingError(f"{path}: {cells.variable!r} is a {type(rows).__name__}, no cell array of trials; "
                             "give recordings.variable in place of recordings.cells")  # fmt: skip
    if cells.trial == "column":
        rows = [list(row) for row in zip(*rows, strict=True)]
    return tuple(_cells_table(path, row) for row in rows)


def _cells_table(path: Path, row: Sequence[Any]) -> pd.DataFrame:
    """The cells of a trial that hold numbers as columns; texts and single numbers beside them do not count."""
    vectors: dict[Column, Any] = {at: value for at, value in enumerate(row) if is_vector(value)}
    if not vectors:
        numeric(path, 0, row[0] if row else None)
    return table(path, vectors)


def list_variables(path: Path) -> tuple[str, ...]:
    """What a MATLAB file holds, in words: names with shapes. RecordingError where it is none."""
    return tuple(f"{name} ({_kind(value)})" for name, value in _content(path, LIMITS, None).items()) or ("nothing",)


def matlab_tables(path: Path) -> tuple[str, ...]:
    """Names of everything in a file that can be read as a table; "" is the file's own vectors."""
    content = _content(path, LIMITS, None)
    own = sum(is_vector(value) for value in content.values()) > 1
    return (*([""] if own else []), *_inner(content, ""))


def _inner(content: Mapping[Any, Any], above: str) -> list[str]:
    found = []
    for name, value in content.items():
        if isinstance(value, np.ndarray) and value.dtype.kind in "fiu" and value.ndim == 2 and min(value.shape) > 1:
            found.append(f"{above}{name}")
        elif isinstance(value, Mapping):
            if any(is_vector(one) for one in value.values()):
                found.append(f"{above}{name}")
            found += _inner(value, f"{above}{name}.")
    return found


def _kind(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"structure with {', '.join(map(str, value))}"
    if isinstance(value, list):
        inner = f" x {len(value[0])}" if value and isinstance(value[0], list) else ""
        return f"cell array {len(value)}{inner}"
    return f"array {' x '.join(map(str, value.shape))}" if isinstance(value, np.ndarray) else type(value).__name__


def _content(path: Path, limits: Limits, wanted: Collection[str] | None) -> dict[str, Any]:
    """Top-level variables by name, all or the wanted ones that there are."""
    import pymatreader

    with parsing(path, "MATLAB file", _ADVICE):
        allow(path, limits, wanted)
        content = pymatreader.read_mat(str(path), variable_names=None if wanted is None else list(wanted))
    return {key: content[key] for key in content if not str(key).startswith("__") and (wanted is None or key in wanted)}


def _names(path: Path) -> list[str]:
    """Names of the top-level variables, without reading them."""
    import pymatreader

    with parsing(path, "MATLAB file", _ADVICE):
        return [str(name) for name, *_ in pymatreader.whosmat(str(path)) if not str(name).startswith("__")]


def _variable(path: Path, content: Mapping[str, Any], name: str) -> Any:
    """A variable by name; dots lead into structures."""
    found: Any = content
    for part in name.split("."):
        if not isinstance(found, Mapping) or part not in found:
            have = ", ".join(map(str, found)) if isinstance(found, Mapping) else type(found).__name__
            raise MisnamedError(f"{path} has no variable {name!r} (no {part!r} among {have}); correct its name")
        found = found[part]
    return found
