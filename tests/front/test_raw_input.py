"""What a user hands over as it is: read-only arrays, a step in another unit, a law twice, a rate beside a time."""

from __future__ import annotations

import copy
import inspect
import pickle
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import undertow
from undertow.campaign.run.folder import run_to_folder
from undertow.comparison.beliefs import Belief
from undertow.errors import ConfigError, IdentificationError, RecordingError, UndertowError
from undertow.front.handover.exchange import equation_from_json
from undertow.front.trials import in_arguments

LAW = {"stiffness": 400.0, "viscous_damping": 2.0}
TERMS = list(LAW)
TIMES = np.arange(0.0, 6.0, 0.01)
NOISE_M = 1e-4


def decay(x0: float = 0.1, seed: int = 0) -> np.ndarray:
    """A recorded displacement (n,) at `TIMES`, m."""
    moved = undertow.simulate(LAW, x0=x0, mass_kg=4.0, times=TIMES).x
    return moved + NOISE_M * np.random.default_rng(seed).standard_normal(moved.size)


def read_only(values: np.ndarray) -> np.ndarray:
    """A copy that cannot be written to, as pandas hands them out."""
    values = values.copy()
    values.flags.writeable = False
    return values


KINDS = {
    "read_only": read_only,
    "series": pd.Series,
    "float32": lambda values: read_only(values.astype(np.float32)),
    "every second": lambda values: np.repeat(values, 2)[::2],
    "turned": lambda values: read_only(values[::-1])[::-1],
    "big endian": lambda values: values.astype(">f8"),
    "nullable": lambda values: pd.Series(values).astype("Float64"),
}
"""Name -> the same numbers as somebody else's library hands them over."""


def quick(**settings: object) -> undertow.Discover:
    """An estimator without what takes its time."""
    return undertow.Discover(**{"terms": TERMS, "resamples": 0, "outside": False, "second_route": False, **settings})


@pytest.fixture(scope="module")
def trials():
    """One decay, read."""
    return undertow.read((decay(), 0.01), units={"x": "m"})


@pytest.fixture(scope="module")
def fitted(trials):
    """Its equation by `fit`."""
    return undertow.fit(trials, TERMS, mass_kg=4.0)


@pytest.fixture(scope="module")
def discovered(trials):
    """Its equation by `Discover`."""
    return quick().fit(trials)


@pytest.mark.parametrize("kind", KINDS)
def test_times_of_any_kind_of_array_simulate_and_predict_alike(kind, fitted, discovered):
    times = KINDS[kind](TIMES)
    for given in (fitted, discovered):
        plain = given.simulate([0.1, 0.0], TIMES).x
        assert given.simulate([0.1, 0.0], times).x == pytest.approx(plain, abs=1e-6)
    moved = undertow.simulate(LAW, x0=0.1, mass_kg=4.0, times=times)
    assert moved.x == pytest.approx(undertow.simulate(LAW, x0=0.1, mass_kg=4.0, times=TIMES).x, abs=1e-6)
    assert np.isfinite(undertow.predict(fitted, x0=0.1, times=times).runs[0].lower).all()


@pytest.mark.parametrize("kind", KINDS)
def test_samples_of_any_kind_of_array_are_fitted_alike(kind, fitted, discovered):
    X, t = KINDS[kind](decay()), KINDS[kind](TIMES)
    found = undertow.fit(X, TERMS, t=t, units={"x": "m"}, mass_kg=4.0)
    assert found.parameters["value"].to_numpy() == pytest.approx(fitted.parameters["value"].to_numpy(), rel=1e-3)
    again = quick().fit(X, t=t, units={"x": "m"})
    assert again.coefficients_ == pytest.approx(discovered.coefficients_, rel=1e-3)
    assert len(undertow.read((X, t), units={"x": "m"})) == 1


def test_a_frame_of_channels_takes_its_times_beside_it_and_keeps_its_names():
    found = undertow.read(pd.DataFrame({"Weg": decay()}), t=pd.Series(TIMES), units={"Weg": "m"})
    assert found[0].amplitude == pytest.approx(0.1, rel=0.01)


@pytest.mark.parametrize(
    ("source", "t", "said"),
    [
        ("a.csv", 0.01, "t is given beside a str, which has a time of its own; leave t out"),
        (pd.DataFrame({"t": TIMES, "x": TIMES}), 0.01, "beside a table with the time in column 't'; leave one of them"),
        ([decay(), decay()], [0.01], "X holds 2 trials but t 1; give one time axis a trial"),
    ],
)
def test_times_that_belong_to_nothing_are_refused(source, t, said):
    with pytest.raises(RecordingError, match=said):
        undertow.read(source, t=t, units={"x": "m"})


@pytest.mark.parametrize("t", [10.0, TIMES * 1000.0])
def test_a_step_of_seconds_without_a_unit_is_refused_as_a_number_and_as_an_array(t):
    with pytest.raises(RecordingError, match="in seconds there would be a sample every 10 s; say it, as in units="):
        undertow.fit(decay(), TERMS, t=t, units={"x": "m"}, mass_kg=4.0)
    with pytest.raises(RecordingError, match="in seconds there would be a sample every 10 s"):
        quick().fit(decay(), t=t, units={"x": "m"})
    found = undertow.fit(decay(), TERMS, t=t, units={"x": "m", "t": "ms"}, mass_kg=4.0)
    assert found.parameters["value"].iloc[0] == pytest.approx(400.0, rel=0.01)


def test_a_rate_in_place_of_a_step_is_refused_with_the_step():
    with pytest.raises(RecordingError, match=r"where 100 Hz are meant t is 0\.01"):
        undertow.read((decay(), 100), units={"x": "m"})


def test_units_beside_a_step_that_are_no_mapping_are_refused():
    with pytest.raises(RecordingError, match=r"units is 'ft'; give a mapping, as in units="):
        undertow.read((decay(), 0.01), units="ft")


def test_a_law_that_is_named_twice_is_refused_everywhere(trials):
    with pytest.raises(ConfigError, match="equation names 'stiffness' twice; take one of them out"):
        undertow.fit(trials, ["stiffness", "stiffness"], mass_kg=4.0)
    with pytest.raises(IdentificationError, match="terms names 'stiffness' twice; take one of them out"):
        quick(terms=["stiffness", "viscous_damping", "stiffness"]).fit(trials)


def test_an_infinite_value_is_noted_as_one_and_left_out():
    X = decay()
    X[500] = np.inf
    notes = undertow.read((X, TIMES), units={"x": "m"})[0].recording.notes
    assert notes[:2] == (
        "displacement: 1 value is infinite and counts as missing",
        "displacement lacks 1 values in a gap, the longest of 0.01 s at 5 s: these samples are left out",
    )


def files(folder: Path, header: str, times: np.ndarray = TIMES) -> Path:
    """Three decays of two columns, in mm."""
    for i, x0 in enumerate((0.06, 0.08, 0.1)):
        rows = [f"{t:.6g},{1e3 * x:.5f}" for t, x in zip(times, decay(x0, i), strict=True)]
        (folder / f"decay{i}.csv").write_text("\n".join([header, *rows]) + "\n")
    return folder


def rated(folder: Path, rate_hz: float, **settings: object):
    """The files read with a rate and without their time."""
    return undertow.read(
        str(folder / "decay*.csv"), columns={"displacement": "Weg"}, units={"Weg": "mm"}, rate_hz=rate_hz, **settings
    )


def test_a_rate_that_contradicts_a_column_of_times_is_refused_until_it_is_accepted(tmp_path):
    folder = files(tmp_path, "Zeit,Weg")
    said = (
        "trial decay0: column 'Zeit' is a time with a sample every 0.01 s, which is 100 Hz, but rate_hz is 50 Hz; map "
        r'the column in columns=\{"time": ...\}, or list clock in accept=\[...\] where rate_hz is right'
    )
    with pytest.raises(RecordingError, match=said):
        rated(folder, 50.0)
    accepted = rated(folder, 50.0, accept=["clock"])
    assert accepted[0].recording.rate_hz == pytest.approx(50.0)
    assert accepted[0].recording.notes[0].startswith("accepted (clock): column 'Zeit' is a time")
    assert rated(folder, 100.2)[0].recording.notes == ()
    with pytest.raises(RecordingError, match=r"column 't' is a time with a sample every 0\.01 s, which is 100 Hz"):
        undertow.read(pd.DataFrame({"t": TIMES, "x": decay()}), units={"x": "m"}, rate_hz=50.0)


@pytest.mark.parametrize(
    ("header", "times"),
    [("Time,Weg", TIMES * 1000.0), ("time,Weg", np.arange(TIMES.size)), ("t [ms],Weg", TIMES * 1000.0),
     ("n,Weg", 0.02 * np.arange(TIMES.size)), ("t,Weg", np.round(TIMES, 1)), ("t,Weg", TIMES + 5.0 * (TIMES > 5.0))],
    ids=["milliseconds that nobody names", "rows counted", "milliseconds", "no name of a time", "no increase", "a gap"],
)  # fmt: skip
def test_a_rate_stands_beside_a_column_that_does_not_contradict_it(tmp_path, header, times):
    assert rated(files(tmp_path, header, times), 100.0)[0].recording.rate_hz == pytest.approx(100.0)


CONFIG = """name: rate
recordings:
  files: "decay*.csv"
  channels:
    time: {rate_hz: 50}
    displacement: {column: Weg, unit: mm}
specimen: {mass_kg: 4.0}
equation: {terms: [stiffness, viscous_damping]}
identify: [output_error]
discrepancy: {suspects: []}
"""


@pytest.mark.parametrize(
    ("t", "units", "said"),
    [
        (TIMES, {}, "t has times with a sample every 0.01 s, which is 100 Hz, but rate_hz is 50 Hz; leave one"),
        (0.01, {}, "t is a step of 0.01 s, which is 100 Hz, but rate_hz is 50 Hz; leave one of the two out"),
        (1e3 * TIMES, {"t": "ms"}, "a sample every 0.01 s, which is 100 Hz, but rate_hz is 50 Hz"),
    ],
)
def test_a_rate_that_contradicts_the_times_of_an_array_is_refused(t, units, said):
    with pytest.raises(RecordingError, match=said):
        undertow.read(decay(), t=t, rate_hz=50.0, units={"x": "m", **units})
    agreed = undertow.read(decay(), t=t, rate_hz=100.0, units={"x": "m", **units})
    assert agreed[0].recording.rate_hz == pytest.approx(100.0)


@pytest.mark.parametrize("empty", [np.nan, None])
def test_a_channel_of_which_no_value_is_there_is_said_to_be_left_out(tmp_path, empty):
    table = pd.DataFrame({"t": TIMES, "x": decay(), "a": empty})
    table.to_csv(tmp_path / "r1.csv", index=False)
    array = np.column_stack([decay(), np.gradient(decay(), TIMES), np.full(TIMES.size, np.nan)])
    for source, settings in ((table, {}), (tmp_path / "r1.csv", {}), (array, {"t": 0.01})):
        units = {"x": "m", "v": "m/s"} if settings else {"x": "m"}
        (doubt,) = undertow.read(source, units=units, **settings).doubts
        assert doubt.endswith("acceleration has no values: left out in this trial")


def test_a_config_whose_rate_contradicts_the_files_is_not_run(tmp_path):
    path = files(tmp_path, "t,Weg") / "c.yaml"
    path.write_text(CONFIG)
    with pytest.raises(UndertowError, match=r"which is 100 Hz, but rate_hz is 50 Hz; map the column in recordings\."):
        run_to_folder(path, out=tmp_path / "run", jobs=1, page=False)
    path.write_text(CONFIG.replace("  channels:", '  accept: {"*": [clock]}\n  channels:'))
    assert len(undertow.load(path)) == 3


def test_a_gravity_and_a_density_that_are_not_the_usual_are_doubted_in_the_run(tmp_path):
    path = files(tmp_path, "t,Weg") / "c.yaml"
    text = CONFIG.replace("{rate_hz: 50}", "{column: t, unit: s}")
    path.write_text(text.replace("mass_kg: 4.0", "mass_kg: 4.0, gravity_m_per_s2: 8.5, water_density_kg_per_m3: 800"))
    done = run_to_folder(path, out=tmp_path / "run", jobs=1, page=False)
    assert "doubt: specimen.gravity_m_per_s2 is 8.5 m/s^2, and 9.7 to 9.9 on Earth: correct it, unless" in done.summary
    assert "specimen.water_density_kg_per_m3 is 800 kg/m^3, and 950 to 1100 in laboratories and at sea" in done.summary


@pytest.mark.parametrize("given", ["0.1", None, 1j])
def test_a_start_that_is_no_number_is_refused_with_its_type(given):
    kind = type(given).__name__
    with pytest.raises(UndertowError, match=rf"x0 is '?\w+[.\d]*'?, of type {kind}; give a number in m or rad"):
        undertow.simulate(LAW, x0=given)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"resamples": "a"}, "resamples is 'a'; give how many resamples are drawn, 0 or more, as 100"),
        ({"resamples": -1}, "resamples is -1; give how many"),
        ({"resamples": 2.5}, r"resamples is 2\.5; give how many"),
        ({"rival_difference": "x"}, "rival_difference is 'x'; give a difference of the criterion"),
        ({"signs": "no"}, "signs is 'no'; give True or False"),
        ({"beliefs": [3]}, r"beliefs holds 3, of type int; give a list of undertow\.comparison\.beliefs\.Belief"),
        ({"beliefs": {"stiffness": 3}}, "beliefs holds {'stiffness': 3}, of type dict; give a list of"),
        ({"beliefs": ("stiffness",)}, "beliefs holds 'stiffness', of type str; give a list of"),
        ({"beliefs": Belief({"stiffness": 1.0}, 100.0, 1.0)}, "beliefs is one Belief; give a list of them"),
        ({"scatter": {"stiffness": 10.0}}, r"scatter of 'stiffness' is 10, relative, and is 0\.5 at most: 10 %"),
    ],
)
def test_a_setting_of_discover_that_is_no_number_is_refused_by_its_name(trials, settings, said):
    with pytest.raises(IdentificationError, match=said):
        quick(**settings).fit(trials)


@pytest.mark.parametrize("seed", ["x", -1, 1.5])
def test_a_seed_that_is_none_is_refused_wherever_something_is_drawn(seed, trials, fitted, discovered):
    run = undertow.simulate(LAW, x0=0.1, mass_kg=4.0, times=TIMES)
    said = rf"seed is {seed!r}; give an integer from 0 on"
    for draw in (
        lambda: fitted.predict(trials, seed=seed), lambda: fitted.posterior(10, seed=seed),
        lambda: discovered.posterior(10, seed=seed), lambda: run.recorded(seed=seed),
    ):  # fmt: skip
        with pytest.raises(UndertowError, match=said):
            draw()
    with pytest.raises(UndertowError, match=f"random_state is {seed!r}; give an integer"):
        quick(random_state=seed).fit(trials)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda f, trials: undertow.simulate(f, 0.1, mass_kg=8.0), "mass_kg is 8, but equation, of type Fitted, has"),
        (lambda f, trials: undertow.simulate(LAW, 0.1, mass_kg="4"), "mass_kg is '4', of type str; give a number in"),
        (lambda f, trials: undertow.simulate(LAW, 0.1, mass_kg=4.0, duration_s=1e12), "9.55e.13 samples; at most 100"),
        (lambda f, trials: f.print("a"), "precision is 'a'; give how many decimals, 0 or more"),
        (lambda f, trials: f.equations(-1), "precision is -1; give how many decimals"),
        (lambda f, trials: f.simulate(0.1).recorded(noise_m=-1.0), "noise_m is -1; give 0 or more"),
        (lambda f, trials: undertow.fit(trials[9:], TERMS), "source holds 0 trials; choose one at least"),
        (lambda f, trials: undertow.fit(trials, LAW), "equation gives numbers of stiffness, viscous_damping, and a fi"),
        (lambda f, trials: undertow.fit(trials, f), "equation is the single Fitted; give a list of names"),
        (lambda f, trials: undertow.fit(trials, TERMS, u=[decay()] * 9), "u is list of 9 entries, but nothing is called"
         r" so; a body that an input drives is fitted by undertow\.fit_driven"),
        (lambda f, trials: undertow.fit(trials, TERMS, foo=decay()), r"foo is ndarray of shape \(600,\), but nothing"),
        (lambda f, trials: undertow.diagnose(trials, TERMS, jobs=-2), "jobs is -2; give how many processes, or 0 for"),
        (lambda f, trials: undertow.read([decay()] * 2, t=0.01, units={"x": "m"}, names=["a", "a"]),
         "names has 'a' 2 times; give each trial its own"),
        (lambda f, trials: equation_from_json(Path("d.json")), "text is of type PosixPath; give what to_json"),
    ],
)  # fmt: skip
def test_a_value_that_means_nothing_is_refused_in_a_sentence(call, said, fitted, trials):
    with pytest.raises(UndertowError, match=said) as caught:
        call(fitted, trials)
    assert "\n" not in str(caught.value)


def test_terms_known_that_are_one_law_are_named(trials):
    given = quick(terms=["stiffness", "viscous_damping", "linear_damping"], known=("viscous_damping", "linear_damping"))
    with pytest.raises(IdentificationError, match="known terms viscous_damping, linear_damping are combinations"):
        given.fit(trials)


@pytest.mark.parametrize("form", ["%Y-%m-%d %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S.%f"])
def test_a_column_of_texts_of_dates_is_a_time(form):
    clock = pd.date_range("2024-01-01", periods=TIMES.size, freq="10ms")
    seen = undertow.read(pd.DataFrame({"t": clock.strftime(form), "x": decay()}), units={"x": "m"})[0].recording
    assert seen.rate_hz == pytest.approx(100.0)
    spoiled = clock.strftime(form).to_series(index=range(TIMES.size))
    spoiled[3] = "??"
    with pytest.raises(RecordingError, match=r"column 't' holds what is no number, .*write None or NaN where a value"):
        undertow.read(
            pd.DataFrame({"t": spoiled, "x": decay()}), {"time": "t", "displacement": "x"}, {"x": "m"}
        )


def test_what_is_noted_of_arrays_names_arguments_and_no_keys_of_a_config():
    said = in_arguments("x: 3 samples look like spikes; state recordings.despike if they are")
    assert said == "x: 3 samples look like spikes; write NaN in their place if they are"
    spiky = decay()
    spiky[200:500:60] += 0.05
    assert not any("recordings." in note for note in undertow.read(spiky, t=0.01, units={"x": "m"}).notes)


def test_a_copy_that_is_added_is_no_more_evidence(trials):
    both = trials + trials
    assert both.names == trials.names
    assert [one.reason.partition(", ")[0] for one in both.failed] == [
        f"trial {name} is the same recording as {name}" for name in trials.names
    ]
    assert (trials[:1] + trials[1:]).failed == ()


def test_a_discover_from_a_pickle_can_be_printed(discovered):
    again = pickle.loads(pickle.dumps(discovered))  # noqa: S301 - our own bytes
    assert str(again) == str(discovered) == again.fit_report()


def test_a_misspelt_parameter_is_a_value_error_that_names_the_nearest():
    with pytest.raises(ValueError, match=r"no parameter 'resample' \(did you mean 'resamples'\?\); it has beliefs"):
        undertow.Discover().set_params(resample=3)


def test_a_run_with_one_group_predicts_and_one_with_several_says_which_to_choose(tmp_path, trials):
    path = files(tmp_path, "t,Weg") / "c.yaml"
    path.write_text(CONFIG.replace("{rate_hz: 50}", "{column: t, unit: s}"))
    run_to_folder(path, out=tmp_path / "run", jobs=1, page=False)
    opened = undertow.open(tmp_path / "run")
    ahead = undertow.predict(opened, trials)
    assert ahead.score() > 0.98
    assert np.isfinite(ahead.runs[0].lower).all()
    assert undertow.simulate(opened, x0=0.1, times=TIMES).x.size == TIMES.size
    twice = type(opened)(opened.folder, opened.groups * 2)
    with pytest.raises(UndertowError, match=r"OpenedRun has 2 groups .*each with an equation of its own; choose"):
        undertow.predict(twice, trials)


def test_diagnose_takes_arrays_with_their_times_and_units():
    X = [decay(x0, i) for i, x0 in enumerate((0.06, 0.08, 0.1))]
    found = undertow.diagnose(X, TERMS, t=0.01, units={"x": "m"}, mass_kg=4.0, suspects=[])
    assert len(found[0].findings.trials) == 3


def test_a_scatter_in_per_cent_and_a_gravity_in_g_are_refused(trials):
    with pytest.raises(ConfigError, match=r"specimen\.scatter\.c is 10, relative, and is 0\.5 at most: 10 % is 0\.1"):
        undertow.diagnose(trials, TERMS, scatter={"k": 0.01, "c": 10.0})
    with pytest.raises(ConfigError, match=r"gravity_m_per_s2 is 1 m/s\^2, less than the Moon's .*; 1 g is 9\.81"):
        undertow.fit(trials, TERMS, gravity_m_per_s2=1.0)


@pytest.mark.parametrize("density", [1.0, 1.025])
def test_a_density_in_grams_per_cubic_centimetre_is_refused(trials, density):
    said = rf"density_kg_per_m3 is {density:g} kg/m\^3, no liquid's .*; 1 g/cm\^3 is 1000"
    with pytest.raises(ConfigError, match=said):
        undertow.fit(trials, TERMS, water_density_kg_per_m3=density)


def test_a_discover_can_be_listed_and_inspected_before_and_after_fit(discovered):
    for one in (quick(), discovered, pickle.loads(pickle.dumps(discovered))):  # noqa: S301 - our own bytes
        assert "predict" in dir(one)
        assert "predict" in dict(inspect.getmembers(one))


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_a_copy_of_a_discover_keeps_its_trials(discovered, copied):
    again = copied(discovered)
    assert again.score() == discovered.score()
    assert again.trials_.names == discovered.trials_.names


def test_truth_values_are_no_recording():
    with pytest.raises(RecordingError, match="X holds truth values, and no numbers; give what the sensor said"):
        undertow.read(decay() > 0.0, t=0.01, units={"x": "m"})
    table, columns = pd.DataFrame({"t": TIMES, "x": decay() > 0.0}), {"time": "t", "displacement": "x"}
    with pytest.raises(RecordingError, match="column 'x' holds truth values, and no numbers"):
        undertow.read(table, columns, {"x": "m", "t": "s"})


def test_what_fits_takes_all_that_read_does(trials):
    table = pd.DataFrame({"x_mm": 1000.0 * decay()})
    known = {"rate_hz": 100.0, "names": ["one"], "window": (0.0, 4.0), "accept": ["damping"]}
    read = undertow.read(table, **known)
    fitted = undertow.fit(table, TERMS, mass_kg=4.0, **known)
    assert fitted.trials.names == ("one",)
    assert fitted.estimates == undertow.fit(read, TERMS, mass_kg=4.0).estimates
    assert quick().fit(table, **known).trials_[0].window == read[0].window
    said = undertow.diagnose(table, TERMS, mass_kg=4.0, suspects=["cubic_stiffness"], **known)
    assert said[0].trials.names == ("one",)
    with pytest.raises(RecordingError, match=r"^names, accept is given, but these trials are read; give it to"):
        undertow.fit(trials, TERMS, names=["one"], accept=["damping"])
    with pytest.raises(RecordingError, match=r"rate_hz is 100.0, but with u x is an array"):
        quick().fit(decay(), t=0.01, u=decay(), rate_hz=100.0)


def test_times_given_by_place_and_words_that_are_none_are_said():
    with pytest.raises(RecordingError, match=r"^the second argument is y, .* by name, as in t=0.01; without them"):
        quick().fit(decay(), TIMES, units={"x": "m"})
    with pytest.raises(RecordingError, match=r"^feature_names is no argument of fit; it takes t, u, hold, columns, "):
        quick().fit(decay(), t=0.01, units={"x": "m"}, feature_names=["x"])
    with pytest.raises(RecordingError, match=r"^(?!the second argument).*no unit"):
        quick().fit(decay(), TIMES, t=0.01)


def test_a_trial_without_a_number_is_what_is_blamed():
    with pytest.raises(RecordingError, match=r"column 'x' holds no number: all \d+ values are missing; leave this"):
        undertow.fit([decay(), decay() * np.nan], TERMS, t=0.01, units={"x": "m"})


def test_a_simulated_motion_is_an_array_of_its_states(discovered):
    run = discovered.simulate([0.1, 0.0], TIMES[:50])
    assert run.shape == np.shape(run) == (50, 2)
    assert np.array_equal(run[:, 0], run.x)
    assert np.array_equal(np.asarray(run, dtype=np.float32)[:, 1], run.v.astype(np.float32))
    assert len(run) == 50
    assert float(np.max(np.abs(run - run[:]))) == 0.0


def test_a_trial_that_cannot_be_used_is_reported_and_results_never_shift(discovered, fitted):
    still = np.full(TIMES.size, 0.1)
    several = [still, decay(), decay(0.06, 1)]
    found = quick().fit(several, t=0.01, units={"x": "m"})
    assert found.n_trials_in_ == 2
    (reason,) = (one.reason for one in found.failed_)
    assert str(found).startswith(f"not used: {reason}\n")
    assert "<p>not used: " in found._repr_html_()
    named = dict(zip(("still", "a", "b"), several, strict=True))
    tables = {name: pd.DataFrame({"t": TIMES, "x_m": x}) for name, x in named.items()}
    for ask in (discovered.predict, discovered.score, fitted.score, fitted.free_runs):
        with pytest.raises(RecordingError, match=r"^1 of 3 trials cannot be used: trial still.*; leave it out"):
            ask(tables)
        ask(undertow.read(tables))


def test_a_header_that_contradicts_the_unit_and_an_acceleration_that_no_rig_bears_are_doubted(tmp_path):
    """A column "Weg [mm]" read as m, 60 m at 1.6 Hz: a green page had said nothing of it."""
    path = files(tmp_path, "t,Weg [mm]") / "c.yaml"
    text = CONFIG.replace("{rate_hz: 50}", "{column: t, unit: s}").replace("column: Weg,", 'column: "Weg [mm]",')
    path.write_text(text.replace("unit: mm}", "unit: m}"))
    said = run_to_folder(path, out=tmp_path / "run", jobs=1, page=False).summary
    assert "displacement.unit is m, and the name of column 'Weg [mm]' says mm: correct the unit" in said
    assert "g, more than 100: is it in mm? correct recordings.channels.displacement.unit" in said
    path.write_text(text)
    said = run_to_folder(path, out=tmp_path / "fine", jobs=1, page=False).summary
    assert "the name of column" not in said
    assert "more than 100" not in said
