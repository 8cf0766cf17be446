"""The files of an audit: audit.json, audit.html (self-contained) and its figures.

Belongs here: the figures (printed coefficients beside what rivals print, what cannot be separated, cells), the page's
making, writing. Does not belong here: what is said (audit).
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from undertow.audit.answer import Answer, Weight
from undertow.audit.effects import (
    DAMPING,
    FRICTION,
    FRICTION_FORCE,
    LINEAR,
    RESONATOR,
    RESONATOR_FREQUENCY,
    RESONATOR_MASS,
)
from undertow.audit.findings import AuditFindings, CellFinding, SeriesFindings
from undertow.audit.forces import WaterShare
from undertow.audit.recipes import Array
from undertow.audit.verdicts import Range, likely, rounded
from undertow.report import style
from undertow.report.writing import rendered, write_text

WIDTH_IN = 11.0
"""Width of a figure over the whole page, inch."""


def write_audit(findings: AuditFindings, folder: Path, config: Mapping[str, Any]) -> Path:
    """Write audit.json, audit.html, figures/*.svg and the resolved config into ``folder``; the page's path."""
    with style.page_style():
        drawn = audit_svgs(findings)
    (folder / "figures").mkdir(exist_ok=True)
    for name, svg in drawn.items():
        write_text(folder / "figures" / f"{name}.svg", svg)
    write_text(
        folder / "audit.json", json.dumps(findings.plain(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    )
    write_text(folder / "config.json", json.dumps(config, indent=1, ensure_ascii=False) + "\n")
    return write_text(folder / "audit.html", audit_html(findings, drawn))


def audit_html(findings: AuditFindings, drawn: Mapping[str, str]) -> str:
    """The page as text, from finished figures (name -> SVG)."""
    inline = {name: Markup(svg[svg.index("<svg") :]) for name, svg in drawn.items()}
    return rendered(
        "audit.html.j2",
        name=findings.name,
        checks=findings.checks,
        trends=findings.trends,
        shares=[(share, inline[f"share-{i}"]) for i, share in enumerate(findings.shares)],
        series=[_block(series, inline, i) for i, series in enumerate(findings.series)],
        cells=findings.cells,
    )


def _block(series: SeriesFindings, inline: Mapping[str, Markup], number: int) -> dict[str, Any]:
    """What the page shows of one audit."""
    return {
        "name": series.name,
        "verdict": series.verdict,
        "confidence": likely(series.verdict.confidence),
        "names": " + ".join(series.verdict.verdict) or "nothing beyond Eq. 15",
        "figures": [svg for name, svg in inline.items() if name.startswith(f"series-{number}-")],
        "parameters": [
            (_group(group), parameter_lines(parameters))
            for group, parameters in zip(series.groups, series.verdict.parameters, strict=True)
        ],
        "others": [
            (label, [(_group(g), parameter_lines(p)) for g, p in zip(series.groups, each, strict=True)])
            for label, each in series.verdict.others.items()
        ],
        "what_if": [(one.name, one.verdict) for one in series.what_if],
    }


def _group(group: Mapping[str, Any]) -> str:
    return ", ".join(f"{name.removesuffix('_m').replace('_', ' ')} {value}" for name, value in group.items())


def parameter_lines(parameters: Mapping[str, Mapping[str, Range]]) -> list[tuple[str, str, str]]:
    """Effect, parameter, and its 90 % interval with unit."""
    return [
        (
            effect,
            name,
            f"{rounded(r.value)} ({rounded(r.low)} to {rounded(r.high)}){'' if r.unit == '1' else ' ' + r.unit}",
        )
        for effect, group in parameters.items()
        for name, r in group.items()
    ]


def audit_svgs(findings: AuditFindings) -> dict[str, str]:
    """Every figure of the page as SVG text, by name."""
    drawn = {}
    for i, share in enumerate(findings.shares):
        figure = style.new_figure(0.55 * WIDTH_IN, 3.2)
        draw_share(share, figure.subplots())
        drawn[f"share-{i}"] = style.svg_text(figure)
    for i, series in enumerate(findings.series):
        if len(series.groups) == 1:
            drawn[f"series-{i}-rows"] = style.svg_text(_rows(series))
            drawn[f"series-{i}-open"] = style.svg_text(_open(series))
        else:
            drawn[f"series-{i}-resonators"] = style.svg_text(_resonators(findings, series))
            figure = style.new_figure(0.6 * WIDTH_IN, 3.0)
            draw_probabilities(series.answer, figure.subplots())
            drawn[f"series-{i}-probabilities"] = style.svg_text(figure)
    return drawn


def _rows(series: SeriesFindings) -> Figure:
    figure = style.new_figure(WIDTH_IN, 3.6)
    places = figure.subplots(1, 2)
    for column, axes in enumerate(places):
        draw_rows(series.answer, 1 - column, axes)
    handles, labels = places[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _open(series: SeriesFindings) -> Figure:
    figure = style.new_figure(WIDTH_IN, 3.2)
    left, right = figure.subplots(1, 2)
    draw_probabilities(series.answer, left)
    draw_mixture(series.answer, right)
    return figure


def _resonators(findings: AuditFindings, series: SeriesFindings) -> Figure:
    figure = style.new_figure(WIDTH_IN, 3.2)
    places = figure.subplots(1, len(series.groups), squeeze=False, sharey=True, sharex=True)[0]
    draw_resonators(series, findings.cells, list(places))
    for axes in places:
        axes.set_yscale("log")
    handles, labels = places[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=max(len(labels), 1), markerscale=2.0)
    return figure


BAND = (0.05, 0.95)
"""Quantiles of a band: 90 %."""

RIVALS_DRAWN = 3
"""Rivals drawn beside Eq. 15: more bands than this cannot be distinguished."""

POINTS_DRAWN = 400
"""Draws of a posterior shown as points."""

NAMES = ("added mass, kg", "drag coefficient")
COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.PURPLE)


def draw_rows(found: Answer, column: int, axes: Axes) -> Axes:
    """Printed m_a (column 0) or C_d (1) of a single case against the release, with what Eq. 15 and the best rivals
    print."""
    case = found.cases[0]
    springs = case.springs
    release = np.array([row.release_m for row in case.rows])
    printed = np.array([(row.added_mass_kg, row.drag_coefficient)[column] for row in case.rows])
    shown = _drawn(found)
    for spring, marker in zip(springs, ("o", "s", "^", "D"), strict=False):
        own = np.array([row.spring == spring for row in case.rows])
        order = np.flatnonzero(own)[np.argsort(release[own])]
        for weight, colour in shown:
            _band(weight, order, column, release[order] * 1e3, axes, colour)
        label = f"printed, {spring} spring" if len(springs) > 1 else "printed"
        axes.plot(release[order] * 1e3, printed[order], marker, color=style.INK, markersize=4, label=label, zorder=5)
    axes.set_xscale("log")
    style.plain_log_ticks(axes.xaxis, list(release * 1e3))
    if column == 1:
        axes.set_yscale("log")
        style.plain_log_ticks(axes.yaxis, [value for value in printed if value > 0.0])
    axes.set(xlabel="release, mm", ylabel=NAMES[column])
    return axes


def _drawn(found: Answer) -> list[tuple[Weight, str]]:
    plain = found.of()
    named = [weight for weight in found.weights if weight.rival.effects][:RIVALS_DRAWN]
    shown = [(weight, colour) for weight, colour in zip(named, COLOURS, strict=False)]
    return [(plain, style.GREY), *shown] if plain is not None else shown


def _band(weight: Weight, rows: NDArray[np.intp], column: int, x: Array, axes: Axes, colour: str) -> None:
    low, high = np.quantile(weight.posteriors[0].predicted[:, rows, column], BAND, axis=0)
    label = weight.rival.label.replace("_", " ")
    known = axes.get_legend_handles_labels()[1]
    axes.fill_between(x, low, high, color=colour, alpha=0.25, linewidth=0.8, label=None if label in known else label)


def draw_probabilities(found: Answer, axes: Axes) -> Axes:
    """Every rival's log evidence below the best one's, the most probable on top."""
    weights = list(found.weights)[::-1]
    best = max(weight.log_evidence for weight in weights)
    gaps = [weight.log_evidence - best for weight in weights]
    colours = [style.SKY if weight.rival.effects else style.GREY for weight in weights]
    axes.barh(range(len(weights)), gaps, color=colours, height=0.6)
    for i, weight in enumerate(weights):
        axes.text(0.0, i, _percent(weight.probability), va="center", ha="left", fontsize=7.5)
    axes.set_yticks(range(len(weights)), [weight.rival.label.replace("_", " ") for weight in weights])
    axes.set_xlim(max(min(gaps), -40.0) * 1.05 - 0.5, 0.0)
    axes.set_xlabel("log evidence below the best (cut at -40); right: probability")
    axes.grid(axis="y", visible=False)
    axes.margins(x=0.1)
    return axes


def _percent(probability: float) -> str:
    if probability > 0.999:
        return " > 99.9 %"
    return f" {100.0 * probability:.3g} %" if probability > 1e-5 else " < 0.001 %"


def draw_mixture(found: Answer, axes: Axes) -> Axes:
    """Linear damping against friction error where both are free, coloured by C_d: what a table leaves open."""
    weight = found.of(LINEAR, FRICTION)
    if weight is None:
        return axes
    draws = weight.posteriors[0].draws
    few = slice(0, POINTS_DRAWN)
    points = axes.scatter(
        draws[DAMPING][few], draws[FRICTION_FORCE][few],
        c=draws["drag_coefficient"][few], s=6, cmap="viridis", rasterized=True,
    )  # fmt: skip
    axes.figure.colorbar(points, ax=axes, label="drag coefficient")
    axes.set(xlabel="linear damping on top, N s/m", ylabel="friction error, N")
    return axes


def draw_resonators(series: SeriesFindings, cells: Sequence[CellFinding], places: Sequence[Axes]) -> None:
    """For each case the resonators (frequency, mass) that print its rows, and the closed cell's first mode."""
    again = [("as printed", series.answer, style.BLUE)]
    again += [(one.name, one.answer, style.ORANGE) for one in series.what_if]
    for i, (group, axes) in enumerate(zip(series.groups, places, strict=True)):
        for label, found, colour in again:
            weight = found.of(RESONATOR)
            if weight is None:
                continue
            draws = weight.posteriors[i].draws
            few = slice(0, POINTS_DRAWN)
            axes.plot(
                draws[RESONATOR_FREQUENCY][few], draws[RESONATOR_MASS][few], ".",
                color=colour, markersize=3, alpha=0.5, label=label, rasterized=True,
            )  # fmt: skip
        for cell in cells:
            if cell.water in group.values():
                frequency, mass = cell.modes.frequencies_rad_per_s[0], cell.modes.masses_kg[0]
                axes.plot(frequency, mass, "*", color=style.VERMILLION, markersize=11, label="closed cell, no fit")
        axes.set_title(
            ", ".join(f"{value:g} m" if isinstance(value, float) else str(value) for value in group.values())
        )
        axes.set_xlabel("frequency, rad/s")
    places[0].set_ylabel("participating mass, kg")


def draw_share(share: WaterShare, axes: Axes) -> Axes:
    """Printed C_d beside what friction and viscous damping of the dry structure alone give at the printed
    velocities."""
    order = np.argsort(share.release_m)
    x = share.release_m[order] * 1e3
    low, high = share.dry_low[order], share.dry_high[order]
    axes.fill_between(x, low, high, color=style.SKY, alpha=0.4, linewidth=0.8, label="dry structure, 90 %")
    axes.plot(x, share.printed[order], "o", color=style.INK, markersize=4, label="printed")
    axes.set_xscale("log")
    axes.set_yscale("log")
    style.plain_log_ticks(axes.xaxis, list(x))
    style.plain_log_ticks(axes.yaxis, list(share.printed))
    axes.set(xlabel="release, mm", ylabel=NAMES[1])
    axes.legend()
    return axes
