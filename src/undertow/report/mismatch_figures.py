"""Figures of where a mismatch is: energy a cycle, residual in time and frequency, residual force, cycle by cycle.

Each function takes a finished result and an Axes (or a Figure) and returns it; none fits, filters or saves. Does not
belong here: curves in time (trial_figures.py), how sure the numbers are (fit_figures.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import chain, cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize, to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator
from scipy.signal import stft

from undertow.discrepancy.cycle_by_cycle import Cycling
from undertow.discrepancy.energy import EnergyBudget
from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.discrepancy.residual import ResidualForce, residual_force
from undertow.discrepancy.words import spelled
from undertow.equation.registry import row
from undertow.errors import UndertowError
from undertow.recording.recording import Array
from undertow.report.numbers import printed_unit, short_number
from undertow.report.style import BLUE, DRAWN, GREEN, GREY, INK, NOT_EXPLAINED, ORANGE, PRESCRIBED, PURPLE, SKY
from undertow.report.trial_figures import WITH_FOUND, leaves, response, with_words
from undertow.report.writing import true_minus

CYCLES_AT_MOST = 12
"""Cycles of an energy budget that are drawn."""

SWINGS_A_WINDOW = 6.0
"""Swings of the body in one window of the map in time and frequency: lines a sixth of its frequency apart part."""

FEWEST_SAMPLES = 32
"""Samples below which there is no map in time and frequency."""

CELLS = 15
"""Cells of displacement, and of speed, over which a residual force is averaged."""

FEWEST_IN_CELL = 3
"""Samples below which a cell stays empty."""

POORLY_KNOWN = 5.0
"""A cycle whose error is this many times the median one does not widen the frame."""

LETTERS_IN_A_ROW = 45
"""Letters of three labels that stand side by side over half a figure."""

SHADES = (0.15, 0.3, 0.45, 0.6, 0.75, 0.9)
"""Opacities of the steps of a map, weakest first."""

_SOURCES: Mapping[str, tuple[str, str]] = {
    "viscous_damping": ("structure: damping", BLUE),
    "coulomb_friction": ("structure: friction", ORANGE),
    "quadratic_drag": ("drag", SKY),
}
"""Words and colour of the laws that every config may prescribe."""


def draw_energy(budget: EnergyBudget, found: Sequence[str], figure: Figure) -> Figure:
    """Left: what each law takes, stacked, a bar a cycle, in per cent of the first cycle's energy, or of the largest
    that a cycle begins with; points: what is lost. Right: the same over all cycles, in per cent of all that is lost.
    ``found`` are the laws that were found."""
    left, right = figure.subplots(1, 2, width_ratios=(1.9, 1.0))
    shown = slice(0, CYCLES_AT_MOST)
    stored = float(np.max(budget.stored))
    number = np.arange(1, budget.stored[shown].size + 1)
    above, below = np.zeros(number.size), np.zeros(number.size)
    rows = []
    for name, values, words, colour in _parts(budget, found):
        share = 100.0 * values[shown] / stored
        bottom = np.where(share >= 0.0, above, below)
        left.bar(number, share, 0.7, bottom=bottom, color=colour, label=words)
        above, below = above + np.maximum(share, 0.0), below + np.minimum(share, 0.0)
        rows.append((words, 100.0 * budget.share(name), colour))
    band = 100.0 * budget.error[shown] / stored
    left.errorbar(number, 100.0 * budget.lost[shown] / stored, band, fmt="D", ms=3.5, color=INK, label="lost, measured")
    left.axhline(0.0, color=GREY, lw=0.6)
    left.set_xticks(number[:: max(1, number.size // 8)])
    left.set_xlabel("cycle")
    left.set_ylabel("% of the first energy" if stored == budget.stored[0] else "% of the largest energy")
    left.grid(axis="x", visible=False)
    for at, (_, value, colour) in enumerate(rows):
        right.barh(at, value, color=colour, height=0.65)
        said = true_minus(f"{round(value)} %")
        right.annotate(said, (max(value, 0.0), at), (3, 0), textcoords="offset points", va="center")
    right.set_yticks(range(len(rows)), [words for words, *_ in rows])
    right.invert_yaxis()
    right.margins(x=0.18)
    right.grid(axis="y", visible=False)
    right.set_xlabel("% of all that is lost")
    return figure


def _parts(budget: EnergyBudget, found: Sequence[str]) -> list[tuple[str, Array, str, str]]:
    """Name, energy a cycle (n,), words and colour of every law, then of what is left: of what was found with a clock
    of its own (another size and phase in every trial), and of what is not explained."""
    spare = iter((PURPLE, "#8C6D31", "#7B4FA3", "#56606B"))
    parts: list[tuple[str, Array, str, str]] = []
    for name, values in budget.taken.items():
        words, colour = _SOURCES.get(name, (spelled(name), ""))
        if name in found:
            words, colour = f"found: {spelled(name)}", GREEN if GREEN not in {p[3] for p in parts} else ""
        parts.append((name, values, words, colour or next(spare, GREY)))
    apart = [spelled(name) for name in found if (law := row(name)) is not None and law.own_clock]
    left = ", ".join([*apart, "and what is not explained"]) if apart else "not explained"
    return [*parts, ("unexplained", budget.unexplained, left, GREY if apart else NOT_EXPLAINED)]


def draw_where(
    group: GroupFindings, trial: TrialFindings, cycling: Cycling, lines: Mapping[str, float], figure: Figure
) -> Figure:
    """Four panels: residual of one trial in time and frequency, residual force of the group's trials over displacement
    and speed, frequency and damping cycle by cycle. ``lines`` are frequencies (Hz) to mark, by what they are."""
    below = 1.0 if cycling.time.size else 0.05  # only a line that says why
    panels = figure.subplots(2, 2, height_ratios=(1.0, below))
    draw_time_frequency(trial, lines, panels[0][0])
    draw_residual_force(group, panels[0][1])
    for panel, which in zip(panels[1], ("frequency", "damping"), strict=True):
        draw_cycles(cycling, panel, which, with_words(group.verdict))
    return figure


def draw_time_frequency(trial: TrialFindings, lines: Mapping[str, float], axes: Axes) -> Axes:
    """Amplitude of the residual of the prescribed equation over time and frequency, with frequencies marked."""
    shown = response(trial)
    if leaves(trial):
        axes.set_title("the free run leaves the recording: no map of its residual")
        axes.set_axis_off()
        return axes
    step = float(np.median(np.diff(trial.t)))
    body = max(lines.values(), default=math.nan) if "body" not in lines else lines["body"]
    even = np.arange(trial.t[0], trial.t[-1], step)
    if even.size < FEWEST_SAMPLES:
        axes.set_title(f"{even.size} samples: too few for a map in time and frequency")
        return axes
    residual = np.interp(even, trial.t, (trial.measured - trial.simulated) * shown.factor)
    wanted = round(SWINGS_A_WINDOW / body / step) if body > 0.0 else even.size // 4
    size = max(min(wanted, even.size // 2), 8)
    frequency, time, values = stft(residual, 1.0 / step, nperseg=size, noverlap=size - max(size // 5, 1), nfft=2 * size)
    top = 2.5 * max([f for f in lines.values() if math.isfinite(f)], default=float(frequency[-1]) / 2.5)
    kept = frequency <= top
    amplitude = 2.0 * np.abs(values[kept])
    largest = float(amplitude.max()) or 1.0
    levels = np.array([*SHADES, 1.0]) * largest
    colours = [to_rgba(NOT_EXPLAINED, shade) for shade in SHADES]
    shades = axes.contourf(time + even[0], frequency[kept], amplitude, levels=levels, colors=colours)
    _bar(shades, axes, f"amplitude ({shown.unit})")
    for (words, at), style in zip(lines.items(), chain(("-",), cycle(("--", ":", "-."))), strict=False):
        if math.isfinite(at):
            axes.axhline(at, color=INK if style == "-" else GREEN, lw=0.9, ls=style, label=f"{words} {at:.3g} Hz")
    axes.set_ylim(0.0, top)
    axes.set(xlabel="time after release (s)", ylabel="frequency (Hz)")
    rows = _legend_above(axes)
    axes.set_title(f"residual in time and frequency, up to {short_number(largest, 2)} {shown.unit}", pad=4 + 14 * rows)
    return axes


def draw_residual_force(group: GroupFindings, axes: Axes) -> Axes:
    """Residual force of the prescribed equation over displacement and speed, mean over the group's trials in cells."""
    forces = _forces(group)
    coordinate = group.trials[0].motion.recording.coordinate
    factor, unit = DRAWN[coordinate]
    axes.set_xlabel(f"displacement ({unit})" if coordinate == "translation" else f"angle ({unit})")
    axes.set_ylabel(f"speed ({unit}/s)")
    if not forces:
        axes.set_title("no residual force: the equation's laws have none along this motion")
        return axes
    x, v, f = (np.concatenate([getattr(one, name) for one in forces]) for name in ("x", "v", "force"))
    wide = [np.linspace(-float(np.max(np.abs(q))), float(np.max(np.abs(q))), CELLS + 1) for q in (x, v)]
    count, _, _ = np.histogram2d(x, v, bins=wide)
    total, _, _ = np.histogram2d(x, v, bins=wide, weights=f - f.mean())
    mean = np.where(count >= FEWEST_IN_CELL, total / np.maximum(count, 1), np.nan)
    largest = float(np.nanmax(np.abs(mean))) if np.any(np.isfinite(mean)) else 1.0
    width, height = ((edges[1] - edges[0]) * factor for edges in wide)
    shades = [*(to_rgba(BLUE, shade) for shade in SHADES[::-1]), *(to_rgba(NOT_EXPLAINED, shade) for shade in SHADES)]
    scale = ScalarMappable(Normalize(-largest, largest), ListedColormap(shades))
    colours = scale.to_rgba(mean)
    for i, j in np.argwhere(np.isfinite(mean)):
        corner = (wide[0][i] * factor, wide[1][j] * factor)
        axes.add_patch(Rectangle(corner, width, height, facecolor=tuple(colours[i, j]), lw=0))
    axes.set_xlim(wide[0][0] * factor, wide[0][-1] * factor)
    axes.set_ylim(wide[1][0] * factor, wide[1][-1] * factor)
    unit = printed_unit(group.specimen.unit("N per kg" if group.equation.mass_kg == 1.0 else "N"))
    _bar(scale, axes, f"{'force' if coordinate == 'translation' else 'moment'} ({unit})")
    axes.set_title(f"residual force, mean in every cell: up to ±{short_number(largest, 2)} {unit}")
    return axes


def _bar(shades: ScalarMappable, axes: Axes, label: str) -> None:
    """A colour bar beside a map."""
    bar = axes.figure.colorbar(shades, ax=axes, ticks=MaxNLocator(4), pad=0.02, fraction=0.04, label=label)
    bar.outline.set_visible(False)


def _forces(group: GroupFindings) -> list[ResidualForce]:
    out = []
    for trial in group.trials:
        try:
            out.append(residual_force(trial.motion, group.equation))
        except UndertowError:
            continue
    return out


def draw_cycles(cycling: Cycling, axes: Axes, which: str, found: str = WITH_FOUND) -> Axes:
    """Frequency or damping of every full cycle: points measured, with one standard error; lines the equations, of which
    ``found`` says what the one with more than the prescribed is."""
    if not cycling.time.size:
        axes.set_title(f"{which} a cycle: no cycle is clear, noise turns the motion too")
        axes.set_axis_off()
        return axes
    scale = 1.0 if which == "frequency" else 100.0
    measured, error = scale * getattr(cycling, which), scale * getattr(cycling, f"{which}_error")
    axes.errorbar(cycling.time, measured, error, fmt="o", ms=3.0, color=INK, elinewidth=0.8, label="measured")
    runs = (("as prescribed", PRESCRIBED, "-", cycling.before), (found, GREEN, "--", cycling.after))
    for words, colour, style, run in runs:
        if run is not None:
            axes.plot(run.time, scale * getattr(run, which), style, color=colour, lw=1.0, label=words)
    if ends := _frame(measured, error, [scale * getattr(run, which) for *_, run in runs if run is not None]):
        axes.set_ylim(*ends)
    axes.set_xlabel("time after release (s)")
    axes.set_ylabel("frequency (Hz)" if which == "frequency" else "damping (% of critical)")
    axes.set_title(f"{which} of every full cycle", pad=4 + 14 * _legend_above(axes))
    return axes


def _frame(measured: Array, error: Array, runs: Sequence[Array]) -> tuple[float, float] | None:
    """Ends of an axis for values (n,) with their errors: those that are known well, and of the equations' what lies not
    further from them than they are wide."""
    finite = np.isfinite(measured)
    known = finite & (error <= POORLY_KNOWN * np.median(error[finite])) if np.isfinite(error[finite]).all() else finite
    if not known.any():
        return None
    low, high = float(measured[known].min()), float(measured[known].max())
    wide = max(high - low, 0.02 * abs(high))
    near = [v[np.isfinite(v) & (v > low - wide) & (v < high + wide)] for v in runs]
    every = np.concatenate([measured[known], *near])
    low, high = float(every.min()), float(every.max())
    room = max(0.1 * (high - low), 0.01 * abs(high))
    return low - room, high + room


def _legend_above(axes: Axes) -> int:
    """The legend between the axes and its title, over no curve and no wider than the axes; its number of rows."""
    words = [str(w) for w in axes.get_legend_handles_labels()[1]]
    columns = 3 if sum(len(w) for w in words) <= LETTERS_IN_A_ROW else 2
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.1, borderpad=0.0)
    return math.ceil(len(words) / columns)
