"""A free run that leaves the recording takes no axis with it, and no figure of a hundred million per cent stands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.axes import Axes

from tests.findings_fixture import small_findings
from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.report import explorer, figures, mismatch_figures, small_multiples, trial_figures
from undertow.report.first_screen import first_screen
from undertow.report.style import new_figure, page_style
from undertow.report.trial_figures import RUNAWAY, leaves, reach


@pytest.fixture
def axes() -> Iterator[Axes]:
    with page_style():
        yield new_figure(5.0, 3.0).subplots()


def runaway(times: float = 1e6) -> TrialFindings:
    trial = small_findings().groups[1].trials[3]
    mismatch = replace(trial.mismatch, nrmse=times, repeatability_nrmse=0.3 * times)
    return replace(trial, simulated=times * trial.measured, mismatch=mismatch)


def said(axes: Axes) -> str:
    return " ".join(text.get_text() for text in axes.texts)


def test_an_axis_ends_at_a_multiple_of_the_measured_motion_and_says_so(axes: Axes) -> None:
    trial = runaway()
    largest = 1e3 * float(np.max(np.abs(trial.measured)))  # mm
    trial_figures.draw_free_run(trial, axes)
    assert axes.get_ylim()[1] == pytest.approx(1.1 * RUNAWAY * largest)
    assert "free run beyond 3 times the measured motion: not drawn" in said(axes)
    assert "error more than 1000 % (allowed more than 1000 %)" in axes.get_title(loc="left")
    upper, lower = trial_figures.draw_first(trial, new_figure(5.0, 4.0), repaired=False).axes
    assert upper.get_ylim()[1] == lower.get_ylim()[1] == pytest.approx(1.1 * RUNAWAY * largest)


def test_large_numbers_are_short_on_the_first_screen() -> None:
    group = replace(small_findings().groups[1], trials=(runaway(),))
    numbers = first_screen(replace(small_findings(), groups=(group,)), ["a"])["shown"]["numbers"]
    assert [one["value"] for one in numbers[:2]] == ["> 1000 %", "> 1000 %"]


def test_a_run_that_stays_is_drawn_whole(axes: Axes) -> None:
    trial = runaway(2.0)
    assert not leaves(trial)
    assert reach(trial) == pytest.approx(2.0 * np.max(np.abs(trial.measured)))
    trial_figures.draw_free_run(trial, axes)
    assert said(axes) == ""


def test_every_other_figure_of_a_run_that_leaves_keeps_its_scale(axes: Axes) -> None:
    trial = runaway()
    group: GroupFindings = replace(small_findings().groups[1], trials=(trial,))
    figures.draw_mismatch(small_findings(), group, axes)
    assert axes.get_ylim()[1] == pytest.approx(2000.0)  # per cent
    assert axes.lines[-1].get_marker() == "^"
    words = said(small_multiples.draw_free_runs(group, new_figure(11.0, 2.6)).axes[0])
    assert "beyond 3 times the measured motion: cut" in words
    curve = explorer.trial_data(trial, 4000)["curves"][1]
    drawn = curve["values"]["step"] * np.cumsum(curve["values"]["by"])
    assert np.max(np.abs(drawn)) == pytest.approx(1e3 * RUNAWAY * np.max(np.abs(trial.measured)), rel=1e-3)


def test_of_a_run_that_leaves_there_is_no_map(axes: Axes) -> None:
    mismatch_figures.draw_time_frequency(runaway(), {"body": 2.0}, axes)
    assert "leaves the recording" in axes.get_title(loc="left")


def test_energy_is_shown_of_the_largest_that_a_cycle_begins_with() -> None:
    stored, lost = np.array([1e-8, 1.0, 0.8]), np.array([-0.9, 0.2, 0.1])
    budget = SimpleNamespace(
        stored=stored, lost=lost, error=0.01 * stored, taken={}, unexplained=lost, time=np.arange(3.0),
        share=lambda name: 1.0,
    )  # fmt: skip
    with page_style():
        left = mismatch_figures.draw_energy(budget, (), new_figure(11.0, 2.3)).axes[0]  # type: ignore[arg-type]
    assert left.get_ylabel() == "% of the largest energy"
    assert abs(left.get_ylim()[0]) < 150.0
