"""The one trial that cannot be of its group: another period, size, noise or stiffness than all others have.

Belongs here: how such a trial shows, and that in words. Does not belong here: groups of several bodies (one_body.py),
scales that friction and drag show (trial_scale.py), what the search leaves of one trial (discrepancy/alone.py).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from undertow.campaign.run.one_body import ALONE, APART, Swing, apart, swings_of
from undertow.comparison.suspects import SUSPECTS
from undertow.conditioning.motion import Motion
from undertow.discrepancy.drifts import WORTH_SAYING, rates
from undertow.discrepancy.findings import GroupFindings
from undertow.discrepancy.words import percent

ALONE_OF_TWO, SURELY = 10.0, 2.0
"""One trial's period is another than that of three or more others where it is `ALONE` times as far from them as they
are from each other, of two others the first of these. Of normal numbers alike one stands so in 16 of 100 groups of
three, in 7 of four, in 1.5 of five. Where nothing is missing it must be `SURELY` times as far, but among `MANY`
others."""

MANY = 4
"""So many other trials show how far one may be off."""

LEAST_APART = 1.01
"""The same, at least: friction and drag move a period by less from release to release."""

AS_LARGE = 1.5
"""The same holds of a trial as large as the others, or so many times larger or smaller: springs and water may change
the period of a far larger one."""

OF_TWO_RIGS = {5: 8.0, 6: 5.0}
"""Stiffness of five, six or more (`ALONE`) trials is of two rigs where it falls into two lots that are so many times
as far apart as either is wide: of normal numbers alike 5 of 1,000 groups do at most."""

QUIET, LOUD = 30.0, 3.0
"""Times the noise of a trial from which on others, alike within the second, say that it was filtered."""

SIZES_APART = 100.0
"""Ratio of one trial's release to all others' that no ladder of releases has, and a unit has."""

UNLIKE = 2.5
"""Repeatabilities by which an unseen trial of a group in which nothing is missing may be off: of 288 sealed groups with
nothing missing (seed 2125001) the furthest was 1.6 away, and one in twenty is 1 away."""

BETWEEN_TRIALS = frozenset(suspect.name for suspect in SUSPECTS if suspect.is_scatter)
"""Names that say how trials differ."""

EXPLAINED = frozenset({"nothing_missing", "explained", "present_but_small"})
"""Of such groups one equation gives every trial's period."""


def strange_trial(group: GroupFindings, known: Collection[str] = ()) -> str:
    """A trial that cannot be of its group, and how it shows; empty where there is none but of those ``known`` to be
    strange. Of a group in which nothing is missing: one that no fit saw and that is far off, or one or several of
    another stiffness; but where something is explained: the one of another size, period or noise."""
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
    return found or (_two_rigs(group, known) if verdict.status in EXPLAINED else "")


def in_one_trial(groups: Sequence[GroupFindings], strange: Collection[str]) -> list[str]:
    """For every group whose verdict names what differs from trial to trial: the one trial of its water that differs, in
    words; empty where there is none but of the ``strange``. Of one trial that is no law: its clock, its spring or its
    file may be another."""
    scattered = [bool(BETWEEN_TRIALS & set(group.verdict.verdict)) for group in groups]
    texts = [lone_trial(g, strange) if named else "" for g, named in zip(groups, scattered, strict=True)]
    said = [(group.verdict.parameters, text) for group, text in zip(groups, texts, strict=True) if text]
    return [
        next((text for numbers, text in said if named and numbers == group.verdict.parameters), "")
        for group, named in zip(groups, scattered, strict=True)
    ]


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


def _two_rigs(group: GroupFindings, known: Collection[str]) -> str:
    """The one trial, or the lot, whose stiffness over mass, fitted alone, lies apart from the others', which lie
    together: friction and drag move it less than periods."""
    own = sorted((rate, name) for name, rate, *_ in rates(group) if name not in known)
    for place in range(1, len(own)) if len(own) > MANY else ():
        below, above = own[:place], own[place:]
        gap = above[0][0] - below[-1][0]
        within = max(lot[-1][0] - lot[0][0] for lot in (below, above))
        if gap > max(OF_TWO_RIGS.get(len(own), ALONE) * within, WORTH_SAYING):
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
