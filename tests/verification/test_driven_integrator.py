"""The driven integrator against DOP853 split at knots and events, and its sensitivities against differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.differences import slope
from undertow.equation.driven import driven_motion
from undertow.equation.driven_kernel import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.input import MotionSize, drive_of
from undertow.errors import IdentificationError

STEP, SAMPLES = 0.01, 600
EXTENT = MotionSize(2.0, 6.0)
NOTHING = np.zeros(0, dtype=np.int64)
FINE = 160
"""Steps a period where differences are taken: the rule for steps may choose one more on one side."""


def theta_of(**numbers):
    """A driven parameter vector with these slots."""
    theta = np.zeros(N_DRIVEN)
    for name, value in {"mass": 4.0, "gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0, **numbers}.items():
        theta[DRIVEN_SLOT[name]] = value
    return theta


def random_input(size=60.0, seed=0):
    """Times and a smooth random input."""
    rng = np.random.default_rng(seed)
    t = np.arange(SAMPLES) * STEP
    return t, np.convolve(rng.normal(size=SAMPLES + 20), np.hanning(20), "same")[:SAMPLES] * size


def by_dop853(theta, drive, end_s):
    """x at the knots up to end_s by DOP853, a piece of the input at a time, split at reversals and at z = 0.

    Independent of the kernel: its own right-hand side and its own events; stuck bodies slip where a bisection says so.
    """
    p = {name: theta[i] for name, i in DRIVEN_SLOT.items()}
    y, out, stuck = [p["x0"], p["v0"], p["bw_z0"]], [p["x0"]], False
    for i, (begin, end) in enumerate(zip(drive.knots[:-1], drive.knots[1:], strict=True)):
        if end > end_s + 1e-9:
            break

        def pull(t, x, v, z, side, i=i, begin=begin, width=end - begin):
            u = np.polyval(drive.pieces[i][::-1], (t - begin) / width)
            viscous = (p["c1"] + p["cb"] * side) * v
            return p["gain"] * u - p["offset"] - z - p["k1"] * x - viscous - p["q"] * v * v * side - p["k3"] * x**3

        y, stuck = _through(p, pull, begin, end, y, stuck)
        out.append(y[0])
    return np.array(out)


def _through(p, pull, t, end, y, stuck):
    """State at the end of one piece of the input, and whether the body is stuck there."""
    x, v, z = y
    for _ in range(50):
        if stuck or v == 0.0:
            over = [s for s in np.linspace(t, end, 9) if abs(pull(s, x, 0.0, z, 0.0)) > p["fc"]]
            if not over:
                return [x, 0.0, z], True
            lo, hi = t, over[0]
            for _ in range(60 if hi > t else 0):
                mid = 0.5 * (lo + hi)
                lo, hi = (mid, hi) if abs(pull(mid, x, 0.0, z, 0.0)) <= p["fc"] else (lo, mid)
            t, stuck = hi, False
        side = np.sign(v) or np.sign(pull(t, x, 0.0, z, 0.0))
        zside = np.sign(z) or side

        def rates(s, state, side=side, zside=zside):
            x, v, z = state
            a = (pull(s, x, v, z, side) - p["fc"] * side) / p["mass"]
            return [v, a, v * (p["bw_a"] - p["bw_g"] * side * z - p["bw_d"] * z * zside)]

        got = solve_ivp(rates, (t, end), [x, v, z], "DOP853", rtol=1e-11, atol=1e-12, events=_two(side, zside, p, t))
        t, (x, v, z) = got.t[-1], got.y[:, -1]
        v, z = (0.0, z) if got.t_events[0].size else (v, 0.0 if got.t_events[1].size else z)
        if got.status == 0:
            return [x, v, z], False
    raise AssertionError("the reference does not get through a piece of the input")


def _two(side, zside, p, begin):
    """Events: reversal, and z = 0 where there is a hysteresis; not the one the piece starts from."""

    def reversal(s, y, *_):
        return side if s <= begin + 1e-12 else y[1]

    def passage(s, y, *_):
        return zside if s <= begin + 1e-12 or p["bw_a"] == 0.0 else y[2]

    reversal.terminal = passage.terminal = True
    return [reversal, passage]


CASES = {
    "spring and drag": {"k1": 100.0, "c1": 2.0, "q": 3.0, "x0": 0.3, "v0": 0.1},
    "stick and slip": {"k1": 100.0, "c1": 2.0, "fc": 30.0, "x0": 0.3},
    "a carriage without a spring": {"c1": 8.0, "fc": 20.0, "offset": -3.0},
    "a carriage that goes easier one way": {"c1": 8.0, "cb": -3.0, "fc": 20.0},
    "a damper that is stiffer one way": {"k1": 100.0, "c1": 4.0, "cb": 3.0, "x0": 0.3},
    "hysteresis": {"k1": 50.0, "c1": 2.0, "bw_a": 50.0, "bw_g": 2.0, "bw_d": -1.0, "x0": 0.1},
    "hardening": {"k1": 40.0, "k3": 30.0, "c1": 1.0, "x0": 0.2},
}


@pytest.mark.parametrize("hold", ["zero", "first", "band_limited"])
@pytest.mark.parametrize("case", CASES)
def test_motion_is_that_of_dop853_split_at_events_and_knots(case, hold):
    t, u = random_input()
    drive = drive_of(t, u, hold)
    theta = theta_of(**CASES[case])
    reference = by_dop853(theta, drive, t[100])
    x = driven_motion(theta, NOTHING, drive, drive.knots[: reference.size], EXTENT, 80).x[:, 0]
    assert np.max(np.abs(x - reference)) < 1e-7 * np.max(np.abs(reference))


@pytest.mark.parametrize("hold", ["zero", "first", "band_limited"])
@pytest.mark.parametrize("case", CASES)
def test_sensitivities_are_those_of_differences(case, hold):
    t, u = random_input()
    drive = drive_of(t, u, hold)
    numbers = {"delay": 0.0213, "offset": 0.0, **CASES[case], "x0": 0.1, "v0": 0.3}
    theta = theta_of(**numbers)
    active = np.array([DRIVEN_SLOT[name] for name in ("mass", "gain", *numbers)])
    motion = driven_motion(theta, active, drive, t, EXTENT, FINE)
    for column, slot in enumerate(active, 1):
        difference = slope(lambda one: driven_motion(one, NOTHING, drive, t, EXTENT, FINE).x[:, 0], theta, slot)
        assert np.max(np.abs(difference - motion.x[:, column])) < 1e-6 * np.max(np.abs(difference)) + 1e-12


def test_a_force_below_friction_moves_nothing():
    t = np.arange(300) * STEP
    drive = drive_of(t, 19.0 * np.sin(7.0 * t), "first")
    assert np.all(driven_motion(theta_of(fc=20.0), NOTHING, drive, t, EXTENT).x[:, 0] == 0.0)


def test_a_jump_of_the_input_above_friction_starts_the_body_at_its_sample():
    t = np.arange(300) * STEP
    drive = drive_of(t, np.where(t < 1.0 - 1e-9, 10.0, 24.0), "zero")
    x = driven_motion(theta_of(fc=20.0), NOTHING, drive, t, EXTENT).x[:, 0]
    assert np.max(np.abs(x - np.where(t > 1.0, 0.5 * (t - 1.0) ** 2, 0.0))) < 1e-9


def test_what_cannot_be_integrated_is_refused():
    t, u = random_input()
    drive = drive_of(t, u)
    with pytest.raises(IdentificationError, match="positive mass and finite parameters, got -1 kg"):
        driven_motion(theta_of(mass=-1.0), NOTHING, drive, t, EXTENT)
    with pytest.raises(IdentificationError, match="delayed_echo of gain 2 N s/m beside an input"):
        driven_motion(theta_of(ge=2.0), NOTHING, drive, t, EXTENT)
    with pytest.raises(IdentificationError, match="leaves every bound after"):
        driven_motion(theta_of(k1=-4000.0, x0=0.1), NOTHING, drive, t, EXTENT)
