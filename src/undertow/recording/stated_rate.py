"""A sampling rate that is stated, against a column of the same table that is a time.

Belongs here: that look and the sentence. Does not belong here: whether a rate is stated (channels.py), who may accept
it (catalogue.py).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.channels import ChannelSpec, TimeSpec
from undertow.recording.layout import FileFormat
from undertow.recording.propose import name_and_unit, speaks_of_time
from undertow.recording.readers import read_table
from undertow.recording.recording import Array
from undertow.recording.stamps import STAMPED
from undertow.recording.units import factor_to_si, is_unit_of

SAME_RATE = 0.01
"""Share by which a stated rate and that of a time beside it may differ: clocks are better, rounded stamps are not."""

UNSAID = ("s", "ms", "us")
"""Units that a column of times without one may be in."""


def other_rate(table: pd.DataFrame, rate_hz: float) -> str:
    """That a column of the table is a time at another rate than the one stated (Hz), and what to do; empty where none
    is. A column that counts rows is no time.

    >>> other_rate(pd.DataFrame({"t": [0.0, 0.01, 0.02], "x": [1.0, 0.9, 0.7]}), 50.0).partition(";")[0]
    "column 't' is a time with a sample every 0.01 s, which is 100 Hz, but rate_hz is 50 Hz"
    """
    for column in table.columns:
        unit = "s" if column in table.attrs.get(STAMPED, ()) else table.attrs.get("units", {}).get(column, "")
        steps = _steps(table[column]) if speaks_of_time(column) else np.zeros(0)
        sizes = _sizes(unit or name_and_unit(column)[1])
        if not steps.size or (len(sizes) > 1 and np.all(steps == 1.0)):
            continue
        usual = (float(np.median(steps)), float(np.mean(steps)))  # rounding misleads the one, gaps the other
        if not any(abs(step * size * rate_hz - 1.0) <= SAME_RATE for step in usual for size in sizes):
            step = usual[0] * sizes[0]
            return (
                f"column {column!r} is a time with a sample every {step:.4g} s, which is {1.0 / step:.5g} Hz, but "
                f"rate_hz is {rate_hz:.5g} Hz; map the column in recordings.channels.time, or list clock in "
                "recordings.accept where rate_hz is right"
            )
    return ""


def file_rate(path: Path, layout: FileFormat, time: TimeSpec, channel: ChannelSpec) -> str:
    """`other_rate` of the table of a file that a channel lies in; empty where its time has a column, or where no
    column has a name."""
    clock = channel.time or time
    if clock.rate_hz is None or channel.file is not None or layout.cells is not None or not layout.header:
        return ""
    layout = layout if channel.variable is None else replace(layout, variable=channel.variable)
    try:
        table = read_table(path, layout)
    except RecordingError:
        return ""  # of columns that nobody asked for, one cannot be read
    return other_rate(table, clock.rate_hz)


def _steps(column: pd.Series) -> Array:
    """Steps (n,) of a column of increasing numbers; none of another."""
    try:
        values = column.to_numpy(dtype=np.float64, na_value=np.nan)
    except (TypeError, ValueError):
        return np.zeros(0)
    steps: Array = np.diff(values[np.isfinite(values)])
    return steps if np.all(steps > 0.0) else np.zeros(0)


def _sizes(unit: str) -> tuple[float, ...]:
    """Seconds of a unit of time; of those that it may be, where it is not said or none."""
    known = (unit,) if unit and is_unit_of(unit, "time", "translation") else UNSAID
    return tuple(factor_to_si(one, "time", "translation")[0] for one in known)
