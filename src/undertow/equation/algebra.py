"""Generated from the laws' rows: forces, slopes and derivatives of all laws, compiled into the integrators.

Do not edit: change a law's row (structure.py and its neighbours) and run `python -m undertow.equation.generate`.
A test compares.
"""

# mypy: disable-error-code="no-untyped-def, untyped-decorator, no-any-return"
# ruff: noqa: E501

from __future__ import annotations

import math

from numba import njit

from undertow.compiling import WITHIN

SLOTS: tuple[str, ...] = (
    "mass", "xe", "x0", "v0", "let_go", "let_go_p", "hold", "k1", "c1", "fc", "q", "c3",
    "cb", "qa", "cp", "p", "k3", "k5", "k2", "kd", "td", "ka", "ks", "xv",
    "xxv", "fs", "vs", "fa", "fn", "fcos", "omega", "fsin", "gcos", "gomega", "gsin", "gcos_t",
    "gsin_t", "gcos_tt", "gsin_tt", "gcos_t3", "gsin_t3", "gcos_t4", "gsin_t4", "gcos_t5", "gsin_t5", "gcos_t6", "gsin_t6", "ge",
    "tau_e", "kb", "fb", "hm1", "hw1", "hz1", "hb1", "hg1", "hs1", "hu1", "hm2", "hw2",
    "hz2", "hb2", "hg2", "hs2", "hu2", "hm3", "hw3", "hz3", "hb3", "hg3", "hs3", "hu3",
    "rk1", "rt1", "rk2", "rt2",
)
"""Names of the parameter vector's places, in order: hm1 is the first hidden oscillator's mass."""

SLOT: dict[str, int] = {name: i for i, name in enumerate(SLOTS)}
N_SLOTS = len(SLOTS)

(
    _MASS, _XE, _X0, _V0, _LET_GO, _LET_GO_P, _HOLD, _K1, _C1, _FC, _Q, _C3,
    _CB, _QA, _CP, _P, _K3, _K5, _K2, _KD, _TD, _KA, _KS, _XV,
    _XXV, _FS, _VS, _FA, _FN, _FCOS, _OMEGA, _FSIN, _GCOS, _GOMEGA, _GSIN, _GCOS_T,
    _GSIN_T, _GCOS_TT, _GSIN_TT, _GCOS_T3, _GSIN_T3, _GCOS_T4, _GSIN_T4, _GCOS_T5, _GSIN_T5, _GCOS_T6, _GSIN_T6, _GE,
    _TAU_E, _KB, _FB,
) = range(51)
_HM = 51
_RK = 72
_NH = 7
_START = 5
MAX_HIDDEN = 3

RUBBING: tuple[str, ...] = ("fc", "fs", "fa", "fn",)
"""Slots that hold friction: it goes with the normal force."""


@njit(inline="always", **WITHIN)
def _power_law(v, p):
    """|v|^p sign(v); beyond a reversal it goes on as an odd function."""
    if v == 0.0:
        return 0.0
    return math.copysign(abs(v) ** p, v)


@njit(inline="always", **WITHIN)
def _power_slope(v, p, way):
    """p |v|^(p-1); 0 at v = 0, and beyond a reversal for an exponent below one, where it has a pole."""
    if v != 0.0 and (v * way > 0.0 or p >= 1.0):
        return p * abs(v) ** (p - 1.0)
    return 0.0


@njit(inline="always", **WITHIN)
def _power_log(v, p):
    """|v|^p sign(v) log|v|."""
    if v == 0.0:
        return 0.0
    return _power_law(v, p) * math.log(abs(v))


@njit(inline="always", **WITHIN)
def _resisting(th, x, v, d, side):
    """Friction's size in the direction d of motion, N."""
    size = th[_FC]
    if th[_FS] != 0.0:
        size += th[_FS] * math.exp(-v * v / (th[_VS] * th[_VS]))
    if th[_FA] != 0.0 or th[_FN] != 0.0:
        size += d * th[_FA] + th[_FN] * side * x
    return size


@njit(inline="always", **WITHIN)
def _smooth_force(th, x, v, d, side):
    """All forces of x and v but friction, N."""
    f = th[_K1] * x + v * (th[_C1] + d * th[_Q] * v)
    if th[_C3] != 0.0 or th[_CB] != 0.0 or th[_QA] != 0.0 or th[_XV] != 0.0 or th[_XXV] != 0.0:
        f += v * (th[_CB] * d + v * (th[_C3] * v + th[_QA]) + x * (x * th[_XXV] + th[_XV]))
    if th[_CP] != 0.0:
        f += th[_CP] * _power_law(v, th[_P])
    if th[_K3] != 0.0 or th[_K5] != 0.0 or th[_K2] != 0.0 or th[_KA] != 0.0:
        f += x * x * (th[_K2] + th[_KA] * side + x * (th[_K3] + th[_K5] * x * x))
    if th[_KS] != 0.0:
        f += th[_KS] * math.sin(x)
    return f


@njit(inline="always", **WITHIN)
def _outside_force(th, x, v, d, side, t, echo):
    """Forces that the time tells, or an echo, N."""
    f = echo * th[_GE]
    if th[_KD] != 0.0:
        w0 = th[_KD] * x
        f += w0 - w0 * math.exp(-t / th[_TD])
    if th[_OMEGA] != 0.0:
        w0 = th[_OMEGA] * t
        f += th[_FCOS] * math.cos(w0) + th[_FSIN] * math.sin(w0)
    if th[_GOMEGA] != 0.0:
        w0 = th[_GOMEGA] * t
        w1 = math.cos(w0)
        w2 = math.sin(w0)
        w3 = t * t * t
        w4 = t * t * t * t
        w5 = t * t * t * t * t
        w6 = t * t * t * t * t * t
        w7 = t * t
        f += th[_GCOS] * w1 + th[_GCOS_T] * t * w1 + th[_GCOS_T3] * w1 * w3 + th[_GCOS_T4] * w1 * w4 + th[_GCOS_T5] * w1 * w5 + th[_GCOS_T6] * w1 * w6 + th[_GCOS_TT] * w1 * w7 + th[_GSIN] * w2 + th[_GSIN_T] * t * w2 + th[_GSIN_T3] * w2 * w3 + th[_GSIN_T4] * w2 * w4 + th[_GSIN_T5] * w2 * w5 + th[_GSIN_T6] * w2 * w6 + th[_GSIN_TT] * w2 * w7
    return f


@njit(inline="always", **WITHIN)
def _slopes(th, x, v, d, side, t):
    """Derivatives of all forces by x and by v, N/m and N s/m."""
    fx = th[_K1]
    fv = th[_C1] + 2.0 * d * th[_Q] * v
    if th[_C3] != 0.0 or th[_CB] != 0.0 or th[_QA] != 0.0 or th[_XV] != 0.0 or th[_XXV] != 0.0:
        fx += v * (2.0 * x * th[_XXV] + th[_XV])
        fv += th[_CB] * d + v * (3.0 * th[_C3] * v + 2.0 * th[_QA]) + x * (x * th[_XXV] + th[_XV])
    if th[_CP] != 0.0:
        fv += th[_CP] * _power_slope(v, th[_P], d)
    if th[_K3] != 0.0 or th[_K5] != 0.0 or th[_K2] != 0.0 or th[_KA] != 0.0 or th[_FA] != 0.0 or th[_FN] != 0.0:
        fx += d * th[_FN] * side + x * (2.0 * th[_K2] + 2.0 * th[_KA] * side + x * (3.0 * th[_K3] + 5.0 * th[_K5] * x * x))
    if th[_KS] != 0.0:
        fx += th[_KS] * math.cos(x)
    if th[_FS] != 0.0:
        w0 = 1.0 / (th[_VS] * th[_VS])
        fv -= 2.0 * d * th[_FS] * v * w0 * math.exp(-v * v * w0)
    if th[_KD] != 0.0:
        fx += th[_KD] - th[_KD] * math.exp(-t / th[_TD])
    return fx, fv


@njit(inline="always", **WITHIN)
def _explicit_drive(th, slot, t):
    """d(M a)/d(slot) of forces that the time alone tells, N per unit of the slot."""
    if slot == _FCOS:
        return -math.cos(th[_OMEGA] * t)
    if slot == _OMEGA:
        return th[_FCOS] * t * math.sin(th[_OMEGA] * t) - th[_FSIN] * t * math.cos(th[_OMEGA] * t)
    if slot == _FSIN:
        return -math.sin(th[_OMEGA] * t)
    if slot == _GCOS:
        return -math.cos(th[_GOMEGA] * t)
    if slot == _GOMEGA:
        w0 = th[_GOMEGA] * t
        w1 = math.sin(w0)
        w2 = math.cos(w0)
        w3 = t * t
        w4 = t * t * t * t
        w5 = t * t * t * t * t
        w6 = t * t * t * t * t * t
        w7 = t**7
        w8 = t * t * t
        return th[_GCOS] * t * w1 + th[_GCOS_T] * w1 * w3 + th[_GCOS_T3] * w1 * w4 + th[_GCOS_T4] * w1 * w5 + th[_GCOS_T5] * w1 * w6 + th[_GCOS_T6] * w1 * w7 + th[_GCOS_TT] * w1 * w8 - th[_GSIN] * t * w2 - th[_GSIN_T] * w2 * w3 - th[_GSIN_T3] * w2 * w4 - th[_GSIN_T4] * w2 * w5 - th[_GSIN_T5] * w2 * w6 - th[_GSIN_T6] * w2 * w7 - th[_GSIN_TT] * w2 * w8
    if slot == _GSIN:
        return -math.sin(th[_GOMEGA] * t)
    if slot == _GCOS_T:
        return -t * math.cos(th[_GOMEGA] * t)
    if slot == _GSIN_T:
        return -t * math.sin(th[_GOMEGA] * t)
    if slot == _GCOS_TT:
        return -t * t * math.cos(th[_GOMEGA] * t)
    if slot == _GSIN_TT:
        return -t * t * math.sin(th[_GOMEGA] * t)
    if slot == _GCOS_T3:
        return -t * t * t * math.cos(th[_GOMEGA] * t)
    if slot == _GSIN_T3:
        return -t * t * t * math.sin(th[_GOMEGA] * t)
    if slot == _GCOS_T4:
        return -t * t * t * t * math.cos(th[_GOMEGA] * t)
    if slot == _GSIN_T4:
        return -t * t * t * t * math.sin(th[_GOMEGA] * t)
    if slot == _GCOS_T5:
        return -t * t * t * t * t * math.cos(th[_GOMEGA] * t)
    if slot == _GSIN_T5:
        return -t * t * t * t * t * math.sin(th[_GOMEGA] * t)
    if slot == _GCOS_T6:
        return -t * t * t * t * t * t * math.cos(th[_GOMEGA] * t)
    if slot == _GSIN_T6:
        return -t * t * t * t * t * t * math.sin(th[_GOMEGA] * t)
    return 0.0


@njit(inline="always", **WITHIN)
def _explicit_force(th, slot, y, nh, t, d, side, x, v, a, fx, echo):
    """d(M a)/d(slot) at fixed state, N per unit of the slot."""
    if slot == _MASS:
        return -a
    if slot == _XE:
        return fx
    if slot == _K1:
        return -x
    if slot == _C1:
        return -v
    if slot == _FC:
        return -d
    if slot == _Q:
        return -d * v * v
    if slot == _C3:
        return -v * v * v
    if slot == _CB:
        return -d * v
    if slot == _QA:
        return -v * v
    if slot == _CP:
        return -_power_law(v, th[_P])
    if slot == _P:
        return -th[_CP] * _power_log(v, th[_P])
    if slot == _K3:
        return -x * x * x
    if slot == _K5:
        return -x * x * x * x * x
    if slot == _K2:
        return -x * x
    if slot == _KD:
        return -x + x * math.exp(-t / th[_TD])
    if slot == _TD:
        return th[_KD] * t * x * math.exp(-t / th[_TD]) / (th[_TD] * th[_TD])
    if slot == _KA:
        return -side * x * x
    if slot == _KS:
        return -math.sin(x)
    if slot == _XV:
        return -v * x
    if slot == _XXV:
        return -v * x * x
    if slot == _FS:
        return -d * math.exp(-v * v / (th[_VS] * th[_VS]))
    if slot == _VS:
        return -2.0 * d * th[_FS] * v * v * math.exp(-v * v / (th[_VS] * th[_VS])) / (th[_VS] * th[_VS] * th[_VS])
    if slot == _FA:
        return -1.0
    if slot == _FN:
        return -d * side * x
    if slot == _GE:
        return -echo
    if slot in (_FCOS, _OMEGA, _FSIN, _GCOS, _GOMEGA, _GSIN, _GCOS_T, _GSIN_T, _GCOS_TT, _GSIN_TT, _GCOS_T3, _GSIN_T3, _GCOS_T4, _GSIN_T4, _GCOS_T5, _GSIN_T5, _GCOS_T6, _GSIN_T6):
        return _explicit_drive(th, slot, t)
    for i in range(nh):
        o = _HM + i * _NH
        if slot >= o and slot < o + _NH:
            if slot == o:
                return _hidden_restoring(th, i, y[2 + 2 * i, 0], y[3 + 2 * i, 0])
            return th[o] * _explicit_hidden(th, slot, i, y[2 + 2 * i, 0], y[3 + 2 * i, 0])
    return 0.0


@njit(inline="always", **WITHIN)
def _rubs(th):
    """Whether friction can hold the body."""
    return th[_FC] != 0.0 or th[_FS] != 0.0 or th[_FA] != 0.0 or th[_FN] != 0.0


@njit(inline="always", **WITHIN)
def _turns(th, active, dims):
    """Whether a law bends where the body reverses, or would."""
    found = th[_FC] != 0.0 or th[_Q] != 0.0 or th[_CB] != 0.0 or th[_CP] != 0.0 or th[_FS] != 0.0 or th[_FA] != 0.0 or th[_FN] != 0.0 or dims[4] > 0
    for slot in active:
        found = found or slot in (_FC, _Q, _CB, _CP, _FS, _FN)
    return found


@njit(inline="always", **WITHIN)
def _kinks(th, active):
    """Whether a law bends where the body passes its rest position, or would."""
    found = th[_KA] != 0.0 or th[_FN] != 0.0
    for slot in active:
        found = found or slot in (_KA, _FN)
    return found


@njit(inline="always", **WITHIN)
def _stirs(th, dims):
    """Whether something may move a body that sticks: what has a time of its own."""
    return dims[1] > 0 or dims[3] > 0 or th[_KD] != 0.0 or th[_OMEGA] != 0.0 or th[_GOMEGA] != 0.0


@njit(inline="always", **WITHIN)
def _hidden_restoring(th, i, s, u):
    """R of hidden oscillator i, per unit mass."""
    o = _HM + i * _NH
    return th[o + 3] * u * abs(u) + th[o + 4] * s * s * s + th[o + 1] * th[o + 1] * s + 2.0 * th[o + 1] * th[o + 2] * u


@njit(inline="always", **WITHIN)
def _hidden_slopes(th, i, s, u, jac):
    """Derivatives of R by s and by u, into jac."""
    o = _HM + i * _NH
    jac[2 * i] = 3.0 * th[o + 4] * s * s + th[o + 1] * th[o + 1]
    jac[2 * i + 1] = 2.0 * th[o + 3] * abs(u) + 2.0 * th[o + 1] * th[o + 2]


@njit(inline="always", **WITHIN)
def _explicit_hidden(th, slot, i, s, u):
    """dR / d(slot) at fixed state."""
    o = _HM + i * _NH
    p = slot - o
    if p == 1:
        return 2.0 * th[o + 1] * s + 2.0 * th[o + 2] * u
    if p == 2:
        return 2.0 * th[o + 1] * u
    if p == 3:
        return u * abs(u)
    if p == 4:
        return s * s * s
    return 0.0


@njit(inline="always", **WITHIN)
def _hidden_kinks(th, i):
    """Whether R bends where u = 0."""
    o = _HM + i * _NH
    return th[o + 3] != 0.0


@njit(**WITHIN)
def _dimensions(th):
    """Length of the state; how many hidden oscillators, memories, and each memory."""
    nh = 0
    for i in range(MAX_HIDDEN):
        if th[_HM + i * _NH + 1] > 0.0:
            nh = i + 1
    n0 = 0
    for j in range(2):
        if th[_RK + j * 2 + 1] > 0.0:
            n0 = j + 1
    n1 = 1 if th[_FB] > 0.0 else 0
    many = n0 + n1
    return 2 + 2 * nh + many, nh, many, n0, n1


@njit(inline="always", **WITHIN)
def _memory_rates(th, y, k, stage, dims, x, v, d, side, t):
    """Rates of all memories into k."""
    at = 2 + 2 * dims[1]
    for j in range(dims[3]):
        o = _RK + j * 2
        z = y[at, 0]
        k[stage, at, 0] = th[o] * v - z / th[o + 1]
        at += 1
    if dims[4] > 0:
        z = y[at, 0]
        k[stage, at, 0] = th[_KB] * v * (-d * z / th[_FB] + 1.0)
        at += 1


@njit(inline="always", **WITHIN)
def _memory_column(th, slot, y, k, stage, c, dims, x, v, d, side, t, dx, dv):
    """Rates of the memories' sensitivities by column c."""
    at = 2 + 2 * dims[1]
    for j in range(dims[3]):
        o = _RK + j * 2
        z = y[at, 0]
        rate = dv * th[o] + -y[at, c] / th[o + 1]
        if slot == o:
            rate += v
        elif slot == o + 1:
            rate += z / (th[o + 1] * th[o + 1])
        k[stage, at, c] = rate
        at += 1
    if dims[4] > 0:
        z = y[at, 0]
        rate = dv * th[_KB] * (-d * z / th[_FB] + 1.0) + -d * th[_KB] * v * y[at, c] / th[_FB]
        if slot == _KB:
            rate += v * (-d * z / th[_FB] + 1.0)
        elif slot == _FB:
            rate += d * th[_KB] * z * v / (th[_FB] * th[_FB])
        k[stage, at, c] = rate
        at += 1
