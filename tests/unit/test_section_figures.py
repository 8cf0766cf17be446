"""Figures of a group's section: what they draw is what was found, and they are left out where they say nothing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.text import Text

from tests.findings_fixture import named, small_findings
from undertow.comparison.tail import Histogram
from undertow.discrepancy.energy import EnergyBudget
from undertow.discrepancy.findings import GroupFindings
from undertow.discrepancy.verdict import Described, Rejected
from undertow.quantities import Estimate
from undertow.report import fit_figures, mismatch_figures
from undertow.report.captions import captions, quality_rows
from undertow.report.group_figures import group_figures, marked_lines, one_trial
from undertow.report.style import GREEN, INK, NOT_EXPLAINED, in_theme, new_figure, page_style

TWO = Described(
    parameters={"added_mass_kg": Estimate(500.0, 10.0, unit="kg"), "drag_coefficient": Estimate(2.0, 0.5, unit="1"),
                "mu": Estimate(0.1, math.nan)},
    correlations={"added_mass_kg": {"drag_coefficient": -0.95}, "drag_coefficient": {"added_mass_kg": -0.95},
                  "mu": {"added_mass_kg": 0.1}},
)  # fmt: skip


def dry() -> GroupFindings:
    return small_findings().groups[0]


def wet() -> GroupFindings:
    return named(small_findings().groups[1])


@pytest.fixture
def axes() -> Iterator[Axes]:
    with page_style():
        yield new_figure(5.0, 3.0).subplots()


def test_the_energy_bars_are_shares_of_the_first_energy_and_green_is_what_was_found() -> None:
    lost = {"coulomb_friction": np.array([1.0, 0.5]), "hidden_resonator": np.array([3.0, -1.5])}
    budget = EnergyBudget(np.arange(2.0), np.array([10.0, 6.0]), np.array([4.0, -1.0]), lost, np.array([0.1, 0.1]))
    with page_style():
        figure = mismatch_figures.draw_energy(budget, ["hidden_resonator"], new_figure(11.0, 2.3))
    stacks = [c for c in figure.axes[0].containers if c.get_label() != "lost, measured"]
    bars = {c.get_label(): [p.get_height() for p in c.patches] for c in stacks}
    assert bars["structure: friction"] == pytest.approx([10.0, 5.0])
    assert bars["found: hidden resonator"] == pytest.approx([30.0, -15.0])
    assert sum(p.get_facecolor() == to_rgba(GREEN) for p in figure.axes[0].patches) == 2
    said = [text.get_text() for text in figure.axes[1].texts]
    assert said == ["50 %", "50 %", "0 %"]



def test_what_an_outside_force_gives_is_not_called_unexplained() -> None:
    """It has its own size and phase in every trial, so no bar of its own: what is left holds it."""
    one = np.ones(2)
    budget = EnergyBudget(one, 4.0 * one, one, {"coulomb_friction": 1.5 * one}, 0.1 * one)
    with page_style():
        names = [
            [label.get_text() for label in figure.axes[1].get_yticklabels()]
            for found in (["external_forcing"], ["cubic_stiffness"], [])
            if (figure := mismatch_figures.draw_energy(budget, found, new_figure(11.0, 2.3)))
        ]
    friction = "structure: friction"
    assert names == [[friction, "external forcing, and what is not explained"]] + 2 * [[friction, "not explained"]]


def test_the_map_marks_the_body_and_what_was_found(axes: Axes) -> None:
    group = wet()
    trial = group.trials[3]
    lines = marked_lines(group, trial)
    assert lines["hidden resonator"] == pytest.approx(9.6 / (2.0 * math.pi))
    own = marked_lines(dry(), dry().trials[3])["body"]
    assert own == pytest.approx(math.sqrt(402036.0 / 2637.4) / (2.0 * math.pi), rel=0.02)
    mismatch_figures.draw_time_frequency(trial, lines, axes)
    said = [text.get_text() for text in axes.get_legend().get_texts()]
    assert said[1] == "hidden resonator 1.53 Hz"
    assert marked_lines(small_findings().groups[1], trial)["strongest line of the residual"] == 1.61


def test_of_a_handful_of_samples_there_is_no_map(axes: Axes) -> None:
    trial = wet().trials[0]
    few = replace(trial, t=trial.t[:20], measured=trial.measured[:20], simulated=trial.simulated[:20])
    mismatch_figures.draw_time_frequency(few, {"body": 2.0}, axes)
    assert "too few" in axes.get_title(loc="left")


def test_the_residual_force_of_a_spring_too_soft_is_red_on_one_side_and_blue_on_the_other(axes: Axes) -> None:
    group = dry()
    pairs = zip(group.equation.terms, group.equation.coefficients, strict=True)
    softer = tuple(0.9 * value if term.name == "stiffness" else value for term, value in pairs)
    wrong = replace(group, equation=replace(group.equation, coefficients=softer))
    mismatch_figures.draw_residual_force(wrong, axes)
    sides: dict[float, set[bool]] = {}
    for cell in axes.patches:
        side = math.copysign(1.0, cell.get_x() + 0.5 * cell.get_width())
        if abs(cell.get_x()) > 10.0:  # mm: the middle is noise
            sides.setdefault(side, set()).add(cell.get_facecolor()[:3] == to_rgba(NOT_EXPLAINED)[:3])
    assert sides == {1.0: {False}, -1.0: {True}}


def test_suspects_stand_in_order_and_one_with_more_evidence_but_excluded_is_red() -> None:
    others = [Rejected("relaxation", "", -20.0), Rejected("quintic_stiffness", "", 3.0), Rejected("late", "")]
    with page_style():
        figure = fit_figures.draw_suspects("hidden resonator", others, new_figure(11.0, 2.0))
    panel = figure.axes[0]
    assert [t.get_text() for t in panel.get_yticklabels()] == ["hidden resonator", "quintic stiffness", "relaxation"]
    widths = [bar.get_width() for bar in panel.patches]
    assert widths == pytest.approx([3.0 / math.log(10.0), -20.0 / math.log(10.0)])


@pytest.mark.parametrize("count", [1, 3, 4, 5])
def test_the_labels_of_many_lines_stand_between_the_map_and_its_title(axes: Axes, count: int) -> None:
    words = ["body", "hidden resonator", "hidden resonator 2", "linear damping", "external forcing"][:count]
    mismatch_figures.draw_time_frequency(
        one_trial(small_findings(), wet()), {word: 1.0 + i for i, word in enumerate(words)}, axes
    )  # fmt: skip
    axes.figure.canvas.draw()
    legend = axes.get_legend()
    title = next(c for c in axes.get_children() if isinstance(c, Text) and c.get_text().startswith("residual"))
    labels, titled, panel = (one.get_window_extent() for one in (legend, title, axes))
    beside = axes.figure.axes[1].get_tightbbox()  # the colour bar
    assert len(legend.get_texts()) == count
    assert [line.get_color() for line in axes.lines] == [INK, *[GREEN] * (count - 1)]  # the body's alone is black
    assert labels.y0 >= panel.y1 - 1.0
    assert titled.y0 >= labels.y1 - 1.0
    assert labels.x1 <= beside.x1 + 1.0


def test_small_odds_have_a_plain_axis_and_large_ones_a_logarithms() -> None:
    for most, scale in ((-9.0, "linear"), (-90.0, "symlog")):
        others = [Rejected("relaxation", "", -2.0), Rejected("late", "", most * math.log(10.0))]
        with page_style():
            figure = fit_figures.draw_suspects("hidden resonator", others, new_figure(11.0, 2.0))
        assert figure.axes[0].get_xscale() == scale
        assert not figure.axes[0].lines[0].get_clip_on()  # the diamond at zero, at the frame's edge


def test_the_pair_plot_shows_the_correlation_and_leaves_out_what_has_no_error(axes: Axes) -> None:
    assert fit_figures.pair_names(TWO) == ["added_mass_kg", "drag_coefficient"]
    fit_figures.draw_pairs(TWO, axes)
    assert [text.get_text() for text in axes.texts] == ["−0.95"]
    assert axes.texts[0].get_ha() == "right"  # the ellipse leans to the left: that corner is free
    (legend,) = axes.figure.legends
    assert [t.get_text() for t in legend.get_texts()] == ["one standard error", "two", "number: correlation"]
    ring = axes.collections[0].get_segments()[1]
    assert np.corrcoef(ring[:-1, 0], ring[:-1, 1])[0, 1] == pytest.approx(-0.95, abs=0.01)


def test_white_residuals_have_no_correlation_and_the_noises_quantiles() -> None:
    trial = dry().trials[3]
    with page_style():
        figure = fit_figures.draw_noise(trial, 0.5, new_figure(11.0, 2.4))
    correlation = figure.axes[0].lines[0].get_ydata()
    assert correlation[0] == pytest.approx(1.0)
    line, points = figure.axes[1].lines
    slope = np.polyfit(points.get_xdata(), points.get_ydata(), 1)[0]
    assert slope >= 0.9 * np.polyfit(line.get_xdata(), line.get_ydata(), 1)[0]


def test_friction_is_drawn_against_other_numbers_only_where_trials_have_their_own() -> None:
    group = dry()
    panels = fit_figures.friction_panels(group)
    assert "damping" in panels
    assert "hold" not in panels  # the fixture's holds are alike
    mean = {"mu": Estimate(0.0068, 1e-4)}
    held = tuple(
        replace(t, fits={"output_error": replace(t.fits["output_error"], parameters=mean)}) for t in group.trials
    )
    assert "damping" not in fit_figures.friction_panels(replace(group, trials=held))
    with page_style():
        figure = fit_figures.draw_friction(group, panels, new_figure(11.0, 2.6))
    assert len(figure.axes) == len(panels)


def test_a_rest_position_that_is_poorly_known_does_not_widen_the_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    group = dry()
    monkeypatch.setattr(fit_figures, "_resting", lambda _: 1e-4)
    unsure = replace(group.trials[0].motion.equilibrium, stderr=1.0)  # a metre
    first = replace(group.trials[0], motion=replace(group.trials[0].motion, equilibrium=unsure))
    heights = []
    for trials in (group.trials, (first, *group.trials[1:])):
        with page_style():
            figure = fit_figures.draw_friction(replace(group, trials=trials), ["rest"], new_figure(11.0, 2.6))
        heights.append(figure.axes[0].get_ylim()[1])
        assert "held by friction" in figure.axes[0].get_legend().get_texts()[0].get_text()
    assert heights[1] == pytest.approx(heights[0], rel=0.5)


def test_captions_name_the_held_out_trial_and_the_equation_that_is_believed() -> None:
    findings = small_findings()
    said = captions(replace(findings, groups=(dry(), wet())), wet())
    trial = one_trial(findings, wet())
    assert trial is not None
    assert f"{trial.motion.name} (held out)" in said["energy"]
    assert "repaired equation" in said["energy"]
    assert "the green line is the repaired equation" in said["where"]
    assert "green" not in captions(findings, dry())["where"]
    assert "prescribed equation" in captions(findings, dry())["noise"]


def test_quality_rows_say_rate_hold_and_what_was_changed() -> None:
    group = dry()
    noted = replace(group.trials[0].motion, notes=("one.", "two", "three", "four"))
    row = quality_rows(replace(group, trials=(replace(group.trials[0], motion=noted),)))[0]
    assert (row["rate"], row["hold"], row["notes"]) == ("100", "0.00", "one; two; three; 1 more")
    assert row["noise"] == "displacement 0.20 mm"


def test_colours_of_a_figure_follow_the_pages_theme() -> None:
    assert in_theme("stroke: #d55e00; fill: #123456") == "stroke: var(--fig-alarm); fill: #123456"


@pytest.mark.parametrize(("own", "words", "alarm"), [(3.0, "it could be one of them", False), (60.0, "missing", True)])
def test_the_replicas_histogram_marks_the_level_and_says_what_it_means(own: float, words: str, alarm: bool) -> None:
    scores = Histogram.of(np.random.default_rng(0).exponential(3.0, 1000), own, 14.0)
    assert scores is not None
    group = wet()
    verdict = replace(group.verdict, null=scores, p_value=0.3 if own < 14.0 else 1e-6)
    with page_style():
        figure = fit_figures.draw_null(scores, verdict.p_value, new_figure(11.0, 2.3))
    place = next(line for line in figure.axes[0].lines if "this level" in str(line.get_label()))
    assert place.get_xdata()[0] == pytest.approx(own / math.log(10.0))
    assert figure.axes[0].get_xlim()[0] < own / math.log(10.0) < figure.axes[0].get_xlim()[1]
    assert (place.get_color() == NOT_EXPLAINED) is alarm
    said = captions(small_findings(), replace(group, verdict=verdict))["null"]
    assert said.startswith("1000 simulated replicas")
    assert words in said
    drawn = group_figures(small_findings(), replace(group, verdict=verdict), ())
    assert "null" in drawn
    assert "null" not in group_figures(small_findings(), group, ())


@pytest.mark.parametrize("scores", [[0.0, 0.0], [5.0, 5.0], [0.0, 1e-3, 10.0]])
def test_a_histogram_counts_every_replica(scores: list[float]) -> None:
    found = Histogram.of(np.array(scores), 1.0, 2.0)
    assert (found is None) is (max(scores) == 0.0)
    if found is not None:
        assert sum(found.counts) == len(scores)
        assert np.all(np.diff(found.edges) > 0.0)
