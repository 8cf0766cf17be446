"""Draws of one sheet's unknowns with their weights, at every scatter at once: importance sampling.

Draws come from the normal approximation at the best point within the ranges; weights are prior times likelihood of the
print over their density. The covariance of a printed pair is what the structure's scatter from trial to trial does to
the recipe (by the sheet's slopes), half a printed digit, the sheet's own error, and the rows' scatter.

Belongs here: prior, likelihood, proposal. Does not belong here: evidence and posteriors (posterior.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import log_ndtr, ndtr

from undertow.audit.case import PrintedCase
from undertow.audit.recipes import Array
from undertow.audit.rivals import Rival, RivalUnknown
from undertow.audit.scatter import scatters
from undertow.audit.surface import SMALLEST_DRAG, Sheet, printed_values, structure_covariances

PROPOSAL_WIDTH = 1.3
"""Draws are this much wider than the normal approximation."""

_LOG_2PI = math.log(2.0 * math.pi)


def sample(case: PrintedCase, rival: Rival, sheet: Sheet, normal_draws: Array) -> tuple[Array, Array]:
    """Draws (S, n, L) of one sheet from ``normal_draws`` (n, L), and the logarithms of their weights (S, n).

    What is pinned stays where it is: its prior is in the sheet's share.
    """
    every = rival.within(sheet.cell).unknowns
    free = [i for i in range(len(every)) if i not in sheet.pinned]
    unknowns, normal_draws = [every[i] for i in free], normal_draws[:, free]
    covariances = covariances_of(case, rival, sheet)
    centre, spread = _approximation(case, unknowns, sheet, free, covariances)
    root = np.linalg.cholesky(spread) * PROPOSAL_WIDTH
    moved = centre[:, None, :] + normal_draws @ np.swapaxes(root, 1, 2)
    proposal = -0.5 * np.sum(normal_draws**2, axis=1)[None, :] - 0.5 * len(unknowns) * _LOG_2PI
    proposal = proposal - np.sum(np.log(np.diagonal(root, axis1=1, axis2=2)), axis=1)[:, None]
    points = np.broadcast_to(sheet.centre, (*moved.shape[:2], len(every))).copy()
    points[:, :, free] = moved
    predicted = sheet.predict(points.reshape(-1, len(every))).reshape(*points.shape[:2], len(case.rows), 2)
    weights = log_prior(unknowns, moved) + log_likelihood(case, predicted, covariances) - proposal
    return points, np.where(np.isfinite(weights), weights + sheet.log_share, -np.inf)


def covariances_of(case: PrintedCase, rival: Rival, sheet: Sheet) -> Array:
    """Covariance (S, rows, 2, 2) of each printed pair at each scatter, given the shared unknowns."""
    base = structure_covariances(case, rival, sheet)
    drags = np.empty(len(case.rows))
    for i, row in enumerate(case.rows):
        drags[i] = max(abs(row.drag_coefficient) if math.isfinite(row.drag_coefficient) else 0.0, SMALLEST_DRAG)
        base[i] += np.diag([row.mass_half_digit**2 / 3.0, row.drag_half_digit**2 / 3.0])
        if sheet.errors is not None:
            base[i] += np.diag(sheet.errors[i] ** 2)
    grid = np.array(scatters(case))
    found = np.broadcast_to(base, (grid.shape[0], *base.shape)).copy()
    found[:, :, 0, 0] += grid[:, :1] ** 2
    found[:, :, 1, 1] += (grid[:, 1:] * drags) ** 2
    return found


def log_likelihood(case: PrintedCase, predicted: Array, covariances: Array) -> Array:
    """Log density (S, n) of the print, for predictions (S, n, rows, 2) before the bound."""
    total = np.zeros(predicted.shape[:2])
    printed, use = _used(case)
    for i, row in enumerate(case.rows):
        block = covariances[:, i]
        if row.on_bound:
            total += log_ndtr(-predicted[:, :, i, 0] / np.sqrt(block[:, 0, 0])[:, None])
        error = np.where(use[i], np.nan_to_num(printed[i]) - predicted[:, :, i], 0.0)
        inverse, log_determinant = _inverse(block, use[i])
        total -= 0.5 * np.einsum("sni,sij,snj->sn", error, inverse, error)
        total -= 0.5 * (log_determinant + use[i].sum() * _LOG_2PI)[:, None]
    return total


def log_prior(unknowns: Sequence[RivalUnknown], points: Array) -> Array:
    """Log density (S, n) of the prior at ``points`` (S, n, L); -inf outside the ranges."""
    total = np.zeros(points.shape[:-1])
    for i, unknown in enumerate(unknowns):
        value = points[..., i]
        if unknown.normal:
            away = (np.array([unknown.low, unknown.high]) - unknown.mean) / unknown.deviation
            inside = unknown.deviation * float(np.diff(ndtr(away))[0])
            total -= 0.5 * ((value - unknown.mean) / unknown.deviation) ** 2 + math.log(inside) + 0.5 * _LOG_2PI
        else:
            total -= math.log(unknown.high - unknown.low)
        total[(value < unknown.low) | (value > unknown.high)] = -np.inf
    return total


def _used(case: PrintedCase) -> tuple[Array, Array]:
    """Printed pairs (rows, 2) and which of them are compared as numbers: printed, and not on the bound."""
    printed = printed_values(case)
    use = np.isfinite(printed)
    use[[row.on_bound for row in case.rows], 0] = False
    return printed, use


def _inverse(block: Array, use: Array) -> tuple[Array, Array]:
    """Inverse (S, 2, 2) and log determinant (S,) of covariances (S, 2, 2) over the used columns, zero elsewhere."""
    inverse = np.zeros_like(block)
    at = np.flatnonzero(use)
    if not at.size:
        return inverse, np.zeros(block.shape[0])
    part = block[:, at[:, None], at]
    inverse[:, at[:, None], at] = np.linalg.inv(part)
    return inverse, np.log(np.linalg.det(part))


def _approximation(
    case: PrintedCase, unknowns: Sequence[RivalUnknown], sheet: Sheet, free: list[int], covariances: Array
) -> tuple[Array, Array]:
    """Centre (S, F) and covariance (S, F, F) of the normal that draws of the ``free`` unknowns come from: Gauss-Newton,
    moved inside the ranges."""
    # a range acts as a normal four of its widths wide: it makes the matrix regular, the weights mend the rest
    widths = np.array([one.deviation if one.normal else 0.5 * (one.high - one.low) for one in unknowns])
    middles = np.array([one.mean if one.normal else 0.5 * (one.low + one.high) for one in unknowns])
    precision = np.broadcast_to(np.diag(1.0 / widths**2), (covariances.shape[0], widths.size, widths.size)).copy()
    right = np.broadcast_to(middles / widths**2, (covariances.shape[0], widths.size)).copy()
    printed = printed_values(case)
    for i, row in enumerate(case.rows):
        use = np.isfinite(printed[i])
        if row.on_bound and sheet.values[i, 0] < 0.0:
            use[0] = False
        slopes = sheet.slopes[i][:, free]
        weighted = np.einsum("cl,scd->sld", slopes, _inverse(covariances[:, i], use)[0])
        gap = np.where(use, np.nan_to_num(printed[i]) - sheet.values[i], 0.0)
        right += weighted @ (gap + slopes @ sheet.centre[free])
        precision += weighted @ slopes
    centre = np.linalg.solve(precision, right[:, :, None])[:, :, 0]
    low, high = np.array([one.low for one in unknowns]), np.array([one.high for one in unknowns])
    for s in np.flatnonzero(np.any((centre < low) | (centre > high), axis=1)):
        centre[s] = _inside(unknowns, precision[s], right[s])
    spread: Array = np.asarray(np.linalg.inv(precision), dtype=np.float64)
    return centre, spread


def _inside(unknowns: Sequence[RivalUnknown], precision: Array, right: Array) -> Array:
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
    return point
