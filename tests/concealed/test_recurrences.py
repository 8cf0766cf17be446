"""An echo half a period later, turned, looks much alike: what is said of its delay and gain holds every such end."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.concealed.test_diagnosis import SHORT, member
from undertow.comparison import attempt, recurrences
from undertow.comparison.attempt import from_starts
from undertow.comparison.candidate import Candidate
from undertow.comparison.joint import fit_joint
from undertow.comparison.level import make_level
from undertow.comparison.recurrences import with_errors_by_recurrences
from undertow.comparison.suspects import chosen
from undertow.discrepancy.case import Case
from undertow.discrepancy.verdict import Described
from undertow.equation import registry
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Specimen
from undertow.likelihood.scale import with_scale_error
from undertow.quantities import Estimate

(ECHO,) = chosen(("delayed_echo",))
NAMES = ("x0_m[a]", "delayed_echo.gain@all", "delayed_echo.delay_s")
HALF = 0.5
"""Half a period, s."""


@dataclass(frozen=True)
class Solved:
    """The unknowns of a fit and their covariance."""

    covariance: np.ndarray
    problem: object = field(default_factory=lambda: SimpleNamespace(names=NAMES, trials=()))


@dataclass(frozen=True)
class Fitted:
    """A fit with one echo."""

    values: dict[str, float]
    criterion: float
    addends: tuple[object, ...]
    solution: Solved
    memory: float = 1.0
    misfit: float = 1.0
    shared_water: bool = True


@dataclass(frozen=True)
class Water:
    """A level of one slow spring."""

    scales: object = field(default_factory=lambda: SimpleNamespace(slowest=math.pi / HALF))
    shared_water: bool = True


def ended(delay: float, gain: float, criterion: float) -> Fitted:
    addend = SimpleNamespace(prefix="delayed_echo", additions=(SimpleNamespace(name="gain", unit="N s/m"),
                             SimpleNamespace(name="delay_s", unit="s")))  # fmt: skip
    return Fitted(dict(zip(NAMES, (0.1, gain, delay), strict=True)), criterion, (addend,), Solved(np.diag([1e-6] * 3)))


def with_ends(monkeypatch, ends: dict[float, tuple[float, float]]) -> Fitted:
    """The fit at a delay of 2 s and a gain of 3 with errors that hold these ends: delay to gain and criterion."""

    def fit(level, addends, memory, known, misfit, *, growing):
        start = known["delayed_echo.delay_s"]
        near = min(ends, key=lambda delay: abs(delay - start), default=math.inf)
        if abs(near - start) > 0.2 * HALF:
            raise IdentificationError("no motion comes of it")
        return ended(near, *ends[near])

    monkeypatch.setattr(recurrences, "fit_joint", fit)
    monkeypatch.setattr(recurrences, "one_look", lambda _: 1.0)
    return with_errors_by_recurrences(Water(), ended(2.0, 3.0, 40.0), (ECHO,))


def test_ends_nearly_as_probable_belong_to_the_errors(monkeypatch):
    found = with_ends(monkeypatch, {1.5: (-3.0, 40.0), 2.5: (-3.0, 42.0), 3.0: (3.0, 48.0), 3.5: (-3.0, 60.0)})
    odds = np.array([1.0, 1.0, math.exp(-1.0), math.exp(-4.0)])  # this end, and the three that are near it
    gains, delays = np.array([0.0, -6.0, -6.0, 0.0]), np.array([0.0, -0.5, 0.5, 1.0])
    share = odds / odds.sum()
    variance = np.diag(found.solution.covariance)
    assert variance == pytest.approx([1e-6, 1e-6 + share @ gains**2, 1e-6 + share @ delays**2])
    assert found.solution.covariance[1, 2] == pytest.approx(share @ (gains * delays))
    assert found.values == ended(2.0, 3.0, 40.0).values


@pytest.mark.parametrize(
    "ends",
    [
        {},  # no motion comes of any
        {1.5: (-3.0, 49.3), 2.5: (-3.0, 60.0)},  # odds of over 99 to 1 against them
        {1.6: (-3.0, 49.3), 2.45: (-3.0, 60.0), 2.9: (3.0, 40.0)},  # and what lies behind such an end is not asked
    ],
)
def test_an_end_that_stands_alone_keeps_its_errors(monkeypatch, ends):
    assert np.array_equal(with_ends(monkeypatch, ends).solution.covariance, np.diag([1e-6] * 3))


def test_a_fit_that_comes_back_ends_the_walk(monkeypatch):
    monkeypatch.setattr(recurrences, "fit_joint", lambda *_, **__: ended(2.05, 3.0, 40.0))  # at its bound, say
    monkeypatch.setattr(recurrences, "one_look", lambda _: 1.0)
    fit = with_errors_by_recurrences(Water(), ended(2.0, 3.0, 40.0), (ECHO,))
    assert np.array_equal(fit.solution.covariance, np.diag([1e-6] * 3))


def test_laws_that_do_not_recur_keep_their_errors():
    fit = ended(2.0, 3.0, 40.0)
    (cubic,) = chosen(("cubic_stiffness",))
    assert with_errors_by_recurrences(Water(), fit, (cubic,)) is fit


@pytest.mark.parametrize(("size", "known"), [(12.0, False), (60.0, True)])
def test_the_errors_of_a_weak_echo_hold_its_true_delay_and_gain_and_those_of_a_stronger_one_are_small(size, known):
    level = make_level([member("short", SHORT, 7400, ((registry.find("delayed_echo", delay_s=2.9), -size),))])
    null = Candidate((), fit_joint(level, (), 2.0, {}, 10.0, growing=True), 0.0)
    found = from_starts(level, null, ECHO, 0.0)
    fit = with_errors_by_recurrences(level, found.fit, found.suspects)
    gain, delay = (fit.value(f"delayed_echo.{name}") for name in ("gain@short", "delay_s"))
    of_gain, of_delay = (fit.solution.stderr(f"delayed_echo.{name}") for name in ("gain@short", "delay_s"))
    assert abs(gain + size) < 2.0 * of_gain
    assert abs(delay - 2.9) < 2.0 * of_delay
    if known:
        assert of_gain < 0.1 * size
        assert of_delay < 0.01
    else:  # it ends half a period off, turned
        assert abs(delay - 2.9) > 10.0 * found.fit.solution.stderr("delayed_echo.delay_s")
        assert gain > 0.0


def test_from_starts_too_half_periods_are_walked(monkeypatch):
    level = make_level([member("short", SHORT, 7400, ((registry.find("delayed_echo", delay_s=2.9), -1000.0),))])
    null = Candidate((), fit_joint(level, (), 2.0, {}, 10.0, growing=True), 0.0)
    walked = []
    monkeypatch.setattr(
        attempt, "_half_periods_on", lambda *given: walked.append(given[-1]) or [replace(given[-1], criterion=-1e9)]
    )
    monkeypatch.setattr(attempt, "_refined", lambda _, fit: fit)
    assert from_starts(level, null, ECHO, 0.0).fit.criterion == -1e9
    assert len(walked) == 1


def test_a_lone_trials_spring_is_as_far_from_the_stated_one_as_trials_differ():
    told = Specimen(stiffness_N_per_m=1000.0, stiffness_error_N_per_m=3.0)

    def specimen(trials: int, dry: bool, spread: dict[str, float]) -> Specimen:
        group = SimpleNamespace(motions=(None,) * trials, spread=spread, model=SimpleNamespace(specimen=told))
        return Case({}, "", group, (), Described(0.1), 0.01, 0.05, 0, dry, True).specimen

    lone = specimen(1, dry=False, spread={"k1": 0.004})
    assert lone.stiffness_error_N_per_m == pytest.approx(5.0)
    assert with_scale_error({"mass_kg": Estimate(20.0, 0.0, unit="kg")}, lone)["mass_kg"].systematic == (
        pytest.approx(0.1)
    )
    assert specimen(2, dry=False, spread={"k1": 0.004}) == told  # their own differences are in the fit
    assert specimen(1, dry=False, spread={}) == told  # its dry trials tell its spring
    assert specimen(1, dry=True, spread={"k1": 0.004}) == told
