"""A body on a base that moves: its integrator against DOP853 in the earth's frame, and fits of synthetic truths."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.differences import slope
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.base_motion import moving_drive
from undertow.equation.driven import driven_motion
from undertow.equation.driven_kernel import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.driven_laws import find_driven
from undertow.equation.input import MotionSize
from undertow.errors import IdentificationError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import fit_driven, free_run

STEP, SAMPLES, NOISE = 0.01, 2000, 1e-4
EXTENT = MotionSize(0.3, 2.0)
NOTHING = np.zeros(0, dtype=np.int64)
T = np.arange(SAMPLES) * STEP
TRUTH = {"mass": 5.0, "k1": 100.0, "c1": 2.0, "fc": 1.0, "wq": 30.0}
NAMES = {
    "k1": "stiffness.k_N_per_m", "c1": "viscous_damping.c_Ns_per_m", "fc": "coulomb_friction.force_N",
    "wq": "quadratic_drag.drag_Ns2_per_m2",
}  # fmt: skip
RESTING = {"mass": 5.0, "k1": 100.0, "c1": 2.0}
TERMS = tuple(find_driven(n) for n in ("stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag"))


def swept(t=T):
    """Displacement of a base, m, velocity and acceleration: from 0.2 to 1.6 Hz."""
    bend = 2.0 * np.pi * 1.4 / T[-1]
    angle, rate = 2.0 * np.pi * 0.2 * t + 0.5 * bend * t**2, 2.0 * np.pi * 0.2 + bend * t
    y, dy = 0.05 * np.sin(angle), 0.05 * rate * np.cos(angle)
    return y, dy, 0.05 * (bend * np.cos(angle) - rate**2 * np.sin(angle))


def theta_of(**numbers):
    """A driven parameter vector with these slots."""
    theta = np.zeros(N_DRIVEN)
    for name, value in {"gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0, **numbers}.items():
        theta[DRIVEN_SLOT[name]] = value
    return theta


def shaken(seed=0, quantity="base_displacement", hold="band_limited", frame="relative", **more):
    """A trial of the truth on the swept base, recorded in that frame with white noise."""
    recorded = dict(zip(("base_displacement", "base_velocity", "base_acceleration"), swept(), strict=True))[quantity]
    drive = moving_drive(T, swept()[0], "base_displacement", "band_limited")
    x = driven_motion(theta_of(**{**TRUTH, **more}), NOTHING, drive, T, EXTENT, 40).x[:, 0]
    x = x + (swept()[0] if frame == "absolute" else 0.0) + NOISE * np.random.default_rng(seed).normal(size=SAMPLES)
    return DrivenTrial("shaken", T, recorded, {"displacement": x}, quantity, hold, frames={"displacement": frame})


def in_earth_frame(p, end_s):
    """Displacement relative to the base at T up to end_s by DOP853 for the body's place against the earth.

    Independent of the kernel: forces of spring and damper from the difference of two motions, water from one alone.
    """

    def rates(t, state):
        place, speed, s, u = state
        y, dy, _ = swept(t)
        base = p["k1"] * (place - y) + p["c1"] * (speed - dy)
        water = p["wq"] * speed * abs(speed) + p["wc"] * speed + p["wc3"] * speed**3
        inside = 2.0 * p["hz1"] * p["hw1"] * u + p["hw1"] ** 2 * s
        a = (-base - water + p["hm1"] * inside) / p["mass"]
        return [speed, a, u, -a - inside]

    y0, dy0, _ = swept(0.0)
    begin = [p["x0"] + y0, p["v0"] + dy0, p["hs1"], p["hu1"]]
    times = T[end_s >= T]
    # no event: drag is smooth but for a jump of its curvature, which steps of 1e-3 of a period keep below 1e-9
    got = solve_ivp(rates, (T[0], times[-1]), begin, "DOP853", times, rtol=1e-12, atol=1e-13, max_step=2e-3)
    return got.y[0] - swept(times)[0]


@pytest.mark.parametrize(
    "laws",
    [
        {"wq": 30.0}, {"wc": 3.0, "wc3": 20.0}, {"x0": 0.05, "v0": -0.2, "wq": 30.0},
        {"hm1": 0.8, "hw1": 5.0, "hz1": 0.02, "wq": 10.0},
    ],
)  # fmt: skip
def test_motion_on_a_base_is_that_of_dop853_in_the_earths_frame(laws):
    theta = theta_of(**{**RESTING, **laws})
    reference = in_earth_frame({name: theta[i] for name, i in DRIVEN_SLOT.items()}, 6.0)
    drive = moving_drive(T, swept()[2], "base_acceleration", "band_limited")
    theta[DRIVEN_SLOT["absolute_v0"]] = swept(0.0)[1] - drive.velocity_at(T[:1])[0]  # an integral lacks its constant
    x = driven_motion(theta, NOTHING, drive, T[: reference.size], EXTENT, 80).x[:, 0]
    # 1e-6: the swept base is not quite band-limited where the record begins
    assert np.max(np.abs(x - reference)) < 1e-6 * np.max(np.abs(reference))


def test_a_stuck_body_rides_on_its_base_and_slips_where_inertia_exceeds_friction():
    drive = moving_drive(T, swept()[0], "base_displacement", "band_limited", ("displacement", "acceleration"))
    holds = driven_motion(theta_of(mass=5.0, fc=40.0), NOTHING, drive, T, EXTENT)
    assert np.max(np.abs(holds.x[:, 0] - swept()[0])) < 1e-9
    inner = slice(20, -20)  # a record's ends are where a band-limited signal is known least
    assert np.max(np.abs(holds.a[inner, 0] - swept()[2][inner])) < 1e-3
    drive = moving_drive(T, swept()[0], "base_displacement", "band_limited")
    slides = driven_motion(theta_of(mass=5.0, fc=10.0), NOTHING, drive, T, EXTENT).x[:, 0]
    first = T[np.flatnonzero(np.abs(slides) > 1e-9)[0]]
    assert first - T[np.flatnonzero(np.abs(swept()[2]) > 2.0)[0]] == pytest.approx(0.0, abs=2.0 * STEP)


@pytest.mark.parametrize("quantity", ["base_displacement", "base_velocity", "base_acceleration"])
@pytest.mark.parametrize("output", ["displacement", "velocity", "acceleration"])
def test_sensitivities_on_a_base_are_those_of_differences(quantity, output):
    recorded = dict(zip(("base_displacement", "base_velocity", "base_acceleration"), swept(), strict=True))[quantity]
    frames = (output,) if output != "displacement" or quantity == "base_displacement" else ()
    drive = moving_drive(T[:600], recorded[:600], quantity, "band_limited", frames)
    numbers = {**TRUTH, "wc": 0.5, "wc3": 2.0, "delay": 0.013, "x0": 0.02, "v0": 0.1, "gain": 1.1, "absolute_v0": 0.01}
    theta = theta_of(**numbers)
    active = np.array([DRIVEN_SLOT[name] for name in numbers])
    place = {"displacement": "x", "velocity": "v", "acceleration": "a"}[output]
    column = getattr(driven_motion(theta, active, drive, T[:600], EXTENT, 40), place)
    calm = np.ones(600, dtype=bool)
    for i, slot in enumerate(active, 1):
        difference = slope(
            lambda one: getattr(driven_motion(one, NOTHING, drive, T[:600], EXTENT, 40), place)[:, 0], theta, slot
        )
        off = np.abs(difference - column[:, i]) / np.max(np.abs(column[:, i]))
        # an acceleration jumps where the body turns: a sample within a step of that instant shows either side
        calm &= (off < 1e-3) | (output != "acceleration")
        assert np.max(off[calm]) < 1e-6
    assert np.count_nonzero(~calm) < 12


def test_swept_base_motion_gives_eq15_within_the_cramer_rao_bound():
    near = {name: 1.05 * TRUTH[slot] for slot, name in NAMES.items()}
    known = DrivenLaws(TERMS, fixed={"mass_kg": 5.0}, starts={"mass_kg": 5.0, **near})
    # the motion itself is linear in small errors: bound from the sensitivities at the truth, start state included
    drive = moving_drive(T, swept()[0], "base_displacement", "band_limited")
    active = np.array([DRIVEN_SLOT[name] for name in (*NAMES, "x0", "v0")])
    jacobian = driven_motion(theta_of(**TRUTH), active, drive, T, EXTENT, 40).x[:, 1:] / NOISE
    bound = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))[: len(NAMES)]
    away = []
    for seed in range(12):
        found = fit_driven([shaken(seed)], known, windows=0).numbers
        away.append([(found[name] - TRUTH[slot]) / b for (slot, name), b in zip(NAMES.items(), bound, strict=True)])
    # 48 standardised errors; their rms is 1 +- 0.1 where the bound is reached
    assert np.sqrt(np.mean(np.square(away))) < 1.1
    assert np.max(np.abs(away)) < 4.0


@pytest.mark.parametrize(
    ("quantity", "hold"), [("base_displacement", "band_limited"), ("base_velocity", "band_limited"),
                           ("base_velocity", "first"), ("base_acceleration", "band_limited")],
)  # fmt: skip
def test_each_quantity_of_the_base_gives_the_same_equation(quantity, hold):
    found = fit_driven([shaken(1, quantity, hold)], DrivenLaws(TERMS, fixed={"mass_kg": 5.0}))
    for slot, name in NAMES.items():
        # straight lines between 100 samples a second lose (w dt)^2 / 12, 1e-3 at 1.6 Hz
        assert found.numbers[name] == pytest.approx(TRUTH[slot], rel=0.01)
    assert found.rms["shaken"] < 1.5 * NOISE


@pytest.mark.parametrize(("said", "true"), [("relative", "absolute"), ("absolute", "relative")])
def test_a_wrong_frame_leaves_far_more_than_noise(said, true):
    right = shaken(0, frame=true)
    wrong = DrivenTrial(
        "shaken", T, right.u, right.outputs, "base_displacement", "band_limited", frames={"displacement": said}
    )
    laws = DrivenLaws(TERMS, fixed={"mass_kg": 5.0})
    assert fit_driven([right], laws).rms["shaken"] < 1.1 * NOISE
    assert fit_driven([wrong], laws).rms["shaken"] > 50.0 * NOISE


def test_forces_are_per_mass_where_nothing_but_the_moving_drives():
    found = fit_driven([shaken(2)], DrivenLaws(TERMS))
    assert found.numbers["mass_kg"] == 1.0
    assert found.numbers["stiffness.k_N_per_m"] == pytest.approx(100.0 / 5.0, rel=1e-3)
    run = free_run(shaken(3), found, 50)
    assert np.std(run - shaken(3).outputs["displacement"]) < 1.2 * NOISE


def test_added_mass_needs_a_known_mass_and_a_known_spring():
    terms = (*TERMS, find_driven("added_mass"))
    with pytest.raises(IdentificationError, match="with 0 forces known: M and m_a act as one"):
        fit_driven([shaken()], DrivenLaws(terms))
    fixed = {"mass_kg": 4.2, "stiffness.k_N_per_m": 100.0}
    found = fit_driven([shaken()], DrivenLaws(terms, fixed=fixed))
    assert found.numbers["added_mass.mass_kg"] == pytest.approx(0.8, abs=0.01)
