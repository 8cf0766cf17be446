"""Is a trial predicted by a fit that never saw it, where a group is too small to hold one back?

Each trial of such a group is left out in turn; what is named, with all numbers of the equation, is fitted to the
level's other trials, and so is the prescribed equation alone. The law was chosen with the trial, its numbers were not:
that proves less than a trial that was held back, and more than one that was fitted.

Belongs here: those fits and free runs. Does not belong here: trials that were held back (validation.py), another
spring's numbers alone (transfer.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from undertow.comparison.candidate import LevelDiagnosis
from undertow.comparison.joint import JointFit, fit_joint
from undertow.comparison.level import Addend, Level, Member
from undertow.conditioning.motion import Motion
from undertow.discrepancy.case import Case
from undertow.discrepancy.validation import median_error, score
from undertow.errors import IdentificationError

MOST = 2
"""Trials of a group up to which each is left out: from three on one is held back, unless the config asks for none, and
every fold is two fits of the whole level."""


@dataclass(frozen=True)
class LeftOut:
    """Median nrmse of a group's trials, each predicted by fits without it: of the prescribed equation and of what is
    named; nan where trials were held back or are more than `MOST`, or no other trial says its numbers."""

    before: float = math.nan
    after: float = math.nan


def left_out(level: Level, cases: Sequence[Case], diagnosis: LevelDiagnosis) -> tuple[LeftOut, ...]:
    """What each case's trials say of fits without them; nothing where nothing is named, or what is named is of no two
    trials alike (a mass of each its own)."""
    fit = diagnosis.best.fit
    asked = diagnosis.named and not any(a.differs for addend in fit.addends for a in addend.additions)
    return tuple(
        _of_group(level, case.member, diagnosis.null.fit, fit) if asked and not case.held else LeftOut()
        for case in cases
    )


def _of_group(level: Level, member: Member, null: JointFit, fit: JointFit) -> LeftOut:
    """The same of one group; of a lone trial as the level's other springs in its water tell it, beside its dry k."""
    lone = len(member.motions) == 1
    if len(member.motions) > MOST:
        return LeftOut()
    if lone and (len(level.members) == 1 or member.model.fixed is None or _of_its_spring(fit.addends)):
        return LeftOut()
    errors = []
    for motion in member.motions:
        fewer = (replace(m, motions=tuple(o for o in m.motions if o.name != motion.name)) for m in level.members)
        rest = replace(level, members=tuple(m for m in fewer if m.motions))
        bare = replace(rest, standing=())
        before = _missed(replace(bare, shared_water=lone or null.shared_water), member, motion, null, ())
        after = _missed(replace(rest, shared_water=lone or fit.shared_water), member, motion, fit, fit.addends)
        errors.append((before, after))
    found = LeftOut(*(median_error(one) for one in zip(*errors, strict=True)))
    return found if math.isfinite(found.before) and math.isfinite(found.after) else LeftOut()


def _of_its_spring(addends: Sequence[Addend]) -> bool:
    """Whether other springs' trials do not say all of what is named."""
    return any(a.scope == "spring" or a.told_by_springs for addend in addends for a in addend.additions)


def _missed(rest: Level, member: Member, motion: Motion, like: JointFit, addends: Sequence[Addend]) -> float:
    """What a fit of the other trials misses of this one; nan where there is no such fit."""
    try:
        fit = fit_joint(rest, tuple(addends), like.memory, like.values, like.misfit, growing=False)
    except IdentificationError:
        return math.nan
    return score(rest, member, fit, motion, member.options.rest_offset_std)
