"""The tables that a trial's channels lie in, read and turned into SI: one table, or several files, groups and clocks.

A column that a file does not have costs that channel in that trial, not the trial, while another says where the body
is.

Belongs here: reading the parts of one trial. Does not belong here: putting them on one clock (clocks.py), missing
values (gaps.py), which files there are (gather.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from undertow.errors import MisnamedError, RecordingError
from undertow.recording.channels import LARGEST, ChannelSpec, TimeSpec
from undertow.recording.layout import Column, FileFormat
from undertow.recording.propose import clock_in_doubt, name_and_unit
from undertow.recording.readers import read_table
from undertow.recording.recording import LEFT_OUT, Array, Coordinate
from undertow.recording.spikes import despike
from undertow.recording.stamps import STAMPED, must_be_seconds, must_hold_no_stamps
from undertow.recording.units import ARBITRARY_LENGTHS, factor_to_si, to_si

FOLLOWED = ("displacement", "velocity")
"""Channels of which one must be there, in this order: they say where the body is."""

ALONE = "an acceleration integrated twice drifts away from any displacement: map displacement or velocity beside it"
"""Why an accelerometer alone is refused, by every command."""

UNCALIBRATED = "an uncalibrated scale"
"""Said of a channel in volts or counts, which is taken as it is."""


@dataclass(frozen=True)
class How:
    """How a file is read: its layout, its time, running medians that replace spikes (channel -> samples)."""

    layout: FileFormat
    time: TimeSpec
    despike: Mapping[str, int]


@dataclass(frozen=True)
class Part:
    """Channels of one table in SI with its time (n,) s; NaN where a value is missing."""

    time: Array
    channels: Mapping[str, Array]


@dataclass(frozen=True)
class Where:
    """Where a trial's channels lie: its own ``file``, those beside it by the name a channel gives (``beside``), how
    each file is read (``how``), the ``trial`` within the file."""

    file: Path
    beside: Mapping[str, str]
    how: Callable[[Path], How]
    trial: int | None
    coordinate: Coordinate

    def path(self, file: str | None) -> Path:
        """The path of one of its files; None is its own. RecordingError where nothing says where that is."""
        if file is not None and file not in self.beside:
            raise RecordingError(
                f"channels lie in the file {file!r}, and nothing says where that is beside {self.file}"
            )
        return self.file if file is None else Path(self.beside[file])


def read_parts(channels: Mapping[str, ChannelSpec], where: Where) -> tuple[list[Part], tuple[str, ...]]:
    """The tables of a trial, the displacement's first, and notes on channels that were left out or changed.

    Raises RecordingError where the part with the displacement (the velocity, where there is none) cannot be read.
    """
    sources: dict[tuple[str | None, str | None, TimeSpec | None], list[str]] = {}
    for name, spec in channels.items():
        sources.setdefault((spec.file, spec.variable, spec.time), []).append(name)
    parts: list[Part] = []
    notes: list[str] = []
    order = sorted(sources, key=lambda one: min(_rank(name) for name in sources[one]))
    for source in order:
        specs = {name: channels[name] for name in sources[source]}
        followed = any(name in part.channels for part in parts for name in FOLLOWED)
        try:
            part, said = _part(specs, where, source, followed)
        except RecordingError as error:
            if not followed:
                raise
            notes.append(f"{', '.join(specs)} {LEFT_OUT}: {error}")
            continue
        parts.append(part)
        notes += said
    return parts, tuple(notes)


def primary(channels: Mapping[str, object]) -> str:
    """The channel that says where the body is; RecordingError where there is none."""
    for name in FOLLOWED:
        if name in channels:
            return name
    have = ", ".join(channels) or "nothing"
    if "acceleration" in channels:
        raise RecordingError(f"channels recorded are {have}; {ALONE}")
    harmonic = "" if channels else " (a harmonic set has no motion in time; `undertow run` takes it)"
    raise RecordingError(f"channels recorded are {have}; motion needs displacement or velocity: map one{harmonic}")


def _rank(name: str) -> int:
    return FOLLOWED.index(name) if name in FOLLOWED else len(FOLLOWED)


def _part(
    specs: Mapping[str, ChannelSpec],
    where: Where,
    source: tuple[str | None, str | None, TimeSpec | None],
    followed: bool,
) -> tuple[Part, tuple[str, ...]]:
    """One table: the channels it has, in SI."""
    file, variable, own = source
    path = where.path(file)
    how = where.how(path)
    layout = how.layout if variable is None else replace(how.layout, variable=variable)
    time = own or how.time
    table, kept, notes = _table(path, layout, time, specs, where.trial if file is None else None, followed)
    part, said = part_of(table, How(layout, time, how.despike), kept, where.coordinate)
    return part, notes + said


def part_of(
    table: pd.DataFrame, how: How, channels: Mapping[str, ChannelSpec], coordinate: Coordinate
) -> tuple[Part, tuple[str, ...]]:
    """Time and channels of a table of numbers, without its blank rows, and notes on what was done to them.

    Raises RecordingError where a time stamp is missing, a unit does not fit, or values cannot be measured ones.
    """
    table = _without_blank_rows(table, how.time)
    found: dict[str, Array] = {}
    notes: tuple[str, ...] = ()
    for name, spec in channels.items():
        found[name], said = _channel(name, spec, table, how.despike, coordinate)
        notes += said
    return Part(_time(table, how.time, coordinate), found), notes + _unsaid_clock(table, how.time)


def _table(
    path: Path, layout: FileFormat, time: TimeSpec, specs: Mapping[str, ChannelSpec], trial: int | None, followed: bool
) -> tuple[pd.DataFrame, dict[str, ChannelSpec], tuple[str, ...]]:
    """The table with the columns of time and of those channels that it has; a note on each that it has not."""
    always: tuple[Column, ...] = () if time.column is None else (time.column,)
    try:
        return read_table(path, layout, _columns(always, specs.values()), trial), dict(specs), ()
    except MisnamedError as error:
        kept = {name: spec for name, spec in specs.items() if _there(path, layout, (*always, *spec.columns), trial)}
        if not kept or not (followed or any(name in kept for name in FOLLOWED)):
            raise
        lost = ", ".join(name for name in specs if name not in kept)
        note = f"{lost} {LEFT_OUT}: {error}"
        return read_table(path, layout, _columns(always, kept.values()), trial), kept, (note,)


def _there(path: Path, layout: FileFormat, columns: Sequence[Column], trial: int | None) -> bool:
    """Whether a file has these columns."""
    try:
        read_table(path, layout, tuple(dict.fromkeys(columns)), trial)
    except MisnamedError:
        return False
    return True


def _columns(always: tuple[Column, ...], specs: Iterable[ChannelSpec]) -> tuple[Column, ...]:
    """Every column that is needed, once."""
    return tuple(dict.fromkeys((*always, *(column for spec in specs for column in spec.columns))))


def _without_blank_rows(table: pd.DataFrame, time: TimeSpec) -> pd.DataFrame:
    """The table without rows that hold nothing: all of them where the time has a column, those at the end else."""
    filled = np.isfinite(table.to_numpy(dtype=np.float64)).any(axis=1)
    if filled.all():
        return table
    if time.column is not None:
        return table[filled]
    there = np.flatnonzero(filled)
    return table.iloc[: there[-1] + 1] if there.size else table


def _time(table: pd.DataFrame, spec: TimeSpec, coordinate: Coordinate) -> Array:
    """Time stamps (n,) in s; a stamp that is not a number is an error wherever it is."""
    if spec.column is None:
        return spec.start_s + np.arange(len(table), dtype=np.float64) / float(spec.rate_hz or np.nan)
    stamps = table[spec.column].to_numpy(dtype=np.float64)
    _must_be_measured("time", stamps, spec.unit)
    must_be_seconds(table, spec.column, spec.unit)
    values, _ = to_si(stamps, spec.unit, "time", coordinate)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise RecordingError(
            f"time column {spec.column!r} has {bad.size} values that are not finite, the first in row {bad[0] + 1} of "
            f"{values.size}; repair the file or give rate_hz"
        )
    return values + spec.start_s


def _unsaid_clock(table: pd.DataFrame, spec: TimeSpec) -> tuple[str, ...]:
    """A note on times in seconds that may be milliseconds, where neither the column's name nor a row of units says."""
    column, told = spec.column, table.attrs.get("units", {})
    if column is None or column in table.attrs.get(STAMPED, ()) or told.get(column) or name_and_unit(column)[1]:
        return ()
    doubt = "" if factor_to_si(spec.unit, "time")[0] != 1.0 else clock_in_doubt(column, table[column])
    return (doubt,) if doubt else ()


def _channel(
    name: str, spec: ChannelSpec, table: pd.DataFrame, medians: Mapping[str, int], coordinate: Coordinate
) -> tuple[Array, tuple[str, ...]]:
    """A channel (n,) in SI, NaN where it is missing, and what was done to it."""
    for column in spec.columns:
        must_hold_no_stamps(table, column, name)
    columns = [table[column].to_numpy(dtype=np.float64) for column in spec.columns]
    for values in columns:
        _must_be_measured(name, values, spec.unit)
    infinite = int(np.count_nonzero(np.any(np.isinf(columns), axis=0)))
    with np.errstate(invalid="ignore"):  # inf less inf is missing too
        summed = np.sum(columns, axis=0)
    values, unit = to_si(spec.sign * (summed - spec.offset), spec.unit, name, coordinate)
    values = np.where(np.isfinite(values), values, np.nan)
    said = "value is infinite and counts" if infinite == 1 else "values are infinite and count"
    notes: tuple[str, ...] = (f"{name}: {infinite} {said} as missing",) if infinite else ()
    if unit.partition("/")[0].strip() in ARBITRARY_LENGTHS:
        notes += (f"{name} is in {unit}, {UNCALIBRATED}: where a result says m, read {unit.partition('/')[0]}",)
    if name in medians:
        known = np.isfinite(values)
        values[known], count = despike(values[known], medians[name])
        share = f"{count} of {values.size} samples"
        notes += (f"{name}: {share} replaced as spikes (running median of {medians[name]})",)
    return values, notes


def _must_be_measured(name: str, values: Array, unit: str) -> None:
    """RecordingError where values are so large or so small that no equation can hold their powers."""
    sizes = np.abs(values[np.isfinite(values)])
    largest = float(np.max(sizes, initial=0.0))
    if largest > LARGEST or 0.0 < largest < 1.0 / LARGEST:
        raise RecordingError(
            f"{name} reaches {largest:.3g} {unit}; a measured value lies between {1.0 / LARGEST:g} and {LARGEST:g}: "
            "correct its unit or column"
        )
