"""`undertow predict` on a terminal: how well a recording is met, or what a motion never tested is like.

Belongs here: a prediction in words. Does not belong here: the free run (front/run_prediction.py).
"""

from __future__ import annotations

import math

import numpy as np

from undertow.campaign.driven.predict import Predicted
from undertow.campaign.response.predict import PredictedSet
from undertow.discrepancy.words import percent
from undertow.front.beside_prediction import mean_period
from undertow.front.run_prediction import RunPrediction


def prediction_text(made: RunPrediction | Predicted | PredictedSet) -> str:
    """The share of samples in the band, and rms against a recording, last of all in its unit; without one peak, period,
    decay and band."""
    if math.isfinite(made.rms):
        lines = [f"in the 90 % band: {100 * made.covered:.1f} % of the samples"]
        if isinstance(made, RunPrediction) and math.isfinite(made.missed):
            lines.append(f"rms over the motion's own rms: {percent(made.missed)}")
        return "\n".join([*lines, f"rms {made.rms:.6g} {made.unit}"])
    return _motion_text(made) if isinstance(made, RunPrediction) else ""


def _motion_text(made: RunPrediction) -> str:
    t, x, unit = made.run.t, made.run.predicted - made.run.rest, made.unit
    period, periods = mean_period(t, x)
    lines = [f"peak {np.max(np.abs(x)):.4g} {unit}"]
    if made.too_coarse:
        lines.append(f"period {made.period_s:.4g} s by the equation: these samples are too few to show it")
    elif periods:
        late = float(np.max(np.abs(x[t >= t[-1] - period])))
        lines.append(f"period {period:.4g} s (mean of {periods}); last swing {late:.4g} {unit}")
    else:
        lines.append(f"no whole period within {t[-1]:.4g} s; at its end {x[-1]:.4g} {unit}")
    half = 0.5 * (made.run.upper - made.run.lower)
    if np.isfinite(half).all():
        lines.append(f"90 % band: +- {np.mean(half):.2g} {unit} on average, {np.max(half):.2g} {unit} at most")
    return "\n".join(lines)
