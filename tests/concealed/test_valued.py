"""At which memory sets are compared: between that of what stands and that of the closest candidate's residual."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import pytest

from tests.concealed.test_diagnosis import member
from undertow.comparison import attempt, search
from undertow.comparison.attempt import at_own, from_starts
from undertow.comparison.candidate import Candidate
from undertow.comparison.joint import at_memory
from undertow.comparison.level import Level, make_level
from undertow.comparison.prescribed import plain_fit
from undertow.comparison.search import _Search
from undertow.comparison.suspects import chosen
from undertow.comparison.trying import ODDS
from undertow.equation import registry
from undertow.likelihood.noise import residual_memory


@cache
def both() -> tuple[Level, Candidate, Candidate, Candidate]:
    """Water that swings, and a dashpot: the level, the equation, the water alone and both, as first fitted."""
    resonator = registry.find("hidden_resonator", natural_frequency_rad_per_s=8.4, damping_ratio=0.02)
    hidden = ((resonator, 150.0), (registry.find("linear_damping"), 900.0))
    level = make_level([member("short", (0.02, 0.03), 6300, hidden)])
    null = Candidate((), plain_fit(level), math.log(0.5))
    water, damping = chosen(("hidden_resonator",))[0], chosen(("linear_damping",))[0]
    one = from_starts(level, null, water, -3.0)
    two = from_starts(level, one, damping, -9.0)
    return level, null, one, two


def searching() -> tuple[_Search, Candidate, Candidate]:
    """A search with nothing but the equation found, the water alone and both."""
    level, null, one, two = both()
    return _Search(level, chosen(("hidden_resonator", "linear_damping")), null, False), one, two


def test_all_that_was_found_is_valued_at_the_memory_of_what_is_closest():
    state, one, _ = searching()
    state.small = [one]
    (said,) = state._first([one])
    memory = math.sqrt(state.memory * residual_memory(one.fit.solution))
    assert memory < 0.5 * state.memory
    assert {c.fit.memory for c in (said, state.null, state.best, *state.found, *state.small)} == {memory}
    assert state.null is state.best is state.found[0]
    assert state.small[0] is said  # one candidate stays one
    assert said.score == pytest.approx(replace(one, fit=at_memory(one.fit, memory)).score)
    assert state._first([one])[0] is one  # no longer memory is gone back to


def test_nothing_closer_leaves_all_as_it_was():
    state, _, _ = searching()
    assert state._first([]) == []
    assert state.best.fit.memory == state.memory


def test_what_stands_is_fitted_once_more_at_its_own_memory_and_a_further_effect_is_judged_beside_its_residual():
    state, one, two = searching()
    (one,) = state._first([one])
    state.found.append(one)
    before = one.fit.memory
    state._stand(one, 0.5)
    assert state.error == 0.5
    assert state.best is state.found[-1]
    assert state.best.fit.criterion <= one.fit.criterion + attempt.SAME_END
    assert state.memory == residual_memory(state.best.fit.solution) < before
    stands = state.best
    beside = replace(two, fit=at_memory(two.fit, stands.fit.memory))
    (said,) = state._further_on([beside])
    assert said.fit.memory == state.best.fit.memory < stands.fit.memory
    assert said.score - state.best.score > max(ODDS, beside.score - stands.score)


def test_a_further_effect_that_is_not_more_probable_then_changes_no_value():
    state, one, two = searching()
    (one,) = state._first([one])
    state._stand(one, 0.5)
    stands, weak = state.best, replace(two, fit=at_memory(two.fit, state.best.fit.memory), log_prior=-1e4)
    assert state._further_on([weak]) == [weak]
    assert state._further_on([replace(weak, log_prior=-9.0, out="on its bound")])[0].fit.memory == stands.fit.memory
    assert state._further_on([]) == []
    assert state.best is stands


def test_pairs_that_are_no_answer_leave_what_was_found_as_it_was_valued(monkeypatch):
    state, one, two = searching()
    (one,) = state._first([one])
    state.best, state.error = one, 0.5
    state.found.append(one)
    before = state.null, state.best, state.found, state.small, state.screened
    monkeypatch.setattr(search, "FAR_ABOVE_NOISE", 1e-3)
    monkeypatch.setattr(search, "explains", lambda *_: False)

    def pair(self: _Search, taken: object) -> tuple[Candidate, float]:
        self.found = [*self.found, *self._first([two])]
        return self.found[-1], 0.4

    monkeypatch.setattr(_Search, "_other_pair", pair)
    assert state._from_another_first() is None
    assert (state.null, state.best, state.found, state.small, state.screened) == before


def test_a_fit_that_loses_by_being_made_again_is_kept(monkeypatch):
    level, _, one, _ = both()
    worse = replace(one.fit, criterion=one.fit.criterion + 1.0)
    monkeypatch.setattr(attempt, "fit_joint", lambda *given, **more: worse)
    assert at_own(level, one) is one
    monkeypatch.setattr(attempt, "fit_joint", lambda *given, **more: replace(worse, criterion=one.fit.criterion - 1.0))
    assert at_own(level, one).fit.criterion == one.fit.criterion - 1.0
