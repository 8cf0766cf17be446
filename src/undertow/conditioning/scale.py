"""Motions out of scale: larger, faster or slower than any body that is let go, as a wrong unit makes them.

Belongs here: those looks and their sentences. Does not belong here: channels against each other (agreement.py), numbers
of an equation (campaign/run/plausible.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from undertow.conditioning.driven import OUTPUTS, DrivenTrial
from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.errors import IdentificationError
from undertow.recording.parts import UNCALIBRATED
from undertow.recording.recording import Coordinate

GRAVITY, HURLED_M_PER_S2 = 9.81, 981.0
"""Gravity, and an acceleration of a hundred times that: no body on springs that was let go has it."""

SLOWEST_S = 400.0
"""A longer period is none of a test: moored ships take some minutes; milliseconds taken for seconds are longer."""

MS = 1e-3
"""Seconds of a millisecond."""

TINY = 1e-12
"""Rate of what does not move, rad/s."""


def out_of_scale(motions: Sequence[Motion]) -> tuple[str, ...]:
    """What no body that is let go does, in sentences: a turn of more than half a turn (degrees taken for radians), an
    acceleration that no rig bears (mm for m), a period longer than any (ms for s); the largest of each.

    >>> out_of_scale([])
    ()
    """
    return tuple(filter(None, (_turned(motions), _hurled(motions), _slow(motions))))


def driven_out_of_scale(trials: Sequence[DrivenTrial], coordinate: Coordinate = "translation") -> tuple[str, ...]:
    """The same of bodies that are driven, by the rate at which half of a record's power is faster; the largest of each.

    >>> import numpy as np
    >>> t = np.arange(0.0, 10.0, 0.01)
    >>> trial = DrivenTrial("r1", t, np.sin(9.0 * t), {"displacement": 30.0 * np.sin(9.0 * t)})
    >>> [said] = driven_out_of_scale([trial])
    >>> said.partition(":")[0]
    'trial r1 moves by 30 m with 237 g, more than 100'
    """
    moved = [one for one in trials if OUTPUTS[0] in one.outputs]
    sizes = {one.name: float(np.max(np.abs(one.outputs[OUTPUTS[0]]))) for one in moved}
    rates = {one.name: _rate(one) for one in moved}
    name = max(sizes, key=lambda one: sizes[one] * rates[one] ** 2, default="")
    if not name:
        return ()
    hurled, period = sizes[name] * rates[name] ** 2, 2.0 * math.pi / max(min(rates.values()), TINY)
    said = []
    if coordinate == "rotation" and max(sizes.values()) > math.pi:
        said.append(f"a body turns by {max(sizes.values()):.3g} rad, more than half a turn (pi): is it in degrees?")
    if coordinate == "translation" and hurled > HURLED_M_PER_S2:
        said.append(
            f"trial {name} moves by {sizes[name]:.3g} m with {hurled / GRAVITY:.3g} g, more than "
            f"{HURLED_M_PER_S2 / GRAVITY:.0f}: is it in mm?"
        )
    if period > SLOWEST_S:
        said.append(
            f"trial {min(rates, key=lambda one: rates[one])} moves with a period of {period:.3g} s, longer than "
            f"{SLOWEST_S:g} s: is its time in ms?"
        )
    return tuple(f"{one} Correct the unit of the displacement or of the time" for one in said)


def _rate(trial: DrivenTrial) -> float:
    """The rate at which half of a record's power is faster, rad/s; a record is as long as it swings at least."""
    values = trial.outputs[OUTPUTS[0]]
    power = np.cumsum(np.abs(np.fft.rfft((values - values.mean()) * np.hanning(values.size))) ** 2)
    at = int(np.searchsorted(power, 0.5 * power[-1]))
    return 2.0 * math.pi * at / float(trial.t[-1] - trial.t[0])


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
    moved = [one for one in motions if one.recording.coordinate == "translation" and not _uncalibrated(one)]
    sizes = [(float(np.max(np.abs(motion.windowed("a")))), motion) for motion in moved]
    size, fastest = max(sizes, key=lambda one: one[0], default=(0.0, None))
    if fastest is None or not size > HURLED_M_PER_S2:
        return ""
    return (
        f"trial {fastest.name} is released from {fastest.amplitude:.3g} m and moves with {size / GRAVITY:.3g} g, more "
        f"than {HURLED_M_PER_S2 / GRAVITY:.0f}: is it in mm? correct recordings.channels.displacement.unit or the unit "
        "of time, or list unit in recordings.accept"
    )


def _uncalibrated(motion: Motion) -> bool:
    """Whether its displacement is in a scale that is no unit of length."""
    return any(UNCALIBRATED in note for note in motion.recording.notes if note.startswith("displacement "))


def _slow(motions: Sequence[Motion]) -> str:
    found = [(_period(motion), motion) for motion in motions]
    period, slowest = max(found, key=lambda one: one[0], default=(0.0, None))
    if slowest is None or not period > SLOWEST_S:
        return ""
    hurled = float(np.max(np.abs(slowest.windowed("a")))) / MS**2 > HURLED_M_PER_S2
    both = hurled and slowest.recording.coordinate == "translation" and not _uncalibrated(slowest)
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
