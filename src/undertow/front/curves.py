"""From a free run to what a figure draws.

Belongs here: that step, and the free run of a user's own law. Does not belong here: drawing (report/trial_curves.py).
"""

from __future__ import annotations

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.discrepancy.words import percent
from undertow.equation.equation import Equation
from undertow.equation.simulate import simulate
from undertow.likelihood.free_run import FreeRun, scored_channel
from undertow.likelihood.output_error import Solution
from undertow.quantities import OK
from undertow.recording.recording import Array
from undertow.report.trial_curves import Curve

STEPS = 3
"""Gauss-Newton steps from where a trial was seen to start: an error of a tenth of a period is gone after two."""

SMALL = 1e-4
"""Step in x0 of a difference quotient, over x0."""


def curve_of(motion: Motion, run: FreeRun, lower: Array | None = None, upper: Array | None = None) -> Curve:
    """One trial's free run, with its band where there is one."""
    none = np.zeros(0)
    label = f"{motion.name}: free-run error {percent(run.nrmse)}"
    return Curve(
        label, run.t, run.simulated, run.measured, none if lower is None else lower, none if upper is None else upper,
        motion.recording.coordinate, scored_channel(motion),
    )  # fmt: skip


def noise_of_curve(motion: Motion) -> float:
    """Standard deviation of the noise of what a free run is scored against."""
    return float(motion.noise.get(scored_channel(motion), 0.0))


def run_of_own_law(equation: Equation, motion: Motion, solution: Solution) -> FreeRun:
    """The free run of an equation with a law that the compiled integrator does not know.

    A trial that was fitted keeps the x0, clock and rest position of the fit; to another they are fitted, as scores are.
    """
    names = solution.problem.names

    def found(name: str, otherwise: float) -> float:
        key = f"{name}[{motion.name}]"
        return float(solution.values[names.index(key)]) if key in names else otherwise

    v0 = found("v0_m_per_s", 0.0 if motion.window.held else float(motion.v[0]))
    start = np.array([
        found("x0_m", float(motion.x[0]) - motion.equilibrium.value), found("shift_s", 0.0),
        found("rest_m", motion.equilibrium.value),
    ])  # fmt: skip
    quantity = scored_channel(motion)
    t, measured = motion.windowed("t"), motion.recorded(quantity)[motion.inside]
    if not any(name.endswith(f"[{motion.name}]") for name in names):
        start = _adjusted(equation, motion, v0, start)
    rest = float(start[2]) if quantity == "displacement" else 0.0
    simulated = _moved(equation, quantity, t, v0, start)[0]
    about = measured - rest
    score = float(np.sqrt(np.mean((about - simulated) ** 2) / np.mean(about**2)))
    return FreeRun(t, about, simulated, score, np.zeros(0), np.zeros((t.size, 0)), OK)


def _adjusted(equation: Equation, motion: Motion, v0: float, start: Array) -> Array:
    """x0, clock and rest position that bring the free run closest to a trial, by a few Gauss-Newton steps."""
    quantity = scored_channel(motion)
    t, measured = motion.windowed("t"), motion.recorded(quantity)[motion.inside]
    rests = float(quantity == "displacement")
    small = SMALL * abs(float(start[0]))
    values = start
    for _ in range(STEPS):
        simulated, rate = _moved(equation, quantity, t, v0, values)
        aside, _ = _moved(equation, quantity, t, v0, values + np.array([small, 0.0, 0.0]))
        slopes = np.column_stack([(aside - simulated) / small, rate, np.full(t.size, rests)])
        left = measured - rests * values[2] - simulated
        values = values + np.linalg.lstsq(slopes, left, rcond=None)[0]
    return values


def _moved(equation: Equation, quantity: str, t: Array, v0: float, start: Array) -> tuple[Array, Array]:
    """What a sensor of this quantity would see at ``t`` (n,), and its rate of change; x0, clock, rest in ``start``."""
    times = np.maximum(t + start[1], 0.0)
    grid = np.unique(np.concatenate([[0.0], times]))
    moved = simulate(equation, float(start[0]), grid, v0)
    level = {"displacement": moved.x, "velocity": moved.v, "acceleration": moved.a}[quantity]
    at = np.searchsorted(grid, times)
    rate = moved.v if quantity == "displacement" else np.gradient(level, grid)
    return level[at], rate[at]
