"""What the other waters of one rig tell of a water: how likely laws are.

Belongs here: which waters are judged once more for that, and what is said of it. Does not belong here: how a water is
judged (discrepancy/judge.py), what it makes of it (comparison/joining.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from undertow.comparison.candidate import RIVAL_ODDS
from undertow.comparison.joining import told_by_other_waters
from undertow.discrepancy.judge import Judged
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import spelled


def told_by_others(water: int, said: Sequence[Judged]) -> tuple[tuple[str, float], ...]:
    """What the others tell of one of the waters that were judged: by name how likely laws are, where that changes
    which are likely beside the one that it names; nothing elsewhere."""
    judged, others = said[water], [other.evidence for i, other in enumerate(said) if i != water]
    evidence = [one for one in others if one]
    told = told_by_other_waters(evidence, sorted(judged.evidence)) if evidence else {}
    if not any(_doubtful(verdict, judged.evidence, told) for verdict in judged.verdicts):
        return ()
    return tuple(sorted(told.items()))


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
