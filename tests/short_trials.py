"""Recordings of planted equations at a low rate, beside their truth: light enough for tests of whole chains.

Integrated by the Eq. 15 campaign's own integrator; sensors add white noise and an offset.
"""

from __future__ import annotations

import numpy as np

from experiments.eq15_campaign.motion import Body, simulate
from experiments.structure.truths import OtherBody
from undertow.recording.recording import Recording

RATE_HZ = 200.0
HOLD_S = 0.5
LONG = OtherBody(3908.8, 590.0, 109592.0, 170.0, 3924.0)
RELEASES_M = (0.03, 0.06, 0.1)
NOISE = (2e-4, 0.1)
"""Of displacement (m) and acceleration (m/s^2)."""


def released(
    body: Body, x0_m: float, name: str, seed: int, duration_s: float = 8.0, channels: tuple[str, ...] = ("x", "a")
) -> Recording:
    """One release held for half a second, with the channels x (displacement) and a (acceleration) wanted."""
    rng = np.random.default_rng(seed)
    held, after = round(HOLD_S * RATE_HZ), round(duration_s * RATE_HZ)
    moved = simulate(body, x0_m, np.arange(after) / RATE_HZ)
    time = np.arange(held + after) / RATE_HZ
    x = np.concatenate([np.full(held, x0_m), moved.x]) + 0.001 + NOISE[0] * rng.standard_normal(time.size)
    a = np.concatenate([np.zeros(held), moved.a]) + 0.05 + NOISE[1] * rng.standard_normal(time.size)
    seen = {"x": ("displacement", x), "a": ("acceleration", a)}
    return Recording(name, time, {seen[channel][0]: seen[channel][1] for channel in channels})


def group(body: Body = LONG, seed: int = 0, **settings: object) -> list[Recording]:
    """One recording a release, of unequal length, named r0, r1, ..."""
    return [
        released(body, x0, f"r{index}", 100 * seed + index, 8.0 - index, **settings)
        for index, x0 in enumerate(RELEASES_M)
    ]


def per_mass(body: Body) -> np.ndarray:
    """k, c, friction and drag over mass (4,)."""
    return np.array([body.k_N_per_m, body.c_Ns_per_m, body.friction_N, body.drag_Ns2_per_m2]) / body.inertia_kg
