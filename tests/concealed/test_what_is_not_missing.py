"""Nothing is missing: without dry trials k, c, mu differ all the same, and a logger has its own way at turns."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.concealed.test_diagnosis import EQ15, SHORT, SPECIMEN, member
from tests.concealed.test_small_effects import found as found_suspect
from undertow.comparison.candidate import Candidate
from undertow.comparison.explained import biases
from undertow.comparison.joint import build, fit_joint
from undertow.comparison.jumps import released, turning
from undertow.comparison.level import Addend, Member, make_level
from undertow.comparison.prescribed import at_its_own_sizes
from undertow.comparison.search import diagnose
from undertow.comparison.sizes import COUNTS_IN_STDERR
from undertow.comparison.suspects import chosen
from undertow.conditioning.condition import condition
from undertow.equation import registry
from undertow.equation.kernel import SLOT
from undertow.errors import IdentificationError
from undertow.likelihood import eq15, output_error
from undertow.likelihood.budget import metered
from undertow.likelihood.output_error import shortened
from undertow.likelihood.problem import TrialOptions
from undertow.likelihood.residuals import motion_of
from undertow.methods.baseline import group_model, terms_by_name

SPREAD = {"k1": 0.003, "c1": 0.06, "fc": 0.05}
SIZES = {"k1": 400000.0, "c1": 820.0, "fc": 140.0}


def without_dry(
    trials: int = 3, spread: dict[str, float] | None = None, freedom: float = math.inf,
    sizes: dict[str, float] = SIZES, stiffness: float = math.nan,
) -> Member:
    """A group that fits its own k, c, mu; k is known where a stiffness is given."""
    known = member("short", SHORT[:trials], 4300)
    specimen = replace(SPECIMEN, stiffness_N_per_m=stiffness)
    model = group_model(terms_by_name(EQ15), known.motions, specimen, None, dry=False, anchored=True)
    spread = SPREAD if spread is None else spread
    return Member(
        "short", model, known.motions, TrialOptions(), allowed=0.05, spread=spread, sizes=sizes, freedom=freedom
    )


def test_each_trial_has_its_own_k_c_mu_as_wide_as_trials_differ():
    one = without_dry()
    problem = build(make_level([one]), ())
    held = {u.name: u.prior_std for u in problem.unknowns if u.name.split("[")[0] in ("k", "c", "mu")}
    assert held == {
        f"{symbol}[{motion.name}]": SPREAD[slot] * SIZES[slot]
        for motion in one.motions for symbol, slot in (("k", "k1"), ("c", "c1"), ("mu", "fc"))
    }  # fmt: skip
    for trial in problem.trials:
        slots = {problem.names[link.unknown]: link.slot for link in trial.links}
        assert slots[f"k[{trial.name}]"] == SLOT["k1"]
        assert slots[f"mu[{trial.name}]"] == SLOT["fc"]


@pytest.mark.parametrize("group", [without_dry(trials=1), without_dry(spread={"k1": 0.0})])
def test_a_lone_trial_and_what_does_not_differ_have_none(group):
    names = build(make_level([group]), ()).names
    assert not [n for n in names if n.split("[")[0] in ("k", "c", "mu")]


def test_trials_differ_by_a_share_of_what_their_own_fit_finds():
    small = {"k1": 403000.0, "c1": 100.0, "fc": 140.0}
    level = make_level([without_dry(sizes=small, stiffness=403000.0)])
    settled = at_its_own_sizes(level).members[0]
    assert settled.sizes["c1"] == pytest.approx(820.0, rel=0.15)
    assert settled.sizes["k1"] == small["k1"]
    held = {u.name.split("[")[0]: u.prior_std for u in build(make_level([settled]), ()).unknowns}
    assert held["c"] == pytest.approx(SPREAD["c1"] * settled.sizes["c1"])
    enough = make_level([without_dry(sizes={"k1": 403000.0, "c1": 900.0, "fc": 160.0}, stiffness=403000.0)])
    assert at_its_own_sizes(enough) is enough
    lone = make_level([without_dry(trials=1, sizes=small, stiffness=403000.0)])
    assert at_its_own_sizes(lone) is lone


def test_scatter_of_trials_is_not_left_in_the_residual():
    misfits = []
    for spread in ({}, SPREAD):
        level = make_level([without_dry(spread=spread)])
        misfits.append(fit_joint(level, (), 2.0, {}, 10.0, growing=True).misfit)
    assert misfits[0] > 3.0
    assert misfits[1] < 1.3


def test_how_well_the_scatter_is_known_comes_from_the_group_where_no_dry_trials_say():
    assert without_dry(freedom=0.0).scatter_freedom == 0.0
    assert member("short", SHORT, 4100).scatter_freedom == math.inf  # stated in its structure
    assert replace(without_dry(), freedom=7.0).scatter_freedom == 7.0


def test_an_acceleration_says_nothing_where_a_body_that_rubs_turns():
    one = member("short", SHORT, 4300)
    level = make_level([one])
    problem = build(level, ())
    for trial, motion in zip(problem.trials, one.motions, strict=True):
        seen = {c.quantity: c for c in trial.channels}
        assert seen["displacement"].unsure is None
        unsure = seen["acceleration"].unsure
        velocity = np.interp(trial.t, motion.t, motion.v)
        turns = np.flatnonzero(np.diff(np.sign(velocity)))
        assert np.all(unsure[turns] | unsure[turns + 1])
        assert np.count_nonzero(unsure) <= 4 * turns.size
    terms = terms_by_name(("stiffness", "viscous_damping"))
    smooth = group_model(terms, one.motions, SPECIMEN, None, dry=True, anchored=True)
    without = build(make_level([replace(one, model=smooth)]), ())
    for trial, motion in zip(without.trials, one.motions, strict=True):
        seen = {c.quantity: c.unsure for c in trial.channels}
        assert seen["displacement"] is None
        assert np.array_equal(seen["acceleration"], released(motion, trial.t, trial.width_s))


def test_cells_that_say_nothing_are_left_out_alike_by_both_integrators():
    level = make_level([member("short", SHORT, 4300)])
    problem = build(level, ())
    assert eq15.is_plain(problem)
    found = output_error.fit(problem)
    for trial, r, jac, used in zip(problem.trials, found.residuals, found.jacobians, found.used, strict=True):
        again = output_error.residuals(trial, found.values)
        assert again is not None
        assert r == pytest.approx(again[0], abs=2e-2)  # in standard deviations of noise
        assert np.array_equal(used, again[2])
        silent = np.flatnonzero(trial.channels[1].unsure) + trial.t.size
        assert silent.size
        for rows in (r[silent], again[0][silent], jac[silent], again[1][silent]):
            assert not np.any(rows)


def test_cells_that_say_nothing_stay_so_in_a_shorter_window():
    problem = build(make_level([member("short", SHORT, 4300)]), ())
    for short, whole in zip(shortened(problem, 2.0).trials, problem.trials, strict=True):
        assert np.array_equal(short.channels[1].unsure, whole.channels[1].unsure[: short.t.size])


def test_nor_where_the_body_may_have_been_let_go():
    one = member("short", SHORT, 4300).motions[0]
    step = float(np.median(np.diff(one.t)))
    cells = np.arange(0.0, 20.0) * 2.0 * step
    sure, unsure = (replace(one.window, release_stderr_s=error, held=True) for error in (0.0, 3.0 * step))
    assert np.flatnonzero(released(replace(one, window=sure), cells, 2.0 * step)).tolist() == [0, 1]
    assert np.flatnonzero(released(replace(one, window=unsure), cells, 2.0 * step)).tolist() == [0, 1, 2, 3, 4]
    free = replace(one, window=replace(unsure, held=False))
    assert not np.any(released(free, cells, 2.0 * step))
    group = member("short", SHORT, 4300)
    level = make_level([replace(group, motions=tuple(replace(m, window=unsure) for m in group.motions))])
    for trial in build(level, ()).trials:
        by_sensor = {c.quantity: c.unsure for c in trial.channels}
        assert by_sensor["displacement"] is None
        assert np.all(by_sensor["acceleration"][trial.t < 6.0 * step])


LATE_S = 0.05
"""An eighth of the body's period, thirteen samples."""


def with_late_accelerometer(group: Member) -> Member:
    """The same trials, their accelerometer read by a clock that is late."""

    def late(motion):
        record = motion.recording
        seen = np.interp(record.time - LATE_S, record.time, record.channels["acceleration"])
        return condition(replace(record, channels={**record.channels, "acceleration": seen}))

    return replace(group, motions=tuple(late(m) for m in group.motions))


def test_a_late_accelerometer_shows_the_release_and_the_turns_later():
    group = with_late_accelerometer(member("short", SHORT, 4300))
    level = make_level([group])
    for trial, motion in zip(build(level, ()).trials, group.motions, strict=True):
        assert level.late_s[motion.name] == pytest.approx(LATE_S, abs=2e-3)
        unsure = next(c.unsure for c in trial.channels if c.quantity == "acceleration")
        step = float(np.median(np.diff(trial.t)))
        turns = motion.t[np.flatnonzero(np.diff(np.sign(motion.v)))]
        for turn in turns[turns < 0.5 * motion.window.end_s]:
            assert np.all(unsure[np.abs(trial.t - turn - LATE_S) < 0.5 * step])
        assert np.all(unsure[trial.t < LATE_S])


def test_an_accelerometer_whose_noise_alone_makes_it_late_is_not():
    assert set(make_level([member("short", SHORT, 4300)]).late_s.values()) == {0.0}


def test_so_that_the_body_is_not_held_against_what_its_accelerometer_shows_before():
    level = make_level([with_late_accelerometer(member("short", SHORT, 4300))])
    as_before = replace(level, late_s={})
    names = ("time_shift", "hidden_resonator", "stiffness_drift", "cubic_stiffness")
    assert diagnose(level, chosen(names)).best.names == ("time_shift",)
    late = (Addend("time_shift", (), frees="acceleration_shift_s"),)
    known, unknown = (fit_joint(one, late, 2.0, {}, 10.0, growing=True).misfit for one in (level, as_before))
    assert known < 1.5
    assert unknown > 1.2 * known


def test_a_motion_that_never_turns_has_no_such_cell():
    one = member("short", SHORT, 4300).motions[0]
    assert not np.any(turning(replace(one, v=np.ones_like(one.v)), np.linspace(0.1, 1.0, 20), 0.05))


def test_nor_where_its_motion_ends_and_it_may_stop():
    one = member("short", SHORT, 4300).motions[0]
    t = np.linspace(0.0, 3.0, 3001)
    v = np.where(t < 1.0, np.cos(math.pi * t), -np.exp(-((t - 1.0) ** 2) / 0.36))  # turns at .5 s, slows down
    cells = np.arange(0.01, 2.6, 0.02)
    found = turning(replace(one, t=t, v=v), cells, 0.02)
    assert np.all(found[np.abs(cells - 0.5) < 0.01])
    late = cells > 1.0
    slow = np.abs(np.interp(cells, t, v)) < 0.3
    assert np.array_equal(found[late], slow[late])
    assert np.count_nonzero(slow & late) > 5
    assert not np.any(found[(cells > 0.53) & ~late])  # slow again after a turn is no stop


def test_nor_before_a_turn_that_is_the_stop_itself():
    one = member("short", SHORT, 4300).motions[0]
    t = np.linspace(0.0, 2.4, 2401)
    v = np.cos(math.pi * t) * np.where(t < 1.5, 1.0, 0.5)  # turns at .5, 1.5 s; what is smoothed crosses zero at 2.4 s
    v = np.where(t > 2.38, -1e-3, np.where(t > 2.0, 0.5 * np.exp(-((t - 2.0) ** 2) / 0.01), v))
    cells = np.arange(0.01, 2.4, 0.02)
    found = turning(replace(one, t=t, v=v), cells, 0.02)
    assert np.all(found[cells > 2.12])
    assert not np.any(found[(cells > 1.6) & (cells < 2.1)])
    assert np.count_nonzero(found) < 20


def test_nor_where_it_stops_and_noise_turns_after_it():
    """One sample at a stop, which lay 27 standard errors off, was a forcing at odds of 10^117."""
    one = member("short", SHORT, 4300).motions[0]
    t = np.linspace(0.0, 3.0, 3001)
    v = np.cos(math.pi * t)  # turns at .5, 1.5 s, stops at 2.2 s
    noise = 1e-4 * np.sin(2.0 * math.pi * 17.0 * t)
    v = np.where(t < 2.2, v * np.where(t > 1.5, np.clip((2.2 - t) / 0.4, 0.0, 1.0), 1.0), noise)
    cells = np.arange(0.01, 3.0, 0.02)
    found = turning(replace(one, t=t, v=v), cells, 0.02)
    assert np.all(found[np.abs(cells - 2.17) < 0.025])
    assert not np.any(found[(cells > 1.6) & (cells < 2.0)])


def test_which_number_an_effect_moves_most_is_said():
    hidden = ((registry.find("linear_damping"), 150.0),)
    level = make_level([member("short", SHORT, 4300, hidden)])
    plain = fit_joint(level, (), 2.0, {}, 10.0, growing=True)
    damping = found_suspect("linear_damping", "one for all springs")
    additions = damping.additions(level.scales, 0.0)
    with_it = fit_joint(level, (Addend("linear_damping", additions),), 2.0, plain.values, 1.0, growing=False)
    name, away = with_it.moved(plain)
    assert name in ("drag_coefficient", "added_mass_kg", "c_mean@short", "mu_mean@short")
    assert away == pytest.approx(abs(with_it.value(name) - plain.value(name)) / plain.solution.stderr(name))
    assert plain.moved(plain)[1] == 0.0
    assert biases(Candidate((), plain, 0.0), Candidate((damping,), with_it, 0.0)) == (away > COUNTS_IN_STDERR)
    force = found_suspect("external_forcing")
    assert not biases(Candidate((), plain, 0.0), Candidate((force,), with_it, 0.0))


def test_a_step_of_a_search_that_stiffens_the_body_a_hundredfold_is_no_motion():
    level = make_level([without_dry()])
    trial = build(level, ()).trials[0]
    base = trial.base.copy()
    for slot, value in (("mass", 2937.0), ("k1", 403000.0), ("x0", 0.02)):
        base[SLOT[slot]] = value
    alone = replace(trial, links=())
    with metered(math.inf) as meter:
        motion_of(alone, base, np.linspace(0.0, 9.0, 100))
        usual = meter.spent
        base[SLOT["k3"]] = 403000.0 * 1e5 / 0.02**2  # its period is 1 / 270 of what was seen
        with pytest.raises(IdentificationError, match=r"swings so fast that steps are .* below"):
            motion_of(alone, base, np.linspace(0.0, 9.0, 100))
        assert meter.spent == usual
