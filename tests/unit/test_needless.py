"""Which of the shorter sets stands: its score, its free run and its numbers are asked, nothing else."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from undertow.comparison import needless
from undertow.comparison.candidate import Candidate, rivals_of
from undertow.comparison.level import Addend, Level
from undertow.comparison.needless import closed_up, leanest, shorter_sets
from undertow.comparison.suspect import Addition, Scales
from undertow.comparison.suspects import SUSPECTS
from undertow.errors import IdentificationError


def shorter(score: float, error: float, out: str = "") -> tuple[SimpleNamespace, float]:
    """A set of this score and error, with a reason against it."""
    return SimpleNamespace(score=score, out=out), error


def test_the_most_probable_set_that_stands_is_the_leanest():
    low, high = shorter(11.0, 0.5), shorter(12.0, 0.9)
    assert leanest([low, high], 0.3, 10.0) is high


@pytest.mark.parametrize(
    "bad", [shorter(20.0, 0.5, "on a bound"), shorter(10.0, 0.5), shorter(20.0, 1.6)],
    ids=["numbers mean nothing", "no more probable", "free run too far"],
)  # fmt: skip
def test_a_set_that_does_not_stand_is_never_the_leanest(bad):
    good = shorter(10.5, 1.5)
    assert leanest([bad, good], 1.5, 10.0) is good
    assert leanest([bad], 1.5, 10.0) is None


def test_a_free_run_as_close_as_repetitions_is_close_enough():
    assert leanest([shorter(11.0, 1.0)], 0.2, 10.0) is not None


def candidate(*slots: str, out: str = "") -> SimpleNamespace:
    """Suspects named by number, whose additions stand at these slots, with a reason against the set."""
    addends = tuple(SimpleNamespace(additions=(SimpleNamespace(slot=slot),)) for slot in slots)
    return SimpleNamespace(suspects=tuple(range(len(slots))), fit=SimpleNamespace(addends=addends), out=out)


@pytest.fixture
def asked(monkeypatch) -> list[tuple[int, tuple[int, ...]]]:
    """Places that are left out, and what is left, instead of fits."""
    seen = []
    left = SimpleNamespace(fit=None, out="", score=0.0)
    monkeypatch.setattr(needless, "without", lambda _l, _n, _c, place, prior: seen.append((place, prior)) or left)
    monkeypatch.setattr(needless, "free_run_error", lambda _level, _fit: 0.7)
    return seen


LEVEL, NULL = SimpleNamespace(standing=()), SimpleNamespace(misfit=100.0)


def test_every_earlier_effect_is_left_out_in_turn_and_the_last_one_never(asked):
    found = shorter_sets(LEVEL, NULL, candidate("c3", "q", "hm1"), tuple)
    assert asked == [(0, (1, 2)), (1, (0, 2))]
    assert [error for _, error in found] == [0.7, 0.7]


def test_the_last_effect_of_an_excluded_set_is_left_out_too(asked):
    shorter_sets(LEVEL, NULL, candidate("c3", "q", out="q is 0.3 standard errors from zero"), tuple)
    assert asked == [(0, (1,)), (1, (0,))]


def test_what_is_more_probable_and_still_excluded_is_shortened_again(monkeypatch):
    """Of a resonator, a dashpot and a force the force alone was the answer (a seiche at .97 of the body's rate), and
    without the one the other was still nothing: `unknown` stood beside odds of e^220."""
    scores = {(1, 2): 30.0, (0, 2): 5.0, (0, 1): 1.0, (2,): 40.0, (1,): 2.0, (0,): 3.0}

    def without(_level, _null, whole, place, prior):
        kept = whole.suspects[:place] + whole.suspects[place + 1 :]
        return SimpleNamespace(suspects=kept, score=scores[kept], out="" if kept == (2,) else "no", fit=None)

    monkeypatch.setattr(needless, "without", without)
    monkeypatch.setattr(needless, "free_run_error", lambda _level, _fit: 0.7)
    three = SimpleNamespace(suspects=(0, 1, 2), score=20.0, out="on a bound", fit=None)
    found = [one.suspects for one, _ in shorter_sets(LEVEL, NULL, three, tuple)]
    assert found == [(1, 2), (2,), (1,), (0, 2), (0, 1)]  # what is less probable is not followed
    assert leanest(shorter_sets(LEVEL, NULL, three, tuple), 1.0, 20.0)[0].suspects == (2,)


def test_what_swings_may_be_needless_beside_something_else_that_swings(asked):
    shorter_sets(LEVEL, NULL, candidate("hm1", "q", "hm2"), tuple)
    assert [place for place, _ in asked] == [0, 1]


def addend(*slots: str) -> Addend:
    return Addend("law", tuple(Addition("number", "kg", slot, 1.0, 1.0) for slot in slots))


def test_resonators_close_up_and_keep_their_order_and_nothing_else_is_renumbered():
    found = closed_up((addend("hm2", "hw2", "hz2"), addend("c3"), addend("hm3", "hw3")))
    assert [[a.slot for a in one.additions] for one in found] == [["hm1", "hw1", "hz1"], ["c3"], ["hm2", "hw2"]]


def test_effects_that_stood_before_the_search_are_not_counted(asked):
    level = SimpleNamespace(standing=(1,))
    both = candidate("hm1", "hm2")
    both.fit.addends = (candidate("hm3").fit.addends[0], *candidate("q", "hm2").fit.addends)
    shorter_sets(level, NULL, both, tuple)
    assert [place for place, _ in asked] == [0]


def test_a_set_without_a_motion_is_no_shorter_set(asked, monkeypatch):
    monkeypatch.setattr(needless, "without", lambda *_: None)
    assert shorter_sets(LEVEL, NULL, candidate("c3", "q"), tuple) == []


def test_what_is_left_out_leaves_no_empty_place_to_the_integrator(monkeypatch):
    fitted: list[list[str]] = []

    def refused(_level: object, addends: tuple[Addend, ...], *_: object, **__: object) -> None:
        fitted.append([a.slot for one in addends for a in one.additions])
        raise IdentificationError("no motion")

    monkeypatch.setattr(needless, "fit_joint", refused)
    own = (addend("hm1", "hw1"), addend("hm2", "hw2"), addend("c3"))
    fit = SimpleNamespace(addends=own, shared_water=True, memory=1.0, values={}, misfit=1.0)
    candidate = SimpleNamespace(suspects=("one", "two", "three"), fit=fit)
    level = Level((), Scales(1.0, 1.0, 1.0, 1.0, 1.0, 1.0))
    assert needless.without(level, NULL, candidate, 0, 0.0) is None
    assert fitted == [["hm1", "hw1", "c3"]]


@pytest.mark.parametrize(("others", "before"), [(1, 100.0), (2, 1.0)])
def test_one_effect_alone_is_judged_beside_the_prescribed_equation(monkeypatch, others, before):
    asked: list[float] = []
    monkeypatch.setattr(needless, "doubt", lambda _level, _fit, stood, *_: asked.append(stood.misfit) or "")
    fit = SimpleNamespace(addends=(addend("c3"),) * (others + 1), shared_water=True, memory=1.0, values={}, misfit=1.0)
    monkeypatch.setattr(needless, "fit_joint", lambda *_, **__: fit)
    level = Level((), Scales(1.0, 1.0, 1.0, 1.0, 1.0, 1.0))
    needless.without(level, NULL, SimpleNamespace(suspects=("a", "b", "c")[: others + 1], fit=fit, out=""), 0, 0.0)
    assert asked == [before]


def test_a_set_is_no_rival_of_itself_beside_a_resonator_that_stands_and_hardly_rings():
    shift, gain = (next(s for s in SUSPECTS if s.name == name) for name in ("time_shift", "gain_error"))
    fit = SimpleNamespace(criterion=0.0, values={"hidden_resonator.damping_ratio@all": 0.67})
    best, near = Candidate((shift,), fit, 0.0), Candidate((gain,), fit, -1.0)
    assert rivals_of(best, [best, near]) == (("gain_error",),)
    two = Candidate((shift, gain), fit, 0.0)
    assert rivals_of(two, [two, Candidate((gain, shift), fit, -1.0)]) == ()


def test_a_set_of_another_size_is_a_rival_where_it_has_no_name_in_common():
    echo, damping, force = (next(s for s in SUSPECTS if s.name == n) for n in (
        "delayed_echo", "linear_damping", "external_forcing"
    ))  # fmt: skip
    fit = SimpleNamespace(criterion=0.0, values={})
    best, two = Candidate((force,), fit, 0.0), Candidate((echo, damping), fit, -1.0)
    assert rivals_of(best, [best, two]) == (("delayed_echo", "linear_damping"),)
    assert rivals_of(best, [best, Candidate((force, damping), fit, -1.0)]) == (), "more of the same contradicts nothing"
    assert rivals_of(best, [best, Candidate((echo, damping), fit, -5.0)]) == ()
    assert rivals_of(two, [Candidate((force,), fit, -1.5), two]) == (("external_forcing",),)
