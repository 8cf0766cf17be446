"""Each trial read, conditioned and checked before anything is fitted: its channels against each other and the config.

A doubt goes to the trial's notes. A trial whose channels contradict each other fails; where half of a group's trials
do, the group cannot tell anything; where every group does, the config is wrong and the run stops.

Belongs here: that order and those consequences. Does not belong here: the checks (conditioning/agreement.py,
conditioning/decaying.py), identified numbers (plausible.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import pandas as pd

from undertow.campaign.config import GroupKey, RunConfig
from undertow.campaign.run.cut_off import SeenEnd, common, reached
from undertow.campaign.run.neighbours import misplaced
from undertow.conditioning.agreement import Disagreement, disagreements
from undertow.conditioning.condition import condition
from undertow.conditioning.decaying import HoldSeen, after_hold, hold_not_cut, refuse_no_decay, why_no_decay
from undertow.conditioning.motion import Motion, Window
from undertow.conditioning.pairs import Stated
from undertow.conditioning.period import dominant_period
from undertow.conditioning.release import find_window, followed
from undertow.conditioning.releases import Released, releases_said, several_releases
from undertow.conditioning.remedies import units_of
from undertow.discrepancy.findings import FailedTrial
from undertow.discrepancy.words import count, group_title
from undertow.errors import FAILURES, ClippedError, ConfigError, LostValuesError, MisnamedError, failure
from undertow.recording.catalogue import EVERYTHING, Catalogue, Entry, TimeWindow, read_trial, trial_of_table
from undertow.recording.copies import copies
from undertow.recording.noise import noise
from undertow.recording.propose import UNSAID_CLOCK
from undertow.recording.quality import doubts
from undertow.recording.recording import LEFT_OUT, Condition, Recording

CONTRADICTED_SHARE = 0.5
"""Share of a group's trials whose contradictions are the group's: more than single trials, the same mistake in most."""

CLOCK = ("time",)
"""Channels of a doubt about the time alone."""

OF_THE_CLOCK = "correct recordings.channels.time.unit, or list unit in recordings.accept"
"""What to do about it."""

GROUPS_NAMED = 5
"""Groups of which a message that stops the run gives one trial's sentence."""


@dataclass(frozen=True)
class Checked:
    """One trial: its motion or why it failed, what does not belong together in it, without doubts ``accepted``, the
    ends of its sensors' ranges that are seen in it, and of a record with several ``releases`` the part of each."""

    name: str
    conditions: Mapping[str, Condition]
    motion: Motion | None = None
    failed: FailedTrial | None = None
    found: tuple[Disagreement, ...] = ()
    accepted: tuple[str, ...] = ()
    ends: tuple[SeenEnd, ...] = ()
    releases: tuple[TimeWindow, ...] = ()

    @property
    def contradiction(self) -> str:
        """What certainly does not belong together, in a sentence, and a clock that may be the reason; empty where
        nothing does so certainly."""
        certain = [one.sentence for one in self.found if one.certain]
        clock = [one.sentence for one in self.found if one.channels == CLOCK and not one.certain]
        return "; ".join([*certain, *clock]) if certain else ""


@dataclass(frozen=True)
class Checker:
    """Reads, checks and conditions one entry; picklable for worker processes."""

    config: RunConfig
    catalogue: Catalogue

    def __call__(self, entry: Entry, table: pd.DataFrame | None = None) -> Checked:
        """The entry's file, or the ``table`` that stands in memory in its place."""
        try:
            read = read_trial(entry, self.catalogue) if table is None else trial_of_table(entry, table, self.catalogue)
        except FAILURES as reason:
            return _failed(entry, (), failure(reason), reason)
        return self.recorded(read, entry)

    def recorded(self, recording: Recording, entry: Entry) -> Checked:
        """A recording that was read already, checked and conditioned; ``entry`` has its window and known doubts."""
        found: tuple[Disagreement, ...] = ()
        several: tuple[Released, ...] = ()
        try:
            said = doubts(recording, entry.accepted)
            unsaid = [note for note in recording.notes if UNSAID_CLOCK in note]
            kept = [note for note in recording.notes if note not in unsaid]
            recording = replace(recording, notes=(*kept, *(d.sentence for d in said if d.kind is None)))
            levels = {name: noise(values) for name, values in recording.channels.items()}
            several = _several(recording, entry, levels)
            window = find_window(recording, entry.window.start_s, entry.window.end_s, levels)
            here = self.catalogue.for_entry(entry)
            also = [Disagreement(d.kind, (d.channel,), 1.0, False, d.sentence) for d in said if d.kind]
            if self.config._source is not None:  # else whoever proposes or reads in memory has asked for the unit
                also += [Disagreement("unit", CLOCK, math.nan, False, f"{note} {OF_THE_CLOCK}") for note in unsaid]
            if several:
                told = releases_said(several, entry.path.name, window.release_s)
                also.append(Disagreement("releases", ("displacement",), float(len(several)), False, told))
            if "hold" not in entry.accepted:
                window, moved = _without_hold(recording, window, entry.window.end_s, levels)
                also += moved
            found, known = self._compared(recording, here, window, levels, entry.accepted, also)
            refuse_no_decay(recording, window, levels, entry.accepted, entry.window.end_s)
            motion = _conditioned(recording, found, window, levels)
            dominant_period(motion)  # a motion that does not swing is this trial's failure, not its group's
            motion = replace(motion, notes=(*motion.notes, *(d.sentence for d in found), *known))
            done = Checked(entry.name, dict(entry.conditions), motion, None, found, entry.accepted)
        except FAILURES as reason:
            done = _failed(entry, found, _why(recording, entry, found, reason, several), reason)
        return replace(done, releases=tuple(one.part for one in several))

    def again(
        self, motion: Motion, accepted: Sequence[str] = (), before: tuple[Disagreement, ...] = ()
    ) -> Checked:
        """A motion that was checked when it was read (and what was found then), against what this config says of it."""
        recording = motion.recording
        known = {one.sentence for one in before}
        now, _ = self._compared(recording, self.catalogue, motion.window, motion.noise, accepted)
        fresh = tuple(one for one in now if one.sentence not in known)
        if any(one.certain for one in fresh):
            notes = motion.notes
            motion = _conditioned(recording, fresh, motion.window, motion.noise)
            motion = replace(motion, notes=notes)
        motion = replace(motion, notes=(*motion.notes, *(d.sentence for d in fresh if d.sentence not in motion.notes)))
        return Checked(recording.name, recording.conditions, motion, None, (*before, *fresh), tuple(accepted))

    def _compared(
        self,
        recording: Recording,
        here: Catalogue,
        window: Window,
        levels: Mapping[str, float],
        accepted: Sequence[str],
        also: Sequence[Disagreement] = (),
    ) -> tuple[tuple[Disagreement, ...], tuple[str, ...]]:
        """Disagreements, and what was found ``also``, that nobody accepted; and a note on those that somebody did."""
        stated = stated_for(self.config, here, recording.conditions)
        found = (*also, *disagreements(recording, window, stated, levels))
        held = hold_not_cut(recording, window, levels)
        if held is not None:
            found = (*found, _hold(held, None))
        known = tuple(f"accepted ({d.kind}): {d.sentence}" for d in found if d.kind in accepted)
        return tuple(d for d in found if d.kind not in accepted), known


def _without_hold(
    recording: Recording, window: Window, end_s: float | None, levels: Mapping[str, float]
) -> tuple[Window, list[Disagreement]]:
    """The window without a hold that it begins with, where that can be cut off, and that as a doubt."""
    held = hold_not_cut(recording, window, levels)
    moved = after_hold(recording, window, held, end_s, levels) if held is not None else None
    return (window, []) if held is None or moved is None else (moved, [_hold(held, moved.start_s)])


def _hold(seen: HoldSeen, used_from_s: float | None) -> Disagreement:
    return Disagreement("hold", ("displacement",), seen.end_s, False, seen.sentence(used_from_s))


def _conditioned(
    recording: Recording, found: Sequence[Disagreement], window: Window, levels: Mapping[str, float]
) -> Motion:
    """The motion; of channels that contradict each other that of one alone, which cannot contradict itself."""
    if any(one.certain for one in found):
        alone = followed(recording)
        recording = replace(recording, channels={alone: recording.channels[alone]})
    return condition(recording, window=window, levels=levels)


def stated_for(config: RunConfig, catalogue: Catalogue, conditions: Mapping[str, Condition]) -> Stated:
    """What the config says of a trial's units and specimen; no specimen where its tables do not know the trial."""
    units = {name: spec.unit for name, spec in catalogue.channels.items()} | {"time": catalogue.time.unit}
    units = units_of(units, catalogue.time.rate_hz)
    try:
        specimen = config.specimen_for(conditions)
    except ConfigError:
        return Stated(units)
    return Stated(units, specimen.mass_kg, specimen.stiffness_N_per_m, not config.is_dry(conditions))


def _failed(entry: Entry, found: tuple[Disagreement, ...], said: str, reason: Exception) -> Checked:
    """A trial that cannot be used, and why."""
    misnamed = isinstance(reason, MisnamedError) or bool(entry.problem)
    failed = FailedTrial(entry.name, said, dict(entry.conditions), isinstance(reason, ClippedError), misnamed)
    cut = reason if isinstance(reason, ClippedError) else None
    ends = tuple(SeenEnd(entry.name, cut.channel, end) for end in cut.ends) if cut else ()
    return Checked(entry.name, dict(entry.conditions), None, failed, found, ends=ends)


def _several(recording: Recording, entry: Entry, levels: Mapping[str, float]) -> tuple[Released, ...]:
    """The releases of a record that holds several, where no window says which of them is meant."""
    if "releases" in entry.accepted or entry.window != EVERYTHING:
        return ()
    return several_releases(recording, levels)


def _why(
    recording: Recording, entry: Entry, found: Sequence[Disagreement], reason: Exception, several: Sequence[Released]
) -> str:
    """Why a trial failed: what contradicts, that it holds several releases, what it shows instead of a decay, or the
    error itself."""
    if isinstance(reason, (ClippedError, LostValuesError)):
        return failure(reason)
    certain = [d.sentence for d in found if d.certain]
    if certain:
        return f"trial {entry.name}: {certain[0]}"
    if several:
        return f"trial {entry.name}: {releases_said(several, entry.path.name)}"
    return why_no_decay(recording, entry.window.start_s, entry.window.end_s) or failure(reason)


def each_once(checked: Sequence[Checked]) -> list[Checked]:
    """Of recordings that are the same only the first: a copy under another name is no repetition."""
    out = list(checked)
    places = [at for at, one in enumerate(out) if one.motion is not None]
    recordings = [one.motion.recording for one in out if one.motion is not None]
    for at, copy in copies(recordings).items():
        one = out[places[at]]
        how = copy.how.format(out[places[copy.original]].name)
        said = f"trial {one.name} is {how}; take one of them out of the campaign"
        out[places[at]] = replace(one, motion=None, failed=FailedTrial(one.name, said, one.conditions), found=())
    return out


@dataclass(frozen=True)
class Sorted:
    """A portion's trials after the check: motions to be fitted, failures, doubts in words, and the groups whose
    channels contradict each other, in words."""

    motions: tuple[Motion, ...]
    failed: tuple[FailedTrial, ...]
    contradicted: Mapping[GroupKey, str] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()


def sorted_out(config: RunConfig, checked: Sequence[Checked], stops: bool = True) -> Sorted:
    """What becomes of each trial and group.

    Raises ConfigError where the channels of every group contradict each other and ``stops`` is set: nothing has been
    fitted yet.
    """
    groups: dict[GroupKey, list[Checked]] = {}
    for one in checked:
        if one.motion is not None or one.contradiction:
            groups.setdefault(config.group_key(one.conditions), []).append(one)
    wrong = {key: [c for c in members if c.contradiction] for key, members in groups.items()}
    contradicted = {
        key: _said_of_group(wrong[key], len(members))
        for key, members in groups.items()
        if len(wrong[key]) >= CONTRADICTED_SHARE * len(members)
    }
    if stops and groups and len(contradicted) == len(groups):
        raise ConfigError(_stops({key: members[0] for key, members in wrong.items()}))
    sound = {key: [c for c in members if c.motion and not c.contradiction] for key, members in groups.items()}
    elsewhere = misplaced({key: [c.motion for c in members if c.motion] for key, members in sound.items()})
    known = {c.name for c in checked if "conditions" in c.accepted}
    ends = common([end for c in checked for end in c.ends], [c.motion.recording for c in checked if c.motion])
    motions, failed = [], _unused([c for c in checked if c.failed is not None], ends)
    for one in checked:
        if one.motion is None:
            continue
        if "clipping" not in one.accepted and (said := reached(one.motion.recording, ends)):
            failed.append(FailedTrial(one.name, said, one.conditions, clipped=True))
            continue
        why = "" if config.group_key(one.conditions) in contradicted else one.contradiction
        why = why or ("" if one.name in known else elsewhere.get(one.name, ""))
        if why:
            failed.append(FailedTrial(one.name, f"trial {one.name}: {why}", one.conditions))
        else:
            motions.append(one.motion)
    return Sorted(tuple(motions), tuple(failed), contradicted, _doubts(groups))


def _unused(trials: Sequence[Checked], ends: Sequence[SeenEnd]) -> list[FailedTrial]:
    """Trials that cannot be used; no sensor's range is accused of an end beyond which other trials go."""
    alone = [one.name for one in trials if one.ends and not any(end in ends for end in one.ends)]
    which = "this one is" if len(alone) == 1 else f"these {len(alone)} are"
    said = f"; other trials go beyond: only {which} left out"
    failed = [(one.failed, one.name in alone) for one in trials if one.failed is not None]
    return [replace(one, clipped=False, reason=one.reason + said) if beyond else one for one, beyond in failed]


def _said_of_group(wrong: Sequence[Checked], trials: int) -> str:
    """What contradicts in a group, in words that go on after "because"."""
    return (
        f"the channels contradict each other in {len(wrong)} of {count(trials, 'trial')} ({wrong[0].name}: "
        f"{wrong[0].contradiction})"
    )


def _stops(examples: Mapping[GroupKey, Checked]) -> str:
    """Why a run stops: one trial's sentence a group."""
    lines = [
        f"  {group_title(dict(key))}, trial {one.name}: {one.contradiction}"
        for key, one in list(examples.items())[:GROUPS_NAMED]
    ]
    more = len(examples) - len(lines)
    whose = "every group" if len(examples) > 1 else "the recordings"
    head = (
        f"the channels of {whose} contradict each other; correct the config, or state what is known in "
        "recordings.accept:"
    )
    return "\n".join([head, *lines, *([f"  and {count(more, 'more group')}"] if more else [])])


def _doubts(groups: Mapping[GroupKey, Sequence[Checked]]) -> tuple[str, ...]:
    """Doubts that do not stop anything, group by group."""
    return tuple(
        f"{group_title(dict(key))}, {said}" for key, members in groups.items()
        for said in doubted({one.name: one.found for one in members}, [one.motion for one in members if one.motion])
    )  # fmt: skip


def doubted(found: Mapping[str, Sequence[Disagreement]], motions: Sequence[Motion]) -> tuple[str, ...]:
    """Doubts that do not stop anything, and channels that are left out, once a kind, with how many trials share them.

    ``found`` is trial -> what does not belong together in it; of ``motions`` the recordings' notes are looked at.
    """
    by_kind: dict[tuple[str, tuple[str, ...]], list[tuple[str, str]]] = {}
    for name, many in found.items():
        for doubt in many:
            if not doubt.certain:
                by_kind.setdefault((doubt.kind, doubt.channels), []).append((name, doubt.sentence))
    for motion in motions:
        for note in motion.recording.notes:
            if LEFT_OUT in note:
                by_kind.setdefault((LEFT_OUT, (note.split()[0],)), []).append((motion.name, note))
    said = []
    for (name, sentence), *others in by_kind.values():
        more = f" and {count(len(others), 'more trial')}" if others else ""
        said.append(f"{name}{more}: {sentence}")
    return tuple(said)
