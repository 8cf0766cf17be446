"""A release that nobody saw: values are missing where the body was let go.

Belongs here: that judgement and its sentence. Does not belong here: where the release is (release.py), gaps elsewhere
(recording/gaps.py).
"""

from __future__ import annotations

import numpy as np

from undertow.errors import LostValuesError
from undertow.recording.recording import Recording

LOST_SHARE = 0.25
"""A gap of more half periods than this hides a release: of a cosine's first quarter half the way is gone."""

STILL_SEEN = 0.5
"""Half periods of hold that must be seen after such a gap: a turning point a period later is still for a third of one,
at nearly the same place."""

LOST_STEPS = 2.5
"""And of more usual steps than this: at the lowest rates a step is that long."""


def refuse_lost_release(recording: Recording, release_s: float, half_s: float) -> None:
    """LostValuesError where a gap holds the release, the quarter swing after it that tells its instant, or the end of
    the hold before it.

    ``half_s`` is half a period of the motion, s. Between the hold and the first sample after such a gap nothing says
    when the body was let go; a guess would be spoken of as a release that is not perfect.
    """
    steps = np.diff(recording.time)
    usual = float(np.median(steps))
    before, after = recording.time[:-1], recording.time[1:]
    long = steps > max(LOST_SHARE * half_s, LOST_STEPS * usual)
    across = np.flatnonzero(long & (before < release_s + LOST_SHARE * half_s) & (after > release_s - STILL_SEEN * half_s))
    if not across.size:
        return
    first, last = float(before[across[0]]), float(after[across[-1]])
    raise LostValuesError(
        f"trial {recording.name}: no sample between {first:.4g} and {last:.4g} s, where the body is let go, and a gap of "
        f"{last - first:.3g} s is {(last - first) / half_s:.2g} half periods: when it was released is not known; begin "
        f"trials.window at {last:.4g} s (start_s: the motion is then taken from there), or take the trial out "
        "(recordings.exclude)"
    )
