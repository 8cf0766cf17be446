"""All trials of a group at once: a panel each, what it says, and its size."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from tests.findings_fixture import named, small_findings
from undertow.discrepancy.findings import AugmentedRun, GroupFindings
from undertow.report.small_multiples import MOTION, draw_free_runs
from undertow.report.style import INK, new_figure, page_style, svg_text


def wet() -> GroupFindings:
    return small_findings().groups[1]


def drawn(group: GroupFindings, at_most: int = 24) -> Figure:
    with page_style():
        return draw_free_runs(group, new_figure(11.0, 5.0), at_most)


@cache
def svg() -> str:
    return svg_text(drawn(wet()))


def headings(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.axes[0].texts if "error" in text.get_text()]


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_every_trial_has_a_panel_with_its_error_and_scales(count: int) -> None:
    figure = drawn(replace(wet(), trials=wet().trials[:count]))
    said = [text.get_text() for text in figure.axes[0].texts]
    assert len(headings(figure)) == count
    assert sum(text.startswith("residual ±") for text in said) == count
    assert sum("s after the release" in text for text in said) == count


def test_of_very_many_trials_the_ends_and_the_worst_are_drawn() -> None:
    many = [replace(t, mismatch=replace(t.mismatch, nrmse=0.01)) for t in wet().trials * 3]
    ordered = sorted(many, key=lambda t: t.motion.amplitude)
    ordered[5] = replace(ordered[5], mismatch=replace(ordered[5].mismatch, nrmse=9.0))
    titles = headings(drawn(replace(wet(), trials=tuple(ordered)), at_most=3))
    assert len(titles) == 3
    assert titles[0].startswith("8 mm")
    assert titles[-1].startswith("33 mm")
    assert "900 %" in titles[1]


def test_a_panels_scale_is_the_trials_largest_excursion() -> None:
    trial = wet().trials[3]
    figure = drawn(replace(wet(), trials=(trial,)))
    lines = [c for c in figure.axes[0].collections if isinstance(c, LineCollection)]
    measured = next(c for c in lines if tuple(c.get_edgecolor()[0]) == to_rgba(INK))
    heights = measured.get_segments()[0][:, 1]
    largest = max(np.max(np.abs(trial.measured)), np.max(np.abs(trial.simulated)))
    middle, half = 0.5 * sum(MOTION), 0.5 * (MOTION[1] - MOTION[0])
    assert heights.max() == pytest.approx(middle + half * trial.measured.max() / largest)
    assert f"±{1e3 * largest:.3g} mm" in [text.get_text() for text in figure.axes[0].texts]


def test_what_was_found_is_drawn_where_there_is_a_run_with_it() -> None:
    run = AugmentedRun(0.02, 0.1 * (wet().trials[0].measured - wet().trials[0].simulated))
    group = named(wet())
    repaired = replace(group, trials=(replace(group.trials[0], augmented=run),))
    bare = replace(wet(), trials=wet().trials[:1])
    assert len(drawn(repaired).axes[0].collections) == len(drawn(bare).axes[0].collections) + 2
    assert [t.get_text() for t in drawn(repaired).legends[0].get_texts()][-1] == "with what was found"


def test_the_same_figure_gives_the_same_bytes_and_names_nothing_outside() -> None:
    assert svg() == svg_text(drawn(wet()))
    assert "<metadata" not in svg()
    assert not re.search(r'(href|src)="(?!#)', svg())


def test_four_trials_of_nine_seconds_take_less_than_90_kilobytes() -> None:
    assert len(svg()) < 90_000  # twenty such groups, with all else, stay under 4 MB
