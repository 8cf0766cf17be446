"""Whether the dry trials of the same spring bear out a law of the structure that is named in water.

A spring that hardens, a rail that rubs unevenly: what belongs to the structure is there without water too. Beside the
dry equation one linear step tells how large such a law is there; far less of it than in water says that something of
the water looks like it.

Belongs here: that comparison. Does not belong here: what becomes of the verdict (earned.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from undertow.comparison.candidate import LevelDiagnosis
from undertow.comparison.joint import JointFit, fit_standing
from undertow.comparison.level import Addend, full_name, make_level
from undertow.comparison.score_test import Stands, linear_estimate
from undertow.discrepancy.case import Case
from undertow.discrepancy.words import spelled
from undertow.errors import IdentificationError
from undertow.quantities import Estimate

CERTAIN = 4.0
"""Standard errors between what dry and wet trials say of a law's size, from which they contradict each other."""

LESS = 0.5
"""Share of the law's size in water below which its size in air must lie: structures differ a little from day to day."""


@dataclass(frozen=True)
class DryAnswer:
    """How many standard errors the dry trials' size of a law lies from what water asks for, and that in words (empty:
    no contradiction)."""

    away: float = 0.0
    because: str = ""


def dry_answer(diagnosis: LevelDiagnosis, likely: str, dry: Sequence[Case]) -> DryAnswer:
    """The strongest contradiction between what is named on a wet level, or else would be named as small (``likely``: by
    its null), and its springs' dry trials, to whose equation nothing was added."""
    small = diagnosis.small or next((c for c in diagnosis.candidates if c.names == (likely,)), None)
    candidate = diagnosis.best if diagnosis.named or small is None else small
    fit = candidate.fit
    named = fit.addends[len(fit.addends) - len(candidate.suspects) :]
    asked = [
        addend for suspect, addend in zip(candidate.suspects, named, strict=True)
        if suspect.origin == "structure" and not suspect.frees and not suspect.is_scatter
        and all(a.scope != "trial" and a.moves is None for a in addend.additions)
    ]  # fmt: skip
    found = [one for addend in asked for case in dry if (one := _compared(fit, addend, case)).because]
    return max(found, key=lambda one: one.away, default=DryAnswer())


def _compared(fit: JointFit, addend: Addend, case: Case) -> DryAnswer:
    """One law against one spring's dry trials."""
    first = next(a for a in addend.additions if not a.inner)
    name = full_name(addend.prefix, first, case.member.label, "")
    if name not in fit.values:
        return DryAnswer()
    wet, unit = Estimate(fit.value(name), fit.solution.stderr(name)), case.member.model.unit(first.unit)
    at = tuple(
        replace(a, start=fit.values.get(full_name(addend.prefix, a, case.member.label, ""), a.start))
        for a in addend.additions
    )
    level = make_level([case.member])
    try:
        there = linear_estimate(level, Stands.of(fit_standing(level)), at)
    except IdentificationError:
        return DryAnswer()
    if there is None or not there[1] > 0.0:
        return DryAnswer()
    air = Estimate(there[0], there[1])
    away = abs(wet.value - air.value) / math.hypot(wet.stderr, air.stderr)
    if not away > CERTAIN or air.value * math.copysign(1.0, wet.value) >= LESS * abs(wet.value):
        return DryAnswer()
    said = spelled(addend.prefix.partition("#")[0])
    air, wet = replace(air, unit=unit), replace(wet, unit=unit)
    return DryAnswer(away, f"the dry trials of the same spring show {said} of {air}, where water asks for {wet}")
