"""Green is earned: what is lacking for an answer turns a verdict into `cannot_tell`, and nothing else does."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from undertow.comparison.candidate import Candidate, probability
from undertow.comparison.level import Addend
from undertow.comparison.null_test import NullTest, SuspectTest
from undertow.comparison.search import _Search
from undertow.comparison.suspect import Addition
from undertow.discrepancy.alone import Alone
from undertow.discrepancy.case import Case
from undertow.discrepancy.decision import posterior
from undertow.discrepancy.dry_check import DryAnswer
from undertow.discrepancy.earned import NEXT, earned
from undertow.discrepancy.judge import _left, _physics, _unit, _without_a_name
from undertow.discrepancy.naming import next_test, other_sets
from undertow.discrepancy.sentence import no_answer, sentence_of
from undertow.discrepancy.validation import Closeness, reach
from undertow.discrepancy.verdict import Described, Verdict
from undertow.discrepancy.wandering import as_what, no_physics
from undertow.likelihood.fit import Specimen
from undertow.likelihood.group import GroupModel
from undertow.quantities import Estimate

GREEN = Verdict({"spring": "short"}, ("a", "b", "c"), status="nothing_missing", sentence="nothing is missing.")
NAMED = replace(GREEN, status="explained", verdict=("linear_damping",), parameters={"linear_damping": {}})
UNKNOWN = replace(GREEN, status="unknown", verdict=("unknown",))


def case(**facts: object) -> Case:
    """A group of three trials whose error of 4 % is allowed to be 5 %."""
    member = SimpleNamespace(motions=tuple(SimpleNamespace(name=name) for name in "abc"), free_start=False)
    return replace(
        Case({"spring": "short"}, "spring short", member, (), Described(0.04), 0.01, 0.05, 0, False, True), **facts
    )


def candidate(
    name: str,
    score: float,
    out: str = "",
    aside: bool = False,
    misfit: float = 1.0,
    becomes: str = "",
    frees: str = "",
    error: float = 0.1,
    inner: bool = False,
    rate: float = 0.0,
) -> SimpleNamespace:
    """A set of one suspect with its log evidence, which leaves so much (mean square over noise), what it becomes on its
    bound, and the relative standard errors of its coefficient and of its frequency, if it has one."""
    errors = {f"{name}.c_Ns_per_m": error, f"{name}.rate": rate, f"{name}.damping": 9.0}
    solution = SimpleNamespace(problem=SimpleNamespace(names=list(errors), trials=()), stderr=errors.get)
    addend = Addend(name, (
        Addition("c_Ns_per_m", "N s/m", "c1", 0.0, 1.0, inner=inner),
        *([Addition("rate", "rad/s", "hw1", 0.0, 1.0, inner=True)] if rate else []),
        Addition("damping", "1", "hz1", 0.0, 1.0, inner=True),  # a number inside that may be zero
    ))  # fmt: skip
    fit = SimpleNamespace(misfit=misfit, addends=(addend,), solution=solution, value=lambda _: -1.0)
    return SimpleNamespace(
        names=(name,), suspects=(name,), score=score, out=out, aside=aside, fit=fit,
        amounts_to=(becomes or name,),
    )  # fmt: skip


def no_trial(misfit: float) -> SimpleNamespace:
    """A fit of no trial at all that leaves so much."""
    return SimpleNamespace(misfit=misfit, solution=SimpleNamespace(problem=SimpleNamespace(trials=()), residuals=()))


def diagnosis(named: bool = False, **facts: object) -> SimpleNamespace:
    """A search that ended and found nothing, unless told otherwise."""
    null = SimpleNamespace(names=(), suspects=(), score=0.0, out="", aside=False, fit=no_trial(1.0), amounts_to=())
    plain = {"named": named, "looked": 20, "unfinished": (), "small": None, "null": null, "screened": ()}
    plain |= {"best": candidate("linear_damping", 20.0), "rivals": ()} | facts
    weak = candidate("linear_damping", 3.0, "brings the free run no closer by what counts", aside=True)
    found = (plain["best"],) if named else (weak,)
    return SimpleNamespace(**({"candidates": (null, *found)} | plain))


def judged(verdict: Verdict, facts: Case, search: SimpleNamespace, doubled: bool, null: NullTest | None = None):
    """What is earned; beside no null of its own unless told otherwise."""
    return earned(verdict, facts, search, null or NullTest(math.nan), doubled)


def beside(p_value: float, size: float = 0.5, hidden: float = 0.5) -> NullTest:
    """A test of one suspect, its effect and what can hide in units of what counts, 2.5 % of the motion."""
    return NullTest(p_value, (SuspectTest("linear_damping", p_value, 1.0, size, hidden),), 0.025)


def test_a_name_that_dry_trials_contradict_is_not_the_answer():
    answer = DryAnswer(9.0, "the dry trials of the same spring show none")
    named, plain = diagnosis(named=True), NullTest(math.nan)
    said = earned(NAMED, case(), named, plain, True, answer)
    assert (said.status, said.verdict) == ("unknown", ("linear_damping", "unknown"))
    assert said.sentence.startswith("spring short: nothing that was tried is the answer, what is missing is unknown.")
    assert said.sentence.endswith("It is not the answer: the dry trials of the same spring show none.")
    assert "once more" in said.next_test
    assert earned(NAMED, case(), named, plain, True, DryAnswer()).status == "explained"


@pytest.mark.parametrize(
    ("unseen", "left", "said"),
    [(0.03, 1.2, "explained"), (0.06, 1.2, "unknown"), (0.03, 9.0, "unknown"), (0.045, 1.2, "unknown")],
)
def test_a_law_that_dry_trials_do_not_have_is_the_waters_where_it_is_proved_to_the_noise(unseen, left, said):
    answer = DryAnswer(9.0, "the dry trials of the same spring show none")
    level = diagnosis(named=True, best=candidate("cubic_stiffness", 20.0, misfit=left))
    named = replace(NAMED, verdict=("cubic_stiffness",), augmented=Described(0.02, unseen))
    before = 0.04 if unseen == 0.045 else 0.12  # no closer with it
    found = earned(named, case(baseline=Described(0.1, before)), level, NullTest(math.nan), True, answer)
    assert found.status == said
    if said == "explained":
        assert found.sentence.endswith(
            " It is there in water alone: the dry trials of the same spring show none. In water added mass that goes "
            "with the amplitude looks much like it, and is no law of this search."
        )
        gate = next(one for one in found.decision if one.gate == "dry_trials_agree")
        assert gate.statistic.endswith("; met, for unseen trials prove it of the water")
        other = replace(named, verdict=("relaxation",))
        assert "looks much like it" not in earned(other, case(baseline=Described(0.1, before)), level,
                                                  NullTest(math.nan), True, answer).sentence


def test_a_name_beside_a_structure_that_lacks_what_nobody_knows_is_not_the_answer():
    puzzled = case(dry_unknown="something that nobody knows is missing in the dry trials too (spring short, dry)")
    said = judged(NAMED, puzzled, diagnosis(named=True), True)
    assert (said.status, said.verdict) == ("unknown", ("linear_damping", "unknown"))
    assert "is missing in the dry trials too (spring short, dry)" in said.sentence
    assert "more dry releases" in said.next_test
    green = judged(GREEN, puzzled, diagnosis(), True, beside(0.4))
    assert (green.status, green.because) == ("cannot_tell", puzzled.dry_unknown)


def test_what_is_small_has_no_name_that_dry_trials_contradict():
    answer = DryAnswer(9.0, "the dry trials of the same spring show none")
    said = earned(GREEN, case(), diagnosis(), beside(0.004), True, answer)
    assert (said.status, said.verdict) == ("present_but_small", ("unknown",))
    assert "; but the dry trials of the same spring show none, so that it is something" in said.sentence
    small = candidate("cubic_stiffness", 40.0)
    said = earned(GREEN, case(), diagnosis(small=small), beside(0.004), True, answer)
    assert said.verdict == ("unknown",)
    assert earned(GREEN, case(), diagnosis(small=small), beside(0.004), True).verdict == ("cubic_stiffness",)


@pytest.mark.parametrize(
    ("null", "status", "names"),
    [
        (beside(0.4), "nothing_missing", ()),
        (beside(0.004), "present_but_small", ("linear_damping",)),
        (beside(0.004, size=1.2), "unknown", ("unknown",)),
        (beside(0.4, hidden=1.2), "cannot_tell", ()),
    ],
)
def test_green_is_for_levels_like_their_null_in_which_little_can_hide(null, status, names):
    said = judged(GREEN, case(), diagnosis(), True, null)
    assert (said.status, said.verdict) == (status, names)
    if status == "cannot_tell":
        hides = "linear damping beside what the equation has could hide in it and move the free run by 3.0 %"
        assert hides in said.because
    elif status != "nothing_missing":
        assert "only 0.4 % stand out as much" in said.sentence


@pytest.mark.parametrize(("p_value", "names"), [(0.3, ("unknown",)), (0.5, ("linear_damping",))])
def test_what_is_small_has_a_name_where_no_other_stands_out_nearly_as_much(p_value, names):
    other = SuspectTest("hidden_resonator (amplitude-dependent)", p_value, 1.0, 0.5, 0.5)
    null = beside(0.004)
    said = judged(GREEN, case(), diagnosis(), True, replace(null, tests=(*null.tests, other)))
    assert (said.status, said.verdict) == ("present_but_small", names)
    assert ("hidden resonator" in said.sentence) == (names == ("unknown",))


@pytest.mark.parametrize(
    ("p_value", "evidence", "rival", "names"),
    [
        (0.004, 60.0, 3.0, ("hysteresis", "external_forcing")), (0.004, 60.0, 59.0, ("hysteresis",)),
        (0.004, None, 3.0, ("hysteresis",)), (0.4, 60.0, 3.0, ("hysteresis",)),
    ],
    ids=["beyond doubt", "a rival as likely", "only most like", "like its null"],
)  # fmt: skip
def test_something_small_beside_what_the_dry_trials_need_is_said_and_named_where_it_is_beyond_doubt(
    p_value, evidence, rival, names
):
    small = None if evidence is None else candidate("external_forcing", evidence, "hardly shown", aside=True)
    other = candidate("cubic_stiffness", rival)
    level = diagnosis(small=small, candidates=(*filter(None, (small,)), other))
    carried = replace(NAMED, verdict=("hysteresis",))
    said = judged(carried, case(), level, True, beside(p_value))
    assert (said.status, said.verdict) == ("explained", names)
    assert ("Beside it something small stands out" in said.sentence) == (p_value < 0.01)
    assert ("external forcing" in said.sentence) == (p_value < 0.01 and evidence is not None)
    assert ("linear damping." in said.sentence) == (p_value < 0.01 and evidence is None)


@pytest.mark.parametrize(
    "found", [(), (candidate("linear_damping", 3.0, "linear_damping is 1.2 standard errors from zero"),)]
)
def test_what_is_small_has_no_name_of_which_no_fit_has_sound_numbers(found):
    said = judged(GREEN, case(), diagnosis(candidates=(*diagnosis().candidates[:1], *found)), True, beside(0.004))
    assert (said.status, said.verdict) == ("present_but_small", ("unknown",))
    assert "most like linear damping" in said.sentence


@pytest.mark.parametrize(
    ("size", "hidden", "status"), [(0.5, 0.5, "present_but_small"), (1.2, 0.5, "unknown"), (0.5, 1.2, "unknown")]
)
def test_what_has_no_name_is_small_only_where_nothing_that_counts_is_as_likely_or_could_hide(size, hidden, status):
    null = beside(0.004)
    other = SuspectTest("hidden_resonator (amplitude-dependent)", 0.006, 1.0, size, hidden)
    said = judged(GREEN, case(), diagnosis(), True, replace(null, tests=(*null.tests, other)))
    assert (said.status, said.verdict) == (status, ("unknown",))
    assert said.sentence.endswith("whether it is small these data do not tell.") == (status == "unknown")
    strong = replace_label(candidate("cubic_stiffness", 40.0), "cubic_stiffness")
    near = replace_label(candidate("quintic_stiffness", 39.0), "quintic_stiffness")
    search = diagnosis(small=strong, candidates=[strong, near])
    said = judged(GREEN, case(), search, True, replace(null, tests=(*null.tests, other)))
    assert (said.status, said.verdict) == (status, ("unknown",))
    assert ("something small is there" in said.sentence) == (status == "present_but_small")
    search = diagnosis(small=strong, candidates=[strong])
    said = judged(GREEN, case(), search, True, replace(null, tests=(*null.tests, other)))
    assert (said.status, said.verdict) == ("present_but_small", ("cubic_stiffness",)), "what has a name keeps it"


def test_what_nobody_knows_has_a_next_test_too():
    said = judged(GREEN, case(), diagnosis(), True, beside(0.004, size=1.2))
    assert (said.verdict, said.next_test) == (("unknown",), next_test("linear_damping"))
    assert said.next_test.startswith("a longer decay from a small release")
    null = SimpleNamespace(score=0.0, fit=no_trial(4.0))
    for facts, words in (({}, NEXT["unnamed"]), ({"dry": True}, NEXT["unnamed"].replace(" in this water", ""))):
        said = judged(UNKNOWN, case(**facts), diagnosis(null=null), True, beside(0.3))
        assert (said.status, said.next_test) == ("unknown", words)
    assert judged(GREEN, case(), diagnosis(), True, beside(0.4)).next_test == ""
    small = judged(GREEN, case(), diagnosis(), True, beside(0.004))
    assert (small.verdict, small.next_test) == (("linear_damping",), next_test("linear_damping"))


def test_a_gain_beyond_every_replica_still_says_what_it_is_most_like():
    null = beside(1e-6)
    said = judged(GREEN, case(), diagnosis(), True, replace(null, tests=(replace(null.tests[0], p_value=0.0),)))
    assert (said.status, said.verdict) == ("present_but_small", ("linear_damping",))
    assert "most like linear damping" in said.sentence


@pytest.mark.parametrize(("allowed", "green"), [(0.29, True), (0.31, False)])
def test_where_repetitions_differ_by_a_third_of_the_motion_nothing_missing_says_nothing(allowed, green):
    """A mass that changed by 4 % on the way was green at a repeatability of 40 %, half of which would not count."""
    said = judged(GREEN, case(allowed=allowed), diagnosis(), True, beside(0.4))
    assert (said.status == "nothing_missing") is green
    (gate,) = (g for g in said.decision if g.gate == "upper_bound")
    assert gate.passed is green
    if not green:
        assert (gate.value, gate.limit) == (pytest.approx(0.155), pytest.approx(0.15))
        assert said.because.startswith("repetitions differ by more than 30 % of the motion")
        assert said.next_test.startswith("releases that differ less, or trials.window over fewer swings")


@pytest.mark.parametrize(
    ("share", "status"), [(0.05, "unknown"), (0.022, "present_but_small"), (0.01, "nothing_missing")]
)
def test_what_is_left_far_above_noise_is_no_green_however_much_trials_differ(monkeypatch, share, status):
    null = SimpleNamespace(names=(), suspects=(), score=0.0, out="", aside=False, fit=no_trial(400.0))
    monkeypatch.setattr("undertow.discrepancy.decision.left_share", lambda fit: share)
    said = judged(GREEN, case(), diagnosis(null=null), True, beside(0.4))
    assert said.status == status
    if status != "nothing_missing":
        assert said.verdict == ("unknown",)
        assert f"leave {100 * share:.1f} % of the motion, 20 times the sensors' noise" in said.sentence
        monkeypatch.setattr("undertow.discrepancy.decision.wanders", lambda fit: True)
        said = judged(GREEN, case(), diagnosis(null=null), True, beside(0.4))
        assert (said.status, "a sensor that wanders" in said.because) == ("cannot_tell", True)


def test_what_is_left_above_noise_is_small_only_where_no_more_could_hide(monkeypatch):
    monkeypatch.setattr("undertow.discrepancy.decision.left_share", lambda fit: 0.021)
    null = SimpleNamespace(score=0.0, fit=no_trial(4.0))
    for hidden, status in ((0.5, "present_but_small"), (1.2, "unknown")):
        said = judged(GREEN, case(), diagnosis(null=null), True, beside(0.4, hidden=hidden))
        assert (said.status, said.verdict) == (status, ("unknown",))


@pytest.mark.parametrize(
    ("all_trials", "largest", "status"),
    [(0.01, False, "cannot_tell"), (0.01, True, "cannot_tell"), (0.05, False, "cannot_tell"), (0.05, True, "unknown")],
)
def test_one_trial_that_is_not_followed_bars_green_and_hides_no_physics(monkeypatch, all_trials, largest, status):
    null = SimpleNamespace(names=(), suspects=(), score=0.0, out="", aside=False, fit=no_trial(400.0))
    monkeypatch.setattr("undertow.discrepancy.decision.left_share", lambda fit: all_trials)
    one = Alone("r4", 0.06, 400.0, largest)
    monkeypatch.setattr("undertow.discrepancy.decision.one_alone", lambda case, fit: one)
    said = judged(GREEN, case(), diagnosis(null=null), True, beside(0.4))
    assert (said.status, one.words in said.because) == (status, status == "cannot_tell")
    little = replace(one, share=0.01)
    monkeypatch.setattr("undertow.discrepancy.decision.one_alone", lambda case, fit: little)
    monkeypatch.setattr("undertow.discrepancy.decision.left_share", lambda fit: 0.01)
    assert judged(GREEN, case(), diagnosis(null=null), True, beside(0.4)).status == "nothing_missing"


def test_what_wanders_is_no_unknown_physics(monkeypatch):
    null = SimpleNamespace(score=0.0, fit=no_trial(4.0))
    assert judged(UNKNOWN, case(), diagnosis(null=null), True, beside(0.3)).status == "unknown"
    monkeypatch.setattr("undertow.discrepancy.decision.wanders", lambda fit: True)
    said = judged(UNKNOWN, case(), diagnosis(null=null), True, beside(0.3))
    assert said.status == "cannot_tell"
    assert "slower than the motion" in said.because
    one = Alone("r4", 0.38, 100.0)
    monkeypatch.setattr("undertow.discrepancy.decision.one_alone", lambda case, fit: one)
    assert judged(UNKNOWN, case(), diagnosis(null=null), True, beside(0.3)).because == one.words
    assert judged(UNKNOWN, case(), diagnosis(null=null), True, beside(0.001)).status == "unknown"


@pytest.mark.parametrize(
    ("rate_hz", "said"), [(0.2, "slower than the motion: a sensor"), (10.0, "faster than the motion, at 10 Hz")]
)
def test_hum_is_not_called_slow(rate_hz, said):
    t = np.arange(2000) * 0.01
    left = np.sin(2.0 * np.pi * rate_hz * t) + 0.1 * np.random.default_rng(1).standard_normal(t.size)
    trial = SimpleNamespace(t=t, period_s=1.0, channels=("displacement",))
    fit = SimpleNamespace(solution=SimpleNamespace(problem=SimpleNamespace(trials=(trial,)), residuals=(left,)))
    assert no_physics(fit).startswith(said)


@pytest.mark.parametrize(
    ("misfit", "p_value", "status"), [(1.1, 0.3, "cannot_tell"), (4.0, 0.3, "unknown"), (1.1, 0.004, "unknown")]
)
def test_unknown_needs_more_than_noise_or_a_level_that_stands_out(misfit, p_value, status):
    null = SimpleNamespace(score=0.0, fit=no_trial(misfit))
    said = judged(UNKNOWN, case(baseline=Described(0.3)), diagnosis(null=null), True, beside(p_value))
    assert said.status == status
    if status == "cannot_tell":
        assert "trials may differ by more than is known" in said.because
        assert said.next_test.startswith("three releases")
    named = replace(UNKNOWN, verdict=("hidden_resonator", "unknown"))
    assert judged(named, case(), diagnosis(null=null), True, beside(p_value)).verdict == named.verdict


def test_what_stands_out_though_the_scatter_is_only_assumed_is_said():
    said = judged(GREEN, case(assumed="there are 2 dry trials"), diagnosis(), True, beside(0.004))
    assert said.status == "present_but_small"
    said = judged(GREEN, case(assumed="there are 2 dry trials"), diagnosis(), True, beside(0.4))
    assert said.status == "cannot_tell"


def test_a_name_needs_a_level_that_stands_out():
    named = replace_label(candidate("linear_damping", 20.0), "linear_damping")
    search = diagnosis(True, best=named)
    assert judged(NAMED, case(), search, True, beside(0.004)).status == "explained"
    said = judged(NAMED, case(), search, True, beside(0.2))
    assert (said.status, said.verdict) == ("cannot_tell", ())
    assert "20 % of such levels with nothing missing stand out as much" in said.because
    assert said.next_test.startswith("more releases")
    other = diagnosis(True, best=replace_label(named, "presliding"))
    assert judged(NAMED, case(), other, True, beside(0.2)).status == "explained"  # a law that was not tested
    two = SimpleNamespace(**{**vars(named), "suspects": (*other.best.suspects, *named.suspects)})
    assert judged(NAMED, case(), diagnosis(True, best=two), True, beside(0.2)).status == "cannot_tell"
    two.fit.misfit = 30.0  # the replicas hold what is left, and tell nothing
    assert judged(PROVED, case(), diagnosis(True, best=two), True, beside(0.2)).status == "explained"
    assert judged(PROVED, case(), search, True, beside(0.2)).status == "cannot_tell"  # but all of this one


def test_a_search_that_ended_on_known_scatter_stays_green():
    said = judged(GREEN, case(), diagnosis(), True)
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
    said = judged(GREEN, case(**facts), diagnosis(**search), True)
    assert (said.status, said.verdict, said.parameters) == ("cannot_tell", (), {})
    assert because in said.because
    assert [gate.because for gate in said.decision if not gate.passed] == [said.because]
    assert said.because in said.sentence
    assert said.next_test


def test_where_nothing_was_looked_for_nothing_is_said_to_be_unknown():
    said = judged(UNKNOWN, case(), diagnosis(looked=0), True)
    assert (said.status, said.verdict) == ("cannot_tell", ())
    assert said.because == "discrepancy.suspects names none that these trials could tell: nothing was looked for"
    far = case(baseline=Described(0.11))  # more than twice what repetitions differ by: something is there all the same
    assert judged(UNKNOWN, far, diagnosis(looked=0), True).status == "unknown"
    assert judged(UNKNOWN, case(), diagnosis(), True).status == "unknown"


@pytest.mark.parametrize(("cycles", "few"), [(3.9, True), (4.1, False)])
def test_what_is_slow_in_a_record_looks_like_a_sensor_that_wanders(cycles, few):
    best = candidate("external_forcing", 20.0, rate=1.0)
    trial = SimpleNamespace(t=np.array([1.0, 11.0]))
    best.fit.solution.problem.trials = (trial, SimpleNamespace(t=np.array([0.0, 4.0])))
    best.fit.values = {"external_forcing.rate": 2.0 * np.pi * cycles / 10.0}
    said = as_what(best)
    assert said.startswith(" as external forcing")
    assert ("fewer than 4 cycles in a record, as a sensor that wanders may" in said) is few
    best.fit.values = {}
    assert as_what(best) == " as external forcing"


def test_channels_that_contradict_leave_no_name_either():
    said = judged(NAMED, case(contradiction="x and a disagree"), diagnosis(True), True)
    assert (said.status, said.verdict, said.contradicted) == ("cannot_tell", (), True)


def test_a_name_stands_where_twice_the_assumed_scatter_leaves_it():
    assert judged(NAMED, case(assumed="there are 2 dry trials"), diagnosis(True), True).verdict == NAMED.verdict
    said = judged(NAMED, case(assumed="there are 2 dry trials"), diagnosis(True), False)
    assert (said.status, said.verdict) == ("cannot_tell", ())
    assert "with twice that nothing would be said" in said.because


def test_an_unknown_that_twice_the_assumed_scatter_allows_is_cannot_tell():
    near = case(assumed="there are 2 dry trials", baseline=Described(0.08))
    assert judged(UNKNOWN, near, diagnosis(), True).status == "cannot_tell"
    far = case(assumed="there are 2 dry trials", baseline=Described(0.3))
    assert judged(UNKNOWN, far, diagnosis(), True).status == "unknown"


def test_unknown_is_not_said_by_a_search_that_did_not_end():
    cut = diagnosis(unfinished=("further effects",))
    said = judged(UNKNOWN, case(), cut, True)
    assert (said.status, said.verdict) == ("cannot_tell", ())
    assert "not tried to the end within discrepancy.budget: further effects" in said.because
    named = replace(UNKNOWN, verdict=("hidden_resonator", "unknown"))
    assert judged(named, case(), cut, True).verdict == ("hidden_resonator", "unknown")  # what was found stays


def test_the_posterior_counts_what_is_excluded_and_the_confidence_does_not():
    said = candidate("linear_damping", 0.0)
    excluded = candidate("relaxation", math.log(3.0), "on its bound")
    assert probability(said, [said, excluded], []) == pytest.approx(1.0)
    cut = SimpleNamespace(best=said, candidates=(said, excluded), screened=())
    assert posterior(cut) == pytest.approx(0.25)
    assert posterior(cut, excluded) == pytest.approx(0.75)


def test_overwhelming_evidence_for_a_small_effect_is_not_green():
    small = SimpleNamespace(names=("cubic_stiffness",), score=60.0)
    said = judged(GREEN, case(), diagnosis(small=small), True)
    assert (said.status, said.verdict) == ("present_but_small", ("cubic_stiffness",))
    assert "10^26 to 1" in said.sentence
    assert judged(GREEN, case(), diagnosis(small=small), True, beside(0.7)).status == "nothing_missing"
    rare = judged(GREEN, case(), diagnosis(small=small), True, beside(0.004))
    assert rare.verdict == ("cubic_stiffness",)  # evidence has a name; the rank among replicas has another
    asked = [gate.statistic for gate in rare.decision if gate.gate == "p_value"]
    assert len(asked) == 1
    assert "odds" not in asked[0]


@pytest.mark.parametrize(
    ("after", "status"), [(0.02, "explained"), (0.034, "explained"), (0.051, "unknown"), (0.06, "unknown")]
)
def test_a_name_that_makes_unseen_trials_worse_is_not_proved(after, status):
    facts = case(baseline=Described(0.04, 0.03))
    named = replace(NAMED, augmented=Described(0.01, after))
    said = judged(named, facts, diagnosis(True), True)
    assert said.status == status
    if status == "unknown":  # the name is kept, and no free run with it is offered
        went = f"went from 3.0 % to {100.0 * after:.1f} %"
        assert said.sentence.endswith(
            f"But this is not proved: linear damping would be named, but the trials it never saw {went}."
        )
        assert (said.verdict, said.augmented) == (("linear_damping", "unknown"), None)
        assert said.next_test.startswith("more releases: what these trials show does not carry over")


@pytest.mark.parametrize(("after", "kept"), [(0.034, True), (0.06, False)])
def test_a_name_beside_unknown_that_makes_unseen_trials_worse_offers_no_free_run(after, kept):
    beside = replace(NAMED, status="unknown", verdict=("sensor_drift", "unknown"), augmented=Described(0.01, after))
    said = judged(beside, case(baseline=Described(0.04, 0.03)), diagnosis(True), True)
    assert (said.status, said.verdict) == ("unknown", beside.verdict)
    assert said.augmented == (beside.augmented if kept else None)
    assert ("But this is not proved: sensor drift would be named" in said.sentence) != kept


@pytest.mark.parametrize(("rate", "held"), [(0.4, True), (0.6, False)])
def test_a_resonator_without_a_frequency_is_no_name_whatever_bars_the_answer(rate, held):
    """Whether the dry trials lack something that nobody knows is asked first, and would keep all names."""
    search = diagnosis(True, best=candidate("hidden_resonator", 20.0, rate=rate))
    numbers = {"hidden_resonator": {"mass_kg": Estimate(8.0, 0.9)}}
    one = replace(NAMED, verdict=("hidden_resonator",), parameters=numbers, augmented=Described(0.01, 0.01))
    said = judged(one, case(dry_unknown="nobody knows for sure what is missing in the dry trials too"), search, True)
    assert said.status == "unknown"
    assert said.verdict == (("hidden_resonator", "unknown") if held else ("unknown",))
    assert (said.parameters, said.augmented) == ((numbers, one.augmented) if held else ({}, None))
    again = judged(one, case(), search, True)
    assert (again.status == "explained") == held
    assert ("the frequency of hidden resonator lies 1.7 standard errors from zero, counting" in again.sentence) != held


@pytest.mark.parametrize(("error", "held"), [(0.4, True), (0.6, False)])
def test_a_law_that_is_not_distinct_from_zero_counting_how_trials_differ_is_no_answer(error, held):
    search = diagnosis(True, best=candidate("linear_damping", 20.0, error=error))
    said = judged(NAMED, case(), search, True)
    assert (said.status, said.verdict) == (("explained", NAMED.verdict) if held else ("unknown", ("unknown",)))
    beside = replace(NAMED, verdict=("hysteresis", "linear_damping"))  # what the dry trials need stays
    names = beside.verdict if held else ("hysteresis", "unknown")
    said = judged(beside, case(), search, True)
    assert said.verdict == names
    assert ("linear damping lies 1.7 standard errors from zero, counting how much it" in said.sentence) != held
    unknown = replace(beside, status="unknown", verdict=("hysteresis", "linear_damping", "unknown"))
    assert judged(unknown, case(), search, True).verdict == (unknown.verdict if held else ("hysteresis", "unknown"))
    inner = diagnosis(True, best=candidate("linear_damping", 20.0, error=error, inner=True))
    assert judged(NAMED, case(), inner, True).status == "explained"
    free = case()
    free.member.free_start = True
    assert judged(NAMED, free, search, True).status == "explained"


DESCRIBES = diagnosis(True, best=candidate("linear_damping", 20.0, misfit=30.0))
"""A name that leaves five times the noise."""


def test_a_description_that_takes_its_own_trials_further_away_is_none_beside_an_unknown_structure_either():
    puzzled = case(dry_unknown="something that nobody knows is missing in the dry trials too")
    named = replace(NAMED, augmented=Described(0.061, math.nan))
    said = judged(named, puzzled, DESCRIBES, True)
    assert (said.status, said.verdict) == ("unknown", ("unknown",))
    assert [gate.gate for gate in said.decision].count("comes_closer") == 1


@pytest.mark.parametrize("status", ["explained", "not_identifiable", "unknown"])
@pytest.mark.parametrize(("after", "names"), [(0.02, ("linear_damping",)), (0.059, ("linear_damping",)), (0.061, ())])
def test_a_description_that_takes_its_own_trials_further_away_is_none_beside_unknown_either(after, names, status):
    rest = ("unknown",) if status == "unknown" else ()
    named = replace(NAMED, status=status, verdict=("linear_damping", *rest), augmented=Described(after, math.nan))
    said = judged(named, case(), DESCRIBES, True)
    if names:
        kept = (*names, "unknown") if status != "not_identifiable" else names  # no unseen trial proves a description
        assert (said.verdict, said.augmented) == (kept, named.augmented)
    else:
        assert (said.status, said.verdict, said.parameters) == ("unknown", ("unknown",), {})
        assert said.augmented is None
        went = "with linear damping the trials it was fitted to go from 4.0 % to 6.1 %"
        assert f"It is not the answer: {went}." in said.sentence


@pytest.mark.parametrize(("names", "held"), [(("gain_error",), True), (("linear_damping", "gain_error"), False)])
def test_no_free_run_of_the_displacement_speaks_against_a_sensor(names, held):
    named = replace(NAMED, verdict=names, augmented=Described(0.061, math.nan))
    found = diagnosis(True, best=candidate("gain_error", 20.0, frees="acceleration_gain"))
    said = judged(named, case(), found, True)
    assert (said.status == "explained") == held
    assert ("comes_closer" in [gate.gate for gate in said.decision]) != held


@pytest.mark.parametrize("status", ["explained", "not_identifiable", "unknown"])
def test_a_name_that_leaves_no_more_than_noise_is_kept_where_its_own_trials_go_further_away(status):
    rest = ("unknown",) if status == "unknown" else ()
    named = replace(NAMED, status=status, verdict=("linear_damping", *rest), augmented=Described(0.061, math.nan))
    for level in (diagnosis(True), diagnosis()):  # also of what the dry trials need, with nothing else named
        said = judged(named, case(), level, True)
        assert (said.status, said.verdict) == ("unknown", ("linear_damping", "unknown"))
        assert (said.parameters, said.augmented) == (named.parameters, None)


def test_a_name_less_likely_than_something_that_was_excluded_is_no_answer():
    more = candidate("external_forcing", 22.0, "its phases are locked to the release")
    said = judged(NAMED, case(), diagnosis(True, candidates=(candidate("linear_damping", 20.0), more)), True)
    assert (said.status, said.verdict, said.parameters) == ("unknown", ("unknown",), {})
    assert "its probability is 12 %, and most probable is external forcing, excluded because its" in said.sentence
    assert said.next_test.startswith("more releases of different size")
    near = diagnosis(True, candidates=(candidate("linear_damping", 20.0), replace_score(more, 19.0)))
    assert judged(NAMED, case(), near, True).status == "explained"


def test_a_name_that_is_more_probable_with_something_beside_it_is_not_all():
    one = candidate("linear_damping", 20.0)
    more = SimpleNamespace(**{**vars(candidate("linear_damping", 22.0, "it is 0.9 standard errors from zero"))})
    more.names = more.amounts_to = ("linear_damping", "hysteresis")
    said = judged(NAMED, case(), diagnosis(True, candidates=(one, more)), True)
    assert (said.status, said.verdict) == ("unknown", ("linear_damping", "unknown"))
    assert (said.parameters, said.augmented) == (NAMED.parameters, NAMED.augmented)
    assert "But this is not all: its probability is 12 %, and most probable is linear damping and" in said.sentence
    assert said.next_test.endswith("something beside what is named is not known yet")
    near = diagnosis(True, candidates=(one, replace_score(more, 19.0)))
    assert judged(NAMED, case(), near, True).status == "explained"
    far = candidate("linear_damping", 20.0, misfit=30.0)  # a description: it says that it leaves more than noise
    described = diagnosis(True, best=far, candidates=(far, more))
    assert judged(PROVED, case(), described, True).status == "explained"


PROVED = replace(NAMED, augmented=Described(0.01, 0.045))
"""An unseen trial within the 5 % by which repetitions differ."""


def test_a_description_must_be_more_likely_than_what_was_excluded_too():
    describes = candidate("linear_damping", 20.0, misfit=30.0)
    for score, status in ((19.0, "explained"), (21.0, "unknown")):
        more = candidate("hidden_resonator", score, "it is 0.9 standard errors from zero")
        both = diagnosis(True, best=describes, candidates=(describes, more))
        assert judged(PROVED, case(), both, True).status == status


@pytest.mark.parametrize(
    ("after", "facts", "misfit", "said"),
    [
        (0.045, {}, 30.0, ""),
        (0.06, {}, 30.0, ""),
        (0.08, {}, 30.0, "unseen trials come no closer than 8.0 %, where repetitions differ by 5.0 %"),
        (math.nan, {}, 30.0, "it has no unseen trial that would prove it"),
        (0.045, {"assumed": "nobody repeated it"}, 30.0, "how much repetitions differ was not measured"),
        (math.nan, {}, 2.0, ""),
    ],
)
def test_what_leaves_more_than_noise_is_an_answer_where_unseen_trials_prove_it(after, facts, misfit, said):
    describes = candidate("linear_damping", 20.0, misfit=misfit)
    named = replace(NAMED, augmented=Described(0.01, after), alternatives=(("cubic_damping",),))
    for status in ("explained", "not_identifiable"):
        verdict = judged(replace(named, status=status), case(**facts), diagnosis(True, best=describes), True)
        if said and status == "explained":
            assert (verdict.status, verdict.verdict) == ("unknown", ("linear_damping", "unknown"))
            assert verdict.parameters == {"linear_damping": {}}
            assert verdict.augmented is not None
            assert f"It is not the answer: {said}" in verdict.sentence
            assert "one of them held out" in verdict.next_test
        else:
            assert verdict.status == status


def test_what_leaves_more_than_noise_is_no_answer_where_unseen_trials_come_no_closer():
    describes = diagnosis(True, best=candidate("linear_damping", 20.0, misfit=30.0))
    for before, status in product((0.03, 0.05), ("explained", "not_identifiable")):
        named = replace(NAMED, status=status, augmented=Described(0.01, 0.04))
        said = judged(named, case(baseline=Described(0.04, before)), describes, True)
        assert said.status == ("unknown" if before < 0.04 else status)  # of rivals, too, what takes them away is none
        assert ("unseen trials come no closer than 3.0 %, where" in said.sentence) == (said.status == "unknown")


def test_what_the_free_run_hardly_shows_outweighs_nothing():
    echo = candidate("delayed_echo", 200.0, "brings the free run no closer by what counts", aside=True)
    both = diagnosis(True, candidates=(candidate("linear_damping", 20.0), echo))
    assert judged(NAMED, case(), both, True).status == "explained"


def test_a_rival_that_was_excluded_outweighs_nothing():
    rival = candidate("hidden_resonator", 300.0, "its damping sits on a bound")
    both = diagnosis(True, candidates=(candidate("linear_damping", 20.0), rival), rivals=(("hidden_resonator",),))
    assert judged(NAMED, case(), both, True).status == "explained"


@pytest.mark.parametrize(
    ("names", "said"),
    [(("linear_damping", "external_forcing"), ("linear_damping", "unknown")), (("hysteresis",), ("unknown",))],
)
def test_a_set_that_holds_what_is_said_does_not_speak_against_it(names, said):
    more = candidate(names[0], 300.0, "it leaves too much")
    more = SimpleNamespace(**(vars(more) | {"names": names, "amounts_to": names}))
    both = diagnosis(True, candidates=(candidate("linear_damping", 20.0), more))
    found = judged(NAMED, case(), both, True)
    assert (found.status, found.verdict) == ("unknown", said)


def test_a_small_effect_has_a_name_where_nothing_else_is_nearly_as_probable():
    small, other = candidate("cubic_stiffness", 40.0), candidate("quintic_stiffness", 38.0, "it sits on a bound")
    far = diagnosis(small=small, candidates=(small, replace_score(other, 30.0)))
    alone = judged(GREEN, case(), far, True, beside(0.004))
    assert (alone.status, alone.verdict) == ("present_but_small", ("cubic_stiffness",))
    both = judged(GREEN, case(), diagnosis(small=small, candidates=(small, other)), True, beside(0.004))
    assert (both.status, both.verdict) == ("present_but_small", ("unknown",))
    assert "most probably cubic stiffness, or quintic stiffness." in both.sentence


def test_a_law_on_its_bound_speaks_for_the_simpler_one_which_it_becomes_there():
    bound = candidate("stribeck_friction", 42.0, "its speed sits on its bound", becomes="coulomb_friction")
    plain = candidate("coulomb_friction", 40.0)
    said = judged(GREEN, case(), diagnosis(small=plain, candidates=(plain, bound)), True, beside(0.004))
    assert (said.status, said.verdict) == ("present_but_small", ("coulomb_friction",))
    named = replace(NAMED, verdict=("coulomb_friction",))
    assert judged(named, case(), diagnosis(True, best=plain, candidates=(plain, bound)), True).status == "explained"
    pair = {"names": ("stribeck_friction", "hysteresis"), "amounts_to": ("coulomb_friction", "hysteresis")}
    more = SimpleNamespace(**(vars(bound) | pair | {"score": 300.0}))  # holds what is said, by what it amounts to
    found = judged(named, case(), diagnosis(True, best=plain, candidates=(plain, more)), True)
    assert (found.status, found.verdict) == ("unknown", ("coulomb_friction", "unknown"))
    sliding = candidate("stribeck_friction", 42.0, "its force is 1.0 standard errors from zero")
    assert judged(named, case(), diagnosis(True, best=plain, candidates=(plain, sliding)), True).status == "unknown"


def test_a_set_that_holds_the_small_effect_is_no_other_name_for_it():
    small, more = candidate("cubic_stiffness", 40.0), candidate("hysteresis", 41.0)
    pair = ("cubic_stiffness", "hysteresis")
    more = SimpleNamespace(**(vars(more) | {"names": pair, "amounts_to": pair}))
    said = judged(GREEN, case(), diagnosis(small=small, candidates=(small, more)), True, beside(0.004))
    assert said.verdict == ("cubic_stiffness",)


@pytest.mark.parametrize(
    ("away", "told", "names"),
    [
        (1.4, math.nan, ("linear_damping", "unknown")), (1.6, math.nan, ("unknown",)), (1.6, 0.7, ("unknown",)),
        (1.6, 0.8, ("linear_damping", "unknown")),
    ],
)  # fmt: skip
def test_what_leaves_the_trials_of_its_own_water_far_away_is_no_description(away, told, names):
    level = diagnosis(True, best=candidate("linear_damping", 20.0, misfit=12.0))
    for verdict in (NAMED, replace(NAMED, status="unknown", verdict=("linear_damping", "unknown"))):
        said = earned(verdict, case(), level, NullTest(math.nan), True, DryAnswer(), Closeness(away, told))
        assert (said.status, said.verdict) == ("unknown", names)
        assert ("1.6 times as far away as repetitions are" in said.sentence) == (names == ("unknown",))
    level = diagnosis(True, best=candidate("linear_damping", 20.0, misfit=1.2))
    near = earned(NAMED, case(), level, NullTest(math.nan), True, DryAnswer(), Closeness(away, told))
    assert near.status == "explained"


@pytest.mark.parametrize(("left", "names"), [(4.0, ("linear_damping", "unknown")), (6.0, ("unknown",))])
def test_where_no_trial_is_unseen_a_description_leaves_a_twentieth_of_what_the_equation_had_left(left, names):
    null = SimpleNamespace(names=(), suspects=(), score=0.0, out="", aside=False, fit=no_trial(101.0), amounts_to=())
    level = diagnosis(True, null=null, best=candidate("linear_damping", 20.0, misfit=1.0 + left))
    said = earned(NAMED, case(), level, NullTest(math.nan), True, DryAnswer(), Closeness(3.0, math.nan))
    assert (said.status, said.verdict) == ("unknown", names)


def test_what_is_named_reaches_as_far_as_its_groups_together():
    runs = {"a": 0.06, "b": 0.06, "c": 0.08, "d": 0.03}
    runs = {name: SimpleNamespace(nrmse=error) for name, error in runs.items()}
    held = tuple(SimpleNamespace(name=name) for name in "d")
    near = replace(case(baseline=Described(0.04, 0.06)), held=held)
    alone = case(allowed=0.1)
    # trials of 1.2, 1.2 and 1.6 repeatabilities, the same of half that: a group is its median, as its equation alone is
    told = reach((near, alone), near, runs, forced=True)
    assert told.away == pytest.approx(math.sqrt((1.2**2 + 0.6**2) / 2.0))
    assert told.explained == pytest.approx(0.75)
    assert told.unseen == 0.03
    assert math.isnan(reach((near, alone), near, runs, forced=False).unseen)  # a trial's own mass is told by no other
    assert math.isnan(reach((near, alone), alone, runs, forced=True).unseen)
    assert math.isnan(reach((alone,), alone, runs, forced=True).explained)


@pytest.mark.parametrize(("unseen", "said"), [(0.07, "explained"), (0.08, "unknown"), (math.nan, "unknown")])
def test_a_force_that_leaves_more_than_noise_is_proved_where_unseen_trials_need_its_size_and_phase_alone(unseen, said):
    level = diagnosis(True, best=candidate("external_forcing", 20.0, misfit=12.0))
    named = replace(NAMED, verdict=("external_forcing",), augmented=Described(0.02, math.nan))
    group = case(baseline=Described(0.2, 0.3))
    found = earned(named, group, level, NullTest(math.nan), True, DryAnswer(), Closeness(0.5, 0.9, unseen))
    assert (found.status, "external_forcing" in found.verdict) == (said, True)


def replace_label(one: SimpleNamespace, label: str) -> SimpleNamespace:
    """The same candidate of another suspect."""
    return SimpleNamespace(**(vars(one) | {"suspects": (SimpleNamespace(label=label),)}))


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


def fading_memory(odds: float) -> SimpleNamespace:
    """A relaxation that leaves noise and misses .4 repeatabilities beside linear damping that leaves twice the noise
    (mean square 2.2) and misses .5, before which stood 3: what the search keeps after asking for the plainer."""
    memory, plain = (
        SimpleNamespace(suspects=(suspect,), names=(suspect.name,), score=score, out="", aside=False,
                        fit=SimpleNamespace(misfit=misfit, miss=miss))
        for suspect, score, misfit, miss in (
            (SimpleNamespace(name="relaxation", without_sliding=None, swings=False, fades=True, plain=False),
             odds, 1.0, 0.4),
            (SimpleNamespace(name="linear_damping", plain=True), 0.0, 2.2, 0.5),
        )
    )  # fmt: skip
    search = SimpleNamespace(error=3.0, level=None, found=[], best=None, _set_aside=lambda *_: None)
    return _Search._plainer(search, (memory, 0.4), [memory, plain])[0]


@pytest.mark.parametrize(("odds", "named"), [(5.0, "linear_damping"), (20.0, "relaxation")])
def test_a_memory_with_overwhelming_evidence_is_not_called_damping(monkeypatch, odds, named):
    monkeypatch.setattr("undertow.comparison.search.free_run_error", lambda _, fit: fit.miss)
    assert fading_memory(odds).names == (named,)


def test_a_kernel_of_radiated_waves_has_no_frequency_to_be_held_against_a_cell():
    waves = {"hidden_resonator": [{"kernel_mass_kg": Estimate(9.0, 1.0), "c_Ns_per_m": Estimate(5.0, 1.0)}]}
    assert _physics(case(), waves).because == "no bound applies to this effect"
    rings = [{"natural_frequency_rad_per_s": Estimate(9.0, 0.1)}]
    assert _physics(case(), {"hidden_resonator": [*waves["hidden_resonator"], *rings]}).because != ""


def test_a_name_that_leaves_more_than_noise_says_that_it_describes():
    def left(misfit: float, trials: int, own: str = "k, c and mu", laws: int = 2) -> str:
        problem = SimpleNamespace(trials=[None] * trials)
        fit = SimpleNamespace(misfit=misfit, solution=SimpleNamespace(problem=problem))
        return _left(SimpleNamespace(best=SimpleNamespace(fit=fit, suspects=(None,) * laws)), case(own=own))

    assert "a description rather than the law" in left(36.0, 2)
    assert left(36.0, 2).endswith("of each trial's own it leaves 6 times the sensors' noise.")
    assert left(36.0, 3).endswith("noise; its numbers' errors hold by how much they move without one trial or another.")
    assert left(1.2, 3) == ""
    assert "Three laws at once are a description rather than the law" in left(1.2, 3, laws=3)
    assert "Three" not in left(36.0, 3, laws=3)
    assert "even with k and c of each trial's own" in left(36.0, 2, "k and c")


@pytest.mark.parametrize(
    ("left", "p_value", "size", "said"),
    [
        (1.2, 0.4, 0.5, "explained"), (1.2, 1e-6, 0.5, "explained"), (1.2, 1e-6, 1.2, "unknown"),
        (9.0, 1e-6, 0.5, "unknown"), (9.0, 0.4, 0.5, "explained"),
    ],
)  # fmt: skip
def test_what_the_dry_trials_need_is_not_all_in_a_water_that_stands_out_beside_it(left, p_value, size, said):
    null = SimpleNamespace(**(vars(diagnosis().null) | {"fit": no_trial(left)}))
    proved = replace(NAMED, augmented=Described(0.02, 0.02))
    level = diagnosis(null=null, best=null, candidates=(null,))
    unseen = case(baseline=Described(0.04, 0.06))
    found = judged(proved, unseen, level, True, beside(p_value, size))
    names = ("linear_damping",) if said == "explained" else ("linear_damping", "unknown")
    assert (found.status, found.verdict) == (said, names)
    if said == "unknown":
        assert "of levels like this with nothing beside it fewer than one in a thousand stand out" in found.sentence
    (gate,) = (g for g in found.decision if g.gate == "p_value")
    assert gate.passed == (said == "explained")


@pytest.mark.parametrize(("away", "unseen", "said"), [(0.5, 0.02, "explained"), (9.0, 0.09, "unknown")])
def test_what_the_dry_trials_need_is_a_description_where_it_leaves_more_than_noise_in_water(away, unseen, said):
    null = SimpleNamespace(**(vars(diagnosis().null) | {"fit": no_trial(9.0)}))
    level = diagnosis(null=null, best=null, candidates=(null,))
    verdict = replace(NAMED, augmented=Described(0.02, unseen))
    group = case(baseline=Described(0.04, 0.06))
    found = earned(verdict, group, level, beside(0.4), True, DryAnswer(), Closeness(away, math.nan))
    assert found.status == said
    assert "linear_damping" in found.verdict  # the dry trials prove that it is there
    assert found.augmented is not None


@pytest.mark.parametrize(("dry", "words"), [(True, "Something that was not recorded and"), (False, "Water that")])
def test_nothing_is_said_to_be_water_in_air(dry, words):
    said = sentence_of(case(dry=dry), ["hidden_resonator"], [], {}, 0.01, math.nan, False, ())
    assert f"{words} oscillates by itself explains it." in said


def test_what_a_sensor_drifts_is_said_to_be_taken_out_of_an_unseen_trial():
    unseen = case(baseline=Described(0.04, 0.03), held=[SimpleNamespace(name="d")])
    said = sentence_of(unseen, ["sensor_drift"], [], {}, 0.01, 0.012, False, ())
    assert "On 1 trial it never saw, with that trial's own drift of the sensor taken out, the error goes from" in said
    assert "taken out" not in sentence_of(unseen, ["gain_error"], [], {}, 0.01, 0.012, False, ())


@pytest.mark.parametrize(("size", "words"), [(5.0, "explains it: 5 ± 3 N/m."), (3.3, "explains it.")])
def test_a_number_hardly_above_its_own_error_is_not_said(size, words):
    numbers = {"relaxation": [{"stiffness_N_per_m": Estimate(size, 3.0, unit="N/m")}]}
    assert words in sentence_of(case(), ["relaxation"], [], numbers, 0.01, math.nan, False, ())


def test_numbers_in_a_sentence_have_names():
    two_pi = Estimate(2.0 * math.pi, 0.01, unit="rad/s")
    resonator = {
        "mass_kg": Estimate(45.0, 1.2, unit="kg"), "natural_frequency_rad_per_s": two_pi,
        "damping_ratio": Estimate(0.04, 0.001),
    }  # fmt: skip
    yields = Estimate(0.02, 0.001, unit="m")
    joint = {"stiffness_N_per_m": Estimate(5e10, 3e9, unit="N/m"), "yield_displacement_m": yields}
    found = {"hidden_resonator": [resonator], "hysteresis": [joint]}
    said = sentence_of(case(), list(found), [], found, 0.01, math.nan, False, ())
    assert "a mass of 45.0 ± 1.2 kg at 1.0000 ± 0.0016 Hz, damping 4 % of critical; " in said
    assert "; (5.00 ± 0.30) × 10^10 N/m, yield displacement 0.0200 ± 0.0010 m." in said


def test_an_error_within_repeatability_is_not_said_to_be_missed_beyond_it():
    in_air = sentence_of(case(dry=True), ["quadratic_drag"], [], {}, 0.01, math.nan, False, ())
    assert "those of the water in equation.terms are left out" in in_air
    assert "left out" not in sentence_of(case(dry=True), ["cubic_stiffness"], [], {}, 0.01, math.nan, False, ())
    more = [["relaxation", "cubic_stiffness"], ["relaxation", "drag_exponent"]]
    beside = sentence_of(case(missing=1), ["relaxation"], more, {}, 0.01, math.nan, False, ())
    assert "cannot tell it from" not in beside
    assert "drag with another power of the speed is there beside it the data do not say." in beside
    some = sentence_of(case(missing=1), ["relaxation"], [], {}, 0.01, math.nan, False, ())
    assert "in 1 of 3 trials the equation misses more than repetitions differ (median error 4.0 %, rep" in some
    alone = case(member=SimpleNamespace(motions=(SimpleNamespace(name="a"),), free_start=False))
    lone = sentence_of(alone, ["relaxation"], [], {}, 0.01, math.nan, False, ())
    assert "what is left has a shape" in lone
    assert "together" not in lone
    most = sentence_of(case(missing=2, baseline=Described(0.3)), ["relaxation"], [], {}, 0.01, math.nan, False, ())
    assert "the equation misses 30 % of the motion in 2 of 3 trials (repeatability 5.0 %)" in most


def test_what_would_lead_to_an_answer_speaks_of_water_in_water_alone():
    """A body in air, or one of which nobody took the water away, has no "in this water"."""
    lacks = {"assumed": "there is 1 dry trial"}
    wet = judged(GREEN, case(**lacks), diagnosis(), True, beside(0.4)).next_test
    assert wet == "three releases in air, or three of the same size in this water, or state specimen.scatter"
    for elsewhere in ({"dry": True}, {"has_dry": False}):
        said = judged(GREEN, case(**lacks, **elsewhere), diagnosis(), True, beside(0.4)).next_test
        assert said == "three releases of the same size, or state specimen.scatter"
    named = replace_label(candidate("linear_damping", 20.0), "linear_damping")
    dry = judged(NAMED, case(dry=True), diagnosis(True, best=named), True, beside(0.2)).next_test
    assert dry.startswith("more releases")
    assert "water" not in dry


def test_a_trial_beyond_repeatability_beside_nothing_missing_is_what_scatter_does():
    some = _without_a_name(GREEN, case(missing=1), far=False).sentence
    assert "explains 2 of 3 trials within repeatability (error 4.0 %, repeatability 5.0 %, beyond which scatter" in some
    assert "one in twenty" not in _without_a_name(GREEN, case(), far=False).sentence


@pytest.mark.parametrize(
    ("anchored", "rotation", "unit"),
    [(True, False, "N/m^3"), (False, False, "N/m^3 per kg"), (False, True, "N m/rad^3 per kg m^2")],
)
def test_what_could_have_been_seen_has_the_unit_of_the_groups_numbers(anchored, rotation, unit):
    model = GroupModel((), Specimen(rotation=rotation), np.zeros(1), (), anchored=anchored)
    member = SimpleNamespace(motions=(), model=model)
    assert _unit("N/m^3", case(member=member)) == unit
    assert _unit("1", case(member=member)) == "1"


def test_several_names_explain_it_together_and_come_closest_together():
    said = sentence_of(case(), ["relaxation", "cubic_stiffness"], [], {}, 0.01, math.nan, False, ())
    assert " together explain it." in said
    assert "Memory that relaxes and stiffness with" in said
    closest = no_answer("spring short", said, "why")
    assert " together come closest." in closest
    assert "explain" not in closest


def test_what_is_named_is_a_law_and_the_sentence_says_what_of_the_physics_obeys_it():
    one, two = ("hidden_resonator",), ("relaxation", "cubic_stiffness")
    said = sentence_of(case(), one, [], {}, 0.01, math.nan, False, ())
    assert " This law describes water that sloshes, a load that swings or another mode of the body alike." in said
    both = sentence_of(case(), two, [], {}, 0.01, math.nan, False, ())
    assert " or material that creeps (relaxation) and springs that harden or soften, " in both
    assert " changes with displacement (cubic stiffness) alike." in both
    assert "describe" not in sentence_of(case(), one, [], {}, 0.01, math.nan, True, ())
    assert "describe" not in sentence_of(case(), ("imperfect_release",), [], {}, 0.01, math.nan, False, ())
    assert not any("describe" in no_answer("spring short", text, "why") for text in (said, both))


def test_a_name_that_leaves_more_describes_and_one_beside_something_else_comes_closest():
    """"Explains it" stood before "the error goes from 33 % to 38 %" and "something else is missing too"."""
    one = (case(), ["relaxation"], [], {}, 0.01, math.nan)
    assert "Memory that relaxes describes it." in sentence_of(*one, False, (), left=True)
    assert "Memory that relaxes comes closest." in sentence_of(*one, True, (), left=True)
    assert "comes closest" in no_answer("spring short", sentence_of(*one, False, (), left=True), "why")


@pytest.mark.parametrize(("value", "error", "more"), [(1.2, 0.1, True), (0.1, 0.2, False), (0.0, math.nan, False)])
def test_damping_grows_with_amplitude_where_that_is_distinct_from_zero(value, error, more):
    one = {"mass_kg": Estimate(9.0, 0.1, unit="kg"), "natural_frequency_rad_per_s": Estimate(6.0, 0.01, unit="rad/s"),
           "damping_ratio": Estimate(0.02, 0.001), "quadratic_damping_per_m": Estimate(value, error, unit="1/m")}
    said = sentence_of(case(), ["hidden_resonator"], [], {"hidden_resonator": [one]}, 0.01, math.nan, False, ())
    assert ("and more with amplitude" in said) is more


@pytest.mark.parametrize(
    ("facts", "advice"),
    [({"has_dry": True}, "more releases of this spring"), ({"has_dry": False}, "three releases of this spring in air"),
     ({"has_dry": False, "dry": True}, "more releases of this spring")],
)  # fmt: skip
def test_where_no_dry_trials_know_the_damping_they_are_what_is_asked_for(facts, advice):
    said = earned(GREEN, case(**facts), diagnosis(), beside(0.4, hidden=1.2), True)
    assert said.status == "cannot_tell"
    assert said.next_test.startswith(advice)


def test_rivals_have_each_name_once_and_none_says_what_the_answer_says():
    sets = (("sine_restoring", "cubic_stiffness"), ("cubic_stiffness", "cubic_stiffness"), ("cubic_stiffness",))
    assert other_sets(("cubic_stiffness", "sine_restoring"), sets) == (("cubic_stiffness",),)
    assert other_sets(("cubic_stiffness",), sets) == (("sine_restoring", "cubic_stiffness"),)


@pytest.mark.parametrize(
    ("assumed", "words"), [("", "repeatability 5.0 %"), ("two trials", "repeatability 5.0 %, assumed")]
)
def test_what_repetitions_differ_by_is_said_to_be_assumed_where_nobody_measured_it(assumed, words):
    assert case(assumed=assumed).repeats == words
