"""Eq. 15 integrated arc by arc: between two reversals the motion is a Taylor series, and so are its derivatives.

    M x'' + c x' + k (x - x_e) + F_c sign(x') + q x'|x'| = 0

Between reversals the signs are constant and the series of x, x' and of their derivatives by the parameters follow
from each other term by term (Moore 1966, Interval Analysis; step length after Jorba and Zou 2005,
doi:10.1080/10586458.2005.10128904). At a reversal S_v+ = S_v- a+/a-; where the springs pull less than F_c the body
stays. `kernel.integrate` knows the same law beside all others and takes ten times longer; a test holds the two
together.

Belongs here: the series, the march from arc to arc, samples of it. Does not belong here: other laws (kernel.py).
numba's cache of likelihood/eq15_search.py, which compiles these functions in, goes by that file's text alone: after
a change here delete the cache, or change a word there (a test compares the two).
"""

# mypy: disable-error-code="no-untyped-def, misc, untyped-decorator"

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from undertow.equation.lanes import load, none, plus, plus_times, store, times, with_first
from undertow.equation.term import Array

Places = NDArray[np.int64]
_MASS, _K, _C, _Q, _F, _XE, _X0, _V0 = range(8)
LAWS = ("mass", "k1", "c1", "q", "fc", "xe", "x0", "v0")
"""Places of the short parameter vector, by the kernel's names of its slots."""

ORDER = 14
"""Terms of a series: with the tolerance below two or three steps an arc."""
TOLERANCE = 1e-8
"""First term left out, relative to the motion's size in that step: a decay is then within 3e-8 of its release, its
derivatives within 3e-6 of theirs, nearer than the general integrator's steps come in a fit."""
LARGEST_ANGLE = 1.5
"""No step turns the motion further (rad): none passes two reversals."""
MOST_STEPS = 4096
"""A motion of more steps than that is left to the kernel; also the bound of `march` on what it stores."""
RUNAWAY = 1e6
"""A motion that grows by this factor leaves every bound."""
_TRIES = 30
_ON_EVENT = 1e-5
"""Halley's search ends with a step of that share of the series' length: what is left is its cube."""
_INVERSE = 1.0 / np.arange(1.0, ORDER + 1.0)
_u, _int = np.uint64, np.int64
"""Types of places; numba compiles a function once more for a literal's type."""
_0, _1, _2, _3, _4 = (np.uint64(i) for i in range(5))
_OPT: dict[str, Any] = {"error_model": "numpy", "nogil": True, "fastmath": {"contract"}, "_nrt": False}
_FAST: dict[str, Any] = {**_OPT, "inline": "always"}
_INNER: dict[str, Any] = {**_OPT, "no_cpython_wrapper": True}
"""Compiler options; a product and a sum may become one instruction, rounded once: half of a series' latency. Nothing
is allocated here, and references to arrays are not counted; Python cannot call the inner ones."""


@njit(**_OPT)
def clear(table: Array) -> None:
    """Zeros into a table (n, m)."""
    for i in range(table.shape[0]):
        for j in range(table.shape[1]):
            table[i, j] = 0.0


@njit(**_INNER)
def _explicit(p, d, slots, by):
    """Derivatives of the force by the slots at fixed state, a column each, into ``by`` (5, width).

    Rows: what multiplies a, x - x_e, v and v^2; and the constant, which for the motion itself (column 0) is
    F_c d - k x_e.
    """
    clear(by)
    by[4, 0] = p[_F] * d - p[_K] * p[_XE]
    for j in range(1, 1 + slots.size):
        slot = slots[j - 1]
        if slot == _MASS:
            by[0, j] = 1.0
        elif slot == _K:
            by[1, j] = 1.0
        elif slot == _C:
            by[2, j] = 1.0
        elif slot == _Q:
            by[3, j] = d
        elif slot == _F:
            by[4, j] = d
        elif slot == _XE:
            by[4, j] = -p[_K]


@njit(**_INNER)
def _series(p, d, by, x, v, order):
    """Series of motion (column 0) and sensitivities (columns 1..) in direction d from their zeroth terms x[0], v[0].

    The motion's newest terms stay in registers and every sum takes the newest terms last, so that nothing waits.
    """
    inverse = 1.0 / p[_MASS]
    k, c, drag = p[_K] * inverse, p[_C] * inverse, p[_Q] * d * inverse
    first = v[_0, _0]
    damping = c + 2.0 * drag * first
    x0, v0 = x[_0, _0] - p[_XE], first
    for term in range(order):
        n, after, step = _u(term), _u(term + 1), _INVERSE[_u(term)]
        inner = 0.0
        for i in range((term - 1) // 2, 0, -1):
            inner += v[_u(i), _0] * v[_u(term - i), _0]
        inner *= 2.0
        if term % 2 == 0 and term > 0:
            inner += v[_u(term // 2), _0] * v[_u(term // 2), _0]
        if term == 0:
            square = first * first
            a = -(k * x0 + c * v0 + drag * square + p[_F] * d * inverse)
        else:
            square = inner + 2.0 * first * v0
            a = -(k * x0 + drag * inner) - damping * v0
        g, m, e, h = -a * inverse, -x0 * inverse, -v0 * inverse, -square * inverse
        for block in range(0, x.shape[1], 4):
            at = _u(block)
            force = times(-k, load(x, n, at))
            if term == 0:
                force = plus_times(force, -inverse, load(by, _4, at))
            product = other = none()
            for i in range(2, term, 2):
                product = plus_times(product, v[_u(i), _0], load(v, _u(term - i), at))
                other = plus_times(other, v[_u(i + 1), _0], load(v, _u(term - i - 1), at))
            if term % 2 == 0 and term > 0:
                product = plus_times(product, v0, load(v, _0, at))
            if term > 0:
                other = plus_times(other, v[_1, _0], load(v, _u(term - 1), at))
            force = plus_times(force, -2.0 * drag, plus(product, other))
            force = plus_times(force, m, load(by, _1, at))
            force = plus_times(force, e, load(by, _2, at))
            force = plus_times(force, h, load(by, _3, at))
            force = plus_times(force, g, load(by, _0, at))
            speed = load(v, n, at)
            store(x, after, at, times(step, speed))
            force = times(step, plus_times(force, -damping, speed))
            store(v, after, at, with_first(force, a * step) if block == 0 else force)
        x0, v0 = v0 * step, a * step


@njit(**_FAST)
def _value(series, s, order, j):
    """Column j of a series at s."""
    total = series[order, j]
    for n in range(order - 1, -1, -1):
        total = total * s + series[n, j]
    return total


@njit(**_INNER)
def _values(series, s, order, out, row):
    """All columns of a series at s into out[row]."""
    for block in range(0, out.shape[1], 4):
        at = _u(block)
        total = load(series, _u(order), at)
        for term in range(order - 1, -1, -1):
            total = plus_times(load(series, _u(term), at), s, total)
        store(out, _u(row), at, total)


@njit(**_FAST)
def _step_length(p, x, v, order, tolerance):
    """How far the series holds to ``tolerance`` of the motion's size, by its last two terms."""
    rate = math.sqrt(p[_K] / p[_MASS])
    size = tolerance * (abs(x[0, 0] - p[_XE]) + abs(v[0, 0]) / rate)
    last = abs(x[order, 0]) + rate * abs(x[order - 1, 0])
    longest = LARGEST_ANGLE / rate
    if not size < last * longest**order:
        return longest
    return math.exp(math.log(size / last) / order)


@njit(**_INNER)
def _reversal(v, b, end, d, order):
    """Where the speed, d v > 0 at 0 and ``end`` at b, is zero: Halley's search kept inside its bracket."""
    lo, hi = 0.0, b
    s, first, slope = 0.9 * b, v[0, 0], v[1, 0]
    if first != 0.0:  # of the parabola through both ends with the slope of the first
        bend = ((end - first) / b - slope) / b
        s = 2.0 * first / (d * math.sqrt(slope * slope - 4.0 * bend * first) - slope)
    for _ in range(_TRIES):
        f = v[order, 0]
        slope = half = 0.0
        for n in range(order - 1, -1, -1):
            half = half * s + slope
            slope = slope * s + f
            f = f * s + v[n, 0]
        if f * d > 0.0:
            lo = s
        else:
            hi = s
        below = slope * slope - f * half
        move = -f * slope / below if below != 0.0 else b
        if abs(move) < _ON_EVENT * b:
            return s + move
        if not (s + move > lo and s + move < hi):
            move = 0.5 * (lo + hi) - s
        s += move
    return s


@njit(**_FAST)
def _way(p, x):
    """Direction in which a body at rest at x starts to move; 0 where friction holds it."""
    pull = -p[_K] * (x - p[_XE])
    if abs(pull) > p[_F]:
        return 1.0 if pull > 0.0 else -1.0
    return 0.0


@njit(**_FAST)
def _turn(p, speed, h, x, v, order):
    """New direction after a reversal at the end of a step of length h; sensitivities jump."""
    before = 0.0
    for n in range(order, 0, -1):
        before = before * h + n * speed[n, 0]
    way = _way(p, x[0])
    after = -(p[_K] * (x[0] - p[_XE]) + p[_F] * way) / p[_MASS] if way != 0.0 else 0.0
    v[0] = 0.0
    for j in range(1, v.size):
        v[j] *= after / before
    return way


@njit(**_OPT)
def march(
    p: Array, slots: Places, end: float, order: int, tolerance: float, xs: Array, vs: Array, ends: Array, by: Array
) -> int:
    """Series of every step up to ``end``; their number, 0 where the motion has no bounds or too many steps.

    ``slots`` (k,) are the active places of the short parameter vector p. xs, vs (steps, ORDER + 1, width) are filled,
    column 0 the motion, 1.. its derivatives; ends (steps + 1,) are the instants between the steps; width is 1 + k
    rounded up to a multiple of 4; ``by`` (5, width) is room.
    """
    clear(xs[0])
    clear(vs[0])
    xs[0, 0, 0] = p[_X0]
    vs[0, 0, 0] = p[_V0]
    for j in range(1, 1 + slots.size):
        xs[0, 0, j] = 1.0 if slots[j - 1] == _X0 else 0.0
        vs[0, 0, j] = 1.0 if slots[j - 1] == _V0 else 0.0
    ends[0] = 0.0
    bound = RUNAWAY * (abs(p[_X0]) + abs(p[_V0]) * math.sqrt(p[_MASS] / p[_K]) + abs(p[_XE]))
    d = 1.0 if p[_V0] > 0.0 else -1.0
    if p[_V0] == 0.0:
        d = _way(p, p[_X0])
    _explicit(p, d, slots, by)
    for i in range(xs.shape[0] - 1):
        x, v = xs[i], vs[i]
        if d == 0.0:
            clear(x[1:])
            clear(v)
            ends[i + 1] = math.inf
            return i + 1
        _series(p, d, by, x, v, order)
        h = _step_length(p, x, v, order, tolerance)
        speed = _value(v, h, order, 0)
        turns = speed * d < 0.0
        if turns:
            h = _reversal(v, h, speed, d, order)
        ends[i + 1] = ends[i] + h
        if not abs(x[0, 0]) < bound or not h > 0.0:
            return 0
        if ends[i + 1] >= end:
            return i + 1
        _values(x, h, order, xs[i + 1], _int(0))
        _values(v, h, order, vs[i + 1], _int(0))
        if turns:
            d = _turn(p, v, h, xs[i + 1, 0], vs[i + 1, 0], order)
            _explicit(p, d, slots, by)
    return 0


@njit(**_OPT)
def accelerations(vs: Array, steps: int, order: int, out: Array) -> None:
    """Series of a from those of v, out (steps, ORDER + 1, width)."""
    for i in range(steps):
        for n in range(order + 1):
            for j in range(vs.shape[2]):
                out[i, n, j] = (n + 1.0) * vs[i, n + 1, j] if n < order else 0.0


@njit(**_OPT)
def integrals(xs: Array, ends: Array, steps: int, order: int, out: Array) -> None:
    """Series of the integral of x from the release, out (steps, ORDER + 1, width): a cell's mean is its difference."""
    for i in range(steps):
        if i == 0:
            clear(out[0])
        else:
            _values(out[i - 1], ends[i] - ends[i - 1], order, out[i], _int(0))
        for n in range(order):
            for j in range(xs.shape[2]):
                out[i, n + 1, j] = xs[i, n, j] * _INVERSE[n]


@njit(**_INNER)
def _four_values(series, s0, s1, s2, s3, order, out, row):
    """`_values` at four places into out[row : row + 4]: none waits for the other."""
    r = _u(row)
    for block in range(0, out.shape[1], 4):
        at = _u(block)
        f0 = f1 = f2 = f3 = load(series, _u(order), at)
        for term in range(order - 1, -1, -1):
            next_term = load(series, _u(term), at)
            f0, f1 = plus_times(next_term, s0, f0), plus_times(next_term, s1, f1)
            f2, f3 = plus_times(next_term, s2, f2), plus_times(next_term, s3, f3)
        store(out, r, at, f0)
        store(out, r + _1, at, f1)
        store(out, r + _2, at, f2)
        store(out, r + _3, at, f3)


@njit(**_OPT)
def sample_at(
    times: Array, late: float, series: Array, ends: Array, steps: int, order: int, levels: Array
) -> None:
    """A quantity's series at times + late (n,), not before the release, into levels (n, width)."""
    i = row = _int(0)
    while row < times.size:
        t = max(times[row] + late, 0.0)
        while i + 1 < steps and ends[i + 1] < t:
            i += 1
        begin = ends[i]
        if ends[i + 1] == math.inf:  # held by friction: constant, or growing evenly where the series is an integral
            for j in range(levels.shape[1]):
                levels[row, j] = series[i, 0, j] + (t - begin) * series[i, 1, j]
            row += 1
        elif row + 3 < times.size and t > 0.0 and times[row + 3] + late <= ends[i + 1]:
            here = begin - late
            s1, s2, s3 = times[row + 1] - here, times[row + 2] - here, times[row + 3] - here
            _four_values(series[i], t - begin, s1, s2, s3, order, levels, row)
            row += 4
        else:
            _values(series[i], t - begin, order, levels, row)
            row += 1


@njit(**_OPT)
def slopes_at(
    times: Array, late: float, series: Array, ends: Array, steps: int, order: int, slopes: Array
) -> None:
    """Rate of change (n,) of a quantity's series at times + late (n,); none before the release."""
    i = 0
    for row in range(times.size):
        t = times[row] + late
        while i + 1 < steps and ends[i + 1] < t:
            i += 1
        s, total = max(t, 0.0) - ends[i], 0.0
        for m in range(order, 0, -1):
            total = total * s + m * series[i, m, 0]
        slopes[row] = total if t >= 0.0 else 0.0
