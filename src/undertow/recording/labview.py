"""LabVIEW's files as tables: measurement files (.lvm, text) and TDMS (binary, through npTDMS).

Belongs here: their headers, groups and own time. Does not belong here: plain text tables (text.py).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.foreign import library, parsing
from undertow.recording.layout import Column, FileFormat, pick
from undertow.recording.text import table_of, text_of
from undertow.recording.vectors import alike, chosen_table, table

TIME = "time"
"""Name of the column that a TDMS group's own clock becomes, in s since the file's first sample."""

X_VALUE = "X_Value"
"""LabVIEW's name of the time column of a measurement file."""

_END = re.compile(r"\*\*\*End_of_Header\*\*\*")
_NEXT = re.compile(r"^Channels[\t,;]", re.MULTILINE)
_ADVICE = "copy it again, or export it as CSV"


def read_lvm(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The asked columns (all with numbers where None) of a LabVIEW measurement file as float64; separator and decimal
    mark are the file's own.

    Columns are named as in the file; time is ``X_Value``, also where the file states only X0 and Delta_X. Where every
    channel has an X of its own the second is ``X_Value 2``. Several segments follow each other.

    Raises RecordingError where the file has no LabVIEW header, or as `undertow.recording.text.read_text`.
    """
    text = text_of(path, layout.limits, layout.encoding)
    if not text.startswith("LabVIEW Measurement") or not _END.search(text):
        raise RecordingError(f"{path} has no header of a LabVIEW measurement file; is its suffix right?")
    said = _keys(text.partition("***End_of")[0].splitlines())
    separator = {"comma": ",", "tab": "\t", "semicolon": ";"}.get(said.get("separator", "tab").lower(), "\t")
    decimal = "," if said.get("decimal_separator", ".").startswith(",") else "."
    own = FileFormat(separator, decimal, limits=layout.limits)
    segments = _segments(text)
    if not segments:
        raise RecordingError(f"{path} has a LabVIEW header and no data below it; copy it again")
    x_columns = said.get("x_columns", "One").lower()
    frames = [_segment_table(path, one, own, x_columns, columns) for one in segments]
    joined = frames[0] if len(frames) == 1 else pd.concat(frames, ignore_index=True)
    joined.attrs = dict(frames[0].attrs)
    return joined


@dataclass(frozen=True)
class _Segment:
    """One segment: what its own header says, key by key, its names and data as text, and the lines above these."""

    said: Mapping[str, str]
    text: str
    above: int


def _segments(text: str) -> list[_Segment]:
    """The segments of a file: each but a lone one has a header of its own between the file's and its data."""
    ends = [match.end() for match in _END.finditer(text)]
    segments, header = [], ends[0]
    for end in ends[1:] or ends:
        following = _NEXT.search(text, end)
        stop = following.start() if following else len(text)
        if text[end:stop].strip():
            segments.append(_Segment(_keys(text[header:end].splitlines()), text[end:stop], text.count("\n", 0, end)))
        header = stop
    return segments


def _keys(lines: Sequence[str]) -> dict[str, str]:
    """Keys of a header in small letters and the rest of their lines; the separator may be any of three."""
    pairs = (re.split(r"[\t,;]", line, maxsplit=1) for line in lines if line.strip())
    return {pair[0].strip().lower(): pair[1].strip() if len(pair) > 1 else "" for pair in pairs}


def _segment_table(
    path: Path, segment: _Segment, layout: FileFormat, x_columns: str, columns: Sequence[Column] | None
) -> pd.DataFrame:
    """The asked columns of one segment."""
    separator = layout.separator or "\t"
    blank = len(segment.text) - len(segment.text.lstrip("\r\n\t ,;"))
    names_line, _, data = segment.text[blank:].partition("\n")
    names = _unique([name.strip() for name in names_line.rstrip("\r\n\t ,;").split(separator)])
    stated = x_columns == "no"
    have: list[Column] = [*names, *([X_VALUE] if stated and X_VALUE not in names else [])]
    layout.limits.allow_columns(path, len(have))
    asked = [have[at] for at in pick(path, have, columns) if columns is not None or have[at] != "Comment"]
    measured = [name for name in asked if not (stated and name == X_VALUE)] or names[-1:]
    above = "\n" * (segment.above + segment.text.count("\n", 0, blank))
    frame = table_of(path, f"{above}{separator.join(names)}\n{data}".encode(), layout, measured)
    if stated and X_VALUE in asked:
        frame[X_VALUE] = _stated_x(path, segment, layout.decimal, len(frame))
    units = segment.said.get("y_unit_label", "").split(separator)
    shown = [name for name in names if not name.startswith(X_VALUE) and name != "Comment"]
    frame.attrs["units"] = {name: unit for name, unit in zip(shown, units, strict=False) if unit and name in asked}
    return frame[asked]


def _stated_x(path: Path, segment: _Segment, decimal: str, count: int) -> Any:
    """Time (count,) in s from X0 and Delta_X."""
    try:
        start, step = (
            float(re.split(r"[\t;]", segment.said.get(key, ""))[0].replace(decimal, ".")) for key in ("x0", "delta_x")
        )
    except ValueError as error:
        raise RecordingError(
            f"{path} states neither X_Value nor X0 and Delta_X; give channels.time: {{rate_hz: ...}}"
        ) from error
    return start + step * np.arange(count)


def _unique(names: Sequence[str]) -> list[str]:
    """Names with a number behind those that stand there before."""
    out: list[str] = []
    for name in names:
        times = sum(one == name or (one.startswith(f"{name} ") and one[len(name) + 1 :].isdigit()) for one in out)
        out.append(f"{name} {times + 1}" if times and name else name)
    return out


def read_tdms(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The asked channels (all of one length where None) of a TDMS group as float64; ``layout.variable`` is the group.

    A group whose channels say their increment has the column ``time``, in s since the earliest start in the file.

    Raises RecordingError where npTDMS is not installed, the file is damaged or too large, or group or channel are
    missing.
    """
    nptdms = library("nptdms", "npTDMS", "labs", path)
    with parsing(path, "TDMS file", _ADVICE), path.open("rb") as stream, nptdms.TdmsFile.open(stream) as file:
        groups = {group.name: group for group in file.groups() if group.channels()}
        group = groups[chosen_table(path, list(groups), layout.variable, "group")]
        channels = {channel.name: channel for channel in group.channels()}
        own_time = TIME not in channels and any("wf_increment" in one.properties for one in channels.values())
        names: list[Column] = [*([TIME] if own_time else []), *channels]
        layout.limits.allow_columns(path, len(names) if columns is None else len(columns))
        asked = [names[at] for at in pick(path, names, columns)]
        wanted = [str(name) for name in asked if not (own_time and name == TIME)]
        if columns is None:
            wanted = [name for name in wanted if channels[name].dtype.kind in "fiuM"]
        # npTDMS counts no more values than the file has bytes for
        layout.limits.allow_bytes(path, 8.0 * sum(len(channels[name]) for name in wanted), "its channels")
        vectors: dict[Column, Any] = {name: _tdms_values(channels[name]) for name in wanted}
        vectors = alike(vectors) if columns is None else vectors
        clocks = [channels[str(name)] for name in vectors] or list(channels.values())[:1]
        if TIME in asked and own_time:
            vectors = {TIME: _tdms_time(path, clocks, file), **vectors}
        units: dict[Column, str] = {name: str(channels[name].properties.get("unit_string", "")) for name in wanted}
        frame = table(path, vectors, units)
    return frame if columns is None else frame[list(columns)]


def tdms_tables(path: Path) -> tuple[str, ...]:
    """Names of the groups that hold channels."""
    nptdms = library("nptdms", "npTDMS", "labs", path)
    with parsing(path, "TDMS file", _ADVICE), path.open("rb") as stream:
        return tuple(group.name for group in nptdms.TdmsFile.read_metadata(stream).groups() if group.channels())


def _tdms_values(channel: Any) -> Any:
    values = np.asarray(channel[:])
    if values.dtype.kind == "M":
        return (values - values[0]) / np.timedelta64(1, "s") if values.size else np.zeros(0)
    return values


def _tdms_time(path: Path, channels: Sequence[Any], file: Any) -> Any:
    """The clock that the channels share, from their increments and starts."""
    clocks = {
        (float(one.properties.get("wf_increment", np.nan)), float(one.properties.get("wf_start_offset", 0.0)),
         one.properties.get("wf_start_time"), len(one))
        for one in channels
    }  # fmt: skip
    if len(clocks) > 1:
        rates = ", ".join(f"{1.0 / step:g} Hz" if step else "no rate" for step, *_ in sorted(clocks, key=str))
        raise RecordingError(
            f"{path}: the channels {', '.join(one.name for one in channels)} have clocks of their own ({rates}); give "
            "the slower or later one its own time: time: {column: time} in recordings.channels"
        )
    ((step, offset, start, count),) = clocks
    starts = [c.properties["wf_start_time"] for g in file.groups() for c in g.channels()
              if c.properties.get("wf_start_time") is not None]  # fmt: skip
    late = float((start - min(starts)) / np.timedelta64(1, "s")) if start is not None else 0.0
    return late + offset + step * np.arange(count)
