"""When the body was let go, and which part of the record is motion.

Belongs here: hold, release instant, start and end of the motion window. Does not belong here: what the motion is.
"""

from __future__ import annotations

import math

import numpy as np

from undertow.conditioning.motion import Window
from undertow.errors import RecordingError
from undertow.recording.quality import noise
from undertow.recording.recording import Array, Recording

QUIET_S = 0.12
"""Shortest time a body must stand still to be called held, s."""

QUIET_HALF_PERIODS = 0.3
"""A hold lasts at least this many half periods: a turning point lingers too, but not so long."""

QUIET_SHARE = 0.02
"""Largest range, relative to the deflection held, within which a body stands still (drift and noise apart)."""

HELD_AWAY_SHARE = 0.3
"""A hold is this share of the largest deflection away from where the body ends up: else it is rest, not a hold."""

TRANSIENT_SAMPLES = 3
"""Samples after the release that still hold the hold's forces in part (filters, the release's own duration)."""

TRANSIENT_S = 0.01
"""Least length of the release transient, s: a quick release takes milliseconds."""

EARLY_IN_RADIANS = 0.4
"""The displacement leaves its hold visibly only this many radians of the motion after the release, at most."""

MOTION_IN_NOISE = 4.0
"""Motion ends where what is left stays under this many standard deviations of noise."""

MOTION_SHARE = 0.004
"""Motion also ends where what is left stays under this share of the largest deflection: below it, drift decides."""


def find_window(recording: Recording, start_s: float | None = None, end_s: float | None = None) -> Window:
    """Release instant and motion window of one recording.

    A hold is a quiet stretch away from where the body ends up; the release is its end, refined between samples from
    the first part of the motion, x0 - x = (a0 / 2) (t - t0)^2. Without a hold (or with ``start_s``) the record is in
    mid-motion: the window starts at its first sample (or there) and the initial velocity is free. The window ends
    with the stuck tail, or at ``end_s``.

    Raises RecordingError where nothing moves, where the body is never let go, or where a window holds under 20 samples.
    """
    time, values = recording.time, followed(recording)
    _check_motion(recording, values)
    quiet_noise = noise(values)
    last = _motion_end(recording, quiet_noise)
    stop = last if end_s is None else min(float(end_s), float(time[-1]))
    hold = _hold_end(time, values, quiet_noise, last) if start_s is None else None
    if hold is None:
        start = float(time[0]) if start_s is None else float(start_s)
        window = Window(start, start, stop, 0.0, False, _reason(start_s, end_s, "no hold seen"))
    else:
        release, error = _refined_release(recording, values, hold)
        transient = max(TRANSIENT_S, TRANSIENT_SAMPLES / recording.rate_hz)
        reason = _reason(start_s, end_s, "released from a hold")
        window = Window(release, release + transient, stop, error, True, reason)
    inside = int(np.count_nonzero((time >= window.start_s) & (time <= window.end_s)))
    if inside < 20:
        raise RecordingError(
            f"trial {recording.name}: {inside} samples lie in the motion window {window.start_s:.4g} to "
            f"{window.end_s:.4g} s; identification needs 20: set trials.window, or look at the recording"
        )
    return window


def followed(recording: Recording) -> Array:
    """The channel in which motion is looked for: displacement, else velocity, else acceleration."""
    for name in ("displacement", "velocity", "acceleration"):
        if name in recording.channels:
            return recording.channels[name]
    have = ", ".join(recording.channels) or "none"
    raise RecordingError(
        f"trial {recording.name}: channels are {have}; motion needs displacement, velocity or acceleration: map one"
    )


def _reason(start_s: float | None, end_s: float | None, seen: str) -> str:
    set_by_user = [n for n, v in (("start", start_s), ("end", end_s)) if v is not None]
    return f"{' and '.join(set_by_user)} set" if set_by_user else seen


def _check_motion(recording: Recording, values: Array) -> None:
    size, level = float(np.ptp(values)), noise(values)
    if size < 10.0 * level or size == 0.0:
        unit = recording.unit(next(n for n in ("displacement", "velocity", "acceleration") if n in recording.channels))
        raise RecordingError(
            f"trial {recording.name}: no release found: the record moves by {size:.3g} {unit} with noise of "
            f"{level:.3g} {unit}; motion must exceed 10 times the noise: look at the sensor"
        )


def _hold_end(time: Array, values: Array, level: float, motion_end: float) -> int | None:
    """Index of the last sample of the last hold before the motion; None where the record starts in mid-motion.

    RecordingError where the body is held and never let go.
    """
    dt = float(np.median(np.diff(time)))
    width = max(5, round(max(QUIET_S, QUIET_HALF_PERIODS * half_period(time, values, level)) / dt))
    if values.size <= width:
        return None
    size = float(np.ptp(values))
    windows = np.lib.stride_tricks.sliding_window_view(values, width)
    tail = float(np.median(values[time >= time[-1] - 0.05 * (time[-1] - time[0])]))
    deflection = np.abs(np.mean(windows, axis=1) - tail)
    quiet = np.ptp(windows, axis=1) < np.maximum(QUIET_SHARE * deflection, 8.0 * level)
    held = np.flatnonzero(quiet & (deflection > HELD_AWAY_SHARE * float(np.max(np.abs(values - tail)))))
    if not held.size:
        return None
    runs = np.split(held, np.flatnonzero(np.diff(held) > 1) + 1)
    long_enough = [run for run in runs if time[run[0]] < motion_end and run.size * dt > 0.3 * QUIET_S]
    if not long_enough:
        return None
    run = max(long_enough, key=lambda r: r.size)
    level_held = float(np.median(values[run[0] : run[-1] + 1]))
    margin = max(6.0 * level, 0.25 * QUIET_SHARE * size)
    here = values[run[0] : run[-1] + width]
    outside = np.flatnonzero(np.abs(here - level_held) > margin)
    outside = outside[outside > run.size - 1] if outside.size else outside
    return int(run[0] + (outside[0] - 1 if outside.size else here.size - 1))


def _refined_release(recording: Recording, values: Array, hold: int) -> tuple[float, float]:
    """Release instant between samples and its standard error, s.

    The acceleration's step, where recorded, brackets it within a sample; the displacement's first part of motion,
    x0 - x = (a0 / 2) (t - t0)^2 (1 - w^2 (t - t0)^2 / 12), refines it where its noise allows better.
    """
    time = recording.time
    dt = float(np.median(np.diff(time)))
    if "displacement" not in recording.channels:
        return float(time[hold]), dt
    x0 = float(np.median(values[max(hold - round(QUIET_S / dt), 0) : hold + 1]))
    tail = float(np.median(values[time >= time[-1] - 0.05 * (time[-1] - time[0])]))
    drop = np.abs(values - x0) / max(abs(x0 - tail), 1e-300)
    first = hold + 1 + int(np.argmax(drop[hold + 1 :] > 0.5)) if np.any(drop[hold + 1 :] > 0.5) else hold + 3
    rows = np.arange(max(hold - 2, 0), min(first + 1, values.size))
    level = noise(values) / max(abs(x0 - tail), 1e-300)
    rows = rows[(drop[rows] > max(3.0 * level, 0.01)) & (drop[rows] < 0.6)]
    if rows.size < 3:
        return float(time[hold]) + 0.5 * dt, 0.5 * dt
    # drop = 1 - cos(w (t - t0)) of an undamped start: arccos makes a straight line whose zero is the release
    angle = np.arccos(np.clip(1.0 - drop[rows], -1.0, 1.0))
    weight = np.sin(angle) / max(level, 1e-6)
    slope, intercept = np.polyfit(time[rows], angle, 1, w=weight)
    spread = np.sqrt(np.sum((weight * (angle - slope * time[rows] - intercept)) ** 2) / max(rows.size - 2, 1))
    release = -intercept / slope
    distance = float(np.mean(time[rows]) - release)
    error = max(spread, 1.0) / math.sqrt(float(np.sum(weight**2))) / slope * (1.0 + distance / np.ptp(time[rows]))
    if not time[hold] - EARLY_IN_RADIANS / slope <= release <= time[hold] + 3.0 * dt:
        return float(time[hold]) + 0.5 * dt, dt
    return float(release), float(max(error, 0.05 * dt))


def _motion_end(recording: Recording, level: float) -> float:
    """Last instant at which the body still oscillates, s in the recording's time.

    Over half a period a sensor's drift is nothing, so what counts is the range of each recorded channel (short means
    against noise) over the half period that follows. Motion ends where that stays under `MOTION_IN_NOISE` times its
    noise and under `MOTION_SHARE` of its largest in every channel. The record's end where it still oscillates.
    """
    time, values = recording.time, followed(recording)
    dt = float(np.median(np.diff(time)))
    half = half_period(time, values, level)
    last = float(time[0])
    for name in ("displacement", "velocity", "acceleration"):
        if name in recording.channels:
            own = recording.channels[name]
            last = max(last, _last_oscillation(time, own, noise(own), half, dt))
    return last


def half_period(time: Array, values: Array, level: float) -> float:
    """Half a period of the record's largest oscillation, s: median time between crossings of its own running middle.

    A quarter of the record where nothing crosses.
    """
    rest = float(np.median(values[time >= time[-1] - 0.25 * (time[-1] - time[0])]))
    margin = max(MOTION_IN_NOISE * level, 0.1 * float(np.max(np.abs(values - rest))))
    side = np.where(values > rest + margin, 1, np.where(values < rest - margin, -1, 0))
    instants, marked = time[side != 0], side[side != 0]
    crossings = instants[np.flatnonzero(np.diff(marked) != 0)]
    if crossings.size < 2:
        return 0.25 * float(time[-1] - time[0])
    return float(np.median(np.diff(crossings)))


def _last_oscillation(time: Array, values: Array, level: float, half: float, dt: float) -> float:
    short = max(1, round(half / 8.0 / dt))
    smooth = np.convolve(values, np.ones(short) / short, mode="valid")
    width = max(3, round(half / dt))
    if smooth.size <= width:
        return float(time[-1])
    windows = np.lib.stride_tricks.sliding_window_view(smooth, width)
    ranges = np.ptp(windows, axis=1)
    margin = max(2.0 * MOTION_IN_NOISE * level / math.sqrt(short), MOTION_SHARE * float(np.max(ranges)))
    moving = np.flatnonzero(ranges > margin)
    if not moving.size:
        return float(time[0])
    if moving[-1] == ranges.size - 1:
        return float(time[-1])
    # the last window that moves: its motion ends where its remaining range is first under the margin
    start = int(moving[-1])
    rest = np.array([np.ptp(smooth[start + i : start + width]) for i in range(width)])
    gone = int(np.argmax(rest <= margin)) if np.any(rest <= margin) else width
    return float(time[min(start + gone + short // 2, time.size - 1)])
