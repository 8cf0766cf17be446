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

    A trial that was fitted keeps the x0, clock and rest of the fit; another starts where it was recorded to start.
    """
    names = solution.problem.names

    def found(name: str, otherwise: float) -> float:
        key = f"{name}[{motion.name}]"
        return float(solution.values[names.index(key)]) if key in names else otherwise

    rest = found("rest_m", motion.equilibrium.value)
    x0 = found("x0_m", float(motion.x[0]) - motion.equilibrium.value)
    v0 = found("v0_m_per_s", 0.0 if motion.window.held else float(motion.v[0]))
    late = found("shift_s", 0.0)
    t = motion.windowed("t")
    quantity = scored_channel(motion)
    times = np.maximum(t + late, 0.0)
    grid = np.unique(np.concatenate([[0.0], times]))
    moved = simulate(equation, x0, grid, v0)
    level = {"displacement": moved.x, "velocity": moved.v, "acceleration": moved.a}[quantity]
    simulated = level[np.searchsorted(grid, times)]
    measured = motion.recorded(quantity)[motion.inside] - (rest if quantity == "displacement" else 0.0)
    score = float(np.sqrt(np.mean((measured - simulated) ** 2) / np.mean(measured**2)))
    return FreeRun(t, measured, simulated, score, np.zeros(0), np.zeros((t.size, 0)), OK)
