"""What dry trials need and no motion in water comes of: the level is judged without it, and says so."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from undertow.campaign.run import course, judgement
from undertow.discrepancy.case import Case
from undertow.discrepancy.verdict import Described, Gate, Verdict
from undertow.errors import IdentificationError


@dataclass(frozen=True)
class Part:
    """A law's number; bristles move friction's coefficient elsewhere."""

    moves: bool = False


@dataclass(frozen=True)
class Needed:
    """Something that the dry trials need."""

    prefix: str
    additions: tuple[Part, ...]


BRISTLES, JOINT = Needed("presliding", (Part(moves=True),)), Needed("hysteresis", (Part(),))


@pytest.mark.parametrize(
    ("standing", "bearable", "used", "said"),
    [
        ((JOINT,), ((JOINT,),), (JOINT,), ""),
        ((BRISTLES, JOINT), ((JOINT,),), (JOINT,), ""),
        ((BRISTLES,), ((),), (), ""),
        ((BRISTLES, JOINT), ((),), (), "no motion in this water comes of what the dry trials need (hysteresis)"),
    ],
)
def test_a_level_that_does_not_bear_what_dry_trials_need_is_judged_without(monkeypatch, standing, bearable, used, said):
    def judge_level(cases, suspects, here, *rest):
        if here not in bearable:
            raise IdentificationError("the motion leaves every bound")
        return cases, here

    monkeypatch.setattr(judgement, "judge_level", judge_level)
    case = Case({"spring": "short"}, "spring short", None, (), Described(0.3, math.nan), 0.01, 0.05, 1, False, True)
    level = judgement._Together((case,), ())
    (found,), here = judgement._Judge(())._judged(level, standing)
    assert here == used
    assert found.dry_unknown == said


def test_a_level_that_bears_nothing_says_why(monkeypatch):
    def judge_level(*_):
        raise IdentificationError("the motion leaves every bound")

    monkeypatch.setattr(judgement, "judge_level", judge_level)
    member = SimpleNamespace(label="short", motions=())
    case = Case({"spring": "short"}, "spring short", member, (), Described(0.3, math.nan), 0.01, 0.05, 1, False, True)
    level = judgement._Together((case,), ())
    (said,) = judgement._Judge(())._judged(level, (BRISTLES, JOINT)).verdicts
    assert (said.status, said.because) == ("cannot_tell", "no suspect could be tried: the motion leaves every bound")


@pytest.mark.parametrize(("known", "used"), [(True, (JOINT,)), (False, ())])
def test_a_number_per_kilogram_of_the_dry_body_does_not_stand_in_water(monkeypatch, known, used):
    """A stiffening spring of a body of unknown mass had been a drift of its stiffness beside it in water."""
    monkeypatch.setattr(judgement, "in_water", lambda standing, specimens, dry: standing)
    monkeypatch.setattr(judgement, "judge_level", lambda cases, suspects, here, *rest: here)
    case = Case({"spring": "short"}, "spring short", None, (), Described(0.3, math.nan), 0.01, 0.05, 1, False, True)
    case = SimpleNamespace(member=SimpleNamespace(label="short", model=SimpleNamespace(specimen=None)), also=case)
    task = SimpleNamespace(anchor=SimpleNamespace(known=known))
    level = judgement._Together((case,), (task,))
    assert judgement._Judge((), (JOINT,))(level) == used


FURTHER = Gate("comes_closer", "further away", 7.4, 1.0, False, lacking="unseen", bars=("explained", "unknown"))
LEFT = Gate("left_above_noise", "left", 3.0, 2.5, False)
LIKELY = Gate("outweighed", "probability", 0.1, 0.5, False, bars=("explained",))


@pytest.mark.parametrize(
    ("names", "failed", "puzzles"),
    [
        (("quintic_stiffness", "unknown"), (FURTHER,), False),
        (("quintic_stiffness", "unknown"), (FURTHER, LEFT), True),
        (("quintic_stiffness", "unknown"), (FURTHER, LIKELY), True),
        (("quintic_stiffness", "unknown"), (LEFT,), True),
        (("unknown",), (FURTHER,), True),
    ],
)
def test_a_name_that_one_dry_trial_did_not_prove_does_not_puzzle_the_water(names, failed, puzzles):
    """At odds of 10^816 to 1 a fifth power was "nobody knows" in two waters, for one small release missed by less."""
    said = Verdict({}, (), status="unknown", verdict=names, decision=failed)
    wet = Case({}, "spring short", SimpleNamespace(label="short"), (), Described(0.3), 0.01, 0.05, 1, False, True)
    (case,) = judgement._beside_unknown([wet], [SimpleNamespace(labels=("short",), verdicts=(said,))])
    assert bool(case.dry_unknown) is puzzles


@dataclass(frozen=True)
class Missed:
    """What the equation misses in a trial, and how far its repetitions differ."""

    nrmse: float
    repeatability_nrmse: float
    place: str = ""

    @property
    def missing(self) -> bool:
        return self.nrmse > self.repeatability_nrmse


@dataclass(frozen=True)
class Trial:
    """A trial's findings."""

    mismatch: Missed


@dataclass(frozen=True)
class Group:
    """A group's findings."""

    verdict: SimpleNamespace
    trials: tuple[Trial, ...]


def test_trials_repeat_as_their_rig_does_with_what_the_dry_trials_need(monkeypatch):
    """A law that is missing in the dry trials had passed for scatter: 'no trial alone stands out (error 20 %,
    repeatability 7.6 %)'."""
    trials = tuple(Trial(Missed(0.2, allowed)) for allowed in (0.3, 0.4, 0.5))
    group = Group(SimpleNamespace(repeatability_nrmse=0.4), trials)
    rig = SimpleNamespace(allowed=0.08, model="model", options="options")
    found = judgement._repeating_as(group, rig)
    assert [t.mismatch.repeatability_nrmse for t in found.trials] == pytest.approx([0.06, 0.08, 0.1])
    assert judgement._repeating_as(group, None) is group
    monkeypatch.setattr(judgement, "place_words", lambda missing: f"{len(missing)} places")
    case = Case(
        {}, "water", Member("model", "options", 0.4), (), Described(0.2), 0.01, 0.4, 0, False, True, place="nowhere"
    )
    held = judgement._with_rig(case, rig, found.trials)
    assert (held.missing, held.allowed, held.member.allowed, held.place) == (3, 0.08, 0.08, "3 places")
    assert judgement._with_rig(case, None, trials) is case


@dataclass(frozen=True)
class Member:
    """What a case has of its level."""

    model: str
    options: str
    allowed: float


@dataclass(frozen=True)
class Shown:
    """A trial as a run shows it."""

    motion: SimpleNamespace
    mismatch: float
    augmented: str | None = None


@dataclass(frozen=True)
class Told:
    """A group as a run shows it."""

    verdict: Verdict
    trials: tuple[Shown, ...]


def test_what_is_shown_of_a_trial_is_what_its_group_was_judged_by(monkeypatch):
    trials = tuple(Shown(SimpleNamespace(name=name), 0.4) for name in ("a", "b", "apart"))
    group = Told(Verdict({}, ("a", "b"), status="nothing_missing"), trials)
    verdict = Verdict({}, ("a", "b"), status="explained", verdict=("cubic_stiffness",))
    said = Told(verdict, tuple(Shown(t.motion, 0.08, "run") for t in trials[:2]))
    monkeypatch.setattr(course, "judged", lambda *_: [said])
    monkeypatch.setattr(course, "_joint", lambda task, one: (task, one))
    monkeypatch.setattr(course, "level_count", lambda *_: 1)
    task = SimpleNamespace(apart=("apart",), dry=False)
    run = SimpleNamespace(
        _dry=([], []), _config=None, _jobs=1, _progress=None, _folder=None, _resume=False, _groups=(), _structures={},
        _plan=(),
    )  # fmt: skip
    (found,) = course.Course._judged(run, [task], [group])
    assert [(t.mismatch, t.augmented) for t in found.trials] == [(0.08, "run"), (0.08, "run"), (0.4, None)]
    assert found.verdict.trials == ("a", "b", "apart")
