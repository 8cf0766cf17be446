"""The page: one self-contained report.html from finished findings, and the figures as files beside it.

Belongs here: which figures there are, and the page's making. Does not belong here: what it says (blocks.py), drawing
(figures.py, trial_figures.py), any computation.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from markupsafe import Markup, escape

from undertow.discrepancy.findings import Findings, GroupFindings
from undertow.report import blocks, figures, first_screen, trial_figures
from undertow.report.arrange import spanning_conditions
from undertow.report.captions import captions, scattering_words
from undertow.report.drawing import without_collection
from undertow.report.explorer import explorer_block
from undertow.report.extent import Extent, extent_of
from undertow.report.group_figures import WIDTH_IN, group_figures, row_of
from undertow.report.style import in_theme, new_figure, page_style, svg_text
from undertow.report.wording import in_plain_words
from undertow.report.writing import rendered, write_text

LEVEL_PARAMETERS = ("added_mass_kg", "drag_coefficient")
"""Parameters drawn against level and amplitude where they were found: those the water has."""

FIRST_IN = (5.6, 3.9)
"""Width and height of the picture on the first screen, inch: its letters stay legible on a phone."""

ROWS_AT_MOST = 500
"""Trials that could not be used, and notes, that a page lists: all stand in trials.csv and manifest.json."""

CAMPAIGN = "campaign"
"""First part of the name of a figure over all groups; of a group's it is the group's anchor."""

SEPARATOR = "--"
"""Between a figure's two parts; no anchor holds it."""

RESERVED_ANCHORS = frozenset({"campaign", "first", "overview", "failed", "made"})
"""Anchors of the page's own parts."""

ANCHOR_AT_MOST = 60
"""Letters of an anchor: it is also a file's name."""


def safe_anchor(text: str) -> str:
    """A text as an anchor of a page: lower case letters, digits and single dashes.

    >>> safe_anchor("spring short, water depth 2.36 m")
    'spring-short-water-depth-2-36-m'
    """
    return re.sub(r"[^a-z0-9]+", "-", text.lower())[:ANCHOR_AT_MOST].strip("-") or "group"


def anchors(texts: Sequence[str]) -> list[str]:
    """One anchor a text, numbered where two would be alike.

    >>> anchors(["depth 2.3", "depth 2,3", "水"])
    ['depth-2-3', 'depth-2-3-2', 'group']
    """
    out: list[str] = []
    for text in texts:
        plain = safe_anchor(text)
        free = (f"{plain}-{number}" for number in itertools.count(2))
        out.append(plain if plain not in {*out, *RESERVED_ANCHORS} else next(a for a in free if a not in out))
    return out


class Each(Protocol):
    """``work(item)`` for every item, in order: on several processes, where the caller has some."""

    def __call__(self, work: Callable[[Any], Any], items: Sequence[Any]) -> list[Any]:
        """The results in the items' order."""


def one_by_one(work: Callable[[Any], Any], items: Sequence[Any]) -> list[Any]:
    """`Each` in this process."""
    return [work(item) for item in items]


def write_report(
    findings: Findings,
    folder: Path,
    manifest: Mapping[str, Any],
    extent: Extent | None = None,
    each: Each = one_by_one,
) -> Path:
    """Write ``report.html`` and ``figures/*.svg`` into the run folder; the page's path.

    ``manifest`` is the run's provenance; its ``config_text`` is shown escaped. Every text that came from files or the
    config is escaped by the template. ``extent`` says how much the campaign holds, where the findings are a part of it;
    ``each`` draws the groups' figures.
    """
    with page_style():
        drawn = page_figures(findings, each)
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
    names = anchors([group.label for group in findings.groups])
    pairs, inline = zip(findings.groups, names, strict=True), Inliner(drawn)
    return rendered(
        "report.html.j2",
        name=findings.name,
        across=in_plain_words(findings.across_groups),
        doubts=[doubt.rstrip(".") for doubt in findings.doubts],
        first=first_screen.first_screen(findings, names),
        groups=[
            {**blocks.group_block(findings, group, name, inline.part(name), whole), **captions(findings, group)}
            for group, name in pairs
        ],
        overview=blocks.overview(findings, names, whole),
        figures=inline.part(CAMPAIGN),
        failed=failed,
        more_failed=more_failed,
        notes=notes,
        more_notes=more_notes,
        manifest=blocks.provenance(manifest),
        methods=blocks.method_notes(findings),
        config_text=escape(manifest.get("config_text", "")),
        counts=blocks.counts(findings, whole),
        scattering=scattering_words(findings),
        shown=blocks.shown_of(findings, whole),
        explorer=explorer_block(findings, names),
    )


def page_figures(findings: Findings, each: Each = one_by_one) -> dict[str, str]:
    """Every figure of the page as SVG text, by name: CAMPAIGN or a group's anchor, SEPARATOR, what it shows."""
    drawn = {}
    if shown := first_screen.shown_trial(findings):
        figure = trial_figures.draw_first(shown.trial, new_figure(*FIRST_IN), shown.repaired)
        drawn[f"{CAMPAIGN}{SEPARATOR}first"] = svg_text(figure)
    parameters = [p for p in LEVEL_PARAMETERS if figures.compared_methods(findings.groups, p)]
    if spanning_conditions(findings).level is not None and parameters and len(findings.groups) > 1:
        figure = new_figure(WIDTH_IN, 3.6)
        for parameter, axes in zip(parameters, row_of(figure, len(parameters)), strict=True):
            figures.draw_against_level(findings, parameter, axes)
        figures.method_legend(findings, parameters, figure)
        drawn[f"{CAMPAIGN}{SEPARATOR}levels"] = svg_text(figure)
    names = anchors([group.label for group in findings.groups])
    work = [_alone(findings, group) for group in findings.groups]
    for name, of_group in zip(names, each(_GroupFigures(tuple(parameters)), work), strict=True):
        for kind, svg in of_group.items():
            drawn[f"{name}{SEPARATOR}{kind}"] = svg
    return drawn


@dataclass(frozen=True)
class _GroupFigures:
    """Draws one group's figures; picklable for worker processes."""

    parameters: tuple[str, ...]

    def __call__(self, one: tuple[Findings, GroupFindings]) -> dict[str, str]:
        with page_style(), without_collection():
            return group_figures(*one, self.parameters)


def _alone(findings: Findings, group: GroupFindings) -> tuple[Findings, GroupFindings]:
    """A group, and the findings without the other groups' trials: what a worker needs, and no more to send."""
    others = tuple(one if one is group else replace(one, trials=()) for one in findings.groups)
    return replace(findings, groups=others, failed=(), notes=()), group


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
        return {kind: Markup(_GLYPH.sub(self._once, in_theme(svg[svg.index("<svg") :]))) for kind, svg in own.items()}

    def _once(self, found: re.Match[str]) -> str:
        outline = found.group()
        if outline in self._defined:
            return ""
        self._defined.add(outline)
        return outline
