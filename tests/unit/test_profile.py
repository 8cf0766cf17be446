"""Profile likelihood: a parabola where a standard error is right, open where nothing holds a number."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tests.small_campaign import BODY, recorded
from undertow.conditioning.condition import condition
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Specimen
from undertow.likelihood.output_error import fit
from undertow.likelihood.problem import Problem, TrialOptions, Unknown
from undertow.methods.baseline import fit_group, group_model, terms_by_name
from undertow.recording.recording import Recording
from undertow.uncertainty.intervals import residual_covariance
from undertow.uncertainty.profile import profile

TERMS = ("stiffness", "viscous_damping", "coulomb_friction")


@cache
def solution():
    table = recorded(0.05, 3)
    channels = {"displacement": table[:, 1], "acceleration": table[:, 2]}
    motion = condition(Recording("r", table[:, 0], channels))
    model = group_model(terms_by_name(TERMS), [motion], Specimen(2637.4), None, dry=True, anchored=True)
    return fit_group(model, [motion], TrialOptions())


def test_a_well_known_number_has_the_interval_that_its_standard_error_says():
    group = solution()
    found = profile(group.solution, "k_N_per_m")
    index = group.solution.problem.names.index("k_N_per_m")
    stderr = float(np.sqrt(residual_covariance(group.solution)[index, index]))
    assert found.outcome == "ok"
    assert found.lower < BODY.k_N_per_m < found.upper
    half = 0.5 * (found.upper - found.lower)
    assert half == pytest.approx(1.6449 * stderr, rel=0.2)  # two channels weigh a little differently
    assert abs(0.5 * (found.upper + found.lower) - found.best) < 0.1 * half


def test_a_profile_is_lowest_at_the_best_value_and_rises_on_both_sides():
    found = profile(solution().solution, "c_Ns_per_m", 0.68)
    at = int(np.argmin(found.rise))
    assert found.values[at] == pytest.approx(found.best)
    assert np.all(np.diff(found.values) >= 0.0)
    assert found.rise[0] > 0.98  # chi-squared at 68 % with one degree of freedom is 0.99; ends to 1 %
    assert found.rise[-1] > 0.98


def test_more_confidence_is_a_wider_interval():
    narrow, wide = (profile(solution().solution, "mu", level) for level in (0.68, 0.95))
    assert wide.lower < narrow.lower < narrow.upper < wide.upper


def test_an_interval_ends_at_a_bound_that_the_data_do_not_rule_out():
    group = solution()
    best = group.solution.value("mu")
    index = group.solution.problem.names.index("mu")
    unknowns = list(group.solution.problem.unknowns)
    bounded = Unknown("mu", best, lower=best * (1.0 - 1e-6), upper=np.inf, scale=best)
    unknowns[index] = bounded
    again = fit(Problem(tuple(unknowns), group.solution.problem.trials), group.solution.values, growing=False)
    assert profile(again, "mu").lower == pytest.approx(best * (1.0 - 1e-6))


def test_a_number_that_the_trials_do_not_speak_of_is_said_to_be_open():
    group = solution()
    problem = group.solution.problem
    free = Unknown("nothing", 1.0, scale=1.0)
    wider = Problem((*problem.unknowns, free), problem.trials)
    found = fit(wider, np.append(group.solution.values, 1.0), growing=False)
    open_one = profile(found, "nothing")
    assert open_one.outcome == "nothing is not bounded below and above by these trials"
    assert open_one.upper == np.inf


def test_a_name_that_the_fit_does_not_have_is_refused():
    with pytest.raises(IdentificationError, match="profile of 'drag': the fit has k_N_per_m, c_Ns_per_m"):
        profile(solution().solution, "drag")


def test_a_level_outside_0_to_1_is_refused():
    with pytest.raises(IdentificationError, match="profile of mu: confidence level is 90; it must lie between 0 and 1"):
        profile(solution().solution, "mu", 90.0)
