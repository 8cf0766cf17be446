"""Figures of driven bodies: a record beside its free runs, points of a harmonic set beside the equation swept.

Each function takes a finished result and a Figure and returns it; none fits or saves. Does not belong here: the curves
of any motion in time (trial_figures.py), the page (driven_page.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from undertow.recording.recording import Array
from undertow.report.style import GREEN, INK, PALE, PRESCRIBED, plain_log_ticks
from undertow.report.trial_figures import Response, Runs, curves_legend, draw_beside, draw_left, draw_runs, reach

SEEN_AT_LEAST = 1e-3
"""Share of the largest motion below which what is left of a point is drawn at the frame's edge."""


def draw_whole(runs: Runs, unseen_from: float | None, figure: Figure) -> Figure:
    """A whole record beside its free runs, and below what these leave; grey from ``unseen_from`` (s) on: held back."""
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.6, 1.0))
    draw_runs(runs, upper)
    draw_left(runs, lower)
    _frame(runs, upper)
    upper.set_xlabel("")
    curves_legend(runs, upper, figure)
    if unseen_from is not None:
        for axes in (upper, lower):
            axes.axvspan(unseen_from, float(runs.t[-1]), color=PALE, lw=0.0, alpha=0.45, zorder=0)
    return figure


def draw_held_back(runs: Runs, figure: Figure) -> Figure:
    """The beginning of a record that was held back beside its free runs, and below what these leave."""
    draw_beside(runs, figure)
    _frame(runs, figure.axes[0])
    return figure


def _frame(runs: Runs, axes: Axes) -> None:
    """The axis of a motion: about zero, but that of a carriage, which stays on one side, from its smallest value on."""
    low, high, factor = float(np.min(runs.measured)), float(np.max(runs.measured)), runs.shown.factor
    size = 1.1 * reach(runs)
    bottom = low - 0.1 * size if low > -0.1 * high else -size
    axes.set_ylim(factor * bottom, factor * size)


@dataclass(frozen=True)
class DrawnCurve:
    """Steady motions of an equation swept one way (``up`` or down): ``frequency_Hz``, ``amplitude``, ``phase`` (deg),
    each (n,); ``repaired``: of the repaired equation, else as prescribed."""

    repaired: bool
    up: bool
    frequency_Hz: Array
    amplitude: Array
    phase: Array


@dataclass(frozen=True)
class DrawnSet:
    """One trial's points as recorded, phases in deg, and how amplitudes are ``shown``; ``rising`` and ``unseen`` (held
    back) are masks (n,). ``left`` is what the equation as prescribed and (where there is one) repaired leave of each
    point's motion, (n,) each, amplitude of the difference."""

    name: str
    shown: Response
    frequency_Hz: Array
    amplitude: Array
    phase: Array
    rising: np.ndarray
    unseen: np.ndarray
    curves: Sequence[DrawnCurve]
    left: Sequence[Array]


def draw_set(drawn: DrawnSet, figure: Figure, phases: bool = True) -> Figure:
    """Amplitudes above, ``phases`` below them, and at the bottom what either equation leaves of each point."""
    heights = (2.2, 1.3, 1.0) if phases else (2.6, 1.0)
    above, *others = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    factor, both_ways = drawn.shown.factor, bool(drawn.rising.any() and not drawn.rising.all())
    for curve in drawn.curves:
        colour = GREEN if curve.repaired else PRESCRIBED
        look: dict[str, Any] = {"color": colour, "lw": 1.2, "ls": "--" if both_ways and not curve.up else "-"}
        label = "equation repaired" if curve.repaired else "equation as prescribed"
        said = label if label not in _labels(above) else "_"
        above.plot(curve.frequency_Hz, factor * curve.amplitude, label=said, **look)
        if phases:
            others[0].plot(curve.frequency_Hz, curve.phase, **look)
    _draw_points(drawn, factor * drawn.amplitude, above)
    if phases:
        _draw_points(drawn, drawn.phase, others[0])
        others[0].set_ylabel("phase (°)")
    _draw_left(drawn, others[-1])
    above.set_ylabel(f"amplitude\n({drawn.shown.unit})")
    above.set_ylim(0.0, None)
    others[-1].set_xlabel("frequency (Hz)")
    figure.legend(*above.get_legend_handles_labels(), loc="outside upper left", ncols=4 if phases else 2)
    figure.align_ylabels()
    return figure


def _labels(axes: Axes) -> list[str]:
    return [str(line.get_label()) for line in axes.lines]


def _draw_points(drawn: DrawnSet, values: Array, axes: Axes) -> None:
    """Measured points: a triangle up or down as the frequency went, hollow where it was held back."""
    for way, marker, word in ((True, "^", "upward"), (False, "v", "downward")):
        for apart in (False, True):
            here = (drawn.rising == way) & (drawn.unseen == apart)
            if here.any():
                label = f"measured {word}{', not fitted' if apart else ''}"
                inside = "none" if apart else INK
                axes.plot(
                    drawn.frequency_Hz[here], values[here], ls="none", marker=marker, ms=4.0, color=INK, mfc=inside,
                    label=label,
                )  # fmt: skip


def _draw_left(drawn: DrawnSet, axes: Axes) -> None:
    """What the equations leave of each point, on a log axis."""
    factor, largest = drawn.shown.factor, float(np.max(drawn.amplitude))
    sizes: list[float] = []
    for left, colour in zip(drawn.left, (PRESCRIBED, GREEN), strict=False):
        shown = factor * np.maximum(left, 0.1 * SEEN_AT_LEAST * largest)
        axes.plot(drawn.frequency_Hz, shown, ls="none", marker="o", ms=3.0, color=colour)
        sizes += shown.tolist()
    if sizes:
        axes.set_yscale("log")
        axes.set_ylim(min(sizes) / 1.5, max(sizes) * 1.5)
        plain_log_ticks(axes.yaxis, sizes)
    axes.set_ylabel(f"left over\n({drawn.shown.unit})")
