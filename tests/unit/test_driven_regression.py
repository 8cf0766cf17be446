"""Numbers of a driven equation by regression with the measured input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.driven.bodies import GIVEN, body, record
from tests.unit.test_driven_trials import recorded
from undertow.comparison.driven_search import STATIC
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_laws import find_driven
from undertow.errors import IdentificationError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import fit_driven
from undertow.methods.driven_regression import by_regression

GIVEN_LAWS = DrivenLaws(tuple(find_driven(name) for name in GIVEN["random"]))


def test_errors_of_a_regression_are_as_large_as_it_says():
    away = []
    for seed in range(12000, 12006):
        one = body("random", seed)
        trial = record(one)
        found = by_regression(trial, fit_driven([trial], GIVEN_LAWS))
        away += [(found[name].value - true) / found[name].stderr for name, true in one.numbers.items()]
    # 24 draws of a standard normal have an rms within 0.4 of 1; corners of the force between samples made it 4
    assert np.sqrt(np.mean(np.square(away))) < 1.4


def test_a_regression_that_cannot_be_made_says_why():
    trial = recorded()
    laws = DrivenLaws(tuple(find_driven(name) for name in ("stiffness", "viscous_damping")))
    fitted = fit_driven([trial], laws)
    still = DrivenTrial("let go", trial.t, 0.0 * trial.u, trial.outputs, free=True)
    with pytest.raises(IdentificationError, match="trial let go: nothing drives it"):
        by_regression(still, fitted)
    shaken = DrivenTrial("run", trial.t, trial.u, {"acceleration": trial.outputs["displacement"]})
    with pytest.raises(IdentificationError, match="acceleration alone is recorded"):
        by_regression(shaken, fitted)
    loop = replace(laws, terms=(*laws.terms, find_driven("bouc_wen")))
    with pytest.raises(IdentificationError, match="bouc_wen has a state of its own"):
        by_regression(trial, replace(fitted, laws=loop))
    many = replace(laws, terms=tuple(find_driven(name) for name in STATIC[1:10]))
    with pytest.raises(IdentificationError, match="10 numbers are not told apart by regression"):
        by_regression(trial.part(0, 200), replace(fitted, laws=many))
