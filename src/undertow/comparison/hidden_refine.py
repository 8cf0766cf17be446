"""Inner parameters of columns by variable projection.

A hidden oscillator enters an equation linearly by its mass, but not by its frequency and damping. Least squares
eliminates everything linear; Gauss-Newton with damping moves the rest.

    min over q of | r - Phi(q) theta(q) |^2,    theta(q) = Phi(q)^+ r

Source: Golub and Pereyra 1973, doi:10.1137/0710036; the Jacobian is Kaufman's 1975 (doi:10.1007/BF01932995), which
leaves out a part that vanishes with the residual.

Belongs here: the iteration. Does not belong here: what the columns are (hidden_library.py) or which start is taken
(hidden_search.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.errors import IdentificationError
from undertow.methods.subset import project_out

Array = NDArray[np.float64]

INNER_BOUNDS = ((0.05, 1e-3), (500.0, 0.95))
"""Widest (w in rad/s, zeta) that a refinement may reach: below, an oscillator is a drift or without damping."""

DIFFERENCE = 1e-4
"""Step of the derivative in the logarithm of a parameter: a response is smooth in it, rounding stays below 1e-8."""

MAX_ITERATIONS = 30
FIRST_DAMPING = 1e-3
LARGEST_STEP = 0.5
"""Largest change of a logarithm at once: a factor of 1.6, so that a flat start does not fling a frequency away."""

SMALLEST_STEP = 1e-5
"""The search ends when no parameter moves by more than this share of itself: far below any standard error here."""


@dataclass(frozen=True)
class Refinement:
    """Where the iteration ended: ``inner`` (m, k), the columns' ``coefficients`` (m,), the residual's sum of squares,
    iterations taken, and whether it came to rest."""

    inner: Array
    coefficients: Array
    squares: float
    iterations: int
    converged: bool


@dataclass(frozen=True)
class _Place:
    """Projected columns with their derivatives at one set of parameters, and the least squares there."""

    coefficients: Array
    residual: Array
    jacobian: Array

    @property
    def squares(self) -> float:
        """Sum of the residual's squares."""
        return float(self.residual @ self.residual)


def refine_inner(
    columns: Callable[[Array], Array],
    fixed: Array,
    response: Array,
    start: Array,
    bounds: tuple[Array, Array],
    iterations: int = MAX_ITERATIONS,
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
    place, damping = _look(columns, basis, target, values, each), FIRST_DAMPING
    for iteration in range(1, iterations + 1):
        step = _step(place, damping)
        proposed = np.clip(values + step, lower, upper)
        moved = float(np.max(np.abs(proposed - values)))
        if moved < SMALLEST_STEP:
            return _done(values.reshape(-1, each), place, iteration, True)
        candidate = _look(columns, basis, target, proposed, each)
        if candidate.squares < place.squares:
            values, place, damping = proposed, candidate, 0.2 * damping
        else:
            damping *= 10.0
    return _done(values.reshape(-1, each), place, iterations, False)


def _done(values: Array, place: _Place, iterations: int, converged: bool) -> Refinement:
    inner: Array = np.exp(values)
    return Refinement(inner, place.coefficients, place.squares, iterations, converged)


def _step(place: _Place, damping: float) -> Array:
    normal = place.jacobian.T @ place.jacobian
    scale = np.maximum(np.diag(normal), np.finfo(float).tiny)
    normal[np.diag_indices(scale.size)] += damping * scale
    step = -np.linalg.lstsq(normal, place.jacobian.T @ place.residual, rcond=None)[0]
    limited = np.asarray(np.clip(step, -LARGEST_STEP, LARGEST_STEP), dtype=np.float64)
    return limited


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
