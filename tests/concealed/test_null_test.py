"""A level beside replicas of itself in which nothing is missing: what stands out, what would be seen, what can hide."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from tests.concealed.test_diagnosis import SHORT, member
from tests.concealed.test_small_effects import found, stands
from undertow.comparison import detectable as detectable_module
from undertow.comparison import null_test as null_module
from undertow.comparison import replicas as replicas_module
from undertow.comparison.attempt import from_places
from undertow.comparison.candidate import Candidate
from undertow.comparison.detectable import Detectable, _first_number
from undertow.comparison.joint import JointFit, free_run_error, its_own, missed_share
from undertow.comparison.level import Addend, Level, make_level
from undertow.comparison.null_test import (
    LEAST_P,
    SIGNIFICANT,
    NullTest,
    SuspectTest,
    _fitted_gain,
    _least,
    _log_weight,
    _looked_at,
    _slightly_wrong,
    null_test,
)
from undertow.comparison.replicas import (
    LeftBy,
    _above_noise,
    _rate,
    _rises,
    _scatter_factors,
    _wanders,
    at_noise_of,
    believed_widths,
    is_of_instrument,
    left_by,
    not_slow,
    replicas,
    spectrum_of,
    surely_wrong,
    wanders_as,
    within_reason,
)
from undertow.comparison.score_stack import Stack
from undertow.comparison.score_test import GridPlace, Stands, peaks, places, renumbered
from undertow.comparison.search import diagnose
from undertow.comparison.sizes import Sizes
from undertow.comparison.suspects import SUSPECTS
from undertow.comparison.tail import Tail, wilks
from undertow.conditioning.condition import condition
from undertow.discrepancy.sentence import changing_words
from undertow.discrepancy.validation import addition_parameters, shared_run
from undertow.equation import registry
from undertow.likelihood.problem import Problem, Unknown

LOOKED_FOR = ("linear_damping", "cubic_stiffness", "cubic_damping", "hidden_resonator", "external_forcing")


def beside_its_null(*hidden: object, seed: int = 2000) -> NullTest:
    """The test of one level with something hidden, for a few suspects."""
    level = make_level([member("short", SHORT, seed, tuple(hidden))])
    fit = stands(level)
    suspects = [found(name, "one for all springs" if name == "linear_damping" else "") for name in LOOKED_FOR]
    return null_test(level, suspects, fit, (Candidate((), fit, 0.0),))


@pytest.mark.parametrize(
    ("p_value", "room", "passes"),
    [(0.11, 2e7, [1000]), (0.09, 2e7, [1000, 8000]), (0.0011, 2e7, [1000, 8000]), (0.0009, 2e7, [1000]),
     (0.09, 1.0, [400, 3200])],
)  # fmt: skip
def test_a_p_value_near_its_limit_of_one_in_a_hundred_is_worked_out_with_more_replicas(p_value, room, passes):
    level, fit = quiet()
    asked, scored, ranked = [], null_module._scored, null_module._ranked
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(null_module, "_scored", lambda *given: (asked.append(given[-1]), scored(*given[:-1], 100))[1])
        patch.setattr(null_module, "ROOM", room)
        patch.setattr(null_module, "_ranked", lambda *given: replace(ranked(*given), p_value=p_value))
        null_test(level, [found("cubic_stiffness")], fit, ())
    assert asked == passes


def test_a_p_value_near_its_limit_hardly_depends_on_what_is_drawn():
    level = make_level([member("short", SHORT, 2000, ((registry.find("cubic_stiffness"), 3.0e5),))])
    fit, laws = stands(level), [found(name) for name in ("cubic_stiffness", "cubic_damping")]
    real, logs = np.random.default_rng, {}
    for closer in (1, 16):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(null_module, "CLOSER", closer)
            patch.setattr(null_module, "DRAWS", 150)
            logs[closer] = []
            for seed in range(8):
                patch.setattr(null_module.np.random, "default_rng", lambda _, seed=seed: real(seed))
                logs[closer].append(math.log(null_test(level, laws, fit, ()).p_value))
    assert np.mean(logs[16]) == pytest.approx(math.log(SIGNIFICANT), abs=0.7)
    assert np.std(logs[16]) < 0.7 * np.std(logs[1])


def test_a_suspect_that_no_place_shows_is_passed_over():
    level, fit = quiet()
    laws = [found(name) for name in ("cubic_stiffness", "cubic_damping")]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Stack, "shows", lambda self, place, at: place.label == "cubic_stiffness")
        assert [test.name for test in null_test(level, laws, fit, ()).tests] == ["cubic_stiffness"]


INSTRUMENTS = ("time_shift", "gain_error", "sensor_drift", "imperfect_release")


def test_suspects_of_which_replicas_show_what_instruments_are_believed_to_do_hardly_count():
    level, fit = quiet()
    seen = []
    with pytest.MonkeyPatch.context() as patch:
        ranked = null_module._ranked
        patch.setattr(null_module, "_ranked", lambda scored, *rest: (seen.extend(scored), ranked(scored, *rest))[1])
        laws = [found(name) for name in ("cubic_stiffness", "cubic_damping", "stribeck_friction")]
        alone = null_test(level, laws, fit, ())
        seen.clear()
        beside = null_test(level, [*laws, *(found(name) for name in INSTRUMENTS)], fit, ())
    share = {s.place.label: s.of_instruments for s in seen}
    assert all(share[s.label] < 0.2 for s in laws)
    assert all(share[name] > 0.5 for name in INSTRUMENTS)
    assert _log_weight([s for s in seen if s.place.label == "time_shift"]) < math.log(0.3)
    assert _log_weight(()) == 0.0
    assert beside.p_value == pytest.approx(alone.p_value, rel=0.15)  # seven suspects that counted alike would be 2.3
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(null_module, "LEAST_WEIGHT", 1.0)
        assert null_test(level, [*laws, *(found(n) for n in INSTRUMENTS)], fit, ()).p_value > 1.2 * alone.p_value


@cache
def calibrated(gain: float) -> tuple[Level, JointFit]:
    """Eight trials with nothing missing whose accelerometer reads that many times too much in all of them."""
    whole = member("short", np.linspace(0.01, 0.03, 8), 2300)
    motions = tuple(
        condition(replace(m.recording, channels={
            **m.recording.channels, "acceleration": gain * m.recording.channels["acceleration"],
        }))
        for m in whole.motions
    )  # fmt: skip
    level = make_level([replace(whole, motions=motions)])
    return level, stands(level)


@pytest.mark.parametrize(("gain", "stands_out"), [(1.012, False), (1.04, True)])
def test_a_calibration_within_what_sensors_err_by_does_not_stand_out_though_all_trials_have_it(gain, stands_out):
    """1.2 % in one trial is two and a half times what a calibration is believed to be off by, and so it is in eight."""
    level, fit = calibrated(gain)
    laws = [found(name) for name in ("gain_error", "cubic_stiffness", "stribeck_friction")]
    assert null_test(level, laws, fit, ()).significant == stands_out
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(replicas_module, "OF_ONE_SENSOR", ())
        assert null_test(level, laws, fit, ()).significant  # as if each trial had a sensor of its own


def test_half_of_the_replicas_have_a_sensor_that_errs_alike_in_all_trials():
    level, fit = calibrated(1.0)
    unknowns = fit.solution.problem.unknowns
    mine = [i for i, u in enumerate(unknowns) if u.name.startswith("acceleration_gain[")]
    width = believed_widths(level, fit.solution)[mine]

    def drawn(kinds: tuple[str, ...]) -> np.ndarray:
        """The trials' gains in every replica, over what is believed of them, as their recordings show them."""
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(replicas_module, "OF_ONE_SENSOR", kinds)
            patch.setattr(replicas_module, "_drawn", lambda power, samples, draws, rng: np.zeros((samples, draws)))
            patch.setattr(replicas_module, "believed_widths", lambda *_: np.where(
                np.isin(np.arange(len(unknowns)), mine), believed_widths(level, fit.solution), 0.0))
            residuals = replicas(level, fit.solution, fit.solution.residuals, 2000, np.random.default_rng(3))
        solution, found = fit.solution, []
        for i, r, jac, used in zip(mine, residuals, solution.jacobians, solution.used, strict=True):
            column = jac[:, list(used).index(i)]
            found.append(column @ r / (column @ column))
        return np.array(found) / width[:, None]

    own, alike = drawn(()), drawn(replicas_module.OF_ONE_SENSOR)
    assert np.std(own, axis=1) == pytest.approx(1.0, abs=0.1)
    assert np.std(alike, axis=1) == pytest.approx(1.0, abs=0.1)  # of one trial nothing is seen of it
    assert not np.any(np.ptp(own, axis=0) < 1e-6)
    assert np.mean(np.ptp(alike, axis=0) < 1e-6) == pytest.approx(0.5, abs=0.05)


def test_instruments_within_belief_are_of_single_trials_alone():
    _, fit = quiet()
    kinds = {u.name.partition("[")[0] for u in fit.solution.problem.unknowns if is_of_instrument(u)}
    assert {"shift_s", "rest_m", "drift_m", "acceleration_gain"} <= kinds
    assert not kinds & {"k", "c", "mu", "x0_m", "k_mean@short"}


def test_a_level_with_nothing_missing_is_like_its_replicas():
    null = beside_its_null()
    assert null.p_value > 0.05
    assert not null.significant
    assert null.scores is not None
    beyond = null.scores.edges[:-1] >= null.scores.own
    assert sum(n for n, b in zip(null.scores.counts, beyond, strict=True) if b) > 0.02 * sum(null.scores.counts)
    assert null.scores.own < null.scores.limit
    assert null.upper_bound < null.smallest  # nothing that counts could hide
    assert "external_forcing" not in {t.label for t in null.shared}  # a force of its own in every trial


def test_damping_at_once_and_a_half_of_what_is_seen_stands_out_and_at_a_quarter_does_not():
    seen = {d.name: d for d in beside_its_null().detectable}
    damping = seen["linear_damping"]
    assert (damping.parameter, damping.unit) == ("c_Ns_per_m", "N s/m")
    assert 0.0 < damping.share_of_motion < 0.1
    assert not damping.named_value < damping.value
    strong = beside_its_null((registry.find("linear_damping"), 1.5 * damping.value), seed=2001)
    assert strong.p_value <= SIGNIFICANT
    assert strong.scores is not None
    assert strong.scores.own > strong.scores.limit
    assert strong.tests[0].label.startswith(("linear_damping", "cubic_damping"))
    assert beside_its_null((registry.find("linear_damping"), 0.25 * damping.value), seed=2001).p_value > SIGNIFICANT


def test_the_tail_of_a_statistic_goes_on_as_an_exponential():
    values = np.random.default_rng(0).exponential(2.0, 20_000)
    tail = Tail.of(values)
    assert math.exp(tail.log_p(np.array([20.0]))[0]) == pytest.approx(math.exp(-10.0), rel=0.3)
    assert math.exp(tail.log_p(np.array([1.0]))[0]) == pytest.approx(math.exp(-0.5), rel=0.02)
    assert tail.at(float(tail.log_p(np.array([15.0]))[0])) == pytest.approx(15.0)
    assert tail.quantile(0.001) == pytest.approx(2.0 * math.log(1000.0), rel=0.05)


def test_replicas_that_are_nearly_all_alike_tell_little_of_the_next():
    # a law that may only add has no gain in most replicas: one of 500 that shows 16 is no event of e^-400
    alike = Tail.of(np.zeros(500))
    assert alike.log_p(np.array([16.0, 1e6])) == pytest.approx([-9.7, -20.7], abs=0.1)
    assert alike.at(float(alike.log_p(np.array([16.0]))[0])) == pytest.approx(16.0)
    lone = Tail.of(np.append(np.zeros(499), 16.0))
    assert lone.log_p(np.array([16.0]))[0] == pytest.approx(math.log(1.0 / 500.0 / 2.0))
    assert lone.at(float(lone.log_p(np.array([100.0]))[0])) == pytest.approx(100.0)
    drawn = np.random.default_rng(0).exponential(1.0, 1000)
    rare = np.append(np.zeros(999), 16.0)
    assert float(np.min(_least({"some": drawn, "rare": rare}, {"some": 0.0, "rare": 0.0}))) > -12.0


@cache
def quiet() -> tuple[Level, JointFit]:
    """Two trials with nothing missing, and the prescribed equation fitted to them."""
    level = make_level([member("short", SHORT[:2], 2300)])
    return level, stands(level)


def test_replicas_that_grow_without_end_give_no_p_value():
    level, fit = quiet()
    drawn = replicas(level, fit.solution, fit.solution.residuals, 20, np.random.default_rng(0))
    assert within_reason(fit.solution, drawn)
    assert not within_reason(fit.solution, [1e5 * r for r in drawn])
    few = [found("cubic_stiffness")]
    none = (Candidate((), fit, 0.0),)
    assert 0.0 < null_test(level, few, fit, none).p_value <= 1.0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(null_module, "replicas", lambda *given: [1e5 * r for r in replicas(*given)])
        assert math.isnan(null_test(level, few, fit, none).p_value)


@cache
def hardening() -> tuple[Level, JointFit, JointFit]:
    """Trials whose spring hardens: the prescribed equation fitted, and with a cubic term."""
    level = make_level([member("short", SHORT, 2001, ((registry.find("cubic_stiffness"), 3.0e7),))])
    fit, suspect = stands(level), found("cubic_stiffness")
    best = from_places(level, Candidate((), fit, 0.0), suspect, peaks(places(level, Stands.of(fit), suspect)), 0.0)
    assert best is not None
    return level, fit, best.fit


def judged(*candidates: Candidate) -> NullTest:
    """The level whose spring hardens, after a search that fitted these."""
    level, fit, _ = hardening()
    return null_test(level, [found("cubic_stiffness"), found("cubic_damping")], fit, candidates)


def test_what_a_fit_gained_and_the_noise_it_leaves_count():
    suspect = found("cubic_stiffness")
    _, fit, closer = hardening()
    before, after = judged(), judged(Candidate((suspect,), closer, 0.0))
    (linear,) = (t for t in before.tests if t.label == suspect.label)
    (fitted,) = (t for t in after.tests if t.label == suspect.label)
    factor = math.sqrt(fit.misfit / closer.misfit * fit.memory / closer.memory)
    assert factor > 1.02
    assert fitted.gain > linear.gain  # weighed by less noise
    weighed = at_noise_of(fit, closer)
    assert _fitted_gain(weighed, [closer]) == pytest.approx(
        0.5 * (weighed.solution.cost - closer.solution.cost), rel=1e-6
    )
    assert fitted.gain >= _fitted_gain(weighed, [closer])
    assert _fitted_gain(weighed, []) == 0.0


def test_the_closest_model_is_one_of_the_same_samples():
    """A bad release is fitted without the first periods: what it leaves is less, and says nothing of the others."""
    suspect = found("cubic_stiffness")
    closer = hardening()[2]
    shorter = tuple(r[40:] for r in closer.solution.residuals)
    fewer = replace(closer.solution, residuals=shorter, n_data=sum(r.size for r in shorter))
    release = Candidate((found("imperfect_release"),), replace(closer, misfit=0.1 * closer.misfit, solution=fewer), 0.0)
    after, beside = (judged(Candidate((suspect,), closer, 0.0), *late) for late in ((), (release,)))
    assert beside.p_value == after.p_value
    assert [test.gain for test in beside.tests] == [test.gain for test in after.tests]


def test_at_another_noise_residuals_and_derivatives_are_weighed_alike():
    _, fit = quiet()
    solution = fit.solution
    halved = tuple(
        replace(t, channels=tuple(replace(c, sigma=0.5 * c.sigma) for c in t.channels)) for t in solution.problem.trials
    )
    other = replace(fit, solution=replace(solution, problem=Problem(solution.problem.unknowns, halved)))
    weighed = at_noise_of(fit, other).solution
    for r, jac, old, old_jac in zip(
        weighed.residuals, weighed.jacobians, solution.residuals, solution.jacobians, strict=True
    ):
        assert r == pytest.approx(2.0 * old)
        assert np.allclose(jac, 2.0 * old_jac)
    assert weighed.chi2 == pytest.approx(4.0 * solution.chi2)
    assert weighed.cost - weighed.chi2 == pytest.approx(solution.cost - solution.chi2)
    assert left_by(at_noise_of(fit, other), other)[0] == pytest.approx(solution.residuals[0])


def test_p_values_in_the_tail_are_as_frequent_as_they_say():
    """Eight statistics of 1,000 replicas, and of recordings like them; with tails that hold the replicas themselves 2.6
    % of 1,500 were below .01 (twenty statistics), now 1.5 %."""
    rng = np.random.default_rng(3)
    p = []
    for _ in range(1500):
        drawn = rng.exponential(size=(8, 1001))
        tails = [Tail.of(row[1:]) for row in drawn]
        own = min(tail.log_p(row[:1])[0] for tail, row in zip(tails, drawn, strict=True))
        together = Tail.of(-_least({str(i): row[1:] for i, row in enumerate(drawn)}, dict.fromkeys("01234567", 0.0)))
        p.append(math.exp(together.log_p(np.array([-own]))[0]))
    small = np.array(p)
    assert 0.005 < np.mean(small < 0.01) < 0.016  # 15 of 1,500, 4 standard deviations either way
    assert np.mean(small < 0.002) < 0.006
    assert abs(np.mean(small < 0.1) - 0.1) < 0.025


def test_what_a_fit_gained_counts_only_where_its_numbers_mean_something():
    level, fit = quiet()
    suspects = (found("cubic_stiffness"), found("cubic_damping"))
    strong = replace(fit, solution=replace(fit.solution, cost=fit.solution.cost - 120.0))
    for several in (suspects[:1], suspects):
        plain = null_test(level, suspects, fit, (Candidate((), fit, 0.0),))
        bound = null_test(level, suspects, fit, (Candidate(several, strong, 0.0, out="it sits on its bound"),))
        small = null_test(level, suspects, fit, (Candidate(several, strong, 0.0, out="too small", aside=True),))
        assert bound.p_value == plain.p_value > 0.05
        assert small.p_value < 1e-3


@pytest.mark.parametrize(("share", "counts"), [(0.2, False), (0.6, True), (2.3, True), (5.0, True)])
def test_what_a_fit_gained_far_slower_than_replicas_are_looked_at_does_not_count(share, counts):
    level, fit = quiet()
    suspect = found("hidden_resonator")
    additions = suspect.additions(level.scales, share * level.scales.fastest)
    frequency = next(a for a in additions if a.name == "natural_frequency_rad_per_s")
    problem = fit.solution.problem
    unknowns = (*problem.unknowns, Unknown(f"hidden_resonator.{frequency.name}", frequency.start))
    solution = replace(
        fit.solution, problem=Problem(unknowns, problem.trials), values=np.append(fit.solution.values, frequency.start)
    )
    fitted = replace(fit, addends=(Addend("hidden_resonator", additions),), solution=solution)
    assert _looked_at(level, Candidate((suspect,), fitted, 0.0)) == counts


def test_two_effects_together_stand_out_by_what_both_gained():
    level, fit = quiet()
    suspects = (found("cubic_stiffness"), found("cubic_damping"))
    strong = replace(fit, solution=replace(fit.solution, cost=fit.solution.cost - 120.0))
    without, together = (null_test(level, suspects, fit, (Candidate(suspects, one, 0.0),)) for one in (fit, strong))
    assert without.p_value > 0.05
    assert together.p_value < 1e-3
    assert [t.p_value for t in together.tests] == pytest.approx([t.p_value for t in without.tests])  # alone as before


def test_the_tolerance_for_wrong_equations_makes_a_gain_less_unusual():
    after = Candidate((found("cubic_stiffness"),), hardening()[2], 0.0)
    assert judged(after).p_value == LEAST_P
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(null_module, "surely_wrong", lambda solution, left: 1e5)
        assert judged(after).p_value > 1e-3


def test_a_model_is_surely_wrong_by_what_it_leaves_at_the_rates_of_the_motion_while_that_is_large():
    _, fit = quiet()
    rng = np.random.default_rng(3)
    noise = [rng.standard_normal(r.size) for r in fit.solution.residuals]
    assert surely_wrong(fit.solution, noise) == 0.0

    def wave(periods: float, decays: bool) -> list[np.ndarray]:
        return [
            np.tile(3.0 * np.sin(2.0 * math.pi * trial.t / (periods * trial.period_s))
                    * np.exp(-decays * 12.0 * (trial.t - trial.t[0]) / np.ptp(trial.t)), len(trial.channels))
            for trial in fit.solution.problem.trials
        ]  # fmt: skip

    def wrong(periods: float, decays: bool) -> float:
        return surely_wrong(fit.solution, [n + w for n, w in zip(noise, wave(periods, decays), strict=True)])

    squares = sum(float(w @ w) for w in wave(0.9, decays=True))
    assert 0.6 * squares < wrong(0.9, decays=True) < squares
    assert wrong(0.15, decays=True) == 0.0  # faster than laws of motion
    standing = sum(float(w @ w) for w in wave(0.9, decays=False))
    assert wrong(0.9, decays=False) < 0.1 * standing  # as large when the body hardly moves: a sensor
    red = [
        [lfilter([1.0], [1.0, -0.9], rng.standard_normal(r.size)) for r in fit.solution.residuals] for _ in range(20)
    ]
    shares = [surely_wrong(fit.solution, one) / sum(float(r @ r) for r in one) for one in red]
    assert float(np.median(shares)) == 0.0
    assert max(shares) < 0.4


def test_a_place_that_what_stands_takes_up_is_neither_tested_nor_drawn():
    level, fit = quiet()
    stand = Stands.of(fit)
    (shown,) = places(level, stand, found("cubic_stiffness"))
    taken = [jac[:, :1] for jac in fit.solution.jacobians]
    cross = np.zeros((len(fit.solution.values), 1))
    for jac, used, own in zip(fit.solution.jacobians, fit.solution.used, taken, strict=True):
        cross[used] += jac.T @ own
    products = np.array([[sum(float(np.sum(own**2)) for own in taken)]])
    columns = tuple((own, np.array([0])) for own in taken)
    hidden = GridPlace("taken", shown.additions, 0.0, columns, cross, products)
    stack = Stack.of(stand, [hidden, shown])
    assert (stack.shows(hidden, stack.slices[0]), stack.shows(shown, stack.slices[1])) == (False, True)
    drawn = _slightly_wrong(stack, 4.0, 200, np.random.default_rng(0))
    information = stack.information[stack.slices[1], stack.slices[1]]
    own = np.linalg.solve(information, drawn[stack.slices[1]])
    assert drawn == pytest.approx(stack.information[:, stack.slices[1]] @ own, rel=1e-9)  # seen at every place
    square = np.einsum("wn,wv,vn->n", own, information, own)
    assert np.all((square > 0.0) & (square <= 4.0))
    assert float(np.mean(square)) == pytest.approx(2.0, rel=0.15)


def test_places_that_the_search_has_seen_need_not_be_looked_at_again():
    level, fit, closer = hardening()
    suspects = [found(n) for n in ("cubic_stiffness", "hidden_resonator", "presliding")]
    seen = {s.label: places(level, Stands.of(fit), s) for s in suspects}
    candidates = (Candidate((suspects[0],), closer, 0.0),)  # its noise weighs the level: places are weighed anew
    afresh, again = (null_test(level, suspects, fit, candidates, looks=looks) for looks in (None, seen))
    assert [t.label for t in again.tests] == [t.label for t in afresh.tests]
    assert [t.gain for t in again.tests] == pytest.approx([t.gain for t in afresh.tests], rel=1e-6)
    assert again.p_value == pytest.approx(afresh.p_value, rel=1e-6)
    none = null_test(level, suspects, fit, candidates, looks={suspects[1].label: ()})  # and nowhere else
    assert {t.label for t in none.tests} == {suspects[0].label, suspects[2].label}


def test_a_second_resonator_is_looked_for_beside_one_that_stands():
    level = make_level([member("short", SHORT, 2100, ())])
    beside = (found("hidden_resonator").grid(level.scales)[0],)
    moved = renumbered(beside[0], [Addend("hidden_resonator", beside[0])])
    assert {a.slot for a in moved} == {a.slot[:-1] + "2" for a in beside[0]}
    assert renumbered(beside[0], ()) == tuple(beside[0])


def test_less_power_asks_for_a_smaller_effect_and_a_twin_for_a_larger_one_to_be_named():
    level, fit = quiet()
    pair = [found("cubic_stiffness"), found("quintic_stiffness")]
    (alone,) = null_test(level, pair[:1], fit, ()).detectable
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(detectable_module, "POWER", 0.5)
        (weaker,) = null_test(level, pair[:1], fit, ()).detectable
    assert weaker.value < 0.95 * alone.value
    beside = {d.name: d for d in null_test(level, pair, fit, ()).detectable}
    assert beside["cubic_stiffness"].named_value > 1.05 * beside["cubic_stiffness"].value
    assert alone.named_value >= alone.value
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(detectable_module, "NAMED", 0.0)
        (seen,) = null_test(level, pair[:1], fit, ()).detectable
    assert seen.named_value == pytest.approx(alone.value)


def test_how_trials_differ_is_not_tested():
    level, fit = quiet()
    assert math.isnan(null_test(level, [found("mass_change")], fit, ()).p_value)
    assert {s.label for s in SUSPECTS if s.is_scatter} == {"mass_change"}


def test_of_many_levels_each_must_stand_out_more():
    level, fit = quiet()
    one, ten = (null_test(level, [found("cubic_stiffness")], fit, (), levels) for levels in (1, 10))
    assert one.p_value == ten.p_value
    assert (one.limit, ten.limit) == pytest.approx((0.01, 0.0010045), rel=1e-4)
    assert ten.detectable[0].value > 1.05 * one.detectable[0].value
    unlikely = replace(one, p_value=0.005)
    assert unlikely.significant
    assert not replace(unlikely, levels=10).significant


def test_a_law_that_nothing_small_leads_to_is_tested_as_it_starts():
    level, fit = quiet()
    test = null_test(level, [found("presliding")], fit, ())
    assert [t.label for t in test.tests] == ["presliding"]
    assert test.p_value > 0.01
    (seen,) = test.detectable
    starts = [additions[0].start for additions in found("presliding").grid(level.scales)]
    assert seen.value in starts
    assert seen.unit == "N/m"
    stiff = places(level, Stands.of(fit), found("presliding"))
    moved = [float(p.own[0, 0]) for p in stiff]
    assert moved[-1] < 0.1 * max(moved)  # the stiffest bristles are nearly sliding
    assert all(p.whole and p.width == 1 for p in stiff)
    assert all(p.gain < 3.0 for p in stiff)  # as it is, not so many times as fits best
    (tested,) = test.tests
    assert 0.0 <= tested.hidden < 1.0


def spectrum_alone(closest: np.ndarray, rate: np.ndarray, plain: np.ndarray) -> np.ndarray:
    """`spectrum_of` what is left of one channel, which alone says whether its sensor's noise rises and wanders."""
    left = LeftBy(closest, plain, rate)
    return spectrum_of(left, _rises([left]), _wanders([left]))


def test_replicas_have_the_spectrum_that_was_left_and_scatter_as_the_fit_believes():
    level, fit = quiet()
    left = left_by(fit, fit)
    assert all(np.array_equal(a, b) for a, b in zip(left, fit.solution.residuals, strict=True))
    still = replace(fit.solution, jacobians=tuple(np.zeros_like(j) for j in fit.solution.jacobians))
    drawn = replicas(level, still, left, 400, np.random.default_rng(1))
    for residual, many, trial in zip(left, drawn, fit.solution.problem.trials, strict=True):
        half = trial.t.size
        own = residual[:half]
        power = np.mean(np.abs(np.fft.rfft(many[:half], axis=0)) ** 2, axis=1)[1:-1]
        assert power == pytest.approx(spectrum_alone(own, _rate(trial), own)[1:-1], rel=0.35)
        assert float(np.mean(many[:half] ** 2)) == pytest.approx(float(np.mean(own**2)), rel=0.15)
    silent = [np.zeros_like(r) for r in left]
    for many, jac, used in zip(
        replicas(level, fit.solution, silent, 400, np.random.default_rng(1)), fit.solution.jacobians,
        fit.solution.used, strict=True,
    ):  # fmt: skip
        moved = jac * believed_widths(level, fit.solution)[used]
        assert float(np.mean(many**2)) == pytest.approx(float(np.mean(np.sum(moved**2, axis=1))), rel=0.3)


def test_instruments_are_as_far_off_as_all_trials_show_and_no_further_than_believed():
    level, fit = quiet()
    unknowns = fit.solution.problem.unknowns
    widths = dict(zip(fit.solution.problem.names, believed_widths(level, fit.solution), strict=True))
    prior = {u.name: u.prior_std for u in unknowns}
    rests = [name for name in prior if name.startswith("rest_m[")]
    gains = [name for name in prior if name.startswith("displacement_gain[")]
    assert len(rests) == len(level.members[0].motions) > 1
    shares = [widths[name] / prior[name] for name in rests]
    assert shares == pytest.approx([shares[0]] * len(rests))  # one habit of the laboratory
    assert 0.0 < shares[0] < 1.2 / math.sqrt(1.0 + len(rests))  # recordings show where a body comes to rest
    assert all(0.6 * prior[name] < widths[name] <= prior[name] for name in gains)  # two sensors tell what differs
    assert all(widths[name] == 0.0 for name in prior if not math.isfinite(prior[name]))
    values = fit.solution.values.copy()
    values[[fit.solution.problem.names.index(name) for name in rests]] += 10.0 * prior[rests[0]]
    far = believed_widths(level, replace(fit.solution, values=values))
    assert far[fit.solution.problem.names.index(rests[0])] == prior[rests[0]]


def test_noise_is_as_stated_where_few_frequencies_are_faster_than_the_motion():
    floor, excess, deviation = _above_noise(np.full(8, 19.0), np.linspace(0.2, 3.0, 8))  # of 16 samples
    assert (floor, excess) == (16.0, 24.0)
    assert deviation == pytest.approx(16.0 * math.sqrt(8.0))


def test_noise_is_that_of_fast_frequencies_where_fits_take_it_up_and_a_wandering_sensors_below():
    rng = np.random.default_rng(8)
    series = rng.standard_normal(4000)
    rate = np.fft.rfftfreq(4000)[1:] * 50.0  # 50 samples a period
    slow, wandering = rate <= 4.0, rate <= 0.5
    spectrum = np.fft.rfft(series)
    taken_up, wave = spectrum.copy(), spectrum.copy()
    taken_up[1:][slow] = 0.0
    wave[1:][slow] *= 3.0
    wanders = spectrum.copy()
    wanders[1:][wandering] *= 5.0

    def found(less: np.ndarray, plain: np.ndarray = spectrum) -> np.ndarray:
        return spectrum_alone(np.fft.irfft(less, 4000), rate, np.fft.irfft(plain, 4000))[1:]

    red = spectrum.copy()
    red[1:] *= 10.0 / np.maximum(rate, 0.1)
    unfitted, moved = red.copy(), (rate > 0.8) & (rate < 1.2)
    unfitted[1:][moved] *= 0.1  # what a trial's own frequency and damping take up
    assert float(np.mean(found(unfitted)[moved])) > 0.3 * float(np.mean(found(red)[moved]))
    assert float(np.min(found(unfitted)[moved])) >= float(np.max(found(unfitted)[(rate > 1.2) & (rate < 4.0)]))

    white = float(np.mean(found(spectrum)[~slow]))
    assert float(np.mean(found(taken_up)[slow])) == pytest.approx(white, rel=0.1)
    assert float(np.mean(found(wave)[slow & ~wandering])) == pytest.approx(9.0 * white, rel=0.2)
    assert float(np.mean(found(spectrum, wanders)[wandering])) > 10.0 * white


def test_a_slow_line_of_cycles_enough_is_no_wander_of_a_sensor():
    rng = np.random.default_rng(8)
    noise = np.fft.rfft(rng.standard_normal(4000))
    rate = np.fft.rfftfreq(4000)[1:] * 100.0  # 40 periods: the first 20 lines are slower than half the body's rate
    for cycles, is_wander in ((2, True), (3, True), (5, False), (12, False), (19, False)):
        tone = noise.copy()
        tone[cycles] *= 30.0 * np.sqrt(4000.0) / np.abs(tone[cycles])
        found = spectrum_alone(np.fft.irfft(noise, 4000), rate, np.fft.irfft(tone, 4000))[cycles]
        assert (found > 100.0 * 4000.0) == is_wander
    between = np.fft.irfft(noise, 4000) + 50.0 * np.sin(2.0 * np.pi * 5.5 * np.arange(4000) / 4000)
    found = spectrum_alone(np.fft.irfft(noise, 4000), rate, between)[5:7]
    assert np.all(found < 0.3 * np.abs(np.fft.rfft(between)[5:7]) ** 2)  # nor one between two frequencies
    white = np.random.default_rng(8).standard_normal((200, 4000))
    wander = [spectrum_alone(one, rate, 5.0 * one)[4:20] for one in white]
    assert 1.0 < float(np.mean(wander)) / (25.0 * 4000.0) < 1.25  # a median of few is a tenth too large
    red = noise.copy()
    red[1:] *= 10.0 / rate
    drawn = spectrum_alone(np.fft.irfft(noise, 4000), rate, np.fft.irfft(red, 4000))[1:]
    slow = rate <= 0.5
    own = np.abs(np.fft.rfft(np.fft.irfft(red, 4000))[1:]) ** 2
    assert float(np.mean((drawn / own)[slow])) > 0.7  # a sensor that wanders more the slower keeps its power
    assert 0.5 < float(np.median((rate**2 * drawn)[slow]) / np.mean((rate**2 * own)[slow])) < 2.0


@pytest.mark.parametrize(("rate", "size"), [(0.42, 60.0), (3.0, 300.0)])
def test_a_force_far_slower_or_faster_than_the_body_is_named(rate, size):
    body = make_level([member("short", SHORT, 2000)]).scales.slowest
    tone = registry.find("external_forcing", frequency_rad_per_s=rate * body)
    level = make_level([member("short", (0.03, 0.04, 0.05), 2000, ((tone, size),))])
    best = diagnose(level, [found(name) for name in LOOKED_FOR[1:]]).best
    assert best.names == ("external_forcing",)
    assert best.fit.value("external_forcing.frequency_rad_per_s") == pytest.approx(rate * body, rel=0.01)
    assert its_own(best.fit).keys() == {f"external_forcing.{part}_N" for part in ("cosine", "sine")}
    values = best.fit.solution.values.copy()
    for i, name in enumerate(best.fit.solution.problem.names):
        values[i] *= 0.5 if "cosine_N[" in name or "sine_N[" in name else 1.0
    halved = replace(best.fit, solution=replace(best.fit.solution, values=values))
    # its size and phase are adjusted to every trial, as the release is: what the joint fit has of them does not matter
    assert free_run_error(level, halved) == pytest.approx(free_run_error(level, best.fit), rel=1e-3)
    (group,) = level.members
    first, again = (shared_run(level, group, fit, group.motions[0], 1e-3).nrmse for fit in (best.fit, halved))
    assert again == pytest.approx(first, rel=1e-3)


def test_a_force_whose_size_and_phase_change_along_the_record_is_named_by_its_frequency():
    body = make_level([member("short", SHORT, 2000)]).scales.slowest
    rng, parts = np.random.default_rng(3), []
    for i, x0 in enumerate((0.03, 0.04, 0.05)):
        phases = dict(zip(("phase_rad", "change_phase_rad", "bend_phase_rad"), rng.uniform(0.0, 6.0, 3), strict=True))
        force = registry.find(
            "changing_force", frequency_rad_per_s=0.5 * body, change_per_s=0.4, bend_per_s2=0.04, **phases
        )
        parts.append(member("short", (x0,), 2000 + i, ((force, 150.0),)))
    level = make_level([replace(parts[0], motions=tuple(m for part in parts for m in part.motions))])
    best = diagnose(level, [found(name) for name in LOOKED_FOR[1:]]).best
    assert best.names == ("external_forcing",)
    moved = {slot for a in best.fit.addends[-1].additions for slot, _ in a.slots}
    assert moved >= {"gomega", "gcos_t", "gsin_t"}
    assert best.fit.value("external_forcing.frequency_rad_per_s") == pytest.approx(0.5 * body, rel=0.02)
    assert best.fit.misfit < 1.3
    steady = replace(found("external_forcing"), wider=())
    assert diagnose(level, [steady]).best.fit.misfit > 5.0 * best.fit.misfit
    amplitude = addition_parameters(best.fit, "short")["external_forcing"][0]["amplitude_N"]
    assert 100.0 < amplitude.value < 600.0
    assert changing_words(best.fit.addends).startswith(" Its size and phase change along each record")
    assert changing_words((Addend("external_forcing", steady.additions(level.scales, body)),)) == ""


def test_scatter_that_few_dry_trials_showed_is_itself_uncertain():
    level, fit = quiet()

    def with_freedom(freedom: float) -> Level:
        (one,) = level.members
        fixed = replace(one.model.fixed, scatter_freedom=freedom)
        return replace(level, members=(replace(one, model=replace(one.model, fixed=fixed)),))

    rng = np.random.default_rng(3)
    assert _scatter_factors(with_freedom(math.inf), 100, rng) == {}
    many = _scatter_factors(with_freedom(300.0), 20_000, rng)["k"]
    assert float(np.mean(many**-2.0)) == pytest.approx(1.0, rel=0.02)
    assert float(np.std(np.log(many))) == pytest.approx(1.0 / math.sqrt(600.0), rel=0.05)
    few = _scatter_factors(with_freedom(2.0), 200_000, rng)["k"]
    beyond = [float(np.mean(few > factor)) for factor in (2.0, 8.0)]
    assert 0.05 < beyond[0] < 0.15  # by the two degrees of freedom alone .22 and .015
    assert beyond[1] < 0.002
    assumed = _scatter_factors(with_freedom(0.0), 20_000, rng)["mu"]
    assert float(np.std(np.log(assumed))) == pytest.approx(math.log(2.0), rel=0.05)
    assert float(np.median(assumed)) == pytest.approx(1.0, rel=0.05)
    names, silent = fit.solution.problem.names, [np.zeros_like(r) for r in fit.solution.residuals]
    for kind in ("k[", "k_mean@"):  # of each trial, and of the mean that the dry trials left
        alone = tuple(
            np.where([names[i].startswith(kind) for i in used], jac, 0.0)
            for jac, used in zip(fit.solution.jacobians, fit.solution.used, strict=True)
        )
        sure, unsure = (
            replicas(
                with_freedom(freedom), replace(fit.solution, jacobians=alone), silent, 400, np.random.default_rng(5)
            )
            for freedom in (math.inf, 1.0)
        )
        assert np.quantile(np.abs(unsure[0]), 0.99) > 1.4 * np.quantile(np.abs(sure[0]), 0.99) > 0.0


def test_a_gain_that_the_likelihood_itself_has_often_is_not_rare_because_replicas_are_alike():
    """An added mass in air, of which the belief about the spring alone tells, gained .6 where replicas gained .1."""
    level, fit = quiet()
    laws = [found(name) for name in ("cubic_stiffness", "cubic_damping", "stribeck_friction")]
    usual = null_test(level, laws, fit, ())
    with pytest.MonkeyPatch.context() as patch:
        drawn = null_module.replicas
        patch.setattr(null_module, "replicas", lambda *rest: [0.05 * r for r in drawn(*rest)])
        alike = null_test(level, laws, fit, ())
        for test in alike.tests:
            assert math.log(test.p_value) >= wilks(test.gain / 0.4, 1)  # no less than as often as its own noise has it
        patch.setattr(null_module, "wilks", lambda gain, width: -math.inf)
        assert null_test(level, laws, fit, ()).tests[0].p_value < 1e-3 * alike.tests[0].p_value
    assert alike.tests[0].p_value < usual.tests[0].p_value


def test_an_effect_is_as_large_as_what_the_reported_numbers_do_not_take_up():
    level, fit = quiet()
    stand = Stands.of(fit)
    suspect = found("linear_damping", "one for all springs")
    (place, *_) = places(level, stand, suspect)
    shared = {n: fit.solution.stderr(n) for n in fit.solution.problem.names if not set("[.") & set(n)}
    one = np.ones((place.width, 1))
    refitted, fixed = (Sizes.on(level, stand, reported).measure(place) for reported in (shared, {}))
    assert 0.0 < refitted.of_free_run(one)[0] < 0.7 * fixed.of_free_run(one)[0]
    assert refitted.of_free_run(2.0 * one)[0] == pytest.approx(2.0 * refitted.of_free_run(one)[0])
    assert refitted.of(one)[0] >= 2.0 * refitted.of_free_run(one)[0]
    none = np.zeros((place.width, place.width))
    assert refitted.bound(np.zeros(place.width), none, 1.6) == 0.0
    assert (
        refitted.bound(np.zeros(place.width), np.eye(place.width), 1.6)
        == pytest.approx(2.0 * 1.6 * refitted.of_free_run(one / math.sqrt(place.width))[0], rel=1e-6)
        or place.width > 1
    )


def test_where_nothing_can_be_tested_there_is_no_probability():
    level = make_level([member("short", SHORT[:2], 2300)])
    fit = stands(level)
    none = null_test(level, (), fit, ())
    assert math.isnan(none.p_value)
    assert (none.tests, none.detectable, none.hides_best) == ((), (), "")
    assert math.isnan(NullTest(0.5, (SuspectTest("a", 0.5, 1.0, 0.1, math.nan),)).upper_bound)
    wide = Detectable("b", "mass_kg", 44.0, "kg", 330.0)
    both = NullTest(0.5, (SuspectTest("a", 0.5, 1.0, 0.1, 0.5), SuspectTest("b (x)", 0.5, 1.0, 0.1, 9.0, wide)), 0.03)
    assert (both.not_testable, both.detectable, both.upper_bound) == (("b",), (), 0.5 * 0.03)


def test_nothing_hides_that_moves_the_free_run_by_more_than_it_misses_and_repetitions_differ():
    wide = NullTest(0.5, (SuspectTest("a", 0.5, 1.0, 0.1, 30.0),), 0.03)
    assert wide.upper_bound == pytest.approx(0.9)
    assert replace(wide, most=0.2).upper_bound == 0.2
    assert math.isnan(replace(wide, tests=(), most=0.2).upper_bound)
    level = make_level([member("short", SHORT[:2], 2300)])
    fit = stands(level)
    tested = null_test(level, tuple(s for s in SUSPECTS if s.name == "linear_damping"), fit, ())
    assert tested.most == pytest.approx(missed_share(level, fit) + 0.05)  # repeatability of these members


def test_what_each_trial_has_of_its_own_is_told_by_the_root_of_its_mean_square():
    level, fit = quiet()
    tone = places(level, Stands.of(fit), found("external_forcing"))[0]
    trials = len(fit.solution.problem.trials)
    assert tone.width == 2 * trials  # a cosine and a sine each
    assert _first_number(tone, np.ones(tone.width)) == pytest.approx(math.sqrt(2.0))
    once = np.zeros(tone.width)
    once[tone.columns[0][1]] = 3.0
    assert _first_number(tone, once) == pytest.approx(3.0 * math.sqrt(2.0 / trials))
    (shared, *_) = places(level, Stands.of(fit), found("linear_damping", "one for all springs"))
    assert _first_number(shared, 5.0 * np.ones(shared.width)) == 1.0


def test_what_is_each_trial_s_own_is_as_large_in_all_of_them():
    """Its direction is not where the recordings' noise pushes, which is most where they tell least."""
    tone = SimpleNamespace(scope="trial", inner=False)
    own = SimpleNamespace(
        place=SimpleNamespace(width=2, whole=False, additions=(tone,)), step=np.array([0.1, 5.0]),
        information=np.diag([4.0, 0.04]), inverse=np.diag([0.25, 25.0]), draws=np.zeros((2, 20)), gains=np.zeros(20),
    )  # fmt: skip
    _, along, size = detectable_module._smallest((), own, 2.02)
    assert list(along) == [1.0, 1.0]
    assert size == pytest.approx(1.0, rel=1e-6)
    tone.scope = "shared"
    assert list(detectable_module._smallest((), own, 2.02)[1]) == pytest.approx([0.02, 1.0])


def test_what_is_slower_than_the_motion_does_not_show_an_effect():
    _, fit = quiet()
    trials = fit.solution.problem.trials

    def waves(rate: float) -> list[np.ndarray]:
        """A wave of so many times the body's rate, whole periods, in every channel of every trial."""
        own = []
        for trial in trials:
            cycles = max(round(rate * trial.t.size * float(np.median(np.diff(trial.t))) / trial.period_s), 1)
            one = np.sin(2.0 * np.pi * cycles * np.arange(trial.t.size) / trial.t.size)
            own.append(np.tile(one, len(trial.channels)))
        return own

    slow, fast = waves(0.2), waves(0.65)  # half the body's rate lies between
    assert not_slow(fit.solution, slow) == pytest.approx(0.0, abs=1e-12)
    assert not_slow(fit.solution, fast) == pytest.approx(1.0)
    both = [2.0 * s + f for s, f in zip(slow, fast, strict=True)]
    assert not_slow(fit.solution, both) == pytest.approx(0.2, rel=1e-6)
    assert not_slow(fit.solution, [0.0 * one for one in fast]) == 1.0


def test_a_relaxation_that_creeps_is_seen_by_what_is_fast_of_it():
    level, fit = quiet()
    suspect = found("relaxation")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(detectable_module, "not_slow", lambda *_: 1.0)
        (every,) = null_test(level, [suspect], fit, ()).detectable
        patch.setattr(detectable_module, "not_slow", lambda *_: 0.25)
        (quarter,) = null_test(level, [suspect], fit, ()).detectable
    assert quarter.value == pytest.approx(2.0 * every.value)  # a quarter of its squares
    (fast,) = null_test(level, [suspect], fit, ()).detectable
    assert fast.at == every.at
    assert fast.value > 1.5 * every.value
    assert fast.share_of_motion == pytest.approx(every.share_of_motion * fast.value / every.value)


def test_what_a_force_would_be_seen_by_is_faster_than_sensors_wander():
    """A force of a period longer than the record is a wandering sensor: at three times the size that was said it was
    not seen."""
    level, fit = quiet()
    (force,) = null_test(level, [found("external_forcing")], fit, ()).detectable
    slow = 0.5 * max(2.0 * math.pi / trial.period_s for trial in fit.solution.problem.trials)
    assert force.at["frequency_rad_per_s"] > slow
    at = [replace(a, start=slow) for a in found("external_forcing").grid(level.scales)[0]]
    assert wanders_as(fit.solution, at)
    assert not wanders_as(fit.solution, [replace(a, start=1.01 * slow) for a in at])
    slowest = min(a.start for place in found("external_forcing").grid(level.scales) for a in place if a.unit == "rad/s")
    assert slowest < slow  # it is looked for there all the same


def test_bristles_that_are_there_are_seen_as_they_are():
    level, fit = quiet()
    suspect = found("presliding")
    stand = Stands.of(fit)
    (soft, *_) = places(level, stand, suspect)
    pushed = [r + columns[:, 0] for r, (columns, _) in zip(fit.solution.residuals, soft.columns, strict=True)]
    less = tuple(2.0 * r - p for r, p in zip(fit.solution.residuals, pushed, strict=True))
    with_bristles = replace(fit, solution=replace(fit.solution, residuals=less))
    (there, *_) = places(level, Stands.of(with_bristles), suspect)
    left = float(there.own[0, 0] - there.cross[:, 0] @ stand.inverse @ there.cross[:, 0])
    assert there.gain == pytest.approx(0.5 * left, rel=0.2)
    assert soft.gain < 0.1 * there.gain


@pytest.mark.parametrize(("information", "told"), [(0.0, 1.0), (4.0, 0.0), (4.0, 1.0)])
def test_an_effect_that_no_size_would_show_has_no_smallest_size(information, told):
    """The recordings do not hold it at all, or everything of it is taken up by what is free."""
    own = SimpleNamespace(
        place=SimpleNamespace(width=1, whole=False, additions=()), step=np.zeros(1),
        information=np.full((1, 1), information),
        inverse=np.full((1, 1), told / 4.0), draws=np.zeros((1, 20)), gains=np.zeros(20),
    )  # fmt: skip
    _, _, size = detectable_module._smallest((), own, 2.0)
    assert math.isnan(size) == (information * told == 0.0)
    if information * told > 0.0:
        assert size == pytest.approx(1.0, rel=1e-6)


def test_replicas_of_white_noise_are_no_louder_than_it_where_the_motion_is_and_below():
    rng, n, per = np.random.default_rng(4), 1000, 40.0
    rate = np.fft.rfftfreq(n)[1:] * per
    below, moving = (np.arange(rate.size) >= 3) & (rate <= 0.5), (rate > 0.5) & (rate <= 4.0)
    power = np.zeros(rate.size)
    for _ in range(200):
        left = [LeftBy(one, one, rate) for one in rng.standard_normal((8, n))]
        rises, wanders = _rises(left), _wanders(left)
        power += np.mean([spectrum_of(one, rises, wanders)[1:] for one in left], axis=0) / (200.0 * n)
    assert np.count_nonzero(below) == 9
    assert float(np.mean(power[below])) == pytest.approx(1.0, abs=0.06)
    assert power[:3] == pytest.approx(1.0 + math.exp(-1.0), abs=0.12)  # there sensors drift: of one line who knows
    assert float(np.mean(power[moving])) == pytest.approx(1.0, abs=0.03)


def test_a_sensor_that_wanders_and_whose_noise_rises_is_known_from_all_its_trials_together():
    rng, n = np.random.default_rng(5), 1000
    rate = np.fft.rfftfreq(n)[1:] * 40.0
    assert float(np.sum(rate <= 0.5)) == 12.0
    size = np.sqrt(np.where(rate <= 0.5, 1.5, np.where(rate <= 4.0, 1.25, 1.0)))

    def left() -> LeftBy:
        spectrum = np.fft.rfft(rng.standard_normal(n))
        spectrum[1:] *= size
        one = np.fft.irfft(spectrum, n)
        return LeftBy(one, one, rate)

    trials = [left() for _ in range(200)]
    alone = [(_rises([one]), _wanders([one])) for one in trials]
    together = [(_rises(trials[i : i + 20]), _wanders(trials[i : i + 20])) for i in range(0, 200, 20)]
    assert np.all(np.mean(alone, axis=0) < 0.75)
    assert np.all(together)


def test_what_a_sensor_has_in_all_trials_alike_is_tested_as_one_number():
    """Free in every trial a gain took up what one trial's body differed by: p was 1e-6, and no fit came closer."""
    level = make_level([member("short", SHORT, 100)])
    fit = stands(level)
    widths = {name: places(level, Stands.of(fit), found(name))[0].width for name in ("gain_error", "sensor_drift")}
    assert widths == {"gain_error": 1, "sensor_drift": len(SHORT)}
