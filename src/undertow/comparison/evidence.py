"""What a joint fit is worth at the noise it leaves itself.

Belongs here: each trial's own noise, the evidence's criterion. Does not belong here: the fit (joint.py), the memory of
residuals (likelihood/noise.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Problem


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


def of_an_effect(name: str) -> bool:
    """Whether an unknown is a trial's own number of something that was added, whatever the trial is called.

    >>> of_an_effect("external_forcing.cosine_N[pull 0.02]"), of_an_effect("x0_m[pull 0.02]")
    (True, False)
    """
    what, of_a_trial, _ = name.partition("[")
    return bool(of_a_trial) and "." in what


def criterion(solution: Solution, misfits: Mapping[str, float], memory: float) -> float:
    """Sum over trials of n_eff ln(misfit), prior terms, and ln(n_eff) for every unknown without a prior."""
    samples = max(solution.n_data / memory, 2.0)
    unknowns = solution.problem.unknowns
    shared = sum(math.isinf(u.prior_std) and "[" not in u.name for u in unknowns)
    of_trials = sum(math.isinf(u.prior_std) and of_an_effect(u.name) for u in unknowns)
    data = sum(
        r.size / memory * math.log(misfits[t.name])
        for t, r in zip(solution.problem.trials, solution.residuals, strict=True)
    )
    return data + solution.cost - solution.chi2 + (shared + of_trials) * math.log(samples)
