"""Whether a record shows a free decay at all: one that is driven, growing, stuck, chopped, wandering or too slowly
sampled is distinguished from one that can be identified, and said so.

Everything is relative to the record's own swings, period, noise and rate.

Belongs here: those judgements and their sentences. Does not belong here: the swings (swings.py), window and release
(release.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from undertow.conditioning.motion import Window
from undertow.conditioning.release import find_window, followed
from undertow.conditioning.swings import NOISE_RANGE, Swings, find_swings
from undertow.errors import RecordingError
from undertow.recording.catalogue import TimeWindow, cut
from undertow.recording.noise import noise
from undertow.recording.recording import Array, Recording

FEWEST_SAMPLES_PER_PERIOD = 8.0
"""Of fewer samples a period nobody can tell whether a faster motion hides behind them."""

NARROW = 0.5
"""A spectrum with more than this share of its power in one line is an oscillation's."""

LINE_BINS = 2
"""Bins either side of a line that belong to it (a Hann window's)."""

GROWS = 1.2
"""Later swings that are so many times the first one after a release and the deflection that it was released from (else
those of the first half): a body that nothing drives does not do that."""

FEWEST_TO_GROW = 4
"""Swings from which on growth is judged."""

FEWEST_TO_STAY = 6
"""Swings from which on a steady amplitude is judged."""

STEADY_ERRORS = 3.0
"""A decline of fewer standard errors is none."""

STEADY_SHARE = 0.01
"""A decline of the amplitude by less than this over a whole record says nothing of damping."""

REGULAR = 0.02
"""Swings that scatter by less than this about one exponential show their decline by their slope; where they beat, the
largest of the last third over the largest of the first does."""

WANDERS = 1.0
"""What a body swings about may move by this share of its largest deflection; recordings of bodies let go keep 0.35."""

ENDS_AWAY = 1.5
"""The record's end lies within so many of its largest deflections of what it swings about: within 1 where it swings."""

END_SHARE = 0.05
"""The record's end, of which the median is taken."""

QUIET_SHARE = 0.2
"""Part of the record at its end in which a body that stuck does not move."""

STILL = 0.1
"""It does not move there if it moves by less than this share of its largest move."""

HELD_PERIODS = 0.5
"""A body that stays beyond half its deflection for more periods than this may be held: a swing does for a third, a
pendulum from 170 degrees for four tenths, one on a spring that is softer to one side for up to two thirds."""

SURELY_HELD_PERIODS = 2.0 / 3.0
"""Beyond this no spring lets it swing: the soft side takes the whole period, two thirds of it beyond half."""

HELD_STILL = 0.6
"""Share of such a stay in which a body that is held lies within `HELD_WIDTH` of where it mostly lies: one that swings
does for a quarter, on a spring that is softer to one side too."""

HELD_WIDTH = 0.05
"""Of its largest deflection."""

NEARLY_ZERO = 0.1
"""A velocity under this share of its largest is nearly zero."""

CAUGHT_SWINGS = 5.0
"""A swing of more than so many times what each loses does not end in the next one: dry friction stops a body after one
or two."""

CAUGHT_MOST = 2.0
"""The same of the most that any swing lost: one that beats ends between two of its waists."""

CAUGHT_SHARE = 0.2
"""Share of the first swing under which nothing is said to be caught: the small last swings of a body that rubs are not
all seen."""

CAUGHT_WITHIN = 1.5
"""Half periods from the last swing to where the body lies still: later ones were too small to be seen, not cut off."""

GUESSED = 3
"""Samples whose median is where a record begins."""

_OUT = "take the trial out (recordings.exclude)"


def refuse_no_decay(
    recording: Recording,
    window: Window,
    levels: Mapping[str, float] | None = None,
    accepted: Sequence[str] = (),
    end_s: float | None = None,
) -> None:
    """RecordingError for a motion window that shows no free decay, with what it shows and the next step.

    ``levels`` is the noise of every channel, where it is known. A steady amplitude is refused only where no hold was
    seen: a body that was let go may swing on for long. ``accepted`` are doubts that are known: "period" for a low rate,
    "hold" for one that wanders, "damping" for one that grows or does not decline. What follows an ``end_s`` that was
    asked for does not count.
    """
    name = followed(recording)
    level = (levels or {}).get(name) or noise(recording.channels[name])
    rows = (recording.time >= window.release_s) & (recording.time <= window.end_s)
    time, values = recording.time[rows], recording.channels[name][rows]
    seen, unit = find_swings(time, values, level), recording.unit(name)
    last = values if end_s is not None else recording.channels[name]
    reasons = {
        "period": _slowly_sampled(time, values),
        "hold": _wanders(seen, _end_of(last), unit) or _held_again(name, time, values, seen),
        "damping": _grows(seen, values, window.held, unit) or ("" if window.held else _steady(seen))
        or ("" if end_s is not None else _caught(name, recording, window, seen)),
    }
    for kind, reason in reasons.items():
        if reason and kind not in accepted:
            raise RecordingError(f"trial {recording.name}: {reason}")


def why_no_decay(recording: Recording, start_s: float | None = None, end_s: float | None = None) -> str:
    """What a record shows instead of a decay, in one sentence; empty where that is not plain.

    For a record that could not be conditioned; ``start_s`` and ``end_s`` are the window that was asked for.
    """
    try:
        name = followed(recording)
    except RecordingError:
        return ""
    rows = np.ones(recording.time.size, dtype=bool)
    rows &= recording.time >= (-np.inf if start_s is None else start_s)
    rows &= recording.time <= (np.inf if end_s is None else end_s)
    time, values = recording.time[rows], recording.channels[name][rows]
    if time.size < FEWEST_SAMPLES_PER_PERIOD:
        return ""
    reason = _slowly_sampled(time, values)
    level = noise(values)
    if not reason and float(np.ptp(values)) > 10.0 * level:
        seen = find_swings(time, values, level)
        unit = recording.unit(name)
        reason = _moves_once(seen, time, values, unit) if seen.count < 2 else _wanders(seen, _end_of(values), unit)
    return f"trial {recording.name}: {reason}" if reason else ""


@dataclass(frozen=True)
class HoldSeen:
    """A hold that a window begins with: where it seems to end, s in the recording's time, and how it is ``seen``."""

    end_s: float
    seen: str

    def sentence(self, used_from_s: float | None) -> str:
        """That in words, with where the trial's start was moved to, if it was."""
        if used_from_s is None:
            left = f"seems not to be cut off; set trials.window.start_s near {self.end_s:.3g} s, or"
        else:
            left = f"is cut off, and the trial used from {used_from_s:.4g} s on; set trials.window.start_s there, or"
        return f"{self.seen}: a hold before the release {left} list hold in recordings.accept"


def hold_not_cut(recording: Recording, window: Window, levels: Mapping[str, float] | None = None) -> HoldSeen | None:
    """That a window begins with a body that was still held; None where its release was seen, or no hold is.

    A swing lies beyond half its deflection for a third of its period; a velocity is nearly zero for a thirtieth.
    """
    name = followed(recording)
    rows = (recording.time >= window.start_s) & (recording.time <= window.end_s)
    time, values = recording.time[rows], recording.channels[name][rows]
    if window.held or name == "acceleration" or time.size < FEWEST_SAMPLES_PER_PERIOD:
        return None
    level = (levels or {}).get(name) or noise(recording.channels[name])
    seen = find_swings(time, values, level)
    if seen.count < 2:
        return None
    away = values - float(np.median(seen.centre))
    size, period = float(np.max(np.abs(away))), 2.0 * seen.half_period_s
    if name == "displacement":
        first = float(np.median(away[:GUESSED]))
        left, usual = np.flatnonzero(np.sign(first) * away < 0.5 * size), period / 3.0
    else:
        left, usual = np.flatnonzero(np.abs(away) > max(NEARLY_ZERO * size, NOISE_RANGE * level)), period / 30.0
    stayed = float(time[left[0]] - time[0]) if left.size else 0.0
    if stayed <= HELD_PERIODS * period:
        return None
    end = float(time[0]) + stayed - 0.5 * usual
    where = "on one side" if name == "displacement" else "at rest"
    return HoldSeen(
        end,
        f"it stays {where} for {stayed:.3g} s at the window's start, and a swing of {period:.3g} s does so for "
        f"{usual:.2g} s",
    )


def after_hold(
    recording: Recording, window: Window, hold: HoldSeen, end_s: float | None, levels: Mapping[str, float]
) -> Window | None:
    """The window without a hold that it begins with: from the release on where that is seen in it, else from where the
    hold seems to end; None where neither leaves a motion that begins without one."""
    inside = cut(recording, TimeWindow(window.start_s))
    for start_s in (None, hold.end_s):
        try:
            found = find_window(inside, start_s, end_s, levels)
        except RecordingError:
            continue
        if (found.held or start_s is not None) and hold_not_cut(inside, found, levels) is None:
            return found
    return None


def _held_again(name: str, time: Array, values: Array, seen: Swings) -> str:
    """That after swings the body is held away from rest once more: another release follows in the same record. Only a
    displacement shows it."""
    if name != "displacement" or seen.count < FEWEST_TO_GROW:
        return ""
    away = values - float(np.median(seen.centre))
    side = np.sign(away) * (np.abs(away) > 0.5 * float(np.max(np.abs(away))))
    ends = np.flatnonzero(np.diff(side)) + 1
    starts, ends = np.r_[0, ends], np.r_[ends, side.size] - 1
    lasted = np.where((side[starts] != 0.0) & (starts > 0), time[ends] - time[starts], 0.0)
    period, width = 2.0 * seen.half_period_s, HELD_WIDTH * float(np.max(np.abs(away)))
    parts = [away[start:end + 1] for start, end in zip(starts, ends, strict=True)]
    still = np.array([np.mean(np.abs(part - np.median(part)) < width) for part in parts]) > HELD_STILL
    long = np.flatnonzero((lasted > SURELY_HELD_PERIODS * period) | (lasted > HELD_PERIODS * period) & still)
    if not long.size:
        return ""
    first = int(long[0])
    at, more = float(time[starts[first]]), f", and {long.size - 1} times more" if long.size > 1 else ""
    return (
        f"it stays on one side for {lasted[first]:.3g} s from {at:.3g} s on{more}, and a swing of "
        f"{period:.3g} s does so for {period / 3.0:.2g} s: it is held again; set "
        f"trials.window.end_s before {at:.3g} s, give a second release as a trial of its own (recordings.releases), or "
        "list hold in recordings.accept"
    )


def _caught(name: str, recording: Recording, window: Window, seen: Swings) -> str:
    """That a body which swung lies still from one swing to the next; only a displacement shows it."""
    sizes, after = 0.5 * seen.size[seen.whole], recording.time > window.end_s
    still = recording.channels["displacement"][after] if name == "displacement" else np.empty(0)
    lies = recording.time[-1] - window.end_s
    if sizes.size < FEWEST_TO_STAY or not still.size or lies < 2.0 * seen.half_period_s:
        return ""
    last, lost = float(sizes[-2]), -np.diff(sizes[:-1])
    least = max(CAUGHT_SWINGS * float(np.median(lost[1 - FEWEST_TO_STAY :])), CAUGHT_MOST * float(np.max(lost)))
    if last < max(least, CAUGHT_SHARE * float(sizes[0])) or float(np.ptp(still)) > STILL * 2.0 * last:
        return ""
    before, at = (float(t) for t in seen.time[1:][seen.whole][-2:])
    if window.end_s - at > CAUGHT_WITHIN * seen.half_period_s:
        return ""
    unit, each = recording.unit(name), float(np.median(lost))
    return (
        f"it swings by {last:.3g} {unit} at {before:.3g} s, each swing {each:.2g} {unit} less than the one before, and "
        f"lies still from {window.end_s:.3g} s on: it was caught or stopped; set trials.window.end_s before "
        f"{before:.3g} s, or list damping in recordings.accept"
    )


def _slowly_sampled(time: Array, values: Array) -> str:
    """That the rate is too low for the motion, by the one line of its spectrum."""
    steps = np.arange(values.size)
    rest = values - np.polyval(np.polyfit(steps, values, 1), steps)
    power = np.abs(np.fft.rfft(rest * np.hanning(values.size))) ** 2
    power[: LINE_BINS - 1] = 0.0
    total = float(np.sum(power))
    if total <= 0.0:
        return ""
    peak = int(np.argmax(power))
    line = float(np.sum(power[max(peak - LINE_BINS, 0) : peak + LINE_BINS + 1]))
    a_period = values.size / peak if peak else math.inf
    if a_period >= FEWEST_SAMPLES_PER_PERIOD or line < NARROW * total:
        return ""
    rate = (values.size - 1) / float(time[-1] - time[0])
    return (
        f"its motion of {rate / a_period:.3g} Hz has {a_period:.1f} samples a period at {rate:.3g} Hz; a decay needs "
        f"{FEWEST_SAMPLES_PER_PERIOD:.0f}, and a faster motion may hide behind so few: record at "
        f"{2.0 * FEWEST_SAMPLES_PER_PERIOD * rate / a_period:.2g} Hz or more, or list period in recordings.accept"
    )


def _moves_once(seen: Swings, time: Array, values: Array, unit: str) -> str:
    """That a body hardly swung, or not, after it moved, or that the record ends before it did."""
    largest = float(np.ptp(values))
    last = values[time >= time[-1] - QUIET_SHARE * (time[-1] - time[0])]
    away = np.flatnonzero(np.abs(values - values[0]) > STILL * largest)
    begun = float(time[away[0]]) if away.size else float(time[0])
    swung = max(seen.time.size - 2, 0)
    rests = float(np.ptp(last)) < STILL * largest
    if rests and swung < 2:
        end = float(np.median(last))
        return (
            f"it moves from {values[0]:.3g} to {end:.3g} {unit} at {begun:.3g} s and stays there without swinging: "
            f"friction or damping stops it within a swing, or it was not let go; release it from further, or {_OUT}"
        )
    if not swung:
        return (
            f"it goes from {values[0]:.3g} to {values[-1]:.3g} {unit} and never turns: the record ends within its "
            f"first swing, it was not let go, or its sensor drifts; correct trials.window, or {_OUT}"
        )
    return (
        f"it turns {'once' if swung == 1 else f'{swung} times'} between {begun:.3g} s, where it begins to move, and "
        f"{time[-1]:.3g} s, where it {'lies still' if rests else 'ends'}; a decay needs 3 turns: "
        f"{'release it from further' if rests else 'record longer'}, or correct trials.window"
    )


def _end_of(values: Array) -> float:
    """Where a record ends."""
    return float(np.median(values[-max(round(END_SHARE * values.size), 1) :]))


def _wanders(seen: Swings, end: float, unit: str) -> str:
    """That what it swings about moves by more than it swings: drift, a jump, a hand; ``end`` is where it ends."""
    if seen.count < 2:
        return ""
    centre, whole = seen.centre, seen.size[seen.whole]
    middle, deflection = float(np.median(centre)), 0.5 * float(np.max(whole))
    moved = float(np.ptp(centre))
    if moved > WANDERS * deflection:
        low, high = sorted((int(np.argmin(centre)), int(np.argmax(centre))))
        return (
            f"what it swings about moves by {moved:.3g} {unit} between {seen.time[low + 2]:.3g} and "
            f"{seen.time[high + 2]:.3g} s, and it swings by {deflection:.3g} {unit}: a sensor that drifts or jumps, or "
            f"a hand; end trials.window before it, or {_OUT}, or list hold in recordings.accept"
        )
    if abs(end - middle) > ENDS_AWAY * deflection:
        return (
            f"it swings about {middle:.3g} {unit} and ends at {end:.3g} {unit}, further away than it ever swung "
            f"({deflection:.3g} {unit}): it was caught or moved; end trials.window at {seen.time[-2]:.3g} s, or list "
            "hold in recordings.accept"
        )
    return ""


def _grows(seen: Swings, values: Array, held: bool, unit: str) -> str:
    """That later swings are larger than earlier ones; of a body let go from a hold also than where it was held: beside
    a second body it may stand still in between and swing as far again, but no further."""
    sizes = 0.5 * seen.size[seen.whole]
    if sizes.size < FEWEST_TO_GROW:
        return ""
    half = 1 if held else sizes.size // 2
    first, later = float(np.max(sizes[:half])), float(np.max(sizes[half:]))
    if held:
        first = max(first, abs(float(np.median(values[:GUESSED])) - float(np.median(seen.centre))))
    if later <= GROWS * first:
        return ""
    at = float(seen.time[1:][seen.whole][half + int(np.argmax(sizes[half:]))])
    return (
        f"its swings grow from {first:.3g} to {later:.3g} {unit} at {at:.3g} s: something drives it, or it is let go "
        f"only then; set trials.window.start_s where it is let go, or {_OUT}, or list damping in recordings.accept"
    )


def _steady(seen: Swings) -> str:
    """That the amplitude does not decline beyond what its own scatter leaves open."""
    sizes = seen.size[seen.whole]
    if sizes.size < FEWEST_TO_STAY:
        return ""
    at, third = np.arange(sizes.size), sizes.size // 3
    slope, start = np.polyfit(at, np.log(sizes), 1)
    spread = float(np.std(np.log(sizes) - start - slope * at, ddof=2))
    if spread < REGULAR:
        decline, error = -float(slope) * sizes.size, spread * math.sqrt(12.0 / sizes.size)
    else:
        decline, error = 1.0 - float(np.max(sizes[-third:]) / np.max(sizes[:third])), 0.0
    if decline > max(STEADY_ERRORS * error, STEADY_SHARE):
        return ""
    return (
        f"its amplitude declines by {100.0 * decline:.2g} % in {0.5 * sizes.size:.3g} periods and no hold is seen "
        "before: it is driven, or the record is too short for its damping; record a release until the amplitude has "
        f"halved, or {_OUT}, or list damping in recordings.accept"
    )
