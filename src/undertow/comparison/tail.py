"""Probabilities of a statistic from simulated values of it, also beyond the largest, and its histogram.

Belongs here: that distribution. Does not belong here: what is simulated (replicas.py, null_test.py).
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from undertow.recording.recording import Array

TAIL = 0.02
"""Share of the replicas by which the tail of a statistic is found: beyond, it is taken to fall exponentially, as surely
as so many values tell. Scatter that few dry trials show has a tail that falls slower, so that no more of it is
extrapolated than must be."""

BINS = 32
"""Bins of the histogram that is kept of a level's replicas."""

WIDEST = 100.0
"""Largest over smallest edge of that histogram: smaller values are counted in its first bin."""

UNSEEN, FALL_UNSEEN = 0.5, 1.0
"""Where no replica exceeds the start, for most are alike (a law that may only add has no gain in them): half a replica
is taken to, and the mean excess to be that of half a squared standard normal number, as sure as one value tells."""


def wilks(gain: float, width: int) -> float:
    """Logarithm of the probability that so many coefficients of nothing gain as much log likelihood: half of a
    chi-squared number (Wilks 1938, doi:10.1214/aoms/1177732360).

    >>> round(math.exp(wilks(1.92, 1)), 3), wilks(0.0, 2)
    (0.05, 0.0)
    """
    return math.log(max(float(chdtrc(width, 2.0 * max(gain, 0.0))), sys.float_info.min))


@dataclass(frozen=True)
class Tail:
    """The distribution of a statistic among replicas: ``values`` sorted, exponential with mean excess ``fall`` above
    ``start``, which a ``share`` exceeds: ``count`` of them, `TAIL` of all, or fewer where many are alike.

    Another value, which had no part in the mean, exceeds x with probability (1 + (x - start) / (count fall))^-count
    (the predictive distribution of an exponential, with a prior of 1 / fall), not with exp(-(x - start) / fall).
    """

    values: Array
    start: float
    fall: float
    count: int
    share: float

    @classmethod
    def of(cls, values: Array) -> Tail:
        """From a statistic of the replicas, (draws,)."""
        ordered = np.sort(values)
        start = float(np.quantile(ordered, 1.0 - TAIL))
        excess = ordered[ordered > start] - start
        fall = float(np.mean(excess)) if excess.size else FALL_UNSEEN
        share = min(max(excess.size, UNSEEN) / ordered.size, TAIL)
        return cls(ordered, start, fall, max(excess.size, 1), share)

    def log_p(self, x: Array) -> Array:
        """Logarithm of the probability that a replica has at least ``x`` (n,)."""
        above = self.values.size - np.searchsorted(self.values, x, side="left")
        ranked = np.log(np.maximum(above, 0.5) / self.values.size)
        beyond = np.maximum(x - self.start, 0.0) / (self.count * self.fall)
        tail = math.log(self.share) - self.count * np.log1p(beyond)
        return np.asarray(np.where(x > self.start, tail, ranked), dtype=np.float64)

    def quantile(self, p: float) -> float:
        """What a replica exceeds with probability ``p`` (at most its ``share``)."""
        return self.at(math.log(p))

    def at(self, log_p: float) -> float:
        """The value that has this log probability (below that of its ``share``)."""
        return self.start + self.count * self.fall * math.expm1(max(math.log(self.share) - log_p, 0.0) / self.count)


@dataclass(frozen=True)
class Histogram:
    """A level's largest score beside those of its replicas: ``counts`` of the replicas in bins whose edges are in equal
    ratios from ``low`` to ``high``, the level's own score, and the score beyond which a level is not like its replicas
    (``limit``)."""

    low: float
    high: float
    counts: tuple[int, ...]
    own: float
    limit: float

    @classmethod
    def of(cls, scores: Array, own: float, limit: float) -> Histogram | None:
        """From the replicas' scores (draws,); None where none is above zero.

        >>> Histogram.of(np.array([0.0, 1.0, 2.0]), 5.0, 3.0).counts[::31]
        (1, 1)
        """
        high = float(np.max(scores, initial=0.0))
        if not high > 0.0:
            return None
        low = max(float(np.min(scores)), high / WIDEST)
        low = low if low < high else high / WIDEST
        counts, _ = np.histogram(np.clip(scores, low, high), np.geomspace(low, high, BINS + 1))
        return cls(low, high, tuple(int(n) for n in counts), own, limit)

    @property
    def edges(self) -> Array:
        """The bins' edges, (bins + 1,)."""
        return np.geomspace(self.low, self.high, len(self.counts) + 1)
