"""Truths that structure studies plant: Eq. 15 of the flume report, and equations that are not Eq. 15.

Each is a level of the recovery study with one law changed, integrated by the Eq. 15 campaign's own integrator (scipy
alone), so that nothing of undertow makes the truth. Recordings and what is found in them stand elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.motion import Body, Value
from experiments.recovery.releases import Truth, plant

EQ15_NAMES = frozenset({"stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag"})
STRIBECK_SHARE = 0.5
"""Static friction beyond the Coulomb force, as a share of it."""

STRIBECK_M_PER_S = 0.03


DRY_WEIGHT_N = tables.STRUCTURE_MASS_KG * tables.GRAVITY_M_PER_S2


@dataclass(frozen=True)
class OtherBody(Body):
    """Eq. 15 with a cubic spring, a drag d |v|^p sign(v) besides q v|v|, and static friction."""

    k3_N_per_m3: float = 0.0
    power_N: float = 0.0
    exponent: float = 3.0
    static_N: float = 0.0
    stribeck_m_per_s: float = STRIBECK_M_PER_S

    def acceleration(self, x: Value, v: Value, direction: float) -> Value:
        """x'' in m/s2 while the body moves with sign(v) = ``direction``."""
        force = self.k3_N_per_m3 * x**3 + self.power_N * direction * np.abs(v) ** self.exponent
        force = force + self.static_N * direction * np.exp(-((v / self.stribeck_m_per_s) ** 2))
        rest: Value = super().acceleration(x, v, direction) - force / self.inertia_kg
        return rest

    def sticks(self, x: float) -> bool:
        """Whether the body at rest at x (m) stays there."""
        return abs(self.k_N_per_m * x + self.k3_N_per_m3 * x**3) <= self.friction_N + self.static_N


@dataclass(frozen=True)
class OtherTruth(Truth):
    """One level with one law changed; ``kind`` is a key of `KINDS`."""

    kind: str = "eq15"

    @property
    def body(self) -> Body:
        """The equation for the integrator."""
        plain = super().body
        own = (plain.inertia_kg, plain.c_Ns_per_m, plain.k_N_per_m)
        friction, drag = plain.friction_N, plain.drag_Ns2_per_m2
        largest = max(tables.RELEASES_M[self.spring])
        speed = largest * np.sqrt(plain.k_N_per_m / plain.inertia_kg)
        peak_drag = drag * speed**2
        if self.kind == "no_friction":
            return OtherBody(*own, 0.0, drag)
        if self.kind in ("cubic_2", "cubic_10"):
            share = 0.02 if self.kind == "cubic_2" else 0.10
            return OtherBody(*own, friction, drag, k3_N_per_m3=share * plain.k_N_per_m / largest**2)
        if self.kind in ("v3", "drag_1.5"):
            exponent = 3.0 if self.kind == "v3" else 1.5
            return OtherBody(*own, friction, 0.0, power_N=peak_drag / speed**exponent, exponent=exponent)
        if self.kind == "dry":
            return OtherBody(tables.STRUCTURE_MASS_KG, *own[1:], self.mu * DRY_WEIGHT_N, 0.0)
        if self.kind == "stribeck":
            return OtherBody(*own, friction, drag, static_N=STRIBECK_SHARE * friction)
        return plain


KINDS: dict[str, frozenset[str]] = {
    "eq15": EQ15_NAMES,
    "no_friction": EQ15_NAMES - {"coulomb_friction"},
    "cubic_2": EQ15_NAMES | {"cubic_stiffness"},
    "cubic_10": EQ15_NAMES | {"cubic_stiffness"},
    "v3": EQ15_NAMES - {"quadratic_drag"} | {"cubic_damping"},
    "drag_1.5": EQ15_NAMES - {"quadratic_drag"} | {"drag_exponent"},
    "stribeck": EQ15_NAMES | {"stribeck_friction"},
    "dry": EQ15_NAMES - {"quadratic_drag"},
}
"""Truths by name, with the terms they are made of. A law that takes the drag's place has its force at the largest
speed; a cubic spring has 2 or 10 % of the linear force at the largest release; dry is the same spring without water."""


def plant_other(spring: str, water_depth_m: float, kind: str) -> OtherTruth:
    """The truth of one level with one law changed; KeyError for a kind that is not in `KINDS`."""
    if kind not in KINDS:
        raise KeyError(f"no truth is called {kind!r}; there are {', '.join(KINDS)}")
    return OtherTruth(**vars(plant(spring, water_depth_m)), kind=kind)
