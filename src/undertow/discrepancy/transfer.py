"""Does what one spring's trials say of the water predict another spring's trials?

A law of the water found on one spring alone, with that spring's dry structure, is run for the trials of another spring
in the same water, with the other's dry structure: nothing of them was fitted. Belongs here: those fits and free runs.
Does not belong here: proof on held-out trials of the same group (validation.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from undertow.comparison.joint import JointFit, fit_joint
from undertow.comparison.level import Level, Member
from undertow.conditioning.motion import Motion
from undertow.discrepancy.validation import median_error, score
from undertow.errors import IdentificationError


def from_other_springs(
    level: Level, fit: JointFit, trials: Sequence[Sequence[Motion]]
) -> tuple[Mapping[str, float], ...]:
    """For every member the nrmse of its ``trials`` as each other member alone predicts them, by that member's label.

    The fit's additions and the equation's coefficients are found anew on the other member; nan where it has no fit or
    its motion has no bounds. Nothing where an addition belongs to one spring or one trial (a structure, an instrument),
    or where one spring alone does not tell it.
    """
    shared = all(a.scope == "shared" and not a.told_by_springs for addend in fit.addends for a in addend.additions)
    if len(level.members) < 2 or not shared or any(addend.frees or addend.late for addend in fit.addends):
        return tuple({} for _ in level.members)
    alone = [_alone(level, fit, member) for member in level.members]
    return tuple(
        {
            other.label: _predicted(level, member, found, trials[place])
            for other, found in zip(level.members, alone, strict=True) if other is not member
        }
        for place, member in enumerate(level.members)
    )  # fmt: skip


def _alone(level: Level, fit: JointFit, member: Member) -> JointFit | None:
    """The same model on one member; None where it cannot be fitted."""
    single = replace(level, members=(member,), shared_water=True)
    known = {name.removesuffix(f"@{member.label}"): value for name, value in fit.values.items()}
    try:
        return fit_joint(single, fit.addends, fit.memory, known | fit.values, fit.misfit, growing=False)
    except IdentificationError:
        return None


def _predicted(level: Level, member: Member, found: JointFit | None, trials: Sequence[Motion]) -> float:
    if found is None:
        return float("nan")
    width = member.options.rest_offset_std
    return median_error([score(level, member, found, motion, width) for motion in trials])
