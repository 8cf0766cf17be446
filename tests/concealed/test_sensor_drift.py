"""A displacement sensor that drifts in any slow manner, in whole campaigns: named, taken out of the free run, and apart
from what the body does; and a hysteresis found from where a small one looks best."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.concealed.test_diagnosis import SPECIMEN, SPRINGS
from tests.concealed.test_hook import PERIOD, level_of, recording
from undertow.campaign.run.rig import standing_addends
from undertow.comparison import attempt, trying
from undertow.comparison.attempt import from_starts
from undertow.comparison.candidate import Candidate, doubt
from undertow.comparison.evidence import criterion
from undertow.comparison.joint import SLOWER, at_memory, build, fit_joint, fit_standing, free_run_error, its_drift
from undertow.comparison.level import Addend, Level, make_level
from undertow.comparison.score_test import GridPlace, Stands, peaks, places
from undertow.comparison.search import diagnose
from undertow.comparison.suspect import DRIFT, DRIFTS
from undertow.comparison.suspects import SUSPECTS, chosen
from undertow.discrepancy.validation import addition_parameters
from undertow.equation import registry
from undertow.likelihood.free_run import STEADY, OwnDrift, free_run
from undertow.likelihood.priors import DRIFT_SHARE
from undertow.likelihood.residuals import residuals

RIVALS = ("sensor_drift", "asymmetric_damping", "asymmetric_stiffness", "relaxation", "linear_damping")
RELEASES = (0.02, 0.035, 0.05)
SIZE = 0.0015
RUBBING = 0.1
"""Of the friction of other tests: ten cycles and more of each trial can be seen."""
FREE = {"q": 40.0, "fc": RUBBING * SPRINGS["long"][2] * SPECIMEN.normal_force_N}
SHAPES = {
    "a ramp that ends": lambda u: np.minimum(u / 0.4, 1.0),
    "a sensor that warms up": lambda u: 1.0 - np.exp(-4.0 * u),
    "there and half back": lambda u: np.sin(0.7 * math.pi * u),
}


def drifting(shape, sizes=(SIZE,) * 3, hidden=()) -> Level:
    """Three releases whose displacement sensor drifts from the release to the end of the record, so far in each."""
    found = []
    for i, (x0, size) in enumerate(zip(RELEASES, sizes, strict=True)):
        one = recording(x0, 40 + i, 0.0, hidden, slots=FREE)
        u = np.clip((one.time - 0.6) / (one.time[-1] - 0.6), 0.0, None)
        x = one.channels["displacement"] + size * shape(u)
        found.append(replace(one, channels={**one.channels, "displacement": x}))
    return level_of(found, RUBBING)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_a_drift_of_any_slow_shape_is_named_and_leaves_the_free_run(shape):
    level = drifting(shape)
    found = diagnose(level, chosen(RIVALS))
    assert found.best.names == ("sensor_drift",)
    (addend,) = found.best.fit.addends
    assert addend.degree > 1
    assert found.best.fit.misfit < 1.6 < 0.05 * found.null.fit.misfit
    assert free_run_error(level, found.best.fit) < 0.6 * free_run_error(level, found.null.fit)


@pytest.mark.parametrize("sizes", [(SIZE,) * 3, (SIZE, -0.7 * SIZE, 1.6 * SIZE)], ids=["alike", "each its own"])
def test_what_the_sensor_drifts_comes_back(sizes):
    level = drifting(SHAPES["a sensor that warms up"], sizes)
    fit = diagnose(level, chosen(RIVALS)).best.fit
    (addend,) = fit.addends
    assert bool(addend.centres) == (len(set(sizes)) == 1)
    for motion, size in zip(level.members[0].motions, sizes, strict=True):
        t = motion.windowed("t")
        moved = np.ptp(SHAPES["a sensor that warms up"](np.array([t[0], t[-1]]) / 11.4))
        assert fit.value(f"drift_m[{motion.name}]") == pytest.approx(size * moved, rel=0.05)
    if len(set(sizes)) == 1:
        told = addition_parameters(fit, "long")["sensor_drift"]
        assert told[0]["drift_m"].value == pytest.approx(SIZE, rel=0.1)


def test_a_drift_and_a_law_of_the_water_are_both_named():
    level = drifting(SHAPES["a ramp that ends"], hidden=((registry.find("linear_damping"), 300.0),))
    found = diagnose(level, chosen(RIVALS))
    assert set(found.best.names) == {"sensor_drift", "linear_damping"}


def test_the_same_with_no_drift_says_nothing_of_it():
    found = diagnose(drifting(SHAPES["a ramp that ends"], (0.0,) * 3), chosen(RIVALS))
    assert found.best.names == ()


def bent(level: Level, degree: int):
    return build(level, (Addend("sensor_drift", (), frees=DRIFT, degree=degree),))


def test_the_first_degree_is_how_far_the_sensor_went_and_all_are_wide():
    level = drifting(SHAPES["a ramp that ends"])
    trial = bent(level, 5).trials[0]
    slow = trial.slow
    assert slow.shape == (trial.t.size, 5)
    assert slow[-1, [0, 2, 4]] - slow[0, [0, 2, 4]] == pytest.approx([1.0, 0.0, 0.0])
    assert slow[-1, [1, 3]] == pytest.approx(slow[0, [1, 3]])
    assert np.all(np.abs(slow.mean(axis=0)) < 0.02)
    widths = {u.name: u.prior_std for u in bent(level, 3).unknowns if u.name.startswith(DRIFT)}
    assert len(widths) == 9
    largest = max(m.amplitude for m in level.members[0].motions)
    assert set(widths.values()) == {DRIFTS * DRIFT_SHARE * largest}


def test_residuals_of_a_drift_have_their_derivatives():
    problem = bent(drifting(SHAPES["a ramp that ends"]), 4)
    trial = problem.trials[1]
    values = np.array([u.start for u in problem.unknowns])
    mine = [i for i, u in enumerate(problem.unknowns) if u.name.startswith(DRIFT) and trial.name in u.name]
    values[mine] = 1e-3 * np.array([1.0, -0.5, 0.3, 0.2])
    r, jac, used = residuals(trial, values)
    for i in mine:
        moved = values.copy()
        moved[i] += 1e-4
        slope = (residuals(trial, moved)[0] - r) / 1e-4
        assert np.max(np.abs(slope)) > 100.0
        assert jac[:, used.tolist().index(i)] == pytest.approx(slope, abs=1e-6 * np.max(np.abs(slope)))


def test_a_short_decay_lets_a_drift_turn_back_less_often():
    level = drifting(SHAPES["a ramp that ends"])
    motion = level.members[0].motions[0]
    t = motion.windowed("t")
    short = replace(motion, inside=motion.inside & (motion.t < 4.3 * PERIOD))
    fit = SimpleNamespace(addends=(Addend("sensor_drift", (), frees=DRIFT, degree=6),))
    assert int(SLOWER * np.ptp(t) / PERIOD) == 5
    assert its_drift(fit, motion) == OwnDrift(DRIFTS * DRIFT_SHARE * motion.amplitude, 5)
    assert its_drift(fit, short).degree == 2
    assert its_drift(SimpleNamespace(addends=(Addend("x", ()),)), motion) is STEADY


def test_a_free_run_is_measured_against_what_the_sensor_saw_without_its_drift():
    level = drifting(SHAPES["a sensor that warms up"])
    member, fit = level.members[0], fit_standing(level)
    motion = member.motions[0]
    theta = fit.theta(0)
    plain = free_run(motion, theta, member.options.rest_offset_std)
    freed = free_run(motion, theta, member.options.rest_offset_std, drift=OwnDrift(0.01, 6))
    assert freed.nrmse < 0.3 * plain.nrmse
    away = plain.measured - freed.measured
    assert np.ptp(away) == pytest.approx(SIZE, rel=0.2)


def test_a_drift_that_dry_trials_show_is_each_trials_own_in_water():
    dry = Addend("sensor_drift", (), frees=DRIFT, degree=3, centres=(1e-3, 2e-4, 1e-4))
    gain = Addend("gain_error", (), frees="acceleration_gain", centres=(0.05,))
    judged = SimpleNamespace(addends=(dry, gain), labels=("long",), values={})
    assert standing_addends([judged]) == (replace(dry, centres=(), degree=6), gain)


def test_a_hysteresis_is_found_from_where_a_small_one_looks_best():
    """Its own starts end as friction or as nothing: with so many cycles a spring that is off by 2 % is out of step."""
    stiffness, displacement = 0.013 * SPRINGS["long"][0], 0.2 * RELEASES[-1]
    (suspect,) = (s for s in SUSPECTS if s.name == "hysteresis")
    laws = {"kb": stiffness, "fb": stiffness * displacement}
    level = level_of([recording(x0, 40 + i, 0.0, slots=laws | FREE) for i, x0 in enumerate(RELEASES)], RUBBING)
    null = Candidate((), fit_standing(level), 0.0)
    seen = peaks(places(level, Stands.of(null.fit), suspect))[:2]
    far = replace(suspect, starts=lambda s: (1e-3 * s.size,))
    without = from_starts(level, null, far, 0.0)
    found = from_starts(level, null, far, 0.0, looked=seen)
    assert found is not None
    assert without is None or found.fit.criterion < without.fit.criterion - 20.0
    assert found.fit.misfit < 1.2
    assert found.fit.value("hysteresis.stiffness_N_per_m") == pytest.approx(stiffness, rel=0.25)
    force = found.fit.value("hysteresis.yield_force_N")
    assert force == pytest.approx(stiffness * displacement, rel=0.25)
    assert diagnose(level, chosen(("hysteresis", "cubic_stiffness"))).best.names == ("hysteresis",)


def test_a_level_fits_the_same_with_a_drift_of_the_first_degree_as_before():
    level = drifting(SHAPES["a ramp that ends"])
    null = fit_standing(level)
    fit = fit_joint(level, (Addend("sensor_drift", (), frees=DRIFT),), null.memory, null.values, null.misfit, False)
    assert fit.misfit < null.misfit
    assert [n for n in fit.values if n.startswith(DRIFT)] == [n for n in null.values if n.startswith(DRIFT)]


def test_what_all_trials_have_in_common_costs_a_number_for_each_degree_and_their_own_one_each():
    level = drifting(SHAPES["a ramp that ends"])
    null = fit_standing(level)
    for centres, wanted in (((1e-3, 2e-4, 1e-4), "alike"), ((), "own")):
        addend = Addend("sensor_drift", (), frees=DRIFT, degree=3, centres=centres)
        fit = at_memory(fit_joint(level, (addend,), 5.0, null.values, 2.0, False), 5.0)
        cost = fit.criterion - criterion(fit.solution, fit.misfits, 5.0)
        each = {"alike": 3 * math.log(fit.solution.n_data / 5.0), "own": 9 * 2.0 * math.log(DRIFTS)}[wanted]
        assert cost == pytest.approx(each)


def test_degrees_that_a_short_decay_has_no_cycles_for_cost_nothing():
    level = drifting(SHAPES["a ramp that ends"])
    null = fit_standing(level)
    addend = Addend("sensor_drift", (), frees=DRIFT, degree=6, centres=(1e-3, 2e-4, 1e-4, 1e-5, 1e-5))
    fit = at_memory(fit_joint(level, (addend,), 5.0, null.values, 2.0, False), 5.0)
    assert max(addend.freed(fit.solution.problem.names).values()) == 5
    assert fit.criterion - criterion(fit.solution, fit.misfits, 5.0) == pytest.approx(
        5 * math.log(fit.solution.n_data / 5.0)
    )


def test_a_gain_is_one_in_all_trials_and_a_drift_may_be_each_trials_own():
    found = []
    for i, (x0, gain) in enumerate(zip(RELEASES, (1.2, 0.85, 1.1), strict=True)):
        one = recording(x0, 40 + i, 0.0, slots=FREE)
        a = gain * one.channels["acceleration"]
        found.append(replace(one, channels={**one.channels, "acceleration": a}))
    level = level_of(found, RUBBING)
    (suspect,) = (s for s in SUSPECTS if s.name == "gain_error")
    candidate = from_starts(level, Candidate((), fit_standing(level), 0.0), suspect, 0.0)
    assert len(candidate.fit.addends[-1].centres) == 1
    one = drifting(SHAPES["a ramp that ends"])
    alone = make_level([replace(one.members[0], motions=one.members[0].motions[:1])])
    (suspect,) = (s for s in SUSPECTS if s.name == "sensor_drift")
    candidate = from_starts(alone, Candidate((), fit_standing(alone), 0.0), suspect, 0.0)
    assert candidate.fit.addends[-1].centres == ()


def test_where_a_small_hysteresis_looks_best_a_fit_begins(monkeypatch):
    (suspect,) = (s for s in SUSPECTS if s.name == "hysteresis")
    level = drifting(SHAPES["a ramp that ends"], (0.0,) * 3)
    null = Candidate((), fit_standing(level), 0.0)
    (stiffness,) = suspect.look(level.scales, 0.007)
    place = GridPlace("hysteresis", (replace(stiffness, start=450.0),), 9.0)
    begins = []
    monkeypatch.setattr(attempt, "_with", lambda *given, **_: begins.append(given[2][0].additions))
    assert from_starts(level, null, replace(suspect, starts=lambda s: ()), 0.0, looked=[place]) is None
    ((first, force),) = begins
    assert (first.start, force.start) == pytest.approx((450.0, 450.0 * 0.007))
    assert first.name == "stiffness_N_per_m"


@pytest.mark.parametrize("far", [1e9, 0.0], ids=["where little is missing", "where much is missing"])
def test_a_search_begins_a_hysteresis_there_too(monkeypatch, far):
    laws = {"kb": 1500.0, "fb": 1500.0 * 0.01} | FREE
    level = level_of([recording(x0, 40 + i, 0.0, slots=laws) for i, x0 in enumerate(RELEASES)], RUBBING)
    offered = []
    monkeypatch.setattr(trying, "FINE", far)
    monkeypatch.setattr(trying, "WORTH", far)
    monkeypatch.setattr(trying, "from_starts", lambda *given, looked=(): offered.append((*given, looked)[-2:]))
    diagnose(level, chosen(("hysteresis",)))
    (_, looked), *_ = offered
    looked = looked or offered[0][0]
    assert [type(place) for place in looked] == [GridPlace] * len(looked)
    assert len(looked) >= 1


def test_of_sensors_a_free_run_shows_a_drift_alone():
    shown = {s.name: s.shown_by_free_run for s in SUSPECTS if s.origin == "instrument"}
    assert shown == {"time_shift": False, "gain_error": False, "sensor_drift": True}


def test_all_degrees_count_in_how_much_a_sensor_errs():
    level = drifting(SHAPES["a ramp that ends"])
    addend = Addend("sensor_drift", (), frees=DRIFT, degree=4)
    null = fit_standing(level)
    fit = fit_joint(level, (addend,), null.memory, null.values, null.misfit, False)
    usual = DRIFT_SHARE * RELEASES[-1]
    for line, rest, words in ((2.7, 1.5, ""), (1.0, 0.8, "no more than 3 times what sensors usually err")):
        values = fit.solution.values.copy()
        for name, degree in addend.freed(fit.solution.problem.names).items():
            values[fit.solution.problem.names.index(name)] = usual * (line if degree == 1 else rest)
        said = doubt(level, replace(fit, solution=replace(fit.solution, values=values)))
        assert words in said
        assert bool(said) == bool(words)
