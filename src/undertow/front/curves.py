"""From a free run to what a figure draws.

Belongs here: that step. Does not belong here: the free run (likelihood/free_run.py), drawing (report/trial_curves.py).
"""

from __future__ import annotations

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.discrepancy.words import percent
from undertow.likelihood.free_run import FreeRun, scored_channel
from undertow.report.trial_curves import Curve


def curve_of(motion: Motion, run: FreeRun) -> Curve:
    """One trial's free run, without a band."""
    none = np.zeros(0)
    label = f"{motion.name}: free-run error {percent(run.nrmse)}"
    turned, shown = motion.recording.coordinate, scored_channel(motion)
    return Curve(label, run.t, run.simulated, run.measured, none, none, turned, shown)


def noise_of_curve(motion: Motion) -> float:
    """Standard deviation of the noise of what a free run is scored against."""
    return float(motion.noise.get(scored_channel(motion), 0.0))
