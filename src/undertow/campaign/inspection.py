"""What is in a file, before any config: layout, channels, rate, gaps, noise, release, a proposed config.

Belongs here: the look at one file and its text. Does not belong here: judgement (recording/quality.py), guesses
(recording/propose_file.py), the config (proposing.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from undertow.campaign.proposing import layout_lines, propose_config
from undertow.campaign.response.proposing import look
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.errors import ConfigError, RecordingError
from undertow.recording.catalogue import Catalogue, Entry, read_trial
from undertow.recording.layout import FileFormat
from undertow.recording.matlab import list_variables
from undertow.recording.parts import ALONE
from undertow.recording.propose import Proposal, strange_unit
from undertow.recording.propose_file import FileProposal, propose_file
from undertow.recording.quality import RecordingSummary, summary
from undertow.recording.readers import suffix_of, trial_name
from undertow.recording.recording import INPUTS

PROPOSED = "proposed config:"
"""The line that a proposed config follows."""

COLUMNS_SHOWN = 12
"""Columns named in a message at most."""


@dataclass(frozen=True)
class Inspection:
    """One file: its layout, proposed mapping, channels at a glance, and its motion (None with the ``reason``).

    ``remarks`` say what reading it left out or changed.
    """

    path: Path
    layout: FileFormat
    proposal: Proposal
    summary: RecordingSummary
    motion: Motion | None
    reason: str = ""
    remarks: tuple[str, ...] = ()


def inspect(path: Path, found: FileProposal | None = None) -> Inspection:
    """Look at one file with the layout that its lines and the mapping that its column names suggest (``found``, where
    that is there already).

    Raises RecordingError where it cannot be read, or no column looks like a channel or like time; it then says what is
    there and which config key helps.
    """
    found = found or propose_file(path)
    layout, proposal = found.layout, found.proposal
    if not proposal.channels or proposal.time is None:
        raise RecordingError(f"{path}: {what_lacks(path, found.table, layout, proposal)}")
    source = Catalogue(
        path.parent, proposal.channels, proposal.time, files=path.name, layout=layout, coordinate=proposal.coordinate
    )
    recording = read_trial(Entry(path.name, path), source)
    glance = summary(recording)
    driver = next((name for name in INPUTS if name in proposal.channels), "")
    if driver:
        reason = f"the body is driven ({driver}), so that no release is looked for"
        return Inspection(path, layout, proposal, glance, None, reason, recording.notes)
    try:
        motion = condition(recording)
    except RecordingError as reason:
        return Inspection(path, layout, proposal, glance, None, str(reason), recording.notes)
    return Inspection(path, layout, proposal, glance, motion, "", recording.notes)


def what_lacks(path: Path, table: pd.DataFrame, layout: FileFormat, proposal: Proposal) -> str:
    """Why a file cannot be looked at further, and which keys of a config would tell what it holds."""
    if suffix_of(path) == ".mat":
        return (
            f"no vector is named like a channel and one like time; it holds {', '.join(list_variables(path))}: "
            "set recordings.variable for a matrix or structure, recordings.cells for a cell array of trials"
        )
    if strange := strange_unit(table):
        return strange
    if list(proposal.channels) == ["acceleration"]:
        return ALONE
    ranges = [
        f"{name} ({np.nanmin(values):.4g} to {np.nanmax(values):.4g})"
        for name, values in ((name, table[name].to_numpy(dtype=np.float64)) for name in table.columns[:COLUMNS_SHOWN])
        if np.isfinite(values).any()
    ]
    empty = [str(name) for name in table.columns if not np.isfinite(table[name].to_numpy(dtype=np.float64)).any()]
    ranges += [f"without a value: {', '.join(empty[:COLUMNS_SHOWN])}"] if empty else []
    named = "" if layout.header else " without names"
    keys = ", ".join(layout_lines(layout))
    how = f"set recordings {{{keys}}} and " if keys else ""
    rate = "" if proposal.time else "; no column looks like time: give channels.time: {rate_hz: ...}"
    what = "by number from 0" if not layout.header else "by hand"
    return (
        f"{len(table)} rows, {table.shape[1]} columns{named}: {', '.join(ranges)}; {how}write recordings.channels "
        f"{what}{rate}"
    )


def inspect_file(path: Path) -> str:
    """The same as text, with a config that runs as printed when saved beside the file, or why there is none."""
    found = propose_file(path)
    if found.response is not None:
        told, config = look(path, found.layout, found.response)
        return "\n".join([*told, PROPOSED, *config])
    seen = inspect(path, found)
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
    proposed = propose_config(seen.path, seen.layout, seen.proposal, seen.motion is not None)
    lines += [f"  doubt: {doubt}" for doubt in dict.fromkeys((*s.doubts, *proposed.doubts))]
    lines += [f"  note: {remark}" for remark in seen.remarks]
    lines.append(_motion_line(seen))
    lines += [f"  {remark}" for remark in seen.proposal.remarks]
    if not proposed.lines:
        return "\n".join([*lines, f"no config is proposed: {proposed.reason or seen.reason}"])
    return "\n".join([*lines, PROPOSED, *proposed.lines])


def save_config(path: Path, told: str) -> Path:
    """Write the config that `inspect_file` proposed beside the file, under its name; the config's path.

    Raises RecordingError where none was proposed, ConfigError where one is there already.
    """
    config = told.partition(f"{PROPOSED}\n")[2]
    if not config:
        raise RecordingError(f"{path}: no config is proposed, so that none is saved; see what stands above")
    target = path.with_name(f"{trial_name(path)}.yaml")
    try:
        with target.open("x", encoding="utf-8") as stream:
            stream.write(f"# Proposed by `undertow inspect` for {path.name}; it runs as it is.\n{config}\n")
    except FileExistsError as error:
        raise ConfigError(f"{target} is there already and is not overwritten; move it away") from error
    return target


def _motion_line(seen: Inspection) -> str:
    if seen.motion is None:
        return f"  no motion: {seen.reason}"
    w = seen.motion.window
    start = f"released at {w.release_s:.4f} +- {w.release_stderr_s:.4f} s" if w.held else "starts in mid-motion"
    unit = seen.motion.recording.unit("displacement")
    return f"  {start}, motion until {w.end_s:.4g} s, amplitude {seen.motion.amplitude:.4g} {unit}"
