"""`undertow.diagnose`, `load`, `open` and `Discover`: the terminal's answers, as a user of Python reads them."""

from __future__ import annotations

import inspect
import json
import pickle
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pandas as pd
import pytest
from sklearn.model_selection import cross_val_score

import undertow
from tests.small_campaign import make_campaign, write_table
from tests.small_campaign import recorded as recorded_table
from undertow.campaign.run.folder import run_to_folder
from undertow.equation.equation import Equation
from undertow.equation.structure import Stiffness
from undertow.errors import ConfigError, IdentificationError, RecordingError, UndertowError
from undertow.front.diagnosed import DiagnosedGroup
from undertow.report.verdict_file import CONTRACT

HARD = {"stiffness": 400.0, "viscous_damping": 1.0, "cubic_stiffness": 4000.0}
PRESCRIBED = ["stiffness", "viscous_damping"]
RIG = {"mass_kg": 4.0, "stiffness_N_per_m": 400.0}


def recorded(x0: float, seed: int, law=None, **settings):
    simulated = undertow.simulate(law or HARD, x0=x0, mass_kg=4.0, rate_hz=60.0, duration_s=6.0)
    return simulated.recorded(noise_m=1e-4, seed=seed, name=f"r{seed}", **settings)


@pytest.fixture(scope="module")
def trials():
    return undertow.read([recorded(x0, seed) for seed, x0 in enumerate((0.04, 0.06, 0.08, 0.1))])


@pytest.fixture(scope="module")
def found(trials):
    return undertow.diagnose(
        trials, PRESCRIBED, suspects=["cubic_stiffness"], scatter={"k": 0.001, "c": 0.05}, seed=3, **RIG
    )


# ---------------------------------------------------------------- diagnose
def test_a_hidden_hardening_is_named_with_its_number(found):
    assert len(found) == 1
    group = found[0]
    assert group is found[group.label] is next(iter(found))
    assert (group.status, group.names) == ("explained", ("cubic_stiffness",))
    row = group.parameters.loc["cubic_stiffness.N_per_m3"]
    assert abs(row["value"] - 4000.0) < 4.0 * row["stderr"]
    verdicts = found.verdicts.loc[group.label]
    assert verdicts["missing"] == "cubic_stiffness"
    assert verdicts["error_repaired"] < 0.5 * verdicts["error"]
    assert found.parameters.loc[(group.label, "cubic_stiffness.N_per_m3"), "value"] == row["value"]
    assert found.failed == ()


def test_what_a_reader_should_know_before_using_a_groups_numbers_is_printed_with_them(found):
    noted = replace(found[0], findings=replace(found[0].findings, notes=("a < b is doubted",)))
    assert noted.notes == ("a < b is doubted",)
    assert str(noted).splitlines()[-1] == "- a < b is doubted"
    assert "<li>a &lt; b is doubted</li>" in noted._repr_html_()


def test_fit_and_diagnose_answer_in_the_same_units_where_only_the_mass_is_known(trials):
    named = undertow.diagnose(trials, PRESCRIBED, suspects=["cubic_stiffness", "added_mass"], mass_kg=4.0)[0]
    fitted = undertow.fit(trials, [*PRESCRIBED, "cubic_stiffness"], mass_kg=4.0)
    assert named.names == ("cubic_stiffness",)
    assert named.findings.fits["output_error"].anchor == fitted.anchor.sentence == "mass 4 kg, as given"
    assert "added_mass" not in {one.name for one in named.verdict.rejected}  # k is free: nothing parts it from the mass
    for said in ("k_N_per_m", "c_Ns_per_m", "cubic_stiffness.N_per_m3"):
        own = said.replace(".", "_")
        one, other = named.estimates[said], fitted.estimates[own]
        assert one.unit == other.unit
        assert abs(one.value - other.value) < 2.0 * one.total_stderr
    assert named.repaired.total_mass_kg == 4.0


def test_draws_of_a_group_spread_and_move_together_as_its_numbers_do(found):
    group = found[0]
    described = group.verdict.augmented
    drawn = group.posterior(20_000, seed=1).values  # noqa: PD011  (a mapping, no DataFrame)
    for name, values in drawn.items():
        assert np.std(values) == pytest.approx(group.estimates[name].total_stderr, rel=0.03)
    one, other = "c_Ns_per_m", "cubic_stiffness.N_per_m3"
    together = described.correlations.get(one, {}).get(other, 0.0)
    assert np.corrcoef(drawn[one], drawn[other])[0, 1] == pytest.approx(together, abs=0.05)
    assert group.plot_corner(100).shape == (len(drawn), len(drawn))
    with pytest.raises(IdentificationError, match=r"1 draws of \d numbers with an error bar; a posterior needs"):
        group.posterior(1)


def test_draws_of_a_group_go_to_arviz(found):
    pytest.importorskip("arviz", reason="the extra arviz is not installed")
    made = found[0].to_arviz(draws=50, chains=2)
    assert made["posterior"]["cubic_stiffness.N_per_m3"].shape == (2, 50)


def test_a_repaired_equation_moves_as_the_body_did(found, trials):
    group = found[0]
    body = undertow.simulate(HARD, x0=0.07, mass_kg=4.0, rate_hz=60.0, duration_s=6.0)
    repaired = undertow.simulate(group.repaired, x0=0.07, times=body.t)
    bare = undertow.simulate(group.prescribed, x0=0.07, times=body.t)
    numbers = dict(zip(group.get_feature_names_out(), group.repaired.coefficients, strict=True))
    assert numbers["viscous_damping"] == pytest.approx(group.estimates["c_Ns_per_m"].value, rel=1e-9)
    assert numbers["viscous_damping"] != pytest.approx(group.prescribed.coefficients[1], rel=1e-6)
    rms = np.sqrt(np.mean(body.x**2))
    assert np.sqrt(np.mean((repaired.x - body.x) ** 2)) < 0.02 * rms
    assert np.sqrt(np.mean((bare.x - body.x) ** 2)) > 0.05 * rms
    assert group.to_latex(numbers=False) == r"M\ddot{x} + k x + c \dot{x} + k_3 x^3 = 0"
    ahead = undertow.predict(group, undertow.read(recorded(0.07, 9)))
    assert ahead.runs[0].nrmse < 0.03
    assert ahead.runs[0].inside > 0.85
    unseen = undertow.read(recorded(0.07, 9))
    assert group.score(unseen) > group.score() - 0.02 > 0.95
    assert group.predict(unseen, adjust=True).score() > ahead.score() - 1e-9
    assert group.score([recorded(0.07, 9)]) == group.score(unseen)
    errors = group.parameters["stderr"]
    (said,) = group.equations()
    assert said == group.repaired.text({"cubic_stiffness": errors["cubic_stiffness.N_per_m3"],
                                        "viscous_damping": errors["c_Ns_per_m"]})  # fmt: skip
    stated = json.loads(group.to_json())["terms"]
    found_error = {one["name"]: [p.get("stderr") for p in one["parameters"].values()] for one in stated}
    assert found_error["cubic_stiffness"] == [pytest.approx(errors["cubic_stiffness.N_per_m3"])]
    assert "scatter of the run's trials" in ahead.notes[0]  # as stated, not as assumed of any rig
    assert group.simulate(0.07, body.t).x == pytest.approx(repaired.x, abs=1e-12)
    assert group.get_feature_names_out().tolist() == list(HARD)
    ends = group.confidence_interval(0.999).loc["cubic_stiffness.N_per_m3"]
    assert ends["low"] < 4000.0 < ends["high"]


def test_a_repaired_equation_with_an_own_law_is_adjusted_to_a_trial_as_any(found, trials):
    class Spring(Stiffness):
        """A spring of a user's own."""

        slots: ClassVar = {}

    class Group(DiagnosedGroup):
        """A group with a given equation."""

        repaired = Equation((Stiffness(),), (400.0,), mass_kg=4.0)

    class OwnLaw(Group):
        """A group whose equation the compiled integrator does not know."""

        repaired = Equation((Spring(),), (400.0,), mass_kg=4.0)

    score = OwnLaw(found[0].findings, trials).score(trials)
    assert score == pytest.approx(Group(found[0].findings, trials).score(trials), abs=1e-5)
    assert score < 0.95  # neither has the law that is missing


def test_a_diagnosis_prints_and_draws_itself(found, trials):
    group = found[0]
    assert group.sentence in str(found)
    assert "cubic_stiffness.N_per_m3" in str(group)
    assert "<table" in found._repr_html_()
    assert "<table" in group._repr_html_()
    labels = [line.get_label() for line in group.plot().lines]
    assert labels[0] == "measured"
    assert labels[1].startswith("as prescribed: error")
    assert labels[2].startswith("with what was found: error")
    held_out = [t.motion.name for t in group.findings.trials if t.held_out]
    assert group.plot().get_title().split()[0] in held_out
    assert group.plot_residual(trial="r2").lines
    assert group.plot(trial=0).get_title().startswith(group.findings.trials[0].motion.name)
    assert found.plot().get_xlabel() == "free-run error (% of motion)"
    assert set(group.trial_table.index) == set(trials.names)
    with pytest.raises(IdentificationError, match=r"no trial is called 'r7' in .*; there are"):
        group.plot(trial="r7")
    with pytest.raises(IdentificationError, match=r"no trial is called 99 in .*; there are"):
        group.plot(trial=99)
    with pytest.raises(ConfigError, match="no group fits 'wet'; say one of: "):
        found["wet"]
    with pytest.raises(IndexError, match="group 5 is asked for, but there are 1: 0 to 0"):
        found[5]


def test_dry_trials_are_given_as_fit_takes_them():
    law = {"stiffness": 400.0, "viscous_damping": 1.0}
    water = law | {"quadratic_drag": 6.0}
    dry, wet = ([recorded(x0, seed, one) for seed, x0 in enumerate((0.1, 0.09, 0.08))] for one in (law, water))
    found = undertow.diagnose(
        undertow.read(wet), [*PRESCRIBED, "quadratic_drag"], dry=undertow.read(dry), suspects=["cubic_stiffness"], **RIG
    )
    assert [group.label for group in found] == ["medium air", "medium water"]
    assert [group.findings.dry for group in found] == [True, False]
    assert found[0].trials.names == ("dry_r0", "dry_r1", "dry_r2")
    assert found[1].parameters.loc["drag_Ns2_per_m2", "value"] == pytest.approx(6.0, rel=0.05)
    with pytest.raises(RecordingError, match="dry is of type ndarray"):
        undertow.diagnose(undertow.read(wet), PRESCRIBED, dry=np.zeros((3, 100)), **RIG)


def test_another_mode_at_more_than_twice_the_bodys_rate_is_found():
    """Between 2.5 and 4 times the body's rate nothing was looked for, and the verdict was "most like a force"."""
    mode = {"mass_kg": 0.2, "natural_frequency_rad_per_s": 27.0, "damping_ratio": 0.01}
    law = {"stiffness": 400.0, "viscous_damping": 1.0, "hidden_resonator": mode}
    trials = undertow.read([recorded(x0, seed, law) for seed, x0 in enumerate((0.1, 0.09, 0.075, 0.06, 0.05))])
    names = ["hidden_resonator", "relaxation", "added_mass", "external_forcing"]
    group = undertow.diagnose(trials, PRESCRIBED, mass_kg=4.0, scatter={"k": 0.002, "c": 0.04}, suspects=names)[0]
    assert group.verdict.verdict == ("hidden_resonator",)
    rate = group.parameters.loc["hidden_resonator.natural_frequency_rad_per_s", "value"]
    assert rate == pytest.approx(27.0, rel=2e-3)


def test_a_group_that_needs_no_repair_has_the_numbers_of_its_equation(trials):
    group = undertow.diagnose(trials, [*PRESCRIBED, "cubic_stiffness"], scatter={"k": 0.001, "c": 0.05}, **RIG)[0]
    assert not group.verdict.verdict
    assert group.parameters.loc["c_Ns_per_m", "value"] == pytest.approx(1.0, abs=0.05)
    assert group.parameters.loc["cubic_stiffness_N_per_m3", "value"] == pytest.approx(4000.0, rel=0.05)


def test_an_equation_that_lacks_nothing_stays_as_it_is(trials):
    found = undertow.diagnose(
        trials, list(HARD), suspects=["quadratic_drag"], scatter={"k": 0.001, "c": 0.05}, seed=3, **RIG
    )[0]
    assert (found.status, found.names) == ("nothing_missing", ())
    assert found.repaired == found.prescribed
    assert np.isnan(found.error_after)


def test_a_trial_of_another_clock_is_named_and_nothing_is_green():
    one = undertow.simulate({"stiffness": 400.0, "viscous_damping": 1.0}, x0=0.06, mass_kg=4.0, rate_hz=60.0)
    tables = [one.recorded(noise_m=1e-4, seed=seed) for seed in range(4)]
    slow = [(2.0 if place == 1 else 1.0) * table.time for place, table in enumerate(tables)]
    arrays = [table.channels["displacement"] for table in tables]
    known = RIG | {"scatter": {"k": 0.001, "c": 0.05}}
    found = undertow.diagnose(arrays, PRESCRIBED, t=slow, units={"x": "m", "t": "s"}, **known)
    assert found[0].status != "nothing_missing"
    (said,) = (doubt for doubt in found.doubts if "trial_2" in doubt)
    assert "look at its clock, its spring" in said
    assert f"doubt: {said}" in str(found)


def test_settings_that_cannot_be_are_refused_in_one_sentence(trials):
    with pytest.raises(ConfigError, match=r"discrepancy.suspects: 'ghost' is none of"):
        undertow.diagnose(trials, PRESCRIBED, suspects=["ghost"])
    with pytest.raises(ConfigError, match="mass_kg is 'heavy'"):
        undertow.diagnose(trials, PRESCRIBED, mass_kg="heavy")
    with pytest.raises(ConfigError, match=r"^seed is 'a' but should be a valid integer"):
        undertow.diagnose(trials, PRESCRIBED, seed="a")
    with pytest.raises(ConfigError, match="group_by: a trial has no condition 'spring'"):
        undertow.diagnose(trials, PRESCRIBED, group_by=["spring"])
    with pytest.raises(ConfigError, match="hold_out names 'zz', and no trial is called so; there are r0, r1"):
        undertow.diagnose(trials, PRESCRIBED, hold_out=["zz"])
    with pytest.raises(ConfigError, match=r"dry says {'depth_m': 1}, and no trial has these conditions"):
        undertow.diagnose(trials, PRESCRIBED, dry={"depth_m": 1})


def test_a_stated_rig_that_the_channels_contradict_stops_a_diagnosis():
    """A mass that is ten times what load cell and accelerometer say is found before anything is fitted."""
    simulated = undertow.simulate(HARD, x0=0.1, mass_kg=4.0, rate_hz=100.0, duration_s=6.0)
    one = simulated.recorded(noise_m=1e-4, acceleration_noise=0.01)
    force = 400.0 * one.channels["displacement"] + 4000.0 * one.channels["displacement"] ** 3
    table = pd.DataFrame({"t": one.time, "x": one.channels["displacement"], "f": force})
    table["a"] = one.channels["acceleration"]
    columns = {"time": "t", "displacement": "x", "acceleration": "a", "spring_force": "f"}
    units = {"x": "m", "a": "m/s^2", "f": "N"}
    trials = undertow.read(table, columns, units)
    with pytest.raises(ConfigError, match="the channels of the recordings contradict each other"):
        undertow.diagnose(trials, PRESCRIBED, suspects=[], stiffness_N_per_m=4000.0)
    with pytest.raises(IdentificationError, match=r"none of 1 trial agrees with what is known of the rig: .*stiffness"):
        undertow.fit(trials, PRESCRIBED, stiffness_N_per_m=4000.0)
    beside = undertow.read(recorded(0.05, 1)) + trials
    left = undertow.fit(beside, list(HARD), stiffness_N_per_m=4000.0)
    assert left.trials.names == ("r1",)
    assert left.doubts[0].startswith("not used: trial trial_1: ")
    assert repr(left).splitlines()[2].startswith("! not used: trial trial_1: ")
    known = undertow.read(table, columns, units, accept=["unit", "gain"])
    assert undertow.fit(known, list(HARD), stiffness_N_per_m=4000.0).trials.names == ("trial_1",)


# ---------------------------------------------------------------- load, open: as the terminal
@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """A small campaign's config, its findings by the terminal's course, and its run folder."""
    made = make_campaign(tmp_path_factory.mktemp("campaign"), (0.03, 0.04, 0.05))
    wrong = recorded_table(0.05, 2)
    wrong[:, 1] *= 1000.0  # millimetres in a column of metres: the accelerometer knows better
    write_table(made.folder / made.files[2], wrong)
    done = run_to_folder(made.config, out=tmp_path_factory.mktemp("runs") / "small", jobs=1)
    return made.config, done.findings, done.folder


def test_a_loaded_campaign_is_diagnosed_as_by_the_terminal(campaign):
    config, findings, _ = campaign
    trials = undertow.load(config)
    found = undertow.diagnose(trials)
    assert [one.reason for one in found.failed] == [one.reason for one in findings.failed]
    assert len(found.failed) == 1
    assert "contradict" in found.failed[0].reason or "recordings.accept" in found.failed[0].reason
    assert [g.verdict.sentence for g in found] == [g.verdict.sentence for g in findings.groups]
    assert found.parameters["value"].to_list() == [
        e.value for g in findings.groups for e in (g.verdict.augmented or g.verdict.baseline).parameters.values()
    ]


def test_an_opened_run_says_what_the_run_said(campaign):
    _, findings, folder = campaign
    opened = undertow.open(folder)
    assert [g.sentence for g in opened] == [g.verdict.sentence for g in findings.groups]
    group = opened[0]
    assert group is opened[group.label]
    found = findings.groups[0].verdict.baseline.parameters["k_N_per_m"]
    assert group.prescribed.loc["k_N_per_m", "value"] == pytest.approx(found.value, rel=1e-6)
    pd.testing.assert_frame_equal(group.parameters, group.repaired)
    assert opened.verdicts.loc[group.label, "error"] == pytest.approx(findings.groups[0].verdict.baseline.nrmse)
    assert len(opened.trials)
    assert len(opened.levels)
    assert len(opened.mismatch)
    assert opened.recordings().names == undertow.load(opened.config).names
    assert opened.report.name == "report.html"
    assert group.sentence in str(opened)
    assert "<table" in opened._repr_html_()
    assert opened.plot().get_yticklabels()[0].get_text() == group.label
    trials = undertow.load(opened.config)
    assert group.predict(trials).runs[0].nrmse == pytest.approx(undertow.predict(group, trials).runs[0].nrmse)


def test_a_folder_that_is_no_run_is_refused(campaign, tmp_path):
    _, _, folder = campaign
    (tmp_path / "verdict.json").write_text("{")
    with pytest.raises(UndertowError, match=r"cannot be read: it is not a run's verdict \(JSONDecodeError\)"):
        undertow.open(tmp_path)
    (tmp_path / "verdict.json").write_text(json.dumps({"contract": "old", "groups": []}))
    with pytest.raises(UndertowError, match=f"follows contract 'old', this undertow reads {CONTRACT}"):
        undertow.open(tmp_path)
    (tmp_path / "verdict.json").write_text((folder / "verdict.json").read_text())
    with pytest.raises(UndertowError, match=r"has no trials.csv; let `undertow run` finish"):
        undertow.open(tmp_path).trials  # noqa: B018
    with pytest.raises(ConfigError, match="no group fits 'wet'; say one of: "):
        undertow.open(folder)["wet"]


@pytest.mark.parametrize("text", ["", "{", '{"contract": 1', "[]"])
def test_a_run_folder_whose_files_are_cut_is_said(campaign, tmp_path, text):
    _, _, folder = campaign
    (tmp_path / "verdict.json").write_text((folder / "verdict.json").read_text())
    (tmp_path / "equations.json").write_text(text)
    for name in ("trials", "levels", "mismatch"):
        (tmp_path / f"{name}.csv").write_text("")
    opened = undertow.open(tmp_path)
    with pytest.raises(UndertowError, match=r"equations\.json is not as a run writes it .* was it changed\? run again"):
        opened[0].simulate(0.04)
    for name in ("trials", "levels", "mismatch"):
        with pytest.raises(UndertowError, match=rf"{name}\.csv is not as a run writes it"):
            getattr(opened, name)


def test_one_suspect_that_is_no_list_is_told_what_may_stand_there(campaign):
    config, _, _ = campaign
    with pytest.raises(ConfigError, match="suspects is 'cubic_stiffness' but should be 'all' or a list"):
        undertow.diagnose(undertow.load(config), suspects="cubic_stiffness")


# ---------------------------------------------------------------- Discover
LIBRARY = {"terms": ["stiffness", "viscous_damping", "cubic_stiffness", "quadratic_drag"], "resamples": 0,
           "outside": False, "second_route": False}  # fmt: skip


def test_discovers_draws_have_the_printed_errors_and_make_a_pair_plot(trials):
    found = undertow.Discover(**LIBRARY).fit(trials)
    drawn = found.posterior(4000).values  # noqa: PD011  (a mapping, no DataFrame)
    for name, values in drawn.items():
        assert np.std(values) == pytest.approx(found.parameters.loc[name, "stderr"], rel=0.1)
    assert found.plot_corner(200).shape == (len(drawn), len(drawn))


def test_discover_takes_paths_tables_arrays_and_trials_alike(trials, tmp_path):
    tables = [pd.DataFrame({"t": m.recording.time, "x": 1e3 * m.recording.channels["displacement"]}) for m in trials]
    for name, table in zip(trials.names, tables, strict=True):
        table.to_csv(tmp_path / f"{name}.csv", sep=";", decimal=",", index=False)
    mm = {"x": "mm"}
    by_trials = undertow.Discover(**LIBRARY).fit(trials)
    assert by_trials.get_feature_names_out().tolist() == ["stiffness", "viscous_damping", "cubic_stiffness"]
    others = (
        undertow.Discover(**LIBRARY).fit(str(tmp_path / "*.csv"), units=mm),
        undertow.Discover(**LIBRARY).fit(tables, units=mm),
        undertow.Discover(**LIBRARY).fit([one["x"] for one in tables], t=[one["t"] for one in tables], units=mm),
    )
    for other in others:
        assert other.parameters["value"].to_numpy() == pytest.approx(by_trials.parameters["value"].to_numpy(), rel=1e-4)
    with pytest.raises(RecordingError, match="has no unit; say it"):
        undertow.Discover(**LIBRARY).fit(tables)


def test_discover_predicts_and_scores_what_it_is_fitted_to_in_every_shape(trials):
    found = undertow.Discover(**LIBRARY).fit(trials)
    X, t = [1e3 * m.recording.channels["displacement"] for m in trials], [m.recording.time for m in trials]
    assert found.score(X, t=t, units={"x": "mm"}) == pytest.approx(found.score(trials), abs=1e-4)
    for one, other in zip(found.predict(X, t=t, units={"x": "mm"}), found.predict(trials), strict=True):
        assert one == pytest.approx(other, abs=1e-4)
    table = pd.DataFrame({"s": t[0], "pot": X[0]})
    said = {"columns": {"time": "s", "displacement": "pot"}, "units": {"pot": "mm"}}
    assert found.score(table, **said) == pytest.approx(found.score(trials[:1]), abs=1e-4)
    assert found.predict(table, **said)[0] == pytest.approx(found.predict(trials[:1])[0], abs=1e-4)


def test_scikit_learn_cross_validates_trials(trials):
    scores = cross_val_score(undertow.Discover(**LIBRARY), trials, cv=len(trials), error_score="raise")
    assert len(scores) == len(trials)
    assert np.min(scores) > 0.9


@pytest.mark.parametrize("shape", ["step", "axis", "axes", "rate"])
def test_scikit_learn_scores_arrays_and_tables_as_they_were_fitted(trials, shape):
    """Its `params` go to fit alone: score lacked the times, and every score was nan."""
    X, t = [1e3 * m.recording.channels["displacement"] for m in trials], trials[0].recording.time
    given = {"step": {"t": 1.0 / 60.0}, "axis": {"t": t}, "axes": {"t": [t] * len(X)}, "rate": {"rate_hz": 60.0}}[shape]
    X = [pd.DataFrame({"x": x}) for x in X] if shape == "rate" else X
    params = {**given, "units": {"x": "mm"}}
    assert t[1] - t[0] == pytest.approx(1.0 / 60.0)
    assert np.min(cross_val_score(undertow.Discover(**LIBRARY), X, cv=2, params=params, error_score="raise")) > 0.9


def test_trials_with_times_of_their_own_cannot_be_scored_without_them(trials):
    X, t = [m.recording.channels["displacement"] for m in trials], [m.recording.time for m in trials]
    X[0], t[0] = X[0][:-1], t[0][:-1]
    found = undertow.Discover(**LIBRARY).fit(X, t=t, units={"x": "m"})
    with pytest.raises(RecordingError, match=r"fit was given a t for each of its 4 trials; give those of these, as in"):
        found.score(X[1:])
    assert found.score(X[1:], t=t[1:]) > 0.9
    with pytest.raises(RecordingError, match=r"source is of type ndarray; give"):
        found.score(X[1])  # a part of a record, as it may be


def test_a_setting_that_discover_has_not_is_said_with_the_nearest_or_where_it_belongs():
    with pytest.raises(TypeError, match=r"^Discover has no setting 'resample'; did you mean 'resamples'\? it has ter"):
        undertow.Discover(resample=3)
    with pytest.raises(TypeError, match=r"^Discover has no setting 'feature_library'; did you mean 'terms'\? it has"):
        undertow.Discover(feature_library=["stiffness"])
    with pytest.raises(TypeError, match=r"^Discover has no setting 'xyz'; it has terms, known, .*, random_state$"):
        undertow.Discover(xyz=1)
    with pytest.raises(TypeError, match=r"no setting 'units': say it in fit, as in Discover\(\).fit\(trials, units="):
        undertow.Discover(units={"x": "mm"})
    assert "resamples" in inspect.signature(undertow.Discover).parameters


@pytest.mark.parametrize(("scatter", "said"), [({"stiffness": 0.01}, "names 'stiffness'"), (0.01, "is 0.01")])
def test_a_scatter_that_is_none_is_said_with_what_it_may_have(trials, scatter, said):
    with pytest.raises(ConfigError, match=rf"^scatter {said}; give a mapping, .* which may have c \(Viscous damping, "):
        undertow.diagnose(trials, PRESCRIBED, scatter=scatter, **RIG)
    wrong = scatter if isinstance(scatter, float) else {"stiffness": "small"}
    with pytest.raises(IdentificationError, match=r"^scatter is .*; give shares by term, as in \{'stiffness': 0.004\}"):
        undertow.Discover(**{**LIBRARY, "scatter": wrong}).fit(trials)


def test_what_discover_found_is_shown_scored_and_handed_over(trials, tmp_path):
    found = undertow.Discover(**LIBRARY).fit(trials)
    unseen = undertow.read(recorded(0.07, 9))
    assert found.score(unseen) > 0.98
    assert found.predict(unseen)[0].shape == found.free_runs(unseen)[0].simulated.shape
    assert found.prediction(unseen).runs[0].nrmse < 0.03
    table = found.confidence_interval()
    assert table.loc["cubic_stiffness", "low"] < 1000.0 < table.loc["cubic_stiffness", "high"]
    assert found.score() == found.score(trials)
    assert found.simulate([0.07, 0.0], np.arange(50) * 0.02).x[0] == 0.07
    assert "cubic_stiffness" in str(found)
    assert "<" in found._repr_html_()
    assert found.plot(trial="r2").get_title().startswith("r2")
    assert found.plot_residual(trial=1).get_title().startswith("r1")
    assert len(found.plot_intervals().get_yticklabels()) == len(found.parameters)
    scope: dict = {}
    exec(found.to_python(), scope)
    own = undertow.simulate(found, x0=0.1, duration_s=3.0, rate_hz=50.0)
    assert scope["simulate"](0.1, own.t)[0] == pytest.approx(own.x, abs=1e-6)
    again = pickle.loads(pickle.dumps(found))  # noqa: S301
    assert again.score(unseen) == pytest.approx(found.score(unseen))
    with pytest.raises(IdentificationError, match="was read from a file, without its 4 trials; draw"):
        again.plot()
    with pytest.raises(IdentificationError, match=r"was read from a file, without its 4 trials; .* ask score"):
        again.score()
