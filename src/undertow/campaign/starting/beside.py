"""Files of one sensor each: which trial they belong to by their names, and the `file` of a config that joins them.

Belongs here: names of such files against names of trials. Does not belong here: what is in them (survey.py), the text
of the config (draft.py).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from undertow.campaign.starting.names import Named
from undertow.campaign.starting.survey import Alike, Reading, Survey
from undertow.discrepancy.words import count
from undertow.recording.patterns import Patterns
from undertow.recording.readers import suffix_of, trial_name
from undertow.recording.recording import INPUTS

_APART = re.compile(r"([/_\-\s]+)")


@dataclass(frozen=True)
class Joined:
    """A survey with the channels of files beside the trials' own, the patterns of these files with what they hold, and
    what is to be done by hand (``said``) with those that no key of a config joins."""

    survey: Survey
    patterns: Mapping[str, str] = field(default_factory=dict)
    said: tuple[str, ...] = ()


def joined(found: Survey, named: Named) -> Joined:
    """The survey with every file of one sensor that has a trial's name but for one part, as its trial's channel."""
    files = found.files
    kinds: dict[tuple[str, Reading], dict[str, str]] = {}
    for name, reading in found.parts.items():
        trial = _trial_of(name, files)
        if trial:
            kinds.setdefault((_template(name, trial, named), reading), {})[name] = trial
    survey, patterns, said = found, dict[str, str](), list[str]()
    for (template, reading), members in kinds.items():
        channels = ", ".join(name for name, _ in reading.channels)
        why = _why_not(template, reading, members, survey)
        if why:
            said.append(f"{_listed(members)} {channels} alone: {why}")
            continue
        survey = _with(survey, template, reading, members)
        for pattern in _patterns(template, members, files):
            patterns[pattern] = f"{channels} of the trials, by recordings.channels.{reading.channels[0][0]}.file"
    return Joined(survey, patterns, tuple(said))


def parted(found: Survey) -> Survey:
    """The survey with groups of velocities alone, each beside a file with the displacement, as parts."""
    whole = [one for group in found.groups for one in group.files if "displacement" in dict(group.reading.channels)]
    alone = [
        group for group in found.groups
        if "displacement" not in dict(group.reading.channels) and all(_trial_of(one, whole) for one in group.files)
    ]  # fmt: skip
    parts = {name: group.reading for group in alone for name in group.files}
    return replace(
        found, groups=tuple(group for group in found.groups if group not in alone), parts={**found.parts, **parts}
    )


def _trial_of(name: str, files: Sequence[str]) -> str:
    """The trial's own file whose name differs in one part, or lacks the last one; empty where none or several do."""
    own = _parts(name)
    near = [one for one in files if _is_near(own, _parts(one))]
    return near[0] if len(near) == 1 else ""


def _parts(name: str) -> list[str]:
    """Parts of a path without its suffix, and what stands between them."""
    return _APART.split(name.removesuffix(suffix_of(Path(name))))


def _is_near(part: Sequence[str], trial: Sequence[str]) -> bool:
    if len(part) == len(trial) + 2:
        return list(part[: len(trial)]) == list(trial)
    different = [at for at, (one, other) in enumerate(zip(part, trial, strict=False)) if one != other]
    words = [(part[at], trial[at]) for at in different]
    return len(part) == len(trial) and len(words) == 1 and all(one[:1].isalpha() for one in words[0])


def _template(name: str, trial: str, named: Named) -> str:
    """The name of a file beside a trial's own with {stem} or conditions in braces; empty where it lies elsewhere, or
    what differs from trial to trial is no condition."""
    folder, _, base = name.rpartition("/")
    above, _, own = trial.rpartition("/")
    stem = trial_name(Path(own))
    if folder != above:
        return ""
    if base.startswith(stem):
        return f"{{stem}}{base.removeprefix(stem)}"
    match = re.search(named.pattern, own) if named.pattern else None
    if match is None:
        return base
    spans = sorted((match.span(group), group) for group in match.groupdict() if match.group(group) is not None)
    pieces, end, shift = list[str](), 0, len(base) - len(own)
    for (begin, stop), group in spans:
        for at in (0, shift):  # before what differs, or behind it
            if base[begin + at : stop + at] == own[begin:stop] and begin + at >= end:
                pieces += [base[end : begin + at], f"{{{group}}}"]
                end = stop + at
                break
        else:
            return base
    return "".join([*pieces, base[end:]])


def _why_not(template: str, reading: Reading, members: Mapping[str, str], survey: Survey) -> str:
    """Why files of one sensor are not joined to their trials, and what to do; empty where they are."""
    first = next(iter(members))
    stem = trial_name(Path(members[first]))
    if not template:
        ending = f"_{Path(first).parent.name or 'sensor'}{suffix_of(Path(first))}"
        return (
            f"copy them beside their trials' files, as {Path(members[first]).parent / (stem + ending)}, and take the "
            "config away and start again with undertow init"
        )
    if "{" not in template and len(members) > 1:
        return f"name them as their trials, {stem}_sensor{suffix_of(Path(first))}, and start again with undertow init"
    owners = [group for group in survey.groups if set(group.files) & set(members.values())]
    if len(survey.groups) != 1 or not owners:
        return "their trials are read in several ways; give each channel its file in recordings.channels by hand"
    base = owners[0].reading
    if {name for name, _ in reading.channels} & {name for name, _ in base.channels}:
        return "their trials have that channel themselves"
    if base.layout != reading.layout:
        return "their lines are laid out otherwise than their trials'; save all of them in one way"
    return ""


def _with(survey: Survey, template: str, reading: Reading, members: Mapping[str, str]) -> Survey:
    """The survey with the channels of these files in the reading of its trials."""
    group = survey.groups[0]
    clock = None if reading.time == group.reading.time else reading.time
    more = tuple((name, replace(spec, file=template, time=clock)) for name, spec in reading.channels)
    order = (*(one for one in group.reading.channels if one[0] not in INPUTS), *more,
             *(one for one in group.reading.channels if one[0] in INPUTS))  # fmt: skip
    changed = Alike(replace(group.reading, channels=order), group.files, group.patterns)
    unread = tuple(one for one in survey.unread if one[0] not in members)
    more_doubts = dict.fromkeys(doubt for name in members for doubt in survey.doubts_of_parts.get(name, ()))
    return replace(
        survey, groups=(changed, *survey.groups[1:]), unread=unread, doubts=(*survey.doubts, *more_doubts),
        remarks=(*survey.remarks, *more_doubts),
    )  # fmt: skip


def _patterns(template: str, members: Mapping[str, str], files: Sequence[str]) -> list[str]:
    """One pattern that fits these files and no trial, else each of them."""
    pattern = re.sub(r"\{\w+\}", "*", template)
    one = Patterns([pattern])
    if any(one.fit(trial_name(Path(name)), name) for name in files):
        return list(members)
    return [pattern] if all(one.fit(trial_name(Path(name)), name) for name in members) else list(members)


def _listed(members: Mapping[str, str]) -> str:
    """Files with the trial that the first belongs to."""
    (name, trial), *more = members.items()
    others = f" and {count(len(more), 'more file')}" if more else ""
    return f"{name}{others}, beside {trial}, hold{'' if more else 's'}"
