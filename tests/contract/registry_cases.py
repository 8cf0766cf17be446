"""A motion for every term in the registry: Eq. 15 of the short spring, dry-like damping, and the term on top.

One place for the contract tests and for the accuracy table; a new term must be given a case here.
"""

from __future__ import annotations

import numpy as np

from undertow.equation import registry
from undertow.equation.equation import Equation

X0_M = 0.02
MASS_KG = 2987.0
TIMES_S = np.arange(0.0, 8.0, 0.01)
BASE = {"stiffness": 404000.0, "viscous_damping": 800.0, "coulomb_friction": 160.0, "quadratic_drag": 3900.0}

# term: coefficient, inner parameters, terms of the base that it stands in for
CASES: dict[str, tuple[float, dict[str, float], tuple[str, ...]]] = {
    "stiffness": (404000.0, {}, ("stiffness",)),
    "viscous_damping": (800.0, {}, ("viscous_damping",)),
    "coulomb_friction": (160.0, {}, ("coulomb_friction",)),
    "added_mass": (350.0, {}, ()),
    "quadratic_drag": (3900.0, {}, ("quadratic_drag",)),
    "added_stiffness": (20000.0, {}, ()),
    "linear_damping": (900.0, {}, ("viscous_damping",)),
    "cubic_damping": (20000.0, {}, ()),
    "asymmetric_damping": (300.0, {}, ()),
    "asymmetric_drag": (1500.0, {}, ()),
    "drag_exponent": (2000.0, {"exponent": 1.5}, ("quadratic_drag",)),
    "cubic_stiffness": (4e7, {}, ()),
    "quintic_stiffness": (4e10, {}, ()),
    "asymmetric_stiffness": (2e6, {}, ()),
    "stiffness_drift": (-8000.0, {"time_s": 2.0}, ()),
    "quadratic_stiffness": (2e6, {}, ()),
    "sine_restoring": (404000.0, {}, ("stiffness",)),
    "position_damping": (2e4, {}, ()),
    "van_der_pol_damping": (2e6, {}, ()),
    "stribeck_friction": (60.0, {"velocity_m_per_s": 0.02}, ()),
    "asymmetric_friction": (30.0, {}, ()),
    "variable_normal_force": (5000.0, {}, ()),
    "hidden_resonator": (
        300.0,
        {
            "natural_frequency_rad_per_s": 9.6,
            "damping_ratio": 0.02,
            "quadratic_damping_per_m": 3.0,
            "cubic_stiffness_per_m2_s2": -500.0,
        },
        (),
    ),
    "relaxation": (30000.0, {"time_s": 0.3}, ()),
    "hysteresis": (40000.0, {"yield_displacement_m": 0.004}, ()),
    "external_forcing": (300.0, {"frequency_rad_per_s": 7.0, "phase_rad": 1.0}, ()),
    "changing_force": (
        300.0,
        {
            "frequency_rad_per_s": 7.0,
            "phase_rad": 1.0,
            "change_per_s": -0.2,
            "change_phase_rad": 0.4,
            "bend_per_s2": 0.01,
            "bend_phase_rad": 2.0,
        },
        (),
    ),
    "delayed_echo": (-500.0, {"delay_s": 1.7}, ()),
}


def equation_with(name: str, rest_m: float = 0.0) -> Equation:
    """The base equation with one term of the registry in its place."""
    coefficient, inner, instead_of = CASES[name]
    kept = {base: value for base, value in BASE.items() if base not in instead_of}
    terms = (*(registry.find(base) for base in kept), registry.find(name, **inner))
    return Equation(terms, (*kept.values(), coefficient), mass_kg=MASS_KG, rest_m=rest_m)
