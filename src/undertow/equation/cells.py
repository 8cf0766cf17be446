"""What water standing in a cell can do, before any fit: its sloshing modes in a closed rectangular cell.

For a tank of width b with water h deep between two walls that sway together (Graham and Rodriguez 1952,
doi:10.1115/1.4010478; Housner 1957; Ibrahim 2005, Liquid Sloshing Dynamics, section 1.2)

    k_n = (2 n - 1) pi / b,   w_n^2 = g k_n tanh(k_n h),   m_n / m = 8 tanh(k_n h) / [(2 n - 1)^3 pi^3 h / b]

and the rest of the water, m - sum m_n, moves with the walls. Only odd modes feel a sway. A cell that is open below
has a stiffer surface: its first mode lies above the closed one's (docs/published_tables.md has both).

Belongs here: closed forms. Does not belong here: identified resonators (discrepancy/), open cells (a solver's work).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from undertow.equation.term import Array
from undertow.errors import UndertowError

GRAVITY_M_PER_S2 = 9.81
"""Standard gravity to the three digits that the recordings deserve, as the report has it (m g in Eqs. 1 and 15)."""

MODES = 8
"""Odd modes that are kept: the eighth holds less than a thousandth of the water."""


@dataclass(frozen=True)
class CellModes:
    """Modes of equal cells together: ``frequencies_rad_per_s`` and ``masses_kg`` (n,), ``rigid_mass_kg``,
    ``water_kg``."""

    frequencies_rad_per_s: Array
    masses_kg: Array
    rigid_mass_kg: float
    water_kg: float


def closed_cell(
    width_m: float, depth_m: float, length_m: float, density_kg_per_m3: float = 1000.0
) -> CellModes:
    """Modes of the water in closed rectangular cells of one width and depth, ``length_m`` long all together.

    UndertowError where a length is not positive.

    >>> modes = closed_cell(0.33, 0.14, 16.5)
    >>> round(float(modes.frequencies_rad_per_s[0]), 2), round(float(modes.masses_kg[0]))
    (9.01, 403)
    """
    for what, value in (("width", width_m), ("depth", depth_m), ("length", length_m)):
        if not (math.isfinite(value) and value > 0.0):
            raise UndertowError(
                f"cell {what} is {value:g} m; it must be positive: measure the still water between walls"
            )
    order = 2.0 * np.arange(1, MODES + 1) - 1.0
    number = order * math.pi / width_m
    tanh = np.tanh(number * depth_m)
    water = density_kg_per_m3 * width_m * depth_m * length_m
    masses = water * 8.0 * tanh / (order**3 * math.pi**3 * depth_m / width_m)
    return CellModes(np.sqrt(GRAVITY_M_PER_S2 * number * tanh), masses, water - float(masses.sum()), water)
