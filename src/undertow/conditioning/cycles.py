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


def equilibrium(cycles: Cycles, friction_halfwidth: float = 0.0) -> Estimate:
    """Where the oscillation is centred, in the sensor's scale, m: mean of (p1 + 2 p2 + p3) / 4 over turning points.

    That combination is free of the amplitude and of a constant loss a half cycle (Coulomb friction shifts the centre
    of each half cycle by +-x_f, alternately). The standard error comes from the values' own scatter, with the turning
    points' errors as its least. ``friction_halfwidth`` (mu N / k) is added where a body's rest, not its centre, counts.
    """
    p = cycles.position
    centres = 0.25 * (p[:-2] + 2.0 * p[1:-1] + p[2:])
    weights = 1.0 / (cycles.amplitude[:-1] + float(np.min(cycles.amplitude)) + 1e-300)
    value = float(np.sum(weights * centres) / np.sum(weights))
    scatter = math.sqrt(float(np.sum(weights * (centres - value) ** 2) / np.sum(weights)))
    least = float(np.median(cycles.position_std)) * math.sqrt(6.0) / 4.0
    error = max(scatter / math.sqrt(max(centres.size / 2.0, 1.0)), least / math.sqrt(centres.size))
    return Estimate(value, math.hypot(error, friction_halfwidth), unit="m", source="centre of the oscillation")
