"""The bridge as a structure: mass, spring, dry losses and quadratic drag; nominal values and their scatter.

    (m + A_inf) x'' = -k x - c x' - q x'|x'| - mu N sgn(x') + F_memory,     |friction| <= mu N at rest

Sources: k, c and mu are the dry means of the physical test's Tables 1 and 2 (k of the springs as its text
states them); their scatter from trial to trial is the sample standard deviation of those tables' columns,
except k's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.virtual_flume.frequency import DENSITY, GRAVITY
from experiments.virtual_flume.section import Level

MASS_KG = 2637.4
DRAG_COEFFICIENT = (
    2.0  # a flat plate normal to a steady stream (Hoerner 1965); nominal, the same at every level
)
STIFFNESS_SCATTER = 0.003  # relative, one sigma; Table 1: load / x0 is steadier still, the fitted k scatters by 0.4 %

# fitted dry values, one a trial: N s/m and -
TABLE_1_C = (687.0, 734.0, 701.0, 719.0, 439.0, 452.0, 400.0)
TABLE_1_MU = (0.00810, 0.00741, 0.00705, 0.00662, 0.00752, 0.00714, 0.00723)
TABLE_2_C = (680.0, 1179.0, 629.0, 662.0, 974.0, 1061.0, 839.0, 756.0, 730.0, 735.0, 857.0, 748.0)
TABLE_2_MU = (
    0.00693, 0.00836, 0.00672, 0.00669, 0.00521, 0.00645, 0.00666, 0.00618, 0.00655, 0.00625, 0.00620,
    0.00633,
)  # fmt: skip


@dataclass(frozen=True)
class SpringSet:
    """Nominal `stiffness` N/m, `damping` N s/m, `friction` -, and the last two's relative scatter."""

    stiffness: float
    damping: float
    friction: float
    damping_scatter: float
    friction_scatter: float


def _spring(stiffness: float, c: tuple[float, ...], mu: tuple[float, ...]) -> SpringSet:
    return SpringSet(
        stiffness,
        float(np.mean(c)),
        float(np.mean(mu)),
        float(np.std(c, ddof=1) / np.mean(c)),
        float(np.std(mu, ddof=1) / np.mean(mu)),
    )


SPRINGS = {
    "long": _spring(109_600.0, TABLE_1_C, TABLE_1_MU),
    "short": _spring(403_000.0, TABLE_2_C, TABLE_2_MU),
}


@dataclass(frozen=True)
class Structure:
    """A trial's `mass` kg, `stiffness` N/m, `damping` N s/m, `drag` q N s2/m2, `friction_force` N."""

    mass: float
    stiffness: float
    damping: float
    drag: float
    friction_force: float


def normal_force(level: Level) -> float:
    """Weight less buoyancy, what the bearings carry; N."""
    return MASS_KG * GRAVITY - DENSITY * GRAVITY * level.submerged_volume_m3


def drag_factor(level: Level) -> float:
    """q = rho Cd A / 2; N s2/m2."""
    return 0.5 * DENSITY * DRAG_COEFFICIENT * level.reference_area_m2


def structure(level: Level, stiffness: float, damping: float, friction: float) -> Structure:
    """The structure at a level for one trial's spring (N/m), damping (N s/m) and friction coefficient."""
    return Structure(MASS_KG, stiffness, damping, drag_factor(level), friction * normal_force(level))
