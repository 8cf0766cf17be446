"""Intervals from few values: Student's t where it is exact, the scatter summed over where trials have noise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from undertow.errors import IdentificationError
from undertow.quantities import Estimate
from undertow.uncertainty.confidence import as_stderr, half_width, mixture_half_width, widening
from undertow.uncertainty.repeats import mean_of_trials, mean_over, scatter_between, scatter_of_two, weighted_mean


def test_a_half_width_is_students_t_times_the_standard_error():
    assert half_width(2.0, 0.9, 3.0) == pytest.approx(2.0 * stats.t.ppf(0.95, 3))
    assert half_width(2.0) == pytest.approx(2.0 * 1.6449, rel=1e-4)


def test_a_widened_standard_error_gives_students_interval_at_the_normal_quantile():
    assert as_stderr(half_width(1.0, 0.9, 2.0)) == pytest.approx(widening(2.0))
    assert widening(math.inf) == 1.0


def test_a_mixture_of_two_widths_lies_between_them():
    weights = np.array([0.5, 0.5])
    half = mixture_half_width(0.0, np.zeros(2), np.array([1.0, 3.0]), weights)
    assert 1.645 < half < 3.0 * 1.645
    inside = weights @ (2.0 * stats.norm.cdf(half / np.array([1.0, 3.0])) - 1.0)
    assert inside == pytest.approx(0.9, abs=1e-9)


def test_a_mixture_without_spread_has_no_width():
    assert mixture_half_width(1.0, np.ones(3), np.zeros(3), np.full(3, 1.0 / 3.0)) == 0.0


@pytest.mark.parametrize("level", [0.0, 1.0, 90.0])
def test_a_confidence_level_outside_0_to_1_is_refused(level):
    with pytest.raises(IdentificationError, match=f"confidence level is {level:g}; it must lie between 0 and 1"):
        half_width(1.0, level)


@pytest.mark.parametrize("count", [2, 3, 4, 6, 12])
def test_a_mean_of_values_without_noise_has_students_interval(count):
    values = np.random.default_rng(count).normal(100.0, 5.0, count)
    mean = mean_of_trials([Estimate(v) for v in values], "kg", "trials")
    exact = stats.t.ppf(0.95, count - 1) * np.std(values, ddof=1) / math.sqrt(count)
    assert mean.value == pytest.approx(np.mean(values))
    assert 1.6449 * mean.stderr == pytest.approx(exact, rel=0.01)  # a grid of 300 scatters
    assert mean.freedom == count - 1


def test_chance_agreement_of_noisy_trials_does_not_pass_for_precision():
    """One precise trial among noisy ones that happen to agree: its own noise is not the mean's error."""
    values, noise = np.array([10.0, 10.1, 9.95, 10.02]), np.array([2.0, 1.5, 1.0, 0.01])
    estimates = [Estimate(v, s) for v, s in zip(values, noise, strict=True)]
    assert mean_of_trials(estimates, "", "trials").stderr > 5.0 * 0.01


def test_a_mean_over_trials_covers_the_rig_s_mean_in_90_of_100_campaigns():
    rng = np.random.default_rng(7)
    inside = []
    for _ in range(400):
        noise = rng.uniform(0.02, 0.3, 3)  # in scatters, as a snap release gives; larger noise is on the safe side
        values = 50.0 + rng.normal(0.0, 1.0, 3) + noise * rng.standard_normal(3)
        mean = mean_of_trials([Estimate(v, s) for v, s in zip(values, noise, strict=True)], "", "trials")
        inside.append(abs(mean.value - 50.0) <= 1.6449 * mean.stderr)
    assert 0.86 < np.mean(inside) < 0.95  # 400 campaigns: standard error 1.5 %


def test_two_springs_tell_the_scatter_better_than_one():
    rng = np.random.default_rng(3)
    groups = [(rng.normal(0.0, 1.0, 4), np.full(4, 0.1)) for _ in range(8)]
    one, eight = scatter_between(groups[:1]), scatter_between(groups)

    def spread(between):
        mean = between.weights @ between.values
        return math.sqrt(between.weights @ (between.values - mean) ** 2)

    assert spread(eight) < 0.5 * spread(one)
    assert 0.6 < eight.median < 1.5


def test_scatter_far_below_noise_is_said_to_be_small_but_not_none():
    values, noise = np.array([1.0, 1.001, 0.999, 1.0]), np.full(4, 0.1)
    between = scatter_between([(values, noise)])
    assert 0.0 < between.median < 0.1


def test_numbers_whose_noise_is_each_its_own_scatter_each_for_itself():
    rng = np.random.default_rng(5)
    values, noise = 1.0 + rng.normal(0.0, [0.15, 0.08], (6, 2)), np.full((6, 2), 0.03)
    both = scatter_of_two([(values, noise, np.zeros(6))])
    for j, between in enumerate(both):
        assert between.median == pytest.approx(scatter_between([(values[:, j], noise[:, j])]).median, rel=0.02)


def test_noise_that_trades_damping_for_friction_does_not_pass_for_scatter():
    rng = np.random.default_rng(6)
    true, noise, together = np.array([0.15, 0.08]), 0.3, -0.99
    root = noise * np.linalg.cholesky([[1.0, together], [together, 1.0]])
    found, alone = [], []
    for _ in range(40):
        values = 1.0 + true * rng.standard_normal((4, 2)) + rng.standard_normal((4, 2)) @ root.T
        both = scatter_of_two([(values, np.full((4, 2), noise), np.full(4, together))])
        found.append([between.median for between in both])
        alone.append([scatter_between([(values[:, j], np.full(4, noise))]).median for j in (0, 1)])
    assert np.all(np.median(found, axis=0) < 0.5 * np.median(alone, axis=0))
    assert 0.7 < math.hypot(*np.median(found, axis=0)) / math.hypot(*true) < 1.3


def test_values_that_differ_along_the_noise_have_not_scattered_and_those_across_it_have():
    steps = 0.3 * np.array([-1.0, 0.5, 0.9, -0.4])
    noise, together = np.full((4, 2), 0.3), np.full(4, -0.99)
    along, across = (
        scatter_of_two([(1.0 + np.column_stack([steps, sign * steps]), noise, together)]) for sign in (-1.0, 1.0)
    )
    assert all(a.median < 0.3 * b.median for a, b in zip(along, across, strict=True))


def test_two_numbers_without_noise_or_difference_have_no_scatter():
    first, second = scatter_of_two([(np.full((3, 2), 4.0), np.zeros((3, 2)), np.zeros(3))])
    assert (first.median, second.median) == (0.0, 0.0)


def test_equal_values_without_noise_have_no_scatter():
    between = scatter_between([(np.full(3, 4.0), np.zeros(3))])
    assert mean_over(np.full(3, 4.0), np.zeros(3), between) == (4.0, 0.0)


def test_weights_follow_noise_and_scatter():
    mean, error = weighted_mean(np.array([0.0, 1.0]), np.array([1.0, 0.0]), 1.0)
    assert mean == pytest.approx(2.0 / 3.0)
    assert error == pytest.approx(math.sqrt(2.0 / 3.0))


def test_single_trials_show_no_scatter():
    with pytest.raises(IdentificationError, match="2 groups, none with two trials; repeat a release"):
        scatter_between([(np.array([1.0]), np.array([0.1])), (np.array([2.0]), np.array([0.1]))])


def test_one_trial_keeps_its_own_error():
    assert mean_of_trials([Estimate(3.0, 0.5)], "kg", "one").stderr == 0.5
    assert math.isnan(mean_of_trials([Estimate(3.0)], "kg", "one").stderr)


def test_a_mean_of_nothing_finite_is_refused():
    with pytest.raises(IdentificationError, match="dry trials: none of 2 trials has a finite value"):
        mean_of_trials([Estimate(math.nan), Estimate(math.inf)], "kg", "dry trials")
