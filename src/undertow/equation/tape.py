"""A list of operations evaluated by one compiled function, with exact derivatives: the speed of laws that are not ours.

The list (tracing.py) is data: whatever law it stands for, the same compiled code runs through it, so that nothing is
generated, compiled or kept for a law. Derivatives go forward through every operation (dual numbers).

Belongs here: values and slopes of the operations. Does not belong here: how a list is made (tracing.py), motions
(tape_march.py).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from undertow.compiling import compiled
from undertow.equation.term import Array
from undertow.equation.tracing import NAMES

(_CONSTANT, _NUMBER, _X, _V, _T, _WHERE, _ADD, _SUB, _MUL, _DIV, _POW, _MAX, _MIN, _ATAN2, _HYPOT, _GT, _GE, _LT, _LE,
 _AND, _OR, _NEG, _POS, _ABS, _SIGN, _SQRT, _SQUARE, _INV, _EXP, _EXPM1, _LOG, _LOG1P, _SIN, _COS, _TAN, _SINH, _COSH,
 _TANH, _ASIN, _ACOS, _ATAN) = range(len(NAMES))  # fmt: skip

WITHIN: dict[str, Any] = {"error_model": "numpy", "nogil": True}
"""Options of the compiled functions: a division by zero is inf or nan, as in numpy."""


@njit(**WITHIN)
def _sign(a):  # type: ignore[no-untyped-def]
    return 1.0 if a > 0.0 else (-1.0 if a < 0.0 else 0.0 * a)


@njit(**WITHIN)
def _pair(op, a, b):  # type: ignore[no-untyped-def]
    """Value of an operation on two numbers, and its slopes by both."""
    if op == _ADD:
        return a + b, 1.0, 1.0
    if op == _SUB:
        return a - b, 1.0, -1.0
    if op == _MUL:
        return a * b, b, a
    if op == _DIV:
        return a / b, 1.0 / b, -a / (b * b)
    if op == _POW:
        if b == 2.0:
            return a * a, 2.0 * a, a * a * math.log(a) if a > 0.0 else 0.0
        value = a**b
        return value, b * a ** (b - 1.0), value * math.log(a) if a > 0.0 else 0.0
    if op == _MAX:
        return (a, 1.0, 0.0) if a >= b or a != a else (b, 0.0, 1.0)
    if op == _MIN:
        return (a, 1.0, 0.0) if a <= b or a != a else (b, 0.0, 1.0)
    if op == _ATAN2:
        square = a * a + b * b
        return math.atan2(a, b), b / square, -a / square
    if op == _HYPOT:
        value = math.hypot(a, b)
        return value, a / value, b / value
    if op == _GT:
        held = a > b
    elif op == _GE:
        held = a >= b
    elif op == _LT:
        held = a < b
    elif op == _LE:
        held = a <= b
    elif op == _AND:
        held = a != 0.0 and b != 0.0
    else:
        held = a != 0.0 or b != 0.0
    return 1.0 if held else 0.0, 0.0, 0.0


@njit(**WITHIN)
def _alone(op, a):  # type: ignore[no-untyped-def]
    """Value of an operation on one number, and its slope."""
    if op == _NEG:
        return -a, -1.0
    if op == _POS:
        return a, 1.0
    if op == _ABS:
        return abs(a), _sign(a)
    if op == _SIGN:
        return _sign(a), 0.0
    if op == _SQRT:
        value = math.sqrt(a) if a >= 0.0 else math.nan
        return value, 0.5 / value
    if op == _SQUARE:
        return a * a, 2.0 * a
    if op == _INV:
        return 1.0 / a, -1.0 / (a * a)
    if op == _EXP:
        value = math.exp(a)
        return value, value
    if op == _EXPM1:
        value = math.expm1(a)
        return value, value + 1.0
    if op == _LOG:
        return math.log(a) if a > 0.0 else math.nan, 1.0 / a
    if op == _LOG1P:
        return math.log1p(a) if a > -1.0 else math.nan, 1.0 / (1.0 + a)
    if op == _SIN:
        return math.sin(a), math.cos(a)
    if op == _COS:
        return math.cos(a), -math.sin(a)
    if op == _TAN:
        value = math.tan(a)
        return value, 1.0 + value * value
    if op == _SINH:
        return math.sinh(a), math.cosh(a)
    if op == _COSH:
        return math.cosh(a), math.sinh(a)
    if op == _TANH:
        value = math.tanh(a)
        return value, 1.0 - value * value
    if op == _ATAN:
        return math.atan(a), 1.0 / (1.0 + a * a)
    inside = abs(a) <= 1.0
    slope = 1.0 / math.sqrt(1.0 - a * a) if abs(a) < 1.0 else math.nan
    if op == _ASIN:
        return math.asin(a) if inside else math.nan, slope
    return math.acos(a) if inside else math.nan, -slope


@njit(**WITHIN)  # type: ignore[untyped-decorator]
def spread(rows: np.ndarray, columns: np.ndarray, width: int) -> np.ndarray:
    """Which columns each row varies with, (n, 1 + w): how many, and which."""
    varies = np.zeros((rows.shape[0], width), dtype=np.bool_)
    found = np.zeros((rows.shape[0], 1 + width), dtype=np.int64)
    for i in range(rows.shape[0]):
        op, a, b = rows[i, 0], rows[i, 1], rows[i, 2]
        for j in range(width):
            if op <= _T:
                varies[i, j] = (op == _X and j == 0) or (op == _V and j == 1) or (op == _NUMBER and columns[a] == j)
            elif op == _WHERE:
                varies[i, j] = varies[b, j] or varies[rows[i, 3], j]
            elif op < _GT:
                varies[i, j] = varies[a, j] or varies[b, j]
            elif op > _OR and op != _SIGN:
                varies[i, j] = varies[a, j]
            if varies[i, j]:
                found[i, 0] += 1
                found[i, found[i, 0]] = j
    return found


@njit(**WITHIN)  # type: ignore[untyped-decorator]
def run(
    rows: np.ndarray, constants: Array, th: Array, x: float, v: float, t: float, value: Array, slope: Array,
    vary: np.ndarray,
) -> None:  # fmt: skip
    """Fill ``value`` (n,) and ``slope`` (n, w), zeros before: derivatives by x, by v, and by parameters, in the columns
    that ``vary`` (`spread`) names. The last row is the sum of the forces."""
    for i in range(rows.shape[0]):
        op, a, b = rows[i, 0], rows[i, 1], rows[i, 2]
        if op <= _T:
            if op == _CONSTANT:
                value[i] = constants[a]
            elif op == _NUMBER:
                value[i] = th[a]
            elif op == _X:
                value[i] = x
            elif op == _V:
                value[i] = v
            else:
                value[i] = t
            for at in range(1, 1 + vary[i, 0]):
                slope[i, vary[i, at]] = 1.0
        elif op == _WHERE:
            taken = b if value[a] != 0.0 else rows[i, 3]
            value[i] = value[taken]
            for at in range(1, 1 + vary[i, 0]):
                slope[i, vary[i, at]] = slope[taken, vary[i, at]]
        elif op <= _OR:
            value[i], by_a, by_b = _pair(op, value[a], value[b])
            for at in range(1, 1 + vary[i, 0]):
                j = vary[i, at]  # what does not vary says nothing, however steep an operation is
                left = by_a * slope[a, j] if slope[a, j] != 0.0 else 0.0
                slope[i, j] = left + (by_b * slope[b, j] if slope[b, j] != 0.0 else 0.0)
        else:
            value[i], by_a = _alone(op, value[a])
            for at in range(1, 1 + vary[i, 0]):
                j = vary[i, at]
                slope[i, j] = by_a * slope[a, j] if slope[a, j] != 0.0 else 0.0


@compiled("Tuple((f8[::1], f8[:,::1]))(i8[:,::1], f8[::1], f8[::1], i8[::1], f8[::1], f8[::1], f8[::1])", **WITHIN)
def evaluate(
    rows: np.ndarray, constants: Array, theta: Array, columns: np.ndarray, x: Array, v: Array, t: Array
) -> tuple[Array, Array]:
    """The list's force (n,) at motions x, v, t (n,), and its derivatives (n, 2 + p) by x, v and p parameters.

    ``columns`` gives for each place of ``theta`` the column of its derivative (from 2 on), -1 for none.
    """
    width = 2
    for place in columns:
        width = max(width, place + 1)
    force, slopes = np.empty(x.size), np.empty((x.size, width))
    value, slope, vary = np.empty(rows.shape[0]), np.zeros((rows.shape[0], width)), spread(rows, columns, width)
    for i in range(x.size):
        run(rows, constants, theta, x[i], v[i], t[i], value, slope, vary)
        force[i] = value[-1]
        slopes[i] = slope[-1]
    return force, slopes
