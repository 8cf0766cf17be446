"""How sure a fit is: noise as it is, not as a data sheet says, and what was held fixed.

Belongs here: covariances and intervals of output-error solutions. Does not belong here: the search itself.
"""

from __future__ import annotations

import numpy as np

from undertow.likelihood.output_error import Solution
from undertow.recording.recording import Array

BLOCK_PERIODS = 1.5
"""Length of a block of residuals, in periods of the motion: longer than what a residual remembers of itself."""

NOISE_BAND = 1.2
"""A fit can take noise for motion up to just above the motion's frequency; beyond, coloured noise falls off."""


def noise_covariance(solution: Solution) -> Array:
    """Covariance (p, p) of the unknowns from the residuals as they are: coloured, and of whatever size.

    Sandwich H^-1 (S + P) H^-1 with H the normal matrix with priors, P the priors' precision and S the sum over blocks
    of the outer product of each block's score J^T r (White 1980; blocks after Newey and West 1987). Blocks are
    `BLOCK_PERIODS` long; S is enlarged by n / (n - p) blocks for the parameters spent.
    """
    size = len(solution.problem.unknowns)
    meat = np.zeros((size, size))
    for trial, r, jac, used in zip(
        solution.problem.trials, solution.residuals, solution.jacobians, solution.used, strict=True
    ):
        n = trial.t.size
        blocks = max(4, round((trial.t[-1] - trial.t[0]) / (BLOCK_PERIODS * trial.period_s)))
        edges = np.linspace(0, n, blocks + 1).astype(int)
        scores = np.zeros((blocks, used.size))
        for i in range(len(trial.channels)):
            rows = slice(i * n, (i + 1) * n)
            weighted = jac[rows] * r[rows, None]
            scores += np.add.reduceat(weighted, edges[:-1], axis=0)
        spent = max(1.0, blocks / max(blocks - used.size, 1.0))
        meat[np.ix_(used, used)] += spent * (scores.T @ scores)
    bread = solution.covariance
    return bread @ (meat + np.diag(solution.problem.believed[1])) @ bread


def residual_covariance(solution: Solution) -> Array:
    """Covariance (p, p) of the unknowns from coloured noise alone: H^-1 (J^T F J) H^-1, F from `noise_factors`.

    Priors hold the unknowns but bring no error of their own: what they stand for is added by whoever set them.
    """
    size = len(solution.problem.unknowns)
    meat = np.zeros((size, size))
    rows = zip(solution.problem.trials, solution.jacobians, solution.used, noise_factors(solution), strict=True)
    for trial, jac, used, factors in rows:
        weight = np.repeat(factors, trial.t.size)
        meat[np.ix_(used, used)] += jac.T @ (jac * weight[:, None])
    return solution.covariance @ meat @ solution.covariance


def noise_factors(solution: Solution) -> list[Array]:
    """Spectral density of each channel's residual where the motion is, over that of white noise as stated; per trial
    (channels,), at least 1.

    Coloured noise and drift pass for motion only up to `NOISE_BAND` times the motion's frequency: the residual's mean
    periodogram there is what a parameter sees. The unknowns have taken their share out of it: enlarged by
    bins / (bins - unknowns / (2 channels)).
    """
    out = []
    for trial, r, used in zip(solution.problem.trials, solution.residuals, solution.used, strict=True):
        n, channels = trial.t.size, len(trial.channels)
        length = (trial.t[-1] - trial.t[0]) * n / max(n - 1, 1)
        bins = int(np.clip(round(NOISE_BAND * length / trial.period_s), 4, n // 2))
        spent = bins / max(bins - 0.5 * used.size / channels, 0.25 * bins)
        factors = np.ones(channels)
        for i in range(channels):
            power = np.abs(np.fft.rfft(r[i * n : (i + 1) * n])[1 : bins + 1]) ** 2 / n
            factors[i] = max(1.0, spent * float(np.mean(power)))
        out.append(factors)
    return out
