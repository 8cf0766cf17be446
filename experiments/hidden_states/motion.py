"""A body with friction, drag and hidden states: the truth behind the study's recordings.

    M x'' + c x' + k x + k3 x^3 + F(sign x') + D |x'|^p sign(x') + z = sum_i m_i (2 zeta_i w_i s_i' + w_i^2 s_i)
    s_i'' + 2 zeta_i w_i s_i' + w_i^2 s_i = -x'',        z' = k_r x' - z / tau

M is the inertia that moves with the body (structure and added mass, without the m_i). Friction may differ between the
two directions. The blind challenge's integrator moves it, so that nothing of undertow makes the truth; parameters,
sensors and seeds stand elsewhere (campaigns.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.motion import Body, Law, resonator
from experiments.blind_challenge.truths.motion import simulate as march

Floats = NDArray[np.float64]
TOLERANCE = 1e-12


@dataclass(frozen=True)
class Oscillator:
    """A hidden mass: ``mass_kg``, ``w`` (rad/s, body held) and damping ratio ``zeta``."""

    mass_kg: float
    w: float
    zeta: float


@dataclass(frozen=True)
class Plant:
    """Parameters of one body; SI units. ``friction_N`` is the mean of both directions, ``asymmetry_N`` half their
    difference; ``drag`` belongs to |x'|^exponent; ``maxwell`` is (k_r in N/m, tau in s), k_r = 0 for none."""

    inertia_kg: float
    c: float
    k: float
    friction_N: float
    drag: float
    exponent: float = 2.0
    k3: float = 0.0
    asymmetry_N: float = 0.0
    maxwell: tuple[float, float] = (0.0, 1.0)
    hidden: tuple[Oscillator, ...] = ()

    def laws(self, x0_m: float) -> tuple[Law, ...]:
        """What is there beside Eq. 15, with states of the size that a release from ``x0_m`` gives."""
        size = abs(x0_m)
        found = [resonator(o.mass_kg, o.w, o.zeta, scale=size) for o in self.hidden]
        found += [Law(codes.STIFF, (0.0, 0.0, self.k3, 0.0))] if self.k3 else []
        found += [Law(codes.ONEWAY, (self.asymmetry_N,))] if self.asymmetry_N else []
        found += [Law(codes.POWER, (self.drag, self.exponent))] if self.exponent != 2.0 else []
        found += [Law(codes.RELAX, self.maxwell, (0.0,), (self.maxwell[0] * size,))] if self.maxwell[0] else []
        return tuple(found)


def simulate(plant: Plant, x0_m: float, times_s: Floats) -> tuple[Floats, Floats]:
    """x (m) and x'' (m/s^2), (n,) each, after a release from rest at ``x0_m``, at even ``times_s`` from 0 on; hidden
    states at rest too."""
    step, late = float(times_s[1] - times_s[0]), float(times_s[0])
    drag = plant.drag if plant.exponent == 2.0 else 0.0
    body = Body(plant.inertia_kg, plant.c, plant.k, plant.friction_N, drag)
    count = times_s.size + (late > 0.0)
    motion = march(body, plant.laws(x0_m), x0_m, count, step, late or None, tolerance=TOLERANCE)
    return motion.x[-times_s.size :], motion.a[-times_s.size :]
