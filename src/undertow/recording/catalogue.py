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

import numpy as np
import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.layout import Column, FileFormat
from undertow.recording.readers import read_table
from undertow.recording.recording import Array, Condition, Coordinate, Recording
from undertow.recording.spikes import Mask, despike
from undertow.recording.units import ARBITRARY_LENGTHS, to_si


@dataclass(frozen=True)
class ChannelSpec:
    """What a channel is made of: SI value = sign (sum of columns - offset) unit.

    ``offset`` is the reading at zero, in ``unit``. Several columns are summed (the load cells of one support).
    """

    columns: tuple[Column, ...]
    unit: str
    sign: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class TimeSpec:
    """Time from a column in ``unit``, or from a constant rate; exactly one of the two."""

    column: Column | None = None
    unit: str = "s"
    rate_hz: float | None = None

    def __post_init__(self) -> None:
        if (self.column is None) == (self.rate_hz is None):
            raise RecordingError(
                f"time has column {self.column!r} and rate {self.rate_hz!r} Hz; give one of them, not both or none"
            )


@dataclass(frozen=True)
class Window:
    """The part of a recording to be used, in its own time, s; None: as far as it goes."""

    start_s: float | None = None
    end_s: float | None = None

    def contains(self, time: Array) -> Mask:
        """Mask (n,) of the times (s) inside."""
        start = -np.inf if self.start_s is None else self.start_s
        end = np.inf if self.end_s is None else self.end_s
        return (time >= start) & (time <= end)


@dataclass(frozen=True)
class Catalogue:
    """Where recordings are and how they are read; paths are relative to ``folder`` (the config's).

    Either ``index``, a table with a row a trial whose ``index_column`` names the file (or ``file``, a name with its
    columns in braces: ``test_{id}.csv``), or ``files``, a glob, with ``pattern``, a regular expression whose named
    groups are conditions. ``conditions`` and ``windows`` go by file name patterns (``*_01.txt``), the last that fits
    wins; ``exclude`` leaves trials out; ``accept`` is pattern -> kinds of doubt (`doubt_kinds`) that are known.
    ``despike`` is channel -> width of the running median in samples. ``index_separator`` and ``index_decimal`` are the
    index's own.
    """

    folder: Path
    channels: Mapping[str, ChannelSpec]
    time: TimeSpec
    index: str | None = None
    index_column: str = "file"
    file: str | None = None
    files: str | None = None
    pattern: str | None = None
    exclude: tuple[str, ...] = ()
    layout: FileFormat = field(default_factory=FileFormat)
    despike: Mapping[str, int] = field(default_factory=dict)
    conditions: Mapping[str, Mapping[str, Condition]] = field(default_factory=dict)
    windows: Mapping[str, Window] = field(default_factory=dict)
    coordinate: Coordinate = "translation"
    index_separator: str = "auto"
    index_decimal: str = "auto"
    accept: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("channels", "despike", "conditions", "windows", "accept"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))


@dataclass(frozen=True, slots=True)
class Entry:
    """One trial that is to be read. ``trial`` counts within the file (None: the file is the trial).

    ``accepted`` are the kinds of doubt that the config says are known. ``problem`` is a sentence where it is already
    clear that it cannot be read, else empty. A campaign of 100,000 trials holds as many entries: ``file`` is text, a
    third of a Path, and read-only ``conditions`` are shared, not copied.
    """

    name: str
    file: str | PathLike[str]
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    window: Window = Window()
    trial: int | None = None
    problem: str = ""
    accepted: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "file", fspath(self.file))
        if not isinstance(self.conditions, MappingProxyType):
            object.__setattr__(self, "conditions", MappingProxyType(dict(self.conditions)))

    @property
    def path(self) -> Path:
        """The file to read."""
        return Path(self.file)


def read_trial(entry: Entry, catalogue: Catalogue) -> Recording:
    """One trial in SI units: columns summed, signs and offsets applied, spikes replaced and counted.

    The record is not cut to ``entry.window``; only samples outside it that are not numbers are left out, and counted.

    Raises RecordingError where the entry has a problem, the file cannot be read, a unit does not fit its channel, or a
    mapped column has NaN inside the window.
    """
    if entry.problem:
        raise RecordingError(f"trial {entry.name}: {entry.problem}")
    try:
        table = read_table(entry.path, catalogue.layout, _mapped(catalogue), entry.trial)
        digest = hashlib.sha256(entry.path.read_bytes()).hexdigest()
        time = _time(table, catalogue)
        table, time, notes = _without_nan(table, time, entry.window)
        channels: dict[str, Array] = {}
        for name, spec in catalogue.channels.items():
            channels[name], said = _channel(name, spec, table, catalogue)
            notes += said
    except RecordingError as error:
        raise type(error)(f"trial {entry.name}: {error}") from error
    return Recording(
        entry.name, time, channels, entry.conditions, catalogue.coordinate, str(entry.path), digest, notes
    )  # fmt: skip


def cut(recording: Recording, window: Window) -> Recording:
    """The part of a recording inside a window; RecordingError where the window holds no sample."""
    inside = window.contains(recording.time)
    _must_hold_samples(inside, recording.time, window)
    channels = {name: values[inside] for name, values in recording.channels.items()}
    return replace(recording, time=recording.time[inside], channels=channels)


def _must_hold_samples(inside: Mask, time: Array, window: Window) -> None:
    if not inside.any():
        raise RecordingError(
            f"the window {window.start_s} to {window.end_s} s holds none of the samples, which are at {time[0]:g} to "
            f"{time[-1]:g} s; correct trials.window"
        )


def _mapped(catalogue: Catalogue) -> tuple[Column, ...]:
    """Every column that a channel or the time needs, once."""
    time = () if catalogue.time.column is None else (catalogue.time.column,)
    columns = (*time, *(column for spec in catalogue.channels.values() for column in spec.columns))
    return tuple(dict.fromkeys(columns))


def _time(table: pd.DataFrame, catalogue: Catalogue) -> Array:
    """Time stamps (n,) in s; a stamp that is not a number is an error wherever it is."""
    spec = catalogue.time
    if spec.column is None:
        return np.arange(len(table), dtype=np.float64) / float(spec.rate_hz or np.nan)
    values, _ = to_si(table[spec.column].to_numpy(), spec.unit, "time", catalogue.coordinate)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise RecordingError(
            f"time column {spec.column!r} has {bad.size} values that are not finite, the first in row {bad[0] + 1} of "
            f"{values.size}; repair the file or give rate_hz"
        )
    return values


def _without_nan(table: pd.DataFrame, time: Array, window: Window) -> tuple[pd.DataFrame, Array, tuple[str, ...]]:
    """The table without incomplete rows outside the window; an incomplete row inside it is an error."""
    finite = np.isfinite(table.to_numpy(dtype=np.float64))
    complete, inside = finite.all(axis=1), window.contains(time)
    _must_hold_samples(inside, time, window)
    for at, column in enumerate(table.columns):
        bad = np.flatnonzero(~finite[:, at] & inside)
        if bad.size:
            raise RecordingError(
                f"column {column!r} has {bad.size} values that are not finite, the first at {time[bad[0]]:g} s; "
                "end trials.window before it or repair the file"
            )
    dropped = int(np.count_nonzero(~complete))
    notes = (f"{dropped} incomplete samples outside the window left out",) if dropped else ()
    return table[complete], time[complete], notes


def _channel(name: str, spec: ChannelSpec, table: pd.DataFrame, catalogue: Catalogue) -> tuple[Array, tuple[str, ...]]:
    """A channel (n,) in SI, and what was done to it."""
    summed = np.sum([table[column].to_numpy(dtype=np.float64) for column in spec.columns], axis=0)
    values, unit = to_si(spec.sign * (summed - spec.offset), spec.unit, name, catalogue.coordinate)
    notes: tuple[str, ...] = ()
    if unit.partition("/")[0].strip() in ARBITRARY_LENGTHS:
        notes += (f"{name} is in {unit}, an uncalibrated scale: where a result says m, read {unit.partition('/')[0]}",)
    if name in catalogue.despike:
        values, count = despike(values, catalogue.despike[name])
        share = f"{count} of {values.size} samples"
        notes += (f"{name}: {share} replaced as spikes (running median of {catalogue.despike[name]})",)
    return values, notes
