"""How others would fit (m_a, C_d) to the same samples: DOP853 with events, solve_ivp as one writes it, lmfit.

Nothing of undertow is used here. Belongs here: each rival's fit. Does not belong here: clocks.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from benchmarks.decay import START, Record

Simulator = Callable[[Record, float, float], np.ndarray]
EXPERT_RTOL = 1e-8
SEARCH = {"xatol": 1e-5, "fatol": 1e-9, "maxiter": 400}
"""Nelder-Mead's tolerances, those of Method 1 in plain Python."""


def dop853_with_events(data: Record, mass: float, drag: float) -> np.ndarray:
    """Displacement at the samples, integrated from reversal to reversal: what an expert writes."""
    out = np.empty(data.t.size)
    t, x, end = 0.0, data.x0, float(data.t[-1])
    while True:
        here = data.t >= t
        if t >= end or abs(data.k * x) <= data.friction:
            out[here] = x
            return out
        d = -np.sign(x)

        def slope(_: float, y: np.ndarray, d: float = d) -> tuple[float, float]:
            v = y[1]
            return v, -(data.c * v + data.k * y[0] + d * data.friction + d * drag * v * v) / mass

        def turn(_: float, y: np.ndarray) -> float:
            return float(y[1])

        turn.terminal, turn.direction = True, -d  # type: ignore[attr-defined]
        leg = solve_ivp(
            slope, (t, end), (x, 0.0), "DOP853", events=turn, rtol=EXPERT_RTOL, atol=1e-10, dense_output=True
        )
        stop = float(leg.t[-1])
        inside = here & (data.t <= stop)
        out[inside] = leg.sol(data.t[inside])[0]
        t, x = stop, float(leg.y[0, -1])


def as_one_writes_it(data: Record, mass: float, drag: float) -> np.ndarray:
    """Displacement at the samples from solve_ivp with its defaults and sign() in the right-hand side."""

    def slope(_: float, y: np.ndarray) -> tuple[float, float]:
        x, v = y
        return v, -(data.c * v + data.k * x + data.friction * np.sign(v) + drag * v * abs(v)) / mass

    run = solve_ivp(slope, (0.0, float(data.t[-1])), (data.x0, 0.0), t_eval=data.t)
    return np.asarray(run.y[0])


def nelder_mead(data: Record, simulate: Simulator) -> tuple[float, float]:
    """(m_a in kg, C_d) of least displacement RMS."""

    def rms(p: np.ndarray) -> float:
        path = simulate(data, data.mass * (1.0 + max(float(p[0]), 0.0)), data.drag_unit * float(p[1]))
        return float(np.sqrt(np.mean((path - data.x) ** 2)))

    best = minimize(rms, np.array(START), method="Nelder-Mead", options=SEARCH)
    return max(float(best.x[0]), 0.0) * data.mass, float(best.x[1])


def lmfit_leastsq(data: Record) -> tuple[float, float]:
    """(m_a in kg, C_d) by lmfit's Levenberg-Marquardt on DOP853 with events."""
    lmfit = importlib.import_module("lmfit")
    parameters = lmfit.Parameters()
    parameters.add("share", value=START[0], min=-0.9)
    parameters.add("drag", value=START[1])

    def misfit(p: dict[str, float]) -> np.ndarray:
        path = dop853_with_events(data, data.mass * (1.0 + float(p["share"])), data.drag_unit * float(p["drag"]))
        return path - data.x

    found = lmfit.minimize(misfit, parameters, method="leastsq").params
    return float(found["share"]) * data.mass, float(found["drag"])
