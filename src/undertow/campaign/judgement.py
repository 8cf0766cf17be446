"""Which groups are judged together, and their verdicts: dry ones first, then each water's groups.

Belongs here: that order, and a group as the judge sees it. Does not belong here: the search (discrepancy/).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from undertow.campaign.analysis import GroupTask
from undertow.campaign.config import RunConfig
from undertow.campaign.workers import Progress, on_processes
from undertow.discrepancy.findings import GroupFindings
from undertow.discrepancy.joint import Member
from undertow.discrepancy.judge import Case, judge
from undertow.discrepancy.suspects import Suspect, chosen
from undertow.discrepancy.verdict import Verdict
from undertow.identification.baseline import group_model


def judged(
    config: RunConfig, tasks: Sequence[GroupTask], groups: Sequence[GroupFindings], jobs: int, progress: Progress
) -> list[GroupFindings]:
    """The groups with their verdicts: dry ones first, then each water's groups together."""
    suspects = chosen(config.discrepancy.suspects)
    cases = [_case(config, task, group) for task, group in zip(tasks, groups, strict=True)]
    dry = [[case] for case in cases if case.dry]
    levels: dict[tuple[object, ...], list[Case]] = {}
    for case in cases:
        if not case.dry:
            levels.setdefault(_water(config, case), []).append(case)
    first = on_processes(_Judge(suspects, ()), dry, jobs, "dry: what is missing", progress)
    names = tuple({n for verdicts in first for v in verdicts for n in v.verdict if n != "unknown"})
    second = on_processes(_Judge(suspects, names), list(levels.values()), jobs, "wet: what is missing", progress)
    said = {tuple(v.group.items()): v for verdicts in (*first, *second) for v in verdicts}
    return [replace(group, verdict=said[tuple(group.key.items())]) for group in groups]


@dataclass(frozen=True)
class _Judge:
    """Judges one level; picklable for worker processes."""

    suspects: tuple[Suspect, ...]
    dry_names: tuple[str, ...]

    def __call__(self, cases: Sequence[Case]) -> tuple[Verdict, ...]:
        return judge(cases, self.suspects, self.dry_names)


def _water(config: RunConfig, case: Case) -> tuple[object, ...]:
    """What groups of the same water share; a group for itself where nothing is known from dry trials."""
    fixed = config.trials.dry or {}
    if not case.has_dry or not fixed:
        return tuple(case.key.items())
    return tuple(case.key[name] for name in fixed if name in case.key)


def _case(config: RunConfig, task: GroupTask, group: GroupFindings) -> Case:
    """A group as the judge sees it."""
    model = group_model(
        task.terms, task.motions, task.specimen, task.dry_structure, dry=task.dry, anchored=task.anchor.known,
        stiffness={n: e.value for n, e in task.stiffness.items()},
    )  # fmt: skip
    fixed = config.trials.dry or {}
    spring = " ".join(str(v) for k, v in task.key.items() if k not in fixed) or "all"
    training = tuple(m for m in task.motions if m.name not in task.held_out)
    held = tuple(m for m in task.motions if m.name in task.held_out)
    member = Member(spring, model, training, task.options, config.trials.hidden_at_release == "free")
    conditions = task.motions[0].recording.conditions
    return Case(
        task.key, group.label, member, held, group.verdict.baseline, group.verdict.sensor_floor_nrmse,
        group.verdict.repeatability_nrmse, sum(t.mismatch.missing for t in group.trials), task.dry,
        task.dry_structure is not None, config.cell_for(conditions),
    )  # fmt: skip
