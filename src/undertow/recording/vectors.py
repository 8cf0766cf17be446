"""Named arrays from a file as one table: what is a column, which side of a matrix is time, equal lengths.

Belongs here: what MATLAB, HDF5, TDMS, UFF and MDF files have in common once they are read. Does not belong here: bytes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from undertow.errors import MisnamedError, RecordingError
from undertow.recording.layout import Column
from undertow.recording.limits import Limits

NAMES_SHOWN = 12
"""Names of tables or columns in a message at most."""


def is_vector(value: Any) -> bool:
    """Whether a value is an array of numbers with one side longer than 1."""
    return isinstance(value, np.ndarray) and value.dtype.kind in "fiu" and np.squeeze(value).ndim == 1


def numeric(path: Path, name: Column, value: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """An array of one or two sides as float64; RecordingError where it holds anything but numbers."""
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu" or np.squeeze(value).ndim not in (1, 2):
        kind = f"{value.dtype} array {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
        raise RecordingError(f"{path}: {name!r} holds a {kind}, not numbers; only arrays of numbers are read")
    return np.asarray(value, dtype=np.float64)


def matrix_columns(path: Path, name: Column, value: Any, limits: Limits) -> dict[Column, Any]:
    """Columns 0, 1, ... of a matrix or vector. Its longer side is time: a recording has more samples than channels."""
    matrix = np.atleast_1d(np.squeeze(numeric(path, name, value)))
    matrix = matrix.reshape(-1, 1) if matrix.ndim == 1 else matrix
    matrix = matrix.T if matrix.shape[1] > matrix.shape[0] else matrix
    limits.allow_columns(path, matrix.shape[1])
    return {at: matrix[:, at] for at in range(matrix.shape[1])}


def alike(vectors: Mapping[Column, Any]) -> dict[Column, Any]:
    """Those of several vectors that make one table: of the length that most of them have, the longest of such."""
    sizes = Counter(int(np.size(value)) for value in vectors.values())
    if not sizes:
        return {}
    most = max(sizes, key=lambda size: (sizes[size] > 1, sizes[size] * size, size))
    return {name: value for name, value in vectors.items() if np.size(value) == most}


def table(path: Path, vectors: Mapping[Column, Any], units: Mapping[Column, str] | None = None) -> pd.DataFrame:
    """Vectors of one length as a table of float64; RecordingError where lengths differ or one holds no numbers.

    ``units`` (column -> unit as the file says it) stand in ``frame.attrs["units"]``.
    """
    columns = {name: np.atleast_1d(np.squeeze(numeric(path, name, value))) for name, value in vectors.items()}
    lengths = {name: values.size for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name}: {size}" for name, size in lengths.items())
        raise RecordingError(
            f"{path}: columns differ in length ({listed}); map columns of one length, or give the channel of the other "
            "length a time of its own (recordings.channels)"
        )
    frame = pd.DataFrame(columns)
    said = {name: unit for name, unit in (units or {}).items() if unit and name in columns}
    if said:
        frame.attrs["units"] = said
    return frame


def chosen_table(path: Path, have: Sequence[str], wanted: str | None, kind: str) -> str:
    """The table that ``recordings.variable`` names, or the only one.

    Raises MisnamedError where there is none of that name, or there are several and none is named.
    """
    listed = ", ".join(repr(name) for name in have[:NAMES_SHOWN]) + (", ..." if len(have) > NAMES_SHOWN else "")
    if wanted is not None:
        if wanted not in have:
            raise MisnamedError(f"{path} has no {kind} {wanted!r}; it has {listed}: correct recordings.variable")
        return wanted
    if len(have) != 1:
        said = f"holds {len(have)} {kind}s: {listed}; name one" if have else f"holds no {kind}; is it a recording? name"
        raise MisnamedError(f"{path} {said} in recordings.variable")
    return have[0]
