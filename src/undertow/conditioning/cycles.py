"""Cycles of a decay: turning points, amplitude, frequency and decrement from half cycle to half cycle.

Belongs here: numbers per cycle. Does not belong here: fits through them (methods/decay.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from undertow.errors import RecordingError
from undertow.quantities import Estimate
from undertow.recording.recording import Array

LOSS, VARIES = (0.85, 0.6), 0.2
"""Share of b, mean and standard deviation: 0 for friction, 1 for linear damping, 1.7 for drag; and by how much it may
be another one from swing to swing, as where more than one of them takes energy."""


@dataclass(frozen=True)
class Cycles:
    """Turning points of one decay, (n,) each: ``time`` s after the release, ``position`` m in the sensor's scale,
    ``position_std``; and between neighbours: ``amplitude`` (n-1,) half the swing (free of the rest position),
    ``frequency_hz`` (n-1,), ``decrement`` (n-2,) of amplitude a full cycle."""

    time: Array
    position: Array
    position_std: Array
    amplitude: Array
    frequency_hz: Array
    decrement: Array


def find_cycles(t: Array, x: Array, v: Array, x_std: Array) -> Cycles:
    """Cycles of smoothed x, v (n,) at t (n,): turning points where v changes sign, by a straight line through v.

    Raises RecordingError with fewer than three turning points.
    """
    at = np.flatnonzero(v[:-1] * v[1:] < 0.0)
    share = v[at] / (v[at] - v[at + 1])
    step = t[at + 1] - t[at]
    time = t[at] + share * step
    position = x[at] + 0.5 * v[at] * share * step
    keep = np.concatenate([[True], np.diff(time) > 0.25 * np.median(np.diff(time))]) if time.size > 2 else time >= 0.0
    time, position, std = time[keep], position[keep], x_std[at][keep]
    if time.size < 3:
        raise RecordingError(
            f"{time.size} turning points in the motion window of {t[-1] - t[0]:.3g} s; a decay needs 3: "
            "widen trials.window"
        )
    amplitude = 0.5 * np.abs(np.diff(position))
    frequency = 0.5 / np.diff(time)
    decrement = 2.0 * np.log(amplitude[:-1] / np.maximum(amplitude[1:], 1e-300))
    return Cycles(time, position, std, amplitude, frequency, decrement)


def equilibrium(cycles: Cycles) -> Estimate:
    """Where the oscillation is centred, in the sensor's scale, m, by each three turning points in a row.

    (p1 + 2 p2 + p3) / 4 is free of the amplitude and of a constant loss a half cycle (Coulomb friction shifts the
    centre of each half cycle by +-x_f, alternately). It is off by b = (p1 - p3)^2 / (4 (p1 - 2 p2 + p3)) where the
    loss goes with the swing (linear damping: Aitken's extrapolation), by some 1.7 b where it goes with the swing's
    square (drag); of a body damped by a quarter of critical b is a fifteenth of the swing. Centre and share of b are
    found together: b has another sign every time, and of few swings `LOSS` is believed of the share. The standard error
    holds what the share is not known, the values' own scatter, and the turning points' errors as its least.
    """
    p = cycles.position
    centres = 0.25 * (p[:-2] + 2.0 * p[1:-1] + p[2:])
    turned = p[:-2] - 2.0 * p[1:-1] + p[2:]
    bent = 0.25 * (p[:-2] - p[2:]) ** 2 / np.where(turned == 0.0, 1e-300, turned)
    weights = 1.0 / (cycles.amplitude[:-1] + float(np.min(cycles.amplitude)) + 1e-300)
    weights /= float(np.mean(weights))
    least = max(float(np.median(cycles.position_std)) * math.sqrt(6.0) / 4.0, 1e-12 * float(np.ptp(p)))
    error, found = least, np.zeros(2)
    design = np.column_stack([np.ones(p.size - 2), bent])
    for _ in range(2):  # the scatter is that beside what the first pass found
        found, variance = _believing(design, centres, 1.0 / (error**2 / weights + (VARIES * bent) ** 2))
        left = centres - found[0] - found[1] * bent
        error = max(math.sqrt(float(np.mean(weights * left**2))), least)
    shared = 2.0 if centres.size > 1 else 1.0  # neighbours have turning points in common
    stderr = math.sqrt(shared * variance)
    return Estimate(float(found[0]), stderr, unit="m", source="centre of the oscillation")


def _believing(design: Array, values: Array, weights: Array) -> tuple[Array, float]:
    """Least squares for the centre and the share of b, which is believed to be `LOSS`; the centre's variance."""
    share, width = LOSS
    normal = (design.T * weights) @ design + np.diag([0.0, 1.0 / width**2])
    inverse = np.linalg.inv(normal)
    return inverse @ (design.T @ (weights * values) + np.array([0.0, share / width**2])), float(inverse[0, 0])
