"""Memory of noise: one number for a series, whatever its size; what is left of a number of samples."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from undertow.likelihood.noise import WINDOW_TIMES, autocovariance, correlate, memory, residual_memory


def remembering(share: float, n: int = 20_000) -> np.ndarray:
    """Noise that keeps this share of itself from sample to sample."""
    return lfilter([1.0], [1.0, -share], np.random.default_rng(3).standard_normal(n))


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_memory_of_a_first_order_process_is_its_closed_form(share):
    squared = share**2
    chance = 0.75  # squares of correlations by chance, over half of the lags
    assert memory(remembering(share)) == pytest.approx((1.0 + squared) / (1.0 - squared) * (1.0 + chance), rel=0.15)


def test_memory_depends_neither_on_size_nor_on_level():
    noise = remembering(0.8, 2000)
    assert memory(7.0 - 3e-4 * noise) == pytest.approx(memory(noise), rel=1e-9)


def test_a_residual_that_is_nothing_has_no_memory():
    assert memory(np.full(50, 2.0)) == 1.0


def test_products_at_lags_are_the_sums_by_hand():
    values = np.array([[1.0, 2.0], [3.0, 0.0], [-1.0, 1.0], [2.0, 5.0]])
    by_hand = [(values[: 4 - lag] * values[lag:]).sum(axis=0) for lag in range(4)]
    assert correlate(values, 3) == pytest.approx(np.array(by_hand[:3]), abs=1e-12)
    assert correlate(values, 9) == pytest.approx(np.array(by_hand), abs=1e-12)


def test_autocovariance_ends_at_the_first_lag_that_is_six_correlation_times_away():
    noise = remembering(0.8, 3000)
    products = correlate(noise[:, None], 300)[:, 0]
    time, last = 1.0, 0
    while last + 1 < WINDOW_TIMES * time:
        last += 1
        time += 2.0 * abs(products[last] / products[0])
    found = autocovariance(noise, [noise.size])
    assert found.size == last + 1
    assert found[0] == pytest.approx(float(noise @ noise) / noise.size)
    half = found.size // 2
    share = half / found.size
    assert found[half] == pytest.approx(products[half] / noise.size * 2.0 * (1.0 - share) ** 3)


def test_autocovariance_of_a_stated_memory_has_so_many_lags():
    noise = remembering(0.0, 3000)
    assert autocovariance(noise, [3000], memory=50).size == 50
    assert autocovariance(noise, [3000]).size < 20


@dataclass(frozen=True)
class Fitted:
    """What of a solution its memory is taken from."""

    problem: SimpleNamespace
    residuals: tuple[np.ndarray, ...]


def test_memory_of_a_fit_is_the_mean_over_channels_of_all_trials():
    long, short = remembering(0.9, 800), remembering(0.2, 300)
    trials = [SimpleNamespace(t=np.arange(400), channels=(1, 2)), SimpleNamespace(t=np.arange(300), channels=(1,))]
    found = residual_memory(Fitted(SimpleNamespace(trials=trials), (long, short)))
    assert found == pytest.approx((memory(long[:400]) + memory(long[400:]) + memory(short)) / 3.0)
