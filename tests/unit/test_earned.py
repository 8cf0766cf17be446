"""Green is earned: what is lacking for an answer turns a verdict into `cannot_tell`, and nothing else does."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest

from undertow.comparison.candidate import Candidate, probability
from undertow.comparison.search import _Search
from undertow.discrepancy.case import Case
from undertow.discrepancy.decision import posterior
from undertow.discrepancy.earned import earned
from undertow.discrepancy.verdict import Described, Verdict

GREEN = Verdict({"spring": "short"}, ("a", "b", "c"), status="nothing_missing", sentence="nothing is missing.")
NAMED = replace(GREEN, status="explained", verdict=("linear_damping",), parameters={"linear_damping": {}})
UNKNOWN = replace(GREEN, status="unknown", verdict=("unknown",))


def case(**facts: object) -> Case:
    """A group of three trials whose error of 4 % is allowed to be 5 %."""
    member = SimpleNamespace(motions=tuple(SimpleNamespace(name=name) for name in "abc"))
    return replace(
        Case({"spring": "short"}, "spring short", member, (), Described(0.04), 0.01, 0.05, 0, False, True), **facts
    )


def candidate(name: str, score: float, out: str = "", aside: bool = False) -> SimpleNamespace:
    """A set of one suspect with its log evidence."""
    return SimpleNamespace(names=(name,), suspects=(name,), score=score, out=out, aside=aside)


def diagnosis(named: bool = False, **facts: object) -> SimpleNamespace:
    """A search that ended and found nothing, unless told otherwise."""
    plain = {"named": named, "looked": 20, "unfinished": (), "small": None, "null": SimpleNamespace(score=0.0)}
    plain |= {"best": candidate("linear_damping", 20.0), "candidates": (), "rivals": ()}
    return SimpleNamespace(**(plain | facts))


def test_a_search_that_ended_on_known_scatter_stays_green():
    said = earned(GREEN, case(), diagnosis(), True)
    assert all(gate.passed for gate in said.decision)
    assert replace(said, decision=()).sentence == GREEN.sentence
    assert said.status == "nothing_missing"


@pytest.mark.parametrize(
    ("facts", "search", "because"),
    [
        ({"contradiction": "x and a disagree"}, {}, "x and a disagree"),
        ({"no_dry": "no dry trial of long could be used"}, {}, "no dry trial of long could be used"),
        ({"assumed": "there is 1 trial"}, {}, "there is 1 trial"),
        ({}, {"looked": 0}, "discrepancy.suspects names none"),
        ({}, {"unfinished": ("relaxation",)}, "not tried to the end within discrepancy.budget: relaxation"),
    ],
)
def test_green_without_its_reasons_is_cannot_tell(facts, search, because):
    said = earned(GREEN, case(**facts), diagnosis(**search), True)
    assert (said.status, said.verdict, said.parameters) == ("cannot_tell", (), {})
    assert because in said.because
    assert [gate.because for gate in said.decision if not gate.passed] == [said.because]
    assert said.because in said.sentence
    assert said.next_test


def test_channels_that_contradict_leave_no_name_either():
    said = earned(NAMED, case(contradiction="x and a disagree"), diagnosis(True), True)
    assert (said.status, said.verdict, said.contradicted) == ("cannot_tell", (), True)


def test_a_name_stands_where_twice_the_assumed_scatter_leaves_it():
    assert earned(NAMED, case(assumed="there are 2 dry trials"), diagnosis(True), True).verdict == NAMED.verdict
    said = earned(NAMED, case(assumed="there are 2 dry trials"), diagnosis(True), False)
    assert (said.status, said.verdict) == ("cannot_tell", ())
    assert "with twice that nothing would be said" in said.because


def test_an_unknown_that_twice_the_assumed_scatter_allows_is_cannot_tell():
    near = case(assumed="there are 2 dry trials", baseline=Described(0.08))
    assert earned(UNKNOWN, near, diagnosis(), True).status == "cannot_tell"
    far = case(assumed="there are 2 dry trials", baseline=Described(0.3))
    assert earned(UNKNOWN, far, diagnosis(), True).status == "unknown"


def test_unknown_is_not_said_by_a_search_that_did_not_end():
    cut = diagnosis(unfinished=("further effects",))
    said = earned(UNKNOWN, case(), cut, True)
    assert (said.status, said.verdict) == ("cannot_tell", ())
    assert "not tried to the end within discrepancy.budget: further effects" in said.because
    named = replace(UNKNOWN, verdict=("hidden_resonator", "unknown"))
    assert earned(named, case(), cut, True).verdict == ("hidden_resonator", "unknown")  # what was found stays


def test_the_posterior_counts_what_is_excluded_and_the_confidence_does_not():
    said = SimpleNamespace(names=("linear_damping",), score=0.0, out="")
    excluded = SimpleNamespace(names=("relaxation",), score=math.log(3.0), out="on its bound")
    assert probability(said, [said, excluded], []) == pytest.approx(1.0)
    cut = SimpleNamespace(best=said, candidates=(said, excluded), screened=())
    assert posterior(cut) == pytest.approx(0.25)
    assert posterior(cut, excluded) == pytest.approx(0.75)


def test_overwhelming_evidence_for_a_small_effect_is_not_green():
    small = SimpleNamespace(names=("cubic_stiffness",), score=60.0)
    said = earned(GREEN, case(), diagnosis(small=small), True)
    assert (said.status, said.verdict) == ("present_but_small", ("cubic_stiffness",))
    assert "10^26 to 1" in said.sentence


@pytest.mark.parametrize(("after", "status"), [(0.02, "explained"), (0.034, "explained"), (0.06, "cannot_tell")])
def test_a_name_that_makes_unseen_trials_worse_is_not_proved(after, status):
    facts = case(baseline=Described(0.04, 0.03))
    named = replace(NAMED, augmented=Described(0.01, after))
    said = earned(named, facts, diagnosis(True), True)
    assert said.status == status
    if status == "cannot_tell":
        assert "linear damping would be named, but the trials it never saw went from 3.0 % to 6.0 %" in said.because


def test_a_name_that_something_excluded_outweighs_is_no_answer():
    more = candidate("external_forcing", 60.0, "its phases are locked to the release")
    said = earned(NAMED, case(), diagnosis(True, candidates=(candidate("linear_damping", 20.0), more)), True)
    assert (said.status, said.verdict) == ("unknown", ("linear_damping", "unknown"))
    assert "far more probable (odds of 10^17 to 1) is external forcing, excluded because its phases" in said.sentence
    assert said.next_test.startswith("more releases of different size")
    near = diagnosis(True, candidates=(candidate("linear_damping", 20.0), replace_score(more, 30.0)))
    assert earned(NAMED, case(), near, True).status == "explained"


def test_a_rival_that_was_excluded_outweighs_nothing():
    rival = candidate("hidden_resonator", 300.0, "its damping sits on a bound")
    both = diagnosis(True, candidates=(candidate("linear_damping", 20.0), rival), rivals=(("hidden_resonator",),))
    assert earned(NAMED, case(), both, True).status == "explained"


def test_what_brings_the_free_run_no_closer_outweighs_nothing():
    echo = candidate("delayed_echo", 200.0, "brings the free run no closer by what counts", aside=True)
    both = diagnosis(True, candidates=(candidate("linear_damping", 20.0), echo))
    assert earned(NAMED, case(), both, True).status == "explained"


def replace_score(one: SimpleNamespace, score: float) -> SimpleNamespace:
    return SimpleNamespace(**(vars(one) | {"score": score}))


def test_what_is_set_aside_twice_is_still_aside_and_what_has_no_sound_numbers_is_not():
    sound, unsound = (Candidate((), None, 0.0, out) for out in ("", "its size sits on a bound"))
    search = SimpleNamespace(found=[sound, unsound])
    for reason in ("it leaves too much", "it brings the free run no closer"):
        _Search._set_aside(search, list(search.found), reason)
    assert [(c.out, c.aside) for c in search.found] == [
        ("it leaves too much", True), ("its size sits on a bound", False)
    ]  # fmt: skip
