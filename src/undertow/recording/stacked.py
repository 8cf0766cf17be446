"""Several trials one below another in one table: seen by a time that begins again, and by a column that counts them.

Belongs here: that look and the sentence. Does not belong here: columns side by side (propose.py).
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from undertow.recording.layout import Column
from undertow.recording.recording import Array

AGAIN = 0.01
"""Share of its first stretch within which a time that goes back begins again where it began."""


def begins_again(time: Array) -> int:
    """How many trials times (n,) are of that go back to where they began; 1 where they do not, or go back elsewhere.

    >>> begins_again(np.array([0.0, 1.0, 2.0, 0.0, 1.0])), begins_again(np.array([0.0, 1.0, 2.0, 1.0, 2.0]))
    (2, 1)
    """
    back = np.flatnonzero(np.diff(time) < 0.0) + 1
    if not back.size or np.any(np.abs(time[back] - time[0]) > AGAIN * (time[back[0] - 1] - time[0])):
        return 1
    return int(back.size) + 1


def stacked(table: pd.DataFrame, clock: Column, in_python: bool = False) -> str:
    """That a table holds several trials one below another, by which column, and how to split it; empty where it does
    not. ``clock`` is its column of times, numbers; a table ``in_python`` needs no files."""
    time = pd.to_numeric(table[clock], errors="coerce").to_numpy(dtype=np.float64)
    number = begins_again(time)
    if number == 1:
        return ""
    trial = np.r_[0, np.cumsum(np.diff(time) < 0.0)]
    beside = [name for name in table.columns if name != clock and _counts(table[name], trial)]
    by = f"by column {beside[0]!r}" if beside else "no column of numbers counts them"
    split = repr(beside[0]) if beside else f"(table[{clock!r}].diff() < 0).cumsum()"
    if in_python:
        rows = f"{{str(n): one for n, one in table.groupby({split})}}"
        return f"holds {number} trials one below another ({by}): give each by its name, as in undertow.read({rows})"
    return (
        f"holds {number} trials one below another ({by}): split it into files, as with pandas: "
        f'for n, one in table.groupby({split}): one.to_csv(f"trial_{{n}}.csv", index=False)'
    )


def _counts(column: pd.Series, trial: np.ndarray) -> bool:
    """Whether a column has one value a trial and another in each."""
    values = column.groupby(trial)
    return bool((values.nunique(dropna=False) == 1).all()) and values.first().is_unique
