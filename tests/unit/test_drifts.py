"""Numbers that should be constants: a planted drift is said with both ends, and scatter alone hardly ever is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.findings_fixture import small_findings
from undertow.campaign.run.plausible import with_doubts
from undertow.discrepancy.drifts import FALSE_ALARM, amplitude_drifts, group_drifts, no_scatter, springs_apart
from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.discrepancy.verdict import Gate
from undertow.likelihood.fit import Fit
from undertow.quantities import Estimate

WATER = ("water_depth_m",)


def wet_group() -> GroupFindings:
    return next(g for g in small_findings().groups if not g.dry)


def trials_with(values: np.ndarray, amplitudes: np.ndarray, error: float) -> list[TrialFindings]:
    """Trials whose fits say these damping coefficients at these amplitudes."""
    model = wet_group().trials[0]
    out = []
    for value, amplitude in zip(values, amplitudes, strict=True):
        numbers = {"c_Ns_per_m": Estimate(float(value), error, unit="N s/m")}
        motion = replace(model.motion, amplitude=float(amplitude))
        out.append(replace(model, motion=motion, fits={"output_error": Fit("output_error", ("r",), {}, numbers)}))
    return out


AMPLITUDES = np.geomspace(0.01, 0.1, 6)


def test_damping_that_doubles_with_amplitude_is_said_with_both_ends():
    values = 500.0 + 500.0 * np.log10(AMPLITUDES / 0.01)
    found = amplitude_drifts(trials_with(values, AMPLITUDES, 20.0), "spring long")
    assert [d.parameter for d in found] == ["c_Ns_per_m"]
    assert found[0].chance < 1e-3
    assert "from 500 at 10 mm to 1000 N s/m at 100 mm" in found[0].sentence
    turning = [
        replace(t, motion=replace(t.motion, recording=replace(t.motion.recording, coordinate="rotation")))
        for t in trials_with(values, AMPLITUDES, 20.0)
    ]
    (said,) = amplitude_drifts(turning, "disc")
    assert "from 500 at 0.01 rad to 1000 N s/m at 0.1 rad" in said.sentence


def test_scatter_alone_drifts_no_more_often_than_stated():
    rng = np.random.default_rng(1)
    alarms = sum(
        bool(amplitude_drifts(trials_with(500.0 + 120.0 * rng.standard_normal(6), AMPLITUDES, 20.0), ""))
        for _ in range(400)
    )
    assert alarms <= 12  # 4 expected at one in a hundred; three standard deviations above


def test_three_trials_are_too_few_for_a_drift():
    values = np.array([500.0, 800.0, 1100.0])
    assert amplitude_drifts(trials_with(values, AMPLITUDES[:3], 1.0), "") == ()


def with_added_mass(group: GroupFindings, spring: str, value: float, error: float) -> GroupFindings:
    fit = Fit("output_error", ("r",), {}, {"added_mass_kg": Estimate(value, error, unit="kg")})
    return replace(group, key={"spring": spring, "water_depth_m": 2.36}, fits={"output_error": fit})


@pytest.mark.parametrize(("other", "said"), [(-80.0, True), (905.0, False)])
def test_added_mass_is_one_for_both_springs_of_a_level_or_it_is_said(other, said):
    group = wet_group()
    pair = [with_added_mass(group, "long", 903.0, 12.0), with_added_mass(group, "short", other, 15.0)]
    found = group_drifts(pair, WATER)
    assert bool(found) is said
    if said:
        assert found[0].along == "spring"
        assert found[0].chance < FALSE_ALARM
        assert "water depth 2.36 m: added_mass_kg is 903" in found[0].sentence
        assert "-80" in found[0].sentence


def test_added_mass_may_differ_from_level_to_level():
    group = wet_group()
    one = with_added_mass(group, "long", 903.0, 12.0)
    other = replace(with_added_mass(group, "long", 100.0, 12.0), key={"spring": "long", "water_depth_m": 2.22})
    assert group_drifts([one, other], WATER) == ()


def test_springs_that_disagree_where_nothing_is_missing_are_said_behind_the_sentence():
    group = wet_group()
    fine = replace(group, verdict=replace(group.verdict, status="nothing_missing", verdict=()))
    pair = [with_added_mass(fine, "long", 903.0, 12.0), with_added_mass(fine, "short", -80.0, 15.0)]
    said = springs_apart(pair, WATER)
    assert said.startswith(" But water depth 2.36 m: added_mass_kg is 903")
    assert "one water has one value (errors of each group's own fit). Each group's equation keeps its own" in said
    third = with_added_mass(fine, "middle", 400.0, 12.0)
    assert "2 more pairs differ." in springs_apart([*pair, third], WATER)
    assert springs_apart([pair[0], with_added_mass(fine, "short", 905.0, 15.0)], WATER) == ""
    open_ = replace(fine.verdict, status="cannot_tell")
    assert springs_apart([pair[0], replace(pair[1], verdict=open_)], WATER) == said
    assert springs_apart(pair, ()) == ""  # nobody says what the water's conditions are
    named = replace(fine.verdict, status="explained", verdict=("hidden_resonator",))
    assert springs_apart([pair[0], replace(pair[1], verdict=named)], WATER) == ""


def green(stiffness: np.ndarray, amplitudes: np.ndarray) -> GroupFindings:
    """A group in which nothing is missing, whose trials were fitted alone with these stiffnesses."""
    plain = small_findings().groups[0]
    trials = []
    for place, (value, amplitude) in enumerate(zip(stiffness, amplitudes, strict=True)):
        recording = replace(plain.trials[0].motion.recording, name=f"t{place}")
        motion = replace(plain.trials[0].motion, amplitude=float(amplitude), recording=recording)
        numbers = {"k_N_per_m": Estimate(float(value), 1.0, unit="N/m")}
        trials.append(replace(plain.trials[0], motion=motion, fits={"output_error": Fit("", ("r",), {}, numbers)}))
    return replace(plain, trials=tuple(trials), verdict=replace(plain.verdict, status="nothing_missing", verdict=()))


DRIFTING = np.array([1000.0, 1012.0, 1009.0, 1025.0, 1037.0])


def test_a_stiffness_that_follows_the_release_in_every_group_is_no_scatter():
    rising = [green(DRIFTING, np.geomspace(0.01, 0.05, 5)) for _ in range(4)]
    said = no_scatter(rising)
    both = "rises with the size of the release, and as much in the order of the trials' names, by 3.4 % in 4 groups"
    assert f"stiffness over mass of single trials {both}" in said
    assert "temperature, a part that works loose" in said
    assert "by chance in at most one campaign of " in said
    mixed = np.array([0.03, 0.011, 0.05, 0.02, 0.035])
    assert "rises in the order of the trials' names" in no_scatter([green(DRIFTING, mixed) for _ in range(4)])
    assert no_scatter(rising[:1]) == ""  # nine of ten pairs: one in twelve by chance
    small = 1000.0 + 0.1 * (DRIFTING - 1000.0)
    assert no_scatter([green(small, np.geomspace(0.01, 0.05, 5)) for _ in range(4)]) == ""
    missing = [replace(g, verdict=replace(g.verdict, status="unknown", verdict=("unknown",))) for g in rising]
    assert no_scatter(missing) == ""
    assert no_scatter([]) == ""


def test_an_order_is_said_also_where_trials_differ_too_much_for_anything_else():
    """A stiffness that rose by 4 % was "cannot tell, releases that differ less"; by 1.6 % its order was said."""
    mixed = np.array([0.03, 0.011, 0.05, 0.02, 0.035])
    rising = [green(DRIFTING, mixed) for _ in range(4)]
    wide = Gate("upper_bound", "what can hide", 0.4, 0.15, False, "repetitions differ", "wide", ("nothing_missing",))
    apart = [
        replace(g, verdict=replace(g.verdict, status="cannot_tell", because=wide.because, decision=(wide,)))
        for g in rising
    ]  # fmt: skip
    said = no_scatter(apart)
    assert "rises in the order of the trials' names, by 3.4 % in 4 groups" in said
    (first, *_), doubts = with_doubts(apart)
    assert first.verdict.status == "cannot_tell"
    assert said in first.verdict.sentence
    assert first.verdict.next_test.startswith("the first releases once more at the end of the series")
    assert any(said in doubt for doubt in doubts)
    other = replace(wide, gate="channels_agree")
    quarrel = [replace(g, verdict=replace(g.verdict, decision=(other,))) for g in apart]
    assert no_scatter(quarrel) == ""


def test_what_differs_by_more_than_rigs_do_needs_less_of_an_order():
    """A mass that leaks by .8 % a trial, and a stiffness that falls by .3 %, had been green at 95 to 99 %."""
    leak = np.array([1000.0, 1008.0, 1016.0, 1024.0, 1032.0])
    amplitudes = np.array([0.03, 0.011, 0.05, 0.02, 0.035])
    groups = [green(leak[:4], amplitudes[:4]), green(leak, amplitudes)]  # one in 1,400 by chance
    assert "rises in the order of the trials' names, by 2.8 % in 2 groups" in no_scatter(groups)
    small = 1000.0 + 0.3 * np.array([0.0, 2.0, 3.0, 24.0, 32.0])  # as much as rigs scatter, and on no line
    assert no_scatter([green(small[:4], amplitudes[:4]), green(small, amplitudes)]) == ""
    assert no_scatter([green(leak[:4], amplitudes[:4]), green(leak[::-1], amplitudes)]) == ""


@pytest.mark.parametrize(("scatter", "most"), [(0.005, 1), (0.02, 6)])  # .2 and 2 expected
def test_scatter_is_hardly_ever_said_to_follow_the_release(scatter, most):
    rng, plain = np.random.default_rng(2), green(DRIFTING, np.geomspace(0.01, 0.05, 5))

    def scattered() -> GroupFindings:
        trials = []
        for trial in plain.trials:
            numbers = {"k_N_per_m": Estimate(1000.0 * float(1.0 + scatter * rng.standard_normal()), 1.0, unit="N/m")}
            trials.append(replace(trial, fits={"output_error": Fit("", ("r",), {}, numbers)}))
        return replace(plain, trials=tuple(trials))

    assert sum(bool(no_scatter([scattered() for _ in range(3)])) for _ in range(200)) <= most


def test_of_water_s_trials_a_lighter_one_counts_as_a_stiffer_one():
    plain = green(DRIFTING, np.geomspace(0.01, 0.05, 5))
    trials = []
    for trial, mass in zip(plain.trials, 1e6 / DRIFTING, strict=True):
        numbers = {"total_mass_kg": Estimate(float(mass), 1.0, unit="kg")}
        trials.append(replace(trial, fits={"output_error": Fit("", ("r",), {}, numbers)}))
    assert "rises with the size of the release" in no_scatter([replace(plain, trials=tuple(trials))] * 4)


def test_a_part_left_on_the_body_from_one_trial_on_is_said_in_the_order_of_the_index():
    """4 % of mass on the last seven of fifteen trials that scatter by .4 %: cannot tell, with no word of it."""
    rng = np.random.default_rng(4)
    own = 1000.0 * (1.0 + 0.004 * rng.standard_normal(15))
    own[8:] *= 0.96
    mixed = rng.permutation(15)
    group = green(own[mixed], np.geomspace(0.05, 0.01, 15)[mixed])  # names t0, t1, ... say nothing of the order
    order = [f"t{np.flatnonzero(mixed == place)[0]}" for place in range(15)]
    said = no_scatter([group], order)
    assert said.startswith(f"stiffness over mass is lower from one trial on, by 4.1 % from trial {order[8]} (by ")
    assert "a part taken off or left on the body" in said
    for gate, as_before in (("nothing_left", said), ("channels_agree", "")):
        bars = (Gate(gate, "", 1.0, 0.0, False, "why"),)
        silent = replace(group, verdict=replace(group.verdict, status="cannot_tell", because="why", decision=bars))
        assert no_scatter([silent], order) == as_before
    assert no_scatter([replace(group, verdict=replace(group.verdict, status="unknown"))], order) == ""
    assert "rises with the size of the release, by 5.7 %" in no_scatter([group])  # the names say nothing of the order


def test_a_rig_that_warms_up_is_seen_in_three_and_four_trials():
    """k fell by .6 % a trial with .05 % of scatter: 144 orders of ranks cannot tell, and the run was green."""
    scatter = 1.0 + 0.0005 * np.random.default_rng(0).standard_normal(7)
    k = 1000.0 * (1.0 - 0.006 * np.arange(7)) * scatter
    sizes = np.array([0.05, 0.03, 0.04])
    said = no_scatter([green(k[:3], sizes), green(k[3:], np.array([0.03, 0.05, 0.02, 0.04]))])
    assert said.startswith("stiffness over mass of single trials falls in the order of the trials' names, by 1.5 %")
    scattered = 1000.0 + 6.0 * np.random.default_rng(1).standard_normal(7)
    assert no_scatter([green(scattered[:3], sizes), green(scattered[3:], np.array([0.03, 0.05, 0.02, 0.04]))]) == ""


def test_one_trial_apart_is_no_change_from_one_trial_on():
    own = np.array([1000.0, 1003.0, 998.0, 1001.0, 999.0, 1002.0, 1000.0, 1080.0])
    assert no_scatter([green(own, np.array([3.0, 1.0, 2.0, 3.1, 1.1, 2.1, 1.5, 2.5]))]) == ""


@pytest.mark.parametrize("trials", [4, 9])
def test_scatter_changes_at_no_trial(trials):
    rng = np.random.default_rng(trials)
    releases = np.linspace(0.01, 0.05, trials)

    def scattered() -> GroupFindings:
        return green(1000.0 * (1.0 + 0.02 * rng.standard_normal(trials)), rng.permutation(releases))

    assert sum(bool(no_scatter([scattered() for _ in range(3)])) for _ in range(30)) <= 1
