"""`undertow.fit`, `simulate` and `predict`: numbers come back within their errors, with their unit and their doubts."""

from __future__ import annotations

import copy
import dataclasses
import importlib.util
import json
import pickle
import warnings

import numpy as np
import pytest

import undertow
from undertow.equation.equation import Equation
from undertow.equation.structure import Stiffness
from undertow.errors import ConfigError, IdentificationError, RecordingError, UndertowError
from undertow.uncertainty.posterior import posterior_draws

MASS_KG = 4.0
LAW = {"stiffness": 400.0, "viscous_damping": 1.0, "quadratic_drag": 6.0}
TRUTH = {"k_N_per_m": 400.0, "c_Ns_per_m": 1.0, "drag_Ns2_per_m2": 6.0}
TERMS = list(LAW)
NOISE_M = 2e-4


def recorded(x0: float, seed: int, law=None, mass_kg: float = MASS_KG, **settings):
    run = undertow.simulate(law or LAW, x0=x0, mass_kg=mass_kg, rate_hz=60.0, duration_s=7.0)
    return run.recorded(noise_m=NOISE_M, seed=seed, name=f"r{seed}", **settings)


@pytest.fixture(scope="module")
def trials():
    return undertow.read([recorded(x0, seed) for seed, x0 in enumerate((0.05, 0.1))])


@pytest.fixture(scope="module")
def found(trials):
    return undertow.fit(trials, TERMS, mass_kg=MASS_KG)


def test_where_nobody_knows_whether_a_logger_averages_errors_hold_both():
    law = {"stiffness": 100.0, "viscous_damping": 0.5, "cubic_stiffness": 3000.0}
    held = [
        np.concatenate([np.full(50, x0), undertow.simulate(law, x0=x0, rate_hz=100.0, duration_s=8.0).x])
        for x0 in (0.05, 0.1, 0.15)
    ]
    seen = []
    for seed in (103, 105, 112):  # by chance means fit a little better here
        rng = np.random.default_rng(seed)
        given = [x + 1e-4 * rng.standard_normal(x.size) for x in held]
        trials = undertow.read(given, t=0.01, units={"x": "m"})
        row = undertow.fit(trials, list(law), mass_kg=1.0).parameters.loc["cubic_stiffness_N_per_m3"]
        seen.append((row["value"] - 3000.0) / row["stderr"])
    # the two differ by 3.5 N/m^3, 7 standard errors of the noise alone
    assert max(map(abs, seen)) < 3.0


def test_a_mass_that_a_stated_stiffness_makes_twice_the_stated_one_is_doubted_by_fit_too(trials):
    found = undertow.fit(trials, TERMS, mass_kg=MASS_KG, stiffness_N_per_m=800.0)
    (doubt,) = found.doubts
    assert doubt.startswith("moving mass over stated mass, in an equation without added mass, ")
    assert float(doubt.split("mass, ")[2].split()[0]) == pytest.approx(2.0, abs=1e-3)
    assert "lies outside 0.9 to 1.3: look at mass_kg and stiffness_N_per_m, the load cells" in doubt
    assert f"! {doubt}" in str(found)
    assert undertow.fit(trials, TERMS, mass_kg=MASS_KG, stiffness_N_per_m=400.0).doubts == ()


def test_a_release_in_another_unit_is_blamed_on_the_unit_and_not_on_a_sign():
    law = {"stiffness": 400.0, "viscous_damping": 1.0, "quadratic_drag": 6.0}
    x = undertow.simulate(law, x0=0.1, mass_kg=MASS_KG, rate_hz=100.0, duration_s=20.0).x
    x = x + NOISE_M * np.random.default_rng(0).standard_normal(x.size)
    found = undertow.fit(x, TERMS, t=0.01, units={"x": "m"})
    said = r"trial trial_1 is released from 100 m, 1000 times the largest that was fitted .*: look at the unit"
    with pytest.raises(IdentificationError, match=said):
        found.score(1000.0 * x, t=0.01, units={"x": "m"})


def test_dry_arrays_are_said_to_need_a_read_of_their_own(trials):
    x = np.asarray(trials[0].recording.channels["displacement"])
    with pytest.raises(RecordingError, match=r"dry is of type ndarray; .* give dry=undertow\.read\(dry, t="):
        undertow.fit(trials, TERMS, mass_kg=MASS_KG, dry=x)


def test_an_error_of_a_fit_names_no_key_of_a_config(trials, monkeypatch):
    def none(*given: object) -> None:
        raise IdentificationError("output error cannot start: set trials.window, or specimen.mass_kg")

    monkeypatch.setattr("undertow.front.fitting.fit_group", none)
    with pytest.raises(IdentificationError, match=r"cannot start: set window=\(start_s, end_s\), or mass_kg$"):
        undertow.fit(trials, TERMS)


# ---------------------------------------------------------------- results as Python's own objects


def test_every_result_goes_through_a_pickle_and_a_deep_copy(trials, found):
    results = (
        trials, trials[0], found, found.predict(trials), undertow.simulate(LAW, x0=0.1), found.equation,
        undertow.diagnose(trials, TERMS),
    )  # fmt: skip
    for one in results:
        assert str(pickle.loads(pickle.dumps(one))) == str(copy.deepcopy(one)) == str(one)  # noqa: S301


def test_results_are_compared_as_objects_and_not_sample_by_sample(trials, found):
    again = undertow.read([recorded(x0, seed) for seed, x0 in enumerate((0.05, 0.1))])
    assert trials != again
    assert found != undertow.fit(trials, TERMS, mass_kg=MASS_KG)
    assert len({trials, again, found, trials[0], trials.recordings[0]}) == 5


# ---------------------------------------------------------------- fit
def test_a_fit_gives_the_planted_numbers_within_their_errors(found):
    table = found.parameters
    assert list(table.columns) == ["value", "stderr", "low", "high", "unit", "note"]
    for name, true in TRUTH.items():
        row = table.loc[name]
        assert abs(row["value"] - true) < 4.0 * row["stderr"]
        assert row["high"] - row["low"] == pytest.approx(2.0 * 1.645 * row["stderr"], rel=0.01)
    assert found.get_feature_names_out().tolist() == TERMS


@pytest.mark.parametrize("method", ["normal", "profile"])
def test_intervals_by_both_methods_hold_about_the_same(found, method):
    table = found.confidence_interval(0.99, method)
    assert list(table.columns) == ["low", "high"]
    for name, true in TRUTH.items():
        assert table.loc[name, "low"] < true < table.loc[name, "high"]
    narrow = found.confidence_interval(0.5, method)
    assert (narrow["high"] - narrow["low"] < table["high"] - table["low"]).all()


def test_an_interval_of_another_kind_is_refused(found):
    with pytest.raises(IdentificationError, match="method is 'bootstrap'; an interval is 'normal' or 'profile'"):
        found.confidence_interval(method="bootstrap")


def test_a_fit_is_printed_simulated_and_scored_as_users_of_pysindy_do(found, trials, capsys):
    (line,) = found.equations()
    assert line == found.equation.text(found._errors())
    assert line in str(found)
    found.print()
    assert capsys.readouterr().out == line + "\n"
    t = np.arange(0.0, 3.0, 0.02)
    moved = found.simulate([0.1, 0.2], t)
    assert (moved.x == found.simulate(0.1, t, v0=0.2).x).all()
    assert (moved.x[0], moved.v[0]) == (0.1, 0.2)
    X, times = [1e3 * m.recording.channels["displacement"] for m in trials], [m.recording.time for m in trials]
    assert found.score(X, t=times, units={"x": "mm"}) == pytest.approx(found.score(), abs=1e-4)
    assert found.score(trials.recordings) == found.score()
    with pytest.raises(UndertowError, match=r"x0 has 3 numbers; give the displacement, or \[displacement, velocity\]"):
        found.simulate([0.1, 0.0, 0.0], t)
    with pytest.raises(UndertowError, match=r"x0 is \[0.1, 0.2\] and v0 1, two velocities; give one of the two"):
        found.simulate([0.1, 0.2], t, v0=1.0)


def test_a_fit_scores_unseen_trials_and_a_wrong_equation_scores_less(found, trials):
    unseen = undertow.read([recorded(0.08, 7)])
    assert found.score(unseen) > 0.985
    bare = undertow.fit(trials, ["stiffness", "viscous_damping"], mass_kg=MASS_KG)
    assert bare.score(unseen) < 0.97
    assert any("times the sensors' noise: the equation lacks something" in one for one in bare.doubts)
    assert not found.doubts
    assert f"! {bare.doubts[0]}" in str(bare)


def test_print_and_html_say_equation_numbers_and_anchor(found):
    text, html = str(found), found._repr_html_()
    for said in (text, html):
        assert "output error on 2 trials together" in said
        assert "mass 4 kg, as given" in said
        assert "drag_Ns2_per_m2" in said
    assert "4 kg" not in str(dataclasses.replace(found, anchor=dataclasses.replace(found.anchor, sentence="<b>")))
    assert "&lt;b&gt;" in dataclasses.replace(
        found, anchor=dataclasses.replace(found.anchor, sentence="<b>")
    )._repr_html_()


def test_without_a_mass_numbers_are_over_it_and_the_result_says_so(trials):
    bare = undertow.fit(trials, TERMS)
    assert bare.parameters.loc["k_N_per_m_per_mass", "value"] == pytest.approx(100.0, rel=0.01)
    assert "per" in bare.anchor.sentence


def test_dry_trials_give_kilograms_and_are_held():
    wet = {"stiffness": 400.0, "viscous_damping": 1.0, "quadratic_drag": 6.0, "added_mass": 1.5}
    dry = {"stiffness": 400.0, "viscous_damping": 1.0}
    trials = [recorded(x0, i, wet) for i, x0 in enumerate((0.06, 0.1))]
    known = [recorded(x0, 10 + i, dry) for i, x0 in enumerate((0.05, 0.08, 0.1))]
    terms = ["stiffness", "viscous_damping", "added_mass", "quadratic_drag"]
    found = undertow.fit(trials, terms, dry=known, mass_kg=MASS_KG)
    assert found.parameters.loc["added_mass_kg", "value"] == pytest.approx(1.5, abs=0.1)
    assert "k and c are held" in found.notes[0]  # of friction it has none
    with pytest.raises(IdentificationError, match="dry holds 3 trials but mass_kg is nan"):
        undertow.fit(trials, terms, dry=known)
    with pytest.raises(IdentificationError, match="stiffness, viscous_damping has no unknown left"):
        undertow.fit(trials, ["stiffness", "viscous_damping"], dry=known, mass_kg=MASS_KG)


def test_a_mass_beside_added_mass_is_not_enough_and_the_result_says_so(trials):
    found = undertow.fit(trials, [*TERMS, "added_mass"], mass_kg=MASS_KG)
    assert "alone cannot part the body's mass from added mass" in found.notes[0]


def test_an_equation_that_is_none_is_refused(trials):
    with pytest.raises(ConfigError, match="equation is the single 'stiffness'; give a list of names"):
        undertow.fit(trials, "stiffness")
    with pytest.raises(ConfigError, match="equation is the single <built-in function abs>; give a list of names"):
        undertow.fit(trials, abs)
    with pytest.raises(ConfigError, match="equation has 0 terms; name some"):
        undertow.fit(trials, [])
    with pytest.raises(ConfigError, match=r"^mass_kg is -1 kg but must be larger than 0"):
        undertow.fit(trials, TERMS, mass_kg=-1.0)


def test_trials_of_two_waters_with_two_areas_are_refused():
    two = [recorded(0.05, 0, conditions={"depth": 1.0}), recorded(0.1, 1, conditions={"depth": 2.0})]
    with pytest.raises(UndertowError, match=r"the rig differs between the 2 trials \(area_m2 0.1 and 0.2\); fit"):
        undertow.fit(two, TERMS, mass_kg=MASS_KG, area_m2={"by": "depth", "1.0": 0.1, "2.0": 0.2})


def test_figures_show_the_trial_that_was_asked_for(found):
    axes = found.plot(trial="r1")
    assert axes.get_title().startswith("r1: free-run error")
    assert [line.get_label() for line in axes.lines] == ["measured", "free run"]
    left = found.plot_residual(trial=0).lines[0].get_ydata()
    assert np.std(left) == pytest.approx(1e3 * NOISE_M, rel=0.15)  # mm, the sensor's noise
    assert found.plot_corner(draws=100).shape == (3, 3)


# ---------------------------------------------------------------- posterior
def test_draws_spread_as_the_likelihood_does_and_not_wider_than_the_errors(found):
    drawn = found.posterior(4000, seed=1)
    assert drawn.outcome == "ok"
    assert drawn.effective > 0.9 * drawn.candidates  # with little noise the likelihood is close to a parabola
    profile = found.confidence_interval(0.9, "profile")
    for name in TRUTH:
        row, ends = found.parameters.loc[name], profile.loc[name]
        width = ends["high"] - ends["low"]
        assert drawn.quantiles(name) == pytest.approx(ends.to_list(), abs=0.06 * width)  # 4000 draws: 2 %, twice over
        assert np.std(drawn.values[name]) < 1.1 * row["stderr"]


def test_too_few_draws_and_unknown_names_are_refused(found):
    with pytest.raises(IdentificationError, match="draws is 1; a posterior needs at least 2"):
        found.posterior(1)
    with pytest.raises(IdentificationError, match="draws of 'mu': the fit has"):
        posterior_draws(found.group.solution, 10, 0, names=["mu"])


def test_arviz_gets_chains_of_draws_or_is_asked_for(found):
    with pytest.raises(UndertowError, match="chains is 0; give at least 1"):
        found.to_arviz(chains=0)
    if importlib.util.find_spec("arviz") is None:
        with pytest.raises(UndertowError, match=r"to_arviz needs ArviZ.*pip install 'undertow\[arviz\]'"):
            found.to_arviz()
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # ArviZ announces its next version while it is imported
        made = found.to_arviz(draws=50, chains=2)
    assert made["posterior"]["k_N_per_m"].shape == (2, 50)
    assert made["posterior"].attrs["inference_library"] == "undertow"


# ---------------------------------------------------------------- predict
def test_a_prediction_of_an_unseen_trial_holds_it_in_its_band(found):
    unseen = undertow.read([recorded(0.08, 7)])
    ahead = found.predict(unseen)
    run = ahead.runs[0]
    assert run.nrmse < 0.03
    assert run.inside > 0.8
    assert (run.lower <= run.predicted).all()
    assert (run.predicted <= run.upper).all()
    assert found.predict(unseen, adjust=True).score() > ahead.score() - 1e-9
    assert list(ahead.table.columns) == ["trial", "time_s", "measured", "predicted", "lower", "upper"]
    assert "inside the 90% band" in str(ahead)
    assert "r7" in ahead._repr_html_()
    assert ahead.plot().get_title().startswith("r7: error")


def test_an_equation_from_a_start_is_run_as_it_is_simulated(found):
    times = np.arange(0.0, 3.0, 0.01)
    ahead = undertow.predict(found.equation, x0=0.05, times=times, rest_m=0.01)
    run = undertow.simulate(found.equation, x0=0.05, times=times)
    assert ahead.runs[0].predicted == pytest.approx(run.x + 0.01, abs=1e-9)
    assert ahead.notes == ("no band: an equation alone has no errors",)


def test_a_prediction_without_what_it_needs_is_refused(found, trials):
    with pytest.raises(UndertowError, match=r"x0 is 0.1 and times None; give trials or both"):
        undertow.predict(found, x0=0.1)
    with pytest.raises(UndertowError, match=r"x0 is 0.1 beside trials, which have their own"):
        undertow.predict(found, trials, x0=0.1)
    with pytest.raises(UndertowError, match="level is 90; the band's share must lie between 0 and 1"):
        undertow.predict(found, trials, level=90.0)
    with pytest.raises(UndertowError, match="adjust is True but a Equation cannot be fitted to trial r0"):
        undertow.predict(found.equation, trials, adjust=True)


@pytest.mark.parametrize("times", [[0.0, -0.1], [0.2, 0.1], [0.0, 0.1, 0.1], [], [[0.0], [0.1]], 0.01])
def test_times_that_are_no_rising_list_are_refused_by_prediction_and_simulation_alike(found, times):
    with pytest.raises(UndertowError, match=r"increasing and not negative|shape .*; give instants"):
        undertow.predict(found, x0=0.1, times=times)
    with pytest.raises(UndertowError, match=r"increasing and not negative|shape .*; give instants"):
        found.simulate([0.05, 0.0], times)


@pytest.mark.parametrize("draws", [0, 1, -3, 2.5])
def test_a_band_of_too_few_draws_is_refused(found, draws):
    with pytest.raises(UndertowError, match=rf"draws is {draws}; a band is made of 2 equations at least, as 200"):
        undertow.predict(found, x0=0.1, times=[0.0, 0.1], draws=draws)


# ---------------------------------------------------------------- simulate
def test_a_body_that_nothing_moves_stays_at_rest():
    law = {**LAW, "hidden_resonator": {"mass_kg": 1.0, "natural_frequency_rad_per_s": 9.0, "damping_ratio": 0.01}}
    for equation in (LAW, law, Equation((Own(),), (400.0,), mass_kg=MASS_KG)):
        run = undertow.simulate(equation, x0=0.0, duration_s=1.0, rate_hz=50.0)
        assert not np.any([run.x, run.v, run.a])
    assert "  from x0 = 0 (SI), 0.98 s" in str(undertow.predict(LAW, x0=0.0, times=run.t))


def test_what_cannot_be_simulated_is_refused():
    with pytest.raises(UndertowError, match=r"times has 2 instants and duration_s is 1.0"):
        undertow.simulate(LAW, x0=0.1, times=[0.0, 1.0], duration_s=1.0)
    with pytest.raises(UndertowError, match="duration_s is -1 s at 60 Hz; both must be positive"):
        undertow.simulate(LAW, x0=0.1, duration_s=-1.0, rate_hz=60.0)
    with pytest.raises(UndertowError, match=r"samples are 0.1 to 0.2 s apart; a recording needs even ones"):
        undertow.simulate(LAW, x0=0.1, times=[0.0, 0.1, 0.3, 0.4]).recorded()
    with pytest.raises(UndertowError, match="v0 is 1 m/s; a body that moves was not held: give hold_s=0"):
        undertow.simulate(LAW, x0=0.1, v0=1.0, duration_s=1.0).recorded()


class Own(Stiffness):
    """A spring of a user's own: its force is found by calling it."""

    name = "own_spring"
    slots = {}  # noqa: RUF012


class Unreadable:
    """An object whose own text cannot be made."""

    def __repr__(self) -> str:
        raise AttributeError("no text")


@pytest.mark.parametrize(
    ("force", "said"),
    [
        (lambda x: 1.0, r"own_spring: its force has the shape \(\) for 5 samples of x, v, a and t; give one number"),
        (lambda x: x[:3], r"own_spring: its force has the shape \(3,\) for 5 samples"),
        (lambda x: x if abs(x) < 1.0 else -x, r"own_spring: its force cannot be calculated from .*ambiguous.*np.where"),
        (lambda x: 1 / 0, r"own_spring: its force cannot .* from arrays of 5 samples \(division by zero, ZeroDiv"),
    ],
)
def test_a_law_of_your_own_that_gives_no_number_a_sample_is_refused(trials, monkeypatch, force, said):
    monkeypatch.setattr(Own, "force", lambda self, x, v, a, t: force(x))
    with pytest.raises(IdentificationError, match=said):
        undertow.fit(trials, [Own(), "viscous_damping"], mass_kg=MASS_KG)


def test_a_law_of_your_own_that_is_called_like_another_is_refused(trials, monkeypatch):
    with pytest.raises(ConfigError, match=r"equation names 'own_spring' twice; .* or rename"):
        undertow.fit(trials, [Own(), Own()])
    monkeypatch.setattr(Own, "name", "stiffness")
    with pytest.raises(ConfigError, match="equation names 'stiffness' twice"):
        undertow.fit(trials, ["stiffness", Own()])
    with pytest.raises(IdentificationError, match=r"terms names 'stiffness' twice; .* rename your own"):
        undertow.Discover(terms=["stiffness", Own()]).fit(trials)


def test_a_law_of_your_own_is_simulated_and_run_free():
    law = Equation((Own(),), (400.0,), mass_kg=MASS_KG)
    with pytest.raises(UndertowError, match="an equation with a law of your own needs both, or times"):
        undertow.simulate(law, x0=0.1)
    run = undertow.simulate(law, x0=0.1, duration_s=3.0, rate_hz=60.0)
    assert run.x == pytest.approx(0.1 * np.cos(10.0 * run.t), abs=1e-5)
    assert undertow.predict(law, x0=0.1, times=run.t).notes == ("no band: an equation alone has no errors",)
    assert list(run.table.columns) == ["t", "x", "v", "a"]
    assert len(run.plot().lines) == 1


@pytest.mark.parametrize(
    ("force", "said"),
    [
        (lambda x: 1 / 0, r"own_spring: its force cannot .* at x = 0\.1, v = .* \(division by zero, ZeroDiv"),
        (lambda x: x if abs(x[0]) > 0.01 else [1.0][3], r"own_spring: .*at x = .*list index out of range, IndexError"),
        (np.log, r"own_spring: its force is nan at x = -0\.05, v = .*; give a finite number to both sides"),
        (lambda x: 1.0, r"own_spring: its force has the shape \(\) for 1 samples"),
    ],
)
def test_a_law_of_your_own_that_fails_in_a_simulation_is_named(monkeypatch, force, said):
    monkeypatch.setattr(Own, "force", lambda self, x, v, a, t: force(x))
    with pytest.raises(IdentificationError, match=said):
        undertow.simulate(Equation((Own(),), (400.0,), mass_kg=MASS_KG), x0=0.1, duration_s=3.0, rate_hz=60.0)


def test_a_coefficient_that_every_trial_gives_another_value_is_said_not_to_be_identified(monkeypatch):
    """A brake that fades with displacement, fitted with one that ends at 30 mm: each trial alone trades it with c."""

    def brake(force):
        own = Own()
        monkeypatch.setattr(Own, "force", lambda self, x, v, a, t: force(x, v))
        return own

    law = Equation((Stiffness(), brake(lambda x, v: v / (1.0 + (x / 0.03) ** 2))), (400.0, 6.0), mass_kg=MASS_KG)
    runs = [undertow.simulate(law, x0=x0, duration_s=3.0, rate_hz=50.0) for x0 in (0.04, 0.1)]
    recorded = [run.recorded(noise_m=2e-4, seed=i, name=f"r{i}") for i, run in enumerate(runs)]
    wrong = brake(lambda x, v: np.where(np.abs(x) < 0.03, v, 0.0))
    said = "\n".join(undertow.fit(recorded, ["stiffness", "viscous_damping", wrong], mass_kg=MASS_KG).doubts)
    assert "not identified from these trials, of which each alone gives another number: c_Ns_per_m (together" in said


def test_a_search_for_what_is_missing_refuses_a_law_of_your_own(trials):
    with pytest.raises(IdentificationError, match=r"equation has own_spring, a law of your own without slots, .*score"):
        undertow.diagnose(trials, [Own(), "viscous_damping"], mass_kg=MASS_KG)


def test_fit_takes_arrays_with_their_times_and_units(found):
    X, times = [1000.0 * r.channels["displacement"] for r in found.trials.recordings], found.trials.recordings[0].time
    again = undertow.fit(X, TERMS, t=times, units={"x": "mm"}, mass_kg=MASS_KG)
    assert again.parameters["value"].to_numpy() == pytest.approx(found.parameters["value"].to_numpy(), rel=1e-6)
    with pytest.raises(UndertowError, match=r"source is of type ndarray; give .* X together with t, as in t=0.01"):
        undertow.fit(X[0], TERMS)


def test_arguments_of_another_kind_are_refused_with_a_sentence(trials):
    with pytest.raises(ConfigError, match=r"mass is 2.0, but nothing is called so; did you mean 'mass_kg'"):
        undertow.fit(trials, TERMS, mass=2.0)
    with pytest.raises(ConfigError, match=r"colour is 'red', but nothing is called so; of a rig may be said mass_kg"):
        undertow.fit(trials, TERMS, colour="red")
    with pytest.raises(ConfigError, match=r"equation holds .*lambda.*, of type function; a law is a name"):
        undertow.fit(trials, ["stiffness", lambda x, v: v])
    with pytest.raises(UndertowError, match=r"x0 has the shape \(2,\); give one number, as x0=0.1, v0=0.0"):
        undertow.simulate(LAW, [0.1, 0.0])
    with pytest.raises(IdentificationError, match=r"terms holds .*, of type object; give names of laws"):
        undertow.Discover(terms=object()).fit(trials)
    with pytest.raises(IdentificationError, match=r"terms holds <Unreadable instance .*>, of type Unreadable; give"):
        undertow.Discover(terms=["stiffness", Unreadable()]).fit(trials)
    with pytest.raises(UndertowError, match=r"this Discover has seen 0 trials; call fit\(trials\) first"):
        undertow.predict(undertow.Discover(), x0=0.1, times=[0.0, 0.1])
    with pytest.raises(IdentificationError, match=r"terms holds 3.0, of type float; give names of laws"):
        undertow.Discover(terms=["stiffness", 3.0]).fit(trials)


def test_a_prescribed_hysteresis_yields_where_it_was_found_to():
    """The force at which it yields had stood as its displacement: `predict` missed 116 % of a motion fitted to .3 %."""
    joint = {"stiffness_N_per_m": 80.0, "yield_displacement_m": 0.01}
    law = {"stiffness": 400.0, "viscous_damping": 2.0, "hysteresis": joint}
    runs = [undertow.simulate(law, x0=x0, mass_kg=MASS_KG, rate_hz=60.0, duration_s=6.0) for x0 in (0.05, 0.1, 0.07)]
    *seen, unseen = [run.recorded(noise_m=5e-5, seed=seed, name=f"h{seed}") for seed, run in enumerate(runs)]
    found = undertow.fit(seen, list(law), mass_kg=MASS_KG)
    (bristles,) = [term for term in found.equation.terms if term.name == "hysteresis"]
    assert bristles.yield_displacement_m == pytest.approx(0.01, rel=0.02)
    force = found.parameters.loc["hysteresis_yield_force_N"]
    assert (force["value"], force["unit"]) == (pytest.approx(0.8, rel=0.02), "N")
    assert undertow.predict(found, unseen).runs[0].nrmse < 0.02


@pytest.mark.parametrize(
    ("law", "numbers"),
    [
        ("hidden_resonator", {"mass_kg": 0.4, "natural_frequency_rad_per_s": 12.0, "damping_ratio": 0.01}),
        ("relaxation", {"stiffness_N_per_m": 60.0, "time_s": 0.1}),
    ],
)
def test_a_prescribed_law_with_a_state_of_its_own_is_fitted(law, numbers):
    """It was refused with a message about arrays: instants that did not increase had been asked of it."""
    whole = {"stiffness": 400.0, "viscous_damping": 2.0, law: numbers}
    runs = [undertow.simulate(whole, x0=x0, mass_kg=MASS_KG, rate_hz=60.0, duration_s=7.0) for x0 in (0.05, 0.1, 0.07)]
    *seen, unseen = [run.recorded(noise_m=5e-5, seed=seed, name=f"s{seed}") for seed, run in enumerate(runs)]
    found = undertow.fit(seen, list(whole), mass_kg=MASS_KG)
    for name, value in numbers.items():
        row = found.parameters.loc[f"{law}_{name}"]
        assert abs(row["value"] - value) < max(4.0 * row["stderr"], 0.002 * value)
    written = next(one for one in json.loads(found.to_json())["terms"] if one["name"] == law)["parameters"]
    assert {name: written[name]["stderr"] for name in numbers} == {
        name: pytest.approx(found.parameters.loc[f"{law}_{name}", "stderr"]) for name in numbers
    }
    assert found.score(unseen) > 0.99


@pytest.mark.parametrize(
    ("law", "numbers"),
    [
        ("stribeck_friction", {"static_force_N": 0.6, "velocity_m_per_s": 0.1}),
        ("delayed_echo", {"gain": -1.5, "delay_s": 1.3}),
    ],
)
def test_an_inner_number_far_from_its_usual_value_is_found(law, numbers):
    """A speed of .1 m/s had ended at 1e-5 with a friction of -4 N, a delay of 1.3 s at .98 s with the other sign."""
    whole = {"stiffness": 400.0, "viscous_damping": 2.0, "coulomb_friction": 0.2, law: numbers}
    runs = [undertow.simulate(whole, x0=x0, mass_kg=MASS_KG, rate_hz=60.0, duration_s=8.0) for x0 in (0.03, 0.1, 0.07)]
    *seen, unseen = [run.recorded(noise_m=5e-5, seed=seed, name=f"f{seed}") for seed, run in enumerate(runs)]
    found = undertow.fit(seen, list(whole), mass_kg=MASS_KG)
    for name, value in numbers.items():
        assert found.parameters.loc[f"{law}_{name}", "value"] == pytest.approx(value, rel=0.03)
    assert found.score(unseen) > 0.99
