"""The posterior over trials' scatter, held against the one case that has an exact answer, and against simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from undertow.errors import IdentificationError
from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Channel, Link, Problem, TrialProblem, Unknown
from undertow.uncertainty.hierarchy import Effect, Held, group_posterior, held_intervals
from undertow.uncertainty.intervals import noise_factors, residual_covariance

CELLS = 40


def level_problem(values, scatter, mean_error, sigma=1e-4):
    """Trials that each measure beta + k_mean + k[trial] in every cell: as plain a hierarchy as there is."""
    unknowns = [Unknown("beta", 0.0, scale=1.0)]
    if mean_error > 0.0:
        unknowns.append(Unknown("k_mean", 0.0, prior_std=mean_error, scale=mean_error))
    trials, residuals, jacobians, used, found = [], [], [], [], [float(np.mean(values))] + [0.0] * (mean_error > 0.0)
    for i, value in enumerate(values):
        shared = list(range(1 + (mean_error > 0.0)))
        own = len(unknowns)
        unknowns.append(Unknown(f"k[t{i}]", 0.0, prior_std=scatter, scale=scatter))
        found.append(value - float(np.mean(values)))
        links = tuple(Link(0, j) for j in (*shared, own))
        channel = Channel("displacement", np.full(CELLS, value), sigma)
        trials.append(TrialProblem(f"t{i}", np.arange(CELLS) * 0.1, np.zeros(1), links, (channel,)))
        residuals.append(np.zeros(CELLS))
        jacobians.append(np.full((CELLS, len(links)), 1.0 / sigma))
        used.append(np.array([*shared, own], dtype=np.int64))
    size = len(unknowns)
    return Solution(
        Problem(tuple(unknowns), tuple(trials)), np.array(found), np.eye(size), 0.0, 0.0, CELLS * len(values), 1, "ok",
        tuple(residuals), tuple(jacobians), tuple(used),
    )  # fmt: skip


@pytest.mark.parametrize(("dry", "wet"), [(3, 3), (4, 4), (6, 3)])
def test_dry_and_wet_trials_together_give_student_s_interval_of_the_pooled_scatter(dry, wet):
    rng = np.random.default_rng(dry + wet)
    in_air, in_water = rng.normal(0.0, 1.0, dry), rng.normal(0.0, 1.0, wet)
    scatter = float(np.std(in_air, ddof=1))
    solution = level_problem(in_water, scatter, scatter / math.sqrt(dry))
    found = group_posterior(solution, [0], [Effect("k", dry - 1.0)])
    freedom = dry + wet - 2
    pooled = math.sqrt(((dry - 1) * scatter**2 + (wet - 1) * np.var(in_water, ddof=1)) / freedom)
    exact = stats.t.ppf(0.95, freedom) * pooled * math.sqrt(1.0 / dry + 1.0 / wet)
    assert found.values[0] == pytest.approx(np.mean(in_water), abs=1e-3)
    assert found.half_widths[0] == pytest.approx(exact, rel=0.03)  # 13 scatters on a grid
    assert found.share_of_means[0] == pytest.approx((1.0 / dry) / (1.0 / dry + 1.0 / wet), abs=0.01)


def test_a_stated_scatter_is_taken_as_it_is():
    solution = level_problem(np.array([0.0, 5.0, -5.0]), 1.0, 0.5)
    found = group_posterior(solution, [0], [Effect("k", math.inf)])
    assert found.half_widths[0] == pytest.approx(1.6449 * math.sqrt(1.0 / 3.0 + 0.25), rel=1e-3)
    assert found.scatter["k"] == 1.0


def test_trials_in_water_that_scatter_more_than_the_dry_ones_widen_the_interval():
    quiet = group_posterior(level_problem(np.array([-0.1, 0.0, 0.1]), 0.1, 0.05), [0], [Effect("k", 3.0)])
    wild = group_posterior(level_problem(np.array([-1.0, 0.0, 1.0]), 0.1, 0.05), [0], [Effect("k", 3.0)])
    assert wild.half_widths[0] > 4.0 * quiet.half_widths[0]
    assert wild.scatter["k"] > 3.0 > quiet.scatter["k"] * 1.5


def test_an_assumed_scatter_counts_as_seen_with_two_degrees_of_freedom():
    solution = level_problem(np.array([0.0, 0.1, -0.1]), 0.1, 0.0)
    assumed = group_posterior(solution, [0], [Effect("k", 0.0)])
    seen = group_posterior(solution, [0], [Effect("k", 2.0)])
    assert assumed.half_widths[0] == seen.half_widths[0]


def test_a_posterior_of_no_unknown_is_refused():
    solution = level_problem(np.array([0.0, 0.1]), 0.1, 0.0)
    with pytest.raises(IdentificationError, match=r"a posterior of 0 shared unknowns; name some of beta, k\[t0\]"):
        group_posterior(solution, [], [Effect("k", 3.0)])


def test_what_a_fit_holds_widens_it_by_own_scatter_and_by_the_mean_that_all_trials_share():
    slopes = np.full((4, 1), 0.25)  # a mean of four trials
    half, share = held_intervals(np.array([0.0]), [Held(slopes, 2.0, 1.0, math.inf)])
    assert half[0] == pytest.approx(1.6449 * math.sqrt(2.0**2 / 4.0 + 1.0), rel=1e-4)
    assert share[0] == pytest.approx(0.5)


def test_a_scatter_seen_with_two_degrees_of_freedom_gives_student_s_t():
    slopes = np.full((3, 1), 1.0 / 3.0)
    half, _ = held_intervals(np.array([0.0]), [Held(slopes, 1.0, 0.0, 2.0)])
    assert half[0] == pytest.approx(stats.t.ppf(0.95, 2) / math.sqrt(3.0), rel=0.03)


def test_nothing_held_leaves_the_noise():
    half, share = held_intervals(np.array([4.0]), [])
    assert half[0] == pytest.approx(2.0 * 1.6449, rel=1e-4)
    assert share[0] == 0.0


def noisy_solution(make, seed=5, cells=400):
    """One trial, one unknown (a level), white sigma 1 stated, residual from ``make(rng, cells)``."""
    rng = np.random.default_rng(seed)
    r = make(rng, cells)
    unknown = Unknown("level", 0.0)
    channel = Channel("displacement", r, 1.0)
    trial = TrialProblem("t", np.arange(cells) * 0.02, np.zeros(1), (Link(0, 0),), (channel,), period_s=1.0)
    jac = np.cos(2.0 * np.pi * trial.t)[:, None]
    return Solution(
        Problem((unknown,), (trial,)), np.zeros(1), np.array([[1.0 / float(jac[:, 0] @ jac[:, 0])]]), 0.0,
        float(r @ r), cells, 1, "ok", (r,), (jac,), (np.array([0]),),
    )  # fmt: skip


def test_white_noise_as_stated_has_a_factor_near_one():
    factors = [noise_factors(noisy_solution(lambda g, n: g.standard_normal(n), seed))[0][0] for seed in range(40)]
    assert 1.0 <= np.mean(factors) < 1.35  # never under 1, and 10 bins a record


def test_coloured_noise_counts_with_its_density_at_the_motion_s_frequency():
    memory = 0.9

    def coloured(rng, cells):
        out = np.zeros(cells)
        for i in range(1, cells):
            out[i] = memory * out[i - 1] + rng.standard_normal()
        return out

    factors = [noise_factors(noisy_solution(coloured, seed))[0][0] for seed in range(40)]
    low = 2.0 * np.pi * np.linspace(0.125, 1.25, 10) * 0.02
    expected = np.mean(1.0 / (1.0 - 2.0 * memory * np.cos(low) + memory**2))
    assert np.mean(factors) == pytest.approx(expected, rel=0.25)  # 40 records of 10 bins


def test_the_residual_s_covariance_grows_with_its_colour():
    white = residual_covariance(noisy_solution(lambda g, n: g.standard_normal(n)))[0, 0]
    slow = residual_covariance(noisy_solution(lambda g, n: 3.0 * np.sin(2.0 * np.pi * np.arange(n) * 0.02)))[0, 0]
    assert slow > 10.0 * white
