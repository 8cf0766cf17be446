"""What a user holds in memory as a table with columns of numbers: arrays, series, frames whose index is the time.

Belongs here: shapes and kinds of numbers. Does not belong here: which column means what (columns.py), files
(recording/).
"""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from undertow.conditioning.motion import Motion
from undertow.errors import RecordingError
from undertow.recording.arrays import instants, real_numbers
from undertow.recording.propose import SLOW_S, speaks_of_time
from undertow.recording.recording import Recording
from undertow.recording.stamps import STAMPED, seconds_of_clock
from undertow.recording.stated_rate import SAME_RATE, other_rate
from undertow.recording.units import factor_to_si

STATES = ("x", "v", "a")
"""Names of the columns of an array X of up to three columns: displacement, and velocity and acceleration where
they were measured."""

TIME = ("t", "time")
"""Names under which the unit of an array's time is said."""


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


def is_timed(X: Any, t: Any) -> bool:
    """Whether a pair is an array X with its times or step t, and not two trials: of two series the second only rises.

    >>> is_timed(pd.Series([1.0, 0.9]), pd.Series([0.0, 0.1])), is_timed(pd.Series([0.0, 0.1]), pd.Series([1.0, 0.9]))
    (True, False)
    """
    if not isinstance(X, pd.DataFrame | pd.Series):
        return not isinstance(X, str | PathLike | Recording | Motion)
    if isinstance(t, pd.Series):
        return bool(t.is_monotonic_increasing and t.is_unique)
    return not isinstance(t, pd.DataFrame | str | PathLike | Recording | Motion)


def timed(X: Any, t: Any) -> list[tuple[Any, Any]]:
    """One (X, t) a trial, of an array with its times or step, or of lists of them.

    Raises RecordingError where X has a time of its own, or the lists differ in length.
    """
    several = isinstance(X, list | tuple) and len(X) > 0 and np.ndim(X[0]) > 0
    arrays = list(X) if several else [X]
    for one in arrays:
        if isinstance(one, str | PathLike | Recording | Motion):
            raise RecordingError(
                f"t is given beside a {type(one).__name__}, which has a time of its own; leave t out, or give the "
                "samples as an array"
            )
    times = list(t) if several and isinstance(t, list | tuple) else [t] * len(arrays)
    if len(times) != len(arrays):
        raise RecordingError(f"X holds {len(arrays)} trials but t {len(times)}; give one time axis a trial")
    return list(zip(arrays, times, strict=True))


def are_arrays(source: Any) -> bool:
    """Whether trials are a list of arrays, which say no times of their own. A single array may be a part of a record.

    >>> are_arrays([np.zeros(3), np.zeros(3)]), are_arrays(np.zeros(3)), are_arrays(["r1.csv"])
    (True, False, False)
    """
    if not isinstance(source, list) or not source:
        return False
    owned = str | PathLike | pd.DataFrame | pd.Series | Recording | Motion
    return all(not isinstance(one, owned) and np.ndim(one) > 0 for one in source)


def one_clock(t: Any) -> Any:
    """The step or the times that several trials share; RecordingError where each has its own."""
    if not isinstance(t, list | tuple) or not t or np.ndim(t[0]) == 0:
        return t
    if all(np.array_equal(one, t[0]) for one in t):
        return t[0]
    raise RecordingError(
        f"fit was given a t for each of its {len(t)} trials; give those of these, as in score(X, t=...), or tables "
        "that hold their own time"
    )


def table_of(
    X: Any, t: ArrayLike, units: Mapping[str, str] | None = None
) -> tuple[pd.DataFrame, float | None, Mapping[str, str] | None]:
    """An array as a table with the columns x, v, a (numbers from 0 where there are more; a frame's keep their names)
    and t, or its rate in Hz where t is a step; and the ``units`` of what is left.

    Raises RecordingError where the shapes do not fit, a frame has a time of its own, or a step is not positive, or so
    long that it needs a unit.
    """
    values = real_numbers(X, "X")
    values = values[:, None] if values.ndim == 1 else values
    if values.ndim != 2 or values.size == 0:
        raise RecordingError(f"X has the shape {np.shape(X)}; give (n,) or (n, k), one row an instant")
    few = values.shape[1] <= len(STATES)
    names = STATES[: values.shape[1]] if few else range(values.shape[1])
    table = pd.DataFrame(values, columns=X.columns if isinstance(X, pd.DataFrame) else names)
    if own := [column for column in table if speaks_of_time(column)]:
        raise RecordingError(f"t is given beside a table with the time in column {own[0]!r}; leave one of them out")
    times = instants(t)
    if times.ndim == 0:
        return table, 1.0 / _step_s(float(times), units), _without_time(units)
    if times.shape != (values.shape[0],):
        raise RecordingError(f"X has {values.shape[0]} rows but t has the shape {times.shape}; give one instant a row")
    table.insert(0, "t", times)
    return table, None, units


def must_be_the_rate(
    rate_hz: float, table: pd.DataFrame, by_step: float | None, units: Mapping[str, str] | None = None
) -> None:
    """RecordingError where a stated rate is not that of the times beside it, a column of the table or a step (its rate
    in Hz, ``by_step``)."""
    said = ""
    if by_step is None:
        clock = table[["t"]]
        unit = next((unit for name, unit in (units or {}).items() if name in TIME), "")
        clock.attrs = {"units": {"t": unit}} if unit else {}
        said = other_rate(clock, rate_hz).partition("; ")[0].replace("column 't' is a time", "t has times")
    elif not abs(by_step - rate_hz) <= SAME_RATE * rate_hz:
        said = f"t is a step of {1.0 / by_step:.4g} s, which is {by_step:.5g} Hz, but rate_hz is {rate_hz:.5g} Hz"
    if said:
        raise RecordingError(f"{said}; leave one of the two out")


def _step_s(step: float, units: Mapping[str, str] | None) -> float:
    """A time step in s; one that is long enough to be in another unit needs one, as an array of times does."""
    said = units if isinstance(units, Mapping) else {}
    unit = next((said[name] for name in TIME if name in said), "")
    if not step > 0.0:
        raise RecordingError(f"t is {step:g} s; a time step must be positive, or give (n,) instants")
    if not unit and step >= SLOW_S:
        raise RecordingError(
            f"t is {step:g}, a time step without a unit, and in seconds there would be a sample every {step:g} s; say "
            f'it, as in units={{"t": "ms"}} or "s"; where {step:g} Hz are meant t is {1.0 / step:.4g}'
        )
    return step * factor_to_si(unit or "s", "time", "translation")[0]


def _without_time(units: Mapping[str, str] | None) -> Mapping[str, str] | None:
    """The units of channels alone."""
    if not isinstance(units, Mapping):
        return units
    return {name: unit for name, unit in units.items() if name not in TIME}
