"""Numbers of the flume report that the campaign is made from, in SI units, each with its table.

Only published values, plain geometry and the choices made where the report prints nothing belong here.
Two corrections to the print: Tables 1 and 2 head the stiffness column kN/m, its values are N/m.
"""

from __future__ import annotations

import math

STRUCTURE_MASS_KG = 2637.4
"""Moving mass of the model (Table 10)."""

GRAVITY_M_PER_S2 = 9.81
WATER_DENSITY_KG_PER_M3 = 1000.0

REFERENCE_AREA_M2 = 0.97
"""Area that every drag coefficient of the report refers to (Table 10), at each wet level."""

DRY_DEPTH_M = 1.63
WET_DEPTHS_M = (2.22, 2.29, 2.36, 2.43, 2.57)
"""Water depths (Table 3)."""

SPAN_M = 3.45
GIRDER_BOTTOM_M = 2.15
GIRDER_HEIGHT_M = 0.28
SOLID_WIDTH_M = 0.383
"""Concrete in a section across the six girders. Not printed in the report: chosen, about 64 mm a web."""

DRY_C_NS_PER_M = {
    "long": (687, 734, 701, 719, 439, 452, 400),
    "short": (680, 1179, 629, 662, 974, 1061, 839, 756, 730, 735, 857, 748),
}
"""Viscous damping of the dry trials (Tables 1 and 2)."""

DRY_MU = {
    "long": (0.00810, 0.00741, 0.00705, 0.00662, 0.00752, 0.00714, 0.00723),
    "short": (
        *(0.00693, 0.00836, 0.00672, 0.00669, 0.00521, 0.00645),
        *(0.00666, 0.00618, 0.00655, 0.00625, 0.00620, 0.00633),
    ),
}
"""Friction coefficient of the dry trials (Tables 1 and 2)."""

DRY_K_N_PER_M = {
    "long": (109177, 109610, 109085, 109276, 109609, 109788, 110601),
    "short": (
        *(401444, 400152, 398343, 401956, 403422, 401853),
        *(403259, 402509, 401390, 403921, 403720, 402464),
    ),
}
"""Stiffness of the dry trials (Tables 1 and 2; N/m, whatever the printed heading says)."""

ADDED_MASS_KG = {
    "long": {2.22: 322.9, 2.29: 717.8, 2.36: 1079.4, 2.43: 1169.0, 2.57: 1271.4},
    "short": {2.22: 0.0, 2.29: 0.0, 2.36: 299.0, 2.43: 1056.0, 2.57: 1079.0},
}
"""Added mass by water depth (Table 4, long spring; Table 6, short spring, its printed zeros kept)."""

DRAG_COEFFICIENT = {
    "long": {2.22: 1.47, 2.29: 3.93, 2.36: 8.00, 2.43: 8.59, 2.57: 8.09},
    "short": {2.22: 7.98, 2.29: 4.98, 2.36: 8.00, 2.43: 9.71, 2.57: 10.10},
}
"""Drag coefficient by water depth (Table 4, long spring; Table 6, short spring)."""

WATER_IN_CELLS_KG = {2.22: 300.0, 2.29: 669.0, 2.36: 1015.0, 2.43: 1104.0, 2.57: 1104.0}
"""Water standing between the girders (Tables 4 and 6)."""

RELEASES_M = {"long": (0.018, 0.030, 0.064, 0.107), "short": (0.008, 0.016, 0.024, 0.033)}
"""Intended releases, chosen inside the report's range (Tables 5 and 10, long; Tables 2 and 6, short)."""


def dry_mean(spring: str) -> tuple[float, float, float]:
    """Mean k (N/m), c (N s/m) and mu (-) of a spring's dry trials (Tables 1 and 2)."""
    columns = (DRY_K_N_PER_M[spring], DRY_C_NS_PER_M[spring], DRY_MU[spring])
    k, c, mu = (math.fsum(column) / len(column) for column in columns)
    return k, c, mu


def wetted_height(water_depth_m: float) -> float:
    """Height of girder below the water, m: H - 2.15 m, between 0 and the girder's 0.28 m."""
    return min(max(water_depth_m - GIRDER_BOTTOM_M, 0.0), GIRDER_HEIGHT_M)


def submerged_volume(water_depth_m: float) -> float:
    """Volume of submerged concrete, m3: V = span * solid width * wetted height.

    The report does not print V. With 3.45 m and 0.383 m it is 0.0925 m3 for each 0.07 m of wetted girder
    up to 0.28 m and stays there; the deck above is not counted. Rounded to 1e-4 m3.
    """
    return round(SPAN_M * SOLID_WIDTH_M * wetted_height(water_depth_m), 4)
