"""Losses and units of the flume's water at a level: what turns bare operators into the water of a trial.

The sponge absorbs what the body radiates. In the cells stands only what laminar Stokes layers on the
girders' webs take.
"""

from __future__ import annotations

import numpy as np

from experiments.virtual_flume import mesh, section
from experiments.virtual_flume.frequency import DENSITY, GRAVITY, Water
from experiments.virtual_flume.laplace import WaterOperators, water_operators

Array = np.ndarray

VISCOSITY = 1.0e-6  # m2/s, water near 20 degrees Celsius
SPONGE_RATE = 6.0  # 1/s at the far end, quadratic from nothing; moved and doubled in results/convergence.md
RAIL_HEIGHT_M = 2.60  # above the floor; nominal: springs, friction and vertical load cells act on this line


def stokes_layer_rate(width_m: float) -> float:
    """Decay rate (1/s) of the first slosh in deep water between two walls with laminar layers.

    zeta = sqrt(nu / (2 w)) / width with w^2 = g pi / width: the layers dissipate rho/2 sqrt(nu w / 2) U^2 an area
    (Keulegan 1959, doi:10.1017/S0022112059000489), the wave holds rho k width / 4 a length.

    >>> 0.005 < stokes_layer_rate(0.334) < 0.008
    True
    """
    w = np.sqrt(GRAVITY * np.pi / width_m)
    return float(np.sqrt(0.5 * VISCOSITY * w) / width_m)


def surface_loss(x: Array, level: section.Level, spacing: mesh.Spacing, in_cells: bool = True) -> Array:
    """Loss n(x) at the surface nodes; 1/s."""
    edge = section.deck_half_width_m()
    start = edge + spacing.open_water_m
    loss = SPONGE_RATE * np.clip((x - start) / spacing.sponge_m, 0.0, 1.0) ** 2
    if in_cells and level.cells_have_surface:
        loss[x < edge - 0.5 * section.WEB_M] = stokes_layer_rate(level.surface_width_m)
    return loss


def flume_water(depth_m: float, spacing: mesh.Spacing | None = None, lossless: bool = False) -> Water:
    """Water of the flume at a level; `lossless`: no sponge, no layers, so that the far end reflects."""
    spacing = spacing or mesh.Spacing()
    operators = water_operators(mesh.flume(depth_m, spacing), RAIL_HEIGHT_M)
    loss = surface_loss(operators.x, section.Level(depth_m), spacing)
    return Water(operators, np.zeros_like(loss) if lossless else loss, 2.0 * DENSITY * section.SPAN_M)


def closed_cells(width_m: float, depth_m: float, length_m: float, refine: float = 1.0) -> Water:
    """Water in closed rectangular cells of a total length, without losses."""
    operators: WaterOperators = water_operators(
        mesh.rectangular_tank(width_m, depth_m, refine), far_wall_moves=True
    )
    return Water(operators, np.zeros_like(operators.x), 2.0 * DENSITY * length_m)
