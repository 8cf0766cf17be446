"""What may be wrong with trials stands in `print(trials)`, and in what `fit` and `Discover` say; names and units that
were said once are known afterwards."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import undertow
from undertow.comparison.discover import NotDiscoveredError
from undertow.conditioning.scale import SLOWEST_S, out_of_scale
from undertow.discrepancy.findings import FailedTrial
from undertow.errors import RecordingError
from undertow.front.trials import first_reasons

LAW = ["stiffness", "viscous_damping"]
RUNS = [
    undertow.simulate({"stiffness": 400.0, "viscous_damping": 2.0}, x0=x0, mass_kg=4.0, rate_hz=100.0, duration_s=6.0)
    for x0 in (0.05, 0.1)
]
TABLES = [
    pd.DataFrame({"t": run.t, "x": run.x + 1e-5 * np.random.default_rng(i).standard_normal(run.t.size)})
    for i, run in enumerate(RUNS)
]


def accelerated(factor: float) -> list[pd.DataFrame]:
    """The trials with an accelerometer that is so many times too sensitive."""
    noise = 0.01 * np.random.default_rng(7).standard_normal(RUNS[0].t.size)
    return [one.assign(a=factor * run.a + noise) for one, run in zip(TABLES, RUNS, strict=True)]


def test_a_gain_that_does_not_fit_is_said_by_trials_and_by_what_is_fitted_to_them():
    trials = undertow.read(accelerated(1.3), units={"x": "m", "a": "m/s^2"})
    (doubt,) = trials.doubts
    assert doubt.startswith("trial_1 and 1 more trial: ")
    assert "acceleration" in doubt
    assert f"  ! {doubt}" in str(trials).split("\n")
    assert doubt.replace("'", "&#x27;") in trials._repr_html_()
    assert trials.notes == ()  # what is a doubt is no note as well
    assert undertow.fit(trials, LAW, mass_kg=4.0).doubts[0] == doubt
    found = undertow.Discover(LAW, resamples=0, outside=False, second_route=False).fit(trials)
    assert str(found).split("\n")[1] == f"! {doubt}"
    assert undertow.read(accelerated(1.0), units={"x": "m", "a": "m/s^2"}).doubts == ()


def test_a_channel_left_out_of_some_trials_is_a_doubt_and_rows_that_lack_a_note():
    tables = accelerated(1.0)
    tables[1]["a"] = np.where(np.arange(len(tables[1])) < 400, np.nan, tables[1]["a"])
    trials = undertow.read(tables, units={"x": "m", "a": "m/s^2"})
    (doubt,) = trials.doubts
    assert doubt.startswith("trial_2: acceleration ")
    assert "left out in this trial" in doubt
    assert not any("left out in this trial" in note for note in trials.notes)
    few = undertow.read([one[(one.t < 2.0) | (one.t > 2.3)] for one in TABLES], units={"x": "m"})
    assert few.doubts == ()
    assert few.notes
    assert f"  - {few.notes[0]}" in str(few)


def test_of_many_notes_the_first_are_shown():
    given = {}
    for i in range(9):
        law = {"stiffness": 400.0 + 20.0 * i, "viscous_damping": 2.0}
        run = undertow.simulate(law, x0=0.1, mass_kg=4.0, rate_hz=100.0, duration_s=6.0)
        table = pd.DataFrame({"t": run.t, "x": run.x + 1e-5 * np.random.default_rng(i).standard_normal(run.t.size)})
        given[f"r{i}"] = table[(table.t < 2.0) | (table.t > 2.3)]
    many = undertow.read(given, units={"x": "m"})
    assert len(many.notes) >= 9
    assert str(many).split("\n")[-1] == f"  - and {len(many.notes) - 8} more note{'s' * (len(many.notes) > 9)} (notes)"


def test_motions_out_of_scale_are_doubted_where_their_unit_is_not_accepted():
    large = [one.assign(x=1e3 * one.x) for one in TABLES]
    (doubt,) = undertow.read(large, units={"x": "m"}).doubts
    assert doubt.startswith("trial trial_2 is released from 100 m and moves with")
    assert doubt.endswith('correct units={"displacement": ...} or the unit of time, or list unit in accept=[...]')
    assert undertow.read(large, units={"x": "m"}, accept=["unit"]).doubts == ()
    slow = [one.assign(t=1e3 * one.t) for one in TABLES]
    (doubt,) = undertow.read(slow, units={"x": "m", "t": "s"}).doubts
    assert f"swings with a period of 629 s, longer than {SLOWEST_S:g} s: is its time in ms?" in doubt
    both = [one.assign(t=1e3 * one.t, x=1e3 * one.x) for one in TABLES]
    (doubt,) = undertow.read(both, units={"x": "m", "t": "s"}).doubts
    assert "is its time in ms, and its displacement, 100 m at the release, in mm? correct" in doubt
    assert out_of_scale(undertow.read(TABLES, units={"x": "m"}).motions) == ()
    assert undertow.read(large, units={"x": "%"}).doubts == ()  # a scale that nobody calibrated is no length


def test_a_unit_that_contradicts_the_column_s_name_is_doubted_where_it_is_not_accepted():
    named = [one.rename(columns={"x": "x [mm]"}) for one in TABLES]
    trials = undertow.read(named, units={"x [mm]": "cm"})
    said = "units={\"displacement\": ...} is cm, and the name of column 'x [mm]' says mm: correct the unit"
    assert [one.startswith(said) for one in trials.doubts] == [True]
    assert f"! {said}" in str(trials)
    assert undertow.read(named, units={"x [mm]": "cm"}, accept=["unit"]).doubts == ()
    assert undertow.read(named).doubts == ()


def test_a_motion_says_itself_in_one_line():
    assert repr(undertow.read(TABLES, units={"x": "m"})[0]) == "Motion('trial_1': 600 samples, released from 0.05)"


def test_many_trials_are_refused_with_the_first_reasons():
    many = [FailedTrial(f"r{i}", f"trial r{i}: it does not swing") for i in range(5)]
    assert first_reasons(many) == "trial r0: it does not swing; trial r1: it does not swing; and 3 more trials"
    assert first_reasons(many[:2]).count(";") == 1
    assert first_reasons([many[0], many[0]]) == "trial r0: it does not swing"
    with pytest.raises(RecordingError, match=r"^column 'x' holds no number: all 600 values are missing; leave this"):
        undertow.read([one.assign(x=np.nan) for one in TABLES], units={"x": "m"})


def test_a_table_of_several_trials_and_an_array_of_several_are_told_how_they_are_given():
    stacked = pd.concat([one.assign(trial=i) for i, one in enumerate(TABLES)])
    with pytest.raises(RecordingError, match=r"as in undertow\.read\(\{str\(n\): one for n, one in table\.groupby\('t"):
        undertow.read(stacked, units={"x": "m"})
    given = {n: one for n, one in stacked.groupby("trial")}
    assert len(undertow.read({str(n): one for n, one in given.items()}, columns={"time": "t", "displacement": "x"},
                             units={"x": "m"})) == 2
    with pytest.raises(RecordingError, match=r"X has 4 columns without names: .* Give several trials as a list"):
        undertow.read(np.column_stack([TABLES[0].x] * 4), t=0.01, units={"x": "m"})


def test_an_equation_is_given_as_users_of_pysindy_ask_for_it():
    found = undertow.fit(undertow.read(TABLES, units={"x": "m"}), LAW, mass_kg=4.0)
    assert found.equations(precision=1) == ["4.0 x'' + 400.0 x + 2.0 v = 0"]
    assert found.equations()[0].startswith("4 x'' + 400.0")
    assert found.get_feature_names() == LAW
    assert found.coefficients().shape == (1, 2)
    assert found.coefficients()[0] == pytest.approx([400.0, 2.0], rel=1e-3)


def test_a_prediction_takes_tables_with_their_units_and_arrays_with_their_times():
    found = undertow.fit(undertow.read(TABLES, units={"x": "m"}), LAW, mass_kg=4.0)
    tables = found.predict(TABLES, units={"x": "m"})
    arrays = found.predict([one.x.to_numpy() for one in TABLES], t=0.01, units={"x": "m"})
    assert tables.runs[1].nrmse == pytest.approx(arrays.runs[1].nrmse, rel=1e-6)
    other = [one.rename(columns={"x": "pot 1", "t": "stamp"}).assign(x=0.0) for one in TABLES]
    named = found.predict(other, columns={"time": "stamp", "displacement": "pot 1"}, units={"pot 1": "m"})
    assert named.runs[0].nrmse == pytest.approx(tables.runs[0].nrmse, rel=1e-6)


def test_a_fitted_discover_knows_the_units_that_it_was_given():
    known = {"terms": LAW, "resamples": 0, "outside": False, "second_route": False}
    found = undertow.Discover(**known).fit(TABLES, units={"x": "m"})
    assert found.score(TABLES) == pytest.approx(found.score(TABLES, units={"x": "m"}))
    large = [one.assign(x=1e3 * one.x) for one in TABLES]
    assert found.score(large, units={"x": "mm"}) == pytest.approx(found.score(TABLES), abs=1e-9)
    assert found.score(found.trials_) == pytest.approx(found.score(TABLES))
    assert len(found.predict(TABLES)) == len(found.free_runs(TABLES)) == 2
    assert found.equations(precision=2) == ["1.00 x'' + 100.00 x + 0.50 v = 0"]
    with pytest.raises(NotDiscoveredError, match="has seen 0 trials"):
        undertow.Discover(**known).score(TABLES)
