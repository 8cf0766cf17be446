"""The simulation against closed forms: every number here comes from a formula, none from an integrator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import ellipk

import undertow
from tests.reference import reference
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.simulate import simulate
from undertow.equation.term import Term
from undertow.errors import UndertowError

M, K = 2987.0, 404000.0
W = math.sqrt(K / M)
PERIOD = 2.0 * math.pi / W


def made_of(mass: float = M, **coefficients: float) -> Equation:
    """An equation from term names and coefficients."""
    return Equation(tuple(registry.find(n) for n in coefficients), tuple(coefficients.values()), mass_kg=mass)


def turning_points(equation: Equation, x0: float, count: int, steps: int = 200) -> np.ndarray:
    """The first ``count`` extrema of x after the release, from samples 0.2 ms apart.

    A sample lies at most 0.1 ms from the extremum: x is off by (w 0.1 ms)^2 / 2, below 1e-6 of it here.
    """
    t = np.arange(0.0, (0.5 * count + 1.2) * PERIOD * 1.3, 2e-4)
    x = simulate(equation, x0, t, steps_per_period=steps).x
    inside = (np.diff(x)[:-1] * np.diff(x)[1:] < 0.0).nonzero()[0] + 1
    return x[inside][:count]


def test_coulomb_friction_takes_four_f_over_k_from_every_cycle():
    # Lorenz's step, e.g. Den Hartog, Mechanical Vibrations (1934) sec. 8.2
    force = 600.0
    peaks = turning_points(made_of(stiffness=K, coulomb_friction=force), 0.03, 8)
    # samples beside the extremum: 1e-6 of x0
    assert np.diff(np.abs([0.03, *peaks])) == pytest.approx(-2.0 * force / K, rel=1e-3, abs=1e-7)


@pytest.mark.parametrize("x0", [0.03, 0.0171, -0.0234])
def test_body_comes_to_rest_within_f_over_k_at_the_predicted_place(x0):
    force = 600.0
    reach = force / K
    amplitude, side = abs(x0), math.copysign(1.0, x0)
    while amplitude > reach:  # half a cycle moves from A to -(A - 2 F/k)
        amplitude, side = amplitude - 2.0 * reach, -side
    rest = simulate(made_of(stiffness=K, coulomb_friction=force), x0, np.array([0.0, 30.0])).x[1]
    assert abs(rest) <= reach
    assert rest == pytest.approx(side * amplitude, abs=1e-9)


def test_viscous_decay_is_the_exact_damped_cosine():
    zeta, t = 0.03, np.linspace(0.0, 10.0, 501)
    wd = W * math.sqrt(1.0 - zeta**2)
    exact = 0.02 * np.exp(-zeta * W * t) * (np.cos(wd * t) + zeta * W / wd * np.sin(wd * t))
    motion = simulate(made_of(stiffness=K, viscous_damping=2.0 * zeta * M * W), 0.02, t, steps_per_period=200)
    assert np.max(np.abs(motion.x - exact)) < 1e-9 * 0.02  # fifth order at 200 steps a period


def test_viscous_peaks_have_the_logarithmic_decrement():
    zeta = 0.02
    peaks = turning_points(made_of(stiffness=K, viscous_damping=2.0 * zeta * M * W), 0.02, 8)
    decrement = np.log(peaks[:-2] / peaks[2:])
    # samples beside the extremum: 2e-6
    assert decrement == pytest.approx(2.0 * math.pi * zeta / math.sqrt(1.0 - zeta**2), abs=5e-6)


def test_quadratic_drag_peaks_follow_the_energy_recursion():
    # v^2 is linear in exp(b x) between turning points: (1 - b X1) e^(b X1) = (1 + b X0) e^(-b X0), b = 2 q / M
    q, peak = 20000.0, 0.1
    b = 2.0 * q / M
    expected = []
    for _ in range(6):
        level = (1.0 + b * peak) * math.exp(-b * peak)
        peak = brentq(lambda p, level=level: (1.0 - b * p) * math.exp(b * p) - level, 0.0, 1.0 / b, xtol=1e-15)
        expected.append(peak)
    peaks = turning_points(made_of(stiffness=K, quadratic_drag=q), 0.1, 6)
    assert np.abs(peaks) == pytest.approx(expected, rel=2e-6)


@pytest.mark.parametrize("degrees", [5.0, 90.0, 160.0])
def test_pendulum_period_is_the_elliptic_integral(degrees):
    # T = 4 K(sin^2(theta0 / 2)) / w0, e.g. Landau and Lifshitz, Mechanics, sec. 11
    angle = math.radians(degrees)
    period = 4.0 * ellipk(math.sin(angle / 2.0) ** 2) / W
    motion = simulate(made_of(sine_restoring=K), angle, np.array([0.0, period]), steps_per_period=200)
    assert motion.x[1] == pytest.approx(angle, abs=1e-9)
    assert motion.v[1] == pytest.approx(0.0, abs=1e-8 * W)


@pytest.mark.parametrize("hardening", [3.0, 0.3, -0.5])
def test_duffing_period_is_the_elliptic_integral(hardening):
    # T = 4 K(m) / sqrt(w^2 (1 + h)), m = h / (2 (1 + h)), h = k3 A^2 / k (Kovacic and Brennan 2011, ch. 2)
    amplitude = 0.03
    period = 4.0 * ellipk(hardening / (2.0 * (1.0 + hardening))) / (W * math.sqrt(1.0 + hardening))
    equation = made_of(stiffness=K, cubic_stiffness=hardening * K / amplitude**2)
    motion = simulate(equation, amplitude, np.array([0.0, period]), steps_per_period=200)
    assert motion.x[1] == pytest.approx(amplitude, rel=1e-9)
    assert motion.v[1] == pytest.approx(0.0, abs=1e-8 * W * amplitude)


def _with_resonator(mass: float, w: float, zeta: float, **coefficients: float) -> Equation:
    names = tuple(coefficients)
    resonator = registry.find("hidden_resonator", natural_frequency_rad_per_s=w, damping_ratio=zeta)
    return Equation((*(registry.find(n) for n in names), resonator), (*coefficients.values(), mass), mass_kg=M)


def test_body_and_resonator_move_as_the_matrix_exponential_of_two_modes():
    # (M + m) x'' + m s'' + k x = 0, x'' + s'' + 2 z w s' + w^2 s = 0
    m, w, z = 300.0, 9.6, 0.02
    inertia = np.array([[M + m, m], [1.0, 1.0]])
    stiffness, damping = np.diag([K, w**2]), np.diag([0.0, 2.0 * z * w])
    lower = -np.linalg.solve(inertia, np.hstack([stiffness, damping]))
    system = np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), lower])
    t = np.linspace(0.0, 15.0, 301)
    exact = np.array([expm(system * s) @ [0.02, 0.0, 0.0, 0.0] for s in t])
    motion = simulate(_with_resonator(m, w, z, stiffness=K), 0.02, t, steps_per_period=200)
    assert np.max(np.abs(motion.x - exact[:, 0])) < 1e-9 * 0.02
    assert np.max(np.abs(motion.hidden[:, 0] - exact[:, 1])) < 1e-8 * np.max(np.abs(exact[:, 1]))


def test_undamped_body_and_resonator_beat_at_the_two_coupled_frequencies():
    # M W^4 - (k + (M + m) w^2) W^2 + k w^2 = 0; in mode W the resonator moves s = x W^2 / (w^2 - W^2)
    m, w, x0 = 300.0, 9.6, 0.02
    squares = np.roots([M, -(K + (M + m) * w**2), K * w**2])
    ratios = squares / (w**2 - squares)
    shares = x0 * np.array([ratios[1], -ratios[0]]) / (ratios[1] - ratios[0])  # s(0) = 0
    t = np.linspace(0.0, 15.0, 301)
    exact = np.cos(np.outer(t, np.sqrt(squares))) @ shares
    motion = simulate(_with_resonator(m, w, 0.0, stiffness=K), x0, t, steps_per_period=200)
    assert np.max(np.abs(motion.x - exact)) < 1e-8 * x0
    assert math.prod(np.sqrt(squares)) == pytest.approx(W * w)


@pytest.mark.parametrize(
    ("name", "coefficient"),
    [("viscous_damping", 900.0), ("coulomb_friction", 200.0), ("quadratic_drag", 4000.0), ("cubic_damping", 2e4),
     ("stribeck_friction", 100.0), ("variable_normal_force", 5000.0), ("van_der_pol_damping", 2e6),
     ("drag_exponent", 1e3)],
)  # fmt: skip
def test_energy_never_rises_under_a_passive_law(name, coefficient):
    motion = simulate(made_of(stiffness=K, **{name: coefficient}), 0.02, np.linspace(0.0, 12.0, 3001))
    energy = 0.5 * M * motion.v**2 + 0.5 * K * motion.x**2
    assert np.max(np.diff(energy)) < 1e-8 * energy[0]  # error of the interpolated v at 60 steps a period


def test_total_energy_never_rises_with_a_resonator():
    m, w = 300.0, 9.6
    motion = simulate(_with_resonator(m, w, 0.02, stiffness=K, coulomb_friction=100.0), 0.02, np.linspace(0, 12, 3001))
    s, u = motion.hidden.T
    energy = 0.5 * M * motion.v**2 + 0.5 * K * motion.x**2 + 0.5 * m * (motion.v + u) ** 2 + 0.5 * m * w**2 * s**2
    assert np.max(np.diff(energy)) < 1e-7 * energy[0]


@pytest.mark.parametrize("x0", [0.00149, -0.00149, 0.0])
def test_body_released_within_the_reach_of_friction_does_not_move(x0):
    motion = simulate(made_of(stiffness=K, coulomb_friction=0.0015 * K), x0, np.linspace(0.0, 5.0, 51))
    assert np.all(motion.x == x0)
    assert np.all(motion.v == 0.0)


def test_sloshing_sets_a_stuck_body_in_motion_again():
    equation = _with_resonator(900.0, 8.0, 0.002, stiffness=K, viscous_damping=8000.0, coulomb_friction=300.0)
    t = np.arange(0.0, 12.0, 0.005)
    motion = simulate(equation, 0.02, t, steps_per_period=200)
    still = np.diff(motion.x) == 0.0
    assert np.sum(still[:-1] & ~still[1:]) > 3  # it stopped and started again, several times
    exact = reference(equation, 0.02, t)[0]
    assert np.max(np.abs(motion.x - exact)) < 1e-7 * 0.02


def _steady(force: float, drive: float, **coefficients: float) -> complex:
    """Complex amplitude of the steady motion under force cos(drive t), with a Maxwell element (tau = 0.3 s)."""
    names = tuple(coefficients)
    terms: list[Term] = [registry.find(n) for n in names]
    terms += [registry.find("relaxation", time_s=0.3), registry.find("external_forcing", frequency_rad_per_s=drive)]
    equation = Equation(tuple(terms), (*coefficients.values(), 60000.0, force), mass_kg=M)
    cycle = 2.0 * math.pi / drive
    t = 40.0 * cycle + np.arange(400) * cycle / 400
    x = simulate(equation, 0.0, t, steps_per_period=200).x
    return complex(2.0 * np.mean(x * np.exp(-1j * drive * t)))


@pytest.mark.parametrize("drive", [2.0, 7.0, 20.0])
def test_maxwell_element_has_its_stiffness_and_damping_at_each_frequency(drive):
    # k' = k_r (w tau)^2 / (1 + (w tau)^2), c' = k_r tau / (1 + (w tau)^2), e.g. Ferry 1980, ch. 3
    k_r, tau, c, force = 60000.0, 0.3, 8000.0, 500.0
    share = 1.0 / (1.0 + (drive * tau) ** 2)
    k_total, c_total = K + k_r * (drive * tau) ** 2 * share, c + k_r * tau * share
    exact = -force / (k_total - M * drive**2 + 1j * drive * c_total)
    assert _steady(force, drive, stiffness=K, viscous_damping=c) == pytest.approx(exact, rel=1e-6)


def test_hysteresis_loop_encloses_its_closed_form_area():
    # branches r = F_y - (F_y + r_m) exp(-(x + X)/x_y), r_m = F_y tanh(X/x_y): area 4 F_y (X - x_y tanh(X/x_y))
    amplitude, yields = 0.02, 0.004
    t = np.linspace(0.0, 6.0, 60001)  # six cycles of 1 s: the first loops settle as exp(-2 X / x_y) a half cycle
    x = amplitude * np.sin(2.0 * np.pi * t)
    r = registry.find("hysteresis", yield_displacement_m=yields).force(x, 0 * x, 0 * x, t)
    last = t >= 5.0
    area = np.trapezoid(r[last], x[last])
    # trapezia between 10,000 samples a cycle: 1e-6
    assert area == pytest.approx(4.0 * yields * (amplitude - yields * math.tanh(amplitude / yields)), rel=1e-5)


def test_first_half_swing_loses_the_work_of_the_yielding_element():
    # from r = 0 at the release to the next turning point, D away: F_y (D - x_y (1 - exp(-D/x_y)))
    k_h, yields, x0 = 40000.0, 0.004, 0.02
    term = registry.find("hysteresis", yield_displacement_m=yields)
    equation = Equation((registry.find("stiffness"), term), (K, k_h), mass_kg=M)

    def imbalance(x1: float) -> float:
        way = x0 + x1
        return 0.5 * K * (x0**2 - x1**2) - k_h * yields * (way - yields * (1.0 - math.exp(-way / yields)))

    expected = brentq(imbalance, 0.5 * x0, x0, xtol=1e-15)
    assert turning_points(equation, x0, 1)[0] == pytest.approx(-expected, rel=2e-6)


def test_echo_of_zero_delay_would_be_damping_and_acts_only_after_the_delay():
    delay = 1.3
    echo = Equation((registry.find("stiffness"), registry.find("delayed_echo", delay_s=delay)), (K, 900.0), mass_kg=M)
    t = np.linspace(0.0, 3.0, 601)
    gap = simulate(echo, 0.02, t).x - simulate(made_of(stiffness=K), 0.02, t).x
    # before: nothing, up to the error of the two step patterns at 60 steps a period (1e-8 of x0)
    assert np.max(np.abs(gap[t < delay])) < 1e-8 * 0.02
    assert np.max(np.abs(gap[t > delay + 0.5])) > 1e-2 * 0.02


def test_motion_from_a_moved_rest_position_is_the_same_motion_moved():
    # a law with a kink at rest, so that the kink must move too
    coefficients = {"stiffness": K, "coulomb_friction": 200.0, "variable_normal_force": 8000.0}
    here = made_of(**coefficients)
    moved = Equation(here.terms, here.coefficients, mass_kg=M, rest_m=0.004)
    t = np.linspace(0.0, 8.0, 401)
    gap = simulate(moved, 0.024, t).x - 0.004 - simulate(here, 0.02, t).x
    assert np.max(np.abs(gap)) < 1e-10


class _Drag(Term):
    """A user's own law without a place in the compiled integrator."""

    name = "my_drag"
    parameters = registry.find("quadratic_drag").parameters
    law, latex, source, left_out = "q v |v|", r"q\dot{x}|\dot{x}|", "test", "test"

    def force(self, x, v, a, t):
        return v * np.abs(v)


def test_a_users_own_law_takes_the_general_path_to_the_same_motion():
    t = np.linspace(0.0, 8.0, 401)
    shared = (registry.find("stiffness"), registry.find("coulomb_friction"))
    own = simulate(Equation((*shared, _Drag()), (K, 160.0, 3900.0), mass_kg=M), 0.02, t)
    compiled = simulate(made_of(stiffness=K, coulomb_friction=160.0, quadratic_drag=3900.0), 0.02, t)
    # the general path stops a reversal at 1e-9 of x0 (m/s) and runs at rtol 1e-10
    assert np.max(np.abs(own.x - compiled.x)) < 1e-6 * 0.02


def test_a_users_own_law_may_decide_by_a_value():
    class _Gate(_Drag):
        name = "my_gate"

        def force(self, x, v, a, t):
            return v * np.abs(v) if x > -1.0 else 0.0 * v

    t = np.linspace(0.0, 4.0, 201)
    deciding, formula = (
        simulate(Equation((registry.find("stiffness"), law), (K, 3900.0), mass_kg=M), 0.02, t)
        for law in (_Gate(), _Drag())
    )
    assert np.max(np.abs(deciding.x - formula.x)) < 1e-8 * 0.02  # one method, 240 steps at rtol 1e-10


def test_a_users_own_law_that_feeds_the_motion_leaves_every_bound():
    equation = Equation((registry.find("stiffness"), _Drag()), (K, -3900.0), mass_kg=M)
    with pytest.raises(UndertowError, match=r"the motion leaves every bound at .* s; a coefficient is wrong"):
        simulate(equation, 3.0, np.linspace(0.0, 30.0, 301))


def test_a_force_of_its_own_sets_a_body_under_a_users_law_out_from_rest():
    laws = (registry.find("stiffness"), registry.find("external_forcing", frequency_rad_per_s=3.0), _Drag())
    motion = simulate(Equation(laws, (K, 3e4, 3900.0), mass_kg=M), 0.0, np.linspace(0.0, 4.0, 101))
    assert np.max(np.abs(motion.x)) > 0.1


def test_memory_beside_a_users_own_law_is_refused_by_name():
    equation = Equation((registry.find("stiffness"), registry.find("relaxation"), _Drag()), (K, 1e4, 3900.0), mass_kg=M)
    with pytest.raises(UndertowError, match="relaxation beside a law without compiled slots"):
        simulate(equation, 0.02, np.linspace(0.0, 1.0, 11))


def test_times_that_fall_back_are_refused():
    with pytest.raises(UndertowError, match=r"3 times, from 0 to 0.1 s; they must be increasing and not negative"):
        simulate(made_of(stiffness=K), 0.02, np.array([0.0, 0.2, 0.1]))


@pytest.mark.parametrize("last", [math.nan, math.inf])
def test_times_that_are_not_finite_are_refused(last):
    with pytest.raises(UndertowError, match=r"3 times, .*; they must be increasing and not negative, and finite"):
        simulate(made_of(stiffness=K), 0.02, np.array([0.0, 0.2, last]))


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ((math.nan, 0.0), "x0 is nan m or rad, and must be finite; give a number"),
        ((math.inf, 0.0), "x0 is inf m or rad, and must be finite"),
        ((0.02, math.nan), "v0 is nan m/s or rad/s, and must be finite"),
    ],
)
def test_a_start_that_is_not_finite_is_refused_by_its_name(start, message):
    x0, v0 = start
    for equation in (made_of(stiffness=K), Equation((registry.find("stiffness"), _Drag()), (K, 3900.0), mass_kg=M)):
        with pytest.raises(UndertowError, match=message):
            simulate(equation, x0, np.linspace(0.0, 1.0, 11), v0)
    with pytest.raises(UndertowError, match=message):
        undertow.simulate({"stiffness": K}, x0=x0, v0=v0, mass_kg=M)


def test_a_motion_that_grows_without_bound_is_refused_with_its_equation():
    with pytest.raises(UndertowError, match=r"left every bound after \d+ steps; a coefficient has the\s+wrong sign"):
        simulate(made_of(stiffness=-K), 0.02, np.array([0.0, 30.0]))


def test_forcing_from_rest_is_not_taken_for_a_runaway():
    equation = made_of(stiffness=K, viscous_damping=800.0, external_forcing=3e5)
    motion = simulate(equation, 0.0, np.linspace(0.0, 10.0, 101))
    assert np.max(np.abs(motion.x)) > 0.3
