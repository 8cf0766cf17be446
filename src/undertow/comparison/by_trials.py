"""Errors of numbers that describe: by how much they would move if one trial were left out.

What a fit of the law itself says of its errors assumes that all trials obey it. A law that leaves more than noise only
describes, and describes each trial with other numbers; their difference is the error that counts.

Belongs here: that error. Does not belong here: fits (joint.py), what is said (discrepancy/).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from undertow.comparison.explained import FAR_ABOVE_NOISE
from undertow.comparison.joint import JointFit
from undertow.comparison.score_test import scaled_inverse
from undertow.recording.recording import Array

FEWEST_TRIALS = 3
"""Trials of a level from which leaving one out says something."""


def with_errors_by_trials(fit: JointFit) -> JointFit:
    """The fit with standard errors no smaller than the jackknife over trials gives (Efron 1982,
    doi:10.1137/1.9781611970319), where it leaves more than noise and has three trials or more; correlations as they
    were."""
    solution = fit.solution
    if fit.misfit <= FAR_ABOVE_NOISE or len(solution.problem.trials) < FEWEST_TRIALS:
        return fit
    stated = np.sqrt(np.maximum(np.diag(solution.covariance), 0.0))
    grown = np.where(stated > 0.0, np.maximum(jackknife(fit) / np.maximum(stated, 1e-300), 1.0), 1.0)
    return replace(fit, solution=replace(solution, covariance=solution.covariance * np.outer(grown, grown)))


def jackknife(fit: JointFit) -> Array:
    """Standard error (unknowns,) by one Gauss-Newton step from the fit to where it would be without each trial in turn.

    A trial's own unknowns have no others to differ from: theirs are zero.
    """
    solution = fit.solution
    unknowns = solution.problem.unknowns
    precision = np.array([1.0 / u.prior_std**2 for u in unknowns])
    common = np.array([not u.name.endswith("]") for u in unknowns])
    normal, parts = np.diag(precision), []
    for jac, r, used in zip(solution.jacobians, solution.residuals, solution.used, strict=True):
        mine, gradient = np.zeros_like(normal), np.zeros(len(unknowns))
        mine[np.ix_(used, used)] = jac.T @ jac
        gradient[used] = jac.T @ r * common[used]  # the trial's own are at rest, priors included
        normal = normal + mine
        parts.append((mine, gradient))
    count = len(parts)
    steps = [scaled_inverse(normal - mine, 1e-9) @ gradient for mine, gradient in parts]
    return np.asarray(np.sqrt((count - 1.0) / count * np.sum(np.square(steps), axis=0)) * common)
