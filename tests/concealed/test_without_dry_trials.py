"""Groups whose spring has no dry trial: their trials differ in k, c, mu all the same, and nothing is missing."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tests.concealed.test_diagnosis import EQ15, SHORT, SPECIMEN, member
from undertow.comparison.joint import build, fit_joint
from undertow.comparison.level import Member, make_level
from undertow.equation.kernel import SLOT
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import group_model, terms_by_name

SPREAD = {"k1": 1200.0, "c1": 50.0, "fc": 7.0}


def without_dry(trials: int = 3, spread: dict[str, float] | None = None, freedom: float = math.inf) -> Member:
    """A group that fits its own k, c, mu."""
    known = member("short", SHORT[:trials], 4300)
    model = group_model(terms_by_name(EQ15), known.motions, SPECIMEN, None, dry=False, anchored=True)
    spread = SPREAD if spread is None else spread
    return Member("short", model, known.motions, TrialOptions(), allowed=0.05, spread=spread, freedom=freedom)


def test_each_trial_has_its_own_k_c_mu_as_wide_as_trials_differ():
    one = without_dry()
    problem = build(make_level([one]), ())
    held = {u.name: u.prior_std for u in problem.unknowns if u.name.split("[")[0] in ("k", "c", "mu")}
    assert held == {
        f"{symbol}[{motion.name}]": SPREAD[slot]
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
