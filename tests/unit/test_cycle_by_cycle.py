"""A motion and its simulation cycle by cycle, on motions whose frequencies and damping are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.discrepancy.cycle_by_cycle import compare_cycles, sidebands
from undertow.likelihood.free_run import FreeRun
from undertow.recording.recording import Recording

RATE_HZ, HOLD_S = 100.0, 0.5
NOISE_M = 1e-5


def recorded(x: np.ndarray) -> Motion:
    """A motion from its displacement after the release, held before it."""
    held = np.full(round(HOLD_S * RATE_HZ), x[0])
    values = np.r_[held, x] + NOISE_M * np.random.default_rng(1).standard_normal(held.size + x.size)
    return condition(Recording("r", np.arange(values.size) / RATE_HZ, {"displacement": values}))


def decay(hertz: float, ratio: float, seconds: float = 12.0) -> np.ndarray:
    t = np.arange(0.0, seconds, 1.0 / RATE_HZ)
    w = 2.0 * math.pi * hertz
    return 0.1 * np.exp(-ratio * w * t) * np.cos(w * math.sqrt(1.0 - ratio**2) * t)


def run_of(motion: Motion, simulated: np.ndarray) -> FreeRun:
    t = motion.windowed("t")
    there = np.interp(t, np.arange(simulated.size) / RATE_HZ, simulated)
    measured = motion.windowed("x") - motion.equilibrium.value
    return FreeRun(t, measured, there, 0.1, np.zeros(1), np.zeros((t.size, 1)))


def test_frequency_and_damping_of_both_are_those_that_were_planted():
    motion = recorded(decay(1.00, 0.02))
    found = compare_cycles(motion, run_of(motion, decay(1.05, 0.03)))
    assert np.median(found.frequency_hz) == pytest.approx(1.00, rel=2e-3)
    assert np.median(found.frequency_hz_simulated) == pytest.approx(1.05, rel=2e-3)
    assert np.median(found.damping_ratio) == pytest.approx(0.02, abs=1e-3)
    assert np.median(found.damping_ratio_simulated) == pytest.approx(0.03, abs=1e-3)
    assert "the frequency is 4.8 % lower and the damping is 2 % of critical, not 3 %" in found.sentence()


def test_equal_motions_differ_in_no_word():
    motion = recorded(decay(1.0, 0.02))
    assert compare_cycles(motion, run_of(motion, decay(1.0, 0.02))).sentence() == ""


def test_a_beat_has_one_sideband_and_a_modulation_two():
    t = np.arange(0.0, 12.0, 1.0 / RATE_HZ)
    motion = recorded(decay(1.0, 0.005))
    beat = decay(1.0, 0.005) - 0.01 * np.cos(2.0 * math.pi * 1.6 * t)
    one = sidebands(motion, run_of(motion, beat))
    assert one.spacing_hz == pytest.approx(0.6, abs=0.05)  # a bin of the window is 0.08 Hz
    assert one.upper_share > 0.5
    assert one.lower_share < 0.1
    swelling = decay(1.0, 0.005) * (1.0 - 0.1 * np.cos(2.0 * math.pi * 0.5 * t))
    two = sidebands(motion, run_of(motion, swelling))
    assert min(two.lower_share, two.upper_share) > 0.2


def test_a_simulation_that_sticks_has_no_endless_damping():
    motion = recorded(decay(1.0, 0.02))
    stuck = np.where(np.arange(1200) > 250, 0.0, decay(1.0, 0.02)) + 1e-18 * np.cos(np.arange(1200))
    found = compare_cycles(motion, run_of(motion, stuck))
    swings = np.isfinite(found.damping_ratio_simulated)
    assert not np.any(np.isinf(found.damping_ratio_simulated))
    assert np.all(found.time[swings] < 4.0)  # it stops 2.5 s after the release; a cycle of 1 s and half a swing more
    assert np.all(found.time[~swings] > 2.5)
    assert f"it swings {np.count_nonzero(~swings)} cycles more after the simulation's equation has come to rest" in (
        found.sentence()
    )
