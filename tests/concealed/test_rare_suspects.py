"""Masses that change, bristles in friction's place, laws beyond doubt inside repeatability, and transfer of springs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.concealed.test_diagnosis import LONG, SCATTER, SHORT, SPECIMEN, SPRINGS, member
from undertow.comparison import joint
from undertow.comparison.candidate import Candidate, doubt
from undertow.comparison.deviations import of_the_means
from undertow.comparison.joining import has_room
from undertow.comparison.joint import build, fit_joint, fit_standing, shared_theta
from undertow.comparison.level import Addend, Member, make_level
from undertow.comparison.replicas import believed_widths
from undertow.comparison.search import diagnose
from undertow.comparison.suspect import Scales
from undertow.comparison.suspects import SUSPECTS, chosen
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.discrepancy.case import Case
from undertow.discrepancy.judge import judge, undecided
from undertow.discrepancy.transfer import from_other_springs
from undertow.discrepancy.validation import addition_parameters, learned_structure, shared_run
from undertow.discrepancy.verdict import Described
from undertow.equation import registry
from undertow.equation.kernel import SLOT
from undertow.likelihood.free_run import free_run, repeatability
from undertow.methods.dry import DEFAULT_SCATTER, believed
from undertow.uncertainty.confidence import widening

RESONATOR = ((registry.find("hidden_resonator", natural_frequency_rad_per_s=9.4, damping_ratio=0.015), 250.0),)


def suspect(name: str):
    """A suspect by its name."""
    return next(s for s in SUSPECTS if s.name == name)


def bristles(level) -> Addend:
    """The suspect of bristles as it is added."""
    return Addend("presliding", suspect("presliding").additions(level.scales, 0.5))


@pytest.fixture(scope="module")
def plain():
    """A short spring's level with nothing hidden."""
    return make_level([member("short", SHORT, 4000)])


def test_bristles_take_friction_with_its_scatter_into_their_own_slot(plain):
    before, after = build(plain, ()), build(plain, (bristles(plain),))
    friction = before.trials[0].base[SLOT["fc"]]
    assert friction > 100.0
    assert after.trials[0].base[SLOT["fc"]] == 0.0
    assert after.trials[0].base[SLOT["fb"]] == pytest.approx(friction)
    moved = {after.unknowns[link.unknown].name.split("[")[0].split("@")[0]
             for link in after.trials[0].links if link.slot == SLOT["fb"]}  # fmt: skip
    assert moved == {"mu_mean", "mu"}
    assert all(link.slot != SLOT["fc"] for link in after.trials[0].links)


def test_bristles_of_one_spring_leave_the_other_its_friction():
    level = make_level([member("short", SHORT[:1], 4010), member("long", LONG[:1], 4020)])
    addition = replace(bristles(level).additions[0], scope="spring", by_spring=(("short", 1e5, 1e3),))
    short, long = build(level, (Addend("presliding", (addition,)),)).trials
    assert short.base[SLOT["fc"]] == 0.0
    assert long.base[SLOT["fc"]] > 100.0
    assert long.base[SLOT["fb"]] == 0.0


def test_repetitions_differ_through_the_force_at_which_bristles_yield(plain):
    motion = plain.members[0].motions[-1]
    theta = plain.members[0].model.theta({"added_mass_kg": 300.0, "drag_coefficient": 1.0}, motion.name)
    theta[SLOT["fb"]], theta[SLOT["fc"]], theta[SLOT["kb"]] = theta[SLOT["fc"]], 0.0, 1e6
    run = free_run(motion, theta, 1e-4)
    friction = 0.1 * theta[SLOT["fb"]]
    assert repeatability(run, {"fb": friction}, 0.001, "displacement", 0) > 0.005  # the sensors' floor is 0.001


def test_only_bristles_and_a_later_start_have_no_value_at_which_they_are_not_there():
    assert {s.label for s in SUSPECTS if s.has_no_zero} == {"presliding", "imperfect_release (a hold that fades)"}


@pytest.mark.parametrize("stiff", [5.0, 50.0])
def test_bristles_are_found_however_stiff_a_rail_is(stiff):
    """At 20 times the spring the search had ended, and a resonator stood in their place."""
    stiffness, _, mu = SPRINGS["short"]
    friction = mu * SPECIMEN.normal_force_N
    yields = registry.find("hysteresis", yield_displacement_m=friction / (stiff * stiffness))
    hidden = ((registry.find("coulomb_friction"), -friction), (yields, stiff * stiffness))
    level = make_level([member("short", SHORT, 4300, hidden)])
    found = diagnose(level, chosen(("presliding", "hidden_resonator", "cubic_stiffness")))
    best = max(found.candidates, key=lambda candidate: candidate.score)
    assert best.names == ("presliding",)
    assert best.aside or not best.out
    assert best.fit.value("presliding.stiffness_N_per_m") == pytest.approx(stiff * stiffness, rel=0.3)


def heavier(plain: Member, kilograms: float, seed: int) -> Member:
    """The same group with its last trial recorded from a body of more mass."""
    one = member("short", SHORT[-1:], seed, ((registry.find("added_mass"), kilograms),))
    return replace(plain, motions=(*plain.motions[:-1], *one.motions))


def test_a_mass_taken_on_between_trials_is_named_with_its_size():
    level = make_level([heavier(member("short", SHORT, 4100), 250.0, 4102), member("long", LONG, 4120)])
    found = diagnose(level, chosen(("linear_damping", "cubic_stiffness", "mass_change", "relaxation")))
    assert found.best.names == ("mass_change",)
    change = addition_parameters(found.best.fit, "short")["mass_change"][0]["mass_kg"]
    assert change.value == pytest.approx(250.0, rel=0.1)


def test_masses_that_do_not_change_are_not_named(plain):
    assert diagnose(plain, chosen(("mass_change",))).best.names == ()


def test_a_law_beyond_doubt_is_named_though_repetitions_differ_by_more():
    hidden = ((registry.find("relaxation", time_s=0.2), 3e4),)
    group = member("short", SHORT, 4200, hidden)
    wide = replace(group, allowed=0.5)  # a rig that repeats so badly that no free run shows anything
    found = diagnose(make_level([wide]), chosen(("relaxation", "sensor_drift", "cubic_stiffness")))
    assert found.best.names == ("relaxation",)


def test_a_sensor_is_not_named_for_what_a_law_explains_better():
    hidden = ((registry.find("relaxation", time_s=0.5), 3e4),)
    wide = replace(member("short", SHORT, 4200, hidden), allowed=0.5)
    found = diagnose(make_level([wide]), chosen(("relaxation", "sensor_drift")))
    assert "sensor_drift" not in found.best.names


def test_one_spring_alone_predicts_the_other_through_the_resonator_it_found():
    level = make_level([member("short", SHORT, 4300, RESONATOR), member("long", LONG, 4320, RESONATOR)])
    found = diagnose(level, chosen(("hidden_resonator", "linear_damping")))
    assert found.best.names == ("hidden_resonator",)
    trials = [m.motions for m in level.members]
    short, long = from_other_springs(level, found.best.fit, trials)
    assert set(short) == {"long"}
    assert set(long) == {"short"}
    without = fit_joint(level, (), 1.0, {}, 10.0, growing=True)
    (nothing, _) = from_other_springs(level, without, trials)
    assert short["long"] < 0.3 * nothing["long"]
    theta = shared_theta(level, level.members[0], found.best.fit, trials[0][0].name)
    assert theta[SLOT["hm1"]] == pytest.approx(250.0, rel=0.1)


def test_what_belongs_to_one_spring_transfers_to_none():
    stiff = ((registry.find("cubic_stiffness"), 3e7),)
    level = make_level([member("short", SHORT, 4400, stiff), member("long", LONG, 4420, stiff)])
    addend = Addend("cubic_stiffness", suspect("cubic_stiffness").additions(level.scales, 0.0))
    fit = fit_joint(level, (addend,), 1.0, {}, 10.0, growing=True)
    assert from_other_springs(level, fit, [m.motions for m in level.members]) == ({}, {})
    assert np.isfinite(fit.criterion)


@pytest.mark.parametrize("missing", [0, 3])
def test_a_level_that_cannot_be_searched_is_neither_green_nor_red(plain, missing):
    member, before = plain.members[0], Described(0.3, float("nan"))
    case = Case({"spring": "short"}, "spring short", member, (), before, 0.01, 0.05, missing, False, True)
    (verdict,) = undecided([case], "no motion within bounds").verdicts
    assert (verdict.status, verdict.verdict) == ("cannot_tell", ())
    assert verdict.because == "no suspect could be tried: no motion within bounds"
    assert verdict.because in verdict.sentence


def test_masses_that_differ_as_stiffness_does_on_any_rig_are_not_named():
    alike = heavier(member("short", SHORT, 4100), 20.0, 4102)  # 0.7 % of the mass: a third of a per cent in frequency
    sure = replace(alike.model.fixed, scatter={**SCATTER, "k": 1e-5})  # dry trials that happened to look alike
    level = make_level([replace(alike, model=replace(alike.model, fixed=sure), allowed=0.01)])
    found = diagnose(level, chosen(("mass_change",)))
    assert found.best.names == ()
    assert any("no more than stiffness differs" in c.out for c in found.candidates)


def test_masses_are_held_against_the_scatter_with_the_trials_that_showed_it():
    one = heavier(member("short", SHORT, 4100), 250.0, 4102)
    known, hardly = (replace(one.model.fixed, scatter_freedom=freedom) for freedom in (20.0, 1.0))
    for fixed, names in ((known, ("mass_change",)), (hardly, ())):
        level = make_level([replace(one, model=replace(one.model, fixed=fixed))])
        found = diagnose(level, chosen(("mass_change",)))
        assert found.best.names == names
        assert any("no more than stiffness differs" in c.out for c in found.candidates) is not bool(names)


def test_masses_that_differ_are_held_against_all_that_moves_with_its_water():
    """A share of stiffness is a share of the mass that swings: of a body that takes much water along more kilograms."""
    usual = 3.0 * max(DEFAULT_SCATTER["k"], SCATTER["k"])
    one = heavier(member("short", SHORT, 4100), usual * 2820.0 * 3.0 / math.sqrt(2.0), 4102)  # 2,637 kg, 2,987 in water
    level = make_level([one])
    fit = fit_joint(level, (Addend("mass_change", suspect("mass_change").additions(level.scales, 0.0)),), 1.0, {}, 10.0,
                    growing=False)  # fmt: skip
    differ = np.std([fit.value(n) for n in fit.solution.problem.names if n.startswith("mass_change.")])
    assert level.scales.mass < differ / usual < fit.theta(0)[SLOT["mass"]]
    assert "no more than stiffness differs" in doubt(level, fit)


def with_cells(group: Member, ratios: Sequence[float]) -> Member:
    """The group with load cells that show so many times its stiffness, trial by trial."""

    def seen(motion: Motion, ratio: float) -> Motion:
        """The motion conditioned again, with load cells."""
        channels = motion.recording.channels
        force = ratio * group.model.fixed.k.value * channels["displacement"]
        return condition(replace(motion.recording, channels={**channels, "spring_force": force}))

    return replace(group, motions=tuple(seen(*pair) for pair in zip(group.motions, ratios, strict=True)))


@pytest.mark.parametrize(("ratios", "told"), [((1.0, 1.001, 0.999), True), ((1.0, 1.0, 0.93), False)])
def test_load_cells_tell_masses_that_differ_from_stiffness_that_differs(ratios, told):
    one = heavier(member("short", SHORT, 4100), 250.0, 4102)
    hardly = replace(one.model.fixed, scatter_freedom=1.0)
    level = make_level([with_cells(replace(one, model=replace(one.model, fixed=hardly)), ratios)])
    fit = fit_joint(level, (Addend("mass_change", suspect("mass_change").additions(level.scales, 0.0)),), 1.0, {}, 10.0,
                    growing=False, quick=True)  # fmt: skip
    assert ("no more than stiffness differs" in doubt(level, fit)) != told


def test_a_strong_resonator_is_found_though_repetitions_differ_by_nearly_as_much():
    hidden = ((registry.find("hidden_resonator", natural_frequency_rad_per_s=14.2, damping_ratio=0.018), 600.0),)
    wide = replace(member("short", SHORT, 4400, hidden), allowed=0.13)
    found = diagnose(make_level([wide]), chosen(("hidden_resonator", "imperfect_release", "linear_damping")))
    assert found.best.names == ("hidden_resonator",)
    assert found.best.fit.value("hidden_resonator.mass_kg") == pytest.approx(600.0, rel=0.05)


def test_an_echo_is_found_wherever_it_comes_back():
    hidden = ((registry.find("delayed_echo", delay_s=2.58), 2900.0),)
    wide = replace(member("short", SHORT, 4500, hidden), allowed=0.35)
    found = diagnose(make_level([wide]), chosen(("delayed_echo", "imperfect_release")))
    assert found.best.names == ("delayed_echo",)
    assert found.best.fit.value("delayed_echo.delay_s") == pytest.approx(2.58, abs=0.01)


def test_what_every_cycle_shows_is_not_the_releases_fault():
    hidden = ((registry.find("cubic_damping"), 8e4),)
    found = diagnose(make_level([member("short", SHORT, 4600, hidden)]), chosen(("imperfect_release",)))
    assert found.best.names == ()
    ahead = [c.out for c in found.candidates if c.score > found.null.score + 5.0]
    assert ahead
    assert all("times the sensors' noise" in out for out in ahead)


def prior_of(problem, name: str) -> float:
    """Prior standard deviation of the first unknown whose name starts so."""
    return next(u.prior_std for u in problem.unknowns if u.name.startswith(name))


def seen_with(plain: Member, freedom: float) -> Member:
    """The same group, its scatter seen with so many degrees of freedom."""
    return replace(plain, model=replace(plain.model, fixed=replace(plain.model.fixed, scatter_freedom=freedom)))


def test_scatter_that_few_dry_trials_show_is_pooled_with_published_rigs_and_a_stated_one_is_not(plain):
    group = plain.members[0]
    c = group.model.fixed.c.value
    stated, few, many = (prior_of(build(make_level([seen_with(group, f)]), ()), "c[") / c for f in (np.inf, 2.0, 200.0))
    assert stated == pytest.approx(SCATTER["c"])
    assert few == pytest.approx(believed(SCATTER, 2.0, "c"))
    assert 1.1 * stated < few < DEFAULT_SCATTER["c"]
    assert stated < many < 1.1 * stated


def test_friction_that_dry_trials_named_scatters_from_trial_to_trial_where_the_equation_has_none(plain):
    group = plain.members[0]
    fixed = group.model.fixed
    bare = replace(group, model=replace(group.model, fixed=replace(fixed, mu=replace(fixed.mu, value=0.0))))
    named = replace(suspect("coulomb_friction").additions(plain.scales, 0.0)[0], by_spring=(("short", 150.0, 2.0),))
    standing = (Addend("coulomb_friction", (named,)),)
    assert prior_of(build(make_level([bare], standing), standing), "friction_N[") == pytest.approx(15.0)
    owned = build(make_level([group], standing), standing)
    assert not any(u.name.startswith("friction_N[") for u in owned.unknowns)


def test_what_is_not_asked_for_is_paid_for(plain):
    asked = fit_joint(plain, (), 1.0, {}, 2.0, growing=True)
    spared = fit_joint(plain, (Addend("imperfect_release", (), late=1.0),), 1.0, {}, 2.0, growing=True)
    steps = 20.0 * len(asked.solution.problem.trials)  # a force held the body for a period in every trial
    assert spared.criterion - asked.criterion > 0.5 * steps * np.log(asked.solution.n_data)


@pytest.mark.parametrize(("memory", "numbers"), [(1.0, 40.0), (4.0, 40.0), (10.0, 20.0)])
def test_a_skipped_period_costs_a_number_a_step_of_its_force_or_a_sample_that_tells_something(memory, numbers):
    channels, t = (None, None), np.arange(250) / 100.0
    trials = tuple(SimpleNamespace(channels=channels, t=t, period_s=p) for p in (0.5, 0.5))
    cost = joint._skipped(SimpleNamespace(trials=trials), (Addend("imperfect_release", (), late=1.0),), memory)
    assert cost == pytest.approx(numbers * np.log((2 * 2 * 250 + 2 * 2 * 50) / memory))
    assert joint._skipped(SimpleNamespace(trials=trials), (), memory) == 0.0


def test_a_memory_that_recordings_hold_beyond_doubt_is_not_called_damping():
    hidden = ((registry.find("relaxation", time_s=0.2), 4.4e4),)
    wide = replace(member("long", (0.06, 0.1), 4700, hidden), allowed=0.3)  # free runs with a dashpot are within it
    found = diagnose(make_level([wide]), chosen(("linear_damping", "relaxation")))
    assert found.best.names == ("relaxation",)


def test_unseen_trials_that_come_no_closer_leave_something_unknown():
    hidden = ((registry.find("linear_damping"), 900.0),)
    group = member("short", SHORT, 4800, hidden)
    held = member("short", SHORT[-1:], 4810).motions  # nothing is hidden in it
    case = Case(
        {"spring": "short"}, "short", group, held, Described(0.3, 0.02, {}), 0.005, 0.05, 3, False, True, {}, False
    )
    (verdict,) = judge((case,), chosen(("linear_damping",)))
    assert verdict.verdict == ("linear_damping", "unknown")
    assert verdict.status == "unknown"


def test_trials_beside_a_too_narrow_repeatability_are_not_unknown_where_scatter_explains_them():
    group = member("short", SHORT, 4850)
    case = Case(
        {"spring": "short"}, "short", group, (), Described(0.03, math.nan, {}), 0.005, 0.05, 2, True, False, {}, False
    )
    (verdict,) = judge((case,), chosen(("linear_damping",)))
    assert verdict.status == "nothing_missing"
    assert "explains 1 of 3 trials within repeatability and the group as a whole" in verdict.sentence
    (outside,) = judge((replace(case, baseline=Described(0.06, math.nan, {})),), chosen(("linear_damping",)))
    assert outside.status == "cannot_tell"  # noise is all that is left: that trials differ is no missing physics
    assert outside.p_value > 0.01
    assert "trials may differ by more than is known" in outside.because


def test_an_added_mass_is_no_suspect_where_nothing_gives_kilograms(plain):
    fit = fit_standing(plain)
    assert not has_room(plain, suspect("added_mass"), fit)  # the equation has one
    (one,) = plain.members
    model = replace(one.model, coefficients=tuple(c for c in one.model.coefficients if c.slot != "mass"))
    without = replace(plain, members=(replace(one, model=model),))
    assert has_room(without, suspect("added_mass"), fit)
    scaled = replace(without, members=(replace(one, model=replace(model, anchored=False)),))
    assert not has_room(scaled, suspect("added_mass"), fit)
    # dry trials that alone say what k is, in units of the stated mass: 7 % of it, negative, had outweighed an answer
    for stiffness, room in ((math.nan, False), (4e5, True)):
        specimen = replace(model.specimen, stiffness_N_per_m=stiffness)
        own = replace(one, model=replace(model, specimen=specimen), own_means=True)
        assert has_room(replace(without, members=(own,)), suspect("added_mass"), fit) is room


def test_a_mass_that_differs_is_no_suspect_of_trials_that_alone_show_how_much_trials_differ(plain):
    fit, (one,) = fit_standing(plain), plain.members

    def room(freedom: float, dry: bool) -> bool:
        fixed = replace(one.model.fixed, scatter_freedom=freedom)
        member = replace(one, model=replace(one.model, fixed=fixed), own_means=dry)
        return has_room(replace(plain, members=(member,)), suspect("mass_change"), fit)

    assert room(math.inf, True)  # stated in the config
    assert room(2.0, False)  # seen in dry trials, asked of wet ones
    assert not room(2.0, True)
    assert not room(0.0, True)


def test_dry_means_differ_by_the_covariance_that_dry_trials_left(plain):
    (one,) = plain.members
    errors = {"k": 1.0, "c": 20.0, "mu": 1e-3}
    fixed = replace(one.model.fixed, mean_errors=errors, c_with_mu=-0.9)
    means = of_the_means(replace(one, model=replace(one.model, fixed=fixed)))
    slopes = np.array([[mean.prior_std * dict(mean.moves).get(s, 0.0) for mean in means] for s in errors])
    sizes = np.array(list(errors.values()))
    expected = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -0.9], [0.0, -0.9, 1.0]]) * np.outer(sizes, sizes)
    assert slopes @ slopes.T == pytest.approx(expected)
    assert len(means) == 3
    loose = replace(fixed, k=replace(fixed.k, stderr=100.0))
    own = of_the_means(replace(one, model=replace(one.model, fixed=loose), own_means=True))
    assert (own[0].prior_std, own[0].believed_std) == (100.0, 1.0)  # the fit is of the trials that gave the mean
    few = replace(fixed, k=replace(fixed.k, freedom=2.0))
    wide = of_the_means(replace(one, model=replace(one.model, fixed=few)))
    assert (wide[0].prior_std, wide[0].believed_std) == (widening(2.0), 1.0)  # no fit leans on few trials
    level = make_level([replace(one, model=replace(one.model, fixed=few))])
    fit = fit_standing(level)
    widths = dict(zip(fit.solution.problem.names, believed_widths(level, fit.solution), strict=True))
    assert [widths[mean.name] for mean in wide] == [mean.believed_std for mean in wide]  # replicas differ by what is


def test_a_description_hears_what_trials_in_water_say_of_the_dry_means(plain):
    fit, (member,) = fit_standing(plain), plain.members
    motion = member.motions[0]
    told, learned = (shared_theta(plain, member, fit, motion.name, asked) for asked in (False, True))
    assert told[SLOT["k1"]] == member.model.trial_base(motion.name)[SLOT["k1"]]
    assert fit.value("k_mean@short") != 0.0
    assert learned[SLOT["k1"]] - told[SLOT["k1"]] == pytest.approx(fit.value("k_mean@short"), rel=1e-6)
    run = shared_run(plain, member, fit, motion, member.options.rest_offset_std)
    assert run.theta[SLOT["k1"]] == learned[SLOT["k1"]]
    said = learned_structure(member, fit)
    assert set(said) == {"k_N_per_m", "c_Ns_per_m", "mu"}
    assert said["k_N_per_m"].value == pytest.approx(learned[SLOT["k1"]])
    assert said["mu"].value * member.model.specimen.normal_force_N == pytest.approx(learned[SLOT["fc"]])
    assert said["c_Ns_per_m"].stderr == fit.solution.stderr("c_mean@short")


@pytest.mark.parametrize(
    ("name", "values", "called"),
    [
        ("stribeck_friction", {"static_force_N": 3.0, "velocity_m_per_s": 0.05}, "stribeck_friction"),
        ("stribeck_friction", {"static_force_N": 3.0, "velocity_m_per_s": 0.1}, "coulomb_friction"),
        ("relaxation", {"stiffness_N_per_m": 3.0, "time_s": 0.3}, "relaxation"),
        ("relaxation", {"stiffness_N_per_m": 3.0, "time_s": 0.25}, "linear_damping"),
        ("relaxation", {"stiffness_N_per_m": 3.0, "time_s": 10.0}, "relaxation"),
    ],
)
def test_a_law_on_its_bound_is_called_what_it_has_become(name, values, called):
    """Friction that fades no more within the motion's speeds is dry, a relaxation that forgets at once is damping."""
    (found,) = chosen((name,))
    additions = found.additions(Scales(1.0, 1.0, 0.2, 1.0, 1.0, 1.0), 0.006 if name == "stribeck_friction" else 1.0)
    fit = SimpleNamespace(
        addends=(Addend(found.name, additions),), values={f"{name}.{slot}": value for slot, value in values.items()}
    )
    assert Candidate((found,), fit, 0.0).amounts_to == (called,)
