"""Generated from the laws' rows: their forces along a whole motion, and their largest slopes.

Do not edit: change a law's row (structure.py and its neighbours) and run `python -m undertow.equation.generate`.
A test compares.
"""

# ruff: noqa: E501

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Inner = Mapping[str, float]
Size = Callable[[str], float]

COLUMNS: dict[str, Callable[[Array, Array, Array, Inner], Array]] = {
    "stiffness": lambda x, v, t, p: 1.0 * x,
    "viscous_damping": lambda x, v, t, p: 1.0 * v,
    "coulomb_friction": lambda x, v, t, p: np.sign(v),
    "quadratic_drag": lambda x, v, t, p: v**2 * np.sign(v),
    "added_stiffness": lambda x, v, t, p: 1.0 * x,
    "linear_damping": lambda x, v, t, p: 1.0 * v,
    "cubic_damping": lambda x, v, t, p: v**3,
    "asymmetric_damping": lambda x, v, t, p: v * np.sign(v),
    "asymmetric_drag": lambda x, v, t, p: v**2,
    "drag_exponent": lambda x, v, t, p: np.abs(v) ** p["exponent"] * np.sign(v),
    "cubic_stiffness": lambda x, v, t, p: x**3,
    "quintic_stiffness": lambda x, v, t, p: x**5,
    "asymmetric_stiffness": lambda x, v, t, p: x**2,
    "stiffness_drift": lambda x, v, t, p: x * (1.0 - np.exp(-t / p["time_s"])),
    "quadratic_stiffness": lambda x, v, t, p: x * np.abs(x),
    "sine_restoring": lambda x, v, t, p: np.sin(x),
    "position_damping": lambda x, v, t, p: v * x,
    "van_der_pol_damping": lambda x, v, t, p: v * x**2,
    "stribeck_friction": lambda x, v, t, p: np.exp(-v**2 / p["velocity_m_per_s"]**2) * np.sign(v),
    "asymmetric_friction": lambda x, v, t, p: np.sign(v) ** 2,
    "variable_normal_force": lambda x, v, t, p: np.abs(x) * np.sign(v),
    "external_forcing": lambda x, v, t, p: np.cos(p["frequency_rad_per_s"] * t + p["phase_rad"]),
    "changing_force": lambda x, v, t, p: p["bend3_per_s3"] * t**3 * np.cos(p["bend3_phase_rad"] + p["frequency_rad_per_s"] * t) + p["bend4_per_s4"] * t**4 * np.cos(p["bend4_phase_rad"] + p["frequency_rad_per_s"] * t) + p["bend5_per_s5"] * t**5 * np.cos(p["bend5_phase_rad"] + p["frequency_rad_per_s"] * t) + p["bend6_per_s6"] * t**6 * np.cos(p["bend6_phase_rad"] + p["frequency_rad_per_s"] * t) + p["bend_per_s2"] * t**2 * np.cos(p["bend_phase_rad"] + p["frequency_rad_per_s"] * t) + p["change_per_s"] * t * np.cos(p["change_phase_rad"] + p["frequency_rad_per_s"] * t) + np.cos(p["frequency_rad_per_s"] * t + p["phase_rad"]),
}
"""Force per unit coefficient (n,) by a law's name, at x, v, t and its inner parameters."""

SPRINGS: dict[str, tuple[Callable[[Array], Array], Callable[[Array], Array]]] = {
    "k1": (lambda x: 1.0 * x, lambda x: 1.0 + 0.0 * x),
    "k3": (lambda x: x**3, lambda x: 3.0 * x**2),
    "k5": (lambda x: x**5, lambda x: 5.0 * x**4),
    "k2": (lambda x: x**2, lambda x: 2.0 * x),
    "ka": (lambda x: x * np.abs(x), lambda x: 2.0 * np.abs(x)),
}
"""Force in the springs per unit coefficient and its slope, by slot, at x (n,)."""


def stiffest(at: Size, size: float) -> float:
    """Bound of the restoring laws' slope up to the displacement ``size`` (m), N/m, from slots' sizes."""
    return float(
        at("k1")
        + 3.0 * at("k3") * size * size
        + 5.0 * at("k5") * size * size * size * size
        + 2.0 * at("k2") * size
        + 2.0 * at("ka") * size
        + at("ks")
        + at("rk1")
        + at("rk2")
        + at("kb")
    )


def most_damped(at: Size, size: float, speed: float) -> float:
    """Bound of the damping laws' slope up to the displacement ``size`` and the speed ``speed``, N s/m."""
    return float(
        at("c1")
        + 2.0 * at("q") * speed
        + 3.0 * at("c3") * speed * speed
        + at("cb")
        + 2.0 * at("qa") * speed
        + size * at("xv")
        + size * size * at("xxv")
    )


def fading(at: Size) -> tuple[float, ...]:
    """Rates at which memories fade by themselves, 1/s (0: there is none)."""
    return ((1.0 / at("rt1") if at("rt1") > 0.0 else 0.0), (1.0 / at("rt2") if at("rt2") > 0.0 else 0.0),)
