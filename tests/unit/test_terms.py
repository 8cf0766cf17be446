"""Laws as forces: values by hand, symmetry, and the responses of hidden states."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from undertow.equation import registry
from undertow.equation.hidden import even_step, linear_response
from undertow.errors import UndertowError

X, V, A, T = (np.array([value]) for value in (0.2, -0.5, 3.0, 0.7))


@pytest.mark.parametrize(
    ("name", "inner", "force"),
    [
        ("stiffness", {}, 0.2),
        ("viscous_damping", {}, -0.5),
        ("coulomb_friction", {}, -1.0),
        ("added_mass", {}, 3.0),
        ("quadratic_drag", {}, -0.25),
        ("added_stiffness", {}, 0.2),
        ("linear_damping", {}, -0.5),
        ("cubic_damping", {}, -0.125),
        ("drag_exponent", {"exponent": 3.0}, -0.125),
        ("cubic_stiffness", {}, 0.008),
        ("quintic_stiffness", {}, 0.00032),
        ("asymmetric_stiffness", {}, 0.04),
        ("stiffness_drift", {"time_s": 0.7}, 0.2 * (1.0 - math.exp(-1.0))),
        ("quadratic_stiffness", {}, 0.04),
        ("sine_restoring", {}, math.sin(0.2)),
        ("position_damping", {}, -0.1),
        ("van_der_pol_damping", {}, -0.02),
        ("stribeck_friction", {"velocity_m_per_s": 0.5}, -math.exp(-1.0)),
        ("asymmetric_friction", {}, 1.0),
        ("variable_normal_force", {}, -0.2),
        ("external_forcing", {"frequency_rad_per_s": 2.0, "phase_rad": 0.1}, math.cos(1.5)),
    ],
)
def test_force_per_unit_coefficient_has_its_value_by_hand(name, inner, force):
    assert registry.find(name, **inner).force(X, V, A, T) == pytest.approx([force])


SYMMETRIC = (
    "stiffness", "viscous_damping", "coulomb_friction", "added_mass", "quadratic_drag", "linear_damping",
    "added_stiffness",
    "cubic_damping", "drag_exponent", "cubic_stiffness", "quintic_stiffness", "quadratic_stiffness", "sine_restoring",
    "stiffness_drift", "van_der_pol_damping", "stribeck_friction", "variable_normal_force", "hidden_resonator",
    "relaxation", "hysteresis", "delayed_echo",
)  # fmt: skip


def _swing(sign: float = 1.0):
    t = np.linspace(0.0, 4.0, 801)
    return sign * 0.02 * np.cos(9.0 * t), -sign * 0.18 * np.sin(9.0 * t), -sign * 1.62 * np.cos(9.0 * t), t


@pytest.mark.parametrize("name", SYMMETRIC)
def test_mirrored_motion_gives_the_mirrored_force(name):
    term = registry.find(name)
    assert term.force(*_swing(-1.0)) == pytest.approx(-term.force(*_swing()), abs=1e-12)


@pytest.mark.parametrize("name", ["asymmetric_stiffness", "position_damping", "asymmetric_friction"])
def test_one_sided_laws_do_not_mirror(name):
    term = registry.find(name)
    assert term.force(*_swing(-1.0)) == pytest.approx(term.force(*_swing()), abs=1e-12)


@pytest.mark.parametrize("name", registry.names())
def test_force_does_not_edit_the_motion(name):
    motion = _swing()
    for array in motion:
        array.setflags(write=False)
    assert registry.find(name).force(*motion).shape == motion[0].shape


def test_resonator_under_a_step_of_acceleration_answers_in_closed_form():
    # s'' + w^2 s = -1 from rest: x'' + s'' = 1 - cos(w t)
    t = np.linspace(0.0, 3.0, 601)
    term = registry.find("hidden_resonator", natural_frequency_rad_per_s=5.0, damping_ratio=0.0)
    response = term.force(0 * t, 0 * t, np.ones_like(t), t)
    assert response == pytest.approx(1.0 - np.cos(5.0 * t), abs=1e-9)


def test_amplitude_dependent_resonator_tends_to_the_linear_one():
    x, v, a, t = _swing()
    linear = registry.find("hidden_resonator", natural_frequency_rad_per_s=5.0, damping_ratio=0.05)
    nearly = registry.find(
        "hidden_resonator", natural_frequency_rad_per_s=5.0, damping_ratio=0.05, quadratic_damping_per_m=1e-9
    )
    # RK4 with 5 ms steps against the exact first-order hold: (w h)^4
    assert nearly.force(x, v, a, t) == pytest.approx(linear.force(x, v, a, t), abs=1e-5)


@pytest.mark.parametrize(("drag", "cubic"), [(0.0, 2e4), (0.0, -3e3), (30.0, 0.0)], ids=["hardens", "softens", "drag"])
def test_an_amplitude_dependent_resonator_answers_as_its_law_says(drag, cubic):
    x, v, a, t = _swing()
    inner = {"quadratic_damping_per_m": drag, "cubic_stiffness_per_m2_s2": cubic}
    term = registry.find("hidden_resonator", natural_frequency_rad_per_s=12.0, damping_ratio=0.05, **inner)

    def pull(s, u):
        return 1.2 * u + 144.0 * s + drag * u * np.abs(u) + cubic * s**3

    def slopes(time, y):
        return [y[1], 1.62 * math.cos(9.0 * time) - pull(*y)]

    s, u = solve_ivp(slopes, (0.0, t[-1]), [0.0, 0.0], "DOP853", t, rtol=1e-10, atol=1e-12).y
    plain = registry.find("hidden_resonator", natural_frequency_rad_per_s=12.0, damping_ratio=0.05)
    size = np.max(np.abs(pull(s, u)))
    assert term.force(x, v, a, t) == pytest.approx(-pull(s, u), abs=1e-3 * size)  # drive interpolated over 5 ms
    assert np.max(np.abs(plain.force(x, v, a, t) + pull(s, u))) > 0.05 * size


def test_relaxation_under_constant_velocity_answers_in_closed_form():
    t = np.linspace(0.0, 3.0, 301)
    response = registry.find("relaxation", time_s=0.4).force(t, np.ones_like(t), 0 * t, t)
    assert response == pytest.approx(0.4 * (1.0 - np.exp(-t / 0.4)), abs=1e-9)


def test_hysteresis_in_one_direction_answers_in_closed_form():
    x = np.linspace(0.0, 0.03, 40)
    response = registry.find("hysteresis", yield_displacement_m=0.005).force(x, 0 * x, 0 * x, x)
    assert response == pytest.approx(0.005 * (1.0 - np.exp(-x / 0.005)), abs=1e-12)


def test_hysteresis_holds_its_force_while_the_body_rests():
    x = np.array([0.0, 0.01, 0.01, 0.01])
    response = registry.find("hysteresis").force(x, 0 * x, 0 * x, np.arange(4.0))
    assert response[1] == response[2] == response[3]


def test_echo_is_the_velocity_of_a_delay_ago_and_nothing_before():
    x, v, a, t = _swing()
    echo = registry.find("delayed_echo", delay_s=1.0).force(x, v, a, t)
    assert np.all(echo[t < 1.0] == 0.0)
    assert echo[t >= 1.0] == pytest.approx(v[t <= t[-1] - 1.0], abs=1e-12)


def test_a_hidden_state_refuses_uneven_time():
    t = np.array([0.0, 0.1, 0.2, 0.35])
    with pytest.raises(UndertowError, match=r"relaxation: time steps differ by 0\.05 s from their median 0\.1 s"):
        registry.find("relaxation").force(t, t, t, t)


def test_even_steps_are_measured():
    assert even_step(np.arange(5) * 0.004, "x") == pytest.approx(0.004)


def test_linear_response_starts_at_rest():
    assert linear_response([1.0], [1.0, 2.0], np.zeros(5), 0.1) == pytest.approx(np.zeros(5))
