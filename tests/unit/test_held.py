"""Values that a logger wrote several times count once; what repeats for another reason stays."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import undertow
from undertow.recording.held import as_read, readings
from undertow.recording.parts import Part

TIME = np.arange(800) * 0.01
NOISE = 2e-4 * np.random.default_rng(3).normal(size=TIME.size)
SWING = 0.1 * np.exp(-0.2 * TIME) * np.cos(10.0 * TIME)


@pytest.mark.parametrize("times", [2, 4, 5])
def test_a_repeated_reading_counts_once(times):
    written = np.repeat((SWING + NOISE)[::times], times)[: TIME.size]
    (trial,) = undertow.read(written, t=TIME, units={"x": "m"})
    assert trial.recording.time.size == TIME.size // times
    assert trial.recording.rate_hz == pytest.approx(100.0 / times)
    assert any(f"it was read at {100.0 / times:.4g} Hz" in note for note in trial.recording.notes)
    assert trial.noise["displacement"] == pytest.approx(2e-4, rel=0.4)
    k = undertow.fit(trial, ["stiffness", "viscous_damping"], mass_kg=4.0).coefficients()[0, 0]
    assert k == pytest.approx(400.16, rel=2e-3)  # 4 kg (10^2 + .2^2)


def test_two_clocks_beside_each_other_are_seen_too():
    fresh = np.floor(np.arange(800) * 0.33 + 0.2)
    written = np.interp(fresh / 33.0, TIME, SWING + NOISE)
    assert readings(written).size == pytest.approx(np.unique(fresh).size, abs=8)


@pytest.mark.parametrize(
    "values",
    [
        SWING + NOISE,
        np.round((SWING + NOISE) / 5e-3) * 5e-3,  # a coarse sensor repeats where it turns
        np.round(SWING / 2e-4) * 2e-4,
        np.where(TIME < 3.0, SWING, SWING[300]),  # a simulated body that has come to rest
        np.round(0.1 * np.exp(-0.2 * TIME) / 1e-4) * 1e-4,  # creeps by less than a step
        np.floor(np.arange(TIME.size) / 4.0) * 1e-4,  # by one step, every fourth sample
    ],
)  # fmt: skip
def test_what_repeats_for_another_reason_stays(values):
    assert readings(values).size == values.size


def test_a_channel_beside_keeps_its_own_clock():
    table = pd.DataFrame({"t": TIME, "x": np.repeat((SWING + NOISE)[::4], 4), "a": -100.0 * SWING + 100.0 * NOISE})
    (trial,) = undertow.read(table, units={"t": "s", "x": "m", "a": "m/s^2"})
    assert set(trial.recording.channels) == {"displacement", "acceleration"}
    assert np.all(np.diff(trial.recording.time) == pytest.approx(0.04))


def test_a_load_held_on_purpose_stays():
    part = Part(TIME, {"displacement": SWING, "force": np.repeat(NOISE[::4], 4)})
    assert as_read(part) == ([part], ())
