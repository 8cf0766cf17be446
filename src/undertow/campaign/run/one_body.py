"""Whether trials that are fitted together swing alike: another period is another body, another spring or other water.

Belongs here: periods side by side, the condition that parts them. Does not belong here: numbers that no body has
(plausible.py), one trial unlike the others (strange_trial.py).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.discrepancy.findings import GroupFindings
from undertow.errors import FAILURES
from undertow.recording.recording import Condition

APART = 1.2
"""Ratio of the longest to the shortest period from which on trials are said not to be of one body: a hardening spring
and friction move it by less from release to release of most rigs, a gap or a stop by more."""

ALONE = 4.0
"""Times as far apart as each is wide: two lots of trials."""


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
