"""Records that hold several releases on one clock are parted at each; those of one release never are."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from undertow.conditioning.releases import releases_said, several_releases
from undertow.recording.recording import Array, Recording

RATE_HZ = 100.0
SIGMA_M = 1e-4


def seconds(duration: float, frequency_hz: float = 1.0) -> Array:
    """Instants of so many periods, s."""
    return np.arange(round(duration * RATE_HZ)) / RATE_HZ / frequency_hz


def decay(periods: float, size: float, damping: float = 0.03) -> Array:
    """A decay of 1 Hz at `RATE_HZ`, from a turning point."""
    angle = 2.0 * np.pi * seconds(periods)
    return size * np.exp(-damping * angle) * np.cos(angle)


def friction(periods: float, size: float, halfwidth: float) -> Array:
    """The same of a body that dry friction stops, away from the middle."""
    swing = np.floor(2.0 * seconds(periods))
    left = size - halfwidth - 2.0 * halfwidth * swing
    x = (-1.0) ** swing * halfwidth + left * np.cos(2.0 * np.pi * seconds(periods))
    stuck = int(np.flatnonzero(left <= 0.0)[0])
    return np.r_[x[:stuck], np.full(x.size - stuck, x[stuck - 1])]


def session(decays: list[Array], hold: float = 2.0, pull: float = 1.5, first: float = 2.0) -> tuple[Array, list[float]]:
    """Held, let go, pulled in a straight line, held, let go, ...: displacement and the instants of the releases, s."""
    x, at = np.empty(0), []
    for one in decays:
        if x.size:
            x = np.r_[x, x[-1] + (one[0] - x[-1]) * seconds(pull) / pull]
        x = np.r_[x, np.full(round((hold if at else first) * RATE_HZ), one[0])]
        at.append(x.size / RATE_HZ)
        x = np.r_[x, one]
    return x, at


def record(x: Array, sigma: float = SIGMA_M, frequency_hz: float = 1.0, size: float = 1.0, seed: int = 0) -> Recording:
    noisy = size * (x + sigma * np.random.default_rng(seed).standard_normal(x.size))
    return Recording("r", np.arange(x.size) / RATE_HZ / frequency_hz, {"displacement": noisy})


BEAT = 0.07 * (decay(30, 1.0) + np.exp(-0.03 * 2.0 * np.pi * seconds(30)) * np.cos(2.1 * np.pi * seconds(30)))

SESSIONS = {
    "two": session([decay(20, 0.1), decay(20, 0.08)]),
    "either side": session([decay(20, 0.1), decay(20, -0.08), decay(20, 0.09)]),
    "one small": session([decay(20, 0.1), decay(20, 0.03), decay(20, 0.1)]),
    "hardly damped": session([decay(30, 0.1, 0.003), decay(30, 0.1, 0.003)]),
    "strongly damped": session([decay(10, 0.1, 0.25), decay(10, 0.08, 0.25)]),
    "still swinging": session([decay(4.3, 0.1), decay(3.6, 0.1), decay(5, 0.1)]),
    "stuck away from the middle": session([friction(10, 0.1, 0.005), friction(10, 0.09, 0.005)]),
    "beating": session([BEAT, 0.7 * BEAT, BEAT]),
    "no hold but a slow pull": session([decay(20, 0.1), decay(20, 0.08)], hold=0.0, pull=3.0),
    "put one after another": session([decay(20, 0.1), decay(20, 0.08)], pull=0.01),
    "no first hold": session([decay(20, 0.1), decay(20, 0.08)], first=0.0),
    "drifting": (lambda x, at: (x + 0.05 * np.arange(x.size) / x.size, at))(*session([decay(20, 0.1)] * 3)),
}


@pytest.mark.parametrize("name", SESSIONS)
def test_each_release_of_a_session_is_found_and_parts_share_nothing(name: str) -> None:
    x, at = SESSIONS[name]
    found = several_releases(record(x))
    np.testing.assert_allclose([one.release_s for one in found], at, atol=0.12)  # a tenth of the period
    edges = [edge for one in found for edge in (one.start_s, one.release_s, one.end_s)]
    assert edges == sorted(edges)
    assert all(one.end_s < following.start_s for one, following in itertools.pairwise(found))
    length = min(np.diff([*at, x.size / RATE_HZ])) - 4.0
    assert all(one.end_s - one.release_s > length for one in found)  # nothing is cut but what the pull covers


@pytest.mark.parametrize("frequency_hz", [0.02, 40.0])
@pytest.mark.parametrize("size", [1e-5, 1e3])
def test_neither_the_period_nor_the_size_counts(frequency_hz: float, size: float) -> None:
    x, at = SESSIONS["either side"]
    found = several_releases(record(x, frequency_hz=frequency_hz, size=size))
    np.testing.assert_allclose([one.release_s * frequency_hz for one in found], at, atol=0.05)


def test_a_record_that_ends_with_another_pull_ends_before_it() -> None:
    x, _ = session([decay(20, 0.1), decay(20, 0.08), np.full(200, 0.1)])
    found = several_releases(record(x))
    assert len(found) == 2
    assert found[-1].end_s == pytest.approx(45.5, abs=0.5)  # its last turn, half a period before


def beats(hold: float, apart: float, share: float, damping: float) -> Array:
    after = 2.0 * np.pi * np.maximum(seconds(60) - hold, 0.0)
    return np.exp(-damping * after) * (np.cos(after) + share * np.cos((1.0 + apart) * after)) * 0.1 / (1.0 + share)


def knocked(at: float, push: float, lasts: float, stuck: tuple[float, float] = (0.0, 0.0)) -> Array:
    """A body let go after 2 s and pushed once; it may stick where it turns in some span of time."""
    dt, x, v, out, sticks = 1.0 / RATE_HZ, 0.1, 0.0, [], False
    for t in seconds(40):
        sticks = stuck[0] <= t < stuck[1] and (sticks or abs(v) < 0.03)
        if t >= 2.0 and not sticks:
            v += dt * ((push if at <= t < at + lasts else 0.0) - (2.0 * np.pi) ** 2 * x - 0.04 * 2.0 * np.pi * v)
            x += dt * v
        v = 0.0 if sticks else v
        out.append(x)
    return np.array(out)


@pytest.mark.parametrize("sigma", [1e-6, 3e-3])
@pytest.mark.parametrize("hold", [0.0, 3.0])
@pytest.mark.parametrize("apart", [0.05, 0.5, 1.0, 3.5])
@pytest.mark.parametrize("share", [0.5, 1.0])
def test_beats_are_one_decay(hold: float, apart: float, share: float, sigma: float) -> None:
    for damping in (0.0005, 0.003, 0.02):
        assert several_releases(record(beats(hold, apart, share, damping), sigma)) == ()


@pytest.mark.parametrize("at", [5.3, 8.0, 25.0])
@pytest.mark.parametrize("push", [0.2, 1.0, 8.0])
def test_a_knock_is_no_release(at: float, push: float) -> None:
    for lasts in (0.05, 0.3, 1.0):
        assert several_releases(record(knocked(at, push, lasts))) == ()


@pytest.mark.parametrize("begins", [3.0, 4.2, 6.1])
def test_a_body_that_sticks_for_a_while_is_not_let_go_twice(begins: float) -> None:
    assert several_releases(record(knocked(0.0, 0.0, 0.0, (begins, begins + 5.0)))) == ()


def test_one_release_is_one_whatever_came_before_it() -> None:
    pull = 0.1 * seconds(2) / 2.0
    rest, held = np.zeros(300), np.full(200, 0.1)
    slipped = np.r_[np.full(300, 0.1), np.full(200, 0.07), held]
    jerky = pull + 0.02 * np.sin(5.0 * seconds(2))
    for before in (held, np.r_[rest, pull, held], np.r_[rest, jerky, held], slipped):
        assert several_releases(record(np.r_[before, decay(30, 0.1)])) == ()
    assert several_releases(record(np.r_[held, friction(30, 0.1, 0.02)])) == ()


@pytest.mark.parametrize("seed", range(5))
def test_what_is_no_decay_is_not_parted(seed: int) -> None:
    rng = np.random.default_rng(seed)
    kernel = np.exp(-0.02 * np.arange(600)) * np.cos(2.0 * np.pi * np.arange(600) / 100.0)
    for x in (
        np.cumsum(rng.standard_normal(4000)), np.repeat(rng.standard_normal(10), 400), rng.standard_normal(4000),
        np.convolve(rng.standard_normal(4599), kernel, "valid"), decay(30, 0.001, -0.01),
    ):  # fmt: skip
        assert several_releases(record(x, 1e-3)) == ()


def test_a_velocity_or_a_measured_input_says_nothing() -> None:
    whole = record(SESSIONS["two"][0])
    x = whole.channels["displacement"]
    assert several_releases(Recording("r", whole.time, {"velocity": x})) == ()
    assert several_releases(Recording("r", whole.time, {"displacement": x, "force": x})) == ()


def test_the_sentence_has_the_parts_and_the_way_out() -> None:
    said = releases_said(several_releases(record(SESSIONS["two"][0])), "tank.csv", 25.5)
    assert said.startswith("it holds 2 releases on one clock (let go near 2, 25.5 s), and only that of 25.5 s is used:")
    assert 'recordings.releases: {"tank.csv": [{start_s: 0, end_s: 2' in said
    assert said.endswith("or list releases in recordings.accept")
