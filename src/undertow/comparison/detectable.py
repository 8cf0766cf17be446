"""What a level would have seen: for every suspect the smallest effect that nine in ten replicas would show.

Belongs here: that size, what it is called, and from which size on it is distinguished from every other. Does not belong
here: p-values and replicas (null_test.py), words (report/).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from undertow.comparison.replicas import not_slow
from undertow.comparison.score_stack import Scored, Stack
from undertow.comparison.score_test import GridPlace
from undertow.comparison.suspect import Addition
from undertow.recording.recording import Array

POWER = 0.9
"""Power with which an effect that is called visible would be seen."""

NAMED = math.log(99.0)
"""Log odds over every other suspect from which an effect has a name."""

HALVINGS = 40

LEAST_NOT_SLOW = 1e-6
"""Share of an effect that is at least held to be faster than a sensor wanders: no transform is more exact."""


@dataclass(frozen=True)
class Detectable:
    """The smallest effect of a suspect that would be detected with 90 % power: its first number (of what is each
    trial's own the root of its mean square), what share of the motion it moves, the size from which on it would be told
    from every other suspect (nan: never), and the numbers inside it (a frequency, a time) for which all this holds."""

    name: str
    parameter: str
    value: float
    unit: str
    share_of_motion: float
    named_value: float = math.nan
    at: Mapping[str, float] = field(default_factory=dict)


def detectable(
    stack: Stack, scored: Sequence[Scored], own: Sequence[Scored], most: Scored, threshold: float, allowed: float
) -> Detectable | None:
    """A suspect's smallest effect that would be detected; None where there is none. ``own`` are its places among all
    that are ``scored``, ``most`` the one that gains most, ``threshold`` the gain from which on it is detected, and
    ``allowed`` the free-run error of one unit of size."""
    best, along, size = (_smallest_whole if most.place.whole else _smallest)(own, most, threshold)
    place = best.place
    if not place.additions or math.isnan(size):
        return None
    size /= 1.0 if place.whole else math.sqrt(_not_slow(stack, place, along))
    first = _first(place)
    share = float(best.measure.of_free_run(size * along[:, None])[0]) * allowed
    named = max(size, _told_apart(stack, scored, best, along))
    value = first.start if place.whole else size * _first_number(place, along)
    told = math.isfinite(named) and not (place.whole and named > size)
    told_from = value / size * named if told else math.nan
    inside = {a.name: a.start for a in place.additions if a.inner}
    return Detectable(place.label.partition(" (")[0], first.name, value, first.unit, share, told_from, inside)


def _smallest(own: Sequence[Scored], best: Scored, threshold: float) -> tuple[Scored, Array, float]:
    """A suspect's best place, the direction of its effect there (what is each trial's own: as large in all of them) and
    the smallest size that would be detected; nan where none would be."""
    of_trials = any(a.scope == "trial" for a in best.place.additions if not a.inner)
    along = best.step if np.any(best.step) and not of_trials else np.ones(best.place.width)
    along = along / np.max(np.abs(along), initial=1e-300)
    square = 0.5 * float(along @ best.information @ along)
    seen = _seen(best, along, threshold)
    if not square > 0.0:
        return best, along, math.nan
    low, high = 0.0, math.sqrt(max(2.0 * threshold, 0.0) / square) or 1.0
    for _ in range(HALVINGS):
        if seen(high):
            break
        low, high = high, 2.0 * high
    else:
        return best, along, math.nan
    for middle in (0.5 * (low + high) for _ in range(HALVINGS)):
        low, high = (low, middle) if seen(middle) else (middle, high)
    return best, along, high


def _not_slow(stack: Stack, place: GridPlace, along: Array) -> float:
    """Share of what an effect leaves, everything that stands moving along, that is no slower than a sensor that wanders
    may be: such a sensor would show the rest as well."""
    moved = -stack.stands.inverse @ (place.cross @ along)
    solution = stack.stands.fit.solution
    every = zip(place.columns, solution.jacobians, solution.used, strict=True)
    left = [columns @ along[where] + jac @ moved[used] for (columns, where), jac, used in every]
    return max(not_slow(solution, left), LEAST_NOT_SLOW)


def _smallest_whole(own: Sequence[Scored], best: Scored, threshold: float) -> tuple[Scored, Array, float]:
    """The same of a law that is there or not: the place of the smallest effect that would be detected; size nan where
    none would be."""
    able = [s for s in own if _seen(s, np.ones(1), threshold)(1.0)]
    place = min(able, key=lambda s: float(s.information[0, 0]), default=best)
    return place, np.ones(1), 1.0 if able else math.nan


def _seen(scored: Scored, along: Array, threshold: float) -> Callable[[float], bool]:
    """Whether an effect so many times ``along`` would be detected with `POWER`."""
    if scored.place.whole:
        there = np.maximum(0.5 * scored.information[0, 0] - scored.draws[0], 0.0)
        return lambda size: float(np.mean(there > threshold)) >= POWER
    push = scored.inverse @ (scored.information @ along)
    across, square = push @ scored.draws, 0.5 * float(along @ scored.information @ push)
    gains = scored.gains
    return lambda size: float(np.mean(gains + size * across + size**2 * square > threshold)) >= POWER


def _first(place: GridPlace) -> Addition:
    return next(a for a in place.additions if not a.inner)


def _first_number(place: GridPlace, along: Array) -> float:
    """What a step is in a place's first number: of what is each trial's own the root of its mean square over trials."""
    if _first(place).scope != "trial":
        return 1.0
    sizes = [float(along[where] @ along[where]) for _, where in place.columns if where.size]
    return math.sqrt(sum(sizes) / len(sizes)) if sizes else 1.0


def _told_apart(stack: Stack, scored: Sequence[Scored], best: Scored, along: Array) -> float:
    """The amplitude along a direction from which on its evidence exceeds every other suspect's by `NAMED`; inf where
    another takes all of it."""
    name = best.place.label.partition(" (")[0]
    push = stack.information[:, best.at] @ along
    mine = 0.5 * float(along @ best.information @ along)
    others = 0.0
    for other in scored:
        if other.place.label.partition(" (")[0] != name:
            others = max(others, 0.5 * float(push[other.at] @ other.inverse @ push[other.at]))
    margin = mine - others
    return math.sqrt(NAMED / margin) if margin > 1e-9 * mine else math.inf
