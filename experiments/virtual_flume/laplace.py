"""Laplace's equation in a section of water: dense operators between surface, walls and the body's sway.

Nine-node quadrilaterals on a trapezoid mesh; antisymmetric potential (zero on x = 0), so half the section is
solved and both halves are counted. Weak form: K phi = U b on the walls, with b = integral of N n_x and n out
of the water. Eliminating the inner nodes leaves, for the surface potential p (m2/s), elevation eta (m) and
body velocity U (m/s),

    M d(eta)/dt = S p + c U                       (kinematic condition, weak)
    F = -rho' [ a U' - c . p' ]                   (sway force on the body; rho' = density x span x 2)

S and M are symmetric and the same c stands in both lines, so that the discrete energy
rho'/2 (p.S p + a U^2) + rho' g/2 eta.M eta changes only by the work F U (Luke 1967,
doi:10.1017/S0022112067000412). Linear water about the rest position. No time and no frequency here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from experiments.virtual_flume.mesh import TrapezoidMesh

Array = np.ndarray

_GAUSS = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])
_WEIGHT = np.array([5.0, 8.0, 5.0]) / 9.0


@dataclass(frozen=True)
class WaterOperators:
    """What the water does to a swaying body, per metre of span and for half the section.

    `x` (n,) m: surface nodes. `mass` (n, n) m: surface mass matrix. `stiffness` (n, n): Dirichlet-to-Neumann
    matrix S.
    `coupling` (n,) m: c. `moment_coupling` (n,) m2: the same for the moment about (0, `pivot_z_m`), from x
    towards z.
    `added_area` m2 and `added_moment` m3: the parts proportional to the body's acceleration.
    """

    x: Array
    mass: Array
    stiffness: Array
    coupling: Array
    moment_coupling: Array
    added_area: float
    added_moment: float
    pivot_z_m: float


def _lagrange(t: Array) -> tuple[Array, Array]:
    """Quadratic shape functions on nodes -1, 0, 1 and their slopes at points t, each (points, 3)."""
    value = np.stack([0.5 * t * (t - 1.0), 1.0 - t * t, 0.5 * t * (t + 1.0)], axis=-1)
    slope = np.stack([t - 0.5, -2.0 * t, t + 0.5], axis=-1)
    return value, slope


def _nodes(mesh: TrapezoidMesh) -> tuple[Array, Array]:
    """x and z of all nodes, (2 rows + 1, 2 columns + 1): corners, midpoints, centres; m."""

    def halve(a: Array) -> Array:
        out = np.empty((2 * a.shape[0] - 1, *a.shape[1:]))
        out[::2], out[1::2] = a, 0.5 * (a[1:] + a[:-1])
        return out

    x = halve(halve(mesh.x).T).T
    return x, np.tile(halve(mesh.z)[:, None], (1, x.shape[1]))


def _element_nodes(mesh: TrapezoidMesh, number: Array) -> Array:
    """Node numbers of the wet elements, (elements, 9), row by row from the lower left."""
    i, j = np.nonzero(mesh.wet)
    return np.stack([number[2 * i + a, 2 * j + b] for a in range(3) for b in range(3)], axis=1)


def _assemble(x: Array, z: Array, elements: Array) -> sp.csc_matrix:
    """Stiffness matrix of the Laplacian, (nodes, nodes)."""
    value, slope = _lagrange(_GAUSS)
    local = np.zeros((elements.shape[0], 9, 9))
    ex, ez = x.ravel()[elements], z.ravel()[elements]
    for a in range(3):
        for b in range(3):
            d_row = np.kron(slope[a], value[b])
            d_col = np.kron(value[a], slope[b])
            xr, xc, zr, zc = ex @ d_row, ex @ d_col, ez @ d_row, ez @ d_col
            jacobian = xc * zr - xr * zc
            grad_x = (zr[:, None] * d_col - zc[:, None] * d_row) / jacobian[:, None]
            grad_z = (-xr[:, None] * d_col + xc[:, None] * d_row) / jacobian[:, None]
            weight = _WEIGHT[a] * _WEIGHT[b] * jacobian
            local += weight[:, None, None] * (
                grad_x[:, :, None] * grad_x[:, None, :] + grad_z[:, :, None] * grad_z[:, None, :]
            )
    rows = np.repeat(elements, 9, axis=1).ravel()
    cols = np.tile(elements, (1, 9)).ravel()
    return sp.csc_matrix((local.ravel(), (rows, cols)), shape=(x.size, x.size))


def _wall_edges(mesh: TrapezoidMesh, number: Array, far_wall_moves: bool) -> Array:
    """Node triples (edges, 3) along the body's walls, the water on the left of the way they run."""
    wet = mesh.wet
    edges = []
    for i, j in zip(*np.nonzero(wet), strict=True):
        r, c = 2 * i, 2 * j
        last = j + 1 == wet.shape[1]
        if (last and far_wall_moves) or (not last and not wet[i, j + 1]):
            edges.append(number[[r, r + 1, r + 2], [c + 2] * 3])
        if j > 0 and not wet[i, j - 1]:
            edges.append(number[[r + 2, r + 1, r], [c] * 3])
        if i + 1 < wet.shape[0] and not wet[i + 1, j]:
            edges.append(number[[r + 2] * 3, [c + 2, c + 1, c]])
        if i > 0 and not wet[i - 1, j]:
            edges.append(number[[r] * 3, [c, c + 1, c + 2]])
    return np.array(edges)


def _wall_loads(x: Array, z: Array, edges: Array, pivot_z_m: float) -> tuple[Array, Array]:
    """Integrals of N n_x (m) and of N (x n_z - (z - pivot) n_x) (m2) over the walls, (nodes,) each."""
    value, _ = _lagrange(_GAUSS)
    sway, moment = np.zeros(x.size), np.zeros(x.size)
    xe, ze = x.ravel()[edges], z.ravel()[edges]
    dx, dz = xe[:, 2] - xe[:, 0], ze[:, 2] - ze[:, 0]
    nx_ds, nz_ds = 0.5 * dz, -0.5 * dx  # normal to the right of the direction of travel: out of the water
    for q in range(3):
        xq, zq = xe @ value[q], ze @ value[q] - pivot_z_m
        np.add.at(sway, edges, _WEIGHT[q] * nx_ds[:, None] * value[q])
        np.add.at(moment, edges, _WEIGHT[q] * (xq * nz_ds - zq * nx_ds)[:, None] * value[q])
    return sway, moment


def _surface_mass(x: Array, edges: Array, place: Array, size: int) -> Array:
    """Mass matrix of the surface's line elements, (size, size); m."""
    local = np.array([[4.0, 2.0, -1.0], [2.0, 16.0, 2.0], [-1.0, 2.0, 4.0]]) / 30.0
    mass = np.zeros((size, size))
    for edge in edges:
        where = place[edge]
        keep = where >= 0
        length = x.ravel()[edge[2]] - x.ravel()[edge[0]]
        mass[np.ix_(where[keep], where[keep])] += length * local[np.ix_(keep, keep)]
    return mass


def water_operators(
    mesh: TrapezoidMesh, pivot_z_m: float = 0.0, far_wall_moves: bool = False
) -> WaterOperators:
    """Dense operators of the half section; the module's docstring has the law, WaterOperators the shapes.

    `far_wall_moves` makes the far end a wall of the body (a closed tank); otherwise it stands still.
    """
    x, z = _nodes(mesh)
    number = np.arange(x.size).reshape(x.shape)
    elements = _element_nodes(mesh, number)
    matrix = _assemble(x, z, elements)
    sway, moment = _wall_loads(x, z, _wall_edges(mesh, number, far_wall_moves), pivot_z_m)
    top = np.nonzero(mesh.wet[-1])[0]
    surface_edges = np.array([number[-1, 2 * j : 2 * j + 3] for j in top])
    used = np.zeros(x.size, dtype=bool)
    used[elements.ravel()] = True
    used[number[:, 0]] = False  # antisymmetry: phi = 0 on x = 0
    on_surface = np.zeros(x.size, dtype=bool)
    on_surface[surface_edges.ravel()] = True
    surface = np.nonzero(used & on_surface)[0]
    inner = np.nonzero(used & ~on_surface)[0]
    place = np.full(x.size, -1)
    place[surface] = np.arange(surface.size)

    k_is = matrix[inner][:, surface]
    lu = splu(matrix[inner][:, inner].tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    from_surface = lu.solve(k_is.toarray())
    from_sway = lu.solve(sway[inner])
    stiffness = matrix[surface][:, surface].toarray() - k_is.T @ from_surface
    return WaterOperators(
        x=x.ravel()[surface],
        mass=_surface_mass(x, surface_edges, place, surface.size),
        stiffness=0.5 * (stiffness + stiffness.T),
        coupling=k_is.T @ from_sway - sway[surface],
        moment_coupling=from_surface.T @ moment[inner] - moment[surface],
        added_area=float(sway[inner] @ from_sway),
        added_moment=float(moment[inner] @ from_sway),
        pivot_z_m=pivot_z_m,
    )
