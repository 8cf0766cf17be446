"""Values that were lost and that the logger filled with one number: the last one, zero, or a number that means none.

Belongs here: stretches that stand still between jumps. Does not belong here: single wrong samples (spikes.py), peaks
that are cut off (clipping.py), rows or cells that are missing (gaps.py).
"""

from __future__ import annotations

import numpy as np

from undertow.recording.clipping import runs
from undertow.recording.recording import Array

FEWEST_EQUAL = 5
"""Equal samples in a row: a peak, finely sampled and rounded, rests that long, but leaves without a jump."""

JUMP_QUANTA = 10.0
"""A jump has this many of the channel's finest steps: rounding makes steps of one or two."""

JUMP_STEPS = 3.0
"""... and this many of the largest step around it: in `FEWEST_EQUAL` samples a motion goes on by five of its steps. A
slow sensor whose values are written several times over jumps as far everywhere."""

FAR_RANGES = 5.0
"""A number that lies so many ranges of all others from their middle is none that a body was at: a sensor's spike ends
where its range does, and nobody tests in a tenth of that."""

Stretch = tuple[int, int]
"""Half-open range of samples."""


def find_dropouts(values: Array, step: float) -> list[Stretch]:
    """Where a channel (n,) with a finest step of ``step`` stands still and comes or goes by a jump.

    A body comes to rest and leaves it smoothly; its displacement, its velocity and the force in its springs cannot
    jump. What stands still up to the first or the last sample is a hold or a rest, and none.

    >>> x = np.cos(np.linspace(0.0, 20.0, 400)); x[100:120] = 0.0; x[330:345] = x[330]
    >>> find_dropouts(x, 0.0)
    [(100, 120), (330, 345)]
    """
    found = []
    for start, last in runs(np.diff(values) == 0.0):
        end = last + 1
        if end - start < FEWEST_EQUAL or start == 0 or end == values.size:
            continue
        reach = 2 * (end - start)
        before = np.abs(np.diff(values[max(start - reach, 0) : start]))
        after = np.abs(np.diff(values[end : end + reach]))
        around = max(float(np.max(before, initial=0.0)), float(np.max(after, initial=0.0)))
        jump = max(abs(values[start] - values[start - 1]), abs(values[end] - values[end - 1]))
        if around > 0.0 and jump > max(JUMP_STEPS * around, JUMP_QUANTA * step):
            found.append((start, end))
    return found


def find_fillers(values: Array) -> np.ndarray:
    """Samples of a channel (n,) that hold a number far outside all others (`FAR_RANGES`), however few they are: their
    places, in order.

    Loggers write one such number for no value. It is the smallest or the largest of all, and always the same.

    >>> x = np.cos(np.linspace(0.0, 20.0, 400)); x[[7, 200, 201]] = -9999.0
    >>> find_fillers(x).tolist(), find_fillers(np.cos(np.linspace(0.0, 20.0, 400))).tolist()
    ([7, 200, 201], [])
    """
    low, high = float(np.min(values)), float(np.max(values))
    others = values[(values != low) & (values != high)]
    reach = float(np.ptp(others)) if others.size else 0.0
    if reach == 0.0:
        return np.zeros(0, dtype=np.intp)
    middle = 0.5 * float(np.max(others) + np.min(others))
    return np.flatnonzero(np.abs(values - middle) > FAR_RANGES * reach)
