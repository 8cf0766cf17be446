"""Arrays as users hand them over: real numbers, instants.

Belongs here: kinds of numbers. Does not belong here: which of them means what (front/, conditioning/).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.recording import Array
from undertow.recording.stamps import seconds_of_clock


def real_numbers(given: Any, name: str) -> Array:
    """An array's numbers as float64; what a mask hides is NaN.

    Raises RecordingError where they are complex, dates, or no numbers.

    >>> real_numbers(np.ma.masked_greater([1.0, 9.0], 5.0), "x")
    array([ 1., nan])
    """
    if np.iscomplexobj(given):
        raise RecordingError(f"{name} holds complex numbers, and is real; give real part, absolute value or angle")
    values = np.asarray(given)
    if values.dtype.kind == "b":
        raise RecordingError(f"{name} holds truth values, and no numbers; give what the sensor said")
    if values.dtype.kind in "mM":
        raise RecordingError(f"{name} holds dates or durations, and no numbers; only times may be dates")
    try:
        if isinstance(given, np.ma.MaskedArray):
            return np.where(np.ma.getmaskarray(given), np.nan, np.ma.getdata(given))
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RecordingError(f"{name} holds what is no number ({error}); give numbers, one row an instant") from error


def instants(given: Any, name: str = "t") -> Array:
    """Times (n,) in s, or a step; dates and durations are seconds since the first.

    Raises RecordingError as `real_numbers`.

    >>> instants(pd.date_range("2026-03-01", periods=3, freq="250ms"))
    array([0.  , 0.25, 0.5 ])
    """
    stamps = None if np.ndim(given) != 1 else seconds_of_clock(pd.Series(given))
    return real_numbers(given, name) if stamps is None else stamps
