"""What a trial's channels say against a motion: weighted residuals with their exact derivatives.

The one builder of them: whoever fits or compares trajectories takes its rows from here (the compiled twin for Eq. 15,
eq15_rows.py, is held to it by a test).

Belongs here: parameter vectors, trajectories, residuals, Jacobian. Does not belong here: what a channel sees of a
motion (observation_model.py), the search (output_error.py, descent.py).
"""

from __future__ import annotations

import numpy as np

from undertow.equation.general import general_trajectory
from undertow.equation.kernel import SLOT, integrate
from undertow.equation.simulate import step_of_motion
from undertow.errors import IdentificationError
from undertow.likelihood.budget import spend
from undertow.likelihood.channel_rows import weigh
from undertow.likelihood.observation_model import signal
from undertow.likelihood.problem import TRAJECTORY_STEPS_PER_PERIOD, TrialProblem
from undertow.recording.recording import Array

MOST_STIFFENED = 100.0
"""What would swing so many times as fast as the body was seen to is no motion of it: a step of a search that went to
metres and 10^5 m/s took as long as all others, and more than a level may spend."""


def parameter_vector(trial: TrialProblem, values: Array) -> Array:
    """The integrator's parameter vector of one trial at the unknowns' values."""
    theta = trial.base.copy()
    rows, factors = trial.linked
    np.add.at(theta, rows[:, 0], factors * values[rows[:, 1]])
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


def motion_of(trial: TrialProblem, theta: Array, times: Array) -> tuple[Array, Array, Array]:
    """x, v, a, each (n, 1 + p), of a trial with its parameter vector at ``times`` (n,): by the integrator that knows
    its laws. Raises IdentificationError where the motion leaves every bound."""
    slots = trial.slots
    if trial.drive is not None:
        from undertow.equation.driven import driven_motion  # compiled where the first driven trial is

        motion = driven_motion(theta, slots, trial.drive, times, trial.extent)
        spend(motion.steps * (1.0 + slots.size))
        return motion.x, motion.v, motion.a
    if trial.laws:
        return general_trajectory(theta, trial.laws, slots, times)
    shortest = trial.period_s / MOST_STIFFENED / trial.steps_a_period
    return trajectory(theta, slots, times, trial.steps_a_period, shortest)


@np.errstate(invalid="ignore", over="ignore")
def residuals(trial: TrialProblem, values: Array) -> tuple[Array, Array, np.ndarray] | None:
    """Weighted residuals (n,), their Jacobian (n, p) and the indices (p,) of the unknowns it belongs to; None where
    the motion leaves every bound."""
    shift = values[trial.shift] if trial.shift >= 0 else 0.0
    times = trial.instants[0] + shift
    rows = [times + values[channel.shift] if channel.shift >= 0 else times for channel in trial.channels]
    merged, orders = _merge(rows)
    since = merged if trial.drive is not None else np.maximum(merged, 0.0)
    theta = parameter_vector(trial, values)
    try:
        motion = motion_of(trial, theta, since)
    except IdentificationError:  # a step of a search that went too far, not an error
        return None
    n = trial.t.size
    r = np.empty(n * len(trial.channels))
    jac = np.empty((r.size, trial.used.size))
    for i, channel in enumerate(trial.channels):
        at = slice(i * n, (i + 1) * n)
        seen = signal(trial, channel.quantity, motion, rows[i], theta, trial.slots, orders[i])
        _one_channel(trial, i, seen, values, r[at], jac[at])
    return r, jac, trial.used


def _merge(rows: list[Array]) -> tuple[Array, list[np.ndarray | None]]:
    """One rising time grid for all channels, and where each channel's instants stand in it (None: in order)."""
    first = rows[0]
    if all(row is first for row in rows) and not np.any(first[1:] < first[:-1]):
        return first, [None] * len(rows)
    every = np.concatenate(rows)
    order = np.argsort(every, kind="stable")
    place = np.empty(order.size, dtype=np.int64)
    place[order] = np.arange(order.size)
    return every[order], [place[i * first.size : (i + 1) * first.size] for i in range(len(rows))]


def _one_channel(
    trial: TrialProblem, number: int, seen: tuple[Array, Array], values: Array, r: Array, jac: Array
) -> None:
    """Weighted residual (n,) of one channel and its rows (n, p) of the Jacobian, filled in."""
    channel = trial.channels[number]
    wanted = (channel.offset, channel.gain, *channel.drift)
    nuisances = np.array([values[j] if j >= 0 else 0.0 for j in wanted])
    rows, factors = trial.linked
    levels, rates = (np.ascontiguousarray(one) for one in seen)
    weigh(
        levels, rates, channel.data, trial.slow, rows, factors, trial.nuisance_columns[number], nuisances,
        1.0 / channel.sigma, r, jac,
    )  # fmt: skip
