"""Offset and friction that vary from stroke to stroke of a driven body: what is found, what predictions hold of it."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from experiments.driven.bands import motion_of
from experiments.driven.bodies import GIVEN, body, record
from experiments.driven.page import PAGE
from experiments.driven.strokes import CASES, HEADER, RESULT, SEEDS, table
from undertow import fit_driven as from_arrays
from undertow.campaign.run.folder import run_to_folder
from undertow.comparison.driven_folds import by_stroke, validation_rms
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_laws import find_driven
from undertow.errors import IdentificationError
from undertow.likelihood.driven import DrivenLaws, drive_for
from undertow.likelihood.driven_strokes import (
    Reach,
    StrokeCourse,
    course_of,
    motion_by_stroke,
    motion_from_state,
    variance_by_stroke,
    widened,
)
from undertow.methods.driven import fit_driven, motion_from
from undertow.methods.driven_equations import predict_driven, read_back, written
from undertow.methods.driven_strokes import vary_by_stroke

SEED = 3000
VARIES_N = (1.0, 0.5)
EMPS = Path(__file__).resolve().parents[2].parent / "shared" / "driven" / "emps_train.csv.gz"


def laws_of(*names):
    """Laws by their names."""
    return DrivenLaws(tuple(find_driven(name) for name in names))


@pytest.fixture(scope="module")
def varying():
    """A carriage whose offset and friction vary, its record, its fit without deviations and with them."""
    one = body("carriage", SEED)
    trial = record(one, varies_N=VARIES_N)
    fitted = fit_driven([trial], laws_of(*GIVEN["carriage"]))
    return one, trial, fitted, vary_by_stroke([trial], fitted)


@pytest.fixture(scope="module")
def reached(varying):
    """What the motion by stroke is asked with: reach, numbers, state, course, deviations."""
    one, trial, fitted, _ = varying
    course = course_of(trial.t, trial.outputs["displacement"])
    deviations = np.random.default_rng(0).normal(size=course.forces.shape[1])
    reach = Reach(trial, fitted.laws, fitted.names, drive_for(trial))
    return reach, dict(one.numbers), np.zeros(2), course, deviations


def test_a_carriage_s_strokes_are_those_of_its_target(varying):
    _, trial, _, _ = varying
    course = course_of(trial.t, trial.outputs["displacement"])
    assert course.ways == (1, -1) * 5  # 25 s, a stroke takes 2.5 s and ends with a rest of a fifth of it
    assert trial.t[[*course.turns]] == pytest.approx(2.5 * np.arange(1, 10) - 0.25, abs=0.2)


def test_a_pair_has_its_offset_both_ways_and_its_friction_against_the_motion():
    course = StrokeCourse((10, 20), (1, -1, 1))
    assert course.forces @ np.array([1.0, 0.25, 3.0, 0.5]) == pytest.approx([1.25, 0.75, 3.5])


def test_strokes_without_deviations_are_one_free_run(reached, varying):
    _, trial, fitted, _ = varying
    reach, numbers, state, course, deviations = reached
    cut = motion_by_stroke(reach, numbers, state, course, 0.0 * deviations).x
    whole = motion_from(trial, fitted.laws, numbers, {"x0": 0.0, "v0": 0.0}, reach.drive)
    assert np.max(np.abs(cut - whole)) < 1e-12  # m; strokes end at samples, where steps end anyway
    assert motion_from_state(reach, numbers, state) == pytest.approx(whole, abs=1e-15)


def test_sensitivities_by_numbers_state_and_pairs_are_those_of_differences(reached):
    reach, numbers, state, course, deviations = reached
    reach = replace(reach, trial=reach.trial.part(200, 5000))  # in the middle of a stroke: at rest v0 has a kink
    course, state = replace(course, turns=tuple(turn - 200 for turn in course.turns)), np.array([0.05, 0.05])
    found = motion_by_stroke(reach, numbers, state, course, deviations)

    def difference(step, moved):
        """Central difference of two motions, extrapolated."""

        def central(h):
            return (moved(h) - moved(-h)) / (2.0 * h)

        return (4.0 * central(step) - central(2.0 * step)) / 3.0

    def close(exact, other):
        """1e-6 of the largest, where the carriage moves; that a stop falls on another sample's side is a jump."""
        assert np.quantile(np.abs(exact - other), 0.98) < 1e-6 * np.max(np.abs(exact))

    for i, name in enumerate(reach.names):
        step = 1e-5 * abs(numbers[name])
        close(found.by_number[:, i], difference(step, lambda h, name=name: motion_by_stroke(
            reach, {**numbers, name: numbers[name] + h}, state, course, deviations).x))  # fmt: skip
    for i in range(2):
        one = np.eye(2)[i]
        close(found.by_state[:, i], difference(1e-6, lambda h, one=one: motion_by_stroke(
            reach, numbers, state + h * one, course, deviations).x))  # fmt: skip
    for i in range(deviations.size):
        one = np.eye(deviations.size)[i]
        close(found.by_pair[:, i], difference(1e-5, lambda h, one=one: motion_by_stroke(
            reach, numbers, state, course, deviations + h * one).x))  # fmt: skip


def test_the_band_s_variance_is_that_of_independent_pairs(reached):
    reach, numbers, state, _, _ = reached
    course = course_of(reach.trial.t, motion_from_state(reach, numbers, state))
    by_pair = motion_by_stroke(reach, numbers, state, course, np.zeros(course.forces.shape[1])).by_pair
    expected = np.sum((by_pair * np.resize(VARIES_N, by_pair.shape[1])) ** 2, axis=1)
    found = variance_by_stroke(replace(reach, names=()), numbers, state, VARIES_N)
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-18)


def test_offset_and_friction_are_told_apart_and_numbers_are_right_within_their_errors(varying):
    one, trial, fitted, found = varying
    strokes = found.strokes
    # five pairs know a standard deviation to a third of it
    assert 0.4 * VARIES_N[0] < strokes.offset_N < 2.0 * VARIES_N[0]
    assert 0.4 * VARIES_N[1] < strokes.friction_N < 2.0 * VARIES_N[1]
    assert strokes.deviations[trial.name].shape == (5, 2)
    assert strokes.left[trial.name] < 0.1 * fitted.rms[trial.name]
    for name, value, error in zip(found.names, found.values, np.sqrt(np.diag(found.covariance)), strict=True):
        assert abs(value - one.numbers[name]) < 3.0 * error


@pytest.mark.parametrize(("varies", "small"), [((0.3, 0.0), "friction_N"), ((0.0, 0.3), "offset_N")])
def test_what_does_not_vary_is_found_to_vary_little(varies, small):
    trial = record(body("carriage", SEED), varies_N=varies)
    strokes = vary_by_stroke([trial], fit_driven([trial], laws_of(*GIVEN["carriage"]))).strokes
    other = "offset_N" if small == "friction_N" else "friction_N"
    assert getattr(strokes, small) < 0.1 * getattr(strokes, other)


def test_a_carriage_that_does_not_vary_is_not_asked():
    trial = record(body("carriage", SEED))
    with pytest.raises(IdentificationError, match=r"by more than 1.5 times the sensor's noise: nothing varies"):
        vary_by_stroke([trial], fit_driven([trial], laws_of(*GIVEN["carriage"])))


def test_bodies_and_trials_without_strokes_are_refused_with_the_reason(varying):
    _, trial, fitted, _ = varying
    short = trial.part(0, 2000)
    few = fit_driven([short], fitted.started)
    with pytest.raises(IdentificationError, match="4 strokes: by how much they differ is asked of 6 to 100"):
        vary_by_stroke([short], few)
    with pytest.raises(IdentificationError, match="bouc_wen remembers earlier strokes"):
        vary_by_stroke([trial], replace(fitted, laws=laws_of("viscous_damping", "bouc_wen")))
    with pytest.raises(IdentificationError, match="no law of the equation changes at once with the direction"):
        vary_by_stroke([trial], replace(fitted, laws=laws_of("viscous_damping", "constant_force")))
    both = replace(trial, outputs={**trial.outputs, "velocity": np.gradient(trial.outputs["displacement"], trial.t)})
    with pytest.raises(IdentificationError, match="strokes are asked of a force and a displacement alone"):
        vary_by_stroke([both], fitted)


def test_odds_that_are_too_small_are_said(varying, monkeypatch):
    _, trial, fitted, found = varying
    monkeypatch.setattr("undertow.methods.driven_strokes.SURE", 1.0 + found.strokes.evidence)
    with pytest.raises(IdentificationError, match=r"the odds for offsets and frictions that differ by stroke are exp"):
        vary_by_stroke([trial], fitted)


def test_numbers_beyond_their_bounds_are_refused(varying, monkeypatch):
    _, trial, fitted, _ = varying
    bounded = find_driven("coulomb_friction")
    own = replace(bounded.parameters[0], lower=1e3)
    monkeypatch.setattr(type(bounded), "parameters", (own, *bounded.parameters[1:]))
    with pytest.raises(IdentificationError, match=r"differ by stroke coulomb_friction.force_N leaves its bounds"):
        vary_by_stroke([trial], fitted)


def test_a_push_that_nobody_records_no_longer_biases_output_error_in_closed_loop():
    one = body("carriage", 4002)
    trial = record(one, 0.0, 5.0, 20000)
    fitted = fit_driven([trial], laws_of(*GIVEN["carriage"]))
    found, name = vary_by_stroke([trial], fitted), "viscous_damping.c_Ns_per_m"
    truth, error = one.numbers[name], np.sqrt(found.covariance[found.names.index(name), found.names.index(name)])
    assert fitted.numbers[name] > 1.5 * truth
    assert abs(found.numbers[name] - truth) < 3.0 * error < 0.3 * truth


def test_fresh_records_lie_in_the_band_that_holds_deviations_and_not_in_the_other(varying):
    one, trial, fitted, found = varying
    inside = {}
    for label, fit in (("without", fitted), ("with", found)):
        equation = read_back(json.loads(json.dumps(written(fit, fit.rms[trial.name], motion_of(trial), trial))))
        shares = []
        for again in (1, 2, 3):
            fresh = record(one, again=again, varies_N=VARIES_N)
            made, x = predict_driven(fresh, equation, 50), fresh.outputs["displacement"]
            shares.append(np.mean(((x >= made.lower) & (x <= made.upper))[50:]))
        inside[label] = np.mean(shares)
    assert inside["with"] > 0.7 > inside["without"] + 0.1
    assert equation.spreads == pytest.approx(widened(5) * np.array([found.strokes.offset_N, found.strokes.friction_N]))


def test_the_front_gives_the_same_band(varying):
    one, trial, _, found = varying
    own = from_arrays(
        trial.outputs["displacement"], t=trial.t, u=trial.u, equation=GIVEN["carriage"], hold="zero"
    ).by_stroke()
    assert own.fit.strokes.offset_N == pytest.approx(found.strokes.offset_N, rel=1e-6)
    fresh = record(one, again=1, varies_N=VARIES_N)
    made = own.predict(fresh.outputs["displacement"], t=fresh.t, u=fresh.u)
    equation = read_back(written(found, found.rms[trial.name], motion_of(trial), trial))
    assert made.stderr == pytest.approx(predict_driven(fresh, equation, 50).stderr, rel=1e-3)


def test_deviations_are_not_taken_where_unseen_samples_come_further_away(varying, monkeypatch):
    _, trial, fitted, _ = varying
    part, end = trial.part(0, 4000), trial.part(4000, 5000)
    trained = fit_driven([part], fitted.started)
    taken, rms = by_stroke(fitted, ([trial], [part], [end]), trained, np.inf)
    assert taken.strokes is not None
    assert rms == pytest.approx(validation_rms([end], vary_by_stroke([part], trained)))
    assert by_stroke(fitted, ([trial], [part], [end]), trained, rms / 1.1) == (fitted, rms / 1.1)


def test_a_run_says_by_how_much_strokes_differ_and_its_prediction_holds_it(tmp_path):
    one = body("carriage", SEED)
    for name, again in (("loop", 0), ("fresh", 1)):
        trial = record(one, again=again, varies_N=VARIES_N)
        columns = {"time_s": trial.t, "position_m": trial.outputs["displacement"], "force_N": trial.u}
        pd.DataFrame(columns).to_csv(tmp_path / f"{name}.csv", index=False)
    (tmp_path / "loop.yaml").write_text(
        "name: carriage\nrecordings:\n  files: loop.csv\n  channels:\n    time: {column: time_s, unit: s}\n"
        "    displacement: {column: position_m, unit: m}\n    force: {column: force_N, unit: N, hold: zero}\n"
        "equation: {terms: [viscous_damping, coulomb_friction, constant_force]}\nidentify: [output_error]\n"
        "discrepancy: {suspects: []}\n"
    )
    done = run_to_folder(tmp_path / "loop.yaml", out=tmp_path / "run")
    assert "From one pair of strokes to the next the offset differs by" in done.sentence
    (group,) = json.loads((tmp_path / "run" / "verdict.json").read_text())["groups"]
    assert group["by_stroke"]["offset_N"] > group["by_stroke"]["friction_N"] > 0.0
    assert len(group["by_stroke"]["trials"]["loop"]["offset_N"]) == 5
    assert "Offset and friction by stroke" in (tmp_path / "run" / "report.html").read_text()
    from undertow.campaign.driven.predict import predict_recording

    assert predict_recording(tmp_path / "run", tmp_path / "fresh.csv").covered > 0.5


def test_the_committed_strokes_are_those_of_the_page():
    with RESULT.open(newline="", encoding="utf-8") as stream:
        lines = list(csv.reader(stream))[1:]
    named = [dict(zip(HEADER, line, strict=True)) for line in lines]
    assert {(one["case"], one["seed"]) for one in named} == {(case, str(seed)) for case in CASES for seed in SEEDS}
    assert not any(one["taken"] == "yes" for one in named if one["case"] == "nothing varies")
    assert table(lines) in PAGE.read_text(encoding="utf-8")


@pytest.mark.skipif(not EMPS.exists(), reason="../shared/driven is not there")
def test_emps_is_closer_on_unseen_samples_than_by_its_four_numbers():
    t, x, u, _ = pd.read_csv(EMPS).to_numpy().T
    trial = DrivenTrial("emps", t, u, {"displacement": x})
    cut = int(0.8 * trial.t.size)
    part, end = trial.part(0, cut), [trial.part(cut, trial.t.size)]
    four = validation_rms(end, fit_driven([part], laws_of(*GIVEN["carriage"])))
    found = vary_by_stroke([part], fit_driven([part], laws_of(*GIVEN["carriage"], "asymmetric_damping")))
    assert validation_rms(end, found) < 0.5 * four  # 1.86 and 4.77 mm
    assert found.strokes.offset_N > 5.0 * found.strokes.friction_N
