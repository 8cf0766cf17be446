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

from undertow.errors import ClippedError, LostValuesError, RecordingError
from undertow.recording.clipping import NOISE_FREE_SHARE, begins_cut, levels, longest_hold, plateaus
from undertow.recording.doubt_kinds import DoubtKind
from undertow.recording.dropouts import find_dropouts, find_fillers
from undertow.recording.noise import noise, quantum
from undertow.recording.recording import INPUTS, Array, Recording
from undertow.recording.spikes import find_spikes

FEWEST_SAMPLES = 50
"""Below this a recording holds less than three cycles at twenty samples each, and a decrement is guesswork."""

SATURATED_SAMPLES = 30
"""A quantised channel whose noise is a whole step repeats a value 30 times in a row once in 10^9 tries."""

GAP_STEPS = 1.5
"""A step longer than this many median steps lacks at least one sample."""

UNEVEN_SHARE = 0.05
"""Relative standard deviation of the time steps above which evenness is doubted."""

SNAP_SAMPLES = 20
"""Spikes that all lie within so many samples are one event, the release most of all, and no faulty sensor."""

SPIKE_SHARE = 0.1
"""Spikes at one instant alone are said from so much of the others' range on."""

FILLED_REACH = 1.5
"""A number this many ranges from the middle of the others is one that loggers write for no value, such as -9999."""

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
    ``unit``; how many samples look like spikes.
    """

    unit: str
    minimum: float
    maximum: float
    noise: float
    quantum: float
    spikes: int


@dataclass(frozen=True)
class RecordingSummary:
    """A recording at a glance. ``gaps`` counts steps in time that lack samples; ``unevenness`` is the relative
    standard deviation of the other steps; ``doubts`` are sentences.
    """

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
        recording.time.size, recording.duration_s, 1.0 / usual, gaps.size,
        float(np.max(gaps, initial=0.0)), float(np.std(even) / usual) if even.size else math.nan,
        {name: _channel_summary(recording, name, values) for name, values in recording.channels.items()}, said,
    )  # fmt: skip


def _channel_summary(recording: Recording, name: str, values: Array) -> ChannelSummary:
    step = quantum(values)
    return ChannelSummary(
        recording.unit(name), float(np.min(values)), float(np.max(values)), noise(values), step,
        len(_spikes(recording, values)),
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
    held = longest_hold(values)
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
    begun = begins_cut(values, sigma) if smooth and _is_even(recording.time) else None
    if begun is not None:
        said = (
            f"{name} begins at {begun:.6g} {unit} and leaves it at speed: its sensor is cut off there, or the body was "
            "pushed and not let go; look at the sensor's range, or list clipping in recordings.accept"
        )
        found.append(Doubt(said, name, "clipping"))
    if cut == 1:
        found.append(Doubt(f"{name}: one peak looks cut at its extreme, between {low:.6g} and {high:.6g} {unit}", name))
    spikes = _spikes(recording, whole)
    if spikes and (spikes[-1] - spikes[0] > SNAP_SAMPLES or _stands_out(whole, spikes, sigma)):
        many = f"{len(spikes)} samples look like spikes" if len(spikes) > 1 else "one sample looks like a spike"
        at = f", the first at {recording.time[spikes[0]]:.4g} s" if len(spikes) > 1 else (
            f", {whole[spikes[0]]:.4g} {unit} at {recording.time[spikes[0]]:.4g} s"
        )  # fmt: skip
        said = f"{name}: {many}{at}; state recordings.despike if {'they are' if len(spikes) > 1 else 'it is'}"
        found.append(Doubt(said, name, "spikes" if _is_steady(name) else None))
    if high - low < 10.0 * sigma:
        said = f"{name}: its range of {high - low:.3g} {unit} is less than ten times its noise of {sigma:.2g} {unit}"
        found.append(Doubt(said, name))
    return found


def _is_even(time: Array) -> bool:
    """Whether samples are so even in time that how fast they fall is how fast the body moves."""
    steps = np.diff(time)
    return bool(np.std(steps) <= UNEVEN_SHARE * np.median(steps))


def _is_steady(name: str) -> bool:
    """Whether a channel of a body cannot jump: friction and impacts let an acceleration jump, a shaker its input."""
    return name != "acceleration" and name not in INPUTS


def _without_lost(
    recording: Recording, name: str, values: Array, accepted: Sequence[str]
) -> tuple[list[Doubt], Array]:
    """The doubt about values that were lost and filled with one number, and the other values.

    Raises LostValuesError where that number lies so far outside that it can only mean none.
    """
    if not _is_steady(name):
        return [], values
    lost, filled = _dropouts(recording, values), find_fillers(values)
    if filled.size and not any(start in filled for start, _ in lost):
        return _without_fillers(recording, name, values, filled, accepted)
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
        raise LostValuesError(f"trial {recording.name}: {said}")
    return [Doubt(said, name, "gaps")], others


def _without_fillers(
    recording: Recording, name: str, values: Array, filled: np.ndarray, accepted: Sequence[str]
) -> tuple[list[Doubt], Array]:
    """The same for samples at these places, that hold a number far outside all others and are no stretch."""
    others, unit = np.delete(values, filled), recording.unit(name)
    many = "1 sample is" if filled.size == 1 else f"{filled.size} samples are"
    said = (
        f"{name}: {many} {values[filled[0]]:.5g} {unit}, the first at {recording.time[filled[0]]:.4g} s, and all "
        f"others lie between {np.min(others):.3g} and {np.max(others):.3g} {unit}: a number far outside the others is "
        "written where values were lost; leave them blank in the file, state recordings.despike, or list gaps in "
        "recordings.accept"
    )
    if "gaps" not in accepted:
        raise LostValuesError(f"trial {recording.name}: {said}")
    return [Doubt(said, name, "gaps")], others


def _stretches(recording: Recording) -> list[slice]:
    """Samples between gaps in time: across one a motion jumps."""
    steps = np.diff(recording.time)
    cuts = (np.flatnonzero(steps > GAP_STEPS * np.median(steps)) + 1).tolist() if steps.size else []
    return [slice(a, b) for a, b in itertools.pairwise([0, *cuts, recording.time.size])]


def _spikes(recording: Recording, values: Array) -> list[int]:
    """Samples that look like spikes."""
    return [int(i) + one.start for one in _stretches(recording) for i in np.flatnonzero(find_spikes(values[one]))]


def _stands_out(values: Array, spikes: Sequence[int], sigma: float) -> bool:
    """Whether spikes within a few samples are a fault and no release: later than the body begins to move, and so large
    that a fit would feel them."""
    begins = int(np.argmax(np.abs(values - values[0]) > 10.0 * sigma))
    others = np.delete(np.arange(values.size), spikes)
    off = float(np.max(np.abs(values[spikes] - np.interp(spikes, others, values[others]))))
    return spikes[0] > begins + SNAP_SAMPLES and off > SPIKE_SHARE * float(np.ptp(values[others]))


def _dropouts(recording: Recording, values: Array) -> list[tuple[int, int]]:
    """Stretches of samples that were lost and filled with one number."""
    step = quantum(values)
    parts = ((one.start, find_dropouts(values[one], step)) for one in _stretches(recording))
    return [(first + start, first + end) for first, found in parts for start, end in found]


def _rough(values: Array) -> float:
    """Noise while the channel moves at all: from the steps that are not zero."""
    moving = np.flatnonzero(np.diff(values) != 0.0)
    return noise(values[np.unique(np.concatenate([moving, moving + 1]))]) if moving.size > FEWEST_SAMPLES else 0.0
