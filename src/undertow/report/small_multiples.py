"""All trials of a group at once: small panels on one Axes, each to its own scale, the residual below the motion.

An Axes a panel would take longer to make than all curves in it, and eighty of them half a minute; each panel says its
scale in words instead. Belongs here: that figure. Does not belong here: one trial drawn large (trial_figures.py), the
explorer, which has every axis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.recording.recording import Array
from undertow.report.arrange import chosen
from undertow.report.numbers import short_number
from undertow.report.style import GREEN, GREY, INK, NOT_EXPLAINED, PALE, PRESCRIBED
from undertow.report.trial_figures import (
    RUNAWAY,
    allowance,
    leaves,
    reach,
    response,
    thinned,
    trial_heading,
    with_words,
)

PANELS_AT_MOST = 24
"""Trials of a group that are drawn; of more, the ends and the worst explained ones."""

POINTS_AT_MOST = 280
"""Points of a curve in a panel: the explorer has every sample."""

ROW_IN, WIDTH_IN = 2.3, 11.0
"""Height of a row of panels and width of the figure, inch."""

MOTION, RESIDUAL = (0.40, 0.84), (0.08, 0.32)
"""Bottom and top of the motion's and of the residual's strip, over a panel's height; its heading stands above, their
scales between them."""

GAP = 0.035
"""Free width between panels, over a panel's width."""


@dataclass(frozen=True)
class _Panel:
    """One trial's place: left edge, width and bottom in panels; what its strips stand for at their tops."""

    trial: TrialFindings
    left: float
    bottom: float
    motion: float
    residual: float

    def x(self, t: Array) -> Array:
        """Instants as places: the window over the panel's width."""
        start, end = self.trial.t[0], self.trial.t[-1]
        return np.asarray(self.left + GAP + (1.0 - 2.0 * GAP) * (t - start) / (end - start), dtype=np.float64)

    def y(self, values: Array, strip: tuple[float, float], largest: float) -> Array:
        """Values as places in a strip, zero in its middle."""
        middle, half = 0.5 * (strip[0] + strip[1]), 0.5 * (strip[1] - strip[0])
        return np.asarray(self.bottom + middle + half * np.clip(values / largest, -1.0, 1.0), dtype=np.float64)


def panel_grid(panels: int) -> tuple[int, int]:
    """Columns and rows for so many panels: wide while they are few.

    >>> panel_grid(4), panel_grid(7)
    ((2, 2), (3, 3))
    """
    columns = 1 if panels < 2 else 2 if panels <= 6 else 3
    return columns, max(1, math.ceil(panels / columns))


def draw_free_runs(group: GroupFindings, figure: Figure, at_most: int = PANELS_AT_MOST) -> Figure:
    """Small multiples of a group, a panel a trial by amplitude: measured, free run, dashed with what the verdict names
    or the closest candidate; below, what they leave to a scale of its own, with what repeatability allows."""
    trials, found = chosen(group.trials, at_most), with_words(group.verdict)
    columns, rows = panel_grid(len(trials))
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.005, 0.005, 0.99, 1.0 - 0.3 / (ROW_IN * rows)))
    axes.set_axis_off()
    axes.set_xlim(0.0, columns)
    axes.set_ylim(0.0, rows)
    for i, trial in enumerate(trials):
        row, column = divmod(i, columns)
        _draw_panel(_panel(trial, float(column), float(rows - 1 - row)), found, axes)
    marks = [("measured", INK, "-"), ("free run", PRESCRIBED, "-")]
    marks += [("frame: trial not explained", NOT_EXPLAINED, "-")] if any(t.mismatch.missing for t in trials) else []
    marks += [(found, GREEN, "--")] if any(t.augmented for t in trials) else []
    handles = [Line2D([], [], color=colour, ls=style, label=words) for words, colour, style in marks]
    figure.legend(handles=handles, loc="upper left", ncols=len(handles), borderaxespad=0.1)
    return figure


def _panel(trial: TrialFindings, left: float, bottom: float) -> _Panel:
    """The trial's place and scales: its largest motion, and its largest residual or what is allowed."""
    residual, band, largest = trial.measured - trial.simulated, allowance(trial), reach(trial)
    left_over = max(float(np.max(np.abs(residual))), band if math.isfinite(band) else 0.0)
    left_over = largest if leaves(trial) else left_over
    return _Panel(trial, left, bottom, largest, left_over or largest)


def _draw_panel(panel: _Panel, found: str, axes: Axes) -> None:
    """One trial: band, curves (the green one called ``found``), heading, and the scales in words."""
    trial = panel.trial
    missing = trial.mismatch.missing
    edge = NOT_EXPLAINED if missing else GREY
    band = allowance(trial)
    sides = panel.x(trial.t[[0, -1]])
    if math.isfinite(band):
        low, high = (panel.y(np.array([side * band]), RESIDUAL, panel.residual)[0] for side in (-1.0, 1.0))
        corners = [(sides[0], low), (sides[1], low), (sides[1], high), (sides[0], high)]
        axes.add_collection(PolyCollection([corners], facecolors=PALE, linewidths=0))
    frame = []
    for low, high in ((panel.bottom + strip[0], panel.bottom + strip[1]) for strip in (MOTION, RESIDUAL)):
        corners = [(sides[0], low), (sides[1], low), (sides[1], high), (sides[0], high)]
        frame.append([*corners, corners[0]])
    axes.add_collection(LineCollection(frame, colors=edge, linewidths=0.6))
    curves = [(trial.measured, MOTION, INK, "-"), (trial.simulated, MOTION, PRESCRIBED, "-")]
    curves.append((trial.measured - trial.simulated, RESIDUAL, PRESCRIBED, "-"))
    if trial.augmented:
        curves.append((trial.measured - trial.augmented.residual, MOTION, GREEN, "--"))
        curves.append((trial.augmented.residual, RESIDUAL, GREEN, "-"))
    for values, strip, colour, style in curves:
        t, few = thinned(trial.t, values, POINTS_AT_MOST)
        largest = panel.motion if strip is MOTION else panel.residual
        line = np.column_stack([panel.x(t), panel.y(few, strip, largest)])
        axes.add_collection(LineCollection([line], colors=colour, linewidths=0.8, linestyles=style))
    head = trial_heading(trial, found)
    axes.text(sides[0], panel.bottom + 0.86, head, fontsize=8.5, va="bottom", color=NOT_EXPLAINED if missing else INK)
    _draw_scales(panel, (float(sides[0]), float(sides[1])), axes)


def _draw_scales(panel: _Panel, sides: tuple[float, float], axes: Axes) -> None:
    """What the strips' heights and the panel's width stand for, in words."""
    shown, t = response(panel.trial), panel.trial.t
    between = panel.bottom + 0.5 * (MOTION[0] + RESIDUAL[1])
    for words, size, at, side in (("", panel.motion, 0, "left"), ("residual ", panel.residual, 1, "right")):
        said = f"{words}±{short_number(size * shown.factor)} {shown.unit}"
        axes.text(sides[at], between, said, fontsize=7.5, ha=side, va="center", color=GREY)
    span = f"{short_number(t[0], 2)} to {short_number(t[-1])} s after the release"
    span += f"; free run beyond {RUNAWAY:g} times the measured motion: cut" if leaves(panel.trial) else ""
    axes.text(sides[0], panel.bottom + 0.065, span, fontsize=7.5, va="top", color=GREY)
