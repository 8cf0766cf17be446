"""Motion under a list of operations: DOP853 from reversal to reversal, compiled, with every number's sensitivities.

The same method, step control and rules as the general path in Python (general.py): scipy's DOP853 with its dense
output, stopped where the velocity changes sign; there a body sticks or goes on, and the sensitivity of its velocity
is multiplied by a+ / a-. Source of the coefficients: Hairer, Norsett, Wanner 1993, as scipy has them.

Belongs here: that integration. Does not belong here: the list (tracing.py), its evaluation (tape.py).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from scipy.integrate import DOP853

from undertow.compiling import compiled
from undertow.equation.tape import WITHIN, run, spread
from undertow.equation.term import Array

_A, _B, _C = (np.ascontiguousarray(one, dtype=np.float64) for one in (DOP853.A, DOP853.B, DOP853.C))
_E3, _E5, _D = (np.ascontiguousarray(one, dtype=np.float64) for one in (DOP853.E3, DOP853.E5, DOP853.D))
_A_MORE, _C_MORE = (np.ascontiguousarray(one, dtype=np.float64) for one in (DOP853.A_EXTRA, DOP853.C_EXTRA))
_STAGES, _ALL = 12, 16
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 10.0
_POWER = -1.0 / 8.0

MASS, REST, INITIAL = -2, -3, -1
"""What a wanted derivative is by, where it is by no number of the list: the mass, the rest position, x0 or v0."""

DONE, UNBOUNDED, TURNING = 0, 1, 2
"""How an integration ends: at its last instant, leaving every bound, or turning too often."""


@njit(**WITHIN)
def _acceleration(tape, by, t, x, v, side, accelerations):  # type: ignore[no-untyped-def]
    """Fill a, its derivatives by x and v, and by each wanted number, (3 + p,), moving to ``side``."""
    rows, constants, th, vary, value, slope, sizes = tape
    mass, rest, still = sizes[0], sizes[1], sizes[2]
    moving = side * max(v * side, still)
    run(rows, constants, th, x - rest, moving, t, value, slope, vary)
    last = rows.shape[0] - 1
    a = -value[last] / mass
    accelerations[0] = a
    if slope.shape[1] == 0:
        return
    accelerations[1] = -slope[last, 0] / mass
    accelerations[2] = -slope[last, 1] / mass
    for j in range(by.size):
        if by[j] == MASS:
            accelerations[3 + j] = -a / mass
        elif by[j] == REST:
            accelerations[3 + j] = -accelerations[1]
        elif by[j] == INITIAL:
            accelerations[3 + j] = 0.0
        else:
            accelerations[3 + j] = -slope[last, by[j]] / mass


@njit(**WITHIN)
def _rate(tape, by, t, y, side, found, out):  # type: ignore[no-untyped-def]
    """Rates of the state (x and its derivatives, then v and its derivatives)."""
    n = y.size // 2
    _acceleration(tape, by, t, y[0], y[n], side, found)
    for j in range(n):
        out[j] = y[n + j]
    out[n] = found[0]
    for j in range(1, n):
        out[n + j] = found[1] * y[j] + found[2] * y[n + j] + found[2 + j]


@njit(**WITHIN)
def _leaves(tape, by, t, x, found):  # type: ignore[no-untyped-def]
    """Direction in which a body at rest starts to move, 0 where it sticks."""
    for side in (1.0, -1.0):
        _acceleration(tape, by, t, x, 0.0, side, found)
        if found[0] * side > 0.0:
            return side
    return 0.0


@njit(**WITHIN)
def _norm(a, b, scale):  # type: ignore[no-untyped-def]
    """Root mean square of (a - b) over the scale."""
    total = 0.0
    for j in range(a.size):
        total += ((a[j] - b[j]) / scale[j]) ** 2
    return math.sqrt(total / a.size)


@njit(**WITHIN)
def _first_step(tape, by, t, end, y, side, found, k, floors, rtol, work):  # type: ignore[no-untyped-def]
    """The first step of a stretch, as scipy chooses it."""
    span = end - t
    if span == 0.0:
        return 0.0
    none, scale, moved, rate = work[0], work[1], work[2], work[3]
    for j in range(y.size):
        none[j] = 0.0
        scale[j] = floors[j] + abs(y[j]) * rtol
    d0, d1 = _norm(y, none, scale), _norm(k, none, scale)
    h0 = min(1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1, span)
    for j in range(y.size):
        moved[j] = y[j] + h0 * k[j]
    _rate(tape, by, t + h0, moved, side, found, rate)
    d2 = _norm(rate, k, scale) / h0
    h1 = max(1e-6, h0 * 1e-3) if d1 <= 1e-15 and d2 <= 1e-15 else (0.01 / max(d1, d2)) ** 0.125
    return min(100.0 * h0, h1, span)


@njit(**WITHIN)
def _stages(tape, by, t, h, y, y_new, side, found, k, work):  # type: ignore[no-untyped-def]
    """One trial step: fills ``y_new`` and the rates k[1:13]."""
    at = work[0]
    for s in range(1, _STAGES):
        for j in range(y.size):
            total = 0.0
            for i in range(s):
                total += k[i, j] * _A[s, i]
            at[j] = y[j] + total * h
        _rate(tape, by, t + _C[s] * h, at, side, found, k[s])
    for j in range(y.size):
        total = 0.0
        for i in range(_STAGES):
            total += k[i, j] * _B[i]
        y_new[j] = y[j] + h * total
    _rate(tape, by, t + h, y_new, side, found, k[_STAGES])


@njit(**WITHIN)
def _error(k, h, y, y_new, floors, rtol):  # type: ignore[no-untyped-def]
    """A step's error over what is allowed."""
    fifth = third = 0.0
    for j in range(y.size):
        e5 = e3 = 0.0
        for i in range(_STAGES + 1):
            e5 += k[i, j] * _E5[i]
            e3 += k[i, j] * _E3[i]
        scale = floors[j] + max(abs(y[j]), abs(y_new[j])) * rtol
        fifth += (e5 / scale) ** 2
        third += (e3 / scale) ** 2
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return h * fifth / math.sqrt((fifth + 0.01 * third) * y.size)


@njit(**WITHIN)
def _interpolant(tape, by, t, h, y, y_new, side, found, k, work, dense):  # type: ignore[no-untyped-def]
    """Fill the step's polynomial ``dense`` (7, n)."""
    at = work[0]
    for more in range(_ALL - _STAGES - 1):
        s = _STAGES + 1 + more
        for j in range(y.size):
            total = 0.0
            for i in range(s):
                total += k[i, j] * _A_MORE[more, i]
            at[j] = y[j] + total * h
        _rate(tape, by, t + _C_MORE[more] * h, at, side, found, k[s])
    for j in range(y.size):
        step = y_new[j] - y[j]
        dense[0, j] = step
        dense[1, j] = h * k[0, j] - step
        dense[2, j] = 2.0 * step - h * (k[_STAGES, j] + k[0, j])
        for row in range(4):
            total = 0.0
            for i in range(_ALL):
                total += _D[row, i] * k[i, j]
            dense[3 + row, j] = h * total


@njit(**WITHIN)
def _within(dense, y, share, j):  # type: ignore[no-untyped-def]
    """The step's polynomial at a share of the step."""
    total = 0.0
    for i in range(7):
        total += dense[6 - i, j]
        total *= share if i % 2 == 0 else 1.0 - share
    return total + y[j]


@njit(**WITHIN)
def _turn(dense, y, side, n):  # type: ignore[no-untyped-def]
    """Share of the step at which the velocity is zero, by halving."""
    low, high = 0.0, 1.0
    while True:
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            return high
        if _within(dense, y, middle, n) * side > 0.0:
            low = middle
        else:
            high = middle


@njit(**WITHIN)
def _samples(tape, by, t, h, stop, y, side, found, dense, times, at, x, v, a):  # type: ignore[no-untyped-def]
    """Fill the samples from index ``at`` up to ``stop``; gives the index behind them."""
    n = y.size // 2
    while at > 0 and times[at - 1] >= t:
        at -= 1
    while at < times.size and times[at] <= stop:
        share = (times[at] - t) / h
        for j in range(n):
            x[at, j] = _within(dense, y, share, j)
            v[at, j] = _within(dense, y, share, n + j)
        _acceleration(tape, by, times[at], x[at, 0], v[at, 0], side, found)
        a[at, 0] = found[0]
        for j in range(1, n):
            a[at, j] = found[1] * x[at, j] + found[2] * v[at, j] + found[2 + j]
        at += 1
    return at


@njit(**WITHIN)
def _step(tape, by, t, end, ahead, y, y_new, side, found, k, floors, rtol, work):  # type: ignore[no-untyped-def]
    """One step that is as right as it must be: its length and the next one's; (-1, 0) where there is none."""
    rejected = False
    least = 10.0 * (np.nextafter(t, math.inf) - t)
    ahead = max(ahead, least)
    while ahead >= least:
        h = min(ahead, end - t)
        _stages(tape, by, t, h, y, y_new, side, found, k, work)
        error = _error(k, h, y, y_new, floors, rtol)
        if error < 1.0:
            factor = _MOST if error == 0.0 else min(_MOST, _SAFETY * error**_POWER)
            return h, h * (min(1.0, factor) if rejected else factor)
        ahead = h * max(_LEAST, _SAFETY * error**_POWER)
        rejected = True
    return -1.0, 0.0


@njit(**WITHIN)
def _stretch(tape, by, t, side, y, found, k, floors, rtol, work, times, at, x, v, a):  # type: ignore[no-untyped-def]
    """To the next reversal or the end: fills samples and ``y``; gives when, the next sample, steps (-1: no bounds)."""
    n, end, still, steps = y.size // 2, times[-1], tape[6][2], 0
    y_new, dense = np.empty(y.size), np.empty((7, y.size))
    _rate(tape, by, t, y, side, found, k[0])
    ahead = _first_step(tape, by, t, end, y, side, found, k[0], floors, rtol, work)
    held = y[n] * side + (still if abs(y[n]) <= still else 0.0)
    turned = False
    while not turned and t < end:
        h, ahead = _step(tape, by, t, end, ahead, y, y_new, side, found, k, floors, rtol, work)
        if h < 0.0:
            return t, at, -1
        steps += 1
        _interpolant(tape, by, t, h, y, y_new, side, found, k, work, dense)
        turned = held >= 0.0 and y_new[n] * side <= 0.0
        share = _turn(dense, y, side, n) if turned and y_new[n] * side < 0.0 else 1.0
        stop = t + h * share if share < 1.0 else (end if h == end - t else t + h)
        at = _samples(tape, by, t, h, stop, y, side, found, dense, times, at, x, v, a)
        for j in range(y.size):
            y_new[j] = _within(dense, y, share, j) if share < 1.0 else y_new[j]
            if not math.isfinite(y_new[j]):
                return stop, at, -1
        for j in range(y.size):
            y[j] = y_new[j]
            k[0, j] = k[_STAGES, j]
        held, t = y[n] * side, stop
    return t, at, steps


@compiled(
    "Tuple((f8[:,::1], f8[:,::1], f8[:,::1], i8, i8, f8))"
    "(i8[:,::1], f8[::1], f8[::1], i8[::1], i8[::1], f8[::1], f8[::1], f8[::1], f8[::1], i8)",
    **WITHIN,
)
def march(
    rows: np.ndarray, constants: Array, th: Array, columns: np.ndarray, by: np.ndarray, sizes: Array, start: Array,
    tolerances: Array, times: Array, turns: int,
) -> tuple[Array, Array, Array, int, int, float]:  # fmt: skip
    """x, v, a, each (m, 1 + p), at ``times`` (m,); how it ended; steps; and when, s.

    ``columns`` as in `tape.evaluate`; ``by`` (p,) the columns of the wanted derivatives, or `MASS`, `REST`, `INITIAL`;
    ``sizes`` the mass, the rest position and the speed that counts as standstill; ``start`` (2 + 2p,) x, its
    derivatives, v and its; ``tolerances`` the relative one and the absolute ones of x and v; ``turns`` the most
    reversals.
    """
    p = by.size
    n = 1 + p
    x, v, a = np.zeros((times.size, n)), np.zeros((times.size, n)), np.zeros((times.size, n))
    value, slope = np.empty(rows.shape[0]), np.zeros((rows.shape[0], (2 + p) if p > 0 else 0))
    tape = (rows, constants, th, spread(rows, columns, slope.shape[1]), value, slope, sizes)
    found, k, work = np.zeros(3 + p), np.empty((_ALL, 2 * n)), np.empty((4, 2 * n))
    y, floors = start.copy(), np.full(2 * n, 1e300)
    floors[0], floors[n] = tolerances[1], tolerances[2]
    t, steps, at = 0.0, 0, 0
    side = math.copysign(1.0, y[n]) if y[n] != 0.0 else _leaves(tape, by, t, y[0], found)
    for _ in range(turns):
        if side == 0.0:
            for i in range(times.size):
                if times[i] >= t:
                    for j in range(n):
                        x[i, j], v[i, j], a[i, j] = y[j], 0.0, 0.0
            return x, v, a, DONE, steps, t
        t, at, more = _stretch(tape, by, t, side, y, found, k, floors, tolerances[0], work, times, at, x, v, a)
        if more < 0:
            return x, v, a, UNBOUNDED, steps, t
        steps += more
        if t >= times[-1]:
            return x, v, a, DONE, steps, t
        _acceleration(tape, by, t, y[0], 0.0, side, found)
        before = found[0]
        side = _leaves(tape, by, t, y[0], found)
        after = found[0] if side != 0.0 else 0.0
        for j in range(1, n):
            y[n + j] *= after / before if before != 0.0 else 0.0
        y[n] = 0.0
    return x, v, a, TURNING, steps, t
