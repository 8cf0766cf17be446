"""One campaign from config to findings: read, condition, dry trials, groups.

Belongs here: the stages, their order, parallel work. Does not belong here: the run folder (folder.py), the terminal.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from operator import attrgetter
from pathlib import Path

from undertow.campaign.config import GroupKey, RunConfig
from undertow.campaign.config.matching import contradicted_headers, planned
from undertow.campaign.config.specimen_rules import strange_constants
from undertow.campaign.run import checkpoints
from undertow.campaign.run.analysis import GroupTask, analyse
from undertow.campaign.run.checking import Checked, Checker, each_once, sorted_out
from undertow.campaign.run.cut_off import with_clipped
from undertow.campaign.run.differing import grown_between
from undertow.campaign.run.gathered import Gathered, PortionFindings
from undertow.campaign.run.judgement import judged
from undertow.campaign.run.plausible import with_doubts
from undertow.campaign.run.portions import TRIALS_AT_ONCE, Portion, portions
from undertow.campaign.run.repeating import scatter_seen
from undertow.campaign.run.tasks import (
    Structures,
    group_task,
    grouped,
    held_out,
    level_count,
    structures_of,
    weighed,
    with_scatter,
)
from undertow.campaign.run.workers import Progress, on_processes, silent, steps
from undertow.conditioning.agreement import Disagreement
from undertow.conditioning.motion import Motion
from undertow.discrepancy.findings import FailedTrial, Findings, GroupFindings
from undertow.discrepancy.words import count, group_title
from undertow.equation.term import Term
from undertow.errors import FAILURES, ConfigError, UndertowError, failure
from undertow.methods.baseline import terms_by_name
from undertow.methods.dry import Scatter
from undertow.recording.catalogue import Catalogue, Entry

REASONS_AT_MOST = 3
"""Different reasons that are said where no trial at all can be used."""

READ, IDENTIFY = "read and condition", "identification"
"""Stages, as progress and the manifest call them."""


@dataclass(frozen=True)
class Read:
    """Conditioned motions, the trials that could not be used, trial -> kinds of doubt that are known, and trial -> what
    does not belong together in it."""

    motions: tuple[Motion, ...]
    failed: tuple[FailedTrial, ...]
    accepted: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    found: Mapping[str, tuple[Disagreement, ...]] = field(default_factory=dict)


def run(
    config: RunConfig,
    jobs: int = 0,
    progress: Progress = silent,
    stages_folder: Path | None = None,
    resume: bool = False,
    given: Read | None = None,
    terms: Sequence[Term] | None = None,
) -> Findings:
    """All findings of a campaign, with every trial's series (`Course` and `Gathered` hold fewer of a large one).

    ``jobs`` is the number of processes (0: one a core). Trials that cannot be used are listed in ``failed``. Finished
    groups are kept in ``stages_folder`` (None: not kept) and, with ``resume``, taken from there. ``given`` are trials
    that were read already: the config's recordings are then not looked at. ``terms`` replace the equation's, where one
    of them is a user's own law.

    Raises UndertowError where the config is wrong or no trial at all can be used.
    """
    course = Course(config, jobs, progress, stages_folder, resume, given=given, terms=terms)
    gathered = Gathered(config, everything=True)
    for part in course.parts():
        gathered.add(part)
    return gathered.findings(course.seconds)


class Course:
    """A campaign's way from recordings to verdicts, a portion of its trials at a time (`portions`).

    ``seconds`` is the wall time a stage so far; ``at_once`` the trials of a portion (0: `TRIALS_AT_ONCE`). Between
    portions only what the dry trials say is kept.
    """

    def __init__(
        self,
        config: RunConfig,
        jobs: int = 0,
        progress: Progress = silent,
        stages_folder: Path | None = None,
        resume: bool = False,
        at_once: int = 0,
        given: Read | None = None,
        terms: Sequence[Term] | None = None,
    ) -> None:
        self.seconds: dict[str, float] = {}
        self._config, self._jobs, self._folder, self._resume = config, jobs, stages_folder, resume
        self._terms = terms_by_name(config.equation.terms) if terms is None else tuple(terms)
        self._catalogue, self._given = config.catalogue(), given
        self._notes: tuple[str, ...] = ()
        self._doubts = (*strange_constants(config), *contradicted_headers(config))
        if given is None:
            plan = planned(config)
            self._notes = plan.notes
            self._plan = portions(config, plan.entries, at_once or TRIALS_AT_ONCE)
            known = [e.conditions for e in plan.entries if set(config.trials.group_by) <= set(e.conditions)]
        else:
            self._plan = (Portion((), len(grouped(config, given.motions)), 0),)
            known = [m.recording.conditions for m in given.motions]
        self._groups = {config.group_key(c): config.is_dry(c) for c in known}
        totals = {READ: sum(p.size for p in self._plan), IDENTIFY: sum(p.groups for p in self._plan)}
        self._progress = steps(progress, totals)
        self._structures: Structures | None = None
        self._repeated: Scatter | None = None
        self._dry: tuple[list[GroupTask], list[GroupFindings]] = ([], [])
        self._read = self._tried = 0

    def parts(self) -> Iterator[PortionFindings]:
        """What was found, portion by portion, dry groups first; groups of a portion in their order.

        Raises UndertowError at the end where no trial at all could be used.
        """
        found, first, last, misnamed = 0, dict[str, str](), "", True
        for portion in self._plan:
            part = self._part(portion)
            found += len(part.groups)
            for one in part.failed:
                first.setdefault(_unnamed(one), one.reason)
            misnamed = misnamed and all(f.misnamed for f in part.failed)
            last = part.failed[-1].reason if part.failed else last
            yield part
            del part  # else two portions would be held
        if not self._read:
            reasons = "; ".join([*first.values()][:REASONS_AT_MOST]) or "the index or the file pattern names none"
            said = f"none of {sum(p.size for p in self._plan)} trials can be used: {reasons}"
            raise ConfigError(said) if misnamed and first else UndertowError(said)
        if not found:
            raise UndertowError(f"none of {self._tried} groups can be identified: {last}")

    def _part(self, portion: Portion) -> PortionFindings:
        with self._stage(READ):
            checked = self._looked_at(portion)
            read = sorted_out(self._config, checked, stops=self._structures is None)
        self._read += len(read.motions)
        with self._stage("dry trials"):
            groups = grouped(self._config, read.motions)
            if self._structures is None:
                sound = {key: motions for key, motions in groups.items() if key not in read.contradicted}
                self._config, said = weighed(self._config, sound, self._terms)
                self._notes = (*self._notes, *said)
                self._structures = structures_of(self._config, sound, self._terms)
            if self._repeated is None:
                self._repeat(groups, read.contradicted)
        with self._stage(IDENTIFY):
            tasks, refused = self._tasks(groups, self._structures, read.contradicted)
            analysed = partial(_analysed, self._folder, self._resume)
            results = on_processes(analysed, tasks, self._jobs, IDENTIFY, self._progress, _task_name)
        self._tried += len(groups)
        pairs = [(t, r) for t, r in zip(tasks, results, strict=True) if isinstance(r, GroupFindings)]
        failed = (*read.failed, *refused, *(f for r in results if not isinstance(r, GroupFindings) for f in r))
        with self._stage("what is missing"):
            found = self._judged([t for t, _ in pairs], [g for _, g in pairs]) if pairs else []
            found = [with_clipped(self._config, group, failed) for group in found]
        known = {e.name: e.accepted for e in portion.entries} if self._given is None else self._given.accepted
        found, implausible = with_doubts(found, known, [m.name for m in read.motions])
        notes = (*self._notes, *_notes(read.motions), *_divided(portion, found))
        doubts = (*self._doubts, *read.doubts, *implausible)
        self._notes = self._doubts = ()
        agreeing = grown_between(found, self._config.trials.dry or {})
        return PortionFindings(tuple(agreeing), failed, notes, doubts, as_fitted=tuple(found))

    def _repeat(self, groups: Mapping[GroupKey, Sequence[Motion]], contradicted: Mapping[GroupKey, str]) -> None:
        """How much trials differ, and the structures with it, where the dry trials are too few to say."""
        sound = {key: motions for key, motions in groups.items() if key not in contradicted}
        self._repeated = scatter_seen(self._config, sound, self._terms, self._structures or {})
        if self._repeated is not None and self._structures:
            self._structures = with_scatter(self._structures, self._repeated)

    def _looked_at(self, portion: Portion) -> list[Checked]:
        """The portion's trials read and checked; trials that were given are compared with the config alone."""
        if self._given is None:
            return _checked(self._config, self._catalogue, portion.entries, self._jobs, self._progress)
        checker, given = Checker(self._config, self._catalogue), self._given
        again = [
            checker.again(motion, given.accepted.get(motion.name, ()), given.found.get(motion.name, ()))
            for motion in given.motions
        ]
        return each_once([*again, *(Checked(one.name, one.conditions, None, one) for one in given.failed)])

    def _tasks(
        self, groups: Mapping[GroupKey, Sequence[Motion]], structures: Structures, contradicted: Mapping[GroupKey, str]
    ) -> tuple[list[GroupTask], list[FailedTrial]]:
        """The groups' tasks, and the trials of those that cannot be identified as the config says."""
        tasks: list[GroupTask] = []
        refused: list[FailedTrial] = []
        for key, motions in groups.items():
            try:
                task = group_task(self._config, key, motions, self._terms, structures, self._repeated)
                tasks.append(replace(task, contradiction=contradicted.get(key, "")))
            except UndertowError as reason:
                refused += _failed(motions, failure(reason))
        return tasks, refused

    def _judged(self, tasks: list[GroupTask], found: list[GroupFindings]) -> list[GroupFindings]:
        """The groups with their verdicts; where dry trials need something, they are looked at beside every portion."""
        known, standing = self._dry
        together = [_joint(t, g) for t, g in zip([*known, *tasks], [*standing, *found], strict=True)]
        said = judged(
            self._config, [t for t, _ in together], [g for _, g in together], self._jobs, self._progress, self._folder,
            self._resume, level_count(self._config, self._groups, self._structures or {}),
        )[len(known) :]  # fmt: skip
        out = []
        for task, group, one in zip(tasks, found, said, strict=True):
            trials = (*one.verdict.trials, *task.apart)
            verdict = replace(one.verdict, trials=trials) if task.apart else one.verdict
            told = {t.motion.name: t for t in one.trials}
            shown = tuple(
                replace(t, augmented=told[t.motion.name].augmented, mismatch=told[t.motion.name].mismatch)
                if t.motion.name in told else t
                for t in group.trials
            )  # fmt: skip
            out.append(replace(group, verdict=verdict, trials=shown))
        dry = [(t, g) for t, g in zip(tasks, out, strict=True) if t.dry]
        if len(self._plan) > 1 and any(g.verdict.verdict for _, g in dry):
            self._dry = ([t for t, _ in dry], [g for _, g in dry])
        return out

    @contextmanager
    def _stage(self, name: str) -> Iterator[None]:
        """Adds the time of the block to the stage's."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start


def _task_name(task: GroupTask) -> str:
    return f"{group_title(task.key)} ({count(len(task.motions), 'trial')})"


def _unnamed(failed: FailedTrial) -> str:
    """A trial's reason without its name, so that one reason of many trials is said once."""
    return failed.reason.removeprefix(f"trial {failed.name}: ").replace(failed.name, "...")


def _joint(task: GroupTask, group: GroupFindings) -> tuple[GroupTask, GroupFindings]:
    """A group as it is searched for what is missing: with the trials that are looked at together."""
    if not task.apart:
        return task, group
    trials = tuple(t for t in group.trials if t.motion.name not in task.apart)
    return replace(task, motions=task.joint, apart=()), replace(group, trials=trials)


def _divided(portion: Portion, found: Sequence[GroupFindings]) -> tuple[str, ...]:
    """That a water has too many groups to be judged together, in words."""
    if not portion.divided or not found:
        return ()
    return (
        f"{found[0].label} to {found[-1].label}: {len(found)} of this water's {portion.divided} groups, which are too "
        "many to be judged together",
    )


def _analysed(folder: Path | None, resume: bool, task: GroupTask) -> GroupFindings | tuple[FailedTrial, ...]:
    """One group analysed, or taken from a finished stage.

    A group that cannot be identified gives its trials as failed: it must not stop the others.
    """
    try:
        if folder is None:
            return analyse(task)
        path = folder / f"{checkpoints.digest(task)}.json"
        kept = checkpoints.load(task, path) if resume else None
        if kept is not None:
            return kept
        findings = analyse(task)
        checkpoints.save(findings, path)
        return findings
    except FAILURES as reason:
        return _failed(task.motions, task.contradiction or failure(reason))


def _failed(motions: Sequence[Motion], reason: str) -> tuple[FailedTrial, ...]:
    """The trials of a group that cannot be identified, each with the group's reason."""
    return tuple(FailedTrial(m.name, reason, dict(m.recording.conditions)) for m in motions)


def read_and_condition(config: RunConfig, jobs: int = 1, progress: Progress = silent) -> Read:
    """Every trial of the config read and conditioned; failures with their reasons instead of an exception.

    Raises ConfigError where the config names something that the list of trials does not have.
    """
    checked = _checked(config, config.catalogue(), entries := planned(config).entries, jobs, progress)
    motions = tuple(one.motion for one in checked if one.motion is not None)
    failed = tuple(one.failed for one in checked if one.failed is not None)
    accepted = {one.name: one.accepted for one in entries if one.accepted}
    return Read(motions, failed, accepted, {one.name: one.found for one in checked if one.found})


def _checked(
    config: RunConfig, catalogue: Catalogue, entries: Sequence[Entry], jobs: int, progress: Progress
) -> list[Checked]:
    """Every trial read, checked and conditioned, each recording once."""
    return each_once(on_processes(Checker(config, catalogue), entries, jobs, READ, progress, attrgetter("name")))


def _notes(motions: Sequence[Motion]) -> tuple[str, ...]:
    """What reading, conditioning and checking found, a trial a line; nothing silent."""
    return tuple(f"{m.name}: {note}" for m in motions for note in (*m.recording.notes, *m.notes))


__all__ = ["Course", "Progress", "Read", "held_out", "read_and_condition", "run"]
