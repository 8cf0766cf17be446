"""In which order and beside what things are shown: trials by amplitude, groups by series and level.

Belongs here: choices of arrangement from a finished result. Does not belong here: drawing (figures.py), words
(wording.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from undertow.discrepancy.findings import Findings, GroupFindings, TrialFindings
from undertow.quantities import Estimate
from undertow.recording.recording import Condition
from undertow.report.wording import REFERENCE_ORDER, is_as_printed

AGREEMENT_IN_STDERR = 2.0
"""Two methods agree when they differ by less than this many of their combined standard errors (95 % two-sided)."""


@dataclass(frozen=True)
class Span:
    """Conditions that tell groups apart: ``series`` (one marker each) and ``level`` (a numeric axis), or None."""

    series: str | None
    level: str | None

    def series_of(self, group: GroupFindings) -> Condition:
        """The group's value of the series' condition; empty where there is none."""
        return "" if self.series is None else group.key.get(self.series, "")

    def level_of(self, group: GroupFindings) -> float:
        """The group's value on the numeric axis; nan where there is none."""
        value = math.nan if self.level is None else group.key.get(self.level, math.nan)
        return float(value) if is_number(value) else math.nan


def is_number(value: object) -> bool:
    """Whether a condition is a number (a truth value is not)."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def spanning_conditions(findings: Findings) -> Span:
    """Series and numeric axis of a campaign's groups.

    The axis is the last condition that is a number in every group and takes more than one value; the series is the
    first other condition.
    """
    columns = list(dict.fromkeys(column for group in findings.groups for column in group.key))
    level = None
    for column in columns:
        values = [group.key.get(column) for group in findings.groups]
        if all(is_number(value) for value in values) and len(set(values)) > 1:
            level = column
    series = next((column for column in columns if column != level), None)
    return Span(series, level)


def by_amplitude(trials: Sequence[TrialFindings]) -> tuple[TrialFindings, ...]:
    """Trials from the smallest release to the largest."""
    return tuple(sorted(trials, key=lambda trial: (trial.motion.amplitude, trial.motion.name)))


def excess(trial: TrialFindings) -> float:
    """How many times what repeatability allows a trial's free-run error is; nan where that is not known."""
    allowed = trial.mismatch.repeatability_nrmse
    return trial.mismatch.nrmse / allowed if allowed > 0.0 else math.nan


def chosen(trials: Sequence[TrialFindings], at_most: int) -> tuple[TrialFindings, ...]:
    """At most so many trials, by amplitude: the smallest and the largest release, then the worst explained ones."""
    ordered = by_amplitude(trials)
    if len(ordered) <= at_most:
        return ordered
    ends = [ordered[0], ordered[-1]][:at_most]
    inner = sorted(ordered[1:-1], key=lambda trial: -(excess(trial) if math.isfinite(excess(trial)) else 0.0))
    return by_amplitude([*ends, *inner[: at_most - len(ends)]])


def group_numbers(group: GroupFindings) -> Mapping[str, Estimate]:
    """The numbers that stand for a group: those of the first method of REFERENCE_ORDER that found any.

    Where none did: the verdict's baseline's.
    """
    for method in (*REFERENCE_ORDER, *group.fits):
        if method in group.fits and group.fits[method].parameters and not is_as_printed(method):
            return group.fits[method].parameters
    return group.verdict.baseline.parameters


@dataclass(frozen=True)
class Agreement:
    """How methods agree on one parameter in one group: how many, their range, the pair that differs most.

    ``distance`` is that pair's difference over its combined standard error, ``difference`` in the parameter's unit. The
    methods see the same trials, so their errors are not independent: the distance describes, it does not test.
    """

    parameter: str
    methods: int
    lowest: float
    highest: float
    pair: tuple[str, str]
    difference: float
    distance: float
    unit: str

    @property
    def agrees(self) -> bool:
        """Whether no pair differs by more than AGREEMENT_IN_STDERR combined standard errors."""
        return self.distance <= AGREEMENT_IN_STDERR


def agreement(group: GroupFindings, parameter: str) -> Agreement | None:
    """Agreement of the methods that gave the parameter an error bar; None with fewer than two of them.

    The recipe that is shown as printed takes no part, nor does an estimate that failed or sits on a bound.
    """
    usable = {
        method: fit.parameters[parameter]
        for method, fit in group.fits.items()
        if not is_as_printed(method) and parameter in fit.parameters and is_usable(fit.parameters[parameter])
    }
    if len(usable) < 2:
        return None
    names = list(usable)
    pairs = [(a, b) for i, a in enumerate(names) for b in names[i + 1 :]]

    def distance(pair: tuple[str, str]) -> float:
        first, second = usable[pair[0]], usable[pair[1]]
        return abs(first.value - second.value) / math.hypot(first.total_stderr, second.total_stderr)

    worst = max(pairs, key=distance)
    values = [estimate.value for estimate in usable.values()]
    gap = abs(usable[worst[0]].value - usable[worst[1]].value)
    unit = usable[worst[0]].unit
    return Agreement(parameter, len(names), min(values), max(values), worst, gap, distance(worst), unit)


def is_usable(estimate: Estimate) -> bool:
    """Whether an estimate has a finite value, a positive finite error, and came without reservation."""
    total = estimate.total_stderr
    return math.isfinite(estimate.value) and math.isfinite(total) and total > 0.0 and estimate.outcome == "ok"
