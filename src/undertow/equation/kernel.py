"""The compiled integrator of one superset equation, exact at every stick, slip and re-slip, with sensitivities.

    M x'' + K(x - x_e) + D(x - x_e, v) + fric(x, v) sign(v) + z + r + G v(t - tau) + F(t) = sum_i m_i R_i,
    s_i'' = -x'' - R_i,   R_i = 2 zeta_i w_i s_i' + w_i^2 s_i + b_i s_i'|s_i'| + g_i s_i^3     (hidden oscillators)
    z_j'  = k_j v - z_j / tau_j                                                              (relaxations)
    r'    = k_b v (1 - sign(v) r / F_b)                                                      (bristle: presliding)

Method: explicit Runge-Kutta of order 5 (Tsitouras 2011, doi:10.1016/j.camwa.2011.06.002) with a fixed largest step;
a step that crosses a velocity reversal is repeated up to the reversal (Newton on the step's length), so that every
step sees a smooth right-hand side. Samples in between come from the quintic through x, v, a at both ends. Columns
1.. of the state carry d(state)/d(parameter); across an event they jump by (f_minus - f_plus) dt*/dp.

One file, because numba's cache does not see changes in other files. Sections: slots, right-hand side, step, events,
output, integrate. Does not belong here: what the slots mean to a user (term.py and its neighbours).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

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

_STUCK_TOLERANCE = 1e-12
"""Share of the velocity's change over the step that counts as zero after Newton's iteration on an event."""

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

_SLIP = -1
_NONE = -2
_OPT = {"fastmath": False, "error_model": "numpy", "nogil": True}
"""Compiler options; only `integrate` is cached: the functions it calls are compiled into it."""


# ---------------------------------------------------------------- right-hand side
@njit(inline="always", **_OPT)
def _power_law(v, d, p):
    """|v|^p in the direction d, safe at v = 0."""
    s = v * d
    if s <= 0.0:
        return 0.0
    return d * s**p


@njit(inline="always", **_OPT)
def _resisting(th, x, v, d):
    """Friction's size in the direction d of motion: F_c + F_a d + F_n |x| + F_s exp(-(v/v_s)^2)."""
    size = th[_FC] + th[_FA] * d
    if th[_FN] != 0.0:
        size += th[_FN] * abs(x)
    if th[_FS] != 0.0:
        size += th[_FS] * math.exp(-((v / th[_VS]) ** 2))
    return size


@njit(inline="always", **_OPT)
def _smooth_force(th, x, v, d):
    """All algebraic forces but friction, at displacement x from rest and velocity v moving in direction d."""
    f = th[_K1] * x + th[_C1] * v + th[_Q] * v * v * d
    if th[_K3] != 0.0 or th[_K2] != 0.0 or th[_KA] != 0.0 or th[_K5] != 0.0:
        f += x * x * (th[_K2] + x * (th[_K3] + x * x * th[_K5])) + th[_KA] * x * abs(x)
    if th[_KS] != 0.0:
        f += th[_KS] * math.sin(x)
    if th[_C3] != 0.0 or th[_XV] != 0.0 or th[_XXV] != 0.0:
        f += v * (th[_C3] * v * v + x * (th[_XV] + th[_XXV] * x))
    if th[_CP] != 0.0:
        f += th[_CP] * _power_law(v, d, th[_P])
    return f


@njit(inline="always", **_OPT)
def _outside_force(th, t, echo):
    """Forces with a clock of their own: harmonic forcing and the delayed echo of the velocity."""
    f = th[_GE] * echo
    if th[_FCOS] != 0.0 or th[_FSIN] != 0.0:
        f += th[_FCOS] * math.cos(th[_OM] * t) + th[_FSIN] * math.sin(th[_OM] * t)
    return f


@njit(inline="always", **_OPT)
def _hidden_restoring(th, i, s, u):
    """R_i of hidden oscillator i at displacement s and velocity u relative to the body, per unit mass."""
    o = _H + i * _NH
    w = th[o + 1]
    return 2.0 * th[o + 2] * w * u + w * w * s + th[o + 3] * u * abs(u) + th[o + 4] * s * s * s


@njit(inline="always", **_OPT)
def _pull(th, y, cols, nh, nr, nb, t, d, echo, v):
    """Net force on the body without friction, N: what accelerates it, or what friction has to hold."""
    x = y[0] - th[_XE]
    f = -_smooth_force(th, x, v, d) - _outside_force(th, t, echo)
    for i in range(nh):
        f += th[_H + i * _NH] * _hidden_restoring(th, i, y[(2 + 2 * i) * cols], y[(3 + 2 * i) * cols])
    base = 2 + 2 * nh
    for j in range(nr + nb):
        f -= y[(base + j) * cols]
    return f


@njit(**_OPT)
def _rhs(th, active, y, dy, cols, nh, nr, nb, t, d, sens):
    """d(state)/dt into dy, column 0; with cols > 1 the sensitivities of the ``active`` slots in columns 1...

    d is the direction of motion (+1, -1) or 0 for a stuck body. sens[0] is v(t - tau), sens[1:] its sensitivities.
    """
    mass = th[_M]
    x = y[0] - th[_XE]
    v = y[cols]
    base = 2 + 2 * nh
    a = 0.0
    if d != 0.0:
        a = (_pull(th, y, cols, nh, nr, nb, t, d, sens[0], v) - _resisting(th, x, v, d) * d) / mass
    dy[0] = v if d != 0.0 else 0.0
    dy[cols] = a
    for i in range(nh):
        dy[(2 + 2 * i) * cols] = y[(3 + 2 * i) * cols]
        dy[(3 + 2 * i) * cols] = -a - _hidden_restoring(th, i, y[(2 + 2 * i) * cols], y[(3 + 2 * i) * cols])
    for j in range(nr):
        o = _R + j * _NR
        dy[(base + j) * cols] = th[o] * dy[0] - y[(base + j) * cols] / th[o + 1]
    if nb:
        dy[(base + nr) * cols] = th[_KB] * v * (1.0 - d * y[(base + nr) * cols] / th[_FB]) if d != 0.0 else 0.0
    if cols > 1:
        _rhs_sensitivities(th, active, y, dy, cols, nh, nr, nb, t, d, x, v, a, sens)


@njit(inline="always", **_OPT)
def _rhs_sensitivities(th, active, y, dy, cols, nh, nr, nb, t, d, x, v, a, sens):
    """Columns 1.. of dy: Jacobian times sensitivity, plus the explicit derivative by each active slot."""
    mass = th[_M]
    base = 2 + 2 * nh
    moving = d != 0.0
    fx = th[_K1]
    fv = th[_C1] + 2.0 * th[_Q] * v * d
    if moving:
        if th[_K3] != 0.0 or th[_K2] != 0.0 or th[_KA] != 0.0 or th[_K5] != 0.0:
            fx += x * (2.0 * th[_K2] + x * (3.0 * th[_K3] + 5.0 * x * x * th[_K5])) + 2.0 * th[_KA] * abs(x)
        if th[_KS] != 0.0:
            fx += th[_KS] * math.cos(x)
        if th[_C3] != 0.0 or th[_XV] != 0.0 or th[_XXV] != 0.0:
            fx += v * (th[_XV] + 2.0 * th[_XXV] * x)
            fv += 3.0 * th[_C3] * v * v + x * (th[_XV] + th[_XXV] * x)
        if th[_CP] != 0.0 and v * d > 0.0:
            fv += th[_CP] * th[_P] * (v * d) ** (th[_P] - 1.0)
        if th[_FN] != 0.0:
            fx += th[_FN] * d * (1.0 if x >= 0.0 else -1.0)
        if th[_FS] != 0.0:
            fv -= d * th[_FS] * math.exp(-((v / th[_VS]) ** 2)) * 2.0 * v / th[_VS] ** 2
    for c in range(1, cols):
        da = 0.0
        if moving:
            da = -fx * y[c] - fv * y[cols + c] - th[_GE] * sens[c]
            for i in range(nh):
                o = _H + i * _NH
                s = y[(2 + 2 * i) * cols]
                u = y[(3 + 2 * i) * cols]
                rs = th[o + 1] * th[o + 1] + 3.0 * th[o + 4] * s * s
                ru = 2.0 * th[o + 2] * th[o + 1] + 2.0 * th[o + 3] * abs(u)
                da += th[o] * (rs * y[(2 + 2 * i) * cols + c] + ru * y[(3 + 2 * i) * cols + c])
            for j in range(nr + nb):
                da -= y[(base + j) * cols + c]
            da += _explicit_force(th, active[c - 1], y, cols, nh, t, d, x, v, a, fx, sens)
            da /= mass
        dy[c] = y[cols + c] if moving else 0.0
        dy[cols + c] = da
        for i in range(nh):
            o = _H + i * _NH
            s = y[(2 + 2 * i) * cols]
            u = y[(3 + 2 * i) * cols]
            rs = th[o + 1] * th[o + 1] + 3.0 * th[o + 4] * s * s
            ru = 2.0 * th[o + 2] * th[o + 1] + 2.0 * th[o + 3] * abs(u)
            dr = rs * y[(2 + 2 * i) * cols + c] + ru * y[(3 + 2 * i) * cols + c]
            dr += _explicit_hidden(th, active[c - 1], i, s, u)
            dy[(2 + 2 * i) * cols + c] = y[(3 + 2 * i) * cols + c]
            dy[(3 + 2 * i) * cols + c] = -da - dr
        for j in range(nr):
            o = _R + j * _NR
            slope = th[o] * dy[c] - y[(base + j) * cols + c] / th[o + 1]
            if active[c - 1] == o:
                slope += dy[0]
            elif active[c - 1] == o + 1:
                slope += y[(base + j) * cols] / (th[o + 1] * th[o + 1])
            dy[(base + j) * cols + c] = slope
        if nb:
            r = y[(base + nr) * cols]
            slope = 0.0
            if moving:
                free = 1.0 - d * r / th[_FB]
                slope = th[_KB] * (y[cols + c] * free - v * d * y[(base + nr) * cols + c] / th[_FB])
                if active[c - 1] == _KB:
                    slope += v * free
                elif active[c - 1] == _FB:
                    slope += th[_KB] * v * d * r / (th[_FB] * th[_FB])
            dy[(base + nr) * cols + c] = slope


@njit(inline="always", **_OPT)
def _explicit_hidden(th, slot, i, s, u):
    """dR_i / d(slot) at fixed state."""
    o = slot - (_H + i * _NH)
    base = _H + i * _NH
    if o == 1:
        return 2.0 * th[base + 2] * u + 2.0 * th[base + 1] * s
    if o == 2:
        return 2.0 * th[base + 1] * u
    if o == 3:
        return u * abs(u)
    if o == 4:
        return s * s * s
    return 0.0


@njit(inline="always", **_OPT)
def _explicit_force(th, slot, y, cols, nh, t, d, x, v, a, fx, sens):
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
        return -d * abs(x)
    if slot == _K2:
        return -x * x
    if slot == _KA:
        return -x * abs(x)
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
        return -_power_law(v, d, th[_P])
    if slot == _P:
        return -th[_CP] * _power_law(v, d, th[_P]) * math.log(v * d) if v * d > 0.0 else 0.0
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
        return -sens[0]
    for i in range(nh):
        o = _H + i * _NH
        if slot >= o and slot < o + _NH:
            s = y[(2 + 2 * i) * cols]
            u = y[(3 + 2 * i) * cols]
            if slot == o:
                return _hidden_restoring(th, i, s, u)
            return th[o] * _explicit_hidden(th, slot, i, s, u)
    return 0.0


# ---------------------------------------------------------------- history for the delayed echo
@njit(**_OPT)
def _echo_at(th, active, t, hist_t, hist, hist_n, cols, sens):
    """v(t - tau) and its sensitivities into sens, by cubic Hermite through the stored ends of the step before.

    Before the release the body is at rest: zero. hist[i] holds (v, a) columns at both ends of step i.
    """
    for c in range(cols):
        sens[c] = 0.0
    when = t - th[_TE]
    if th[_GE] == 0.0 or when < 0.0 or hist_n == 0:
        return
    lo = 0
    hi = hist_n - 1
    while lo < hi:
        mid = (lo + hi + 1) // 2
        if hist_t[mid, 0] <= when:
            lo = mid
        else:
            hi = mid - 1
    h = hist_t[lo, 1] - hist_t[lo, 0]
    r = (when - hist_t[lo, 0]) / h
    if r > 1.0:
        r = 1.0
    h00 = (1.0 + 2.0 * r) * (1.0 - r) ** 2
    h10 = r * (1.0 - r) ** 2 * h
    h01 = r * r * (3.0 - 2.0 * r)
    h11 = r * r * (r - 1.0) * h
    for c in range(cols):
        sens[c] = h00 * hist[lo, 0, c] + h10 * hist[lo, 1, c] + h01 * hist[lo, 2, c] + h11 * hist[lo, 3, c]
    if cols > 1:
        d00 = 6.0 * r * (r - 1.0) / h
        a = d00 * (hist[lo, 0, 0] - hist[lo, 2, 0])
        a += (1.0 - r) * (1.0 - 3.0 * r) * hist[lo, 1, 0] + r * (3.0 * r - 2.0) * hist[lo, 3, 0]
        for c in range(1, cols):
            if active[c - 1] == _TE:
                sens[c] -= a


# ---------------------------------------------------------------- one step
@njit(**_OPT)
def _step(th, active, y, out, k, tmp, cols, n, nh, nr, nb, t, h, d, hist_t, hist, hist_n, sens):
    """One Runge-Kutta step of length h from y to out; k[:, 0] must hold the slope at y; k[:, 6] gets that at out."""
    delayed = th[_GE] != 0.0
    size = n * cols
    for stage in range(1, 7):
        w0, w1, w2 = h * _A[stage, 0], h * _A[stage, 1], h * _A[stage, 2]
        w3, w4, w5 = h * _A[stage, 3], h * _A[stage, 4], h * _A[stage, 5]
        for i in range(size):
            out[i] = (
                y[i] + w0 * k[i, 0] + w1 * k[i, 1] + w2 * k[i, 2] + w3 * k[i, 3] + w4 * k[i, 4] + w5 * k[i, 5]
            )  # fmt: skip
        now = t + _C[stage] * h
        if delayed:
            _echo_at(th, active, now, hist_t, hist, hist_n, cols, sens)
        _rhs(th, active, out, tmp, cols, nh, nr, nb, now, d, sens)
        for i in range(size):
            k[i, stage] = tmp[i]


# ---------------------------------------------------------------- events
@njit(**_OPT)
def _excess(th, y, cols, nh, nr, nb, t, echo):
    """By how much the pull on a body at rest exceeds what friction holds, N (negative: it sticks), and whereto."""
    x = y[0] - th[_XE]
    pull = _pull(th, y, cols, nh, nr, nb, t, 0.0, echo, 0.0)
    forward = pull - _resisting(th, x, 0.0, 1.0)
    backward = -pull - _resisting(th, x, 0.0, -1.0)
    if forward > backward:
        return forward, 1.0
    return backward, -1.0


@njit(**_OPT)
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


@njit(**_OPT)
def _gauge(th, y, cols, nh, nr, nb, t, echo, which):
    """What is zero at an event: state ``which`` (x from rest, or a velocity), or with _SLIP a stuck body's excess pull."""
    if which == _SLIP:
        return _excess(th, y, cols, nh, nr, nb, t, echo)[0]
    return y[which * cols] - (th[_XE] if which == 0 else 0.0)


@njit(**_OPT)
def _locate(th, active, y, out, k, tmp, cols, n, nh, nr, nb, t, h, d, hist_t, hist, hist_n, sens, which):
    """Length of the step that ends on an event, with ``out`` and k[6] there; the full step must have crossed it.

    Newton with the state's own slope, kept inside a bracket; bisection for the excess pull, which has none.
    """
    lo = 0.0
    hi = h
    f0 = _gauge(th, y, cols, nh, nr, nb, t, sens[0], which)
    f1 = _gauge(th, out, cols, nh, nr, nb, t + h, sens[0], which)
    scale = abs(f0) + abs(f1)
    guess = h * f0 / (f0 - f1) if f0 * f1 < 0.0 else 0.5 * h
    if which != _SLIP and f0 * f1 < 0.0:
        guess = _cubic_root(f0, f1, h * k[which * cols, 0], h * k[which * cols, 6], guess / h) * h
    length = h
    for _ in range(80):
        if guess <= lo or guess >= hi:
            guess = 0.5 * (lo + hi)
        length = guess
        _step(th, active, y, out, k, tmp, cols, n, nh, nr, nb, t, length, d, hist_t, hist, hist_n, sens)
        f = _gauge(th, out, cols, nh, nr, nb, t + length, sens[0], which)
        if abs(f) <= _STUCK_TOLERANCE * scale or hi - lo < 1e-15 * (1.0 + t):
            break
        if f * f1 > 0.0:
            hi = length
        else:
            lo = length
        slope = k[which * cols, 6] if which != _SLIP else 0.0
        guess = length - f / slope if slope != 0.0 else 0.5 * (lo + hi)
    return length


@njit(**_OPT)
def _jump(y, before, after, n, cols, which):
    """Sensitivities across an event at which state ``which`` is zero: S += (f_minus - f_plus) dt*/dp."""
    slope = before[which * cols]
    if slope == 0.0:
        return
    for c in range(1, cols):
        dt = -y[which * cols + c] / slope
        for i in range(n):
            y[i * cols + c] += (before[i * cols] - after[i * cols]) * dt


# ---------------------------------------------------------------- samples inside a step
@njit(**_OPT)
def _sample(y, f0, out, f1, cols, nh, h, r, row, ox, ov, oa, os):
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
        x0 = y[c]
        x1 = out[c]
        v0 = y[cols + c]
        v1 = out[cols + c]
        a0 = f0[cols + c]
        a1 = f1[cols + c]
        ox[row, c] = x0 + b * (x1 - x0) + p1 * v0 + q1 * v1 + p2 * a0 + q2 * a1
        ov[row, c] = db * (x1 - x0) + dp1 * v0 + dq1 * v1 + dp2 * a0 + dq2 * a1
        oa[row, c] = eb * (x1 - x0) + ep1 * v0 + eq1 * v1 + ep2 * a0 + eq2 * a1
    for i in range(nh):
        s0 = y[(2 + 2 * i) * cols]
        s1 = out[(2 + 2 * i) * cols]
        u0 = y[(3 + 2 * i) * cols]
        u1 = out[(3 + 2 * i) * cols]
        a0 = f0[(3 + 2 * i) * cols]
        a1 = f1[(3 + 2 * i) * cols]
        os[row, 2 * i] = s0 + b * (s1 - s0) + p1 * u0 + q1 * u1 + p2 * a0 + q2 * a1
        os[row, 2 * i + 1] = db * (s1 - s0) + dp1 * u0 + dq1 * u1 + dp2 * a0 + dq2 * a1


@njit(**_OPT)
def _start(th, active, y, cols, nh):
    """Initial state and its sensitivities by x0, v0 and the hidden oscillators' initial states."""
    y[0] = th[_X0]
    y[cols] = th[_V0]
    for i in range(nh):
        y[(2 + 2 * i) * cols] = th[_H + i * _NH + 5]
        y[(3 + 2 * i) * cols] = th[_H + i * _NH + 6]
    for c in range(1, cols):
        slot = active[c - 1]
        if slot == _X0:
            y[c] = 1.0
        elif slot == _V0:
            y[cols + c] = 1.0
        for i in range(nh):
            if slot == _H + i * _NH + 5:
                y[(2 + 2 * i) * cols + c] = 1.0
            elif slot == _H + i * _NH + 6:
                y[(3 + 2 * i) * cols + c] = 1.0


# ---------------------------------------------------------------- the whole motion
@njit(
    "Tuple((f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i8))(f8[::1], i8[::1], f8[::1], f8)",
    cache=True,
    **_OPT,
)
def integrate(th, active, times, h_max):
    """Motion from t = 0 with the parameter vector ``th`` (slots as in SLOTS), sampled at ``times`` (m,), s, rising.

    ``active`` (p,) are the slots whose sensitivities are wanted, ``h_max`` the largest step in s. Gives x, v, a each
    (m, 1 + p): column 0 the motion, column 1 + j its derivative by slot active[j]; the hidden displacements and
    velocities (m, 2 n_hidden); and the number of steps, negative where the motion left every bound.
    """
    m = times.size
    cols = 1 + active.size
    nh = 0
    for i in range(3):
        if th[_H + i * _NH + 1] > 0.0:
            nh = i + 1
    nr = 0
    for j in range(2):
        if th[_R + j * _NR + 1] > 0.0:
            nr = j + 1
    nb = 1 if th[_FB] > 0.0 else 0
    n = 2 + 2 * nh + nr + nb
    ox = np.zeros((m, cols))
    ov = np.zeros((m, cols))
    oa = np.zeros((m, cols))
    os = np.zeros((m, 2 * nh))
    size = n * cols
    y = np.zeros(size)
    out = np.zeros(size)
    tmp = np.zeros(size)
    k = np.zeros((size, 7))
    first = np.zeros(size)
    last = np.zeros(size)
    sens = np.zeros(cols)
    delayed = th[_GE] != 0.0
    room = 4 + int(4.0 * (times[m - 1] / min(h_max, max(th[_TE], 1e-4)) + 1.0)) if delayed else 1
    hist_t = np.zeros((room, 2))
    hist = np.zeros((room, 4, cols))
    breaks = np.zeros(room)
    n_breaks = 0
    if delayed:
        breaks[0] = th[_TE]
        n_breaks = 1
        h_max = min(h_max, max(th[_TE], 1e-4))
    hist_n = 0
    driven = nh > 0 or nr > 0 or delayed or th[_FCOS] != 0.0 or th[_FSIN] != 0.0
    signed = (
        th[_FC] != 0.0 or th[_Q] != 0.0 or th[_CP] != 0.0 or th[_FA] != 0.0
        or th[_FN] != 0.0 or th[_FS] != 0.0 or nb > 0
    )  # fmt: skip
    kinked = th[_KA] != 0.0 or th[_FN] != 0.0
    _start(th, active, y, cols, nh)
    t = 0.0
    row = 0
    steps = 0
    limit = 1e6 * (abs(th[_X0]) + abs(th[_V0]) + 1e-9)
    d = 1.0 if y[cols] > 0.0 else -1.0
    if y[cols] == 0.0:
        excess, side = _excess(th, y, cols, nh, nr, nb, t, 0.0)
        d = side if excess > 0.0 else 0.0
    _rhs(th, active, y, first, cols, nh, nr, nb, t, d, sens)
    for i in range(size):
        k[i, 0] = first[i]
    while row < m:
        if d == 0.0 and not driven:
            for r in range(row, m):
                for c in range(cols):
                    ox[r, c] = y[c]
            break
        h = h_max
        for b in range(n_breaks):
            if breaks[b] > t + 1e-12 and breaks[b] < t + h:
                h = breaks[b] - t
        _step(th, active, y, out, k, tmp, cols, n, nh, nr, nb, t, h, d, hist_t, hist, hist_n, sens)
        event = _NONE
        for e in range(-2, nh):
            which = 1 if e == -1 else 3 + 2 * e
            if e == -2:
                which = 0
                if not kinked or (y[0] - th[_XE]) * (out[0] - th[_XE]) >= 0.0:
                    continue
            elif e == -1 and d == 0.0:
                which = _SLIP
                if _excess(th, out, cols, nh, nr, nb, t + h, sens[0])[0] <= 0.0:
                    continue
            elif e == -1:
                if not signed or out[cols] * d >= 0.0:
                    continue
            elif th[_H + e * _NH + 3] == 0.0 or abs(y[which * cols]) < 1e-12:
                continue
            elif out[which * cols] * y[which * cols] > 0.0:
                continue
            h = _locate(
                th, active, y, out, k, tmp, cols, n, nh, nr, nb, t, h, d, hist_t, hist, hist_n, sens, which
            )  # fmt: skip
            event = which
        steps += 1
        for i in range(size):
            last[i] = k[i, 6]
        while row < m and times[row] <= t + h + 1e-13:
            _sample(y, first, out, last, cols, nh, h, (times[row] - t) / h, row, ox, ov, oa, os)
            row += 1
        if delayed:
            hist_t[hist_n, 0] = t
            hist_t[hist_n, 1] = t + h
            for c in range(cols):
                hist[hist_n, 0, c] = y[cols + c]
                hist[hist_n, 1, c] = first[cols + c]
                hist[hist_n, 2, c] = out[cols + c]
                hist[hist_n, 3, c] = last[cols + c]
            hist_n += 1
        t += h
        for i in range(size):
            y[i] = out[i]
            first[i] = last[i]
        if event != _NONE:
            if event == 0:
                y[0] = th[_XE]
            elif event > 0:
                y[event * cols] = 0.0
            if event == 1 or event == _SLIP:
                excess, side = _excess(th, y, cols, nh, nr, nb, t, sens[0])
                d = side if event == _SLIP or excess > 0.0 else 0.0
            _rhs(th, active, y, tmp, cols, nh, nr, nb, t, d, sens)
            if event == 1:
                _jump(y, last, tmp, n, cols, event)
                _rhs(th, active, y, tmp, cols, nh, nr, nb, t, d, sens)
            for i in range(size):
                first[i] = tmp[i]
            if delayed and (event == 1 or event == _SLIP) and n_breaks < room:
                breaks[n_breaks] = t + th[_TE]
                n_breaks += 1
        for i in range(size):
            k[i, 0] = first[i]
        if not (abs(y[0]) < limit) or steps > 2000000 or (delayed and hist_n == room):
            return ox, ov, oa, os, -steps
    return ox, ov, oa, os, steps
