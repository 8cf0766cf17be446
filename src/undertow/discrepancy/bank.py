"""Columns by which a residual force is told static from memory: a bank of laws without names.

Belongs here: functions of (x, v), and responses to the motion, along one trial. Does not belong here: what is learned
with them (shares.py), laws with names (equation/).
"""

from __future__ import annotations

import cmath
import math

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from undertow.discrepancy.residual import EvenMotion
from undertow.equation.hidden import Hysteresis, even_step
from undertow.equation.term import Array

DEGREE = 5
"""Highest total power of x and v: stiffness up to x^5, damping up to v^5."""

SLOW_SPEEDS = (0.03, 0.1)
"""Speeds, relative to the fastest, below which friction may be larger (Stribeck)."""

YIELDS = (0.05, 0.15, 0.5)
"""Yield displacements of the elements that yield, relative to the largest release."""

RELAXATIONS = (1.0, 3.0)
"""Times of the relaxations, in radians of the slowest body."""

LOWEST, HIGHEST = 0.4, 2.5
"""Span of the bank's frequencies, relative to the slowest and the fastest body: beyond it a hidden oscillator follows
the motion as a mass or as a spring."""


def static_columns(even: EvenMotion, size: float, speed: float) -> Array:
    """Functions of (x, v) along one trial, (n, p): powers up to the fifth, dry friction's laws, their products.

    ``size`` (m) and ``speed`` (m/s) are the group's largest; columns are of order one.
    """
    x, v = even.x / size, even.v / speed
    side, sx = np.sign(v), np.sign(x)
    columns = [x**i * v**j for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i) if i + j > 0]
    columns += [side, side * np.abs(x), side * x, side * x**2, np.abs(v), v * np.abs(v), side * np.abs(v) ** 0.5]
    columns += [sx * x**2, sx * v**2, np.abs(x) * v, np.abs(v) * x, x * v * np.abs(v)]
    columns += [side * np.exp(-np.abs(v) / slow) for slow in SLOW_SPEEDS]
    return np.column_stack(columns)


def bank_frequencies(slowest: float, fastest: float, span_s: float) -> Array:
    """Frequencies of the hidden linear states, rad/s: one a line width of the window (2 pi / span).

    >>> bank_frequencies(5.0, 5.0, 2.0 * math.pi).tolist()
    [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0]
    """
    step = 2.0 * math.pi / span_s
    count = math.ceil((HIGHEST * fastest - LOWEST * slowest) / step - 1e-6) + 1
    return np.asarray(LOWEST * slowest + step * np.arange(count), dtype=np.float64)


def memory_columns(even: EvenMotion, size: float, slowest: float, frequencies: Array, span_s: float) -> Array:
    """Responses of hidden states to the motion of one trial, from rest at its release, (n, p).

    Each frequency brings displacement and velocity of an oscillator that forgets within the window, driven by the
    measured acceleration: together they span every linear memory of that band. Then relaxations, driven by the
    velocity, and elements that yield.
    """
    step = even_step(even.t, f"trial {even.name}")
    columns = []
    for w in frequencies:
        ringing = w * _response(complex(-1.0 / span_s, w), even.a, step)
        columns += [ringing.real, ringing.imag]
    for radians in RELAXATIONS:
        columns.append(slowest * _response(complex(-slowest / radians), even.v, step).real)
    stride = max(1, int(2.0 * math.pi / float(np.max(frequencies)) / 60.0 / step))
    coarse = slice(None, None, stride)
    for share in YIELDS:
        term = Hysteresis(share * size)
        force = term.force(even.x[coarse], even.v[coarse], even.a[coarse], even.t[coarse])
        columns.append(np.interp(even.t, even.t[coarse], force))
    return np.column_stack(columns)


def _response(pole: complex, drive: Array, step: float) -> NDArray[np.complex128]:
    """z (n,) with z' = pole z + drive, at rest at the first sample; exact for a drive straight between samples."""
    turn = cmath.exp(pole * step)
    new = (turn - 1.0 - pole * step) / (pole**2 * step)
    old = (turn - 1.0) / pole - new
    z, _ = lfilter([new, old], [1.0, -turn], drive.astype(np.complex128), zi=np.array([-new * drive[0]]))
    return np.asarray(z, dtype=np.complex128)


def clock_pair(t: Array, frequency: float) -> Array:
    """Cosine and sine of a steady oscillation, (n, 2), at ``t`` (n,) s and ``frequency`` rad/s.

    >>> clock_pair(np.zeros(1), 3.0).tolist()
    [[1.0, 0.0]]
    """
    return np.column_stack([np.cos(frequency * t), np.sin(frequency * t)])
