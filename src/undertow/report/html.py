"""The page: one self-contained report.html from finished findings, and the figures as files beside it.

Belongs here: which figures there are, and the page's making. Does not belong here: what it says (blocks.py), drawing
(figures.py, trial_figures.py), any computation.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from undertow.discrepancy.findings import Findings, GroupFindings
from undertow.equation.equation import Equation
from undertow.report import blocks, figures, first_screen, trial_figures
from undertow.report.arrange import excess, spanning_conditions, unexplained
from undertow.report.behind import repaired_of
from undertow.report.expressions import numeric_lines
from undertow.report.extent import Extent, extent_of
from undertow.report.style import new_figure, page_style, svg_text
from undertow.report.wording import anchors
from undertow.report.writing import write_text

LEVEL_PARAMETERS = ("added_mass_kg", "drag_coefficient")
"""Parameters drawn against level and amplitude where they were found: those the water has."""

WIDTH_IN = 11.0
"""Width of a figure over the whole page, inch."""

FIRST_IN = (5.6, 3.9)
"""Width and height of the picture on the first screen, inch: its letters stay legible on a phone."""

ROW_IN = 2.7
"""Height of one row of small multiples, inch."""

RESIDUALS_AT_MOST = 3
"""Trials of a group whose residual is drawn large: the worst explained ones."""

ROWS_AT_MOST = 500
"""Trials that could not be used, and notes, that a page lists: all stand in trials.csv and manifest.json."""

CAMPAIGN = "campaign"
"""First part of the name of a figure over all groups; of a group's it is the group's anchor."""

SEPARATOR = "--"
"""Between a figure's two parts; no anchor holds it."""


def write_report(
    findings: Findings, folder: Path, manifest: Mapping[str, Any], extent: Extent | None = None
) -> Path:  # fmt: skip
    """Write ``report.html`` and ``figures/*.svg`` into the run folder; the page's path.

    ``manifest`` is the run's provenance; its ``config_text`` is shown escaped. Every text that came from files or the
    config is escaped by the template. ``extent`` says how much the campaign holds, where the findings are a part of it.
    """
    with page_style():
        drawn = page_figures(findings)
    (folder / "figures").mkdir(exist_ok=True)
    for name, svg in drawn.items():
        write_text(folder / "figures" / f"{name}.svg", svg)
    return write_text(folder / "report.html", page(findings, drawn, manifest, extent))


def page(
    findings: Findings, drawn: Mapping[str, str], manifest: Mapping[str, Any], extent: Extent | None = None
) -> str:
    """The page as text, from finished figures (name -> SVG)."""
    whole = extent or extent_of(findings)
    failed, more_failed = blocks.first_of(findings.failed, ROWS_AT_MOST)
    notes, more_notes = blocks.first_of(findings.notes, ROWS_AT_MOST)
    environment = Environment(
        loader=PackageLoader("undertow.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    names = anchors([group.label for group in findings.groups])
    pairs, inline = zip(findings.groups, names, strict=True), Inliner(drawn)
    return environment.get_template("report.html.j2").render(
        name=findings.name,
        across=findings.across_groups,
        doubts=[doubt.rstrip(".") for doubt in findings.doubts],
        first=first_screen.first_screen(findings, names),
        groups=[blocks.group_block(findings, group, name, inline.part(name), whole) for group, name in pairs],
        overview=blocks.overview(findings, names, whole),
        figures=inline.part(CAMPAIGN),
        failed=failed,
        more_failed=more_failed,
        notes=notes,
        more_notes=more_notes,
        manifest=blocks.provenance(manifest),
        methods=blocks.method_notes(findings),
        config_text=manifest.get("config_text", ""),
        counts=blocks.counts(findings, whole),
        shown=blocks.shown_of(findings, whole),
    )


def page_figures(findings: Findings) -> dict[str, str]:
    """Every figure of the page as SVG text, by name: CAMPAIGN or a group's anchor, SEPARATOR, what it shows."""
    drawn = {}
    if shown := first_screen.shown_trial(findings):
        figure = trial_figures.draw_first(shown.trial, new_figure(*FIRST_IN), shown.repaired)
        drawn[f"{CAMPAIGN}{SEPARATOR}first"] = svg_text(figure)
    parameters = [p for p in LEVEL_PARAMETERS if figures.compared_methods(findings.groups, p)]
    if spanning_conditions(findings).level is not None and parameters and len(findings.groups) > 1:
        figure = new_figure(WIDTH_IN, 3.6)
        for parameter, axes in zip(parameters, _row(figure, len(parameters)), strict=True):
            figures.draw_against_level(findings, parameter, axes)
        figures.method_legend(findings, parameters, figure)
        drawn[f"{CAMPAIGN}{SEPARATOR}levels"] = svg_text(figure)
    names = anchors([group.label for group in findings.groups])
    for group, name in zip(findings.groups, names, strict=True):
        for kind, svg in _group_figures(findings, group, parameters).items():
            drawn[f"{name}{SEPARATOR}{kind}"] = svg
    return drawn


def _row(figure: Figure, number: int) -> Sequence[Axes]:
    return list(figure.subplots(1, number, squeeze=False)[0])


def _group_figures(findings: Findings, group: GroupFindings, parameters: Sequence[str]) -> dict[str, str]:
    """A group's figures by what they show."""
    shown = min(len(group.trials), trial_figures.PANELS_AT_MOST)
    runs = new_figure(WIDTH_IN, ROW_IN * trial_figures.panel_grid(shown)[1])
    found = [p for p in parameters if figures.compared_methods([group], p)]
    drawn = {
        "equation": equation_svg(group.equation, group.equation_errors),
        "runs": svg_text(trial_figures.draw_free_runs(group, runs)),
        "summary": _summary(findings, group, found if len(group.trials) > 1 else []),
    }
    if written := repaired_of(group):
        drawn["repaired"] = equation_svg(*written)
    if found:
        agreement = new_figure(WIDTH_IN, 2.0)
        for parameter, place in zip(found, _row(agreement, len(found)), strict=True):
            figures.draw_agreement(group, parameter, place)
        drawn["agreement"] = svg_text(agreement)
    open_trials = sorted(unexplained(group), key=excess, reverse=True)[:RESIDUALS_AT_MOST]
    if open_trials:
        residuals = new_figure(WIDTH_IN, 2.0 * len(open_trials))
        drawn["residuals"] = svg_text(trial_figures.draw_residuals(open_trials, residuals))
    return drawn


def _summary(findings: Findings, group: GroupFindings, parameters: Sequence[str]) -> str:
    """Mismatch, decay, and each parameter against amplitude, side by side under one legend."""
    summary = new_figure(WIDTH_IN, 3.4)
    axes = _row(summary, 2 + len(parameters))
    figures.draw_mismatch(findings, group, axes[0])
    trial_figures.draw_decay(group, axes[1])
    for parameter, place in zip(parameters, axes[2:], strict=True):
        figures.draw_against_amplitude(findings, [group], parameter, place)
    figures.group_legend(group, parameters, summary)
    return svg_text(summary)


def equation_svg(equation: Equation, errors: Mapping[str, float]) -> str:
    """The equation with its numbers, typeset, as SVG."""
    lines = numeric_lines(equation, errors)
    figure = new_figure(WIDTH_IN, 0.34 * len(lines) + 0.1)
    for i, line in enumerate(lines):
        figure.text(0.0, 1.0 - (i + 0.55) / len(lines), f"${line}$", fontsize=12, va="center")
    return svg_text(figure, outlines=True)


_GLYPH = re.compile(r'<path id="[^"]*" d="[^"]*" transform="[^"]*"/>\n?')
"""The outline of a letter, as a typeset equation defines it."""


class Inliner:
    """Figures as SVG elements for use inside one page, where a letter's outline is defined once for all of them."""

    def __init__(self, drawn: Mapping[str, str]) -> None:
        self._drawn = drawn
        self._defined: set[str] = set()

    def part(self, part: str) -> Mapping[str, Markup]:
        """The figures of one part of the page, by what they show."""
        start = f"{part}{SEPARATOR}"
        own = {name.removeprefix(start): svg for name, svg in self._drawn.items() if name.startswith(start)}
        return {kind: Markup(_GLYPH.sub(self._once, svg[svg.index("<svg") :])) for kind, svg in own.items()}

    def _once(self, found: re.Match[str]) -> str:
        outline = found.group()
        if outline in self._defined:
            return ""
        self._defined.add(outline)
        return outline
