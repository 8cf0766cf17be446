"""How near a search on a driven body comes where its equation misses the motion by far more than the noise."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven import driven_motion
from undertow.equation.driven_kernel import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.driven_laws import find_driven
from undertow.equation.input import MotionSize, drive_of
from undertow.likelihood.driven import DrivenLaws
from undertow.likelihood.output_error import SearchEffort
from undertow.methods import driven
from undertow.methods.driven import WHOLE_EFFORT, fit_driven

STEP = 0.02


@pytest.fixture(scope="module")
def hardening():
    """2 x'' + x' + 50 x + 400 x^3 = u, noise of 1e-5 m: a linear equation misses it by far more."""
    t = np.arange(3000) * STEP
    phases = np.random.default_rng(4).uniform(0.0, 2.0 * math.pi, 30)
    tones = 0.1 * np.arange(1, 31)

    def force(s):
        return 2.0 * np.sum(np.cos(2.0 * math.pi * tones * s + phases))

    def rate(s, y):
        return [y[1], (force(s) - y[1] - 50.0 * y[0] - 400.0 * y[0] ** 3) / 2.0]

    x = solve_ivp(rate, (0.0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-8, atol=1e-10).y[0]
    noise = np.random.default_rng(5).normal(0.0, 1e-5, t.size)
    u = np.array([force(s) for s in t])
    return DrivenTrial("x", t, u, {"displacement": x + noise}, "force", "band_limited", frames={})


def test_a_search_that_stops_early_is_within_a_tenth_of_the_errors_of_one_that_does_not(hardening):
    laws = DrivenLaws(tuple(find_driven(name) for name in ("stiffness", "viscous_damping")))
    early = fit_driven([hardening], laws, windows=0)
    late = fit_driven([hardening], laws, windows=0, effort=SearchEffort(200, 1e-3))
    assert WHOLE_EFFORT.as_left
    assert early.solution.chi2 > 100.0 * early.solution.n_data
    assert early.solution.iterations < late.solution.iterations
    errors = np.sqrt(np.diag(late.covariance))
    assert np.max(np.abs(early.values - late.values) / errors) < 0.1


def carriage(rate_hz: float) -> DrivenTrial:
    """A carriage that sticks and slips under a slow force, with noise of 0.01 mm and what the equation lacks: a drive
    that pulls harder one way."""
    t = np.arange(round(20.0 * rate_hz)) / rate_hz
    u = 120.0 * np.sin(2.0 * math.pi * 0.3 * t) + 30.0 * np.sin(2.0 * math.pi * 0.11 * t)
    theta = np.zeros(N_DRIVEN)
    numbers = {"gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0, "mass": 95.0, "c1": 200.0, "fc": 20.0, "cb": -20.0}
    for name, value in numbers.items():
        theta[DRIVEN_SLOT[name]] = value
    x = driven_motion(theta, np.zeros(0, dtype=np.int64), drive_of(t, u, "first"), t, MotionSize(), 60).x[:, 0]
    return DrivenTrial("x", t, u, {"displacement": x + np.random.default_rng(2).normal(0.0, 1e-5, t.size)})


def test_slow_motion_is_fitted_to_fewer_samples_first(monkeypatch):
    laws = DrivenLaws(tuple(find_driven(name) for name in ("viscous_damping", "coulomb_friction", "constant_force")))
    trial, sizes = carriage(500.0), []
    known = driven.fit

    def counted(problem, *more, **settings):
        sizes.append(max(piece.t.size for piece in problem.trials))
        return known(problem, *more, **settings)

    monkeypatch.setattr(driven, "fit", counted)
    found = fit_driven([trial], laws)
    first = sizes.index(trial.t.size)
    assert first > 1
    assert max(sizes[:first]) < trial.t.size / 10
    monkeypatch.setattr(driven, "_coarse", lambda *_: None)
    plain = fit_driven([trial], laws)
    assert found.solution.chi2 < 1.01 * plain.solution.chi2
    assert np.max(np.abs(found.values - plain.values) / np.sqrt(np.diag(plain.covariance))) < 0.5


@pytest.mark.parametrize(
    ("rate_hz", "cycle", "steps"), [(500.0, 40, 41), (500.0, 400, 4), (25.0, 40, 2), (12.0, 40, 1)]
)
def test_so_many_samples_a_cycle_are_left(rate_hz, cycle, steps):
    t = np.arange(round(40.0 * rate_hz)) / rate_hz
    x = np.sin(2.0 * math.pi * 0.25 * t) + 1e-4 * np.cos(300.0 * t)
    trial = DrivenTrial("x", t, np.sin(t), {"displacement": x})
    assert trial.slowness(cycle) == pytest.approx(steps, rel=0.2, abs=0)


def test_a_thinned_trial_keeps_what_a_force_did():
    t = np.arange(1003) * 0.01
    trial = DrivenTrial("x", t, np.cos(3.0 * t), {"displacement": np.sin(t)}, instrument=np.sin(2.0 * t))
    thin = trial.thinned(4)
    assert (thin.t.size, thin.hold) == (250, "zero")
    assert thin.u[7] == pytest.approx(np.mean(trial.u[28:32]))
    assert np.sum(thin.u) * 0.04 == pytest.approx(np.sum(trial.u[:1000]) * 0.01)
    assert np.array_equal(thin.outputs["displacement"], trial.outputs["displacement"][:1000:4])
    assert thin.instrument is not None
    assert np.array_equal(thin.instrument, np.sin(2.0 * t)[:1000:4])
