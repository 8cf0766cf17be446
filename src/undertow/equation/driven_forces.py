"""The right-hand side of a driven body, compiled: the laws of kernel.py, and what comes from outside.

    M x'' + (all laws of kernel.py) + b + z = g u(t - tau)

on a base at rest. On a base that moves with the acceleration g u(t - tau), x is the displacement relative to it and

    M x'' + (laws between body and base) + b + z + W(r) = -M g u(t - tau),    r' = x'' + g u(t - tau)
    s_i'' = -r' - R_i,   W(r) = wc r + wq r|r| + wc3 r^3

r is the body's velocity through water at rest, a state of its own: its zeros are events like any other's. In water that
moves with the acceleration g u(t - tau) about a base at rest (waves, currents; Morison et al. 1950)

    M x'' + (laws of the structure) + b + z + W(r) = C g u(t - tau),    r' = x'' - g u(t - tau)

with M the body's mass and its added mass together, C = rho V + m_a. What comes
from outside enters kernel.py's right-hand side where a delayed echo does. u is the input between its samples
(input.py), g its gain, tau its delay, b a constant force, z a hysteresis (driven_memory.py).

A ``world`` is (piece of the input, its begin in s, knots, pieces, places of z and r in the state (0: none), sides of z
and of r). Does not belong here: steps and events (driven_kernel.py), what slots mean to a user (driven_laws.py).
"""

from __future__ import annotations

from numba import njit

from undertow.compiling import WITHIN
from undertow.equation.algebra import (
    _MASS,
    _V0,
    _X0,
    _XE,
    N_SLOTS,
    _explicit_force,
    _resisting,
    _slopes,
    _smooth_force,
)
from undertow.equation.driven_memory import _memory_force, _memory_slope, _sliders_begin
from undertow.equation.driven_slots import DRIVEN_SLOT, IWAN, SLIDERS
from undertow.equation.kernel import _C, _int, _rhs, _start

_GAIN, _TAU, _OFF, _BA, _BN, _BZ, _MOVING, _W0, _R0, _WC, _WQ, _W3, _WAVE, _KIND = (
    DRIVEN_SLOT[name] for name in (
        "gain", "delay", "offset", "bw_a", "bw_n", "bw_z0",
        "moving", "base_v0", "absolute_v0", "wc", "wq", "wc3", "wave", "memory",
    )
)  # fmt: skip


@njit(inline="always", **WITHIN)
def _input(knots, pieces, piece, r):
    """u and du/dt on a piece at the fraction r of its length."""
    u = 0.0
    du = 0.0
    for p in range(pieces.shape[1] - 1, -1, -1):
        du = du * r + u
        u = u * r + pieces[piece, p]
    return u, du / (knots[piece + 1] - knots[piece])


@njit(**WITHIN)
def _push(th, active, y, cols, u, du, iz, ir, d, rside, sens):
    """What acts from outside, with the sign of an echo, and its derivatives: into sens."""
    lever, inertia = 1.0, -1
    if th[_MOVING] > 0.0:
        lever, inertia = -th[_MASS], _MASS
    elif th[_MOVING] < 0.0:
        lever, inertia = th[_WAVE], _WAVE
    sens[0] = th[_OFF] - lever * th[_GAIN] * u
    for c in range(1, cols):
        slot = active[c - 1]
        s = 0.0
        if slot == _GAIN:
            s -= lever * u
        elif slot == _TAU:
            s += lever * th[_GAIN] * du
        elif slot == _OFF:
            s += 1.0
        elif slot == inertia:
            s += th[_MOVING] * th[_GAIN] * u
        sens[c] = s
    if iz > 0:
        _memory_force(th, active, y, cols, d, iz, sens)
    if ir > 0:
        _drag(th, active, y, cols, ir, rside, sens)


@njit(**WITHIN)
def _drag(th, active, y, cols, ir, rside, sens):
    """Forces of the water where it or the base moves, and their derivatives: added to sens."""
    r = y[ir, 0]
    sens[0] += r * (th[_WC] + th[_WQ] * r * rside + th[_W3] * r * r)
    by_r = th[_WC] + 2.0 * th[_WQ] * r * rside + 3.0 * th[_W3] * r * r
    for c in range(1, cols):
        slot = active[c - 1]
        s = by_r * y[ir, c]
        if slot == _WC:
            s += r
        elif slot == _WQ:
            s += r * r * rside
        elif slot == _W3:
            s += r * r * r
        sens[c] += s


@njit(**WITHIN)
def _rhs_alone(th, active, y, k, stage, cols, t, d, side, sens):
    """kernel.py's right-hand side for a body without hidden states: the same laws, without a look for any state."""
    x = y[0, 0] - th[_XE]
    v = y[1, 0]
    mass = th[_MASS]
    if d == 0.0:
        for c in range(cols):
            k[stage, 0, c] = 0.0
            k[stage, 1, c] = 0.0
        return
    a = -(_smooth_force(th, x, v, d, side) + sens[0] + _resisting(th, x, v, d, side) * d) / mass
    k[stage, 0, 0] = v
    k[stage, 1, 0] = a
    if cols > 1:
        fx, fv = _slopes(th, x, v, d, side, t)
        for c in range(1, cols):
            slot = active[c - 1]
            dv = y[1, c]
            force = -fx * y[0, c] - fv * dv - sens[c]
            if slot < N_SLOTS and slot != _X0 and slot != _V0:
                force += _explicit_force(th, slot, y, 0, t, d, side, x, v, a, fx, 0.0)
            k[stage, 0, c] = dv
            k[stage, 1, c] = force / mass


@njit(**WITHIN)
def _carried(th, active, k, stage, cols, dims, u, du, ir):
    """What the input's acceleration does beside the force: a base's to hidden oscillators, and a base's or the water's
    to the velocity through water."""
    for c in range(cols):
        slot = active[c - 1] if c > 0 else -1
        moved = 0.0
        if c == 0:
            moved = th[_GAIN] * u
        elif slot == _GAIN:
            moved = u
        elif slot == _TAU:
            moved = -th[_GAIN] * du
        if th[_MOVING] > 0.0:
            for i in range(dims[1]):
                k[stage, 3 + 2 * i, c] -= moved
        if ir > 0:
            k[stage, ir, c] = k[stage, 1, c] + th[_MOVING] * moved


@njit(**WITHIN)
def _slope(th, active, y, k, stage, cols, dims, t, h, d, side, world, sens, jac):
    """d(state)/dt at a stage of the step of length h from t, into k[stage]."""
    piece, begin, knots, pieces, iz, ir, zside, rside = world
    now = t + _C[stage] * h
    u, du = _input(knots, pieces, piece, (now - begin) / (knots[piece + 1] - knots[piece]))
    _push(th, active, y, cols, u, du, iz, ir, d, rside, sens)
    if dims[1] + dims[2] == 0:
        _rhs_alone(th, active, y, k, stage, cols, now, d, side, sens)
    else:
        _rhs(th, active, y, k, stage, cols, dims, now, d, side, sens, jac)
    if iz > 0:
        _memory_slope(th, active, y, k, stage, cols, d, zside, iz)
    if th[_MOVING] != 0.0:
        _carried(th, active, k, stage, cols, dims, u, du, ir)


@njit(**WITHIN)
def _push_before(th, active, y, dims, t, h, world, sens):
    """What acts from outside where a step of length h from t begins, into sens[0]."""
    piece, begin, knots, pieces, iz, ir, _, rside = world
    u, du = _input(knots, pieces, piece, (t - begin) / (knots[piece + 1] - knots[piece]))
    d = 1.0 if y[1, 0] > 0.0 else -1.0
    _push(th, active, y, _int(1), u, du, iz, ir, d, rside, sens)


@njit(**WITHIN)
def _begin(th, active, y, cols, dims, iz, ir, rate):
    """The start state and its sensitivities; ``rate`` is the input at the start."""
    _start(th, active, y, cols, dims)
    if iz > 0:
        y[iz, 0] = th[_BZ]
        if th[_KIND] == IWAN:
            _sliders_begin(th, active, y, cols, iz)
    if ir > 0:
        y[ir, 0] = th[_V0] + th[_MOVING] * (th[_GAIN] * th[_W0] + th[_R0])
    for c in range(1, cols):
        slot = active[c - 1]
        if iz > 0 and slot == _BZ and th[_KIND] != IWAN:
            y[iz, c] = 1.0
        if ir > 0 and slot == _V0:
            y[ir, c] = 1.0
        elif ir > 0 and slot == _R0:
            y[ir, c] = th[_MOVING]
        elif ir > 0 and slot == _GAIN:
            y[ir, c] = th[_MOVING] * th[_W0]
        elif ir > 0 and slot == _TAU:
            y[ir, c] = -th[_MOVING] * th[_GAIN] * rate


@njit(**WITHIN)
def _states(th, active, n):
    """Length of the state behind n of kernel.py's, with the places of z and r in it (0: none)."""
    iz = 0
    ir = 0
    remembers = th[_BA] != 0.0 or th[_BZ] != 0.0 or th[_KIND] != 0.0
    wet = th[_WC] != 0.0 or th[_WQ] != 0.0 or th[_W3] != 0.0
    for slot in active:
        remembers = remembers or slot == _BA
        wet = wet or slot in (_WC, _WQ, _W3)
    if remembers:
        iz = n
        n += 1 + SLIDERS if th[_KIND] == IWAN else 1
    if wet and th[_MOVING] != 0.0:
        ir = n
        n += 1
    return n, iz, ir
