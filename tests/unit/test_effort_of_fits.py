"""Where a suspect's fits spend their steps: no end is followed twice, only a model's last fit goes to its end."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from undertow.comparison import joint
from undertow.comparison.attempt import SAME_END, _apart
from undertow.likelihood.output_error import CLOSE, COARSE, FULL, QUICK


def quick(criterion: float, shared_water: bool = True) -> SimpleNamespace:
    return SimpleNamespace(criterion=criterion, shared_water=shared_water)


def test_of_two_starts_that_ended_at_one_place_one_is_followed():
    first, again, other = quick(100.0), quick(100.0 + 0.5 * SAME_END), quick(100.0 + 2.0 * SAME_END)
    assert _apart([first, again, other]) == [first, other]


def test_one_water_and_two_are_different_ends_at_the_same_criterion():
    both = [quick(100.0), quick(100.0, shared_water=False)]
    assert _apart(both) == both


@pytest.fixture
def efforts(monkeypatch) -> list[object]:
    """Efforts of a joint fit's fits, whose noise is what ``noise`` says one after the other."""
    seen: list[object] = []
    noise = iter((4.0, 2.0, 1.9, 1.9, 1.9))
    trial = SimpleNamespace(name="r1", channels=(), t=SimpleNamespace(size=10), period_s=1.0)
    problem = SimpleNamespace(unknowns=(), trials=())
    solution = SimpleNamespace(values=(), n_data=10, problem=SimpleNamespace(trials=(trial,)))
    monkeypatch.setattr(joint, "build", lambda _level, _addends: problem)
    monkeypatch.setattr(joint, "tempered", lambda *_: problem)
    monkeypatch.setattr(joint, "trial_misfits", lambda *_: {"r1": next(noise)})
    monkeypatch.setattr(joint, "criterion", lambda *_: 0.0)
    monkeypatch.setattr(joint, "_width", lambda *_: 0.0)
    monkeypatch.setattr(joint, "_skipped", lambda *_: 0.0)

    def fitted(_problem: object, _values: object, growing: bool, effort: object) -> SimpleNamespace:
        seen.append((growing, effort))
        return solution

    monkeypatch.setattr(joint.output_error, "fit", fitted)
    problem.trials = (trial,)
    return seen


LEVEL = SimpleNamespace(shared_water=True)


def test_the_noise_is_found_by_coarse_fits_and_the_last_one_goes_to_the_end(efforts):
    fit = joint.fit_joint(LEVEL, (), 1.0, {}, 10.0, growing=True)
    assert efforts == [(True, COARSE), (False, COARSE), (False, COARSE), (False, CLOSE)]
    assert fit.misfits == {"r1": 1.9}


def test_where_the_noise_is_known_one_coarse_fit_goes_before_the_last(efforts):
    joint.fit_joint(LEVEL, (), 1.0, {}, 4.2, growing=False)
    assert efforts == [(False, COARSE), (False, CLOSE)]


def test_a_quick_fit_is_one_fit(efforts):
    joint.fit_joint(LEVEL, (), 1.0, {}, 10.0, growing=True, quick=True)
    assert efforts == [(True, QUICK)]


def test_only_a_quick_fit_is_not_tried_again_from_its_start():
    assert [effort.thorough for effort in (FULL, CLOSE, COARSE, QUICK)] == [True, True, True, False]
