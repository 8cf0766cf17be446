"""A search's budget counts the integrator's steps and stops what spends more."""

from __future__ import annotations

import numpy as np
import pytest

from undertow.equation.driven_kernel import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.equation import equation_15
from undertow.equation.input import drive_of
from undertow.likelihood import output_error
from undertow.likelihood.budget import BudgetError, metered, spend
from undertow.likelihood.problem import Channel, Link, TrialProblem


def test_what_an_inner_meter_spends_its_outer_one_spends_too():
    with metered(100.0) as outer, metered(10.0) as inner:
        spend(7)
    assert (outer.spent, inner.spent) == (7.0, 7.0)


def test_the_meter_that_ran_out_is_named():
    with metered(100.0) as outer, metered(10.0) as inner:
        with pytest.raises(BudgetError, match="took more than the 10 integrator steps") as short:
            spend(11)
        assert short.value.meter is inner
        with pytest.raises(BudgetError, match="took more than the 100 integrator steps") as long:
            spend(100)
        assert long.value.meter is outer


def test_nothing_is_counted_outside_a_meter():
    spend(1e30)


def test_a_trajectory_spends_its_steps_times_its_columns():
    theta = equation_15(2637.4, 0.0, 590.0, 109600.0, 170.0, 3924.0).theta()
    times = np.arange(0.0, 3.0, 0.01)
    none, two = np.zeros(0, dtype=np.int64), np.array([0, 1])
    with metered(1e12) as alone:
        output_error.trajectory(theta, none, times)
    with metered(1e12) as carried:
        output_error.trajectory(theta, two, times)
    assert carried.spent == pytest.approx(3.0 * alone.spent)


def driven(*slots: str, begins_s: float = 0.0) -> TrialProblem:
    """Half a second of a body under a rising force, whose numbers in ``slots`` are unknown."""
    theta, t = np.zeros(N_DRIVEN), begins_s + np.arange(0.0, 0.5, 0.01)
    for name, value in {"gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0, "mass": 4.0, "k1": 100.0, "c1": 3.0}.items():
        theta[DRIVEN_SLOT[name]] = value
    links = tuple(Link(DRIVEN_SLOT[name], i) for i, name in enumerate(slots))
    seen = (Channel("displacement", np.zeros(t.size), 1.0),)
    return TrialProblem("run", t, theta, links, seen, drive=drive_of(t, 20.0 * (t - t[0]), "first"))


def test_a_driven_motion_spends_its_steps_times_its_columns():
    with metered(1e12) as alone:
        assert output_error.residuals(driven(), np.zeros(0)) is not None
    with metered(1e12) as carried:
        assert output_error.residuals(driven("k1", "c1"), np.zeros(2)) is not None
    assert carried.spent == pytest.approx(3.0 * alone.spent)


def test_a_driven_record_may_begin_before_its_clocks_zero():
    later, earlier = (output_error.residuals(driven("k1", begins_s=s), np.zeros(1))[0] for s in (0.0, -0.25))
    assert np.max(later) > 1e-3
    assert earlier == pytest.approx(later, rel=1e-9, abs=1e-12)
