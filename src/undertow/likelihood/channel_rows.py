"""What a channel sees of a motion in cells, and its weighted residuals with their Jacobian, compiled.

Belongs here: those two loops, whose formulas observation_model.py and residuals.py state. Does not belong here: the
motion (residuals.py), Eq. 15's rows, which come from its series (eq15_rows.py).
"""

# mypy: disable-error-code="no-untyped-def, misc, untyped-decorator"

from __future__ import annotations

import math

from undertow.compiling import OPTIONS, compiled
from undertow.equation.taylor_series import Places
from undertow.recording.recording import Array

QUANTITIES = {"displacement": 0, "velocity": 1, "acceleration": 2}
"""Numbers of the quantities that a motion has by itself."""


@compiled(
    "void(i8, b1, i8, f8, f8, f8[::1], i8[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[::1])", **OPTIONS
)
def in_cells(
    quantity: int, averaged: bool, stride: int, width: float, swell: float, times: Array, place: Places,
    x: Array, v: Array, a: Array, levels: Array, rates: Array,
) -> None:
    """Fill ``levels`` (n, 1 + p) and ``rates`` (n,) with what a channel sees in cells of ``width`` s.

    ``times`` (k,) are the cells' edges by the channel's clock, begins ``stride`` apart; ``place`` (k,) is where each
    stands in the motion ``x``, ``v``, ``a``, each (m, 1 + p).
    """
    for row in range(rates.size):
        at = stride * row
        begin, end = place[at], place[at + 1]
        if quantity == 2:
            first = 1.0 if times[at] >= 0.0 else 0.0
            last = 1.0 if times[at + 1] >= 0.0 else 0.0
            rates[row] = (last * a[end, 0] - first * a[begin, 0]) / width
            turns = v[begin, 0] * v[end, 0] <= 0.0
            for c in range(levels.shape[1]):
                mean = (v[end, c] - v[begin, c]) / width
                if averaged:
                    levels[row, c] = mean
                elif turns:
                    levels[row, c] = mean * swell
                else:
                    levels[row, c] = 1.5 * mean - 0.25 * (first * a[begin, c] + last * a[end, c])
        elif quantity == 1:
            rates[row] = (v[end, 0] - v[begin, 0]) / width
            for c in range(levels.shape[1]):
                moved = (x[end, c] - x[begin, c]) / width
                levels[row, c] = moved if averaged else 1.5 * moved - 0.25 * (v[begin, c] + v[end, c])
        else:
            start = max(times[at], 0.0)
            span = max(times[at + 1], 0.0) - start
            rates[row] = (x[end, 0] - x[begin, 0]) / width
            share = (max(times[at] + 0.5 * width, 0.0) - start) / max(span, 2.2250738585072014e-308)
            rest = 1.0 - share
            for c in range(levels.shape[1]):
                if averaged:
                    area = 0.5 * span * (x[begin, c] + x[end, c]) - span**2 / 12.0 * (v[end, c] - v[begin, c])
                    levels[row, c] = (area + (width - span) * x[begin, c]) / width
                else:
                    bend = span * share * rest * (v[begin, c] * rest - v[end, c] * share)
                    place_of = x[begin, c] * rest**2 * (1.0 + 2.0 * share)
                    levels[row, c] = place_of + x[end, c] * share**2 * (1.0 + 2.0 * rest) + bend


@compiled(
    "void(f8[:,::1], f8[::1], f8[::1], f8[:,::1], i8[:,::1], f8[::1], i8[::1], f8[::1], f8, f8[::1], f8[:,::1])",
    **OPTIONS,
)
def weigh(
    levels: Array, rates: Array, data: Array, slow: Array, links: Places, factors: Array, columns: Places,
    nuisances: Array, weight: float, r: Array, jac: Array,
) -> None:
    """Fill the residual ``r`` (n,) of one channel and its rows ``jac`` (n, unknowns).

    ``links`` (l, 4) end with the columns of the motion and of the Jacobian, with ``factors`` (l,); ``columns`` (4 + d,)
    are those of the trial's clock, the channel's clock, offset and gain (-1: none) and its d degrees of drift,
    ``nuisances`` (2 + d,) the values of all but the clocks. ``slow`` (n, d or more) is what a drift of one is; data
    that are not a number say nothing.
    """
    offset, gain = nuisances[0], 1.0 + nuisances[1]
    for row in range(r.size):
        for c in range(jac.shape[1]):
            jac[row, c] = 0.0
        if math.isnan(data[row]):
            r[row] = 0.0
            continue
        level = gain * levels[row, 0] + offset - data[row]
        for i in range(factors.size):
            jac[row, links[i, 3]] += factors[i] * gain * weight * levels[row, links[i, 2]]
        for i in range(2):
            if columns[i] >= 0:
                jac[row, columns[i]] += gain * weight * rates[row]
        if columns[2] >= 0:
            jac[row, columns[2]] += weight
        if columns[3] >= 0:
            jac[row, columns[3]] += weight * levels[row, 0]
        for i in range(columns.size - 4):
            level += nuisances[2 + i] * slow[row, i]
            jac[row, columns[4 + i]] += weight * slow[row, i]
        r[row] = level * weight
