"""What an equation leaves: as slow as a sensor that wanders, or at the rate of the motion."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from undertow.discrepancy.wandering import left_share, wanders

T = np.arange(2000) / 100.0  # 20 s: ten periods of 2 s


def left(*residuals: np.ndarray) -> SimpleNamespace:
    """A fit that leaves these residuals, a trial each."""
    trials = tuple(SimpleNamespace(t=T[: r.size], period_s=2.0) for r in residuals)
    return SimpleNamespace(solution=SimpleNamespace(problem=SimpleNamespace(trials=trials), residuals=residuals))


@pytest.mark.parametrize("seed", range(4))
def test_noise_that_is_correlated_from_sample_to_sample_wanders(seed):
    noise = np.random.default_rng(seed).standard_normal(T.size)
    assert wanders(left(lfilter([1.0], [1.0, -0.97], noise), lfilter([1.0], [1.0, -0.97], noise[::-1])))


@pytest.mark.parametrize("seed", range(4))
def test_noise_with_a_memory_shorter_than_a_period_wanders_too(seed):
    noise = np.random.default_rng(seed).standard_normal((2, T.size))
    assert wanders(left(*(lfilter([1.0], [1.0, -0.6], row) for row in noise)))


@pytest.mark.parametrize("shape", ["decays", "grows and fades", "steady"])
def test_what_swings_with_the_body_does_not(shape):
    size = {"decays": np.exp(-T / 4.0), "grows and fades": T * np.exp(-T / 4.0), "steady": np.ones(T.size)}[shape]
    noise = np.random.default_rng(3).standard_normal(T.size)
    assert not wanders(left(20.0 * size * np.cos(np.pi * T + 0.2 * T) + noise))


def test_a_record_too_short_for_slower_rates_tells_nothing():
    assert not wanders(left(np.random.default_rng(1).standard_normal(300)))


def test_what_is_left_is_a_share_of_the_recorded_motion():
    motion = np.cos(np.pi * T)
    channels = tuple(
        SimpleNamespace(quantity=quantity, sigma=sigma, values=size * motion)
        for quantity, sigma, size in (("acceleration", 0.5, 10.0), ("displacement", 0.01, 1.0))
    )
    trials = tuple(SimpleNamespace(name=name, t=T, period_s=2.0, channels=channels) for name in "ab")
    residual = np.concatenate([np.full(T.size, 7.0), np.full(T.size, 5.0)])
    solution = SimpleNamespace(problem=SimpleNamespace(trials=trials), residuals=(residual, 3.0 * residual))
    expected = 0.05 * np.sqrt((1.0 + 9.0) / 2.0) / np.std(motion)
    assert left_share(SimpleNamespace(solution=solution)) == pytest.approx(expected)
