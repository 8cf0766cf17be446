"""A search's budget counts the integrator's steps and stops what spends more."""

from __future__ import annotations

import numpy as np
import pytest

from undertow.equation.equation import equation_15
from undertow.likelihood import output_error
from undertow.likelihood.budget import BudgetError, metered, spend


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
