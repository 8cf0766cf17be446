"""What decides that a driven equation lacks a law: fifths left out in turn, bands, equations on disk."""

from __future__ import annotations

import numpy as np

from undertow.comparison.driven_folds import come_closer
from undertow.comparison.driven_search import _sound
from undertow.methods.driven_equations import equation_text


def test_a_law_that_brings_most_windows_closer_holds_though_one_gets_worse():
    before, after = np.full(20, 4.0), np.full(20, 1.0)
    after[3] = 6.0
    assert come_closer(before, after) == ""


def test_a_law_that_helps_one_window_alone_does_not_hold():
    before, after = np.full(20, 4.0), np.full(20, 3.9)
    before[3], after[3] = 90.0, 1.0
    assert "no surely closer" in come_closer(before, after)


def test_a_fit_without_a_motion_holds_no_law():
    before = np.full(20, 4.0)
    assert "no bounded motion" in come_closer(before, np.append(np.ones(19), np.inf))
    assert come_closer(np.append(np.ones(19), np.inf), before) == ""


def test_a_bound_of_another_law_does_not_stop_the_new_one():
    assert _sound("bouc_wen", "on a bound: relaxation.time_s = 0.001")
    assert not _sound("bouc_wen", "on a bound: relaxation.time_s = 0.001, bouc_wen.loop = 0")
    assert _sound("bouc_wen", "did not converge in 12 iterations")
    assert not _sound("bouc_wen", "not identifiable from these trials: a, b move together")


def test_an_equation_is_written_with_its_errors():
    row = {"law": "k x", "name": "stiffness.k_N_per_m", "value": 50.0, "stderr": 0.1, "unit": "N/m"}
    entry = {"mass_kg": 2.0, "names": ["mass_kg"], "covariance": [[0.01]], "rows": [row]}
    assert equation_text(entry) == "M x'' + k x = F(t), M = 2 +- 0.1; stiffness.k_N_per_m = 50 +- 0.1 N/m"
