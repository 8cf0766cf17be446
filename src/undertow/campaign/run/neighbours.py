"""Trials that swing like those of another group: two rows of an index exchanged, a level mistyped.

Belongs here: the comparison of periods between groups. Does not belong here: a trial's own channels
(conditioning/agreement.py), what becomes of the trial (checking.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from undertow.campaign.config import GroupKey
from undertow.conditioning.motion import Motion
from undertow.discrepancy.words import group_title
from undertow.likelihood.problem import dominant_period

FEWEST = 3
"""Trials of a group of which a median still says what most of them do when one is another group's."""

LEAST_SCATTER = 0.003
"""Scatter of periods, relative, that every group is granted: friction ends a last swing early."""

OFF = 6.0
"""A trial is off its group beyond so many times the scatter."""

LIKE = 2.0
"""It is like another group's within so many times the scatter."""


@dataclass(frozen=True)
class _Group:
    """A group's median period, s, and its trials' scatter about that, relative."""

    period_s: float
    scatter: float


def misplaced(groups: Mapping[GroupKey, Sequence[Motion]]) -> dict[str, str]:
    """Trial -> sentence, for trials whose period is another group's and surely not that of their own.

    Scatter is the median deviation from the group's median; groups of fewer than three trials say nothing.
    """
    periods = {key: {m.name: dominant_period(m) for m in motions} for key, motions in groups.items()}
    known = {key: _group(list(own.values())) for key, own in periods.items() if len(own) >= FEWEST}
    found = {}
    for key, here in known.items():
        for name, period in periods[key].items():
            like = [other for other in known if other != key and _belongs(period, here, known[other])]
            if like:
                nearest = min(like, key=lambda other: _off(period, known[other]))
                found[name] = (
                    f"it swings with a period of {period:.3g} s, as the trials of {group_title(dict(nearest))} do "
                    f"({known[nearest].period_s:.3g} s), and those of its own group, {group_title(dict(key))}, with "
                    f"{here.period_s:.3g} s: correct its conditions, or list conditions in recordings.accept"
                )
    return found


def _group(periods: Sequence[float]) -> _Group:
    middle = float(np.median(periods))
    scatter = float(np.median(np.abs(np.log(np.asarray(periods) / middle))))
    return _Group(middle, max(scatter, LEAST_SCATTER))


def _off(period: float, group: _Group) -> float:
    return abs(math.log(period / group.period_s))


def _belongs(period: float, own: _Group, other: _Group) -> bool:
    """Whether a trial of one group is the other's."""
    scatter = max(own.scatter, other.scatter)
    return _off(period, own) > OFF * scatter and _off(period, other) < LIKE * scatter


__all__ = ["misplaced"]
