"""The compiled integrator of a body with a measured input: steps and events over the laws of driven_forces.py.

Steps and the search for events are those of the decays' integrator (kernel.py: `_stepping`, `_watching`), here over
another right-hand side. Steps end at samples, at knots of the input, and at events: reversal, stick and slip, the
passage of the rest position, of z = 0 and of a velocity through water of 0. Nothing here knows a period or a spring.

Compiled only where a driven trial is. numba's cache sees changes of its own file alone, so that a mark of the other
files' text is part of what is compiled. Does not belong here: forces (driven_forces.py), holds (input.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from undertow.compiling import OPTIONS, WITHIN, compiled, mark_of
from undertow.equation import algebra, driven_forces, driven_memory, driven_slots, kernel
from undertow.equation.algebra import _CP, _FS, _GE, _P, _XE, MAX_HIDDEN, _dimensions, _rubs
from undertow.equation.driven_forces import (
    _BN,
    _BZ,
    _KIND,
    _TAU,
    _WQ,
    _begin,
    _input,
    _push_before,
    _slope,
    _states,
)  # fmt: skip
from undertow.equation.driven_memory import _memory_step, _share_sliders, _slider_slips, _sliders_turn
from undertow.equation.driven_slots import DRIVEN_SLOT as DRIVEN_SLOT
from undertow.equation.driven_slots import IWAN, LUGRE, PINCHED, SLIDERS
from undertow.equation.driven_slots import N_DRIVEN as N_DRIVEN
from undertow.equation.kernel import (
    _INSTANT,
    _NONE,
    _SLIP,
    _excess,
    _int,
    _jump,
    _short_near_reversal,
    _stepping,
    _watched,
    _watching,
    whole_lanes,
)
from undertow.equation.term import Array

_BENT_SHARE = 0.5
_BENT_FINEST = 64.0
"""Near z = 0 a step changes z by half of it, the finest by 1/64 of a full step's change: |z|^n has a kink."""

_driven_step = _stepping(_slope)
_driven_event = _watching(_driven_step, _push_before)


# ---------------------------------------------------------------- before the first step
@njit(**WITHIN)
def _events_watched(th, active, dims, iz, ir, watch):
    """How many states have zeros that are events, into ``watch``."""
    many = _watched(th, active, dims, watch)
    if iz > 0:
        known = False
        for i in range(many):
            known = known or watch[i] == 1
        if not known:
            watch[many] = 1
            many += 1
    if iz > 0 and th[_KIND] != LUGRE:
        watch[many] = iz
        many += 1
    drags = th[_WQ] != 0.0
    for slot in active:
        drags = drags or slot == _WQ
    if ir > 0 and drags:
        watch[many] = ir
        many += 1
    return many


@njit(**WITHIN)
def _flags(th, active, iz, broken):
    """Whether the body rubs, whether steps shrink near a reversal and near z = 0, whether a knot changes the slope."""
    rubs = _rubs(th)
    sharp = th[_FS] != 0.0 or (th[_CP] != 0.0 and th[_P] < kernel._SHARP_EXPONENT)
    bends = iz > 0 and th[_KIND] <= PINCHED
    bent = bends and th[_BN] != 1.0 and th[_BN] != 2.0
    turning = broken
    for slot in active:
        turning = turning or slot == _TAU
        bent = bent or (bends and slot == _BN)
    return rubs, sharp, bent, turning


@njit(**WITHIN)
def _mode(th, active, y, dims, t, iz, ir, at, knots, pieces, sens, rubs):
    """Direction of motion, sides of the rest position, of z and of r where the motion begins."""
    side = 1.0 if y[0, 0] > th[_XE] or (y[0, 0] == th[_XE] and y[1, 0] > 0.0) else -1.0
    rside = 1.0 if ir == 0 or y[ir, 0] >= 0.0 else -1.0
    d = 1.0 if y[1, 0] > 0.0 else -1.0
    if y[1, 0] == 0.0:
        world = (at[0], at[1], knots, pieces, iz, ir, 1.0, rside)
        _push_before(th, active, y, dims, t, 0.0, world, sens)
        excess, way = _excess(th, y, dims, t, side, sens[0])
        d = way if excess > 0.0 or not rubs else 0.0
    zside = 1.0 if th[_BZ] >= 0.0 else -1.0
    if iz > 0 and th[_BZ] == 0.0:
        zside = d if d != 0.0 else 1.0
    if iz > 0 and th[_KIND] == IWAN:
        zside = _sliders_turn(th, y, iz, d)
    return d, side, zside, rside


@njit(inline="always", **WITHIN)
def _through_side(y, k, ir, before):
    """Side of zero of the velocity through water, or the one it goes to: in still water it vanishes at every reversal,
    where one event hides the other. The drag itself is zero there, so that no slope changes."""
    if ir == 0 or (y[ir, 0] == 0.0 and k[0, ir, 0] == 0.0):
        return before
    if y[ir, 0] == 0.0:
        return 1.0 if k[0, ir, 0] > 0.0 else -1.0
    return 1.0 if y[ir, 0] > 0.0 else -1.0


# ---------------------------------------------------------------- one step
@njit(inline="always", **WITHIN)
def _step_length(th, y, k, iz, whole, h_max, sharp, bent):
    """Length of the next step: the way to the next stop in equal parts, shorter where a law changes sharply."""
    parts = math.ceil(whole / h_max * (1.0 - 1e-9))
    h = whole / parts if parts > 1 else whole
    if sharp:
        h = min(h, _short_near_reversal(th, abs(y[1, 0]), abs(k[0, 1, 0]), h))
    if bent:
        full = abs(k[0, iz, 0]) * h
        change = min(full, _BENT_SHARE * abs(y[iz, 0]) + full / _BENT_FINEST)
        h = h if change >= full else change / abs(k[0, iz, 0])
    if iz > 0:
        h = _memory_step(th, y, k, iz, h)
    return h


@njit(**WITHIN)
def _after_event(th, active, y, k, cols, dims, t, d, side, world, sens, jac, event, rubs):
    """Direction of motion and sides after an event, with the slope and the sensitivities' jump there."""
    zero = _int(0)
    piece, begin, knots, pieces, iz, ir, zside, rside = world
    if event >= 0:
        y[event, 0] = th[_XE] if event == 0 else 0.0
    if event == 0:
        side = 1.0 if y[1, 0] > 0.0 else -1.0
    elif iz > 0 and event == iz and th[_KIND] == IWAN:
        zside = _slider_slips(th, active, y, cols, iz, d, zside)
    elif iz > 0 and event == iz:
        zside = 1.0 if k[0, iz, 0] > 0.0 else -1.0
    elif ir > 0 and event == ir:
        rside = 1.0 if k[0, ir, 0] > 0.0 else -1.0
    world = (piece, begin, knots, pieces, iz, ir, zside, rside)
    if event == 1 or event == _SLIP:
        _push_before(th, active, y, dims, t, 0.0, world, sens)
        excess, way = _excess(th, y, dims, t, side, sens[0])
        d = way if event == _SLIP or excess > 0.0 or not rubs else 0.0
        if iz > 0 and th[_KIND] == IWAN:
            zside = _sliders_turn(th, y, iz, d)
            world = (piece, begin, knots, pieces, iz, ir, zside, rside)
    _slope(th, active, y, k, zero, cols, dims, t, 0.0, d, side, world, sens, jac)
    if event == 1:
        _jump(y, k, cols, dims, event)
        _slope(th, active, y, k, zero, cols, dims, t, 0.0, d, side, world, sens, jac)
    return d, side, zside, rside


@njit(**WITHIN)
def _cross_knot(th, active, y, k, cols, dims, t, d, side, world, sens, jac):
    """Direction of motion after a knot at which the input, or its slope, jumps, with the new slope there.

    A delay moves the knot itself, so that its sensitivity jumps with the slope of the state (dt*/d(delay) = 1).
    """
    zero = _int(0)
    for c in range(cols):
        for i in range(dims[0]):
            k[6, i, c] = k[0, i, c]
    if d == 0.0:
        _push_before(th, active, y, dims, t, 0.0, world, sens)
        excess, way = _excess(th, y, dims, t, side, sens[0])
        d = way if excess > 0.0 else 0.0
    _slope(th, active, y, k, zero, cols, dims, t, 0.0, d, side, world, sens, jac)
    for c in range(1, cols):
        if active[c - 1] == _TAU:
            for i in range(dims[0]):
                y[i, c] += k[6, i, 0] - k[0, i, 0]
    _slope(th, active, y, k, zero, cols, dims, t, 0.0, d, side, world, sens, jac)
    return d


@njit(inline="always", **WITHIN)
def _write(y, k, cols, n, d, row, ox, ov, oa, os):
    """The state at a sample into its row."""
    for c in range(cols):
        ox[row, c] = y[0, c]
        ov[row, c] = y[1, c] if d != 0.0 else 0.0
        oa[row, c] = k[0, 1, c]
    for i in range(2, n):
        os[row, i - 2] = y[i, 0]


# ---------------------------------------------------------------- the whole motion
@njit(**WITHIN)
def _travel(th, active, knots, pieces, times, h_max, bound, state, rows, dims, places, flags, watch):
    """All steps from times[0] to the last sample; their number, negative where the motion left the bound."""
    y, out, k, jac, sens = state
    ox, ov, oa, os = rows
    iz, ir = places
    rubs, sharp, bent, turning = flags
    n, m, cols, zero = dims[0], times.size, sens.size, _int(0)
    t, piece = times[0], _int(0)
    while piece < knots.size - 2 and knots[piece + 1] + th[_TAU] <= t:
        piece += 1
    at = (piece, knots[piece] + th[_TAU])
    rate, _ = _input(knots, pieces, piece, (t - at[1]) / (knots[piece + 1] - knots[piece]))
    _begin(th, active, y, cols, dims, iz, ir, rate)
    d, side, zside, rside = _mode(th, active, y, dims, t, iz, ir, at, knots, pieces, sens, rubs)
    world = (at[0], at[1], knots, pieces, iz, ir, zside, rside)
    _slope(th, active, y, k, zero, cols, dims, t, 0.0, d, side, world, sens, jac)
    rside = _through_side(y, k, ir, rside)
    world = (at[0], at[1], knots, pieces, iz, ir, zside, rside)
    row, steps = _int(0), 0
    most = 64 * (m + knots.size) + 64 * int((times[m - 1] - times[0]) / h_max)
    while True:
        while row < m and times[row] <= t + h_max * _INSTANT:
            _write(y, k, cols, n, d, row, ox, ov, oa, os)
            row += 1
        if row >= m:
            return steps
        end = times[row]
        on_knot = piece < knots.size - 2 and knots[piece + 1] + th[_TAU] <= end + h_max * _INSTANT
        if on_knot:
            end = knots[piece + 1] + th[_TAU]
        whole, event = end - t, _NONE
        h = _step_length(th, y, k, iz, whole, h_max, sharp, bent)
        ends = h >= whole * (1.0 - 1e-12)
        if h > h_max * _INSTANT:
            _driven_step(th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac)
            event, length = _driven_event(th, active, y, out, k, cols, dims, t, h, d, side, world, sens, jac, watch)
            ends = ends and length == h
            t = end if ends else t + length
            for c in range(cols):
                for i in range(n):
                    y[i, c] = out[i, c]
                    k[0, i, c] = k[6, i, c]
        else:
            t = end
        steps += 1
        if event != _NONE:
            d, side, zside, rside = _after_event(
                th, active, y, k, cols, dims, t, d, side, world, sens, jac, event, rubs
            )  # fmt: skip
        if on_knot and ends:
            piece += 1
        rside = _through_side(y, k, ir, rside)
        world = (piece, knots[piece] + th[_TAU], knots, pieces, iz, ir, zside, rside)
        if on_knot and ends and turning:
            stuck = d == 0.0
            d = _cross_knot(th, active, y, k, cols, dims, t, d, side, world, sens, jac)
            if stuck and iz > 0 and th[_KIND] == IWAN:
                zside = _sliders_turn(th, y, iz, d)
                world = (piece, knots[piece] + th[_TAU], knots, pieces, iz, ir, zside, rside)
        if not (abs(y[0, 0]) < bound) or steps > most:
            return -steps


def _with_mark(mark: int) -> Any:
    """The compiled integrator; ``mark`` stands for the other files' text, so that their changes are compiled anew."""

    @compiled(
        "Tuple((f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], i8))"
        "(f8[::1], i8[::1], f8[::1], f8[:,::1], b1, f8[::1], f8, f8)",
        **OPTIONS,
    )
    def drive(th, active, knots, pieces, broken, times, h_max, bound):
        """Motion from times[0] with the parameter vector ``th`` (slots as in DRIVEN_SLOTS), at rising ``times`` (m,) s.

        The input is sum_p pieces[i, p] r^p on piece i, r from 0 to 1 between knots[i] and knots[i + 1] (s);
        ``broken`` says that it jumps there. ``active`` (p,) are the slots whose sensitivities are wanted, ``h_max``
        the largest step in s, ``bound`` a displacement that no sound motion reaches. Gives x, v, a each (m, 1 + p):
        column 0 the motion, column 1 + j its derivative by slot active[j]; hidden states (m, q); and the number of
        steps, negative where the motion left the bound.
        """
        if mark < 0:
            raise ValueError("a mark is not negative")
        longer = np.zeros(N_DRIVEN + 4 * SLIDERS)
        longer[:N_DRIVEN] = th
        th = longer
        th[_GE] = 1.0
        if th[_KIND] == IWAN:
            _share_sliders(th)
        m = times.size
        cols = 1 + active.size
        own = _dimensions(th)
        n, iz, ir = _states(th, active, own[0])
        dims = (n, *own[1:])
        rows = (np.zeros((m, cols)), np.zeros((m, cols)), np.zeros((m, cols)), np.zeros((m, n - 2)))
        width = whole_lanes(cols)
        state = (
            np.zeros((n, width)), np.zeros((n, width)), np.zeros((7, n, width)),
            np.zeros(2 * MAX_HIDDEN), np.zeros(cols),
        )  # fmt: skip
        watch = np.empty(5 + MAX_HIDDEN, np.int64)
        watch = watch[: _events_watched(th, active, dims, iz, ir, watch)]
        flags = _flags(th, active, iz, broken)
        steps = _travel(
            th, active, knots, pieces, times, h_max, bound, state, rows, dims, (iz, ir), flags, watch
        )  # fmt: skip
        return rows[0], rows[1], rows[2], rows[3], steps

    return drive


drive: Callable[
    [Array, NDArray[np.int64], Array, Array, bool, Array, float, float], tuple[Array, Array, Array, Array, int]
]
drive = _with_mark(mark_of(algebra, kernel, driven_slots, driven_memory, driven_forces))
