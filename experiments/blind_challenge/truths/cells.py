"""Fully nonlinear water in closed rectangular cells: the Miles-Lukovsky modal equations of one surging tank.

Surface zeta = sum beta_i cos(i pi x / l), potential in the tank's frame phi = sum R_n cos(k_n x) cosh(k_n (z + h)) /
cosh(k_n h) with k_n = n pi / l. With D_ni = dA_n / dbeta_i, A_n = rho int phi_n dQ and A_nk = rho int grad phi_n grad
phi_k dQ (Faltinsen and Timokha, Sloshing, 2009, ch. 7):

    D beta' = A R,    D^T (R' + nu R) + 1/2 R (dA / dbeta) R + rho b g (l / 2) beta + lambda a = 0

without any expansion in the surface's height. The force on the body is -m_l a - sum lambda_i beta_i''. Integrals over x
are Gauss-Legendre sums, those over z are closed forms. Holds while the surface is single-valued and the bottom stays
wet.
"""

import math

import numpy as np

from experiments.blind_challenge.truths.compiled import kernel

HEADER = 6  # modes, nodes, length l, depth h, rho times the breadth of all cells, gravity


def cell_numbers(
    length: float, depth: float, breadth_density: float, gravity: float, damping: float, modes: int = 4
) -> np.ndarray:
    """The numbers of a CELL law: geometry (m), rho b in kg/m^2, g, and the damping ratio of every mode (1)."""
    nodes, weights = np.polynomial.legendre.leggauss(8 * modes)
    x = 0.5 * length * (nodes + 1.0)
    wave = np.arange(1, modes + 1) * math.pi / length
    rates = 2.0 * damping * np.sqrt(gravity * wave * np.tanh(wave * depth))
    cosines = np.cos(np.outer(x, wave))
    sines = np.sin(np.outer(x, wave))
    head = [modes, x.size, length, depth, breadth_density, gravity]
    return np.concatenate([head, rates, 0.5 * length * weights, cosines.ravel(), sines.ravel()])


def cell_frequency(length: float, depth: float, gravity: float, mode: int = 1) -> float:
    """Linear natural frequency of a mode of a rectangular cell, rad/s: w^2 = g k tanh(k h) (Lamb 1932)."""
    wave = mode * math.pi / length
    return math.sqrt(gravity * wave * math.tanh(wave * depth))


def cell_mass(length: float, depth: float, breadth_density: float, mode: int = 1) -> float:
    """Participating mass of an odd linear mode, kg: m_l 8 tanh(k h) / (n^3 pi^3 h / l) (Graham and Rodriguez 1952)."""
    if mode % 2 == 0:
        return 0.0
    total = breadth_density * length * depth
    wave = mode * math.pi / length
    return total * 8.0 * math.tanh(wave * depth) / ((mode * math.pi) ** 3 * depth / length)


@kernel
def _solve(matrix, right):
    """Gaussian elimination with pivots, in place; columns of `right` become the solutions."""
    n = matrix.shape[0]
    for i in range(n):
        pivot = i
        for r in range(i + 1, n):
            if abs(matrix[r, i]) > abs(matrix[pivot, i]):
                pivot = r
        if pivot != i:
            for c in range(n):
                matrix[i, c], matrix[pivot, c] = matrix[pivot, c], matrix[i, c]
            for c in range(right.shape[1]):
                right[i, c], right[pivot, c] = right[pivot, c], right[i, c]
        for r in range(i + 1, n):
            factor = matrix[r, i] / matrix[i, i]
            for c in range(i, n):
                matrix[r, c] -= factor * matrix[i, c]
            for c in range(right.shape[1]):
                right[r, c] -= factor * right[i, c]
    for c in range(right.shape[1]):
        for i in range(n - 1, -1, -1):
            for r in range(i + 1, n):
                right[i, c] -= matrix[i, r] * right[r, c]
            right[i, c] /= matrix[i, i]


@kernel
def _integrals(h, s, p, o, shallow, slope):
    """D, A, 1/2 R dA R, and per node the scaled cosh, sinh and velocities at the surface."""
    n, q, length, depth = int(p[o]), int(p[o + 1]), p[o + 2], p[o + 3]
    first = HEADER + n
    d = np.zeros((n, n))
    a = np.zeros((n, n))
    quad = np.zeros(n)
    speed = np.zeros((q, 2))
    for j in range(q):
        w = p[o + 4] * p[o + first + j]
        cs = first + q + j * n
        sn = cs + q * n
        zeta = 0.0
        for i in range(n):
            zeta += h[s + i] * p[o + cs + i]
        for i in range(n):
            k = (i + 1) * math.pi / length
            up, down, base = math.exp(k * zeta), math.exp(-k * (zeta + 2.0 * depth)), 1.0 + math.exp(-2.0 * k * depth)
            shallow[j, i] = (up + down) / base
            slope[j, i] = (up - down) / base
            speed[j, 0] -= h[s + n + i] * k * p[o + sn + i] * shallow[j, i]
            speed[j, 1] += h[s + n + i] * k * p[o + cs + i] * slope[j, i]
        energy = 0.5 * (speed[j, 0] ** 2 + speed[j, 1] ** 2)
        for i in range(n):
            ki = (i + 1) * math.pi / length
            quad[i] += w * energy * p[o + cs + i]
            for m in range(n):
                km = (m + 1) * math.pi / length
                d[i, m] += w * p[o + cs + i] * shallow[j, i] * p[o + cs + m]
                both = (slope[j, i] * shallow[j, m] + shallow[j, i] * slope[j, m]) / (ki + km)
                if i == m:
                    apart = (zeta + depth) / math.cosh(ki * depth) ** 2
                else:
                    apart = (slope[j, i] * shallow[j, m] - shallow[j, i] * slope[j, m]) / (ki - km)
                a[i, m] += (
                    0.5
                    * w
                    * ki
                    * km
                    * (p[o + sn + i] * p[o + sn + m] * (both + apart) + p[o + cs + i] * p[o + cs + m] * (both - apart))
                )
    return d, a, quad, speed


@kernel
def _second_rates(p, o, d, a, potential, spread, speed, shallow, slope):
    """Right-hand sides of D beta'' = ... for the free part, given beta' and R'."""
    n, q, length = int(p[o]), int(p[o + 1]), p[o + 2]
    first = HEADER + n
    right = np.zeros(n)
    for j in range(q):
        w = p[o + 4] * p[o + first + j]
        cs = first + q + j * n
        sn = cs + q * n
        rise = 0.0
        for i in range(n):
            rise += spread[i] * p[o + cs + i]
        for i in range(n):
            k = (i + 1) * math.pi / length
            pull = -k * p[o + sn + i] * shallow[j, i] * speed[j, 0] + k * p[o + cs + i] * slope[j, i] * speed[j, 1]
            right[i] += w * rise * (pull - p[o + cs + i] * k * slope[j, i] * rise)
    for i in range(n):
        for m in range(n):
            right[i] += a[i, m] * potential[m]
    return right


@kernel
def cell_load(h, s, p, o, scratch, r):
    """(force, mass) on the body; leaves beta', the free R' and its part per unit acceleration in `scratch`."""
    n, q, length = int(p[o]), int(p[o + 1]), p[o + 2]
    shallow = np.empty((q, n))
    slope = np.empty((q, n))
    d, a, quad, speed = _integrals(h, s, p, o, shallow, slope)
    momentum = np.empty(n)
    right = np.empty((n, 2))
    flow = np.zeros((n, 1))
    for i in range(n):
        momentum[i] = p[o + 4] * length**2 * (-2.0 if i % 2 == 0 else 0.0) / ((i + 1) * math.pi) ** 2
        right[i, 0] = -quad[i] - p[o + 4] * p[o + 5] * 0.5 * length * h[s + i]
        right[i, 1] = -momentum[i]
        for m in range(n):
            flow[i, 0] += a[i, m] * h[s + n + m]
    _solve(d.T.copy(), right)
    _solve(d.copy(), flow)
    for i in range(n):
        right[i, 0] -= p[o + HEADER + i] * h[s + n + i]
        scratch[r + i] = flow[i, 0]
        scratch[r + n + i] = right[i, 0]
        scratch[r + 2 * n + i] = right[i, 1]
    bend = np.zeros((n, 2))
    bend[:, 0] = _second_rates(p, o, d, a, right[:, 0], flow[:, 0], speed, shallow, slope)
    for i in range(n):
        for m in range(n):
            bend[i, 1] += a[i, m] * right[m, 1]
    _solve(d.copy(), bend)
    force = 0.0
    mass = p[o + 4] * length * p[o + 3]
    for i in range(n):
        force -= momentum[i] * bend[i, 0]
        mass += momentum[i] * bend[i, 1]
    return force, mass


@kernel
def cell_rates(a, s, p, o, scratch, r, rate, d):
    """Rates of beta and R once the body's acceleration is known."""
    n = int(p[o])
    for i in range(n):
        rate[d + i] = scratch[r + i]
        rate[d + n + i] = scratch[r + n + i] + a * scratch[r + 2 * n + i]
