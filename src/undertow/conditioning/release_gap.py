"""A release that nobody saw: values are missing where the body was let go.

Belongs here: that judgement and its sentence. Does not belong here: where the release is (release.py), gaps elsewhere
(recording/gaps.py).
"""

from __future__ import annotations

import math

import numpy as np

from undertow.errors import LostValuesError
from undertow.recording.recording import Array, Recording

LOST_SHARE = 0.25
"""A gap of more half periods than this hides a release: of a cosine's first quarter half the way is gone."""

STILL_SEEN = 0.5
"""Half periods of hold that must be seen after such a gap: a turning point a period later is still for a third of one,
at nearly the same place."""

LOST_STEPS = 2.5
"""And of more usual steps than this: at the lowest rates a step is that long."""

STILL_SHARE = 0.02
"""Range of what stood still before a gap, relative to the whole range (drift apart from noise)."""

STILL_IN_NOISE = 8.0
"""The same in standard deviations of the noise."""


def refuse_lost_release(recording: Recording, values: Array, level: float, release_s: float, half_s: float) -> None:
    """LostValuesError where a gap holds the release, the quarter swing after it that tells its instant, or the end of
    the hold before it; and where all samples from a release that was seen (nan: none) to a gap stand still.

    ``values`` (n,) is the channel that is followed, ``level`` its noise, ``half_s`` half a period of the motion, s.
    Between the hold and the first sample after such a gap nothing says when the body was let go; a guess would be
    spoken of as a release that is not perfect.
    """
    time, steps = recording.time, np.diff(recording.time)
    begins = release_s if math.isfinite(release_s) else float(time[0])
    still = max(STILL_SHARE * float(np.ptp(values)), STILL_IN_NOISE * level)

    def hides(at: int) -> bool:
        """Whether the gap after this sample hides the release."""
        if math.isfinite(release_s) and time[at] < release_s + LOST_SHARE * half_s:
            return bool(time[at + 1] > release_s - STILL_SEEN * half_s)
        seen = values[: at + 1][time[: at + 1] >= begins]
        return seen.size > 1 and float(np.ptp(seen)) < still

    long = np.flatnonzero(steps > max(LOST_SHARE * half_s, LOST_STEPS * float(np.median(steps))))
    lost = [at for at in long.tolist() if hides(at)]
    if not lost:
        return
    first, last = float(time[lost[0]]), float(time[lost[-1] + 1])
    raise LostValuesError(
        f"trial {recording.name}: no sample between {first:.4g} and {last:.4g} s, where the body is let go, and a gap "
        f"of {last - first:.3g} s is {(last - first) / half_s:.2g} half periods: when it was released is not known; "
        f"begin trials.window at {last:.4g} s (start_s: the motion is then taken from there), or take the trial out "
        "(recordings.exclude)"
    )
