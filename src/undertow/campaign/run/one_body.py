"""Whether trials that are fitted together swing alike: another period is another body, another spring or other water.

Belongs here: periods side by side, the condition that parts them. Does not belong here: numbers that no body has
(plausible.py).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.discrepancy.drifts import WORTH_SAYING, rates
from undertow.discrepancy.findings import GroupFindings
from undertow.discrepancy.words import percent
from undertow.errors import FAILURES
from undertow.recording.recording import Condition

APART = 1.2
"""Ratio of the longest to the shortest period from which on trials are said not to be of one body: a hardening spring
and friction move it by less from release to release of most rigs, a gap or a stop by more."""

ALONE, ALONE_OF_TWO, SURELY = 4.0, 10.0, 2.0
"""One trial's period is another than that of three or more others where it is so many times as far from them as they
are from each other, of two others the second. Of normal numbers alike one stands so in 16 of 100 groups of three, in 7
of four, in 1.5 of five. Where nothing is missing it must be `SURELY` times as far, but among `MANY` others."""

MANY = 4
"""So many other trials show how far one may be off."""

OFF_RATE = {5: 8.0, 6: 5.0}
"""Stiffness of five, six or more (`ALONE`) trials is of two rigs where it falls into two lots that are so many times
as far apart as either is wide: of normal numbers alike 4 of 1,000 groups do."""

QUIET, LOUD = 30.0, 3.0
"""Times the noise of a trial from which on others, alike within the second, say that it was filtered."""

LEAST_APART = 1.01
"""The same, at least: friction and drag move a period by less from release to release."""

AS_LARGE = 1.5
"""The same holds of a trial as large as the others, or so many times larger or smaller: springs and water may change
the period of a far larger one."""

SIZES_APART = 100.0
"""Ratio of one trial's release to all others' that no ladder of releases has, and a unit has."""

UNLIKE = 2.5
"""Repeatabilities by which an unseen trial of a group in which nothing is missing may be off: of 288 sealed groups with
nothing missing (seed 2125001) the furthest was 1.6 away, and one in twenty is 1 away."""

EXPLAINED = frozenset({"nothing_missing", "explained", "present_but_small"})
"""Of such groups one equation gives every trial's period."""


@dataclass(frozen=True)
class Swing:
    """One trial: its ``name``, period (s), largest motion (m or rad) and conditions."""

    name: str
    period_s: float
    amplitude: float
    conditions: Mapping[str, Condition]


def swings_of(motions: Sequence[Motion]) -> list[Swing]:
    """The periods of trials; those without one are left out."""
    found = []
    for motion in motions:
        try:
            found.append(Swing(motion.name, dominant_period(motion), motion.amplitude, motion.recording.conditions))
        except FAILURES:
            continue
    return found


def apart(swings: Sequence[Swing]) -> bool:
    """Whether their periods differ by more than one body's."""
    periods = [one.period_s for one in swings]
    return len(periods) > 1 and max(periods) > APART * min(periods)


def bodies(swings: Sequence[Swing]) -> int:
    """How many bodies trials are of, by gaps between their periods."""
    return len(_lots(swings))


def parted_by(swings: Sequence[Swing]) -> str:
    """The condition that parts trials into groups of one period each, one of words and of few values first; empty where
    none does."""
    names = [name for name in swings[0].conditions if all(name in one.conditions for one in swings)] if swings else []
    sizes = {}
    for name in names:
        groups: dict[Condition, list[Swing]] = defaultdict(list)
        for one in swings:
            groups[one.conditions[name]].append(one)
        if not any(apart(members) for members in groups.values()):
            sizes[name] = (not all(isinstance(value, str) for value in groups), len(groups))
    return min(sizes, key=lambda name: sizes[name], default="")


def not_one_body(group: GroupFindings) -> str:
    """That a group which is not explained holds trials of other periods, and what parts them; empty where it is one
    body's, or no condition has a value for each period: one with a gap, or two that swing together, have many.
    """
    swings = swings_of([trial.motion for trial in group.trials])
    if group.verdict.status in ("nothing_missing", "explained") or not apart(swings):
        return ""
    name, lots = parted_by(swings), _lots(swings)
    told = bool(name) and len({one.conditions[name] for one in swings}) == len(lots)
    if not told and not _many_bodies(lots):
        return ""
    key = f"set trials.group_by: [{', '.join((*group.key, name))}]" if told else (
        "give every trial its condition, as a column of an index or a part of its name, and set trials.group_by"
    )  # fmt: skip
    first, last = lots[0][0], lots[-1][-1]
    return (
        f"trial {first.name} swings at a period of {first.period_s:.3g} s and {last.name} at {last.period_s:.3g} s, "
        f"more than {100.0 * (APART - 1.0):.0f} % apart{'' if told else ', and none between'}: these are not one body "
        f"or spring; {key}"
    )


def _lots(swings: Sequence[Swing]) -> list[list[Swing]]:
    """Trials in order of their periods, parted where these lie apart."""
    lots: list[list[Swing]] = []
    for one in sorted(swings, key=lambda one: one.period_s):
        if not lots or one.period_s > APART * lots[-1][-1].period_s:
            lots.append([])
        lots[-1].append(one)
    return lots


def _many_bodies(lots: Sequence[Sequence[Swing]]) -> bool:
    """Whether lots of trials show by themselves that they are of several bodies: two of each at least, alike in period
    beside how far the next lot is, from releases of one range. One body whose period goes with its swing has none."""
    sizes = [[one.amplitude for one in lot] for lot in lots]
    alike = all(lot[-1].period_s / lot[0].period_s - 1.0 < (APART - 1.0) / ALONE for lot in lots)
    one_range = all(max(min(a), min(b)) <= min(max(a), max(b)) for a, b in pairwise(sizes))
    return len(lots) > 1 and min(map(len, lots)) > 1 and alike and one_range


def strange_trial(group: GroupFindings, known: Collection[str] = ()) -> str:
    """A trial that cannot be of its group, and how it shows: one that no fit saw, of a group in which nothing is
    missing, or the one of another period where nothing is explained; empty where there is none but of those ``known``
    to be strange."""
    verdict = group.verdict
    limit = UNLIKE * verdict.repeatability_nrmse
    unseen = [t for t in group.trials if t.held_out and t.mismatch.nrmse > limit and t.motion.name not in known]
    advice = "look at its clock, its spring and what its file is, or leave it out (recordings.exclude)"
    if verdict.status == "nothing_missing" and unseen:
        worst = max(unseen, key=lambda one: one.mismatch.nrmse)
        size, times = worst.mismatch.nrmse, worst.mismatch.nrmse / verdict.repeatability_nrmse
        return (
            f"trial {worst.motion.name}, which no fit saw, is {times:.2g} times as far from the equation as "
            f"repetitions are ({percent(size)} of its motion{_beside(worst.motion, group)}): {advice}"
        )
    sizes = {trial.motion.name: trial.motion.amplitude for trial in group.trials}
    for name, size in sizes.items():
        rest = [other for label, other in sizes.items() if label != name]
        if name not in known and len(rest) > 1 and not min(rest) / SIZES_APART < size < SIZES_APART * max(rest):
            return (
                f"trial {name} is released from {size:.3g}, the others of its group from {min(rest):.3g} to "
                f"{max(rest):.3g}: look at the unit of its displacement (recordings.layouts)"
            )
    if verdict.status == "explained":
        return ""
    sure = SURELY if verdict.status in EXPLAINED else 1.0
    found = lone_trial(group, known, sure) or _quiet_trial(group, known)
    return found or (_off_rate(group, known) if verdict.status in EXPLAINED else "")


def _quiet_trial(group: GroupFindings, known: Collection[str]) -> str:
    """The one trial with far less noise than the others, which are alike: a filter took the noise, and moves a decay by
    as much as it delays it."""
    noise = {}
    for trial in group.trials:
        level = trial.mismatch.sensor_floor_nrmse * float(np.std(trial.measured))
        if trial.motion.name not in known and level > 0.0:
            noise[trial.motion.name] = level
    name = min(noise, key=lambda one: noise[one], default="")
    others = [level for label, level in noise.items() if label != name]
    if len(others) < 2 or max(others) > LOUD * min(others) or min(others) < QUIET * noise[name]:
        return ""
    return (
        f"trial {name} has {min(others) / noise[name]:.0f} times less noise than the others of its group: it may be "
        "filtered, and its motion with it; give the record as it was, or leave it out (recordings.exclude)"
    )


def _off_rate(group: GroupFindings, known: Collection[str]) -> str:
    """The one trial, or the lot, whose stiffness over mass, fitted alone, lies apart from the others', which lie
    together: friction and drag move it less than periods."""
    own = sorted((rate, name) for name, rate, *_ in rates(group) if name not in known)
    for place in range(1, len(own)) if len(own) > MANY else ():
        below, above = own[:place], own[place:]
        gap = above[0][0] - below[-1][0]
        within = max(lot[-1][0] - lot[0][0] for lot in (below, above))
        if gap > max(OFF_RATE.get(len(own), ALONE) * within, WORTH_SAYING):
            lot = min((below, above), key=len)
            names = ", ".join(sorted(name for _, name in lot))
            return (
                f"stiffness over mass of {'trial' if len(lot) == 1 else 'trials'} {names} is {percent(gap)} "
                f"{'above' if lot is above else 'below'} that of the others, and each lot lies within {percent(within)}"
                ": look at the spring, the mass and the clock; group by what was changed (trials.group_by), or "
                "leave it out (recordings.exclude)"
            )
    return ""


def lone_trial(group: GroupFindings, known: Collection[str] = (), sure: float = 1.0) -> str:
    """The one trial of another period, in words: another clock, spring or body, where the others swing alike; empty
    where there is none but of those ``known`` to be strange. It is ``sure`` times as far from them as it need be."""
    swings = swings_of([trial.motion for trial in group.trials])
    for one in (one for one in swings if one.name not in known):
        others = [other for other in swings if other is not one]
        if len(others) > 1 and not apart(others) and _alone(one, others, sure):
            return (
                f"trial {one.name} is unlike the others{_periods(one, others)}: look at its clock, its spring and what "
                "its file is, or leave it out (recordings.exclude)"
            )
    return ""


def _alone(one: Swing, others: Sequence[Swing], sure: float) -> bool:
    """Whether a trial's period is another than the others'."""
    low, high = min(o.period_s for o in others), max(o.period_s for o in others)
    off = max(low / one.period_s, one.period_s / high)
    times = (sure if len(others) < MANY else 1.0) * (ALONE if len(others) > 2 else ALONE_OF_TWO)
    sizes = [o.amplitude for o in others]
    as_large = min(sizes) / AS_LARGE < one.amplitude < AS_LARGE * max(sizes)
    return off > APART or (as_large and off > LEAST_APART and off - 1.0 > times * (high / low - 1.0))


def _beside(motion: Motion, group: GroupFindings) -> str:
    """A trial's period beside its group's, where it is another."""
    mine = swings_of([motion])
    others = swings_of([t.motion for t in group.trials if t.motion.name != motion.name])
    return _periods(mine[0], others) if mine and others and not apart(others) else ""


def _periods(one: Swing, others: Sequence[Swing]) -> str:
    low, high = min(o.period_s for o in others), max(o.period_s for o in others)
    if low / LEAST_APART <= one.period_s <= LEAST_APART * high:
        return ""
    theirs = f"{low:.4g}" if f"{low:.4g}" == f"{high:.4g}" else f"{low:.4g} to {high:.4g}"
    return f", at a period of {one.period_s:.4g} s beside {theirs} s"
