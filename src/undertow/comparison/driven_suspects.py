"""Which laws may be missing on a driven body: names alone, so that a config can be checked without what fits them.

Belongs here: those names. Does not belong here: how they are tried (driven_search.py).
"""

from __future__ import annotations

from undertow.equation.driven_hysteresis import HYSTERESES

STATIC = (
    "constant_force", "stiffness", "viscous_damping", "coulomb_friction", "asymmetric_stiffness", "cubic_stiffness",
    "quintic_stiffness", "quadratic_stiffness", "quadratic_drag", "cubic_damping", "position_damping",
    "van_der_pol_damping", "variable_normal_force", "asymmetric_damping",
)  # fmt: skip
"""Laws of x and v without inner numbers that may be missing."""
OF_WATER = ("froude_krylov", "added_mass", "linear_damping")
"""Laws that may be missing where the water moves."""
SUSPECTS_IN_TIME = (
    *STATIC, *OF_WATER, "stribeck_friction", "relaxation", "hidden_resonator", *(law.name for law in HYSTERESES),
)  # fmt: skip
"""Every law that the search may add, to one body or another."""
