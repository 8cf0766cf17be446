"""Where a channel is cut off at the end of its sensor's range.

Belongs here: how a cut is seen in samples. Does not belong here: what follows for a trial (quality.py) and for
others (campaign/run/cut_off.py).
"""

from __future__ import annotations

import math

import numpy as np

from undertow.errors import RangeEnd
from undertow.recording.noise import noise
from undertow.recording.recording import Array

PLATEAU_SAMPLES = 5
"""An unclipped peak, finely sampled and quantised, rests this long on its last step only if it is flat there."""

PLATEAU_DROP_QUANTA = 10.0
"""A parabola that rests L samples on its top step has fallen 4 steps at L from its middle (x'' L^2/2 with
L = 2 sqrt(2q/x'')) and a fifth by rounding; a clipped peak leaves at full speed. Twice that divides them."""

LEVEL_BAND = 8.0
"""Noise scatters a level of some hundred samples over so many standard deviations."""

LEVEL_DROP = 3.0
"""A peak that reaches through that whole band and is not cut has fallen four times as much at its own length."""

LEVEL_KINK = 10.0
"""A level left so much faster is one, however short: a peak with five samples in the band has fallen by six bands at
its own length, one with more by less. Of 4,000 swings of 20 to 200 samples a period that nothing cuts none was called
so; of the same ones cut at .6 to .95 of their size 75 % are (56 % by the longer ones alone)."""

LEVEL_SHORT = 5
"""Samples in the band of such a level at least."""

LEVEL_RUN = 7
"""A peak of fewer samples within the band, whose ends are left out, is as flat as a level: of 6,000 swings that nothing
cuts nine had a level with five samples, none with seven."""

LEVEL_SAMPLES = 16
"""So many samples tell these apart where a level is left more slowly."""

LEVEL_BEND = -2.0
"""A level does not bend: its part that goes with the square of time is noise, a peak's some 4 to 7 deviations below."""

LEVEL_PARTS = 40
"""Samples of a swing from which slow noise is estimated: of more it looks smaller, in fewer the swing is not smooth."""

FOLLOWED = 0.2
"""A swing is followed from a level on over this share of the channel's range: some 50 degrees from rest."""

FOLLOWED_BANDS = 8.0
"""... and over so many bands of noise at least."""

PASSED = 0.2
"""A swing whose parabola goes beyond the level by less than this share of the way that it is followed was let go from
rest there, which a hold is, however it was come to: of 1,500 holds after a pull at constant speed 3 % pass for more
(short ones, seen coarsely), of 2,000 swings cut at .6 to .95 of their size 1 % for less."""

SWINGS_BACK = 0.2
"""A body swings further to the other side of where it ends than this share of the level it begins with; one that creeps
back leaves its hold at once, too."""

BEGINS_PASSED = 0.5
"""A level that a record begins with is left at speed from this share on: of 1,000 holds from the first sample on, with
noise up to .004 of their size, none passes for more than .4; of as many swings cut at .6 to .95 84 % do."""

NOISE_FREE_SHARE = 1e-5
"""Noise below this share of the range is a simulation's: its hold may well be constant."""


def plateaus(values: Array, step: float) -> int:
    """How often a channel (n,) runs into its own largest or smallest value and leaves it at speed.

    A plateau is `PLATEAU_SAMPLES` or more samples exactly at the extreme, with a fall of `PLATEAU_DROP_QUANTA` steps
    on both sides within half its length. A quantised peak has less of one; the hold before a release is left from rest.
    """
    found = 0
    for extreme, sign in ((np.max(values), 1.0), (np.min(values), -1.0)):
        for start, end in runs(values == extreme):
            reach = max((end - start) // 2, 3)
            if end - start < PLATEAU_SAMPLES or start < reach or end + reach > values.size:
                continue
            before, after = values[start - reach], values[end - 1 + reach]
            fall = min(sign * (extreme - before), sign * (extreme - after))
            far = max(FOLLOWED * float(np.ptp(values)), PLATEAU_DROP_QUANTA * step)
            cut = _goes_beyond(sign * (extreme - values[end:]), far) > PASSED
            found += bool(fall > PLATEAU_DROP_QUANTA * step and cut)
    return found


def levels(values: Array, sigma: float) -> tuple[RangeEnd, ...]:
    """Where a channel (n,) with noise of ``sigma`` comes to a level and leaves it at speed: the ends of a sensor's
    range, whose noise is added afterwards.

    Samples within `LEVEL_BAND` of the extreme are a peak. Where nothing cuts it, it bends; a peak that hardly reaches
    into the band has fallen little at its own length. What is left from rest is a hold. Noise may be slower than the
    samples, as behind a filter: what it is over a fortieth of a swing counts where that is more.
    """
    if sigma <= NOISE_FREE_SHARE * float(np.ptp(values)):
        return ()
    sigma = _slow_too(values, sigma)
    found: list[RangeEnd] = []
    for sign in (1.0, -1.0):
        signed, band = sign * values, LEVEL_BAND * sigma
        high = float(np.max(signed))
        tops, kinked = [np.zeros(0)], False
        for start, end in runs(signed > high - band):
            reach = max((end - start) // 2, 3)
            if end - start < LEVEL_SHORT or start < reach or end + reach > signed.size:
                continue
            fall = high - max(signed[start - reach], signed[end - 1 + reach])
            leaves_at_once = bool(fall > LEVEL_KINK * band)
            top = signed[start + 1 : end - 1]  # its first and last sample may be on the way
            far = max(FOLLOWED * float(np.ptp(values)), FOLLOWED_BANDS * band)
            if _goes_beyond(float(np.mean(top)) - signed[end:], far) <= PASSED:
                continue
            if leaves_at_once or (end - start >= LEVEL_RUN and fall > LEVEL_DROP * band):
                tops.append(top)
                kinked |= leaves_at_once
        samples, bend = np.concatenate(tops), sum(_bend(top) for top in tops) / math.sqrt(max(len(tops) - 1, 1))
        if (samples.size >= LEVEL_SAMPLES or kinked) and bend > LEVEL_BEND * sigma:
            found.append(RangeEnd(sign * float(np.mean(samples)), sign > 0.0, band))
    return tuple(found)


def begins_cut(values: Array, sigma: float) -> float | None:
    """The level that a channel (n,) with noise of ``sigma`` begins with and leaves at speed: the end of a sensor's
    range, or where a body was pushed and not let go. None where it does not, or noise hides how it is left."""
    if sigma <= NOISE_FREE_SHARE * float(np.ptp(values)):
        return None
    band, far = LEVEL_BAND * _slow_too(values, sigma), FOLLOWED * float(np.ptp(values))
    if FOLLOWED_BANDS * band > far:
        return None
    for sign in (1.0, -1.0):
        signed = sign * values
        start, end = runs(signed > float(np.max(signed)) - band)[0]
        top = signed[start + 1 : end - 1]
        if start > 0 or top.size < LEVEL_SAMPLES or _bend(top) <= LEVEL_BEND * band / LEVEL_BAND:
            continue
        rest = float(np.median(signed[-max(signed.size // 20, 1) :]))
        if rest - float(np.min(signed)) < SWINGS_BACK * (float(np.mean(top)) - rest):
            continue
        if _goes_beyond(float(np.mean(top)) - signed[end:], far) > BEGINS_PASSED:
            return sign * float(np.mean(top))
    return None


def _slow_too(values: Array, sigma: float) -> float:
    """Noise, 1 sigma, with what is slower than the samples: over a fortieth of a swing."""
    cycles = 1 + int(np.argmax(np.abs(np.fft.rfft(np.diff(values)))[1:]))
    return max(sigma, noise(values[:: max(values.size // (cycles * LEVEL_PARTS), 1)]))


def _goes_beyond(falls: Array, far: float) -> float:
    """How far beyond a level a swing goes that leaves it, as a share of the way that it is followed: by the vertex of a
    parabola through its falls (n,) below the level, the first one on, up to ``far``. 0 from rest, or where it does not
    fall; inf of a straight line, and of fewer than three samples."""
    past = np.flatnonzero(falls >= far)
    way = falls[: max(int(past[0]) + 1, 3)] if past.size else falls
    if way.size < 3:
        return math.inf
    if float(np.max(way)) <= 0.0:
        return 0.0
    c2, c1, c0 = np.polyfit(np.arange(way.size), way, 2)
    return float(c1**2 / (4.0 * c2) - c0) / float(np.max(way)) if c2 > 0.0 else math.inf


def _bend(top: Array) -> float:
    """The part of a run of samples (n,) that goes with the square of time, as one normalised coefficient: of noise its
    standard deviation is the noise's; of a peak it is negative. 0 of fewer than four samples."""
    if top.size < 4:
        return 0.0
    u = np.linspace(-1.0, 1.0, top.size)
    shape = u**2 - np.mean(u**2)
    return float(shape @ top) / math.sqrt(float(shape @ shape))


def longest_hold(values: Array) -> int:
    """Longest run of samples exactly at the largest or smallest value."""
    lengths = [e - s for extreme in (np.max(values), np.min(values)) for s, e in runs(values == extreme)]
    return max(lengths, default=0)


def runs(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> list[tuple[int, int]]:
    """Half-open index ranges where a mask (n,) holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
