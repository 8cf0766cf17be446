"""How sure a fit is: noise as it is, not as a data sheet says, and what was held fixed.

Belongs here: covariances and intervals of output-error solutions. Does not belong here: the search itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from scipy import stats

from undertow.errors import IdentificationError
from undertow.identification.output_error import Solution
from undertow.quantities import Estimate
from undertow.recording.recording import Array

BLOCK_PERIODS = 1.5
"""Length of a block of residuals, in periods of the motion: longer than what a residual remembers of itself."""


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
    precision = np.array([1.0 / u.prior_std**2 for u in solution.problem.unknowns])
    bread = solution.covariance
    covariance: Array = bread @ (meat + np.diag(precision)) @ bread
    return covariance


def systematic_covariance(solution: Solution, fixed: Mapping[int, tuple[Array, float]]) -> Array:
    """Covariance from parameters that were held fixed: sum over them of d d^T, d = -H^-1 J^T J_f sigma_f.

    ``fixed`` maps an index to (J_f stacked over trials as the residuals are, sigma_f).
    """
    size = len(solution.problem.unknowns)
    total = np.zeros((size, size))
    for column, sigma in fixed.values():
        gradient = np.zeros(size)
        at = 0
        for r, jac, used in zip(solution.residuals, solution.jacobians, solution.used, strict=True):
            gradient[used] += jac.T @ column[at : at + r.size]
            at += r.size
        move = solution.covariance @ gradient * sigma
        total += np.outer(move, move)
    return total


def half_width(stderr: float, level: float = 0.9, degrees_of_freedom: float = math.inf) -> float:
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


def mean_of_trials(estimates: list[Estimate], unit: str, source: str) -> Estimate:
    """Mean over trials that differ by more than their noise: random-effects mean (DerSimonian and Laird 1986).

    The standard error is the larger of the weighted one and scatter / sqrt(n), enlarged by Student's t at 68 % for few
    trials. IdentificationError without a finite estimate.
    """
    good = [e for e in estimates if math.isfinite(e.value)]
    if not good:
        raise IdentificationError(
            f"{source}: none of {len(estimates)} trials has a finite value; look at their outcomes"
        )
    values = np.array([e.value for e in good])
    n = values.size
    noise = np.array([e.stderr if math.isfinite(e.stderr) else 0.0 for e in good])
    if n == 1:
        return Estimate(float(values[0]), float(noise[0]) or math.nan, unit=unit, source=source)
    between = max(float(np.var(values, ddof=1)) - float(np.mean(noise**2)), 0.0)
    weights = 1.0 / np.maximum(noise**2 + between, 1e-300)
    if between == 0.0 and not np.any(noise > 0.0):
        weights = np.ones(n)
    mean = float(np.sum(weights * values) / np.sum(weights))
    plain = float(np.std(values, ddof=1)) / math.sqrt(n)
    weighted = 1.0 / math.sqrt(float(np.sum(weights))) if np.any(noise > 0.0) else plain
    few = half_width(1.0, 0.683, n - 1) / half_width(1.0, 0.683)
    return Estimate(mean, max(plain, weighted) * few, unit=unit, source=source)
