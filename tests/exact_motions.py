"""Motions of Eq. 15 as a perfect conditioning would give them, beside their truth: for tests of regressions.

Integrated by the Eq. 15 campaign's own integrator (scipy's DOP853 split at reversals), nothing of undertow.
"""

from __future__ import annotations

import numpy as np

from experiments.eq15_campaign.motion import Body, simulate
from undertow.conditioning.motion import Motion, Window
from undertow.quantities import Estimate
from undertow.recording.recording import Recording

HOLD_S = 1.0
START_S = 0.1
MOVING_SHARE = 0.9


def exact_motion(
    body: Body,
    x0_m: float,
    name: str = "r1",
    rate_hz: float = 1000.0,
    duration_s: float = 12.0,
    a_noise: float = 0.0,
    offset_m: float = 0.0,
    a_offset: float = 0.0,
    force_noise: float = 0.0,
    force_offset_N: float = 0.0,
    k_cells_N_per_m: float | None = None,
    seed: int = 0,
) -> Motion:
    """x, v, a of a release at ``x0_m``; white noise on a, offsets of the sensors, load cells that see k (x - rest)."""
    rng = np.random.default_rng(seed)
    held = round(HOLD_S * rate_hz)
    time = np.arange(held + round(duration_s * rate_hz)) / rate_hz
    since = np.arange(round(duration_s * rate_hz)) / rate_hz
    moved = simulate(body, x0_m, since)
    a = moved.a + a_offset + a_noise * rng.standard_normal(since.size)
    x = moved.x + offset_m
    spring = (body.k_N_per_m if k_cells_N_per_m is None else k_cells_N_per_m) * moved.x + force_offset_N
    spring = np.concatenate([np.full(held, spring[0]), spring])
    channels = {
        "displacement": np.concatenate([np.full(held, x[0]), x]),
        "acceleration": np.concatenate([a_offset + a_noise * rng.standard_normal(held), a]),
        "spring_force": spring + force_noise * rng.standard_normal(spring.size),
    }
    end = MOVING_SHARE * (duration_s if moved.stopped_s is None else moved.stopped_s)
    return Motion(
        recording=Recording(name, time, channels),
        window=Window(HOLD_S, HOLD_S + START_S, HOLD_S + end, held=True),
        t=since, x=x, v=moved.v, a=a,
        x_std=np.full_like(x, 1e-6), v_std=np.full_like(x, 1e-5), a_std=np.full_like(x, max(a_noise, 1e-6)),
        inside=(since >= START_S) & (since <= end),
        equilibrium=Estimate(offset_m, 1e-6, unit="m"),
        amplitude=abs(x0_m),
        noise={"acceleration": a_noise, "displacement": 0.0, "spring_force": force_noise},
    )  # fmt: skip


LONG = Body(inertia_kg=3908.8, c_Ns_per_m=590.0, k_N_per_m=109592.0, friction_N=170.0, drag_Ns2_per_m2=3924.0)
SHORT = Body(inertia_kg=2936.4, c_Ns_per_m=810.0, k_N_per_m=402036.0, friction_N=150.0, drag_Ns2_per_m2=3880.0)
RELEASES_M = (0.018, 0.030, 0.064, 0.107)


def exact_group(body: Body = LONG, releases_m: tuple[float, ...] = RELEASES_M, **sensors: float) -> list[Motion]:
    """One motion a release, named r0, r1, ..., each with noise of its own."""
    seed = int(sensors.pop("seed", 0))
    return [
        exact_motion(body, x0, name=f"r{index}", seed=1000 * seed + index, **sensors)
        for index, x0 in enumerate(releases_m)
    ]
