"""The release is found from the first swing: exactly where the law is its own, under noise of any colour."""

import numpy as np
import pytest
from scipy.signal import lfilter

from tests.exact_motions import LONG, SHORT, exact_motion
from undertow.conditioning.first_swing import LAW_SHARE, fit_first_swing
from undertow.conditioning.release import find_window
from undertow.recording.recording import Recording

W = 12.0
RELEASE_S = 0.7313
TIME = np.arange(0.0, 4.0, 0.002)


def swing(x0=0.02, damping=0.03, friction_m=1e-3):
    """A hold and the first two seconds of a damped swing whose centre friction shifts by ``friction_m``."""
    late = np.maximum(TIME - RELEASE_S, 0.0)
    angle = W * late
    size = x0 - friction_m
    return x0 + size * (np.exp(-damping * angle) * (np.cos(angle) + damping * np.sin(angle)) - 1.0)


def first_guess(t0=RELEASE_S + 0.02, w=1.1 * W):
    return {"t0": t0, "x0": 0.02, "size": 0.02, "w": w}


@pytest.mark.parametrize("damping", [0.0, 0.03, 0.15])
def test_a_swing_with_viscous_and_dry_friction_gives_its_release_exactly(damping):
    found = fit_first_swing(TIME, swing(damping=damping), 1e-9, **first_guess())
    assert found.t0 == pytest.approx(RELEASE_S, abs=1e-6)  # the law is the swing's own
    assert found.size == pytest.approx(0.019, rel=1e-3)


def test_stated_errors_hold_under_white_noise():
    rng, z = np.random.default_rng(4), []
    for _ in range(40):
        noisy = swing() + 1e-3 * rng.standard_normal(TIME.size)
        found = fit_first_swing(TIME, noisy, 1e-3, **first_guess())
        z.append((found.t0 - RELEASE_S) / found.stderr)
        assert found.stderr < 0.006  # 1 mm of noise on 20 mm of motion: a fifteenth of a radian
    assert 0.4 < np.sqrt(np.mean(np.square(z))) < 1.4  # 40 draws know their rms to 11 %; the law's share widens it


def test_a_swing_that_is_no_oscillation_is_cut_short_until_it_looks_like_one():
    late = np.maximum(TIME - RELEASE_S, 0.0)
    pendulum_like = 0.02 * np.cos(W * late * (1.0 - 0.05 * (W * late) ** 2 / 9.0))
    found = fit_first_swing(TIME, pendulum_like, 1e-6, **first_guess())
    assert found.t0 == pytest.approx(RELEASE_S, abs=5e-4)
    assert abs(found.t0 - RELEASE_S) < 3.0 * found.stderr


def test_no_swing_is_found_in_a_hold_and_in_a_handful_of_samples():
    assert fit_first_swing(TIME, np.full(TIME.size, 0.02) + 0.1 * TIME, 1e-6, **first_guess()) is None
    few = slice(None, None, 100)
    assert fit_first_swing(TIME[few], swing()[few], 1e-6, **first_guess()) is None


def slow_noise(count, size, seconds, rng, dt=0.004):
    """First-order noise of standard deviation ``size`` and correlation time ``seconds``."""
    memory = np.exp(-dt / seconds)
    white = rng.standard_normal(count + 500) * size * np.sqrt(1.0 - memory**2)
    return lfilter([1.0], [1.0, -memory], white)[500:]


@pytest.mark.parametrize("colour_s", [0.0, 0.005, 0.02, 0.1])
@pytest.mark.parametrize(("body", "x0", "noise"), [(SHORT, 0.008, 1e-3), (SHORT, 0.033, 1e-3), (LONG, 0.03, 1e-3)])
def test_releases_are_found_under_noise_of_an_eighth_of_the_deflection(body, x0, noise, colour_s):
    exact = exact_motion(body, x0, rate_hz=250.0)
    held = 250
    clean = np.concatenate([np.full(held, x0), exact.x])
    time = np.arange(clean.size) / 250.0
    w = np.sqrt(body.k_N_per_m / body.inertia_kg)
    rng = np.random.default_rng(11)
    for _ in range(4):
        noisy = clean + noise * rng.standard_normal(clean.size)
        noisy += slow_noise(clean.size, noise, colour_s, rng) if colour_s else 0.0
        window = find_window(Recording("r", time, {"displacement": noisy}))
        assert window.held
        # noise over deflection is the error in radians of one sample half way; slow noise counts more, for as long
        # as it lasts; the rest is what drag leaves open
        allowed = (5.0 if colour_s < 0.1 else 12.0) * noise / x0 + LAW_SHARE * 0.05
        assert abs(window.release_s - held / 250.0) < allowed / w
