"""Whether trials that are fitted together swing alike: another period is another body, another spring or other water.

Belongs here: periods side by side, the condition that parts them. Does not belong here: numbers that no body has
(plausible.py).
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

EXPLAINED = frozenset({"nothing_missing", "explained", "present_but_small"})
"""Of such groups one equation gives every trial's period."""


@dataclass(frozen=True)
class Swing:
    """One trial: its ``name``, period (s) and conditions."""

    name: str
    period_s: float
    conditions: Mapping[str, Condition]


def swings_of(motions: Sequence[Motion]) -> list[Swing]:
    """The periods of trials; those without one are left out."""
    found = []
    for motion in motions:
        try:
            found.append(Swing(motion.name, dominant_period(motion), motion.recording.conditions))
        except FAILURES:
            continue
    return found


def apart(swings: Sequence[Swing]) -> bool:
    """Whether their periods differ by more than one body's."""
    periods = [one.period_s for one in swings]
    return len(periods) > 1 and max(periods) > APART * min(periods)


def bodies(swings: Sequence[Swing]) -> int:
    """How many bodies trials are of, by gaps between their periods."""
    periods = sorted(one.period_s for one in swings)
    return 1 + sum(after > APART * before for before, after in pairwise(periods))


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
    name = "" if group.verdict.status in EXPLAINED or not apart(swings) else parted_by(swings)
    if not name or len({one.conditions[name] for one in swings}) != bodies(swings):
        return ""
    first, *_, last = sorted(swings, key=lambda one: one.period_s)
    return (
        f"trial {first.name} swings at a period of {first.period_s:.3g} s and {last.name} at {last.period_s:.3g} s, "
        f"more than {100.0 * (APART - 1.0):.0f} % apart: these are not one body or spring; set trials.group_by: "
        f"[{', '.join((*group.key, name))}]"
    )
