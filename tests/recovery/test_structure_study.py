"""Slices of the structure studies, so that they never rot; the whole of them is in docs/structure_measured.md."""

import csv
from dataclasses import replace

import numpy as np
import pysindy
import pytest

import undertow
from experiments.structure import bound, page, real, routes, study
from experiments.structure.pysindy_examples import EXAMPLES, exact_support, noisy, path_of
from experiments.structure.truths import KINDS, plant_other
from undertow.methods.subset import BestSubset


@pytest.mark.parametrize(
    ("kind", "spring", "depth", "noise", "seed"),
    [("eq15", "short", 2.36, "N4", 1), ("v3", "short", 2.36, "N4", 0), ("cubic_2", "long", 2.57, "N3", 0)],
)
def test_the_true_terms_and_no_others_are_found(kind, spring, depth, noise, seed):
    row = study.judge("support", plant_other(spring, depth, kind), noise, seed)
    assert row.exact == 1
    assert row.left == pytest.approx(1.0, abs=0.06)


def test_an_exponent_between_the_laws_is_found_by_its_column():
    row = study.judge("exponent", plant_other("long", 2.57, "drag_1.5"), "N3", 0)
    assert row.exact == 1
    assert 1.35 < row.inner < 1.65
    assert abs(row.inner - 1.5) < 4.0 * row.inner_stderr


def test_beside_dry_trials_the_exponent_is_found_under_a_millimetre_of_noise():
    row = study.judge("exponent_dry", plant_other("short", 2.36, "drag_1.5"), "N4", 0)
    assert row.exact == 1
    assert 1.35 < row.inner < 1.65  # the bound of its standard deviation is 0.03, without dry trials 0.28
    assert abs(row.inner - 1.5) < 4.0 * row.inner_stderr


def test_the_committed_bound_is_that_of_the_sensitivities():
    with (study.FOLDER / "bound.csv").open(newline="") as stream:
        rows = {(row["spring"], row["noise"], row["dry_trials"]): row for row in csv.DictReader(stream)}
    assert len(rows) == 12
    now = bound.bound(plant_other("short", 2.36, "drag_1.5"), "N4", dry=False)
    # the other processor's rounding, and three digits in the table
    assert now.exponent_std == pytest.approx(float(rows["short", "N4", "0"]["exponent_std"]), rel=0.01)
    assert now.misfit == pytest.approx(float(rows["short", "N4", "0"]["misfit"]), rel=0.02)
    for (spring, noise, dry), row in rows.items():
        if dry == "1":
            assert float(row["exponent_std"]) < 0.2 * float(rows[spring, noise, "0"]["exponent_std"])


def test_both_routes_agree_and_a_wrong_clock_is_said():
    truth = plant_other("long", 2.57, "eq15")
    right, wrong = (dict(zip(routes.COLUMNS, routes.judge(truth, "N3", 1, setting), strict=True))
                    for setting in ("both sensors", "late accelerometer"))  # fmt: skip
    assert (right["exact"], right["agrees"]) == (1, 1)
    assert (wrong["exact"], wrong["agrees"]) == (1, 0)


def test_trials_of_the_routes_study_are_of_unequal_length():
    kept = routes.recordings(plant_other("long", 2.57, "eq15"), "N1", 0, "displacement alone")
    assert len({recording.time.size for recording in kept}) == 4
    assert all(set(recording.channels) == {"displacement"} for recording in kept)


@pytest.mark.filterwarnings("ignore")  # pysindy's own, about its numpy calls
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
def test_the_optimiser_and_the_library_run_inside_plain_pysindy(example):
    assert exact_support(example, noisy(path_of(example), 1e-3, 0), BestSubset())
    assert isinstance(example.library(), pysindy.feature_library.base.BaseFeatureLibrary)


def test_planted_equations_differ_from_equation_15_as_they_say():
    plain, cubic = (plant_other("short", 2.36, kind).body for kind in ("eq15", "cubic_10"))
    at = np.array([0.033])
    resting = (cubic.acceleration(at, 0.0 * at, 1.0) - plain.acceleration(at, 0.0 * at, 1.0)) * plain.inertia_kg
    assert resting == pytest.approx(-0.1 * plain.k_N_per_m * at)
    speed = 0.033 * np.sqrt(plain.k_N_per_m / plain.inertia_kg)
    for kind in ("v3", "drag_1.5"):
        other = plant_other("short", 2.36, kind).body
        assert other.acceleration(0.0, speed, 1.0) == pytest.approx(plain.acceleration(0.0, speed, 1.0))
    assert plant_other("short", 2.36, "stribeck").body.sticks(1.4 * plain.friction_N / plain.k_N_per_m)
    with pytest.raises(KeyError, match=r"no truth is called 'v4'; there are eq15"):
        plant_other("short", 2.36, "v4")


def test_the_page_is_made_from_the_committed_rows(tmp_path):
    page.write_page(tmp_path / "page.md")
    assert (tmp_path / "page.md").read_text() == page.PAGE.read_text()


def test_rows_are_read_back_as_they_were_written(tmp_path):
    row = study.Row("support", "eq15", "long", 2.57, "N1", 3, 1, "stiffness", 0, 1.01)
    other = replace(row, seed=4, inner=1.5, inner_stderr=0.1)
    study.write_rows([other, row], tmp_path / "rows.csv")
    again = study.read_rows(tmp_path / "rows.csv")
    assert list(again) == [row.campaign, other.campaign]
    assert again[other.campaign] == other
    assert study.read_rows(tmp_path / "none.csv") == {}


def test_every_committed_row_is_of_a_known_truth():
    for name in study.STUDIES:
        with (study.FOLDER / f"{name}.csv").open(newline="") as stream:
            rows = list(csv.DictReader(stream))
        assert rows
        assert {row["kind"] for row in rows} <= set(KINDS)
        assert {row["study"] for row in rows} == {name}


@pytest.mark.skipif(
    not (real.ROOT / ".." / "shared" / "recordings").is_dir(),
    reason="the real recordings are not beside the repository (../shared/recordings)",
)
def test_a_pendulum_is_a_sine_with_viscous_and_dry_friction_of_which_one_may_be_another():
    case = real.CASES[0]
    one = undertow.Discover(case.terms, resamples=0, outside=False).fit(real.motions(case)[:1])
    assert {term.name for term in one.terms_} == {"sine_restoring", "viscous_damping", "coulomb_friction"}
    assert ("sine_restoring", "coulomb_friction", "quadratic_drag") in one.rivals_
    said = one.structure_.collinear.sentences
    both = undertow.Discover(case.terms, resamples=0, outside=False).fit(real.motions(case))
    assert {term.name for term in both.terms_} == {"sine_restoring", "coulomb_friction", "quadratic_drag"}
    assert ("sine_restoring", "viscous_damping", "coulomb_friction") in both.rivals_
    assert any("viscous_damping and coulomb_friction are hardly distinguishable" in sentence for sentence in said)
