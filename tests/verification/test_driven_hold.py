"""What an input is between its samples is found: the free run is at the noise with the hold that drove the body alone,
and a delay of 2 ms beside it comes back within its error."""

from __future__ import annotations

import numpy as np
import pytest

from undertow import fit_driven
from undertow.equation.driven import driven_motion
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.input import HOLDS, MotionSize, drive_of

TRUTH = {"mass": 2.0, "k1": 5000.0, "c1": 10.0, "gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0}
DELAY_S, STEP_S, NOISE_M = 2e-3, 0.02, 1e-6
"""Six samples a cycle of the resonance of 8 Hz, where a straight line loses 9 % of the force."""


def driven_by(hold, seed):
    """Times, force and displacement of the body under a random force with that hold, felt 2 ms later."""
    rng = np.random.default_rng(seed)
    t = STEP_S * np.arange(3000)
    u = np.convolve(rng.normal(size=t.size + 2), [0.25, 0.5, 0.25], "valid") * 20.0
    theta = np.zeros(N_DRIVEN)
    for name, value in {**TRUTH, "delay": DELAY_S}.items():
        theta[DRIVEN_SLOT[name]] = value
    x = driven_motion(theta, np.zeros(0, dtype=np.int64), drive_of(t, u, hold), t, MotionSize(0.1, 5.0), 60).x[:, 0]
    return t, u, x + NOISE_M * rng.normal(size=t.size)


@pytest.mark.parametrize("truth", HOLDS)
def test_the_hold_that_drove_the_body_leaves_the_noise_and_no_other_does(truth):
    t, u, x = driven_by(truth, 12)
    starts = {"mass_kg": 1.9, "stiffness.k_N_per_m": 4800.0, "viscous_damping.c_Ns_per_m": 11.0, "input_delay_s": 0.0}
    found = {hold: fit_driven(x, t=t, u=u, hold=hold, starts=starts) for hold in HOLDS}
    rms = {hold: one.rms for hold, one in found.items()}
    assert min(rms, key=rms.get) == truth
    assert rms[truth] == pytest.approx(NOISE_M, rel=0.05)
    assert min(value for hold, value in rms.items() if hold != truth) > 3.0 * NOISE_M
    delay = found[truth].numbers["input_delay_s"]
    assert abs(delay.value - DELAY_S) < 4.0 * delay.stderr < 1e-3 * STEP_S
