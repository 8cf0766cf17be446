"""The text of a campaign's first config: what was found as keys, what was guessed as comments beside them.

Belongs here: YAML. Does not belong here: looking at files (survey.py, names.py), trying the config (start.py).
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from glob import escape
from pathlib import Path

from undertow.campaign import proposing
from undertow.campaign.starting.names import Named
from undertow.campaign.starting.survey import Alike, Reading, Survey
from undertow.equation.hydrodynamics import AddedMass, QuadraticDrag
from undertow.recording.channels import TimeWindow
from undertow.recording.readers import suffix_of
from undertow.recording.recording import CHANNELS

WIDTH = 118
"""Characters of a comment's line."""

WATER_TERMS = (AddedMass.name, QuadraticDrag.name)
"""What still water does to any body: a campaign with dry trials and others begins with it, else it would be found as
something hidden."""

SPECIMEN = """\
# What the laboratory knows of the specimen; every entry is optional, and a table may go by a condition:
# specimen:
#   mass_kg: 100.0                 # all that moves when dry
#   stiffness_N_per_m: {by: spring, short: 4.0e+5, long: 1.1e+5}
#   area_m2: 1.0                   # drag area of the part in water
#   submerged_volume_m3: 0.1       # takes weight off: without it friction in water is taken to be as large as in air"""
"""Keys to be filled in."""


@dataclass(frozen=True)
class Draft:
    """What a config will say. ``left_out`` are files and why; ``starts`` files and the first instant used, s;
    ``parts`` files that hold several releases and the part of each; ``beside`` patterns of files that hold channels of
    trials, and what they hold; ``notes`` are sentences that stand above it."""

    name: str
    survey: Survey
    named: Named
    left_out: Mapping[str, str] = field(default_factory=dict)
    starts: Mapping[str, float] = field(default_factory=dict)
    parts: Mapping[str, Sequence[TimeWindow]] = field(default_factory=dict)
    beside: Mapping[str, str] = field(default_factory=dict)
    notes: Sequence[str] = ()

    @property
    def trials(self) -> int:
        """How many trials are used."""
        more = sum(len(own) - 1 for own in self.parts.values())
        return len(self.survey.files) + more - len(self.left_out)

    def text(self, wrong: str = "") -> str:
        """The config as YAML with comments; ``wrong`` is why no trial can be used as it is."""
        base = self.survey.groups[0].reading
        driven = proposing.driven_terms(dict(base.channels))
        terms = driven or proposing.TERMS + (WATER_TERMS if self.named.wet else ())
        lines = [
            *_comment(f"Proposed by `undertow init` from the files. {_state(wrong)} Guesses stand beside their keys."),
            *(line for note in self.notes for line in _comment(note)),
            f"name: {proposing.plain(self.name)}",
            "recordings:",
            *_indented(self._recordings(base), 2),
            "trials:",
            *_indented(self._trials(), 2),
            *SPECIMEN.splitlines(),
            "equation:",
            "  # undertow terms lists all; added_mass and quadratic_drag are what still water does",
            f"  terms: [{', '.join(terms)}]",
            f"  coordinate: {base.coordinate}",
            *([proposing.DRIVEN_IDENTIFY] if driven else []),
        ]  # fmt: skip
        return "\n".join(lines) + "\n"

    def _recordings(self, base: Reading) -> list[str]:
        globs = ["files:", *(f"  - {proposing.plain(one)}" for one in _globs(self.survey.files))]
        lines = globs if self.survey.index is None else self.survey.index.lines
        if self.named.pattern:
            said = ", ".join(f"{name} ({meaning})" for name, meaning in self.named.meanings.items())
            lines += _comment(f"parts of the file names are conditions: {said}")
            lines.append(f"pattern: {proposing.plain(self.named.pattern)}")
        left_out = {**self._unread(), **self.left_out}
        if left_out or self.beside:
            lines.append("exclude:")
            for pattern, why in self.beside.items():
                lines += [*_indented(_comment(f"no trials of their own: {why}"), 2), f"  - {proposing.plain(pattern)}"]
            for name, why in sorted(left_out.items()):
                lines += [*_indented(_comment(why), 2), f"  - {proposing.plain(escape(name))}"]
        lines += proposing.parts_lines({escape(name): parts for name, parts in self.parts.items()})
        lines += proposing.layout_lines(base.layout)
        for remark in self.survey.remarks:
            lines += _comment(f"guessed: {remark}")
        lines += ["channels:", f"  time: {proposing.time_text(base.time)}"]
        lines += [f"  {line}" for line in proposing.channel_lines(dict(base.channels))]
        others = [group for group in self.survey.groups[1:] if set(group.files) - set(self.left_out)]
        if others:
            lines.append("layouts:")
        for group in others:
            for pattern in group.patterns:
                lines += [f"  {proposing.plain(pattern)}:", *_indented(_differences(base, group), 4)]
        return lines

    def _unread(self) -> dict[str, str]:
        """Files that cannot be read and that the globs fit all the same."""
        index, ends = self.survey.index, {_end(name) for name in self.survey.files}
        fits = index.listed if index is not None else {name for name, _ in self.survey.unread if _end(name) in ends}
        return {name: why for name, why in self.survey.unread if name in fits}

    def _trials(self) -> list[str]:
        lines = [
            "# trials with the same of these conditions are fitted together",
            f"group_by: [{', '.join(map(proposing.plain, self.named.group_by))}]",
        ]
        if self.named.dry is not None:
            name, value = self.named.dry
            said = f"{value:.12g}" if isinstance(value, float) else proposing.plain(value)
            lines.append(f"dry: {{{proposing.plain(name)}: {said}}}")
        else:
            lines += ["# conditions of the trials without water: {water_depth_m: 0}", "dry: none"]
        if self.starts:
            lines += ["# a hand holds the body before these instants", "window:"]
            for name, start in sorted(self.starts.items()):
                lines.append(f"  {proposing.plain(escape(name))}: {{start_s: {start:.12g}}}")
        return lines


def _differences(base: Reading, group: Alike) -> list[str]:
    """Keys of a layout in which a group differs from the base."""
    there = group.reading
    own, others = proposing.layout_keys(there.layout), proposing.layout_keys(base.layout)
    lines = [f"{key}: {value}" for key, value in own.items() if value != others[key]]
    channels, known = dict(there.channels), dict(base.channels)
    said = [f"time: {proposing.time_text(there.time)}"] if there.time != base.time else []
    for name in CHANNELS:
        if channels.get(name) != known.get(name):
            said.append(f"{name}: {proposing.spec_text(channels[name]) if name in channels else 'none'}")
    return [*lines, *(["channels:", *_indented(said, 2)] if said else [])] or ["header: first"]


def _globs(files: Iterable[str]) -> list[str]:
    """One glob for every folder and suffix."""
    return sorted({f"{escape(folder)}/*{end}" if folder else f"*{end}" for folder, end in map(_end, files)})


def _end(name: str) -> tuple[str, str]:
    """Folder and suffix of a file, as they are written."""
    folder, _, base = name.rpartition("/")
    suffix = suffix_of(Path(base))
    return folder, base[-len(suffix):] if suffix else ""


def _state(wrong: str) -> str:
    """Whether the config runs as it is."""
    return f"Correct it first, no trial can be used: {wrong}." if wrong else "It runs as it is."


def _comment(text: str) -> list[str]:
    """A sentence as lines of comment."""
    return textwrap.wrap(
        " ".join(text.split()), WIDTH, initial_indent="# ", subsequent_indent="# ", break_long_words=False,
        break_on_hyphens=False,
    )  # fmt: skip


def _indented(lines: Iterable[str], by: int) -> list[str]:
    return [" " * by + line for line in lines]
