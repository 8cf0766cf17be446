"""The bodies of the misuse campaigns and one recording of each: exact Eq. 15 motions as ordinary sensors see them.

Four rigs: the flume report's bridge section (about 1 and 2 Hz), a light fast body (3.4 Hz), a slow model hull and a
torsion pendulum. The equation is integrated by `experiments.eq15_campaign.motion`, which imports nothing of
undertow. What a campaign consists of and how it is written belongs to `campaigns`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np
import pandas as pd

from experiments.eq15_campaign.motion import Body, Floats, Motion, hold_and_release

GRAVITY_M_PER_S2 = 9.81
WATER_DENSITY_KG_PER_M3 = 1000.0
LOAD_SHARES = (0.49, 0.51)
"""Parts of the spring force k x that the two load cells carry."""

SCATTER = {"k": 0.003, "c": 0.06, "mu": 0.05}
"""Relative standard deviation from trial to trial, as in the eq15 campaign."""


@dataclass(frozen=True)
class Water:
    """One water level: added mass (kg), drag coefficient, its area (m2) and the displaced volume (m3)."""

    added_mass_kg: float = 0.0
    drag_coefficient: float = 0.0
    area_m2: float = 0.0
    volume_m3: float = 0.0


@dataclass(frozen=True)
class Rig:
    """A body on springs, in air and in water, and its sensors.

    In rotation the same attributes hold inertia (kg m2), moments (N m) and angles (rad).

    Attributes
    ----------
    mass_kg : all that moves when dry.
    stiffness_N_per_m : by spring.
    c_Ns_per_m : viscous damping of the dry body.
    mu : friction coefficient on the weight less the buoyancy.
    levels : water by depth (m); the dry one is the first.
    releases_m : intended release amplitudes, by spring.
    rate_hz, hold_s, motion_s : sampling rate, time held before the release, time recorded after it.
    noise : standard deviation of each column's white noise, in SI units.
    """

    mass_kg: float
    stiffness_N_per_m: Mapping[str, float]
    c_Ns_per_m: float
    mu: float
    levels: Mapping[float, Water]
    releases_m: Mapping[str, tuple[float, ...]]
    rate_hz: float
    hold_s: float
    motion_s: float
    noise: Mapping[str, float]

    @property
    def dry_depth_m(self) -> float:
        """The depth at which the body hangs in air, m."""
        return next(iter(self.levels))


@dataclass(frozen=True)
class Release:
    """One release: what is done, and what differs from the rig as designed.

    Attributes
    ----------
    spring, depth_m, x0_m : spring, water depth and amplitude intended.
    seed : of this trial's scatter and noise.
    c_factor : times the rig's damping.
    hardening_per_m2 : cubic stiffness over stiffness: spring force k x (1 + hardening x^2).
    hold_s, motion_s, rate_hz : where they differ from the rig's.
    """

    spring: str
    depth_m: float
    x0_m: float
    seed: int
    c_factor: float = 1.0
    hardening_per_m2: float = 0.0
    hold_s: float | None = None
    motion_s: float | None = None
    rate_hz: float | None = None


@dataclass(frozen=True)
class HardeningBody(Body):
    """Eq. 15 with a cubic spring beside the straight one: k x + cubic x^3."""

    cubic_N_per_m3: float = field(default=0.0)

    def acceleration(self, x, v, direction):  # type: ignore[no-untyped-def]
        """Acceleration x'' (m/s2) while the body moves with sign(x') = `direction`."""
        return super().acceleration(x, v, direction) - self.cubic_N_per_m3 * x**3 / self.inertia_kg


BRIDGE = Rig(
    mass_kg=2637.4,
    stiffness_N_per_m={"long": 109_592.0, "short": 402_036.0},
    c_Ns_per_m=590.0,
    mu=0.0072,
    levels={
        1.63: Water(),
        2.29: Water(717.8, 3.93, 0.97, 0.185),
        2.36: Water(1079.4, 8.0, 0.97, 0.2775),
    },
    releases_m={"long": (0.05, 0.107, 0.08, 0.064), "short": (0.02, 0.04, 0.03, 0.025)},
    rate_hz=100.0,
    hold_s=0.8,
    motion_s=9.0,
    noise={"x": 5e-5, "v": 2e-3, "a": 0.05, "force": 3.0},
)
"""The report's model bridge; added mass and drag of the long spring (Table 4) serve both springs."""

FAST = Rig(
    mass_kg=12.0,
    stiffness_N_per_m={"long": 12.0 * (2.0 * math.pi * 3.4) ** 2},
    c_Ns_per_m=4.0,
    mu=0.006,
    levels={0.5: Water(), 1.2: Water(3.0, 2.0, 0.03, 0.002)},
    releases_m={"long": (0.02, 0.04, 0.03, 0.025)},
    rate_hz=250.0,
    hold_s=0.13,
    motion_s=3.5,
    noise={"x": 2e-5, "v": 1e-3, "a": 0.05, "force": 0.2},
)
"""A light body of 3.4 Hz, let go after 0.13 s: less than half a period."""

PENDULUM = Rig(
    mass_kg=0.50,
    stiffness_N_per_m={"long": 0.50 * (2.0 * math.pi * 0.9) ** 2},
    c_Ns_per_m=0.11,
    mu=0.0,
    levels={0.0: Water()},
    releases_m={"long": (0.15, 0.35, 0.25)},
    rate_hz=100.0,
    hold_s=0.6,
    motion_s=10.0,
    noise={"x": 2e-4, "v": 2e-3, "a": 0.02, "force": 0.005},
)
"""A torsion pendulum of 0.9 Hz, inertia 0.50 kg m2, damping 2 %: an angle, its rate, no water."""

HULL = Rig(
    mass_kg=40.0,
    stiffness_N_per_m={"long": 40.0 * (2.0 * math.pi * 0.2) ** 2},
    c_Ns_per_m=1.0,
    mu=0.0,
    levels={0.0: Water(drag_coefficient=0.08, area_m2=1.0)},
    releases_m={"long": (0.35,)},
    rate_hz=20.0,
    hold_s=3.0,
    motion_s=60.0,
    noise={"x": 2e-4, "v": 2e-3, "a": 0.02, "force": 0.005},
)
"""A model hull that rolls at 0.2 Hz with quadratic damping."""


@cache
def record(rig_name: str, release: Release) -> pd.DataFrame:
    """One recording, a row a sample, SI units: t, x, v, a and the two load cells lc1, lc2. Not to be edited: copy it.

    The body is held at x0 until the release; k, c and mu are drawn about the rig's, the amplitude within 2 %.
    """
    rig = RIGS[rig_name]
    rng = np.random.default_rng([15, release.seed])
    k, c, mu = (
        mean * (1.0 + SCATTER[name] * rng.standard_normal())
        for name, mean in (
            ("k", rig.stiffness_N_per_m[release.spring]),
            ("c", rig.c_Ns_per_m * release.c_factor),
            ("mu", rig.mu),
        )
    )
    water = rig.levels[release.depth_m]
    normal_N = (rig.mass_kg - water.volume_m3 * WATER_DENSITY_KG_PER_M3) * GRAVITY_M_PER_S2
    body = HardeningBody(
        inertia_kg=rig.mass_kg + water.added_mass_kg,
        c_Ns_per_m=c,
        k_N_per_m=k,
        friction_N=mu * normal_N,
        drag_Ns2_per_m2=0.5 * water.drag_coefficient * WATER_DENSITY_KG_PER_M3 * water.area_m2,
        cubic_N_per_m3=k * release.hardening_per_m2,
    )
    x0 = release.x0_m * (1.0 + rng.uniform(-0.02, 0.02))
    hold = (rig.hold_s if release.hold_s is None else release.hold_s) * rng.uniform(0.95, 1.05)
    times = _times(rig, release, hold)
    motion = hold_and_release(body, x0, times - hold)
    force = k * motion.x * (1.0 + release.hardening_per_m2 * motion.x * motion.x)
    return _sensed(rig, rng, times, motion, force)


def _times(rig: Rig, release: Release, hold_s: float) -> Floats:
    """Time stamps of a record, s from 0."""
    rate = release.rate_hz or rig.rate_hz
    return np.arange(round((hold_s + (release.motion_s or rig.motion_s)) * rate)) / rate


def _sensed(
    rig: Rig, rng: np.random.Generator, times: Floats, motion: Motion, force: Floats
) -> pd.DataFrame:
    """The columns, each with its sensor's noise."""
    left, right = (share * force for share in LOAD_SHARES)
    quantities = {"x": motion.x, "v": motion.v, "a": motion.a, "lc1": left, "lc2": right}
    table = pd.DataFrame({"t": times})
    for column, quantity in quantities.items():
        noise = rig.noise["force" if column.startswith("lc") else column]
        table[column] = quantity + noise * rng.standard_normal(times.size)
    return table


RIGS = {"bridge": BRIDGE, "fast": FAST, "pendulum": PENDULUM, "hull": HULL}
