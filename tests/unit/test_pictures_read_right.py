"""What stands in a picture is true of it: names of lines and of zero, peaks, numbers and places of labels."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tests.browser import BROWSER, REASON, Page, browser
from tests.findings_fixture import named, small_findings
from tests.unit.test_report_first_screen import named_findings
from undertow.discrepancy.energy import EnergyBudget
from undertow.discrepancy.findings import AugmentedRun, GroupFindings
from undertow.discrepancy.verdict import Gate, Rejected, Verdict
from undertow.report import captions as texts
from undertow.report import fit_figures
from undertow.report.captions import captions
from undertow.report.html import write_report
from undertow.report.small_multiples import MOTION, RESIDUAL, draw_free_runs
from undertow.report.style import new_figure, page_style
from undertow.report.trial_figures import draw_decay, half_cycle_peaks

OTHERS = (Rejected("hidden_resonator", "", 11.0), Rejected("relaxation", "", -300.0))


def wet(verdict: Verdict | None = None) -> GroupFindings:
    """A group whose trials have a free run with more than the equation."""
    group = small_findings().groups[1]
    run = [AugmentedRun(0.02, 0.1 * (t.measured - t.simulated)) for t in group.trials]
    trials = tuple(replace(t, augmented=one) for t, one in zip(group.trials, run, strict=True))
    return replace(group, trials=trials, verdict=verdict or group.verdict)


def nothing_said(best: str, rejected: tuple[Rejected, ...] = OTHERS) -> Verdict:
    """A verdict that names nothing, with the evidence of the ``best`` or the strongest set of suspects."""
    gate = Gate("evidence", f"log odds of {best} over nothing", 43.0, 4.6, True)
    return replace(
        wet().verdict, status="unknown", verdict=("unknown",), augmented=None, rejected=rejected, decision=(gate,)
    )


def said_in(figure: Figure) -> list[str]:
    """All texts of a figure that has been drawn."""
    FigureCanvasAgg(figure).draw()
    found = [t.get_text() for axes in figure.axes for t in axes.texts]
    found += [t.get_text() for legend in figure.legends for t in legend.get_texts()]
    return found + [axes.get_title(loc="left") for axes in figure.axes]


# ---------------------------------------------------------------- odds
def test_the_odds_zero_is_what_they_are_beside() -> None:
    assert fit_figures.odds_beside(nothing_said("stiffness_drift")) == "stiffness drift (closest, not said)"
    assert fit_figures.odds_beside(nothing_said("a_law+a_law+relaxing")) == "2 a laws + relaxing (closest, not said)"
    assert fit_figures.odds_beside(nothing_said("relaxation")) == "the equation as it is"  # it has odds of its own
    assert fit_figures.odds_beside(replace(nothing_said("x"), decision=())) == "the equation as it is"
    found = replace(nothing_said("stiffness_drift"), status="explained", verdict=("stiffness_drift",))
    assert fit_figures.odds_beside(found) == "stiffness drift"
    unproved = replace(found, status="unknown", verdict=("stiffness_drift", "unknown"))
    assert fit_figures.odds_beside(unproved) == "stiffness drift (closest, not proved)"


def test_axis_mark_and_caption_of_the_odds_name_the_same_zero() -> None:
    group = wet(nothing_said("stiffness_drift"))
    zero = "stiffness drift (closest, not said)"
    with page_style():
        figure = fit_figures.draw_suspects(zero, OTHERS, new_figure(11.0, 2.0))
    axes = figure.axes[0]
    assert axes.get_yticklabels()[0].get_text() == zero
    assert axes.get_xlabel() == f"log10 of the odds beside {zero}"
    assert captions(small_findings(), group)["suspects"].startswith(f"Green diamond: {zero}. ")


def test_odds_have_true_minus_signs_and_no_powers() -> None:
    with page_style():
        figure = fit_figures.draw_suspects("a law", OTHERS, new_figure(11.0, 2.0))
    assert said_in(figure)[:2] == ["4.8", "\u2212130"]
    ticks = [label.get_text() for label in figure.axes[0].get_xticklabels()]
    assert {"\u2212100", "\u221210", "0"} <= set(ticks)
    assert all(re.fullmatch(r"\u2212?\d+", tick) for tick in ticks)


# ---------------------------------------------------------------- green lines
@pytest.mark.parametrize("found", [False, True])
def test_the_green_line_is_what_was_found_only_where_something_was(found: bool) -> None:
    group = wet(named(wet()).verdict if found else nothing_said("stiffness_drift"))
    words, not_said = ("with what was found", "closest") if found else ("with the closest candidate", "what was found")
    with page_style():
        decay = new_figure(5.0, 3.0)
        draw_decay(group, decay.subplots())
        figures = [draw_free_runs(group, new_figure(11.0, 5.0)), decay]
    for figure in figures:
        said = "; ".join(said_in(figure))
        assert words in said
        assert not_said not in said
    text = captions(small_findings(), group)
    left = "the repaired equation" if found else "the equation with the closest candidate"
    assert f"What {left} leaves of trial" in text["noise"]
    assert f"the green line is {left}" in text["where"]


# ---------------------------------------------------------------- peaks
def swing(end: float, start: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A swing of 1 Hz that hardly decays, from rest at zero."""
    t = np.arange(start, end, 0.005)
    return t, np.exp(-0.02 * t) * np.cos(2.0 * math.pi * t)


@pytest.mark.parametrize("end", np.arange(3.0, 4.0, 0.05))
def test_a_half_cycle_that_the_record_cuts_off_is_no_peak(end: float) -> None:
    for start in (0.0, 0.05, 0.15, 0.2):
        times, sizes = half_cycle_peaks(*swing(end, start), 0.01)
        assert sizes == pytest.approx(np.exp(-0.02 * times), rel=0.07)
        assert bool(times[0] == start) is (start < 0.1)  # a release from rest, a little late
        assert times[-1] > end - 0.8


def test_a_body_that_stops_keeps_its_last_peak() -> None:
    t = np.arange(0.0, 0.501, 0.005)
    x = 0.3 + 0.7 * np.cos(2.0 * math.pi * t)  # friction: this half swing is about 0.3, and then it holds
    for rest in (0, 3, 200):
        times, sizes = half_cycle_peaks(0.005 * np.arange(x.size + rest), np.append(x, np.full(rest, x[-1])), 0.01)
        assert times.size == 2
        assert sizes == pytest.approx([1.0, 0.4], abs=1e-3)


# ---------------------------------------------------------------- labels and numbers
def test_no_curve_runs_through_the_scales_of_a_panel() -> None:
    with page_style():
        figure = draw_free_runs(replace(wet(), trials=wet().trials[:1]), new_figure(11.0, 2.6))
    axes = figure.axes[0]
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    scales = [text for text in axes.texts if "\u00b1" in text.get_text()]
    assert len(scales) == 2
    for text in scales:
        low, high = axes.transData.inverted().transform(text.get_window_extent(canvas.get_renderer()))[:, 1]
        assert RESIDUAL[1] <= low < high <= MOTION[0]


def test_large_and_small_numbers_stand_without_an_e(monkeypatch: pytest.MonkeyPatch) -> None:
    trial = wet().trials[0]
    large = replace(
        trial, motion=replace(trial.motion, amplitude=5.04), t=trial.t + 3000.0, measured=700.0 * trial.measured,
        simulated=700.0 * trial.simulated, augmented=None,
    )  # fmt: skip
    with page_style():
        said = said_in(draw_free_runs(replace(wet(), trials=(large,)), new_figure(11.0, 2.6)))
    assert any(text.startswith("5040 mm") for text in said)
    assert not any(re.search(r"\de[+-]?\d", text) for text in said)
    budget = EnergyBudget(np.zeros(1), np.array([2.66e6]), np.array([1e6]), {}, np.array([math.nan]))
    monkeypatch.setattr(texts, "budget_of", lambda *_: budget)
    energy = captions(small_findings(), wet())["energy"]
    assert "begins with 2.66 \u00d7 10\u2076 J and loses 1 \u00d7 10\u2076 J" in energy


# ---------------------------------------------------------------- explorer
def with_speed(group: GroupFindings) -> GroupFindings:
    """The group with a second channel in every recording: a panel more for the explorer."""
    trials = []
    for trial in group.trials:
        recording = trial.motion.recording
        channels = {**recording.channels, "velocity": np.gradient(recording.channels["displacement"], recording.time)}
        motion = replace(trial.motion, recording=replace(recording, channels=channels))
        trials.append(replace(trial, motion=motion))
    return replace(group, trials=tuple(trials))


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Page]:
    if BROWSER is None:
        pytest.skip(REASON)
    findings = named_findings()
    findings = replace(findings, groups=tuple(with_speed(group) for group in findings.groups[-1:]))
    with browser() as tab:
        tab.shape(1200, 900)
        tab.open(write_report(findings, tmp_path, {}))
        tab.run('document.getElementById("explore").scrollIntoView()')
        tab.until('document.querySelector("#explore-plot .main-svg")')
        yield tab


def test_nothing_is_printed_over_the_explorers_panels_whatever_the_windows_size(page: Page) -> None:
    box = "document.querySelector('#explore-plot{}').getBoundingClientRect()"
    page.run("document.querySelector('#explore-channels input[value=velocity]').click()")
    for width in (900, 1100):
        page.shape(width, 800)
        page.until(f"Math.abs({box.format('')}.width - {box.format(' .main-svg')}.width) < 2")  # drawn anew
        ends = page.run(f"[{box.format(' .main-svg')}.bottom, {box.format(' + *')}.top]")
        assert ends[0] <= ends[1] + 1.0
        assert page.run(f"{box.format(' .main-svg')}.height") == 90 + 3 * 190
