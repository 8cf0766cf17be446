"""Bodies that a hand moves before it holds and releases them: the release is found, at any speed of body and hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from undertow.conditioning.condition import condition
from undertow.conditioning.decaying import refuse_no_decay
from undertow.conditioning.period import dominant_period
from undertow.conditioning.release import find_window
from undertow.recording.recording import Recording

Array = NDArray[np.float64]

SAMPLES = 50
RELEASE_RADIANS = 0.3
"""A body whose hold wobbles by a hundredth is released with a velocity: the instant is open by about that angle."""


@dataclass(frozen=True)
class Hand:
    """What a hand does, in periods of the body: how long and how fast it moves (``pace``), by what share of the release
    (``size``); how long it holds, how much it wobbles and sinks then, as shares of the release."""

    moves: float = 3.0
    pace: float = 0.3
    size: float = 0.3
    holds: float = 1.0
    wobble: float = 0.01
    sinks: float = 0.02


def smooth(rng: np.random.Generator, count: int, width: float) -> Array:
    """A smooth random walk about zero of standard deviation 1, (count,)."""
    raw = gaussian_filter1d(rng.standard_normal(count + 20 * SAMPLES), width)[10 * SAMPLES :][:count]
    return np.asarray((raw - raw.mean()) / np.std(raw)) if count > 1 else raw


def hand_held(hand: Hand, frequency: float, seed: int) -> tuple[Recording, float]:
    """A record of a hand, a hold and a decay, and when the body was let go, s."""
    rng = np.random.default_rng(seed)
    moved, held = round(hand.moves * SAMPLES), round(hand.holds * SAMPLES)
    pulled = np.clip((np.arange(moved) / max(moved, 1) - 0.3) / 0.6, 0.0, 1.0) ** 2
    before = pulled + hand.size * smooth(rng, moved, hand.pace * SAMPLES) * (1.0 - pulled)
    holding = 1.0 + hand.wobble * smooth(rng, held, 0.2 * SAMPLES) - hand.sinks * np.arange(held) / held
    angle = 2.0 * np.pi * np.arange(15 * SAMPLES) / SAMPLES
    free = holding[-1] * np.exp(-0.02 * angle) * (np.cos(angle) + 0.02 * np.sin(angle))
    x = 0.05 * np.concatenate([before, holding, free])
    time = np.arange(x.size) / (SAMPLES * frequency)
    noisy = x + 5e-5 * rng.standard_normal(x.size)
    return Recording("r1", time, {"displacement": noisy}), float(time[moved + held])


@pytest.mark.parametrize("frequency", [0.3, 40.0])
@pytest.mark.parametrize(
    "hand",
    [
        Hand(), Hand(moves=10.0), Hand(size=0.8, moves=6.0), Hand(pace=1.0, moves=10.0), Hand(holds=0.45),
        Hand(holds=3.0), Hand(holds=3.0, wobble=0.03, sinks=0.05), Hand(wobble=0.0, sinks=0.0), Hand(moves=0.0),
    ],
    ids=str,
)  # fmt: skip
def test_the_release_is_found_after_what_a_hand_did(hand: Hand, frequency: float) -> None:
    for seed in range(3):
        recording, released = hand_held(hand, frequency, seed)
        window = find_window(recording)
        refuse_no_decay(recording, window)
        assert window.held
        assert abs(window.release_s - released) * 2.0 * np.pi * frequency < RELEASE_RADIANS
        motion = condition(recording, window=window)
        assert dominant_period(motion) * frequency == pytest.approx(1.0, rel=0.03)
        assert motion.amplitude == pytest.approx(0.05, rel=0.1)


def test_a_fast_hand_that_moves_for_long_does_not_pass_for_the_body() -> None:
    """Of 200 swings 170 are the hand's: the body's period is that of the motion after the release."""
    for seed in range(4):
        recording, released = hand_held(Hand(moves=60.0, pace=0.05, size=0.8, holds=3.0, wobble=0.0), 3.4, seed)
        window = find_window(recording)
        assert window.held
        assert abs(window.release_s - released) * 2.0 * np.pi * 3.4 < RELEASE_RADIANS
