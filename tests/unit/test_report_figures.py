"""Figures of a report: every trial and every number is drawn where it belongs, with its unit, whatever is missing."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import same_color
from matplotlib.lines import Line2D

from tests.findings_fixture import bare_findings, make_findings, small_findings
from undertow.discrepancy.findings import GroupFindings
from undertow.quantities import Estimate
from undertow.report import figures, trial_figures
from undertow.report.style import NOT_EXPLAINED, method_colour, new_figure, page_style, plain_log_ticks, svg_text


@pytest.fixture
def axes() -> Iterator[Axes]:
    with page_style():
        yield new_figure(5.0, 3.0).subplots()


def dry() -> GroupFindings:
    return small_findings().groups[0]


def wet() -> GroupFindings:
    return small_findings().groups[1]


def markers(axes: Axes) -> list[tuple[float, float]]:
    """Places of all single points on the axes."""
    lines = [line for line in axes.get_lines() if len(line.get_xdata()) == 1]
    return [(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in lines]


# ---------------------------------------------------------------- parameters
def test_each_methods_value_stands_at_its_level(axes: Axes) -> None:
    findings = make_findings()
    assert figures.draw_against_level(findings, "added_mass_kg", axes) is axes
    assert axes.get_xlabel() == "water depth (m)"
    assert axes.get_ylabel() == "added mass $m_a$ (kg)"
    drawn = {round(y, 6) for _, y in markers(axes)}
    wanted = [g.fits[m].parameters["added_mass_kg"].value for g in findings.groups if not g.dry for m in g.fits]
    printed = [g.fits["method2_printed"].parameters["added_mass_kg"].value for g in findings.groups if not g.dry]
    for value in set(wanted) - set(printed):
        assert round(value, 6) in drawn
    for value in printed:
        assert round(value, 6) not in drawn


def test_without_a_numeric_condition_groups_stand_side_by_side_by_name(axes: Axes) -> None:
    findings = small_findings()
    keys = ({"spring": "long"}, {"spring": "short"})
    named = tuple(replace(wet(), key=key) for key in keys)
    figures.draw_against_level(replace(findings, groups=named), "drag_coefficient", axes)
    assert [label.get_text() for label in axes.get_xticklabels()] == ["spring long", "spring short"]
    assert axes.get_ylabel() == "drag coefficient $C_d$ (-)"


def test_a_negative_added_mass_is_on_the_axis_with_zero_marked(axes: Axes) -> None:
    value = wet().fits["output_error"].parameters["added_mass_kg"].value
    assert value < 0.0
    figures.draw_against_level(small_findings(), "added_mass_kg", axes)
    low, high = axes.get_ylim()
    assert low < value < 0.0 < high
    assert any(list(line.get_ydata()) == [0.0, 0.0] for line in axes.get_lines())


def test_an_estimate_on_a_bound_is_hollow(axes: Axes) -> None:
    assert wet().fits["method1"].parameters["added_mass_kg"].outcome != "ok"
    figures.draw_against_level(small_findings(), "added_mass_kg", axes)
    (bound,) = [line for line in axes.get_lines() if list(line.get_ydata()) == [0.0]]
    assert bound.get_markerfacecolor() == "white"


def test_a_value_far_from_all_others_is_an_arrow_and_hides_none(axes: Axes) -> None:
    far = replace(wet().fits["sindy"], parameters={"added_mass_kg": Estimate(9e6, 1.0, unit="kg")})
    group = replace(wet(), fits={**wet().fits, "sindy": far})
    figures.draw_against_level(replace(small_findings(), groups=(group,)), "added_mass_kg", axes)
    assert axes.get_ylim()[1] < 1e4
    assert [line.get_marker() for line in axes.get_lines()].count("^") == 1


def test_every_trial_and_method_is_drawn_against_amplitude(axes: Axes) -> None:
    figures.draw_against_amplitude(small_findings(), [wet()], "added_mass_kg", axes)
    methods = figures.compared_methods([wet()], "added_mass_kg")
    assert len(methods) == 4
    assert len(markers(axes)) == len(methods) * len(wet().trials)
    assert axes.get_xlabel() == "release amplitude (mm)"
    for x, _ in markers(axes):
        nearest = min(abs(x / (trial.motion.amplitude * 1e3) - 1.0) for trial in wet().trials)
        assert nearest < 0.09  # set side by side, by 5 % a method


def test_agreement_leaves_the_printed_recipe_out(axes: Axes) -> None:
    figures.draw_agreement(wet(), "drag_coefficient", axes)
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert labels == ["SINDy", "Method 1", "Method 2", "Output error"]
    assert axes.get_xlabel() == "drag coefficient $C_d$ (-)"


def test_intervals_are_one_and_two_standard_errors(axes: Axes) -> None:
    figures.draw_agreement(wet(), "drag_coefficient", axes)
    estimate = wet().fits["output_error"].parameters["drag_coefficient"]
    own = [line for line in axes.get_lines() if same_color(line.get_color(), method_colour("output_error"))]
    widths = sorted(float(np.ptp(line.get_xdata())) for line in own)
    assert widths == pytest.approx([0.0, 2.0 * estimate.total_stderr, 4.0 * estimate.total_stderr])


def test_errors_that_are_all_nan_are_drawn_as_hollow_points_without_bars(axes: Axes) -> None:
    findings = bare_findings()
    figures.draw_agreement(findings.groups[0], "c_Ns_per_m_per_mass", axes)
    (point,) = [line for line in axes.get_lines() if line.get_marker() == "o"]
    assert point.get_markerfacecolor() == "white"
    assert all(math.isfinite(limit) for limit in axes.get_xlim())


# ---------------------------------------------------------------- mismatch
def test_every_trials_error_is_drawn_and_the_unexplained_ones_in_their_colour(axes: Axes) -> None:
    figures.draw_mismatch(small_findings(), wet(), axes)
    wanted = {(t.motion.amplitude * 1e3, 100.0 * t.mismatch.nrmse) for t in wet().trials}
    assert set(markers(axes)) == wanted
    points = [line for line in axes.get_lines() if len(line.get_xdata()) == 1]
    assert all(same_color(point.get_color(), NOT_EXPLAINED) for point in points)
    assert [point.get_markerfacecolor() for point in points].count("white") == 1  # the one held out


def test_the_error_axis_starts_at_half_the_smallest_value(axes: Axes) -> None:
    figures.draw_mismatch(small_findings(), wet(), axes)
    smallest = min(t.mismatch.sensor_floor_nrmse for t in wet().trials)
    assert axes.get_ylim()[0] == pytest.approx(50.0 * smallest)
    assert axes.get_ylim()[1] > 100.0 * max(t.mismatch.nrmse for t in wet().trials)


def test_a_mismatch_without_floors_and_without_error_is_drawn(axes: Axes) -> None:
    findings = bare_findings()
    figures.draw_mismatch(findings, findings.groups[0], axes)
    axes.figure.canvas.draw()  # type: ignore[union-attr]
    assert axes.get_ylim()[0] > 0.0


def test_a_legend_never_runs_over_the_pages_width() -> None:
    for labels in (["Method 1"] * 9, ["a spring with a very long name indeed"] * 6, ["x" * 400], []):
        columns = figures.legend_columns(labels)
        widest = max((len(label) for label in labels), default=0) + 6
        assert columns == 1 or columns * widest <= figures.LEGEND_LETTERS


# ---------------------------------------------------------------- curves
def test_measured_and_free_run_are_drawn_with_units_and_what_is_allowed(axes: Axes) -> None:
    trial = wet().trials[0]
    trial_figures.draw_free_run(trial, axes)
    measured, run = axes.get_lines()
    assert np.max(measured.get_ydata()) == pytest.approx(1e3 * np.max(trial.measured))
    assert np.min(run.get_ydata()) == pytest.approx(1e3 * np.min(trial.simulated))
    assert (axes.get_ylabel(), axes.get_xlabel()) == ("displacement\n(mm)", "time after release (s)")
    assert axes.get_title(loc="left") == "8 mm · error 69 % (allowed 45 %) · NOT EXPLAINED (1.5×)"


def test_a_rate_alone_is_drawn_as_a_rate_and_an_angle_in_degrees(axes: Axes) -> None:
    findings = bare_findings(velocity_only=True, coordinate="rotation")
    trial = findings.groups[0].trials[0]
    trial_figures.draw_free_run(trial, axes)
    assert axes.get_ylabel() == "angular velocity\n(°/s)"
    assert np.max(axes.get_lines()[0].get_ydata()) == pytest.approx(np.degrees(np.max(trial.measured)))
    assert "11.5 °" in axes.get_title(loc="left")


def test_the_residual_is_measured_minus_free_run_about_zero(axes: Axes) -> None:
    trial = wet().trials[3]
    trial_figures.draw_residual(trial, axes)
    residual = axes.get_lines()[-1].get_ydata()
    assert np.max(np.abs(residual)) == pytest.approx(1e3 * np.max(np.abs(trial.measured - trial.simulated)))
    assert axes.get_ylim()[0] == -axes.get_ylim()[1]


def test_a_thinned_curve_keeps_its_ends_and_every_extreme() -> None:
    t = np.linspace(0.0, 60.0, 60_001)
    values = np.sin(40.0 * t) * np.exp(-0.05 * t)
    few, shown = trial_figures.thinned(t, values)
    assert few.size <= trial_figures.POINTS_AT_MOST
    assert (shown.min(), shown.max()) == (values.min(), values.max())
    assert np.all(np.diff(few) > 0.0)
    short = trial_figures.thinned(t[:50], values[:50])
    assert short[0].size == 50


def test_the_decay_shows_measured_and_simulated_peaks_of_every_trial(axes: Axes) -> None:
    trial_figures.draw_decay(dry(), axes)
    assert len(axes.get_lines()) == 2 * len(dry().trials)
    firsts = [float(line.get_ydata()[0]) for line in axes.get_lines()]
    for trial, measured, simulated in zip(dry().trials, firsts[::2], firsts[1::2], strict=True):
        turned = np.max(np.abs(trial.measured[6:30])) * 1e3  # mm; behind the first crossing: the window opens too late
        assert measured == pytest.approx(turned, rel=0.05)
        assert simulated == pytest.approx(measured, rel=0.1)  # 0.2 mm of noise on 6 mm
    assert axes.get_ylabel() == "peak displacement a half cycle (mm)"


def test_a_body_released_from_rest_and_a_motion_of_nothing_are_drawn_without_a_warning(axes: Axes) -> None:
    findings = bare_findings()
    group = findings.groups[0]
    trial = replace(group.trials[0], motion=replace(group.trials[0].motion, amplitude=0.0))
    still = replace(trial, measured=0.0 * trial.t, simulated=0.0 * trial.t)
    figures.draw_mismatch(findings, replace(group, trials=(trial,)), axes)
    trial_figures.draw_decay(replace(group, trials=(still,)), axes)
    assert axes.get_xscale() == "linear"


@pytest.mark.parametrize("values", [[0.13, 0.2], [1.0, 5.0, 90.0], [1e-5, 3.0, 1e4], [7.0], [690.0, 640.0, 621.0]])
def test_ticks_of_a_log_axis_are_few_and_plain(axes: Axes, values: list[float]) -> None:
    axes.set_yscale("log")
    axes.plot(range(len(values)), values)
    plain_log_ticks(axes.yaxis, values)
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert 1 <= len(labels) <= 5
    assert [float(label) for label in labels] == pytest.approx(list(axes.get_yticks()), rel=1e-5)
    assert len(axes.yaxis.get_minorticklocs()) == 0


@pytest.mark.parametrize("values", [[2e-9, 3e-6], [1e6, 4e8], [1.234e-7, 1.31e-7]])
def test_ticks_of_very_small_and_large_sizes_are_powers_of_ten_without_an_e(axes: Axes, values: list[float]) -> None:
    axes.set_yscale("log")
    axes.plot(range(len(values)), values)
    plain_log_ticks(axes.yaxis, values)
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert labels
    assert all("10" in label and "e" not in label for label in labels), labels
    small = new_figure(3.0, 2.0).subplots()
    small.plot([0.0, 1.0], [0.0, 3e-7])
    small.figure.canvas.draw()
    assert "1e" not in small.yaxis.get_offset_text().get_text()


# ---------------------------------------------------------------- SVG
def test_coordinates_are_rounded_by_less_than_a_tenth_of_a_point() -> None:
    with page_style():
        figure = new_figure(2.0, 2.0)
        points = ([0.0, 0.123456, 1.0], [0.0, 0.987654, 1.0])
        figure.add_artist(Line2D(*points, color="#123456"))
        svg = svg_text(figure)
    path = re.search(r'd="([^"]*)"[^>]*#123456', svg)
    assert path is not None
    numbers = [float(n) for n in re.findall(r"-?[\d.]+", path.group(1))]
    assert numbers == pytest.approx([0.0, 144.0, 144 * 0.123456, 144 * (1 - 0.987654), 144.0, 0.0], abs=0.0501)


def test_a_published_value_is_a_line_where_it_is_near_and_left_out_where_it_would_squash_the_rest() -> None:
    group = small_findings().groups[1]
    near = next(iter(group.fits["sindy"].parameters.values())).value
    name = next(iter(group.fits["sindy"].parameters))
    for value, lines in ((near, 1), (1e3 * abs(near), 0)):
        known = replace(group, specimen=replace(group.specimen, published=((name, value),)))
        with page_style():
            axes = new_figure(5.0, 2.0).subplots()
            figures.draw_agreement(known, name, axes)
        drawn = [line for line in axes.lines if line.get_linestyle() == "-."]
        assert len(drawn) == lines
        if lines:
            assert drawn[0].get_xdata()[0] == value
            assert axes.get_xlim()[0] < value < axes.get_xlim()[1]
