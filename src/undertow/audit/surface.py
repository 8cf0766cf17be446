"""A rival's answer surface: what the recipes would print, as a function of the rival's unknowns, near the table.

In every piece of a rival's range (of a resonator's frequencies; one piece elsewhere) the unknowns are fitted to the
printed numbers by Gauss-Newton through the recipes themselves; what the recipes return there, with its slopes, is the
surface that posterior.py integrates.

Belongs here: fitting and linearising through the recipes. Does not belong here: bending (bending.py), evidence, draws.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.optimize import lsq_linear

from undertow.audit.case import PrintedCase, case_returns, row_returns
from undertow.audit.effects import RESONATOR_MASS
from undertow.audit.recipes import SLOPE_STEPS, Array, Returned
from undertow.audit.rivals import Rival, RivalUnknown
from undertow.errors import UndertowError

FIT_MASS_SHARE = 0.02
"""Weight of an added mass while fitting: this share of the structure's mass counts as one."""

FIT_DRAG_SHARE = 0.1
"""Weight of a drag coefficient while fitting: this share of it counts as one."""

SMALLEST_DRAG = 0.5
"""Drag coefficients below this are weighed as this."""

ROUNDS = 6
PASSES = 2
"""Times that slopes are taken anew; between them they follow the answers by Broyden's update."""

HALVINGS = 4
SETTLED = 0.05
"""Fitting ends when no unknown moves by more than this share of its scale."""

STEP_SHARE = 0.05
"""Step of a slope over the unknown's scale."""

STRAIGHT_STEP = 1.0
"""The same of an unknown in which answers do not bend: less would drown in what a search leaves."""

WIDE = 1e3
"""Standard deviations within which an unbounded unknown is searched."""

KEPT_BEHIND = 60.0
"""Pieces whose misfit (chi-square) lies further behind the best one's are not refined: e^-30 of its weight."""


CLOSER = 3.0
"""A neighbour whose misfit is better by this much is worth starting from."""


PINNED_STEPS = 2
"""Steps of the other unknowns where some are pinned: in those the answers are nearly straight."""


@dataclass(frozen=True)
class Sheet:
    """The surface in one piece: ``centre`` (L,), what is printed there ``values`` (rows, 2), ``slopes`` (rows, 2, L).

    Columns are m_a (without bound; kg) and C_d (at m_a = 0 where the printed one is on the bound). ``misfit`` is the
    chi-square of the fit, ``cell`` the piece of the rival's split range, None where there is one.
    """

    cell: tuple[float, float] | None
    centre: Array
    values: Array
    slopes: Array
    misfit: float
    curves: Array | None = None
    """Second derivatives (rows, 2, L, L) over two, where the sheet was bent."""
    log_share: float = 0.0
    """Logarithm of the share of the prior that the piece holds."""
    errors: Array | None = None
    """Root-mean-square misfit (rows, 2) of the bent sheet at the points it was bent through."""
    pinned: tuple[int, ...] = ()
    """Unknowns that stand fast on this sheet: it is one point of a cloud in them (exploring.py)."""

    def predict(self, points: Array) -> Array:
        """What is printed (n, rows, 2) at points (n, L)."""
        away = points - self.centre
        answers = away @ self.slopes.reshape(-1, away.shape[1]).T
        if self.curves is not None:
            at = np.nonzero(np.any(self.curves != 0.0, axis=(0, 1)))
            curves = self.curves[:, :, at[0], at[1]].reshape(answers.shape[1], -1)
            answers += (away[:, at[0]] * away[:, at[1]]) @ curves.T
        found: Array = self.values + answers.reshape(-1, *self.values.shape)
        return found


@dataclass(frozen=True)
class Surface:
    """The sheets of one rival; pieces far behind the best are left out."""

    rival: Rival
    sheets: tuple[Sheet, ...]


def printed_values(case: PrintedCase) -> Array:
    """Printed (m_a, C_d) of every row, (rows, 2), nan where there is none."""
    return np.array([[row.added_mass_kg, row.drag_coefficient] for row in case.rows])


def structure_covariances(case: PrintedCase, rival: Rival, sheet: Sheet) -> Array:
    """What the scatter of k, c, mu from trial to trial does to each printed pair, (rows, 2, 2), by the sheet's
    slopes."""
    names = [unknown.name for unknown in rival.unknowns]
    found = np.zeros((len(case.rows), 2, 2))
    for i, row in enumerate(case.rows):
        dry = case.structures[row.spring]
        for short, deviation in (("k", dry.k_scatter), ("c", dry.c_scatter), ("mu", dry.mu_scatter)):
            slope = sheet.slopes[i, :, names.index(f"{short}.{row.spring}")] * deviation
            found[i] += np.outer(slope, slope)
    return found


def _whitening(case: PrintedCase, rival: Rival, sheet: Sheet) -> Array:
    """Matrices (rows, 2, 2) that bring a fit's misses to one standard deviation: the structure's scatter and a round
    share of m_a and C_d; what is not printed or on its bound is not mixed with the other column."""
    printed = printed_values(case)
    drag = FIT_DRAG_SHARE * np.maximum(np.abs(np.nan_to_num(printed[:, 1])), SMALLEST_DRAG)
    found = structure_covariances(case, rival, sheet)
    found[:, 0, 0] += (FIT_MASS_SHARE * case.mass_kg) ** 2
    found[:, 1, 1] += drag**2
    alone = ~np.isfinite(printed).all(axis=1) | np.array([row.on_bound for row in case.rows])
    found[alone, 0, 1] = found[alone, 1, 0] = 0.0
    return np.asarray(np.linalg.inv(np.linalg.cholesky(found)), dtype=np.float64)


def build_surface(case: PrintedCase, rival: Rival) -> Surface:
    """The surface of one rival over all its pieces. UndertowError where the recipes cannot be run in any."""
    edges = rival.edges.tolist()
    cells = list(pairwise(edges)) if edges else [None]
    return Surface(rival, fitted_sheets(case, rival, cells))


def fitted_sheets(
    case: PrintedCase, rival: Rival, cells: Sequence[tuple[float, float] | None], start: Array | None = None
) -> tuple[Sheet, ...]:
    """Sheets in some pieces of a rival's range; those far behind the best after the first round are left out.

    ``start`` (L,) is a point to fit from. UndertowError where the recipes cannot be run in any of them.
    """
    first = [_first_sheet(case, rival.within(cell), cell, start) for cell in cells]
    sheets = [one for one in first if one is not None]
    if not sheets:
        raise UndertowError(
            f"audit case {case.name}: the recipes cannot be run under {rival.label} in any of {len(cells)} ranges; "
            "releases are too small for it"
        )
    misfits = [best_point(case, rival.within(sheet.cell), sheet)[1] for sheet, _ in sheets]
    refined = [
        _refine(case, rival.within(sheet.cell), sheet, returned)
        for (sheet, returned), misfit in zip(sheets, misfits, strict=True)
        if misfit < min(misfits) + KEPT_BEHIND
    ]
    return tuple(_from_neighbours(case, rival, refined))


def _from_neighbours(case: PrintedCase, rival: Rival, sheets: list[Sheet]) -> list[Sheet]:
    """Sheets fitted again from a neighbour's point where the neighbour came much closer: fits end in local minima."""
    found = list(sheets)
    order = list(range(len(found)))
    for i, j in [*pairwise(order), *pairwise(order[::-1])]:
        if found[i].misfit + CLOSER > found[j].misfit:
            continue
        inside = rival.within(found[j].cell)
        again = _first_sheet(case, inside, found[j].cell, found[i].centre)
        if again is not None:
            better = _refine(case, inside, *again)
            found[j] = better if better.misfit < found[j].misfit else found[j]
    return found


def pinned_sheet(
    case: PrintedCase, rival: Rival, start: Array, pinned: tuple[int, ...], slopes: Array | None
) -> Sheet | None:
    """The surface with some unknowns pinned where ``start`` (L,) has them, the others brought to the print from there;
    None where a recipe cannot be run. ``slopes`` (rows, 2, L) are those of a point near by; None takes them anew."""
    at = start.tolist()
    held = replace(rival, unknowns=tuple(
        replace(one, low=at[i], high=at[i]) if i in pinned else one for i, one in enumerate(rival.unknowns)
    ))  # fmt: skip
    sheet = Sheet(None, start, np.zeros((len(case.rows), 2)), np.zeros(0), 0.0, pinned=pinned)
    try:
        sheet = replace(sheet, values=_at_print(case, held, start))
        if slopes is None:
            made = _sheet(case, held, None, start, None)
            if made is None:
                return None
            sheet = replace(made[0], pinned=pinned)
        else:
            sheet = replace(sheet, slopes=slopes)
        for _ in range(PINNED_STEPS):
            centre, misfit = best_point(case, held, sheet)
            centre[list(pinned)] = start[list(pinned)]
            sheet = replace(sheet, centre=centre, values=_at_print(case, held, centre), misfit=misfit)
    except UndertowError:
        return None
    return sheet


def _at_print(case: PrintedCase, rival: Rival, point: Array) -> Array:
    return printed_columns(case, case_returns(case, rival.values(point), at_print(case)))


def _first_sheet(
    case: PrintedCase, rival: Rival, cell: tuple[float, float] | None, start: Array | None
) -> tuple[Sheet, tuple[Returned, ...]] | None:
    if start is not None:
        low, high = (np.array([getattr(one, end) for one in rival.unknowns]) for end in ("low", "high"))
        return _sheet(case, rival, cell, np.clip(start, low, high), None)
    printed = printed_values(case)
    centre = np.array([unknown.centre for unknown in rival.unknowns])
    names = [unknown.name for unknown in rival.unknowns]
    resonating = 0.5 * rival.values(centre).get(RESONATOR_MASS, 0.0)
    mass, drag = (
        float(np.median(column[np.isfinite(column)])) if np.isfinite(column).any() else 1.0 for column in printed.T
    )
    for i, name in enumerate(names):
        if name.startswith("added_mass_kg"):
            centre[i] = max(mass - resonating, 1.0)
        elif name == "drag_coefficient":
            centre[i] = 0.5 * max(drag, SMALLEST_DRAG)
    return _sheet(case, rival, cell, centre, None)


def _sheet(
    case: PrintedCase,
    rival: Rival,
    cell: tuple[float, float] | None,
    centre: Array,
    starts: tuple[Returned, ...] | None,
) -> tuple[Sheet, tuple[Returned, ...]] | None:
    """The surface linearised at ``centre``; None where the motion there sticks or leaves every bound."""
    names = [unknown.name for unknown in rival.unknowns]
    # a resonator may make two minima: only there are all masses searched
    if starts is None and cell is None:
        starts = at_print(case)
    try:
        here = case_returns(case, rival.values(centre), starts)
        values = printed_columns(case, here)
        slopes = np.zeros((*values.shape, len(names)))
        for i, unknown in enumerate(rival.unknowns):
            step = (STEP_SHARE if unknown.bends else STRAIGHT_STEP) * unknown.scale
            step = -step if centre[i] + step > unknown.high else step
            if step == 0.0:
                continue
            moved = centre.copy()
            moved[i] += step
            there = _moved(case, rival.values(moved), here, unknown.name)
            slopes[:, :, i] = (printed_columns(case, there) - values) / step
    except UndertowError:
        return None
    sheet = Sheet(cell, centre, values, slopes, 0.0)
    return sheet, here


def _moved(
    case: PrintedCase, values: Mapping[str, float], here: tuple[Returned, ...], name: str
) -> tuple[Returned, ...]:
    """What the recipes return with one unknown moved; rows of springs that it does not belong to stay as they are."""
    owner = name.partition(".")[2] if name.partition(".")[2] in case.springs else ""
    return tuple(
        row_returns(case, row, values, near, SLOPE_STEPS) if owner in ("", row.spring) else near
        for row, near in zip(case.rows, here, strict=True)
    )


def at_print(case: PrintedCase) -> tuple[Returned, ...]:
    """The printed answers as a start of the recipes: where there are two minima, the printed one is found from here."""
    printed = np.nan_to_num(printed_values(case), nan=1.0).tolist()
    return tuple(Returned(max(mass, 0.0), drag, drag) for mass, drag in printed)


def printed_columns(case: PrintedCase, returned: tuple[Returned, ...]) -> Array:
    """What would be printed, (rows, 2): m_a without its bound, C_d at m_a = 0 where the printed one is on the bound."""
    drags = [
        one.bounded_drag if row.on_bound else one.drag_coefficient for row, one in zip(case.rows, returned, strict=True)
    ]
    return np.column_stack([[one.added_mass_kg for one in returned], drags])


def best_point(case: PrintedCase, rival: Rival, sheet: Sheet) -> tuple[Array, float]:
    """The unknowns (L,) that bring the linear surface closest to the print within their bounds and priors;
    chi-square."""
    target = printed_values(case) - sheet.values
    # on the bound any m_a below 0 prints 0: only what lies above counts
    target[np.array([row.on_bound for row in case.rows]) & (sheet.values[:, 0] < 0.0), 0] = np.nan
    use = np.isfinite(target)
    white = _whitening(case, rival, sheet)
    matrix = (white @ sheet.slopes)[use]
    goal = np.einsum("rcd,rd->rc", white, np.nan_to_num(target))[use]
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
        method="bvls",
    )
    return np.clip(sheet.centre + found.x * scale, low, high), 2.0 * float(found.cost)


def _limits(unknown: RivalUnknown) -> tuple[float, float]:
    if not unknown.normal:
        return unknown.low, unknown.high
    reach = WIDE * max(unknown.deviation, 1e-30)
    return max(unknown.low, unknown.mean - reach), min(unknown.high, unknown.mean + reach)


def _refine(case: PrintedCase, rival: Rival, sheet: Sheet, returned: tuple[Returned, ...]) -> Sheet:
    """Gauss-Newton from a sheet, slopes taken anew at the end of each pass until the last one hardly moves."""
    scale = np.array([max(unknown.scale, 1e-30) for unknown in rival.unknowns])
    for _ in range(PASSES):
        moved, reached = _descend(case, rival, sheet, returned)
        if moved is sheet:
            break
        far = float(np.max(np.abs(moved.centre - sheet.centre) / scale))
        anew = _sheet(case, rival, sheet.cell, moved.centre, reached)
        if anew is None:
            break
        sheet, returned = anew
        if far < SETTLED:
            break
    return replace(sheet, misfit=best_point(case, rival, sheet)[1])


def _descend(
    case: PrintedCase, rival: Rival, sheet: Sheet, returned: tuple[Returned, ...]
) -> tuple[Sheet, tuple[Returned, ...]]:
    """One pass: steps halved until the recipes' own answers come closer to the print, slopes by Broyden's update.

    The same sheet where no step comes closer.
    """
    scale = np.array([max(unknown.scale, 1e-30) for unknown in rival.unknowns])
    white = _whitening(case, rival, sheet)
    here = _misfit(case, rival, white, sheet.centre, sheet.values)
    for _ in range(ROUNDS):
        move = best_point(case, rival, sheet)[0] - sheet.centre
        if np.max(np.abs(move) / scale) < SETTLED:
            break
        for _ in range(HALVINGS):
            target = sheet.centre + move
            try:
                reached = case_returns(case, rival.values(target), returned)
                values = printed_columns(case, reached)
                there = _misfit(case, rival, white, target, values)
            except UndertowError:
                there = np.inf
            if there < here:
                break
            move = 0.5 * move
        if not there < here:
            break
        step = move / scale
        missed = (values - sheet.values - sheet.slopes @ move)[:, :, None]
        slopes = sheet.slopes + missed * (step / scale) / float(step @ step)
        sheet, returned, here = Sheet(sheet.cell, target, values, slopes, 0.0), reached, there
    return sheet, returned


def _misfit(case: PrintedCase, rival: Rival, white: Array, centre: Array, values: Array) -> float:
    """Chi-square of the recipes' answers and of the normal priors, weighed as while fitting."""
    gap = printed_values(case) - values
    for i, row in enumerate(case.rows):
        if row.on_bound:
            gap[i, 0] = min(-values[i, 0], 0.0)
    weighed = np.einsum("rcd,rd->rc", white, np.nan_to_num(gap))
    prior = [(x - one.mean) / one.deviation for x, one in zip(centre, rival.unknowns, strict=True) if one.normal]
    return float(np.sum(weighed**2)) + float(np.sum(np.square(prior)))
