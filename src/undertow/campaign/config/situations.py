"""The conditions that occur in a campaign's list of trials, and what a config that names others is told.

Belongs here: conditions with the trials that have them, nearest names. Does not belong here: which keys of a config
name conditions (matching.py).
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from undertow.recording.catalogue import Entry
from undertow.recording.conditions import number, written
from undertow.recording.recording import Condition

SHOWN = 8
"""Names or values in a sentence at most; of more it says how many there are."""

CLOSE = 0.6
"""Likeness (difflib's ratio) from which a text is suggested in place of another."""


@dataclass
class Situation:
    """Conditions that some trials share: the values of the names that were asked for, and who has them."""

    conditions: dict[str, Condition]
    trials: list[str] = field(default_factory=list)

    def at(self, names: Iterable[str]) -> str:
        """The values of some names in words: ``spring long, water_depth_m 2.36``; "all trials" without names."""
        said = ", ".join(f"{name} {written(self.conditions[name])}" for name in names if name in self.conditions)
        return said or "all trials"


def situations(entries: Iterable[Entry], names: Iterable[str]) -> list[Situation]:
    """Every combination of these conditions that occurs, with its trials, in the order of the list.

    >>> entries = [Entry("a", "a.csv", {"level": 2.0, "x0": 0.1}), Entry("b", "b.csv", {"level": 2.0, "x0": 0.2})]
    >>> situations(entries, ["level"])
    [Situation(conditions={'level': 2.0}, trials=['a', 'b'])]
    """
    asked = tuple(dict.fromkeys(names))
    found: dict[tuple[tuple[str, Condition], ...], Situation] = {}
    for entry in entries:
        key = tuple((name, entry.conditions[name]) for name in asked if name in entry.conditions)
        found.setdefault(key, Situation(dict(key))).trials.append(entry.name)
    return list(found.values())


def values_of(here: Iterable[Situation], name: str) -> list[Condition]:
    """The different values of one condition, numbers first, in order."""
    found = {one.conditions[name] for one in here if name in one.conditions}
    return sorted(found, key=lambda value: (isinstance(value, str), value))


def listed(values: Sequence[Condition]) -> str:
    """Values in a row, the first `SHOWN` of them.

    >>> listed([1.63, 2.36]), listed([])
    ('1.63, 2.36', 'none')
    """
    more = f" and {len(values) - SHOWN} more" if len(values) > SHOWN else ""
    return (", ".join(written(value) for value in values[:SHOWN]) or "none") + more


def nearest(asked: Condition, values: Sequence[Condition]) -> str:
    """The end of a sentence that suggests the value nearest to what was asked for; empty where none is near.

    >>> nearest(1.65, [1.63, 2.22]), nearest("2,2", [1.63, 2.22]), nearest("lnog", ["long", "short"])
    ('; did you mean 1.63?', '; did you mean 2.22?', '; did you mean long?')
    """
    wanted = number(asked)
    numbers = [(value, n) for value in values if (n := number(value)) is not None]
    if wanted is not None and numbers:
        return f"; did you mean {written(min(numbers, key=lambda pair: abs(pair[1] - wanted))[0])}?"
    near = difflib.get_close_matches(str(asked), [written(value) for value in values], n=1, cutoff=CLOSE)
    return f"; did you mean {near[0]}?" if near else ""
