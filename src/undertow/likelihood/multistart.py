"""Fits from starts that nobody chose: where the first search fails, the record itself gives the next ones.

Growing windows lead Eq. 15 from nearly every start to its optimum; where they do not, period and release give a start.
A hidden oscillator started far from its frequency ends as damping or as mass; then the equation without it is fitted,
and the oscillator is offered to that at frequencies from well below the body's to well above.

Belongs here: where to start again, and what a sample stands for where a search ended. Does not belong here: the search
itself (output_error.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from undertow.equation.kernel import SLOT
from undertow.errors import IdentificationError
from undertow.likelihood import output_error
from undertow.likelihood.output_error import FULL, QUICK, SearchEffort, Solution
from undertow.likelihood.problem import Problem
from undertow.recording.recording import Array

FREQUENCY_RATIOS = np.geomspace(0.3, 2.6, 12)
"""Frequencies offered, relative to the motion's own: neighbours are 22 % apart, within reach of two periods' window."""

MASS_SHARE = 0.08
DAMPING_RATIO = 0.03
"""Oscillator offered: heavy enough to pull the search, damped enough to be seen from a neighbouring frequency."""

CANDIDATES = 3
"""How many of the quick searches are followed to their ends."""

RECORD_DAMPING = {"c1": 0.01, "fc": 0.003, "q": 0.01}
"""Damping of a start from the record: shares of 2 M w (viscous), k x0 (friction) and M / x0 (drag)."""

GOOD_FIT = 2.0
"""Mean squared residual in units of noise up to which the first end is taken: what is left is noise."""

MOST_EXPONENT = 700.0
"""Of what an exponential is taken: beyond it is no number."""


def hidden_unknowns(problem: Problem) -> dict[str, tuple[int, float, float]]:
    """Unknowns that are the first hidden oscillator's mass, frequency and damping ratio in all trials.

    By slot (hm1, hw1, hz1): index of the unknown, the factor to the slot and what the slot holds besides.
    """
    found: dict[str, tuple[int, float, float]] = {}
    trial = problem.trials[0]
    for name in ("hm1", "hw1", "hz1"):
        for link in trial.links:
            if link.slot == SLOT[name] and name not in found:
                found[name] = (link.unknown, link.factor, float(trial.base[link.slot]))
    return found


def fit(problem: Problem, start: Array | None = None) -> Solution:
    """The best values of all unknowns from a blind ``start`` (p,), or the unknowns' own starts.

    Where the first search leaves more than noise it starts again from the record's period and release; a hidden
    oscillator that is unknown is offered to the equation without it at frequencies from 0.3 to 2.6 of the motion's.
    The end of least cost is returned, lone samples taken as they were recorded (`as_recorded`). Raises
    IdentificationError where no start has a motion within bounds.
    """
    begin = np.array([u.start for u in problem.unknowns]) if start is None else np.array(start, dtype=np.float64)
    return as_recorded(_best_end(problem, begin))


def _best_end(problem: Problem, begin: Array) -> Solution:
    """The end of least cost of all searches."""
    ends = [] if (first := _attempt(problem, begin, True, FULL)) is None else [first]
    if ends and ends[0].chi2 <= GOOD_FIT * ends[0].n_data:
        return ends[0]
    hidden = hidden_unknowns(problem)
    begin = from_record(problem, begin)
    if "hw1" not in hidden:
        further = _attempt(problem, begin, True, FULL)
        ends += [] if further is None else [further]
    else:
        quick = [_attempt(problem, values, True, QUICK) for values in _offers(problem, begin, hidden)]
        tried = sorted((s for s in quick if s is not None), key=lambda s: s.cost)
        followed = (_attempt(problem, s.values, False, FULL) for s in tried[:CANDIDATES])
        ends += [s for s in followed if s is not None]
    if not ends:
        raise IdentificationError(
            f"the equation has no motion within bounds for {', '.join(t.name for t in problem.trials[:3])} from any "
            "start tried (its own scale, the record's period and release); set trials.window, or leave out a term"
        )
    return min(ends, key=lambda s: s.cost)


def from_record(problem: Problem, begin: Array) -> Array:
    """``begin`` (p,) with mass or stiffness by the motion's period, release by its first cell, light damping."""
    values, given = begin.copy(), set()
    for trial in problem.trials:
        rate = 2.0 * math.pi / trial.period_s
        theta = output_error.parameter_vector(trial, begin)
        own = {link.slot: link for link in reversed(trial.links)}
        displaced = [c for c in trial.channels if c.quantity == "displacement"]
        x0 = float(displaced[0].values[0]) if displaced and SLOT["x0"] in own else float(theta[SLOT["x0"]])
        k, mass = float(theta[SLOT["k1"]]), float(theta[SLOT["mass"]])
        if SLOT["mass"] in own:
            mass = k / rate**2
        elif SLOT["k1"] in own:
            k = mass * rate**2
        size = abs(x0) or 1.0
        scales = {"c1": 2.0 * mass * rate, "fc": k * size, "q": mass / size}
        wanted = {"mass": mass, "k1": k, "x0": x0} | {n: RECORD_DAMPING[n] * scales[n] for n in RECORD_DAMPING}
        for name, number in wanted.items():
            link = own.get(SLOT[name])
            if link is not None and link.unknown not in given:
                values[link.unknown] += (number - float(theta[link.slot])) / link.factor
                given.add(link.unknown)
    return np.clip(values, *problem.bounds)


def _attempt(problem: Problem, values: Array, growing: bool, effort: SearchEffort) -> Solution | None:
    try:
        return output_error.fit(problem, values, growing=growing, effort=effort)
    except IdentificationError:
        return None


def _offers(problem: Problem, begin: Array, hidden: dict[str, tuple[int, float, float]]) -> Iterator[Array]:
    """Starts at every frequency, the rest from the fit without the oscillator."""
    bare = _without(problem, begin, hidden)
    trial = problem.trials[0]
    rate = 2.0 * math.pi / trial.period_s
    theta = output_error.parameter_vector(trial, bare)
    wanted = {"hm1": MASS_SHARE * abs(float(theta[SLOT["mass"]])), "hz1": DAMPING_RATIO}
    for ratio in FREQUENCY_RATIOS:
        values = bare.copy()
        for name, number in {**wanted, "hw1": ratio * rate}.items():
            if name in hidden:
                index, factor, besides = hidden[name]
                values[index] = (number - besides) / factor
        yield values


def _without(problem: Problem, begin: Array, hidden: dict[str, tuple[int, float, float]]) -> Array:
    """Values of the fit with the oscillator's mass held at zero; the start where even that has no motion."""
    unknowns, values = list(problem.unknowns), begin.copy()
    for name, (index, factor, besides) in hidden.items():
        number = (0.0 - besides) / factor if name == "hm1" else values[index]
        unknowns[index] = replace(unknowns[index], start=number, lower=number, upper=number)
        values[index] = number
    bare = _attempt(Problem(tuple(unknowns), problem.trials), values, True, FULL)
    return begin if bare is None else bare.values.copy()


def as_recorded(solution: Solution) -> Solution:
    """The solution with lone samples as instants or as means over their steps, whichever fits better, and as its
    ``ambiguity`` the distance to the other's values times the root of its probability (errors of a mixture of both).

    Loggers do one or the other and recordings do not say which. Friction changes its sign at every turn and the
    acceleration jumps there: a mean holds part of the jump, an instant none. The search compares means, which have no
    jumps; where it ended the turns themselves tell, all trials of a fit alike, for they share a logger. A body without
    friction hardly tells, and the two differ by (w dt)^2 / 24 of the amplitude: its numbers' errors then hold both. The
    solution itself where every cell holds several samples, or where neither has a motion within bounds.
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
    probable = 1.0 / (1.0 + math.exp(min(0.5 * (other.cost - best.cost), MOST_EXPONENT)))
    return replace(best, ambiguity=math.sqrt(probable) * abs(other.values - best.values))
