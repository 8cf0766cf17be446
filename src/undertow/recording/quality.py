"""Whether a recording can be used: noise, finest step, clipping, gaps; doubts in words, and errors where it cannot.

Belongs here: what the samples say of the sensor. Does not belong here: what they say of the motion (conditioning).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from undertow.errors import ClippedError, RangeEnd, RecordingError
from undertow.recording.doubt_kinds import DoubtKind
from undertow.recording.dropouts import find_dropouts
from undertow.recording.recording import INPUTS, Array, Recording
from undertow.recording.spikes import MAD_TO_SIGMA, find_spikes

FEWEST_SAMPLES = 50
"""Below this a recording holds less than three cycles at twenty samples each, and a decrement is guesswork."""

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

SATURATED_SAMPLES = 30
"""A quantised channel whose noise is a whole step repeats a value 30 times in a row once in 10^9 tries."""

NOISE_FREE_SHARE = 1e-5
"""Noise below this share of the range is a simulation's: its hold may well be constant."""

GAP_STEPS = 1.5
"""A step longer than this many median steps lacks at least one sample."""

UNEVEN_SHARE = 0.05
"""Relative standard deviation of the time steps above which evenness is doubted."""

SNAP_SAMPLES = 20
"""Spikes that all lie within so many samples are one event, the release most of all, and no faulty sensor."""

FILLED_REACH = 1.5
"""A number this many ranges from the middle of the others is one that loggers write for no value, such as -9999."""

_ORDERS = range(2, 9)  # differences of these orders: each removes the motion better than the one before


@dataclass(frozen=True)
class Doubt:
    """One sentence about the samples of a ``channel`` ("time" for its steps); ``kind`` is what a config accepts it as,
    None where it is a note alone."""

    sentence: str
    channel: str
    kind: DoubtKind | None = None


@dataclass(frozen=True)
class ChannelSummary:
    """One channel: extremes, ``noise`` (1 sigma, rounding included), ``quantum`` (finest step, 0: none seen), all in
    ``unit``; how many samples look like spikes; ``plateaus``, the times a peak was cut at the channel's own extreme.
    """

    unit: str
    minimum: float
    maximum: float
    noise: float
    quantum: float
    spikes: int
    plateaus: int


@dataclass(frozen=True)
class RecordingSummary:
    """A recording at a glance. ``gaps`` counts steps in time that lack samples; ``unevenness`` is the relative
    standard deviation of the other steps; ``doubts`` are sentences.
    """

    name: str
    samples: int
    duration_s: float
    rate_hz: float
    gaps: int
    largest_gap_s: float
    unevenness: float
    channels: Mapping[str, ChannelSummary]
    doubts: tuple[str, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "channels", MappingProxyType(dict(self.channels)))


def quantum(values: Array) -> float:
    """Finest step of a channel in its unit; 0 where values lie on no grid that can be seen.

    >>> round(quantum(np.round(np.sin(np.linspace(0.0, 9.0, 500)) / 0.01) * 0.01), 6)
    0.01
    """
    levels = np.unique(values)
    steps = np.diff(levels)
    steps = steps[steps > 1e-9 * max(float(np.ptp(values)), 1e-300)]
    if steps.size < 2:
        return float(steps[0]) if steps.size else 0.0
    finest = float(np.median(steps[steps < 1.5 * np.min(steps)]))
    near = steps[steps < 5.5 * finest] / finest
    # printing rounds a grid to decimals, which moves steps of a few quanta by at most a fifth of one
    on_grid = float(np.mean(np.abs(near - np.round(near)) < 0.2))
    if on_grid > 0.95 and levels.size < 0.9 * values.size:
        return finest
    return float(np.median(steps)) if levels.size < values.size / 20 else 0.0  # an uneven grid, visited often


def noise(values: Array) -> float:
    """Standard deviation of what is no motion (n,), rounding included, in the values' unit.

    White noise of variance s^2 has a d-th difference of variance C(2d, d) s^2, while a smooth motion's shrinks with
    every order: the smallest estimate among orders 2 to 8 is taken, by the median of absolute differences, so that
    spikes and the release do not count. A channel rounded to steps q has at least q / sqrt(12).

    >>> rng = np.random.default_rng(1); t = np.arange(4000) / 250
    >>> round(noise(0.1 * np.cos(6 * t) + rng.normal(0, 1e-3, t.size)), 4)
    0.001
    """
    floor = quantum(values) / math.sqrt(12.0)
    sizes = []
    for order in _ORDERS:
        differences = np.diff(values, n=order)
        if differences.size:
            size = MAD_TO_SIGMA * float(np.median(np.abs(differences)))
            sizes.append(size / math.sqrt(math.comb(2 * order, order)))
    return max(min(sizes, default=0.0), floor)


def plateaus(values: Array, step: float) -> int:
    """How often a channel (n,) runs into its own largest or smallest value and leaves it at speed.

    A plateau is `PLATEAU_SAMPLES` or more samples exactly at the extreme, with a fall of `PLATEAU_DROP_QUANTA` steps
    on both sides within half its length. The hold before a release has no such fall on its left, a quantised peak
    has less of one.
    """
    found = 0
    for extreme, sign in ((np.max(values), 1.0), (np.min(values), -1.0)):
        for start, end in _runs(values == extreme):
            reach = max((end - start) // 2, 3)
            if end - start < PLATEAU_SAMPLES or start < reach or end + reach > values.size:
                continue
            before, after = values[start - reach], values[end - 1 + reach]
            fall = min(sign * (extreme - before), sign * (extreme - after))
            found += bool(fall > PLATEAU_DROP_QUANTA * step)
    return found


def levels(values: Array, sigma: float) -> tuple[RangeEnd, ...]:
    """Where a channel (n,) with noise of ``sigma`` comes to a level and leaves it at speed: the ends of a sensor's
    range, whose noise is added afterwards.

    Samples within `LEVEL_BAND` of the extreme are a peak. Where nothing cuts it, it bends; a peak that hardly reaches
    into the band has fallen little at its own length. Noise may be slower than the samples, as behind a filter: what
    it is over a fortieth of a swing counts where that is more.
    """
    if sigma <= NOISE_FREE_SHARE * float(np.ptp(values)):
        return ()
    cycles = 1 + int(np.argmax(np.abs(np.fft.rfft(np.diff(values)))[1:]))
    sigma = max(sigma, noise(values[:: max(values.size // (cycles * LEVEL_PARTS), 1)]))
    found: list[RangeEnd] = []
    for sign in (1.0, -1.0):
        signed, band = sign * values, LEVEL_BAND * sigma
        high = float(np.max(signed))
        tops, kinked = [np.zeros(0)], False
        for start, end in _runs(signed > high - band):
            reach = max((end - start) // 2, 3)
            if end - start < LEVEL_SHORT or start < reach or end + reach > signed.size:
                continue
            fall = high - max(signed[start - reach], signed[end - 1 + reach])
            leaves_at_once = bool(fall > LEVEL_KINK * band)
            if leaves_at_once or (end - start >= LEVEL_RUN and fall > LEVEL_DROP * band):
                tops.append(signed[start + 1 : end - 1])  # its first and last sample may be on the way
                kinked |= leaves_at_once
        samples, bend = np.concatenate(tops), sum(_bend(top) for top in tops) / math.sqrt(max(len(tops) - 1, 1))
        if (samples.size >= LEVEL_SAMPLES or kinked) and bend > LEVEL_BEND * sigma:
            found.append(RangeEnd(sign * float(np.mean(samples)), sign > 0.0, band))
    return tuple(found)


def _bend(top: Array) -> float:
    """The part of a run of samples (n,) that goes with the square of time, as one normalised coefficient: of noise its
    standard deviation is the noise's; of a peak it is negative. 0 of fewer than four samples."""
    if top.size < 4:
        return 0.0
    u = np.linspace(-1.0, 1.0, top.size)
    shape = u**2 - np.mean(u**2)
    return float(shape @ top) / math.sqrt(float(shape @ shape))


def check(recording: Recording, accepted: Sequence[str] = ()) -> tuple[str, ...]:
    """Doubts about a recording, in sentences; raises as `doubts` does."""
    return tuple(doubt.sentence for doubt in doubts(recording, accepted))


def doubts(recording: Recording, accepted: Sequence[str] = ()) -> tuple[Doubt, ...]:
    """Doubts about a recording; with "clipping" among what is ``accepted`` a cut channel is one of them.

    Raises RecordingError where an answer would be wrong (too few samples, a constant channel), ClippedError for a
    channel that is cut off.
    """
    if recording.time.size < FEWEST_SAMPLES:
        raise RecordingError(
            f"trial {recording.name} has {recording.time.size} samples; at least {FEWEST_SAMPLES} are needed for three "
            "cycles: is it the right file, or a cut copy?"
        )
    found = [Doubt(sentence, "time") for sentence in _doubts_of_time(recording)]
    for name, values in recording.channels.items():
        try:
            found += _doubts_of_channel(recording, name, values, accepted)
        except ClippedError as cut:
            if "clipping" not in accepted:
                raise
            said = str(cut).removeprefix(f"trial {recording.name}: ")
            found.append(Doubt(f"accepted (clipping): {said}", name))
    return tuple(found)


def summary(recording: Recording) -> RecordingSummary:
    """What is in a recording, for ``undertow inspect``; what `check` would raise stands among the doubts."""
    try:
        said = check(recording)
    except RecordingError as error:
        said = (str(error),)
    steps = np.diff(recording.time)
    usual = float(np.median(steps)) if steps.size else math.nan
    gaps = steps[steps > GAP_STEPS * usual]
    even = steps[steps <= GAP_STEPS * usual]
    return RecordingSummary(
        recording.name, recording.time.size, recording.duration_s, 1.0 / usual, gaps.size,
        float(np.max(gaps, initial=0.0)), float(np.std(even) / usual) if even.size else math.nan,
        {name: _channel_summary(recording, name, values) for name, values in recording.channels.items()}, said,
    )  # fmt: skip


def _channel_summary(recording: Recording, name: str, values: Array) -> ChannelSummary:
    step = quantum(values)
    return ChannelSummary(
        recording.unit(name), float(np.min(values)), float(np.max(values)), noise(values), step,
        len(_spikes(recording, values)), plateaus(values, step),
    )  # fmt: skip


def _doubts_of_time(recording: Recording) -> list[str]:
    steps = np.diff(recording.time)
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP_STEPS * usual)
    doubts = []
    if gaps.size:
        worst = gaps[np.argmax(steps[gaps])]
        doubts.append(
            f"{gaps.size} gaps in time, the longest of {steps[worst]:.3g} s (usual step {usual:.3g} s) at "
            f"{recording.time[worst]:.4g} s"
        )
    even = steps[steps <= GAP_STEPS * usual]
    uneven = float(np.std(even) / usual)
    if uneven > UNEVEN_SHARE:
        doubts.append(f"time steps scatter by {uneven:.0%} of {usual:.3g} s; more than {UNEVEN_SHARE:.0%} is uneven")
    return doubts


def _doubts_of_channel(recording: Recording, name: str, whole: Array, accepted: Sequence[str]) -> list[Doubt]:
    unit = recording.unit(name)
    low, high = float(np.min(whole)), float(np.max(whole))
    if low == high:
        raise RecordingError(
            f"trial {recording.name}: {name} is constant at {low:.6g} {unit} over {recording.duration_s:.3g} s; "
            "was the sensor connected? take it out of recordings.channels or exclude the trial"
        )
    found, values = _without_lost(recording, name, whole, accepted)
    low, high = float(np.min(values)), float(np.max(values))
    step = quantum(values)
    cut = plateaus(values, step)
    held = _longest_hold(values)
    stuck = held >= SATURATED_SAMPLES and _rough(values) > max(step, NOISE_FREE_SHARE * (high - low))
    sigma = noise(values)
    smooth = name != "acceleration" and INPUTS.keys().isdisjoint(recording.channels)
    flat = levels(values, sigma) if smooth else ()  # an acceleration jumps at the release, a driven body may rest
    if cut >= 2 or stuck or flat:
        said = f"{cut} peaks are cut" if cut >= 2 else f"{held} samples in a row do not move at all"
        said = f"{said} at the extreme value" if cut >= 2 or stuck else (
            f"swings end at {' and at '.join(f'{end.value:.6g}' for end in flat)} {unit}, flat but for noise"
        )  # fmt: skip
        raise ClippedError(
            f"trial {recording.name}: {name} is clipped between {low:.6g} and {high:.6g} {unit}: {said}; widen the "
            "sensor's range, take it out of recordings.channels, or start trials.window later", name, flat
        )  # fmt: skip
    if cut == 1:
        found.append(Doubt(f"{name}: one peak looks cut at its extreme, between {low:.6g} and {high:.6g} {unit}", name))
    spikes = _spikes(recording, whole)
    if spikes and spikes[-1] - spikes[0] > SNAP_SAMPLES:
        said = f"{name}: {len(spikes)} samples look like spikes; state recordings.despike if they are"
        found.append(Doubt(said, name, "spikes" if _is_steady(name) else None))
    if high - low < 10.0 * sigma:
        said = f"{name}: its range of {high - low:.3g} {unit} is less than ten times its noise of {sigma:.2g} {unit}"
        found.append(Doubt(said, name))
    return found


def _is_steady(name: str) -> bool:
    """Whether a channel of a body cannot jump: friction and impacts let an acceleration jump, a shaker its input."""
    return name != "acceleration" and name not in INPUTS


def _without_lost(
    recording: Recording, name: str, values: Array, accepted: Sequence[str]
) -> tuple[list[Doubt], Array]:
    """The doubt about values that were lost and filled with one number, and the other values.

    Raises RecordingError where that number lies so far outside that it can only mean none.
    """
    lost = _dropouts(recording, values) if _is_steady(name) else []
    if not lost:
        return [], values
    others = np.delete(values, np.concatenate([np.arange(start, end) for start, end in lost]))
    start, end = max(lost, key=lambda one: one[1] - one[0])
    times = "" if len(lost) == 1 else f"{len(lost)} times, the longest "
    said = (
        f"{name} stands still {times}at {values[start]:.5g} {recording.unit(name)}, from {recording.time[start]:.4g} "
        f"to {recording.time[end - 1]:.4g} s, and jumps there: values were lost; leave them blank in the file, set "
        "trials.window, or list gaps in recordings.accept"
    )
    middle, reach = 0.5 * float(np.max(others) + np.min(others)), float(np.ptp(others))
    if "gaps" not in accepted and any(abs(values[first] - middle) > FILLED_REACH * reach for first, _ in lost):
        raise RecordingError(f"trial {recording.name}: {said}")
    return [Doubt(said, name, "gaps")], others


def _stretches(recording: Recording) -> list[slice]:
    """Samples between gaps in time: across one a motion jumps."""
    steps = np.diff(recording.time)
    cuts = (np.flatnonzero(steps > GAP_STEPS * np.median(steps)) + 1).tolist() if steps.size else []
    return [slice(a, b) for a, b in itertools.pairwise([0, *cuts, recording.time.size])]


def _spikes(recording: Recording, values: Array) -> list[int]:
    """Samples that look like spikes."""
    return [int(i) + one.start for one in _stretches(recording) for i in np.flatnonzero(find_spikes(values[one]))]


def _dropouts(recording: Recording, values: Array) -> list[tuple[int, int]]:
    """Stretches of samples that were lost and filled with one number."""
    step = quantum(values)
    parts = ((one.start, find_dropouts(values[one], step)) for one in _stretches(recording))
    return [(first + start, first + end) for first, found in parts for start, end in found]


def _rough(values: Array) -> float:
    """Noise while the channel moves at all: from the steps that are not zero."""
    moving = np.flatnonzero(np.diff(values) != 0.0)
    return noise(values[np.unique(np.concatenate([moving, moving + 1]))]) if moving.size > FEWEST_SAMPLES else 0.0


def _longest_hold(values: Array) -> int:
    """Longest run of samples exactly at the largest or smallest value."""
    runs = [end - start for extreme in (np.max(values), np.min(values)) for start, end in _runs(values == extreme)]
    return max(runs, default=0)


def _runs(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> list[tuple[int, int]]:
    """Half-open index ranges where a mask holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
