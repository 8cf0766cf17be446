"""What a run keeps of its portions: all of it, or of a large campaign what its page shows, and counts of the rest.

Belongs here: what is kept, and the sentences over all groups. Does not belong here: the work (course.py), tables and
page (report/).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

from undertow.campaign.config import RunConfig
from undertow.campaign.run.portions import group_order
from undertow.discrepancy.drifts import group_drifts, springs_apart
from undertow.discrepancy.findings import FailedTrial, Findings, GroupFindings
from undertow.discrepancy.words import count, either, group_title, least_sets, spelled
from undertow.report.arrange import chosen, excess
from undertow.report.extent import Extent
from undertow.report.tables import NOTES_AT_MOST

GROUPS_SHOWN = 32
"""Groups that a page shows one by one: with its figures each takes 0.3 MB, and 30 MB do not open."""

TRIALS_SHOWN = 60
"""Trials of a group that a page lists: the ends, and those that repetitions explain least."""

DOUBTS_AT_MOST = 100
"""Doubts about the recordings that a page lists; trials' own stand in the notes."""

TITLES_SAID = 3
"""Groups without a result that the sentence over all groups names."""

COMPARED_AT_MOST = 200
"""Groups whose numbers are compared pair by pair: of 200 there are 19,900 pairs."""


@dataclass(frozen=True)
class PortionFindings:
    """What one portion of a campaign gave: groups in order, trials that could not be used, notes, doubts; ``as_fitted``
    are the groups before errors grew where groups differ (empty: the same)."""

    groups: tuple[GroupFindings, ...]
    failed: tuple[FailedTrial, ...]
    notes: tuple[str, ...]
    doubts: tuple[str, ...] = ()
    as_fitted: tuple[GroupFindings, ...] = ()


class Gathered:
    """A campaign's findings as its parts come.

    With ``everything`` all of them are kept; else at most `GROUPS_SHOWN` groups (dry ones up to half of them, and those
    that are explained least) of at most `TRIALS_SHOWN` trials, and ``extent`` counts the others. ``contradicted`` are
    the sentences of groups whose channels contradict each other.
    """

    def __init__(self, config: RunConfig, everything: bool = False) -> None:
        self._config, self._everything = config, everything
        self._groups: list[GroupFindings] = []
        self._compared: list[GroupFindings] = []
        self._failed: list[FailedTrial] = []
        self._notes: list[str] = []
        self._notes_more = 0
        self._doubts: list[str] = []
        self._doubts_more = 0
        self._named: Counter[str] = Counter()
        self._sensed: Counter[str] = Counter()
        self._titles: set[str] = set()
        self.contradicted: list[str] = []
        self.extent = Extent()

    def add(self, part: PortionFindings) -> None:
        """One more part; nothing else of it is held afterwards."""
        self._failed += part.failed
        self.contradicted += [g.verdict.sentence for g in part.groups if g.verdict.contradicted]
        room = len(part.notes) if self._everything else max(NOTES_AT_MOST - len(self._notes), 0)
        self._notes += part.notes[:room]
        self._notes_more += max(len(part.notes) - room, 0)
        room = max(DOUBTS_AT_MOST - len(self._doubts), 0)
        self._doubts += part.doubts[:room]
        self._doubts_more += max(len(part.doubts) - room, 0)
        self.extent = self.extent.with_groups(part.groups)
        for group, fitted in zip(part.groups, part.as_fitted or part.groups, strict=True):
            (self._sensed if group.verdict.origin == "instrument" else self._named).update(_names(group))
            self._titles.add(group_title(group.key))
            if len(self._compared) <= COMPARED_AT_MOST:
                self._compared.append(replace(fitted, trials=()))
            self._groups.append(group if self._everything else fewer_trials(group))
        if not self._everything:
            self._groups = fewer_groups(self._groups)
            self.extent = self.extent.of_groups(self._groups)

    def findings(self, seconds: Mapping[str, float]) -> Findings:
        """What is kept, groups in order, with the sentences over all groups; ``seconds`` is the wall time a stage."""
        config = self._config
        groups = sorted(self._groups, key=lambda g: group_order(g.key.items(), g.dry))
        return Findings(
            config.name, tuple(groups), tuple(self._failed), tuple(config.identify), config.equation.coordinate,
            dict(seconds),
            across(self._named, self.extent.statuses, self._sensed) + self._springs_apart() + self._left_out(),
            (*self._notes, *self._further_notes()),
            (*self._doubts, *([f"{count(self._doubts_more, 'more doubt')}"] if self._doubts_more else ())),
        )  # fmt: skip

    def _springs_apart(self) -> str:
        """That springs disagree where nothing is missing else, behind the sentence over all groups."""
        few = len(self._compared) <= COMPARED_AT_MOST
        return springs_apart(self._compared, self._config.trials.dry or {}) if few else ""

    def _left_out(self) -> str:
        """How many trials failed, and which groups have no result for it, behind the sentence over all groups."""
        if not self._failed:
            return ""
        by = self._config.trials.group_by
        keys = ({name: one.conditions[name] for name in by if name in one.conditions} for one in self._failed)
        titles = dict.fromkeys(group_title(key) for key in keys if len(key) == len(by))
        without = [title for title in titles if title not in self._titles]
        text = f" {count(len(self._failed), 'trial')} failed"
        if without:
            more = ", ..." if len(without) > TITLES_SAID else ""
            text += f", and {count(len(without), 'group')} {'has' if len(without) == 1 else 'have'} no result: "
            text += "; ".join(without[:TITLES_SAID]) + more
        return f"{text}."

    def _further_notes(self) -> tuple[str, ...]:
        """Notes that are left out, and parameters that differ from group to group where they should not."""
        notes = (f"{self._notes_more} more notes stand in notes.txt",) if self._notes_more else ()
        if len(self._compared) > COMPARED_AT_MOST:
            return (
                *notes,
                f"parameters that drift from group to group were not looked for: {self.extent.groups} groups are more "
                f"than the {COMPARED_AT_MOST} that are compared pair by pair",
            )
        ordered = sorted(self._compared, key=lambda g: group_order(g.key.items(), g.dry))
        return (*notes, *(d.sentence for d in group_drifts(ordered, self._config.trials.dry or {})))


def _names(group: GroupFindings) -> list[str]:
    """What a group's verdict names, in words, each once; names that are not certain stand together."""
    verdict = group.verdict
    if verdict.status == "not_identifiable":
        return [either([" and ".join(_words(n)) for n in least_sets((verdict.verdict, *verdict.alternatives))])]
    if verdict.status == "unknown" and (named := _words(n for n in verdict.verdict if n != "unknown")):
        return [f"something unknown beside or instead of {' and '.join(named)}"]
    return _words(verdict.verdict if verdict.status != "present_but_small" else ())


def _words(names: Iterable[str]) -> list[str]:
    return ["something unknown" if name == "unknown" else spelled(name) for name in dict.fromkeys(names)]


def across(
    named: Mapping[str, int], statuses: Mapping[str, int], sensed: Mapping[str, int] = MappingProxyType({})
) -> str:
    """One sentence over all groups, from how many name what (``sensed``: a fault of a sensor), and how many have which
    status.

    >>> across({"drag": 2}, {"explained": 2, "cannot_tell": 1})
    'The equation leaves out: drag in 2 of 3 groups. For 1 group these data cannot tell whether anything is missing.'
    >>> across({}, {"nothing_missing": 2})
    'The equation explains 2 groups; nothing is missing.'
    >>> across({"quadratic drag": 1}, {"explained": 1})
    'The equation leaves out: quadratic drag.'
    >>> across({}, {"explained": 2}, {"clipping": 2})
    'Not the motion but a sensor shows: clipping in 2 of 2 groups.'
    """
    groups = sum(statuses.values())
    of, parts = count(groups, "group"), []
    for words, names in (("The equation leaves out", named), ("Not the motion but a sensor shows", sensed)):
        said = "; ".join(f"{name} in {number} of {of}" if groups > 1 else name for name, number in names.items())
        parts += [f"{words}: {said}."] if said else []
    if statuses.get("nothing_missing", 0) == groups:
        parts.append(f"The equation explains {of}; nothing is missing.")
    elif fine := statuses.get("nothing_missing", 0):
        parts.append(f"In {count(fine, 'group')} nothing is missing.")
    if small := statuses.get("present_but_small", 0):
        parts.append(f"In {count(small, 'group')} something is there that is smaller than repetitions differ.")
    if open_ := statuses.get("cannot_tell", 0):
        parts.append(f"For {count(open_, 'group')} these data cannot tell whether anything is missing.")
    return " ".join(parts)


def fewer_trials(group: GroupFindings) -> GroupFindings:
    """The group with at most `TRIALS_SHOWN` of its trials."""
    kept = chosen(group.trials, TRIALS_SHOWN)
    return group if len(kept) == len(group.trials) else replace(group, trials=kept)


def fewer_groups(groups: Sequence[GroupFindings]) -> list[GroupFindings]:
    """At most `GROUPS_SHOWN` groups: dry ones (up to half), then those explained least, in the order they came."""
    if len(groups) <= GROUPS_SHOWN:
        return list(groups)
    ranked = sorted(range(len(groups)), key=lambda i: _loudness(groups[i]), reverse=True)
    dry = [i for i in ranked if groups[i].dry][: GROUPS_SHOWN // 2]
    wet = [i for i in ranked if not groups[i].dry][: GROUPS_SHOWN - len(dry)]
    return [groups[i] for i in sorted((*dry, *wet))]


def _loudness(group: GroupFindings) -> tuple[bool, float]:
    """How much a group asks to be seen: something is missing, and how far its worst trial is from a repetition."""
    far = [e for t in group.trials if math.isfinite(e := excess(t))]
    return group.verdict.status != "nothing_missing", max(far, default=0.0)
