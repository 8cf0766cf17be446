"""Recordings that are one and the same under several names are found, and repetitions of one release are not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import resample_poly

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


def originals(trials: list[Recording]) -> dict[int, int]:
    return {at: copy.original for at, copy in copies(trials).items() if "the same recording as {}" in copy.how}


@pytest.mark.parametrize("digits", [2.5e-4, 1e-3, 1.5e-3])
@pytest.mark.parametrize("cut", [slice(0, None), slice(15, None), slice(0, 2100), slice(140, 2000)])
def test_one_recording_exported_again_is_the_same(cut: slice, digits: float) -> None:
    rng = np.random.default_rng(1)
    first, second = released(rng), released(rng)
    again = np.round((first[cut] + 0.02) / digits) * digits
    trials = [trial("a", first), trial("b", second), trial("c", again), trial("d", second[40:])]
    assert originals(trials) == {2: 0, 3: 1}
    assert originals(trials[::-1]) == {2: 0, 3: 1}


def test_of_three_exports_the_first_is_the_original() -> None:
    x = released(np.random.default_rng(2))
    assert originals([trial("a", x[10:]), trial("b", np.round(x, 3)), trial("c", x)]) == {1: 0, 2: 0}


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


def lasting(rng: np.random.Generator, scatter: float = 1e-3, sigma: float = 1e-3, ring: float = 0.0) -> Array:
    """A minute of `released`, with ringing and hum of a size (m) that are the same in every trial."""
    t = np.arange(12_000) / RATE_HZ
    size, rate = 1.0 + scatter * rng.standard_normal(2)
    angle = 6.0 * rate * np.maximum(t - 0.8, 0.0)
    rung = np.exp(-3.0 * np.maximum(t - 0.8, 0.0)) * np.sin(230.0 * (t - 0.8)) * (t > 0.8)
    x = size * np.exp(-0.02 * angle) * np.cos(angle) + ring * (rung + np.sin(2.0 * np.pi * 30.0 * t))
    return np.asarray(x + sigma * rng.standard_normal(t.size))


def said(recordings: list[Recording]) -> dict[int, str]:
    return {at: copy.how.format(recordings[copy.original].name) for at, copy in copies(recordings).items()}


AGAIN = "the recording a resampled: their noise is the same"

CHANGED = {
    "turned round": (lambda x: -x, 1.0, "the recording a times -1"),
    "turned round and cut": (lambda x: 0.2 - x[333:9000], 1.0, "the recording a times -1"),
    "in mm": (lambda x: 1e3 * x, 1.0, "the recording a times 1000"),
    "scaled and rounded": (lambda x: np.round(0.37 * x, 4), 1.0, "the recording a times 0.37"),
    "every second": (lambda x: x[::2], 2.0, "every 2nd sample of a"),
    "every second, the others": (lambda x: np.round(x[1::2], 3), 2.0, "every 2nd sample of a"),
    "every third, turned round": (lambda x: -x[2::3], 3.0, "every 3rd sample of a, times -1"),
    "every tenth": (lambda x: x[::10], 10.0, "every 10th sample of a"),
    "means of four": (lambda x: x.reshape(-1, 4).mean(axis=1), 4.0, AGAIN),
    "between samples": (lambda x: between(x, 1.54), 1.54, AGAIN),
    "at a higher rate": (lambda x: between(x, 0.6), 0.6, AGAIN),
    "filtered and thinned": (lambda x: resample_poly(x, 2, 5), 2.5, AGAIN),
}  # fmt: skip


def between(x: Array, step: float) -> Array:
    """Straight lines between samples, so many of their steps apart."""
    return np.interp(np.arange(0.0, x.size - 1.0, step), np.arange(x.size), x)


@pytest.mark.parametrize("name", CHANGED)
def test_a_changed_copy_is_seen_and_said_to_be_that(name: str) -> None:
    change, step, how = CHANGED[name]
    rng = np.random.default_rng(7)
    x, other = lasting(rng), lasting(rng)
    assert said([trial("a", x), trial("b", other), trial("c", change(x), RATE_HZ / step)]) == {2: how}
    back = said([trial("c", change(x), RATE_HZ / step), trial("b", other), trial("a", x)])
    assert list(back) == [2]
    assert "c" in back[2]


def test_the_part_of_a_thinned_copy_is_found_by_the_clocks() -> None:
    x = lasting(np.random.default_rng(8))
    part = Recording("c", 203 / RATE_HZ + np.arange(1600) * 5.0 / RATE_HZ, {"displacement": x[203::5][:1600]})
    assert said([trial("a", x), part]) == {1: "every 5th sample of a"}


@pytest.mark.parametrize("scatter", [0.0, 1e-4, 1e-2])
@pytest.mark.parametrize("sigma", [1e-5, 1e-3])
@pytest.mark.parametrize("step", [0.0, 1.0, 2.0, 30.0, 1000.0])
@pytest.mark.parametrize("ring", [0.0, 20.0])
def test_repetitions_turned_round_scaled_or_at_another_rate_are_no_copies(
    scatter: float, sigma: float, step: float, ring: float
) -> None:
    rng = np.random.default_rng(9)
    changes = [*CHANGED.values(), (lambda x: x, 1.0, "")]
    first = lasting(rng, scatter, sigma, ring * sigma)
    for change, every, _ in changes:
        pair = [first, lasting(rng, scatter, sigma, ring * sigma)]
        if step:
            pair = [np.round(x / (step * sigma)) * step * sigma for x in pair]
        if not np.array_equal(*pair):
            assert said([trial("a", pair[0]), trial("b", change(pair[1]), RATE_HZ / every)]) == {}


def test_simulations_without_noise_of_a_linear_body_are_no_copies_of_each_other() -> None:
    x = lasting(np.random.default_rng(10), sigma=0.0)
    for kind in (np.float64, np.float32):
        trials = [trial(str(i), (factor * x).astype(kind).astype(float)) for i, factor in enumerate((1.0, 0.5, -1.0))]
        assert said([*trials, trial("thin", x[::2], RATE_HZ / 2.0)]) == {}


def test_a_turned_copy_is_left_out_with_a_sentence() -> None:
    x = released(np.random.default_rng(11))
    t = np.arange(x.size) / RATE_HZ
    trials = undertow.read([x, -x], t=t, units={"x": "m"}, names=["a", "b"])
    assert trials.failed[0].reason == (
        "trial b is the recording a times -1; take one of them out of the campaign"
    )
