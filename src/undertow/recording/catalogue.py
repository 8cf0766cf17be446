"""Where a campaign's recordings are, what their columns mean, and the way from there to `Recording`.

Belongs here: plain descriptions (the config's models become these), the list of trials, reading one. Does not belong
here: file formats (readers.py), judging quality (quality.py), choosing among trials (campaign).
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from os import PathLike, fspath
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

import numpy as np
import pandas as pd

from undertow.errors import MisnamedError, RecordingError
from undertow.recording.channels import ChannelSpec, TimeSpec, TimeWindow
from undertow.recording.clocks import placed
from undertow.recording.gaps import complete, must_hold_samples
from undertow.recording.held import as_read
from undertow.recording.layout import FileFormat
from undertow.recording.parts import How, Part, Where, part_of, primary, read_parts
from undertow.recording.patterns import patterns_of
from undertow.recording.readers import trial_name
from undertow.recording.recording import Array, Condition, Coordinate, Recording
from undertow.recording.stacked import begins_again
from undertow.recording.stated_rate import file_rate

EVERYTHING = TimeWindow()
"""No limit at either end."""


class Layouts(Protocol):
    """What file name patterns say of how files are read (the config's ``recordings.layouts``)."""

    @property
    def patterns(self) -> tuple[str, ...]:
        """The patterns in their order."""

    def applied(self, base: Catalogue, fitting: tuple[str, ...]) -> Catalogue:
        """The catalogue of a file that these patterns fit: their keys in place of the base's, the last one winning."""


@dataclass(frozen=True)
class Catalogue:
    """Where recordings are and how they are read; paths are relative to ``folder`` (the config's).

    Either ``index``, a table with a row a trial whose ``index_column`` names the file (or ``file``, a name with its
    columns in braces: ``test_{id}.csv``), or ``files``, globs, with ``pattern``, a regular expression whose named
    groups are conditions. ``conditions`` and ``windows`` go by file name patterns (``*_01.txt``), the last that fits
    wins; ``exclude`` leaves trials out; ``accept`` is pattern -> kinds of doubt (`doubt_kinds`) that are known.
    ``despike`` is channel -> width of the running median in samples. ``index_separator`` and ``index_decimal`` are the
    index's own. ``layouts`` says what differs by file name pattern (`for_file`). ``releases`` are the parts of a
    recording that are a trial each, where it holds several releases, by file name pattern, the last that fits.
    """

    folder: Path
    channels: Mapping[str, ChannelSpec]
    time: TimeSpec
    index: str | None = None
    index_column: str = "file"
    file: str | None = None
    files: str | tuple[str, ...] | None = None
    pattern: str | None = None
    exclude: tuple[str, ...] = ()
    layout: FileFormat = field(default_factory=FileFormat)
    despike: Mapping[str, int] = field(default_factory=dict)
    conditions: Mapping[str, Mapping[str, Condition]] = field(default_factory=dict)
    windows: Mapping[str, TimeWindow] = field(default_factory=dict)
    coordinate: Coordinate = "translation"
    index_separator: str = "auto"
    index_decimal: str = "auto"
    accept: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    layouts: Layouts | None = None
    releases: Mapping[str, tuple[TimeWindow, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("channels", "despike", "conditions", "windows", "accept", "releases"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    def for_file(self, name: str, file: str) -> Catalogue:
        """The catalogue as it holds for the trial of this name in this file: layouts by pattern applied."""
        if self.layouts is None:
            return self
        fitting = patterns_of(self.layouts.patterns).fitting(name, file)
        return self.layouts.applied(self, fitting)

    def for_entry(self, entry: Entry) -> Catalogue:
        """The same for a trial."""
        return self.for_file(entry.name, str(entry.file))

    @property
    def beside(self) -> tuple[str, ...]:
        """Names of further files that channels lie in, as the config writes them."""
        return tuple(dict.fromkeys(spec.file for spec in self.channels.values() if spec.file is not None))


@dataclass(frozen=True, slots=True)
class Entry:
    """One trial that is to be read. ``trial`` counts within the file (None: the file is the trial); ``part`` is the
    part of the recording that is this trial, of one that holds several releases.

    ``accepted`` are the kinds of doubt that the config says are known. ``problem`` is a sentence where it is already
    clear that it cannot be read, else empty. ``beside`` are the paths of further files its channels lie in, by the name
    that the config gives them. A campaign of 100,000 trials holds as many entries: ``file`` is text, a
    third of a Path, and read-only ``conditions`` are shared, not copied.
    """

    name: str
    file: str | PathLike[str]
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    window: TimeWindow = EVERYTHING
    trial: int | None = None
    problem: str = ""
    accepted: tuple[str, ...] = ()
    beside: Mapping[str, str] = field(default_factory=dict)
    part: TimeWindow = EVERYTHING

    def __post_init__(self) -> None:
        object.__setattr__(self, "file", fspath(self.file))
        if not isinstance(self.conditions, MappingProxyType):
            object.__setattr__(self, "conditions", MappingProxyType(dict(self.conditions)))

    @property
    def path(self) -> Path:
        """The file to read."""
        return Path(self.file)

    @property
    def whole_file(self) -> bool:
        """Whether the file is this trial and no other."""
        return self.trial is None and self.part == EVERYTHING


def read_trial(entry: Entry, catalogue: Catalogue) -> Recording:
    """One trial in SI units on the clock of its displacement: columns summed, signs and offsets applied, spikes
    replaced and counted, channels with other clocks interpolated (clocks.py), missing samples left out (gaps.py).

    The record is cut to ``entry.part``, not to ``entry.window``. ``notes`` say what was changed and which channels
    were left out.

    Raises RecordingError where the entry has a problem, the file cannot be read, a unit does not fit its channel, a
    column of times contradicts a stated rate that nobody accepted, nothing says where the body is, or that lacks too
    many values inside the window.
    """
    if entry.problem:
        raise RecordingError(f"trial {entry.name}: {entry.problem}")
    here = catalogue.for_entry(entry)
    try:
        primary(here.channels)
        parts, notes = read_parts(here.channels, _where(entry, catalogue, here))
        notes = (*notes, *_stated_rate(entry, here))
        time, channels, said = _whole(parts, entry)
        with entry.path.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
    except RecordingError as error:
        raise type(error)(f"trial {entry.name}: {error}") from error
    notes = (*notes, *said)
    return Recording(entry.name, time, channels, entry.conditions, here.coordinate, str(entry.path), digest, notes)


def trial_of_table(entry: Entry, table: pd.DataFrame, catalogue: Catalogue) -> Recording:
    """One trial of a table in memory, by the rules of `read_trial`; the entry says its name, conditions and window.

    Raises RecordingError where nothing says where the body is, a time stamp is missing, or the displacement lacks too
    many values inside the window.
    """
    how = How(catalogue.layout, catalogue.time, catalogue.despike)
    try:
        primary(catalogue.channels)
        part, notes = part_of(table, how, catalogue.channels, catalogue.coordinate)
        time, channels, said = _whole([part], entry)
    except RecordingError as error:
        raise type(error)(f"trial {entry.name}: {error}") from error
    return Recording(entry.name, time, channels, entry.conditions, catalogue.coordinate, notes=(*notes, *said))


def _whole(parts: list[Part], entry: Entry) -> tuple[Array, dict[str, Array], tuple[str, ...]]:
    """Time and channels of a trial on one clock, at the instants where all that is kept has a value, and notes."""
    read = [as_read(part) for part in parts]
    time, channels, said = _on_one_clock([one for found, _ in read for one in found])
    said = (*(note for _, notes in read for note in notes), *said)
    if entry.part != EVERYTHING:
        inside = entry.part.contains(time)
        must_hold_samples(inside, time, entry.part, "recordings.releases")
        time, channels = time[inside], {name: values[inside] for name, values in channels.items()}
    time, channels, more = complete(time, channels, entry.window, primary(channels))
    return time, channels, (*said, *more)


def _stated_rate(entry: Entry, here: Catalogue) -> tuple[str, ...]:
    """MisnamedError where a column of the trial's file is a time at another rate than the stated one; a note where
    that was accepted."""
    other = file_rate(entry.path, here.layout, here.time, here.channels[primary(here.channels)])
    if other and "clock" not in entry.accepted:
        raise MisnamedError(other)
    return (f"accepted (clock): {other}",) if other else ()


def _where(entry: Entry, catalogue: Catalogue, here: Catalogue) -> Where:
    """Where a trial's channels lie, and how each of its files is read: its own as the trial, others by their names."""

    def how(path: Path) -> How:
        said = here if path == entry.path else catalogue.for_file(trial_name(path), str(path))
        return How(said.layout, said.time, said.despike)

    return Where(entry.path, entry.beside, how, entry.trial, here.coordinate)


def _on_one_clock(parts: list[Part]) -> tuple[Array, dict[str, Array], tuple[str, ...]]:
    """All channels at the instants of the part that has the primary one; NaN where they have no value."""
    leader = primary({name: None for part in parts for name in part.channels})
    first, *others = sorted(parts, key=lambda part: leader not in part.channels)
    _must_increase(first.time, first.channels)
    channels, notes = dict(first.channels), []
    for part in others:
        for name, values in part.channels.items():
            found = placed(name, part.time, values, first.time, leader)
            if found.note:
                notes.append(found.note)
            if found.samples is not None:
                channels[name] = found.samples
    return first.time, channels, tuple(notes)


def _must_increase(time: Array, channels: Mapping[str, Array]) -> None:
    """RecordingError where a time stamp is not later than the one before; where another channel rises from sample to
    sample, the columns may be exchanged."""
    late = np.flatnonzero(~(np.diff(time) > 0.0))
    if (trials := begins_again(time)) > 1:
        raise RecordingError(
            f"time begins again {trials - 1} times (first at sample {late[0] + 1}): the file holds {trials} trials one "
            "below another; split it into a file each (docs/formats.md, Several trials in one file)"
        )
    if 2 * late.size > time.size and np.all(np.diff(time) >= 0.0):
        raise RecordingError(
            f"{late.size} of {time.size - 1} steps of time are 0 s: its clock is coarser than its samples; give "
            "channels.time: {rate_hz: ...} in its place"
        )
    if late.size:
        raise RecordingError(
            f"time goes from {time[late[0]]:g} s to {time[late[0] + 1]:g} s at sample {late[0] + 1}; time must "
            f"increase: {_exchanged(channels) or 'remove duplicated or swapped rows'}"
        )


def _exchanged(channels: Mapping[str, Array]) -> str:
    """That a channel rises as times do, so that its column may be the time's; empty where none does."""
    rising = [name for name, values in channels.items() if values.size > 1 and np.all(np.diff(values) > 0.0)]
    if not rising:
        return ""
    keys = f"recordings.channels.time and .{rising[0]}"
    return f"{rising[0]} does, from sample to sample: are the columns of {keys} exchanged?"


def cut(recording: Recording, window: TimeWindow) -> Recording:
    """The part of a recording inside a window; RecordingError where the window holds no sample."""
    inside = window.contains(recording.time)
    must_hold_samples(inside, recording.time, window)
    channels = {name: values[inside] for name, values in recording.channels.items()}
    return replace(recording, time=recording.time[inside], channels=channels)


__all__ = [
    "Catalogue", "ChannelSpec", "Entry", "Layouts", "TimeSpec", "TimeWindow", "cut", "read_trial", "trial_of_table",
]  # fmt: skip
