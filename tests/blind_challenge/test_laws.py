"""The challenge's simulators against closed forms and against linear systems solved another way."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.motion import Body, Law, resonator, simulate

STEP = 2.0 * math.pi / 100.0
PLAIN = Body(1.0, 0.0, 1.0, 0.0, 0.0)


def linear_motion(matrix: np.ndarray, start: np.ndarray, samples: int) -> np.ndarray:
    """States of a linear system at the samples, by the matrix exponential."""
    once = expm(matrix * STEP)
    out = [start]
    for _ in range(samples - 1):
        out.append(once @ out[-1])
    return np.array(out)


def test_a_damped_body_follows_the_closed_form() -> None:
    c, n = 0.06, 800
    motion = simulate(PLAIN.changed(damping=c), (), 1.0, n, STEP)
    w = math.sqrt(1.0 - (c / 2.0) ** 2)
    t = motion.time
    exact = np.exp(-c / 2.0 * t) * (np.cos(w * t) + c / 2.0 / w * np.sin(w * t))
    assert np.max(np.abs(motion.x - exact)) < 1e-8  # tolerance 1e-9 a step over 8 periods


def test_coulomb_peaks_fall_by_four_forces_over_stiffness_and_the_body_sticks_where_it_must() -> None:
    force = 0.03
    motion = simulate(PLAIN.changed(coulomb=force), (), 1.0, 1500, STEP)
    for cycle in range(1, 8):
        assert motion.x[100 * cycle] == pytest.approx(1.0 - 4.0 * force * cycle, abs=1e-8)
    # half swings end at 1 - 2 f n with turning sign; the first one within f of 0 is the last
    halves = np.arange(40)
    ends = (1.0 - 2.0 * force * halves) * (-1.0) ** halves
    rest = ends[np.argmax(np.abs(ends) <= force + 1e-12)]
    assert motion.x[-1] == pytest.approx(rest, abs=1e-8)
    assert motion.v[-1] == 0.0


def test_the_first_step_may_be_shorter_than_the_others() -> None:
    body = PLAIN.changed(coulomb=0.01, drag=0.1)
    fine = simulate(body, (), 1.0, 801, STEP / 4.0)
    late = simulate(body, (), 1.0, 200, STEP, first=STEP / 4.0)
    assert late.time[1] == STEP / 4.0
    assert np.allclose(late.x[1:], fine.x[1::4][: late.x.size - 1], atol=1e-9)


def test_a_cubic_spring_keeps_its_energy() -> None:
    motion = simulate(PLAIN, (Law(codes.STIFF, (0.0, 0.0, 0.4, 0.1)),), 1.0, 1500, STEP)
    energy = 0.5 * motion.v**2 + 0.5 * motion.x**2 + 0.1 * motion.x**4 + 0.1 / 6.0 * motion.x**6
    assert np.ptp(energy) < 1e-7  # tolerance 1e-9 a step over 15 periods


def test_quadratic_drag_takes_the_closed_form_of_the_first_swing() -> None:
    q = 0.2
    motion = simulate(PLAIN.changed(drag=q), (), 1.0, 51, STEP / 10.0)
    # v^2 on a swing to the left: y' = -2 x + 2 q y with y = v^2 over x, from y(1) = 0
    x = motion.x
    y = (2.0 * q * x + 1.0) / (2.0 * q**2) - (2.0 * q + 1.0) / (2.0 * q**2) * np.exp(2.0 * q * (x - 1.0))
    assert np.allclose(motion.v**2, y, atol=1e-9)


def test_a_hidden_resonator_is_the_linear_system_of_four_states() -> None:
    m, w, z = 0.15, 1.3, 0.03
    # unknowns x, v, s, s': v' = -x + m (2 z w s' + w^2 s), s'' = -2 z w s' - w^2 s - v'
    pull = np.array([0.0, 0.0, w**2, 2.0 * z * w])
    rise = np.array([-1.0, 0.0, 0.0, 0.0]) + m * pull
    matrix = np.array([[0.0, 1.0, 0.0, 0.0], rise, [0.0, 0.0, 0.0, 1.0], -pull - rise])
    exact = linear_motion(matrix, np.array([1.0, 0.0, 0.0, 0.0]), 600)
    motion = simulate(PLAIN, (resonator(m, w, z),), 1.0, 600, STEP)
    assert np.allclose(motion.x, exact[:, 0], atol=1e-8)
    assert np.allclose(motion.hidden[:, 0], exact[:, 2], atol=1e-8)


def test_a_relaxing_force_is_the_linear_system_of_three_states() -> None:
    k, tau = 0.1, 0.7
    matrix = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, -1.0], [0.0, k, -1.0 / tau]])
    exact = linear_motion(matrix, np.array([1.0, 0.0, 0.0]), 400)
    motion = simulate(PLAIN, (Law(codes.RELAX, (k, tau), (0.0,), (k,)),), 1.0, 400, STEP)
    assert np.allclose(motion.x, exact[:, 0], atol=1e-8)


def test_a_compliant_support_is_the_linear_system_of_four_states() -> None:
    k, m, c, own = 1.0, 0.05, 0.1, 12.0
    matrix = np.array(
        [[0.0, 1.0, 0.0, 0.0], [-k, 0.0, k, 0.0], [0.0, 0.0, 0.0, 1.0], [k / m, 0.0, -(k + own) / m, -c / m]]
    )
    exact = linear_motion(matrix, np.array([1.0, 0.0, 0.0, 0.0]), 300)
    motion = simulate(PLAIN, (Law(codes.SUPPORT, (k, m, c, own), (0.0, 0.0), (0.1, 0.1)),), 1.0, 300, STEP)
    assert np.allclose(motion.x, exact[:, 0], atol=1e-7)


def test_a_convolution_is_the_state_space_that_has_the_same_kernel() -> None:
    gain, decay, w = 0.15, 0.35, 1.4
    law = Law(codes.KERNEL, (0.0, gain, 0.0), kernel=lambda s: np.exp(-decay * s) * np.cos(w * s), kernel_length=60.0)
    motion = simulate(PLAIN.changed(damping=0.02), (law,), 1.0, 500, STEP)
    matrix = np.array([[0, 1, 0, 0], [-1, -0.02, -gain, 0], [0, 1, -decay, -w], [0, 0, w, -decay]])
    exact = linear_motion(matrix, np.array([1.0, 0.0, 0.0, 0.0]), 500)
    assert np.allclose(motion.x, exact[:, 0], atol=2e-6)  # quadrature at 320 nodes a period
    assert np.ptp(exact[:, 0] - linear_motion(matrix[:2, :2], np.array([1.0, 0.0]), 500)[:, 0]) > 0.1


def test_two_kernels_act_together_and_each_keeps_its_own_row() -> None:
    def kernel(decay: float) -> Law:
        return Law(codes.KERNEL, (0.0, 0.1, 0.0), kernel=lambda s: np.exp(-decay * s), kernel_length=40.0)

    motion = simulate(PLAIN, (kernel(0.5), kernel(2.0)), 1.0, 200, STEP)
    matrix = np.array([[0, 1, 0, 0], [-1, 0, -0.1, -0.1], [0, 1, -0.5, 0], [0, 1, 0, -2.0]])
    exact = linear_motion(matrix, np.array([1.0, 0.0, 0.0, 0.0]), 200)
    assert np.allclose(motion.x, exact[:, 0], atol=2e-6)


def test_an_echo_is_nothing_before_its_delay_and_the_delayed_velocity_after_it() -> None:
    gain, delay = 0.2, 3.0 * STEP * 25
    motion = simulate(PLAIN, (Law(codes.ECHO, (0.0, gain, delay)),), 1.0, 150, STEP)
    free = np.cos(motion.time)
    before = motion.time <= delay
    assert np.allclose(motion.x[before], free[before], atol=1e-8)

    def rate(t: float, y: np.ndarray) -> list[float]:  # until twice the delay the echo is of the free swing
        return [y[1], -y[0] - gain * (-math.sin(t - delay) if t > delay else 0.0)]

    until = motion.time[motion.time < 2.0 * delay]
    exact = solve_ivp(rate, (0.0, until[-1]), [1.0, 0.0], t_eval=until, rtol=1e-10, atol=1e-12, max_step=0.05)
    assert np.allclose(motion.x[: until.size], exact.y[0], atol=1e-7)


def test_dahl_bristles_follow_the_exponential_of_the_first_swing_and_bouc_wen_contains_them() -> None:
    k, slip = 0.2, 0.3
    dahl = simulate(PLAIN, (Law(codes.DAHL, (k, slip), (0.0,), (k * slip,)),), 1.0, 300, STEP)
    first = dahl.v <= 0.0
    first[np.argmin(first) :] = False
    exact = -k * slip * (1.0 - np.exp((dahl.x - 1.0) / slip))
    assert np.allclose(dahl.hidden[first, 0], exact[first], atol=1e-8)
    numbers = (k, slip, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.5, 0.3, 0.05, 0.2)
    bouc = simulate(PLAIN, (Law(codes.BOUCWEN, numbers, (0.0, 0.0), (1.0, 1.0)),), 1.0, 300, STEP)
    assert np.allclose(bouc.x, dahl.x, atol=1e-7)


def test_pinching_and_degradation_change_bouc_wen() -> None:
    plain = (0.2, 0.3, 1.0, 0.5, 0.5, 0.0, 0.0, 0.0, 0.1, 0.5, 0.3, 0.05, 0.2)
    pinched = (0.2, 0.3, 1.0, 0.5, 0.5, 0.02, 0.02, 0.8, 0.1, 0.5, 0.3, 0.05, 0.2)
    a, b = (
        simulate(PLAIN, (Law(codes.BOUCWEN, p, (0.0, 0.0), (1.0, 1.0)),), 1.0, 400, STEP).x for p in (plain, pinched)
    )
    assert np.max(np.abs(a - b)) > 0.01


def test_one_element_of_an_iwan_joint_is_elastic_then_slips() -> None:
    k, limit = 0.3, 0.12
    motion = simulate(PLAIN, (Law(codes.IWAN, (1.0, k, limit), (0.0,), (limit,)),), 1.0, 50, STEP)
    exact = np.maximum(k * (motion.x - 1.0), -limit)
    assert np.allclose(motion.hidden[:, 0], exact, atol=5e-5)  # an element begins to slip within a step


def test_stiff_lugre_bristles_are_coulomb_friction() -> None:
    force = 0.02
    law = Law(codes.LUGRE, (force / 1e-4, 0.5, force, force, 0.05), (0.0,), (1e-4,))
    soft = simulate(PLAIN, (law,), 1.0, 400, STEP)
    hard = simulate(PLAIN.changed(coulomb=force), (), 1.0, 400, STEP)
    assert np.max(np.abs(soft.x - hard.x)) < 5e-3  # friction alone moves it by 0.3


def test_rate_and_state_friction_slides_at_its_steady_level() -> None:
    level, a, b, speed, slip = 0.02, 0.002, 0.003, 0.05, 0.02
    law = Law(codes.RATE_STATE, (level, a, b, speed, slip), (slip / speed,), (slip / speed,))
    motion = simulate(PLAIN, (law,), 1.0, 26, STEP)
    loss = 0.5 - 0.5 * motion.v[-1] ** 2 - 0.5 * motion.x[-1] ** 2
    assert loss == pytest.approx(level * (1.0 - motion.x[-1]), rel=0.35)  # weakens by (b - a) ln(v / V0) on the way


def test_a_part_that_bounces_without_loss_keeps_the_energy() -> None:
    mass, gap, k = 0.1, 0.2, 60.0
    law = Law(codes.CONTACT, (mass, 0.0, 0.0, gap, gap, k, 0.0), (0.0, 0.0), (gap, gap))
    motion = simulate(PLAIN, (law,), 1.0, 800, STEP)
    s, rate = motion.hidden.T
    depth = np.maximum(np.abs(s) - gap, 0.0)
    energy = 0.5 * motion.v**2 + 0.5 * motion.x**2 + 0.5 * mass * (motion.v + rate) ** 2 + k * depth**2.5 / 2.5
    assert np.max(depth) > 0.0
    assert np.ptp(energy) < 5e-6  # some forty hits


def test_a_stop_is_not_felt_before_its_gap() -> None:
    free = simulate(PLAIN, (), -1.0, 100, STEP)
    met = simulate(PLAIN, (Law(codes.STOP, (0.5, 5.0, 0.0)),), -1.0, 100, STEP)
    before = np.cumsum(free.x > 0.5) == 0
    assert np.allclose(met.x[before], free.x[before], atol=1e-8)
    assert np.max(met.x) < 0.95


def test_static_friction_holds_a_body_that_coulomb_friction_would_let_go() -> None:
    body = PLAIN.changed(coulomb=0.1)
    held = simulate(body, (Law(codes.STRIBECK, (0.05, 0.1)),), 0.13, 50, STEP)
    slips = simulate(body, (), 0.13, 50, STEP)
    assert np.all(held.x == 0.13)
    assert slips.x[-1] < 0.12


def test_a_growing_force_lets_a_stuck_body_go_at_the_moment_it_exceeds_friction() -> None:
    body = Body(1.0, 0.0, 1.0, 0.3, 0.0)
    law = Law(codes.TONES, (1.0, 0.5, 0.1, -0.5 * math.pi))  # 0.5 sin(0.1 t)
    motion = simulate(body, (law,), 0.0, 200, STEP)
    start = math.asin(0.6) / 0.1
    assert np.all(motion.v[motion.time < start] == 0.0)
    assert np.all(motion.v[(motion.time > start + 1e-6) & (motion.time < start + 1.0)] > 0.0)


def test_friction_uneven_by_direction_makes_the_rest_position_and_no_other_difference() -> None:
    body = PLAIN.changed(coulomb=0.02)
    skewed = simulate(body, (Law(codes.ONEWAY, (0.01,)),), 1.0 - 0.01, 300, STEP)
    shifted = simulate(body, (), 1.0, 300, STEP)
    assert np.allclose(skewed.x + 0.01, shifted.x, atol=1e-8)


def test_the_drag_of_keulegan_follows_the_last_half_swing() -> None:
    q = 0.1
    constant = simulate(PLAIN.changed(drag=q), (Law(codes.KEULEGAN, (q, 0.0, -1.0, 0.5)),), 1.0, 300, STEP)
    plain = simulate(PLAIN.changed(drag=q), (), 1.0, 300, STEP)
    assert np.allclose(constant.x, plain.x, atol=1e-10)
    more = simulate(PLAIN.changed(drag=q), (Law(codes.KEULEGAN, (q, 1.0, -1.0, 1.0)),), 1.0, 300, STEP)
    first = more.time < 3.0
    assert np.allclose(more.x[first], plain.x[first], atol=1e-8)  # the first half swing has the reference's size
    assert abs(more.x[200]) < abs(plain.x[200])


def test_a_body_that_its_spring_no_longer_holds_ends_as_no_number_within_few_steps() -> None:
    """x'' + v |v| / 2 + x - 2 x^3 = 0 from x = 1: drag holds it back so that ever smaller steps would not end."""
    softens = Law(codes.STIFF, (0.0, 0.0, -2.0, 0.0))
    motion = simulate(PLAIN.changed(drag=0.5), (softens,), 1.0, 200, STEP)
    assert np.all(np.isfinite(motion.x[:5]))
    assert np.all(np.isnan(motion.x[-100:]))
    held = simulate(PLAIN, (softens,), 0.6, 200, STEP)
    assert np.max(np.abs(held.x)) == pytest.approx(0.6, rel=1e-6)


def test_a_fading_tone_is_a_tone_at_first_and_nothing_at_last():
    body = Body(3000.0, 800.0, 4e5, 100.0, 2000.0)
    tone = simulate(body, (Law(codes.TONES, (1.0, 500.0, 9.0, 0.7)),), 0.03, 800, 0.01).x
    steady, gone = (
        simulate(body, (Law(codes.FADING, (500.0, 9.0, 0.7, rate)),), 0.03, 800, 0.01).x for rate in (0.0, 1e4)
    )
    assert np.max(np.abs(steady - tone)) < 1e-9
    assert np.max(np.abs(gone - simulate(body, (), 0.03, 800, 0.01).x)) < 1e-5  # a push of a tenth of a millisecond
