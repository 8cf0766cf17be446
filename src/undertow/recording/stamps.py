"""Dates and times of day as seconds since the first row: of a text file's cells, of pandas' columns.

Belongs here: stamps. Does not belong here: clocks that are seconds already (clocks.py), Excel's cells (excel.py).
"""

from __future__ import annotations

import re

import numpy as np
import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.layout import Column
from undertow.recording.recording import Array
from undertow.recording.units import factor_to_si

STAMP = re.compile(
    r"\s{0,3}(?P<date>\d{1,4}([-./])\d{1,2}\2\d{1,4}|\d{8})?[ T]{0,3}"
    r"(?P<hour>\d{1,2}):(?P<minute>[0-5]\d):(?P<second>[0-5]\d(?:[.,]\d{1,9})?)"
    r"\s{0,3}(?P<half>[AaPp]\.?[Mm]\.?)?\s{0,3}(?P<zone>Z|UTC|[+-]\d{2}:?\d{2})?\s{0,3}"
)
"""A time of day with seconds, and a date before it where there is one, as loggers and spreadsheets write them. No part
is without a limit: a cell of a million spaces is looked at once."""

DAY_S = 86400.0

STAMPED = "stamps"
"""Entry of a table's attrs: the columns that held stamps or durations, and hold seconds now."""


def is_stamp(text: str) -> bool:
    """Whether a cell is a time of day, or a date with one.

    >>> is_stamp("2026-03-01T10:00:00.25Z"), is_stamp("01.03.2026 10:00:00,25"), is_stamp("10.5")
    (True, True, False)
    """
    return STAMP.fullmatch(text) is not None


def seconds_of_texts(cells: pd.Series) -> Array:
    """Cells of texts (n,) that are stamps as seconds since the first, (n,); empty ones are NaN.

    The order of day and month does not matter: a date that changes is the next day, and so is a time of day without a
    date that falls back by more than half a day.

    Raises ValueError, with the first wrong cell's place as its argument, where one is no stamp or of another time zone.

    >>> seconds_of_texts(pd.Series(["01/02/2026 11:59:59.75 PM", "02/02/2026 12:00:00.25 AM"]))
    array([0. , 0.5])
    """
    found = cells.astype("string").str.extract(f"^{STAMP.pattern}$")
    empty = cells.isna().to_numpy()
    zone = found["zone"].fillna("").to_numpy()
    wrong = ~empty & (found["second"].isna().to_numpy() | (zone != zone[int(np.argmin(empty))]))
    if wrong.any():
        raise ValueError(int(wrong.argmax()))
    told = found[~empty]
    hour = told["hour"].astype(float).to_numpy()
    half = told["half"].fillna("").str.lower().str[:1].to_numpy()
    hour = np.where(half == "", hour, hour % 12.0 + 12.0 * (half == "p"))
    second = told["second"].str.replace(",", ".").astype(float).to_numpy()
    of_day = 3600.0 * hour + 60.0 * told["minute"].astype(float).to_numpy() + second
    date = told["date"].fillna("").to_numpy()
    later = (date[1:] != date[:-1]) | ((date[1:] == "") & (np.diff(of_day) < -0.5 * DAY_S))
    seconds = np.full(len(cells), np.nan)
    seconds[~empty] = of_day - of_day[0] + DAY_S * np.r_[0.0, np.cumsum(later)]
    return np.round(seconds, 9)


def must_be_seconds(table: pd.DataFrame, column: Column, unit: str) -> None:
    """RecordingError where a column that held stamps is said to be in another unit than seconds."""
    if column in table.attrs.get(STAMPED, ()) and factor_to_si(unit, "time")[0] != 1.0:
        raise RecordingError(
            f"time column {column!r} holds dates or times of day, which are read as seconds since the first, but its "
            f"unit is said to be {unit!r}; write s"
        )


def must_hold_no_stamps(table: pd.DataFrame, column: Column, channel: str) -> None:
    """RecordingError where a channel's column held stamps: it is a clock, and no reading of a sensor."""
    if column in table.attrs.get(STAMPED, ()):
        raise RecordingError(
            f"{channel} is said to be in column {column!r}, which holds dates or times of day; map another column"
        )


def seconds_of_clock(values: pd.Series | pd.Index | pd.DataFrame) -> Array | None:
    """pandas' dates or durations (n,), or texts of them, as seconds since the first that is there, (n,); None where
    they are neither.

    >>> seconds_of_clock(pd.Series(pd.date_range("2026-03-01 10:00", periods=3, freq="250ms")))
    array([0.  , 0.25, 0.5 ])
    """
    if isinstance(values, pd.DataFrame):
        return None  # two columns of one name, which are refused elsewhere
    if values.dtype.kind in "OTU" or isinstance(values.dtype, pd.StringDtype):
        return _of_texts(pd.Series(values))
    if not (pd.api.types.is_datetime64_any_dtype(values) or pd.api.types.is_timedelta64_dtype(values)):
        return None
    there = values[values.notna()]
    if not len(there):
        raise RecordingError(f"column {values.name!r} holds dates or durations, and none of them is there; repair it")
    first = there.iloc[0] if isinstance(there, pd.Series) else there[0]
    return np.asarray((values - first) / pd.Timedelta(seconds=1), dtype=np.float64)


def _of_texts(cells: pd.Series) -> Array | None:
    """Cells that are all stamps, or empty, as seconds since the first; None of others."""
    there = cells[cells.notna()]
    if not len(there) or not all(isinstance(cell, str) for cell in there) or not is_stamp(there.iloc[0]):
        return None
    try:
        return seconds_of_texts(cells)
    except ValueError:
        return None
