"""A fit's steps: short enough for the body, and no shorter than what swings beside it or acts on it needs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.simulate import fastest_frequency, step_of_motion
from undertow.likelihood.output_error import FULL, QUICK, trajectory

OWN = math.sqrt(4000.0 / 100.0)
TIMES = np.linspace(0.0, 20.0, 2001)
BESIDE = {
    "nothing": {},
    "a light resonator at 1.5": {"hm1": 3.0, "hw1": 1.5 * OWN, "hz1": 0.01},
    "a heavy resonator at 3": {"hm1": 30.0, "hw1": 3.0 * OWN, "hz1": 0.01},
    "a resonator at 6": {"hm1": 10.0, "hw1": 6.0 * OWN, "hz1": 0.01},
    "a force at 2": {"fcos": 40.0, "omega": 2.0 * OWN},
    "a force at 6": {"fcos": 40.0, "omega": 6.0 * OWN},
    "a memory that fades at once": {"rk1": 1000.0, "rt1": 0.01},
    "a memory that fades within a period": {"rk1": 1000.0, "rt1": 0.1},
    "bristles that bend at once": {"kb": 4000.0, "fb": 2.0},
    "bristles that bend slowly": {"kb": 4000.0, "fb": 100.0},
}


def body(**numbers: float) -> np.ndarray:
    """100 kg on 4 kN/m with every kind of damping, let go at 0.1 m."""
    theta = np.zeros(N_SLOTS)
    basis = {"mass": 100.0, "k1": 4000.0, "c1": 5.0, "q": 30.0, "fc": 0.2, "x0": 0.1}
    for slot, value in (basis | numbers).items():
        theta[SLOT[slot]] = value
    return theta


@pytest.mark.parametrize("beside", BESIDE.values(), ids=BESIDE)
def test_a_fit_s_steps_are_exact_beside_any_sensor_and_a_quick_search_s_nearly(beside):
    theta = body(**beside)
    active = np.array([SLOT[slot] for slot in ("mass", "k1", "c1", "q", "fc", *beside)])
    fine = trajectory(theta, active, TIMES, 10 * FULL.steps_a_period)[0]
    size = np.abs(fine).max(axis=0)
    for effort, motion, slope in ((FULL, 1e-6, 1e-4), (QUICK, 2e-5, 2e-3)):
        error = np.abs(trajectory(theta, active, TIMES, effort.steps_a_period)[0] - fine).max(axis=0) / size
        assert error[0] < motion
        assert error[1:].max() < slope


def test_what_swings_beside_the_body_shortens_steps_by_less_than_its_frequency_is_higher():
    own = 2.0 * math.pi / OWN / 40
    assert step_of_motion(body(), 40) == pytest.approx(own)
    force = body(fcos=40.0, omega=6.0 * OWN)
    assert step_of_motion(force, 40) == pytest.approx(own / (0.4 * 6.0))
    assert fastest_frequency(force) == pytest.approx(6.0 * OWN)
    assert step_of_motion(body(fcos=40.0, omega=2.0 * OWN), 40) == pytest.approx(own)
    resonator = body(hm1=21.0, hw1=5.0 * OWN)
    assert step_of_motion(resonator, 40) == pytest.approx(own / (0.6 * 5.0 * math.sqrt(1.21)))


def test_a_body_without_a_spring_has_a_step():
    assert step_of_motion(body(k1=0.0, x0=0.0), 40) == pytest.approx(2.0 * math.pi / 40)
