"""The files of an audit: audit.json, audit.html (self-contained) and its figures.

Belongs here: the figures (printed coefficients beside what rivals print, what cannot be separated, cells), the page's
making, writing. Does not belong here: what is said (audit).
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup, escape
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
from undertow.audit.verdicts import OF_SPRING, Range, SeriesVerdict, rounded
from undertow.discrepancy.words import condition_words, group_title
from undertow.report import style
from undertow.report.numbers import plain_number, printed_unit
from undertow.report.wording import effects_words, parameter_name, reason_words, unbroken
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
    inline = {name: Markup(style.in_theme(svg[svg.index("<svg") :])) for name, svg in drawn.items()}
    return rendered(
        "audit.html.j2",
        name=findings.name,
        lead=audit_words(findings.lead),
        checks=[(rule, [audit_words(one) for one in said]) for rule, said in findings.together()],
        trends=[
            (trend.title, NAMES[trend.quantity == "drag_coefficient"].split(",")[0], trend.law.rows,
             f"{trend.law.exponent:.2f} ± {trend.law.half_width_95:.2f}".replace("-", "\N{MINUS SIGN}"))
            for trend in findings.trends
        ],
        shares=[(audit_words(share.sentence), inline[f"share-{i}"]) for i, share in enumerate(findings.shares)],
        series=[_block(series, inline, i) for i, series in enumerate(findings.series)],
        cells=findings.cells,
    )  # fmt: skip


_AT_LEVELS = re.compile(r"\b([a-z]+(?:_[a-z]+)*_[a-z]+) = (\d+(?:\.\d+)?(?:(?:, | and )\d+(?:\.\d+)?)*)")
_PROBABILITY = re.compile(r"(?<=probability )(of |above )?(\d(?:\.\d+)?(?:e-\d+)?)")
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=%|(?:kg|m|m³|N|N/m|m/s|rad/s|s|J)(?:[ ,;:.)]|$))")
_MINUS = re.compile(r"(?<![\w)])-(?=\d)")
_FORMULAS = {
    "m_a": "mₐ", "x''": "ẍ", "x0": "x₀", "mu N": "μ N", "mu (": "μ (", "2 pi": "2 π", "2 zeta": "2 ζ", "rho": "ρ",
    "sqrt(": "√(", " / 2": "/2",
}  # fmt: skip


def audit_text(text: str) -> str:
    """A sentence of the audit for a reader: names, conditions and powers in words and signs, probabilities in per cent.

    >>> print(audit_text("coulomb_friction does (probability 0.995)"))
    Coulomb friction does (probability 99.5\N{NO-BREAK SPACE}%)
    """
    text = _AT_LEVELS.sub(lambda found: condition_words(found[1], found[2]), text)
    text = _PROBABILITY.sub(lambda found: f"{found[1] or ''}{_percent(float(found[2]))}", text)
    for printed, meant in _FORMULAS.items():
        text = text.replace(printed, meant)
    text = _MINUS.sub("\N{MINUS SIGN}", text)
    return _BEFORE_UNIT.sub("\N{NO-BREAK SPACE}", reason_words(text))


def audit_words(text: str) -> Markup:
    """The same on the page, where letters stand below the line.

    >>> print(audit_words("m_a is 1.0918e+08 times k x0^2 / 2 at water_depth_m = 2.22 and 2.29, +- 1"))
    m<sub>a</sub> is 1.0918 × 10⁸ times k x₀²/2 at water depth 2.22 and 2.29\N{NO-BREAK SPACE}m, ± 1
    """
    return Markup(str(escape(audit_text(text))).replace("mₐ", "m<sub>a</sub>").replace("C_d", "C<sub>d</sub>"))


def effect_words(effects: Sequence[str], water: bool = True) -> str:
    """A rival in words.

    >>> effect_words(("linear_damping", "rest_offset")), effect_words(()), effect_words((), water=False)
    ('linear damping + rest offset', 'Eq. 15 alone', 'no water force')
    """
    if not effects:
        return "Eq. 15 alone" if water else "no water force"
    return effects_words(effects)


def _block(series: SeriesFindings, inline: Mapping[str, Markup], number: int) -> dict[str, Any]:
    """What the page shows of one audit."""
    said = series.verdict
    most = max(series.answer.weights, key=lambda weight: weight.log_evidence)
    best = (effect_words(most.rival.effects, most.rival.water), _percent(most.probability))
    own = f"series-{number}-"
    sets = [(f"If it is {effect_words(said.verdict)}", said.parameters)]
    sets += [(f"If it is {effect_words(label.split(' + '))}", each) for label, each in said.others.items()]
    return {
        "name": series.name,
        "sentence": audit_words(said.sentence),
        "next_test": audit_words(said.next_test),
        "status": _status(said),
        "confidence": _percent(said.confidence),
        "names": effect_words(said.verdict),
        "others": ", ".join(effect_words(names) for names in said.alternatives),
        "figures": {name.rpartition("-")[2]: svg for name, svg in inline.items() if name.startswith(own)},
        "best": None if most is series.answer.weights[0] else best,
        "groups": [unbroken(group_title(group)) if group else "median (90 % interval)" for group in series.groups],
        "parameters": [(title, parameter_lines(each)) for title, each in sets],
        "what_if": [(one.name, audit_words(one.verdict.sentence)) for one in series.what_if],
    }  # fmt: skip


def _status(said: SeriesVerdict) -> tuple[str, str]:
    """A verdict in two words, and the page's colour of it."""
    if not said.informs_about_water:
        return "says nothing of the water", "unsure"
    if said.status == "explained":
        return "named", "found"
    return ("nothing missing", "good") if said.status == "nothing_missing" else ("several fit", "unsure")


def parameter_lines(groups: Sequence[Mapping[str, Mapping[str, Range]]]) -> list[tuple[str, list[str]]]:
    """Every parameter in words with its unit, and its median with the 90 % interval in each group."""
    return [
        (_parameter(effect, name, r.unit), [_interval(one[effect][name]) for one in groups])
        for effect, group in groups[0].items()
        for name, r in group.items()
    ]


def _parameter(effect: str, name: str, unit: str) -> str:
    """One parameter in words: whose it is, its spring, its unit."""
    name, _, spring = name.replace("gain_error.", "").partition(".")
    words = name.replace("stiffness_", OF_SPRING) if name.startswith("stiffness_") else parameter_name(name).words
    words = "damping c" if name == "c_Ns_per_m" else words
    start = "" if effect == "water" else f"{effect_words((effect,))}: "
    return f"{start}{words}{f', spring {spring}' if spring else ''}{'' if unit == '1' else f', {printed_unit(unit)}'}"


def _interval(r: Range) -> str:
    middle, low, high = (rounded(value) if 1e-4 <= abs(value) < 1e6 else plain_number(value, 3) for value in (
        r.value, r.low, r.high
    ))  # fmt: skip
    return f"{middle} ({low} to {high})"


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
    label = effect_words(weight.rival.effects, weight.rival.water)
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
        axes.text(0.4, i, _percent(weight.probability), va="center", ha="left", fontsize=7.5)
    axes.set_yticks(range(len(weights)), [effect_words(w.rival.effects, w.rival.water) for w in weights])
    axes.set_xlim(max(min(gaps), -40.0) * 1.05 - 0.5, 0.0)
    axes.set_xlabel("log evidence below the best (cut at \N{MINUS SIGN}40); right: probability")
    axes.grid(axis="y", visible=False)
    axes.margins(x=0.1)
    return axes


def _percent(probability: float) -> str:
    """A probability in per cent, never as certain, in tables, sentences and figures alike.

    >>> _percent(0.6449), _percent(0.9997), _percent(0.999), _percent(1e-30), _percent(0.00509)
    ('64.5 %', 'above 99.9 %', '99.9 %', 'below 0.001 %', '0.51 %')
    """
    if probability > 0.999:
        return "above 99.9 %"
    return f"{100.0 * probability:.{3 if probability > 0.1 else 2}g} %" if probability > 1e-5 else "below 0.001 %"


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
    axes.set(xlabel="linear damping of the water, N s/m", ylabel="friction beyond the dry one, N")
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
