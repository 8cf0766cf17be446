"""MATLAB files as tables, through pymatreader (both the old format and 7.3).

Belongs here: variables, structures and cell arrays. Does not belong here: which column means what (catalogue.py).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from undertow.errors import MisnamedError, RecordingError
from undertow.recording.layout import CellLayout, Column, FileFormat, pick


def read_matlab(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """A matrix (columns 0, 1, ...), a structure of vectors, or the file's own vectors (columns by name), as float64.

    Raises RecordingError where the file is no MATLAB file, the variable is missing, or a column is no vector of
    numbers; objects and functions are refused.
    """
    content = _content(path)
    found = _variable(path, content, layout.variable) if layout.variable else content
    if isinstance(found, Mapping):
        vectors = {key: value for key, value in found.items() if _is_vector(value)}
        names: list[Column] = list(vectors)
        chosen = [names[at] for at in pick(path, names, columns)]
        return _table(path, {name: vectors[str(name)] for name in chosen})
    matrix = _numeric(path, layout.variable or "", found)
    matrix = matrix.reshape(-1, 1) if matrix.ndim == 1 else matrix
    numbers: list[Column] = list(range(matrix.shape[1]))
    return _table(path, {at: matrix[:, at] for at in pick(path, numbers, columns)})


def read_cells(path: Path, cells: CellLayout) -> tuple[pd.DataFrame, ...]:
    """One table a trial of a cell array, each with columns 0, 1, ... in the array's order.

    Raises RecordingError where the variable is no cell array or a trial's cells differ in length.
    """
    rows = _variable(path, _content(path), cells.variable)
    if not isinstance(rows, list) or not rows or not all(isinstance(row, list) for row in rows):
        raise RecordingError(f"{path}: {cells.variable!r} is a {type(rows).__name__}, no cell array of trials; "
                             "give recordings.variable in place of recordings.cells")  # fmt: skip
    if cells.trial == "column":
        rows = [list(row) for row in zip(*rows, strict=True)]
    return tuple(_table(path, dict(enumerate(row))) for row in rows)


def list_variables(path: Path) -> tuple[str, ...]:
    """What a MATLAB file holds, in words: names with shapes. RecordingError where it is none."""
    return tuple(f"{name} ({_kind(value)})" for name, value in _content(path).items()) or ("nothing",)


def _kind(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"structure with {', '.join(map(str, value))}"
    if isinstance(value, list):
        inner = f" x {len(value[0])}" if value and isinstance(value[0], list) else ""
        return f"cell array {len(value)}{inner}"
    return f"array {' x '.join(map(str, value.shape))}" if isinstance(value, np.ndarray) else type(value).__name__


def _content(path: Path) -> dict[str, Any]:
    import pymatreader
    from scipy.io.matlab import MatReadError

    try:
        content = pymatreader.read_mat(str(path))
    except (MatReadError, ValueError, OSError, TypeError, KeyError, IndexError, AttributeError, NotImplementedError,
            EOFError, MemoryError, OverflowError, struct.error, zlib.error) as error:  # fmt: skip
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise RecordingError(f"{path} is no readable MATLAB file ({reason}); save it again with -v7") from error
    return {key: value for key, value in content.items() if not key.startswith("__")}


def _variable(path: Path, content: Mapping[str, Any], name: str) -> Any:
    """A variable by name; dots lead into structures."""
    found: Any = content
    for part in name.split("."):
        if not isinstance(found, Mapping) or part not in found:
            have = ", ".join(found) if isinstance(found, Mapping) else type(found).__name__
            raise MisnamedError(f"{path} has no variable {name!r} (no {part!r} among {have}); correct its name")
        found = found[part]
    return found


def _is_vector(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.kind in "fiu" and np.squeeze(value).ndim == 1


def _numeric(path: Path, name: Column, value: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu" or np.squeeze(value).ndim not in (1, 2):
        kind = f"{value.dtype} array {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
        raise RecordingError(f"{path}: {name!r} holds a {kind}, not numbers; only arrays of numbers are read")
    return np.asarray(value, dtype=np.float64)


def _table(path: Path, vectors: Mapping[Any, Any]) -> pd.DataFrame:
    columns = {name: np.squeeze(_numeric(path, name, value)) for name, value in vectors.items()}
    lengths = {name: values.size for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name}: {size}" for name, size in lengths.items())
        raise RecordingError(f"{path}: columns differ in length ({listed}); map columns of one length")
    return pd.DataFrame(columns)
