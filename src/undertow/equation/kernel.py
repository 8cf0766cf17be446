"""The compiled integrator of one superset equation, exact at every stick, slip and re-slip, with sensitivities.

    M x'' + K(x - x_e) + D(x - x_e, v) + fric(x, v) sign(v) + z + r + G v(t - tau) + F(t) = sum_i m_i R_i,
    s_i'' = -x'' - R_i,   R_i = 2 zeta_i w_i s_i' + w_i^2 s_i + b_i s_i'|s_i'| + g_i s_i^3     (hidden oscillators)
    z_j'  = k_j v - z_j / tau_j                                                              (relaxations)
    r'    = k_b v (1 - sign(v) r / F_b)                                                      (bristle: presliding)

Method: explicit Runge-Kutta of order 5 (Tsitouras 2011, doi:10.1016/j.camwa.2011.06.002) with a fixed largest step;
a step that crosses a velocity reversal is repeated up to the reversal (Newton on the step's length), so that every
step sees a smooth right-hand side. Samples in between come from the quintic through x, v, a at both ends. The state
is an array y[column, i]: column 0 the motion, columns 1.. d(state)/d(parameter); across an event these jump by
(f_minus - f_plus) dt*/dp. Each step runs in one mode: ``d`` the direction of motion (+1, -1; 0 stuck), ``side`` the
side of the rest position (+1, -1). Laws with a kink are continued smoothly beyond their side, so that a stage that
oversteps an event by rounding does not see the other branch. An echo's kinks, a delay after each event, end steps too.

One file, because numba's cache does not see changes in other files. Sections: slots, right-hand side, step, events,
output, integrate. Does not belong here: what the slots mean to a user (term.py and its neighbours).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from undertow.compiling import compiled
from undertow.equation.term import Array

# ---------------------------------------------------------------- slots of the parameter vector
_PLAIN = (
    "mass", "k1", "k2", "ka", "k3", "k5", "ks", "c1", "q", "c3", "xv", "xxv", "cp", "p",
    "fc", "fs", "vs", "fa", "fn", "fcos", "fsin", "omega", "ge", "tau_e", "xe", "x0", "v0", "kb", "fb",
)  # fmt: skip
_HIDDEN = ("m", "w", "z", "b", "g", "s0", "u0")
_RELAX = ("k", "tau")
MAX_HIDDEN = 3
MAX_RELAX = 2
SLOTS: tuple[str, ...] = (
    _PLAIN
    + tuple(f"{n}{i}" for i in range(1, MAX_HIDDEN + 1) for n in ("hm", "hw", "hz", "hb", "hg", "hs", "hu"))
    + tuple(f"{n}{i}" for i in range(1, MAX_RELAX + 1) for n in ("rk", "rt"))
)
"""Names of the parameter vector's places, in order: hm1 is the first hidden oscillator's mass, and so on."""

SLOT: dict[str, int] = {name: i for i, name in enumerate(SLOTS)}
N_SLOTS = len(SLOTS)

(
    _M, _K1, _K2, _KA, _K3, _K5, _KS, _C1, _Q, _C3, _XV, _XXV, _CP, _P,
    _FC, _FS, _VS, _FA, _FN, _FCOS, _FSIN, _OM, _GE, _TE, _XE, _X0, _V0, _KB, _FB,
) = range(len(_PLAIN))  # fmt: skip
_H = len(_PLAIN)
_NH = len(_HIDDEN)
_R = _H + MAX_HIDDEN * _NH
_NR = len(_RELAX)

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

_int = np.int64
"""Written around an integer constant that is passed on: numba compiles a function once more for a literal's type."""
_STRIBECK_REACH = 3.0
_STRIBECK_SHARE = 0.3
"""Within three v_s of v = 0 (beyond, exp(-9) is left) a step may change v by 0.3 v_s: 1e-5 of x0 down to 1 mm/s."""
_SHARP_EXPONENT = 1.8
_POWER_SHARE = 0.5
_POWER_FINEST = 256.0
"""Below that exponent steps near v = 0 change v by half of it, the finest by 1/256 of a full step's change."""
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
_OPT: dict[str, Any] = {"fastmath": False, "error_model": "numpy", "nogil": True}
"""Compiler options; only `integrate` is cached: the functions it calls are compiled into it."""
_BORROWS: dict[str, Any] = {**_OPT, "_nrt": False, "no_cpython_wrapper": True}
"""For functions that allocate nothing: numba then does not count references to arrays, which cost half of the time.
Python cannot call them, which saves compiling a wrapper each."""


# ---------------------------------------------------------------- right-hand side
@njit(inline="always", **_BORROWS)
def _power_law(v, p):
    """|v|^p sign(v); beyond a reversal it goes on as an odd function."""
    if v == 0.0:
        return 0.0
    return math.copysign(abs(v) ** p, v)


@njit(inline="always", **_BORROWS)
def _resisting(th, x, v, d, side):
    """Friction's size in the direction d of motion: F_c + F_a d + F_n |x| + F_s exp(-(v/v_s)^2)."""
    size = th[_FC] + th[_FA] * d + th[_FN] * x * side
    if th[_FS] != 0.0:
        size += th[_FS] * math.exp(-((v / th[_VS]) ** 2))
    return size


@njit(inline="always", **_BORROWS)
def _smooth_force(th, x, v, d, side):
    """All algebraic forces but friction, at displacement x from rest and velocity v moving in direction d."""
    f = th[_K1] * x + th[_C1] * v + th[_Q] * v * v * d
    if th[_K3] != 0.0 or th[_K2] != 0.0 or th[_KA] != 0.0 or th[_K5] != 0.0:
        f += x * x * (th[_K2] + th[_KA] * side + x * (th[_K3] + x * x * th[_K5]))
    if th[_KS] != 0.0:
        f += th[_KS] * math.sin(x)
    if th[_C3] != 0.0 or th[_XV] != 0.0 or th[_XXV] != 0.0:
        f += v * (th[_C3] * v * v + x * (th[_XV] + th[_XXV] * x))
    if th[_CP] != 0.0:
        f += th[_CP] * _power_law(v, th[_P])
    return f


@njit(inline="always", **_BORROWS)
def _outside_force(th, t, echo):
    """Forces with a clock of their own: harmonic forcing and the delayed echo of the velocity."""
    f = th[_GE] * echo
    if th[_FCOS] != 0.0 or th[_FSIN] != 0.0:
        f += th[_FCOS] * math.cos(th[_OM] * t) + th[_FSIN] * math.sin(th[_OM] * t)
    return f


@njit(inline="always", **_BORROWS)
def _hidden_restoring(th, i, s, u):
    """R_i of hidden oscillator i at displacement s and velocity u relative to the body, per unit mass."""
    o = _H + i * _NH
    w = th[o + 1]
    return 2.0 * th[o + 2] * w * u + w * w * s + th[o + 3] * u * abs(u) + th[o + 4] * s * s * s


@njit(inline="always", **_BORROWS)
def _pull(th, y, dims, t, d, side, echo, v):
    """Net force on the body without friction, N: what accelerates it, or what friction has to hold."""
    _, nh, nr, nb = dims
    f = -_smooth_force(th, y[0, 0] - th[_XE], v, d, side) - _outside_force(th, t, echo)
    for i in range(nh):
        f += th[_H + i * _NH] * _hidden_restoring(th, i, y[0, 2 + 2 * i], y[0, 3 + 2 * i])
    for j in range(2 + 2 * nh, 2 + 2 * nh + nr + nb):
        f -= y[0, j]
    return f


@njit(**_BORROWS)
def _rhs(th, active, y, k, stage, cols, dims, t, d, side, sens, jac):
    """d(state)/dt of the first ``cols`` columns of y into k[:, :, stage].

    dims: state length, hidden oscillators, relaxations, bristles. sens[0] is v(t - tau), sens[1:] its sensitivities;
    jac is room for the hidden oscillators' slopes.
    """
    _, nh, nr, nb = dims
    x = y[0, 0] - th[_XE]
    v = y[0, 1]
    base = 2 + 2 * nh
    speed = 0.0
    a = 0.0
    if d != 0.0:
        speed = v
        a = (_pull(th, y, dims, t, d, side, sens[0], v) - _resisting(th, x, v, d, side) * d) / th[_M]
    k[0, 0, stage] = speed
    k[0, 1, stage] = a
    for i in range(nh):
        k[0, 2 + 2 * i, stage] = y[0, 3 + 2 * i]
        k[0, 3 + 2 * i, stage] = -a - _hidden_restoring(th, i, y[0, 2 + 2 * i], y[0, 3 + 2 * i])
    for j in range(nr):
        o = _R + j * _NR
        k[0, base + j, stage] = th[o] * speed - y[0, base + j] / th[o + 1]
    if nb:
        k[0, base + nr, stage] = th[_KB] * speed * (1.0 - d * y[0, base + nr] / th[_FB])
    if cols > 1:
        fx, fv = _slopes(th, x, v, d, side)
        for i in range(nh):
            o = _H + i * _NH
            s, u = y[0, 2 + 2 * i], y[0, 3 + 2 * i]
            jac[2 * i] = th[o + 1] * th[o + 1] + 3.0 * th[o + 4] * s * s
            jac[2 * i + 1] = 2.0 * th[o + 2] * th[o + 1] + 2.0 * th[o + 3] * abs(u)
        for c in range(1, cols):
            _rhs_column(th, active[c - 1], y, k, stage, c, dims, t, d, side, x, speed, a, fx, fv, sens[0], sens[c], jac)


@njit(inline="always", **_BORROWS)
def _slopes(th, x, v, d, side):
    """Derivatives of the algebraic forces by x and by v, N/m and N s/m."""
    fx = th[_K1] + th[_FN] * d * side
    fv = th[_C1] + 2.0 * th[_Q] * v * d
    if th[_K3] != 0.0 or th[_K2] != 0.0 or th[_KA] != 0.0 or th[_K5] != 0.0:
        fx += x * (2.0 * (th[_K2] + th[_KA] * side) + x * (3.0 * th[_K3] + 5.0 * x * x * th[_K5]))
    if th[_KS] != 0.0:
        fx += th[_KS] * math.cos(x)
    if th[_C3] != 0.0 or th[_XV] != 0.0 or th[_XXV] != 0.0:
        fx += v * (th[_XV] + 2.0 * th[_XXV] * x)
        fv += 3.0 * th[_C3] * v * v + x * (th[_XV] + th[_XXV] * x)
    if th[_CP] != 0.0 and v != 0.0 and (v * d > 0.0 or th[_P] >= 1.0):  # below one the slope has a pole at v = 0
        fv += th[_CP] * th[_P] * abs(v) ** (th[_P] - 1.0)
    if th[_FS] != 0.0:
        fv -= d * th[_FS] * math.exp(-((v / th[_VS]) ** 2)) * 2.0 * v / th[_VS] ** 2
    return fx, fv


@njit(inline="always", **_BORROWS)
def _rhs_column(th, slot, y, k, stage, c, dims, t, d, side, x, v, a, fx, fv, echo, echo_by, jac):
    """The column c of y: Jacobian times sensitivity, plus the explicit derivative by its slot."""
    _, nh, nr, nb = dims
    base = 2 + 2 * nh
    da = 0.0
    dv = 0.0
    if d != 0.0:
        dv = y[c, 1]
        da = -fx * y[c, 0] - fv * dv - th[_GE] * echo_by
        for i in range(nh):
            da += th[_H + i * _NH] * (jac[2 * i] * y[c, 2 + 2 * i] + jac[2 * i + 1] * y[c, 3 + 2 * i])
        for j in range(base, base + nr + nb):
            da -= y[c, j]
        da = (da + _explicit_force(th, slot, y, nh, t, d, side, x, v, a, fx, echo)) / th[_M]
    k[c, 0, stage] = dv
    k[c, 1, stage] = da
    for i in range(nh):
        dr = jac[2 * i] * y[c, 2 + 2 * i] + jac[2 * i + 1] * y[c, 3 + 2 * i]
        k[c, 2 + 2 * i, stage] = y[c, 3 + 2 * i]
        k[c, 3 + 2 * i, stage] = -da - dr - _explicit_hidden(th, slot, i, y[0, 2 + 2 * i], y[0, 3 + 2 * i])
    for j in range(nr):
        r = _R + j * _NR
        slope = th[r] * dv - y[c, base + j] / th[r + 1]
        if slot == r:
            slope += v
        elif slot == r + 1:
            slope += y[0, base + j] / (th[r + 1] * th[r + 1])
        k[c, base + j, stage] = slope
    if nb:
        r0 = y[0, base + nr]
        free = 1.0 - d * r0 / th[_FB]
        slope = th[_KB] * (dv * free - v * d * y[c, base + nr] / th[_FB])
        if slot == _KB:
            slope += v * free
        elif slot == _FB:
            slope += th[_KB] * v * d * r0 / (th[_FB] * th[_FB])
        k[c, base + nr, stage] = slope


@njit(inline="always", **_BORROWS)
def _explicit_hidden(th, slot, i, s, u):
    """dR_i / d(slot) at fixed state."""
    base = _H + i * _NH
    o = slot - base
    if o == 1:
        return 2.0 * th[base + 2] * u + 2.0 * th[base + 1] * s
    if o == 2:
        return 2.0 * th[base + 1] * u
    if o == 3:
        return u * abs(u)
    if o == 4:
        return s * s * s
    return 0.0


@njit(inline="always", **_BORROWS)
def _explicit_force(th, slot, y, nh, t, d, side, x, v, a, fx, echo):
    """d(M a)/d(slot) at fixed state, N per unit of the slot."""
    if slot == _M:
        return -a
    if slot == _K1:
        return -x
    if slot == _C1:
        return -v
    if slot == _Q:
        return -v * v * d
    if slot == _FC:
        return -d
    if slot == _XE:
        return fx
    if slot == _FA:
        return -1.0
    if slot == _FN:
        return -d * x * side
    if slot == _K2:
        return -x * x
    if slot == _KA:
        return -x * x * side
    if slot == _K3:
        return -x * x * x
    if slot == _K5:
        return -x * x * x * x * x
    if slot == _KS:
        return -math.sin(x)
    if slot == _C3:
        return -v * v * v
    if slot == _XV:
        return -x * v
    if slot == _XXV:
        return -x * x * v
    if slot == _CP:
        return -_power_law(v, th[_P])
    if slot == _P:
        return -th[_CP] * _power_law(v, th[_P]) * math.log(abs(v)) if v != 0.0 else 0.0
    if slot == _FS:
        return -d * math.exp(-((v / th[_VS]) ** 2))
    if slot == _VS:
        return -d * th[_FS] * math.exp(-((v / th[_VS]) ** 2)) * 2.0 * v * v / th[_VS] ** 3
    if slot == _FCOS:
        return -math.cos(th[_OM] * t)
    if slot == _FSIN:
        return -math.sin(th[_OM] * t)
    if slot == _OM:
        return t * (th[_FCOS] * math.sin(th[_OM] * t) - th[_FSIN] * math.cos(th[_OM] * t))
    if slot == _GE:
        return -echo
    for i in range(nh):
        o = _H + i * _NH
        if slot >= o and slot < o + _NH:
            if slot == o:
                return _hidden_restoring(th, i, y[0, 2 + 2 * i], y[0, 3 + 2 * i])
            return th[o] * _explicit_hidden(th, slot, i, y[0, 2 + 2 * i], y[0, 3 + 2 * i])
    return 0.0


# ---------------------------------------------------------------- history for the delayed echo
@njit(**_BORROWS)
def _remember(past, at, y, out, k, cols, dims, t, h):
    """Store x, v, a of every column at both ends of the step from y to out as number ``at`` of the history."""
    ends, states = past
    ends[at, 0] = t
    ends[at, 1] = t + h
    for c in range(cols):
        states[at, 0, c] = y[c, 0]
        states[at, 1, c] = y[c, 1]
        states[at, 2, c] = k[c, 1, 0]
        states[at, 3, c] = out[c, 0]
        states[at, 4, c] = out[c, 1]
        states[at, 5, c] = k[c, 1, 6]


@njit(**_BORROWS)
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
            if active[c - 1] == _TE:
                sens[c] -= a


@njit(**_OPT)
def _longer(rows):
    """Rows (n, 2) with room for twice as many."""
    more = np.zeros((2 * rows.shape[0], 2))
    for i in range(rows.shape[0]):
        more[i, 0] = rows[i, 0]
        more[i, 1] = rows[i, 1]
    return more


@njit(**_OPT)
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
@njit(inline="always", **_BORROWS)
def _echoed(th, active, y, k, stage, cols, dims, t, h, d, side, world, sens, jac):
    """The right-hand side of a decay at a stage of the step of length h from t; ``world`` is what it remembers."""
    now = t + _C[stage] * h
    if th[_GE] != 0.0:
        past, stored = world
        when = now - th[_TE] - (_ECHO_INSIDE * h if _C[stage] == 1.0 else 0.0)
        _echo_at(th, active, when, past, stored, cols, sens)
    _rhs(th, active, y, k, stage, cols, dims, now, d, side, sens, jac)


@njit(inline="always", **_BORROWS)
def _echo_before(th, active, y, dims, t, h, world, sens):
    """The echo where the step of length h from t begins, into sens[0]."""
    if th[_GE] != 0.0:
        past, stored = world
        _echo_at(th, active, t - th[_TE] + _ECHO_INSIDE * h, past, stored, _int(1), sens)


def _stepping(slope: Any) -> Any:
    """One Runge-Kutta step over the right-hand side ``slope``, which takes a stage of a step and a ``world``.

    `step` goes from y to out by the length h, for the first ``cols`` columns. The slope of stage s stands at
    k[:, :, s]; that of y (s = 0) must be there, that of out is left there (s = 6).
    """

    @njit(**_BORROWS)
    def step(th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac):
        n = dims[0]
        for stage in range(1, 7):
            w0, w1, w2 = h * _A[stage, 0], h * _A[stage, 1], h * _A[stage, 2]
            w3, w4, w5 = h * _A[stage, 3], h * _A[stage, 4], h * _A[stage, 5]
            for c in range(cols):
                for i in range(n):
                    out[c, i] = (
                        y[c, i] + w0 * k[c, i, 0] + w1 * k[c, i, 1] + w2 * k[c, i, 2] + w3 * k[c, i, 3]
                        + w4 * k[c, i, 4] + w5 * k[c, i, 5]
                    )  # fmt: skip
            slope(th, active, out, k, stage, cols, dims, t, h, d, side, world, sens, jac)

    return step


_step = _stepping(_echoed)


@njit(**_BORROWS)
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


# ---------------------------------------------------------------- events
@njit(**_BORROWS)
def _excess(th, y, dims, t, side, echo):
    """By how much the pull on a body at rest exceeds what friction holds, N (negative: it sticks), and whereto."""
    x = y[0, 0] - th[_XE]
    pull = _pull(th, y, dims, t, 0.0, side, echo, 0.0)
    forward = pull - _resisting(th, x, 0.0, 1.0, side)
    backward = -pull - _resisting(th, x, 0.0, -1.0, side)
    if forward > backward:
        return forward, 1.0
    return backward, -1.0


@njit(**_BORROWS)
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


@njit(**_BORROWS)
def _gauge(th, y, dims, t, side, echo, which):
    """What is zero at an event: state ``which`` (x from rest, or a velocity); _SLIP: a stuck body's excess pull."""
    if which == _SLIP:
        return _excess(th, y, dims, t, side, echo)[0]
    return y[0, which] - (th[_XE] if which == 0 else 0.0)


def _locating(step: Any) -> Any:
    """The search for an event inside a step, over that ``step`` function.

    `locate` gives the length of the step that ends on the event, with ``out`` and slope 6 there; the full step must
    have crossed it. Newton with the state's own slope, the secant for the excess pull, which has none; both kept inside
    a bracket. The search runs on the motion alone, its last step on all columns. f0 is the gauge at the step's start.
    """

    @njit(**_BORROWS)
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
                guess = _cubic_root(f0, f_hi, h * k[0, which, 0], h * k[0, which, 6], guess / h) * h
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
                slope = k[0, which, 6]
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

    @njit(**_BORROWS)
    def first(th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac, watch):
        event = _NONE
        for which in watch:
            f0 = y[0, which] - (th[_XE] if which == 0 else 0.0)
            if which == 1 and d == 0.0:
                which = _SLIP
                crossed = _excess(th, out, dims, t + h, side, sens[0])[0] > 0.0
                if crossed:
                    behind = sens[0]
                    before(th, active, y, dims, t, h, world, sens)
                    f0 = _excess(th, y, dims, t, side, sens[0])[0]
                    sens[0] = behind
            elif which == 1:
                crossed = out[0, 1] * d < 0.0
            else:
                crossed = f0 * (out[0, which] - (th[_XE] if which == 0 else 0.0)) < 0.0
            if crossed:
                h = locate(
                    th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac, which, f0
                )  # fmt: skip
                event = which
        return event, h

    return first


_first_event = _watching(_step, _echo_before)


@njit(**_BORROWS)
def _watched(th, active, dims, watch):
    """How many states have zeros that are events, into ``watch`` (5 + hidden oscillators,)."""
    signed = th[_FC] != 0.0 or th[_FA] != 0.0 or th[_FN] != 0.0 or th[_FS] != 0.0
    signed = signed or th[_Q] != 0.0 or th[_CP] != 0.0 or dims[3] > 0
    kinked = th[_KA] != 0.0 or th[_FN] != 0.0
    for slot in active:  # a law whose coefficient is 0 makes no event, but its sensitivity changes sign there
        signed = signed or slot in (_FC, _FN, _FS, _Q, _CP)
        kinked = kinked or slot in (_KA, _FN)
    many = 0
    if kinked:
        watch[many] = 0
        many += 1
    if signed:
        watch[many] = 1
        many += 1
    for i in range(dims[1]):
        if th[_H + i * _NH + 3] != 0.0:
            watch[many] = 3 + 2 * i
            many += 1
    return many


@njit(**_BORROWS)
def _jump(y, k, cols, dims, which):
    """Sensitivities across an event at which state ``which`` is zero: S += (f_minus - f_plus) dt*/dp.

    f_minus stands at slope 6, f_plus at slope 0.
    """
    n = dims[0]
    if k[0, which, 6] == 0.0:
        return
    for c in range(1, cols):
        dt = -y[c, which] / k[0, which, 6]
        for i in range(n):
            y[c, i] += (k[0, i, 6] - k[0, i, 0]) * dt


@njit(**_BORROWS)
def _cross_break(th, active, y, k, cols, dims, t, h, d, side, past, stored, sens, jac):
    """New slope 0 where an echo starts or has a kink; the sensitivity by tau jumps where the echo itself does.

    It does where the release had a velocity: that front arrives at t = tau, so dt*/dtau = 1.
    """
    n = dims[0]
    zero = _int(0)
    _echo_at(th, active, t - th[_TE] + _ECHO_INSIDE * h, past, stored, cols, sens)
    _rhs(th, active, y, k, zero, cols, dims, t, d, side, sens, jac)
    if t < 1.5 * th[_TE] and th[_V0] != 0.0:
        for c in range(1, cols):
            if active[c - 1] == _TE:
                for i in range(n):
                    y[c, i] += k[0, i, 6] - k[0, i, 0]
        _rhs(th, active, y, k, zero, cols, dims, t, d, side, sens, jac)


# ---------------------------------------------------------------- samples inside a step
@njit(**_BORROWS)
def _sample(y, out, k, cols, dims, h, r, row, ox, ov, oa, os):
    """Quintic Hermite through x, v, a at both ends of a step, at the fraction r of its length, into row ``row``."""
    r2 = r * r
    r3 = r2 * r
    r4 = r3 * r
    r5 = r4 * r
    b = 10.0 * r3 - 15.0 * r4 + 6.0 * r5
    p1 = (r - 6.0 * r3 + 8.0 * r4 - 3.0 * r5) * h
    q1 = (-4.0 * r3 + 7.0 * r4 - 3.0 * r5) * h
    p2 = (0.5 * r2 - 1.5 * r3 + 1.5 * r4 - 0.5 * r5) * h * h
    q2 = (0.5 * r3 - r4 + 0.5 * r5) * h * h
    db = (30.0 * r2 - 60.0 * r3 + 30.0 * r4) / h
    dp1 = 1.0 - 18.0 * r2 + 32.0 * r3 - 15.0 * r4
    dq1 = -12.0 * r2 + 28.0 * r3 - 15.0 * r4
    dp2 = (r - 4.5 * r2 + 6.0 * r3 - 2.5 * r4) * h
    dq2 = (1.5 * r2 - 4.0 * r3 + 2.5 * r4) * h
    eb = (60.0 * r - 180.0 * r2 + 120.0 * r3) / (h * h)
    ep1 = (-36.0 * r + 96.0 * r2 - 60.0 * r3) / h
    eq1 = (-24.0 * r + 84.0 * r2 - 60.0 * r3) / h
    ep2 = 1.0 - 9.0 * r + 18.0 * r2 - 10.0 * r3
    eq2 = 3.0 * r - 12.0 * r2 + 10.0 * r3
    for c in range(cols):
        dx = out[c, 0] - y[c, 0]
        v0 = y[c, 1]
        v1 = out[c, 1]
        a0 = k[c, 1, 0]
        a1 = k[c, 1, 6]
        ox[row, c] = y[c, 0] + b * dx + p1 * v0 + q1 * v1 + p2 * a0 + q2 * a1
        ov[row, c] = db * dx + dp1 * v0 + dq1 * v1 + dp2 * a0 + dq2 * a1
        oa[row, c] = eb * dx + ep1 * v0 + eq1 * v1 + ep2 * a0 + eq2 * a1
    for i in range(2, 2 + 2 * dims[1], 2):
        ds = out[0, i] - y[0, i]
        os[row, i - 2] = (
            y[0, i] + b * ds + p1 * y[0, i + 1] + q1 * out[0, i + 1] + p2 * k[0, i + 1, 0] + q2 * k[0, i + 1, 6]
        )  # fmt: skip
        os[row, i - 1] = db * ds + dp1 * y[0, i + 1] + dq1 * out[0, i + 1] + dp2 * k[0, i + 1, 0] + dq2 * k[0, i + 1, 6]


@njit(**_BORROWS)
def _start(th, active, y, cols, dims):
    """Initial state and its sensitivities by x0, v0 and the hidden oscillators' initial states."""
    nh = dims[1]
    y[0, 0] = th[_X0]
    y[0, 1] = th[_V0]
    for i in range(nh):
        y[0, 2 + 2 * i] = th[_H + i * _NH + 5]
        y[0, 3 + 2 * i] = th[_H + i * _NH + 6]
    for c in range(1, cols):
        slot = active[c - 1]
        if slot == _X0:
            y[c, 0] = 1.0
        elif slot == _V0:
            y[c, 1] = 1.0
        for i in range(nh):
            if slot == _H + i * _NH + 5:
                y[c, 2 + 2 * i] = 1.0
            elif slot == _H + i * _NH + 6:
                y[c, 3 + 2 * i] = 1.0


@njit(**_BORROWS)
def _dimensions(th):
    """Length of the state; numbers of hidden oscillators, of relaxations and of bristles that the vector asks for."""
    nh = 0
    for i in range(MAX_HIDDEN):
        if th[_H + i * _NH + 1] > 0.0:
            nh = i + 1
    nr = 0
    for j in range(MAX_RELAX):
        if th[_R + j * _NR + 1] > 0.0:
            nr = j + 1
    nb = 1 if th[_FB] > 0.0 else 0
    return 2 + 2 * nh + nr + nb, nh, nr, nb


@njit(**_BORROWS)
def _bound(th, dims):
    """A displacement no sound motion reaches, m: a million times what the initial state and the forcing stand for."""
    size = abs(th[_X0]) + abs(th[_V0]) + abs(th[_XE]) + (abs(th[_FCOS]) + abs(th[_FSIN])) / th[_M]
    for i in range(dims[1]):
        size += abs(th[_H + i * _NH + 5]) + abs(th[_H + i * _NH + 6])
    return 1e6 * size


# ---------------------------------------------------------------- the whole motion
@compiled("Tuple((f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i8))(f8[::1], i8[::1], f8[::1], f8)", **_OPT)
def integrate(
    th: Array, active: NDArray[np.int64], times: Array, h_max: float
) -> tuple[Array, Array, Array, Array, int]:
    """Motion from t = 0 with the parameter vector ``th`` (slots as in SLOTS), sampled at ``times`` (m,), s, rising.

    ``active`` (p,) are the slots whose sensitivities are wanted, ``h_max`` the largest step in s. Gives x, v, a each
    (m, 1 + p): column 0 the motion, column 1 + j its derivative by slot active[j]; the hidden displacements and
    velocities (m, 2 n_hidden); and the number of steps, negative where the motion left every bound.
    """
    m = times.size
    cols = 1 + active.size
    dims = _dimensions(th)
    nh = dims[1]
    ox = np.zeros((m, cols))
    ov = np.zeros((m, cols))
    oa = np.zeros((m, cols))
    os = np.zeros((m, 2 * nh))
    n = dims[0]
    y = np.zeros((cols, n))
    out = np.zeros((cols, n))
    k = np.zeros((cols, n, 7))
    jac = np.zeros(2 * MAX_HIDDEN)
    sens = np.zeros(cols)
    delayed = th[_GE] != 0.0
    if delayed:
        h_max = min(h_max, max(th[_TE], 1e-3 * h_max))
    room = 64 + int(times[m - 1] / h_max) if delayed else 1
    past = (np.zeros((room, 2)), np.zeros((room, 6, cols)))
    zero = _int(0)
    stored = _int(0)
    kinks = np.zeros((room, 2))  # instants at which an echo has a kink, in order, and how often that was echoed
    kinks[0, 0] = th[_TE]
    n_kinks = 1 if delayed else 0
    next_kink = 0
    driven = nh > 0 or dims[2] > 0 or delayed or th[_FCOS] != 0.0 or th[_FSIN] != 0.0
    rubs = th[_FC] != 0.0 or th[_FA] != 0.0 or th[_FN] != 0.0 or th[_FS] != 0.0
    sharp = th[_FS] != 0.0 or (th[_CP] != 0.0 and th[_P] < _SHARP_EXPONENT)
    watch = np.empty(5 + MAX_HIDDEN, np.int64)
    watch = watch[: _watched(th, active, dims, watch)]
    _start(th, active, y, cols, dims)
    t = 0.0
    row = _int(0)
    steps = 0
    limit = _bound(th, dims)
    most = min(_MOST_STEPS, _STEPS_SPARE + _STEPS_A_STRETCH * int(times[m - 1] / h_max))
    side = 1.0 if y[0, 0] > th[_XE] or (y[0, 0] == th[_XE] and y[0, 1] > 0.0) else -1.0
    d = 1.0 if y[0, 1] > 0.0 else -1.0
    if y[0, 1] == 0.0:
        excess, way = _excess(th, y, dims, t, side, 0.0)
        d = way if excess > 0.0 or not rubs else 0.0
    _rhs(th, active, y, k, zero, cols, dims, t, d, side, sens, jac)
    while row < m:
        if d == 0.0 and not driven:
            for r in range(row, m):
                for c in range(cols):
                    ox[r, c] = y[c, 0]
            break
        h = h_max
        if sharp:
            h = _short_near_reversal(th, abs(y[0, 1]), abs(k[0, 1, 0]), h_max)
        on_kink = next_kink < n_kinks and kinks[next_kink, 0] < t + h * (1.0 + 1e-9)
        if on_kink:
            h = kinks[next_kink, 0] - t
        if on_kink and h < _INSTANT * h_max:
            _cross_break(th, active, y, k, cols, dims, t, h_max, d, side, past, stored, sens, jac)
            next_kink += 1
            continue
        world = (past, stored)
        _step(th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac)
        event, length = _first_event(th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac, watch)
        on_kink = on_kink and length == h
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
        for c in range(cols):
            for i in range(n):
                y[c, i] = out[c, i]
                k[c, i, 0] = k[c, i, 6]
        if event != _NONE:
            if event == 0:
                y[0, 0] = th[_XE]
                side = 1.0 if y[0, 1] > 0.0 else -1.0
            elif event > 0:
                y[0, event] = 0.0
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
            kinks[n_kinks, 0] = t + th[_TE]
            kinks[n_kinks, 1] = 0.0 if fresh else kinks[next_kink - 1, 1] + 1.0
            n_kinks += 1
        if not (abs(y[0, 0]) < limit) or steps > most:
            return ox, ov, oa, os, -steps
    return ox, ov, oa, os, steps
