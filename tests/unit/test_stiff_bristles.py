"""Bristles that follow the motion much faster than it swings: exact steps, and as few as the body itself needs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from undertow.equation.kernel import N_SLOTS, SLOT, integrate
from undertow.equation.simulate import fastest_frequency, step_of_motion
from undertow.likelihood.output_error import FULL, trajectory

TIMES = np.arange(0.0, 3.0, 0.01)
NONE = np.zeros(0, dtype=np.int64)
MASS, STIFFNESS, DAMPING, RELEASE = 2637.0, 402e3, 800.0, 0.033


def body(**numbers: float) -> np.ndarray:
    """A body of 2637 kg on 402 kN/m, let go at 33 mm."""
    theta = np.zeros(N_SLOTS)
    basis = {"mass": MASS, "k1": STIFFNESS, "c1": DAMPING, "x0": RELEASE}
    for slot, value in (basis | numbers).items():
        theta[SLOT[slot]] = value
    return theta


def by_hand(kb: float, fb: float) -> np.ndarray:
    """The same motion by DOP853 from turn to turn: until it turns, the bristles' force is one of displacement alone."""
    t, x, z, way, found = 0.0, RELEASE, 0.0, -1.0, np.full(TIMES.size, np.nan)
    while t < TIMES[-1]:

        def force(at: float, x: float = x, z: float = z, way: float = way) -> float:
            return way * fb + (z - way * fb) * float(np.exp(-way * (at - x) * kb / fb))

        def rates(_: float, y: np.ndarray, force=force) -> list[float]:
            return [y[1], (-STIFFNESS * y[0] - DAMPING * y[1] - force(y[0])) / MASS]

        def turns(_: float, y: np.ndarray, way: float = way) -> float:
            return way * y[1]

        turns.terminal, turns.direction = True, -1
        part = solve_ivp(
            rates, (t, TIMES[-1]), [x, way * 1e-14], "DOP853", events=turns, dense_output=True, rtol=1e-11, atol=1e-15,
            first_step=1e-7,
        )  # fmt: skip
        inside = np.flatnonzero(np.clip(TIMES, t, part.t[-1]) == TIMES)
        found[inside] = part.sol(TIMES[inside])[0]
        t, x = float(part.t[-1]), float(part.y[0, -1])
        z, way = force(x), -way
    return found


@pytest.mark.parametrize(("stiff", "share"), [(1.0, 0.1), (10.0, 0.02), (65.0, 0.012), (300.0, 0.01), (100.0, 0.3)])
def test_motion_on_bristles_is_exact_however_stiff_they_are(stiff, share):
    kb, fb = stiff * STIFFNESS, share * STIFFNESS * RELEASE
    # the last soon rings on its bristles, which do not yield any more
    here = trajectory(body(kb=kb, fb=fb), NONE, TIMES, FULL.steps_a_period)[0][:, 0]
    assert np.max(np.abs(here - by_hand(kb, fb))) < 2e-6 * RELEASE


@pytest.mark.parametrize(("stiff", "share"), [(1.0, 0.1), (20.0, 0.02), (300.0, 0.01)])
def test_so_are_its_sensitivities(stiff, share):
    numbers = {"kb": stiff * STIFFNESS, "fb": share * STIFFNESS * RELEASE}
    slots = np.array([SLOT[slot] for slot in ("mass", "c1", *numbers)])
    found = trajectory(body(**numbers), slots, TIMES, 200)[0]
    for column, slot in enumerate(("mass", "c1", *numbers), start=1):
        by = 1e-4 * body(**numbers)[SLOT[slot]]
        up, down = (
            trajectory(body(**(numbers | {slot: body(**numbers)[SLOT[slot]] + sign * by})), NONE, TIMES, 200)[0][:, 0]
            for sign in (1.0, -1.0)
        )
        slope = (up - down) / (2.0 * by)
        assert np.max(np.abs(found[:, column] - slope)) < 2e-3 * np.max(np.abs(slope))


def test_bristles_that_hardly_bend_swing_like_dry_friction():
    bristles = trajectory(body(kb=43e3, fb=6.0), NONE, TIMES)[0][:, 0]
    sliding = trajectory(body(fc=6.0), NONE, TIMES)[0][:, 0]
    assert np.max(np.abs(bristles - sliding)) < 2e-4  # 4 F / k is 6e-5 m a cycle, the bristles bend by 1.4e-4


@pytest.mark.parametrize("steps", [12, 40])
def test_steps_are_short_enough_for_bristles_to_be_stable(steps):
    coarse = trajectory(body(kb=43e3, fb=20.0), NONE, TIMES, steps)[0][:, 0]
    fine = trajectory(body(kb=43e3, fb=20.0), NONE, TIMES, 200)[0][:, 0]
    assert np.max(np.abs(coarse - fine)) < 1e-5


def test_stiff_bristles_cost_a_few_steps_a_turn():
    def steps(**numbers: float) -> int:
        theta = body(**numbers)
        return integrate(theta, NONE, TIMES[TIMES < 1.5], step_of_motion(theta, 40))[-1]

    bare, force = steps(), 0.01 * STIFFNESS * RELEASE
    turns = 1.5 / (np.pi * np.sqrt(MASS / STIFFNESS))
    for stiff in (1.0, 20.0, 1000.0):
        assert steps(kb=stiff * STIFFNESS, fb=force) < bare + 35 * turns


def test_the_fastest_frequency_is_that_of_the_body_on_its_bristles():
    assert fastest_frequency(body(kb=3.0 * STIFFNESS, fb=6.0)) == pytest.approx(2.0 * fastest_frequency(body()))
    assert step_of_motion(body(kb=3.0 * STIFFNESS, fb=6.0), 40) == pytest.approx(step_of_motion(body(), 40))
