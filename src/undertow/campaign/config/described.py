"""The `recordings` section in the terms of undertow.recording: channels, time, layout; the same by file name pattern.

Belongs here: the way from settings to a catalogue's parts. Does not belong here: keys and defaults
(recording_settings.py), the rest of the config (run_config.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from undertow.campaign.config.recording_settings import ChannelSettings, RecordingsSettings
from undertow.recording.catalogue import Catalogue, ChannelSpec, TimeSpec
from undertow.recording.layout import CellLayout, Column, FileFormat
from undertow.recording.limits import Limits
from undertow.recording.recording import BESIDE, CHANNELS, INPUTS


@dataclass(frozen=True)
class FileDescription:
    """Channels, time and layout of a file, and the running medians that replace spikes (channel -> samples)."""

    channels: Mapping[str, ChannelSpec]
    time: TimeSpec
    layout: FileFormat
    despike: Mapping[str, int]


def described(said: RecordingsSettings) -> FileDescription:
    """What the settings say of a file; RecordingError where time has both or neither of column and rate."""
    if said.response is not None:  # no samples in time: a rate that nobody asks for
        return FileDescription({}, TimeSpec(rate_hz=1.0), _layout(said, {}), {})
    positions = said.cells.model_dump(exclude={"variable", "trial"}, exclude_none=True) if said.cells else {}
    time = said.channels.time
    column = time.column
    if column is None and time.rate_hz is None:
        column = positions.get("time")
    specs = {}
    for name in (*CHANNELS, *INPUTS, *BESIDE):
        one = getattr(said.channels, name)
        if one is not None:
            specs[name] = _channel(one, positions.get(name))
    medians = {name: one.median for name, one in said.despike.items() if name in specs}
    clock = TimeSpec(column, time.unit, time.rate_hz, time.start_s)
    return FileDescription(specs, clock, _layout(said, positions), medians)


def for_pattern(said: RecordingsSettings, *patterns: str) -> RecordingsSettings:
    """The settings of a file that these of `recordings.layouts` fit: keys that are given replace the others, channel by
    channel; the last pattern wins.
    """
    for pattern in patterns:
        layout = said.layouts[pattern]
        changed = {key: getattr(layout, key) for key in layout.model_fields_set}
        own = changed.pop("channels", None)
        if own is not None:
            more = {key: getattr(own, key) for key in own.model_fields_set}
            changed["channels"] = said.channels.model_copy(update=more)
        said = said.model_copy(update=changed)
    return said


@dataclass(frozen=True)
class ByPattern:
    """`undertow.recording.catalogue.Layouts` from the settings."""

    said: RecordingsSettings

    @property
    def patterns(self) -> tuple[str, ...]:
        """The patterns in their order."""
        return tuple(self.said.layouts)

    def applied(self, base: Catalogue, fitting: tuple[str, ...]) -> Catalogue:
        """The catalogue of a file that these patterns fit."""
        if not fitting:
            return base
        here = described(for_pattern(self.said, *fitting))
        return replace(base, channels=here.channels, time=here.time, layout=here.layout, despike=here.despike)


def _channel(one: ChannelSettings, position: int | None) -> ChannelSpec:
    columns: tuple[Column, ...] = one.columns or ()
    if not columns:
        columns = (one.column if one.column is not None else position,)  # type: ignore[assignment]
    time = None
    if one.time is not None:
        time = TimeSpec(one.time.column, one.time.unit, one.time.rate_hz, one.time.start_s)
    return ChannelSpec(columns, one.unit, float(one.sign), one.offset, one.file, one.variable, time)


def _layout(said: RecordingsSettings, positions: Mapping[str, int]) -> FileFormat:
    separator = None if said.separator == "auto" else {"tab": "\t", "space": r"\s+"}.get(said.separator, said.separator)
    cells = CellLayout(said.cells.variable, said.cells.trial, positions) if said.cells else None
    return FileFormat(
        separator, said.decimal, said.header == "first", said.skip_rows, said.unit_row, said.variable, cells,
        said.encoding, Limits(said.limits.megabytes, said.limits.columns),
    )  # fmt: skip
