"""Sensitivities by a coefficient that is 0: a search that starts without a law must see where it would lead."""

from __future__ import annotations

import numpy as np
import pytest

from undertow.equation.kernel import N_SLOTS, SLOT, SLOTS, integrate

TIMES_S = np.linspace(0.0, 8.0, 400)
STEP_S = 0.005

KINKED = {"q": 1e-4, "fc": 1e-6, "fn": 1e-5, "ka": 1e-3, "fs": 1e-6, "cp": 1e-4}
"""Slots whose law turns or bends where the motion reverses or passes its rest position, with a small step, SI."""


def _theta() -> np.ndarray:
    """A lightly damped oscillator at 0.87 Hz, 14 mm wide, and inner parameters for laws that are switched off."""
    theta = np.zeros(N_SLOTS)
    for slot, value in {"mass": 1.0, "k1": 30.0, "c1": 0.34, "x0": -0.0142, "v0": 0.0095, "p": 1.7, "vs": 0.05}.items():
        theta[SLOT[slot]] = value
    return theta


@pytest.mark.parametrize("slot", [s for s in KINKED if s in SLOTS])
def test_sensitivity_by_a_coefficient_of_zero_is_that_of_a_tiny_one(slot):
    active = np.array([SLOT[slot]])
    at_zero, tiny = _theta(), _theta()
    tiny[SLOT[slot]] = KINKED[slot]
    none, some = (integrate(theta, active, TIMES_S, STEP_S)[0] for theta in (at_zero, tiny))
    difference = (some[:, 0] - none[:, 0]) / KINKED[slot]
    # one-sided difference: off by half the second derivative times the step, and by sticking near the end for friction
    assert np.max(np.abs(none[:, 1] - difference)) < 2e-3 * np.max(np.abs(difference))
