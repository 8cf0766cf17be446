"""Figures of trials in time: measured against free run, residual, decay.

Each function takes a finished result and an Axes (a Figure where there are two) and returns it; none fits, filters or
saves. Does not belong here: all trials of a group at once (small_multiples.py), figures of parameters (figures.py),
style and saving (style.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import percent
from undertow.recording.recording import Array, Recording
from undertow.report.arrange import chosen, excess
from undertow.report.behind import is_repaired
from undertow.report.numbers import short_number
from undertow.report.style import DRAWN, GREEN, INK, NOT_EXPLAINED, PALE, PRESCRIBED, plain_log_ticks

CURVES_AT_MOST = 8
"""Decays on one axes that a reader can still tell apart."""

POINTS_AT_MOST = 900
"""Points of a curve in a panel; of more, the lowest and the highest of each stretch are drawn."""

SWINGS_SHOWN = 12
"""Swings of the trial on the page's first screen: more run into each other at its width."""

FIRST_POINTS = 400
"""Points of a curve on the page's first screen."""

RUNAWAY = 3.0
"""A free run is drawn up to so many times the largest measured motion: further away it has left the recording."""

WITH_FOUND, WITH_CLOSEST = "with what was found", "with the closest candidate"
"""How a free run with more than the equation is called: where the verdict names what was added, and where not."""

STILL_MOVES = 0.35
"""Share of a swing's largest speed: where a record cuts off a faster motion, its last value is no peak (a slower one's
is within 6 % of it)."""


@dataclass(frozen=True)
class Response:
    """What the free run is compared with, in words; the unit it is drawn in, and how many of it make one in SI."""

    words: str
    unit: str
    factor: float


class Moved(Protocol):
    """A motion as it was measured and as a free run has it, (n,) in SI."""

    @property
    def measured(self) -> Array:
        """The recording."""

    @property
    def simulated(self) -> Array:
        """The free run of the equation as prescribed."""


@dataclass(frozen=True)
class Runs:
    """A motion (n,) beside the free runs of the equation as prescribed (``simulated``) and ``repaired`` (None: not
    drawn), in SI; how they are ``shown``, how far repetitions would lie from it (RMS; nan: nobody knows), from when the
    time is counted, and what the free runs are ``called``."""

    t: Array
    measured: Array
    simulated: Array
    repaired: Array | None
    shown: Response
    allowed: float = math.nan
    clock: str = "time after release (s)"
    called: tuple[str, str] = ("equation as prescribed", "equation repaired")


def runs_of(trial: TrialFindings) -> Runs:
    """What is drawn of a trial in time."""
    repaired = trial.measured - trial.augmented.residual if trial.augmented else None
    return Runs(trial.t, trial.measured, trial.simulated, repaired, response(trial), allowance(trial))


def response(trial: TrialFindings) -> Response:
    """What a trial's free run is compared with."""
    return response_of(trial.motion.recording)


def response_of(recording: Recording) -> Response:
    """Displacement where it was recorded, else velocity (a rate gyro alone)."""
    return drawn_as("displacement" if "displacement" in recording.channels else "velocity", recording.coordinate)


def drawn_as(channel: str, coordinate: str) -> Response:
    """How a channel of a motion is drawn."""
    factor, unit = DRAWN[coordinate]
    turned = "angle" if channel == "displacement" else "angular velocity"
    words = turned if coordinate == "rotation" else channel
    return Response(words, unit if channel == "displacement" else f"{unit}/s", factor)


def with_words(verdict: Verdict) -> str:
    """How the free run with more than the equation is called, where a verdict's trials have one."""
    return WITH_FOUND if is_repaired(verdict) else WITH_CLOSEST


def allowance(trial: TrialFindings) -> float:
    """How far repetitions would lie from a trial's measured motion (RMS), in SI; nan where nobody knows."""
    return trial.mismatch.repeatability_nrmse * float(np.sqrt(np.mean(trial.measured**2)))


def time_axes(axes: Axes, label: str, clock: str = "time after release (s)") -> None:
    """Labels of an axes over the time, which its curves fill."""
    axes.set(xlabel=clock, ylabel=label)
    axes.margins(x=0.0)


def leaves(trial: Moved) -> bool:
    """Whether a trial's free run leaves the recording, and with it every axis that shows the motion."""
    return bool(np.max(np.abs(trial.simulated)) > RUNAWAY * (np.max(np.abs(trial.measured)) or np.inf))


def reach(trial: Moved) -> float:
    """The largest excursion that is drawn of a trial, in SI: measured or of the free run, as far as `RUNAWAY`."""
    measured, run = float(np.max(np.abs(trial.measured))), float(np.max(np.abs(trial.simulated)))
    return max(measured, min(run, RUNAWAY * measured) if measured else run) or 1.0


def _say_that_it_leaves(runs: Runs, axes: Axes) -> None:
    """The axis ends at `reach`, and says so, where the free run leaves the recording."""
    if leaves(runs):
        size = 1.1 * reach(runs) * runs.shown.factor
        axes.set_ylim(-size, size)
        words = f"free run beyond {RUNAWAY:g} times the measured motion: not drawn"
        behind = {"facecolor": "#ffffff", "linewidth": 0.0, "pad": 2.0}
        axes.text(
            0.99, 0.97, words, transform=axes.transAxes, ha="right", va="top", fontsize=8, color=NOT_EXPLAINED,
            bbox=behind,
        )  # fmt: skip


def thinned(t: Array, values: Array, at_most: int = POINTS_AT_MOST) -> tuple[Array, Array]:
    """At most so many points of a curve, (m,) each: the lowest and the highest of each stretch, so that peaks stay.

    >>> t = np.arange(10_000.0)
    >>> few, shown = thinned(t, np.where(t == 4321.0, 9.0, 0.0), 100)
    >>> few.size <= 100, float(shown.max())
    (True, 9.0)
    """
    if t.size <= at_most:
        return t, values
    stretches = np.array_split(np.arange(t.size), at_most // 2)
    kept = {int(s[end]) for s in stretches for end in (np.argmin(values[s]), np.argmax(values[s]))}
    index = np.array(sorted(kept))
    return t[index], values[index]


def trial_heading(trial: TrialFindings, found: str = WITH_FOUND) -> str:
    """Release amplitude, free-run error against what is allowed, and in words if the trial is not explained; ``found``
    is what the green line is called."""
    factor, unit = DRAWN[trial.motion.recording.coordinate]
    mismatch = trial.mismatch
    error = f"error {percent(mismatch.nrmse)} (allowed {percent(mismatch.repeatability_nrmse)})"
    text = f"{short_number(trial.motion.amplitude * factor)} {unit} · {error}"
    if trial.held_out:
        text += " · held out"
    text += f" · NOT EXPLAINED ({excess(trial):.1f}×)" if mismatch.missing else ""
    return text + (f"\n{found}: error {percent(trial.augmented.nrmse)}" if trial.augmented else "")


def draw_free_run(trial: TrialFindings, axes: Axes, found: str = WITH_FOUND) -> Axes:
    """Measured motion of one trial and the free run of its group's equation from the release, against time; dashed the
    free run ``found``."""
    draw_runs(runs_of(trial), axes, found)
    axes.set_title(trial_heading(trial, found), color=NOT_EXPLAINED if trial.mismatch.missing else INK)
    return axes


def draw_runs(runs: Runs, axes: Axes, found: str = WITH_FOUND) -> Axes:
    """A motion beside its free runs, against time; dashed the free run ``found``."""
    factor = runs.shown.factor
    axes.plot(*thinned(runs.t, runs.measured * factor), color=INK, lw=1.1, label="measured")
    axes.plot(*thinned(runs.t, runs.simulated * factor), color=PRESCRIBED, lw=0.7, label="free run")
    if runs.repaired is not None:
        axes.plot(*thinned(runs.t, runs.repaired * factor), color=GREEN, lw=0.8, ls="--", label=found)
    time_axes(axes, f"{runs.shown.words}\n({runs.shown.unit})", runs.clock)
    _say_that_it_leaves(runs, axes)
    return axes


def draw_residual(trial: TrialFindings, axes: Axes) -> Axes:
    """Measured minus free run against time, green with what the verdict names; grey: plus and minus what repeatability
    allows, as an RMS."""
    return draw_left(runs_of(trial), axes)


def draw_left(runs: Runs, axes: Axes) -> Axes:
    """What free runs leave of a motion, against time, in the colours of the runs; grey: plus and minus what is
    allowed."""
    factor = runs.shown.factor
    band = runs.allowed * factor
    if math.isfinite(band):
        axes.axhspan(-band, band, color=PALE, lw=0)
    residual = (runs.measured - runs.simulated) * factor
    axes.plot(*thinned(runs.t, residual), color=PRESCRIBED, lw=0.7)
    if runs.repaired is not None:
        axes.plot(*thinned(runs.t, (runs.measured - runs.repaired) * factor), color=GREEN, lw=0.8)
    size = 1.1 * max(float(np.max(np.abs(residual))), band if math.isfinite(band) else 0.0, 1e-9)
    size = 1.1 * reach(runs) * factor if leaves(runs) else size
    axes.set_ylim(-size, size)
    time_axes(axes, f"residual\n({runs.shown.unit})", runs.clock)
    return axes


def draw_first(trial: TrialFindings, figure: Figure, repaired: bool) -> Figure:
    """One trial for the page's first screen; ``repaired``: with the equation repaired."""
    return draw_beside(runs_of(trial if repaired else replace(trial, augmented=None)), figure)


def draw_beside(runs: Runs, figure: Figure) -> Figure:
    """A motion for the page's first screen, its first SWINGS_SHOWN swings: measured, the equation as prescribed and the
    equation repaired; below, what either leaves, grey what repeatability allows."""
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.6, 1.0))
    draw_runs(runs, upper)
    draw_left(runs, lower)
    for line in upper.lines:
        line.set_linewidth(1.4)
    upper.set_xlabel("")
    upper.set_ylim(-1.1 * reach(runs) * runs.shown.factor, 1.1 * reach(runs) * runs.shown.factor)
    end = _swings_end(runs)
    _cut(upper, end)
    _cut(lower, end)
    lower.locator_params(axis="y", nbins=3)
    curves_legend(runs, upper, figure)
    return figure


def curves_legend(runs: Runs, axes: Axes, figure: Figure) -> None:
    """What the curves of `draw_runs` are, in a row above the figure; labels of its vertical axes in one line."""
    for line, label in zip(axes.lines, ("measured", *runs.called), strict=False):
        line.set_label(label)
    figure.legend(handles=list(axes.lines), loc="outside upper left", ncols=3)
    figure.align_ylabels()


def _cut(axes: Axes, end: float) -> None:
    """Curves end there, with no more than FIRST_POINTS points each."""
    for line in axes.lines:
        t, values = np.asarray(line.get_xdata(orig=True)), np.asarray(line.get_ydata(orig=True))
        line.set_data(*thinned(t[t <= end], values[t <= end], FIRST_POINTS))
    axes.set_xlim(float(np.min(axes.lines[0].get_xdata())), end)


def _swings_end(trial: Runs) -> float:
    """When a motion's first SWINGS_SHOWN swings are over, or it ends."""
    peaks, _ = half_cycle_peaks(trial.t, trial.measured, 0.02 * float(np.max(np.abs(trial.measured))))
    return float(peaks[2 * SWINGS_SHOWN] if peaks.size > 2 * SWINGS_SHOWN else trial.t[-1])


def half_cycle_peaks(t: Array, x: Array, smallest: float) -> tuple[Array, Array]:
    """Time and size of the largest |x| of every half cycle; crossings are counted once |x| has exceeded ``smallest``.
    What the ends of the record cut off before (or after) its peak is left out.

    >>> t = np.arange(0.0, 2.0, 0.01)
    >>> _, sizes = half_cycle_peaks(t, np.exp(-t) * np.cos(2.0 * np.pi * t), 0.01)
    >>> [round(float(size), 2) for size in sizes]
    [1.0, 0.61, 0.37, 0.23, 0.14]
    """
    side = np.where(x > smallest, 1, np.where(x < -smallest, -1, 0))
    away = np.flatnonzero(side)
    if away.size == 0:
        return np.zeros(0), np.zeros(0)
    splits = np.flatnonzero(np.diff(side[away])) + 1
    pieces = _with_peaks(x, np.split(away, splits))
    peaks = [piece[int(np.argmax(np.abs(x[piece])))] for piece in pieces]
    return t[peaks], np.abs(x[peaks])


def _with_peaks(x: Array, pieces: list[NDArray[np.intp]]) -> list[NDArray[np.intp]]:
    """The half cycles whose peaks a record shows: without a first or last one that it cuts off while the body moves. A
    release from rest and a body that stops are peaks."""
    if len(pieces) == 1:
        return pieces
    starts = [int(piece[0]) for piece in pieces[1:]]
    half = float(np.median(np.diff(starts))) if len(starts) > 1 else 2.0 * (starts[0] - int(pieces[0][0]))
    first, last = int(pieces[0][0]), int(pieces[-1][-1])
    outside = np.concatenate([[np.nan], x, [np.nan]])  # what is before the first sample, or after the last
    begins = np.isnan(outside[first]) and _moves(np.abs(x[pieces[0][::-1]]), np.abs(x[pieces[1]]), half)
    ends = np.isnan(outside[last + 2]) and _moves(np.abs(x[pieces[-1]]), np.abs(x[pieces[-2]]), half)
    return pieces[bool(begins) : len(pieces) - bool(ends)]


def _moves(sizes: Array, beside: Array, half: float) -> bool:
    """Whether |x| of a piece still grows towards its end faster than that of a body that is about to turn: over the
    last eighth of a half cycle of ``half`` samples. ``beside`` is |x| of the half cycle next to it."""
    near = max(1, round(half / 8.0))
    if sizes.size <= near:
        return True
    angle = math.pi * near / half
    turning = 1.0 - math.cos(angle) + STILL_MOVES * math.sin(angle)
    grown = float(np.max(sizes) - np.max(sizes[:-near]))
    return grown > turning * max(float(np.max(sizes)), float(np.max(beside)))


def draw_decay(group: GroupFindings, axes: Axes) -> Axes:
    """Amplitude of every half cycle against time on a log axis: points measured, lines the free run, dashed with what
    the verdict names or, where it names nothing, with the closest candidate."""
    trials = chosen(group.trials, CURVES_AT_MOST)
    factor, sizes = response(trials[0]).factor, []
    for trial in trials:
        noise = min(trial.motion.noise.values(), default=0.0)
        smallest = max(0.01 * float(np.max(np.abs(trial.measured))), 3.0 * noise)
        t, size = half_cycle_peaks(trial.t, trial.measured, smallest)
        axes.plot(t, size * factor, ".", color=INK, ms=4.0)
        sizes += [float(value) * factor for value in size if value > 0.0]
        t, size = half_cycle_peaks(trial.t, trial.simulated, smallest)
        axes.plot(t, size * factor, "-", color=PRESCRIBED, lw=0.9)
        if trial.augmented:
            t, size = half_cycle_peaks(trial.t, trial.measured - trial.augmented.residual, smallest)
            axes.plot(t, size * factor, "--", color=GREEN, lw=0.9)
    if sizes:
        axes.set_ylim(0.7 * min(sizes), 1.4 * max(sizes))
        axes.set_yscale("log")
        plain_log_ticks(axes.yaxis, sizes)
    shown = response(trials[0])
    axes.set(xlabel="time after release (s)", ylabel=f"peak {shown.words} a half cycle ({shown.unit})")
    found = f" · dashed: {with_words(group.verdict)}" if any(trial.augmented for trial in trials) else ""
    axes.set_title(f"points: measured · lines: free run{found}", fontsize=8)
    return axes
