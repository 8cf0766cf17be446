"""The compiled integrator of one superset equation, exact at every stick, slip and re-slip, with sensitivities.

    M x'' + sum of all laws(x - x_e, v, d, t) + sum_j z_j + G v(t - tau) = sum_i m_i R_i,
    s_i'' = -x'' - R_i(s_i, s_i')          (hidden oscillators)
    z_j'  = rate_j(z_j, x, v, t)           (memories: relaxations, bristles)

Forces, slopes, rates and derivatives by parameters are algebra.py, generated from the laws' rows (generate.py).

Method: explicit Runge-Kutta of order 5 (Tsitouras 2011, doi:10.1016/j.camwa.2011.06.002) with a fixed largest step;
a step that crosses a velocity reversal is repeated up to the reversal (Newton on the step's length), so that every
step sees a smooth right-hand side. Samples in between come from the quintic through x, v, a at both ends. The state
is an array y[i, column]: column 0 the motion, columns 1.. d(state)/d(parameter); across an event these jump by
(f_minus - f_plus) dt*/dp. Each step runs in one mode: ``d`` the direction of motion (+1, -1; 0 stuck), ``side`` the
side of the rest position (+1, -1). Laws with a kink are continued smoothly beyond their side, so that a stage that
oversteps an event by rounding does not see the other branch. An echo's kinks, a delay after each event, end steps too,
and so does the end of a release that was not sudden: a hook that holds the body at x0 and lets go until t = T,
    M x'' + ... = F_h (1 - t / T)^p,  F_h what holds the body at t = 0, p >= 1 (a slot of 0 is p = 1).

numba's cache sees changes of its own file alone, so that a mark of algebra.py's text is part of what is compiled.
Sections: right-hand side, history, step, events, output, integrate. Does not belong here: any law's formula, what the
slots mean to a user (term.py and its neighbours).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from undertow.compiling import OPTIONS, WITHIN, compiled, mark_of
from undertow.equation import algebra
from undertow.equation.algebra import (
    _CP,
    _FB,
    _FCOS,
    _FS,
    _FSIN,
    _GCOS,
    _GE,
    _GSIN,
    _HM,
    _HOLD,
    _KB,
    _LET_GO,
    _LET_GO_P,
    _MASS,
    _NH,
    _P,
    _START,
    _TAU_E,
    _V0,
    _VS,
    _X0,
    _XE,
    MAX_HIDDEN,
    _dimensions,
    _explicit_force,
    _explicit_hidden,
    _hidden_kinks,
    _hidden_restoring,
    _hidden_slopes,
    _kinks,
    _memory_column,
    _memory_rates,
    _outside_force,
    _resisting,
    _rubs,
    _slopes,
    _smooth_force,
    _stirs,
    _turns,
)
from undertow.equation.algebra import N_SLOTS as N_SLOTS
from undertow.equation.algebra import SLOT as SLOT
from undertow.equation.algebra import SLOTS as SLOTS
from undertow.equation.lanes import LANES, load, plus_times, store, times
from undertow.equation.term import Array

_EVENT_TOLERANCE = 1e-10
"""Share of a gauge's change over the step that counts as zero on an event: moves the event by as much of the step."""
_ECHO_INSIDE = 1e-9
"""Share of a step by which an echo is looked up inside its stretch of history, away from the kinks at its ends."""

# Tsitouras' 5(4) pair, row s: weights of the slopes before stage s; the seventh stage is the next step's first.
_A = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.161, 0.0, 0.0, 0.0, 0.0, 0.0],
        [-0.008480655492356989, 0.335480655492357, 0.0, 0.0, 0.0, 0.0],
        [2.8971530571054935, -6.359448489975075, 4.3622954328695815, 0.0, 0.0, 0.0],
        [5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525, 0.0, 0.0],
        [5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383, 0.0],
        [
            0.09646076681806523, 0.01, 0.4798896504144996,
            1.379008574103742, -3.290069515436081, 2.324710524099774,
        ],
    ]
)  # fmt: skip
_C = np.array([0.0, 0.161, 0.327, 0.9, 0.9800255409045097, 1.0, 1.0])

_u = np.uint64
_int = np.int64
"""Written around an integer constant that is passed on: numba compiles a function once more for a literal's type."""
_STRIBECK_REACH = 3.0
_STRIBECK_SHARE = 0.3
"""Within three v_s of v = 0 (beyond, exp(-9) is left) a step may change v by 0.3 v_s: 1e-5 of x0 down to 1 mm/s."""
_SHARP_EXPONENT = 1.8
_POWER_SHARE = 0.5
_POWER_FINEST = 256.0
"""Below that exponent steps near v = 0 change v by half of it, the finest by 1/256 of a full step's change."""
_BEND = 0.25
_STABLE = 2.0
_RING = 0.25
"""Bristles that do not yet yield: a step bends them by a quarter of their reach fb / kb, by more where less is left to
bend (the fifth order's error stays), within what is stable, and takes a quarter radian of their own swing at most."""
_SHARE_LEFT = 0.25
_LAST_SHARE = 1.0 / 256.0
"""A hook that does not let go evenly: a step takes a quarter of the time that is left, the last ones 1/256 of all."""
_YIELDED = 1e-10
"""Share of their force within which bristles slide with the body: they stay as they are until it reverses."""
_ECHOES = 3.0
"""How often a kink's echo is a step's end again: each echo is smoother by one derivative than what it repeats."""
_INSTANT = 1e-12
"""Two events nearer than this share of the largest step are one."""
_SLIP = -1
_NONE = -2
_MOST_STEPS = 2_000_000
_STEPS_A_STRETCH = 20
_STEPS_SPARE = 10_000
"""A motion of more steps than that is given up: 20 a longest step of time, room for events and for short steps at sharp
laws. More comes from a law too stiff for the step, whose velocity turns at every one of them."""


@njit(inline="always", **WITHIN)
def whole_lanes(cols: int) -> int:
    """Columns of an array whose rows hold ``cols`` and are computed four at a time."""
    return LANES * ((cols + LANES - 1) // LANES)


# ---------------------------------------------------------------- right-hand side
@njit(inline="always", **WITHIN)
def _pull(th, y, dims, t, d, side, echo, v):
    """Net force on the body without friction, N: what accelerates it, or what friction has to hold."""
    x = y[0, 0] - th[_XE]
    f = -_smooth_force(th, x, v, d, side) - _outside_force(th, x, v, d, side, t, echo)
    for i in range(dims[1]):
        f += th[_HM + i * _NH] * _hidden_restoring(th, i, y[2 + 2 * i, 0], y[3 + 2 * i, 0])
    for j in range(2 + 2 * dims[1], 2 + 2 * dims[1] + dims[2]):
        f -= y[j, 0]
    if th[_LET_GO] > 0.0:
        f += th[_HOLD] * max(1.0 - t / th[_LET_GO], 0.0) ** max(th[_LET_GO_P], 1.0)
    return f


@njit(**WITHIN)
def _hold(th, active, y, cols, dims, side, sens, jac):
    """What the hook holds at t = 0 into its slot, N, and its sensitivities into the second half of sens; the way in
    which the body will go."""
    x = y[0, 0] - th[_XE]
    until = th[_LET_GO]
    th[_LET_GO] = 0.0
    th[_HOLD] = -_pull(th, y, dims, 0.0, 0.0, side, 0.0, 0.0)
    fx, _ = _slopes(th, x, 0.0, 0.0, side, 0.0)
    for i in range(dims[1]):
        _hidden_slopes(th, i, y[2 + 2 * i, 0], y[3 + 2 * i, 0], jac)
    for c in range(1, cols):
        by = _explicit_force(th, active[c - 1], y, dims[1], 0.0, 0.0, side, x, 0.0, 0.0, fx, 0.0) - fx * y[0, c]
        for i in range(dims[1]):
            mass = th[_HM + i * _NH]
            by += mass * (jac[2 * i] * y[2 + 2 * i, c] + jac[2 * i + 1] * y[3 + 2 * i, c])
        sens[cols + c] = -by
    th[_LET_GO] = until
    return -1.0 if th[_HOLD] > 0.0 else 1.0


@njit(inline="always", **WITHIN)
def _hook(th, active, k, stage, cols, t, sens):
    """The hook's part of the explicit derivatives of the force, into row 1 of k[stage]."""
    p = max(th[_LET_GO_P], 1.0)
    left = max(1.0 - t / th[_LET_GO], 0.0)
    share = left**p
    for c in range(1, cols):
        k[stage, 1, c] += share * sens[cols + c]
        if active[c - 1] == _LET_GO:
            k[stage, 1, c] += th[_HOLD] * p * left ** (p - 1.0) * t / (th[_LET_GO] * th[_LET_GO])
        elif active[c - 1] == _LET_GO_P and left > 0.0:
            k[stage, 1, c] += th[_HOLD] * share * np.log(left)


@njit(**WITHIN)
def _rhs(th, active, y, k, stage, cols, dims, t, d, side, sens, jac):
    """d(state)/dt of the first ``cols`` columns of y into k[stage].

    dims: state length, hidden oscillators, memories, each memory. sens[0] is v(t - tau), sens[1:cols] its
    sensitivities, what follows those of the hook's hold; jac is room for the hidden oscillators' slopes.
    """
    x = y[0, 0] - th[_XE]
    v = y[1, 0]
    speed = 0.0
    a = 0.0
    per_mass = 1.0 / th[_MASS]
    if d != 0.0:
        speed = v
        a = (_pull(th, y, dims, t, d, side, sens[0], v) - _resisting(th, x, v, d, side) * d) * per_mass
    if cols > 1:
        fx, fv = _slopes(th, x, v, d, side, t)
        for i in range(dims[1]):
            _hidden_slopes(th, i, y[2 + 2 * i, 0], y[3 + 2 * i, 0], jac)
        if d != 0.0:
            for c in range(1, cols):
                by = _explicit_force(th, active[c - 1], y, dims[1], t, d, side, x, speed, a, fx, sens[0])
                k[stage, 1, c] = by - th[_GE] * sens[c]
            if th[_LET_GO] > 0.0:
                _hook(th, active, k, stage, cols, t, sens)
        _sweep(th, y, k[stage], cols, dims, d, per_mass, fx, fv, jac)
        if dims[0] > 2:
            for c in range(1, cols):
                dv = y[1, c] if d != 0.0 else 0.0
                for i in range(dims[1]):
                    by = _explicit_hidden(th, active[c - 1], i, y[2 + 2 * i, 0], y[3 + 2 * i, 0])
                    k[stage, 3 + 2 * i, c] -= by
                _memory_column(th, active[c - 1], y, k, stage, c, dims, x, speed, d, side, t, y[0, c], dv)
    k[stage, 0, 0] = speed
    k[stage, 1, 0] = a
    for i in range(dims[1]):
        k[stage, 2 + 2 * i, 0] = y[3 + 2 * i, 0]
        k[stage, 3 + 2 * i, 0] = -a - _hidden_restoring(th, i, y[2 + 2 * i, 0], y[3 + 2 * i, 0])
    _memory_rates(th, y, k, stage, dims, x, speed, d, side, t)


@njit(**WITHIN)
def _sweep(th, y, slopes, cols, dims, d, per_mass, fx, fv, jac):
    """Jacobian times sensitivity into ``slopes`` for the first ``cols`` columns of y, four at a time; its row 1 holds
    the explicit derivatives of the force. A body that sticks has none."""
    nh = dims[1]
    moves = 1.0 if d != 0.0 else 0.0
    of_mass = per_mass * moves
    for block in range(0, cols, LANES):
        at = _u(block)
        speed = load(y, _u(1), at)
        force = plus_times(load(slopes, _u(1), at), -fx, load(y, _u(0), at))
        force = plus_times(force, -fv, speed)
        for i in range(nh):
            mass = th[_HM + i * _NH]
            force = plus_times(force, mass * jac[2 * i], load(y, _u(2 + 2 * i), at))
            force = plus_times(force, mass * jac[2 * i + 1], load(y, _u(3 + 2 * i), at))
        for j in range(2 + 2 * nh, 2 + 2 * nh + dims[2]):
            force = plus_times(force, -1.0, load(y, _u(j), at))
        slope = times(of_mass, force)
        store(slopes, _u(0), at, times(moves, speed))
        store(slopes, _u(1), at, slope)
        for i in range(nh):
            rate = load(y, _u(3 + 2 * i), at)
            against = plus_times(times(-1.0, slope), -jac[2 * i], load(y, _u(2 + 2 * i), at))
            store(slopes, _u(2 + 2 * i), at, rate)
            store(slopes, _u(3 + 2 * i), at, plus_times(against, -jac[2 * i + 1], rate))


# ---------------------------------------------------------------- history for the delayed echo
@njit(**WITHIN)
def _remember(past, at, y, out, k, cols, dims, t, h):
    """Store x, v, a of every column at both ends of the step from y to out as number ``at`` of the history."""
    ends, states = past
    ends[at, 0] = t
    ends[at, 1] = t + h
    for c in range(cols):
        states[at, 0, c] = y[0, c]
        states[at, 1, c] = y[1, c]
        states[at, 2, c] = k[0, 1, c]
        states[at, 3, c] = out[0, c]
        states[at, 4, c] = out[1, c]
        states[at, 5, c] = k[6, 1, c]


@njit(**WITHIN)
def _echo_at(th, active, when, past, stored, cols, sens):
    """v(when) and its sensitivities into sens, from the quintic through x, v, a at both ends of the stored step.

    Before the release the body is at rest: zero. The sensitivity by tau also holds -a(when).
    """
    for c in range(cols):
        sens[c] = 0.0
    if when < 0.0 or stored == 0:
        return
    ends, states = past
    lo = 0
    hi = stored - 1
    while lo < hi:
        mid = (lo + hi + 1) // 2
        if ends[mid, 0] <= when:
            lo = mid
        else:
            hi = mid - 1
    h = ends[lo, 1] - ends[lo, 0]
    r = min((when - ends[lo, 0]) / h, 1.0)
    r2 = r * r
    r3 = r2 * r
    r4 = r3 * r
    db = (30.0 * r2 - 60.0 * r3 + 30.0 * r4) / h
    dp1 = 1.0 - 18.0 * r2 + 32.0 * r3 - 15.0 * r4
    dq1 = -12.0 * r2 + 28.0 * r3 - 15.0 * r4
    dp2 = (r - 4.5 * r2 + 6.0 * r3 - 2.5 * r4) * h
    dq2 = (1.5 * r2 - 4.0 * r3 + 2.5 * r4) * h
    for c in range(cols):
        sens[c] = db * (states[lo, 3, c] - states[lo, 0, c]) + dp1 * states[lo, 1, c] + dq1 * states[lo, 4, c]
        sens[c] += dp2 * states[lo, 2, c] + dq2 * states[lo, 5, c]
    if cols > 1:
        s = states[lo, :, 0]
        a = (60.0 * r - 180.0 * r2 + 120.0 * r3) / (h * h) * (s[3] - s[0])
        a += ((-36.0 * r + 96.0 * r2 - 60.0 * r3) * s[1] + (-24.0 * r + 84.0 * r2 - 60.0 * r3) * s[4]) / h
        a += (1.0 - 9.0 * r + 18.0 * r2 - 10.0 * r3) * s[2] + (3.0 * r - 12.0 * r2 + 10.0 * r3) * s[5]
        for c in range(1, cols):
            if active[c - 1] == _TAU_E:
                sens[c] -= a


@njit(**OPTIONS)
def _longer(rows):
    """Rows (n, 2) with room for twice as many."""
    more = np.zeros((2 * rows.shape[0], 2))
    for i in range(rows.shape[0]):
        more[i, 0] = rows[i, 0]
        more[i, 1] = rows[i, 1]
    return more


@njit(**OPTIONS)
def _grown(past):
    """The history with room for twice as many steps."""
    ends, states = past
    more = np.zeros((2 * ends.shape[0], 6, states.shape[2]))
    for i in range(ends.shape[0]):
        for j in range(6):
            for c in range(states.shape[2]):
                more[i, j, c] = states[i, j, c]
    return _longer(ends), more


# ---------------------------------------------------------------- one step
@njit(inline="always", **WITHIN)
def _echoed(th, active, y, k, stage, cols, dims, t, h, d, side, world, sens, jac):
    """The right-hand side of a decay at a stage of the step of length h from t; ``world`` is what it remembers."""
    now = t + _C[stage] * h
    if th[_GE] != 0.0:
        past, stored = world
        when = now - th[_TAU_E] - (_ECHO_INSIDE * h if _C[stage] == 1.0 else 0.0)
        _echo_at(th, active, when, past, stored, cols, sens)
    _rhs(th, active, y, k, stage, cols, dims, now, d, side, sens, jac)


@njit(inline="always", **WITHIN)
def _echo_before(th, active, y, dims, t, h, world, sens):
    """The echo where the step of length h from t begins, into sens[0]."""
    if th[_GE] != 0.0:
        past, stored = world
        _echo_at(th, active, t - th[_TAU_E] + _ECHO_INSIDE * h, past, stored, _int(1), sens)


def _stepping(slope: Any) -> Any:
    """One Runge-Kutta step over the right-hand side ``slope``, which takes a stage of a step and a ``world``.

    `step` goes from y to out by the length h, for the first ``cols`` columns. The slope of stage s stands at
    k[s]; that of y (s = 0) must be there, that of out is left there (s = 6).
    """

    @njit(**WITHIN)
    def step(th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac):
        n = dims[0]
        for stage in range(1, 7):
            w0, w1, w2 = h * _A[stage, 0], h * _A[stage, 1], h * _A[stage, 2]
            w3, w4, w5 = h * _A[stage, 3], h * _A[stage, 4], h * _A[stage, 5]
            for i in range(n):
                row = _u(i)
                for block in range(0, cols, LANES):
                    at = _u(block)
                    moved = plus_times(load(y, row, at), w0, load(k[0], row, at))
                    if stage > 1:
                        moved = plus_times(moved, w1, load(k[1], row, at))
                    if stage > 2:
                        moved = plus_times(moved, w2, load(k[2], row, at))
                    if stage > 3:
                        moved = plus_times(moved, w3, load(k[3], row, at))
                    if stage > 4:
                        moved = plus_times(moved, w4, load(k[4], row, at))
                    if stage > 5:
                        moved = plus_times(moved, w5, load(k[5], row, at))
                    store(out, row, at, moved)
            slope(th, active, out, k, stage, cols, dims, t, h, d, side, world, sens, jac)

    return step


_step = _stepping(_echoed)


@njit(**WITHIN)
def _short_near_reversal(th, speed, slope, h):
    """Step length that resolves what changes sharply around v = 0, at the speed |v| and its slope |a|.

    Stribeck's peak: steps of a share of v_s inside three v_s. A power law with an exponent near or below one is not
    analytic at v = 0: steps shrink and grow there in geometric progression.
    """
    change = slope * h
    if th[_FS] != 0.0:
        outside = speed - _STRIBECK_REACH * th[_VS]
        change = min(change, _STRIBECK_SHARE * th[_VS] + max(outside, 0.0))
    if th[_CP] != 0.0 and th[_P] < _SHARP_EXPONENT:
        change = min(change, _POWER_SHARE * speed + slope * h / _POWER_FINEST)
    return h if change >= slope * h else change / slope


@njit(**WITHIN)
def _short_while_bending(th, left, speed, slope, h):
    """Step length for bristles with the share ``left`` of their force to go, at the speed |v| and its slope |a|."""
    reach = min(_STABLE, _BEND * left**-0.2) * th[_FB] / abs(th[_KB])
    stiff = np.sqrt(abs(th[_KB]) * left / th[_MASS])
    return min(h, _RING / stiff, 2.0 * reach / (speed + np.sqrt(speed * speed + 2.0 * slope * reach) + 1e-300))


# ---------------------------------------------------------------- events
@njit(**WITHIN)
def _excess(th, y, dims, t, side, echo):
    """By how much the pull on a body at rest exceeds what friction holds, N (negative: it sticks), and whereto."""
    x = y[0, 0] - th[_XE]
    pull = _pull(th, y, dims, t, 0.0, side, echo, 0.0)
    forward = pull - _resisting(th, x, 0.0, 1.0, side)
    backward = -pull - _resisting(th, x, 0.0, -1.0, side)
    if forward > backward:
        return forward, 1.0
    return backward, -1.0


@njit(**WITHIN)
def _cubic_root(f0, f1, s0, s1, r):
    """Root in (0, 1) of the cubic through f0, f1 with slopes s0, s1, by two Newton steps from r."""
    c2 = 3.0 * (f1 - f0) - 2.0 * s0 - s1
    c3 = 2.0 * (f0 - f1) + s0 + s1
    for _ in range(2):
        slope = s0 + r * (2.0 * c2 + 3.0 * r * c3)
        if slope == 0.0:
            return r
        r -= (f0 + r * (s0 + r * (c2 + r * c3))) / slope
    return r


@njit(**WITHIN)
def _gauge(th, y, dims, t, side, echo, which):
    """What is zero at an event: state ``which`` (x from rest, or a velocity); _SLIP: a stuck body's excess pull."""
    if which == _SLIP:
        return _excess(th, y, dims, t, side, echo)[0]
    return y[which, 0] - (th[_XE] if which == 0 else 0.0)


def _locating(step: Any) -> Any:
    """The search for an event inside a step, over that ``step`` function.

    `locate` gives the length of the step that ends on the event, with ``out`` and slope 6 there; the full step must
    have crossed it. Newton with the state's own slope, the secant for the excess pull, which has none; both kept inside
    a bracket. The search runs on the motion alone, its last step on all columns. f0 is the gauge at the step's start.
    """

    @njit(**WITHIN)
    def locate(th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac, which, f0):
        alone = _int(1)
        lo = 0.0
        hi = h
        f_lo = f0
        f_hi = _gauge(th, out, dims, t + h, side, sens[0], which)
        scale = abs(f0) + abs(f_hi)
        guess = 0.5 * h
        if f0 * f_hi < 0.0:
            guess = h * f0 / (f0 - f_hi)
            if which != _SLIP:
                guess = _cubic_root(f0, f_hi, h * k[0, which, 0], h * k[6, which, 0], guess / h) * h
        length = h
        for _ in range(80):
            if not (guess > lo and guess < hi):
                guess = 0.5 * (lo + hi)
            length = guess
            step(th, active, y, out, k, alone, dims, t, length, d, side, world, sens, jac)
            f = _gauge(th, out, dims, t + length, side, sens[0], which)
            if abs(f) <= _EVENT_TOLERANCE * scale or hi - lo < 1e-15 * (h + abs(t)):
                break
            if f * f_hi > 0.0:
                hi, f_hi = length, f
                f_lo *= 0.5 if which == _SLIP else 1.0
            else:
                lo, f_lo = length, f
                f_hi *= 0.5 if which == _SLIP else 1.0
            if which == _SLIP:
                guess = lo + (hi - lo) * f_lo / (f_lo - f_hi) if f_lo != f_hi else 0.5 * (lo + hi)
            else:
                slope = k[6, which, 0]
                guess = length - f / slope if slope != 0.0 else 0.5 * (lo + hi)
        if cols > 1:
            step(th, active, y, out, k, cols, dims, t, length, d, side, world, sens, jac)
        return length

    return locate


def _watching(step: Any, before: Any) -> Any:
    """Which event ends a step, over that ``step`` function; ``before`` puts what acts at the step's start in sens[0].

    `first` gives the event (_NONE: none) and the step's length; ``out`` is there. ``watch`` are the states whose zeros
    are events: the passage of the rest position (0), the body's reversal (1; of a stuck body: _SLIP), any other's.
    """
    locate = _locating(step)

    @njit(**WITHIN)
    def first(th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac, watch):
        event = _NONE
        for which in watch:
            f0 = y[which, 0] - (th[_XE] if which == 0 else 0.0)
            if which == 1 and d == 0.0:
                which = _SLIP
                crossed = _excess(th, out, dims, t + h, side, sens[0])[0] > 0.0
                if crossed:
                    behind = sens[0]
                    before(th, active, y, dims, t, h, world, sens)
                    f0 = _excess(th, y, dims, t, side, sens[0])[0]
                    sens[0] = behind
            elif which == 1:
                crossed = out[1, 0] * d < 0.0
            else:
                crossed = f0 * (out[which, 0] - (th[_XE] if which == 0 else 0.0)) < 0.0
            if crossed:
                h = locate(
                    th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac, which, f0
                )  # fmt: skip
                event = which
        return event, h

    return first


_first_event = _watching(_step, _echo_before)


@njit(**WITHIN)
def _watched(th, active, dims, watch):
    """How many states have zeros that are events, into ``watch`` (5 + hidden oscillators,).

    A law whose coefficient is 0 makes no event, but its sensitivity changes sign there.
    """
    many = 0
    if _kinks(th, active):
        watch[many] = 0
        many += 1
    if _turns(th, active, dims):
        watch[many] = 1
        many += 1
    for i in range(dims[1]):
        if _hidden_kinks(th, i):
            watch[many] = 3 + 2 * i
            many += 1
    return many


@njit(**WITHIN)
def _jump(y, k, cols, dims, which):
    """Sensitivities across an event at which state ``which`` is zero: S += (f_minus - f_plus) dt*/dp.

    f_minus stands at slope 6, f_plus at slope 0.
    """
    n = dims[0]
    if k[6, which, 0] == 0.0:
        return
    for c in range(1, cols):
        dt = -y[which, c] / k[6, which, 0]
        for i in range(n):
            y[i, c] += (k[6, i, 0] - k[0, i, 0]) * dt


@njit(**WITHIN)
def _cross_break(th, active, y, k, cols, dims, t, h, d, side, past, stored, sens, jac):
    """New slope 0 where an echo starts or has a kink; the sensitivity by tau jumps where the echo itself does.

    It does where the release had a velocity: that front arrives at t = tau, so dt*/dtau = 1.
    """
    n = dims[0]
    zero = _int(0)
    _echo_at(th, active, t - th[_TAU_E] + _ECHO_INSIDE * h, past, stored, cols, sens)
    _rhs(th, active, y, k, zero, cols, dims, t, d, side, sens, jac)
    if t < 1.5 * th[_TAU_E] and th[_V0] != 0.0:
        for c in range(1, cols):
            if active[c - 1] == _TAU_E:
                for i in range(n):
                    y[i, c] += k[6, i, 0] - k[0, i, 0]
        _rhs(th, active, y, k, zero, cols, dims, t, d, side, sens, jac)


# ---------------------------------------------------------------- samples inside a step
@njit(**WITHIN)
def _sample(y, out, k, cols, dims, h, r, row, ox, ov, oa, os):
    """Quintic Hermite through x, v, a at both ends of a step, at the fraction r of its length, into row ``row``.

    Columns are written four at a time: up to three numbers pass into the rows behind, which are written later.
    """
    r2 = r * r
    r3 = r2 * r
    r4 = r3 * r
    r5 = r4 * r
    rate = 1.0 / h
    b = 10.0 * r3 - 15.0 * r4 + 6.0 * r5
    p1 = (r - 6.0 * r3 + 8.0 * r4 - 3.0 * r5) * h
    q1 = (-4.0 * r3 + 7.0 * r4 - 3.0 * r5) * h
    p2 = (0.5 * r2 - 1.5 * r3 + 1.5 * r4 - 0.5 * r5) * h * h
    q2 = (0.5 * r3 - r4 + 0.5 * r5) * h * h
    db = (30.0 * r2 - 60.0 * r3 + 30.0 * r4) * rate
    dp1 = 1.0 - 18.0 * r2 + 32.0 * r3 - 15.0 * r4
    dq1 = -12.0 * r2 + 28.0 * r3 - 15.0 * r4
    dp2 = (r - 4.5 * r2 + 6.0 * r3 - 2.5 * r4) * h
    dq2 = (1.5 * r2 - 4.0 * r3 + 2.5 * r4) * h
    eb = (60.0 * r - 180.0 * r2 + 120.0 * r3) * rate * rate
    ep1 = (-36.0 * r + 96.0 * r2 - 60.0 * r3) * rate
    eq1 = (-24.0 * r + 84.0 * r2 - 60.0 * r3) * rate
    ep2 = 1.0 - 9.0 * r + 18.0 * r2 - 10.0 * r3
    eq2 = 3.0 * r - 12.0 * r2 + 10.0 * r3
    here = _u(row)
    begins, ends = k[0], k[6]
    for block in range(0, cols, LANES):
        at = _u(block)
        x0, v0, v1 = load(y, _u(0), at), load(y, _u(1), at), load(out, _u(1), at)
        a0, a1 = load(begins, _u(1), at), load(ends, _u(1), at)
        dx = plus_times(load(out, _u(0), at), -1.0, x0)
        x = plus_times(plus_times(plus_times(x0, b, dx), p1, v0), q1, v1)
        store(ox, here, at, plus_times(plus_times(x, p2, a0), q2, a1))
        v = plus_times(plus_times(times(db, dx), dp1, v0), dq1, v1)
        store(ov, here, at, plus_times(plus_times(v, dp2, a0), dq2, a1))
        a = plus_times(plus_times(times(eb, dx), ep1, v0), eq1, v1)
        store(oa, here, at, plus_times(plus_times(a, ep2, a0), eq2, a1))
    for i in range(2, 2 + 2 * dims[1], 2):
        ds = out[i, 0] - y[i, 0]
        os[row, i - 2] = (
            y[i, 0] + b * ds + p1 * y[i + 1, 0] + q1 * out[i + 1, 0] + p2 * k[0, i + 1, 0] + q2 * k[6, i + 1, 0]
        )  # fmt: skip
        os[row, i - 1] = db * ds + dp1 * y[i + 1, 0] + dq1 * out[i + 1, 0] + dp2 * k[0, i + 1, 0] + dq2 * k[6, i + 1, 0]


@njit(**WITHIN)
def _start(th, active, y, cols, dims):
    """Initial state and its sensitivities by x0, v0 and the hidden oscillators' initial states."""
    nh = dims[1]
    y[0, 0] = th[_X0]
    y[1, 0] = th[_V0]
    for i in range(nh):
        y[2 + 2 * i, 0] = th[_HM + i * _NH + _START]
        y[3 + 2 * i, 0] = th[_HM + i * _NH + _START + 1]
    for c in range(1, cols):
        slot = active[c - 1]
        if slot == _X0:
            y[0, c] = 1.0
        elif slot == _V0:
            y[1, c] = 1.0
        for i in range(nh):
            if slot == _HM + i * _NH + _START:
                y[2 + 2 * i, c] = 1.0
            elif slot == _HM + i * _NH + _START + 1:
                y[3 + 2 * i, c] = 1.0


@njit(**WITHIN)
def _bound(th, dims):
    """A displacement no sound motion reaches, m: a million times what the initial state and the forcing stand for."""
    outside = abs(th[_FCOS]) + abs(th[_FSIN]) + abs(th[_GCOS]) + abs(th[_GSIN])
    size = abs(th[_X0]) + abs(th[_V0]) + abs(th[_XE]) + outside / th[_MASS]
    for i in range(dims[1]):
        size += abs(th[_HM + i * _NH + _START]) + abs(th[_HM + i * _NH + _START + 1])
    return 1e6 * size


# ---------------------------------------------------------------- the whole motion
def _with_mark(mark: int) -> Any:
    """The compiled integrator; ``mark`` stands for the laws' text, so that another one is compiled anew."""

    @compiled("Tuple((f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i8))(f8[::1], i8[::1], f8[::1], f8)", **OPTIONS)
    def integrate(th, active, times, h_max):
        """Motion from t = 0 with the parameter vector ``th`` (slots as in SLOTS), sampled at ``times`` (m,), s, rising.

        ``active`` (p,) are the slots whose sensitivities are wanted, ``h_max`` the largest step in s. Gives x, v, a
        each (m, 1 + p): column 0 the motion, column 1 + j its derivative by slot active[j]; the hidden displacements
        and velocities (m, 2 n_hidden); and the number of steps, negative where the motion left every bound.
        """
        if mark < 0:
            raise ValueError("a mark is not negative")
        m = times.size
        cols = 1 + active.size
        dims = _dimensions(th)
        nh = dims[1]
        ox = np.zeros((m + LANES, cols))  # room behind the last sample for what `_sample` writes past its row
        ov = np.zeros((m + LANES, cols))
        oa = np.zeros((m + LANES, cols))
        os = np.zeros((m, 2 * nh))
        n = dims[0]
        width = whole_lanes(cols)
        y = np.zeros((n, width))
        out = np.zeros((n, width))
        k = np.zeros((7, n, width))
        jac = np.zeros(2 * MAX_HIDDEN)
        sens = np.zeros(2 * cols)
        hooked = th[_LET_GO] > 0.0
        released = th[_LET_GO]
        if hooked:
            th = th.copy()
        delayed = th[_GE] != 0.0
        if delayed:
            h_max = min(h_max, max(th[_TAU_E], 1e-3 * h_max))
        room = 64 + int(times[m - 1] / h_max) if delayed else 1
        past = (np.zeros((room, 2)), np.zeros((room, 6, cols)))
        zero = _int(0)
        stored = _int(0)
        kinks = np.zeros((room, 2))  # instants at which an echo has a kink, in order, and how often that was echoed
        kinks[0, 0] = th[_TAU_E]
        n_kinks = 1 if delayed else 0
        next_kink = 0
        driven = delayed or _stirs(th, dims)
        rubs = _rubs(th)
        bristles = dims[4] > 0 and th[_KB] != 0.0
        sharp = th[_FS] != 0.0 or (th[_CP] != 0.0 and th[_P] < _SHARP_EXPONENT)
        watch = np.empty(5 + MAX_HIDDEN, np.int64)
        watch = watch[: _watched(th, active, dims, watch)]
        _start(th, active, y, cols, dims)
        t = 0.0
        row = _int(0)
        steps = 0
        limit = _bound(th, dims)
        most = min(_MOST_STEPS, _STEPS_SPARE + _STEPS_A_STRETCH * int(times[m - 1] / h_max))
        side = 1.0 if y[0, 0] > th[_XE] or (y[0, 0] == th[_XE] and y[1, 0] > 0.0) else -1.0
        d = 1.0 if y[1, 0] > 0.0 else -1.0
        if y[1, 0] == 0.0:
            excess, way = _excess(th, y, dims, t, side, 0.0)
            d = way if excess > 0.0 or not rubs else 0.0
            if hooked:
                way = _hold(th, active, y, cols, dims, side, sens, jac)
                d = 0.0 if rubs else way
        yielded = th.copy()
        yielded[_KB] = 0.0
        _rhs(th, active, y, k, zero, cols, dims, t, d, side, sens, jac)
        while row < m:
            if d == 0.0 and not driven and not hooked:
                for r in range(row, m):
                    for c in range(cols):
                        ox[r, c], ov[r, c], oa[r, c] = y[0, c], 0.0, 0.0
                break
            h = h_max
            if sharp:
                h = _short_near_reversal(th, abs(y[1, 0]), abs(k[0, 1, 0]), h_max)
            law = th
            if bristles and d != 0.0:
                left = 1.0 - d * y[n - 1, 0] / th[_FB]
                if left > _YIELDED:
                    h = _short_while_bending(th, left, abs(y[1, 0]), abs(k[0, 1, 0]), h)
                else:
                    law = yielded
            if hooked and th[_LET_GO_P] > 1.0:
                h = min(h, max(_SHARE_LEFT * (released - t), _LAST_SHARE * released))
            on_end = hooked and released < t + h * (1.0 + 1e-9)
            if on_end:
                h = released - t
            on_kink = next_kink < n_kinks and kinks[next_kink, 0] < t + h * (1.0 + 1e-9)
            if on_kink:
                h = kinks[next_kink, 0] - t
            if on_kink and h < _INSTANT * h_max:
                _cross_break(th, active, y, k, cols, dims, t, h_max, d, side, past, stored, sens, jac)
                next_kink += 1
                continue
            on_end = on_end and h == released - t
            if on_end and h < _INSTANT * h_max:
                hooked = False
                th[_LET_GO] = yielded[_LET_GO] = 0.0
                _rhs(th, active, y, k, zero, cols, dims, t, d, side, sens, jac)
                continue
            world = (past, stored)
            _step(law, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac)
            event, length = _first_event(law, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac, watch)
            on_kink = on_kink and length == h
            on_end = on_end and length == h
            h = length
            steps += 1
            while row < m and times[row] <= t + h * (1.0 + _INSTANT):
                _sample(y, out, k, cols, dims, h, (times[row] - t) / h, row, ox, ov, oa, os)
                row += 1
            if delayed:
                if stored == past[0].shape[0]:
                    past = _grown(past)
                _remember(past, stored, y, out, k, cols, dims, t, h)
                stored += 1
            t = kinks[next_kink, 0] if on_kink else t + h
            if on_end:
                t = released
            for i in range(n):
                for c in range(cols):
                    y[i, c] = out[i, c]
                    k[0, i, c] = k[6, i, c]
            if event != _NONE:
                if event == 0:
                    y[0, 0] = th[_XE]
                    side = 1.0 if y[1, 0] > 0.0 else -1.0
                elif event > 0:
                    y[event, 0] = 0.0
                if event == 1 or event == _SLIP:
                    excess, way = _excess(th, y, dims, t, side, sens[0])
                    d = way if event == _SLIP or excess > 0.0 or not rubs else 0.0
                _rhs(th, active, y, k, zero, cols, dims, t, d, side, sens, jac)
                if event == 1:
                    _jump(y, k, cols, dims, event)
                    _rhs(th, active, y, k, zero, cols, dims, t, d, side, sens, jac)
            if on_kink:
                _cross_break(th, active, y, k, cols, dims, t, h_max, d, side, past, stored, sens, jac)
                next_kink += 1
            fresh = event == 1 or event == _SLIP
            if delayed and (fresh or (on_kink and kinks[next_kink - 1, 1] < _ECHOES)):
                if n_kinks == kinks.shape[0]:
                    kinks = _longer(kinks)
                kinks[n_kinks, 0] = t + th[_TAU_E]
                kinks[n_kinks, 1] = 0.0 if fresh else kinks[next_kink - 1, 1] + 1.0
                n_kinks += 1
            if not (abs(y[0, 0]) <= limit) or steps > most:  # 0 <= 0: a body that nothing moves stays
                return ox[:m], ov[:m], oa[:m], os, -steps
        return ox[:m], ov[:m], oa[:m], os, steps

    return integrate


integrate: Callable[[Array, NDArray[np.int64], Array, float], tuple[Array, Array, Array, Array, int]]
integrate = _with_mark(mark_of(algebra))
