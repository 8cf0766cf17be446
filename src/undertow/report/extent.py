"""How much a campaign holds, where a page shows only part of it.

Belongs here: counts. Does not belong here: their words (blocks.py), what is shown (campaign/gathered.py).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from undertow.discrepancy.findings import Findings, GroupFindings
from undertow.recording.recording import Condition

Key = tuple[tuple[str, Condition], ...]


@dataclass(frozen=True)
class Extent:
    """Trials, groups and trials not explained of a whole campaign; ``statuses``: verdict's status -> groups.

    ``sizes`` is each shown group's own number of trials, and of trials not explained.
    """

    trials: int = 0
    groups: int = 0
    missing: int = 0
    statuses: Mapping[str, int] = field(default_factory=dict)
    sizes: Mapping[Key, tuple[int, int]] = field(default_factory=dict)

    def with_groups(self, groups: Iterable[GroupFindings]) -> Extent:
        """The extent with more groups."""
        statuses, sizes = Counter(self.statuses), dict(self.sizes)
        for group in groups:
            statuses[group.verdict.status] += 1
            sizes[key_of(group)] = len(group.trials), sum(t.mismatch.missing for t in group.trials)
        new = [size for key, size in sizes.items() if key not in self.sizes]
        return Extent(
            self.trials + sum(trials for trials, _ in new), self.groups + len(new),
            self.missing + sum(missing for _, missing in new), dict(statuses), sizes,
        )  # fmt: skip

    def of_groups(self, groups: Iterable[GroupFindings]) -> Extent:
        """The same with the sizes of these groups alone."""
        keys = {key_of(group) for group in groups}
        return replace(self, sizes={key: size for key, size in self.sizes.items() if key in keys})

    def size_of(self, group: GroupFindings) -> tuple[int, int]:
        """Trials of a group, and how many of them are not explained."""
        own = len(group.trials), sum(t.mismatch.missing for t in group.trials)
        return self.sizes.get(key_of(group), own)


def key_of(group: GroupFindings) -> Key:
    """A group's conditions as what it is looked up by."""
    return tuple(group.key.items())


def extent_of(findings: Findings) -> Extent:
    """The extent of findings that hold everything."""
    return Extent().with_groups(findings.groups)
