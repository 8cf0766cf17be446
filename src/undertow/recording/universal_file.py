"""Universal files, data set 58 (.uff, .unv), as tables, through pyuff.

Belongs here: time responses. Does not belong here: frequency responses, which are no recordings of a decay.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.foreign import library, parsing
from undertow.recording.layout import Column, FileFormat, pick
from undertow.recording.vectors import alike, table

TIME = "time"
"""Name of the column that the abscissa becomes, in s."""

TIME_RESPONSE, REAL = 1, (2, 4)
"""Function type and ordinate types of data set 58 that are read (SDRC universal file description, set 58)."""

_DIRECTIONS = ("", "+X", "+Y", "+Z", "+RX", "+RY", "+RZ")


def read_universal(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The asked time responses (all of one length where None) as float64, with the column ``time``.

    A response is named by its first identification line where those differ, else by node and direction (``12+X``),
    else by its number; its number from 0 is always understood.

    Raises RecordingError where pyuff is not installed, the file is damaged or too large, holds no time response, or the
    asked ones have different times.
    """
    pyuff = library("pyuff", "pyuff", "labs", path)
    layout.limits.allow_bytes(path, path.stat().st_size, "its data sets")
    with parsing(path, "universal file", "export it again as data set 58"), contextlib.redirect_stdout(io.StringIO()):
        file = pyuff.UFF(str(path))
        kinds = np.atleast_1d(file.get_set_types())
        sets = [file.read_sets(at) for at in np.flatnonzero(kinds == 58).tolist()]
        sets = [one for one in sets if one["func_type"] == TIME_RESPONSE and one["ord_data_type"] in REAL]
        if not sets:
            raise RecordingError(
                f"{path} has {len(kinds)} data sets, none of them a time response (58, function type 1); export those"
            )
        return _table(path, sets, layout, columns)


def _table(
    path: Path, sets: Sequence[Mapping[str, Any]], layout: FileFormat, columns: Sequence[Column] | None
) -> pd.DataFrame:
    numbers = columns is not None and all(isinstance(one, int) or one == TIME for one in columns)
    labels: list[Column] = list(range(len(sets))) if numbers else _labels(sets)
    names: list[Column] = [TIME, *labels]
    layout.limits.allow_columns(path, len(names))
    asked = [names[at] for at in pick(path, names, columns)]
    found: dict[Column, Any] = {}
    times = {}
    for label, one in zip(labels, sets, strict=True):
        if label in asked:
            count = min(int(one["num_pts"]), np.size(one["data"]))
            found[label] = np.asarray(one["data"], dtype=np.float64)[:count]
            times[label] = np.asarray(one["x"], dtype=np.float64)[:count]
    found = alike(found) if columns is None else found
    if TIME in asked:
        first = next(iter(found), labels[0])
        time = times.get(first, np.asarray(sets[0]["x"], dtype=np.float64))
        other = next((label for label in found if not np.array_equal(times[label], time)), None)
        if other is not None and columns is not None:
            raise RecordingError(
                f"{path}: {other!r} has other times than {first!r}; give it its own: time: {{column: time}} in "
                "recordings.channels"
            )
        found = {TIME: time, **found}
    units = {
        label: str(one.get("ordinate_axis_units_lab") or "").strip() for label, one in zip(labels, sets, strict=True)
    }
    frame = table(path, found, {label: unit for label, unit in units.items() if unit.upper() != "NONE"})
    return frame if columns is None else frame[list(columns)]


def _labels(sets: Sequence[Mapping[str, Any]]) -> list[Column]:
    """Names of the responses: identification lines, else node and direction, else numbers; the first that differ."""
    lines = [str(one.get("id1", "")).strip() for one in sets]
    if len(set(lines)) == len(lines) and all(line and line.upper() != "NONE" for line in lines):
        return list(lines)
    nodes = [f"{one.get('rsp_node', '')}{_direction(one.get('rsp_dir', 0))}" for one in sets]
    if len(set(nodes)) == len(nodes) and all(nodes):
        return list(nodes)
    return list(range(len(sets)))


def _direction(code: Any) -> str:
    """A direction's code in letters: 1 is +X, -2 is -Y, 4 to 6 turn about the axes."""
    at = abs(int(code))
    if at >= len(_DIRECTIONS):
        return ""
    return _DIRECTIONS[at] if int(code) >= 0 else _DIRECTIONS[at].replace("+", "-")
