"""How probable each rival is, given a table, and what its unknowns may be.

Row i prints y_i = recipe(physics, errors of k, c, mu, V) + e_i. The covariance of e_i is what the structure's scatter
from trial to trial does to the recipe (by the surface's slopes), half a printed digit, and a scatter of its own (kg;
share of C_d) whose size is unknown and summed over an even logarithmic grid. A printed m_a = 0 means m_a <= 0 before
the bound. Unknowns are integrated by importance sampling around each node's best point; the evidence is the mean
weight.

Belongs here: likelihood, evidence, draws. Does not belong here: rivals' priors (rivals.py), words (verdicts.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from undertow.discrepancy.audit.case import Case, case_returns
from undertow.discrepancy.audit.recipes import Array
from undertow.discrepancy.audit.rivals import Rival, Unknown
from undertow.discrepancy.audit.surface import SMALLEST_DRAG, Sheet, Surface, printed_values
from undertow.errors import UndertowError

MASS_SCATTER_SHARES = tuple(np.geomspace(0.001, 0.05, 6))
"""Scatter of a printed m_a beyond what the structure makes, over the structure's mass: 5 % are a quarter of a cycle of
phase after ten cycles, more than a fit of a whole decay can miss."""

DRAG_SCATTER_SHARES = tuple(np.geomspace(0.005, 0.4, 6))
"""The same of a printed C_d, over its value."""

DRAWS = 300
"""Draws a node and scatter."""

PROPOSAL_WIDTH = 1.3
"""Draws are this much wider than the normal approximation."""

KEPT_DRAWS = 2000
"""Draws that stand for a posterior."""

INTERVAL = (0.05, 0.95)
"""Quantiles of a 90 % interval."""

_LOG_2PI = math.log(2.0 * math.pi)


@dataclass(frozen=True)
class Weighed:
    """One rival on one case, before the scatter is summed over: log evidence at each scatter, (S,), and all draws.

    ``logs`` (S, nodes, DRAWS) are logarithms of the draws' weights, ``points`` (S, nodes, DRAWS, L) the draws.
    """

    case: Case
    surface: Surface
    log_evidences: Array
    logs: Array
    points: Array


@dataclass(frozen=True)
class Posterior:
    """One rival after the table: equally weighted ``draws`` (name -> (n,)), ``predicted`` (n, rows, 2) what the surface
    prints at each, and the scatter of the rows beyond what the structure makes (medians: kg, share of C_d)."""

    rival: Rival
    draws: Mapping[str, Array]
    predicted: Array
    mass_scatter_kg: float
    drag_scatter: float
    sheets: NDArray[np.intp]
    """Index of the node of each draw, (n,)."""

    def interval(self, name: str) -> tuple[float, float, float]:
        """Median and 90 % interval of an unknown; UndertowError for a name that is not in the rival."""
        if name not in self.draws:
            have = ", ".join(self.draws)
            raise UndertowError(f"{self.rival.label} has no unknown {name!r}, it has {have}; choose one of them")
        low, middle, high = np.quantile(self.draws[name], [INTERVAL[0], 0.5, INTERVAL[1]])
        return float(middle), float(low), float(high)


def scatters(case: Case) -> tuple[tuple[float, float], ...]:
    """The grid of scatters summed over, (S,): kg of m_a, share of C_d."""
    return tuple((share * case.mass_kg, drag) for share, drag in product(MASS_SCATTER_SHARES, DRAG_SCATTER_SHARES))


def weigh(case: Case, surface: Surface, seed: int = 0) -> Weighed:
    """Evidence of one rival at each scatter; UndertowError where no draw lies within its priors."""
    unknowns = surface.rival.unknowns
    normal_draws = np.random.default_rng(seed).standard_normal((DRAWS, len(unknowns)))
    grid = scatters(case)
    logs = np.empty((len(grid), len(surface.sheets), DRAWS))
    points = np.empty((*logs.shape, len(unknowns)))
    for i, scatter in enumerate(grid):
        for j, sheet in enumerate(surface.sheets):
            points[i, j], logs[i, j] = _sample(case, unknowns, sheet, scatter, normal_draws)
    highest = float(np.max(logs))
    if not math.isfinite(highest):
        raise UndertowError(
            f"audit case {case.name}: no draw of {surface.rival.label} lies within its priors; widen their ranges"
        )
    with np.errstate(divide="ignore"):
        evidences = highest + np.log(np.sum(np.exp(logs - highest), axis=(1, 2)) / (DRAWS * surface.tried))
    return Weighed(case, surface, evidences, logs, points)


def log_mean(logs: Array) -> float:
    """Logarithm of the mean of exp(logs), safe against overflow.

    >>> round(log_mean(np.log([1.0, 3.0])), 12) == round(math.log(2.0), 12)
    True
    """
    highest = float(np.max(logs))
    return highest + math.log(float(np.mean(np.exp(logs - highest)))) if math.isfinite(highest) else -math.inf


def posterior(weighed: Weighed, seed: int = 0, elsewhere: Array | None = None) -> Posterior:
    """Draws of one rival; ``elsewhere`` (S,) is what other cases say about the scatter, log evidence at each."""
    case, surface = weighed.case, weighed.surface
    logs = weighed.logs if elsewhere is None else weighed.logs + elsewhere[:, None, None]
    share = np.exp(logs - np.max(logs)).ravel()
    rng = np.random.default_rng(seed)
    chosen = np.unravel_index(rng.choice(share.size, KEPT_DRAWS, p=share / share.sum()), logs.shape)
    points, sheets = weighed.points[chosen], chosen[1]
    draws = {unknown.name: points[:, i] for i, unknown in enumerate(surface.rival.unknowns)}
    for name in surface.rival.node_names:
        draws[name] = np.array([sheet.node[name] for sheet in surface.sheets])[sheets]
    predicted = np.empty((KEPT_DRAWS, len(case.rows), 2))
    for j in np.unique(sheets):
        predicted[sheets == j] = surface.sheets[j].predict(points[sheets == j])
    grid = np.array(scatters(case))[chosen[0]]
    mass, drag = np.median(grid, axis=0)
    return Posterior(surface.rival, draws, predicted, float(mass), float(drag), sheets)


def _covariances(case: Case, unknowns: Sequence[Unknown], sheet: Sheet, scatter: tuple[float, float]) -> Array:
    """Covariance (rows, 2, 2) of each printed pair, given the shared unknowns."""
    names = [unknown.name for unknown in unknowns]
    found = np.zeros((len(case.rows), 2, 2))
    for i, row in enumerate(case.rows):
        dry = case.structures[row.spring]
        for short, deviation in (("k", dry.k_scatter), ("c", dry.c_scatter), ("mu", dry.mu_scatter)):
            slope = sheet.slopes[i, :, names.index(f"{short}.{row.spring}")] * deviation
            found[i] += np.outer(slope, slope)
        drag = max(abs(row.drag_coefficient) if math.isfinite(row.drag_coefficient) else 0.0, SMALLEST_DRAG)
        found[i, 0, 0] += scatter[0] ** 2 + row.mass_half_digit**2 / 3.0
        found[i, 1, 1] += (scatter[1] * drag) ** 2 + row.drag_half_digit**2 / 3.0
        if sheet.errors is not None:
            found[i] += np.diag(sheet.errors[i] ** 2)
    return found


def _log_likelihood(case: Case, predicted: Array, covariances: Array) -> Array:
    """Log density (n,) of the print, for predictions (n, rows, 2) before the bound."""
    total = np.zeros(predicted.shape[0])
    for i, row in enumerate(case.rows):
        printed = np.array([row.added_mass_kg, row.drag_coefficient])
        use = np.isfinite(printed)
        if row.on_bound:
            total += norm.logcdf(-predicted[:, i, 0] / math.sqrt(covariances[i, 0, 0]))
            use[0] = False
        error = (printed - predicted[:, i])[:, use]
        block = covariances[i][np.ix_(use, use)]
        if error.shape[1]:
            total -= 0.5 * np.einsum("ni,ij,nj->n", error, np.linalg.inv(block), error)
            total -= 0.5 * (math.log(np.linalg.det(block)) + error.shape[1] * _LOG_2PI)
    return total


def _log_prior(unknowns: Sequence[Unknown], points: Array) -> Array:
    total = np.zeros(points.shape[0])
    for i, unknown in enumerate(unknowns):
        value = points[:, i]
        if unknown.normal:
            total -= (
                0.5 * ((value - unknown.mean) / unknown.deviation) ** 2 + math.log(unknown.deviation) + 0.5 * _LOG_2PI
            )
        elif unknown.logarithmic:
            total -= np.log(np.maximum(value, unknown.low)) + math.log(math.log(unknown.high / unknown.low))
        else:
            total -= math.log(unknown.high - unknown.low)
        total[(value < unknown.low) | (value > unknown.high)] = -np.inf
    return total


def _sample(
    case: Case, unknowns: Sequence[Unknown], sheet: Sheet, scatter: tuple[float, float], normal_draws: Array
) -> tuple[Array, Array]:
    """Draws (DRAWS, L) of one node at one scatter, and the logarithms of their weights."""
    covariances = _covariances(case, unknowns, sheet, scatter)
    centre, spread = _approximation(case, unknowns, sheet, covariances)
    root = np.linalg.cholesky(spread) * PROPOSAL_WIDTH
    points = centre + normal_draws @ root.T
    proposal = -0.5 * np.sum(normal_draws**2, axis=1) - float(np.sum(np.log(np.diag(root))))
    proposal -= 0.5 * len(unknowns) * _LOG_2PI
    weights = _log_prior(unknowns, points) - proposal
    inside = np.isfinite(weights)
    weights[inside] += _log_likelihood(case, sheet.predict(points[inside]), covariances)
    return points, weights + sheet.log_weight


def _approximation(case: Case, unknowns: Sequence[Unknown], sheet: Sheet, covariances: Array) -> tuple[Array, Array]:
    """Centre (L,) and covariance (L, L) of the normal that draws come from: Gauss-Newton, moved inside the ranges."""
    printed = printed_values(case)
    # a range acts as a normal four of its widths wide: it makes the matrix regular, the weights mend the rest
    widths = np.array([one.deviation if one.normal else 0.5 * (one.high - one.low) for one in unknowns])
    middles = np.array([one.mean if one.normal else 0.5 * (one.low + one.high) for one in unknowns])
    precision = np.diag(1.0 / widths**2)
    right = middles / widths**2
    for i, row in enumerate(case.rows):
        use = np.isfinite(printed[i])
        if row.on_bound and sheet.values[i, 0] < 0.0:
            use[0] = False
        if not use.any():
            continue
        slopes = sheet.slopes[i][use]
        inverse = np.linalg.inv(covariances[i][np.ix_(use, use)])
        right = right + slopes.T @ inverse @ ((printed[i] - sheet.values[i])[use] + slopes @ sheet.centre)
        precision = precision + slopes.T @ inverse @ slopes
    return _inside(unknowns, precision, right)


def _inside(unknowns: Sequence[Unknown], precision: Array, right: Array) -> tuple[Array, Array]:
    """Minimum of the quadratic within the ranges: what leaves its range is set on its end and the rest solved again."""
    free = np.ones(len(unknowns), dtype=bool)
    point = np.zeros(len(unknowns))
    for _ in range(len(unknowns)):
        fixed = ~free
        point[free] = np.linalg.solve(
            precision[np.ix_(free, free)], right[free] - precision[np.ix_(free, fixed)] @ point[fixed]
        )
        over = [
            (max(unknown.low - point[i], point[i] - unknown.high) / max(unknown.scale, 1e-30), i)
            for i, unknown in enumerate(unknowns)
            if free[i]
        ]
        worst = max(over, default=(0.0, -1))
        if worst[0] <= 0.0:
            break
        i = worst[1]
        point[i] = min(max(point[i], unknowns[i].low), unknowns[i].high)
        free[i] = False
    spread: Array = np.asarray(np.linalg.inv(precision), dtype=np.float64)
    return point, spread


def surface_error(case: Case, found: Posterior, draws: int = 8) -> Array:
    """Root-mean-square difference (2,) of surface and recipes over the first draws: m_a in kg, C_d as a share."""
    errors = []
    for i in range(draws):
        values = {name: float(column[i]) for name, column in found.draws.items()}
        exact = case_returns(case, values)
        for j, (row, one) in enumerate(zip(case.rows, exact, strict=True)):
            drag = one.bounded_drag if row.on_bound else one.drag_coefficient
            size = max(abs(row.drag_coefficient), SMALLEST_DRAG)
            gap = found.predicted[i, j] - np.array([one.added_mass_kg, drag])
            errors.append([gap[0], gap[1] / size])
    return np.asarray(np.sqrt(np.nanmean(np.square(errors), axis=0)), dtype=np.float64)
