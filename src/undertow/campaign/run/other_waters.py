"""What the other waters of one rig tell of a water: how likely laws are, and what they lack.

Belongs here: which waters are judged once more for that, and what is said of it. Does not belong here: how a water is
judged (discrepancy/judge.py), what it makes of it (comparison/joining.py, comparison/elsewhere.py).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from undertow.comparison.candidate import RIVAL_ODDS
from undertow.comparison.elsewhere import Elsewhere
from undertow.comparison.joining import told_by_other_waters
from undertow.discrepancy.judge import Judged
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import spelled


@dataclass(frozen=True)
class FromOthers:
    """What other waters say of laws, by name, and what they lack; false where it is nothing."""

    told: tuple[tuple[str, float], ...] = ()
    elsewhere: tuple[Elsewhere, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.told or self.elsewhere)


def told_by_others(water: int, said: Sequence[Judged], standing: Collection[str] = ()) -> FromOthers:
    """What the others tell of one of the waters that were judged: how likely laws are, where that changes which are
    likely beside the one that it names; and what they lack, where nobody knows what it lacks, or it is part of that
    (``standing`` are the dry trials' own laws)."""
    judged, others = said[water], [other for i, other in enumerate(said) if i != water]
    evidence = [other.evidence for other in others if other.evidence]
    told = told_by_other_waters(evidence, sorted(judged.evidence)) if evidence else {}
    if not any(_doubtful(verdict, judged.evidence, told) for verdict in judged.verdicts):
        told = {}
    lacks = (found for other in others if (found := _lacking(other, standing)) is not None)
    more = {one.names: one for one in lacks if _may_lack(judged, one, standing)}
    return FromOthers(tuple(sorted(told.items())), tuple(more.values()))


def _lacking(judged: Judged, standing: Collection[str]) -> Elsewhere | None:
    """What one water lacks beside what the dry trials do, where that explains a group and can be told to others."""
    numbers = tuple((name, value) for name, (value, _) in sorted(judged.values.items()) if "[" not in name)
    found = Elsewhere(tuple(addend for addend in judged.addends if addend.prefix not in standing), numbers)
    sure = any(verdict.status == "explained" for verdict in judged.verdicts)
    return found if sure and found.can_be_told else None


def _may_lack(judged: Judged, other: Elsewhere, standing: Collection[str]) -> bool:
    """Whether a water may lack what another does: nobody knows what it lacks, or it is part of that."""
    names = [set(verdict.verdict) - set(standing) for verdict in judged.verdicts]
    unknown = any(verdict.status == "unknown" for verdict in judged.verdicts)
    return unknown or any(own and own < set(other.names) for own in names)


def _doubtful(verdict: Verdict, evidence: Mapping[str, float], told: Mapping[str, float]) -> bool:
    """Whether what other waters say changes which laws are within the odds of rivals of the likeliest, which is the one
    that is named (what else decided its name stands)."""
    named = [name for name in verdict.verdict if name != "unknown"]
    if not told or len(named) != 1 or named[0] != _likeliest(evidence)[0]:
        return False
    return _likeliest(evidence) != _likeliest({name: score + told[name] for name, score in evidence.items()})


def _likeliest(evidence: Mapping[str, float]) -> list[str]:
    """Laws within the odds of rivals of the likeliest, the likeliest first."""
    order = sorted(evidence, key=lambda name: -evidence[name])
    return [name for name in order if evidence[order[0]] - evidence[name] < math.log(RIVAL_ODDS)]


def with_the_reason(judged: Judged, alone: Judged) -> Judged:
    """Verdicts beside other waters; one that says another thing than alone says why."""
    verdicts = []
    for now, before in zip(judged.verdicts, alone.verdicts, strict=True):
        if (now.status, now.verdict, now.alternatives) != (before.status, before.verdict, before.alternatives):
            sets = [" and ".join(names) for names in (before.verdict, *before.alternatives)]
            words = spelled(" or ".join(sets)).replace("unknown", "something unknown")
            found = f"could not tell {words} from each other" if len(sets) > 1 else f"showed {words}"
            text = f"This water alone {found}; the campaign's others help."
            now = replace(now, sentence=f"{now.sentence} {text}")
        verdicts.append(now)
    return replace(judged, verdicts=tuple(verdicts))
