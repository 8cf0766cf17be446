"""What a stated standard error promises, and how few values widen it.

A parameter's standard error is the half width of its 90 % interval over 1.645: for many trials that is one standard
deviation, for few it is Student's t or a mixture of normals that makes it wider. Belongs here: that convention. Does
not belong here: where the spread comes from (repeats.py, hierarchy.py, intervals.py).
"""

from __future__ import annotations

import functools
import math

import numpy as np
from scipy import stats
from scipy.optimize import brentq
from scipy.special import ndtr

from undertow.errors import IdentificationError
from undertow.recording.recording import Array

INTERVAL_LEVEL = 0.9
"""Confidence at which stated standard errors are right: value +- 1.645 stderr holds the truth in 90 of 100 campaigns,
however few trials there are."""

WIDEST_IN_DEVIATIONS = 100.0
"""Bracket of an interval's half width in standard deviations of a mixture; a mixture's quantile lies far inside."""


def half_width(stderr: float, level: float = INTERVAL_LEVEL, degrees_of_freedom: float = math.inf) -> float:
    """Half width of an interval of confidence ``level``: Student's t times the standard error.

    >>> round(half_width(1.0, 0.9), 3), round(half_width(1.0, 0.9, 2), 3)
    (1.645, 2.92)
    """
    if not 0.0 < level < 1.0:
        raise IdentificationError(f"confidence level is {level:g}; it must lie between 0 and 1, as 0.9")
    quantile = 0.5 + 0.5 * level
    if math.isinf(degrees_of_freedom):
        return float(stats.norm.ppf(quantile)) * stderr
    return float(stats.t.ppf(quantile, degrees_of_freedom)) * stderr


@functools.lru_cache(maxsize=1024)
def widening(freedom: float) -> float:
    """Student's t over the normal quantile at `INTERVAL_LEVEL`: what makes a standard error from few values honest.

    >>> round(widening(2.0), 3), widening(math.inf)
    (1.775, 1.0)
    """
    return half_width(1.0, INTERVAL_LEVEL, freedom) / half_width(1.0)


def as_stderr(half: float) -> float:
    """Standard error whose normal interval at `INTERVAL_LEVEL` has this half width.

    >>> round(as_stderr(1.6449), 3)
    1.0
    """
    return half / half_width(1.0)


def mixture_half_width(value: float, centres: Array, spreads: Array, weights: Array) -> float:
    """Half width about ``value`` that holds `INTERVAL_LEVEL` of normals (m,) with ``weights`` (m,), which sum to 1; NaN
    or infinite where a spread is.

    >>> round(mixture_half_width(0.0, np.zeros(1), np.ones(1), np.ones(1)), 3)
    1.645
    """
    typical = float(np.sqrt(weights @ (spreads**2 + (centres - value) ** 2)))
    if not 0.0 < typical < np.inf:
        return typical
    spreads = np.maximum(spreads, 1e-12 * typical)

    def inside(half: float) -> float:
        upper = ndtr((value + half - centres) / spreads)
        lower = ndtr((value - half - centres) / spreads)
        return float(weights @ (upper - lower)) - INTERVAL_LEVEL

    return float(brentq(inside, 0.0, WIDEST_IN_DEVIATIONS * typical))
