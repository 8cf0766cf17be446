"""Where a mismatch is: when, at which frequency, at which amplitude.

Belongs here: measures of one trial's free-run residual. Does not belong here: what made it.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy.signal import periodogram

from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.discrepancy.mismatch import Mismatch
from undertow.likelihood.free_run import FreeRun, scored_channel
from undertow.recording.recording import Array

BODY_BAND = 0.15
"""Half width, relative to the body's own frequency, inside which a line counts as the body's own."""

SMALLEST_LINE_PERIODS = 3
"""A line is looked for from this many cycles in the window on: slower is drift."""


def locate(motion: Motion, run: FreeRun, floor: float, repeatability: float) -> Mismatch:
    """The mismatch of one trial's free run, with its place in time, frequency and amplitude.

    ``floor`` and ``repeatability`` are the two scores that the residual is held against (`freerun`).
    """
    noise = motion.noise.get(scored_channel(motion), 0.0)
    residual = run.residual
    early, middle, late = thirds(residual, noise)
    frequency, share = strongest_line(run.t, residual, 1.0 / dominant_period(motion), noise)
    return Mismatch(
        motion.name, run.nrmse, floor, repeatability, early, middle, late, frequency, share,
        amplitude_exponent(run, dominant_period(motion), noise),
    )  # fmt: skip


def thirds(residual: Array, noise: float) -> tuple[float, float, float]:
    """Fractions of the residual's variance above noise in the first, second and last third of the window.

    All nan where nothing is above noise.

    >>> thirds(np.r_[np.ones(10), np.zeros(20)], 0.0)
    (1.0, 0.0, 0.0)
    """
    parts = [max(float(np.sum(p**2)) - p.size * noise**2, 0.0) for p in np.array_split(residual, 3)]
    total = sum(parts)
    if total <= 0.0:
        return math.nan, math.nan, math.nan
    return parts[0] / total, parts[1] / total, parts[2] / total


def strongest_line(t: Array, residual: Array, body_hz: float, noise: float) -> tuple[float, float]:
    """Frequency (Hz) of the residual's strongest line that is not the body's own, and its share of the variance above
    noise; (nan, nan) where the window is too short for one.

    The share is that of the three bins around the peak of a Hann-windowed spectrum. Lines within `BODY_BAND` of the
    body's frequency, and slower than `SMALLEST_LINE_PERIODS` cycles in the window, are left out.
    """
    dt = float(np.median(np.diff(t)))
    span = float(t[-1] - t[0])
    even = np.interp(np.arange(t[0], t[-1], dt), t, residual)
    frequency, power = periodogram(even, 1.0 / dt, "hann", detrend="linear")
    allowed = (frequency >= SMALLEST_LINE_PERIODS / span) & (np.abs(frequency / body_hz - 1.0) > BODY_BAND)
    allowed &= frequency <= 10.0 * body_hz
    above = float(np.sum(power)) * (frequency[1] - frequency[0]) - noise**2
    if not np.any(allowed) or above <= 0.0:
        return math.nan, math.nan
    peak = int(np.flatnonzero(allowed)[np.argmax(power[allowed])])
    band = float(np.sum(power[max(peak - 1, 0) : peak + 2])) * (frequency[1] - frequency[0])
    return float(frequency[peak]), min(band / above, 1.0)


def amplitude_exponent(run: FreeRun, period_s: float, noise: float) -> float:
    """Exponent p of residual ~ amplitude^p within the trial, from cycle to cycle; nan below four usable cycles.

    RMS of residual and of motion a cycle, straight line through their logarithms; cycles whose residual is noise
    (under twice its standard deviation) do not count.
    """
    edges = np.arange(run.t[0], run.t[-1], period_s)
    sizes, errors = [], []
    for start, stop in itertools.pairwise(edges):
        cycle = (run.t >= start) & (run.t < stop)
        if np.count_nonzero(cycle) < 4:
            continue
        sizes.append(float(np.sqrt(np.mean(run.measured[cycle] ** 2))))
        errors.append(float(np.sqrt(np.mean(run.residual[cycle] ** 2))))
    size, error = np.array(sizes), np.array(errors)
    good = (error > 2.0 * noise) & (size > 0.0)
    if np.count_nonzero(good) < 4 or float(np.ptp(np.log(size[good]))) < 0.3:
        return math.nan
    return float(np.polyfit(np.log(size[good]), np.log(error[good]), 1)[0])
