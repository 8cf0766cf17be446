"""The memory of noise and what it leaves of a number of samples: the one home of both.

Two questions, two formulas. Of a series alone, what its own variance is known from: n over 1 + 2 sum rho^2 (Bartlett
1935, doi:10.2307/2983642, Eq. 6 for a variance), which evidence n ln(misfit) needs. Of a regression, what its
coefficients are known from: n over the mean factor by which correlation widens their variances, which depends on the
columns.

Belongs here: autocovariances, memory, effective samples. Does not belong here: intervals (uncertainty/intervals.py),
criteria (comparison/evidence.py).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.signal import fftconvolve

from undertow.likelihood.output_error import Solution
from undertow.recording.recording import Array

MEMORY_SHARE = 0.1
"""Longest memory of a residual looked for, as a share of the rows: beyond it is mostly the estimate's own noise."""

WINDOW_TIMES = 6.0
"""Lags are used up to this many correlation times (Sokal 1997, doi:10.1007/978-1-4899-0319-8_6)."""


BY_CHANCE = 0.75
"""What correlations by chance add to the memory of white noise."""


def memory(residual: Array) -> float:
    """Samples of a series (n,) that say as much of its variance as one of white noise: at least 1.

    The integrated autocorrelation time of its squared correlations, over half of its lags. Correlations by chance are
    squared too: white noise gives 1 + `BY_CHANCE`, and what decides by this has been set with that.

    >>> bool(1.5 < memory(np.random.default_rng(0).standard_normal(4000)) < 2.0)
    True
    """
    centred = residual - residual.mean()
    products = correlate(centred[:, None], centred.size // 2)[:, 0]
    if products[0] <= 0.0:
        return 1.0
    rho = products / products[0]
    return float(1.0 + 2.0 * np.sum(rho[1:] ** 2))


def residual_memory(solution: Solution) -> float:
    """Mean number of cells over which residuals are correlated: the mean `memory` of all trials' channels."""
    total, count = 0.0, 0
    for trial, r in zip(solution.problem.trials, solution.residuals, strict=True):
        n = trial.t.size
        for i in range(len(trial.channels)):
            total += memory(r[i * n : (i + 1) * n])
            count += 1
    return total / max(count, 1)


def autocovariance(residual: Array, lengths: Sequence[int], memory: int | None = None) -> Array:
    """Autocovariance (memory,) of ``residual`` (n,) at lags 0, 1, ..., pooled over trials of ``lengths`` rows; of
    several columns (n, p) the sum of theirs.

    Weighted down by Parzen's window to ``memory`` rows, so that it belongs to a spectrum without negative values;
    ``memory`` None takes `WINDOW_TIMES` correlation times, at most `MEMORY_SHARE` of the rows.
    """
    longest = max(2, memory or int(MEMORY_SHARE * residual.size))
    sums, first = np.zeros(longest), 0
    for length in filter(None, lengths):
        own = np.sum(correlate(residual.reshape(len(residual), -1)[first : first + length], longest), axis=1)
        sums[: own.size] += own
        first += length
    if memory is None and sums[0] > 0.0:
        times = 2.0 * np.cumsum(np.abs(sums / sums[0])) - 1.0
        enough = np.flatnonzero(np.arange(1, longest + 1) >= WINDOW_TIMES * times)
        sums = sums[: max(2, int(enough[0]) + 1 if enough.size else longest)]
    lag = np.arange(sums.size) / sums.size
    parzen = np.where(lag < 0.5, 1.0 - 6.0 * lag**2 * (1.0 - lag), 2.0 * (1.0 - lag) ** 3)
    return sums / len(residual) * parzen


def score_matrix(columns: Array, covariance: Array, lengths: Sequence[int]) -> Array:
    """X'RX (p, p): covariance of X'e for noise e of this autocovariance, independent between trials."""
    kernel = np.concatenate([covariance[:0:-1], covariance])[:, None]
    total, first = np.zeros((columns.shape[1], columns.shape[1])), 0
    for length in filter(None, lengths):
        part = columns[first : first + length]
        first += length
        spread = fftconvolve(part, kernel, mode="full", axes=0)[covariance.size - 1 :][: part.shape[0]]
        total += part.T @ spread
    return 0.5 * (total + total.T)


def effective_samples(columns: Array, scores: Array, variance: float) -> float:
    """Independent rows of ``columns`` (n, p) under noise of this ``variance`` and `score_matrix`.

    n / tau, where tau is the mean factor by which correlation widens the variance of a coefficient (1 for white noise
    and never below; Bartlett 1946, doi:10.2307/2983611).
    """
    gram = columns.T @ columns
    widening = float(np.trace(np.linalg.pinv(gram, hermitian=True) @ scores)) / (columns.shape[1] * variance)
    return float(max(columns.shape[0] / max(widening, 1.0), columns.shape[1] + 1))


def correlate(values: Array, lags: int) -> Array:
    """Sums of products at lags 0 to lags - 1 of each column of ``values`` (n, p): (at most lags, p)."""
    size = 2 ** int(np.ceil(np.log2(2 * values.shape[0])))
    spectrum = np.fft.rfft(values, size, axis=0)
    return np.fft.irfft(np.abs(spectrum) ** 2, size, axis=0)[: min(lags, values.shape[0])]
