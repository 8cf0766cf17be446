"""The prescribed equation alone on a level: its fit, again from where a suspect left it, at sizes of its own.

Belongs here: fits without a suspect. Does not belong here: fits of suspects (attempt.py), which are tried (search.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from undertow.comparison.candidate import Candidate
from undertow.comparison.joint import JointFit, fit_joint, fit_standing, shared_theta
from undertow.comparison.level import Level, Member
from undertow.equation.kernel import SLOT
from undertow.errors import IdentificationError
from undertow.likelihood.noise import residual_memory

ENDED_SHORT = 2.0
"""A fit whose criterion another start betters by more (a unit of log evidence) had ended short of its optimum."""

HARDLY = 10.0
"""An answer ahead of the equation by so many times what a better start gained it would be found again."""

FURTHER = 2
"""So often at most a level is searched again from a better optimum of the equation."""

SETTLING = 3
"""Fits after which sizes are taken as they are."""

LARGER = 1.1
"""A size that a fit finds is taken over where it is larger by this factor."""


def plain_fit(level: Level) -> JointFit:
    """The prescribed equation alone: one water for all springs, or each spring's own added mass and drag, whichever the
    data prefer. A suspect has to beat both.

    Raises IdentificationError where it has no motion.
    """
    together = fit_standing(level)
    if len(level.members) < 2:
        return together
    try:
        alone = replace(level, shared_water=False)
        apart = fit_joint(alone, level.standing, together.memory, {}, together.misfit, growing=True)
    except IdentificationError:
        return together
    return min((together, apart), key=lambda f: f.criterion)


def further_on(level: Level, null: Candidate, tried: Sequence[Candidate], best: Candidate) -> Candidate | None:
    """The prescribed equation from where the closest excluded suspect left it, or a bad release that leaves out the
    first swings, if it had ended short of that optimum; else None. A suspect that comes out at nothing may still have
    led out of a bad place, and so may fewer swings: friction, a dashpot and drag of a single decay trade places, and
    what is nearer by that alone would pass for something missing."""
    seen = null.fit.solution.n_data
    able = [c for c in tried if len(c.suspects) == 1 and ((c.out and c.fit.solution.n_data == seen) or _is_late(c))]
    closest = min(able, key=lambda c: c.fit.misfit, default=null)
    if closest.score <= null.score:
        return None
    level, fit = replace(level, shared_water=null.fit.shared_water), null.fit
    try:
        went = fit_joint(level, fit.addends, fit.memory, closest.fit.values, closest.fit.misfit, growing=False)
        gained = fit.criterion - went.criterion
        if gained < ENDED_SHORT or best.score - null.score > HARDLY * gained / 2.0:
            return None
        memory = residual_memory(went.solution)
        return replace(null, fit=fit_joint(level, fit.addends, memory, went.values, went.misfit, growing=False))
    except IdentificationError:
        return None


def _is_late(candidate: Candidate) -> bool:
    """Whether a candidate says that trials follow the equation from later on alone."""
    return any(suspect.late for suspect in candidate.suspects)


def at_its_own_sizes(level: Level) -> Level:
    """The level with trials that differ by a share of what its own fit finds, where that is more than was known before:
    a dashpot and a drag that nothing told apart trade places once trials may differ."""
    for _ in range(SETTLING):
        if not any(len(m.motions) > 1 and any(m.spread.values()) for m in level.members):
            return level
        try:
            fit = plain_fit(level)
        except IdentificationError:
            return level
        members = tuple(_resized(level, m, fit) for m in level.members)
        if members == level.members:
            return level
        level = replace(level, members=members)
    return level


def _resized(level: Level, member: Member, fit: JointFit) -> Member:
    """A group with the sizes of k, c, mu that a fit finds where they are surely larger."""
    theta = shared_theta(level, member, fit, member.motions[0].name)
    found = {slot: abs(float(theta[SLOT[slot]])) for slot in member.sizes}
    if all(found[slot] <= LARGER * size for slot, size in member.sizes.items()):
        return member
    return replace(member, sizes={slot: max(size, found[slot]) for slot, size in member.sizes.items()})
