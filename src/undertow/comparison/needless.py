"""Whether a set of effects needs all of them: of two effects the first is chosen before the second is known.

Belongs here: the same set without one of its effects, and which of those stands. Does not belong here: when that is
asked (search.py), the fit (joint.py).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from undertow.comparison.candidate import Candidate, doubt
from undertow.comparison.explained import swings
from undertow.comparison.joint import JointFit, fit_joint, free_run_error
from undertow.comparison.level import Addend, Level
from undertow.comparison.suspect import Suspect
from undertow.errors import IdentificationError


def shorter_sets(
    level: Level, null: JointFit, candidate: Candidate, prior: Callable[[Sequence[Suspect]], float]
) -> list[tuple[Candidate, float]]:
    """The candidate refitted without each of its earlier effects in turn, with the free run's error; of a set that is
    excluded also without the last, which may only have led the others out of a bad place, and so on of what is more
    probable then, and still excluded.

    ``prior`` gives the log prior of a set, ``null`` is the prescribed equation as fitted.
    """
    found = []
    for place in range(len(candidate.suspects) - (not candidate.out)):
        others = (*candidate.suspects[:place], *candidate.suspects[place + 1 :])
        shorter = without(level, null, candidate, place, prior(others))
        if shorter is not None:
            found.append((shorter, free_run_error(level, shorter.fit)))
            if shorter.out and len(others) > 1 and shorter.score > candidate.score:
                found += shorter_sets(level, null, shorter, prior)
    return found


def leanest(
    shorter: Sequence[tuple[Candidate, float]], error: float, least: float
) -> tuple[Candidate, float] | None:
    """The most probable of the sets whose numbers mean something, whose score exceeds ``least`` and whose free run
    comes as close as ``error`` or as repetitions; None where all effects are needed."""
    near = max(error, 1.0)
    able = [pair for pair in shorter if not pair[0].out and pair[0].score > least and pair[1] <= near]
    return max(able, key=lambda pair: pair[0].score, default=None)


def without(level: Level, null: JointFit, candidate: Candidate, place: int, prior: float) -> Candidate | None:
    """The same model without the effect at ``place``, refitted from where the others are; None where that gives no
    motion. Its numbers are judged beside what stood before: of one effect alone the prescribed equation, ``null``."""
    fit = candidate.fit
    kept = [i for i in range(len(candidate.suspects)) if i != place]
    own = fit.addends[len(level.standing) :]
    level = replace(level, shared_water=fit.shared_water)
    addends = closed_up((*level.standing, *(own[i] for i in kept)))
    try:
        fit = fit_joint(level, addends, fit.memory, fit.values, fit.misfit, growing=False)
    except IdentificationError:
        return None
    said = doubt(level, fit, null) if len(kept) == 1 else doubt(level, fit, candidate.fit, candidate.out)
    return Candidate(tuple(candidate.suspects[i] for i in kept), fit, prior, said)


def closed_up(addends: Sequence[Addend]) -> tuple[Addend, ...]:
    """Addends whose resonators take the integrator's places one after the other, without one that is left empty."""
    found: list[Addend] = []
    for addend in addends:
        if swings(addend):
            place = str(1 + sum(swings(earlier) for earlier in found))
            addend = replace(addend, additions=tuple(replace(a, slot=a.slot[:-1] + place) for a in addend.additions))
        found.append(addend)
    return tuple(found)
