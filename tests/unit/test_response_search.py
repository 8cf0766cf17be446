"""Harmonic sets that lack nothing are given nothing; what is left is told from noise."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import undertow
from undertow.comparison.driven_folds import Tried
from undertow.comparison.response_search import _p_value, _PointSearch, _unsure, discover_response, every_fifth
from undertow.conditioning.harmonic import HarmonicSet
from undertow.equation.driven_laws import find_driven
from undertow.methods.harmonic_set import fit_harmonic_set

FREQUENCIES = np.linspace(0.55, 1.2, 30)
NOISE = 1e-3
LAWS = {"stiffness": 50.0, "viscous_damping": 0.6, "cubic_stiffness": 100.0}


@pytest.fixture(scope="module")
def clean():
    """Steady motions of a body of 2 kg whose resonance leans and does not fold."""
    return undertow.frequency_response(LAWS, FREQUENCIES, force=1.0, mass_kg=2.0).states


def noisy(states, seed: int, sigma: float = 0.0) -> HarmonicSet:
    """The motions with white noise on both parts."""
    rng = np.random.default_rng(seed)
    cosine, sine = np.array([(s.cosine, s.sine) for s in states]).T + NOISE * rng.standard_normal((2, len(states)))
    rate, force = 2.0 * np.pi * FREQUENCIES, np.ones(FREQUENCIES.size)
    stated = np.full(rate.size, sigma) if sigma else np.zeros(0)
    return HarmonicSet(rate, force, np.hypot(cosine, sine), np.arctan2(-sine, cosine), stated)


def test_sets_that_lack_nothing_are_given_no_law(clean):
    terms = [find_driven(name) for name in LAWS]
    found = [discover_response(noisy(clean, seed), [np.arange(30)], terms, {}) for seed in range(20)]
    assert [one.added for one in found] == [()] * 20
    assert all(one.tried for one in found)
    assert sum(not one.adequate for one in found) <= 1  # 1 in 100 is said to leave more than noise


def test_a_missing_law_is_added_and_leaves_noise(clean):
    terms = [find_driven(name) for name in ("stiffness", "viscous_damping")]
    found = discover_response(noisy(clean, 1), [np.arange(30)], terms, {}, ("cubic_stiffness", "quadratic_drag"))
    assert found.added == ("cubic_stiffness",)
    assert found.adequate
    assert found.validation[1] < 0.2 * found.validation[0]
    assert found.unseen.sum() == 6


def test_errors_that_are_stated_too_small_leave_more_than_noise(clean):
    terms = [find_driven(name) for name in LAWS]
    right, small = (
        discover_response(noisy(clean, 2, sigma), [np.arange(30)], terms, {}, ()) for sigma in (NOISE, 0.5 * NOISE)
    )
    assert right.adequate
    assert not small.adequate


def test_held_out_points_are_every_fifth_and_never_an_end():
    mask = every_fifth([np.arange(8), np.arange(20, 7, -1)], 21)
    assert mask.nonzero()[0].tolist() == [2, 13, 18]


def test_laws_that_these_points_cannot_tell_apart_are_named_as_alternatives():
    """A small drag over a narrow band: as well a cubic damping."""
    laws = {"stiffness": 50.0, "viscous_damping": 0.3, "quadratic_drag": 1.0}
    frequencies = np.linspace(0.74, 0.85, 30)
    states = undertow.frequency_response(laws, frequencies, force=1.0, mass_kg=2.0).states
    rng = np.random.default_rng(3)
    cosine, sine = np.array([(s.cosine, s.sine) for s in states]).T + 5e-3 * rng.standard_normal((2, 30))
    measured = HarmonicSet(2.0 * np.pi * frequencies, np.ones(30), np.hypot(cosine, sine), np.arctan2(-sine, cosine))
    given = [find_driven(name) for name in ("stiffness", "viscous_damping")]
    found = discover_response(measured, [np.arange(30)], given, {"mass_kg": 2.0}, ("quadratic_drag", "cubic_damping"))
    assert {*found.added, *(name for _, name in found.alternatives)} == {"quadratic_drag", "cubic_damping"}
    assert len(found.added) == 1


def test_what_stood_in_for_another_law_is_taken_out(clean, monkeypatch):
    """Rounds that add a drag, which is not there, before the hardening, which is."""
    given = [find_driven(name) for name in ("stiffness", "viscous_damping")]
    left = ["quadratic_drag", "cubic_stiffness"]

    def round_of(search, current):
        name = left.pop(0) if left else ""
        more = [Tried(name, 0.0, 1.0, 0.5)] if name else []
        return (search.fitted((*current.fit.terms, find_driven(name))) if name else None), (), more

    monkeypatch.setattr(_PointSearch, "round", round_of)
    found = discover_response(noisy(clean, 4), [np.arange(30)], given, {})
    assert found.added == ("cubic_stiffness",)
    assert [term.name for term in found.best.terms] == ["stiffness", "viscous_damping", "cubic_stiffness"]


def test_a_coefficient_that_may_be_zero_is_no_law(clean):
    terms = [find_driven(name) for name in (*LAWS, "quadratic_drag")]
    fitted = fit_harmonic_set(noisy(clean, 5), terms, {}, {})
    assert "within 2 standard errors of 0" in _unsure("quadratic_drag", fitted)
    assert _unsure("cubic_stiffness", fitted) == ""


@pytest.mark.parametrize("wrong", [slice(0, 0), slice(0, 18), slice(18, 30)], ids=["neither", "first", "second"])
def test_neighbours_that_err_alike_in_either_of_two_sweeps_are_no_noise(wrong):
    left = np.random.default_rng(1).standard_normal((2, 30))
    left[:, wrong] = 1.0
    measured = SimpleNamespace(sigma=np.zeros(0), rate=np.arange(30.0))
    p = _p_value(SimpleNamespace(missed=left), measured, [np.arange(18), np.arange(29, 17, -1)], seed=0)
    assert (p < 0.02) == (wrong.stop > 0)
