"""The releases that recovery studies plant: Eq. 15 of the flume report with k, c, mu equal in all trials.

The motion comes from the Eq. 15 campaign's integrator (scipy alone), so that nothing of undertow makes the truth.
What is estimated from the recordings and how the results are tabulated stands elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.motion import Body, Floats, Motion, simulate
from experiments.eq15_campaign.sensors import drift
from undertow.recording.recording import Recording

RATE_HZ = 1000.0
HOLD_S = 1.0
RECORD_AFTER_RELEASE_S = 12.0
CONVERTER_STEPS = 2**14
FULL_SCALE = {"displacement": 0.15, "acceleration": 20.0}
"""Range of the converter, - to +, m and m/s^2."""

LARGEST_DRIFT = {"displacement": 2e-4, "acceleration": 0.02}
LARGEST_OFFSET = {"displacement": 1e-3, "acceleration": 0.1}
NOISE = {"N1": (5e-5, 0.02), "N3": (2e-4, 0.1), "N4": (1e-3, 0.1)}
"""Standard deviations of white noise on x (m) and a (m/s^2)."""


@dataclass(frozen=True)
class Truth:
    """Parameters of Eq. 15 at one level, the same in all trials; SI units."""

    spring: str
    water_depth_m: float
    k_N_per_m: float
    c_Ns_per_m: float
    mu: float
    added_mass_kg: float
    drag_coefficient: float
    normal_force_N: float

    @property
    def body(self) -> Body:
        """The equation for the integrator."""
        drag = 0.5 * tables.WATER_DENSITY_KG_PER_M3 * tables.REFERENCE_AREA_M2 * self.drag_coefficient
        inertia = tables.STRUCTURE_MASS_KG + self.added_mass_kg
        return Body(inertia, self.c_Ns_per_m, self.k_N_per_m, self.mu * self.normal_force_N, drag)

    @property
    def unknowns(self) -> Floats:
        """m_a (kg), c (N s/m), mu, C_d: what is to be recovered, k being known."""
        return np.array([self.added_mass_kg, self.c_Ns_per_m, self.mu, self.drag_coefficient])

    def with_unknowns(self, values: Floats) -> Truth:
        """The same level with other m_a, c, mu, C_d."""
        mass, c, mu, drag = (float(value) for value in values)
        return replace(self, added_mass_kg=mass, c_Ns_per_m=c, mu=mu, drag_coefficient=drag)


def plant(spring: str, water_depth_m: float) -> Truth:
    """Truth of one level: dry means of Tables 1 and 2, m_a and C_d of Tables 4 and 6."""
    k, c, mu = tables.dry_mean(spring)
    buoyancy = tables.submerged_volume(water_depth_m) * tables.WATER_DENSITY_KG_PER_M3
    return Truth(
        spring, water_depth_m, k, c, mu,
        tables.ADDED_MASS_KG[spring][water_depth_m],
        tables.DRAG_COEFFICIENT[spring][water_depth_m],
        (tables.STRUCTURE_MASS_KG - buoyancy) * tables.GRAVITY_M_PER_S2,
    )  # fmt: skip


@lru_cache(maxsize=256)
def _move(truth: Truth, x0_m: float, early_s: float) -> Motion:
    times = early_s + np.arange(round(RECORD_AFTER_RELEASE_S * RATE_HZ)) / RATE_HZ
    return simulate(truth.body, x0_m, times)


def record(truth: Truth, x0_m: float, noise: str, rng: np.random.Generator, name: str) -> Recording:
    """One trial as `seen` says; the release falls anywhere between two samples (to a tenth of a sample)."""
    moved = _move(truth, x0_m, rng.integers(0, 10) / 10.0 / RATE_HZ)
    conditions = {"spring": truth.spring, "water_depth_m": truth.water_depth_m}
    return Recording(name, *seen(x0_m, moved.x, moved.a, noise, rng), conditions)


def seen(
    x0_m: float, x: Floats, a: Floats, noise: str, rng: np.random.Generator, drift_times: float = 1.0
) -> tuple[Floats, dict[str, Floats]]:
    """Time, and what a string potentiometer and an accelerometer make of a hold and a motion: offsets, drift (so many
    times the ordinary one), noise, 14 bits."""
    held = round(HOLD_S * RATE_HZ)
    exact = {
        "displacement": np.concatenate([np.full(held, x0_m), x]), "acceleration": np.concatenate([np.zeros(held), a])
    }  # fmt: skip
    time = np.arange(held + x.size) / RATE_HZ
    channels = {}
    for (quantity, values), size in zip(exact.items(), NOISE[noise], strict=True):
        read = values + rng.uniform(-1.0, 1.0) * LARGEST_OFFSET[quantity]
        read = read + drift(rng, time, drift_times * LARGEST_DRIFT[quantity]) + size * rng.standard_normal(time.size)
        step = 2.0 * FULL_SCALE[quantity] / CONVERTER_STEPS
        channels[quantity] = np.rint(read / step) * step
    return time, channels


def record_group(truth: Truth, noise: str, seed: int) -> list[Recording]:
    """The four releases of a level, everything about the sensors drawn from ``seed``."""
    rng = np.random.default_rng(seed)
    releases = tables.RELEASES_M[truth.spring]
    return [record(truth, x0, noise, rng, f"{truth.spring}-{x0:g}") for x0 in releases]
