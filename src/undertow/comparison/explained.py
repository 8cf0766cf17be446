"""What a candidate explains of what the prescribed equation leaves, and what kind of effect its last one is.

Belongs here: those questions. Does not belong here: the search that asks them (search.py), whether a candidate's
numbers mean anything (candidate.py).
"""

from __future__ import annotations

import numpy as np

from undertow.comparison.candidate import Candidate, damping_ratio
from undertow.comparison.clock import at_a_resonance
from undertow.comparison.level import Addend
from undertow.comparison.limits import FAR_ABOVE_NOISE
from undertow.comparison.sizes import COUNTS_IN_STDERR
from undertow.comparison.suspects import RINGS
from undertow.equation.kernel import SLOT

NEARLY_ALL = 0.75
"""Share of the residual above noise that such a law must explain."""

SLIDING = 0.1
"""Sliding friction over a hysteresis' yield force below which it is what friction has become."""

NOISE = 1.5
"""Mean squared residual over noise that may be noise alone: from a hold it is known no better."""

ALL = 0.95
"""Share of the residual above noise that a bad release must explain (in later cycles it leaves none), and two effects
that neither is enough alone."""


def asked(candidate: Candidate) -> float:
    """Share of the residual above noise that a candidate's last effect must explain to be named, 0 where it need not
    explain any (k, c, mu of each trial's own may have taken it up, far from what is known of them). A bad release and a
    force with its own clock leave none, as far as noise is known; what a resonator leaves that is not quite one (waves
    that break) swings at the resonator's frequency, and much of it passes for a force of that frequency; and what a
    force leaves whose waves die out passes for a resonator.
    """
    last = candidate.suspects[-1]
    if last.of_the_release:
        return ALL if candidate.fit.misfit > NOISE else NEARLY_ALL
    if len(candidate.suspects) == 1 or not any(s.has_its_own_clock for s in candidate.suspects):
        return 0.0
    if at_a_resonance(candidate.fit):
        return ALL
    return NEARLY_ALL if last.has_its_own_clock else 0.0


def beyond_doubt(before: Candidate, after: Candidate) -> bool:
    """Whether the most probable candidate explains nearly all of a residual far above the sensors' noise, which no
    k, c, mu of each trial's own takes away: physics, though repetitions differ by more."""
    return before.fit.misfit > FAR_ABOVE_NOISE and explains(before, after, NEARLY_ALL)


def biases(before: Candidate, after: Candidate) -> bool:
    """Whether an effect that may hide in the motion counts by what it does to a number that is reported: a dashpot can
    double c. A sensor, and a force with a size of its own in every trial, do not."""
    if any(s.has_its_own_clock or not s.shown_by_free_run for s in after.suspects):
        return False
    return after.fit.moved(before.fit)[1] > COUNTS_IN_STDERR


def hides(before: Candidate, after: Candidate) -> bool:
    """Whether one law more, whose numbers mean something, leaves nearly no more than noise and moves a number that is
    reported, however close the free run was without it."""
    return (not after.out or after.aside) and explains(before, after, NEARLY_ALL) and biases(before, after)


def explains(before: Candidate, after: Candidate, share: float) -> bool:
    """Whether one candidate explains more than a share of the residual above noise that another leaves; no share is
    always explained."""
    return share <= 0.0 or before.fit.misfit - after.fit.misfit > share * (before.fit.misfit - 1.0)


def swings(addend: Addend) -> bool:
    """Whether an addend is a hidden oscillator, or a kernel that takes the place of one."""
    return any(a.slot.startswith("hm") for a in addend.additions)


def slides(candidate: Candidate) -> float:
    """Sliding friction left beside a candidate's hysteresis, over the force at which that yields (mean of trials)."""
    vectors = [candidate.fit.theta(trial) for trial in range(len(candidate.fit.solution.problem.trials))]
    return float(np.mean([abs(v[SLOT["fc"]]) / max(v[SLOT["fb"]], 1e-300) for v in vectors]))


def fading(candidate: Candidate) -> bool:
    """Whether a candidate's last effect is a resonator that hardly rings: gone within a few cycles."""
    if not candidate.suspects or not candidate.suspects[-1].swings or candidate.suspects[-1].variant:
        return False
    last = candidate.fit.addends[-1]
    return candidate.fit.value(f"{last.prefix}.damping_ratio") > RINGS


def single_fading(candidate: Candidate) -> bool:
    """Whether a candidate is one memory that rings in nothing: a relaxation, an echo, a resonator that hardly rings."""
    if len(candidate.suspects) != 1:
        return False
    (alone,) = candidate.suspects
    return damping_ratio(candidate.fit) > RINGS if alone.swings else alone.fades
