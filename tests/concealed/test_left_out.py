"""Trials that a fit left out, each in turn, where a group is too small to hold one back."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import pandas as pd
import pytest

from tests.concealed.test_diagnosis import SHORT, condition, member, recording
from tests.concealed.test_small_effects import found
from undertow.comparison.joint import JointFit, fit_joint
from undertow.comparison.level import Addend, Level, make_level
from undertow.comparison.suspects import chosen
from undertow.discrepancy import left_out as folds
from undertow.discrepancy.case import Case
from undertow.discrepancy.judge import judge
from undertow.discrepancy.left_out import LeftOut, left_out
from undertow.discrepancy.transfer import from_other_springs
from undertow.discrepancy.validation import score
from undertow.discrepancy.verdict import Described
from undertow.equation import registry
from undertow.errors import IdentificationError
from undertow.front.diagnosed import DiagnosedGroup
from undertow.front.opening import OpenedGroup
from undertow.report.verdict_file import group_json

RELAXES = ((registry.find("relaxation", time_s=0.2), 6e4),)
NOTHING = LeftOut()


def fitted(level: Level, name: str) -> JointFit:
    """A level with one suspect added to the equation."""
    suspect = found(name)
    addend = Addend(name, suspect.additions(level.scales, suspect.starts(level.scales)[0]))
    return fit_joint(level, (addend,), 1.0, {}, 10.0, growing=True)


@cache
def pair() -> tuple[Level, JointFit, JointFit]:
    """Two trials of a spring in water that relaxes: the prescribed equation, and with a relaxation."""
    level = make_level([member("short", SHORT[1:], 6100, RELAXES)])
    return level, fit_joint(level, (), 1.0, {}, 10.0, growing=True), fitted(level, "relaxation")


@cache
def two_springs() -> tuple[Level, JointFit, JointFit]:
    """One trial of one spring and two of another, in one water that relaxes."""
    level = make_level([member("short", SHORT[2:], 6100, RELAXES), member("long", (0.06, 0.09), 6120, RELAXES)])
    return level, fit_joint(level, (), 1.0, {}, 10.0, growing=True), fitted(level, "relaxation")


def cases(level: Level, held: tuple[object, ...] = ()) -> list[SimpleNamespace]:
    """The level's groups, as far as they are asked for."""
    return [SimpleNamespace(member=one, held=held) for one in level.members]


def named(null: JointFit, fit: JointFit, named: bool = True) -> SimpleNamespace:
    """A diagnosis that says so."""
    return SimpleNamespace(named=named, null=SimpleNamespace(fit=null), best=SimpleNamespace(fit=fit))


def test_each_trial_is_predicted_by_fits_of_the_other_alone(monkeypatch):
    level, null, fit = pair()
    (one,) = level.members
    seen, plain = [], folds.fit_joint
    monkeypatch.setattr(folds, "fit_joint", lambda rest, *given, **more: (
        seen.append([m.name for member in rest.members for m in member.motions]), plain(rest, *given, **more))[1])
    (apart,) = left_out(level, cases(level), named(null, fit))
    names = [m.name for m in one.motions]
    assert seen == [[names[1]], [names[1]], [names[0]], [names[0]]]  # as prescribed, and with what is named
    alone = [replace(level, members=(replace(one, motions=(m,)),)) for m in reversed(one.motions)]
    width = one.options.rest_offset_std
    by_hand = [
        score(rest, one, plain(rest, fit.addends, fit.memory, fit.values, fit.misfit, growing=False), motion, width)
        for rest, motion in zip(alone, one.motions, strict=True)
    ]  # fmt: skip
    assert apart.after == pytest.approx(sum(by_hand) / 2.0)
    assert apart.after < 0.5 * apart.before


def test_a_lone_trial_is_predicted_by_the_other_spring_and_by_nothing_else():
    level, null, fit = two_springs()
    short, long = left_out(level, cases(level), named(null, fit))
    (moved, _) = from_other_springs(level, fit, [m.motions for m in level.members])
    assert short.after == pytest.approx(moved["long"], rel=0.05)
    assert short.after < short.before
    assert math.isfinite(long.after)
    undried = replace(level.members[0], model=replace(level.members[0].model, fixed=None))
    assert left_out(level, [SimpleNamespace(member=undried, held=())], named(null, fit)) == (NOTHING,)
    single = make_level([replace(level.members[0])])
    own = fitted(single, "relaxation")
    assert left_out(single, cases(single), named(fit_joint(single, (), 1.0, {}, 10.0, growing=True), own)) == (NOTHING,)
    stiff = fitted(level, "cubic_stiffness")
    assert left_out(level, cases(level), named(null, stiff))[0] == NOTHING  # it is each spring's own
    assert math.isfinite(left_out(level, cases(level), named(null, stiff))[1].after)


def test_nothing_is_left_out_where_trials_are_held_back_nothing_is_named_or_each_has_its_own():
    level, null, fit = pair()
    assert left_out(level, cases(level, held=level.members[0].motions[:1]), named(null, fit)) == (NOTHING,)
    assert left_out(level, cases(level), named(null, fit, named=False)) == (NOTHING,)
    (one,) = level.members
    many = replace(level, members=(replace(one, motions=(*one.motions, *member("short", SHORT, 6150).motions[:1])),))
    assert left_out(many, cases(many), named(null, fit)) == (NOTHING,)  # three, none of which the config holds back
    differing = replace(fit.addends[0].additions[0], slot="mass", scope="trial", prior_std=1.0)
    heavier = replace(fit, addends=(replace(fit.addends[0], additions=(differing,)),))
    assert differing.differs
    assert left_out(level, cases(level), named(null, heavier)) == (NOTHING,)


def test_what_stands_is_no_part_of_the_prescribed_equation(monkeypatch):
    level, null, fit = pair()
    standing = replace(level, standing=fit.addends)
    seen, plain = [], folds.fit_joint
    monkeypatch.setattr(folds, "fit_joint", lambda rest, addends, *given, **more: (
        seen.append((len(rest.standing), len(addends))), plain(rest, addends, *given, **more))[1])
    left_out(standing, cases(standing), named(null, fit))
    assert set(seen) == {(0, 0), (1, 1)}


def test_a_fit_that_does_not_come_out_says_nothing(monkeypatch):
    level, null, fit = pair()

    def fails(*_: object, **__: object) -> JointFit:
        raise IdentificationError("no motion")

    monkeypatch.setattr(folds, "fit_joint", fails)
    assert left_out(level, cases(level), named(null, fit)) == (NOTHING,)


def test_a_verdict_of_two_trials_says_what_fits_without_each_miss():
    level, _, _ = pair()
    case = Case({"spring": "short"}, "spring short", level.members[0], (), Described(0.4), 0.004, 0.05, 2, False, True)
    (verdict,) = judge([case], chosen(("relaxation", "cubic_stiffness")))
    assert verdict.verdict == ("relaxation",)
    before, after = verdict.baseline.cross_validated_nrmse, verdict.augmented.cross_validated_nrmse
    assert after < 0.5 * before
    assert "not proved on an unseen trial." in verdict.sentence
    assert f"each of its 2 trials is missed by {100 * before:.2g} % as prescribed" in verdict.sentence
    entry = json.loads(json.dumps(group_json(verdict)))
    assert entry["augmented"]["cross_validated_nrmse"] == pytest.approx(after)
    assert entry["baseline"]["cross_validated_nrmse"] == pytest.approx(before)
    assert entry["augmented"]["held_out_nrmse"] is None


def test_what_another_spring_says_of_a_lone_trial_is_said_once():
    level, _, _ = two_springs()
    cases = [
        Case({"spring": one.label}, one.label, one, (), Described(0.4), 0.004, 0.05, len(one.motions), False, True)
        for one in level.members
    ]  # fmt: skip
    short, long = judge(cases, chosen(("relaxation", "cubic_stiffness")))
    assert short.verdict == long.verdict == ("relaxation",)
    assert "With the numbers that the other spring's trials (long) alone give" in short.sentence
    assert "Predicted by" not in short.sentence
    assert "Predicted by fits without it, each of its 2 trials is missed by" in long.sentence
    assert math.isfinite(short.augmented.cross_validated_nrmse)


def test_trials_left_out_beside_a_force_have_only_its_size_and_phase_fitted():
    tone = ((registry.find("external_forcing", frequency_rad_per_s=7.0, phase_rad=0.4), 900.0),)
    group = member("short", SHORT[1:], 6300, tone)
    case = Case({"spring": "short"}, "spring short", group, (), Described(0.4), 0.004, 0.05, 2, False, True)
    (verdict,) = judge([case], chosen(("external_forcing", "cubic_stiffness")))
    assert verdict.verdict == ("external_forcing",)
    assert verdict.augmented.cross_validated_nrmse < 0.5 * verdict.baseline.cross_validated_nrmse
    assert "2 trials, with only that trial's size and phase of the force fitted, is missed by" in verdict.sentence


def test_beside_a_force_of_its_own_an_unseen_trials_error_is_told_apart(monkeypatch):
    tone = ((registry.find("external_forcing", frequency_rad_per_s=7.0, phase_rad=0.4), 900.0),)
    group = member("short", SHORT, 6200, tone)
    held = condition(recording("short", 0.022, 6250, tone))
    case = Case({"spring": "short"}, "spring short", group, (held,), Described(0.4, 0.4), 0.004, 0.05, 4, False, True)
    (verdict,) = judge([case], chosen(("external_forcing", "cubic_stiffness")))
    assert verdict.verdict == ("external_forcing",)
    assert math.isnan(verdict.augmented.held_out_nrmse)
    assert verdict.augmented.cross_validated_nrmse < 0.1
    assert verdict.baseline.cross_validated_nrmse == 0.4
    assert "as prescribed, by" not in verdict.sentence  # it says so of the trial that was held back


@pytest.mark.parametrize(
    ("held", "apart", "score"), [(0.2, math.nan, 0.8), (math.nan, 0.3, 0.7), (math.nan, math.nan, 0.9)]
)
def test_a_groups_score_is_of_trials_held_out_or_left_out_in_turn_before_those_that_were_fitted(held, apart, score):
    row = {
        "held_out_repaired": held, "held_out_error": math.nan, "left_out_repaired": apart, "error_repaired": 0.1,
        "error": 0.4,
    }  # fmt: skip
    assert OpenedGroup._own_score(SimpleNamespace(row=row)) == pytest.approx(score)
    errors = [held, 0.1] if math.isfinite(held) else [0.1, 0.1]
    table = pd.DataFrame({"error_repaired": errors, "error": [0.4, 0.4], "held_out": [math.isfinite(held), False]})
    assert DiagnosedGroup._own_score(SimpleNamespace(row=row, trial_table=table)) == pytest.approx(score)
