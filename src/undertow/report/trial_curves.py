"""Figures for a notebook: recorded motion, free run with its band, residual, pair plot; of a diagnosis its errors.

Each function takes plain results and an Axes and returns the Axes; none fits, filters or saves. Does not belong here:
the report's own figures (trial_figures.py, figures.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import pyplot
from matplotlib.axes import Axes

from undertow.conditioning.motion import Motion
from undertow.discrepancy.findings import TrialFindings
from undertow.discrepancy.words import percent
from undertow.likelihood.free_run import FreeRun, scored_channel
from undertow.recording.recording import Array
from undertow.report.style import BLUE, GREEN, GREY, INK, NOT_EXPLAINED, PALE, PRESCRIBED, page_style
from undertow.report.trial_figures import WITH_FOUND, Response, allowance, drawn_as, response, thinned, time_axes

WIDTH_IN, HEIGHT_IN = 8.0, 3.2
"""Size of a figure of one trial, inches."""

PANEL_IN = 1.9
"""Side of one panel of a pair plot, inches."""

BINS = 24
"""Bars of a histogram."""


@dataclass(frozen=True)
class Curve:
    """One trial's free run as drawn, (n,) each, in SI: ``measured`` may be empty, ``lower`` and ``upper`` too."""

    label: str
    t: Array
    simulated: Array
    measured: Array
    lower: Array
    upper: Array
    coordinate: str = "translation"
    quantity: str = "displacement"

    @property
    def shown(self) -> Response:
        """What it is in words, and the unit it is drawn in."""
        return drawn_as(self.quantity, self.coordinate)


def curve_of(motion: Motion, run: FreeRun) -> Curve:
    """One trial's free run, without a band."""
    none = np.zeros(0)
    label = f"{motion.name}: free-run error {percent(run.nrmse)}"
    turned, shown = motion.recording.coordinate, scored_channel(motion)
    return Curve(label, run.t, run.simulated, run.measured, none, none, turned, shown)


def noise_of_curve(motion: Motion) -> float:
    """Standard deviation of the noise of what a free run is scored against."""
    return float(motion.noise.get(scored_channel(motion), 0.0))


__all__ = [
    "Axes", "Curve", "curve_of", "draw_intervals", "draw_pairs", "draw_recording", "draw_run", "draw_run_residual",
    "new_axes", "noise_of_curve",
]  # fmt: skip


def new_axes() -> Axes:
    """An empty Axes in the page's style, of a figure that a notebook shows."""
    with page_style():
        return pyplot.subplots(figsize=(WIDTH_IN, HEIGHT_IN))[1]


def draw_recording(motion: Motion, axes: Axes) -> Axes:
    """A trial's recorded displacement about its rest position, against the time after its release."""
    shown, inside = drawn_as("displacement", motion.recording.coordinate), motion.inside
    away = (motion.x[inside] - motion.equilibrium.value) * shown.factor
    axes.plot(*thinned(motion.t[inside], away), label=motion.name)
    time_axes(axes, f"{shown.words} ({shown.unit})")
    axes.legend(loc="upper right")
    return axes


def draw_run(curve: Curve, axes: Axes) -> Axes:
    """Measured motion and free run against time, with the free run's 90 % band where there is one."""
    shown, factor = curve.shown, curve.shown.factor
    if curve.lower.size:
        low, high = curve.lower * factor, curve.upper * factor
        axes.fill_between(curve.t, low, high, color=PALE, lw=0, label="90 % band of the free run")
    if curve.measured.size:
        axes.plot(*thinned(curve.t, curve.measured * factor), color=INK, lw=1.1, label="measured")
    axes.plot(*thinned(curve.t, curve.simulated * factor), color=BLUE, lw=0.9, label="free run")
    time_axes(axes, f"{shown.words} ({shown.unit})")
    axes.set_title(curve.label)
    axes.legend(loc="upper right", ncols=3)
    return axes


def draw_run_residual(curve: Curve, axes: Axes, noise: float = 0.0) -> Axes:
    """Measured less free run against time; grey: plus and minus two standard deviations of the sensor's noise."""
    shown, factor = curve.shown, curve.shown.factor
    if noise > 0.0:
        axes.axhspan(-2.0 * noise * factor, 2.0 * noise * factor, color=PALE, lw=0, label="sensor noise (2 sigma)")
        axes.legend(loc="upper right")
    axes.plot(*thinned(curve.t, (curve.measured - curve.simulated) * factor), color=GREEN, lw=0.8)
    time_axes(axes, f"residual {shown.words} ({shown.unit})")
    axes.set_title(curve.label)
    return axes


def draw_pairs(draws: Mapping[str, Array], units: Mapping[str, str]) -> Any:
    """Pair plot of draws (name -> (m,)): histograms on the diagonal, points below it; returns the Axes (k, k)."""
    names = list(draws)
    size = PANEL_IN * max(len(names), 2)
    with page_style():
        _, panels = pyplot.subplots(len(names), len(names), figsize=(size, size), squeeze=False, sharex="col")
    for row, own in enumerate(names):
        for column, other in enumerate(names):
            panel = panels[row, column]
            if column > row:
                panel.set_axis_off()
            elif column == row:
                panel.hist(draws[own], bins=BINS, color=BLUE)
                panel.set_yticks([])
            else:
                panel.plot(draws[other], draws[own], ".", ms=1.5, color=GREY)
            if column == 0 and row:
                panel.set_ylabel(_named(own, units))
            if row == len(names) - 1:
                panel.set_xlabel(_named(other, units))
                panel.tick_params(axis="x", rotation=30)
    return panels


def draw_intervals(rows: Sequence[tuple[str, float, float, float]], axes: Axes) -> Axes:
    """Values with their intervals (label, low, value, high), one below the other, each over its own value."""
    for at, (_, low, value, high) in enumerate(rows):
        scale = abs(value) or 1.0
        axes.plot([low / scale, high / scale], [at, at], color=BLUE, lw=3.0)
        axes.plot([value / scale], [at], "o", color=INK, ms=4.0)
    axes.set_yticks(range(len(rows)), [label for label, *_ in rows])
    axes.set_xlabel("over the value found")
    axes.invert_yaxis()
    return axes


def _named(name: str, units: Mapping[str, str]) -> str:
    unit = units.get(name, "")
    return f"{name}\n({unit})" if unit not in ("", "1") else name


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


def draw_runs_before_and_after(trial: TrialFindings, axes: Axes, words: str = WITH_FOUND) -> Axes:
    """Measured motion with what repetitions allow as a band, the prescribed equation's free run and that of the one
    with more, of which ``words`` say what it is.

    x0, clock and rest position were adjusted to the trial, alike for both equations.
    """
    shown = response(trial)
    band, measured = allowance(trial) * shown.factor, trial.measured * shown.factor
    if math.isfinite(band):
        t, middle = thinned(trial.t, measured)
        axes.fill_between(t, middle - band, middle + band, color=PALE, lw=0, label="allowed by repeatability")
    axes.plot(*thinned(trial.t, measured), color=INK, lw=1.1, label="measured")
    before = f"as prescribed: error {percent(trial.mismatch.nrmse)}"
    axes.plot(*thinned(trial.t, trial.simulated * shown.factor), color=PRESCRIBED, lw=0.9, label=before)
    if trial.augmented:
        found = (trial.measured - trial.augmented.residual) * shown.factor
        after = f"{words}: error {percent(trial.augmented.nrmse)}"
        axes.plot(*thinned(trial.t, found), color=GREEN, lw=0.9, ls="--", label=after)
    axes.set_title(f"{trial.motion.name}{' (held out)' if trial.held_out else ''}")
    time_axes(axes, f"{shown.words} ({shown.unit})")
    axes.legend(loc="upper right", ncols=2)
    return axes
