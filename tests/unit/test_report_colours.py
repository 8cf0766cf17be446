"""One thing has one colour in every figure: the equation as prescribed is blue, missing or not; maps have a scale."""

from __future__ import annotations

import math
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
from matplotlib.colors import same_color, to_rgba
from matplotlib.figure import Figure

from tests.findings_fixture import small_findings
from undertow.discrepancy.cycle_by_cycle import cycling
from undertow.discrepancy.findings import TrialFindings
from undertow.report import mismatch_figures, small_multiples, trial_curves, trial_figures
from undertow.report.style import PRESCRIBED, new_figure


def trial(missing: bool) -> TrialFindings:
    found = small_findings().groups[1].trials[3]
    return replace(found, mismatch=replace(found.mismatch, repeatability_nrmse=0.0 if missing else math.inf))


@pytest.mark.parametrize("missing", [True, False])
def test_the_prescribed_equation_is_blue_in_every_figure(missing: bool) -> None:
    one, figure = trial(missing), new_figure(9.0, 3.0)
    group = replace(small_findings().groups[1], trials=(one,))
    run, residual, decay, front, cycles = figure.subplots(1, 5)
    trial_figures.draw_free_run(one, run)
    trial_figures.draw_residual(one, residual)
    trial_figures.draw_decay(group, decay)
    trial_curves.draw_runs_before_and_after(one, front)
    found = cycling(one)
    assert found is not None
    mismatch_figures.draw_cycles(found, cycles, "damping")
    lines = [run.lines[1], residual.lines[0], decay.lines[1], front.lines[1], cycles.lines[-1]]
    assert all(same_color(to_rgba(line.get_color()), PRESCRIBED) for line in lines)
    many = small_multiples.draw_free_runs(group, new_figure(11.0, 2.6)).axes[0]
    assert sum(same_color(c.get_edgecolor()[0], PRESCRIBED) for c in many.collections if len(c.get_edgecolor())) == 2


def test_the_explorer_draws_the_prescribed_equation_in_the_same_colour() -> None:
    folder = files("undertow.report") / "templates"
    text = "".join((folder / name).read_text(encoding="utf-8") for name in ("page.js.j2", "page.css.j2"))
    assert 'before: ink("--fig-blue")' in text
    assert "label.before { color: var(--fig-blue); }" in text


def test_maps_have_colour_bars_in_the_colours_of_their_cells() -> None:
    group, figure = small_findings().groups[1], Figure()
    left, right = figure.subplots(1, 2)
    mismatch_figures.draw_time_frequency(trial(True), {"body": 2.0}, left)
    mismatch_figures.draw_residual_force(group, right)
    assert len(figure.axes) == 4
    low, high = figure.axes[3].get_ylim()
    assert low == -high
    assert len({tuple(np.round(cell.get_facecolor(), 3)) for cell in right.patches}) <= 12
