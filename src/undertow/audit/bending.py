"""A sheet of an answer surface bent around a posterior: a quadratic through the recipes' own answers at its draws.

Its misfit at those draws is the surface's own error and part of every likelihood (posterior.py).

Belongs here: the quadratic, and through which draws. Does not belong here: where it is centred (surface.py), points
that no quadratic holds (exploring.py).
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from undertow.audit.case import PrintedCase, case_returns
from undertow.audit.posterior import posterior, weigh
from undertow.audit.recipes import Array, Returned
from undertow.audit.rivals import Rival
from undertow.audit.scatter import log_belief, log_sum
from undertow.audit.surface import Sheet, Surface, fitted_sheets, printed_columns
from undertow.errors import UndertowError

BENT_FROM = 1.6
"""Draws through which a surface is bent, for each coefficient of the quadratic."""

BENT_LEAST = 0.05
"""Least width of those draws over an unknown's scale."""

BENT_SHARE = 0.1
"""Sheets with less of the posterior than this stay flat."""

BENT_WIDER = 1.4
"""The draws are spread by this much around their mean, so that the quadratic holds beyond them."""

PREFERRED = 0.02
"""Pieces with more of the posterior than this are cut in three, ..."""

MOST_PREFERRED = 3
"""... unless there are more of them than this: then the answers hardly bend with what is split."""

POINTS_PER_COEFFICIENT = 1.4
"""A quadratic is only taken through this many points for each of its coefficients."""


def _pairs(rival: Rival) -> list[tuple[int, int]]:
    return [
        (i, j)
        for i, one in enumerate(rival.unknowns)
        for j, other in enumerate(rival.unknowns[: i + 1])
        if one.bends and other.bends
    ]


def coefficients(rival: Rival) -> int:
    """How many coefficients a bent sheet of a rival has: one, each unknown, products of those that bend."""
    return 1 + len(rival.unknowns) + len(_pairs(rival))


def bend(case: PrintedCase, rival: Rival, sheet: Sheet, points: Array) -> Sheet:
    """The sheet as a quadratic about the middle of ``points`` (n, L) through the recipes' own answers there, with its
    errors.

    Products of the unknowns that bend are taken; points at which a recipe cannot be run are left out, and
    with too few of them left the sheet stays as it is.
    """
    names = [unknown.name for unknown in rival.unknowns]
    near = tuple(Returned(float(mass), float(drag), float(drag)) for mass, drag in np.nan_to_num(sheet.values, nan=1.0))
    exact, kept = [], []
    for point in points:
        try:
            exact.append(printed_columns(case, case_returns(case, rival.values(point), near)))
        except UndertowError:
            continue
        kept.append(point)
    scale = np.array([max(unknown.scale, 1e-30) for unknown in rival.unknowns])
    pairs = _pairs(rival)
    if len(kept) < POINTS_PER_COEFFICIENT * coefficients(rival):
        return sheet
    middle = np.mean(kept, axis=0)
    away = (np.array(kept) - middle) / scale
    columns = np.column_stack([np.ones(len(kept)), away, *(away[:, i] * away[:, j] for i, j in pairs)])
    answers = np.array(exact).reshape(len(kept), -1)
    fitted, _, rank, _ = np.linalg.lstsq(columns, answers, rcond=1e-10)
    spare = max(len(kept) - int(rank), 1)
    errors = np.sqrt(np.sum((answers - columns @ fitted) ** 2, axis=0) / spare)
    shape = sheet.values.shape
    slopes = (fitted[1 : 1 + len(names)] / scale[:, None]).T.reshape(*shape, len(names))
    curves = np.zeros((*shape, len(names), len(names)))
    for (i, j), row in zip(pairs, fitted[1 + len(names) :], strict=True):
        curves[:, :, i, j] = row.reshape(shape) / (scale[i] * scale[j])
    return replace(
        sheet, centre=middle, values=fitted[0].reshape(shape), slopes=slopes, curves=curves,
        errors=errors.reshape(shape),
    )  # fmt: skip


def bent_surface(case: PrintedCase, surface: Surface, seed: int = 0) -> Surface:
    """A surface whose preferred sheets are bent through the recipes at draws of its own first posterior."""
    rival = surface.rival
    if rival.split:
        surface = _finer(case, surface, seed)
    first = posterior(weigh(case, surface, seed), seed)
    sheets = []
    for j, sheet in enumerate(surface.sheets):
        own = np.flatnonzero(first.sheets == j)
        if own.size < BENT_SHARE * first.sheets.size:
            sheets.append(sheet)
            continue
        inside = rival.within(sheet.cell)
        sheets.append(bend(case, inside, sheet, _around(inside, first.points[own], seed)))
    return replace(surface, sheets=tuple(sheets))


def _around(rival: Rival, draws: Array, seed: int) -> Array:
    """Points (n, L) spread as ``draws`` of a posterior are, a little wider, within the ranges."""
    scale = np.array([max(unknown.scale, 1e-30) for unknown in rival.unknowns])
    spread = np.cov(draws / scale, rowvar=False) + BENT_LEAST**2 * np.eye(scale.size)
    normal_draws = np.random.default_rng(seed).standard_normal((int(BENT_FROM * coefficients(rival)), scale.size))
    points = draws.mean(axis=0) + BENT_WIDER * scale * (normal_draws @ np.linalg.cholesky(spread).T)
    low, high = (np.array([getattr(unknown, end) for unknown in rival.unknowns]) for end in ("low", "high"))
    return np.asarray(np.clip(points, low, high), dtype=np.float64)


def _finer(case: PrintedCase, surface: Surface, seed: int) -> Surface:
    """Where the table prefers few pieces they are cut in three; every sheet then knows its share of the prior."""
    rival = surface.rival
    first = weigh(case, surface, seed)
    share = np.array([log_sum((log_belief()[:, None] + first.logs[:, j]).ravel()) for j in range(len(surface.sheets))])
    preferred = np.exp(share - log_sum(share)) > PREFERRED
    sheets: list[Sheet] = []
    for sheet, cut in zip(surface.sheets, preferred.tolist(), strict=True):
        if not cut or preferred.sum() > MOST_PREFERRED or sheet.cell is None:
            sheets.append(sheet)
            continue
        edges = np.linspace(*sheet.cell, 4).tolist()
        try:
            sheets += fitted_sheets(case, rival, list(pairwise(edges)), sheet.centre)
        except UndertowError:
            sheets.append(sheet)
    whole = float(rival.edges[-1] - rival.edges[0])
    return Surface(rival, tuple(
        replace(sheet, log_share=math.log((sheet.cell[1] - sheet.cell[0]) / whole)) if sheet.cell else sheet
        for sheet in sheets
    ))  # fmt: skip
