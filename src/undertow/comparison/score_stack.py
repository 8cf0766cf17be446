"""All places of all suspects side by side, and one of them as scored: products that every replica shares.

Belongs here: those sums. Does not belong here: replicas (replicas.py), one place's columns (score_test.py), p-values
(null_test.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from undertow.comparison.replicas import ONE_SIDED
from undertow.comparison.score_test import GridPlace, Stands
from undertow.comparison.sizes import COUNTS_IN_REPEATABILITY, Measure
from undertow.recording.recording import Array

SHOWN = 1e-6
"""Share of a place's information that what stands must leave: all else is taken up, and nothing can be said of it."""


@dataclass(frozen=True)
class Stack:
    """All places side by side: by trial their columns (rows, m) and indices (m,), the products of all columns with each
    other and with what stands (``away``), everything that stands moving along, and by place its slice."""

    stands: Stands
    places: tuple[GridPlace, ...]
    columns: tuple[tuple[Array, np.ndarray], ...]
    away: Array
    information: Array
    slices: tuple[slice, ...]

    @classmethod
    def of(cls, stands: Stands, places: Sequence[GridPlace]) -> Stack:
        """From the places of all suspects, one after the other."""
        ends = np.cumsum([p.width for p in places])
        slices = tuple(slice(int(end) - p.width, int(end)) for p, end in zip(places, ends, strict=True))
        width = int(ends[-1])
        cross = np.hstack([p.cross for p in places])
        products = np.zeros((width, width))
        columns = []
        for trial in range(len(stands.fit.solution.problem.trials)):
            mine = np.hstack([p.columns[trial][0] for p in places])
            where = np.concatenate([s.start + p.columns[trial][1] for p, s in zip(places, slices, strict=True)])
            products[np.ix_(where, where)] += mine.T @ mine
            columns.append((mine, where))
        away = cross.T @ stands.inverse
        products -= away @ cross  # in place: of 60 trials, each with forces of its own, it has 7,000 columns
        return cls(stands, tuple(places), tuple(columns), away, products, slices)

    def shows(self, place: GridPlace, at: slice) -> bool:
        """Whether what stands leaves anything of a place's columns."""
        left = np.diag(self.information[at, at]) / np.maximum(np.diag(place.own), 1e-300)
        return bool(np.max(left) >= SHOWN)

    def scores(self, residuals: Sequence[Array], gradient: Array) -> Array:
        """Scores (width, n) of residuals (rows, n) of every trial, with the gradient (unknowns, n) of what stands."""
        out = -self.away @ gradient
        for (mine, where), r in zip(self.columns, residuals, strict=True):
            out[where] += mine.T @ r
        return np.asarray(out, dtype=np.float64)


@dataclass(frozen=True)
class Scored:
    """One place scored: its slice in the stack, the recordings' score (q,), replicas' (q, draws), the same without the
    tolerance, information (q, q) and its inverse, how large effects are, and what share of the replicas' variance is
    what instruments are believed to do."""

    place: GridPlace
    at: slice
    score: Array
    draws: Array
    noise: Array
    information: Array
    inverse: Array
    measure: Measure
    of_instruments: float = 0.0

    @property
    def gains(self) -> Array:
        """Gain of every replica, (draws,)."""
        if self.place.whole:
            return np.asarray(np.maximum(-self.draws[0] - 0.5 * self.information[0, 0], 0.0), dtype=np.float64)
        return np.asarray(0.5 * np.einsum("qd,qd->d", self.draws, self.inverse @ self.draws), dtype=np.float64)

    @property
    def gain(self) -> float:
        """Gain of the recordings."""
        if self.place.whole:
            return max(float(-self.score[0] - 0.5 * self.information[0, 0]), 0.0)
        return 0.5 * float(self.score @ self.inverse @ self.score)

    @property
    def step(self) -> Array:
        """Estimated coefficients (q,): of a whole law 1."""
        if self.place.whole:
            return np.ones(1)
        return np.asarray(-self.inverse @ self.score)

    @property
    def hidden(self) -> float:
        """The largest free-run error that can still hide here (95 %), in units of what counts."""
        if self.place.whole:
            share, width = -float(self.inverse[0, 0] * self.score[0]), float(self.inverse[0, 0] * np.std(self.noise[0]))
            there = share + ONE_SIDED * width >= 1.0
            return float(self.measure.of_free_run(self.step[:, None])[0]) / COUNTS_IN_REPEATABILITY if there else 0.0
        spread = self.inverse @ np.atleast_2d(np.cov(self.noise, bias=True)) @ self.inverse
        return self.measure.bound(self.step, spread, ONE_SIDED)
