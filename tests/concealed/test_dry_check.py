"""A law of the structure that is named in water must be there in air: as large, or what is missing is another."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.concealed.test_diagnosis import SHORT, member
from tests.concealed.test_small_effects import found
from undertow.comparison import score_test
from undertow.comparison.candidate import LevelDiagnosis
from undertow.comparison.joint import fit_joint
from undertow.comparison.level import make_level
from undertow.comparison.score_test import Stands, linear_estimate, places
from undertow.comparison.search import diagnose
from undertow.discrepancy.case import Case
from undertow.discrepancy.dry_check import CERTAIN, dry_answer
from undertow.discrepancy.verdict import Described
from undertow.equation import registry

STIFF = ((registry.find("cubic_stiffness"), 6.0e7),)
DAMPED = ((registry.find("linear_damping"), 1500.0),)


@cache
def named(name: str, *hidden: object) -> LevelDiagnosis:
    """What is named in water for trials with something hidden."""
    level = make_level([member("short", SHORT, 2001, hidden)])
    said = diagnose(level, [found(name, "one for all springs" if name == "linear_damping" else "")])
    assert said.best.names == (name,)
    return said


def in_air(*hidden: object) -> Case:
    """The same spring's other trials."""
    own = member("short", SHORT, 4001, hidden)
    return Case({}, "dry", own, (), Described(0.01), 0.01, 0.05, 0, True, True)


def test_a_spring_that_hardens_in_water_alone_is_contradicted_by_air():
    said = dry_answer(named("cubic_stiffness", *STIFF), "", [in_air()])
    assert said.away > CERTAIN
    assert "the dry trials of the same spring show cubic stiffness of" in said.because
    assert "N/m^3, where water asks for" in said.because


def test_a_spring_that_hardens_in_air_too_is_borne_out():
    assert dry_answer(named("cubic_stiffness", *STIFF), "", [in_air(*STIFF)]).because == ""


def test_what_belongs_to_the_water_is_not_looked_for_in_air():
    assert dry_answer(named("linear_damping", *DAMPED), "", [in_air()]).because == ""



def test_what_is_too_small_to_be_named_is_held_against_air_too():
    said = named("cubic_stiffness", *STIFF)
    small = replace(said, best=said.null)
    assert dry_answer(small, "cubic_stiffness", [in_air()]).because
    assert dry_answer(small, "hidden_resonator", [in_air()]).because == ""


def test_one_linear_step_gives_the_size_and_its_error():
    level = make_level([member("short", SHORT, 2001, ((registry.find("cubic_stiffness"), 2.0e6),))])
    fit = fit_joint(level, (), 1.0, {}, 10.0, growing=True)
    (law,) = found("cubic_stiffness").grid(level.scales)
    size, error = linear_estimate(level, Stands.of(fit), law)
    assert error > 0.0
    assert size == pytest.approx(2.0e6, abs=4.0 * error)


@pytest.mark.parametrize(("name", "largest"), [("cubic_stiffness", 1e188), ("presliding", 1e188)])
def test_a_place_from_which_a_body_falls_says_nothing(monkeypatch, name, largest):
    """Beside an unstable rest position what moves the start grows without end: its square was no number, and the whole
    level had no verdict."""
    level = make_level([member("short", SHORT, 2001)])
    stands, law = Stands.of(fit_joint(level, (), 1.0, {}, 10.0, growing=True)), found(name)
    assert any(place.columns for place in places(level, stands, law))
    plain, seen = score_test.output_error.residuals, []

    def falls(trial, values):
        r, jac, used = plain(trial, values)
        seen.append(trial.name)
        return (r * largest if len(seen) % 2 == 0 else r), np.full_like(jac, largest), used

    monkeypatch.setattr(score_test.output_error, "residuals", falls)
    assert [(place.columns, place.gain) for place in places(level, stands, law)] == [((), 0.0)] * len(
        law.grid(level.scales)
    )
