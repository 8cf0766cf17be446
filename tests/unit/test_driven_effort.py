"""How near a search on a driven body comes where its equation misses the motion by far more than the noise."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_laws import find_driven
from undertow.likelihood.driven import DrivenLaws
from undertow.likelihood.output_error import SearchEffort
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
