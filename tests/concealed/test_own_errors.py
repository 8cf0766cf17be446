"""Errors of a law that is there: those of its own residual, not of what the equation leaves without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.concealed.test_diagnosis import SHORT, member
from tests.concealed.test_small_effects import found, stands
from undertow.comparison import joint
from undertow.comparison.joint import JointFit, fit_joint, with_own_errors
from undertow.comparison.level import Addend, Level, make_level
from undertow.equation import registry
from undertow.errors import IdentificationError

RATE, ASKED = 9.6, "hidden_resonator.natural_frequency_rad_per_s"
"""A sloshing mass' frequency: no gain of a sensor moves it."""
SEEDS = range(7400, 7424, 3)


def sloshing(seed: int) -> tuple[Level, JointFit]:
    """Water that swings, fitted with its own law at the memory of what the equation alone leaves."""
    water = registry.find("hidden_resonator", natural_frequency_rad_per_s=RATE, damping_ratio=0.02)
    level = make_level([member("short", SHORT, seed, ((water, 150.0),))])
    before = stands(level)
    addend = Addend("hidden_resonator", found("hidden_resonator").additions(level.scales, 9.3))
    return level, fit_joint(level, (addend,), before.memory, before.values, before.misfit, growing=False)


def test_errors_of_a_law_that_is_there_are_those_that_are_made():
    misses, shrunk = [], []
    for seed in SEEDS:
        level, fit = sloshing(seed)
        own = with_own_errors(level, fit)
        misses.append((own.value(ASKED) - RATE) / own.solution.stderr(ASKED))
        shrunk.append(own.solution.stderr(ASKED) / fit.solution.stderr(ASKED))
    assert np.median(shrunk) < 0.2
    # the root of a mean of eight squares lies between 0.41 and 1.66 for 99 % of sound errors
    assert 0.41 < np.sqrt(np.mean(np.square(misses))) < 1.66, misses


def test_evidence_and_memory_stay_as_they_were_compared():
    level, fit = sloshing(7400)
    own = with_own_errors(level, fit)
    assert (own.criterion, own.memory, own.addends) == (fit.criterion, fit.memory, fit.addends)
    assert own.misfit <= fit.misfit


def test_a_residual_that_is_correlated_for_longer_keeps_its_errors():
    level, fit = sloshing(7400)
    lower = replace(fit, memory=1.0)
    assert with_own_errors(level, lower) is lower


def test_a_fit_that_gives_no_motion_keeps_its_errors(monkeypatch):
    level, fit = sloshing(7400)

    def none(*_: object, **__: object) -> JointFit:
        raise IdentificationError("no motion")

    monkeypatch.setattr(joint, "fit_joint", none)
    assert with_own_errors(level, fit) is fit
