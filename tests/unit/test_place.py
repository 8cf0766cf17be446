"""Where a mismatch is: thirds, lines, amplitude exponent, on residuals made for it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from undertow.discrepancy.mismatch import Mismatch
from undertow.discrepancy.place import amplitude_exponent, strongest_line, thirds
from undertow.likelihood.free_run import FreeRun

T = np.arange(0.0, 10.0, 0.01)


def run(measured, residual) -> FreeRun:
    return FreeRun(T, measured, measured - residual, 0.1, np.zeros(1), np.zeros((T.size, 1)))


def test_thirds_add_up_to_one_and_see_where_the_residual_is():
    late = np.where(T > 7.0, 1.0, 0.0)
    shares = thirds(late, 0.0)
    assert sum(shares) == pytest.approx(1.0)
    assert shares[2] == pytest.approx(1.0)


def test_noise_alone_has_no_place():
    noise = 0.01 * np.random.default_rng(1).standard_normal(T.size)
    assert all(math.isnan(s) or s < 1.0 for s in thirds(noise, 0.02))
    assert math.isnan(thirds(noise, 0.02)[0])


def test_a_line_beside_the_bodys_own_is_found_with_its_share():
    residual = np.cos(2 * np.pi * 1.55 * T)
    frequency, share = strongest_line(T, residual, body_hz=0.9, noise=0.0)
    assert frequency == pytest.approx(1.55, abs=0.1)  # bins of 0.1 Hz in ten seconds
    assert share > 0.9


def test_the_bodys_own_line_is_not_called_a_line():
    residual = np.cos(2 * np.pi * 0.9 * T) + 0.1 * np.cos(2 * np.pi * 2.5 * T)
    frequency, _ = strongest_line(T, residual, body_hz=0.9, noise=0.0)
    assert frequency == pytest.approx(2.5, abs=0.1)


@pytest.mark.parametrize("power", [1.0, 3.0])
def test_amplitude_exponent_is_the_power_of_the_residual(power):
    size = np.exp(-0.3 * T)
    wave = np.cos(2 * np.pi * T)
    found = amplitude_exponent(run(size * wave, 0.01 * size**power * wave), 1.0, 0.0)
    assert found == pytest.approx(power, abs=0.1)  # the envelope bends a little within a cycle


def test_a_trial_is_missing_something_only_beyond_repeatability():
    assert Mismatch("a", 0.06, 0.01, 0.05).missing
    assert not Mismatch("a", 0.04, 0.01, 0.05).missing
