"""What other waters of a campaign say of a law that one of them cannot tell from another."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest

from undertow.campaign.run import judgement
from undertow.campaign.run.judgement import _Judge, _Together
from undertow.campaign.run.other_waters import told_by_others, with_the_reason
from undertow.comparison.candidate import evidence_by_name
from undertow.comparison.joining import LAWS_DIFFER, told_by_other_waters
from undertow.comparison.suspects import SUSPECTS
from undertow.discrepancy.judge import Judged
from undertow.discrepancy.verdict import Verdict

NAMES = ("cubic_damping", "drag_exponent", "linear_damping")


def said(status: str, verdict=(), alternatives=(), evidence=None, sentence="Something.") -> Judged:
    one = Verdict({}, (), (), status=status, verdict=verdict, alternatives=alternatives, sentence=sentence)
    return Judged((one,), ("short",), evidence=evidence or {})


NEAR = {"drag_exponent": 20.0, "linear_damping": 17.0, "cubic_damping": 3.0}
UNTOLD = said("not_identifiable", ("drag_exponent",), (("linear_damping",),), NEAR)
SURE = said("explained", ("linear_damping",), (), {"linear_damping": 30.0, "drag_exponent": 20.0})


def test_only_a_water_of_which_the_others_change_what_is_likely_is_judged_beside_them():
    assert not told_by_others(1, [UNTOLD, SURE])
    told = dict(told_by_others(0, [UNTOLD, SURE]))
    assert told["linear_damping"] == pytest.approx(math.log(3.0), abs=0.02)
    assert told["drag_exponent"] == pytest.approx(math.log(LAWS_DIFFER + 3.0 * math.exp(-10.0)), abs=0.02)
    assert told_by_others(0, [UNTOLD, said("cannot_tell")]) == ()
    assert told_by_others(0, [SURE, SURE]) == ()
    agrees = said("not_identifiable", ("linear_damping",), (("relaxation",),), {"linear_damping": 9.0})
    assert not told_by_others(0, [agrees, SURE])  # no free decay separates them: no other water does
    by_more_than_evidence = said("explained", ("drag_exponent",), (), {"drag_exponent": 9.0, "linear_damping": 15.0})
    assert not told_by_others(0, [by_more_than_evidence, SURE])


def test_a_name_that_the_others_make_improbable_is_judged_again_and_one_far_ahead_is_not():
    for ahead, again in ((6.0, True), (14.0, False)):
        other = said("explained", ("drag_exponent",), (), {"linear_damping": 4.0, "drag_exponent": 4.0 + ahead})
        assert bool(told_by_others(0, [other, SURE])) == again


def test_waters_that_say_nothing_leave_all_as_it_was_and_each_counts_once():
    nothing = told_by_other_waters([dict.fromkeys(NAMES, 3.0)], NAMES)
    assert list(nothing.values()) == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    once = told_by_other_waters([SURE.evidence], NAMES)
    twice = told_by_other_waters([SURE.evidence, SURE.evidence], NAMES)
    assert twice == pytest.approx({name: 2.0 * by for name, by in once.items()})
    assert min(once.values()) == pytest.approx(math.log(LAWS_DIFFER), abs=0.02)


def test_a_verdict_that_other_waters_changed_says_so_and_another_does_not():
    now = with_the_reason(SURE, UNTOLD).verdicts[0].sentence
    assert now.endswith(
        "This water alone could not tell drag exponent or linear damping from each other; the campaign's others help."
    )
    other = said("explained", ("drag_exponent",))
    assert "This water alone showed drag exponent; the" in with_the_reason(SURE, other).verdicts[0].sentence
    unknown = said("unknown", ("unknown",))
    assert "This water alone showed something unknown; the" in with_the_reason(SURE, unknown).verdicts[0].sentence
    assert with_the_reason(UNTOLD, UNTOLD).verdicts[0].sentence == "Something."


def candidate(name: str, score: float, out: str = "", aside: bool = False) -> SimpleNamespace:
    suspect = next(s for s in SUSPECTS if s.name == name)
    return SimpleNamespace(suspects=(suspect,), names=(name,), score=score, out=out, aside=aside)


def test_evidence_is_of_laws_of_the_body_with_sound_numbers():
    null = SimpleNamespace(suspects=(), score=10.0, out="", aside=False)
    damping, force = candidate("linear_damping", 30.0), candidate("external_forcing", 90.0)
    unsound, small = candidate("relaxation", 50.0, "on its bound"), candidate("cubic_damping", 15.0, "small", True)
    screened = SimpleNamespace(suspect=candidate("cubic_stiffness", 0.0).suspects[0], score=8.0)
    every = (null, damping, force, unsound, small)
    found = SimpleNamespace(null=null, best=damping, candidates=every, screened=(screened,))
    assert evidence_by_name(found) == {"linear_damping": 20.0, "cubic_damping": 5.0, "cubic_stiffness": -2.0}
    found.best = force
    assert evidence_by_name(found) == {}
    found.best = SimpleNamespace(suspects=(*damping.suspects, *small.suspects))
    assert evidence_by_name(found) == {}


def test_a_water_is_judged_with_what_the_others_tell_and_kept_apart_from_without(monkeypatch, tmp_path):
    asked, kept = [], []
    monkeypatch.setattr(judgement, "judge_level", lambda *given: (asked.append(given[-1]), SURE)[1])
    monkeypatch.setattr(judgement.checkpoints, "save_verdicts", lambda found, path: kept.append(path.name))
    monkeypatch.setattr(judgement, "in_water", lambda *_: ())
    plain, judge = _Together((), ()), _Judge((), folder=tmp_path)
    judge(plain)
    judge(replace(plain, told=(("relaxation", 1.0),)))
    assert asked == [{}, {"relaxation": 1.0}]
    assert len(set(kept)) == 2
