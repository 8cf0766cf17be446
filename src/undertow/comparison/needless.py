"""Whether a set of effects needs all of them: of two effects the first is chosen before the second is known.

Belongs here: the same set without one of its effects, and which of those stands. Does not belong here: when that is
asked (search.py), the fit (attempt.py).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from undertow.comparison.attempt import without
from undertow.comparison.candidate import Candidate
from undertow.comparison.joint import JointFit, free_run_error
from undertow.comparison.level import Level
from undertow.comparison.suspect import Suspect


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
