"""Output error: the parameters whose simulated motion lies closest to what the sensors said.

Levenberg-Marquardt (descent.py) on the compiled trajectories with their exact sensitivities (residuals.py), all trials
and channels together, weighted by noise, with priors on nuisances and on random effects; first on a short window, then
on longer ones, so that a wrong start cannot lock on to a wrong phase. Source: Maine and Iliff 1985 (NASA RP 1138) for
output error; report Method 1 for the trajectory fit.

Belongs here: normal equations of all trials, windows, the solution and its covariance. Does not belong here: what is
fitted (problem.py), intervals (intervals.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from undertow.errors import IdentificationError
from undertow.likelihood import eq15 as sheet
from undertow.likelihood.descent import Descent, Rule, descend
from undertow.likelihood.problem import TRAJECTORY_STEPS_PER_PERIOD, Problem
from undertow.likelihood.residuals import parameter_vector, residuals, trajectory
from undertow.quantities import OK
from undertow.recording.recording import Array

FIRST_WINDOW_PERIODS = 1.0
"""The first window of a growing fit, in periods of the motion; each next one is twice as long."""


def growing_windows(problem: Problem) -> list[float]:
    """Windows in s, growing, all shorter than the longest trial."""
    longest = max(float(t.t[-1] - t.t[0]) for t in problem.trials)
    windows = [FIRST_WINDOW_PERIODS * max(t.period_s for t in problem.trials)]
    while windows[-1] < longest:
        windows.append(2.0 * windows[-1])
    return windows[:-1]


def shortened(problem: Problem, seconds: float) -> Problem:
    """The same problem on each trial's first ``seconds`` of motion."""
    trials = []
    for trial in problem.trials:
        keep = trial.t <= trial.t[0] + seconds
        channels = tuple(
            replace(c, values=c.values[keep], unsure=None if c.unsure is None else c.unsure[keep])
            for c in trial.channels
        )
        trials.append(replace(trial, t=trial.t[keep], channels=channels))
    return Problem(problem.unknowns, tuple(trials))


STOP_IN_STDERR = 1e-3
"""The search ends when no unknown moves by more than this share of its own standard error."""

MAX_ITERATIONS = 80
FIRST_DAMPING = 1e-6
"""Start of Levenberg-Marquardt's damping relative to the diagonal: nearly Gauss-Newton, since a free decay leaves the
common scale of mass and forces to the priors alone, and damping would freeze that direction."""

POOR_FIT = 25.0
"""Mean squared residual in units of noise above which the whole record is also tried from the start itself: an
equation that is wrong can lead growing windows astray."""

LEAST_INFORMATION = 1e-120
"""Floor of the normal matrix' diagonal: what the data say nothing of gets an error of 1e60, whose square is finite."""

NAMES_AT_MOST = 3
"""Trials named in a message at most."""

__all__ = [
    "FULL", "QUICK", "SearchEffort", "Solution", "fit", "parameter_vector", "residuals", "trajectory",
]  # fmt: skip

NO_INFORMATION = 1e-15
"""Share of the largest eigenvalue of the scaled normal matrix below which a direction is rounding: left out."""


@dataclass(frozen=True)
class Solution:
    """Where the search ended: ``values`` and ``covariance`` of the unknowns (noise as stated, priors included).

    ``cost`` is the sum of squared weighted residuals and prior terms, ``chi2`` without priors; ``residuals`` one array
    a trial, channels one after the other, in units of their noise; ``jacobians`` likewise (n, p), p in ``used``.
    ``ambiguity`` (p,) is what the recording leaves open besides (multistart.py; None: nothing), as standard errors.
    """

    problem: Problem
    values: Array
    covariance: Array
    cost: float
    chi2: float
    n_data: int
    iterations: int
    outcome: str
    residuals: tuple[Array, ...]
    jacobians: tuple[Array, ...]
    used: tuple[np.ndarray, ...]
    ambiguity: Array | None = None

    def value(self, name: str) -> float:
        """Value of the unknown of that name."""
        return float(self.values[self.problem.names.index(name)])

    def stderr(self, name: str) -> float:
        """Standard error of the unknown of that name from the covariance."""
        index = self.problem.names.index(name)
        return math.sqrt(max(float(self.covariance[index, index]), 0.0))


@dataclass(frozen=True)
class _Point:
    """Everything at one set of values: normal matrix, gradient, cost."""

    normal: Array
    gradient: Array
    cost: float
    chi2: float
    residuals: tuple[Array, ...]
    jacobians: tuple[Array, ...]
    used: tuple[np.ndarray, ...]


@np.errstate(over="ignore", invalid="ignore")
def _evaluate(problem: Problem, values: Array, above: float = math.inf) -> _Point | None:
    """Everything at ``values``; None where a motion leaves every bound, or as soon as the cost is known to be
    ``above`` what stands."""
    size = len(problem.unknowns)
    centres, precision = problem.believed
    away = values - centres
    asked = float(precision @ away**2)
    normal, gradient = np.zeros((size, size)), np.zeros(size)
    chi2 = 0.0
    all_r, all_j, all_used = [], [], []
    for trial in problem.trials:
        got = residuals(trial, values)
        if got is None:
            return None
        r, jac, used = got
        square, slope, size_of_r = jac.T @ jac, jac.T @ r, float(r @ r)
        if not (np.isfinite(square).all() and np.isfinite(slope).all() and math.isfinite(size_of_r)):
            return None  # a motion that all but leaves every bound: no place to step from
        normal[used[:, None], used] += square
        gradient[used] += slope
        chi2 += size_of_r
        if chi2 + asked > above:
            return None
        all_r.append(r)
        all_j.append(jac)
        all_used.append(used)
    normal[np.diag_indices(size)] += precision
    gradient += precision * away
    cost = chi2 + asked
    if not math.isfinite(cost):
        return None
    return _Point(normal, gradient, cost, chi2, tuple(all_r), tuple(all_j), tuple(all_used))


@dataclass(frozen=True)
class SearchEffort:
    """How far a search goes: at most so many iterations a window, and the step in standard errors at which it stops.

    ``as_left``: standard errors by the size of the residuals that are left, where that is above the noise; the search
    also ends with a step that gains no more than that. ``steps_a_period``: those of a decay's integrator.
    """

    iterations: int = MAX_ITERATIONS
    stop_in_stderr: float = STOP_IN_STDERR
    as_left: bool = False
    steps_a_period: int = TRAJECTORY_STEPS_PER_PERIOD

    @property
    def thorough(self) -> bool:
        """Whether what ends far from the recordings is tried again from its start, on the whole record at once."""
        return self.iterations >= MAX_ITERATIONS


FULL = SearchEffort()
QUICK = SearchEffort(10, 0.05, steps_a_period=18)
"""Enough to tell a good start from a bad one; motions are within 1e-5 of the release."""

CLOSE = SearchEffort(stop_in_stderr=0.01)
"""Enough to compare models: a hundredth of a standard error changes a log evidence by 1e-4."""

COARSE = SearchEffort(stop_in_stderr=0.05, as_left=True, steps_a_period=24)
"""Enough to find what noise a model leaves: followed to where it comes to rest; motions within 3e-6 of the release."""


def _search(problem: Problem, values: Array, effort: SearchEffort = FULL) -> Descent[_Point]:
    """Levenberg-Marquardt from ``values``; IdentificationError where the start itself has no bounds."""
    lower, upper = problem.bounds
    values = np.clip(values, lower, upper)
    trials = tuple(
        trial if trial.steps_a_period == effort.steps_a_period else replace(trial, steps_a_period=effort.steps_a_period)
        for trial in problem.trials
    )
    problem = Problem(problem.unknowns, trials)
    point = _evaluate(problem, values)
    if point is None:
        names = [trial.name for trial in problem.trials if residuals(trial, values) is None]
        raise IdentificationError(
            f"output error cannot start: the equation's motion leaves every bound for {_some(names)}; set "
            "trials.window, exclude what is no decay, or leave out a term"
        )
    proved = effort.stop_in_stderr <= STOP_IN_STDERR
    rule = Rule(effort.iterations, effort.stop_in_stderr, FIRST_DAMPING, proved=proved)
    evaluate = partial(_evaluate, problem)
    if not effort.as_left:
        return descend(evaluate, values, point, (lower, upper), rule)
    count = sum(r.size for r in point.residuals)
    return descend(evaluate, values, point, (lower, upper), rule, lambda place: max(1.0, place.cost / count))


def fit(
    problem: Problem,
    start: Array | None = None,
    growing: bool = True,
    effort: SearchEffort = FULL,
) -> Solution:
    """The best values of all unknowns.

    ``start`` (p,) replaces the unknowns' own starts (priors stay where they are); ``growing`` begins with one period
    of motion and doubles the window up to the whole.

    Raises IdentificationError where the start's motion leaves every bound.
    """
    values = np.array([u.start for u in problem.unknowns]) if start is None else np.array(start, dtype=np.float64)
    windows = growing_windows(problem) if growing else []
    if sheet.is_plain(problem):
        solution = _compiled(problem, values, windows, effort)
        if solution is not None:
            return solution
    iterations, first = 0, values
    try:
        for window in windows:
            reached = _search(shortened(problem, window), values, effort)
            values, iterations = reached.values, iterations + reached.iterations
        end = _search(problem, values, effort)
    except IdentificationError:
        if values is first:
            raise
        end = _search(problem, first, effort)  # what fits a window ran away in the next
    iterations += end.iterations
    n_data = sum(r.size for r in end.place.residuals)
    if growing and effort.thorough and (not end.converged or end.place.chi2 > POOR_FIT * n_data):
        second = _search(problem, first, effort)
        iterations += second.iterations
        end = second if second.place.cost < end.place.cost else end
    return _solution(problem, end.values, end.place, iterations, end.converged)


def _compiled(problem: Problem, values: Array, windows: list[float], effort: SearchEffort) -> Solution | None:
    """The fit of a plain problem in one compiled call; None where the search in Python has to find the way."""
    limits = (effort.iterations, effort.stop_in_stderr, FIRST_DAMPING)
    found = sheet.search(problem, values, np.array([*windows, math.inf]), *limits)
    if found is None:
        return None
    n_data = sum([r.size for r in found.residuals])
    if windows and effort.thorough and (not found.converged or found.chi2 > POOR_FIT * n_data):
        second = sheet.search(problem, values, np.array([math.inf]), *limits)
        if second is not None and second.cost < found.cost:
            found = second
    return _solution(problem, found.values, found, found.iterations, found.converged)


def _some(names: list[str]) -> str:
    """The first of some trials' names, and how many more there are."""
    shown = ", ".join(names[:NAMES_AT_MOST]) or "all trials together"
    more = len(names) - NAMES_AT_MOST
    return f"{shown} and {more} more" if more > 0 else shown


def _solution(
    problem: Problem, values: Array, point: _Point | sheet.Found, iterations: int, converged: bool
) -> Solution:
    bounds = zip(problem.unknowns, values.tolist(), strict=True)
    known = point.inverse if isinstance(point, sheet.Found) else None
    if known is not None and all([u.lower < value < u.upper for u, value in bounds]):
        covariance, outcome = known, OK
    else:
        covariance, outcome = _with_care(problem, values, point.normal)
    if not converged:
        outcome = f"did not converge in {iterations} iterations"
    return Solution(
        problem, values, covariance, point.cost, point.chi2, sum([r.size for r in point.residuals]), iterations,
        outcome, point.residuals, point.jacobians, point.used,
    )  # fmt: skip


def _with_care(problem: Problem, values: Array, normal: Array) -> tuple[Array, str]:
    """Covariance and outcome where unknowns may stand on bounds or hardly be known."""
    lower, upper = problem.bounds
    on_bound = (values <= lower) | (values >= upper)
    free = np.flatnonzero(~on_bound)
    inner = normal[np.ix_(free, free)]
    scale = 1.0 / np.sqrt(np.maximum(inner.diagonal(), LEAST_INFORMATION))
    eigenvalues, directions = np.linalg.eigh(inner * scale[:, None] * scale)
    sizes = np.abs(eigenvalues)
    known = sizes > NO_INFORMATION * sizes.max(initial=0.0)
    root = directions[:, known] * scale[:, None]
    covariance = np.zeros_like(normal)
    covariance[np.ix_(free, free)] = (root / eigenvalues[known]) @ root.T
    if free.size < values.size:
        names = ", ".join(f"{problem.names[i]} = {values[i]:.4g}" for i in np.flatnonzero(on_bound))
        return covariance, f"on a bound: {names}"
    if eigenvalues[0] < 1e-10 * eigenvalues[-1]:
        worst = [problem.names[i] for i in np.argsort(-np.abs(directions[:, 0]))[:3]]
        return covariance, f"not identifiable from these trials: {', '.join(worst)} move together"
    return covariance, OK
