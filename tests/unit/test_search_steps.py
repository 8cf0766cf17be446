"""What a search tries again, passes over and counts as a gain, and how many replicas of a level it draws."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from undertow.comparison import null_test, search, trying
from undertow.comparison.joining import may_join
from undertow.comparison.score_test import Stands, _gain_whole
from undertow.comparison.suspect import Scales
from undertow.comparison.suspects import SUSPECTS, Suspect

SCALES = Scales(mass=4000.0, rate=5.0, speed=0.5, size=0.1, slowest=4.0, fastest=6.0)


def suspect(name: str) -> Suspect:
    """The first suspect of this name."""
    return next(s for s in SUSPECTS if s.name == name)


def candidate(name: str, score: float, misfit: float, miss: float = 1.0) -> SimpleNamespace:
    """A suspect that was fitted: its score, what it leaves, how far its free run is from the recording."""
    fit = SimpleNamespace(misfit=misfit, miss=miss)
    return SimpleNamespace(suspects=(suspect(name),), names=(name,), score=score, fit=fit, out="", aside=False)


def test_where_all_leave_far_more_than_noise_plain_laws_of_the_body_start_anew_the_most_probable_first(monkeypatch):
    """A memory, friction that becomes bristles and what a sensor does have no start that owes nothing to the rest."""
    names = ("cubic_damping", "delayed_echo", "cubic_stiffness", "presliding", "sensor_drift", "linear_damping")
    scores = (10.0, 70.0, 30.0, 60.0, 50.0, 20.0)
    tried = [candidate(name, score, misfit=40.0) for name, score in zip(names, scores, strict=True)]
    monkeypatch.setattr(trying.attempt, "anew", lambda level, null, one: (begun.append(one.names[0]), one)[1])
    begun: list[str] = []
    state = SimpleNamespace(level=None, null=candidate("cubic_damping", 0.0, misfit=100.0), left={True: 1e9})
    assert trying.Trying._anew(state, tried) == tried
    assert begun == ["cubic_stiffness", "linear_damping", "cubic_damping"]


def test_behind_a_law_passed_over_for_what_it_leaves_the_next_may_still_be_the_answer(monkeypatch):
    """A memory beyond doubt that brings trials no closer, a loop that leaves five times noise, a spring that does."""
    monkeypatch.setattr(search, "free_run_error", lambda _, fit: fit.miss)
    monkeypatch.setattr(search, "beyond_doubt", lambda *_: True)
    monkeypatch.setattr(search, "replace", lambda c, **new: SimpleNamespace(**(vars(c) | new)))
    probable = [
        candidate("relaxation", 660.0, misfit=1.1, miss=4.5), candidate("hysteresis", 350.0, misfit=30.0),
        candidate("cubic_stiffness", 340.0, misfit=1.1),
    ]  # fmt: skip
    null = SimpleNamespace(suspects=(), score=0.0, fit=SimpleNamespace(misfit=7000.0, miss=3.4))
    state = SimpleNamespace(level=None, null=null, best=null, error=3.4, small=[], found=list(probable))
    for name in ("_too_small", "_set_aside"):
        setattr(state, name, partial(getattr(search._Search, name), state))
    assert search._Search._worthwhile(state, probable, 1.0) == (probable[2], 1.0)
    aside = {c.names[0]: c.out for c in state.found if c.aside}
    assert aside["hysteresis"] == "relaxation leaves no more than noise"


@pytest.mark.parametrize("size", [2.0, 0.5, -0.2], ids=["larger than it starts", "half as large", "of the other sign"])
def test_a_law_taken_whole_gains_what_it_takes_off_half_the_squares_and_never_less_than_nothing(size):
    rng = np.random.default_rng(0)
    law = rng.standard_normal(50)
    left = -size * law
    step = np.array([-(law @ left) / (law @ law)])
    stands = Stands(fit=SimpleNamespace(), inverse=np.zeros((1, 1)), gradient=np.zeros(1))
    gained = 0.5 * float(left @ left - (left + law) @ (left + law))
    assert _gain_whole(stands, np.zeros((1, 1)), np.array([[law @ law]]), step) == pytest.approx(max(gained, 0.0))


@pytest.mark.parametrize(
    ("samples", "draws"),
    [(1_000, [1000]), (40_000, [500, 500]), (60_000, [333, 333, 333, 1]), (30_000_000, [1] * 1000)],
)
def test_residuals_of_a_large_level_are_drawn_as_many_at_a_time_as_there_is_room_for(monkeypatch, samples, draws):
    drawn = []
    monkeypatch.setattr(null_test, "replicas", lambda level, solution, left, count, rng: drawn.append(count))
    monkeypatch.setattr(null_test, "within_reason", lambda *_: True)
    monkeypatch.setattr(null_test, "believed_widths", lambda *_: None)
    monkeypatch.setattr(null_test, "surely_wrong", lambda *_: 0.0)
    monkeypatch.setattr(null_test, "_slightly_wrong", lambda stack, square, count, rng: np.zeros((1, count)))
    stands = SimpleNamespace(
        fit=SimpleNamespace(solution=SimpleNamespace(residuals=())), pulled=lambda _: None, gradient=np.zeros(1)
    )
    stack = SimpleNamespace(stands=stands, scores=lambda *_: np.zeros((1, drawn[-1])), places=(), slices=())
    halves = [SimpleNamespace(size=samples // 2)] * 2
    null_test._scored(None, stack, None, halves, np.random.default_rng(0), 1000)
    assert drawn == draws
    drawn.clear()
    monkeypatch.setattr(null_test, "within_reason", lambda *_: False)
    assert null_test._scored(None, stack, None, halves, np.random.default_rng(0), 1000) == []
    assert drawn == draws[:1]


def test_a_number_is_searched_in_steps_of_about_the_size_at_which_it_starts():
    """A step far beyond the start leaves what is there, one far below it takes long: a tenth to thirty fold."""
    for one in SUSPECTS:
        for start in one.starts(SCALES):
            for a in one.additions(SCALES, start):
                assert a.start == 0.0 or 0.1 < abs(a.start) / a.scale < 30.0, (one.label, a.name)


@pytest.mark.parametrize(
    ("first", "joins"),
    [((), True), (("external_forcing",), True), (("cubic_stiffness",), True), (("linear_damping",), False),
     (("hidden_resonator",), False), (("external_forcing", "drag_exponent"), False)],
)  # fmt: skip
def test_a_late_start_joins_what_lasts_but_nothing_that_the_water_does(first, joins):
    """Of a flume with sloshing cells "linear damping and a bad release" became an answer: it took what that leaves."""
    (late,) = [s for s in SUSPECTS if s.late]
    best = SimpleNamespace(suspects=tuple(map(suspect, first)), names=first, fit=SimpleNamespace(addends=()))
    assert may_join(best, late) is joins
    assert may_join(best, suspect("imperfect_release"))  # a speed of each trial's own is another thing
