"""What is in a harmonic set's file, and a config for such files that runs as printed.

Belongs here: that look and that text. Does not belong here: guesses of columns (recording/propose_response.py),
recordings in time (campaign/inspection.py, proposing.py).
"""

from __future__ import annotations

import glob
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from undertow.campaign.proposing import layout_lines, parsed, plain
from undertow.campaign.response.sets import Sweeps, sweeps
from undertow.discrepancy.words import count
from undertow.errors import RecordingError
from undertow.recording.layout import FileFormat
from undertow.recording.propose_response import ResponseProposal
from undertow.recording.readers import trial_name

TERMS = ("stiffness", "viscous_damping")
"""The equation that a proposal begins with."""


def response_lines(
    name: str, files: Sequence[str], layout: FileFormat, proposal: ResponseProposal
) -> tuple[str, ...]:  # fmt: skip
    """A config of harmonic sets that are read alike, as YAML; ``files`` are paths from its folder."""
    globs = [plain(glob.escape(file)) for file in files]
    lines = [f"name: {plain(name)}", "recordings:"]
    lines += [f"  files: {globs[0]}"] if len(globs) == 1 else ["  files:", *(f"    - {one}" for one in globs)]
    lines += [f"  {line}" for line in layout_lines(layout)]
    lines.append("  response:")
    for key, (column, unit) in proposal.columns.items():
        said = [f"column: {plain(column)}", *([f"unit: {plain(unit)}"] if key != "sweep" else [])]
        said += ["sign: -1"] if key == "phase" and proposal.lag else []
        said += ["frame: relative"] if key == "amplitude" and proposal.drive.startswith("base_") else []
        lines.append(f"    {key}: {{{', '.join(said)}}}")
    if not proposal.drive:
        lines.append(f"    force: {{value: 1.0, unit: {plain('N m' if proposal.coordinate == 'rotation' else 'N')}}}")
    lines += ["equation:", f"  terms: [{', '.join(TERMS)}]", f"  coordinate: {proposal.coordinate}"]
    return (*lines, "identify: [output_error]")


def look(path: Path, layout: FileFormat, proposal: ResponseProposal) -> tuple[list[str], tuple[str, ...]]:
    """A harmonic set at a glance, and the lines of its config.

    Raises RecordingError where a run could not use the set.
    """
    config = response_lines(trial_name(path), [path.name], layout, proposal)
    group = usable("\n".join(config), path.parent)[0]
    table = group.tables[0]
    hertz, phase = table.rate / (2.0 * math.pi), np.degrees(table.phase)
    upward = int(np.sum(table.rising))
    lines = [
        f"{path}",
        f"  a harmonic set: {hertz.size} points, {hertz.min():.5g} to {hertz.max():.5g} Hz, {upward} of them reached "
        f"upward and {hertz.size - upward} downward ({count(len(group.along), 'sweep')})",
        f"  amplitude: {table.amplitude.min():.5g} to {table.amplitude.max():.5g} {group.unit}",
        f"  phase before the drive: {phase.min():.4g} to {phase.max():.4g} deg",
    ]
    if proposal.drive:
        lines.append(f"  {proposal.drive}: {table.drive.min():.5g} to {table.drive.max():.5g}")
    return [*lines, *(f"  {remark}" for remark in proposal.remarks)], config


def usable(text: str, folder: Path) -> list[Sweeps]:
    """The sets of a proposed config; RecordingError where one of them cannot be used."""
    groups, failed = sweeps(parsed(text, folder))
    if failed:
        raise RecordingError("; ".join(failed.values()))
    return groups
