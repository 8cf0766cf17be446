"""The measure of strength: calibrated on campaigns with nothing missing, right in size where something is."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2, ncx2

from experiments.blind_challenge import strength as measure
from experiments.blind_challenge.effects import kind
from experiments.blind_challenge.laboratory import noisy
from experiments.blind_challenge.rigs import Needs, Sensor, draw_rig, factors
from experiments.blind_challenge.scene import Change, Scene, move, read

REPLICAS = 30
KEYS = ("hidden_resonator", "linear_damping")  # one that noise hides, one that scatter hides


@pytest.fixture(scope="module", params=KEYS)
def campaign(request: pytest.FixtureRequest) -> dict:
    """A laboratory with few short trials, its linearisation and an effect of strength 3."""
    law = kind(request.param)
    rng = np.random.default_rng(11)
    needs = Needs(trials=(4, 4), springs=(1,), levels=(1,), coordinate="translation", quiet=True)
    rig = replace(draw_rig(rng, needs, "many"), scatter=(0.006, 0.1, 0.06), scatter_shape="normal", periods=9.0)
    views = [measure.view(rig, trial) for trial in rig.trials]
    shape = law.draw(rng, rig)
    white, _ = measure.effect_response(rig, views, lambda s, d: law.applied(shape, d, s), 1.0, True)
    linear = measure.Linear(rig, views, random=True, plain=False)
    factor = 3.0 / math.sqrt(linear.inner(white, white))
    return {
        "rig": rig,
        "views": views,
        "effect": [factor * r for r in white],
        "numbers": law.numbers(shape, 1.0, views[-1].scene),
        "dose": factor,
        "change": lambda scene, dose: law.applied(shape, dose, scene),
    }


def scores(campaign: dict, dose: float, rng: np.random.Generator) -> list[float]:
    """The best test's score on simulated trials with scatter and noise, linear about every trial's own k, c, mu."""
    out = []
    for _ in range(REPLICAS):
        trials = tuple(
            replace(t, factors=factors(rng, campaign["rig"].scatter, "normal")) for t in campaign["rig"].trials
        )
        rig = replace(campaign["rig"], trials=trials)
        views = [measure.view(rig, trial, own=True) for trial in trials]
        effect, _ = measure.effect_response(rig, views, campaign["change"], campaign["dose"], True)
        linear = measure.Linear(rig, views, random=True, plain=False)
        apart = np.zeros(linear.prior.size)
        residuals = []
        for j, (v, places) in enumerate(zip(views, linear.places, strict=True)):
            for (name, _, trial), place in places.items():
                if trial == j and name in ("k", "c", "mu"):
                    apart[place] = v.scene.trial.factors[("k", "c", "mu").index(name)] - 1.0
            change = campaign["change"](v.scene, dose)
            perfect = read(v.scene, change, move(v.scene, change, v.samples), 0)
            real = {s.channel: noisy(rng, s, perfect[s.channel]) for s in rig.sensors}
            residuals.append(measure.whiten(rig, real) - v.base)
        out.append(linear.score(effect, residuals, apart))
    return out


@pytest.mark.slow
def test_without_an_effect_the_score_of_the_best_test_is_standard_normal(campaign: dict) -> None:
    found = scores(campaign, 0.0, np.random.default_rng(1))
    assert abs(np.mean(found)) < 3.3 / math.sqrt(REPLICAS)  # 3.3 standard errors
    low, high = chi2.ppf([0.001, 0.999], REPLICAS - 1) / (REPLICAS - 1)
    assert low < np.var(found, ddof=1) < high


@pytest.mark.slow
def test_an_effect_of_strength_three_moves_the_score_by_three(campaign: dict) -> None:
    found = scores(campaign, campaign["dose"], np.random.default_rng(2))
    assert np.mean(found) == pytest.approx(3.0, abs=3.3 / math.sqrt(REPLICAS))


def test_what_the_equation_can_take_up_itself_has_no_strength(campaign: dict) -> None:
    def stiffer(scene: Scene, dose: float) -> Change:
        return Change(scene.body.changed(stiffness=scene.body.stiffness * (1.0 + 1e-3 * dose)))

    rig = campaign["rig"]
    found = measure.strength_of(rig, campaign["views"], stiffer, 1.0, True)
    raw = sum(float(r @ r) for r in measure.responses(rig, campaign["views"], lambda s: stiffer(s, 1.0))[0])
    prior = 1e-3**2 / 0.01**2 if {"stiffness", "mass"} <= rig.knows else 0.0
    assert found.statistic < 1e-4 * raw + 2.0 * prior
    assert found.leftover < 1e-5


def test_statistic_goes_with_the_square_of_the_dose_and_size_with_the_dose(campaign: dict) -> None:
    def change(scene: Scene, dose: float) -> Change:
        return campaign["change"](scene, dose)

    one, ten = (measure.strength_of(campaign["rig"], campaign["views"], change, d, True) for d in (0.1, 1.0))
    assert ten.statistic == pytest.approx(100.0 * one.statistic, rel=0.02)
    assert ten.size == pytest.approx(10.0 * one.size, rel=0.02)
    assert ten.repeatability == one.repeatability


@pytest.mark.parametrize("unknowns", [1, 3, 12])
def test_half_power_is_where_every_second_test_is_passed(unknowns: int) -> None:
    at = measure.half_power(unknowns)
    assert measure.best_power(at, unknowns) == pytest.approx(0.5, abs=1e-9)
    assert measure.best_power(0.0, unknowns) == pytest.approx(0.01, abs=1e-6)
    draws = ncx2.rvs(unknowns, at, size=4000, random_state=3)
    assert np.mean(draws > chi2.isf(0.01, unknowns)) == pytest.approx(0.5, abs=0.03)


def test_correlated_noise_is_whitened_to_its_variance() -> None:
    sensor = Sensor("displacement", 2.0, 0.7, 0.0, "m", 1.0, "ch0")
    line = noisy(np.random.default_rng(0), sensor, np.zeros(20000))
    assert np.std(line) == pytest.approx(2.0, rel=0.03)

    class Lab:
        sensors = (sensor,)

    white = measure.whiten(Lab, {"displacement": line})  # type: ignore[arg-type]
    assert np.std(white) == pytest.approx(1.0, rel=0.02)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.03


def test_scatter_of_the_damping_hides_more_damping_and_not_a_resonator(campaign: dict) -> None:
    found = []
    for scatter in (0.01, 0.3):
        rig = replace(campaign["rig"], scatter=(0.006, scatter, 0.06))
        linear = measure.Linear(rig, campaign["views"], random=True, plain=False)
        found.append(linear.inner(campaign["effect"], campaign["effect"]))
    ratio = found[0] / found[1]
    assert ratio > 3.0 if "c_Ns_per_m" in campaign["numbers"] else ratio < 1.5


def test_an_effect_that_makes_motions_run_away_is_without_limit_and_its_small_doses_are_not(campaign: dict) -> None:
    def mad(scene: Scene, dose: float) -> Change:  # negative damping
        body = scene.body.changed(damping=-1e4 * dose * scene.body.damping, drag=-scene.body.drag * dose)
        return Change(body if dose > 0.5 else scene.body.changed(damping=scene.body.damping * (1.0 - dose)))

    rig, views = campaign["rig"], campaign["views"]
    with np.errstate(all="ignore"):
        assert measure.strength_of(rig, views, mad, 1.0, False).statistic == math.inf
        assert math.isfinite(measure.strength_of(rig, views, mad, 1.0, True).statistic)
