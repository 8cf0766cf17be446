"""Numbers of a driven equation by regression with the measured input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.driven.bodies import GIVEN, body, record
from tests.unit.test_driven_trials import recorded
from undertow.comparison.driven_suspects import STATIC
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven import driven_motion
from undertow.equation.driven_laws import find_driven
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.input import MotionSize, drive_of
from undertow.errors import IdentificationError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import fit_driven
from undertow.methods.driven_instrument import by_regression, regressed

GIVEN_LAWS = DrivenLaws(tuple(find_driven(name) for name in GIVEN["random"]))


def test_errors_of_a_regression_are_as_large_as_it_says():
    away = []
    for seed in range(12000, 12006):
        one = body("random", seed)
        trial = record(one)
        found = by_regression(trial, fit_driven([trial], GIVEN_LAWS))
        away += [(found[name].value - true) / found[name].stderr for name, true in one.numbers.items()]
    # 24 draws of a standard normal have an rms within 0.4 of 1; corners of the force between samples made it 4
    assert np.sqrt(np.mean(np.square(away))) < 1.4


def test_a_regression_that_cannot_be_made_says_why():
    trial = recorded()
    laws = DrivenLaws(tuple(find_driven(name) for name in ("stiffness", "viscous_damping")))
    fitted = fit_driven([trial], laws)
    still = DrivenTrial("let go", trial.t, 0.0 * trial.u, trial.outputs, free=True)
    with pytest.raises(IdentificationError, match="trial let go: nothing drives it"):
        by_regression(still, fitted)
    shaken = DrivenTrial("run", trial.t, trial.u, {"acceleration": trial.outputs["displacement"]})
    with pytest.raises(IdentificationError, match="acceleration alone is recorded"):
        by_regression(shaken, fitted)
    loop = replace(laws, terms=(*laws.terms, find_driven("bouc_wen")))
    with pytest.raises(IdentificationError, match="bouc_wen has a state of its own"):
        by_regression(trial, replace(fitted, laws=loop))
    many = replace(laws, terms=tuple(find_driven(name) for name in STATIC[1:10]))
    with pytest.raises(IdentificationError, match="10 numbers are not told apart by regression"):
        by_regression(trial.part(0, 200), replace(fitted, laws=many))


def test_test_functions_that_see_no_force_are_not_taken():
    rng = np.random.default_rng(8)
    t = np.arange(24576) / 750.0
    tones = np.fft.rfftfreq(t.size, 1.0 / 750.0)
    phases = np.exp(2j * np.pi * rng.random(tones.size))
    u = np.fft.irfft(np.where((tones > 5.0) & (tones < 150.0), phases, 0.0), t.size)
    u *= 50.0 / np.std(u)  # nothing below 5 Hz, where a hysteresis still lets the body wander
    loop = {"mass": 2.0, "k1": 5e4, "c1": 10.0, "bw_a": 5e4, "bw_g": 800.0, "bw_d": -1100.0, "bw_n": 1.0}
    theta = np.zeros(N_DRIVEN)
    for name, value in {"gain": 1.0, "bw_unit": 1.0, **loop}.items():
        theta[DRIVEN_SLOT[name]] = value
    x = driven_motion(theta, np.zeros(0, dtype=np.int64), drive_of(t, u, "first"), t, MotionSize(), 60).x[:, 0]
    trial = DrivenTrial("run", t, u, {"displacement": x + 5e-6 * rng.normal(size=t.size)})
    laws = DrivenLaws(tuple(find_driven(name) for name in ("stiffness", "viscous_damping")))
    fitted = fit_driven([trial], laws)
    found = by_regression(trial, fitted)
    surest = regressed(trial, fitted, laws.terms, trial.outputs)
    assert found["mass_kg"].value == pytest.approx(2.0, rel=0.4)
    assert 5e4 < found["stiffness.k_N_per_m"].value < 2e5
    assert surest["stiffness.k_N_per_m"].value < 1e4
