"""From a free run to what a figure draws.

Belongs here: that step. Does not belong here: the free run (likelihood/free_run.py), drawing (report/trial_curves.py).
"""

from __future__ import annotations

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.discrepancy.words import percent
from undertow.likelihood.free_run import FreeRun, scored_channel
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
