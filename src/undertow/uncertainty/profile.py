"""How well one number is known when all others may give way: its profile likelihood.

A standard error says how the misfit curves at its lowest point; where it is not a parabola (a small friction, a
frequency that two oscillators could share, a parameter near its bound) only the profile tells how far a number may go.

Belongs here: the profile of one unknown of an output-error fit, and the interval it gives. Does not belong here: the
search for each of its points (output_error.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2

from undertow.errors import IdentificationError
from undertow.likelihood import output_error
from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Problem
from undertow.quantities import OK
from undertow.recording.recording import Array
from undertow.uncertainty.confidence import INTERVAL_LEVEL
from undertow.uncertainty.intervals import noise_factors

DOUBLINGS = 12
"""How often the step away from the best value is doubled in search of an interval's end: to 4096 standard errors."""

END_IN_WIDTHS = 0.01
"""An interval's end is found to this share of its distance from the best value."""

STEEP = 1e6
"""What a rise counts where there is no motion: a finite number, for the search of a zero."""


@dataclass(frozen=True)
class Profile:
    """Profile of the unknown ``name``: tried ``values`` (m,), rising, and by how much twice the negative log likelihood
    rises there over its least, ``rise`` (m,); ``best`` and the ends ``lower``, ``upper`` of the interval of confidence
    ``level``, in the unknown's unit. An end is a bound where the unknown has one, infinite where nothing holds it.
    ``outcome`` is "ok" or a sentence.
    """

    name: str
    values: Array
    rise: Array
    best: float
    lower: float
    upper: float
    level: float
    outcome: str


def profile(solution: Solution, name: str, level: float = INTERVAL_LEVEL) -> Profile:
    """Profile likelihood of one unknown: it is held at value after value, all others fitted anew.

    The interval holds what raises twice the negative log likelihood by less than chi^2(level, 1) (Venzon and Moolgavkar
    1988, doi:10.2307/2347496). The noise is what the residual shows near the motion's frequency (`noise_factors`),
    priors count as in the fit.

    Raises IdentificationError for a name that is not among the unknowns and for a level outside 0 to 1.
    """
    if name not in solution.problem.names:
        have = ", ".join(solution.problem.names)
        raise IdentificationError(f"profile of {name!r}: the fit has {have}; name one of them")
    if not 0.0 < level < 1.0:
        raise IdentificationError(f"profile of {name}: confidence level is {level:g}; it must lie between 0 and 1")
    walk = _Walk(solution, name)
    limit = float(chi2.ppf(level, 1))
    ends = [walk.end(side, limit) for side in (-1.0, 1.0)]
    order = np.argsort(walk.values)
    values, rise = np.array(walk.values)[order], np.array(walk.rises)[order]
    outcome = OK
    open_ends = [word for word, end in zip(("below", "above"), ends, strict=True) if math.isinf(end)]
    if open_ends:
        outcome = f"{name} is not bounded {' and '.join(open_ends)} by these trials"
    return Profile(name, values, rise, walk.best, ends[0], ends[1], level, outcome)


class _Walk:
    """Refits along one unknown, each from its nearest neighbour; remembers what it tried."""

    def __init__(self, solution: Solution, name: str) -> None:
        self.index = solution.problem.names.index(name)
        self.problem = as_noisy(solution)
        found = output_error.fit(self.problem, solution.values, growing=False)
        self.cost, self.best = found.cost, float(found.values[self.index])
        self.step = max(found.stderr(name), 1e-9 * abs(self.best), 1e-12 * solution.problem.unknowns[self.index].scale)
        self.unknown = self.problem.unknowns[self.index]
        self.values, self.rises, self.ends = [self.best], [0.0], [found.values]

    def rise(self, value: float) -> float:
        """By how much the cost rises with the unknown held at ``value``; kept with the point."""
        nearest = int(np.argmin(np.abs(np.array(self.values) - value)))
        start = self.ends[nearest].copy()
        start[self.index] = value
        unknowns = list(self.problem.unknowns)
        unknowns[self.index] = replace(self.unknown, lower=value, upper=value)
        try:
            found = output_error.fit(Problem(tuple(unknowns), self.problem.trials), start, growing=False)
        except IdentificationError:  # no motion there: as far off as can be
            return math.inf
        self.values.append(value)
        self.rises.append(found.cost - self.cost)
        self.ends.append(found.values)
        return found.cost - self.cost

    def end(self, side: float, limit: float) -> float:
        """Where the rise crosses ``limit`` on one side (-1, +1): a bound, or infinite, where it does not."""
        bound = self.unknown.upper if side > 0.0 else self.unknown.lower
        inner, away = self.best, self.step * math.sqrt(limit)
        for _ in range(DOUBLINGS):
            outer = self.best + side * away
            if side * (outer - bound) >= 0.0:
                outer = bound
            if self.rise(outer) >= limit:
                near = END_IN_WIDTHS * abs(outer - self.best)
                return float(brentq(lambda value: min(self.rise(value) - limit, STEEP), inner, outer, xtol=near))
            if outer == bound:
                return bound
            inner, away = outer, 2.0 * away
        return side * math.inf


def as_noisy(solution: Solution) -> Problem:
    """The problem with each channel's noise as large as the residual shows it where the motion is."""
    trials = tuple(
        replace(
            trial,
            channels=tuple(
                replace(channel, sigma=channel.sigma * math.sqrt(float(factor)))
                for channel, factor in zip(trial.channels, factors, strict=True)
            ),
        )
        for trial, factors in zip(solution.problem.trials, noise_factors(solution), strict=True)
    )
    return Problem(solution.problem.unknowns, trials)
