"""A hidden oscillator from displacement alone: found where it is, not where a static law bends the spring."""

import numpy as np
import pytest

from undertow.comparison.hidden_trajectories import (
    LINEAR,
    discover_hidden_on_trajectories,
    effective_values,
    fit_equation,
    weigh,
)
from undertow.conditioning.condition import condition
from undertow.equation.equation import Equation
from undertow.equation.hidden import HiddenResonator
from undertow.equation.simulate import simulate
from undertow.equation.structure import CubicStiffness, Stiffness, ViscousDamping
from undertow.errors import IdentificationError
from undertow.recording.recording import Recording

NOISE_M = 3e-4
RATE_HZ = 40.0


def recorded(terms, values, name="house"):
    """A house of 1 kg at 6.5 rad/s released from 20 mm after a second's hold, displacement alone."""
    times = np.arange(1, round(14.0 * RATE_HZ)) / RATE_HZ
    x = simulate(Equation(terms, values, mass_kg=1.0), 0.02, times).x
    hold = round(RATE_HZ)
    signal = np.concatenate([np.full(hold + 1, 0.02), x])
    signal = signal + NOISE_M * np.random.default_rng(8).standard_normal(signal.size)
    return condition(Recording(name, np.arange(signal.size) / RATE_HZ, {"displacement": signal}, {}))


@pytest.fixture(scope="module")
def damped_house():
    return recorded((Stiffness(), ViscousDamping(), HiddenResonator(7.2, 0.03)), (42.0, 0.3, 0.06))


def test_a_tuned_mass_damper_is_found_from_the_houses_displacement(damped_house):
    choice = discover_hidden_on_trajectories([damped_house], LINEAR)
    fit = choice.fit
    assert fit.count == 1
    assert fit.backed
    assert "oscillator" in choice.candidates[0].name
    assert "kept, the evidence is" in fit.search.why()[0]
    # five standard errors; one trial of thirteen periods, and rivals may stand beside
    assert abs(fit.frequencies[0].value - 7.2) < 5.0 * fit.frequencies[0].stderr < 1.5
    assert choice.candidates[0].misfit == pytest.approx(1.0, abs=0.3)
    criteria = [one.criterion for one in choice.candidates]
    assert criteria == sorted(criteria)


def test_a_spring_that_bends_is_no_oscillator():
    house = recorded((Stiffness(), ViscousDamping(), CubicStiffness()), (42.0, 0.3, 12000.0))
    choice = discover_hidden_on_trajectories([house], LINEAR)
    assert choice.fit.count == 0
    assert choice.fit.search.oscillators == ()
    assert "refused" in choice.fit.search.why()[0]
    assert choice.candidates[0].name == "with static rivals"
    assert choice.fit.coefficients["cubic_stiffness"].value == pytest.approx(12000.0, rel=0.1)


def test_a_larger_equation_never_leaves_more_than_the_one_it_starts_from(damped_house):
    plain = fit_equation([damped_house], LINEAR)
    larger = fit_equation([damped_house], (*LINEAR, CubicStiffness()), like=plain)
    assert larger.chi2 <= plain.chi2 * (1.0 + 1e-9)


def test_a_candidate_pays_for_every_free_number_with_the_logarithm_of_effective_values(damped_house):
    plain = fit_equation([damped_house], LINEAR)
    n = effective_values(plain)
    assert 2.0 < n < 0.1 * plain.n_data  # what a missing oscillator leaves swings on for many cells
    candidate = weigh("plain", plain, n)
    assert candidate.parameters == 2
    assert candidate.criterion == pytest.approx(n * np.log(candidate.misfit) + 2.0 * np.log(n))


def test_no_trial_is_refused():
    with pytest.raises(IdentificationError, match="0 motions; give at least one trial"):
        discover_hidden_on_trajectories([])
