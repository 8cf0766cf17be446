"""How much driven trials differ: by a stated scatter, and as trials of the same input show it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.unit.test_driven_trials import NOISE, recorded
from undertow.campaign.driven.beside import sensor_noise
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_laws import find_driven
from undertow.likelihood.driven import DrivenLaws, drive_for
from undertow.methods.driven import fit_driven, motion_from
from undertow.methods.driven_repeatability import repeatability_by_repeats, repeatability_by_scatter, scattered

LAWS = DrivenLaws(tuple(find_driven(name) for name in ("stiffness", "viscous_damping")))


def test_a_body_that_follows_its_force_differs_as_its_spring_does():
    trial = recorded({"mass": 0.04, "k1": 100.0, "c1": 0.3}, noise=1e-6)
    fitted = fit_driven([trial], LAWS)
    assert scattered(fitted, {"k": 0.05, "mu": 0.1}) == {"stiffness.k_N_per_m": 0.05}
    # x = F / k: 95 % of normal draws are within 1.96 deviations; a quantile of 200 draws is known to 7 %
    assert repeatability_by_scatter(trial, fitted, {"k": 0.05}, 0.0, 0) == pytest.approx(1.96 * 0.05, rel=0.2)
    assert repeatability_by_scatter(trial, fitted, {"mu": 0.1}, 0.02, 0) == 0.02


def test_trials_of_the_same_input_show_what_they_differ_by():
    trial = recorded()
    x = trial.outputs["displacement"]
    again = DrivenTrial("again", trial.t, 1.01 * trial.u, {"displacement": 1.1 * x})
    other = DrivenTrial("other", trial.t, trial.u[::-1], {"displacement": x})
    seen = repeatability_by_repeats([trial, again, other])
    assert set(seen) == {"run", "again"}
    assert seen["run"] == pytest.approx(0.1 / np.sqrt(2.0), rel=0.01)  # the mean of x is not quite 0
    away = NOISE * np.random.default_rng(3).normal(size=x.size)
    noisy = DrivenTrial("noisy", trial.t, trial.u, {"displacement": x + away})
    assert repeatability_by_repeats([trial, noisy])["run"] == pytest.approx(NOISE / np.sqrt(2.0) / np.std(x), rel=0.05)


def test_a_fast_motion_is_not_taken_for_noise_of_the_sensor():
    slow = recorded(noise=1e-5)
    rng = np.random.default_rng(5)
    t = np.arange(3000) * 0.01
    u = 20.0 * np.convolve(rng.normal(size=t.size), np.hanning(7), "same")
    starts = {"mass_kg": 0.02, "stiffness.k_N_per_m": 100.0, "viscous_damping.c_Ns_per_m": 0.3}
    laws = DrivenLaws(LAWS.terms, starts=starts)
    still = DrivenTrial("fast", t, u, {"displacement": 1e-3 * rng.normal(size=t.size)})
    x = motion_from(still, laws, starts, {"x0": 0.0, "v0": 0.0}, drive_for(still))
    fast = DrivenTrial("fast", t, u, {"displacement": x + 1e-5 * rng.normal(size=t.size)})
    assert fast.noise()["displacement"] > 10e-5  # a dozen samples a cycle
    assert sensor_noise(fast, fit_driven([fast], laws)) == pytest.approx(1e-5, rel=0.1)
    terms = tuple(find_driven(name) for name in ("coulomb_friction", "quadratic_drag"))
    assert sensor_noise(slow, fit_driven([slow], DrivenLaws((*LAWS.terms, *terms)))) == pytest.approx(1e-5, rel=0.1)
