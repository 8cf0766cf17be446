"""Vector fitting: a rational function of s = i w through samples; poles found without the operators.

Z(s) = d + sum_j r_j / (s - p_j), conjugate pairs; poles relocated until they stand still
(Gustavsen and Semlyen 1999, doi:10.1109/61.772353). Nothing here knows of water.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.virtual_flume.frequency import Mode

Array = np.ndarray


@dataclass(frozen=True)
class RationalFit:
    """`poles` (k,) with positive imaginary part, 1/s; `residues` (k,); `constant`: units of the values.

    `worst_relative_error` is the largest |fit - value| over the root mean square of the values.
    """

    poles: Array
    residues: Array
    constant: float
    worst_relative_error: float

    def __call__(self, s: Array) -> Array:
        """The fitted function at s (any shape), 1/s."""
        s = np.asarray(s, dtype=complex)[..., None]
        pairs = self.residues / (s - self.poles) + self.residues.conj() / (s - self.poles.conj())
        return self.constant + pairs.sum(axis=-1)

    def modes(self) -> list[Mode]:
        """Poles as modes of an apparent mass in kg: participating mass -2 Re(r / p), the heaviest first."""
        found = [
            Mode(abs(p), -p.real / abs(p), -2.0 * (r / p).real)
            for p, r in zip(self.poles, self.residues, strict=True)
        ]
        return sorted(found, key=lambda m: -abs(m.participating_mass))


def _basis(s: Array, poles: Array) -> Array:
    """Real-coefficient partial fractions of conjugate pairs, (len(s), 2 k)."""
    plus, minus = 1.0 / (s[:, None] - poles), 1.0 / (s[:, None] - poles.conj())
    return np.concatenate([plus + minus, 1j * (plus - minus)], axis=1)


def _least_squares(matrix: Array, values: Array) -> Array:
    """Real solution of a complex least-squares problem with scaled columns."""
    stacked = np.concatenate([matrix.real, matrix.imag])
    size = np.linalg.norm(stacked, axis=0)
    size[size == 0.0] = 1.0
    return np.linalg.lstsq(stacked / size, np.concatenate([values.real, values.imag]), rcond=None)[0] / size


def _relocate(s: Array, values: Array, weight: Array, poles: Array) -> Array:
    """Zeros of the fitted denominator: the next poles, upper half plane, reflected to the stable side."""
    basis = _basis(s, poles)
    k = poles.size
    system = np.concatenate([basis, np.ones((s.size, 1)), -values[:, None] * basis], axis=1)
    solution = _least_squares(weight[:, None] * system, weight * values)
    c = solution[2 * k + 1 :]
    # companion of 1 + sum c_j basis_j in real form, pair by pair
    a = np.zeros((2 * k, 2 * k))
    b = np.zeros(2 * k)
    row = np.zeros(2 * k)
    for j, p in enumerate(poles):
        a[2 * j : 2 * j + 2, 2 * j : 2 * j + 2] = [[p.real, p.imag], [-p.imag, p.real]]
        b[2 * j] = 2.0
        row[2 * j], row[2 * j + 1] = c[j], c[k + j]
    zeros = np.linalg.eigvals(a - np.outer(b, row))
    zeros = -np.abs(zeros.real) + 1j * zeros.imag
    kept = zeros[zeros.imag > 1e-9]
    real = np.sort(zeros[np.abs(zeros.imag) <= 1e-9].real)
    paired = [-np.sqrt(abs(u * v)) * (0.8 - 0.6j) for u, v in zip(real[::2], real[1::2], strict=False)]
    return np.concatenate([kept, np.array(paired, dtype=complex)])[:k]


def vector_fit(w: Array, values: Array, pairs: int, rounds: int = 40) -> RationalFit:
    """Fit values (complex, at s = i w, w in rad/s) with `pairs` conjugate pole pairs and a real constant.

    Raises ValueError for fewer samples than unknowns.
    """
    if w.size < 2 * pairs + 1:
        raise ValueError(f"{w.size} frequencies cannot fix {pairs} pole pairs; give at least {2 * pairs + 1}")
    s = 1j * np.asarray(w, dtype=float)
    start = np.linspace(w.min(), w.max(), pairs)
    poles = -0.02 * start + 1j * start
    weight = 1.0 / np.sqrt(np.abs(values))
    for _ in range(rounds):
        poles = _relocate(s, values, weight, poles)
    basis = np.concatenate([_basis(s, poles), np.ones((s.size, 1))], axis=1)
    solution = _least_squares(weight[:, None] * basis, weight * values)
    k = poles.size
    residues = solution[:k] + 1j * solution[k : 2 * k]
    error = np.max(np.abs(basis @ solution - values)) / np.sqrt(np.mean(np.abs(values) ** 2))
    return RationalFit(poles, residues, float(solution[-1]), float(error))
