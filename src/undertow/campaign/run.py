"""One campaign from config to findings: read, condition, dry trials, groups.

Belongs here: the stages, their order, parallel work. Does not belong here: the run folder (folder.py), the terminal.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from undertow.campaign import stages
from undertow.campaign.analysis import GroupTask, analyse
from undertow.campaign.config import RunConfig
from undertow.campaign.judgement import judged
from undertow.campaign.settings import EverySettings, LargestSettings
from undertow.campaign.workers import Progress, on_processes, silent
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.discrepancy.drifts import group_drifts
from undertow.discrepancy.findings import FailedTrial, Findings, GroupFindings
from undertow.discrepancy.words import count
from undertow.equation.term import Term
from undertow.errors import RecordingError, UndertowError
from undertow.identification.baseline import GroupFit, terms_by_name
from undertow.identification.decay import load_cell_stiffness
from undertow.identification.dry import Scatter, dry_fits, pooled_scatter, structural_terms, structure_from
from undertow.identification.fit import Specimen, Structure
from undertow.identification.intervals import mean_of_trials
from undertow.identification.problem import TrialOptions, dominant_period
from undertow.identification.scale import choose_anchor, trial_stiffness
from undertow.quantities import Estimate
from undertow.recording.catalogue import Catalogue, Entry, read_trial
from undertow.recording.gather import gather
from undertow.recording.quality import check
from undertow.recording.recording import Condition


@dataclass(frozen=True)
class Read:
    """Conditioned motions and the trials that could not be used."""

    motions: tuple[Motion, ...]
    failed: tuple[FailedTrial, ...]


@dataclass
class _Clock:
    """Wall time a stage, s."""

    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Adds the time of the block to the stage's."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start


def run(
    config: RunConfig,
    jobs: int = 0,
    progress: Progress = silent,
    stages_folder: Path | None = None,
    resume: bool = False,
) -> Findings:
    """All findings of a campaign.

    ``jobs`` is the number of processes (0: one a core). Trials that cannot be used are listed in ``failed``. Finished
    groups are kept in ``stages_folder`` (None: not kept) and, with ``resume``, taken from there.

    Raises UndertowError where the config is wrong or no trial at all can be used.
    """
    clock = _Clock()
    terms = terms_by_name(config.equation.terms)
    with clock.stage("read and condition"):
        read = read_and_condition(config, jobs, progress)
    if not read.motions:
        reasons = "; ".join(f.reason for f in read.failed[:3]) or "the index or the file pattern names none"
        raise UndertowError(f"none of {len(read.failed)} trials can be used: {reasons}")
    with clock.stage("dry trials"):
        groups = _grouped(config, read.motions)
        structures = _structures(config, groups, terms)
    with clock.stage("identification"):
        tasks = [
            _task(config, key, motions, terms, structures, groups) for key, motions in groups.items()
        ]
        results = on_processes(_Analyst(stages_folder, resume), tasks, jobs, "identification", progress)
    found = [r for r in results if isinstance(r, GroupFindings)]
    failed = read.failed + tuple(f for r in results if not isinstance(r, GroupFindings) for f in r)
    if not found:
        raise UndertowError(f"none of {len(tasks)} groups can be identified: {failed[-1].reason}")
    kept = [t for t, r in zip(tasks, results, strict=True) if isinstance(r, GroupFindings)]
    with clock.stage("what is missing"):
        found = judged(config, kept, found, jobs, progress, stages_folder, resume)
    return Findings(
        config.name, tuple(found), failed, tuple(config.identify), config.equation.coordinate, clock.seconds,
        _across(found), (*_notes(read), *(d.sentence for d in group_drifts(found, config.trials.dry or {}))),
    )  # fmt: skip


@dataclass(frozen=True)
class _Analyst:
    """Analyses one group, or takes it from a finished stage; picklable for worker processes.

    A group that cannot be identified gives its trials as failed: it must not stop the others.
    """

    folder: Path | None
    resume: bool

    def __call__(self, task: GroupTask) -> GroupFindings | tuple[FailedTrial, ...]:
        try:
            return self._found(task)
        except UndertowError as reason:
            return tuple(FailedTrial(m.name, str(reason), dict(m.recording.conditions)) for m in task.motions)

    def _found(self, task: GroupTask) -> GroupFindings:
        if self.folder is None:
            return analyse(task)
        path = self.folder / f"{stages.digest(task)}.json"
        kept = stages.load(task, path) if self.resume else None
        if kept is not None:
            return kept
        findings = analyse(task)
        stages.save(findings, path)
        return findings


def read_and_condition(config: RunConfig, jobs: int = 1, progress: Progress = silent) -> Read:
    """Every trial of the config read and conditioned; failures with their reasons instead of an exception."""
    catalogue = config.catalogue()
    entries = gather(catalogue)
    results = on_processes(_Conditioner(catalogue), entries, jobs, "read and condition", progress)
    motions = [r for r in results if isinstance(r, Motion)]
    failed = [r for r in results if isinstance(r, FailedTrial)]
    return Read(tuple(motions), tuple(failed))


@dataclass(frozen=True)
class _Conditioner:
    """Reads and conditions one entry; picklable for worker processes."""

    catalogue: Catalogue

    def __call__(self, entry: Entry) -> Motion | FailedTrial:
        try:
            recording = read_trial(entry, self.catalogue)
            doubts = check(recording)
            recording = replace(recording, notes=recording.notes + doubts)
            motion = condition(recording, start_s=entry.window.start_s, end_s=entry.window.end_s)
            dominant_period(motion)  # a motion that does not swing is this trial's failure, not its group's
            return motion
        except UndertowError as reason:
            return FailedTrial(entry.name, str(reason), dict(entry.conditions))


def _grouped(config: RunConfig, motions: Sequence[Motion]) -> dict[tuple[tuple[str, Condition], ...], list[Motion]]:
    """Motions by group, dry groups first, then in order of their conditions; each in order of amplitude."""
    groups: dict[tuple[tuple[str, Condition], ...], list[Motion]] = {}
    for motion in motions:
        groups.setdefault(config.group_key(motion.recording.conditions), []).append(motion)

    def order(key: tuple[tuple[str, Condition], ...]) -> tuple[object, ...]:
        dry = config.is_dry(groups[key][0].recording.conditions)
        return (not dry, *((isinstance(v, str), str(v) if isinstance(v, str) else f"{v:020.6f}") for _, v in key))

    return {key: sorted(groups[key], key=lambda m: (m.amplitude, m.name)) for key in sorted(groups, key=order)}


_Key = tuple[tuple[str, Condition], ...]


def _spring(config: RunConfig, key: _Key) -> _Key:
    """The part of a group's key that its dry trials share: everything the config's ``dry`` does not fix."""
    fixed = config.trials.dry or {}
    return tuple((name, value) for name, value in key if name not in fixed)


@dataclass(frozen=True)
class _Dry:
    """A structure from dry trials, with the load cells' ratio to it (mean; stderr is the spread)."""

    structure: Structure
    ratio: Estimate


def _structures(config: RunConfig, groups: Mapping[_Key, Sequence[Motion]], terms: Sequence[Term]) -> dict[_Key, _Dry]:
    """The structure of every spring that has dry trials and a known mass."""
    fitted: dict[_Key, dict[str, GroupFit]] = {}
    slopes: dict[_Key, list[float]] = {}
    for key, motions in groups.items():
        specimen = config.specimen_for(motions[0].recording.conditions)
        if not config.is_dry(motions[0].recording.conditions) or not math.isfinite(specimen.mass_kg):
            continue
        spring = _spring(config, key)
        found = dry_fits(motions, structural_terms(terms), specimen, TrialOptions())
        if not found:
            continue
        fitted[spring] = found
        measured = [(m, _slope(m)) for m in motions]
        slopes[spring] = [
            slope.value / fitted[spring][m.name].estimates["k_N_per_m"].value
            for m, slope in measured if slope and m.name in fitted[spring]
        ]  # fmt: skip
    stated = config.specimen.scatter
    scatter = pooled_scatter(list(fitted.values()))
    if stated is not None:
        scatter = Scatter({"k": stated.k, "c": stated.c, "mu": stated.mu}, math.inf)
    away = [ratio / float(np.mean(ratios)) - 1.0 for ratios in slopes.values() for ratio in ratios]
    freedom = len(away) - sum(bool(ratios) for ratios in slopes.values())
    spread = math.sqrt(sum(d * d for d in away) / freedom) if freedom > 0 else math.nan
    return {
        spring: _Dry(
            structure_from(fits, scatter),
            Estimate(float(np.mean(slopes[spring])) if slopes[spring] else math.nan, spread, unit="1"),
        )
        for spring, fits in fitted.items()
    }


def _slope(motion: Motion) -> Estimate | None:
    """Slope of spring force on displacement, None where either is not recorded."""
    channels = motion.recording.channels
    if "spring_force" not in channels or "displacement" not in channels:
        return None
    return load_cell_stiffness(motion)


def _task(
    config: RunConfig,
    key: _Key,
    motions: Sequence[Motion],
    terms: Sequence[Term],
    structures: Mapping[_Key, _Dry],
    groups: Mapping[_Key, Sequence[Motion]],
) -> GroupTask:
    conditions = motions[0].recording.conditions
    specimen = config.specimen_for(conditions)
    dry = config.is_dry(conditions)
    found = structures.get(_spring(config, key))
    structure = found.structure if found else None
    slopes = {m.name: s for m in motions if (s := _slope(m)) is not None}
    mean_slope = mean_of_trials(list(slopes.values()), "N/m", "load cells") if slopes else None
    anchor = choose_anchor(specimen, structure, mean_slope, dry)
    stiffness = {}
    if found is not None and slopes and not dry and math.isfinite(found.ratio.value):
        stiffness = trial_stiffness(found.structure.k, slopes, found.ratio, found.structure.scatter["k"])
    stated = config.specimen.scatter
    return GroupTask(
        dict(key), dry, tuple(motions), _group_terms(terms, dry), specimen, None if dry else structure, anchor,
        stiffness, {"k": stated.k, "c": stated.c, "mu": stated.mu} if stated else _dry_scatter(structure),
        structure.scatter_freedom if structure is not None and stated is None else math.inf, structure,
        held_out(config, motions), tuple(config.identify), _options(structure, specimen), config.seed,
    )  # fmt: skip


def _group_terms(terms: Sequence[Term], dry: bool) -> tuple[Term, ...]:
    return structural_terms(terms) if dry else tuple(terms)


def _dry_scatter(structure: Structure | None) -> dict[str, float]:
    return dict(structure.scatter) if structure is not None else {}


def _options(structure: Structure | None, specimen: Specimen) -> TrialOptions:
    """Nuisances of a trial: the rest position's prior is the width in which friction lets the body come to rest."""
    if structure is None:
        return TrialOptions()
    width = structure.mu.value * specimen.normal_force_N / structure.k.value
    return TrialOptions(rest_offset_std=width) if math.isfinite(width) and width > 0.0 else TrialOptions()


def held_out(config: RunConfig, motions: Sequence[Motion]) -> tuple[str, ...]:
    """Names of a group's trials that are never fitted; ``motions`` in order of amplitude.

    auto: from three trials on every third, starting with the second, never the smallest or the largest.
    """
    rule = config.trials.hold_out
    names = [m.name for m in motions]
    if rule == "auto":
        return tuple(names[i] for i in range(1, len(names) - 1, 3)) if len(names) >= 3 else ()
    if isinstance(rule, EverySettings):
        return tuple(names[1 :: rule.every]) if len(names) > 1 else ()
    if isinstance(rule, LargestSettings):
        if rule.largest >= len(names):
            raise RecordingError(
                f"trials.hold_out: largest {rule.largest} leaves none of the {len(names)} trials "
                f"({', '.join(names)}) to be fitted; hold out fewer"
            )
        return tuple(names[-rule.largest :])
    return tuple(n for n in names if n in rule)


def _across(groups: Sequence[GroupFindings]) -> str:
    """One sentence over all groups."""
    named: dict[str, list[str]] = {}
    for group in groups:
        for name in dict.fromkeys(group.verdict.verdict):
            words = "something unknown" if name == "unknown" else name.replace("_", " ")
            named.setdefault(words, []).append(group.label)
    if not named:
        return f"The equation explains {count(len(groups), 'group')}; nothing is missing."
    of = count(len(groups), "group")
    parts = [f"{name} in {len(labels)} of {of}" for name, labels in named.items()]
    return f"The equation leaves out: {'; '.join(parts)}."


def _notes(read: Read) -> tuple[str, ...]:
    """What reading and conditioning changed, a trial a line; nothing silent."""
    return tuple(
        f"{m.name}: {note}" for m in read.motions for note in (*m.recording.notes, *m.notes)
    )


__all__ = ["Progress", "Read", "held_out", "read_and_condition", "run"]
