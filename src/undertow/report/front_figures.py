"""Figures of a diagnosis for a notebook: errors before and after, one trial before and after.

Each function takes a finished result and an Axes and returns the Axes; none fits, filters or saves. Does not belong
here: the page's figures (figures.py, trial_figures.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from undertow.discrepancy.findings import TrialFindings
from undertow.discrepancy.words import percent
from undertow.report.style import GREEN, INK, NOT_EXPLAINED, PALE, PRESCRIBED
from undertow.report.trial_curves import Axes
from undertow.report.trial_figures import response, thinned

Row = tuple[str, float, float, float]
"""A group's label, its free-run error before and after the repair (nan: none), and what repetitions allow."""


def draw_errors(rows: Sequence[Row], axes: Axes) -> Axes:
    """Free-run error of each group, in per cent of the motion: grey what is allowed, vermillion before, green after."""
    for at, (_, before, after, allowed) in enumerate(rows):
        axes.barh([at], [100.0 * allowed], color=PALE, height=0.7, label="allowed by repeatability" if not at else None)
        colour = NOT_EXPLAINED if before > allowed else INK
        axes.plot([100.0 * before], [at], "D", color=colour, label="equation as prescribed" if not at else None)
        if math.isfinite(after):
            axes.plot([100.0 * after], [at], "o", color=GREEN, label="with what was found")
    axes.set_yticks(range(len(rows)), [label for label, *_ in rows])
    axes.invert_yaxis()
    axes.set_xlabel("free-run error (% of motion)")
    handles, labels = axes.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    axes.legend(list(unique.values()), list(unique), loc="lower right")
    return axes


def draw_runs_before_and_after(trial: TrialFindings, axes: Axes) -> Axes:
    """Measured motion with what repetitions allow as a band, the prescribed equation's free run and the repaired one's.

    x0, clock and rest position were adjusted to the trial, alike for both equations.
    """
    shown = response(trial)
    rms = float(np.sqrt(np.mean(trial.measured**2)))
    allowed = trial.mismatch.repeatability_nrmse * rms * shown.factor
    measured = trial.measured * shown.factor
    if math.isfinite(allowed):
        t, band = thinned(trial.t, measured)
        axes.fill_between(t, band - allowed, band + allowed, color=PALE, lw=0, label="allowed by repeatability")
    axes.plot(*thinned(trial.t, measured), color=INK, lw=1.1, label="measured")
    before = f"as prescribed: error {percent(trial.mismatch.nrmse)}"
    axes.plot(*thinned(trial.t, trial.simulated * shown.factor), color=PRESCRIBED, lw=0.9, label=before)
    if trial.augmented:
        found = (trial.measured - trial.augmented.residual) * shown.factor
        after = f"repaired: error {percent(trial.augmented.nrmse)}"
        axes.plot(*thinned(trial.t, found), color=GREEN, lw=0.9, ls="--", label=after)
    axes.set_title(f"{trial.motion.name}{' (held out)' if trial.held_out else ''}")
    axes.set_xlabel("time after release (s)")
    axes.set_ylabel(f"{shown.words} ({shown.unit})")
    axes.margins(x=0.0)
    axes.legend(loc="upper right", ncols=2)
    return axes
