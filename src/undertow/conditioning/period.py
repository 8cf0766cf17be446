"""The period that a motion has, from its crossings of its rest position, or from its turns.

Belongs here: that mean. Does not belong here: turns (swings.py).
"""

from __future__ import annotations

import numpy as np

from undertow.conditioning.motion import Motion, once_a_motion
from undertow.conditioning.swings import PAUSED, find_swings
from undertow.errors import IdentificationError


@once_a_motion
def dominant_period(motion: Motion) -> float:
    """Mean period of the motion from crossings of the equilibrium inside the window, s.

    Pauses are left out: a sensor that drifts crosses once more long after the motion has died. Where fewer than two
    crossings are found, because what it swings about drifts, the period is that of the turns. IdentificationError where
    there is no swing between two turns either.
    """
    x = motion.windowed("x") - motion.equilibrium.value
    t = motion.windowed("t")
    error = float(np.median(motion.windowed("x_std")))
    if "displacement" not in motion.recording.channels:
        x, error = motion.windowed("v"), float(np.median(motion.windowed("v_std")))
    threshold = 0.05 * float(np.max(np.abs(x)))
    beyond = np.flatnonzero(np.abs(x) > threshold)
    last = np.flatnonzero(np.diff(np.sign(x[beyond])) != 0)
    before, after = beyond[last], beyond[last + 1]
    # on the straight line between, not at a sample: cells are as wide at any rate
    crossings = t[before] + (t[after] - t[before]) * x[before] / (x[before] - x[after])
    if crossings.size < 2:
        swings = find_swings(t, x, error)
        if swings.count:
            return 2.0 * swings.half_period_s
        raise IdentificationError(
            f"trial {motion.name}: it does not swing in the motion window of {t[-1] - t[0]:.3g} s "
            f"({crossings.size} crossings of its equilibrium, no two turns); a fit needs two: widen trials.window"
        )
    half = np.diff(crossings)
    usual = np.sort(half)[(half.size - 1) // 2]
    return float(2.0 * np.mean(half[half <= PAUSED * usual]))
