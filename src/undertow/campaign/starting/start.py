"""From a folder of recordings to a config that runs: looked at, drafted, every trial tried as a run would, written.

Belongs here: that order. Does not belong here: the look (survey.py), names (names.py), text (draft.py).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from shlex import quote

from undertow.campaign.config import RunConfig
from undertow.campaign.config.matching import planned
from undertow.campaign.driven.trials import driven_trials, is_driven
from undertow.campaign.proposing import driven_terms, hold_cut, parsed
from undertow.campaign.response.proposing import response_lines, usable
from undertow.campaign.run.checking import Checked, Checker
from undertow.campaign.run.one_body import Swing, apart, bodies, parted_by, swings_of
from undertow.campaign.starting.beside import joined, parted
from undertow.campaign.starting.draft import Draft
from undertow.campaign.starting.names import Named, read_names
from undertow.campaign.starting.survey import Survey, survey
from undertow.discrepancy.words import count
from undertow.errors import ConfigError, RecordingError, UndertowError
from undertow.recording.catalogue import Entry, TimeWindow
from undertow.recording.gather import by_release

FILE_NAME = "undertow.yaml"
"""The config's name, in the folder that it is about."""

ASKED = "fill in specimen: mass_kg and, of the part in water, area_m2 and submerged_volume_m3"
"""What is to be done where dry trials are known: without a mass or a stiffness they say nothing of the body in water,
and without its volume the friction there is taken to be as large as in air."""

TERMS_FIRST = "look at the equation's terms"
"""What is to be done of a driven body: its recordings alone give kilograms."""

DOUBTS_SHOWN = 6
"""Guesses on the terminal at most."""

CONTRADICTS = "contradicts itself; correct it, then take it out of exclude: "
_KEY = re.compile(r"\b(recordings|trials)\.[a-z]")

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Started:
    """The written config, how many trials it uses, files it leaves out and why, how many layouts it has, what is to be
    done ``next``, and guesses without which every number may be wrong (``doubts``)."""

    path: Path
    trials: int
    left_out: tuple[tuple[str, str], ...]
    layouts: int
    next: str
    doubts: tuple[str, ...] = ()

    @property
    def summary(self) -> str:
        """The same in lines."""
        kinds = "one layout" if self.layouts == 1 else f"{self.layouts} layouts"
        without = f"; {count(len(self.left_out), 'file')} left out:" if self.left_out else ""
        lines = [f"written: {self.path}: {count(self.trials, 'trial')} in {kinds}{without}"]
        lines += [f"  {name}: {why}" for name, why in self.left_out]
        lines += [f"  guessed: {doubt}" for doubt in self.doubts[:DOUBTS_SHOWN]]
        if len(self.doubts) > DOUBTS_SHOWN:
            lines.append(f"  and {len(self.doubts) - DOUBTS_SHOWN} more guesses, which stand in the config")
        return "\n".join([*lines, f"next: {self.next}, then undertow run {quote(str(self.path))}"])


def start(folder: Path, out: Path | None = None, progress: Progress = lambda stage, done, of: None) -> Started:
    """Look at a folder's recordings and write a config (``undertow.yaml`` there) that runs as it is.

    Files that cannot be read or used are left out with the reason as a comment; a start held by hand is cut.

    Raises ConfigError where the folder holds no recording that can be read or the config is there already,
    UndertowError where no trial can be used.
    """
    path = out or folder / FILE_NAME
    if path.exists():
        raise ConfigError(f"{path} is there already and is not overwritten; move it away or give another with --out")
    if path.parent.resolve() != folder.resolve():
        raise ConfigError(f"{path} must lie in {folder}: its paths are relative to it; give a name there with --out")
    found = survey(folder, lambda done, of: progress("look", done, of))
    if found.sets:
        return _written_sets(found, folder, path)
    named = read_names(found.files) if found.index is None else found.index.named
    notes = (f"{found.index.name}: {named.beside} (trials.group_by)",) if found.index and named.beside else ()
    draft = _planned(Draft(folder.resolve().name or "campaign", found, named, notes=notes), folder)
    found = draft.survey
    tried = _tried(draft, folder, progress)
    if not tried.trials:
        draft = replace(draft, parts=tried.parts)
        raise UndertowError(_none_left(draft, tried.left_out, folder, path))
    draft = tried
    _config(draft, folder)
    _write(path, draft.text())
    left_out = (*found.unread, *draft.left_out.items())
    asked = TERMS_FIRST if driven_terms(dict(found.groups[0].reading.channels)) else (
        ASKED if draft.named.wet else "fill in specimen and dry"
    )  # fmt: skip
    said = (*found.doubts, *draft.notes)
    return Started(path, draft.trials, tuple(sorted(left_out)), len(found.groups), asked, said)


def _with_sensors(draft: Draft) -> Draft:
    """The draft with files of one sensor each joined to their trials."""
    whole = parted(draft.survey)
    named = read_names(whole.files) if whole.index is None and draft.named != Named() else draft.named
    one = joined(whole, named)
    if not one.patterns:
        return replace(draft, notes=(*draft.notes, *one.said))
    told = (
        f"{', '.join(one.patterns)}: files of one sensor each are joined to the trials that they are named like (file, "
        "in recordings.channels)"
    )
    return replace(draft, survey=one.survey, named=named, beside=one.patterns, notes=(*draft.notes, told, *one.said))


def _written_sets(found: Survey, folder: Path, path: Path) -> Started:
    """A config of a folder's harmonic sets that are read as most of them are; each is tried as a run would."""
    alike: dict[str, list[str]] = {}
    for name, layout, proposal in found.sets:
        alike.setdefault("\n".join(response_lines("tried", ["*"], layout, proposal)), []).append(name)
    most = max(alike.values(), key=len)
    layout, first = next((layout, proposal) for name, layout, proposal in found.sets if name in most)
    left_out, names = dict(found.unread), list[str]()
    for name, _, _ in found.sets:
        if name not in most:
            left_out[name] = f"its columns are not those of {most[0]}; it needs a config of its own"
            continue
        try:
            usable("\n".join(response_lines("tried", [name], layout, first)), folder)
        except RecordingError as error:
            left_out[name] = str(error)
            continue
        names.append(name)
    if not names:
        why = "; ".join(f"{name}: {reason}" for name, reason in list(left_out.items())[:3])
        raise UndertowError(f"none of {len(found.sets)} harmonic sets in {folder} can be used; {why}")
    said = ["Proposed by `undertow init` from the files. It runs as it is; correct what was guessed.", *first.remarks]
    said += [f"left out: {name}: {reason}" for name, reason in sorted(left_out.items())]
    title = folder.resolve().name or "campaign"
    lines = [*(f"# {line}" for line in said), *response_lines(title, names, layout, first)]
    _write(path, "\n".join(lines) + "\n")
    return Started(path, len(names), tuple(sorted(left_out.items())), 1, TERMS_FIRST)


def _none_left(draft: Draft, left_out: Mapping[str, str], folder: Path, path: Path) -> str:
    """Why no trial can be used. Where a reason names a key of the config, this is written with all of them."""
    name, why = next((one for one in left_out.items() if _KEY.search(one[1])), next(iter(left_out.items())))
    said = f"none of {len(left_out)} trials in {folder} can be used; {name}: {why.removeprefix(CONTRADICTS)}"
    if not _KEY.search(why):
        return said
    _write(path, draft.text(f"{name}: {why.removeprefix(CONTRADICTS)}"))
    if draft.survey.doubts:
        said += f" (guessed: {'; '.join(draft.survey.doubts[:DOUBTS_SHOWN])})"
    return f"{said}. {path} is written with all of them: correct it there, then undertow run {path}"


def _write(path: Path, text: str) -> None:
    with path.open("x", encoding="utf-8") as stream:
        stream.write(text)


def _config(draft: Draft, folder: Path) -> RunConfig:
    """The draft as a config that matches its files; ConfigError where it does not."""
    config = parsed(draft.text(), folder)
    planned(config)
    return config


def _planned(draft: Draft, folder: Path) -> Draft:
    """The draft with channels of files beside the trials' own, without what was read from names where that does not
    fit together."""
    found = _with_sensors(draft)
    try:
        _config(found, folder)
    except ConfigError as error:
        said = str(error).splitlines()[0].removeprefix("config: ")
        names = "File names" if draft.survey.index is None else "The index's columns"
        note = f"{names} give no conditions that fit together ({said})."
        found = _with_sensors(replace(draft, named=Named(), notes=(note,)))
        _config(found, folder)
    return found


def _tried(draft: Draft, folder: Path, progress: Progress) -> Draft:
    """The draft with those trials left out that a run could not use, held starts cut, and a trial for each release of
    recordings that hold several."""
    config = _config(draft, folder)
    if is_driven(config):
        failed = driven_trials(config)[1]
        names = {e.name: e.path.relative_to(folder.absolute()).as_posix() for e in planned(config).entries}
        return replace(draft, left_out={names[one]: why for one, why in failed.items()})
    checker, entries = Checker(config, config.catalogue()), planned(config).entries
    left_out: dict[str, str] = {}
    starts: dict[str, float] = {}
    parts: dict[str, tuple[TimeWindow, ...]] = {}
    motions = []
    for done, entry in enumerate(entries):
        progress("try", done, len(entries))
        name = entry.path.relative_to(folder.absolute()).as_posix()
        whole = checker(entry)
        trials = {name: (entry, whole)}
        if whole.releases:
            parts[name] = whole.releases
            trials = {one.name: (one, checker(one)) for one in by_release(entry, whole.releases)}
        for label, (one, seen) in trials.items():
            checked, start_s = _without_hold(checker, one, seen)
            if checked.failed is not None:
                left_out[label] = checked.failed.reason.removeprefix(f"trial {one.name}: ")
            elif checked.contradiction:
                left_out[label] = f"{CONTRADICTS}{checked.contradiction}"
            elif checked.motion is not None:
                motions.append(checked.motion)
                starts |= {} if start_s is None else {label: start_s}
    progress("try", len(entries), len(entries))
    notes = (*draft.notes, *([_several(parts)] if parts else []))
    return _parted(replace(draft, left_out=left_out, starts=starts, parts=parts, notes=notes), swings_of(motions))


def _without_hold(checker: Checker, entry: Entry, checked: Checked) -> tuple[Checked, float | None]:
    """A trial without a hold that it begins with, and where it begins then, s; None where nothing is cut."""
    cut = hold_cut(checked)
    again = None if cut is None else checker(replace(entry, window=cut))
    return (checked, None) if cut is None or again is None or again.failed is not None else (again, cut.start_s)


def _several(parts: Mapping[str, Sequence[TimeWindow]]) -> str:
    """That recordings hold several releases each, in a sentence."""
    named = ", ".join(f"{name} {len(own)}" for name, own in list(parts.items())[:DOUBTS_SHOWN])
    more = ", ..." if len(parts) > DOUBTS_SHOWN else ""
    holds = "holds" if len(parts) == 1 else "hold"
    return (
        f"{count(len(parts), 'recording')} {holds} several releases on one clock ({named}{more}): each release is a "
        "trial, name_1, name_2, ... (recordings.releases has the part of each)"
    )


def _parted(draft: Draft, swings: Sequence[Swing]) -> Draft:
    """The draft with groups by a word of the names, where trials of one group swing at periods of several bodies and
    each has its own word: a word of every trial would part them too."""
    groups: dict[tuple[object, ...], list[Swing]] = {}
    for one in swings:
        groups.setdefault(tuple(one.conditions.get(key) for key in draft.named.group_by), []).append(one)
    mixed = [one for members in groups.values() if apart(members) for one in members]
    name = parted_by(mixed)
    values = {one.conditions[name] for one in mixed} if name else set()
    words = draft.survey.index is not None or all(isinstance(value, str) for value in values)
    if not name or len(values) != bodies(mixed) or not words:
        return draft
    periods = [one.period_s for one in mixed]
    said = f"trials swing at periods from {min(periods):.3g} to {max(periods):.3g} s: groups go by {name} too"
    named = replace(draft.named, group_by=(*draft.named.group_by, name))
    return replace(draft, named=named, notes=(*draft.notes, said))
