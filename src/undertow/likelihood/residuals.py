"""What a trial's channels say against a motion: weighted residuals with their exact derivatives.

The one builder of them: whoever fits or compares trajectories takes its rows from here (the compiled twin for Eq. 15,
eq15_rows.py, is held to it by a test).

Belongs here: parameter vectors, trajectories, residuals, Jacobian. Does not belong here: what a channel sees of a
motion (observation_model.py), the search (output_error.py, descent.py).
"""

from __future__ import annotations

import numpy as np

from undertow.equation.general import general_trajectory
from undertow.equation.input import Drive
from undertow.equation.kernel import SLOT, integrate
from undertow.equation.simulate import step_of_motion
from undertow.errors import IdentificationError
from undertow.likelihood.budget import spend
from undertow.likelihood.eq15 import unknowns_of
from undertow.likelihood.observation_model import instants, signal
from undertow.likelihood.problem import TRAJECTORY_STEPS_PER_PERIOD, Channel, TrialProblem
from undertow.recording.recording import Array

MOST_STIFFENED = 100.0
"""What would swing so many times as fast as the body was seen to is no motion of it: a step of a search that went to
metres and 10^5 m/s took as long as all others, and more than a level may spend."""


def parameter_vector(trial: TrialProblem, values: Array) -> Array:
    """The integrator's parameter vector of one trial at the unknowns' values."""
    theta = trial.base.copy()
    for link in trial.links:
        theta[link.slot] += link.factor * values[link.unknown]
    return theta


def trajectory(
    theta: Array, slots: np.ndarray, times: Array, steps_per_period: int = TRAJECTORY_STEPS_PER_PERIOD,
    shortest: float = 0.0,
) -> tuple[Array, Array, Array]:
    """x, v, a, each (n, 1 + p), of a parameter vector at ``times`` (n,): motion and derivatives by ``slots`` (p,).

    Raises IdentificationError where the total mass is not positive, something swings so fast that steps would be
    shorter than ``shortest`` (s), or the motion leaves every bound.
    """
    mass = float(theta[SLOT["mass"]])
    if not mass > 0.0 or not np.all(np.isfinite(theta)):
        raise IdentificationError(f"a trajectory needs a positive total mass and finite parameters, got {mass:g} kg")
    step = step_of_motion(theta, steps_per_period)
    if step < shortest:
        raise IdentificationError(f"something swings so fast that steps are {step:.3g} s, below {shortest:.3g} s")
    x, v, a, _, count = integrate(theta, slots, np.array(times, dtype=np.float64), step)
    spend(abs(count) * (1.0 + slots.size))
    if count < 0:
        raise IdentificationError(
            f"the motion leaves every bound after {-count} steps; a coefficient has the wrong sign"
        )
    return x, v, a


def motion_of(trial: TrialProblem, values: Array, times: Array) -> tuple[Array, Array, Array]:
    """x, v, a, each (n, 1 + p), of a trial at the unknowns' values and ``times`` (n,): by the integrator that knows its
    laws. Raises IdentificationError where the motion leaves every bound."""
    theta, slots = parameter_vector(trial, values), trial.slots
    if trial.drive is not None:
        return _driven(trial, trial.drive, theta, slots, times)
    if trial.laws:
        return general_trajectory(theta, trial.laws, slots, times)
    shortest = trial.period_s / MOST_STIFFENED / trial.steps_a_period
    return trajectory(theta, slots, times, trial.steps_a_period, shortest)


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
    try:
        motion = motion_of(trial, values, since)
    except IdentificationError:  # a step of a search that went too far, not an error
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
    residual = (predicted - channel.values) * weight
    if channel.unsure is not None:
        residual[channel.unsure], jac[channel.unsure] = 0.0, 0.0
    return residual
