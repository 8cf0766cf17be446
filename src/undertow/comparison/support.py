"""How probable what is said is, alone or beside more, and what is left of an answer of which that is too little.

A search adds effects one after the other. Where sets that were excluded for their numbers outweigh the last of them,
what they hold in common with the answer stands: nobody gives up the first effect because nobody knows the second.

Belongs here: that probability and that rest. Does not belong here: the search (search.py), the gates (discrepancy/).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

from undertow.comparison.candidate import Candidate, LevelDiagnosis, probability, rivals_of
from undertow.comparison.suspects import SUSPECTS

MORE_LIKELY = 0.5
"""Probability of a name, alone or beside more, among all that was fitted, excluded or not, above which it is said: of 9
names with less, on campaigns of known truth, 8 were wrong, of 31 with more 3; of descriptions, which leave more than
noise, 3 of 4 and 3 of 21."""


LOOPS = {s.without_sliding: s.name for s in SUSPECTS if s.without_sliding}
"""What bristles are whose loop stands beside sliding friction."""


def alike(names: Iterable[str]) -> Counter[str]:
    """How often each name stands in a set, bristles as the loop that they have.

    >>> alike(["delayed_echo", "presliding"]) == alike(["hysteresis", "delayed_echo"])
    True
    """
    return Counter(LOOPS.get(name, name) for name in names)


@dataclass(frozen=True)
class Support:
    """The probability of an answer or one of its rivals, alone or beside more, and the most probable set without it;
    the probability of exactly these, nothing beside them, and the most probable set of other names."""

    likely: float
    other: Candidate
    exactly: float
    rather: Candidate


def support(diagnosis: LevelDiagnosis) -> Support:
    """How probable the answer is among everything that was fitted, what was excluded for its numbers included.

    A set that holds what is said does not speak against it, nor does one with bristles for hysteresis, whose loop they
    have. What was set aside because the free run hardly shows it is no better answer than one that it shows."""
    said = [alike(names) for names in (diagnosis.best.names, *diagnosis.rivals)]
    names = {tuple(sorted(names)) for names in (diagnosis.best.names, *diagnosis.rivals)}
    considered = [c for c in diagnosis.candidates if not c.aside or tuple(sorted(c.names)) in names]
    sets = {tuple(sorted(c.amounts_to)): c for c in considered}
    holds = {n for n in sets if any(one <= alike(n) for one in said)}

    def of(these: set[tuple[str, ...]]) -> tuple[float, Candidate]:
        """How probable some of the sets are, and the most probable of the others."""
        likely = sum(probability(sets[n], considered, diagnosis.screened, excluded=True) for n in these)
        others = (c for c in considered if tuple(sorted(c.amounts_to)) not in these)
        return likely, max(others, key=lambda c: c.score, default=diagnosis.null)

    return Support(*of(holds), *of({n for n in holds if any(one == alike(n) for one in said)}))


def supported(diagnosis: LevelDiagnosis) -> LevelDiagnosis:
    """The diagnosis without the last effects of its answer where those are outweighed and what is left of it is not;
    itself where all is outweighed, or nothing."""
    shorter = diagnosis
    while len(shorter.best.suspects) > 1 and support(shorter).likely < MORE_LIKELY:
        before = shorter.best.suspects[:-1]
        best = next((c for c in diagnosis.candidates if c.suspects == before and not c.out), None)
        if best is None:
            return diagnosis
        sure = probability(best, diagnosis.candidates, diagnosis.screened)
        rivals = rivals_of(best, diagnosis.candidates)
        shorter = replace(diagnosis, best=best, rivals=rivals, confidence=sure)
    return shorter if support(shorter).likely >= MORE_LIKELY else diagnosis
