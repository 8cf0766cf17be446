"""Errors of numbers that describe: by how much they would move if one trial were left out, or all large ones.

What a fit of the law itself says of its errors assumes that all trials obey it. A law that leaves more than noise only
describes, and describes each trial with other numbers; their difference is the error that counts. Where it describes
small motions with other numbers than large ones, leaving out one trial of many hardly shows it.

Belongs here: that error. Does not belong here: fits (joint.py), what is said (discrepancy/).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from undertow.comparison.joint import JointFit
from undertow.comparison.limits import FAR_ABOVE_NOISE
from undertow.comparison.score_test import scaled_inverse
from undertow.recording.recording import Array

FEWEST_TRIALS = 3
"""Trials of a level from which leaving one out says something."""

LEAST_KNOWN = 1e-6
"""Stated error over how far a number moves below which it sits on a bound: what it could be is not known so."""

FEWEST_HALVED = 4
"""Trials of each spring from which leaving half of them out does: one alone leaves what goes with its size open."""


def with_errors_by_trials(fit: JointFit) -> JointFit:
    """The fit with standard errors no smaller than the jackknife over trials gives (Efron 1982,
    doi:10.1137/1.9781611970319), or half the difference between small and large releases, where it leaves more than
    noise and has three trials or more; correlations as they were."""
    solution = fit.solution
    if fit.misfit <= FAR_ABOVE_NOISE or len(solution.problem.trials) < FEWEST_TRIALS:
        return fit
    stated = np.sqrt(np.maximum(np.diag(solution.covariance), 0.0))
    away = np.maximum(jackknife(fit), between_sizes(fit))
    grown = np.ones_like(stated)
    np.divide(away, stated, out=grown, where=stated > np.maximum(LEAST_KNOWN * away, 1e-150))
    grown = np.maximum(grown, 1.0)
    return replace(fit, solution=replace(solution, covariance=solution.covariance * np.outer(grown, grown)))


def jackknife(fit: JointFit) -> Array:
    """Standard error (unknowns,) by one Gauss-Newton step from the fit to where it would be without each trial in turn.

    A trial's own unknowns have no others to differ from: theirs are zero.
    """
    count = len(fit.solution.problem.trials)
    steps = _without(fit, [[i] for i in range(count)])
    return np.asarray(np.sqrt((count - 1.0) / count * np.sum(np.square(steps), axis=0)))


def between_sizes(fit: JointFit) -> Array:
    """Half the difference (unknowns,) between where the fit would be without the smaller half of each spring's releases
    and without the larger, by one Gauss-Newton step each: the standard deviation of numbers that go with the size of
    the motion, and where they do not about their own error. Zero where a spring has fewer than four trials."""
    problem = fit.solution.problem
    alike: dict[tuple[int, ...], list[int]] = {}
    for i, used in enumerate(fit.solution.used):
        shared = (int(j) for j in used if not problem.names[j].endswith("]"))
        alike.setdefault(tuple(shared), []).append(i)
    sizes = [float(np.max(np.abs(trial.channels[0].values))) for trial in problem.trials]
    ordered = [sorted(own, key=lambda i: sizes[i]) for own in alike.values()]
    if min(len(own) for own in ordered) < FEWEST_HALVED:
        return np.zeros(len(problem.unknowns))
    small = [i for own in ordered for i in own[: len(own) // 2]]
    without_small, without_large = _without(fit, [small, [i for i in range(len(sizes)) if i not in small]])
    return np.asarray(0.5 * np.abs(without_small - without_large))


def _without(fit: JointFit, left_out: Sequence[Sequence[int]]) -> list[Array]:
    """Steps (unknowns,) of what trials share from the fit to where it would be without these trials."""
    solution = fit.solution
    unknowns = solution.problem.unknowns
    common = np.array([not u.name.endswith("]") for u in unknowns])
    normal, parts = np.diag(solution.problem.believed[1]), []
    for jac, r, used in zip(solution.jacobians, solution.residuals, solution.used, strict=True):
        mine, gradient = np.zeros_like(normal), np.zeros(len(unknowns))
        mine[np.ix_(used, used)] = jac.T @ jac
        gradient[used] = jac.T @ r * common[used]  # the trial's own are at rest, priors included
        normal = normal + mine
        parts.append((mine, gradient))
    steps = []
    for out in left_out:
        matrix, gradient = normal - sum(parts[i][0] for i in out), np.sum([parts[i][1] for i in out], axis=0)
        steps.append(np.asarray(scaled_inverse(matrix, 1e-9) @ gradient * common))
    return steps
