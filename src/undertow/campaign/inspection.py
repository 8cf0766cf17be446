"""What is in a file, before any config: layout, channels, rate, gaps, noise, release, a proposed config.

Belongs here: the look at one file and its text. Does not belong here: judgement (recording/quality.py), guesses
(recording/propose.py, recording/propose_layout.py), the config (proposing.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from undertow.campaign.proposing import layout_lines, propose_config
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.errors import RecordingError
from undertow.recording.catalogue import Catalogue, Entry, Window, read_trial
from undertow.recording.layout import Column, FileFormat
from undertow.recording.matlab import list_variables
from undertow.recording.propose import Proposal, propose_mapping
from undertow.recording.propose_layout import propose_layout
from undertow.recording.quality import RecordingSummary, summary
from undertow.recording.readers import READERS, read_table, suffix_of
from undertow.recording.text import read_text

COLUMNS_SHOWN = 12
"""Columns named in a message at most."""


@dataclass(frozen=True)
class Inspection:
    """One file: its layout, proposed mapping, channels at a glance, and its motion (None with the ``reason``).

    ``window`` is the part without missing values, where values are missing; ``remarks`` say what stands in the way.
    """

    path: Path
    layout: FileFormat
    proposal: Proposal
    summary: RecordingSummary
    motion: Motion | None
    reason: str = ""
    window: Window = field(default_factory=Window)
    remarks: tuple[str, ...] = ()


def inspect(path: Path) -> Inspection:
    """Look at one file with the layout that its lines and the mapping that its column names suggest.

    Raises RecordingError where it cannot be read, or no column looks like a channel or like time; it then says what is
    there and which config key helps.
    """
    layout = propose_layout(path) if path.is_file() and READERS.get(suffix_of(path)) is read_text else FileFormat()
    table = read_table(path, layout)
    proposal = propose_mapping(table, table.attrs.get("units"))
    if not proposal.channels or proposal.time is None:
        raise RecordingError(f"{path}: {_what_lacks(path, table, layout, proposal)}")
    window, remarks = _without_missing(table, proposal)
    source = Catalogue(
        path.parent, proposal.channels, proposal.time, files=path.name, layout=layout, coordinate=proposal.coordinate
    )
    recording = read_trial(Entry(path.name, path, window=window), source)
    glance = summary(recording)
    try:
        motion = condition(recording, start_s=window.start_s, end_s=window.end_s)
    except RecordingError as reason:
        return Inspection(path, layout, proposal, glance, None, str(reason), window, remarks)
    return Inspection(path, layout, proposal, glance, motion, "", window, remarks)


def _what_lacks(path: Path, table: pd.DataFrame, layout: FileFormat, proposal: Proposal) -> str:
    """Why a file cannot be looked at further, and which keys of a config would tell what it holds."""
    if suffix_of(path) == ".mat":
        return (
            f"no vector is named like a channel and one like time; it holds {', '.join(list_variables(path))}: "
            "set recordings.variable for a matrix or structure, recordings.cells for a cell array of trials"
        )
    ranges = [
        f"{name} ({np.nanmin(values):.4g} to {np.nanmax(values):.4g})"
        for name, values in ((name, table[name].to_numpy(dtype=np.float64)) for name in table.columns[:COLUMNS_SHOWN])
        if np.isfinite(values).any()
    ]
    named = "" if layout.header else " without names"
    keys = ", ".join(layout_lines(layout))
    how = f"set recordings {{{keys}}} and " if keys else ""
    rate = "" if proposal.time else "; no column looks like time: give channels.time: {rate_hz: ...}"
    what = "by number from 0" if not layout.header else "by hand"
    return (
        f"{len(table)} rows, {table.shape[1]} columns{named}: {', '.join(ranges)}; {how}write recordings.channels "
        f"{what}{rate}"
    )


def _without_missing(table: pd.DataFrame, proposal: Proposal) -> tuple[Window, tuple[str, ...]]:
    """The longest part of a table whose mapped columns are complete, and a remark for each that is not."""
    columns: list[Column] = [column for spec in proposal.channels.values() for column in spec.columns]
    time = table[proposal.time.column].to_numpy(dtype=np.float64) if proposal.time else np.zeros(0)
    finite = np.isfinite(table[columns].to_numpy(dtype=np.float64))
    if finite.all() or not np.isfinite(time).all():
        return Window(), ()
    remarks = []
    for at, column in enumerate(columns):
        bad = np.flatnonzero(~finite[:, at])
        if bad.size:
            remarks.append(
                f"column {column!r} lacks {bad.size} of {time.size} values, the first at {time[bad[0]]:g} s: leave it "
                "unmapped, or set trials.window"
            )
    edges = np.flatnonzero(np.diff(np.concatenate([[False], finite.all(axis=1), [False]]).astype(np.int8)))
    if not edges.size:
        return Window(), tuple(remarks)
    start, end = max(zip(edges[::2], edges[1::2], strict=True), key=lambda run: int(run[1] - run[0]))
    first = float(time[start]) if start > 0 else None
    last = float(time[end - 1]) if end < time.size else None
    return Window(first, last), tuple(remarks)


def inspect_file(path: Path) -> str:
    """The same as text, with a config that runs as printed when saved beside the file, or why there is none."""
    seen = inspect(path)
    s = seen.summary
    lines = [f"{path}", f"  {s.samples} samples, {s.duration_s:.4g} s at {s.rate_hz:.5g} Hz"]
    if s.gaps:
        lines.append(f"  {s.gaps} gaps, the largest {s.largest_gap_s:.3g} s")
    if math.isfinite(s.unevenness) and s.unevenness > 0.01:
        lines.append(f"  time steps vary by {100 * s.unevenness:.2g} % (1 sigma)")
    for name, c in s.channels.items():
        steps = f", steps of {c.quantum:.3g}" if c.quantum else ""
        spikes = f", {c.spikes} spikes" if c.spikes else ""
        lines.append(f"  {name}: {c.minimum:.5g} to {c.maximum:.5g} {c.unit}, noise {c.noise:.2g}{steps}{spikes}")
    proposed = propose_config(seen.path, seen.layout, seen.proposal, seen.window, seen.motion is not None)
    lines += [f"  doubt: {doubt}" for doubt in (*seen.remarks, *s.doubts, *proposed.doubts)]
    lines.append(_motion_line(seen))
    lines += [f"  {remark}" for remark in seen.proposal.remarks]
    if not proposed.lines:
        return "\n".join([*lines, f"no config is proposed: {proposed.reason or seen.reason}"])
    return "\n".join([*lines, "proposed config:", *proposed.lines])


def _motion_line(seen: Inspection) -> str:
    if seen.motion is None:
        return f"  no motion: {seen.reason}"
    w = seen.motion.window
    start = f"released at {w.release_s:.4f} +- {w.release_stderr_s:.4f} s" if w.held else "starts in mid-motion"
    unit = seen.motion.recording.unit("displacement")
    return f"  {start}, motion until {w.end_s:.4g} s, amplitude {seen.motion.amplitude:.4g} {unit}"
