"""Hidden states as pysindy columns: against closed forms, inside a plain SINDy, and refined."""

import pickle

import numpy as np
import pysindy
import pytest
from scipy.integrate import solve_ivp
from sklearn.base import clone

from undertow.equation.hidden import HiddenResonator, Relaxation
from undertow.errors import IdentificationError
from undertow.methods.hidden_library import HiddenStateLibrary, oscillator_grid
from undertow.methods.subset import BestSubset
from undertow.methods.variable_projection import refine_inner

STEP_S = 0.005
RATIO, W, ZETA = 0.08, 9.6, 0.02
BODY_W, BODY_ZETA = 11.6, 0.02


def released(x0, seconds):
    """x, v, a of a linear body with a hidden oscillator after a release, (n, 3)."""
    mass = np.array([[1.0 + RATIO, RATIO], [1.0, 1.0]])

    def acceleration(y):
        body = -(BODY_W**2) * y[0] - 2.0 * BODY_ZETA * BODY_W * y[2]
        water = -(W**2) * y[1] - 2.0 * ZETA * W * y[3]
        return np.linalg.solve(mass, [body, water])

    t = np.arange(0.0, seconds, STEP_S)
    y = solve_ivp(
        lambda _, y: [y[2], y[3], *acceleration(y)], (0.0, t[-1]), [x0, 0.0, 0.0, 0.0], "DOP853", t, rtol=1e-10,
        atol=1e-13,
    ).y  # fmt: skip
    a = np.array([acceleration(column)[0] for column in y.T])
    return np.column_stack([y[0], y[2], a])


@pytest.fixture(scope="module")
def trials():
    """Two releases of unequal length, noise-free."""
    return [released(0.03, 5.0), released(0.016, 7.0)]


def test_an_undamped_response_to_a_constant_push_is_one_minus_cosine():
    t = np.arange(2000) * 1e-3
    states = np.column_stack([t, t, np.full(t.size, 2.0)])
    got = np.asarray(HiddenStateLibrary(1e-3, [(7.0, 0.0)]).fit_transform(states))[:, 0]
    assert np.allclose(got, 2.0 * (1.0 - np.cos(7.0 * t)), atol=1e-9)  # closed form, rounding only


def test_columns_are_those_of_the_terms_and_the_drift_belongs_to_each_trajectory(trials):
    library = HiddenStateLibrary(STEP_S, [(W, ZETA)], [0.3], drift_order=1)
    parts = library.fit_transform(trials)
    assert library.get_feature_names() == [
        "hidden(w=9.6, z=0.02)", "relaxation(tau=0.3)", "drift0[0]", "drift0[1]", "drift1[0]", "drift1[1]",
    ]  # fmt: skip
    for place, (part, states) in enumerate(zip(parts, trials, strict=True)):
        x, v, a = states.T
        t = np.arange(x.size) * STEP_S
        assert np.array_equal(part[:, 0], HiddenResonator(W, ZETA).force(x, v, a, t))
        assert np.array_equal(part[:, 1], Relaxation(0.3).force(x, v, a, t))
        assert np.all(part[:, 2 + place] == 1.0)
        assert np.all(part[:, 3 - place] == 0.0)
        assert part[0, 4 + place] == -1.0
        assert part[-1, 4 + place] == 1.0


def test_the_drift_of_a_trajectory_that_was_not_fitted_is_nothing(trials):
    library = HiddenStateLibrary(STEP_S, [(W, ZETA)], drift_order=0).fit(trials)
    assert np.all(library.transform(trials[0])[:, 1:] == 0.0)
    assert np.all(np.asarray(library.transform(trials[0][:1])) == 0.0)


def test_a_plain_sindy_finds_the_mass_of_a_hidden_oscillator_on_trials_of_unequal_length(trials):
    states = [trial[:, :2] for trial in trials]
    drives = [trial[:, 2:] for trial in trials]
    rates = [trial[:, 1:] for trial in trials]
    library = pysindy.PolynomialLibrary(degree=1, include_bias=False, include_interaction=False)
    hidden = HiddenStateLibrary(STEP_S, [(W, ZETA)])
    # the acceleration drives the hidden state but is no column of its own
    both = pysindy.GeneralizedLibrary([library, hidden], inputs_per_library=[(0, 1), (0, 1, 2)])
    model = pysindy.SINDy(feature_library=both, optimizer=pysindy.STLSQ(threshold=1e-3, alpha=0.0))
    model.fit(states, t=STEP_S, x_dot=rates, u=drives)
    stiffness, damping, ratio = -model.coefficients()[1]
    # noise-free; the response takes the drive as straight between samples: (w h)^2 / 12 = 2e-4
    assert ratio == pytest.approx(RATIO, rel=1e-3)
    assert stiffness == pytest.approx(BODY_W**2, rel=1e-3)
    assert damping == pytest.approx(2.0 * BODY_ZETA * BODY_W, rel=2e-2)


def test_the_best_subset_keeps_one_oscillator_of_a_grid_and_refinement_brings_it_home(trials):
    library = HiddenStateLibrary(STEP_S, oscillator_grid(6.0, 14.0, 9, (0.02,)))
    columns = np.vstack([np.asarray(part) for part in library.fit_transform(trials)])
    body = np.vstack([trial[:, :2] for trial in trials])
    response = -np.concatenate([trial[:, 2] for trial in trials])
    optimizer = BestSubset(forced=(0, 1), n_effective=50.0).fit(np.hstack([body, columns]), response[:, None])
    kept = [library.oscillators[i] for i in np.flatnonzero(optimizer.support_[0][2:])]
    nearest = min(kept, key=lambda one: abs(one[0] - W))
    start = HiddenStateLibrary(STEP_S, [nearest])
    beside = pysindy.PolynomialLibrary(degree=1, include_bias=False)
    refined = start.refined(trials, [-trial[:, 2] for trial in trials], _FirstTwo(beside))
    w, zeta = refined.oscillators[0]
    assert w == pytest.approx(W, rel=1e-3)
    assert zeta == pytest.approx(ZETA, rel=0.05)
    assert start.oscillators == [nearest]  # the first library is left as it was


def test_a_relaxation_time_and_an_oscillator_are_refined_together(trials):
    truth = HiddenStateLibrary(STEP_S, [(8.0, 0.05)], [0.25]).fit(trials)
    response = [np.asarray(part) @ np.array([0.3, 40.0]) for part in truth.transform(trials)]
    start = HiddenStateLibrary(STEP_S, [(8.6, 0.02)], [0.6], drift_order=1)
    refined = start.refined(trials, response)
    # noise-free and exact columns; four rounds in turn leave a few thousandths
    assert refined.oscillators[0] == (pytest.approx(8.0, rel=5e-3), pytest.approx(0.05, rel=0.1))
    assert refined.relaxation_times_s == (pytest.approx(0.25, rel=0.05),)
    assert refined.drift_order == 1


class _FirstTwo(pysindy.feature_library.base.BaseFeatureLibrary):
    """x and v of three input columns, as a library."""

    def __init__(self, inner):
        self.inner = inner

    def fit(self, x, y=None):
        self.inner.fit([part[:, :2] for part in x])
        return self

    def transform(self, x):
        return self.inner.transform([part[:, :2] for part in x])

    def get_feature_names(self, input_features=None):
        return self.inner.get_feature_names()


def test_lorenz_and_van_der_pol_are_found_with_a_hidden_library_beside_the_polynomials():
    t = np.arange(0.0, 8.0, 2e-3)

    def lorenz(_, y):
        return [10.0 * (y[1] - y[0]), y[0] * (28.0 - y[2]) - y[1], y[0] * y[1] - 8.0 / 3.0 * y[2]]

    def van_der_pol(_, y):
        return [y[1], 2.0 * (1.0 - y[0] ** 2) * y[1] - y[0]]

    for rates, start, terms in ((lorenz, [-8.0, 7.0, 27.0], 7), (van_der_pol, [2.0, 0.0], 4)):
        states = solve_ivp(rates, (0.0, 8.0), start, "DOP853", t, rtol=1e-10, atol=1e-12).y.T
        slopes = np.array([rates(0.0, row) for row in states])
        library = pysindy.PolynomialLibrary(degree=3) + HiddenStateLibrary(2e-3, [(3.0, 0.1)], drift_order=1)
        model = pysindy.SINDy(feature_library=library, optimizer=pysindy.STLSQ(threshold=0.2))
        model.fit(states, t=t, x_dot=slopes)
        found = model.coefficients()
        assert np.count_nonzero(found) == terms
        names = library.get_feature_names()
        hidden = [i for i, name in enumerate(names) if name.startswith(("hidden", "drift"))]
        assert hidden
        assert not np.any(found[:, hidden])
        assert np.isfinite(model.predict(states)).all()


def test_the_library_clones_pickles_and_prints_its_parameters(trials):
    library = HiddenStateLibrary(STEP_S, ((W, ZETA),), (0.3,), 2).fit(trials)
    twin = clone(library)
    assert twin.get_params() == library.get_params()
    again = pickle.loads(pickle.dumps(library))  # noqa: S301 - our own bytes
    assert np.array_equal(again.transform(trials)[0], library.transform(trials)[0])
    assert "oscillators=((9.6, 0.02),)" in repr(library)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda x: HiddenStateLibrary(STEP_S).fit(x), "0 columns; give oscillators"),
        (lambda x: HiddenStateLibrary(0.0, [(W, ZETA)]).fit(x), "step_s is 0.0 s"),
        (lambda x: HiddenStateLibrary(STEP_S, [(-1.0, ZETA)]).fit(x), "an oscillator of -1 rad/s"),
        (lambda x: HiddenStateLibrary(STEP_S, [(W, 1.0)]).fit(x), "damping ratio 1; frequencies"),
        (lambda x: HiddenStateLibrary(STEP_S, (), [0.0]).fit(x), "a relaxation time of 0 s"),
        (lambda x: HiddenStateLibrary(STEP_S, [(W, ZETA)]).fit(x[0][:, 0]), r"shape \(1000,\); give columns x, v"),
        (lambda x: HiddenStateLibrary(STEP_S, [(W, ZETA)]).fit(x).transform(np.full((3, 3), np.nan)), "9 of 9 input"),
        (lambda x: HiddenStateLibrary(STEP_S, (), [1.0]).refined(x, [x[0][:, 2]]), "refined got 1 hidden states, 2"),
        (lambda x: oscillator_grid(5.0, 5.0), "frequencies from 5 to 5 rad/s; give 0 < lowest"),
    ],
)
def test_what_cannot_be_a_column_is_refused_with_its_value(trials, make, words):
    with pytest.raises(IdentificationError, match=words):
        make(trials)


def test_a_refinement_refuses_starts_that_are_not_positive_and_columns_that_are_not_finite():
    bounds = (np.array([1.0, 1e-3]), np.array([20.0, 0.9]))
    with pytest.raises(IdentificationError, match=r"starts at \[\[0.0, 0.1\]\]; frequencies and dampings must be"):
        refine_inner(lambda q: np.ones((9, len(q))), np.ones((9, 1)), np.ones(9), np.array([[0.0, 0.1]]), bounds)
    with pytest.raises(IdentificationError, match="27 of 27 values of the columns"):
        refine_inner(
            lambda q: np.full((9, len(q)), np.nan), np.ones((9, 1)), np.ones(9), np.array([[5.0, 0.1]]), bounds
        )


def test_a_refinement_that_starts_at_the_truth_stays_there():
    t = np.linspace(0.0, 4.0, 400)

    def wave(q):
        return np.column_stack([np.exp(-z * w * t) * np.sin(w * t) for w, z in q])

    bounds = (np.array([1.0, 1e-3]), np.array([20.0, 0.9]))
    truth = np.array([[7.0, 0.05]])
    response = 3.0 * wave(truth)[:, 0]
    at = refine_inner(wave, np.ones((400, 1)), response, truth, bounds)
    assert at.inner == pytest.approx(truth, rel=1e-6)
