"""An equation whose fit ended short of its optimum, and a suspect that came out at nothing beyond it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.concealed.test_diagnosis import SHORT, member
from tests.concealed.test_small_effects import found, stands
from undertow.comparison import search
from undertow.comparison.candidate import Candidate
from undertow.comparison.joint import JointFit
from undertow.comparison.level import Level, make_level
from undertow.comparison.prescribed import ENDED_SHORT, FURTHER, HARDLY, further_on
from undertow.comparison.search import diagnose
from undertow.comparison.suspects import SUSPECTS

NOTHING = "cubic_stiffness is 0.1 standard errors from zero"


def stuck(fit: JointFit) -> JointFit:
    """The fit as if it had ended short: its misfit tripled, its criterion worse."""
    return replace(fit, misfit=3.0 * fit.misfit, criterion=fit.criterion + 20.0 * ENDED_SHORT)


@pytest.fixture(scope="module")
def single() -> tuple[Level, JointFit]:
    """One trial with nothing missing, and the prescribed equation fitted to it."""
    level = make_level([member("short", SHORT[:1], 2300)])
    return level, stands(level)


def test_an_equation_that_ended_short_goes_on_from_where_a_suspect_that_is_nothing_led(single):
    level, fit = single
    tried = [Candidate((found("cubic_stiffness"),), fit, -3.0, NOTHING)]
    null = Candidate((), stuck(fit), -0.1)
    further = further_on(level, null, tried, null)
    assert further is not None
    assert (further.suspects, further.log_prior) == ((), -0.1)
    assert further.fit.criterion == pytest.approx(fit.criterion, abs=0.5)
    for name, value in fit.values.items():
        assert further.fit.values[name] == pytest.approx(value, abs=0.2 * fit.solution.stderr(name))


def test_an_equation_at_its_optimum_stays_and_one_whose_suspect_means_something_does(single):
    level, fit = single
    suspects = (found("cubic_stiffness"),)
    ahead = replace(fit, criterion=fit.criterion - 20.0)  # excluded, more likely, and the equation cannot follow
    null, short = Candidate((), fit, -0.1), Candidate((), stuck(fit), -0.1)
    assert further_on(level, null, [Candidate(suspects, ahead, -3.0, NOTHING)], null) is None
    assert further_on(level, short, [Candidate(suspects, fit, -3.0)], short) is None
    assert further_on(level, null, (), null) is None


def test_a_bad_release_that_leaves_out_the_first_swings_leads_on_and_is_not_named_for_it(single):
    level, fit = single
    (late,) = (s for s in SUSPECTS if s.name == "imperfect_release" and s.late)
    short, far = Candidate((), stuck(fit), -0.1), Candidate((), stuck(stuck(fit)), -0.1)
    named = Candidate((late,), replace(fit, criterion=fit.criterion - 1.0), -3.0)
    further = further_on(level, short, [named], named)
    assert further is not None
    assert further.fit.criterion == pytest.approx(fit.criterion, abs=0.5)
    assert further_on(level, Candidate((), fit, -0.1), [named], named) is None  # at its optimum: the release is bad
    assert further_on(level, far, [replace(named, suspects=(found("cubic_stiffness"),))], named) is None


@pytest.mark.parametrize(("times", "again"), [(0.9, True), (1.1, False)])
def test_nothing_is_looked_for_again_where_an_answer_stands_far_ahead_of_the_better_equation_too(single, times, again):
    level, fit = single
    null, tried = Candidate((), stuck(fit), -0.1), [Candidate((found("cubic_stiffness"),), fit, -3.0, NOTHING)]
    gained = 20.0 * ENDED_SHORT
    ahead = replace(fit, criterion=null.fit.criterion - times * HARDLY * gained)
    answer = Candidate((found("coulomb_friction"),), ahead, null.log_prior)
    assert (further_on(level, null, tried, answer) is not None) == again


def test_a_search_begins_again_from_the_better_equation(single, monkeypatch):
    level, fit = single
    monkeypatch.setattr(search, "plain_fit", lambda level: stuck(fit))
    asked = []

    def further(*seen):
        asked.append(seen)
        return Candidate((), fit, -0.1)

    monkeypatch.setattr(search, "further_on", further)
    diagnosis = diagnose(level, [found("cubic_stiffness")])
    assert diagnosis.null.fit.criterion == pytest.approx(fit.criterion, abs=0.5)
    assert len(asked) == FURTHER  # a better optimum may not be the best yet
    assert [before.fit.criterion > fit.criterion + 10.0 for _, before, *_ in asked] == [True, False]
