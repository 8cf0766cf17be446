"""What a channel sees of a motion: in cells its mean over the cell, at single samples the motion there.

A cell holds the mean of its samples, and the model is compared with the mean of its motion over the same span. The mean
of a velocity is a difference of displacements, that of an acceleration a difference of velocities, so that both are
exact, and neither jumps when a reversal (where friction changes its sign, and the acceleration with it) passes from one
cell into the next. Between a cell's edges a displacement is the cubic of its values and slopes there,

    mean x = (x_0 + x_1) / 2 - D (v_1 - v_0) / 12,   off by (w D)^4 / 720: 4e-7 of the motion at 50 cells a period.

Samples taken D / m apart have the mean of a cell D wide but for (w D / m)^2 / 24 of the motion, the same share in all
channels: under 2e-4 at 50 cells a period of two samples each. A sample on its own is compared with that cubic's middle,
an acceleration with that of the cubic through velocities and accelerations at its step's edges. A step in which the
body turns has a jump: there the mean over the step is taken, enlarged by 1 + (w D)^2 / 24, w the motion's frequency,
which is what a logger that smooths would see, so that a search meets no jumps. Where it ends lone samples are taken as
recorded (multistart.py).

Belongs here: signals, their rates of change and sensitivities, compiled in channel_rows.py. Does not belong here: the
instants at which a motion is needed (problem.py), weights, nuisances, the search (output_error.py), the twin of this on
Eq. 15's series (eq15_rows.py).
"""

from __future__ import annotations

import math

import numpy as np

from undertow.equation.general import spring_force
from undertow.likelihood.channel_rows import QUANTITIES, in_cells
from undertow.likelihood.problem import TrialProblem
from undertow.recording.recording import Array

Motion3 = tuple[Array, Array, Array]


def signal(
    trial: TrialProblem, quantity: str, motion: Motion3, times: Array, theta: Array, slots: np.ndarray,
    place: np.ndarray | None = None,
) -> tuple[Array, Array]:
    """What a channel sees, (n, 1 + p) with sensitivities by ``slots`` (p,), and its rate of change (n,), SI.

    ``motion`` is x, v, a, each (m, 1 + p); ``times`` (k,) the trial's instants by the channel's own clock, ``place``
    (k,) where they stand in the motion (None: all in order). Before the release, at 0, the body is held. Of a motion
    that leaves every bound the values are not finite, and numpy's warnings are the caller's.
    """
    at = np.arange(times.size) if place is None else place
    if trial.width_s <= 0.0:
        return _at_samples(trial, quantity, tuple(one[at] for one in motion), theta, slots)
    levels, rates = np.empty((trial.t.size, motion[0].shape[1])), np.empty(trial.t.size)
    seen = QUANTITIES.get(quantity, 0)
    in_cells(
        seen, trial.averaged, trial.instants[1], trial.width_s, swell(trial), np.ascontiguousarray(times), at,
        *(np.ascontiguousarray(one) for one in motion), levels, rates,
    )  # fmt: skip
    return spring_force(theta, slots, levels, rates) if quantity == "spring_force" else (levels, rates)


def swell(trial: TrialProblem) -> float:
    """By what an acceleration's mean over one sample's step is enlarged to be about the acceleration; 1 in cells."""
    return 1.0 if trial.averaged else 1.0 + (2.0 * math.pi / trial.period_s * trial.width_s) ** 2 / 24.0


def _at_samples(
    trial: TrialProblem, quantity: str, motion: tuple[Array, ...], theta: Array, slots: np.ndarray
) -> tuple[Array, Array]:
    """Signal and rate at the samples themselves."""
    x, v, a = motion
    if quantity == "velocity":
        return v, a[:, 0]
    if quantity == "acceleration":
        return a, np.gradient(a[:, 0], trial.t)
    return spring_force(theta, slots, x, v[:, 0]) if quantity == "spring_force" else (x, v[:, 0])
