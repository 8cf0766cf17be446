"""What is in a file, before any config: channels, rate, gaps, noise, release, a proposed mapping.

Belongs here: the look at one file and its text. Does not belong here: judgement (recording/quality.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.equation.shelf import catalogue as shelf_catalogue
from undertow.errors import RecordingError
from undertow.recording.catalogue import Catalogue, ChannelSpec, Entry, read_trial
from undertow.recording.propose import Proposal, propose_mapping
from undertow.recording.quality import RecordingSummary, summary
from undertow.recording.readers import read_table


@dataclass(frozen=True)
class Inspection:
    """One file: its proposed mapping, its channels at a glance, and its motion (None with the ``reason``)."""

    path: Path
    proposal: Proposal
    summary: RecordingSummary
    motion: Motion | None
    reason: str = ""


def inspect(path: Path) -> Inspection:
    """Look at one file with the mapping that its column names suggest.

    Raises RecordingError where it cannot be read, or no column looks like a channel or like time.
    """
    proposal = propose_mapping(read_table(path))
    if not proposal.channels or proposal.time is None:
        said = "; ".join(proposal.remarks) or "no column names"
        raise RecordingError(
            f"{path.name}: {len(proposal.channels)} channels recognised ({said}); write recordings.channels by hand "
            "(header: none and skip_rows help with files without a header)"
        )
    source = Catalogue(path.parent, proposal.channels, proposal.time, files=path.name, coordinate=proposal.coordinate)
    recording = read_trial(Entry(path.name, path), source)
    try:
        return Inspection(path, proposal, summary(recording), condition(recording))
    except RecordingError as reason:
        return Inspection(path, proposal, summary(recording), None, str(reason))


def inspect_file(path: Path) -> str:
    """The same as text, with the mapping as YAML to paste into a config."""
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
    lines += [f"  doubt: {doubt}" for doubt in s.doubts]
    lines.append(_motion_line(seen))
    lines += [f"  {remark}" for remark in seen.proposal.remarks]
    return "\n".join([*lines, *_mapping(seen.proposal)])


def _motion_line(seen: Inspection) -> str:
    if seen.motion is None:
        return f"  no motion: {seen.reason}"
    w = seen.motion.window
    start = f"released at {w.release_s:.4f} +- {w.release_stderr_s:.4f} s" if w.held else "starts in mid-motion"
    unit = seen.motion.recording.unit("displacement")
    return f"  {start}, motion until {w.end_s:.4g} s, amplitude {seen.motion.amplitude:.4g} {unit}"


def _mapping(proposal: Proposal) -> list[str]:
    time = proposal.time
    lines = ["proposed mapping:", "  channels:"]
    if time is not None:
        lines.append(f"    time: {{column: {_plain(time.column)}, unit: {time.unit}}}")
    lines += [f"    {name}: {_spec(spec)}" for name, spec in proposal.channels.items()]
    return lines


def _spec(spec: ChannelSpec) -> str:
    columns = ", ".join(_plain(c) for c in spec.columns)
    where = f"columns: [{columns}]" if len(spec.columns) > 1 else f"column: {columns}"
    return f"{{{where}, unit: {_plain(spec.unit)}}}"


def _plain(value: object) -> str:
    """A value as YAML: bare where that is safe, in double quotes else."""
    text = str(value)
    safe = isinstance(value, int) or all(ch.isalnum() or ch in "_/^" for ch in text)
    return text if safe else '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def describe_terms() -> str:
    """Every term on the shelf: law, parameters with units, source, what a residual looks like without it."""
    blocks = []
    for term in shelf_catalogue():
        units = ", ".join(f"{p.name} [{p.unit}]" for p in term.parameters)
        blocks.append(
            f"{term.name}\n  law        {term.law}\n  parameters {units}\n  source     {term.source}\n"
            f"  left out   {term.left_out}"
        )
    return "\n".join(blocks)
