"""What decides that a driven equation lacks a law: fifths left out in turn, bands, equations on disk."""

from __future__ import annotations

import pytest

from undertow.comparison.driven_search import Tried, _judged_by_folds, _sound
from undertow.methods.driven_equations import equation_text

WEAK = Tried("position_damping", -3.9, 5.1e-3, 3.5e-3, "evidence -3.9 is below 3")


def test_a_law_that_brings_every_fifth_closer_holds():
    assert _judged_by_folds(WEAK, [4.9, 2.2, 5.1], [1.9, 2.8, 3.9]).because == ""


@pytest.mark.parametrize(
    ("after", "sentence"),
    [([4.8, 2.1, 5.0], "come no closer"), ([0.1, 0.1, 5.3], "the worst fifth that was left out gets worse")],
)
def test_a_law_that_helps_one_fifth_alone_does_not_hold(after, sentence):
    assert sentence in _judged_by_folds(WEAK, [4.9, 2.2, 5.1], after).because


def test_a_bound_of_another_law_does_not_stop_the_new_one():
    assert _sound("bouc_wen", "on a bound: relaxation.time_s = 0.001")
    assert not _sound("bouc_wen", "on a bound: relaxation.time_s = 0.001, bouc_wen.loop = 0")
    assert _sound("bouc_wen", "did not converge in 12 iterations")
    assert not _sound("bouc_wen", "not identifiable from these trials: a, b move together")


def test_an_equation_is_written_with_its_errors():
    row = {"law": "k x", "name": "stiffness.k_N_per_m", "value": 50.0, "stderr": 0.1, "unit": "N/m"}
    entry = {"mass_kg": 2.0, "names": ["mass_kg"], "covariance": [[0.01]], "rows": [row]}
    assert equation_text(entry) == "M x'' + k x = F(t), M = 2 +- 0.1; stiffness.k_N_per_m = 50 +- 0.1 N/m"
