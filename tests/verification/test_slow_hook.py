"""A hook that lets go slowly, F_h (1 - t / T): the integrator against closed forms and against scipy's."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from undertow.equation.kernel import N_SLOTS, SLOT, integrate

RATE = 3.0
TIMES = np.linspace(0.0, 6.0, 301)
STEP = 2.0 * math.pi / RATE / 40.0
NONE = np.zeros(0, dtype=np.int64)
BODY = {"mass": 1.3, "k1": 1.3 * RATE**2, "k3": 40.0, "c1": 0.2, "q": 3.0, "x0": 0.1, "xe": 0.01}


def theta(**values: float) -> np.ndarray:
    found = np.zeros(N_SLOTS)
    for slot, value in values.items():
        found[SLOT[slot]] = value
    return found


def motion(**values: float) -> np.ndarray:
    x, *_, steps = integrate(theta(**values), NONE, TIMES, STEP)
    assert steps > 0
    return x[:, 0]


@pytest.mark.parametrize("time", [0.02, 0.3, 1.0, 1.4])
def test_an_undamped_body_swings_on_with_the_amplitude_of_a_ramp(time):
    """Of x'' + w^2 (x - x0 (1 - t / T)) = 0 from rest at x0 the amplitude after T is x0 sin(w T / 2) / (w T / 2)."""
    x, v, _, _, _ = integrate(theta(mass=1.0, k1=RATE**2, x0=0.1, let_go=time), NONE, TIMES, STEP)
    after = time <= TIMES
    size = np.hypot(x[after, 0], v[after, 0] / RATE)
    assert size == pytest.approx(0.1 * abs(math.sin(RATE * time / 2.0)) / (RATE * time / 2.0), rel=1e-6)
    before = TIMES[~after]
    held = 0.1 * (1.0 - before / time) + 0.1 * np.sin(RATE * before) / (RATE * time)
    assert x[~after, 0] == pytest.approx(held, abs=1e-8)


@pytest.mark.parametrize("power", [1.0, 1.4, 3.0])
@pytest.mark.parametrize("x0", [0.1, -0.08])
@pytest.mark.parametrize("time", [0.05, 0.7, 2.5])
def test_it_is_scipys_motion_with_drag_and_a_spring_that_hardens(time, x0, power):
    b = {**BODY, "x0": x0}
    spring = lambda x: b["k1"] * (x - b["xe"]) + b["k3"] * (x - b["xe"]) ** 3  # noqa: E731

    def slope(t, y):
        hook = spring(x0) * max(1.0 - t / time, 0.0) ** power
        return [y[1], (hook - spring(y[0]) - b["c1"] * y[1] - b["q"] * y[1] * abs(y[1])) / b["mass"]]

    options = {"rtol": 1e-11, "atol": 1e-13, "max_step": 0.02}
    first = solve_ivp(slope, (0.0, time), [x0, 0.0], t_eval=[*TIMES[time > TIMES], time], **options).y
    then = solve_ivp(slope, (time, 6.0), first[:, -1], t_eval=TIMES[time <= TIMES], **options).y
    assert motion(**b, let_go=time, let_go_p=power) == pytest.approx(np.concatenate([first[0, :-1], then[0]]), abs=3e-8)


@pytest.mark.parametrize("power", [0.0, 1.4, 3.0])
@pytest.mark.parametrize("time", [0.05, 0.7, 2.5])
@pytest.mark.parametrize("friction", [0.0, 0.15])
def test_its_sensitivities_are_those_of_differences(time, friction, power):
    further = (*(("let_go_p",) if power else ()), *(("fc",) if friction else ()))
    slots = ("let_go", "k1", "k3", "c1", "q", "x0", "xe", "mass", *further)
    body = {**BODY, "fc": friction, "let_go": time, "let_go_p": power, "k1": 12.0}
    active = np.array([SLOT[slot] for slot in slots])
    x, *_ = integrate(theta(**body), active, TIMES, STEP)
    for column, slot in enumerate(slots, start=1):
        by = 1e-5 * max(abs(body[slot]), 0.1)
        change = (motion(**{**body, slot: body[slot] + by}) - motion(**{**body, slot: body[slot] - by})) / (2.0 * by)
        rough = 1e-3 if slot == "let_go" and 1.0 < power < 2.0 else 1e-4  # its slope has no limit at the end
        assert x[:, column] == pytest.approx(change, abs=rough * np.max(np.abs(change))), slot


def test_friction_holds_until_the_hook_has_let_go_as_much():
    """k x0 t / T reaches the friction at T F_c / (k x0)."""
    body = {"mass": 1.0, "k1": 9.0, "x0": 0.1, "fc": 0.3, "let_go": 1.2}
    assert integrate(theta(**body), NONE, TIMES, STEP)[0][TIMES < 0.4, 0] == pytest.approx(0.1, abs=0.0)
    assert motion(**body)[TIMES > 0.45].max() < 0.1
    assert motion(**{**body, "fc": 1.0}) == pytest.approx(0.1, abs=0.0)  # more than the spring pulls


def test_a_resonator_beside_the_body_is_held_as_still_and_a_hook_of_no_time_is_none():
    beside = {"hm1": 0.2, "hw1": 4.0, "hz1": 0.02}
    slots = ("let_go", "hm1", "hw1", "k1")
    body = {**BODY, **beside, "let_go": 0.6}
    x, *_ = integrate(theta(**body), np.array([SLOT[slot] for slot in slots]), TIMES, STEP)
    for column, slot in enumerate(slots, start=1):
        by = 1e-5 * body[slot]
        change = (motion(**{**body, slot: body[slot] + by}) - motion(**{**body, slot: body[slot] - by})) / (2.0 * by)
        assert x[:, column] == pytest.approx(change, abs=1e-4 * np.max(np.abs(change))), slot
    sudden = motion(**BODY, **beside)
    assert motion(**BODY, **beside, let_go=1e-6) == pytest.approx(sudden, abs=1e-6)
    assert np.max(np.abs(motion(**BODY, **beside, let_go=0.6) - sudden)) > 0.01


@pytest.mark.parametrize("time", [0.5, 3.0])
def test_an_echo_comes_back_from_a_slow_release_too(time):
    """The echo's first kink, its delay after the start, may come before the hook has let go or after."""
    body = {**BODY, "ge": 0.3, "tau_e": 1.7, "let_go": time}
    slots = ("let_go", "ge", "tau_e")
    x, *_ = integrate(theta(**body), np.array([SLOT[slot] for slot in slots]), TIMES, STEP)
    finer = integrate(theta(**body), NONE, TIMES, STEP / 8.0)[0][:, 0]
    assert x[:, 0] == pytest.approx(finer, abs=1e-6)
    for column, slot in enumerate(slots, start=1):
        by = 1e-5 * body[slot]
        change = (motion(**{**body, slot: body[slot] + by}) - motion(**{**body, slot: body[slot] - by})) / (2.0 * by)
        assert x[:, column] == pytest.approx(change, abs=1e-3 * np.max(np.abs(change))), slot
