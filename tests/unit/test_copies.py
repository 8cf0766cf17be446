"""Recordings that are one and the same under several names are found, and repetitions of one release are not."""

from __future__ import annotations

import numpy as np
import pytest

import undertow
from undertow.recording.copies import copies
from undertow.recording.recording import Array, Recording

RATE_HZ = 200.0


def released(rng: np.random.Generator, scatter: float = 1e-3, sigma: float = 1e-3, step: float = 0.0) -> Array:
    """A hold of .8 s and a decay of size 1 whose rate, size and damping differ by ``scatter`` from trial to trial."""
    t = np.arange(3000) / RATE_HZ
    size, rate, damping = 1.0 + scatter * rng.standard_normal(3) * (1.0, 0.5, 10.0)
    angle = 6.0 * rate * np.maximum(t - 0.8, 0.0)
    x = size * np.exp(-0.02 * damping * angle) * np.cos(angle) + sigma * rng.standard_normal(t.size)
    return np.round(x / step) * step if step else x


def trial(name: str, x: Array, rate_hz: float = RATE_HZ) -> Recording:
    return Recording(name, np.arange(x.size) / rate_hz, {"displacement": x})


@pytest.mark.parametrize("digits", [2.5e-4, 1e-3, 1.5e-3])
@pytest.mark.parametrize("cut", [slice(0, None), slice(15, None), slice(0, 2100), slice(140, 2000)])
def test_one_recording_exported_again_is_the_same(cut: slice, digits: float) -> None:
    rng = np.random.default_rng(1)
    first, second = released(rng), released(rng)
    again = np.round((first[cut] + 0.02) / digits) * digits
    trials = [trial("a", first), trial("b", second), trial("c", again), trial("d", second[40:])]
    assert copies(trials) == {2: 0, 3: 1}
    assert copies(trials[::-1]) == {2: 0, 3: 1}


def test_of_three_exports_the_first_is_the_original() -> None:
    x = released(np.random.default_rng(2))
    assert copies([trial("a", x[10:]), trial("b", np.round(x, 3)), trial("c", x)]) == {1: 0, 2: 0}


def test_another_rate_is_another_recording() -> None:
    x = released(np.random.default_rng(3))
    assert copies([trial("a", x), trial("b", x, 2.0 * RATE_HZ)]) == {}


def test_noise_that_is_repeated_on_another_motion_is_none() -> None:
    same = [released(np.random.default_rng(4), scatter) for scatter in (0.0, 0.05)]
    assert copies([trial(str(i), x) for i, x in enumerate(same)]) == {}


@pytest.mark.parametrize("scatter", [0.0, 1e-4, 1e-2])
@pytest.mark.parametrize("sigma", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("step", [0.0, 0.1, 1.0, 3.0, 30.0, 100.0])
def test_repetitions_of_one_release_are_no_copies(scatter: float, sigma: float, step: float) -> None:
    rng = np.random.default_rng(5)
    trials = [trial(str(i), released(rng, scatter, sigma, step * sigma)) for i in range(10)]
    unequal = {r.channels["displacement"].tobytes(): r for r in trials}  # coarse and without scatter some are equal
    assert copies(list(unequal.values())) == {}


def test_what_python_reads_is_held_against_itself() -> None:
    rng = np.random.default_rng(6)
    first, second = released(rng), released(rng)
    t = np.arange(first.size) / RATE_HZ
    four = [first, second, first.copy(), np.round(second, 3)]
    trials = undertow.read(four, t=t, units={"x": "m"}, names=list("abcd"))
    assert trials.names == ("a", "b")
    assert [one.name for one in trials.failed] == ["c", "d"]
    assert "trial d is the same recording as b, sample by sample; take one of them out" in trials.failed[1].reason
