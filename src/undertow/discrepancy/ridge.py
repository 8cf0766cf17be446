"""Laws without names, learned on all trials but one and tried on that one.

Least squares with a penalty on the size of the coefficients (ridge); its strength is the one that predicts left-out
trials best. A bank is not used where what it gains on left-out trials is not distinct from zero. Every trial counts by
its weight, whatever its size.

Source: Hoerl and Kennard 1970, doi:10.1080/00401706.1970.10488634.

Belongs here: the learning, on normal matrices. Does not belong here: the columns (bank.py) or what they mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from undertow.equation.term import Array
from undertow.errors import IdentificationError

STRENGTHS = (1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0)
"""Penalties tried, relative to the columns' own sums of squares: at the weakest, forces that cancel may be a hundred
times what they explain, no more; a bank of memory could else build any force out of the inertia itself."""

TOLD_FROM_ZERO = 2.0
"""A bank's mean gain on left-out trials must be this many times its standard error over trials."""

TINY = 1e-12
"""Penalty of columns that are fitted freely, relative likewise: keeps collinear ones solvable."""


@dataclass(frozen=True)
class _Learned:
    """Coefficients with each trial left out in turn, (trials, p), and the share of its square sum left over, (trials,),
    times its weight."""

    values: Array
    left: Array


def left_out_residuals(
    ys: Sequence[Array], free: Sequence[Array], banks: Sequence[Sequence[Array]], weights: Sequence[float]
) -> tuple[list[Array], ...]:
    """What is left of every trial's ``ys`` (n,): after the ``free`` columns fitted to all trials, then with each bank
    of columns added in turn, learned on the other trials.

    ``free`` (n, q) and each bank's (n, p) have one array a trial; ``weights`` from 0 (nothing is learned from this
    trial) to 1. IdentificationError with fewer than two trials of a weight above zero.

    >>> y = [np.array([1.0, 2.0, -1.0]), np.array([2.0, 0.5, 0.0])]
    >>> none = [np.zeros((3, 0))] * 2
    >>> after = left_out_residuals(y, none, [[3.0 * one[:, None] for one in y]], [1.0, 1.0])
    >>> bool(np.max(np.abs(after[1][0])) < 1e-3)
    True
    """
    heard = sum(w > 0.0 for w in weights)
    if heard < 2:
        raise IdentificationError(
            f"{heard} of {len(ys)} trials have a weight above 0; a law is learned on one and tried on another: give two"
        )
    widths = [free[0].shape[1], *(bank[0].shape[1] for bank in banks)]
    tables = [np.hstack([f, *(b[i] for b in banks)]) for i, f in enumerate(free)]
    scale = np.sqrt(np.mean([np.mean(t**2, axis=0) for t in tables], axis=0))
    tables = [t / np.where(scale > 0.0, scale, 1.0) for t in tables]
    grams = [w * _gram(t, y) for t, y, w in zip(tables, ys, weights, strict=True)]
    penalty = np.full(widths[0], TINY)
    together = _solve(grams, penalty)
    after = [[y - t[:, : widths[0]] @ together for t, y in zip(tables, ys, strict=True)]]
    best = _learn(grams, penalty)
    for width in widths[1:]:
        without = np.concatenate([penalty, np.full(width, np.inf)])
        choices = [np.concatenate([penalty, np.full(width, s)]) for s in STRENGTHS]
        learned = [_learn(grams, choice) for choice in choices]
        at = int(np.argmin([np.sum(one.left) for one in learned]))
        gains = (best.left - learned[at].left)[np.array(weights) > 0.0]
        if float(np.mean(gains)) > TOLD_FROM_ZERO * float(np.std(gains, ddof=1)) / np.sqrt(gains.size):
            penalty, best = choices[at], learned[at]
        else:
            penalty, best = without, _learn(grams, without)
        after.append(
            [y - t[:, : penalty.size] @ b for t, y, b in zip(tables, ys, best.values, strict=True)]
        )
    return tuple(after)


def _gram(table: Array, y: Array) -> Array:
    """Normal matrix of columns and response, (p + 1, p + 1), in units of the response's sum of squares."""
    both = np.column_stack([table, y])
    return np.asarray(both.T @ both / max(float(y @ y), 1e-300), dtype=np.float64)


def _solve(grams: Sequence[Array], penalty: Array) -> Array:
    """Ridge coefficients (p,) of the first p columns; infinite penalties leave their columns out."""
    total = np.sum(grams, axis=0)
    used = np.flatnonzero(np.isfinite(penalty))
    values = np.zeros(penalty.size)
    if used.size:
        normal = total[np.ix_(used, used)]
        sizes = np.maximum(np.diag(normal), 1e-300)
        values[used] = np.linalg.solve(normal + np.diag(penalty[used] * sizes), total[used, -1])
    return values


def _learn(grams: Sequence[Array], penalty: Array) -> _Learned:
    """Coefficients with each trial left out, and how much of that trial they leave."""
    values, left = [], []
    count = penalty.size
    for i, gram in enumerate(grams):
        b = _solve([g for j, g in enumerate(grams) if j != i], penalty)
        values.append(b)
        left.append(float(gram[-1, -1] - 2.0 * b @ gram[:count, -1] + b @ gram[:count, :count] @ b))
    return _Learned(np.array(values), np.array(left))
