"""Method 1 as the report describes it, in plain Python: RK4 at 1 ms with sign(), Nelder-Mead, displacement RMS.

The measure of speed for, and the check on, the compiled Method 1: it imports nothing of undertow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

STEP_S = 0.001


def sign(value: float) -> float:
    """-1, 0 or 1."""
    return (value > 0.0) - (value < 0.0)


def simulate(
    mass: float, c: float, k: float, friction: float, drag: float, x0: float, steps: int
) -> list[float]:
    """Displacement of M x'' + c x' + k x + F sign(x') + q x'|x'| = 0 from rest at x0, one value a millisecond."""

    def acceleration(x: float, v: float) -> float:
        return -(c * v + k * x + friction * sign(v) + drag * v * abs(v)) / mass

    h = STEP_S
    x, v = x0, 0.0
    out = [x]
    for _ in range(steps):
        a1 = acceleration(x, v)
        a2 = acceleration(x + 0.5 * h * v, v + 0.5 * h * a1)
        v2 = v + 0.5 * h * a1
        a3 = acceleration(x + 0.5 * h * v2, v + 0.5 * h * a2)
        v3 = v + 0.5 * h * a2
        a4 = acceleration(x + h * v3, v + h * a3)
        x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v + h * a3)
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        out.append(x)
    return out


def identify(
    t: Sequence[float], x: Sequence[float], x0: float, mass: float, k: float, c: float,
    friction: float, drag_unit: float,
    starts: Sequence[tuple[float, float]] = ((0.2, 5.0),),
) -> tuple[float, float, float]:
    """(m_a, C_d, displacement RMS) for one trial; t (s after release), x (m from rest); m_a held at or above 0."""
    steps = math.ceil(t[-1] / STEP_S)
    grid = np.arange(steps + 1) * STEP_S
    data = np.asarray(x)

    def rms(p: np.ndarray) -> float:
        path = simulate(mass * (1.0 + max(float(p[0]), 0.0)), c, k, friction, drag_unit * float(p[1]), x0, steps)
        error = np.interp(t, grid, path) - data
        return float(np.sqrt(np.mean(error**2)))

    ends = [
        minimize(rms, np.array(start), method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-9, "maxiter": 400})
        for start in starts
    ]
    best = min(ends, key=lambda end: float(end.fun))
    return max(float(best.x[0]) * mass, 0.0), float(best.x[1]), float(best.fun)
