"""Swings of a record: where it turns, whatever it swings about.

A turn counts once the record has come back from it by more than a margin (hysteresis), so that neither an offset nor a
drift nor noise makes or hides one, as they do with crossings of a rest position.

Belongs here: turns, swings between them, their period. Does not belong here: whether they are a decay (decaying.py).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from undertow.recording.recording import Array

NOISE_RANGE = 10.0
"""Range of noise in its standard deviations: what 100,000 samples reach."""

LARGE_SHARE = 0.1
"""Swings under this share of the largest one do not count: noise, drift, a second mode."""

MEDIAN_OF = 3
"""Samples whose running median is followed, so that a single spike is no turn."""


END = 0.2
"""Share of a swing at either end in which the body may have stopped."""

BETWEEN = 1.0 - 2.0 * math.acos(1.0 - 2.0 * END) / math.pi
"""Of a cosine's half period, the time between these ends."""

PAUSED = 1.5
"""Time between two turns, over what its middle part says, or between two crossings, over the usual one, from which on
the motion paused between them."""


@dataclass(frozen=True)
class Swings:
    """Turns of a record: ``time`` (n,) s and ``position`` (n,) in the channel's unit, the record's two ends among them;
    ``took`` (n - 1,) s from each to the next, without the time at which a body lay still and its sensor drifted.

    >>> t = np.arange(0.0, 3.0, 0.01)
    >>> s = find_swings(t, np.cos(2.0 * np.pi * t) + 0.2 * t, 1e-6)
    >>> s.count, round(s.half_period_s, 2)
    (4, 0.5)
    """

    time: Array
    position: Array
    took: Array

    @property
    def size(self) -> Array:
        """From each turn to the next, (n - 1,), in the channel's unit."""
        return np.abs(np.diff(self.position))

    @property
    def whole(self) -> np.ndarray:
        """Which swings lie between two turns and not at the record's ends, (n - 1,)."""
        inner = np.ones(max(self.time.size - 1, 0), dtype=bool)
        inner[:1] = inner[-1:] = False
        return inner

    @property
    def count(self) -> int:
        """How many whole swings there are."""
        return int(np.count_nonzero(self.whole))

    @property
    def half_period_s(self) -> float:
        """Median duration of the whole swings, s; nan without one."""
        return float(np.median(self.took[self.whole])) if self.count else math.nan

    @property
    def centre(self) -> Array:
        """What each pair of whole neighbours swings about, (p1 + 2 p2 + p3) / 4, (count - 1,)."""
        p = self.position[1:-1]
        return np.asarray(0.25 * (p[:-2] + 2.0 * p[1:-1] + p[2:]))


def find_swings(time: Array, values: Array, level: float) -> Swings:
    """Swings of ``values`` (n,) at ``time`` (n,) s, whose noise has the standard deviation ``level``."""
    smooth = _running_median(values)
    least = NOISE_RANGE * level
    turns = _turns(smooth, least)
    largest = float(np.max(np.abs(np.diff(smooth[turns])), initial=0.0))
    if LARGE_SHARE * largest > least:
        turns = _turns(smooth, LARGE_SHARE * largest)
    return Swings(time[turns], smooth[turns], _took(time, smooth, turns))


def _took(time: Array, values: Array, turns: np.ndarray) -> Array:
    """Time from each turn to the next, (n - 1,), s; of one that takes `PAUSED` times as long as it moves, what its
    middle part says: the body stopped, and what its sensor drifted by passed for the way to the next turn."""
    took = np.diff(time[turns])
    for i, (begin, end) in enumerate(itertools.pairwise(turns.tolist())):
        way = values[end] - values[begin]
        if way == 0.0:
            continue
        share = (values[begin : end + 1] - values[begin]) / way
        first, last = (begin + int(np.argmax(share >= part)) for part in (END, 1.0 - END))
        moved = float(time[last] - time[first]) / BETWEEN
        took[i] = moved if took[i] > PAUSED * moved > 0.0 else took[i]
    return np.asarray(took)


def _running_median(values: Array) -> Array:
    if values.size < MEDIAN_OF:
        return values
    inner = np.median(np.lib.stride_tricks.sliding_window_view(values, MEDIAN_OF), axis=1)
    return np.concatenate([values[:1], inner, values[-1:]])


def _turns(values: Array, margin: float) -> np.ndarray:
    """Indices of the first sample, of every turn that is left by more than ``margin``, and of the last sample."""
    rising = np.diff(values)
    moved = np.flatnonzero(rising)
    change = np.flatnonzero(np.diff(np.sign(rising[moved]))) if moved.size else moved
    candidates = np.concatenate([[0], moved[change] + 1, [values.size - 1]]).tolist()
    at = values[candidates].tolist()
    turns, best, way = [0], 0, 0
    for i in range(1, len(at)):
        if way == 0:
            if abs(at[i] - at[0]) > margin:
                way, best = (1 if at[i] > at[0] else -1), i
        elif way * (at[i] - at[best]) >= 0.0:
            best = i
        elif way * (at[best] - at[i]) > margin:
            turns.append(candidates[best])
            way, best = -way, i
    turns.append(candidates[best] if way else candidates[-1])
    if turns[-1] != candidates[-1]:
        turns.append(candidates[-1])
    return np.array(turns if len(turns) > 1 else [0, values.size - 1])
