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


def _stiffness(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return 1.0 * x


def _viscous_damping(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return 1.0 * v


def _coulomb_friction(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return np.sign(v)


def _quadratic_drag(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return v**2 * np.sign(v)


def _added_stiffness(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return 1.0 * x


def _linear_damping(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return 1.0 * v


def _cubic_damping(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return v**3


def _drag_exponent(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return np.abs(v) ** p["exponent"] * np.sign(v)


def _cubic_stiffness(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return x**3


def _quintic_stiffness(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return x**5


def _asymmetric_stiffness(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return x**2


def _stiffness_drift(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return x * (1.0 - np.exp(-t / p["time_s"]))


def _quadratic_stiffness(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return x * np.abs(x)


def _sine_restoring(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return np.sin(x)


def _position_damping(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return v * x


def _van_der_pol_damping(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return v * x**2


def _stribeck_friction(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return np.exp(-v**2 / p["velocity_m_per_s"]**2) * np.sign(v)


def _asymmetric_friction(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return np.sign(v) ** 2


def _variable_normal_force(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return np.abs(x) * np.sign(v)


def _external_forcing(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return np.cos(p["frequency_rad_per_s"] * t + p["phase_rad"])


def _changing_force(x: Array, v: Array, t: Array, p: Inner) -> Array:
    return p["bend_per_s2"] * t**2 * np.cos(p["bend_phase_rad"] + p["frequency_rad_per_s"] * t) + p["change_per_s"] * t * np.cos(p["change_phase_rad"] + p["frequency_rad_per_s"] * t) + np.cos(p["frequency_rad_per_s"] * t + p["phase_rad"])


COLUMNS: dict[str, Callable[[Array, Array, Array, Inner], Array]] = {
    "stiffness": _stiffness,
    "viscous_damping": _viscous_damping,
    "coulomb_friction": _coulomb_friction,
    "quadratic_drag": _quadratic_drag,
    "added_stiffness": _added_stiffness,
    "linear_damping": _linear_damping,
    "cubic_damping": _cubic_damping,
    "drag_exponent": _drag_exponent,
    "cubic_stiffness": _cubic_stiffness,
    "quintic_stiffness": _quintic_stiffness,
    "asymmetric_stiffness": _asymmetric_stiffness,
    "stiffness_drift": _stiffness_drift,
    "quadratic_stiffness": _quadratic_stiffness,
    "sine_restoring": _sine_restoring,
    "position_damping": _position_damping,
    "van_der_pol_damping": _van_der_pol_damping,
    "stribeck_friction": _stribeck_friction,
    "asymmetric_friction": _asymmetric_friction,
    "variable_normal_force": _variable_normal_force,
    "external_forcing": _external_forcing,
    "changing_force": _changing_force,
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
        + size * at("xv")
        + size * size * at("xxv")
    )


def fading(at: Size) -> tuple[float, ...]:
    """Rates at which memories fade by themselves, 1/s (0: there is none)."""
    return ((1.0 / at("rt1") if at("rt1") > 0.0 else 0.0), (1.0 / at("rt2") if at("rt2") > 0.0 else 0.0),)
