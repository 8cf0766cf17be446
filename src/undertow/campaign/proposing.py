"""A config for one recording that runs as printed, or the reason why there is none.

What is proposed was loaded and its trial read, checked and conditioned, as a run would do.

Belongs here: that config's text and its trial run. Does not belong here: guesses of columns and layout
(recording/propose.py, recording/propose_layout.py).
"""

from __future__ import annotations

import glob
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from ruamel.yaml import YAML

from undertow.campaign.config import RunConfig
from undertow.campaign.run.checking import Checked, Checker
from undertow.recording.catalogue import ChannelSpec, Window
from undertow.recording.gather import gather
from undertow.recording.layout import FileFormat
from undertow.recording.propose import Proposal
from undertow.recording.readers import trial_name

TERMS = ("stiffness", "viscous_damping", "coulomb_friction")
"""What every body that swings may have: the equation that a proposal begins with."""

NO_TEXT = frozenset({"null", "true", "false"})
"""Words that YAML does not read as texts."""


@dataclass(frozen=True)
class Proposed:
    """Lines of a config; none with the ``reason``. ``doubts`` are what checking its trial found, in sentences."""

    lines: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    reason: str = ""


def propose_config(path: Path, layout: FileFormat, proposal: Proposal, window: Window, moves: bool) -> Proposed:
    """A config of one trial: the file's layout and channels, its window where a part must be cut off.

    ``window`` is the part without missing values; ``moves`` whether a motion was seen in it.
    """
    if not moves:
        return Proposed()
    lines = config_lines(path, layout, proposal, window)
    checked = _tried(lines, path.parent)
    hold = next((d for d in checked.found if d.kind == "hold"), None)
    said = tuple(d.sentence for d in checked.found)
    if hold is not None and checked.motion is not None:
        time = checked.motion.recording.time
        start = float(time[min(int(np.searchsorted(time, hold.factor)), time.size - 1)])
        lines = config_lines(path, layout, proposal, Window(start, window.end_s))
        checked = _tried(lines, path.parent)
        said = (hold.sentence, *(d.sentence for d in checked.found))
    if checked.failed is not None:
        return Proposed((), said, checked.failed.reason)
    if checked.contradiction:
        return Proposed((), said, "a run would stop at what contradicts above; correct it in a config of your own")
    return Proposed(lines, said)


def config_lines(path: Path, layout: FileFormat, proposal: Proposal, window: Window) -> tuple[str, ...]:
    """What a config says of one file, as YAML."""
    time = proposal.time
    pattern = _plain(glob.escape(path.name))
    stem = trial_name(path)
    lines = [f"name: {_plain(stem)}", "recordings:", f"  files: {pattern}"]
    lines += [f"  {line}" for line in layout_lines(layout)]
    lines.append("  channels:")
    if time is not None:
        lines.append(f"    time: {{column: {_plain(time.column)}, unit: {_plain(time.unit)}}}")
    lines += [f"    {name}: {_spec(spec)}" for name, spec in proposal.channels.items()]
    lines += ["trials:", "  group_by: [trial]", f"  conditions: {{{pattern}: {{trial: {_plain(stem)}}}}}"]
    lines += ["  dry: none", "  hold_out: []"]
    limits = {"start_s": window.start_s, "end_s": window.end_s}
    said = ", ".join(f"{name}: {value:.12g}" for name, value in limits.items() if value is not None)
    if said:
        lines.append(f"  window: {{{pattern}: {{{said}}}}}")
    lines += ["equation:", f"  terms: [{', '.join(TERMS)}]", f"  coordinate: {proposal.coordinate}"]
    return tuple(lines)


def _tried(lines: Sequence[str], folder: Path) -> Checked:
    """The trial of a proposed config as a run would have it before it is fitted."""
    config = RunConfig.model_validate(YAML(typ="safe", pure=True).load("\n".join(lines)))
    config._folder = folder.absolute()
    catalogue = config.catalogue()
    (entry,) = gather(catalogue)
    return Checker(config, catalogue)(entry)


def layout_lines(layout: FileFormat) -> Sequence[str]:
    """Keys of a layout that differ from what a config has by default."""
    said = {
        "skip_rows": str(layout.skip_rows) if layout.skip_rows else "",
        "header": "" if layout.header else "none",
        "unit_row": "true" if layout.unit_row else "",
        "decimal": "" if layout.decimal == "." else f'"{layout.decimal}"',
    }
    return [f"{key}: {value}" for key, value in said.items() if value]


def _spec(spec: ChannelSpec) -> str:
    columns = ", ".join(_plain(c) for c in spec.columns)
    where = f"columns: [{columns}]" if len(spec.columns) > 1 else f"column: {columns}"
    return f"{{{where}, unit: {_plain(spec.unit)}}}"


def _plain(value: object) -> str:
    """A value as YAML: bare where that is safe, in double quotes else."""
    text = str(value)
    safe = isinstance(value, int) or (text[:1].isalpha() and all(ch.isalnum() or ch in "_/^" for ch in text))
    if safe and text.lower() not in NO_TEXT:
        return text
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
