"""Where a body comes to rest, and until when it swings.

Belongs here: the motion's end and the rest position that a record ends at. Does not belong here: its beginning
(release.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from undertow.recording.recording import Array, Recording

MOTION_IN_NOISE = 4.0
"""Motion ends where what is left stays under this many standard deviations of noise."""

SHORT_MEAN_SHARE = 1.0 / 8.0
"""Means over this share of half a period are free of most noise and keep the motion."""

TAIL_SHARE = 0.05
"""The record's end, in which a body that came to rest shows where, and how much its sensor moves by itself."""

MEANS_STEP_SHARE = 1.0 / 128.0
"""How finely the motion's end is looked for, in half periods."""

MARGINS = tuple(np.geomspace(1.0, 1.6, 9).tolist())
"""Motion's end is the mean of where it falls under so many times the margin: at one margin alone, whether a last swing
counts is a matter of luck, and a quarter of a period."""

MOTION_SHARE = 0.004
"""Motion also ends where what is left stays under this share of the largest deflection: below it, drift decides."""

STILL_SWINGS = 0.2
"""A body whose last period ranges over more than this share of the record's range has not come to rest."""


def rest_position(time: Array, values: Array, half: float) -> float:
    """Where the body ends up: the median of the record's end; of its last period where it still swings there.

    ``half`` is half a period, s. A record of few swings may end on a turn, as far away as a hold is.
    """
    if np.ptp(values[time >= time[-1] - 2.0 * half]) > STILL_SWINGS * np.ptp(values):
        last = max(TAIL_SHARE * (time[-1] - time[0]), 2.0 * half)
    else:
        last = TAIL_SHARE * (time[-1] - time[0])
    return float(np.median(values[time >= time[-1] - last]))


def motion_end(recording: Recording, levels: Mapping[str, float], half: float) -> float:
    """Last instant at which the body still oscillates, s in the recording's time.

    Over half a period a sensor's drift is nothing, so what counts is the range of each recorded channel (short means
    against noise) over the half period that follows. Motion ends where that stays under `MOTION_IN_NOISE` times its
    noise and under `MOTION_SHARE` of its largest in every channel. The record's end where it still oscillates.
    """
    time = recording.time
    dt = float(np.median(np.diff(time)))
    last = float(time[0])
    for name in ("displacement", "velocity", "acceleration"):
        if name in recording.channels:
            last = max(last, _last_oscillation(time, recording.channels[name], levels[name], half, dt))
    return last


def _last_oscillation(time: Array, values: Array, level: float, half: float, dt: float) -> float:
    """End of the last half period in which short means range over more than noise; the record's end if that is it."""
    span = max(SHORT_MEAN_SHARE * half, dt)
    at, smooth = _short_means(time, values, span, MEANS_STEP_SHARE * half)
    width = round(1.0 / MEANS_STEP_SHARE)
    if smooth.size <= width:
        return float(time[-1])
    ranges = np.ptp(np.lib.stride_tricks.sliding_window_view(smooth, width), axis=1)
    noise_of_means = level / math.sqrt(span / dt)
    margin = max(2.0 * MOTION_IN_NOISE * noise_of_means, MOTION_SHARE * float(np.max(ranges)))
    return float(np.mean([_last_above(at, smooth, ranges, margin * share) for share in MARGINS]))


def _last_above(at: Array, smooth: Array, ranges: Array, margin: float) -> float:
    """Instant from which on ``smooth`` moves by no more than ``margin`` in half a period."""
    moving = np.flatnonzero(ranges > margin)
    if not moving.size:
        return float(at[0])
    if moving[-1] == ranges.size - 1:
        return float(at[-1])
    # the last window that moves: its motion ends where its remaining range is first under the margin
    last = smooth[moving[-1] : moving[-1] + smooth.size - ranges.size + 1][::-1]
    rest = (np.maximum.accumulate(last) - np.minimum.accumulate(last))[::-1]
    return float(at[moving[-1] + int(np.argmax(rest <= margin))])


def _short_means(time: Array, values: Array, span: float, step: float) -> tuple[Array, Array]:
    """Instants (n,) at multiples of ``step`` and means of ``values`` over ``span`` about them, the same at any rate."""
    between = 0.5 * (time[1:] + time[:-1])
    edges = np.concatenate([[2.0 * time[0] - between[0]], between, [2.0 * time[-1] - between[-1]]])
    area = np.concatenate([[0.0], np.cumsum(values * np.diff(edges))])
    first, last = edges[0] + 0.5 * span, edges[-1] - 0.5 * span
    at = step * np.arange(math.ceil(first / step), math.floor(last / step) + 1)
    means: Array = (np.interp(at + 0.5 * span, edges, area) - np.interp(at - 0.5 * span, edges, area)) / span
    return at, means
