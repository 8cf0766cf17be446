"""The exact search over all subsets of columns, and what it tells besides the winner.

Belongs here: the criterion of every subset, rivals, the evidence for a column. Does not belong here: pysindy
(subset.py), correlated noise, physics.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.errors import IdentificationError

Array = NDArray[np.float64]

MAX_FREE_COLUMNS = 20
"""2^20 subsets take about a second and some 100 MB; each further column doubles both."""

COLLINEAR = 1e-10
"""A unit column with less than this square left after the others is a combination of them."""

SIGN_CHECK_CHUNK = 16_384
"""Subsets whose coefficients are solved for at once when signs are looked at."""

SIGN_CHECK_MARGIN = 60.0
"""Odds of e^30 against: subsets so far behind the best allowed one weigh nothing whatever their signs."""


@dataclass(frozen=True)
class Subset:
    """A subset: its columns and its criterion."""

    columns: tuple[int, ...]
    criterion: float


@dataclass(frozen=True)
class SubsetSearch:
    """Outcome of a search over all subsets.

    ``evidence`` maps a column to the criterion of the best subset without it less that of the best one with it:
    above 0 it is needed (inf where forced).
    """

    best: Subset
    rivals: tuple[Subset, ...]
    evidence: Mapping[int, float]
    n_effective: float

    def support(self, columns: int, nuisance: Sequence[int] = ()) -> NDArray[np.bool_]:
        """(columns,) True for the best subset's columns and for the nuisance."""
        chosen = np.zeros(columns, dtype=bool)
        chosen[[*self.best.columns, *nuisance]] = True
        return chosen


def search_subsets(
    information: Array,
    moments: Array,
    labels: Sequence[int],
    n_effective: float,
    forced: Sequence[int] = (),
    signs: Mapping[int, int] | None = None,
    rival_difference: float = 6.0,
    together: Sequence[Sequence[int]] = (),
    exclusive: Sequence[Sequence[int]] = (),
) -> SubsetSearch:
    """Every subset of columns by how much the data resist that the other coefficients are 0.

    Coefficients theta of all columns have the ``information`` matrix (p, p), the inverse of their covariance;
    ``moments`` (p,) is information @ theta. The misfit of a subset S is the smallest (theta - t)' information
    (theta - t) over all t that are 0 outside S. Its criterion is the extended BIC with gamma 1/2 (Chen and Chen 2008,
    doi:10.1093/biomet/asn034), misfit + |S| [ln(n_effective) + ln(q)], q being the free columns: the more laws are
    offered, the more one of them looks right by chance. ``labels`` (p,) are the names by which ``forced``, ``signs``,
    ``together`` (columns that enter all or none), ``exclusive`` (of which at most one enters) and the result speak of
    the columns.

    Raises IdentificationError with more than 20 free columns, forced columns that are collinear, or constraints that
    leave no subset.
    """
    place = {label: index for index, label in enumerate(labels)}
    held = [place[label] for label in forced]
    free = [index for index in range(len(labels)) if index not in held]
    if len(free) > MAX_FREE_COLUMNS:
        raise IdentificationError(
            f"{len(free)} free columns; all subsets can be tried up to {MAX_FREE_COLUMNS}: "
            "force the terms known to be there or leave some out"
        )
    gram = _gram(information, moments)
    sums = np.maximum(residual_sums(_reduced(gram, held, free, labels)), 0.0)
    counts = np.array([int(mask).bit_count() for mask in range(sums.size)]) + len(held)
    criteria = sums + counts * (np.log(n_effective) + np.log(max(len(free), 1)))
    names = tuple(labels[index] for index in free)
    criteria[_forbidden(names, tuple(forced), together, exclusive)] = np.inf
    limits = {place[label]: sign for label, sign in (signs or {}).items() if label in place}
    if limits:
        _refuse(criteria, gram, held, free, limits)
    if not np.any(np.isfinite(criteria)):
        raise IdentificationError(
            f"none of {sums.size} subsets obeys the signs {dict(signs or {})}, together {[list(g) for g in together]} "
            f"and exclusive {[list(g) for g in exclusive]}; free the sign of a forced column or loosen a group"
        )
    return _Table(criteria, tuple(forced), names).summarise(rival_difference, n_effective)


def _forbidden(
    names: Sequence[int], forced: Sequence[int], together: Sequence[Sequence[int]], exclusive: Sequence[Sequence[int]]
) -> NDArray[np.bool_]:
    """Which masks over ``names`` break up a group that belongs together or hold two of an exclusive one."""
    masks = np.arange(2 ** len(names))
    broken = np.zeros(masks.size, dtype=bool)
    for groups, most in ((together, None), (exclusive, 1)):
        for group in groups:
            inside = sum(((masks >> names.index(label)) & 1 for label in group if label in names), 0 * masks)
            inside = inside + sum(label in forced for label in group)
            broken |= (inside > most) if most is not None else (inside > 0) & (inside < len(group))
    return broken


def _gram(information: Array, moments: Array) -> Array:
    """Gram matrix (p + 1, p + 1) of unit columns and a response with these moments; signs stay as they are."""
    scale = np.sqrt(np.maximum(np.diag(information), np.finfo(float).tiny))
    size = moments.size
    gram = np.empty((size + 1, size + 1))
    gram[:size, :size] = information / np.outer(scale, scale)
    gram[size, :size] = gram[:size, size] = moments / scale
    gram[size, size] = moments @ np.linalg.lstsq(information, moments, rcond=None)[0]
    return gram


def residual_sums(gram: Array) -> Array:
    """Residual sums of squares of all subsets, (2^p,), from ``gram`` (p + 1, p + 1) of columns and response (last).

    Bit j of the index says whether column j is in. Column by column the table doubles: one half leaves the column out,
    the other takes it in by a Schur complement. inf where a column is a combination of those before it.

    >>> columns = np.array([[1.0, 0.0, 2.0], [0.0, 1.0, 1.0]])   # unit vectors and the response (2, 1)
    >>> residual_sums(columns.T @ columns).tolist()
    [5.0, 1.0, 4.0, 0.0]
    """
    table, valid = gram[None], np.ones(1, dtype=bool)
    for _ in range(gram.shape[0] - 1):
        pivot = table[:, 0, 0]
        usable = pivot > COLLINEAR
        inverse = np.where(usable, 1.0 / np.where(usable, pivot, 1.0), 0.0)
        row = table[:, 0, 1:]
        without = table[:, 1:, 1:]
        table = np.concatenate([without, without - row[:, :, None] * (row * inverse[:, None])[:, None, :]])
        valid = np.concatenate([valid, valid & usable])
    return np.where(valid, table[:, 0, 0], np.inf)


def _reduced(gram: Array, held: Sequence[int], free: Sequence[int], labels: Sequence[int]) -> Array:
    """Gram matrix of the free columns and the response after the held ones are taken in."""
    rest = [*free, gram.shape[0] - 1]
    reduced: Array = gram[np.ix_(rest, rest)]
    if not held:
        return reduced
    own, cross = gram[np.ix_(held, held)], gram[np.ix_(held, rest)]
    smallest = float(np.linalg.eigvalsh(own)[0])
    if smallest <= COLLINEAR:
        raise IdentificationError(
            f"forced columns {[labels[index] for index in held]} are combinations of each other (smallest eigenvalue "
            f"{smallest:.2g} of their correlation matrix, more than {COLLINEAR:g} is needed); force fewer of them"
        )
    return reduced - cross.T @ np.linalg.solve(own, cross)


def _refuse(
    criteria: Array, gram: Array, held: Sequence[int], free: Sequence[int], limits: Mapping[int, int]
) -> None:
    """Set the criterion of subsets that break a sign to inf, in place.

    The best are looked at first; once one obeys, those more than `SIGN_CHECK_MARGIN` behind it keep their criterion.
    """
    order = np.argsort(criteria)
    order = order[np.isfinite(criteria[order])]
    best = np.inf
    for first in range(0, order.size, SIGN_CHECK_CHUNK):
        chunk = order[first : first + SIGN_CHECK_CHUNK]
        if criteria[chunk[0]] > best + SIGN_CHECK_MARGIN:
            break
        broken = _breaks_sign(chunk, gram, held, free, limits)
        if not np.all(broken):
            best = min(best, float(criteria[chunk[~broken]].min()))
        criteria[chunk[broken]] = np.inf


def _breaks_sign(
    masks: NDArray[np.int64], gram: Array, held: Sequence[int], free: Sequence[int], limits: Mapping[int, int]
) -> NDArray[np.bool_]:
    """Whether the least-squares coefficients of each subset break a sign, (n_masks,)."""
    bits = (masks[:, None] >> np.arange(len(free))) & 1
    sizes = bits.sum(axis=1)
    broken = np.zeros(masks.size, dtype=bool)
    for size in np.unique(sizes):
        rows = np.flatnonzero(sizes == size)
        if size + len(held) == 0:
            continue
        chosen = np.nonzero(bits[rows])[1].reshape(rows.size, int(size))
        members = np.hstack([np.tile(held, (rows.size, 1)).astype(int), np.asarray(free, dtype=int)[chosen]])
        normal = gram[members[:, :, None], members[:, None, :]]
        values = np.linalg.solve(normal, gram[members, -1][:, :, None])[:, :, 0]
        for column, sign in limits.items():
            broken[rows] |= np.any((members == column) & (sign * values < 0.0), axis=1)
    return broken


@dataclass(frozen=True)
class _Table:
    """Criteria (2^p,) of all subsets; bit j of an index stands for names[j]."""

    criteria: Array
    forced: tuple[int, ...]
    names: tuple[int, ...]

    def summarise(self, rival_difference: float, n_effective: float) -> SubsetSearch:
        winner = int(np.argmin(self.criteria))
        close = np.isfinite(self.criteria) & (self.criteria <= self.criteria[winner] + rival_difference)
        near = np.flatnonzero(close)
        near = near[np.argsort(self.criteria[near])]
        evidence = {label: float("inf") for label in self.forced}
        masks = np.arange(self.criteria.size)
        for bit, label in enumerate(self.names):
            inside = (masks >> bit) & 1 == 1
            evidence[label] = _difference(self.criteria[~inside].min(), self.criteria[inside].min())
        return SubsetSearch(
            best=self.candidate(winner),
            rivals=tuple(self.candidate(int(mask)) for mask in near if mask != winner),
            evidence=evidence,
            n_effective=n_effective,
        )

    def candidate(self, mask: int) -> Subset:
        chosen = [name for bit, name in enumerate(self.names) if mask >> bit & 1]
        return Subset(tuple(sorted([*self.forced, *chosen])), float(self.criteria[mask]))


def _difference(without: float, within: float) -> float:
    """without - within, -inf where no subset with the column is allowed."""
    return float("-inf") if not np.isfinite(within) else float(without - within)
