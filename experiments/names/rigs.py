"""The rigs and the plan of a campaign: bodies, springs, water, releases, scatter, without anything hidden.

Belongs here: what a laboratory would build. Does not belong here: what is hidden in it (effects.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from experiments.eq15_campaign import sensors, tables

DRY_DEPTH_M, WET_DEPTH_M = tables.DRY_DEPTH_M, 2.36
GRAVITY_M_PER_S2, WATER_KG_PER_M3 = 9.81, 1000.0

SCATTER: Mapping[str, Mapping[str, float]] = {
    "report": {"k": 0.004, "c": 0.23, "mu": 0.09},
    "careful": {"k": 0.003, "c": 0.06, "mu": 0.05},
}
"""Relative scatter from trial to trial: what 7 and 12 dry trials of one rig gave (report, Tables 1 and 2: c 25 and
20 %, mu 6 and 11 %, k 0.4 %), and that of the Eq. 15 campaign."""


@dataclass(frozen=True)
class Spring:
    """One spring: stiffness, viscous damping, friction coefficient (dry), and the smallest and largest release."""

    k: float
    c: float
    mu: float
    releases: tuple[float, float]


@dataclass(frozen=True)
class Rig:
    """A body on springs in water, SI units (of rotation for a pendulum): moving mass, weight on the rails (kg), drag
    area, displaced volume, ranges from which a campaign's added mass and drag coefficient are drawn, sensors."""

    name: str
    coordinate: str
    mass: float
    area: float
    volume: float
    added: tuple[float, float]
    drag: tuple[float, float]
    springs: Mapping[str, Spring]
    sensors: tuple[sensors.Sensor, ...]

    def normal_force(self, wet: bool) -> float:
        """Weight less buoyancy, N."""
        return (self.mass - (WATER_KG_PER_M3 * self.volume if wet else 0.0)) * GRAVITY_M_PER_S2


    def noisier(self, factor: float) -> Rig:
        """The same rig with sensors whose noise is so many times larger."""
        return replace(self, sensors=tuple(replace(s, noise=factor * s.noise) for s in self.sensors))


def _dry(spring: str) -> tuple[float, float, float]:
    return tables.dry_mean(spring)


FLUME = Rig(
    "flume", "translation", tables.STRUCTURE_MASS_KG, tables.REFERENCE_AREA_M2, tables.submerged_volume(WET_DEPTH_M),
    (250.0, 900.0), (3.0, 9.0),
    {"short": Spring(*_dry("short"), (0.008, 0.033)), "long": Spring(*_dry("long"), (0.018, 0.107))},
    sensors.SENSORS,
)  # fmt: skip
"""The bridge model of the report: its masses, springs and releases; added mass and drag inside its tables' range."""

PENDULUM = Rig(
    "pendulum", "rotation", 12.0, 0.004, 0.0, (1.0, 4.0), (1.0, 3.0),
    {"short": Spring(420.0, 2.2, 0.008, (0.25, 0.9)), "long": Spring(110.0, 1.4, 0.008, (0.25, 0.9))},
    (
        sensors.Sensor("angle_rad", 5e-4, 1e-3, 1e-3, 1.6, 5),
        sensors.Sensor("angular_accel_radps2", 0.1, 0.03, 0.02, 60.0, 4),
    ),
)  # fmt: skip
"""A body that swings through up to half a right angle: where a sine can be distinguished from its first term."""


@dataclass(frozen=True)
class Trial:
    """One release of a campaign: file, spring, wet or dry, intended release, its place in the order of testing."""

    file: str
    spring: str
    wet: bool
    x0: float
    order: int


REPEATED = 500_000_000
"""How far the chances of a repetition are from those of its campaign, as seeds."""


@dataclass(frozen=True)
class Plan:
    """What is tested and how: rig, springs, trials a group, dry trials a spring, rate, seconds, scatter, seed, spread
    (largest over smallest release, at most the rig's own). A ``repetition`` is the same rig in the same water once
    more, with chances of its own."""

    seed: int
    rig: Rig = FLUME
    springs: tuple[str, ...] = ("short", "long")
    wet_trials: int = 4
    dry_trials: int = 4
    rate_hz: float = 250.0
    seconds: float = 12.0
    scatter: str = "careful"
    spread: float = math.inf
    repetition: int = 0
    water: Mapping[str, float] = field(default_factory=dict)

    @property
    def chances(self) -> int:
        """The seed of what differs between repetitions: scatter of trials, releases reached, clocks, noise."""
        return self.seed + REPEATED * self.repetition

    def trials(self) -> tuple[Trial, ...]:
        """All trials, dry ones first, releases in geometric steps from the largest down."""
        out: list[Trial] = []
        for wet in (False, True):
            for spring in self.springs:
                low, high = self.rig.springs[spring].releases
                low = max(low, high / self.spread)
                count = self.wet_trials if wet else self.dry_trials
                for x0 in np.geomspace(high, low, max(count, 1))[:count]:
                    place = len(out)
                    name = f"t{place:02d}_{'wet' if wet else 'dry'}_{spring}.csv"
                    out.append(Trial(name, spring, wet, float(x0), place))
        return tuple(out)

    def waters(self) -> dict[str, float]:
        """Added mass (kg) and drag coefficient of this campaign's water, the same for all springs."""
        rng = np.random.default_rng([self.seed, 1])
        drawn = {"added": rng.uniform(*self.rig.added), "drag": rng.uniform(*self.rig.drag)}
        return drawn | dict(self.water)

    def means(self, trial: Trial) -> dict[str, float]:
        """Numbers of the equation (slots of motion.py) for a trial of this campaign, without scatter."""
        rig, spring, water = self.rig, self.rig.springs[trial.spring], self.waters()
        wet = 1.0 if trial.wet else 0.0
        return {
            "M": rig.mass + wet * water["added"],
            "c": spring.c,
            "k": spring.k,
            "fc": spring.mu * rig.normal_force(trial.wet),
            "q": wet * 0.5 * water["drag"] * WATER_KG_PER_M3 * rig.area,
        }


__all__ = ["DRY_DEPTH_M", "FLUME", "PENDULUM", "SCATTER", "WET_DEPTH_M", "Plan", "Rig", "Spring", "Trial"]
