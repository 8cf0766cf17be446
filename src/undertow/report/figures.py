"""Figures of what was found: parameters against level and amplitude, agreement of methods, mismatch.

Each function takes a finished result and an Axes and returns the Axes; none fits, filters or saves. Does not belong
here: curves in time (trial_figures.py), style and saving (style.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from statistics import median
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from undertow.discrepancy.findings import Findings, GroupFindings
from undertow.discrepancy.words import SAID_AT_MOST, condition_words, split_unit
from undertow.quantities import Estimate
from undertow.recording.recording import Condition
from undertow.report.arrange import Span, by_amplitude, is_usable, spanning_conditions
from undertow.report.numbers import printed_unit, short_number
from undertow.report.style import (
    DRAWN,
    GREY,
    INK,
    NOT_EXPLAINED,
    PALE,
    SKY,
    method_colour,
    plain_log_ticks,
    series_marker,
)
from undertow.report.wording import is_as_printed, method_label, parameter_name

LEGEND_LETTERS = 150
"""Letters of a legend's row over the page's width, six an entry for its mark: more would be cut off at the edge."""

OUTLIER_IN_SPREADS = 10.0
"""A value further from the median than this many spreads is drawn as an arrow at the edge: it hides no other."""

DODGE_SHARE = 0.6
"""Share of the closest two levels' distance over which the methods are set side by side."""


def parameter_axis_label(parameter: str, unit: str) -> str:
    """Words, symbol and unit of a parameter, for an axis.

    >>> parameter_axis_label("added_mass_kg", "kg")
    'added mass $m_a$ (kg)'
    >>> parameter_axis_label("drag_coefficient", "1")
    'drag coefficient $C_d$ (-)'
    """
    name = parameter_name(parameter)
    symbol = f" ${name.symbol}$" if name.symbol else ""
    return f"{name.words}{symbol}" + (f" ({printed_unit(unit) or '-'})" if unit else "")


def amplitude_scale(findings: Findings) -> tuple[float, str]:
    """Factor and unit in which amplitudes are drawn: mm, or degrees for a rotation."""
    return DRAWN["rotation" if findings.coordinate == "rotation" else "translation"]


def compared_methods(groups: Iterable[GroupFindings], parameter: str) -> tuple[str, ...]:
    """Methods that found the parameter in some group, in the order they ran, without recipes shown as printed."""
    found = [method for group in groups for method, fit in group.fits.items() if parameter in fit.parameters]
    return tuple(method for method in dict.fromkeys(found) if not is_as_printed(method))


def draw_against_level(findings: Findings, parameter: str, axes: Axes) -> Axes:
    """A parameter of each group against the numeric condition (water level): colour a method, marker a series.

    Bars are one standard error (noise and what was held fixed). Hollow: on a bound, or without an error bar. Without a
    numeric condition the groups stand side by side.
    """
    span = spanning_conditions(findings)
    groups = [g for g in findings.groups if any(parameter in fit.parameters for fit in g.fits.values())]
    methods = compared_methods(groups, parameter)
    series = _series_values(findings, span)
    places = {id(g): span.level_of(g) if span.level else float(i) for i, g in enumerate(groups)}
    offsets = _offsets(sorted(set(places.values())), len(methods) * len(series))
    points = []
    for group in groups:
        at = series.index(span.series_of(group))
        for i, method in enumerate(methods):
            fit = group.fits.get(method)
            if fit is None or parameter not in fit.parameters:
                continue
            place = places[id(group)] + offsets[at * len(methods) + i]
            points.append((place, fit.parameters[parameter], method_colour(method, methods), series_marker(at)))
    _draw_points(points, axes)
    if span.level:
        axes.set_xticks(sorted(set(places.values())))
        words, unit = split_unit(span.level)
        axes.set_xlabel(f"{words} ({unit})" if unit else words)
    else:
        axes.set_xticks(list(places.values()), [g.label for g in groups], rotation=20, ha="right")
        axes.set_xlabel("group")
    axes.set_ylabel(parameter_axis_label(parameter, _unit_of(points)))
    return axes


def draw_against_amplitude(findings: Findings, groups: Sequence[GroupFindings], parameter: str, axes: Axes) -> Axes:
    """A parameter found on each trial alone against its release amplitude, for the groups of one level.

    The same colours, markers and bars as draw_against_level.
    """
    span = spanning_conditions(findings)
    series = _series_values(findings, span)
    methods = compared_methods(findings.groups, parameter)
    factor, unit = amplitude_scale(findings)
    points = []
    for group in groups:
        marker = series_marker(series.index(span.series_of(group)))
        for trial in by_amplitude(group.trials):
            for i, method in enumerate(methods):
                fit = trial.fits.get(method)
                if fit is None or parameter not in fit.parameters:
                    continue
                place = trial.motion.amplitude * factor * 1.05 ** (i - 0.5 * (len(methods) - 1))
                points.append((place, fit.parameters[parameter], method_colour(method, methods), marker))
    _draw_points(points, axes)
    _draw_published(groups, parameter, axes, "y")
    _amplitude_axis(axes, [p[0] for p in points], unit)
    axes.set_ylabel(parameter_axis_label(parameter, _unit_of(points)))
    return axes


def draw_agreement(group: GroupFindings, parameter: str, axes: Axes) -> Axes:
    """Each method's interval of one parameter in one group, side by side: thick one, thin two standard errors.

    A value far from all others is an arrow at the edge with its number; hollow: on a bound or without an error bar.
    A recipe shown as printed takes no part.
    """
    found = {m: f.parameters for m, f in group.fits.items() if not is_as_printed(m)}
    rows = [(m, parameters[parameter]) for m, parameters in found.items() if parameter in parameters]
    rows = [(m, e) for m, e in rows if math.isfinite(e.value)]
    methods = tuple(group.fits)
    low, high = sensible_limits([e for _, e in rows], 2.0)
    for row, (method, estimate) in enumerate(rows):
        colour = method_colour(method, methods)
        if not low <= estimate.value <= high:
            _edge_arrow(axes, row, estimate, (low, high), colour)
            continue
        error = estimate.total_stderr if math.isfinite(estimate.total_stderr) else 0.0
        axes.plot([estimate.value - 2 * error, estimate.value + 2 * error], [row, row], color=colour, lw=1.0)
        axes.plot([estimate.value - error, estimate.value + error], [row, row], color=colour, lw=3.2)
        face = colour if is_usable(estimate) else "white"
        axes.plot([estimate.value], [row], "o", color=colour, mfc=face, ms=5.5)
    axes.set_xlim(low, high)
    _draw_published([group], parameter, axes, "x")
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_yticks(range(len(rows)), [method_label(method) for method, _ in rows])
    axes.grid(axis="y", visible=False)
    axes.locator_params(axis="x", nbins=4)
    axes.set_xlabel(parameter_axis_label(parameter, rows[0][1].unit if rows else ""))
    return axes


def _draw_published(
    groups: Sequence[GroupFindings], parameter: str, axes: Axes, along: Literal["x", "y"]
) -> None:
    """A dash-dotted line at every published value of a parameter, which the axis is widened for at most to double."""
    get, put, line = (getattr(axes, name) for name in (
        ("get_xlim", "set_xlim", "axvline") if along == "x" else ("get_ylim", "set_ylim", "axhline")
    ))  # fmt: skip
    for value in dict.fromkeys(v for g in groups for name, v in g.specimen.published if name == parameter):
        low, high = get()
        if low - 0.5 * (high - low) < value < high + 0.5 * (high - low):
            room = 0.05 * (high - low)
            put(min(low, value - room), max(high, value + room))
            line(value, color=GREY, ls="-.", lw=1.1)


def draw_mismatch(findings: Findings, group: GroupFindings, axes: Axes) -> Axes:
    """Free-run error of each trial of a group against amplitude, in per cent, with both floors, on log axes.

    Grey up to what repeatability allows, a blue line at what the sensors alone give. A trial above the grey is not
    explained: a vermillion diamond. Hollow: held out. An error of zero stands at the axis's lower end, one beyond
    `SAID_AT_MOST` there as a triangle.
    """
    factor, unit = amplitude_scale(findings)
    trials = by_amplitude(group.trials)
    x = [trial.motion.amplitude * factor for trial in trials]
    repeat = [100.0 * min(trial.mismatch.repeatability_nrmse, SAID_AT_MOST) for trial in trials]
    errors = [100.0 * min(trial.mismatch.nrmse, SAID_AT_MOST) for trial in trials]
    sensor = [100.0 * trial.mismatch.sensor_floor_nrmse for trial in trials]
    wide = _amplitude_axis(axes, x, unit)
    shown = [*repeat, *sensor, *errors]
    bottom = 0.5 * min((value for value in shown if value > 0.0), default=1.0)
    top = 2.0 * max((value for value in shown if math.isfinite(value)), default=1.0)
    axes.set_ylim(bottom, max(top, 4.0 * bottom))
    axes.set_yscale("log")
    axes.fill_between(wide, bottom, np.maximum(_ends_repeated(repeat), bottom), color=PALE, lw=0)
    axes.plot(wide, _ends_repeated(sensor), color=SKY, lw=1.2)
    for place, error, trial in zip(x, errors, trials, strict=True):
        missing, beyond = trial.mismatch.missing, trial.mismatch.nrmse > SAID_AT_MOST
        colour = NOT_EXPLAINED if missing else INK
        face = "white" if trial.held_out else colour
        marker = "^" if beyond else "D" if missing else "o"
        axes.plot([place], [max(error, bottom)], marker, ms=5.5, color=colour, mfc=face)
    plain_log_ticks(axes.yaxis, [value for value in shown if value > 0.0 and math.isfinite(value)])
    axes.set_ylabel("free-run error (% of motion)")
    return axes


def group_legend(group: GroupFindings, parameters: Sequence[str], figure: Figure) -> None:
    """What the marks of a group's panels mean, above them: draw_mismatch's, and each method's colour."""
    methods = tuple(dict.fromkeys(m for p in parameters for m in compared_methods([group], p)))
    marks = [
        Line2D([], [], color=INK, marker="o", ls="none", label="explained"),
        Line2D([], [], color=NOT_EXPLAINED, marker="D", ls="none", label="not explained"),
        Line2D([], [], color=GREY, marker="o", mfc="white", ls="none", label="hollow: held out"),
        Line2D([], [], color=PALE, lw=7, label="allowed by repeatability"),
        Line2D([], [], color=SKY, lw=1.2, label="sensors alone"),
        *(Line2D([], [], color=method_colour(m, methods), lw=3, label=method_label(m)) for m in methods),
    ]
    _legend(marks, figure)


def _legend(marks: Sequence[Line2D], figure: Figure) -> None:
    columns = legend_columns([str(mark.get_label()) for mark in marks])
    figure.legend(handles=marks, loc="outside upper left", ncols=columns)


def legend_columns(labels: Sequence[str]) -> int:
    """How many entries stand beside each other in a legend over the page's width.

    >>> legend_columns(["SINDy", "Method 1"]), legend_columns(["a condition with a long value " * 2] * 5)
    (2, 2)
    """
    if sum(len(label) + 6 for label in labels) <= LEGEND_LETTERS:
        return max(len(labels), 1)
    return max(1, LEGEND_LETTERS // (max(len(label) for label in labels) + 6))


def method_legend(findings: Findings, parameters: Sequence[str], figure: Figure) -> None:
    """Colours of methods and markers of series, above a figure's panels."""
    found = [m for p in parameters for m in compared_methods(findings.groups, p)]
    methods = tuple(dict.fromkeys(found))
    span = spanning_conditions(findings)
    marks = [Line2D([], [], color=method_colour(m, methods), lw=3, label=method_label(m)) for m in methods]
    if span.series is not None:
        for i, value in enumerate(_series_values(findings, span)):
            label = condition_words(span.series, value)
            marks.append(Line2D([], [], color=GREY, marker=series_marker(i), ls="none", label=label))
    hollow = "hollow: on a bound or no error bar"
    marks.append(Line2D([], [], color=GREY, marker="o", mfc="white", ls="none", label=hollow))
    _legend(marks, figure)


def sensible_limits(estimates: Sequence[Estimate], errors_shown: float = 1.0) -> tuple[float, float]:
    """Limits of an axis that show these estimates, so many of their errors, and none that are far from all others.

    >>> low, high = sensible_limits([Estimate(10.0, 1.0), Estimate(11.0, 1.0), Estimate(900.0, 1.0)])
    >>> low < 9.0, 12.0 < high < 100.0
    (True, True)
    """
    usable = [e for e in estimates if math.isfinite(e.value)]
    if not usable:
        return 0.0, 1.0
    middle = median(e.value for e in usable)
    errors = [e.total_stderr for e in usable if math.isfinite(e.total_stderr)]
    spread = max(median(abs(e.value - middle) for e in usable), median(errors) if errors else 0.0)
    kept = [e for e in usable if abs(e.value - middle) <= OUTLIER_IN_SPREADS * spread] or usable
    widest = max(spread, max(e.value for e in kept) - min(e.value for e in kept))
    reach = [min(errors_shown * e.total_stderr, widest) if math.isfinite(e.total_stderr) else 0.0 for e in kept]
    low = min(e.value - r for e, r in zip(kept, reach, strict=True))
    high = max(e.value + r for e, r in zip(kept, reach, strict=True))
    room = 0.08 * (high - low) or 0.05 * abs(middle) or 1.0
    return low - room, high + room


Point = tuple[float, Estimate, str, str]


def _draw_points(points: Sequence[Point], axes: Axes) -> None:
    low, high = sensible_limits([p[1] for p in points])
    for place, estimate, colour, marker in points:
        if not math.isfinite(estimate.value):
            continue
        if not low <= estimate.value <= high:
            edge, mark = (high, "^") if estimate.value > high else (low, "v")
            axes.plot([place], [edge], mark, color=colour, ms=4.5, mfc="white", clip_on=False)
            continue
        total = estimate.total_stderr
        error = total if math.isfinite(total) else 0.0
        face = colour if is_usable(estimate) else "white"
        axes.errorbar([place], [estimate.value], [error], fmt=marker, color=colour, mfc=face, ms=4.5, elinewidth=1.0)
    axes.set_ylim(low, high)
    if low < 0.0 < high:
        axes.axhline(0.0, color=GREY, lw=0.6)


def _edge_arrow(axes: Axes, row: int, estimate: Estimate, limits: tuple[float, float], colour: str) -> None:
    right = estimate.value > limits[1]
    edge = limits[1] if right else limits[0]
    axes.plot([edge], [row], ">" if right else "<", color=colour, ms=6, clip_on=False)
    shift, align = (-8, "right") if right else (8, "left")
    text = short_number(estimate.value)
    axes.annotate(
        text, (edge, row), (shift, 0), textcoords="offset points", ha=align, va="center", color=colour, fontsize=8
    )


def _series_values(findings: Findings, span: Span) -> list[Condition]:
    return list(dict.fromkeys(span.series_of(group) for group in findings.groups))


def _offsets(levels: Sequence[float], number: int) -> list[float]:
    closest = min((b - a for a, b in pairwise(levels)), default=1.0)
    if number < 2:
        return [0.0] * number
    return [float(value) for value in np.linspace(-0.5, 0.5, number) * DODGE_SHARE * closest]


def _unit_of(points: Sequence[Point]) -> str:
    return next((estimate.unit for _, estimate, _, _ in points if estimate.unit), "")


def _amplitude_axis(axes: Axes, x: Sequence[float], unit: str) -> list[float]:
    """Label, limits and, unless a body was released at rest, a log scale; returns x with the limits around it."""
    axes.set_xlabel(f"release amplitude ({unit})")
    low, high = min(x, default=1.0), max(x, default=1.0)
    wide = [low / 1.25, *x, high * 1.25] if low > 0.0 else [-0.1 * high, *x, 1.1 * high or 1.0]
    axes.set_xlim(wide[0], wide[-1])
    if low > 0.0:
        axes.set_xscale("log")
        plain_log_ticks(axes.xaxis, x)
    return wide


def _ends_repeated(values: Sequence[float]) -> list[float]:
    return [values[0], *values, values[-1]]
