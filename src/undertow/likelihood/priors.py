"""What is believed beforehand of everything that is no physics: clocks, gains, offsets, drift, the rest position.

Every width is relative to the trial's own period, size or range, so that a watch's balance and a ship get the same
treatment. What a laboratory knows better stands in its config.

Belongs here: those widths, each with its reason; the clock's stands where clocks are first fitted (conditioning/
fusion.py) and is taken from there. Does not belong here: where they are used (problem.py, joint.py, trajectories.py).
"""

from __future__ import annotations

import math

from undertow.conditioning.fusion import CLOCK_RADIANS

__all__ = [
    "CLOCK_RADIANS", "DRIFT_SHARE", "GAIN_STD", "LATE_RELEASE_RADIANS", "REST_SHARE", "clock_std",
]  # fmt: skip

LATE_RELEASE_RADIANS = 0.6
"""Prior of the release instant where an equation is searched, rad: noise of an eighth of the motion moves it so far."""

GAIN_STD = 0.005
"""Prior of a sensor's gain against another's, relative: half a per cent of calibration."""

DRIFT_SHARE = 0.003
"""Prior of the displacement's drift over a record, relative to the largest release of what is fitted together."""

REST_SHARE = 0.05
"""Prior of the rest position where friction is not known, relative to the trial's largest displacement: with the
friction that ends a decay after ten swings a body rests within a twentieth of its release."""


def clock_std(period_s: float) -> float:
    """Prior of a clock for a body of this period, s.

    >>> round(clock_std(1.0), 4)
    0.0048
    """
    return CLOCK_RADIANS * period_s / (2.0 * math.pi)
