"""How far printed rows may scatter by themselves, beyond what the structure's own scatter and digits make.

Nobody prints it, so it is summed over: a grid of (kg of m_a, share of C_d), even in both logarithms up to what a fit of
a whole decay can miss. Beyond lies the belief that a column is noise, which explains any table: what a verdict owes to
the cap is read off the same grid and said with it.

Belongs here: the grid and its prior. Does not belong here: likelihoods (sampling.py), evidence (posterior.py).
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from undertow.audit.case import PrintedCase
from undertow.audit.recipes import Array

MASS_SHARES = tuple(np.geomspace(0.001, 0.2, 8))
"""Scatter of a printed m_a over the structure's mass; from a fifth on a column says nothing of the water."""

DRAG_SHARES = tuple(np.geomspace(0.005, 0.4, 6))
"""The same of a printed C_d, over its value."""

BELIEVED = 0.05
"""Share of the mass that rows may scatter by: 5 % are a quarter of a cycle of phase after ten cycles, more than a fit
of a whole decay can miss."""

CAPS = (BELIEVED, 0.1, 0.2)
"""Caps under which a verdict is looked at again."""


def scatters(case: PrintedCase) -> tuple[tuple[float, float], ...]:
    """The grid of scatters summed over, (S,): kg of m_a, share of C_d."""
    return tuple((share * case.mass_kg, drag) for share, drag in product(MASS_SHARES, DRAG_SHARES))


def log_belief(cap: float = BELIEVED) -> Array:
    """Logarithm of the prior of each scatter of the grid, (S,), summing to one: even up to ``cap``, a share of the
    mass.

    >>> [round(float(np.exp(log_belief(cap)).sum()), 12) for cap in CAPS]
    [1.0, 1.0, 1.0]
    >>> bool(np.exp(log_belief())[-1] == 0.0)
    True
    """
    share = np.repeat(np.array(MASS_SHARES), len(DRAG_SHARES))
    inside = (share <= cap * (1.0 + 1e-9)).astype(np.float64)
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(inside / inside.sum()), dtype=np.float64)


def log_sum(logs: Array) -> float:
    """Logarithm of the sum of exp(logs), safe against overflow.

    >>> round(log_sum(np.log([1.0, 3.0])), 12) == round(math.log(4.0), 12)
    True
    """
    highest = float(np.max(logs))
    return highest + math.log(float(np.sum(np.exp(logs - highest)))) if math.isfinite(highest) else -math.inf
