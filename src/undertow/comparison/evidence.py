"""What a joint fit is worth at the noise it leaves itself.

Belongs here: each trial's own noise, the evidence's criterion, the memory of residuals. Does not belong here: the fit
(joint.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Problem
from undertow.recording.recording import Array


def tempered(problem: Problem, misfits: Mapping[str, float], memory: float) -> Problem:
    """The same problem with each trial's noise enlarged by sqrt(misfit of that trial x memory)."""
    trials = []
    for t in problem.trials:
        factor = math.sqrt(misfits[t.name] * memory)
        trials.append(replace(t, channels=tuple(replace(c, sigma=c.sigma * factor) for c in t.channels)))
    return Problem(problem.unknowns, tuple(trials))


def trial_misfits(solution: Solution, misfits: Mapping[str, float], memory: float) -> dict[str, float]:
    """Mean squared residual of each trial in units of its sensors' noise, at least 1."""
    return {
        trial.name: max(float(r @ r) * misfits[trial.name] * memory / r.size, 1.0)
        for trial, r in zip(solution.problem.trials, solution.residuals, strict=True)
    }


def criterion(solution: Solution, misfits: Mapping[str, float], memory: float) -> float:
    """Sum over trials of n_eff ln(misfit), prior terms, and ln(n_eff) for every unknown without a prior."""
    samples = max(solution.n_data / memory, 2.0)
    unknowns = solution.problem.unknowns
    shared = sum(math.isinf(u.prior_std) and "[" not in u.name for u in unknowns)
    of_trials = sum(math.isinf(u.prior_std) and "[" in u.name and "." in u.name for u in unknowns)
    data = sum(
        r.size / memory * math.log(misfits[t.name])
        for t, r in zip(solution.problem.trials, solution.residuals, strict=True)
    )
    return data + solution.cost - solution.chi2 + (shared + of_trials) * math.log(samples)


def residual_memory(solution: Solution) -> float:
    """Mean number of cells over which residuals are correlated (integrated autocorrelation, at least 1)."""
    total, count = 0.0, 0
    for trial, r in zip(solution.problem.trials, solution.residuals, strict=True):
        n = trial.t.size
        for i in range(len(trial.channels)):
            total += _memory(r[i * n : (i + 1) * n])
            count += 1
    return total / max(count, 1)


def _memory(residual: Array) -> float:
    """Integrated autocorrelation time of a series by its squared correlations: 1 for white noise, in samples."""
    centred = residual - residual.mean()
    power = np.abs(np.fft.rfft(centred, 2 * centred.size)) ** 2
    correlation = np.fft.irfft(power)[: centred.size // 2]
    if correlation[0] <= 0.0:
        return 1.0
    rho = correlation / correlation[0]
    return float(1.0 + 2.0 * np.sum(rho[1:] ** 2))
