"""Decays of a body beside its driven records: one equation, and more known of it than from either."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import undertow
from experiments.driven.bodies import GIVEN, SPRUNG_NOISE_M, Body, body, record
from undertow.comparison.driven_search import discover_driven
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven import driven_motion
from undertow.equation.driven_laws import find_driven
from undertow.equation.input import MotionSize, drive_of
from undertow.errors import IdentificationError, RecordingError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import fit_driven
from undertow.methods.driven_shares import shares_of

STEP_S = 0.01
NOTHING = np.zeros(0, dtype=np.int64)
LAWS = DrivenLaws(tuple(find_driven(name) for name in GIVEN["random"]))


def decay(one: Body, seed: int, x0_m: float = 0.3, samples: int = 800) -> DrivenTrial:
    """The body let go at ``x0_m``."""
    t = np.arange(samples) * STEP_S
    drive = drive_of(t, np.zeros(samples), "first")
    x = driven_motion(one.theta((x0_m, 0.0, 0.0)), NOTHING, drive, t, MotionSize(x0_m, 1.0), 60).x[:, 0]
    x = x + SPRUNG_NOISE_M * np.random.default_rng(seed).standard_normal(samples)
    return DrivenTrial(f"decay {seed}", t, np.zeros(samples), {"displacement": x}, free=True)


def errors(fit) -> dict[str, float]:
    return dict(zip(fit.names, np.sqrt(np.diag(fit.covariance)), strict=True))


def test_one_equation_of_both_is_the_truth_and_narrower_than_of_either():
    z, ratios, narrower = [], [], []
    for seed in range(10):
        one = body("random", 9100 + seed)
        shaken, free = record(one).part(0, 3000), decay(one, seed)
        laws = replace(LAWS, fixed={"mass_kg": one.numbers["mass_kg"]})
        both, alone = fit_driven([shaken, free], laws), fit_driven([shaken], laws)
        said = shares_of([shaken, free], both)
        for name, error in errors(both).items():
            z.append((both.numbers[name] - one.numbers[name]) / error)
            narrower.append(error / errors(alone)[name])  # both are widened by what their residuals look like
            assert said[name].together == pytest.approx(error)
            assert error < min(said[name].driven, said[name].decays)
            ratios.append(said[name].driven / errors(alone)[name])
    assert np.median(narrower) < 0.97
    assert np.max(narrower) < 1.2
    assert np.sqrt(np.mean(np.square(z))) == pytest.approx(1.0, abs=0.35)
    assert np.max(np.abs(z)) < 4.0
    assert np.median(ratios) == pytest.approx(1.0, abs=0.1)  # what driven records tell, fitted alone or as a part


def test_a_decay_tells_the_gain_of_an_input_in_volts():
    one = body("random", 9200)
    shaken, free = record(one).part(0, 3000), decay(one, 1)
    volts = replace(shaken, u=shaken.u / 7.3)
    known = {"mass_kg": one.numbers["mass_kg"]}
    starts = {name: 0.8 * value for name, value in one.numbers.items() if name != "mass_kg"} | {"input_gain": 5.0}
    found = fit_driven([volts, free], replace(LAWS, fixed=known, starts=starts | known))
    assert found.numbers["input_gain"] == pytest.approx(7.3, abs=4.0 * errors(found)["input_gain"])
    assert shares_of([volts, free], found)["input_gain"].decays == np.inf
    assert np.isfinite(shares_of([volts, free], found)["stiffness.k_N_per_m"].decays)


def test_what_is_missing_is_found_with_decays_beside():
    one = body("random", 9301, "cubic_stiffness")
    found = discover_driven([decay(one, 2), record(one)], LAWS, ["cubic_stiffness", "quadratic_drag"])
    assert found.added == ("cubic_stiffness",)
    assert len(found.augmented.rms) == 2
    whole = body("random", 9302)
    assert discover_driven([decay(whole, 3), record(whole)], LAWS, ["cubic_stiffness"]).added == ()


def test_lists_of_records_are_one_body_with_none_as_the_input_of_a_decay():
    one = body("random", 9400)
    shaken, free = record(one).part(0, 2500), decay(one, 4)
    x, u = [shaken.outputs["displacement"], free.outputs["displacement"]], [shaken.u, None]
    found = undertow.fit_driven(x, t=[shaken.t, STEP_S], u=u, equation=GIVEN["random"])
    assert found.trial.name == "x0"
    for name, estimate in found.numbers.items():
        assert abs(estimate.value - one.numbers[name]) < 4.0 * estimate.stderr
    assert set(found.told) == set(found.numbers)
    alone = undertow.fit_driven(x[0], t=shaken.t, u=shaken.u, equation=GIVEN["random"])
    assert alone.told == {}
    discovered = undertow.Discover(terms=["cubic_stiffness"], known=GIVEN["random"]).fit(x, t=[shaken.t, STEP_S], u=u)
    assert discovered.driven_.added == ()
    assert len(discovered.driven_.baseline.rms) == 2


def test_what_is_no_decay_and_lists_that_do_not_fit_are_refused():
    one = body("random", 9500)
    free = decay(one, 5)
    with pytest.raises(IdentificationError, match="nothing drives any of 1 trials: decays alone are fitted without"):
        fit_driven([free], LAWS)
    with pytest.raises(RecordingError, match="its input force is up to 2 in a decay, which nothing drives"):
        replace(free, u=np.full(free.t.size, 2.0))
    x = free.outputs["displacement"]
    with pytest.raises(RecordingError, match="x has 2 records, t 2 and u 1; give one of each, None as u of a decay"):
        undertow.fit_driven([x, x], t=STEP_S, u=[None])
    with pytest.raises(RecordingError, match="an instrument is a signal beside one record, and x has 2"):
        undertow.fit_driven([x, x], t=STEP_S, u=[x, None], instrument=x)
