"""Fully nonlinear potential flow in a closed rectangular cell: no expansion in the waves' amplitude.

The water between floor and surface, 0 < z < d(x, t) = h + eta, is mapped onto a fixed rectangle by s = z / d. With the
potential phi in quadratic elements along x and one polynomial over the depth, its kinetic energy is a sum over
Gauss points,

    T = 1/2 int [ d phi_x^2 - 2 d_x s phi_x phi_s + (d_x^2 s^2 + 1) phi_s^2 / d ] ds dx = 1/2 p . S(eta) p,

with p the potential at the surface and S what is left when the inner nodes are eliminated (floor and walls by
nature let nothing through). Zakharov's canonical equations (1968, doi:10.1007/BF00913182),

    M eta' = S p,        M p' = -1/2 p . (dS/d eta) p - g M eta,

then keep energy and volume exactly, but for the step in time: dS/d eta is the exact derivative of the same sum,
and the inner nodes do not enter it because they are stationary. The surface is a function of x: a wave may be steep,
it cannot overturn. Per metre of cell length and per density; no body here, no losses, no time.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigh
from scipy.linalg.lapack import dpbtrf, dpbtrs

Array = np.ndarray

GRAVITY = 9.81  # m/s2
LEAST_DEPTH = 0.02  # of the still depth; below it the floor falls dry and the map has no meaning
_POINTS = 4  # Gauss points an element


@dataclass(frozen=True)
class Flow:
    """Two harmonic extensions at one surface: of p and of x, both at the surface nodes.

    `flux` (n,) m2/s = S p and `sway_flux` (n,) m = S x; `push` (n,) = 1/2 p . (dS/d eta) p, m3/s2;
    `cross` (n,) = x . (dS/d eta) p, m2/s.
    """

    flux: Array
    sway_flux: Array
    push: Array
    cross: Array


@dataclass(frozen=True)
class LinearMode:
    """A mode of the water at rest: `frequency` rad/s; `participating_area` m2 (times density and length: kg)."""

    frequency: float
    participating_area: float


class Cell:
    """Operators of a closed cell `width_m` wide and `depth_m` deep at rest.

    `elements` along x, a polynomial of degree `order` over the depth. Surface nodes `x` (n,) run from -width/2 to
    width/2, n = 2 elements + 1. Raises ValueError for sizes that are not positive.
    """

    def __init__(self, width_m: float, depth_m: float, elements: int = 24, order: int = 8) -> None:
        if not (width_m > 0.0 and depth_m > 0.0 and elements >= 2 and order >= 2):
            raise ValueError(
                f"cell of {width_m:g} m x {depth_m:g} m with {elements} elements of order {order}: width and depth "
                "must be positive, elements and order at least 2; give such a cell"
            )
        self.width, self.depth, self.elements, self.order = width_m, depth_m, elements, order
        self.x = np.linspace(-0.5 * width_m, 0.5 * width_m, 2 * elements + 1)
        self.columns = 2 * np.arange(elements)[:, None] + np.arange(3)
        self._along()
        self._basis = self._element_basis()
        self._places()

    @property
    def area(self) -> float:
        """Water's area in the section; m2."""
        return self.width * self.depth

    def _along(self) -> None:
        """Shape functions along x at the Gauss points, and the surface's mass matrix (n, n), m."""
        point, weight = np.polynomial.legendre.leggauss(_POINTS)
        size = self.width / self.elements
        self._value = np.stack([0.5 * point * (point - 1.0), 1.0 - point**2, 0.5 * point * (point + 1.0)], axis=1)
        self._slope = np.stack([point - 0.5, -2.0 * point, point + 0.5], axis=1) * (2.0 / size)
        self._weight = weight * 0.5 * size
        local = np.einsum("g,ga,gb->ab", self._weight, self._value, self._value)
        self.mass = np.zeros((self.x.size, self.x.size))
        for where in self.columns:
            self.mass[np.ix_(where, where)] += local
        self.inverse_mass = np.linalg.inv(self.mass)

    def _depth_integrals(self) -> tuple[Array, Array, Array, Array]:
        """Integrals over 0 < s < 1 of l l, s l l', s^2 l' l', l' l' of the depth's polynomials, (order+1,)*2 each."""
        knots = 0.5 * (1.0 - np.cos(np.pi * np.arange(self.order + 1) / self.order))
        point, weight = np.polynomial.legendre.leggauss(self.order + 2)
        s, w = 0.5 * (point + 1.0), 0.5 * weight
        fit = np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * knots - 1.0, self.order))
        value = np.polynomial.chebyshev.chebvander(point, self.order) @ fit
        rate = np.polynomial.chebyshev.chebder(np.eye(self.order + 1), axis=0)
        slope = 2.0 * np.polynomial.chebyshev.chebvander(point, self.order - 1) @ rate @ fit
        return (
            np.einsum("q,qi,qj->ij", w, value, value),
            np.einsum("q,qi,qj->ij", w * s, value, slope),
            np.einsum("q,qi,qj->ij", w * s * s, slope, slope),
            np.einsum("q,qi,qj->ij", w, slope, slope),
        )

    def _element_basis(self) -> Array:
        """Element matrices of d, d_x, d_x^2/d and 1/d at each Gauss point, (4 points, nodes, nodes)."""
        a0, a1, a2, a3 = self._depth_integrals()
        n, m = self._value, self._slope
        parts = [
            np.einsum("ga,gb,ij->gaibj", m, m, a0),
            -(np.einsum("ga,gb,ij->gaibj", m, n, a1) + np.einsum("ga,gb,ji->gaibj", n, m, a1)),
            np.einsum("ga,gb,ij->gaibj", n, n, a2),
            np.einsum("ga,gb,ij->gaibj", n, n, a3),
        ]
        nodes = 3 * (self.order + 1)
        return np.concatenate(parts).reshape(4 * _POINTS, nodes, nodes)

    def _places(self) -> None:
        """Where element entries go: nodes, inner unknowns, and the band of the inner matrix."""
        rows = self.order + 1
        row = np.tile(np.arange(rows), 3)
        column = np.repeat(self.columns, rows, axis=1)
        self._node = column * rows + row
        self._inner = row < self.order
        unknown = (column * self.order + row)[:, self._inner]
        self._unknowns = self.x.size * self.order
        self._band = 3 * self.order - 1
        i, j = unknown[:, :, None], unknown[:, None, :]
        self._lower = np.nonzero((i >= j).ravel())[0]
        # LAPACK's lower band, stored column by column
        self._band_place = (j * (self._band + 1) + i - j).ravel()[self._lower]
        grid = np.arange(self.x.size)[:, None] * rows + np.arange(rows)
        self._inner_nodes, self._top = grid[:, :-1].ravel(), grid[:, -1]

    def _profile(self, eta: Array) -> tuple[Array, Array]:
        """Depth d (m) and slope d_x at the Gauss points, (elements, points) each."""
        local = eta[self.columns]
        return self.depth + local @ self._value.T, local @ self._slope.T

    def flow(self, eta: Array, p: Array) -> Flow:
        """The flow under a surface `eta` (n,) m with potential `p` (n,) m2/s; see Flow.

        Raises ValueError where the surface comes to the floor.
        """
        d, dx = self._profile(eta)
        if not d.min() > LEAST_DEPTH * self.depth:
            raise ValueError(
                f"the water is {d.min():.3g} m deep somewhere, rest {self.depth:g} m: it must stay above "
                f"{LEAST_DEPTH:g} of that; release from a smaller amplitude or take more breaking"
            )
        factor = np.concatenate([d, dx, dx * dx / d, 1.0 / d], axis=1) * np.tile(self._weight, 4)
        nodes = self._basis.shape[1]
        element = (factor @ self._basis.reshape(4 * _POINTS, -1)).reshape(-1, nodes, nodes)
        both = self._extend(element, np.column_stack([p, self.x]))
        local = both[self._node]
        out = np.zeros_like(both)
        np.add.at(out, self._node, element @ local)
        push, cross = self._surface_derivatives(d, dx, local)
        return Flow(out[self._top, 0], out[self._top, 1], 0.5 * push, cross)

    def _extend(self, element: Array, surface: Array) -> Array:
        """Harmonic extensions (all nodes, k) of surface values (n, k)."""
        whole = np.zeros((self.x.size * (self.order + 1), surface.shape[1]))
        whole[self._top] = surface
        load = np.zeros_like(whole)
        np.add.at(load, self._node, element @ whole[self._node])
        inner = element[:, self._inner][:, :, self._inner].ravel()[self._lower]
        size = self._unknowns * (self._band + 1)
        band = np.bincount(self._band_place, weights=inner, minlength=size)
        factor, failed = dpbtrf(band.reshape(self._unknowns, -1).T, lower=1)
        if failed:
            raise ValueError(
                f"unknown {failed} of {self._unknowns} under the surface has no positive pivot, rest depth "
                f"{self.depth:g} m: the map must be one to one; take more elements or a smaller release"
            )
        solved, _ = dpbtrs(factor, -load[self._inner_nodes], lower=1)
        whole[self._inner_nodes] = solved
        return whole

    def _surface_derivatives(self, d: Array, dx: Array, local: Array) -> tuple[Array, Array]:
        """p . (dS/d eta) p and x . (dS/d eta) p, (n,) each, from the extensions in the elements (e, nodes, 2)."""
        moved = np.einsum("mij,ej->emi", self._basis, local[:, :, 0], optimize=True)
        pair = np.einsum("emi,eik->kem", moved, local).reshape(2, self.elements, 4, _POINTS)
        by_depth = pair[:, :, 0] - (dx**2 * pair[:, :, 2] + pair[:, :, 3]) / d**2
        by_slope = pair[:, :, 1] + 2.0 * dx / d * pair[:, :, 2]
        each = (by_depth * self._weight) @ self._value + (by_slope * self._weight) @ self._slope
        out = np.zeros((2, self.x.size))
        for k in range(2):
            np.add.at(out[k], self.columns, each[k])
        return out[0], out[1]

    def slope(self, eta: Array) -> Array:
        """The surface's slope at the Gauss points, (elements, points)."""
        return self._profile(eta)[1]

    def weighted(self, weight: Array, field: Array) -> Array:
        """Integral of N w f over the surface, (n,): `weight` (elements, points) >= 0, `field` (n,) at the nodes."""
        local = (weight * (field[self.columns] @ self._value.T) * self._weight) @ self._value
        out = np.zeros_like(field)
        np.add.at(out, self.columns, local)
        return out

    @cached_property
    def still_stiffness(self) -> Array:
        """S at rest, (n, n)."""
        rest = np.zeros_like(self.x)
        return np.stack([self.flow(rest, e).flux for e in np.eye(self.x.size)])

    @cached_property
    def still_modes(self) -> tuple[Array, Array]:
        """Squared wavenumber-like eigenvalues (n,) 1/m, rising, and shapes (n, n) with v . M v = 1, of S v = l M v."""
        return eigh(0.5 * (self.still_stiffness + self.still_stiffness.T), self.mass)

    def linear_modes(self, count: int) -> list[LinearMode]:
        """The first sway modes of small waves: frequency and participating area.

        In x'' = a the mode's amplitude obeys q'' + l g q = -a (v . S x); its force is rho (v . S x)^2 / (l g) w^2 s.
        """
        value, shape = self.still_modes
        drive = shape.T @ self.still_stiffness @ self.x
        share = drive**2 / np.maximum(value, 1e-9)
        sway = [i for i in range(1, value.size) if share[i] > 1e-9 * self.area]
        return [LinearMode(float(np.sqrt(GRAVITY * value[i])), float(share[i])) for i in sway[:count]]

    def energy(self, eta: Array, p: Array) -> float:
        """Energy of the flow relative to the cell; m4/s2 (times density and length: J)."""
        return float(0.5 * p @ self.flow(eta, p).flux + 0.5 * GRAVITY * eta @ self.mass @ eta)


def theory_mode(width_m: float, depth_m: float, number: int = 1) -> LinearMode:
    """Linear theory of the rectangular tank in sway, odd `number` (Graham and Rodriguez 1952).

    w^2 = g k tanh(k h), k = n pi / width; share of the water 8 tanh(k h) / (n^3 pi^3 h / width).

    >>> round(theory_mode(0.3344, 0.14).frequency, 3)
    8.932
    """
    k = number * np.pi / width_m
    deep = np.tanh(k * depth_m)
    share = 8.0 * deep / ((number * np.pi) ** 3 * depth_m / width_m)
    return LinearMode(float(np.sqrt(GRAVITY * k * deep)), float(share * width_m * depth_m))
