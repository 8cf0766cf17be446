"""Which suspects may be tried on a level, alone or beside what stands, and what is believed of them beforehand.

Belongs here: room for a suspect, and priors. Does not belong here: the search (search.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from undertow.comparison.candidate import Candidate
from undertow.comparison.joint import JointFit
from undertow.comparison.level import Level, Member
from undertow.comparison.suspect import EACH_SPRING, Suspect
from undertow.equation.kernel import SLOT

PRIOR_NOTHING = 0.5
"""Prior probability that the prescribed equation lacks nothing."""

FURTHER_EFFECT_PRIOR = 0.01
"""Prior odds of a second (third) effect beside one that is there."""

MOST_EFFECTS = 3
"""Effects named on one level, and hidden oscillators in one equation, at most."""

SPRINGS = 3
"""Springs that tell a stiffness of the water from an added mass of each spring's own, at least."""

LAWS_DIFFER = 0.01
"""Prior probability that what one water of a rig lacks is another law than what another water does."""

STRUCTURE_WHEN_DRY_IS_CLEAN = 0.01
"""Prior odds of a structural effect where dry trials of the same rig show nothing missing."""


def has_room(level: Level, suspect: Suspect, fit: JointFit) -> bool:
    """Whether a suspect differs from what is free anyway: a coefficient that every group fits is no suspect,
    nor a sensor that is not recorded."""
    if len(level.members) == 1 and suspect.variant == EACH_SPRING:
        return False
    if suspect.name in {addend.prefix for addend in level.standing}:
        return False
    if suspect.at_the_beginning:
        return any(m.window.held for member in level.members for m in member.motions)
    if suspect.frees:
        return any(name.startswith(f"{suspect.frees}[") for name in fit.solution.problem.names)
    additions = suspect.additions(level.scales, suspect.starts(level.scales)[0])
    if any(a.slot == "mass" for a in additions) and not all(m.model.anchored for m in level.members):
        return False  # nothing gives kilograms: an added mass is the scale of all other numbers
    if any(a.slot == "mass" and a.scope != "trial" for a in additions) and all(_weighs(m, fit) for m in level.members):
        return False  # the same where kilograms come from the mass alone
    if any(a.scope == "trial" for a in additions) and level.trials < 2 and suspect.origin != "outside":
        return False  # an outside force of one trial may be a tone that nothing else is (clock.py)
    differing = any(a.slot == "mass" and a.scope == "trial" for a in additions)
    if differing and all(m.tells_its_scatter for m in level.members):
        return False  # a decay knows k / M alone: what k scatters by is seen in these very trials
    if any(a.told_by_springs for a in additions) and sum(m.model.fixed is not None for m in level.members) < SPRINGS:
        return False  # each spring may have an added mass of its own
    moved = {SLOT[a.moves[0]] for a in additions if a.moves is not None}
    if any(not fit.theta(trial)[slot] for slot in moved for trial in range(len(fit.solution.problem.trials))):
        return False  # nothing is there that could stand elsewhere
    slots = {a.slot for a in additions if a.scope != "trial"}
    free = [{c.slot for c in m.model.coefficients} for m in level.members]
    return not slots or not all(slots <= own for own in free)


def _weighs(member: Member, fit: JointFit) -> bool:
    """Whether a group's kilograms come from the stated mass alone: k is what these decays say of it, in units of that
    mass, and no load cell says it in newtons."""
    if member.model.weighed:
        return True
    weighed_by_loads = any(c.quantity == "spring_force" for t in fit.solution.problem.trials for c in t.channels)
    return member.own_means and not math.isfinite(member.model.specimen.stiffness_N_per_m) and not weighed_by_loads


def may_join(best: Candidate, suspect: Suspect) -> bool:
    """Whether a suspect can be added: once each, memories up to three, one variant of a name."""
    memories = sum(a.slot.startswith("hm") for d in best.fit.addends for a in d.additions)
    if suspect.late and any(s.origin == "water" for s in best.suspects):
        return False  # a start of its own in every trial takes up what a memory leaves beside the damping it looks like
    if suspect.swings:
        return not best.suspects or (not suspect.variant and memories < MOST_EFFECTS)
    return suspect.name not in best.names


def may_pair(one: Suspect, other: Suspect) -> bool:
    """Whether two suspects may be tried at once: of one name only what swings by itself."""
    return one.name != other.name or one.swings


def told_by_other_waters(evidence: Sequence[Mapping[str, float]], names: Sequence[str]) -> dict[str, float]:
    """By how much the log prior of each of these laws rises with what other waters of one rig say: which law is missing
    is the same in all of them but for a share `LAWS_DIFFER`. ``evidence`` are their log posteriors by name.

    >>> told = told_by_other_waters([{"cubic_damping": 8.0, "relaxation": 0.0}], ("cubic_damping", "relaxation"))
    >>> {name: round(by, 2) for name, by in told.items()}
    {'cubic_damping': 0.69, 'relaxation': -4.54}
    """
    told = dict.fromkeys(names, 0.0)
    for one in evidence:
        most = max(one.values())
        weights = {name: math.exp(score - most) for name, score in one.items()}
        for name in told:
            share = weights.get(name, 0.0) / sum(weights.values())
            told[name] += math.log((1.0 - LAWS_DIFFER) * share * len(names) + LAWS_DIFFER)
    return told


def log_prior(suspects: Sequence[Suspect], count: int, clean_when_dry: bool) -> float:
    """Log prior of a set of suspects out of ``count``."""
    rare = STRUCTURE_WHEN_DRY_IS_CLEAN if clean_when_dry else 1.0
    each = sum(math.log((rare if s.origin == "structure" else 1.0) / count) for s in suspects)
    return math.log(1.0 - PRIOR_NOTHING) + (len(suspects) - 1) * math.log(FURTHER_EFFECT_PRIOR) + each
