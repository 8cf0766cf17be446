"""Output error of Eq. 15 compiled as a whole: Levenberg-Marquardt over growing windows in one call.

What output_error.py does for every equation, done for the commonest without going back to Python between steps.

Belongs here: the compiled search. Does not belong here: residuals (eq15_rows.py), integration (taylor_series.py),
windows and outcomes (output_error.py).
"""

# mypy: disable-error-code="no-untyped-def, misc, untyped-decorator"

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from undertow.compiling import compiled
from undertow.equation.taylor_series import Places
from undertow.equation.term import Array
from undertow.likelihood.eq15_rows import (
    INNER,
    Arrays,
    evaluate,
    follow,
    points_room,
    room_for,
    rows_of,
    spread_of_data,
    unknowns_in,
)

_SHEET = (
    "Tuple((f8[::1], f8[:,::1], i8[:,::1], f8[:,::1], i8[:,::1], f8[::1], i8[:,::1], f8[::1], f8[::1], f8[:,::1]))"
)
_FOUND = "Tuple((f8[::1], f8, f8, i8, i8, f8[::1], f8[:,::1], f8[:,::1], f8[:,::1]))"
"""numba's types of a sheet (eq15.py) and of what `search` gives."""
_LOWER, _UPPER = 0, 1
_OPT: dict[str, Any] = {"error_model": "numpy", "nogil": True}
_EARLY_STOP = 2.0
"""A window that is not the whole record has done its work within so many of its standard errors: the step is taken, and
the next window, which knows more, looks at where it led."""
_CLOSING = 10.0
"""A full Gauss-Newton step within so many times the stop ends the search: what it leaves is of the order of its square,
and residuals and cost follow it along their slopes."""
_WELL_KNOWN = 1e8
"""Largest condition of the normal equations, in units of their diagonal, at which they are inverted at once."""
_NEAR = (1.3, 0.01)
"""A window that is done is followed by the whole record at once where the square of the residual there is no more than
so many times the noise's and a hundredth of the motion's: since costs only fall, it cannot end in a worse valley (one
that sticks a turn too early leaves 1.7 times the noise's and more). Else one twice as long follows."""


@njit(**INNER)
def _factor(normal, damping, free, scale, a):
    """Cholesky factor of the damped normal equations of the free unknowns in units of ``scale``; False: it has none."""
    size = scale.size
    for i in range(size):
        for j in range(i + 1):
            a[i, j] = normal[i, j] * scale[i] * scale[j] if free[i] and free[j] else 0.0
        a[i, i] = max(a[i, i], 1e-30) * (1.0 + damping) if free[i] else 1.0
    for i in range(size):
        for j in range(i + 1):
            total = a[i, j]
            for m in range(j):
                total -= a[i, m] * a[j, m]
            if i > j:
                a[i, j] = total / a[j, j]
            elif total > 1e-15 * a[i, i]:
                a[i, i] = math.sqrt(total)
            else:
                return False
    return True


@njit(**INNER)
def _solve(a, gradient, free, scale, step):
    """Step of the free unknowns that takes the gradient away, by the factor ``a``."""
    size = scale.size
    for i in range(size):
        total = -scale[i] * gradient[i] if free[i] else 0.0
        for m in range(i):
            total -= a[i, m] * step[m]
        step[i] = total / a[i, i]
    for i in range(size - 1, -1, -1):
        total = step[i]
        for m in range(i + 1, size):
            total -= a[m, i] * step[m]
        step[i] = total / a[i, i]
    for i in range(size):
        step[i] *= scale[i]


@njit(**_OPT)
def _inverse(normal, a):
    """Inverse of the normal equations; empty where they are all but singular."""
    size = normal.shape[0]
    inverse, nothing, gradient = np.empty((size, size)), np.empty((0, 0)), np.empty(size)
    scale, free = np.empty(size), np.empty(size, dtype=np.bool_)
    for i in range(size):
        gradient[i], free[i] = 0.0, True
        if not normal[i, i] > 0.0:
            return nothing
        scale[i] = 1.0 / math.sqrt(normal[i, i])
    if not _factor(normal, 0.0, free, scale, a):
        return nothing
    spread = 0.0  # trace of the scaled inverse: with the scaled trace, p, it bounds the condition
    for i in range(size):
        gradient[i] = -1.0
        _solve(a, gradient, free, scale, inverse[i])
        gradient[i] = 0.0
        spread += inverse[i, i] / scale[i] ** 2
    if not size * spread < _WELL_KNOWN:
        return nothing
    for i in range(size):
        for j in range(i):
            inverse[i, j] = inverse[j, i] = 0.5 * (inverse[i, j] + inverse[j, i])
    return inverse


@njit(**INNER)
def _scale_and_free(here, values, box, scale, free):
    """Each unknown's step that changes the cost by one, and whether it may move: not further out of its bounds."""
    for i in range(values.size):
        scale[i] = 1.0 / math.sqrt(max(here[2][i, i], 1e-300))
        low, high = values[i] <= box[_LOWER, i], values[i] >= box[_UPPER, i]
        free[i] = not ((low and here[3][i] > 0.0) or (high and here[3][i] < 0.0))


@njit(**INNER)
def _moved(box, values, step, scale, new):
    """The values after a step, or the bounds that they pass; the step so taken, and its size in standard errors."""
    far = 0.0
    for i in range(values.size):
        new[i] = min(max(values[i] + step[i], box[_LOWER, i]), box[_UPPER, i])
        step[i] = new[i] - values[i]
        far = max(far, abs(step[i]) / scale[i])
    return far


@compiled(f"{_FOUND}({_SHEET}, i8[:,::1], f8[::1], f8[::1], i8, f8, f8)", **_OPT)
def search(
    sheet: Arrays, columns: Places, start: Array, windows: Array, iterations: int, stop: float, first_damping: float
) -> Arrays:
    """Levenberg-Marquardt over growing ``windows`` (w,) s as output_error's, to ``stop`` standard errors.

    Gives values, cost, chi2, iterations, whether the last window converged (-1: no motion at the start of a window, or
    normal equations that Cholesky cannot solve: left to the general search), residuals, Jacobian and normal equations
    of the last window and the inverse of these, empty where it needs care.
    """
    box = sheet[9]
    size = start.size
    values, new = np.empty(size), np.empty(size)
    a, step, scale = np.empty((size, size)), np.zeros(size), np.ones(size)
    _moved(box, start, step, scale, values)
    room, rows = room_for(sheet, values), rows_of(sheet)
    widest = np.int64(0)  # not a literal, for whose type points_room would be compiled once more
    for trial in range(columns.shape[0]):
        widest = max(widest, unknowns_in(columns[trial], room[-1]))
    here, there = points_room(rows, widest, size), points_room(rows, widest, size)
    nothing = np.empty((0, 0))
    free = np.empty(size, dtype=np.bool_)
    spent, done, cost, chi2 = 0, 0, 0.0, 0.0
    near = min(_NEAR[0] * rows, _NEAR[1] * spread_of_data(sheet))
    stage, last, tried = 0, windows.size - 1, False
    while stage <= last:
        ahead = done == 1 and stage < last and not tried
        precise = ahead or stage == last
        window = windows[last if precise else stage]
        cost, chi2 = evaluate(sheet, columns, values, window, precise, room, here)
        tried = ahead and not 0.0 <= chi2 <= near
        if tried:
            continue
        stage, enough = (last + 1, stop) if precise else (stage + 1, max(stop, _EARLY_STOP))
        if cost < 0.0:
            return values, cost, chi2, spent, -1, here[0], here[1], here[2], nothing
        damping = first_damping
        done = 0
        for _ in range(iterations):
            spent += 1
            _scale_and_free(here, values, box, scale, free)
            if not _factor(here[2], damping, free, scale, a):
                return values, cost, chi2, spent, -1, here[0], here[1], here[2], nothing
            _solve(a, here[3], free, scale, step)
            moved = _moved(box, values, step, scale, new)
            if moved < (_CLOSING * enough if precise and damping <= first_damping else enough):
                if precise:  # so short a step needs no proof: the next window looks again, the last one follows it
                    cost, chi2 = follow(sheet, columns, step, cost, room, here)
                values, new = new, values
                done = 1
                break
            new_cost, new_chi2 = evaluate(sheet, columns, new, window, precise, room, there)
            if new_cost >= 0.0 and new_cost <= cost * (1.0 + 1e-14):
                gained = cost - new_cost
                values, new, cost, chi2 = new, values, new_cost, new_chi2
                here, there = there, here
                damping = max(damping * 0.1, 1e-15)
                if gained < 1e-10 * cost:
                    done = 1
                    break
            else:
                damping = max(damping * 8.0, 1e-6)
                if damping > 1e12:
                    done = 1
                    break
    return values, cost, chi2, spent, done, here[0], here[1], here[2], _inverse(here[2], a)
