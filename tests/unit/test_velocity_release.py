"""A velocity alone shows its release: it is zero while the body is held. A turning point is no release."""

from __future__ import annotations

import numpy as np
import pytest

from tests.decays import Decay, recorded
from undertow.conditioning.release import find_window


@pytest.mark.parametrize("frequency_hz", [0.05, 1.0, 40.0])
@pytest.mark.parametrize("held", [0.6, 3.0])
@pytest.mark.parametrize("noise", [1e-3, 1e-2])
def test_a_body_set_off_from_a_hold_is_found_within_a_third_of_a_radian(frequency_hz, held, noise):
    decay = Decay(frequency_hz, friction=0.01, noise=noise, held=held, seed=4)
    window = find_window(recorded(decay, ("velocity",)))
    assert window.held
    assert 2.0 * np.pi * (frequency_hz * window.release_s - held) == pytest.approx(0.0, abs=0.3)


@pytest.mark.parametrize("frequency_hz", [0.05, 1.0, 40.0])
@pytest.mark.parametrize("samples", [50.0, 2000.0])
def test_a_record_that_begins_at_a_turning_point_was_not_held(frequency_hz, samples):
    decay = Decay(frequency_hz, samples, friction=0.01, held=0.0, periods=8.0, seed=4)
    window = find_window(recorded(decay, ("velocity",)))
    assert not window.held
    assert window.release_s == pytest.approx(0.0, abs=0.1 / frequency_hz)


def test_a_rest_shorter_than_a_tenth_of_a_period_is_no_hold():
    window = find_window(recorded(Decay(1.0, 400.0, friction=0.01, held=0.06, periods=8.0, seed=4), ("velocity",)))
    assert not window.held
