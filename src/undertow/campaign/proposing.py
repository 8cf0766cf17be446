"""A config for one recording that runs as printed, or the reason why there is none.

What is proposed was loaded and its trial read, checked and conditioned, as a run would do.

Belongs here: that config's text and its trial run. Does not belong here: guesses of columns and layout
(recording/propose_file.py).
"""

from __future__ import annotations

import glob
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from ruamel.yaml import YAML

from undertow.campaign.config import RunConfig
from undertow.campaign.run.checking import Checked, Checker
from undertow.discrepancy.words import count
from undertow.equation.driven_laws import FroudeKrylov
from undertow.equation.hydrodynamics import QuadraticDrag
from undertow.equation.registry import catalogue
from undertow.equation.structure import Stiffness, ViscousDamping
from undertow.recording.catalogue import ChannelSpec, TimeSpec, TimeWindow
from undertow.recording.gather import gather
from undertow.recording.layout import FileFormat
from undertow.recording.propose import Proposal
from undertow.recording.readers import trial_name
from undertow.recording.recording import INPUTS

TERMS = tuple(law.name for law in catalogue() if law.structural)
"""What every body that swings may have: the equation that a proposal begins with."""

DRIVEN_TERMS = ("stiffness", "viscous_damping", "constant_force")
WAVE_TERMS = tuple(law.name for law in (Stiffness, ViscousDamping, QuadraticDrag, FroudeKrylov))
"""The equation that a proposal for a driven body begins with."""

DRIVEN_IDENTIFY = "identify: [output_error]"
"""The only way in which a driven body is identified."""

NO_TEXT = frozenset({"null", "true", "false"})
"""Words that YAML does not read as texts."""


@dataclass(frozen=True)
class Proposed:
    """Lines of a config; none with the ``reason``. ``doubts`` are what checking its trial found, in sentences."""

    lines: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    reason: str = ""


def driven_terms(channels: Collection[str]) -> tuple[str, ...]:
    """The equation that a proposal begins with where one of the channels is an input; empty where none is."""
    if not any(name in INPUTS for name in channels):
        return ()
    return WAVE_TERMS if any(name.startswith("water_") for name in channels) else DRIVEN_TERMS


def propose_config(path: Path, layout: FileFormat, proposal: Proposal, moves: bool) -> Proposed:
    """A config of one trial: the file's layout and channels, its window where a part must be cut off.

    ``moves`` says whether a motion was seen in it.
    """
    if terms := driven_terms(proposal.channels):
        lines = config_lines(path, layout, proposal, TimeWindow(), terms)
        return Proposed((*lines, DRIVEN_IDENTIFY))
    if not moves:
        return Proposed()
    lines = config_lines(path, layout, proposal, TimeWindow())
    (checked,) = _tried(lines, path.parent)
    said = tuple(d.sentence for d in checked.found)
    if checked.releases:
        return _each_release(path, layout, proposal, checked)
    cut = hold_cut(checked)
    if cut is not None:
        lines = config_lines(path, layout, proposal, cut)
        held = tuple(d.sentence for d in checked.found if d.kind == "hold")
        (checked,) = _tried(lines, path.parent)
        said = (*held, *(d.sentence for d in checked.found))
    if checked.failed is not None:
        return Proposed((), said, checked.failed.reason)
    if checked.contradiction:
        return Proposed((), said, "a run would stop at what contradicts above; correct it in a config of your own")
    return Proposed(lines, said)


def _each_release(path: Path, layout: FileFormat, proposal: Proposal, whole: Checked) -> Proposed:
    """A config with a trial for each release of a recording that can be used."""
    pattern = glob.escape(path.name)
    every = config_lines(path, layout, proposal, TimeWindow(), releases={pattern: whole.releases})
    trials = _tried(every, path.parent)
    used = [part for part, one in zip(whole.releases, trials, strict=True) if one.failed is None]
    said = [f"it holds {count(len(trials), 'release')} on one clock: each is a trial (recordings.releases)"]
    said += [f"left out: {one.failed.reason}" for one in trials if one.failed is not None]
    said += [f"{one.name}: {d.sentence}" for one in trials for d in one.found]
    if not used or any(one.contradiction for one in trials):
        return Proposed((), tuple(said), "no release of it can be used; see what stands above")
    return Proposed(config_lines(path, layout, proposal, TimeWindow(), releases={pattern: used}), tuple(said))


def config_lines(
    path: Path,
    layout: FileFormat,
    proposal: Proposal,
    window: TimeWindow,
    terms: Sequence[str] = TERMS,
    releases: Mapping[str, Sequence[TimeWindow]] = MappingProxyType({}),
) -> tuple[str, ...]:
    """What a config says of one file, as YAML."""
    time = proposal.time
    pattern = plain(glob.escape(path.name))
    stem = trial_name(path)
    lines = [f"name: {plain(stem)}", "recordings:", f"  files: {pattern}"]
    lines += [f"  {line}" for line in (*parts_lines(releases), *layout_lines(layout))]
    lines.append("  channels:")
    if time is not None:
        lines.append(f"    time: {time_text(time)}")
    lines += [f"    {line}" for line in channel_lines(proposal.channels)]
    if driven_terms(proposal.channels):  # all trials of a driven body are fitted together
        lines += ["trials:", "  group_by: []"]
    else:
        lines += ["trials:", "  group_by: [trial]", f"  conditions: {{{pattern}: {{trial: {plain(stem)}}}}}"]
    lines += ["  dry: none", "  hold_out: []"]
    limits = {"start_s": window.start_s, "end_s": window.end_s}
    said = ", ".join(f"{name}: {value:.12g}" for name, value in limits.items() if value is not None)
    if said:
        lines.append(f"  window: {{{pattern}: {{{said}}}}}")
    lines += ["equation:", f"  terms: [{', '.join(terms)}]", f"  coordinate: {proposal.coordinate}"]
    return tuple(lines)


def channel_lines(channels: Mapping[str, ChannelSpec]) -> list[str]:
    """Keys of recordings.channels beside the time, where the base moves with frames."""
    lines = [f"{name}: {spec_text(spec)}" for name, spec in channels.items()]
    return [_against(line) for line in lines] if any(name.startswith("base_") for name in channels) else lines


def _against(line: str) -> str:
    """A channel's line where the base moves, with the usual frame of such a sensor, and a hold with an acceleration."""
    usual = {"displacement": "relative", "velocity": "relative", "acceleration": "absolute"}
    name = line.strip().split(":")[0]
    more = f"frame: {usual[name]}" if name in usual else "hold: band_limited" if name == "base_displacement" else ""
    return f"{line[:-1]}, {more}}}" if more and line.endswith("}") else line


def parts_lines(parts: Mapping[str, Sequence[TimeWindow]]) -> tuple[str, ...]:
    """What `recordings` says of recordings that hold several releases, by pattern: the part of each."""
    if not parts:
        return ()
    lines = ["# one recording holds several releases on one clock: the part of each is a trial", "releases:"]
    for pattern, own in sorted(parts.items()):
        lines.append(f"  {plain(pattern)}:")
        lines += [f"    - {{start_s: {one.start_s:.12g}, end_s: {one.end_s:.12g}}}" for one in own]
    return tuple(lines)


def hold_cut(checked: Checked) -> TimeWindow | None:
    """The part of a trial after a hand let go; None where none held it."""
    hold = next((d for d in checked.found if d.kind == "hold"), None)
    if hold is None or checked.motion is None:
        return None
    time = checked.motion.recording.time
    return TimeWindow(float(time[min(int(np.searchsorted(time, hold.factor)), time.size - 1)]))


def parsed(text: str, folder: Path) -> RunConfig:
    """A proposed config, with paths relative to a folder."""
    config = RunConfig.model_validate(YAML(typ="safe", pure=True).load(text))
    config._folder = folder.absolute()
    return config


def _tried(lines: Sequence[str], folder: Path) -> list[Checked]:
    """The trials of a proposed config as a run would have them before they are fitted."""
    config = parsed("\n".join(lines), folder)
    catalogue = config.catalogue()
    return [Checker(config, catalogue)(entry) for entry in gather(catalogue)]


def layout_lines(layout: FileFormat) -> Sequence[str]:
    """Keys of a layout that differ from what a config has by default."""
    default = layout_keys(FileFormat())
    return [f"{key}: {value}" for key, value in layout_keys(layout).items() if value != default[key]]


def layout_keys(layout: FileFormat) -> Mapping[str, str]:
    """What a config says of a layout, key by key."""
    return {
        "skip_rows": str(layout.skip_rows),
        "header": "first" if layout.header else "none",
        "unit_row": "true" if layout.unit_row else "false",
        "variable": "null" if layout.variable is None else plain(layout.variable),
        "decimal": f'"{layout.decimal}"',
    }


def spec_text(spec: ChannelSpec) -> str:
    """A channel as a config writes it."""
    columns = ", ".join(plain(c) for c in spec.columns)
    said = [f"columns: [{columns}]" if len(spec.columns) > 1 else f"column: {columns}", f"unit: {plain(spec.unit)}"]
    if spec.file is not None:
        said.append(f"file: {plain(spec.file)}")
    if spec.variable is not None:
        said.append(f"variable: {plain(spec.variable)}")
    if spec.time is not None:
        said.append(f"time: {time_text(spec.time)}")
    return f"{{{', '.join(said)}}}"


def time_text(time: TimeSpec) -> str:
    """Time as a config writes it."""
    return f"{{column: {plain(time.column)}, unit: {plain(time.unit)}}}"


def plain(value: object) -> str:
    """A value as YAML: bare where that is safe, in double quotes else."""
    text = str(value)
    safe = isinstance(value, int) or (text[:1].isalpha() and all(ch.isalnum() or ch in "_/^" for ch in text))
    if safe and text.lower() not in NO_TEXT:
        return text
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
