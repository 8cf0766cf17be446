"""A level beside replicas of itself in which nothing is missing: what stands out, what would be seen, what can hide."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.concealed.test_diagnosis import SHORT, member
from tests.concealed.test_small_effects import found, stands
from undertow.comparison.candidate import Candidate
from undertow.comparison.level import make_level
from undertow.comparison.null_test import POWER, SIGNIFICANT, Detectable, NullTest, SuspectTest, null_test
from undertow.comparison.replicas import left_by, replicas
from undertow.comparison.score_test import Stands, places
from undertow.comparison.sizes import Sizes
from undertow.comparison.tail import Tail
from undertow.equation import registry

LOOKED_FOR = ("linear_damping", "cubic_stiffness", "cubic_damping", "hidden_resonator", "external_forcing")


def beside_its_null(*hidden: object, seed: int = 2000) -> NullTest:
    """The test of one level with something hidden, for a few suspects."""
    level = make_level([member("short", SHORT, seed, tuple(hidden))])
    fit = stands(level)
    suspects = [found(name, "one for all springs" if name == "linear_damping" else "") for name in LOOKED_FOR]
    return null_test(level, suspects, fit, (Candidate((), fit, 0.0),))


def test_a_level_with_nothing_missing_is_like_its_replicas():
    null = beside_its_null()
    assert null.p_value > 0.05
    assert not null.significant
    assert null.upper_bound < null.smallest  # nothing that counts could hide
    assert "external_forcing" not in {t.label for t in null.shared}  # a force of its own in every trial
    assert np.all(np.diff(null.replicas) >= 0.0)


def test_damping_at_once_and_a_half_of_what_is_seen_stands_out_and_at_a_quarter_does_not():
    seen = {d.name: d for d in beside_its_null().detectable}
    damping = seen["linear_damping"]
    assert (damping.parameter, damping.unit) == ("c_Ns_per_m", "N s/m")
    assert 0.0 < damping.share_of_motion < 0.1
    assert not damping.named_value < damping.value
    strong = beside_its_null((registry.find("linear_damping"), 1.5 * damping.value), seed=2001)
    assert strong.p_value <= SIGNIFICANT
    assert strong.tests[0].label.startswith(("linear_damping", "cubic_damping"))
    assert beside_its_null((registry.find("linear_damping"), 0.25 * damping.value), seed=2001).p_value > SIGNIFICANT


def test_the_tail_of_a_statistic_goes_on_as_an_exponential():
    values = np.random.default_rng(0).exponential(2.0, 20_000)
    tail = Tail.of(values)
    assert math.exp(tail.log_p(np.array([20.0]))[0]) == pytest.approx(math.exp(-10.0), rel=0.3)
    assert math.exp(tail.log_p(np.array([1.0]))[0]) == pytest.approx(math.exp(-0.5), rel=0.02)
    assert tail.at(float(tail.log_p(np.array([15.0]))[0])) == pytest.approx(15.0)
    alike = Tail.of(np.zeros(100))
    assert np.all(alike.log_p(np.array([1e-3, 1e6])) < -100.0)
    assert tail.quantile(0.001) == pytest.approx(2.0 * math.log(1000.0), rel=0.05)


def test_replicas_scatter_as_the_fit_believes_and_keep_the_noise_it_left():
    level = make_level([member("short", SHORT[:2], 2300)])
    fit = stands(level)
    left = left_by(fit, fit)
    assert all(np.array_equal(a, b) for a, b in zip(left, fit.solution.residuals, strict=True))
    drawn = replicas(level, fit.solution, left, 300, np.random.default_rng(1))
    for residual, many, jac, used in zip(left, drawn, fit.solution.jacobians, fit.solution.used, strict=True):
        assert many.shape == (residual.size, 300)
        priors = np.array([fit.solution.problem.unknowns[i].prior_std for i in used])
        moved = jac * np.where(np.isfinite(priors), priors, 0.0)
        expected = float(np.mean(residual**2) + np.mean(np.sum(moved**2, axis=1)))
        assert float(np.mean(many**2)) == pytest.approx(expected, rel=0.2)


def test_an_effect_that_the_reported_numbers_take_up_moves_them_and_not_the_free_run():
    level = make_level([member("short", SHORT[:2], 2300)])
    fit = stands(level)
    stand = Stands.of(fit)
    errors = {"drag_coefficient@short": 0.1, "drag_coefficient": 0.1}
    sizes = Sizes.on(level, stand, errors)
    damping, forced = (
        places(level, stand, suspect, suspect.grid(level.scales))[0]
        for suspect in (found("linear_damping", "one for all springs"), found("cubic_stiffness"))
    )
    for place in (damping, forced):
        measure = sizes.measure(place)
        one = np.ones((place.width, 1))
        assert measure.of_free_run(2.0 * one)[0] == pytest.approx(2.0 * measure.of_free_run(one)[0])
        assert measure.of(one)[0] >= 2.0 * measure.of_free_run(one)[0]
        assert measure.bound(np.zeros(place.width), np.zeros((place.width, place.width)), 1.6) == pytest.approx(0.0)


def test_where_nothing_can_be_tested_there_is_no_probability():
    level = make_level([member("short", SHORT[:2], 2300)])
    fit = stands(level)
    none = null_test(level, (), fit, ())
    assert math.isnan(none.p_value)
    assert (none.tests, none.detectable, none.hides_best) == ((), (), "")
    assert math.isnan(NullTest(0.5, (SuspectTest("a", 0.5, 1.0, 0.1, math.nan),)).upper_bound)
    assert 0.0 < POWER < 1.0
    wide = Detectable("b", "mass_kg", 44.0, "kg", 330.0)
    both = NullTest(0.5, (SuspectTest("a", 0.5, 1.0, 0.1, 0.5), SuspectTest("b (x)", 0.5, 1.0, 0.1, 9.0, wide)), 0.03)
    assert (both.not_testable, both.detectable, both.upper_bound) == (("b",), (), 0.5 * 0.03)
