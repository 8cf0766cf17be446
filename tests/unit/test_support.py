"""What outweighed sets hold in common with the answer stands; an answer that nothing supports does not."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from undertow.comparison.candidate import LevelDiagnosis
from undertow.comparison.support import MORE_LIKELY, support, supported


def fitted(names: str, score: float, out: str = "", aside: bool = False) -> SimpleNamespace:
    """A set of laws by name, with its score and a reason against its numbers."""
    each = tuple(names.split("+")) if names else ()
    suspects = tuple(SimpleNamespace(name=n, like=(), plain=False, swings=False, overdamped_as="") for n in each)
    return SimpleNamespace(
        suspects=suspects, names=each, amounts_to=each, score=score, out=out, aside=aside,
        fit=SimpleNamespace(values={}),
    )  # fmt: skip


def same_suspects(*sets: SimpleNamespace) -> None:
    """The same suspects by name in all sets."""
    by = {s.name: s for one in sets for s in one.suspects}
    for one in sets:
        one.suspects = tuple(by[s.name] for s in one.suspects)


def diagnosis(best: SimpleNamespace, *others: SimpleNamespace) -> LevelDiagnosis:
    same_suspects(best, *others)
    nothing = fitted("", 0.0)
    return LevelDiagnosis(nothing, best, (nothing, best, *others), 0.9, ())


def test_the_first_effect_stands_where_excluded_sets_that_hold_it_outweigh_the_second():
    both, first = fitted("damping+kernel", 100.0), fitted("damping", 95.0)
    excluded = fitted("damping+force", 106.0, "one trial knows no clock")
    said = diagnosis(both, first, excluded)
    assert support(said).likely < MORE_LIKELY
    assert support(said).other is excluded
    found = supported(said)
    assert found.best is first
    assert support(found).likely == pytest.approx(1.0)


def test_an_answer_that_is_more_likely_than_not_is_kept():
    both, first = fitted("damping+kernel", 106.0), fitted("damping", 95.0)
    said = diagnosis(both, first, fitted("damping+force", 100.0, "out"))
    assert supported(said) is said


def test_bristles_do_not_speak_against_the_loops_that_they_have():
    both, first = fitted("echo+hysteresis", 100.0), fitted("echo", 50.0)
    excluded = fitted("echo+presliding", 102.2, "presliding is 1.6 standard errors from zero")
    said = diagnosis(both, first, excluded)
    assert support(said).likely == pytest.approx(1.0)
    assert supported(said) is said
    turned = diagnosis(excluded, first, both)
    assert support(turned).likely == pytest.approx(1.0)


def test_where_the_first_effect_is_outweighed_too_the_answer_is_as_it_was():
    both, first = fitted("damping+kernel", 100.0), fitted("damping", 95.0)
    said = diagnosis(both, first, fitted("echo+force", 120.0, "out"))
    assert supported(said) is said


def test_a_first_effect_whose_numbers_mean_nothing_is_no_rest():
    both, first = fitted("damping+kernel", 100.0), fitted("damping", 95.0, "on its bound")
    said = diagnosis(both, first, fitted("damping+force", 106.0, "out"))
    assert supported(said) is said


def test_the_rest_has_rivals_of_its_own():
    both, first, rival = fitted("damping+kernel", 100.0), fitted("damping", 95.0), fitted("exponent", 93.0)
    found = supported(diagnosis(both, first, rival, fitted("damping+force", 106.0, "out")))
    assert found.rivals == (("exponent",),)


def test_what_is_said_with_more_beside_it_is_no_more_probable_alone():
    one, more = fitted("damping", 95.0), fitted("damping+kernel", 99.0, "on its bound")
    found = support(diagnosis(one, more))
    assert found.likely == pytest.approx(1.0)
    assert found.exactly == pytest.approx(0.018, rel=0.01)
    assert found.rather is more
    twice = support(diagnosis(fitted("mode", 95.0), fitted("mode+mode", 99.0, "out")))
    assert twice.exactly == pytest.approx(0.018, rel=0.01)


def test_rivals_that_are_said_are_part_of_what_is_probable():
    one, other = fitted("damping", 95.0), fitted("exponent", 97.0)
    said = diagnosis(one, other)
    assert support(said).exactly < 0.2
    assert support(LevelDiagnosis(said.null, one, said.candidates, 0.9, (("exponent",),))).exactly == pytest.approx(1.0)


def test_what_was_set_aside_does_not_outweigh():
    one = fitted("damping", 95.0)
    assert support(diagnosis(one, fitted("echo", 120.0, "hardly shows", aside=True))).likely == pytest.approx(1.0)
