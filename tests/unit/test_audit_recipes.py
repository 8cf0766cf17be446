"""The recipes on simulated motions: the fast Method 1 is the slow one, Method 2 has the errors its formulas have."""

from __future__ import annotations

import math

import numpy as np
import pytest

from undertow.audit.recipes import Known, Returned, method1_returns, method2_returns, trajectory
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.errors import UndertowError
from undertow.likelihood.fit import Specimen
from undertow.methods.method1 import History, search

LONG = Known(2637.4, 109592.0, 590.0, 0.0073, 0.97, 0.3)
SHORT = Known(2637.4, 402036.0, 821.0, 0.0065, 0.97, 0.3)


def physics(known: Known, x0: float, added: float, drag: float, **slots: float) -> np.ndarray:
    theta = np.zeros(N_SLOTS)
    theta[SLOT["mass"]], theta[SLOT["k1"]] = known.mass_kg + added, known.k_N_per_m
    theta[SLOT["c1"]], theta[SLOT["fc"]], theta[SLOT["x0"]] = known.c_Ns_per_m, known.friction_N, x0
    theta[SLOT["q"]] = drag * known.drag_unit
    for name, value in slots.items():
        theta[SLOT[name]] += value
    return theta


CASES = {
    "equation 15": (LONG, physics(LONG, 0.108, 1271.0, 6.0), 6.0),
    "linear damping": (LONG, physics(LONG, 0.030, 1271.0, 1.0, c1=600.0), 4.0),
    "resonator": (LONG, physics(LONG, 0.108, 500.0, 2.0, hm1=300.0, hw1=9.4, hz1=0.02), 4.0),
    "resonator below the body": (SHORT, physics(SHORT, 0.033, 500.0, 2.0, hm1=300.0, hw1=9.4, hz1=0.02), 2.5),
}


@pytest.mark.parametrize("name", CASES)
def test_the_fast_search_ends_where_nelder_mead_does(name):
    known, theta, window = CASES[name]
    fast = method1_returns(theta, known, window)
    times = np.arange(0.0, window, 0.004)
    x, _, _ = trajectory(theta, times, 0.01)
    specimen = Specimen(known.mass_kg, area_m2=known.area_m2, submerged_volume_m3=known.volume_m3)
    slow = search(History(times, x, float(x[0])), (known.k_N_per_m, known.c_Ns_per_m, known.mu), specimen, -math.inf)
    # 2 kg and 1 %: 24 samples a period against every 4 ms, where the model cannot fit, weigh the cycles differently
    assert fast.added_mass_kg == pytest.approx(slow[0], abs=2.0)
    assert fast.drag_coefficient == pytest.approx(slow[1], rel=0.01)


def test_a_start_near_by_leads_to_the_same_minimum():
    known, theta, window = CASES["resonator"]
    blind = method1_returns(theta, known, window)
    near = Returned(blind.added_mass_kg + 40.0, blind.drag_coefficient + 1.0, blind.bounded_drag)
    again = method1_returns(theta, known, window, start=near)
    assert again.added_mass_kg == pytest.approx(blind.added_mass_kg, abs=0.2)  # the last step is below 1e-3
    assert again.drag_coefficient == pytest.approx(blind.drag_coefficient, rel=1e-3)


def test_a_negative_added_mass_is_printed_as_zero_with_the_drag_of_the_bound():
    known, _, window = CASES["resonator below the body"]
    low = method1_returns(physics(SHORT, 0.033, 0.0, 2.0, hm1=300.0, hw1=9.0, hz1=0.02), known, window)
    assert low.added_mass_kg < 0.0
    assert low.bounded == (0.0, low.bounded_drag)
    assert Returned(10.0, 2.0, 3.0).bounded == (10.0, 2.0)


@pytest.mark.parametrize(("share", "side"), [(1.0, -1.0), (0.0, 0.0), (-1.0, 1.0)])
def test_method_2_misses_added_mass_by_friction_on_the_side_of_the_jump_it_reads(share, side):
    theta = physics(LONG, 0.05, 1200.0, 0.0)
    got = method2_returns(theta, LONG, turn_share=share)
    bias = side * LONG.friction_N / (LONG.k_N_per_m * 0.045 / 3837.4)  # |x''| at a first turn of about 45 mm
    assert got.added_mass_kg - 1200.0 == pytest.approx(bias, abs=0.15 * abs(bias) + 3.0)


def test_an_offset_of_the_displacement_tilts_method_2_with_one_over_the_release():
    errors = [
        method2_returns(physics(LONG, x0, 1200.0, 2.0), LONG, offset_m=0.001).added_mass_kg - 1200.0
        for x0 in (0.02, 0.04, 0.08)
    ]
    ratios = np.array(errors[:-1]) / errors[1:]
    assert np.all(np.array(errors) < 0.0)  # the first turn is on the other side: the offset takes from it
    assert np.allclose(ratios, 2.0, atol=0.6)  # the turn is smaller than the release by friction and drag


def test_eq_21_as_printed_is_taken_in_magnitude_and_its_sign_kept_beside():
    got = method2_returns(physics(LONG, 0.05, 1200.0, 4.0), LONG, keep_inertia=False)
    assert got.bounded_drag < 0.0
    assert got.drag_coefficient == -got.bounded_drag


def test_a_motion_that_sticks_before_it_turns_is_refused():
    theta = physics(LONG, 0.0018, 0.0, 0.0)
    with pytest.raises(UndertowError, match=r"from 0\.0018 m sticks within half a cycle"):
        method2_returns(theta, LONG, offset_m=0.0017)


def test_a_motion_that_runs_away_is_refused():
    theta = physics(LONG, 0.05, 0.0, 0.0, c1=-9000.0)
    with pytest.raises(UndertowError, match=r"from 0\.05 m left every bound"):
        trajectory(theta, np.linspace(0.0, 400.0, 5), 0.01)
