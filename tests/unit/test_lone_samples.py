"""Lone samples: instants and means are told apart by the turns, and cells of several samples are left alone."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.efficiency.rates import DRAG_UNIT, NAMES, picked, thinned
from experiments.recovery.releases import Truth, plant, record
from undertow.conditioning.condition import condition
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.identification import blind, output_error
from undertow.identification.lone_samples import as_recorded
from undertow.identification.problem import Link, Problem, ProblemBuilder, TrialOptions
from undertow.recording.recording import Recording

RELEASE_M = 0.033
SEED = 3


@pytest.fixture(scope="module")
def truth() -> Truth:
    """The short spring at 2.36 m: half a second a period, one sample a cell at 100 Hz."""
    return plant("short", 2.36)


@pytest.fixture(scope="module")
def full(truth: Truth) -> Recording:
    """One release at 1 kHz."""
    return record(truth, RELEASE_M, "N1", np.random.default_rng(SEED), "short")


def problem(truth: Truth, recording: Recording) -> Problem:
    """m_a, C_d, c, mu of one trial."""
    builder = ProblemBuilder()
    for name, start in zip(NAMES, (500.0, 5.0, 500.0, 0.006), strict=True):
        builder.unknown(name, start)
    base = np.zeros(N_SLOTS)
    base[SLOT["mass"]], base[SLOT["k1"]] = 2637.4, truth.k_N_per_m
    factors = (("mass", 1.0), ("q", DRAG_UNIT), ("c1", 1.0), ("fc", truth.normal_force_N))
    links = tuple(Link(SLOT[slot], i, factor) for i, (slot, factor) in enumerate(factors))
    builder.trial(condition(recording), base, links, TrialOptions())
    return builder.build()


def early_s() -> float:
    """How long before a sample the release fell: the first draw of `record`."""
    return float(np.random.default_rng(SEED).integers(0, 10)) / 1e4


def test_a_logger_that_averages_is_seen_as_such(truth: Truth, full: Recording):
    found = blind.fit(problem(truth, thinned(full, 10))).problem.trials[0]
    assert found.width_s > 0.0
    assert found.averaged


def test_a_logger_that_samples_is_seen_as_such_and_fits_better(truth: Truth, full: Recording):
    asked = problem(truth, picked(full, truth, RELEASE_M, early_s(), 10))
    searched, found = output_error.fit(asked), blind.fit(asked)
    assert found.problem.trials[0].width_s == 0.0
    assert found.chi2 < 0.9 * searched.chi2  # twenty turns, each a few units of noise off where means are compared


def test_cells_of_several_samples_are_left_alone(truth: Truth, full: Recording):
    searched = output_error.fit(problem(truth, full))
    assert as_recorded(searched) is searched
