"""A harmonic set with a known truth: a hardening body swept up and down under a stepped sine.

    python -m experiments harmonic_set [FOLDER]        # default data/harmonic_set

Nothing of undertow stands in it: the motion is integrated by DOP853, the body goes on from one frequency to the next,
and amplitude and phase are those of the last of its periods at the drive's frequency, with noise on both parts alike.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

MASS_KG, STIFFNESS_N_PER_M, DAMPING_NS_PER_M, CUBIC_N_PER_M3 = 2.0, 50.0, 0.6, 400.0
FORCE_N, NOISE_M = 1.0, 3e-4
FREQUENCIES_HZ = np.round(np.linspace(0.55, 1.2, 33), 4)
SETTLING_PERIODS, SAMPLES = 60, 256
SEED = 11


def swept(frequencies: np.ndarray) -> list[complex]:
    """C - i S of x = C cos(w t) + S sin(w t) at one frequency after the other, the body going on from the last."""
    out, state = [], np.zeros(2)
    for f in frequencies:
        w, period = 2.0 * math.pi * f, 1.0 / f

        def slope(t, y, w=w):
            force = FORCE_N * math.cos(w * t) - DAMPING_NS_PER_M * y[1]
            return [y[1], (force - STIFFNESS_N_PER_M * y[0] - CUBIC_N_PER_M3 * y[0] ** 3) / MASS_KG]

        end = SETTLING_PERIODS * period
        times = np.linspace(end - period, end, SAMPLES, endpoint=False)
        found = solve_ivp(slope, (0.0, end), state, "DOP853", [*times, end], rtol=1e-9, atol=1e-11)
        out.append(complex(np.mean(found.y[0, :-1] * np.exp(-1j * w * times)) * 2.0))
        state = found.y[:, -1]
    return out


def main(folder: Path | None = None) -> None:
    """Write both sweeps and the truth."""
    if folder is None:
        folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("data") / "harmonic_set"
    rng = np.random.default_rng(SEED)
    for name, frequencies in (("sweep_up", FREQUENCIES_HZ), ("sweep_down", FREQUENCIES_HZ[::-1])):
        noise = NOISE_M * (rng.standard_normal(frequencies.size) + 1j * rng.standard_normal(frequencies.size))
        motion = np.array(swept(frequencies)) + noise
        rows = zip(frequencies, 1e3 * np.abs(motion), -np.degrees(np.angle(motion)), strict=True)
        lines = [f"{f:.4f},{FORCE_N:g},{a:.3f},{lag:.3f}" for f, a, lag in rows]
        text = "\n".join(["frequency_Hz,force_N,amplitude_mm,phase_lag_deg", *lines]) + "\n"
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    truth = {
        "mass_kg": MASS_KG, "stiffness.k_N_per_m": STIFFNESS_N_PER_M, "viscous_damping.c_Ns_per_m": DAMPING_NS_PER_M,
        "cubic_stiffness.N_per_m3": CUBIC_N_PER_M3, "noise_m": NOISE_M,
    }  # fmt: skip
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
