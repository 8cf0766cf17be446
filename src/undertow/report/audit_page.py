"""The files of an audit: audit.json, audit.html (self-contained) and its figures.

Belongs here: which figures there are, the page's making, writing. Does not belong here: drawing (audit_figures.py),
what is said (audit).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from markupsafe import Markup
from matplotlib.figure import Figure

from undertow.audit.findings import AuditFindings, SeriesFindings
from undertow.audit.verdicts import Range, likely, rounded
from undertow.report import audit_figures
from undertow.report.style import new_figure, page_style, svg_text
from undertow.report.writing import rendered, write_text

WIDTH_IN = 11.0
"""Width of a figure over the whole page, inch."""


def write_audit(findings: AuditFindings, folder: Path, config: Mapping[str, Any]) -> Path:
    """Write audit.json, audit.html, figures/*.svg and the resolved config into ``folder``; the page's path."""
    with page_style():
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
        figure = new_figure(0.55 * WIDTH_IN, 3.2)
        audit_figures.draw_share(share, figure.subplots())
        drawn[f"share-{i}"] = svg_text(figure)
    for i, series in enumerate(findings.series):
        if len(series.groups) == 1:
            drawn[f"series-{i}-rows"] = svg_text(_rows(series))
            drawn[f"series-{i}-open"] = svg_text(_open(series))
        else:
            drawn[f"series-{i}-resonators"] = svg_text(_resonators(findings, series))
            figure = new_figure(0.6 * WIDTH_IN, 3.0)
            audit_figures.draw_probabilities(series.answer, figure.subplots())
            drawn[f"series-{i}-probabilities"] = svg_text(figure)
    return drawn


def _rows(series: SeriesFindings) -> Figure:
    figure = new_figure(WIDTH_IN, 3.6)
    places = figure.subplots(1, 2)
    for column, axes in enumerate(places):
        audit_figures.draw_rows(series.answer, 1 - column, axes)
    handles, labels = places[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _open(series: SeriesFindings) -> Figure:
    figure = new_figure(WIDTH_IN, 3.2)
    left, right = figure.subplots(1, 2)
    audit_figures.draw_probabilities(series.answer, left)
    audit_figures.draw_mixture(series.answer, right)
    return figure


def _resonators(findings: AuditFindings, series: SeriesFindings) -> Figure:
    figure = new_figure(WIDTH_IN, 3.2)
    places = figure.subplots(1, len(series.groups), squeeze=False, sharey=True, sharex=True)[0]
    audit_figures.draw_resonators(series, findings.cells, list(places))
    for axes in places:
        axes.set_yscale("log")
    handles, labels = places[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=max(len(labels), 1), markerscale=2.0)
    return figure
