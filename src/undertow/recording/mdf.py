"""Measurement data files of the ASAM (MDF4, MDF3) as tables, through asammdf.

Belongs here: channel groups and their clocks. Does not belong here: which channel means what (catalogue.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from undertow.errors import MisnamedError, RecordingError
from undertow.recording.file_guard import MDF_GUARD
from undertow.recording.foreign import library, parsing
from undertow.recording.layout import Column, FileFormat, pick
from undertow.recording.vectors import chosen_table, table

TIME = "time"
"""Name of the column that a group's master channel becomes, in s since the file's start."""

_VIRTUAL, _LOOKED_UP = (3, 6), (1, 5, 7)
"""Kinds of channel in MDF 4: without bytes, and with bytes of any length elsewhere."""

_INVALID = 3
"""Flags of a channel in MDF 4 some of whose values, or all, are marked as invalid by a bit behind the record."""

_LAST_NUMBER, _TEXTS_3 = 5, (7, 8)
"""Data types: whole and floating numbers come first in MDF 4; texts and bytes in MDF 3."""

_ADVICE = "export it again as MDF 4, or as CSV"


def read_mdf(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The asked channels (all of a group where None) of one channel group as float64, with the column ``time``.

    ``layout.variable`` is the group: its acquisition name, or its number from 0; None: the only group that has all
    asked channels.

    Raises RecordingError where asammdf is not installed, the file is damaged or too large, or group or channel are
    missing.
    """
    with _opened(path) as file:
        groups = _groups(file)
        name = _group(path, groups, layout.variable, columns)
        number, channels = groups[name]
        names: list[Column] = [TIME, *(one for one in channels if one != TIME)]
        layout.limits.allow_columns(path, len(names) if columns is None else len(columns))
        asked = [names[at] for at in pick(path, names, columns)]
        samples = int(file.groups[number].channel_group.cycles_nr)
        layout.limits.allow_bytes(path, 8.0 * samples * len(asked), f"channel group {name!r}")
        _must_fit(path, file.groups[number])
        vectors: dict[Column, Any] = {TIME: np.asarray(file.get_master(number))}
        units = {}
        for column in (one for one in asked if one != TIME):
            if not _holds_numbers(file.groups[number].channels[channels[str(column)]]):
                if columns is not None:
                    raise RecordingError(f"{path}: channel {column!r} holds texts or bytes; only numbers are read")
                continue
            place = {"group": number, "index": channels[str(column)]}
            signal = file.get(str(column), ignore_invalidation_bits=True, **place)
            values = _with_gaps(np.asarray(signal.samples), signal.invalidation_bits)
            if columns is not None or (values.dtype.kind in "fiu" and values.ndim == 1):
                vectors[column], units[column] = values, str(signal.unit or "")
        frame = table(path, vectors, units)
    return frame if columns is None else frame[list(columns)]


def mdf_tables(path: Path) -> tuple[str, ...]:
    """Names of the channel groups that hold more than a clock."""
    with _opened(path) as file:
        return tuple(name for name, (_, channels) in _groups(file).items() if channels)


def _with_gaps(values: Any, marks: Any) -> Any:
    """A channel's values, NaN where they are marked as invalid; left out they would not fit the clock."""
    if marks is None or values.ndim != 1 or values.dtype.kind not in "fiub":
        return values
    return np.where(np.asarray(marks, dtype=bool), np.nan, values.astype(np.float64))


def _must_fit(path: Path, group: Any) -> None:
    """RecordingError where a channel ends beyond the group's records: asammdf reads the memory behind them."""
    record = int(group.channel_group.samples_byte_nr)
    invalid = 8 * int(getattr(group.channel_group, "invalidation_bytes_nr", 0))
    for one in group.channels:
        first = getattr(one, "byte_offset", None)
        if first is None:  # MDF 2 and 3
            first, bit = divmod(one.start_offset, 8)
            first += getattr(one, "additional_byte_offset", 0)
        else:
            bit = one.bit_offset
        end = 0 if _is_virtual(one) else first + -(-(bit + one.bit_count) // 8)
        marked = invalid and one.flags & _INVALID
        if end > record or (marked and one.pos_invalidation_bit >= invalid):
            raise RecordingError(
                f"{path} is damaged: channel {one.name!r} ends at byte {end} of records of {record} bytes; copy the "
                "file again, or export it again"
            )


def _is_virtual(channel: Any) -> bool:
    """Whether a channel's values are its records' numbers, so that it has no bytes (MDF 4)."""
    return hasattr(channel, "byte_offset") and channel.channel_type in _VIRTUAL


def _holds_numbers(channel: Any) -> bool:
    """Whether a channel has numbers; what asammdf makes of texts, by offsets it does not check, is not asked for."""
    if not hasattr(channel, "byte_offset"):
        return int(channel.data_type) not in _TEXTS_3
    return _is_virtual(channel) or (channel.channel_type not in _LOOKED_UP and int(channel.data_type) <= _LAST_NUMBER)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    MDF_GUARD.begin()  # it imports the same library, beside this process
    asammdf = library("asammdf", "asammdf", "labs", path)
    MDF_GUARD.check(path)
    with parsing(path, "MDF file", _ADVICE, cycles=True):
        file = asammdf.MDF(path)
        try:
            yield file
        finally:
            file.close()


def _groups(file: Any) -> dict[str, tuple[int, dict[str, int]]]:
    """Groups by acquisition name (number where that is empty or not the only one): number, channels without a clock."""
    said = [str(getattr(group.channel_group, "acq_name", "") or "") for group in file.groups]
    found = {}
    for number, group in enumerate(file.groups):
        name = said[number] if said[number] and said.count(said[number]) == 1 else str(number)
        master = file.masters_db.get(number)
        found[name] = (number, {one.name: at for at, one in enumerate(group.channels) if at != master})
    return found


def _group(
    path: Path, groups: dict[str, tuple[int, dict[str, int]]], wanted: str | None, columns: Sequence[Column] | None
) -> str:
    """The group that is named, or the only one that has all asked channels."""
    if wanted is not None:
        return chosen_table(path, list(groups), wanted, "channel group")
    have = [name for name, (_, channels) in groups.items() if channels]
    asked = [str(one) for one in columns or () if one != TIME]
    fitting = [name for name in have if all(one in groups[name][1] for one in asked)]
    if len(fitting) == 1:
        return fitting[0]
    everywhere = {one for name in have for one in groups[name][1]}
    lacking = next((one for one in asked if one not in everywhere), None)
    if lacking is not None:
        listed = ", ".join(sorted(everywhere)[:30])
        raise MisnamedError(f"{path} has no column {lacking!r}; it has {listed}; correct recordings.channels")
    if not fitting and asked:
        raise RecordingError(
            f"{path}: {', '.join(asked)} lie in different channel groups, each with its own clock; give those that are "
            "not in the displacement's group their own time: time: {column: time} in recordings.channels"
        )
    return chosen_table(path, fitting, None, "channel group")
