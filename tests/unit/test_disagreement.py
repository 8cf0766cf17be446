"""Trials that differ by more than their errors: joint errors grow until they agree, else they stay."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import undertow
from tests.findings_fixture import small_findings
from undertow.campaign.run.differing import grown_between, with_grown_errors
from undertow.discrepancy.findings import GroupFindings
from undertow.discrepancy.verdict import Described
from undertow.equation.equation import Equation
from undertow.equation.hydrodynamics import AddedMass
from undertow.equation.structure import Stiffness
from undertow.likelihood.fit import Fit
from undertow.quantities import Estimate
from undertow.uncertainty.disagreement import (
    ALIKE,
    OF_ONE_TRIAL,
    _share_of_squares,
    differing,
    grown,
    scatter_to_agree,
    with_scatter,
)
from undertow.uncertainty.growth import HALVES, LEVELS, SPRINGS, TRIALS, Grown, grown_words

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
    said = f"than the fit's own: mass_kg ({found[0].grown:.2g}) between trials fitted alone"
    assert grown_words(found)[0].endswith(said)


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
    after, found = with_grown_errors(fits, singles)
    assert after["sindy"].parameters["mass_kg"].stderr > 1.0
    assert [one.parameter for one in found] == ["mass_kg"]
    assert after["decay"] == fits["decay"]
    mean = Fit("sindy", ("a", "b"), {}, joint, notes=("mean over trials, each fitted alone",))
    assert with_grown_errors({"sindy": mean}, singles) == ({"sindy": mean}, ())


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
    assert any("differ by more than the fit's own: c_Ns_per_m (" in note for note in found.notes)


def test_fit_of_one_trial_says_that_its_intervals_are_of_this_trial():
    found = undertow.fit(decays(2.0), list(LAW), mass_kg=4.0)
    assert OF_ONE_TRIAL in found.notes
    assert OF_ONE_TRIAL in str(found)


def test_halves_of_the_amplitude_that_differ_make_an_error_grow_that_trials_do_not():
    joint = {"mass_kg": Estimate(10.0, 0.5, 0.2, "kg", "output error")}
    trials = alone(9.3, 10.7, 9.3, 10.7)
    assert grown(joint, trials)[1] == ()
    assert grown(joint, trials, (1.0, 2.0, 3.0, 4.0))[1] == ()  # small and large alike: 9.3 and 10.7 in both halves
    after, found = grown(joint, trials, (1.0, 4.0, 2.0, 3.0))
    # halves 9.3 and 10.7, each with 1/sqrt(2): 1.4^2 = 1 + 2 s^2, and the mean of both has s/sqrt(2)
    assert after["mass_kg"].stderr == pytest.approx(math.hypot(0.5, math.sqrt(0.48 / 2.0)), rel=1e-9)
    assert (found[0].among, found[0].chi_squared) == (HALVES, pytest.approx(1.96))
    assert after["mass_kg"].source == "output error; trials differ"
    assert grown_words(found)[0].endswith("between trials of small and of large amplitude")


def test_three_trials_have_no_halves():
    joint = {"mass_kg": Estimate(10.0, 0.5, unit="kg")}
    assert grown(joint, alone(9.4, 10.0, 10.6), (1.0, 2.0, 3.0)) == grown(joint, alone(9.4, 10.0, 10.6))


@pytest.mark.parametrize("values", [(9.0, 11.0), (1.0, 2.0, 9.0), (0.0, 0.0, 3.0, 4.0)])
def test_with_the_scatter_to_agree_chi_squared_is_its_degrees_of_freedom(values):
    numbers, noise = np.array(values), 0.1 * np.arange(1.0, 1.0 + len(values))
    between = scatter_to_agree(numbers, noise)
    assert differing(numbers, np.hypot(noise, between))[0] == pytest.approx(len(values) - 1, rel=1e-6)


def test_numbers_that_agree_need_no_scatter_and_keep_their_estimate():
    assert scatter_to_agree(np.array([1.0, 1.1]), np.array([1.0, 1.0])) == 0.0
    estimate = Estimate(1.0, 0.5, unit="kg")
    assert with_scatter(estimate, 0.0) is estimate
    twice = with_scatter(with_scatter(estimate, 1.0), 1.0)
    assert (twice.stderr, twice.source) == (pytest.approx(1.5), "trials differ")


def group_at(spring: str, depth: float, added: float, stiffness: float, dry: bool = False) -> GroupFindings:
    """A group whose own fit says these, each within 10."""
    group = next(g for g in small_findings().groups if not g.dry)
    numbers = {"added_mass_kg": Estimate(added, 8.0, 6.0, "kg"), "k_N_per_m": Estimate(stiffness, 10.0, 0.0, "N/m")}
    equation = Equation((AddedMass(), Stiffness()), (added, stiffness), mass_kg=1000.0)
    errors = {"mass": 10.0, "added_mass": 10.0, "stiffness": 10.0}
    prescribed = Described(0.1, parameters={"added_mass_kg": numbers["added_mass_kg"]})
    verdict = replace(group.verdict, baseline=prescribed)
    return replace(
        group, verdict=verdict, key={"spring": spring, "water_depth_m": depth}, dry=dry, structure=None, notes=(),
        equation=equation,
        equation_errors=errors, fits={"output_error": Fit("output_error", ("r",), {}, numbers)},
    )  # fmt: skip


def test_springs_of_one_water_that_differ_in_added_mass_have_errors_with_which_they_agree():
    groups = [group_at("long", 2.0, 900.0, 5e3), group_at("short", 2.0, 700.0, 9e3), group_at("long", 1.0, 300.0, 5e3)]
    after = grown_between(groups, ["water_depth_m"])
    expected = math.hypot(8.0, math.sqrt((200.0**2 - 2.0 * 10.0**2) / 2.0))
    for group in after[:2]:
        assert group.fits["output_error"].parameters["added_mass_kg"].stderr == pytest.approx(expected)
        assert group.equation_errors["added_mass"] > 100.0
        assert group.verdict.baseline.parameters["added_mass_kg"].stderr == pytest.approx(expected)
        assert group.equation_errors["stiffness"] == 10.0
        assert [(one.parameter, one.among) for one in group.grown] == [("added_mass_kg", SPRINGS)]
        assert group.grown[0].grown == pytest.approx(expected / 8.0)
        assert group.remarks[-1].endswith("between groups in the same water")
    assert after[2] is groups[2]


def test_a_parameter_that_several_methods_give_stands_once_with_its_largest_growth():
    each = ((2.0, TRIALS), (3.14, TRIALS), (1.5, LEVELS))
    found = [Grown("mu", 9.0, 3, 0.03, times, among) for times, among in each]
    (said,) = grown_words(found)
    assert said.endswith(": mu (3.1) between trials fitted alone; mu (1.5) between groups on the same spring")


def test_levels_of_one_spring_that_differ_in_stiffness_do_so_too_but_not_dry_groups_or_unknown_water():
    groups = [group_at("long", 2.0, 900.0, 5000.0), group_at("long", 1.0, 300.0, 5300.0)]
    after = grown_between(groups, ["water_depth_m"])
    assert [g.fits["output_error"].parameters["k_N_per_m"].stderr > 200.0 for g in after] == [True, True]
    assert [g.fits["output_error"].parameters["added_mass_kg"].stderr for g in after] == [8.0, 8.0]
    assert grown_between(groups, []) == groups
    dry = [groups[0], group_at("long", 1.0, 300.0, 5300.0, dry=True)]
    assert grown_between(dry, ["water_depth_m"]) == dry


@pytest.mark.parametrize("unit", [1.0, 1e-160])
def test_a_trial_with_twice_the_noise_counts_a_quarter_in_any_unit(unit):
    """Numbers of 1e-160 of noise overflowed, with six lines of warnings before the sentence."""
    assert _share_of_squares(unit * np.array([1.0, 2.0])) == pytest.approx((1.0 + 0.25**2) / 1.25**2)
