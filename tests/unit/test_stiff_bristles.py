"""Bristles that follow the motion much faster than it swings: stable steps, and dry friction in the end."""

from __future__ import annotations

import numpy as np
import pytest

from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.simulate import MOST_STIFF, fastest_frequency
from undertow.likelihood.output_error import trajectory

TIMES = np.arange(0.0, 3.0, 0.01)
NONE = np.zeros(0, dtype=np.int64)


def body(**numbers: float) -> np.ndarray:
    """A body of 2637 kg on 402 kN/m, let go at 33 mm."""
    theta = np.zeros(N_SLOTS)
    for slot, value in ({"mass": 2637.0, "k1": 402e3, "c1": 800.0, "x0": 0.033} | numbers).items():
        theta[SLOT[slot]] = value
    return theta


def test_bristles_that_hardly_bend_swing_like_dry_friction():
    bristles = trajectory(body(kb=43e3, fb=6.0), NONE, TIMES)[0][:, 0]
    sliding = trajectory(body(fc=6.0), NONE, TIMES)[0][:, 0]
    assert np.max(np.abs(bristles - sliding)) < 2e-4  # 4 F / k is 6e-5 m a cycle, the bristles bend by 1.4e-4


@pytest.mark.parametrize("steps", [12, 40])
def test_steps_are_short_enough_for_bristles_to_be_stable(steps):
    coarse = trajectory(body(kb=43e3, fb=20.0), NONE, TIMES, steps)[0][:, 0]
    fine = trajectory(body(kb=43e3, fb=20.0), NONE, TIMES, 200)[0][:, 0]
    assert np.max(np.abs(coarse - fine)) < 1e-5


def test_steps_do_not_shorten_without_end():
    own = fastest_frequency(body(kb=43e3))
    assert fastest_frequency(body(kb=43e3, fb=6.0)) > 5.0 * own
    assert fastest_frequency(body(kb=43e3, fb=1e-6)) == pytest.approx(MOST_STIFF * own)
