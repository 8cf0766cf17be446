"""Which hysteresis: the family's contest, proof on another amplitude, numbers and files of its laws."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from experiments.driven import hysteresis as experiment
from experiments.driven.bodies import GIVEN as SPRUNG
from experiments.driven.bodies import body
from experiments.driven.bodies import record as sprung_record
from experiments.driven.hysteresis import GIVEN, NOISE_M, away, numbers_of, record
from experiments.driven.page import read
from undertow import fit_driven
from undertow.campaign.driven.run import sentence_of
from undertow.comparison import driven_hysteresis, driven_search
from undertow.comparison.driven_folds import Tried
from undertow.comparison.driven_hysteresis import _decided, _unsound, remembers
from undertow.comparison.driven_search import discover_driven
from undertow.equation.driven_laws import find_driven
from undertow.errors import IdentificationError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven_equations import predict_driven, read_back, written

SEED = 3100
"""Bodies of this file: neither those of the rules' calibration nor those of the proof in docs/driven_measured.md."""


@pytest.fixture(scope="module")
def pinched():
    """A pinched body, its record, and what the search makes of it."""
    trial = record("pinched", SEED, 1.0).part(0, 4000)
    laws = DrivenLaws(tuple(find_driven(name) for name in GIVEN))
    return trial, discover_driven([trial], laws, ["bouc_wen", "pinched", "iwan"])


def test_the_member_that_is_there_is_chosen_and_predicts_other_amplitudes_where_the_others_do_not(pinched):
    _, found = pinched
    assert found.added == ("pinched",)
    others = [record("pinched", SEED, factor) for factor in (0.5, 2.0)]
    assert max(away(others, found.augmented)) < 1.2
    assert {"bouc_wen", "bouc_wen with exponent", "iwan"} <= set(found.members) | {t.name for t in found.tried}
    for name, member in found.members.items():
        assert name == "pinched" or max(away(others, member)) > 5.0


def test_members_that_lose_say_to_whom_and_the_sentence_names_those_that_cannot_be_told(pinched):
    trial, found = pinched
    reasons = {one.name: one.because for one in found.tried}
    assert "pinched comes closer" in reasons["bouc_wen with exponent"]
    assert reasons["pinched"] == ""
    assert "cannot tell" not in sentence_of("body", [trial], found)
    unsure = replace(found, rivals=("iwan", "lugre"))
    assert sentence_of("body", [trial], unsure).endswith("The record cannot tell pinched from iwan or lugre.")


def stand_in(name, many):
    """A fit of so many numbers with that hysteresis."""
    laws = SimpleNamespace(terms=(find_driven(name),))
    return SimpleNamespace(laws=laws, names=("one",) * many, started=name)


def decided(after, names, monkeypatch, closer=True):
    """The contest's decision for bouc_wen of 6 numbers at 1.0 and others of ``names`` numbers at ``after``."""
    before = np.full(20, 4.0)
    monkeypatch.setattr(
        driven_hysteresis, "fold_errors",
        lambda training, laws: before if laws == "bouc_wen" or not closer else np.full(20, 1.0),
    )  # fmt: skip
    fits = {name: stand_in(name, many) for name, many in names.items()}
    tried = [Tried(name, 0.0, 1.0, after[name]) for name in names]
    return _decided([], (stand_in("bouc_wen", 6), 1.0), tried, fits)


def test_the_member_of_fewest_numbers_is_kept_where_two_come_as_close(monkeypatch):
    made = decided({"pinched": 0.495, "lugre": 0.5}, {"pinched": 8, "lugre": 7}, monkeypatch)
    assert made.fitted.started == "lugre"
    assert made.rivals == ("pinched",)


def test_a_simpler_member_takes_the_place_of_one_that_comes_no_closer(monkeypatch):
    made = decided({"iwan": 1.01, "pinched": 1.3}, {"iwan": 5, "pinched": 8}, monkeypatch)
    assert made.fitted.started == "iwan"
    assert made.rivals == ("bouc_wen",)


def test_a_member_that_is_not_proved_on_parts_left_out_stays_a_rival(monkeypatch):
    made = decided({"pinched": 0.5}, {"pinched": 8}, monkeypatch, closer=False)
    assert made.fitted.started == "bouc_wen"
    assert made.rivals == ("pinched",)
    assert "come closer, where 15 are asked for" in made.tried[0].because


def test_what_stands_is_kept_where_nothing_comes_closer(monkeypatch):
    made = decided({"pinched": 0.99}, {"pinched": 8}, monkeypatch)
    assert (made.fitted.started, made.rms) == ("bouc_wen", 1.0)


def test_the_contest_is_opened_by_friction_or_the_simplest_loop_and_by_no_other():
    assert remembers(stand_in("coulomb_friction", 3))
    assert remembers(stand_in("bouc_wen", 3))
    assert not remembers(stand_in("stiffness", 3))
    assert not remembers(stand_in("iwan", 3))


def test_bristles_take_the_place_of_dry_friction():
    trial = record("lugre", SEED, 1.0).part(0, 3000)
    laws = DrivenLaws(tuple(find_driven(name) for name in (*GIVEN, "coulomb_friction")))
    found = discover_driven([trial], laws, ["lugre"])
    assert found.added == ("lugre",)
    assert [term.name for term in found.augmented.laws.terms] == [*GIVEN, "lugre"]
    assert found.validation[1] < 1.2 * NOISE_M < 0.1 * found.validation[0]


def test_no_member_is_tried_where_a_free_run_is_at_the_noise():
    laws = DrivenLaws(tuple(find_driven(name) for name in SPRUNG["random"]))
    found = discover_driven([sprung_record(body("random", SEED))], laws, ["lugre"])
    assert (found.added, found.tried, dict(found.members)) == ((), (), {})


def test_dry_friction_stays_where_bristles_come_no_closer(monkeypatch):
    monkeypatch.setattr(driven_search, "AT_NOISE", 0.0)
    laws = DrivenLaws(tuple(find_driven(name) for name in SPRUNG["random"]))
    found = discover_driven([sprung_record(body("random", SEED))], laws, ["lugre"])
    assert found.added == ()
    (tried,) = found.tried
    assert "lugre comes no closer to the first 3200 samples than what stands" in tried.because


@pytest.mark.parametrize(
    ("numbers", "left", "stands"),
    [(3, 0.99, False), (3, 0.9, True), (2, 1.02, True), (2, 1.2, False)],
    ids=["as many and hardly closer", "closer", "fewer and as close", "fewer and further off"],
)
def test_a_member_must_come_closer_and_with_fewer_numbers_as_close(monkeypatch, numbers, left, stands):
    current = SimpleNamespace(started="stands", names=("a", "b", "c"))
    trial = SimpleNamespace(name="r", t=np.arange(9.0))
    trial.part = lambda begin, end: trial

    class Laws(str):
        fixed, starts = {}, {}

    def fitted(trials: object, laws: str, *_: object) -> SimpleNamespace:
        chi2 = 1e4 * (left if laws == "member" else 1.0)
        return SimpleNamespace(solution=SimpleNamespace(chi2=chi2), names=tuple("abc"[:numbers]), started=laws)

    monkeypatch.setattr(driven_hysteresis, "fit_driven", fitted)
    monkeypatch.setattr(driven_hysteresis, "drive_for", lambda part: None)
    monkeypatch.setattr(driven_hysteresis, "_in_its_place", lambda *_: Laws("member"))
    monkeypatch.setattr(driven_hysteresis, "replace", lambda laws, **_: laws)
    monkeypatch.setattr(driven_hysteresis, "_unsound", lambda *_: "")
    problem = SimpleNamespace(trials=(trial,), unknowns=())
    monkeypatch.setattr(driven_hysteresis, "driven_problem", lambda *_: problem)
    monkeypatch.setattr(driven_hysteresis, "residuals", lambda *_: (np.ones(9),))
    if stands:
        assert driven_hysteresis._best_start(trial, current, "lugre", [{"k": 1.0}], False) == "member"
        return
    with pytest.raises(IdentificationError, match=rf"lugre comes no closer .* their squares are {left:.3g} of"):
        driven_hysteresis._best_start(trial, current, "lugre", [{"k": 1.0}], False)


def test_a_member_without_a_sound_start_is_not_tried_further(monkeypatch):
    monkeypatch.setattr(driven_search, "AT_NOISE", 0.0)
    monkeypatch.setattr(driven_hysteresis, "_unsound", lambda law, fitted: "on a bound")
    laws = DrivenLaws(tuple(find_driven(name) for name in SPRUNG["random"]))
    found = discover_driven([sprung_record(body("random", SEED))], laws, ["lugre"])
    assert "none of 6 starts of lugre leads to a bounded motion inside its bounds" in found.tried[0].because


@pytest.mark.parametrize("truth", experiment.TRUTHS)
def test_numbers_come_back_within_their_errors_from_starts_a_fifth_away(truth):
    numbers, trial = numbers_of(truth, SEED), record(truth, SEED, 1.0).part(0, 2500)
    held = {name: numbers[name] for name in ("bouc_wen.unit_N", "lugre.sigma1_Ns_per_m", "iwan.chi") if name in numbers}
    starts = {name: value * (1.2 if "exponent" not in name else 1.0) for name, value in numbers.items()}
    starts = {name: value if "pinch" not in name else numbers[name] for name, value in starts.items()}
    equation = [*GIVEN, truth.split()[0]]
    found = fit_driven(
        trial.outputs["displacement"], t=trial.t, u=trial.u, equation=equation, starts=starts, held=held
    )
    for name, estimate in found.numbers.items():
        assert abs(estimate.value - numbers[name]) < 4.5 * estimate.stderr + 1e-9, name
    assert found.rms < 1.1 * NOISE_M


def test_a_law_s_held_numbers_are_on_disk_and_come_back(pinched):
    trial, found = pinched
    exponent = found.members["bouc_wen with exponent"]
    entry = json.loads(json.dumps(written(exponent, 1e-3, 0.2, trial)))
    rows = {row["name"]: row for row in entry["rows"]}
    assert rows["bouc_wen.unit_N"]["held"]
    assert not rows["bouc_wen.exponent"]["held"]
    again = read_back(entry)
    assert again.laws.fixed["bouc_wen.unit_N"] == exponent.laws.fixed["bouc_wen.unit_N"]
    part = trial.part(0, 400)
    assert np.all(np.isfinite(predict_driven(part, again, 50).values))


def test_the_table_of_the_experiment_is_that_of_its_rows():
    assert experiment.table(read(experiment.RESULT)) in (
        (experiment.RESULT.parents[2] / "docs" / "driven_measured.md").read_text()
    )


@pytest.mark.parametrize(
    ("outcome", "sound"),
    [
        ("ok", True),
        ("on a bound: lugre.static_N", False),
        ("on a bound: viscous_damping.c_Ns_per_m", True),  # no number of its own
        ("not identifiable: lugre.sigma0_N_per_m", False),
    ],
)
def test_a_member_whose_own_number_is_on_a_bound_is_no_law(monkeypatch, outcome, sound):
    monkeypatch.setattr(driven_hysteresis, "begun_beyond", lambda problem, values: "")
    solution = SimpleNamespace(problem=None, values=None)
    assert (_unsound("lugre", SimpleNamespace(outcome=outcome, solution=solution)) == "") == sound
