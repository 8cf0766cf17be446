"""Why each suspect that was tried alone is not the answer.

Belongs here: those reasons, with their odds. Does not belong here: rivals that the data cannot exclude (naming.py).
"""

from __future__ import annotations

import math

from undertow.comparison.candidate import Candidate, LevelDiagnosis
from undertow.discrepancy.verdict import Rejected


def rejected_of(diagnosis: LevelDiagnosis) -> tuple[Rejected, ...]:
    """Every single suspect that is not the answer, and why."""
    out: dict[str, Rejected] = {}
    best = diagnosis.best
    for candidate in sorted(diagnosis.candidates, key=lambda c: -c.score):
        if len(candidate.suspects) != 1 or candidate.names[0] in best.names or candidate.names in diagnosis.rivals:
            continue
        name = candidate.names[0]
        odds = candidate.score - _said(diagnosis).score
        out.setdefault(name, Rejected(name, candidate.out or _odds(candidate, diagnosis), odds))
    for label in diagnosis.unfinished:
        name = label.partition(" (")[0]
        if name not in best.names:
            out.setdefault(name, Rejected(name, "not tried to the end: it took more than its budget"))
    for screened in diagnosis.screened:
        name = screened.suspect.name
        if name not in best.names:
            because = f"not fitted in full: a first estimate gives odds of at most {_power(screened.gain)} to 1 for it"
            odds = screened.score - _said(diagnosis).score
            out.setdefault(name, Rejected(name, because, odds))
    return tuple(out.values())


def _said(diagnosis: LevelDiagnosis) -> Candidate:
    """What is said: the best set of suspects, or the equation as it is."""
    return diagnosis.best if diagnosis.best.suspects else diagnosis.null


def _odds(candidate: Candidate, diagnosis: LevelDiagnosis) -> str:
    behind = _said(diagnosis).score - candidate.score
    other = " + ".join(_said(diagnosis).names) or "the equation as it is"
    if behind > 0.0:
        return f"odds of {_power(behind)} to 1 against it beside {other}"
    return f"brings the free run closer by less than counts, at odds of {_power(-behind)} to 1 for it"


def _power(log_odds: float) -> str:
    return f"10^{log_odds / math.log(10.0):.0f}" if log_odds > math.log(1e3) else f"{math.exp(log_odds):.0f}"
