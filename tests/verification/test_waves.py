"""A body in water that moves: its integrator against DOP853, sensitivities, fits of synthetic truths, still water."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.differences import slope
from undertow.conditioning.driven import DrivenTrial
from undertow.conditioning.water import one_velocity
from undertow.equation.base_motion import moving_drive
from undertow.equation.driven import driven_motion
from undertow.equation.driven_laws import find_driven, places
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.input import MotionSize, drive_of
from undertow.errors import ConfigError, IdentificationError, RecordingError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import fit_driven, free_run

STEP, SAMPLES, NOISE = 0.02, 3000, 1e-4
EXTENT = MotionSize(0.3, 2.0)
NOTHING = np.zeros(0, dtype=np.int64)
T = np.arange(SAMPLES) * STEP
DRY, ADDED, DISPLACED = 5.0, 2.0, 3.0
TRUTH = {"mass": DRY + ADDED, "wave": DISPLACED + ADDED, "k1": 100.0, "c1": 2.0, "fc": 0.5, "wq": 30.0}
NAMES = {
    "k1": "stiffness.k_N_per_m", "c1": "viscous_damping.c_Ns_per_m", "fc": "coulomb_friction.force_N",
    "wq": "quadratic_drag.drag_Ns2_per_m2", "wave": "froude_krylov.displaced_kg",
}  # fmt: skip
TERMS = tuple(
    find_driven(n)
    for n in ("stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag", "froude_krylov")
)  # fmt: skip


def components(seed=3):
    """Angular frequency, phase and velocity of the sea's waves, (8,) each."""
    rng = np.random.default_rng(seed)
    return 2.0 * np.pi * np.linspace(0.2, 0.9, 8), rng.uniform(0.0, 2.0 * np.pi, 8), 0.12 * rng.uniform(0.5, 1.0, 8)


def sea(t=T, seed=3):
    """Velocity and acceleration of a sea of eight waves from 0.2 to 0.9 Hz, m/s and m/s^2."""
    w, phase, size = components(seed)
    angle = np.multiply.outer(t, w) + phase
    return np.sin(angle) @ size, np.cos(angle) @ (size * w)


def theta_of(**numbers):
    """A driven parameter vector with these slots."""
    theta = np.zeros(N_DRIVEN)
    for name, value in {"gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0, **numbers}.items():
        theta[DRIVEN_SLOT[name]] = value
    return theta


def in_waves(seed=0, quantity="water_velocity", truth=TRUTH, waves=3, hold="band_limited"):
    """A trial of the truth in the sea, its displacement with white noise."""
    recorded = dict(zip(("water_velocity", "water_acceleration"), sea(seed=waves), strict=True))[quantity]
    drive = moving_drive(T, sea(seed=waves)[0], "water_velocity", "band_limited")
    x = driven_motion(theta_of(**truth), NOTHING, drive, T, EXTENT, 40).x[:, 0]
    x = x + NOISE * np.random.default_rng(seed).normal(size=SAMPLES)
    return DrivenTrial("sea", T, recorded, {"displacement": x}, quantity, hold)


def by_dop853(p, end_s):
    """Displacement at T up to end_s by DOP853: Morison's force as it is written, independent of the kernel."""

    w, phase, size = components()

    def rates(t, state):
        x, v = state
        angle = w * t + phase
        r, du = v - np.sin(angle) @ size, np.cos(angle) @ (size * w)
        water = p["wq"] * r * abs(r) + p["wc"] * r + p["wc3"] * r**3
        return [v, (p["wave"] * du - water - p["k1"] * x - p["c1"] * v) / p["mass"]]

    times = T[end_s >= T]
    # no event: drag is smooth but for a jump of its curvature, which short steps keep below 1e-9
    begin, ends = [p["x0"], p["v0"]], (T[0], times[-1])
    got = solve_ivp(rates, ends, begin, "DOP853", times, rtol=1e-12, atol=1e-13, max_step=5e-3)
    return got.y[0]


@pytest.mark.parametrize("quantity", ["water_velocity", "water_acceleration"])
@pytest.mark.parametrize(
    "laws", [{"wq": 30.0, "wave": 5.0}, {"wq": 30.0}, {"wave": 5.0}, {"wc": 3.0, "wc3": 20.0, "wave": 2.0, "x0": 0.05}]
)
def test_motion_in_waves_is_that_of_dop853(laws, quantity):
    theta = theta_of(**{"mass": 7.0, "k1": 100.0, "c1": 2.0, **laws})
    reference = by_dop853({name: theta[i] for name, i in DRIVEN_SLOT.items()}, 5.0)
    drive = moving_drive(T, sea()[quantity == "water_acceleration"], quantity, "band_limited")
    theta[DRIVEN_SLOT["absolute_v0"]] = sea(T[:1])[0][0] - drive.velocity_at(T[:1])[0]  # an integral's constant
    x = driven_motion(theta, NOTHING, drive, T[: reference.size], EXTENT, 80).x[:, 0]
    # 1e-5: the sea is not quite band-limited where the record begins
    assert np.max(np.abs(x - reference)) < 1e-5 * np.max(np.abs(reference))


@pytest.mark.parametrize("quantity", ["water_velocity", "water_acceleration"])
def test_sensitivities_in_waves_are_those_of_differences(quantity):
    recorded = sea()[quantity == "water_acceleration"][:600]
    drive = moving_drive(T[:600], recorded, quantity, "band_limited")
    numbers = {**TRUTH, "wc": 0.5, "wc3": 2.0, "delay": 0.013, "x0": 0.02, "v0": 0.1, "gain": 1.1, "absolute_v0": 0.01}
    theta = theta_of(**numbers)
    active = np.array([DRIVEN_SLOT[name] for name in numbers])
    column = driven_motion(theta, active, drive, T[:600], EXTENT, 40).x
    for i, slot in enumerate(active, 1):
        difference = slope(lambda one: driven_motion(one, NOTHING, drive, T[:600], EXTENT, 40).x[:, 0], theta, slot)
        assert np.max(np.abs(difference - column[:, i])) < 1e-6 * np.max(np.abs(column[:, i]))


def test_in_still_water_the_motion_is_that_of_a_body_nothing_drives():
    begun = {"mass": 7.0, "k1": 100.0, "c1": 2.0, "fc": 0.5, "x0": 0.2}
    still = moving_drive(T, np.zeros(SAMPLES), "water_velocity", "band_limited")
    waves = driven_motion(theta_of(**begun, wq=30.0, wave=5.0), NOTHING, still, T, EXTENT, 40).x[:, 0]
    decay = driven_motion(theta_of(**begun, q=30.0), NOTHING, drive_of(T, 0.0 * T), T, EXTENT, 40).x[:, 0]
    assert np.max(np.abs(waves - decay)) < 1e-10


def test_a_stuck_body_slips_where_the_waves_force_exceeds_friction():
    theta = theta_of(**{**TRUTH, "wq": 0.0, "fc": 4.0, "c1": 0.0, "k1": 0.0})
    drive = moving_drive(T, sea()[0], "water_velocity", "band_limited")
    x = driven_motion(theta, NOTHING, drive, T, EXTENT, 40).x[:, 0]
    first = T[np.flatnonzero(np.abs(x) > 1e-9)[0]]
    assert first - T[np.flatnonzero(np.abs(TRUTH["wave"] * sea()[1]) > 4.0)[0]] == pytest.approx(0.0, abs=2.0 * STEP)


def test_waves_give_morisons_numbers_within_the_cramer_rao_bound():
    near = {name: 1.05 * TRUTH[slot] for slot, name in NAMES.items()}
    known = DrivenLaws(TERMS, fixed={"mass_kg": TRUTH["mass"]}, starts={"mass_kg": TRUTH["mass"], **near})
    drive = moving_drive(T, sea()[0], "water_velocity", "band_limited")
    active = np.array([DRIVEN_SLOT[name] for name in (*NAMES, "x0", "v0")])
    jacobian = driven_motion(theta_of(**TRUTH), active, drive, T, EXTENT, 40).x[:, 1:] / NOISE
    bound = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))[: len(NAMES)]
    away = []
    for seed in range(12):
        found = fit_driven([in_waves(seed)], known, windows=0).numbers
        away.append([(found[name] - TRUTH[slot]) / b for (slot, name), b in zip(NAMES.items(), bound, strict=True)])
    # 60 standardised errors; their rms is 1 +- 0.09 where the bound is reached
    assert np.sqrt(np.mean(np.square(away))) < 1.1
    assert np.max(np.abs(away)) < 4.0


@pytest.mark.parametrize(
    ("quantity", "hold"),
    [("water_velocity", "band_limited"), ("water_velocity", "first"), ("water_acceleration", "band_limited"),
     ("water_acceleration", "first")],
)  # fmt: skip
def test_either_record_of_the_water_gives_the_same_equation_from_no_start_values(quantity, hold):
    found = fit_driven([in_waves(1, quantity, hold=hold)], DrivenLaws(TERMS, fixed={"mass_kg": TRUTH["mass"]}))
    for slot, name in NAMES.items():
        # straight lines between 50 samples a second lose (w dt)^2 / 12, 1e-3 at 0.9 Hz
        assert found.numbers[name] == pytest.approx(TRUTH[slot], rel=0.02)
    assert found.rms["sea"] < 1.5 * NOISE


@pytest.mark.parametrize("known", [{NAMES["k1"]: TRUTH["k1"]}, {NAMES["wave"]: DISPLACED}])
def test_added_mass_is_found_where_the_mass_and_stiffness_or_displaced_mass_are_known(known):
    terms = (*TERMS, find_driven("added_mass"))
    found = fit_driven([in_waves(1)], DrivenLaws(terms, fixed={"mass_kg": DRY, **known}))
    wanted = {"added_mass.mass_kg": ADDED, NAMES["wave"]: DISPLACED, NAMES["k1"]: TRUTH["k1"]}
    for name, true in wanted.items():
        if name in known:
            continue
        error = np.sqrt(found.covariance[found.names.index(name), found.names.index(name)])
        assert abs(found.numbers[name] - true) < 4.0 * error < 0.1 * true
    other = in_waves(5, waves=8)
    away = free_run(other, found, 50) - other.outputs["displacement"]
    assert np.sqrt(np.mean(away[50:] ** 2)) < 1.5 * NOISE


def test_forces_are_per_mass_where_nothing_but_the_water_drives():
    found = fit_driven([in_waves(1)], DrivenLaws(TERMS))
    assert found.numbers["mass_kg"] == 1.0
    assert found.numbers[NAMES["k1"]] == pytest.approx(TRUTH["k1"] / TRUTH["mass"], rel=0.01)
    assert found.numbers[NAMES["wave"]] == pytest.approx(TRUTH["wave"] / TRUTH["mass"], rel=0.01)


def test_two_records_of_one_water_are_better_than_either():
    rng = np.random.default_rng(0)
    u, du = sea()
    seen, rate = u + 0.02 * rng.normal(size=SAMPLES), du + 0.1 + 0.05 * rng.normal(size=SAMPLES)
    one = one_velocity("r", T, seen, rate)
    assert np.std(one - u) < 0.4 * np.std(seen - u)
    assert np.std(np.gradient(one - u, T)) < 0.2 * np.std(np.gradient(seen - u, T))
    assert np.max(np.abs(one_velocity("r", T, u, du) - u)) < 1e-4


@pytest.mark.parametrize("factor", [-1.0, 2.0, 9.81])
def test_an_acceleration_that_is_not_the_velocitys_rate_is_refused(factor):
    with pytest.raises(RecordingError, match="trial r: water_acceleration is not the rate of water_velocity"):
        one_velocity("r", T, sea()[0], factor * sea()[1])


def test_laws_that_waves_cannot_move_are_refused():
    dry = tuple(find_driven(n) for n in ("stiffness", "viscous_damping"))
    with pytest.raises(IdentificationError, match="the water moves, and none of stiffness, viscous_damping feels it"):
        fit_driven([in_waves()], DrivenLaws(dry))
    with pytest.raises(IdentificationError, match="added mass beside motion of the water alone, with 1 forces known"):
        fit_driven([in_waves()], DrivenLaws((*TERMS, find_driven("added_mass")), fixed={"mass_kg": DRY}))
    with pytest.raises(ConfigError, match="'drag_exponent' goes with the velocity through water, and in waves only"):
        places((find_driven("drag_exponent"),), "water")
    with pytest.raises(ConfigError, match="'froude_krylov' goes with the acceleration of the water, and the input is"):
        places((find_driven("froude_krylov"),), "force")
