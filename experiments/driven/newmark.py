"""`python -m experiments driven.newmark`: what the integrator of the Bouc-Wen benchmark does to the mass that is found.

The benchmark's authors integrate with Newmark's constant mean acceleration at 15 kHz. Motions made so under the first
8,192 forces of the training record, at that rate and at four times it, with hardly any noise, are fitted here; the
truth is their body.

Belongs here: that motion, those fits. Does not belong here: the fit (methods/driven.py), the record (../shared/driven).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from numba import njit
from scipy.signal import resample

import undertow

RECORD = Path(__file__).resolve().parents[3] / "shared" / "driven" / "bouc_wen_train.csv.gz"
RATE_HZ, SAMPLES, SETTLED = 750.0, 8192, 400
STEPS = (20, 80)
"""Steps a sample: 15 kHz, and a quarter of its step."""
NOISE_M = 1e-7
EQUATION = ("stiffness", "viscous_damping", "bouc_wen")
STARTS = {"bouc_wen.alpha_N_per_m": 5e4, "bouc_wen.loop": 800.0, "bouc_wen.skew": -1100.0}


@njit
def newmark(force: np.ndarray, step: float) -> np.ndarray:
    """Displacement (n,) of the benchmark's body under a force (n,), from rest; z by the trapezoidal rule."""
    m, c, k, alpha, loop, skew = 2.0, 10.0, 5e4, 5e4, 800.0, -1100.0
    out = np.zeros(force.size)
    x, v, z, a = 0.0, 0.0, 0.0, force[0] / m
    for i in range(1, force.size):
        new, slope = a, alpha * v - loop * abs(v) * z - skew * v * abs(z)
        for _ in range(50):
            v1 = v + 0.5 * step * (a + new)
            x1 = x + step * v + 0.25 * step * step * (a + new)
            z1 = z + step * slope
            for _ in range(20):
                z1 = z + 0.5 * step * (slope + alpha * v1 - loop * abs(v1) * z1 - skew * v1 * abs(z1))
            left = new - (force[i] - c * v1 - k * x1 - z1) / m
            new -= left / (1.0 + (0.5 * c * step + 0.25 * (k + alpha) * step * step) / m)
            if abs(left) < 1e-11:
                break
        x, v, z, a = x1, v1, z1, new
        out[i] = x
    return out


def main() -> None:
    """Both motions and the numbers that are found from them."""
    force = pd.read_csv(RECORD)["force_N"].to_numpy()[:SAMPLES]
    t, part = np.arange(SAMPLES) / RATE_HZ, slice(SETTLED, SAMPLES)
    noise = NOISE_M * np.random.default_rng(0).standard_normal(SAMPLES)
    for steps in STEPS:
        x = newmark(resample(force, SAMPLES * steps), 1.0 / (RATE_HZ * steps))[::steps] + noise
        found = undertow.fit_driven(
            x[part], t=t[part], u=force[part], equation=EQUATION, hold="band_limited", starts=STARTS,
            held={"bouc_wen.exponent": 1.0},
        )  # fmt: skip
        said = ", ".join(f"{name} {one.value:.6g}" for name, one in found.numbers.items())
        print(f"{RATE_HZ * steps / 1e3:g} kHz: {said}", flush=True)
