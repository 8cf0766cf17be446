"""Motions out of scale: larger, faster or slower than any body that is let go, as a wrong unit makes them.

Belongs here: those looks and their sentences. Does not belong here: channels against each other (agreement.py), numbers
of an equation (campaign/run/plausible.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.errors import IdentificationError

GRAVITY, HURLED_M_PER_S2 = 9.81, 981.0
"""Gravity, and an acceleration of a hundred times that: no body on springs that was let go has it."""

SLOWEST_S = 400.0
"""A longer period is none of a test: moored ships take some minutes; milliseconds taken for seconds are longer."""

MS = 1e-3
"""Seconds of a millisecond."""


def out_of_scale(motions: Sequence[Motion]) -> tuple[str, ...]:
    """What no body that is let go does, in sentences: a turn of more than half a turn (degrees taken for radians), an
    acceleration that no rig bears (mm for m), a period longer than any (ms for s); the largest of each.

    >>> out_of_scale([])
    ()
    """
    return tuple(filter(None, (_turned(motions), _hurled(motions), _slow(motions))))


def _turned(motions: Sequence[Motion]) -> str:
    turned = [motion for motion in motions if motion.recording.coordinate == "rotation"]
    most = max(turned, key=lambda one: one.amplitude, default=None)
    if most is None or not most.amplitude > math.pi:
        return ""
    return (
        f"trial {most.name} is released from {most.amplitude:.3g} rad, more than half a turn (pi): is it in degrees? "
        "correct recordings.channels.displacement.unit, or list unit in recordings.accept"
    )


def _hurled(motions: Sequence[Motion]) -> str:
    moved = [motion for motion in motions if motion.recording.coordinate == "translation"]
    sizes = [(float(np.max(np.abs(motion.windowed("a")))), motion) for motion in moved]
    size, fastest = max(sizes, key=lambda one: one[0], default=(0.0, None))
    if fastest is None or not size > HURLED_M_PER_S2:
        return ""
    return (
        f"trial {fastest.name} is released from {fastest.amplitude:.3g} m and moves with {size / GRAVITY:.3g} g, more "
        f"than {HURLED_M_PER_S2 / GRAVITY:.0f}: is it in mm? correct recordings.channels.displacement.unit or the unit "
        "of time, or list unit in recordings.accept"
    )


def _slow(motions: Sequence[Motion]) -> str:
    found = [(_period(motion), motion) for motion in motions]
    period, slowest = max(found, key=lambda one: one[0], default=(0.0, None))
    if slowest is None or not period > SLOWEST_S:
        return ""
    hurled = float(np.max(np.abs(slowest.windowed("a")))) / MS**2 > HURLED_M_PER_S2
    both = hurled and slowest.recording.coordinate == "translation"
    asked, keys = (
        (f"is its time in ms, and its displacement, {slowest.amplitude:.3g} m at the release, in mm?",
         "recordings.channels.time.unit and recordings.channels.displacement.unit")
        if both else ("is its time in ms?", "recordings.channels.time.unit")
    )  # fmt: skip
    return (
        f"trial {slowest.name} swings with a period of {period:.3g} s, longer than {SLOWEST_S:g} s: {asked} "
        f"correct {keys}, or list unit in recordings.accept"
    )


def _period(motion: Motion) -> float:
    """Its period, s; 0 where it does not swing."""
    if motion.window.end_s - motion.window.release_s < SLOWEST_S:
        return 0.0
    try:
        return dominant_period(motion)
    except IdentificationError:
        return 0.0
