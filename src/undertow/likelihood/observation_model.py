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
recorded (lone_samples.py).

Belongs here: instants at which a trial's motion is needed, signals, their rates of change and sensitivities. Does not
belong here: weights, nuisances, the search (output_error.py), the compiled twin of this (eq15_rows.py).
"""

from __future__ import annotations

import math

import numpy as np

from undertow.equation.general import spring_force
from undertow.likelihood.problem import TrialProblem
from undertow.recording.recording import Array

EVEN = 1e-4
"""Cells whose centres are a cell's width apart within this share of it share their edges."""

Motion3 = tuple[Array, Array, Array]


def edges_are_shared(trial: TrialProblem) -> bool:
    """Whether each cell ends where the next one begins: no gap, and an even clock."""
    return bool(np.all(np.abs(np.diff(trial.t) - trial.width_s) <= EVEN * trial.width_s))


def instants(trial: TrialProblem) -> tuple[Array, int]:
    """Instants (k,) s at which a trial's motion is needed, and how far apart two cells' beginnings stand in them.

    Lone instants: themselves, 0. Cells: n + 1 edges, 1, where they touch; else beginnings and ends in turns, 2.
    """
    half = 0.5 * trial.width_s
    if half <= 0.0:
        return trial.t, 0
    if edges_are_shared(trial):
        return np.append(trial.t - half, trial.t[-1] + half), 1
    return np.column_stack([trial.t - half, trial.t + half]).ravel(), 2


@np.errstate(invalid="ignore", over="ignore")
def signal(
    trial: TrialProblem, quantity: str, motion: Motion3, times: Array, theta: Array, slots: np.ndarray
) -> tuple[Array, Array]:
    """What a channel sees, (n, 1 + p) with sensitivities by ``slots`` (p,), and its rate of change (n,), SI.

    ``motion`` is x, v, a, each (k, 1 + p), at ``times`` (k,), which are the trial's `instants` by the channel's own
    clock; before the release, at 0, the body is held. Of a motion that leaves every bound the values are not finite.
    """
    if trial.width_s <= 0.0:
        return _at_samples(trial, quantity, motion, theta, slots)
    x, v, a = motion
    stride, width = (1 if times.size == trial.t.size + 1 else 2), trial.width_s
    begin, end = slice(0, times.size - 1, stride), slice(1, None, stride)
    if quantity == "acceleration":
        free = np.where((times >= 0.0)[:, None], a, 0.0)
        rate = (free[end, 0] - free[begin, 0]) / width
        mean = (v[end] - v[begin]) / width
        if trial.averaged:
            return mean, rate
        turns = v[begin, :1] * v[end, :1] <= 0.0
        return np.where(turns, mean * swell(trial), 1.5 * mean - 0.25 * (free[begin] + free[end])), rate
    moved = (x[end] - x[begin]) / width
    if quantity == "velocity":
        if not trial.averaged:
            moved = 1.5 * moved - 0.25 * (v[begin] + v[end])
        return moved, (v[end, 0] - v[begin, 0]) / width
    place = (_mean if trial.averaged else _middle)(times, begin, end, width, x, v)
    rate = moved[:, 0]
    return spring_force(theta, slots, place, rate) if quantity == "spring_force" else (place, rate)


def swell(trial: TrialProblem) -> float:
    """By what an acceleration's mean over one sample's step is enlarged to be about the acceleration; 1 in cells."""
    return 1.0 if trial.averaged else 1.0 + (2.0 * math.pi / trial.period_s * trial.width_s) ** 2 / 24.0


def _mean(times: Array, begin: slice, end: slice, width: float, x: Array, v: Array) -> Array:
    """Mean displacement of each cell, of which what lies before the release is held, (n, 1 + p)."""
    free = np.maximum(times, 0.0)
    span = (free[end] - free[begin])[:, None]
    area = 0.5 * span * (x[begin] + x[end]) - span**2 / 12.0 * (v[end] - v[begin])
    mean: Array = (area + (width - span) * x[begin]) / width
    return mean


def _middle(times: Array, begin: slice, end: slice, width: float, x: Array, v: Array) -> Array:
    """Displacement in the middle of each step, (n, 1 + p)."""
    free = np.maximum(times, 0.0)
    span = (free[end] - free[begin])[:, None]
    place = np.maximum(times[begin] + 0.5 * width, 0.0)[:, None] - free[begin][:, None]
    s = place / np.maximum(span, np.finfo(float).tiny)
    rest = 1.0 - s
    bend = span * s * rest * (v[begin] * rest - v[end] * s)
    middle: Array = x[begin] * rest**2 * (1.0 + 2.0 * s) + x[end] * s**2 * (1.0 + 2.0 * rest) + bend
    return middle


def _at_samples(
    trial: TrialProblem, quantity: str, motion: Motion3, theta: Array, slots: np.ndarray
) -> tuple[Array, Array]:
    """Signal and rate at the samples themselves."""
    x, v, a = motion
    if quantity == "velocity":
        return v, a[:, 0]
    if quantity == "acceleration":
        return a, np.gradient(a[:, 0], trial.t)
    return spring_force(theta, slots, x, v[:, 0]) if quantity == "spring_force" else (x, v[:, 0])
