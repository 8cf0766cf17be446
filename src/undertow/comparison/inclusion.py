"""How often a term would be found again: the search repeated on blocks of the motion drawn with replacement.

Belongs here: the resampling of a linear problem by blocks within its trials. Does not belong here: the search itself
(exact_subsets.py), or how the problem came about (stepwise_selection.py).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.stepwise_selection import Selected
from undertow.errors import IdentificationError
from undertow.methods.exact_subsets import search_subsets

Array = NDArray[np.float64]

BLOCK_CELLS = 50
"""Rows of a block: one period of the motion."""


def inclusion(found: Selected, resamples: int = 100, seed: int = 0) -> tuple[float, ...]:
    """Share of resampled campaigns whose best subset holds each term of the library, (n_terms,).

    Each channel of each trial is cut into blocks of a period, drawn with replacement; the coefficients of the full
    library are estimated anew and the exact search is repeated with the information of the whole data. The noise enters
    twice, in the data and in the draw, so that the shares are on the careful side.

    Raises IdentificationError for fewer than 10 ``resamples``.
    """
    if resamples < 10:
        raise IdentificationError(f"{resamples} resamples give no probability; draw at least 10, better 100")
    columns = found.linear.columns[:, list(found.offered)]
    grams, moments, trial_of = block_sums(columns, found.linear.response, found.linear.lengths, BLOCK_CELLS)
    information = found.optimizer.information_[0]
    rng = np.random.default_rng(seed)
    counts = np.zeros(len(found.book.terms))
    for _ in range(resamples):
        weights = drawn(trial_of, rng)
        gram, moment = np.tensordot(weights, grams, axes=1), weights @ moments
        theta = np.linalg.lstsq(gram, moment, rcond=None)[0]
        search = search_subsets(
            information,
            information @ theta,
            labels=range(len(found.offered)),
            n_effective=found.search.n_effective,
            forced=tuple(found.optimizer.forced),
            signs=found.optimizer.signs,
            together=tuple(found.optimizer.together),
            exclusive=tuple(found.optimizer.exclusive),
        )
        counts[list(found.terms_of(search.best))] += 1.0
    return tuple((counts / resamples).tolist())


def block_sums(
    columns: Array, response: Array, lengths: Sequence[int], block: int
) -> tuple[Array, Array, NDArray[np.int64]]:
    """X'X (b, p, p) and X'y (b, p) of every block of ``block`` rows, and the part (b,) that it belongs to.

    ``lengths`` are the rows of the parts in order; the last block of a part takes in what is left over.
    """
    grams, moments, part_of, first = [], [], [], 0
    for part, length in enumerate(lengths):
        if not length:
            continue
        edges = first + block * np.arange(max(length // block, 1))
        for start, end in zip(edges, [*edges[1:], first + length], strict=True):
            x, y = columns[start:end], response[start:end]
            grams.append(x.T @ x)
            moments.append(x.T @ y)
            part_of.append(part)
        first += length
    return np.array(grams), np.array(moments), np.array(part_of, dtype=np.int64)


def drawn(part_of: NDArray[np.int64], rng: np.random.Generator) -> Array:
    """How often each block is drawn (b,), as many as there are from each part."""
    weights = np.zeros(part_of.size)
    for part in np.unique(part_of):
        own = np.flatnonzero(part_of == part)
        weights[own] = np.bincount(rng.integers(0, own.size, own.size), minlength=own.size)
    return weights
