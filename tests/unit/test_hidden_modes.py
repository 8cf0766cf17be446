"""Modes of a short window: against closed forms, a body alone, and a body with a hidden oscillator."""

import math

import numpy as np
import pytest

from undertow.comparison.hidden_modes import (
    HankelModes,
    Mode,
    coupled_modes,
    hankel_modes,
    seeds_from_modes,
)
from undertow.conditioning.motion import Motion, Window
from undertow.errors import IdentificationError
from undertow.quantities import Estimate
from undertow.recording.recording import Recording


def motion_of(waves, seconds=6.0, noise=0.0, step=0.002):
    """A motion whose acceleration is a sum of damped waves (w, zeta, amplitude, phase)."""
    t = np.arange(0.0, seconds, step)
    a = sum(size * np.exp(-z * w * t) * np.cos(w * t + phase) for w, z, size, phase in waves)
    v = np.cumsum(a) * step
    v -= v.mean()
    a = a + noise * np.random.default_rng(4).standard_normal(t.size)
    recording = Recording("made", t, {"acceleration": a}, {})
    nothing = np.zeros(t.size)
    return Motion(
        recording, Window(0.0, 0.0, seconds, held=True), t, v, v, a, nothing, nothing, nothing,
        np.ones(t.size, dtype=bool), Estimate(0.0, 0.0, unit="m"), 1.0, {"acceleration": noise},
    )  # fmt: skip


def test_two_damped_waves_come_back_with_frequency_damping_and_amplitude():
    found = hankel_modes(motion_of([(11.6, 0.03, 4.0, 0.2), (9.4, 0.02, 0.5, 1.0)])).modes
    # samples fall unevenly into twenty cells a period: what that makes up stays below half a per cent
    assert all(mode.amplitude < 0.005 * found[0].amplitude for mode in found[2:])
    # averaging to twenty cells a period shifts no pole and takes under 2 % of the amplitude
    assert (found[0].w, found[0].zeta) == (pytest.approx(11.6, rel=2e-3), pytest.approx(0.03, abs=1e-3))
    assert (found[1].w, found[1].zeta) == (pytest.approx(9.4, rel=5e-3), pytest.approx(0.02, abs=3e-3))
    assert found[0].amplitude == pytest.approx(4.0, rel=0.03)
    assert found[1].amplitude == pytest.approx(0.5, rel=0.1)


def test_noise_makes_no_second_mode_of_a_wave_alone():
    modes = hankel_modes(motion_of([(11.6, 0.03, 4.0, 0.2)], noise=0.1))
    assert [round(mode.w, 1) for mode in modes.modes] == [11.6]
    assert modes.singular_values[0] == 1.0
    assert np.all(np.diff(modes.singular_values) <= 0.0)


def test_coupled_modes_keep_the_product_and_the_sum_of_squares():
    (low, _), (high, _) = coupled_modes(11.6, [(9.6, 0.0, 0.1)])
    # characteristic polynomial of body and oscillator without damping: exact
    assert low * high == pytest.approx(11.6 * 9.6, rel=1e-12)
    assert low**2 + high**2 == pytest.approx(11.6**2 + 1.1 * 9.6**2, rel=1e-12)


def test_a_body_alone_has_its_own_frequency_and_two_oscillators_make_three_modes():
    assert coupled_modes(11.6, []) == ((pytest.approx(11.6), pytest.approx(0.0, abs=1e-12)),)
    three = coupled_modes(11.6, [(7.5, 0.02, 0.07), (10.5, 0.02, 0.07)])
    assert len(three) == 3
    assert all(0.0 < zeta < 0.02 for _, zeta in three)
    assert [w for w, _ in three] == sorted(w for w, _ in three)


def test_modes_agree_where_every_expected_one_is_near_and_seeds_are_all_but_the_body():
    modes = HankelModes((Mode(12.0, 0.03, 4.0), Mode(9.0, 0.5, 0.3)), 4, np.ones(3))
    assert modes.agree_with([(12.3, 0.0), (9.2, 0.0)])
    assert not modes.agree_with([(12.3, 0.0), (9.6, 0.0)])
    assert seeds_from_modes(modes) == ((9.0, 0.15),)


def test_what_cannot_have_modes_is_refused_with_its_value():
    with pytest.raises(IdentificationError, match=r"trial made: 2\.\d* periods in the window; modes need 3"):
        hankel_modes(motion_of([(2.0 * math.pi, 0.01, 1.0, 0.0)], seconds=2.5))
    with pytest.raises(IdentificationError, match="frequency is -1 rad/s; it must be above 0"):
        coupled_modes(-1.0, [])
