"""Standard errors of a regression whose residual is correlated in time and whose trials differ.

Belongs here: covariances and factors from residuals. Does not belong here: the regression, or errors of what was held
fixed (scale.py).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm
from scipy.stats import t as student

Array = NDArray[np.float64]

COVERAGE_TAIL = 0.95
"""Upper end of the 90 % interval at which few trials are made as wide as Student's t says."""

SCATTER_LEVEL = 0.95
"""Quantile of what noise alone would make of the scatter between trials; beyond it the scatter is taken as real."""

LEVEL_OF_TWO = 0.999
"""The same of two trials, where what is real makes an error four times as wide as their difference says."""


def robust_covariance(
    columns: Sequence[Array], residuals: Sequence[Array], block: int, nuisance: int = 0
) -> tuple[Array, Array]:
    """Covariance (p, p) of pooled least squares, and the factor (p,) by which trials scatter beyond it.

    ``columns`` (n_i, p) and ``residuals`` (n_i,) of each trial, less the ``nuisance`` columns' share; rows that are not
    used are zero. The covariance is (X'X)^-1 S (X'X)^-1 with Bartlett's window: S is the sum of outer products of
    moving sums of X e over ``block`` rows, divided by ``block`` (Newey and West 1987, doi:10.2307/1913610), times
    n / (n - p) for the parameters spent. The factor is `scatter_factor`.

    >>> rng = np.random.default_rng(0)
    >>> covariance, factor = robust_covariance([np.ones((400, 1))], [rng.standard_normal(400)], block=5)
    >>> bool(0.7 < covariance[0, 0] * 400 < 1.3), factor.tolist()
    (True, [1.0])
    """
    rows = sum(int(np.count_nonzero(np.any(part != 0.0, axis=1))) for part in columns)
    freedom = rows / max(rows - columns[0].shape[1] - nuisance, 1)
    scores = [
        freedom * score_covariance(part * residual[:, None], block)
        for part, residual in zip(columns, residuals, strict=True)
    ]
    grams = [part.T @ part for part in columns]
    moments = [part.T @ residual for part, residual in zip(columns, residuals, strict=True)]
    bread = np.linalg.inv(np.sum(grams, axis=0))
    return bread @ np.sum(scores, axis=0) @ bread, scatter_factor(grams, scores, moments)


def score_covariance(scores: Array, block: int) -> Array:
    """Covariance (p, p) of the sum of the rows of ``scores`` (n, p), correlated over up to ``block`` rows."""
    edge = np.zeros((block, scores.shape[1]))
    cumulated = np.cumsum(np.vstack([edge, scores, edge]), axis=0)
    sums = cumulated[block:] - cumulated[:-block]
    covariance: Array = sums.T @ sums / block
    return covariance


def scatter_factor(grams: Sequence[Array], scores: Sequence[Array], moments: Sequence[Array]) -> Array:
    """How much wider than the residual says the standard errors (p,) have to be because trials differ; 1 or more.

    ``grams`` X'X, ``scores`` the covariance of X'e and ``moments`` X'e of each trial. The jackknife over trials is
    compared with what the residual's noise alone would make of it, coefficient by coefficient. Where it is larger, the
    standard error grows in proportion; where it is beyond `SCATTER_LEVEL` of what noise makes, by (t quantile / normal
    quantile) at n_trials - 1 degrees of freedom too. Of two trials only beyond `LEVEL_OF_TWO`; 1 for one trial, which
    has no jackknife.
    """
    count, size = len(grams), grams[0].shape[0]
    if count < 2:
        return np.ones(size)
    total, moment = np.sum(grams, axis=0), np.sum(moments, axis=0)
    inverses = [np.linalg.inv(total - gram) for gram in grams]
    changes = np.array([inverses[trial] @ (moment - moments[trial]) for trial in range(count)])
    found = np.sum((changes - changes.mean(axis=0)) ** 2, axis=0)
    ratio = found / np.maximum(_expected_scatter(inverses, scores), np.finfo(float).tiny)
    freedom = count - 1
    beyond = ratio > chi2.ppf(SCATTER_LEVEL if count > 2 else LEVEL_OF_TWO, freedom) / freedom
    widening = student.ppf(COVERAGE_TAIL, freedom) / norm.ppf(COVERAGE_TAIL)
    noise_alone = np.sqrt(np.maximum(ratio, 1.0)) if count > 2 else np.ones(size)
    factor: Array = np.where(beyond, np.sqrt(ratio) * widening, noise_alone)
    return factor


def _expected_scatter(inverses: Sequence[Array], scores: Sequence[Array]) -> Array:
    """Sum of squares (p,) of leave-one-trial-out estimates about their mean, from the residuals' noise alone."""
    count = len(inverses)
    mean = np.mean(inverses, axis=0)
    expected = np.zeros(inverses[0].shape[0])
    for left_out in range(count):
        for trial in range(count):
            # a trial's noise enters every leave-one-out estimate but the one without it
            share = inverses[left_out] * (left_out != trial) - mean + inverses[trial] / count
            expected += np.einsum("ij,jk,ik->i", share, scores[trial], share)
    return expected
