"""When the body was let go, and which part of the record is motion.

Belongs here: hold, release instant, start and end of the motion window. Does not belong here: what the motion is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from undertow.conditioning.first_swing import fit_first_swing
from undertow.conditioning.motion import Window
from undertow.conditioning.motion_end import (
    MOTION_IN_NOISE,
    SHORT_MEAN_SHARE,
    TAIL_SHARE,
    motion_end,
    rest_position,
)
from undertow.conditioning.release_gap import refuse_lost_release
from undertow.conditioning.swings import find_swings
from undertow.errors import RecordingError
from undertow.recording.noise import noise
from undertow.recording.recording import Array, Recording

QUIET_HALF_PERIODS = 0.3
"""A hold is looked for in stretches of this many half periods: a turning point lingers too, but not so long."""

QUIET_RUN = 0.1
"""Stretches that are quiet begin over at least this many half periods."""

SHORTEST_HOLD = 0.15
"""A record that begins so many half periods before its first swing began with a hold."""

HOLD_SEEN = 0.5
"""How much of a hold is compared with a swing that never stopped, in half periods."""

SWING_SEEN = 2.0
"""And how much of the swing after it, rad."""

SWUNG = 1.5
"""A body swung through where it seemed to stand still when that leaves so many times less of the samples' squares."""

SWUNG_BEFORE = 0.8
"""A body that was as far on the other side before, relative to the hold, was not held: nobody pulls it there first."""

QUIET_END = 0.5
"""What a record's end still does is noise where four of its standard deviations are under this share of the motion."""

GUESSED = 3
"""Samples whose median is where a record begins."""

FEWEST_AFTER = 20
"""Samples after a release that show the motion's own period."""

OTHER_PERIOD = 1.3
"""A period that differs by this factor from the whole record's is another one."""

FEWEST_QUIET = 5
"""A hold is seen in at least this many samples."""

FEWEST_MEANS = 50
"""So many means tell their own noise; from fewer, the samples' noise is taken for white."""

QUIET_SHARE = 0.02
"""Largest range, relative to the deflection held, within which a body stands still (drift and noise apart)."""

QUIET_IN_NOISE = 8.0
"""The same in standard deviations of its noise."""

LINGERS = 1.5
"""A stretch that is quiet so many times as long as a turning point would be is no turning point."""

HELD_AWAY_SHARE = 0.3
"""A hold is this share of the largest deflection away from where the body ends up: else it is rest, not a hold."""

HELD_FIRST = 0.8
"""A hold at the record's beginning is at this share of the largest deflection at least: a decay begins with it."""

TRANSIENT_SHARE = 0.05
"""Half period's share after the release that still holds the hold's forces in part (filters, a slow release); at
least a sample."""

HALF_WAY_RADIANS = math.pi / 3.0
"""A body let go is half way to its centre after this angle: 1 - cos."""

UNREFINED_RADIANS = 0.3
"""Error of a release that is known from that alone: friction and damping shift the way by so much."""

CROSSING_SHARE = 0.1
"""A crossing goes from this share of the largest deflection on one side to as much on the other."""


def find_window(
    recording: Recording,
    start_s: float | None = None,
    end_s: float | None = None,
    levels: Mapping[str, float] | None = None,
) -> Window:
    """Release instant and motion window of one recording.

    A hold is a quiet stretch away from where the body ends up; the release is its end, refined between samples
    from the first swing (`fit_first_swing`). Without a hold (or with ``start_s``) the record is in
    mid-motion: the window starts at its first sample (or there) and the initial velocity is free. The window ends
    with the stuck tail, or at ``end_s``. ``levels`` is the noise of every channel, where it is known already.

    Raises RecordingError where nothing moves, where the body is never let go, or where a window holds under 20 samples;
    LostValuesError where the release lies in a gap.
    """
    time, channel = recording.time, followed(recording)
    levels = {name: noise(own) for name, own in recording.channels.items()} if levels is None else levels
    _check_motion(recording, channel, levels[channel])
    half, last, found = _seen(recording, levels, start_s)
    stop = last if end_s is None else min(float(end_s), float(time[-1]))
    release, error = found if found is not None else (math.nan, math.nan)
    if start_s is None:
        refuse_lost_release(recording, recording.channels[channel], levels[channel], release, half)
    if found is None:
        start = float(time[0]) if start_s is None else float(start_s)
        window = Window(start, start, stop)
    else:
        transient = max(TRANSIENT_SHARE * half, 1.0 / recording.rate_hz)
        window = Window(release, release + transient, stop, error, True)
    inside = int(np.count_nonzero((time >= window.start_s) & (time <= window.end_s)))
    if inside < 20:
        raise RecordingError(
            f"trial {recording.name}: {inside} samples lie in the motion window {window.start_s:.4g} to "
            f"{window.end_s:.4g} s; identification needs 20: set trials.window, or look at the recording"
        )
    return window


def _seen(
    recording: Recording, levels: Mapping[str, float], start_s: float | None
) -> tuple[float, float, tuple[float, float] | None]:
    """Half a period, the motion's end, and the release with its error (None: not seen, or a start is given), s.

    What a hand did before the release has another period: that of the motion after it is compared, and where it is
    another one everything is looked for once more.
    """
    channel = followed(recording)
    time, values, level = recording.time, recording.channels[channel], levels[channel]
    half = half_period(time, values, level)
    last, found = motion_end(recording, levels, half), None
    for _ in range(2):
        found = _release(recording, level, half, last) if start_s is None else None
        begin = found[0] if found is not None else start_s
        after = time >= (time[0] if begin is None else begin)
        if begin is None or np.count_nonzero(after) < FEWEST_AFTER:
            break
        own = half_period(time[after], values[after], level)
        if half / OTHER_PERIOD < own < half * OTHER_PERIOD:
            break
        half = own
        last = motion_end(recording, levels, half)
    return half, last, found


def followed(recording: Recording) -> str:
    """Name of the channel in which motion is looked for: displacement, else velocity, else acceleration."""
    for name in ("displacement", "velocity", "acceleration"):
        if name in recording.channels:
            return name
    have = ", ".join(recording.channels) or "none"
    raise RecordingError(
        f"trial {recording.name}: channels are {have}; motion needs displacement, velocity or acceleration: map one"
    )


def _check_motion(recording: Recording, channel: str, level: float) -> None:
    size, unit = float(np.ptp(recording.channels[channel])), recording.unit(channel)
    if size < 10.0 * level or size == 0.0:
        raise RecordingError(
            f"trial {recording.name}: no release found: the record moves by {size:.3g} {unit} with noise of "
            f"{level:.3g} {unit}; motion must exceed 10 times the noise: look at the sensor"
        )


def _hold(time: Array, values: Array, level: float, half: float, motion_end: float) -> tuple[int, int] | None:
    """First and last sample of the last hold before the motion; None where the record starts in mid-motion.

    Looked for in means over an eighth of half a period, so that noise, white or slow, is no motion.
    """
    dt = float(np.median(np.diff(time)))
    short = max(1, round(SHORT_MEAN_SHARE * half / dt))
    smooth = np.convolve(values, np.ones(short) / short, mode="valid")
    level = _slow_noise(smooth, short, level)
    width = max(FEWEST_QUIET, round(QUIET_HALF_PERIODS * half / dt))
    if smooth.size <= width:
        return None
    windows = np.lib.stride_tricks.sliding_window_view(smooth, width)
    tail = rest_position(time, values, half)
    deflection = np.abs(np.mean(windows, axis=1) - tail)
    quiet = np.ptp(windows, axis=1) < np.maximum(QUIET_SHARE * deflection, QUIET_IN_NOISE * level)
    held = np.flatnonzero(quiet & (deflection > HELD_AWAY_SHARE * float(np.max(np.abs(smooth - tail)))))
    if not held.size:
        return None
    runs = np.split(held, np.flatnonzero(np.diff(held) > 1) + 1)
    long_enough = [run for run in runs if time[run[0]] < motion_end and run.size * dt > QUIET_RUN * half]
    if not long_enough:
        return None
    run = max(long_enough, key=lambda r: r.size)
    level_held = float(np.median(smooth[run[0] : run[-1] + 1]))
    margin = max(6.0 * level, 0.25 * QUIET_SHARE * float(np.ptp(values)))
    here = smooth[run[0] : run[-1] + width]
    outside = np.flatnonzero(np.abs(here - level_held) > margin)
    outside = outside[outside > run.size - 1] if outside.size else outside
    last = outside[0] - 1 if outside.size else here.size - 1
    return int(run[0]), int(run[0] + last + short // 2)


def _release(recording: Recording, level: float, half: float, motion_end: float) -> tuple[float, float] | None:
    """Release instant and its standard error, s; None where the record shows no hold: it starts in mid-motion.

    Candidates are the last quiet stretch and the record's own beginning. Each is compared with a swing that never
    stopped, through the same samples: a turning point is quiet too, seen coarsely.
    """
    if followed(recording) == "velocity":
        return _set_off(recording, level, half)
    hold = _hold(recording.time, recording.channels[followed(recording)], level, half, motion_end)
    if hold is not None:
        found = _refined_release(recording, level, half, hold)
        if _lasts(recording, level, half, hold) or (
            not _swung_before(recording, half, hold) and _stood_still(recording, half, hold, found[0])
        ):
            return found
    return _from_the_beginning(recording, level, half)


def _set_off(recording: Recording, level: float, half: float) -> tuple[float, float] | None:
    """Release instant of a velocity that is zero from the record's beginning, and its error, s; None where it is not so
    for longer than a turning point is."""
    time, values = recording.time, recording.channels["velocity"]
    short = max(1, round(SHORT_MEAN_SHARE * half / float(np.median(np.diff(time)))))
    smooth = np.convolve(values - rest_position(time, values, half), np.ones(short) / short, mode="same")
    away = np.abs(smooth)
    quiet = max(QUIET_SHARE * float(np.max(away)), QUIET_IN_NOISE * _slow_noise(smooth, short, level))
    beyond = np.flatnonzero(away > quiet)
    if not beyond.size or beyond[0] < FEWEST_QUIET:
        return None
    starts = float(time[beyond[0]])
    first = float(np.max(away[(time >= starts) & (time <= starts + half)]))
    before = math.asin(min(quiet / first, 1.0)) * half / math.pi
    if starts - time[0] <= max(2.0 * LINGERS * before, SHORTEST_HOLD * half):
        return None
    # means over a short stretch begin to rise by half of it before the velocity does
    return starts - before + 0.25 * SHORT_MEAN_SHARE * half, UNREFINED_RADIANS * half / math.pi


def _from_the_beginning(recording: Recording, level: float, half: float) -> tuple[float, float] | None:
    """Release instant of a record that begins with a hold too short to be quiet, and its error, s."""
    if "displacement" not in recording.channels:
        return None
    time, values = recording.time, recording.channels["displacement"]
    away = values - rest_position(time, values, half)
    first = float(np.median(away[:GUESSED]))
    if abs(first) < HELD_FIRST * float(np.max(np.abs(away))):
        return None
    past = np.flatnonzero(away / first < 0.5)
    if not past.size:
        return None
    guess = float(time[past[0]]) - HALF_WAY_RADIANS * half / math.pi
    if guess - time[0] < SHORTEST_HOLD * half or past[0] < GUESSED:
        return None
    hold = (0, int(np.searchsorted(time, guess)))
    found = _refined_release(recording, level, half, hold)
    long_enough = found[0] - time[0] >= SHORTEST_HOLD * half
    return found if long_enough and _stood_still(recording, half, hold, found[0]) else None


def _lasts(recording: Recording, level: float, half: float, hold: tuple[int, int]) -> bool:
    """Whether a quiet stretch lasts longer than any turning point could pass for one."""
    time, values = recording.time, recording.channels[followed(recording)]
    size = abs(float(np.median(values[hold[0] : hold[1] + 1])) - rest_position(time, values, half))
    short = max(1, round(SHORT_MEAN_SHARE * half / float(np.median(np.diff(time)))))
    smooth = np.convolve(values, np.ones(short) / short, mode="valid")
    quiet = max(QUIET_SHARE, QUIET_IN_NOISE * _slow_noise(smooth, short, level) / size) if size > 0.0 else 1.0
    lingers = 2.0 * math.acos(max(1.0 - quiet, -1.0)) * half / math.pi
    return float(time[hold[1]] - time[hold[0]]) > LINGERS * lingers


def _swung_before(recording: Recording, half: float, hold: tuple[int, int]) -> bool:
    """Whether the body swung to the other side, as far as it stands in the hold, before that: it is in mid-decay."""
    time, values = recording.time, recording.channels[followed(recording)]
    away = values - rest_position(time, values, half)
    size = float(np.median(away[hold[0] : hold[1] + 1]))
    short = max(1, round(SHORT_MEAN_SHARE * half / float(np.median(np.diff(time)))))
    before = away[: hold[0]]
    if before.size < short or size == 0.0:
        return False
    smooth = np.convolve(before, np.ones(short) / short, mode="valid")
    return float(np.min(smooth / size)) < -SWUNG_BEFORE


def _stood_still(recording: Recording, half: float, hold: tuple[int, int], release: float) -> bool:
    """Whether a body stood still until ``release`` (s) rather than swung through a turning point there.

    Both are fitted to the same samples: x0 and, from the release on, a swing; or one swing through all of them.
    """
    if "displacement" not in recording.channels:
        return True
    w = math.pi / half
    time, values = recording.time, recording.channels["displacement"]
    first = max(float(time[hold[0]]), release - HOLD_SEEN * half)
    rows = (time >= first) & (time <= release + SWING_SEEN / w)
    if np.count_nonzero(rows & (time < release)) < GUESSED:
        return True
    angle = w * (time[rows] - release)
    moved = np.maximum(angle, 0.0)
    swing = np.column_stack([np.cos(angle), np.sin(angle), angle * np.cos(angle), angle * np.sin(angle)])
    stopped = np.column_stack([1.0 - np.cos(moved), moved - np.sin(moved), moved**2 * np.cos(moved), moved**3])
    return _left(stopped, values[rows]) <= SWUNG * _left(swing, values[rows])


def _left(columns: Array, values: Array) -> float:
    """What is left of values (n,) beside a constant and columns (n, p), as a sum of squares."""
    table = np.column_stack([np.ones(values.size), columns])
    residual = values - table @ np.linalg.lstsq(table, values, rcond=None)[0]
    return float(residual @ residual)


def _slow_noise(smooth: Array, short: int, level: float) -> float:
    """Standard deviation of means over ``short`` samples whose noise is ``level``, more where the noise is slow."""
    white = level / math.sqrt(short)
    return max(white, noise(smooth[::short])) if smooth.size > FEWEST_MEANS * short else white


def _refined_release(recording: Recording, level: float, half: float, hold: tuple[int, int]) -> tuple[float, float]:
    """Release instant between samples and its standard error, s: from the first swing, or from where it is half done.

    Where neither displacement nor a whole first swing is recorded it is the end of the hold.
    """
    time, last = recording.time, hold[1]
    dt = float(np.median(np.diff(time)))
    if "displacement" not in recording.channels:
        return float(time[last]), dt
    values = recording.channels["displacement"]
    w = math.pi / half
    x0 = float(np.median(values[max(hold[0], last - round(half / dt)) : last + 1]))
    size = x0 - rest_position(time, values, half)
    short = max(1, round(SHORT_MEAN_SHARE * half / dt))
    smooth = np.convolve(values, np.ones(short) / short, mode="same")
    drop = (x0 - smooth) / size
    gone = np.flatnonzero((drop > 0.5) & (np.arange(drop.size) > last))
    if not gone.size:
        return float(time[last]) + 0.5 * dt, dt
    guess = float(time[gone[0]]) - HALF_WAY_RADIANS / w
    earliest = max(float(time[hold[0]]), guess - half)
    rows = (time >= earliest) & (time <= guess + 2.0 * half)
    level = _slow_noise(smooth, short, level) * math.sqrt(short)
    swing = fit_first_swing(time[rows], values[rows], level, guess, x0, size, w)
    if swing is None or not earliest <= swing.t0 <= time[gone[0]] + dt:
        return guess, UNREFINED_RADIANS / w
    return swing.t0, max(swing.stderr, 0.05 * dt)


def half_period(time: Array, values: Array, level: float) -> float:
    """Half a period of the record's largest oscillation, s: median time between crossings of its own running middle.

    Where swings that stand out of what the record's end still does are more than twice as far apart, the others are
    slow noise about the rest, and do not count. Where nothing crosses (it drifts, or ends elsewhere) the median time
    between turns; a quarter of the record where there are none.
    """
    rest = float(np.median(values[time >= time[-1] - 0.25 * (time[-1] - time[0])]))
    margin = max(MOTION_IN_NOISE * level, CROSSING_SHARE * float(np.max(np.abs(values - rest))))
    every = _between_crossings(time, values - rest, margin)
    if math.isnan(every):
        every = find_swings(time, values, level).half_period_s
        return every if math.isfinite(every) else 0.25 * float(time[-1] - time[0])
    end = MOTION_IN_NOISE * float(np.std(values[time >= time[-1] - TAIL_SHARE * (time[-1] - time[0])]))
    if end > QUIET_END * float(np.max(np.abs(values - rest))):
        return every  # it still swings there: only the maxima of a beat would stand out
    largest = _between_crossings(time, values - rest, max(margin, end))
    return largest if every < 0.5 * largest else every


def _between_crossings(time: Array, away: Array, margin: float) -> float:
    """Median time from one side beyond ``margin`` to the other, s; nan with fewer than two crossings. Of two unlike
    times in the middle the shorter: a motion that beats pauses between crossings."""
    side = np.where(away > margin, 1, np.where(away < -margin, -1, 0))
    instants, marked = time[side != 0], side[side != 0]
    apart = np.sort(np.diff(instants[np.flatnonzero(np.diff(marked) != 0)]))
    if not apart.size:
        return math.nan
    lower, upper = (float(apart[i]) for i in ((apart.size - 1) // 2, apart.size // 2))
    return lower if upper > OTHER_PERIOD * lower else 0.5 * (lower + upper)
