"""Trials that differ by more than their errors: joint errors grow until they agree, else they stay."""

from __future__ import annotations

import math

import numpy as np
import pytest

import undertow
from undertow.campaign.run.differing import with_grown_errors
from undertow.likelihood.fit import Fit
from undertow.quantities import Estimate
from undertow.uncertainty.disagreement import ALIKE, OF_ONE_TRIAL, grown, grown_words

LAW = {"stiffness": 400.0, "viscous_damping": 2.0}


def alone(*values: float, stderr: float = 1.0) -> list[dict[str, Estimate]]:
    return [{"mass_kg": Estimate(value, stderr, unit="kg")} for value in values]


def test_trials_that_agree_leave_the_error_as_it_is():
    joint = {"mass_kg": Estimate(10.0, 0.5, 0.2, "kg")}
    assert grown(joint, alone(9.4, 10.2, 10.1, 10.3)) == (joint, ())
    assert grown_words(()) == ()


def test_the_error_of_trials_that_differ_is_that_of_a_mean_over_trials_that_differ():
    joint = {"mass_kg": Estimate(10.0, 0.05, 0.2, "kg", "output error")}
    values = np.array([6.0, 9.0, 10.0, 11.0, 14.0])
    after, found = grown(joint, alone(*values, stderr=0.1))
    expected = 1.296 * float(np.std(values, ddof=1)) / math.sqrt(5.0)  # Student's t at 4 over the normal quantile
    assert after["mass_kg"].stderr == pytest.approx(expected, rel=0.02)
    assert (after["mass_kg"].value, after["mass_kg"].systematic) == (10.0, 0.2)
    assert after["mass_kg"].source == "output error; trials differ"
    assert (found[0].freedom, found[0].grown) == (4, pytest.approx(after["mass_kg"].stderr / 0.05))
    assert found[0].p_value < ALIKE
    assert "in mass_kg: the standard errors" in grown_words(found)[0]


@pytest.mark.parametrize(
    "bad",
    [Estimate(99.0, math.nan), Estimate(99.0, 0.0), Estimate(99.0, 1.0, outcome="on its bound"), Estimate(math.nan)],
)
def test_an_estimate_without_an_error_or_on_a_bound_does_not_count(bad):
    joint = {"mass_kg": Estimate(10.0, 0.5, unit="kg")}
    assert grown(joint, [*alone(10.0, 10.1), {"mass_kg": bad}, {}])[1] == ()


def test_two_trials_that_differ_leave_little_that_is_known():
    joint = {"mass_kg": Estimate(10.0, 0.05, unit="kg")}
    after, _ = grown(joint, alone(9.0, 11.0, stderr=0.1))
    assert after["mass_kg"].stderr > 2.0  # six times the difference's own error of the mean, Student's t at 1


def test_means_over_single_fits_are_left_alone_and_joint_fits_are_not():
    joint = {"mass_kg": Estimate(10.0, 0.05, unit="kg")}
    both = zip("ab", alone(5.0, 15.0), strict=True)
    singles = {name: {"sindy": Fit("sindy", (name,), {}, one)} for name, one in both}
    fits = {"sindy": Fit("sindy", ("a", "b"), {}, joint), "decay": Fit("decay", ("a", "b"), {}, joint)}
    after = with_grown_errors(fits, singles)
    assert after["sindy"].parameters["mass_kg"].stderr > 1.0
    assert "mass_kg" in after["sindy"].notes[0]
    assert after["decay"] == fits["decay"]
    mean = Fit("sindy", ("a", "b"), {}, joint, notes=("mean over trials, each fitted alone",))
    assert with_grown_errors({"sindy": mean}, singles)["sindy"] == mean


def decays(*damping: float) -> list[undertow.Trials]:
    runs = [
        undertow.simulate(LAW | {"viscous_damping": c}, x0=0.05 + 0.02 * i, mass_kg=4.0, rate_hz=100.0, duration_s=6.0)
        for i, c in enumerate(damping)
    ]
    return [run.recorded(noise_m=1e-4, seed=i, name=f"r{i}") for i, run in enumerate(runs)]


def test_fit_says_that_trials_differ_and_its_interval_holds_all_of_them():
    found = undertow.fit(decays(1.7, 2.0, 2.3), list(LAW), mass_kg=4.0)
    c = found.parameters.loc["c_Ns_per_m"]
    assert c["low"] < 1.75 < 2.25 < c["high"]
    assert "trials differ" in c["note"]
    assert any("differ by more than their errors in c_Ns_per_m" in note for note in found.notes)


def test_fit_of_one_trial_says_that_its_intervals_are_of_this_trial():
    found = undertow.fit(decays(2.0), list(LAW), mass_kg=4.0)
    assert OF_ONE_TRIAL in found.notes
    assert OF_ONE_TRIAL in str(found)
