"""What another water of the same rig lacks, tried on a level from the numbers that it has there.

Two strong laws can mask each other so that neither, nor both from starts of their own, are found; where another water
showed them a fit may begin beside the answer. It is judged as any other set is.

Belongs here: such a set and its fit. Does not belong here: which waters tell which (campaign/run/judgement.py), what is
believed of it (search.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.comparison.attempt import PAIR_BUDGET, one_look
from undertow.comparison.candidate import RIVAL_ODDS, Candidate, doubt
from undertow.comparison.joining import has_room
from undertow.comparison.joint import JointFit, fit_joint
from undertow.comparison.level import Addend, Level
from undertow.comparison.prescribed import plain_fit
from undertow.comparison.suspect import Suspect
from undertow.errors import IdentificationError
from undertow.likelihood.budget import BudgetError, metered
from undertow.likelihood.noise import residual_memory


@dataclass(frozen=True)
class Elsewhere:
    """What was added to another water's equation, and the numbers that it has there, by the names of unknowns."""

    addends: tuple[Addend, ...]
    values: tuple[tuple[str, float], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the set."""
        return tuple(addend.prefix.partition("#")[0] for addend in self.addends)

    @property
    def can_be_told(self) -> bool:
        """Whether another water's trials can begin there: not with what a sensor or a release had in these trials."""
        return bool(self.addends) and not any(addend.frees or addend.late for addend in self.addends)

    def beginning(self) -> tuple[Addend, ...]:
        """The addends that begin at their numbers there; each spring's own, or the mean where a spring is another, and
        what is each trial's own where it began there."""
        return tuple(
            replace(d, additions=tuple(
                replace(a, start=self._number(f"{d.prefix}.{a.name}", a.start)) for a in d.additions
            )) for d in self.addends
        )  # fmt: skip

    def _number(self, name: str, otherwise: float) -> float:
        found = [value for key, value in self.values if key.partition("@")[0] == name]
        return float(np.mean(found)) if found else otherwise


def from_elsewhere(
    level: Level, null: Candidate, suspects: Sequence[Suspect], other: Elsewhere, budget: float
) -> Candidate | None:
    """The equation with what another water lacks, from its numbers there and with a log prior of 0; None where this
    level does not try one of its laws, no motion comes of them, or it takes more than its budget."""
    mine = [_like(addend, suspects, level) for addend in other.addends]
    if None in mine:
        return None
    level = replace(level, shared_water=null.fit.shared_water)
    addends, known, fits = (*null.fit.addends, *other.beginning()), null.fit.values | dict(other.values), []
    with metered(budget):
        for growing in (False, True):
            try:
                fits.append(fit_joint(level, addends, null.fit.memory, known, null.fit.misfit, growing, quick=True))
            except (IdentificationError, BudgetError):
                continue
        ahead = min(fits, key=lambda fit: fit.criterion, default=None)
        fit = None if ahead is None else _to_the_end(level, ahead)
    return None if fit is None else Candidate(tuple(s for s in mine if s), fit, 0.0, doubt(level, fit, null.fit))


def that_come_closer(
    level: Level, suspects: Sequence[Suspect], others: Sequence[Elsewhere], misfit: float, budget: float = 1.0
) -> tuple[Elsewhere, ...]:
    """Those of what other waters lack that may be more probable, by odds that have a name, than what was found to leave
    ``misfit``: by what their residuals, at their own memory, show of the difference, whatever their numbers cost."""
    null, found = Candidate((), plain_fit(level), 0.0), []
    usable, spent = [s for s in suspects if has_room(level, s, null.fit)], budget * PAIR_BUDGET * one_look(null.fit)
    for other in others:
        one = from_elsewhere(level, null, usable, other, spent)
        if one is not None and not one.out:
            independent = one.fit.solution.n_data / residual_memory(one.fit.solution)
            if 0.5 * independent * math.log(misfit / one.fit.misfit) > math.log(RIVAL_ODDS):
                found.append(other)
    return tuple(found)


def _to_the_end(level: Level, fit: JointFit) -> JointFit | None:
    """The same fit until its noise is its own."""
    try:
        return fit_joint(level, fit.addends, fit.memory, fit.values, fit.misfit, growing=False)
    except (IdentificationError, BudgetError):
        return None


def _like(addend: Addend, suspects: Sequence[Suspect], level: Level) -> Suspect | None:
    """The suspect of an addend: of its name, and if there is one with the same unknowns."""
    named = [s for s in suspects if s.name == addend.prefix.partition("#")[0]]
    names = [a.name for a in addend.additions]
    alike = [s for s in named if [a.name for a in s.additions(level.scales, s.starts(level.scales)[0])] == names]
    return next(iter((*alike, *named)), None)
