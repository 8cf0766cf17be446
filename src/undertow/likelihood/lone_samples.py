"""Whether a sample that stands alone in its cell is the motion at its instant or the mean over its step.

Loggers do one or the other and recordings do not say which. Friction changes its sign at every turn and the
acceleration jumps there: a mean holds part of the jump, an instant none. The search compares means, which have no
jumps; where it ended the turns themselves tell, all trials of a fit alike, for they share a logger. A body without
friction hardly tells, and the two differ by (w dt)^2 / 24 of the amplitude: its numbers' errors then hold both.

Belongs here: that choice. Does not belong here: what either looks like (observation_model.py), the search
(output_error.py).
"""

from __future__ import annotations

import math
from dataclasses import replace

from undertow.errors import IdentificationError
from undertow.likelihood import output_error
from undertow.likelihood.output_error import Solution

MOST = 700.0
"""Of what an exponential is taken: beyond it is no number."""


def as_recorded(solution: Solution) -> Solution:
    """The solution with lone samples as instants or as means over their steps, whichever fits better, and as its
    ``ambiguity`` the distance to the other's values times the root of its probability (errors of a mixture of both).

    The solution itself where every cell holds several samples, or where neither has a motion within bounds.
    """
    trials = solution.problem.trials
    if not any(trial.width_s > 0.0 and not trial.averaged for trial in trials):
        return solution
    means = tuple(replace(trial, averaged=True) for trial in trials)
    instants = tuple(trial if trial.averaged else replace(trial, width_s=0.0) for trial in trials)
    ends = []
    for either in (means, instants):
        try:
            problem = replace(solution.problem, trials=either)
            ends.append(output_error.fit(problem, solution.values, growing=False))
        except IdentificationError:  # at its edge a motion can have bounds in one and none in the other
            continue
    if not ends:
        return solution
    best, other = min(ends, key=lambda end: end.cost), max(ends, key=lambda end: end.cost)
    probable = 1.0 / (1.0 + math.exp(min(0.5 * (other.cost - best.cost), MOST)))
    return replace(best, ambiguity=math.sqrt(probable) * abs(other.values - best.values))
