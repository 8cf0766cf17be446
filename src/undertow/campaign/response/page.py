"""What the page of harmonic sets shows: sentences, how sure they are, points beside the equations swept, tables.

Belongs here: those parts, from what was found. Does not belong here: curves (curves.py), the page's shape
(report/driven_page.py), the run (run.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.campaign.driven.page import tried_rows
from undertow.campaign.response.curves import drawn_sets
from undertow.campaign.response.sets import Sweeps
from undertow.comparison.response_search import DEVIATIONS, ResponseFound
from undertow.discrepancy.words import count, percent
from undertow.methods.harmonic_set import HarmonicFit
from undertow.report.driven_figures import DrawnSet, draw_set
from undertow.report.driven_page import HARMONIC, PagePart, PageTable, Picture, WrittenEquation, verdict_of
from undertow.report.html import FIRST_IN
from undertow.report.style import new_figure, page_style, svg_text
from undertow.report.trial_figures import drawn_as
from undertow.report.wording import p_words

DRAWN_AT_MOST = 12
"""Trials of a group that the page draws."""

WIDTH_IN, HEIGHT_IN = 11.0, 5.2
"""A figure over the whole page, inch."""

UNSEEN = "points that no fit had seen"


def page_part(config: RunConfig, group: Sweeps, found: ResponseFound, entry: Mapping[str, Any], said: str) -> PagePart:
    """One group's part of the page; ``entry`` is its group of verdict.json, ``said`` its sentence."""
    held_back = bool(np.any(found.unseen))
    unseen = UNSEEN if held_back else "the points that were fitted"
    drawn = drawn_sets(config, group, found, DRAWN_AT_MOST)
    first = max(drawn, key=_gained)
    with page_style():
        pictures = [Picture(svg_text(draw_set(one, new_figure(WIDTH_IN, HEIGHT_IN))), _caption(one)) for one in drawn]
        figure = svg_text(draw_set(first, new_figure(*FIRST_IN), phases=False))
    return PagePart(
        verdict_of(entry), said, sure_words(found, unseen), written(found.baseline, group),
        None if found.augmented is None else written(found.augmented, group), _numbers(found, entry, unseen),
        Picture(figure, _caption(first, phases=False)), pictures, _tables(config, found), unseen=unseen,
        measured="Measured points beside the equation swept", rotation=config.equation.coordinate == "rotation",
    )  # fmt: skip


def written(fit: HarmonicFit, group: Sweeps) -> WrittenEquation:
    """A fit's equation with its numbers."""
    mover = group.measured.mover
    return WrittenEquation(fit.terms, fit.numbers, HARMONIC[mover], mover)


def sure_words(found: ResponseFound, unseen: str) -> str:
    """How sure an answer is, by what the run computed."""
    start = "no probability is computed for harmonic sets. "
    left = f"Noise alone would leave what is left, or more, with {p_words(found.p_value)}"
    if found.unchecked:
        return f"{start}No law was tried, so that nothing is claimed. {left}."
    laws = count(len({one.name for one in found.tried}), "law")
    if not found.added:
        return f"{start}{laws} were tried, and none comes surely closer to {unseen}. {left}."
    return (
        f"{start}What was added brings the equation closer to {unseen}, and surely closer to points left out in turn "
        f"({DEVIATIONS:g} standard errors are asked for); of {laws} tried. {left}."
    )


def _numbers(found: ResponseFound, entry: Mapping[str, Any], unseen: str) -> list[tuple[str, str, str]]:
    """The numbers of the first screen."""
    held = entry["baseline"]["held_out_nrmse"]
    before = entry["baseline"]["nrmse"] if held is None else held
    what = "error of the equation as prescribed" if found.added else "error of the equation"
    loud = "alarm" if found.added or entry["status"] == "unknown" else ""
    numbers = [(percent(before), f"{what}, at {unseen}", loud)]
    if found.added:
        numbers.append((percent(entry["augmented"]["held_out_nrmse"]), "error of the repaired equation, there", "good"))
    if math.isfinite(found.p_value):
        words = "how often noise alone would leave what is left, or more"
        numbers.append((p_words(found.p_value), words, "" if found.adequate else "alarm"))
    return numbers


def _gained(one: DrawnSet) -> float:
    """By how much what is left of a trial's points falls, over their motion; what is left where nothing was added."""
    sizes = [float(np.sqrt(np.mean(left**2))) for left in one.left]
    return (sizes[0] - sizes[-1] if len(sizes) > 1 else sizes[0]) / float(np.sqrt(np.mean(one.amplitude**2)))


def _caption(one: DrawnSet, phases: bool = True) -> str:
    ways = bool(one.rising.any()), not one.rising.all()
    triangles = "triangles are measured, as the frequency went (up or down)"
    hollow = ", hollow where no fit saw them" if one.unseen.any() else ""
    green = ", green the repaired one" if len(one.left) > 1 else ""
    lines = "; dashed where the frequency went down" if all(ways) else ""
    fitted = "fitted to the filled ones" if one.unseen.any() else "fitted to them"
    both = "amplitude and phase of the motion against the drive" if phases else "amplitude of the motion"
    return (
        f"Trial {one.name}, {count(one.amplitude.size, 'point')}, {both}: {triangles}{hollow}. Lines: blue the "
        f"equation as prescribed{green}, {fitted}, swept as the frequency was{lines}. Below: "
        "amplitude of measured minus equation, a point each, on a logarithmic axis."
    )


def _tables(config: RunConfig, found: ResponseFound) -> Sequence[PageTable]:
    """What was tried."""
    if not found.tried:
        return []
    shown = drawn_as("displacement", config.equation.coordinate)
    note = (
        "RMS of measured minus equation, of the cosine and sine parts at points that no fit had seen, without and with "
        "the law. Numbers in a reason are in SI units."
    )
    rows = tried_rows(found.tried, shown.factor, shown.unit)
    return [PageTable("What was tried, on points nobody fitted", rows, note)]
