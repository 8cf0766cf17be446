"""A rival's answer surface: what the recipes would print, as a function of the rival's unknowns, near the table.

At every node (mass, frequency, damping of a resonator; an exponent) the other unknowns are fitted to the printed
numbers by Gauss-Newton through the recipes themselves; what the recipes return there, with its slopes, is the surface
that posterior.py integrates.

Belongs here: fitting and linearising through the recipes. Does not belong here: bending (bending.py), evidence, draws.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from undertow.discrepancy.audit.case import Case, case_returns, row_returns
from undertow.discrepancy.audit.recipes import Array, Returned
from undertow.discrepancy.audit.rivals import Rival, Unknown
from undertow.errors import UndertowError

FIT_MASS_SHARE = 0.02
"""Weight of an added mass while fitting: this share of the structure's mass counts as one."""

FIT_DRAG_SHARE = 0.1
"""Weight of a drag coefficient while fitting: this share of it counts as one."""

SMALLEST_DRAG = 0.5
"""Drag coefficients below this are weighed as this."""

ROUNDS = 6
HALVINGS = 4
SETTLED = 0.05
"""Fitting ends when no unknown moves by more than this share of its scale."""

STEP_SHARE = 0.05
"""Step of a slope over the unknown's scale."""

WIDE = 1e3
"""Standard deviations within which an unbounded unknown is searched."""

KEPT_BEHIND = 60.0
"""Nodes whose misfit (chi-square) lies further behind the best one's are not refined: e^-30 of its weight."""


@dataclass(frozen=True)
class Sheet:
    """The surface at one node: ``centre`` (L,), what is printed there ``values`` (rows, 2), ``slopes`` (rows, 2, L).

    Columns are m_a (without bound; kg) and C_d (at m_a = 0 where the printed one is on the bound). ``misfit`` is the
    chi-square of the fit, ``node`` the fixed values.
    """

    node: Mapping[str, float]
    centre: Array
    values: Array
    slopes: Array
    misfit: float
    curves: Array | None = None
    """Second derivatives (rows, 2, L, L) over two, where the sheet was bent."""
    log_weight: float = 0.0
    """Logarithm of the share of the prior that the node stands for, over an even one."""
    errors: Array | None = None
    """Root-mean-square misfit (rows, 2) of the bent sheet at the points it was bent through."""

    def predict(self, points: Array) -> Array:
        """What is printed (n, rows, 2) at points (n, L)."""
        away = points - self.centre
        flat: Array = self.values + np.einsum("rcl,nl->nrc", self.slopes, away)
        if self.curves is None:
            return flat
        bent: Array = flat + np.einsum("rckl,nk,nl->nrc", self.curves, away, away)
        return bent


@dataclass(frozen=True)
class Surface:
    """All nodes of one rival: ``sheets``; ``tried`` is how many nodes there were, those left out far behind
    included."""

    rival: Rival
    sheets: tuple[Sheet, ...]
    tried: int


def printed_values(case: Case) -> Array:
    """Printed (m_a, C_d) of every row, (rows, 2), nan where there is none."""
    return np.array([[row.added_mass_kg, row.drag_coefficient] for row in case.rows])


def fit_weights(case: Case) -> Array:
    """What counts as one standard deviation while fitting, (rows, 2)."""
    printed = printed_values(case)
    drag = FIT_DRAG_SHARE * np.maximum(np.abs(np.nan_to_num(printed[:, 1])), SMALLEST_DRAG)
    return np.column_stack([np.full(len(case.rows), FIT_MASS_SHARE * case.mass_kg), drag])


def build_surface(case: Case, rival: Rival) -> Surface:
    """The surface of one rival over all its nodes; nodes far behind the best after the first round are dropped.

    UndertowError where the recipes cannot be run at any node.
    """
    starts = [
        _first_sheet(case, rival, dict(zip(rival.node_names, node.tolist(), strict=True))) for node in rival.nodes
    ]
    sheets = [(sheet, returned) for sheet, returned in (one for one in starts if one is not None)]
    if not sheets:
        raise UndertowError(
            f"audit case {case.name}: the recipes cannot be run under {rival.label} at any of {rival.nodes.shape[0]} "
            "nodes; releases are too small for it"
        )
    best = min(_best_misfit(case, rival, sheet) for sheet, _ in sheets)
    near = [one for one in sheets if _best_misfit(case, rival, one[0]) < best + KEPT_BEHIND]
    refined = tuple(_refine(case, rival, sheet, returned) for sheet, returned in near)
    return Surface(rival, refined, rival.nodes.shape[0])


def _first_sheet(case: Case, rival: Rival, node: Mapping[str, float]) -> tuple[Sheet, tuple[Returned, ...]] | None:
    printed = printed_values(case)
    centre = np.array([unknown.centre for unknown in rival.unknowns])
    names = [unknown.name for unknown in rival.unknowns]
    resonating = 0.5 * sum(one.centre for one in rival.unknowns if one.name == "hidden_resonator.mass_kg")
    mass, drag = (
        float(np.median(column[np.isfinite(column)])) if np.isfinite(column).any() else 1.0 for column in printed.T
    )
    for i, name in enumerate(names):
        if name.startswith("added_mass_kg"):
            centre[i] = max(mass - resonating, 1.0)
        elif name == "drag_coefficient":
            centre[i] = 0.5 * max(drag, SMALLEST_DRAG)
    return _sheet(case, rival, node, centre, None)


def _sheet(
    case: Case, rival: Rival, node: Mapping[str, float], centre: Array, starts: tuple[Returned, ...] | None
) -> tuple[Sheet, tuple[Returned, ...]] | None:
    """The surface linearised at ``centre``; None where the motion there sticks or leaves every bound."""
    names = [unknown.name for unknown in rival.unknowns]
    # a resonator may make two minima: only there are all masses searched
    if starts is None and not node:
        starts = tuple(Returned(max(r.added_mass_kg, 0.0), r.drag_coefficient, r.drag_coefficient) for r in _sane(case))
    try:
        here = case_returns(case, {**node, **dict(zip(names, centre.tolist(), strict=True))}, starts)
        values = printed_columns(case, here)
        slopes = np.zeros((*values.shape, len(names)))
        for i, unknown in enumerate(rival.unknowns):
            step = STEP_SHARE * unknown.scale * (-1.0 if centre[i] + STEP_SHARE * unknown.scale > unknown.high else 1.0)
            if step == 0.0:
                continue
            moved = centre.copy()
            moved[i] += step
            there = _moved(case, {**node, **dict(zip(names, moved.tolist(), strict=True))}, here, unknown.name)
            slopes[:, :, i] = (printed_columns(case, there) - values) / step
    except UndertowError:
        return None
    sheet = Sheet(node, centre, values, slopes, 0.0)
    return sheet, here


def _moved(
    case: Case, values: Mapping[str, float], here: tuple[Returned, ...], name: str
) -> tuple[Returned, ...]:
    """What the recipes return with one unknown moved; rows of springs that it does not belong to stay as they are."""
    owner = name.partition(".")[2] if name.partition(".")[2] in case.springs else ""
    return tuple(
        row_returns(case, row, values, near) if owner in ("", row.spring) else near
        for row, near in zip(case.rows, here, strict=True)
    )


def _sane(case: Case) -> tuple[Returned, ...]:
    return tuple(
        Returned(*np.nan_to_num([row.added_mass_kg, row.drag_coefficient], nan=1.0).tolist()) for row in case.rows
    )


def printed_columns(case: Case, returned: tuple[Returned, ...]) -> Array:
    """What would be printed, (rows, 2): m_a without its bound, C_d at m_a = 0 where the printed one is on the bound."""
    drags = [
        one.bounded_drag if row.on_bound else one.drag_coefficient for row, one in zip(case.rows, returned, strict=True)
    ]
    return np.column_stack([[one.added_mass_kg for one in returned], drags])


def best_point(case: Case, rival: Rival, sheet: Sheet) -> tuple[Array, float]:
    """The unknowns (L,) that bring the linear surface closest to the print within their bounds and priors;
    chi-square."""
    printed, weights = printed_values(case), fit_weights(case)
    target = printed - sheet.values
    bound = np.array([row.on_bound for row in case.rows])
    # on the bound any m_a below 0 prints 0: only what lies above counts
    below = bound & (sheet.values[:, 0] < 0.0)
    target[below, 0] = np.nan
    use = np.isfinite(target)
    matrix = (sheet.slopes / weights[:, :, None])[use]
    goal = (target / weights)[use]
    normal = np.array([unknown.normal for unknown in rival.unknowns])
    deviations = np.array([unknown.deviation for unknown in rival.unknowns])
    extra = np.diag(np.where(normal, 1.0 / np.where(normal, np.maximum(deviations, 1e-30), 1.0), 0.0))[normal]
    means = np.array([unknown.mean for unknown in rival.unknowns])
    prior_goal = ((means - sheet.centre) / np.where(normal, np.maximum(deviations, 1e-30), 1.0))[normal]
    low, high = (np.array(limits) for limits in zip(*(_limits(unknown) for unknown in rival.unknowns), strict=True))
    scale = np.array([max(unknown.scale, 1e-30) for unknown in rival.unknowns])
    rows = np.vstack([matrix, extra]) * scale
    found = lsq_linear(
        rows,
        np.concatenate([goal, prior_goal]),
        bounds=((low - sheet.centre) / scale - 1e-9, (high - sheet.centre) / scale + 1e-9),
    )
    return np.clip(sheet.centre + found.x * scale, low, high), 2.0 * float(found.cost)


def _limits(unknown: Unknown) -> tuple[float, float]:
    if not unknown.normal:
        return unknown.low, unknown.high
    reach = WIDE * max(unknown.deviation, 1e-30)
    return max(unknown.low, unknown.mean - reach), min(unknown.high, unknown.mean + reach)


def _best_misfit(case: Case, rival: Rival, sheet: Sheet) -> float:
    return best_point(case, rival, sheet)[1]


def _refine(case: Case, rival: Rival, sheet: Sheet, returned: tuple[Returned, ...]) -> Sheet:
    """Gauss-Newton from a sheet, steps halved until the recipes' own answers come closer to the print."""
    scale = np.array([max(unknown.scale, 1e-30) for unknown in rival.unknowns])
    names = [unknown.name for unknown in rival.unknowns]
    here = _misfit(case, rival, sheet.centre, sheet.values)
    for _ in range(ROUNDS):
        move = best_point(case, rival, sheet)[0] - sheet.centre
        for _ in range(HALVINGS):
            target = sheet.centre + move
            try:
                reached = case_returns(case, {**sheet.node, **dict(zip(names, target.tolist(), strict=True))}, returned)
                there = _misfit(case, rival, target, printed_columns(case, reached))
            except UndertowError:
                there = np.inf
            if there < here:
                break
            move = 0.5 * move
        if not there < here or np.max(np.abs(move) / scale) < SETTLED:
            break
        moved = _sheet(case, rival, sheet.node, target, reached)
        if moved is None:
            break
        (sheet, returned), here = moved, there
    return replace(sheet, misfit=best_point(case, rival, sheet)[1])


def _misfit(case: Case, rival: Rival, centre: Array, values: Array) -> float:
    """Chi-square (2,) of the recipes' answers and of the normal priors, weighed as while fitting."""
    gap = (printed_values(case) - values) / fit_weights(case)
    for i, row in enumerate(case.rows):
        if row.on_bound:
            gap[i, 0] = max(values[i, 0], 0.0) / (FIT_MASS_SHARE * case.mass_kg)
    prior = [(x - one.mean) / one.deviation for x, one in zip(centre, rival.unknowns, strict=True) if one.normal]
    return float(np.nansum(gap**2)) + float(np.sum(np.square(prior)))
