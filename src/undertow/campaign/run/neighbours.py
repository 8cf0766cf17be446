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
from undertow.conditioning.period import dominant_period
from undertow.discrepancy.words import group_title

FEWEST = 3
"""Trials of a group of which a median still says what most of them do when one is another group's."""

LEAST_RANGE = 0.01
"""Range of periods, relative, that every group is granted: they go with amplitude, and friction ends a last swing
early."""

OFF = 5.0
"""A trial is off its group beyond so many times the range of the others' periods: water that swings by itself moves
them by some per cent from trial to trial."""

LIKE = 1.0
"""It is like another group's within so many times the range."""

OTHER_CLOCK, ALIKE = math.log(30.0), math.log(2.0)
"""No spring or water changes a period so much, and a unit of time does, where all other trials swing alike."""


@dataclass(frozen=True)
class _Group:
    """A group's median period, s, and the range of its trials' periods but the one farthest off, relative."""

    period_s: float
    width: float


def misplaced(groups: Mapping[GroupKey, Sequence[Motion]]) -> dict[str, str]:
    """Trial -> sentence, for trials whose period is another group's, or of another clock, and surely not of their own.

    Groups of fewer than three trials say nothing.
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
            elif _off(period, here) > OTHER_CLOCK and here.width < ALIKE:
                found[name] = (
                    f"it swings with a period of {period:.3g} s, and the others of its group, "
                    f"{group_title(dict(key))}, with {here.period_s:.3g} s: is its time in another unit? correct it "
                    "for this file (recordings.layouts), or list conditions in recordings.accept"
                )
    return found


def _group(periods: Sequence[float]) -> _Group:
    middle = float(np.median(periods))
    away = np.log(np.asarray(periods) / middle)
    most = np.delete(away, np.argmax(np.abs(away)))
    return _Group(middle, max(float(np.ptp(most)), LEAST_RANGE))


def _off(period: float, group: _Group) -> float:
    return abs(math.log(period / group.period_s))


def _belongs(period: float, own: _Group, other: _Group) -> bool:
    """Whether a trial of one group is the other's."""
    width = max(own.width, other.width)
    return _off(period, own) > OFF * width and _off(period, other) < LIKE * width


__all__ = ["misplaced"]
