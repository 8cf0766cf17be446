"""What a user holds in memory as a table with columns of numbers: arrays, series, frames whose index is the time.

Belongs here: shapes and kinds of numbers. Does not belong here: which column means what (columns.py), files
(recording/).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from undertow.errors import RecordingError
from undertow.recording.arrays import instants, real_numbers
from undertow.recording.propose import speaks_of_time
from undertow.recording.stamps import STAMPED, seconds_of_clock

STATES = ("x", "v", "a")
"""Names of the columns of an array X of up to three columns: displacement, and velocity and acceleration where
they were measured."""


def frame_of(given: pd.DataFrame | pd.Series) -> pd.DataFrame:
    """A frame or series with dates and durations as seconds, and with its index as a column where that is the time: an
    index of dates or durations, of numbers whose name says so, or without a name of numbers with decimals.

    >>> frame_of(pd.Series([1.0, 0.9], index=[0.0, 0.01], name="x [mm]")).columns.to_list()
    ['time', 'x [mm]']
    """
    table = given.to_frame(STATES[0] if given.name is None else given.name) if isinstance(given, pd.Series) else given
    index = table.index
    stamps = seconds_of_clock(index)
    kept = {column: clock for column in table if (clock := seconds_of_clock(table[column])) is not None}
    name = "time" if index.name is None else index.name
    timed = index.dtype.kind == "f" if index.name is None else index.dtype.kind in "fiu" and speaks_of_time(name)
    timed = (timed or stamps is not None) and not any(speaks_of_time(column) for column in table.columns)
    if not (kept or timed):
        return table
    found = table.reset_index(drop=True)
    for column, seconds in kept.items():
        found[column] = seconds
    if timed:
        found.insert(0, name, index.to_numpy(dtype=np.float64) if stamps is None else stamps)
    told = (*kept, *((name,) if timed and stamps is not None else ()))
    found.attrs = {**table.attrs, STAMPED: told, "units": {**table.attrs.get("units", {}), **dict.fromkeys(told, "s")}}
    return found


def by_name(given: Mapping[Any, Any]) -> tuple[list[Any], tuple[str, ...] | None]:
    """Tables by name as a list with their names; columns by name, one of which is the time, as one table, without.

    Raises RecordingError where columns differ in length.
    """
    columns = any(speaks_of_time(name) and not isinstance(one, pd.DataFrame | tuple) for name, one in given.items())
    if not columns and all(isinstance(one, pd.DataFrame | pd.Series | tuple) for one in given.values()):
        return list(given.values()), tuple(map(str, given))
    try:
        return [pd.DataFrame({name: _unmasked(one, name) for name, one in given.items()})], None
    except ValueError as error:
        raise RecordingError(f"the columns {', '.join(map(repr, given))} make no table: {error}") from error


def _unmasked(one: Any, name: Any) -> Any:
    """A column as an array; what a mask hides is NaN."""
    return real_numbers(one, str(name)) if isinstance(one, np.ma.MaskedArray) else np.asarray(one)


def table_of(X: ArrayLike, t: ArrayLike) -> tuple[pd.DataFrame, float | None]:
    """An array as a table with the columns x, v, a (numbers from 0 where there are more) and t, or its rate."""
    values = real_numbers(X, "X")
    values = values[:, None] if values.ndim == 1 else values
    if values.ndim != 2 or values.size == 0:
        raise RecordingError(f"X has the shape {np.shape(X)}; give (n,) or (n, k), one row an instant")
    few = values.shape[1] <= len(STATES)
    table = pd.DataFrame(values, columns=STATES[: values.shape[1]] if few else range(values.shape[1]))
    times = instants(t)
    if times.ndim == 0:
        if not times > 0.0:
            raise RecordingError(f"t is {float(times):g} s; a time step must be positive, or give (n,) instants")
        return table, 1.0 / float(times)
    if times.shape != (values.shape[0],):
        raise RecordingError(f"X has {values.shape[0]} rows but t has the shape {times.shape}; give one instant a row")
    table.insert(0, "t", times)
    return table, None
