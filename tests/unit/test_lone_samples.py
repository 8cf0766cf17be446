"""Lone samples: instants and means are distinguished by the turns, and cells of several samples are left alone."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from experiments.efficiency.rates import picked, problem, thinned
from experiments.recovery.releases import Truth, plant, record
from undertow.conditioning.condition import condition
from undertow.conditioning.period import dominant_period
from undertow.likelihood import multistart as blind
from undertow.likelihood import output_error
from undertow.likelihood.multistart import as_recorded
from undertow.likelihood.problem import cells
from undertow.recording.recording import Recording


class Still(SimpleNamespace):
    """What stands for a motion: like one, it is itself alone."""

    __hash__ = object.__hash__


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


def early_s() -> float:
    """How long before a sample the release fell: the first draw of `record`."""
    return float(np.random.default_rng(SEED).integers(0, 10)) / 1e4


def test_a_logger_that_averages_is_seen_as_such(truth: Truth, full: Recording):
    found = blind.fit(problem(truth, condition(thinned(full, 10)))).problem.trials[0]
    assert found.width_s > 0.0
    assert found.averaged


def test_a_logger_that_samples_is_seen_as_such_and_fits_better(truth: Truth, full: Recording):
    asked = problem(truth, condition(picked(full, truth, RELEASE_M, early_s(), 10)))
    searched, found = output_error.fit(asked), blind.fit(asked)
    assert found.problem.trials[0].width_s == 0.0
    assert found.chi2 < 0.9 * searched.chi2  # twenty turns, each a few units of noise off where means are compared


def test_cells_of_several_samples_are_left_alone(truth: Truth, full: Recording):
    searched = output_error.fit(problem(truth, condition(full)))
    assert as_recorded(searched) is searched


def test_a_cell_in_which_samples_are_missing_is_left_out(truth: Truth, full: Recording):
    lost = slice(2500, 2503)
    holed = condition(Recording("holed", np.delete(full.time, lost), {
        name: np.delete(values, lost) for name, values in full.channels.items()
    }))  # fmt: skip
    left, m = cells(holed, dominant_period(holed))
    assert m > 3
    assert np.max(holed.t[left[:, -1]] - holed.t[left[:, 0]]) < (m - 0.5) * 1e-3
    assert np.max(np.diff(left[:, 0])) > m  # the cell is gone
    (residual,) = output_error.fit(problem(truth, holed)).residuals
    assert np.max(np.abs(residual)) < 6.0


@pytest.mark.parametrize(
    ("noise", "samples", "a_cell"),
    [
        ({"displacement": 3e-4, "acceleration": 5e-3}, 94.0, 2),
        ({"displacement": 1e-5}, 94.0, 1),
        ({"displacement": 3e-4, "acceleration": 1e-4}, 94.0, 1),  # the quietest channel decides
        ({"displacement": 1e-5, "spring_force": 1e-9}, 1000.0, 20),
        ({"displacement": 1e-9}, 60.0, 1),
        ({"displacement": 1e-9}, 250.0, 5),
    ],
)
def test_quiet_samples_are_taken_together_only_where_their_mean_is_that_of_the_span(noise, samples, a_cell):
    """A tenth of a metre at 1 Hz: means of two instants of 94 a period miss 2e-5 m and 7e-4 m/s^2 of it."""
    t = np.arange(0.0, 10.0, 1.0 / samples)
    step = float(np.median(np.diff(t)))
    motion = Still(name="r", t=t, step_s=step, inside=t > 0.0, amplitude=0.1, noise=noise)
    index, m = cells(motion, 1.0)
    assert m == a_cell
    assert index.shape[1] == m
