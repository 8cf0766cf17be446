"""Output error: the parameters whose simulated motion lies closest to what the sensors said.

Levenberg-Marquardt on the compiled trajectories with their exact sensitivities, all trials and channels together,
weighted by noise, with priors on nuisances and on random effects; first on a short window, then on longer ones, so
that a wrong start cannot lock on to a wrong phase. Source: Maine and Iliff 1985 (NASA RP 1138) for output error;
report Method 1 for the trajectory fit.

Belongs here: residuals, Jacobian, search. Does not belong here: what is fitted (problem.py), intervals (intervals.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from undertow.equation.general import general_trajectory
from undertow.equation.input import Drive
from undertow.equation.kernel import SLOT, integrate
from undertow.equation.simulate import fastest_frequency
from undertow.errors import IdentificationError
from undertow.likelihood import eq15 as sheet
from undertow.likelihood.budget import spend
from undertow.likelihood.eq15 import unknowns_of
from undertow.likelihood.observation_model import instants, signal
from undertow.likelihood.problem import TRAJECTORY_STEPS_PER_PERIOD, Channel, Problem, TrialProblem
from undertow.likelihood.windows import growing_windows, shortened
from undertow.quantities import OK
from undertow.recording.recording import Array

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

NO_INFORMATION = 1e-15
"""Share of the largest eigenvalue of the scaled normal matrix below which a direction is rounding: left out."""


@dataclass(frozen=True)
class Solution:
    """Where the search ended: ``values`` and ``covariance`` of the unknowns (noise as stated, priors included).

    ``cost`` is the sum of squared weighted residuals and prior terms, ``chi2`` without priors; ``residuals`` one array
    a trial, channels one after the other, in units of their noise; ``jacobians`` likewise (n, p), p in ``used``.
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

    def value(self, name: str) -> float:
        """Value of the unknown of that name."""
        return float(self.values[self.problem.names.index(name)])

    def stderr(self, name: str) -> float:
        """Standard error of the unknown of that name from the covariance."""
        index = self.problem.names.index(name)
        return math.sqrt(max(float(self.covariance[index, index]), 0.0))


def parameter_vector(trial: TrialProblem, values: Array) -> Array:
    """The integrator's parameter vector of one trial at the unknowns' values."""
    theta = trial.base.copy()
    for link in trial.links:
        theta[link.slot] += link.factor * values[link.unknown]
    return theta


def trajectory(
    theta: Array, slots: np.ndarray, times: Array, steps_per_period: int = TRAJECTORY_STEPS_PER_PERIOD
) -> tuple[Array, Array, Array]:
    """x, v, a, each (n, 1 + p), of a parameter vector at ``times`` (n,): motion and derivatives by ``slots`` (p,).

    Raises IdentificationError where the total mass is not positive or the motion leaves every bound.
    """
    mass = float(theta[SLOT["mass"]])
    if not mass > 0.0 or not np.all(np.isfinite(theta)):
        raise IdentificationError(f"a trajectory needs a positive total mass and finite parameters, got {mass:g} kg")
    step = 2.0 * math.pi / fastest_frequency(theta) / steps_per_period
    x, v, a, _, count = integrate(theta, slots, np.array(times, dtype=np.float64), step)
    spend(abs(count) * (1.0 + slots.size))
    if count < 0:
        raise IdentificationError(
            f"the motion leaves every bound after {-count} steps; a coefficient has the wrong sign"
        )
    return x, v, a


def _integrate(
    trial: TrialProblem, values: Array, times: Array, slots: np.ndarray
) -> tuple[Array, Array, Array] | None:
    """The trajectory, or None where there is none: a search step that went too far, not an error."""
    try:
        theta = parameter_vector(trial, values)
        if trial.drive is not None:
            return _driven(trial, trial.drive, theta, slots, times)
        return general_trajectory(theta, trial.laws, slots, times) if trial.laws else trajectory(theta, slots, times)
    except IdentificationError:
        return None


def _driven(
    trial: TrialProblem, drive: Drive, theta: Array, slots: np.ndarray, times: Array
) -> tuple[Array, Array, Array]:
    """The motion under a measured input; its integrator is compiled where the first driven trial is."""
    from undertow.equation.driven import driven_motion

    motion = driven_motion(theta, slots, drive, times, trial.extent)
    spend(motion.steps * (1.0 + slots.size))
    return motion.x, motion.v, motion.a


def residuals(trial: TrialProblem, values: Array) -> tuple[Array, Array, np.ndarray] | None:
    """Weighted residuals (n,), their Jacobian (n, p) and the indices (p,) of the unknowns it belongs to; None where
    the motion leaves every bound."""
    slots = trial.slots
    shift = values[trial.shift] if trial.shift >= 0 else 0.0
    times = instants(trial)[0] + shift
    rows = [_grid(times, channel, values) for channel in trial.channels]
    merged, orders = _merge(rows)
    since = merged if trial.drive is not None else np.maximum(merged, 0.0)
    motion = _integrate(trial, values, since, slots)
    if motion is None:
        return None
    used, column = _columns(trial)
    n = trial.t.size
    r = np.empty(n * len(trial.channels))
    jac = np.zeros((r.size, used.size))
    theta = parameter_vector(trial, values)
    for i, channel in enumerate(trial.channels):
        at = slice(i * n, (i + 1) * n)
        own = (motion[0][orders[i]], motion[1][orders[i]], motion[2][orders[i]])
        seen = signal(trial, channel.quantity, own, rows[i], theta, slots)
        r[at] = _one_channel(trial, channel, seen, values, jac[at], column, slots)
    return r, jac, used


def _grid(times: Array, channel: Channel, values: Array) -> Array:
    return times + values[channel.shift] if channel.shift >= 0 else times


def _merge(rows: list[Array]) -> tuple[Array, list[np.ndarray | slice]]:
    """One rising time grid for all channels, and where each channel's instants stand in it."""
    first = rows[0]
    if all(row is first for row in rows) and not np.any(np.diff(first) < 0.0):
        return first, [slice(None)] * len(rows)
    every = np.concatenate(rows)
    order = np.argsort(every, kind="stable")
    place = np.empty(order.size, dtype=np.int64)
    place[order] = np.arange(order.size)
    return every[order], [place[i * first.size : (i + 1) * first.size] for i in range(len(rows))]


def _columns(trial: TrialProblem) -> tuple[np.ndarray, dict[int, int]]:
    used = unknowns_of(trial)
    return used, {int(j): c for c, j in enumerate(used)}


def _one_channel(
    trial: TrialProblem,
    channel: Channel,
    seen: tuple[Array, Array],
    values: Array,
    jac: Array,
    column: dict[int, int],
    slots: np.ndarray,
) -> Array:
    """Weighted residual of one channel; fills its rows of the Jacobian."""
    level_and_slopes, rate = seen
    gain = 1.0 + (values[channel.gain] if channel.gain >= 0 else 0.0)
    level = level_and_slopes[:, 0]
    predicted = gain * level
    weight = 1.0 / channel.sigma
    place = {int(slot): c for c, slot in enumerate(slots)}
    for link in trial.links:
        jac[:, column[link.unknown]] += (link.factor * gain * weight) * level_and_slopes[:, 1 + place[link.slot]]
    for index in (trial.shift, channel.shift):
        if index >= 0:
            jac[:, column[index]] += gain * weight * rate
    if channel.offset >= 0:
        predicted = predicted + values[channel.offset]
        jac[:, column[channel.offset]] += weight
    if channel.drift >= 0:
        line = (trial.t - trial.t[0]) / (trial.t[-1] - trial.t[0]) - 0.5
        predicted = predicted + values[channel.drift] * line
        jac[:, column[channel.drift]] += weight * line
    if channel.gain >= 0:
        jac[:, column[channel.gain]] += weight * level
    return (predicted - channel.values) * weight


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


def _evaluate(problem: Problem, values: Array, above: float = math.inf) -> _Point | None:
    """Everything at ``values``; None where a motion leaves every bound, or as soon as the cost is known to be
    ``above`` what stands."""
    size = len(problem.unknowns)
    precision = np.array([1.0 / u.prior_std**2 for u in problem.unknowns])
    away = values - np.array([u.start for u in problem.unknowns])
    with np.errstate(over="ignore", invalid="ignore"):
        asked = float(precision @ away**2)
    normal, gradient = np.zeros((size, size)), np.zeros(size)
    chi2 = 0.0
    all_r, all_j, all_used = [], [], []
    for trial in problem.trials:
        with np.errstate(over="ignore", invalid="ignore"):
            got = residuals(trial, values)
            if got is None:
                return None
            r, jac, used = got
            square, slope, size_of_r = jac.T @ jac, jac.T @ r, float(r @ r)
        if not (np.all(np.isfinite(square)) and np.all(np.isfinite(slope)) and math.isfinite(size_of_r)):
            return None  # a motion that all but leaves every bound: no place to step from
        normal[np.ix_(used, used)] += square
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


def _bounds(problem: Problem) -> tuple[Array, Array]:
    return np.array([u.lower for u in problem.unknowns]), np.array([u.upper for u in problem.unknowns])


def _step(point: _Point, damping: float, free: np.ndarray, scale: Array) -> Array:
    """Damped Gauss-Newton step of the unknowns that are free to move."""
    step = np.zeros(point.gradient.size)
    index = np.flatnonzero(free)
    s = scale[index]
    a = point.normal[np.ix_(index, index)] * np.outer(s, s)
    diagonal = np.maximum(np.diag(a), 1e-30)
    a[np.diag_indices(index.size)] += damping * diagonal
    try:
        step[index] = -s * np.linalg.solve(a, s * point.gradient[index])
    except np.linalg.LinAlgError:
        a[np.diag_indices(index.size)] += 1e-9 * diagonal
        step[index] = -s * np.linalg.lstsq(a, s * point.gradient[index], rcond=None)[0]
    return step


@dataclass(frozen=True)
class SearchEffort:
    """How far a search goes: at most so many iterations a window, and the step in standard errors at which it stops."""

    iterations: int = MAX_ITERATIONS
    stop_in_stderr: float = STOP_IN_STDERR


FULL = SearchEffort()
QUICK = SearchEffort(12, 0.05)
"""Enough to tell a good start from a bad one."""


def _search(problem: Problem, values: Array, effort: SearchEffort = FULL) -> tuple[Array, _Point, int, bool]:
    """Levenberg-Marquardt from ``values``; IdentificationError where the start itself has no bounds."""
    lower, upper = _bounds(problem)
    values = np.clip(values, lower, upper)
    point = _evaluate(problem, values)
    if point is None:
        names = [trial.name for trial in problem.trials if residuals(trial, values) is None]
        raise IdentificationError(
            f"output error cannot start: the equation's motion leaves every bound for {_some(names)}; set "
            "trials.window, exclude what is no decay, or leave out a term"
        )
    damping = FIRST_DAMPING
    for iteration in range(1, effort.iterations + 1):
        scale = 1.0 / np.sqrt(np.maximum(np.diag(point.normal), 1e-300))
        pinned = ((values <= lower) & (point.gradient > 0.0)) | ((values >= upper) & (point.gradient < 0.0))
        step = _step(point, damping, ~pinned, scale)
        trial_values = np.clip(values + step, lower, upper)
        moved = np.abs(trial_values - values) / scale
        candidate = _evaluate(problem, trial_values, point.cost * (1.0 + 1e-14))
        if candidate is not None:
            gained = point.cost - candidate.cost
            values, point = trial_values, candidate
            damping = max(damping * 0.1, 1e-15)
            if np.max(moved) < effort.stop_in_stderr or gained < 1e-10 * point.cost:
                return values, point, iteration, True
        else:
            if np.max(moved) < effort.stop_in_stderr:
                return values, point, iteration, True
            damping = max(damping * 8.0, 1e-6)
            if damping > 1e12:
                return values, point, iteration, True
    return values, point, effort.iterations, False


def fit(
    problem: Problem,
    start: Array | None = None,
    growing: bool = True,
    progress: Callable[[str], None] | None = None,
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
            values, _, count, _ = _search(shortened(problem, window), values, effort)
            iterations += count
            if progress is not None:
                progress(f"window {window:.3g} s")
        values, point, count, converged = _search(problem, values, effort)
    except IdentificationError:
        if values is first:
            raise
        values, point, count, converged = _search(problem, first, effort)  # what fits a window ran away in the next
    iterations += count
    n_data = sum(r.size for r in point.residuals)
    if growing and effort is FULL and (not converged or point.chi2 > POOR_FIT * n_data):
        second = _search(problem, first)
        iterations += second[2]
        if second[1].cost < point.cost:
            values, point, _, converged = second
    return _solution(problem, values, point, iterations, converged)


def _compiled(problem: Problem, values: Array, windows: list[float], effort: SearchEffort) -> Solution | None:
    """The fit of a plain problem in one compiled call; None where the search in Python has to find the way."""
    limits = (effort.iterations, effort.stop_in_stderr, FIRST_DAMPING)
    found = sheet.search(problem, values, np.array([*windows, math.inf]), *limits)
    if found is None:
        return None
    n_data = sum([r.size for r in found.residuals])
    if windows and effort is FULL and (not found.converged or found.chi2 > POOR_FIT * n_data):
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
    lower, upper = _bounds(problem)
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
