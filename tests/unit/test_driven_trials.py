"""Driven trials: holds of the input, what a trial is checked for, fits of synthetic truths."""

from __future__ import annotations

import numpy as np
import pytest

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.base_motion import moving_drive
from undertow.equation.driven import driven_motion
from undertow.equation.driven_kernel import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.driven_laws import find_driven, places
from undertow.equation.input import MotionSize, drive_of
from undertow.errors import ConfigError, IdentificationError, RecordingError, UndertowError
from undertow.likelihood.driven import DrivenLaws, against_base, driven_problem
from undertow.methods.driven import fit_driven, free_run
from undertow.methods.driven_order import must_not_be_swapped, power_given
from undertow.methods.driven_start import half_lengths, start_values

NOISE = 1e-4
TRUTH = {"mass": 4.0, "k1": 100.0, "c1": 3.0, "fc": 5.0, "q": 4.0}
NAMES = {
    "mass": "mass_kg", "k1": "stiffness.k_N_per_m", "c1": "viscous_damping.c_Ns_per_m",
    "fc": "coulomb_friction.force_N", "q": "quadratic_drag.drag_Ns2_per_m2",
}  # fmt: skip
TERMS = tuple(find_driven(n) for n in ("stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag"))


def recorded(truth=TRUTH, samples=3000, step=0.01, hold="first", seed=1, delay=0.0, swept=False, noise=NOISE):
    """A trial of a known body under a random or swept force, with white noise on its displacement."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) * step
    u = np.convolve(rng.normal(size=samples + 30), np.hanning(30), "same")[:samples] * 20.0
    if swept:
        u = 60.0 * np.sin(2.0 * np.pi * (0.2 * t + 0.5 * 1.4 / t[-1] * t**2))
    theta = np.zeros(N_DRIVEN)
    for name, value in {"gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0, "delay": delay, **truth}.items():
        theta[DRIVEN_SLOT[name]] = value
    x = driven_motion(theta, np.zeros(0, dtype=np.int64), drive_of(t, u, hold), t, MotionSize(), 60).x[:, 0]
    return DrivenTrial("run", t, u, {"displacement": x + noise * rng.normal(size=samples)}, hold=hold)


@pytest.mark.parametrize("swept", [False, True])
def test_eq15_under_a_measured_force_is_found_within_its_errors(swept):
    found = fit_driven([recorded(swept=swept)], DrivenLaws(TERMS))
    assert found.outcome == "ok"
    for (name, true), error in zip(TRUTH.items(), np.sqrt(np.diag(found.covariance)), strict=True):
        index = found.names.index(NAMES[name])
        error = np.sqrt(found.covariance[index, index])
        # four standard errors of noise alone, which are under a per cent of each number
        assert abs(found.values[index] - true) < 4.0 * error < 0.05 * true
    assert found.rms["run"] == pytest.approx(NOISE, rel=0.05)


def test_a_window_starts_where_its_record_does_and_at_rest_where_no_displacement_is_recorded():
    trial = recorded(samples=600)
    alone = DrivenTrial("run", trial.t, trial.u, {"acceleration": trial.u / 4.0})
    seen, unseen = (driven_problem([one], DrivenLaws(TERMS), windows=2).unknowns for one in (trial, alone))
    starts = {u.name: u.start for u in seen}
    x = trial.outputs["displacement"]
    assert (starts["x0_m[run:0]"], starts["x0_m[run:1]"]) == (x[0], x[300])
    assert starts["v0_m_per_s[run:1]"] == pytest.approx((x[302] - x[298]) / 0.04, rel=0.05)
    assert {u.start for u in unseen if u.name.startswith(("x0_", "v0_"))} == {0.0}


def test_a_delay_of_two_milliseconds_is_found():
    near = {NAMES[k]: 0.9 * v for k, v in TRUTH.items()}
    laws = DrivenLaws(TERMS, starts={"input_delay_s": 0.0, **near})
    found = fit_driven([recorded(delay=0.002, hold="band_limited")], laws)
    assert found.numbers["input_delay_s"] == pytest.approx(0.002, abs=1e-4)


def test_the_right_hold_leaves_noise_and_a_wrong_one_more():
    trial = recorded(hold="zero", step=0.03, samples=1500)
    wrong = DrivenTrial("run", trial.t, trial.u, trial.outputs, hold="first")
    assert fit_driven([trial], DrivenLaws(TERMS)).rms["run"] == pytest.approx(NOISE, rel=0.1)
    assert fit_driven([wrong], DrivenLaws(TERMS)).rms["run"] > 2.0 * NOISE


def test_a_free_run_from_start_samples_follows_a_record_nobody_fitted():
    found = fit_driven([recorded()], DrivenLaws(TERMS))
    other = recorded(seed=7)
    run = free_run(other, found, 50)
    assert np.sqrt(np.mean((run - other.outputs["displacement"])[50:] ** 2)) < 1.2 * NOISE


def test_a_hidden_oscillator_is_found_in_a_record_that_begins_in_the_middle_of_its_motion():
    truth = {"mass": 4.0, "k1": 100.0, "c1": 3.0, "hm1": 0.8, "hw1": 8.0, "hz1": 0.04}
    whole = recorded(truth, hold="first")
    names = ("stiffness", "viscous_damping", "hidden_resonator")
    held = {f"hidden_resonator.{name}": 0.0 for name in ("quadratic_damping_per_m", "cubic_stiffness_per_m2_s2")}
    near = {"natural_frequency_rad_per_s": 7.5, "damping_ratio": 0.05, "mass_kg": 0.7}
    starts = {"mass_kg": 4.2, "stiffness.k_N_per_m": 97.0, "viscous_damping.c_Ns_per_m": 2.8}
    starts |= {f"hidden_resonator.{name}": value for name, value in near.items()}
    found = fit_driven([whole.part(1000, 3000)], DrivenLaws(tuple(map(find_driven, names)), held, starts))
    assert found.rms["run"] == pytest.approx(NOISE, rel=0.05)
    assert found.numbers["hidden_resonator.mass_kg"] == pytest.approx(0.8, rel=1e-3)
    # from 50 samples: without the oscillator's own start the run misses 300 times the noise
    other = recorded(truth, seed=7).part(1500, 3000)
    assert np.sqrt(np.mean((free_run(other, found, 50) - other.outputs["displacement"])[50:] ** 2)) < 1.5 * NOISE


def test_a_body_without_a_spring_is_a_body():
    truth = {"mass": 95.0, "c1": 200.0, "fc": 20.0, "offset": -3.0}
    trial = recorded(truth, step=0.005, samples=4000)
    laws = DrivenLaws(tuple(find_driven(n) for n in ("viscous_damping", "coulomb_friction", "constant_force")))
    found = fit_driven([DrivenTrial("run", trial.t, trial.u, trial.outputs)], laws)
    assert found.numbers["mass_kg"] == pytest.approx(95.0, rel=0.02)
    assert found.numbers["constant_force.force_N"] == pytest.approx(-3.0, abs=0.1)


def test_a_fit_does_not_move_the_start_to_make_up_for_what_is_missing():
    trial = recorded({"mass": 95.0, "c1": 200.0, "cb": -60.0, "fc": 20.0}, step=0.005, samples=4000, noise=1e-5)
    names = ("viscous_damping", "coulomb_friction", "constant_force", "asymmetric_damping")
    laws = tuple(find_driven(n) for n in names)
    lacking, whole = (fit_driven([trial], DrivenLaws(some)) for some in (laws[:3], laws))
    assert "x0_m[run]" not in lacking.solution.problem.names
    run = free_run(trial, lacking, 50)
    assert np.sqrt(np.mean((run - trial.outputs["displacement"]) ** 2)) < 1.1 * lacking.rms["run"]
    assert "x0_m[run]" in whole.solution.problem.names
    assert whole.numbers["asymmetric_damping.c_Ns_per_m"] == pytest.approx(-60.0, rel=0.02)


def test_start_values_come_from_the_record_itself():
    found = start_values(recorded(), TERMS, 16)
    assert found["mass_kg"] == pytest.approx(4.0, rel=0.05)
    assert found["stiffness"] == pytest.approx(100.0, rel=0.02)
    with pytest.raises(IdentificationError, match="rows for 5 numbers"):
        start_values(recorded().part(0, 250), TERMS, 110)
    assert half_lengths(200) == [4, 8]


def exchanged(trial):
    """The trial with force and displacement in each other's columns."""
    return DrivenTrial("run", trial.t, trial.outputs["displacement"], {"displacement": trial.u})


LOOP = {"mass": 4.0, "k1": 100.0, "c1": 3.0, "bw_a": 50.0, "bw_g": 4.0}


@pytest.mark.parametrize(
    "more",
    [
        {}, {"swept": True}, {"truth": {"mass": 95.0, "c1": 200.0, "fc": 20.0}},
        {"truth": LOOP},  # a hysteresis: the force is no sum of the displacement and its rates
        {"truth": {"mass": 0.04, "k1": 100.0, "c1": 0.3}},  # follows its force without delay
        {"samples": 300}, {"noise": 1e-2}, {"delay": 0.02},
    ],
)  # fmt: skip
def test_swapped_columns_are_told_from_a_force_and_what_it_moves(more):
    trial = recorded(**more)
    must_not_be_swapped(trial)
    with pytest.raises(IdentificationError, match=r"trial run: the input follows the output: .* exchange them"):
        fit_driven([exchanged(trial)], DrivenLaws(TERMS))


@pytest.mark.parametrize("more", [{}, {"truth": LOOP}, {"delay": 0.2}, {"delay": 0.1, "swept": True}])
def test_a_turned_sign_or_a_delay_is_not_taken_for_swapped_columns(more):
    trial = recorded(**more)
    must_not_be_swapped(trial)
    must_not_be_swapped(DrivenTrial("run", trial.t, -trial.u, trial.outputs))


def test_a_force_gives_energy_and_exchanged_columns_take_it():
    trial = recorded()
    assert power_given(trial) > 3.0
    assert power_given(exchanged(trial)) < -3.0


def test_a_record_with_a_hole_is_refused():
    trial = recorded()
    keep = np.r_[0:500, 600:3000]
    with pytest.raises(RecordingError, match=r"no sample between 4\.99 s and 6 s, so that nobody knows the input"):
        DrivenTrial("run", trial.t[keep], trial.u[keep], {"displacement": trial.outputs["displacement"][keep]})


def test_an_input_turned_round_has_no_positive_mass():
    trial = recorded()
    swapped = DrivenTrial("run", trial.t, -trial.u, trial.outputs)
    with pytest.raises(IdentificationError, match="no test function gives a positive mass"):
        fit_driven([swapped], DrivenLaws(TERMS))


def test_holds_pass_through_their_samples():
    t = np.arange(200) * 0.01
    u = np.sin(2.0 * np.pi * 20.0 * t + 0.3)
    between = t[60:140] + 0.005
    exact = np.sin(2.0 * np.pi * 20.0 * between + 0.3)
    holds = ("zero", "first", "band_limited")
    errors = {hold: np.max(np.abs(drive_of(t, u, hold).at(between) - exact)) for hold in holds}
    # five samples a period: a straight line loses (w dt)^2 / 12, a fifth of it in the middle of the step
    assert errors["zero"] > 0.5 > errors["first"] > 0.15
    assert errors["band_limited"] < 2e-3
    for hold in errors:
        assert np.allclose(drive_of(t, u, hold).at(t[:-1] + 1e-12), u[:-1], atol=1e-7)


def test_inputs_that_are_none_are_refused():
    t = np.arange(300) * 0.01
    with pytest.raises(UndertowError, match="299 samples at 300 instants"):
        drive_of(t, t[1:])
    with pytest.raises(UndertowError, match="hold 'second' is none of zero, first, band_limited"):
        drive_of(t, t, "second")
    with pytest.raises(UndertowError, match="needs even steps within 1 %"):
        drive_of(t**1.1, t, "band_limited")
    moved = {"displacement": np.sin(t)}
    with pytest.raises(RecordingError, match="the input force stays at 2; an input that never moves"):
        DrivenTrial("r", t, np.full(300, 2.0), moved)
    with pytest.raises(RecordingError, match="force has 299 samples but time has 300"):
        DrivenTrial("r", t, t[1:], moved)
    with pytest.raises(RecordingError, match="nothing is recorded of the motion"):
        DrivenTrial("r", t, t, {})
    with pytest.raises(RecordingError, match="force has 1 values that are not finite"):
        DrivenTrial("r", t, np.where(t == 0.0, np.nan, t), moved)
    with pytest.raises(RecordingError, match="100 samples; a driven trial needs 200"):
        DrivenTrial("r", t[:100], t[:100], {"displacement": t[:100]})
    with pytest.raises(RecordingError, match="time must rise"):
        DrivenTrial("r", t[::-1], t, moved)


def test_a_moving_base_wants_frames_it_can_serve():
    t = np.arange(300) * 0.01
    y = np.sin(t)
    with pytest.raises(RecordingError, match=r"the base moves \(base_velocity\), and displacement has no frame"):
        DrivenTrial("r", t, y, {"displacement": y}, "base_velocity")
    with pytest.raises(RecordingError, match="displacement is absolute, but base_velocity does not say where"):
        DrivenTrial("r", t, y, {"displacement": y}, "base_velocity", frames={"displacement": "absolute"})
    with pytest.raises(UndertowError, match="base_displacement held 'first' between samples has no acceleration"):
        moving_drive(t, y, "base_displacement")
    with pytest.raises(UndertowError, match="base_velocity held 'zero' between samples"):
        moving_drive(t, y, "base_velocity", "zero")
    with pytest.raises(UndertowError, match="a force at 300 instants has no velocity"):
        drive_of(t, y).velocity_at(t)
    with pytest.raises(UndertowError, match="where the base is at 300 instants was not recorded"):
        moving_drive(t, y, "base_velocity").displacement_at(t)
    with pytest.raises(ConfigError, match="'drag_exponent' goes with the velocity through water"):
        places((find_driven("drag_exponent"),), "base")


def test_outputs_against_the_base_are_those_against_the_earth_less_the_base():
    t = np.arange(400) * 0.01
    y, dy, ddy = np.sin(3.0 * t), 3.0 * np.cos(3.0 * t), -9.0 * np.sin(3.0 * t)
    seen = {"displacement": 1.5 * y, "velocity": 1.5 * dy, "acceleration": 1.5 * ddy}
    frames = dict.fromkeys(seen, "absolute")
    trial = DrivenTrial("r", t, y, seen, "base_displacement", "band_limited", frames=frames)
    own, inner = against_base(trial), slice(40, -40)  # ends of a band-limited signal are known least
    for name, values in seen.items():
        assert np.allclose(own.outputs[name][inner], values[inner] / 3.0, rtol=0.0, atol=2e-3 * np.max(values))
    assert own.absolute == ()


def test_laws_of_driven_bodies_have_places():
    assert [p.name for p in places((find_driven("bouc_wen"),))][:2] == ["bouc_wen.alpha_N_per_m", "bouc_wen.loop"]
    with pytest.raises(ConfigError, match="'external_forcing' beside a measured input"):
        find_driven("external_forcing")
    with pytest.raises(ConfigError, match="number 2 has no place"):
        places((find_driven("stiffness"), find_driven("stiffness")))


def test_a_mass_of_nearly_nothing_is_refused_before_it_is_integrated_for_hours():
    theta = np.zeros(N_DRIVEN)
    for name, value in {"mass": 1e-9, "c1": 200.0, "gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0}.items():
        theta[DRIVEN_SLOT[name]] = value
    t = np.arange(5000) * 0.005
    with pytest.raises(IdentificationError, match=r"goes at .* rad/s at its fastest and would take .* steps a sample"):
        driven_motion(theta, np.zeros(0, dtype=np.int64), drive_of(t, np.sin(t)), t, MotionSize(), 12)
