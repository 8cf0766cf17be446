"""The water's answer to a harmonic sway: added mass, radiation damping, and the modes behind them.

Surface dynamics with a Rayleigh-type loss n(x) (1/s) on potential and elevation alike:

    M (d/dt + n) eta = S p + c U,      (d/dt + n) p = -g eta

so that, for U ~ exp(s t), p = -[S + M (s + n)^2 / g]^-1 c U and F = -Z(s) s U with the apparent mass

    Z(s) = rho' [a - c . p / U],       Z(i w) = A(w) + B(w) / (i w).

Linear water; n is zero but for the sponge and for laminar Stokes layers in the cells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig, solve
from scipy.optimize import brentq

from experiments.virtual_flume.laplace import WaterOperators

Array = np.ndarray

GRAVITY = 9.81  # m/s2
DENSITY = 1000.0  # kg/m3, fresh water


@dataclass(frozen=True)
class Water:
    """Operators with losses and units of the whole model.

    `operators`: per metre and half section. `loss` (n,) 1/s at the surface nodes. `scale_kg_per_m2`: density
    times span times two halves, which turns areas into masses.
    """

    operators: WaterOperators
    loss: Array
    scale_kg_per_m2: float

    @property
    def added_mass_at_once_kg(self) -> float:
        """Added mass of a sudden acceleration (infinite frequency); kg."""
        return self.scale_kg_per_m2 * self.operators.added_area


@dataclass(frozen=True)
class Mode:
    """A pole of the apparent mass: `frequency` rad/s, `damping_ratio` -, `participating_mass` kg."""

    frequency: float
    damping_ratio: float
    participating_mass: float


def apparent_mass(water: Water, s: complex) -> complex:
    """Z(s) of the module's docstring; kg, s in 1/s."""
    o = water.operators
    shifted = s + water.loss
    matrix = o.stiffness + o.mass * (shifted[:, None] * shifted[None, :]) / GRAVITY
    return complex(water.scale_kg_per_m2 * (o.added_area + o.coupling @ solve(matrix, o.coupling)))


def added_mass_and_damping(water: Water, w: Array) -> tuple[Array, Array]:
    """A (kg) and B (N s/m) at the frequencies w (rad/s), each (len(w),)."""
    z = np.array([apparent_mass(water, 1j * value) for value in np.atleast_1d(w)])
    return z.real, -np.atleast_1d(w) * z.imag


def modes(water: Water, band: tuple[float, float] = (0.5, 25.0)) -> list[Mode]:
    """All oscillating poles with frequency inside the band (rad/s), the heaviest first.

    Z(s) = Z(inf) + sum_i r_i / (s - s_i) over conjugate pairs; the participating mass is what the pair adds to
    Z(0), m_i = -2 Re(r_i / s_i), which for m_i (x'' + s'') with s'' + 2 z w s' + w^2 s = -x'' is m_i itself.
    """
    o = water.operators
    n = o.x.size
    relation = solve(o.mass, o.stiffness, assume_a="pos")
    state = np.block([[-np.diag(water.loss), relation], [-GRAVITY * np.eye(n), -np.diag(water.loss)]])
    value, left, right = eig(state, left=True, right=True)
    drive = np.concatenate([solve(o.mass, o.coupling, assume_a="pos"), np.zeros(n)])
    # sway force = -rho' [a U' - c . p'], p' = s p: the residue of Z = a - c . p / U
    read = np.concatenate([np.zeros(n), -o.coupling])
    norm = np.einsum("ij,ij->j", left.conj(), right)
    residue = water.scale_kg_per_m2 * (read @ right) * (left.conj().T @ drive) / norm
    found = []
    for s, r in zip(value, residue, strict=True):
        if s.imag > 0.0 and band[0] < abs(s) < band[1]:
            found.append(Mode(abs(s), -s.real / abs(s), -2.0 * (r / s).real))
    return sorted(found, key=lambda m: -abs(m.participating_mass))


@dataclass(frozen=True)
class BodyFrequency:
    """A `frequency` (rad/s) at which the sprung body moves freely, and the `share` of a static release it carries."""

    frequency: float
    share: float


def body_frequencies(water: Water, mass_kg: float, stiffness: float) -> list[BodyFrequency]:
    """Frequencies where k = w^2 (m + A(w)), the largest share first; stiffness N/m.

    A release from x0 moves as x0 sum_i share_i cos(w_i t) where radiation is small, with share_i = k / (w_i^2 M_i) and
    M_i = m + A + (w/2) dA/dw; the shares then add up to one. Searched between 2 and 16 rad/s.
    """
    w = np.linspace(2.0, 16.0, 281)

    def dynamic_mass(value: float) -> float:
        return mass_kg + apparent_mass(water, 1j * value).real

    def excess(value: float) -> float:
        return stiffness - value**2 * dynamic_mass(value)

    left = np.array([excess(value) for value in w])
    found = []
    for i in np.nonzero(left[:-1] * left[1:] < 0.0)[0]:
        root = float(brentq(excess, w[i], w[i + 1], xtol=1e-9))
        step = 1e-5 * root
        slope = (dynamic_mass(root + step) - dynamic_mass(root - step)) / (2.0 * step)
        share = stiffness / (root**2 * (dynamic_mass(root) + 0.5 * root * slope))
        found.append(BodyFrequency(root, share))
    return sorted(found, key=lambda b: -b.share)
