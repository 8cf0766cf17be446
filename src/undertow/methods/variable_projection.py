"""Inner parameters of columns by variable projection.

A hidden oscillator enters an equation linearly by its mass, but not by its frequency and damping. Least squares
eliminates everything linear; Gauss-Newton with damping moves the rest.

    min over q of | r - Phi(q) theta(q) |^2,    theta(q) = Phi(q)^+ r

Source: Golub and Pereyra 1973, doi:10.1137/0710036; the Jacobian is Kaufman's 1975 (doi:10.1007/BF01932995), which
leaves out a part that vanishes with the residual.

Belongs here: columns, projected, and their derivatives. Does not belong here: the iteration (likelihood/descent.py),
what the columns are (hidden_library.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.errors import IdentificationError
from undertow.likelihood.descent import Rule, descend
from undertow.methods.subset import project_out

Array = NDArray[np.float64]

INNER_BOUNDS = ((0.05, 1e-3), (500.0, 0.95))
"""Widest (w in rad/s, zeta) that a refinement may reach: below, an oscillator is a drift or without damping."""

DIFFERENCE = 1e-4
"""Step of the derivative in the logarithm of a parameter: a response is smooth in it, rounding stays below 1e-8."""

RULE = Rule(30, stop=1e-5, damping=1e-3, lower=0.2, higher=10.0, farthest=0.5, in_own_unit=True)
"""Ends when no parameter moves by 1e-5 of itself, far below any standard error here; a parameter changes by a factor of
1.6 at once at most, so that a flat start does not fling a frequency away."""


@dataclass(frozen=True)
class Refinement:
    """Where the iteration ended: ``inner`` (m, k) and the columns' ``coefficients`` (m,)."""

    inner: Array
    coefficients: Array


@dataclass(frozen=True)
class _Place:
    """Projected columns with their derivatives at one set of parameters, and the least squares there."""

    coefficients: Array
    residual: Array
    jacobian: Array

    @property
    def cost(self) -> float:
        """Sum of the residual's squares."""
        return float(self.residual @ self.residual)

    @property
    def normal(self) -> Array:
        """Normal matrix by the logarithms."""
        return np.asarray(self.jacobian.T @ self.jacobian)

    @property
    def gradient(self) -> Array:
        """Half the slope of the cost by the logarithms."""
        return np.asarray(self.jacobian.T @ self.residual)


def refine_inner(
    columns: Callable[[Array], Array],
    fixed: Array,
    response: Array,
    start: Array,
    bounds: tuple[Array, Array],
) -> Refinement:
    """Parameters of ``columns`` that explain ``response`` best beside the ``fixed`` columns.

    ``columns`` maps (m, k) positive parameters, k to a column (w and zeta of an oscillator, tau of a relaxation), to
    (n, m); ``fixed`` is (n, q), ``response`` (n,), ``start`` (m, k), ``bounds`` two arrays (k,). Steps are taken in the
    parameters' logarithms.

    Raises IdentificationError where the start is not positive or the columns are not finite.

    >>> t = np.linspace(0.0, 5.0, 300)
    >>> def wave(q):
    ...     return np.column_stack([np.exp(-z * w * t) * np.cos(w * t) for w, z in q])
    >>> found = refine_inner(wave, np.ones((300, 1)), 2.0 * wave([[7.0, 0.05]])[:, 0] + 1.0, np.array([[6.5, 0.1]]),
    ...                      (np.array([1.0, 1e-3]), np.array([20.0, 0.9])))
    >>> found.inner.round(4).tolist(), found.coefficients.round(4).tolist()
    ([[7.0, 0.05]], [2.0])
    """
    if not np.all(start > 0.0):
        raise IdentificationError(f"a refinement starts at {start.tolist()}; frequencies and dampings must be above 0")
    lower, upper = (np.broadcast_to(np.log(bound), start.shape).ravel() for bound in bounds)
    basis, _ = np.linalg.qr(fixed / np.maximum(np.linalg.norm(fixed, axis=0), np.finfo(float).tiny))
    target = response - basis @ (basis.T @ response)
    values = np.clip(np.log(start).ravel(), lower, upper)
    each = start.shape[1]
    place = _look(columns, basis, target, values, each)

    def look(numbers: Array, above: float) -> _Place | None:
        there = _look(columns, basis, target, numbers, each)
        return there if there.cost <= above else None

    end = descend(look, values, place, (lower, upper), RULE)
    inner: Array = np.exp(end.values).reshape(-1, each)
    return Refinement(inner, end.place.coefficients)


def _look(columns: Callable[[Array], Array], basis: Array, target: Array, values: Array, each: int) -> _Place:
    """Columns and their derivatives by each parameter's logarithm in one call, projected; least squares."""
    count = values.size // each
    inner = np.exp(values).reshape(-1, each)
    raised = [inner * np.exp(DIFFERENCE * np.eye(each)[axis]) for axis in range(each)]
    every = columns(np.vstack([inner, *raised]))
    bad = int(np.count_nonzero(~np.isfinite(every)))
    if bad:
        raise IdentificationError(
            f"{bad} of {every.size} values of the columns at {inner.tolist()} are not finite; a refinement needs them"
        )
    every = every - basis @ (basis.T @ every)
    now = every[:, :count]
    coefficients: Array = np.asarray(np.linalg.lstsq(now, target, rcond=None)[0], dtype=np.float64)
    residual = target - now @ coefficients
    jacobian = np.empty((target.size, values.size))
    for axis in range(each):
        slopes = (every[:, count * (axis + 1) : count * (axis + 2)] - now) / DIFFERENCE
        jacobian[:, axis::each] = -project_out(now, slopes * coefficients)
    return _Place(coefficients, residual, jacobian)
