"""Forces and rates of the hysteresis of a driven body, compiled: one member of the family at a time.

With z the force that is remembered (N), v the velocity, d its direction, and h = 1 but where it is pinched,

    Bouc and Wen   F = z,  z' = h(z) v (alpha - (loop d z + skew |z|) (|z| / unit)^(n-1)),  h = 1 - P exp(-(z / W)^2)
    LuGre          F = z + sigma1 q,  z' = sigma0 q,  q = v (1 - d z / g(v)),  g = F_c + F_s exp(-(v / v_s)^2)
    Iwan           F = sum_i s_i,  s_i' = k_i v while |s_i| < f_i or the body turns back, else s_i' = 0

A slider of Iwan's slips at an event: the state at ``iz`` is how far the body still is from the next slip (m, negative
in the direction of motion), the sliders stand behind it. They slip in their own order, those with short ways first, so
that ``zside`` is how many slip. Rows and sources: driven_hysteresis.py. Does not belong here: other laws
(driven_forces.py), steps (driven_kernel.py).
"""

from __future__ import annotations

import math

from numba import njit

from undertow.compiling import WITHIN
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN, SLIDERS
from undertow.equation.driven_slots import IWAN as _IWAN
from undertow.equation.driven_slots import LUGRE as _LUGRE
from undertow.equation.driven_slots import PINCHED as _PINCHED

_KIND, _BA, _BG, _BD, _BN, _BU, _BZ, _PP, _PW, _LC, _LR, _LV, _LM, _IF, _IX = (
    DRIVEN_SLOT[name] for name in (
        "memory", "bw_a", "bw_g", "bw_d", "bw_n", "bw_unit", "bw_z0",
        "pinch", "pinch_w", "lg_c", "lg_r", "lg_v", "lg_m", "iw_f", "iw_x",
    )
)  # fmt: skip
_N = SLIDERS
_SHARE_K, _SHARE_F, _BY_K, _BY_F = (N_DRIVEN + i * SLIDERS for i in range(4))
"""Behind the slots: each slider's share of stiffness and of force, and their derivatives by chi."""

_BRISTLE_SHARE, _BRISTLE_STABLE = 0.5, 2.5
"""A step of LuGre's law moves the body by the first share of the way over which its bristles bend, g / sigma0, where
they begin to; by more where they have nearly their steady bend (the error of a step goes with its sixth power times
what is left of the way), up to the second, beyond which the integrator is not stable."""
_STRIBECK_SHARE, _PINCH_SHARE = 0.5, 0.3
"""Inside `_PEAK_REACH` v_s a step changes v by this share of v_s; inside as many W, a pinched z by this share of W."""
_PEAK_REACH = 3.0
_SLIPS = 1.0 - 1e-9
"""A slider slips from this share of its force on: what rounding leaves of an instant at which several slip."""
_NEVER = 1e30
"""Distance to the next slip where every slider slips already, m."""


# ---------------------------------------------------------------- Bouc and Wen, pinched or not
@njit(inline="always", **WITHIN)
def _pinching(th, z):
    """h(z), its slope, and exp(-(z / W)^2)."""
    if th[_KIND] != _PINCHED:
        return 1.0, 0.0, 0.0
    r = z / th[_PW]
    e = math.exp(-r * r)
    return 1.0 - th[_PP] * e, 2.0 * th[_PP] * e * r / th[_PW], e


@njit(**WITHIN)
def _bouc_wen_rates(th, active, y, k, stage, cols, d, zside, iz):
    """Rate of z and of its sensitivities; |v| and |z| continued smoothly in the directions d and zside."""
    v = y[1, 0] if d != 0.0 else 0.0
    z = y[iz, 0]
    n = th[_BN]
    size = z * zside
    p = 1.0
    if n != 1.0:
        p = (abs(z) / th[_BU]) ** (n - 1.0)
    loop = -th[_BG] * d * z - th[_BD] * size
    h, by_h, e = _pinching(th, z)
    plain = th[_BA] + p * loop
    k[stage, iz, 0] = h * v * plain
    by_z = v * (h * n * p * (-th[_BG] * d - th[_BD] * zside) + by_h * plain)
    for c in range(1, cols):
        slot = active[c - 1]
        dv = y[1, c] if d != 0.0 else 0.0
        rate = dv * h * plain + by_z * y[iz, c]
        if slot == _BA:
            rate += h * v
        elif slot == _BG:
            rate -= h * v * p * d * z
        elif slot == _BD:
            rate -= h * v * p * size
        elif slot == _BN and z != 0.0:
            rate += h * v * p * loop * math.log(abs(z) / th[_BU])
        elif slot == _BU and n != 1.0:
            rate -= h * v * p * loop * (n - 1.0) / th[_BU]
        elif slot == _PP:
            rate -= v * e * plain
        elif slot == _PW:
            rate -= v * plain * 2.0 * th[_PP] * e * z * z / th[_PW] ** 3
        k[stage, iz, c] = rate


# ---------------------------------------------------------------- LuGre
@njit(inline="always", **WITHIN)
def _bristle(th, v, z, d):
    """q = v (1 - d z / g), its derivatives by v, z and g, and those of g by F_s and v_s."""
    r = v / th[_LV]
    e = math.exp(-r * r)
    g = th[_LC] + th[_LR] * e
    by_g = d * v * z / (g * g)
    free = 1.0 - d * z / g
    by_v = free - by_g * 2.0 * r / th[_LV] * th[_LR] * e
    return v * free, by_v, -d * v / g, by_g, e, 2.0 * r * r / th[_LV] * th[_LR] * e


@njit(inline="always", **WITHIN)
def _explicit_bristle(slot, by_g, e, by_vs):
    """dq / d(slot) at fixed state."""
    if slot == _LC:
        return by_g
    if slot == _LR:
        return by_g * e
    if slot == _LV:
        return by_g * by_vs
    return 0.0


@njit(**WITHIN)
def _bristle_rates(th, active, y, k, stage, cols, d, iz):
    """Rate of LuGre's z and of its sensitivities."""
    v = y[1, 0] if d != 0.0 else 0.0
    q, by_v, by_z, by_g, e, by_vs = _bristle(th, v, y[iz, 0], d)
    k[stage, iz, 0] = th[_BA] * q
    for c in range(1, cols):
        slot = active[c - 1]
        dv = y[1, c] if d != 0.0 else 0.0
        rate = th[_BA] * (by_v * dv + by_z * y[iz, c] + _explicit_bristle(slot, by_g, e, by_vs))
        if slot == _BA:
            rate += q
        k[stage, iz, c] = rate


@njit(**WITHIN)
def _bristle_force(th, active, y, cols, d, iz, sens):
    """LuGre's force and its derivatives, added to sens."""
    v = y[1, 0] if d != 0.0 else 0.0
    q, by_v, by_z, by_g, e, by_vs = _bristle(th, v, y[iz, 0], d)
    sens[0] += y[iz, 0] + th[_LM] * q
    for c in range(1, cols):
        slot = active[c - 1]
        dv = y[1, c] if d != 0.0 else 0.0
        s = y[iz, c] + th[_LM] * (by_v * dv + by_z * y[iz, c] + _explicit_bristle(slot, by_g, e, by_vs))
        if slot == _LM:
            s += q
        sens[c] += s


# ---------------------------------------------------------------- Iwan
@njit(**WITHIN)
def _share_sliders(th):
    """Shares of stiffness and force of all sliders, and their derivatives by chi, behind the slots."""
    for power in range(2):
        exponent = th[_IX] + 1.0 + power
        share = _SHARE_K if power == 0 else _SHARE_F
        by = _BY_K if power == 0 else _BY_F
        below = 0.0
        slope_below = 0.0
        for i in range(_N):
            r = (i + 1.0) / _N
            above = r**exponent
            slope_above = above * math.log(r)
            th[share + i] = above - below
            th[by + i] = slope_above - slope_below
            below = above
            slope_below = slope_above


@njit(**WITHIN)
def _sliders_begin(th, active, y, cols, iz):
    """Sliders that a body drawn by z0 / K from a virgin state would have, and their sensitivities."""
    drawn = th[_BZ]
    way = 1.0 if drawn >= 0.0 else -1.0
    for i in range(_N):
        pulled = th[_SHARE_K + i] * drawn
        held = th[_SHARE_F + i] * th[_IF]
        slips = abs(pulled) >= held
        y[iz + 1 + i, 0] = way * held if slips else pulled
        for c in range(1, cols):
            slot = active[c - 1]
            if slips:
                y[iz + 1 + i, c] = way * _held_by(th, slot, i)
            elif slot == _BZ:
                y[iz + 1 + i, c] = th[_SHARE_K + i]
            elif slot == _IX:
                y[iz + 1 + i, c] = th[_BY_K + i] * drawn


@njit(inline="always", **WITHIN)
def _held_by(th, slot, i):
    """Derivative of the force at which slider i slips."""
    if slot == _IF:
        return th[_SHARE_F + i]
    if slot == _IX:
        return th[_BY_F + i] * th[_IF]
    return 0.0


@njit(**WITHIN)
def _sliders_turn(th, y, iz, d):
    """How many sliders slip where the body sets out in the direction d; the way to the next slip into the state."""
    many = 0
    if d != 0.0:
        while many < _N and y[iz + 1 + many, 0] * d >= th[_SHARE_F + many] * th[_IF] * _SLIPS:
            many += 1
    _next_slip(th, y, iz, d, many)
    return float(many)


@njit(**WITHIN)
def _next_slip(th, y, iz, d, many):
    """Distance to the next slip, negative in the direction of motion, into the state."""
    y[iz, 0] = -_NEVER if d >= 0.0 else _NEVER
    if many < _N and d != 0.0 and th[_BA] > 0.0:
        room = th[_SHARE_F + many] * th[_IF] - d * y[iz + 1 + many, 0]
        y[iz, 0] = -d * room / (th[_SHARE_K + many] * th[_BA])


@njit(**WITHIN)
def _slider_slips(th, active, y, cols, iz, d, zside):
    """The next slider begins to slip, and with it those that reach their force at the same instant, as where a small
    loop closes: they have their forces from here on. Gives how many slip."""
    i = int(zside)
    first = i
    while i < _N and (i == first or y[iz + 1 + i, 0] * d >= th[_SHARE_F + i] * th[_IF] * _SLIPS):
        y[iz + 1 + i, 0] = d * th[_SHARE_F + i] * th[_IF]
        for c in range(1, cols):
            y[iz + 1 + i, c] = d * _held_by(th, active[c - 1], i)
        i += 1
    _next_slip(th, y, iz, d, i)
    return float(i)


@njit(**WITHIN)
def _slider_rates(th, active, y, k, stage, cols, d, zside, iz):
    """Rates of the sliders that stick and of their sensitivities; of the distance to the next slip."""
    v = y[1, 0] if d != 0.0 else 0.0
    slipping = int(zside)
    k[stage, iz, 0] = v
    for c in range(1, cols):
        k[stage, iz, c] = 0.0
    for i in range(_N):
        at = iz + 1 + i
        sticks = 0.0 if i < slipping else 1.0
        stiffness = sticks * th[_SHARE_K + i] * th[_BA]
        k[stage, at, 0] = stiffness * v
        for c in range(1, cols):
            slot = active[c - 1]
            rate = stiffness * y[1, c] if d != 0.0 else 0.0
            if slot == _BA:
                rate += sticks * th[_SHARE_K + i] * v
            elif slot == _IX:
                rate += sticks * th[_BY_K + i] * th[_BA] * v
            k[stage, at, c] = rate


# ---------------------------------------------------------------- whichever it is
@njit(**WITHIN)
def _memory_force(th, active, y, cols, d, iz, sens):
    """The hysteresis' force and its derivatives, added to sens."""
    if th[_KIND] == _LUGRE:
        _bristle_force(th, active, y, cols, d, iz, sens)
        return
    first = iz
    last = iz + 1
    if th[_KIND] == _IWAN:
        first = iz + 1
        last = first + _N
    for c in range(cols):
        for i in range(first, last):
            sens[c] += y[i, c]


@njit(**WITHIN)
def _memory_slope(th, active, y, k, stage, cols, d, zside, iz):
    """Rates of the hysteresis' states and of their sensitivities."""
    if th[_KIND] == _LUGRE:
        _bristle_rates(th, active, y, k, stage, cols, d, iz)
    elif th[_KIND] == _IWAN:
        _slider_rates(th, active, y, k, stage, cols, d, zside, iz)
    else:
        _bouc_wen_rates(th, active, y, k, stage, cols, d, zside, iz)


@njit(**WITHIN)
def _memory_step(th, y, k, iz, h):
    """Length of a step that follows LuGre's bristles, or the pinching of a loop."""
    if th[_KIND] == _LUGRE:
        speed = abs(y[1, 0])
        slope = abs(k[0, 1, 0])
        r = speed / th[_LV]
        g = th[_LC] + th[_LR] * math.exp(-r * r)
        left = abs(1.0 - abs(y[iz, 0]) / g) if y[1, 0] * y[iz, 0] > 0.0 else 1.0
        share = _BRISTLE_SHARE * (left + 1e-5) ** (-1.0 / 6.0)
        reach = min(share, _BRISTLE_STABLE) * g / th[_BA]
        h = min(h, 2.0 * reach / (speed + math.sqrt(speed * speed + 2.0 * slope * reach)))
        change = _STRIBECK_SHARE * th[_LV] + max(speed - _PEAK_REACH * th[_LV], 0.0)
        if th[_LR] != 0.0 and change < slope * h:
            h = change / slope
    elif th[_KIND] == _PINCHED:
        slope = abs(k[0, iz, 0])
        change = _PINCH_SHARE * th[_PW] + max(abs(y[iz, 0]) - _PEAK_REACH * th[_PW], 0.0)
        if change < slope * h:
            h = change / slope
    return h
