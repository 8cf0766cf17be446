"""Which groups are judged together, and their verdicts: dry ones first, then each water's groups.

Belongs here: that order, and a group as the judge sees it. Does not belong here: the search (discrepancy/).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from undertow.campaign.config import GroupKey, RunConfig
from undertow.campaign.run import checkpoints
from undertow.campaign.run.analysis import GroupTask
from undertow.campaign.run.other_waters import told_by_others, with_the_reason
from undertow.campaign.run.rig import (
    WetRig,
    believable_repeatability,
    dry_specimens,
    in_water,
    spring_label,
    standing_addends,
    with_known,
)
from undertow.campaign.run.workers import Progress, on_processes
from undertow.comparison.deviations import SLOTS, size_in
from undertow.comparison.level import Addend, Member
from undertow.comparison.suspect import Suspect
from undertow.comparison.suspects import chosen
from undertow.discrepancy.case import Case
from undertow.discrepancy.earned import NEXT, stands_in_water
from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.discrepancy.judge import Judged, judge_level, undecided
from undertow.discrepancy.mismatch import place_words
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import count, group_title, own_words, spelled
from undertow.errors import FAILURES, failure
from undertow.likelihood.fit import Specimen, Structure
from undertow.methods.baseline import group_model
from undertow.methods.dry import DEFAULT_SCATTER, believed
from undertow.methods.repeated import FEWEST

SELF_REPEATABILITY = 0.01
"""Free-run error that one trial fitted to itself may keep: no repetition can differ from it."""

LOOSER = 10.0
"""How much wider than its error a dry mean may be where its own trials are judged."""

MOST_FRICTION = 0.1
"""Friction that a dry group's own trials may turn out to have, over the largest force of their spring."""


def judged(
    config: RunConfig,
    tasks: Sequence[GroupTask],
    groups: Sequence[GroupFindings],
    jobs: int,
    progress: Progress,
    folder: Path | None = None,
    resume: bool = False,
    levels: int = 1,
) -> list[GroupFindings]:
    """The groups with their verdicts: dry ones first, then each water's groups together; ``levels`` is how many of
    these the whole campaign has.

    Each level's verdicts are kept in ``folder`` as they come (None: not kept) and, with ``resume``, taken from there.
    """
    suspects = chosen(config.discrepancy.suspects, config.equation.coordinate == "rotation")
    cases, tasks, failed = _cases(config, tasks, groups)
    dry = [_Together((case,), (task,)) for case, task in zip(cases, tasks, strict=True) if case.dry]
    budget = config.discrepancy.budget
    beside = _Judge(suspects, folder=folder, resume=resume, budget=budget, levels=levels)
    first = on_processes(beside, dry, jobs, "dry: what is missing", progress, _together_name)
    standing = standing_addends(first)
    if standing:
        again = with_known(config, tasks, standing)
        groups = [_repeating_as(group, again.get(tuple(group.key.items()))) for group in groups]
        trials = {tuple(group.key.items()): group.trials for group in groups}
        keys = [tuple(case.key.items()) for case in cases]
        cases = [_with_rig(case, again[key], trials[key]) for case, key in zip(cases, keys, strict=True)]
    cases = _beside_unknown(cases, first)
    waters: dict[tuple[object, ...], _Together] = {}
    for case, task in zip(cases, tasks, strict=True):
        if not case.dry:
            water = _water(config, case)
            together = waters.get(water, _Together((), ()))
            waters[water] = _Together((*together.cases, case), (*together.tasks, task))
    pairs = zip(dry, first, strict=True)
    clean = tuple(one.cases[0] for one, said in pairs if not (said.addends or said.verdicts[0].status == "unknown"))
    judge = _Judge(suspects, standing, folder, resume, dry_specimens(config, tasks), budget, levels, clean)
    place = "wet: " if config.trials.dry else ""
    wet = on_processes(judge, list(waters.values()), jobs, f"{place}what is missing", progress, _together_name)
    told = {
        i: replace(water, told=told) for i, water in enumerate(waters.values()) if (told := told_by_others(i, wet))
    }
    more = on_processes(judge, list(told.values()), jobs, f"{place}beside other waters", progress, _together_name)
    wet = [*wet, *(with_the_reason(one, wet[i]) for i, one in zip(told, more, strict=True))]
    said = failed | {tuple(v.group.items()): v for judged in (*first, *wet) for v in judged.verdicts}
    runs = {name: run for judged in (*first, *wet) for name, run in judged.runs.items()}
    return [
        replace(
            group, verdict=said[tuple(group.key.items())],
            trials=tuple(replace(t, augmented=runs.get(t.motion.name)) for t in group.trials),
        )
        for group in groups
    ]  # fmt: skip


def _cases(
    config: RunConfig, tasks: Sequence[GroupTask], groups: Sequence[GroupFindings]
) -> tuple[list[Case], list[GroupTask], dict[GroupKey, Verdict]]:
    """Groups as the judge sees them with their tasks; and the verdicts of those that cannot be judged."""
    cases, told, failed = list[Case](), list[GroupTask](), dict[GroupKey, Verdict]()
    for task, group in zip(tasks, groups, strict=True):
        if task.contradiction:  # nothing can be said of it, and it must not speak for other springs of its water
            failed[tuple(group.key.items())] = contradicted_verdict(group, task.contradiction)
            continue
        try:
            cases.append(_case(config, task, group))
            told.append(task)
        except FAILURES as reason:
            failed[tuple(group.key.items())] = _without_case(group, failure(reason))
    return cases, told, failed


def _beside_unknown(cases: Sequence[Case], dry: Sequence[Judged]) -> list[Case]:
    """The cases, wet ones with what the dry trials of their spring lack and nobody knows, and with what they cannot
    tell from what they need: it is there in water too."""
    said = {label: verdict for judged in dry for label, verdict in zip(judged.labels, judged.verdicts, strict=True)}
    puzzling = {
        label: f"nobody knows for sure what is missing in the dry trials too ({group_title(verdict.group)})"
        for label, verdict in said.items() if verdict.status == "unknown" and not stands_in_water(verdict)
    }  # fmt: skip
    rivals = {label: verdict.alternatives for label, verdict in said.items() if verdict.status == "not_identifiable"}
    return [
        case if case.dry else replace(
            case, dry_unknown=puzzling.get(case.member.label, ""), dry_rivals=rivals.get(case.member.label, ())
        ) for case in cases
    ]  # fmt: skip


@dataclass(frozen=True)
class _Together:
    """Groups of one water, as the judge sees them and as they were analysed; ``told`` is what other waters say of
    laws."""

    cases: tuple[Case, ...]
    tasks: tuple[GroupTask, ...]
    told: tuple[tuple[str, float], ...] = ()


def _together_name(one: _Together) -> str:
    return "; ".join(group_title(case.key) for case in one.cases)


@dataclass(frozen=True)
class _Judge:
    """Judges one level of so many in the campaign, or takes its verdicts from a finished stage; ``clean`` are the dry
    groups to whose equation nothing was added. Picklable for worker processes."""

    suspects: tuple[Suspect, ...]
    standing: tuple[Addend, ...] = ()
    folder: Path | None = None
    resume: bool = False
    dry: Mapping[str, Specimen] = field(default_factory=dict)
    budget: float = 1.0
    levels: int = 1
    clean: tuple[Case, ...] = ()

    def __call__(self, level: _Together) -> Judged:
        standing = in_water(self.standing, {c.member.label: c.member.model.specimen for c in level.cases}, self.dry)
        if not all(task.anchor.known for task in level.tasks):
            standing = ()  # a number per kilogram of the dry body is none of the body and its water
        if self.folder is None:
            return self._judged(level, standing)
        free = [c.member.free_start for c in level.cases]
        cells = [dict(c.cell) for c in level.cases]
        said = (free, cells, [(c.dry_unknown, c.dry_rivals) for c in level.cases], level.told)
        also = repr((sorted(s.label for s in self.suspects), standing, *said, self.budget, self.levels))
        path = self.folder / f"verdict-{checkpoints.level_digest(level.tasks, also)}.json"
        labels = tuple(c.member.label for c in level.cases)
        kept = checkpoints.load_verdicts(level.tasks, labels, path) if self.resume else None
        if kept is not None:
            return kept
        found = self._judged(level, standing)
        checkpoints.save_verdicts(found, path)
        return found

    def _judged(self, level: _Together, here: tuple[Addend, ...]) -> Judged:
        """A level's verdicts; one that cannot be searched says so and does not stop the others.

        Where no motion comes of bristles in friction's place (with what was taken for sliding), it is searched without;
        where none comes of what else the dry trials need either, without all of it, as beside what nobody knows.
        """
        sliding = tuple(d for d in here if not any(a.moves for a in d.additions))
        reason = ""
        for standing in dict.fromkeys((here, sliding, ())):
            cases = level.cases if standing or not sliding else _unused(level.cases, sliding)
            try:
                told = dict(level.told)
                return judge_level(cases, self.suspects, standing, self.budget, self.levels, self.clean, told)
            except FAILURES as one:
                reason = reason or failure(one).rstrip(".")
        return undecided(level.cases, reason)


def _unused(cases: Sequence[Case], standing: Sequence[Addend]) -> tuple[Case, ...]:
    """Groups that are judged without what their dry trials need, and say so."""
    names = " and ".join(spelled(addend.prefix.partition(".")[0]) for addend in standing)
    because = f"no motion in this water comes of what the dry trials need ({names})"
    return tuple(replace(case, dry_unknown=because) for case in cases)


def _loosened(structure: Structure | None, task: GroupTask) -> Structure | None:
    """Dry trials' own k, c, mu as a start for their groups: a law that is missing may have bent the means, damping to
    twice its size and friction to nothing."""
    if structure is None:
        return None
    k, c, mu = (replace(e, stderr=LOOSER * e.stderr) for e in (structure.k, structure.c, structure.mu))
    friction = MOST_FRICTION * k.value * max(m.amplitude for m in task.motions) / task.specimen.normal_force_N
    if math.isfinite(friction) and friction > mu.stderr > 0.0:
        mu = replace(mu, stderr=friction)
    c = replace(c, stderr=max(c.stderr, abs(c.value)))
    errors = {symbol: structure.error_of_mean(symbol) for symbol in SLOTS}
    return replace(structure, k=k, c=c, mu=mu, mean_errors=errors)


def _repeating_as(group: GroupFindings, rig: WetRig | None) -> GroupFindings:
    """A wet group whose trials may differ as much as its rig has it with what the dry trials need, which had passed for
    their scatter."""
    if rig is None or not group.verdict.repeatability_nrmse > 0.0:
        return group
    factor = rig.allowed / group.verdict.repeatability_nrmse
    return replace(group, trials=tuple(
        replace(t, mismatch=replace(t.mismatch, repeatability_nrmse=factor * t.mismatch.repeatability_nrmse))
        for t in group.trials
    ))  # fmt: skip


def _with_rig(case: Case, rig: WetRig | None, trials: Sequence[TrialFindings]) -> Case:
    """A wet group held against its rig as the dry trials with what they need give it."""
    if rig is None:
        return case
    member = replace(case.member, model=rig.model, options=rig.options, allowed=rig.allowed)
    missing = [t.mismatch for t in trials if t.mismatch.missing]
    return replace(case, member=member, allowed=rig.allowed, missing=len(missing), place=place_words(missing))


def _water(config: RunConfig, case: Case) -> tuple[object, ...]:
    """What groups of the same water share; a group for itself where nothing is known from dry trials."""
    fixed = config.trials.dry or {}
    if not case.has_dry or not fixed:
        return tuple(case.key.items())
    return tuple(case.key[name] for name in fixed if name in case.key)


def _without_case(group: GroupFindings, reason: str) -> Verdict:
    """The verdict of a group whose equation cannot be set up for a search."""
    because = f"its search could not start: {reason.rstrip('.')}"
    return replace(group.verdict, because=because, sentence=f"{group.label}: cannot tell, because {because}.")


def contradicted_verdict(group: GroupFindings, because: str) -> Verdict:
    """The verdict of a group whose channels, or what is stated, contradict each other: nothing is looked for in it."""
    was, text = group.verdict, f"{group.label}: cannot tell, because {because}."
    return Verdict(
        was.group, was.trials, was.held_out, "cannot_tell", because=because, sentence=text, contradicted=True,
        next_test=NEXT["contradiction"], baseline=was.baseline, physical_check=was.physical_check,
        sensor_floor_nrmse=was.sensor_floor_nrmse, repeatability_nrmse=was.repeatability_nrmse,
    )  # fmt: skip


def _no_dry(config: RunConfig, task: GroupTask) -> str:
    """That a wet group's spring has no dry trials though the config names some, uneven ones, or none that say anything
    of the water, in words."""
    if task.uneven:
        return task.uneven
    if task.dry or not config.trials.dry or task.dry_structure is not None:
        return ""
    if not task.anchor.known:
        return (
            "neither the body's mass nor a spring's stiffness is known, without which dry trials say nothing of the "
            "same body in water"
        )
    return f"no dry trial of {spring_label(config, task)} could be used, and water cannot be separated from structure"


def _assumed(config: RunConfig, task: GroupTask) -> str:
    """Why nobody knows how much trials differ, in words; empty where it was measured or stated."""
    if config.specimen.scatter is not None:
        return ""
    dry = task.dry_structure
    seen = dry.scatter_freedom if dry is not None else task.freedom if task.scatter else 0.0
    if seen >= FEWEST - 1:
        return ""
    many = len(task.motions) >= FEWEST
    if many and task.dry and not task.anchor.known:
        return (
            "how much trials differ is reckoned where specimen.mass_kg or specimen.stiffness_N_per_m is stated, and "
            "neither is; specimen.scatter would say it too"
        )
    rest = (
        f"{FEWEST} dry trials of a spring, {FEWEST} releases of one size or specimen.scatter would say how much trials "
        "differ"
    )
    if dry is not None:
        return f"{rest}, and its spring has {count(task.dry_trials, 'dry trial')}"
    in_air = "" if config.trials.dry or not many else " (in air? then trials.dry says so)"
    return f"{rest}, and this group has {count(len(task.motions), 'trial')}{in_air}"


def _with_scatter(member: Member, task: GroupTask, group: GroupFindings) -> Member:
    """A group without a structure of its own, with how much its trials differ: as stated, as other springs' dry trials
    or the campaign's repetitions show, or as is usual."""
    if member.model.fixed is not None or not group.equation.compiled or not group.trials:
        return member
    relative, freedom = (task.scatter, task.freedom) if task.scatter else (DEFAULT_SCATTER, 0.0)
    theta = group.equation.theta(1.0)
    spread = {slot: believed(relative, freedom, symbol) for symbol, slot in SLOTS.items()}
    sizes = {slot: size_in(theta, slot) for slot in spread}
    return replace(member, spread=spread, sizes=sizes, freedom=freedom)


def _case(config: RunConfig, task: GroupTask, group: GroupFindings) -> Case:
    """A group as the judge sees it."""
    structure = _loosened(task.dry_structure, task) if task.dry else task.dry_structure
    model = group_model(
        task.terms, task.motions, task.specimen, structure, dry=task.dry, anchored=task.anchor.known,
        stiffness={n: e.value for n, e in task.stiffness.items()},
    )  # fmt: skip
    spring = spring_label(config, task)
    training = tuple(m for m in task.motions if m.name not in task.held_out)
    held = tuple(m for m in task.motions if m.name in task.held_out)
    member = Member(spring, model, training, task.options, config.trials.hidden_at_release == "free")
    conditions = task.motions[0].recording.conditions
    believed = min(believable_repeatability(task), group.verdict.repeatability_nrmse)
    member = replace(_with_scatter(member, task, group), allowed=believed, own_means=task.dry)
    if len(training) == 1 and task.dry_structure is None and config.specimen.scatter is None:
        member = replace(member, allowed=math.hypot(group.verdict.sensor_floor_nrmse, SELF_REPEATABILITY))
    return Case(
        task.key, group.label, member, held, group.verdict.baseline, group.verdict.sensor_floor_nrmse,
        group.verdict.repeatability_nrmse, sum(t.mismatch.missing for t in group.trials), task.dry,
        task.dry_structure is not None, config.cell_for(conditions),
        place_words([t.mismatch for t in group.trials if t.mismatch.missing]),
        task.contradiction, _no_dry(config, task), _assumed(config, task), own=own_words(model.scattering),
    )  # fmt: skip
