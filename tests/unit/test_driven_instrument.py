"""Numbers by an instrument, beside output error: carriages in closed loop, and records that have no use of one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.driven.bodies import GIVEN, body, record
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_laws import find_driven
from undertow.errors import IdentificationError, RecordingError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import fit_driven
from undertow.methods.driven_instrument import BesideInstrument, beside_instrument, motion_of_instrument
from undertow.methods.driven_start import start_values
from undertow.quantities import Estimate

SEED = 3000
LAWS = DrivenLaws(tuple(find_driven(name) for name in GIVEN["carriage"]))


@pytest.fixture(scope="module")
def calm():
    """A carriage in closed loop that nothing pushes, its trial and its fit."""
    one = body("carriage", SEED)
    trial = record(one)
    return one, trial, fit_driven([trial], LAWS)


def test_both_estimates_are_right_where_nothing_pushes(calm):
    one, trial, fitted = calm
    both = beside_instrument(trial, fitted)
    assert both.strength > 0.99
    for name, found in both.instrument.items():
        # four of its standard errors, which are under 1e-3 of each number
        assert abs(found.value - one.numbers[name]) < 4.0 * found.stderr < 4e-3 * abs(one.numbers[name])
    assert set(both.instrument) == set(fitted.names)
    assert both.sentence == ""


def test_an_unrecorded_push_biases_output_error_in_closed_loop_and_not_the_instrument():
    name = "viscous_damping.c_Ns_per_m"
    one = body("carriage", SEED)
    trial = record(one, 0.0, 10.0)
    both = beside_instrument(trial, fit_driven([trial], LAWS))
    truth = one.numbers[name]
    assert both.output_error[name].value > 1.5 * truth
    assert abs(both.instrument[name].value - truth) < 2.0 * both.instrument[name].stderr < 0.4 * truth


def test_numbers_that_are_far_apart_are_told():
    fit = {"mass_kg": Estimate(90.0, 1.0, unit="kg"), "drag": Estimate(5.0, 1.0, unit="N s^2/m^2")}
    other = {"mass_kg": Estimate(95.0, 1.5, unit="kg"), "drag": Estimate(6.0, 1.0, unit="N s^2/m^2")}
    both = BesideInstrument("run", fit, other, 0.99)
    assert both.apart["mass_kg"] == pytest.approx(5.0 / np.hypot(1.0, 1.5))
    assert "mass_kg is 90.0 ± 1.0 kg by output error and 95.0 ± 1.5 kg by the instrument, 2.8 standard errors" in (
        both.sentence
    )
    assert "drag" not in both.sentence


def test_what_is_held_is_not_estimated(calm):
    one, trial, _ = calm
    name = "coulomb_friction.force_N"
    held = replace(LAWS, fixed={name: one.numbers[name]})
    both = beside_instrument(trial, fit_driven([trial], held))
    assert name not in both.instrument
    mass = both.instrument["mass_kg"]
    assert abs(mass.value - one.numbers["mass_kg"]) < 4.0 * mass.stderr


def test_short_test_functions_take_no_place_for_an_acceleration(calm):
    one, trial, _ = calm
    found = start_values(trial, LAWS.terms, 8)
    # noise of 0.01 mm stays; with the sampled second derivative it was half of the mass
    assert found["mass_kg"] == pytest.approx(one.numbers["mass_kg"], rel=0.1)


def test_the_motion_of_an_instrument_is_the_instrument_delayed_and_scaled():
    t = np.arange(2000) * 0.005
    target = 3.0 * np.sin(t) + np.sin(2.3 * t)
    late = 0.5 * np.interp(t - 8 * 0.005, t, target) + 1.0
    trial = DrivenTrial("late", t, np.cos(t), {"displacement": late}, instrument=target)
    copy, strength = motion_of_instrument(trial)
    assert strength == pytest.approx(1.0, abs=1e-9)
    assert np.allclose(copy[8:], late[8:], atol=1e-9)


def test_an_instrument_that_says_too_little_is_refused(calm):
    _, trial, fitted = calm
    noise = np.random.default_rng(0).normal(size=trial.t.size)
    with pytest.raises(IdentificationError, match=r"the instrument explains .* % of the velocity's power, under 10 %"):
        beside_instrument(replace(trial, instrument=noise), fitted)
    with pytest.raises(IdentificationError, match=r"has no instrument; map channels\.instrument"):
        beside_instrument(replace(trial, instrument=None), fitted)
    with pytest.raises(IdentificationError, match=r"has no instrument; map channels\.instrument"):
        motion_of_instrument(replace(trial, instrument=None))


def test_records_and_laws_that_an_instrument_does_not_serve_are_refused(calm):
    _, trial, fitted = calm
    base = replace(trial, quantity="base_acceleration", frames={"displacement": "relative"})
    with pytest.raises(IdentificationError, match="an instrument serves a force and a displacement alone"):
        beside_instrument(base, fitted)
    more = replace(fitted, laws=replace(fitted.laws, terms=(*fitted.laws.terms, find_driven("bouc_wen"))))
    with pytest.raises(IdentificationError, match="bouc_wen has a state of its own"):
        beside_instrument(trial, more)
    with pytest.raises(IdentificationError, match="where the instrument moves, 4 numbers are not told apart"):
        beside_instrument(trial.part(0, 220), fitted)


def test_an_instrument_that_never_moves_or_has_another_length_is_no_trial(calm):
    _, trial, _ = calm
    with pytest.raises(RecordingError, match="the instrument stays at 0 and moves nothing"):
        replace(trial, instrument=np.zeros(trial.t.size))
    with pytest.raises(RecordingError, match="instrument has 3 samples but time has 5000"):
        replace(trial, instrument=np.arange(3.0))


def test_a_part_of_a_trial_keeps_its_part_of_the_instrument(calm):
    _, trial, _ = calm
    assert np.array_equal(trial.part(100, 900).instrument, trial.instrument[100:900])
