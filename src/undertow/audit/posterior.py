"""How probable each rival is, given a table, and what its unknowns may be.

Row i prints y_i = recipe(physics, errors of k, c, mu, V) + e_i. A printed m_a = 0 means m_a <= 0 before the bound.
Unknowns are integrated by importance sampling around each sheet's best point (sampling.py), for every scatter of the
rows (scatter.py); the evidence at a scatter is the mean weight.

Belongs here: evidence, posteriors. Does not belong here: likelihoods (sampling.py), rivals' priors (rivals.py), words
(verdicts.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.audit.case import PrintedCase
from undertow.audit.recipes import Array
from undertow.audit.rivals import Rival
from undertow.audit.sampling import sample
from undertow.audit.scatter import log_belief, scatters
from undertow.audit.surface import Surface
from undertow.errors import UndertowError

DRAWS = 300
"""Draws a sheet and scatter."""

POINT_DRAWS = 24
"""The same where a sheet is one point of a cloud: there are many of them."""

KEPT_DRAWS = 2000
"""Draws that stand for a posterior."""

INTERVAL = (0.05, 0.95)
"""Quantiles of a 90 % interval."""


@dataclass(frozen=True)
class Weighed:
    """One rival on one case, before the scatter is summed over: log evidence at each scatter, (S,), and all draws.

    ``logs`` (S, sheets, draws) are logarithms of the draws' weights, ``points`` (S, sheets, draws, L) the draws.
    """

    case: PrintedCase
    surface: Surface
    log_evidences: Array
    logs: Array
    points: Array


@dataclass(frozen=True)
class RivalPosterior:
    """One rival after the table: equally weighted ``draws`` (name -> (n,)), ``predicted`` (n, rows, 2) what the surface
    prints at each, and the scatter of the rows beyond what the structure makes (medians: kg, share of C_d)."""

    rival: Rival
    draws: Mapping[str, Array]
    points: Array
    """The same as coordinates, (n, L)."""
    predicted: Array
    mass_scatter_kg: float
    drag_scatter: float
    sheets: NDArray[np.intp]
    """Index of the sheet of each draw, (n,)."""

    def interval(self, name: str) -> tuple[float, float, float]:
        """Median and 90 % interval of an unknown; UndertowError for a name that is not in the rival."""
        if name not in self.draws:
            have = ", ".join(self.draws)
            raise UndertowError(f"{self.rival.label} has no unknown {name!r}, it has {have}; choose one of them")
        low, middle, high = np.quantile(self.draws[name], [INTERVAL[0], 0.5, INTERVAL[1]])
        return float(middle), float(low), float(high)


def weigh(case: PrintedCase, surface: Surface, seed: int = 0) -> Weighed:
    """Evidence of one rival at each scatter; UndertowError where no draw lies within its priors."""
    rival = surface.rival
    draws = POINT_DRAWS if surface.sheets[0].pinned else DRAWS
    normal_draws = np.random.default_rng(seed).standard_normal((draws, len(rival.unknowns)))
    logs = np.empty((len(scatters(case)), len(surface.sheets), draws))
    points = np.empty((*logs.shape, len(rival.unknowns)))
    for j, sheet in enumerate(surface.sheets):
        points[:, j], logs[:, j] = sample(case, rival, sheet, normal_draws)
    highest = float(np.max(logs))
    if not math.isfinite(highest):
        raise UndertowError(
            f"audit case {case.name}: no draw of {rival.label} lies within its priors; widen their ranges"
        )
    with np.errstate(divide="ignore"):
        evidences = highest + np.log(np.sum(np.exp(logs - highest), axis=(1, 2)) / draws)
    return Weighed(case, surface, evidences, logs, points)


def posterior(weighed: Weighed, seed: int = 0, elsewhere: Array | None = None) -> RivalPosterior:
    """Draws of one rival; ``elsewhere`` (S,) is what other cases say about the scatter, log evidence at each."""
    case, surface = weighed.case, weighed.surface
    belief = log_belief() if elsewhere is None else log_belief() + elsewhere
    logs = weighed.logs + belief[:, None, None]
    if not math.isfinite(float(np.max(logs))):  # other cases rule this rival out at every scatter
        logs = weighed.logs + log_belief()[:, None, None]
    share = np.exp(logs - np.max(logs)).ravel()
    rng = np.random.default_rng(seed)
    chosen = np.unravel_index(rng.choice(share.size, KEPT_DRAWS, p=share / share.sum()), logs.shape)
    points, sheets = weighed.points[chosen], chosen[1]
    predicted = np.empty((KEPT_DRAWS, len(case.rows), 2))
    for j in np.unique(sheets):
        predicted[sheets == j] = surface.sheets[j].predict(points[sheets == j])
    grid = np.array(scatters(case))[chosen[0]]
    mass, drag = np.median(grid, axis=0)
    draws = named_draws(surface.rival, points)
    return RivalPosterior(surface.rival, draws, points, predicted, float(mass), float(drag), sheets)


def named_draws(rival: Rival, points: Array) -> dict[str, Array]:
    """Draws (n,) of every unknown by name, from coordinates (n, L)."""
    return {
        unknown.name: np.exp(points[:, i]) if unknown.logarithmic else points[:, i]
        for i, unknown in enumerate(rival.unknowns)
    }
