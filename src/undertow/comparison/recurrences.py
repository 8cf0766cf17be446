"""Errors of a memory that recurs: half a period later, turned, an echo in a slow decay looks much alike.

What a fit says of its delay's error holds about one of these ends. Where others are nearly as probable the delay may be
any of theirs, and the gain of either sign: their spread belongs to the errors.

Belongs here: that spread. Does not belong here: which end is closest (attempt.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from undertow.comparison.attempt import QUICK_LOOKS, one_look, turned
from undertow.comparison.candidate import RIVAL_ODDS
from undertow.comparison.joint import JointFit, fit_joint
from undertow.comparison.level import Addend, Level
from undertow.comparison.suspect import Suspect
from undertow.errors import IdentificationError
from undertow.likelihood.budget import BudgetError, metered
from undertow.recording.recording import Array


def with_errors_by_recurrences(level: Level, fit: JointFit, suspects: Sequence[Suspect]) -> JointFit:
    """The fit, whose last laws are ``suspects``, with errors that hold every end within odds of `RIVAL_ODDS` to which
    half periods more or less lead: the covariance (unknowns, unknowns) and that of the ends about this one."""
    at = replace(level, shared_water=fit.shared_water)
    own = fit.addends[len(fit.addends) - len(suspects) :]
    ends = [
        end for suspect, addend in zip(suspects, own, strict=True) if suspect.recurs
        for way in (-1.0, 1.0) for end in _ends(at, fit, addend, way)
    ]  # fmt: skip
    if not ends:
        return fit
    odds = np.array([math.exp(0.5 * (fit.criterion - end.criterion)) for end in ends])
    away = np.array([_values(end) - _values(fit) for end in ends])
    spread = np.einsum("k,ki,kj->ij", odds / (1.0 + float(np.sum(odds))), away, away)
    return replace(fit, solution=replace(fit.solution, covariance=fit.solution.covariance + spread))


def _ends(level: Level, fit: JointFit, addend: Addend, way: float) -> Iterator[JointFit]:
    """Ends to which half periods in one direction lead, one after the other, as long as they are probable."""
    half = way * math.pi / level.scales.slowest
    delay = next(f"{addend.prefix}.{a.name}" for a in addend.additions if a.unit == "s")
    last = fit
    while True:
        try:
            with metered(QUICK_LOOKS * one_look(fit)):
                end = fit_joint(level, fit.addends, fit.memory, turned(last, addend, half), fit.misfit, growing=False)
        except (BudgetError, IdentificationError):
            return
        moved = way * (end.values[delay] - last.values[delay])
        if end.criterion - fit.criterion > 2.0 * math.log(RIVAL_ODDS) or moved < 0.5 * abs(half):  # at a bound, or back
            return
        yield end
        last = end


def _values(fit: JointFit) -> Array:
    return np.array([fit.values[name] for name in fit.solution.problem.names])
