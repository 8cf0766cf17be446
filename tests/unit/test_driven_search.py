"""What decides that a driven equation lacks a law: fifths left out in turn, bands, equations on disk."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments.driven.additions import PROOF, RESULT, cases, row, table
from experiments.driven.bodies import GIVEN, body, record
from experiments.driven.page import read
from undertow.comparison.driven_folds import come_closer
from undertow.comparison.driven_search import _sound, _unsure, discover_driven
from undertow.equation.driven_laws import find_driven
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import fit_driven
from undertow.methods.driven_begin import begun_beyond
from undertow.methods.driven_equations import equation_text

ROOT = Path(__file__).resolve().parents[2]


def test_a_law_that_brings_most_windows_closer_holds_though_one_gets_worse():
    before, after = np.full(20, 4.0), np.full(20, 1.0)
    after[3] = 6.0
    assert come_closer(before, after) == ""


def test_a_law_that_helps_one_window_alone_does_not_hold():
    before, after = np.full(20, 4.0), np.full(20, 3.9)
    before[3], after[3] = 90.0, 1.0
    assert "no surely closer" in come_closer(before, after)


def test_a_law_that_helps_barely_more_than_half_of_the_windows_does_not_hold():
    before = np.full(20, 4.0)
    after = np.where(np.arange(20) < 13, 0.1, 4.1)
    assert "13 of 20 come closer, where 15 are asked for" in come_closer(before, after)
    assert come_closer(before, np.where(np.arange(20) < 15, 0.1, 4.1)) == ""


def test_too_few_windows_prove_nothing():
    assert "no record is long enough to leave parts of it out; give one of 1000 samples" in (
        come_closer(np.full(4, 4.0), np.full(4, 1.0))
    )


def test_a_law_of_overwhelming_evidence_is_not_added_where_nothing_unseen_can_prove_it():
    trial = record(body("random", 3001, "cubic_stiffness")).part(0, 1100)
    laws = DrivenLaws(tuple(find_driven(name) for name in GIVEN["random"]))
    found = discover_driven([trial], laws, ["cubic_stiffness"])
    assert found.added == ()
    (tried,) = found.tried
    assert tried.evidence > 100.0
    assert tried.after < 0.5 * tried.before
    assert "no record is long enough" in tried.because


def carriage(numbers, wanders_N=0.0, seed=3):
    """A fit of a synthetic carriage by its given equation and a hysteresis with these numbers held."""
    trial = record(body("carriage", seed), wanders_N)
    laws = tuple(find_driven(name) for name in (*GIVEN["carriage"], "bouc_wen"))
    held = {"bouc_wen.loop": 5.0, "bouc_wen.skew": 0.0, "bouc_wen.exponent": 1.0, **numbers}
    starts = {**body("carriage", seed).numbers, "bouc_wen.alpha_N_per_m": 20.0}
    return fit_driven([trial], DrivenLaws(laws, held, starts), windows=0)


def test_a_hysteresis_that_begins_where_no_motion_brings_it_is_refused():
    fitted = carriage({"bouc_wen.alpha_N_per_m": 0.1})
    problem, values = fitted.solution.problem, fitted.solution.values.copy()
    assert begun_beyond(problem, values) == ""
    values[problem.names.index("z0_N[carriage]")] = 0.5
    assert "begins with a hysteresis of 0.5 N, and its motion reaches 0.0" in begun_beyond(problem, values)


def test_a_law_whose_coefficient_may_as_well_be_nothing_is_refused():
    assert "within 2 standard errors of 0" in _unsure("bouc_wen", carriage({}))
    assert _unsure("coulomb_friction", carriage({})) == ""


@pytest.mark.parametrize(
    ("kind", "missing"), [("random", ""), ("swept", "asymmetric_damping"), ("random", "hidden_resonator")]
)
def test_the_search_adds_what_a_body_lacks_and_nothing_else(kind, missing):
    assert row(body(kind, 2000, missing), 0.0)[3:5] == ((missing or "nothing"),) * 2


def test_bristles_of_half_a_millimetre_beside_dry_friction_are_found_on_strokes_of_200_mm():
    trial = record(body("carriage", 303, "bouc_wen"))
    laws = DrivenLaws(tuple(find_driven(name) for name in GIVEN["carriage"]))
    found = discover_driven([trial], laws, ["bouc_wen"])
    assert found.added == ("bouc_wen",)
    assert found.validation[1] < 1.2 * trial.noise()["displacement"] < 0.1 * found.validation[0]
    assert found.augmented.numbers["bouc_wen.alpha_N_per_m"] == pytest.approx(2e4, rel=0.05)


def test_a_carriage_in_closed_loop_whose_drive_wanders_lacks_no_law():
    assert row(body("carriage", 9), 0.1)[4] == "nothing"


def test_the_committed_additions_are_of_bodies_in_the_list_and_on_the_page():
    rows = read(RESULT)
    known = {(one.kind, str(one.seed), f"{wander:g}", one.missing or "nothing") for one, wander in cases(PROOF)}
    assert {tuple(one[:4]) for one in rows} <= known
    assert len(rows) == len(known)
    assert table(rows) in (ROOT / "docs" / "driven_measured.md").read_text(encoding="utf-8")


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
    assert equation_text(entry) == "M x'' + k x = F(t), M = 2.00 +- 0.10; stiffness.k_N_per_m = 50.00 +- 0.10 N/m"
