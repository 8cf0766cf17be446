"""A sheet of an answer surface bent around a posterior: a quadratic through the recipes' own answers at its draws.

Its misfit at those draws is the surface's own error and part of every likelihood (posterior.py).

Belongs here: the quadratic. Does not belong here: where it is centred (surface.py), which draws (answer.py).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from undertow.discrepancy.audit.case import Case, case_returns
from undertow.discrepancy.audit.recipes import Array, Returned
from undertow.discrepancy.audit.rivals import Rival
from undertow.discrepancy.audit.surface import Sheet, printed_columns
from undertow.errors import UndertowError

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


def bend(case: Case, rival: Rival, sheet: Sheet, points: Array) -> Sheet:
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
