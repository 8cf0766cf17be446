"""Harmonic sets: steady motions against closed forms and a stiff integrator of others, fits at the bound, bad input."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import undertow
from undertow.equation.driven_laws import find_driven, places
from undertow.equation.driven_slots import DRIVEN_SLOT
from undertow.equation.input import MotionSize
from undertow.equation.steady_state import closed_orbit
from undertow.errors import ConfigError, IdentificationError, RecordingError, UndertowError
from undertow.methods.harmonic_set import harmonic_theta
from undertow.recording.propose import propose_mapping

FORCE = 1.0
DUFFING = {"stiffness": 50.0, "viscous_damping": 0.6, "cubic_stiffness": 400.0}
FREQUENCIES = np.linspace(0.55, 1.2, 27)
LAWS = ("stiffness", "viscous_damping", "cubic_stiffness", "coulomb_friction")
TRUTH = {"mass_kg": 2.0, "stiffness.k_N_per_m": 50.0, "viscous_damping.c_Ns_per_m": 0.6,
         "cubic_stiffness.N_per_m3": 400.0, "coulomb_friction.force_N": 0.1}  # fmt: skip
NOISE = 1e-3


def swept(sweep: str, law: dict | None = None, frequencies: np.ndarray = FREQUENCIES):
    return undertow.frequency_response(law or DUFFING, frequencies, force=FORCE, sweep=sweep, mass_kg=2.0)


def test_a_linear_body_has_the_textbooks_response():
    law = {"stiffness": 50.0, "viscous_damping": 0.8}
    table = swept("up", law).table
    w = 2.0 * np.pi * FREQUENCIES
    exact = FORCE / (50.0 - 2.0 * w**2 + 0.8j * w)
    assert table["amplitude"].to_numpy() == pytest.approx(np.abs(exact), rel=1e-6)
    assert table["phase_rad"].to_numpy() == pytest.approx(np.angle(exact), abs=1e-6)
    assert swept("down", law).table["amplitude"].to_numpy() == pytest.approx(np.abs(exact), rel=1e-6)


def test_a_fold_shows_its_upper_branch_upward_and_its_lower_branch_downward():
    up, down = (swept(way).table["amplitude"].to_numpy() for way in ("up", "down"))
    folded = up > 1.5 * down
    assert 2 <= np.count_nonzero(folded) <= 8
    assert np.all(np.diff(np.flatnonzero(folded)) == 1)  # one stretch of frequencies
    assert up[~folded] == pytest.approx(down[~folded], rel=1e-6)


@pytest.mark.parametrize("sweep", ["up", "down"])
def test_steady_motions_are_those_of_a_direct_integration(sweep):
    states = swept(sweep).states
    for state in (states[4], states[17], states[-1]):
        period = 2.0 * math.pi / state.rate

        def slope(t, y, w=state.rate):
            return [y[1], (FORCE * math.cos(w * t) - 50.0 * y[0] - 0.6 * y[1] - 400.0 * y[0] ** 3) / 2.0]

        # thirty periods on from there, by another integrator: still the same motion
        times = np.linspace(29.0 * period, 30.0 * period, 65)[:-1]
        far = solve_ivp(slope, (0.0, 30.0 * period), state.state, "DOP853", times, rtol=1e-10, atol=1e-12)
        cosine, sine = (2.0 / 64.0) * np.array([np.cos(state.rate * times), np.sin(state.rate * times)]) @ far.y[0]
        assert math.hypot(cosine - state.cosine, sine - state.sine) < 2e-5 * state.amplitude
        assert state.stable


def test_derivatives_of_a_steady_motion_are_those_of_finite_differences():
    unknowns = places([find_driven(law) for law in LAWS], "force")
    theta = harmonic_theta(TRUTH, unknowns)
    active = np.array([DRIVEN_SLOT[slot] for slot in ("mass", "k1", "c1", "k3", "fc")])
    extent = MotionSize(0.2, 1.0)

    def found(vector):
        return closed_orbit(vector, FORCE, 5.2, np.array([-0.1, 0.6]), extent, active)

    slopes = found(theta).slopes
    for i, slot in enumerate(active):
        step = 1e-4 * theta[slot]
        ends = []
        for sign in (1.0, -1.0):
            moved = theta.copy()
            moved[slot] += sign * step
            ends.append(np.array([found(moved).cosine, found(moved).sine]))
        assert slopes[:, i] == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=1e-4, abs=1e-9)


def test_a_body_whose_friction_exceeds_the_force_stays_where_it_is():
    stuck = undertow.frequency_response(
        {"stiffness": 50.0, "coulomb_friction": 2.0}, [0.5, 0.8], force=FORCE, mass_kg=2.0
    ).table
    assert np.all(stuck["amplitude"] < 1e-9)


BASE = 0.03
ON_BASE = {"stiffness": 100.0, "viscous_damping": 1.5, "quadratic_drag": 15.0}


@pytest.mark.parametrize("f", [0.6, 0.8, 1.1])
def test_a_body_on_a_moving_base_settles_where_a_direct_integration_in_the_earths_frame_does(f):
    w, period = 2.0 * math.pi * f, 1.0 / f

    def slope(t, y):  # spring and damper feel the difference of two motions, the water one alone
        base, moved = BASE * math.cos(w * t), -BASE * w * math.sin(w * t)
        return [y[1], (-100.0 * (y[0] - base) - 1.5 * (y[1] - moved) - 15.0 * y[1] * abs(y[1])) / 4.0]

    times = np.linspace(60.0 * period, 61.0 * period, 129)[:-1]
    x = solve_ivp(slope, (0.0, 61.0 * period), [0.0, 0.0], "DOP853", times, rtol=1e-10, atol=1e-12).y[0]
    cosine, sine = (2.0 / 128.0) * np.array([np.cos(w * times), np.sin(w * times)]) @ x
    drives = {"base_displacement": BASE, "base_acceleration": -BASE * w**2}
    for drive, size in drives.items():
        for frame, moved in (("absolute", 0.0), ("relative", BASE)):
            got = undertow.frequency_response(ON_BASE, [f], **{drive: size}, frame=frame, mass_kg=4.0).table
            assert got["amplitude"][0] == pytest.approx(math.hypot(cosine - moved, sine), rel=1e-6)
            assert got["phase_rad"][0] == pytest.approx(math.atan2(-sine, cosine - moved), abs=1e-6)


def test_numbers_of_a_body_on_a_moving_base_come_back_whatever_is_recorded_of_it():
    f = np.linspace(0.5, 1.2, 30)
    for frame in ("absolute", "relative"):
        made = undertow.frequency_response(ON_BASE, f, base_displacement=BASE, frame=frame, mass_kg=4.0).table
        points = (f, made["amplitude"], made["phase_rad"])
        known = {"base_displacement": BASE, "frame": frame, "equation": list(ON_BASE)}
        held = undertow.fit_response(*points, held={"mass_kg": 4.0}, **known)
        assert [held.numbers[name].value for name in held.numbers] == pytest.approx([4.0, 100.0, 1.5, 15.0], rel=1e-6)
        assert held.response.table["amplitude"].to_numpy() == pytest.approx(made["amplitude"].to_numpy(), rel=1e-6)
        per_mass = undertow.fit_response(*points, **known).numbers  # the motion says nothing of the size of forces
        assert [one.value for one in per_mass.values()] == pytest.approx([1.0, 25.0, 0.375, 3.75], rel=1e-6)


def measured(seed: int):
    """Both sweeps of Duffing's body with friction, noise on cosine and sine alike."""
    law = DUFFING | {"coulomb_friction": 0.1}
    rng = np.random.default_rng(seed)
    states = [s for way in ("up", "down") for s in swept(way, law).states]
    cosine = np.array([s.cosine for s in states]) + NOISE * rng.standard_normal(len(states))
    sine = np.array([s.sine for s in states]) + NOISE * rng.standard_normal(len(states))
    return np.tile(FREQUENCIES, 2), np.hypot(cosine, sine), np.arctan2(-sine, cosine)


def test_numbers_come_back_with_errors_at_the_cramer_rao_bound_from_no_start_values():
    away, left = [], []
    for seed in range(12):
        f, amplitude, phase = measured(seed)
        found = undertow.fit_response(f, amplitude, phase, force=FORCE, equation=LAWS, sigma=NOISE)
        # with the noise stated the printed error is the bound: the inverse of what the points hold of the numbers
        away.append([(found.numbers[name].value - value) / found.numbers[name].stderr for name, value in TRUTH.items()])
        left.append(found.rms)
    # 60 standardised errors; their rms is 1 +- 0.09 where the bound is reached
    assert 0.75 < np.sqrt(np.mean(np.square(away))) < 1.2
    assert np.max(np.abs(away)) < 4.0
    assert np.mean(left) == pytest.approx(NOISE, rel=0.1)
    assert "cubic_stiffness.N_per_m3 = " in repr(found)
    assert len(found.response.table) == 54


def test_what_is_held_stays_and_errors_without_sigma_come_from_what_is_left():
    f, amplitude, phase = measured(3)
    found = undertow.fit_response(
        f, amplitude, phase, force=np.full(f.size, FORCE), equation=LAWS, held={"mass_kg": 2.0}
    )
    assert (found.numbers["mass_kg"].value, found.numbers["mass_kg"].stderr) == (2.0, 0.0)
    stated = undertow.fit_response(
        f, amplitude, phase, force=FORCE, equation=LAWS, held={"mass_kg": 2.0}, sigma=np.full(f.size, NOISE)
    )
    for name in ("stiffness.k_N_per_m", "coulomb_friction.force_N"):
        assert found.numbers[name].stderr == pytest.approx(stated.numbers[name].stderr, rel=0.2)


def test_a_law_that_is_missing_shows_in_what_is_left():
    f, amplitude, phase = measured(5)
    with_all = undertow.fit_response(f, amplitude, phase, force=FORCE, equation=LAWS)
    without = undertow.fit_response(f, amplitude, phase, force=FORCE, equation=LAWS[:3])
    assert without.rms > 3.0 * with_all.rms


def test_a_number_that_ends_on_its_bound_is_said():
    f = np.linspace(0.5, 1.2, 20)
    w = 2.0 * np.pi * f
    exact = 1.0 / (50.0 - 2.0 * w**2 - 0.4j * w)  # energy is given to this body
    found = undertow.fit_response(f, np.abs(exact), np.angle(exact), force=1.0)
    assert found.numbers["viscous_damping.c_Ns_per_m"].value == pytest.approx(0.0, abs=1e-6)
    assert "on a bound: viscous_damping.c_Ns_per_m" in repr(found)


def test_a_response_can_be_drawn():
    axes = swept("up").plot()
    assert axes.get_xlabel() == "frequency (Hz)"
    assert len(axes.lines[0].get_xdata()) == FREQUENCIES.size


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"phase_rad": np.zeros(3)}, RecordingError, "54 amplitudes, 3 phases and 0 errors; give one of each"),
        ({"amplitude": np.zeros(54)}, RecordingError, "amplitudes from 0; leave such points out"),
        ({"force": 0.0}, RecordingError, "the force is 0 N at 54 points"),
        ({"equation": ("stiffness", "relaxation")}, ConfigError, "'relaxation' keeps a state from one period"),
        ({"held": {"stiffness": 4.0}}, ConfigError, "'stiffness' is no number of this equation; it has mass_kg, "),
        ({"held": {"mass_kg": "4"}}, ConfigError, "held says that mass_kg is '4'; give a finite number"),
        ({"held": TRUTH}, IdentificationError, "all 5 numbers .* are held, and nothing is left to be found; leave one"),
        ({"equation": "stiffness"}, ConfigError, "equation is the single 'stiffness'; give a list of names"),
        ({"sigma": -1.0}, UndertowError, "sigma: 1 of 1 errors are not above zero"),
    ],
)
def test_a_set_that_does_not_fit_together_is_refused_in_a_sentence(change, error, message):
    f, amplitude, phase = measured(0)
    usual = {"frequency_Hz": f, "amplitude": amplitude, "phase_rad": phase, "force": FORCE, "equation": LAWS}
    arguments = usual | change
    with pytest.raises(error, match=message):
        undertow.fit_response(**arguments)


def test_what_was_fitted_to_a_set_is_asked_for_its_response():
    f, amplitude, phase = measured(0)
    found = undertow.fit_response(f, amplitude, phase, force=FORCE, equation=LAWS)
    assert found.equation.mass_kg == found.numbers["mass_kg"].value
    again = undertow.frequency_response(found, FREQUENCIES[:6], force=FORCE).table
    law = dict(zip(LAWS, found.equation.coefficients, strict=True))
    by_numbers = undertow.frequency_response(law, FREQUENCIES[:6], force=FORCE, mass_kg=found.equation.mass_kg).table
    pd.testing.assert_frame_equal(again, by_numbers)


def test_more_unknowns_than_values_are_refused():
    f, amplitude, phase = (part[:2] for part in measured(0))
    with pytest.raises(IdentificationError, match=r"5 numbers are unknown .* and 2 points hold 4 measured values"):
        undertow.fit_response(f, amplitude, phase, force=FORCE, equation=LAWS)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"force": [1.0, 2.0]}, r"force has the shape \(2,\), frequency_Hz \(1,\); give one or as many"),
        ({"frequency_Hz": [0.5, -1.0]}, "frequency_Hz: 2 values, not all finite and above zero"),
        ({"force": 0.0}, "force: amplitudes must be finite and not zero"),
        ({"sweep": "sideways"}, "sweep is 'sideways'; it is 'up' or 'down'"),
        ({"base_displacement": 0.1}, "force, base_displacement is given; give exactly one"),
        ({"force": None}, "none is given; give exactly one"),
        ({"frame": "absolute"}, "frame is 'absolute'; on a base that moves it is 'relative' or 'absolute'"),
    ],
)
def test_a_response_that_cannot_be_asked_for_is_refused(arguments, message):
    with pytest.raises(UndertowError, match=message):
        undertow.frequency_response(DUFFING, **({"frequency_Hz": [0.5], "force": 1.0, "mass_kg": 2.0} | arguments))


def test_a_body_without_damping_settles_nowhere():
    with pytest.raises(IdentificationError, match="comes to no motion of the force's period within 240 periods"):
        undertow.frequency_response({"stiffness": 50.0}, [0.5], force=1.0, mass_kg=2.0)


def test_a_harmonic_set_is_no_recording_in_time():
    table = pd.DataFrame({"frequency_Hz": [0.5, 0.6], "force_N": [1.0, 1.0], "amplitude_mm": [3.0, 4.0]})
    with pytest.raises(RecordingError, match="'force_N', 'amplitude_mm' are amplitudes by frequency, a harmonic set"):
        propose_mapping(table)
    beside_time = table.assign(time_s=[0.0, 0.1], disp_mm=[1.0, 2.0])
    assert set(propose_mapping(beside_time).channels) >= {"displacement"}


def test_complex_amplitudes_are_refused_and_not_cut_to_their_real_part():
    table = swept("up").table
    complex_amplitude = table["amplitude"] * np.exp(1j * table["phase_rad"])
    with pytest.raises(RecordingError, match="amplitude holds complex numbers, and is real; give real part, absolute"):
        undertow.fit_response(FREQUENCIES, complex_amplitude, table["phase_rad"], force=FORCE)
    with pytest.raises(RecordingError, match="force holds complex numbers"):
        undertow.fit_response(FREQUENCIES, table["amplitude"], table["phase_rad"], force=1j)
