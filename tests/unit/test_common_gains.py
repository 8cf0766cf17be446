"""One sensor's gain errs by the same in all trials: many trials do not average it out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from undertow.comparison.common_gains import with_common_gains
from undertow.discrepancy.validation import _mean_amplitude
from undertow.likelihood.problem import Unknown

NOISE, GAIN, TRIALS = 0.002, 0.005, 8


@dataclass(frozen=True)
class Fit:
    """What is read of a fit."""

    solution: Any
    addends: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Solution:
    problem: Any
    covariance: np.ndarray
    values: np.ndarray


def fitted(kind: str = "displacement_gain", frees: str = "") -> Fit:
    """A size that every trial measures with noise and with a gain of its own, as a fit of independent gains has it."""
    unknowns = [Unknown("size_N", 0.0)]
    unknowns += [Unknown(f"{kind}[r{i}]", 0.0, prior_std=GAIN) for i in range(TRIALS)]
    normal = np.diag([0.0, *[1.0 / GAIN**2] * TRIALS])
    for i in range(TRIALS):
        row = np.zeros(1 + TRIALS)
        row[0] = row[1 + i] = 1.0 / NOISE
        normal += np.outer(row, row)
    problem = SimpleNamespace(unknowns=tuple(unknowns), names=tuple(u.name for u in unknowns))
    addends = (SimpleNamespace(frees=frees),)
    return Fit(Solution(problem, np.linalg.inv(normal), np.zeros(1 + TRIALS)), addends)


@pytest.mark.parametrize("kind", ["displacement_gain", "acceleration_gain"])
def test_a_common_gain_is_as_uncertain_after_many_trials_as_after_one(kind):
    fit = fitted(kind)
    assert fit.solution.covariance[0, 0] == pytest.approx((NOISE**2 + GAIN**2) / TRIALS)
    grown = with_common_gains(fit)
    assert grown.solution.covariance[0, 0] == pytest.approx(NOISE**2 / TRIALS + GAIN**2)
    assert np.linalg.eigvalsh(grown.solution.covariance)[0] > 0.0


def test_a_gain_that_is_suspected_is_measured_and_adds_nothing():
    fit = fitted("acceleration_gain", frees="acceleration_gain")
    np.testing.assert_array_equal(with_common_gains(fit).solution.covariance, fit.solution.covariance)


def test_a_fit_without_gains_keeps_its_errors():
    fit = fitted("rest_m")
    np.testing.assert_array_equal(with_common_gains(fit).solution.covariance, fit.solution.covariance)


def test_a_mean_amplitude_is_no_surer_than_the_fit_nor_than_its_trials_differ():
    names = tuple(f"external_forcing.{part}_N[r{i}]" for i in range(4) for part in ("cosine", "sine"))
    values = np.array([3.0, 4.0, -4.0, 3.0, 5.0, 0.0, 0.0, -5.0])
    same = 0.1**2 * np.outer(values, values) / 25.0  # all sizes off by the same, .1 N
    trials = [SimpleNamespace(name=f"r{i}", t=np.array([0.0, 8.0])) for i in range(4)]
    fit = Fit(Solution(SimpleNamespace(names=names, trials=trials), same, values))
    own = [
        SimpleNamespace(name=f"{part}_N", of_its_own=True, slots=((slot, 1.0),))
        for part, slot in (("cosine", "fcos"), ("sine", "fsin"))
    ]
    force = SimpleNamespace(prefix="external_forcing", additions=own)
    found = _mean_amplitude(fit, force)
    assert (found.value, found.stderr) == pytest.approx((5.0, 0.1))
    sizes = np.array([4.0, 6.0, 5.0, 5.0])
    apart = replace(fit.solution, values=values * np.repeat(sizes / 5.0, 2))
    found = _mean_amplitude(replace(fit, solution=apart), force)
    assert found.stderr == pytest.approx(float(np.std(sizes, ddof=1)) / 2.0)
