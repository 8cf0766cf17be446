"""Errors of numbers that describe: what leaving out one trial after the other gives."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.concealed.test_diagnosis import member
from tests.concealed.test_small_effects import found, stands
from undertow.comparison.by_trials import FEWEST_HALVED, between_sizes, jackknife, with_errors_by_trials
from undertow.comparison.joint import JointFit, fit_joint
from undertow.comparison.level import Addend, Level, make_level
from undertow.equation import registry

RELEASES = (0.010, 0.016, 0.023, 0.03)


@cache
def described() -> tuple[Level, JointFit]:
    """Trials whose damping goes with the cube of the speed, described by a linear one."""
    hidden = ((registry.find("cubic_damping"), 300_000.0),)
    level = make_level([member("short", RELEASES, 7300, hidden)])
    return level, with_linear_damping(level)


def with_linear_damping(level: Level) -> JointFit:
    suspect = found("linear_damping", "one for all springs")
    addend = Addend("linear_damping", suspect.additions(level.scales, 0.0))
    before = stands(level)
    return fit_joint(level, (addend,), before.memory, before.values, before.misfit, growing=False)


def test_one_step_gives_the_jackknife_of_fits_without_each_trial():
    level, fit = described()
    assert fit.misfit > 2.5
    place = fit.solution.problem.names.index("linear_damping.c_Ns_per_m")
    (whole,) = level.members
    without = []
    for i in range(len(RELEASES)):
        kept = tuple(m for j, m in enumerate(whole.motions) if j != i)
        level_without = make_level([replace(whole, motions=kept)])
        start = {name: value for name, value in fit.values.items() if whole.motions[i].name not in name}
        again = fit_joint(level_without, fit.addends, fit.memory, start, fit.misfit, growing=False)
        without.append(again.value("linear_damping.c_Ns_per_m"))
    n = len(without)
    exact = np.sqrt((n - 1) / n * np.sum((np.array(without) - fit.solution.values[place]) ** 2))
    assert jackknife(fit)[place] == pytest.approx(exact, rel=0.5)
    assert exact > 2.0 * fit.solution.stderr("linear_damping.c_Ns_per_m")  # trials differ by more than is stated


def without(level: Level, fit: JointFit, kept: slice) -> float:
    """The damping that these trials alone give."""
    (whole,) = level.members
    fewer = make_level([replace(whole, motions=whole.motions[kept])])
    gone = {m.name for m in whole.motions} - {m.name for m in whole.motions[kept]}
    start = {name: value for name, value in fit.values.items() if not any(trial in name for trial in gone)}
    again = fit_joint(fewer, fit.addends, fit.memory, start, fit.misfit, growing=False)
    return again.value("linear_damping.c_Ns_per_m")


def test_numbers_that_go_with_the_size_of_the_motion_differ_by_half_of_what_small_and_large_releases_say():
    level, fit = described()
    place = fit.solution.problem.names.index("linear_damping.c_Ns_per_m")
    small, large = (without(level, fit, kept) for kept in (slice(0, 2), slice(2, 4)))
    assert large < 1.3 * small < 0.0  # beside a drag that takes up too much of the cube
    assert between_sizes(fit)[place] == pytest.approx(0.5 * (small - large), rel=0.5)
    assert between_sizes(fit)[place] > jackknife(fit)[place]
    own = [i for i, n in enumerate(fit.solution.problem.names) if n.endswith("]")]
    assert np.all(between_sizes(fit)[own] == 0.0)


def test_three_trials_have_no_small_and_large_half():
    level, _ = described()
    (whole,) = level.members
    few = with_linear_damping(make_level([replace(whole, motions=whole.motions[: FEWEST_HALVED - 1])]))
    assert np.all(between_sizes(few) == 0.0)
    assert np.any(jackknife(few) > 0.0)


def test_a_descriptions_errors_grow_and_its_correlations_stay():
    _, fit = described()
    grown = with_errors_by_trials(fit)
    name = "linear_damping.c_Ns_per_m"
    place = fit.solution.problem.names.index(name)
    assert grown.solution.stderr(name) == pytest.approx(max(jackknife(fit)[place], between_sizes(fit)[place]))
    before, after = (
        c / np.sqrt(np.outer(np.diag(c), np.diag(c))) for c in (fit.solution.covariance, grown.solution.covariance)
    )
    assert after == pytest.approx(before)
    assert np.all(np.diag(grown.solution.covariance) >= np.diag(fit.solution.covariance) * (1.0 - 1e-12))
    own = [i for i, n in enumerate(fit.solution.problem.names) if n.endswith("]")]
    assert grown.solution.covariance[own, own] == pytest.approx(fit.solution.covariance[own, own])


@pytest.mark.filterwarnings("error")
def test_a_number_on_its_bound_keeps_its_error():
    _, fit = described()
    place = fit.solution.problem.names.index("linear_damping.c_Ns_per_m")
    for held in (0.0, 5e-324, 1e-40):
        covariance = fit.solution.covariance.copy()
        covariance[place], covariance[:, place] = 0.0, 0.0
        covariance[place, place] = held
        grown = with_errors_by_trials(replace(fit, solution=replace(fit.solution, covariance=covariance)))
        assert np.all(np.isfinite(grown.solution.covariance))
        assert grown.solution.covariance[place, place] == held


def test_errors_of_a_law_and_of_two_trials_stay_as_stated():
    level, fit = described()
    assert with_errors_by_trials(replace(fit, misfit=2.4)) is not None
    assert with_errors_by_trials(replace(fit, misfit=2.4)).solution is fit.solution
    (whole,) = level.members
    pair = make_level([replace(whole, motions=whole.motions[:2])])
    few = replace(with_linear_damping(pair), misfit=50.0)
    assert with_errors_by_trials(few) is few
