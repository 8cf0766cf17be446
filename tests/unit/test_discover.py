"""`undertow.Discover`: found, told and predicted as scikit-learn's estimators do, and honest about what it is not."""

import html
import pickle
from dataclasses import replace

import numpy as np
import pytest
from sklearn.base import clone, is_regressor
from sklearn.exceptions import NotFittedError as UnfittedEstimator
from sklearn.utils.validation import check_is_fitted

import undertow
from experiments.structure.truths import OtherBody
from tests.short_trials import LONG, group, per_mass, released
from undertow.comparison.discover import Discovery, motions_of
from undertow.comparison.stepwise_selection import Rules
from undertow.comparison.structure import Effort, find_structure, number_covariance
from undertow.comparison.structure_report import as_html, as_text, doubts, findings, number_rows, odds
from undertow.conditioning.condition import condition
from undertow.equation.hydrodynamics import QuadraticDrag
from undertow.equation.structure import CoulombFriction, CubicStiffness, Stiffness, ViscousDamping
from undertow.errors import IdentificationError, NotFittedError, RecordingError

EQ15 = {"stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag"}
SIX = ("stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag", "cubic_stiffness", "cubic_damping")


@pytest.fixture(scope="module")
def trials():
    return group()


@pytest.fixture(scope="module")
def fitted(trials):
    return undertow.Discover(resamples=20).fit(trials)


def test_ten_terms_come_down_to_equation_15(fitted):
    assert {term.name for term in fitted.terms_} == EQ15
    order = [next(i for i, t in enumerate(fitted.terms_) if t.name == n) for n in SIX[:4]]
    errors = np.array([fitted.estimates_[name].stderr for name in SIX[:4]])
    assert np.all(np.abs(fitted.coefficients_[order] - per_mass(LONG)) < 4.0 * errors)
    assert np.all(errors / per_mass(LONG) < 0.05)


def test_terms_that_are_there_are_found_again_in_resamples(fitted):
    assert all(fitted.inclusion_[name] >= 0.9 for name in EQ15)
    assert set(fitted.inclusion_) == set(fitted.structure_.considered)


def test_a_trial_that_was_not_seen_is_predicted_to_its_noise(fitted):
    unseen = released(LONG, 0.08, "unseen", 77)
    floor = 2e-4 / np.sqrt(np.mean((condition(unseen).windowed("x") - 0.001) ** 2))
    # nothing comes closer to a recording than its own noise, of which the trial's nuisances take up little
    assert 0.9 * floor < 1.0 - fitted.score([unseen]) < 1.6 * floor
    assert Discovery.score(fitted, [unseen]) == fitted.score([unseen])  # the search alone, without front
    predicted = fitted.predict([unseen])
    assert predicted[0].shape == condition(unseen).windowed("t").shape
    heavier = released(OtherBody(*[1.1 * LONG.inertia_kg, *list(vars(LONG).values())[1:]]), 0.08, "heavier", 5)
    # a tenth more mass is 5 % of the frequency: half a radian after two of the eight seconds
    assert fitted.score([heavier]) < 0.75


def test_the_equation_has_the_digits_that_its_errors_allow(fitted):
    (text,) = fitted.equations()
    assert text.startswith("x'' + 28.0")
    stiffness = fitted.estimates_["stiffness"]
    shown = text.split()[2]
    assert abs(float(shown) - stiffness.value) < stiffness.stderr
    assert len(shown) < 9


def test_the_report_says_everything_in_order(fitted, trials):
    report = fitted.fit_report([trials[1]])
    parts = (
        "structure of 3 trials: r0, r1, r2", "x'' + 28.0", "found again", "without cubic_damping", "free-run error",
        "weak form on the recorded acceleration agrees", "times the sensors' noise", "r1 0.0",
    )  # fmt: skip
    assert [part for part in parts if part not in report] == []
    assert "free-run" not in fitted.fit_report()
    page = fitted._repr_html_()
    assert page.startswith("<div><p><code>x&#x27;&#x27; + 28.0")
    assert "<table>" in page
    assert fitted._repr_mimebundle_()["text/html"] == page


def test_clone_params_repr_and_pickle_are_scikit_learns(fitted, trials):
    settings = {"terms": SIX, "known": ("stiffness",), "exclusive": (("quadratic_drag", "cubic_damping"),)}
    one = undertow.Discover(**settings)
    assert clone(one).get_params() == one.get_params()
    assert one.set_params(resamples=30).resamples == 30
    said = r"^nonsense is set to 1, but Discover has no parameter 'nonsense'; it has beliefs, [a-z_, ]*, together$"
    with pytest.raises(IdentificationError, match=said):
        fitted.set_params(nonsense=1)
    assert repr(undertow.Discover(signs=False)) == "Discover(signs=False)"
    again = pickle.loads(pickle.dumps(fitted))  # noqa: S301 - our own bytes
    assert again.equations() == fitted.equations()
    assert again.score([trials[0]]) == fitted.score([trials[0]])
    check_is_fitted(fitted)
    assert not is_regressor(clone(fitted))
    assert "Discover" in undertow.Discover()._repr_html_()


ASKED = (
    lambda d: d.predict([]), lambda d: d.score([]), lambda d: d.equations(), lambda d: d.equation_, lambda d: d.rivals_,
    lambda d: d.fit_report(), lambda d: d.terms_, lambda d: d.coefficients_, lambda d: d.inclusion_,
)  # fmt: skip


@pytest.mark.parametrize("ask", ASKED)
def test_an_unfitted_estimator_says_so_as_ours_and_as_scikit_learns_error(ask):
    for error in (NotFittedError, UnfittedEstimator, ValueError, AttributeError):
        with pytest.raises(error, match=r"this Discover has seen 0 trials; call fit\(trials\) first"):
            ask(undertow.Discover())
    with pytest.raises(UnfittedEstimator, match="is not fitted yet"):
        check_is_fitted(undertow.Discover())


def test_fit_leaves_settings_and_trials_alone(fitted, trials):
    before = {name: np.array(values) for name, values in trials[0].channels.items()}
    one = undertow.Discover(terms=SIX, known=["stiffness"], resamples=0, outside=False, second_route=False)
    assert one.fit(trials) is one
    assert one.get_params()["known"] == ["stiffness"]
    assert all(np.array_equal(before[name], trials[0].channels[name]) for name in before)
    assert one.n_trials_in_ == 3
    assert one.inclusion_ == {}


def test_groups_and_known_terms_are_obeyed_by_name(trials):
    quick = {"resamples": 0, "outside": False, "second_route": False}
    kept = undertow.Discover(terms=SIX, known=("cubic_damping",), **quick).fit(trials)
    assert "cubic_damping" in {term.name for term in kept.terms_}
    costs = {row[0]: row[2] for row in number_rows(kept.structure_)[1:]}
    assert [name for name, cost in costs.items() if cost == "known to be there"] == ["cubic_damping"]
    assert float(costs["stiffness"]) > 1000.0
    assert "known to be there" in kept.fit_report()
    apart = undertow.Discover(terms=SIX, exclusive=(("viscous_damping", "quadratic_drag"),), **quick).fit(trials)
    assert not {"viscous_damping", "quadratic_drag"} <= {term.name for term in apart.terms_}


def test_trials_whose_stiffness_differs_do_not_make_a_cubic_spring():
    bodies = [OtherBody(*[*list(vars(LONG).values())[:2], LONG.k_N_per_m * factor, *list(vars(LONG).values())[3:]])
              for factor in (0.995, 1.0, 1.006)]  # fmt: skip
    pairs = zip(bodies, (0.03, 0.06, 0.1), strict=True)
    trials = [released(body, x0, f"s{i}", i) for i, (body, x0) in enumerate(pairs)]
    quick = {"terms": SIX, "resamples": 0, "outside": False, "second_route": False}
    alike = undertow.Discover(**quick).fit(trials)
    own = undertow.Discover(**quick, scatter={"stiffness": 0.005}).fit(trials)
    assert {term.name for term in own.terms_} == EQ15
    assert {term.name for term in alike.terms_} != EQ15
    assert own.structure_.left < 1.1


def test_a_law_that_the_library_lacks_is_said_first():
    body = OtherBody(LONG.inertia_kg, LONG.c_Ns_per_m, LONG.k_N_per_m, LONG.friction_N, 3924.0, static_N=170.0)
    one = undertow.Discover(terms=SIX, resamples=0, second_route=False).fit(group(body))
    assert one.adequate_ is False
    assert "viscous_damping" not in {term.name for term in one.terms_}
    assert one.outside_.names == ("linear_damping", "stribeck_friction")  # what is not in the set, and what no set has
    second_line = one.fit_report().splitlines()[1]
    assert second_line.startswith("! all trials: no trial alone stands out")
    assert "friction that is larger at low speed" in second_line
    assert f"<strong>{html.escape(one.outside_.sentence)}" in one._repr_html_()


def test_an_equation_that_leaves_nothing_out_is_adequate_only_where_scatter_is_known(trials):
    quick = {"terms": SIX, "resamples": 0, "second_route": False}
    assumed = undertow.Discover(**quick).fit(trials)
    assert (assumed.adequate_, assumed.outside_.status) == (None, "cannot_tell")
    said = undertow.Discover(**quick, scatter={"stiffness": 0.002}).fit(trials)
    assert (said.adequate_, said.outside_.status) == (True, "nothing_missing")
    assert f"- {said.outside_.sentence}" in said.fit_report()
    assert undertow.Discover(**quick, outside=False).fit(trials).adequate_ is None


def test_an_inner_parameter_has_a_name_a_unit_and_an_error():
    body = OtherBody(LONG.inertia_kg, LONG.c_Ns_per_m, LONG.k_N_per_m, LONG.friction_N, 3924.0, static_N=170.0)
    terms = (*SIX, "stribeck_friction")
    one = undertow.Discover(terms=terms, resamples=0, outside=False, second_route=False).fit(group(body))
    speed = one.estimates_["stribeck_friction.velocity_m_per_s"]
    assert speed.unit == "m/s"
    assert abs(speed.value - 0.03) < 4.0 * speed.stderr
    assert "stribeck_friction.velocity_m_per_s" in one.fit_report()
    kept = next(term for term in one.terms_ if term.name == "stribeck_friction")
    assert kept.inner["velocity_m_per_s"] == speed.value


def test_a_swing_that_was_never_held_is_enough():
    trials = [replace(r, time=r.time[150:] - r.time[150], channels={"displacement": r.channels["displacement"][150:]})
              for r in group()]  # fmt: skip
    one = undertow.Discover(terms=SIX, resamples=10, outside=False).fit(trials)
    assert all("v0" in cells.names for cells in one.structure_.found.trials)
    assert {term.name for term in one.terms_} == EQ15
    assert one.score(trials) > 0.98


def test_displacement_alone_is_enough():
    one = undertow.Discover(terms=SIX, resamples=0, outside=False).fit(group(channels=("x",)))
    assert {term.name for term in one.terms_} == EQ15
    assert one.structure_.route.response == "displacement"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"known": ("drag",)}, r"known names 'drag', which is not in the library stiffness, viscous_damping"),
        ({"known": "stiffness"}, r"known is the text 'stiffness'; give a sequence of names"),
        ({"together": (("stiffness", "spring"),)}, r"together names 'spring'"),
        ({"exclusive": (("a", "b"),)}, r"exclusive names 'a'"),
        ({"terms": ("stiffnes",)}, r"equation term 'stiffnes' is not in the registry; did you mean 'stiffness'"),
        ({"terms": ()}, r"3 trials and 0 terms; give at least one of each"),
        ({"terms": ("stiffness", "hidden_resonator")}, r"^hidden_resonator is no force of x and v alone.* simulated"),
        ({"scatter": {"mass": 0.1}}, r"scatter of 'mass' is 0.1; give a share above 0 of one of stiffness"),
        ({"scatter": {"stiffness": -0.1}}, r"scatter of 'stiffness' is -0.1; give a share above 0"),
        ({"terms": SIX, "resamples": 3, "outside": False}, r"3 resamples give no probability; draw at least 10"),
    ],
)
def test_settings_without_an_answer_are_refused_with_the_value(settings, message, trials):
    with pytest.raises(ValueError, match=message):
        undertow.Discover(**settings).fit(trials)


def test_trials_that_are_none_are_refused(fitted, trials):
    for wrong, message in (([], r"source holds 0 trials"), ([1.0], r"source is of type float; give paths")):
        with pytest.raises(RecordingError, match=message):
            fitted.predict(wrong)
    for wrong, message in (([], r"trials is 0 trials"), (trials[0], r"trials is Recording; give a list"),
                           ([1.0], r"a trial is of type float; give Recording or Motion")):  # fmt: skip
        with pytest.raises(IdentificationError, match=message):
            motions_of(wrong)


def test_what_is_doubtful_is_said_first(fitted):
    structure = fitted.structure_
    name = structure.names[1]
    worse = dict(structure.numbers)
    worse[name] = replace(worse[name], outcome="not distinct from 0: 0.1 with a standard error of 0.2")
    route = replace(structure.route, agrees=False, sentence="weak form DISAGREES")
    lost = replace(structure, numbers=worse, route=route)
    assert f"{name}: not distinct from 0" in as_text(lost).splitlines()[2]
    assert doubts(lost)[0] == "weak form DISAGREES"
    assert "weak form DISAGREES" not in findings(lost)
    assert as_html(lost).count("<strong>") == 2
    missing = replace(structure, route=None, route_outcome="no second route: the window is too short")
    assert "no second route: the window is too short" in findings(missing)


def test_odds_are_readable():
    assert [odds(d) for d in (2.0, 6.0, 100.0)] == ["2.7 to 1", "20 to 1", "over 1000000 to 1"]


def test_undertow_exports_discover_and_nothing_that_is_not_there():
    assert "Discover" in undertow.__all__
    with pytest.raises(AttributeError, match=r"module 'undertow' has no attribute 'Find'; it has Discover"):
        undertow.Find  # noqa: B018 - asked for to see it refused


def test_a_library_that_cannot_move_as_the_body_raises():
    motions = [condition(recording) for recording in group()]
    terms = (Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag(), CubicStiffness())
    with pytest.raises(IdentificationError, match=r"0 trials and 5 terms; give at least one of each"):
        find_structure([], terms)
    with pytest.raises(IdentificationError, match=r"obeys the (signs|groups)|exclusive"):
        find_structure(motions, terms, Rules(known=(0, 1), exclusive=((0, 1),)), effort=Effort(0, False, False))


def test_a_body_that_gains_energy_is_doubted_first_and_the_sign_that_forbids_it_is_named():
    law = {"stiffness": 1.0, "viscous_damping": -1.0, "van_der_pol_damping": 1.0}
    runs = [undertow.simulate(law, x0=x0, rate_hz=25.0, duration_s=40.0) for x0 in (0.5, 2.0, 4.0)]
    rng = np.random.default_rng(1)
    given = [run.x + 1e-3 * rng.standard_normal(run.t.size) for run in runs]
    driven = undertow.read(given, t=0.04, units={"x": "m"}, accept=["damping"])
    settings = {"terms": list(law), "resamples": 0, "outside": False, "second_route": False}
    signed = str(undertow.Discover(**settings).fit(driven)).split("\n")
    assert signed[1].startswith("! trial_3: it stays on one side for 5.52 s at the window's start")
    assert "times the sensors' noise: the equation lacks something" in signed[2]
    assert signed[3].startswith("! viscous_damping would leave less with a coefficient below 0")
    assert "needs signs=False" in signed[3]
    free = undertow.Discover(**settings, signs=False).fit(driven)
    assert free.estimates_["viscous_damping"].value == pytest.approx(-1.0, abs=0.01)
    assert [line for line in str(free).split("\n") if line.startswith("!")] == [signed[1]]


def test_only_the_sign_that_stands_in_the_way_is_blamed():
    law = {"stiffness": 1.0, "viscous_damping": -0.8, "van_der_pol_damping": 0.8}
    run = undertow.simulate(law, x0=2.0, rate_hz=50.0, duration_s=30.0)
    given = run.x + 1e-3 * np.random.default_rng(0).standard_normal(run.t.size)
    driven = undertow.read([given], t=0.02, units={"x": "m"}, accept=["damping"])
    said = str(undertow.Discover(resamples=0, outside=False, second_route=False).fit(driven)).split("\n")
    blamed = [line.split()[1] for line in said if "would leave less" in line]
    assert blamed == ["viscous_damping"]  # friction and drag, whose forces look like it, had been blamed too


def test_false_terms_together_do_not_take_the_place_of_a_true_one():
    """Weak viscous beside quadratic damping: this noise draws two terms more at odds of two to one."""
    times = np.arange(0.0, 12.0, 0.02)
    noise = np.random.default_rng(0)
    force = {"stiffness": 39.5, "viscous_damping": 0.1, "quadratic_drag": 2.0}
    decays = [
        undertow.simulate(force, x0=start, mass_kg=1.0, times=times).x + noise.normal(0.0, 1e-3, times.size)
        for start in (0.1, 0.06)
    ]
    found = undertow.Discover(resamples=0, outside=False, second_route=False).fit(decays, t=times, units={"x": "m"})
    assert {term.name for term in found.terms_} == set(force)
    first = found.structure_.rivals[0]
    assert first.difference < 0.0
    assert len(first.terms) == 5
    assert "for it, too few for the larger of the two" in "\n".join(findings(found.structure_))
    assert len(repr(found.structure_)) < 20_000


def body_of(mass_kg, seed=0):
    """A decay of 400 N/m and 1 N s/m under noise of 0.2 mm."""
    times = np.arange(0.0, 8.0, 0.01)
    free = undertow.simulate({"stiffness": 400.0, "viscous_damping": 1.0}, x0=0.1, mass_kg=mass_kg, times=times)
    return free.x + np.random.default_rng(seed).normal(0.0, 2e-4, times.size)


@pytest.mark.parametrize("masses", [(4.0, 4.04), (4.0, 4.04, 4.02)])
def test_trials_that_differ_widen_the_errors_of_what_they_share(masses):
    """The trial in the middle, which the mean fits, has no more say than the others."""
    decays = [body_of(mass, seed) for seed, mass in enumerate(masses)]
    found = undertow.Discover(["stiffness", "viscous_damping"], resamples=0, outside=False, second_route=False)
    found.fit(decays, t=0.01, units={"x": "m"})
    stiffness = found.estimates_["stiffness"]
    assert 0.2 < stiffness.stderr < 4.0
    assert stiffness.value == pytest.approx(400.0 / np.mean(masses), abs=0.1)


@pytest.mark.slow
def test_errors_of_one_trial_hold_the_truth_as_often_as_they_say():
    z = []
    for seed in range(100):
        found = undertow.Discover(["stiffness", "viscous_damping"], resamples=0, outside=False, second_route=False)
        found.fit([body_of(4.0, seed)], t=0.01, units={"x": "m"})
        z += [(found.estimates_[n].value - v) / found.estimates_[n].stderr for n, v in
              (("stiffness", 100.0), ("viscous_damping", 0.25))]  # fmt: skip
    assert 0.85 < np.std(z) < 1.15


def test_a_number_that_rivals_place_elsewhere_has_their_distance_in_its_error():
    """Quadratic drag where weak viscous damping is hardly seen: alone it is 2.25 +- 0.04, of a truth of 2."""
    times = np.arange(0.0, 8.0, 0.01)
    force = {"stiffness": 100.0, "viscous_damping": 0.1, "quadratic_drag": 2.0}
    decays = [
        undertow.simulate(force, x0=start, mass_kg=1.0, times=times).x
        + np.random.default_rng([6, i]).normal(0.0, 6e-3, times.size)
        for i, start in enumerate((0.05, 0.1, 0.15))
    ]
    found = undertow.Discover(resamples=0, outside=False, second_route=False).fit(decays, t=times, units={"x": "m"})
    drag = found.estimates_["quadratic_drag"]
    with_both = ("stiffness", "viscous_damping", "quadratic_drag")
    assert with_both in (*found.rivals_, tuple(term.name for term in found.terms_))
    assert abs(drag.value - 2.0) < 2.0 * drag.stderr
    covariance, widening = number_covariance(found.structure_.found)
    place = [term.name for term in found.terms_].index("quadratic_drag")
    assert drag.stderr > 2.0 * np.sqrt(covariance[place, place]) * widening[place]


def test_what_a_fit_takes_up_of_the_noise_is_in_its_errors(monkeypatch):
    found = undertow.Discover(["stiffness", "viscous_damping"], resamples=0, outside=False, second_route=False)
    selected = found.fit([body_of(4.0)], t=0.01, units={"x": "m"}).structure_.found
    wide = np.sqrt(np.diag(number_covariance(selected)[0]))
    lengths = [sum(selected.linear.lengths)]
    monkeypatch.setattr("undertow.comparison.structure.taken_up", lambda *_: [np.zeros((n, 1)) for n in lengths])
    plain = np.sqrt(np.diag(number_covariance(selected)[0]))
    assert np.all(wide / plain > 1.03)
    assert np.all(wide / plain < 1.3)
