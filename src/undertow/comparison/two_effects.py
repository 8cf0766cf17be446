"""Two effects seen at once: two that mask each other are both weak alone, and strong together.

One linear step from the prescribed equation in the coefficients of two places at once, over all pairs of places of the
suspects' grids; the best pairs are where fits of two effects start.

Belongs here: that step over pairs. Does not belong here: one suspect's step (score_test.py), fits (attempt.py), which
pair is believed (search.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from undertow.comparison.level import Level
from undertow.comparison.score_stack import SHOWN, Stack
from undertow.comparison.score_test import GridPlace, Stands, scaled_inverse, started
from undertow.comparison.suspect import Addition
from undertow.recording.recording import Array

WIDEST = 6
"""Coefficients of a place at most: those of every trial's own are no law of the body."""

PAIRS = 6
"""Pairs that are fitted of those that one linear step in both shows to be best."""

RCOND = 1e-4
"""Directions of less than this share of a place's information are taken up by the other one."""


@dataclass(frozen=True)
class PairLook:
    """Two places, by their suspects' labels, their additions where the joint step leads, by how much the log evidence
    could rise, and by how much with the better one alone."""

    labels: tuple[str, str]
    additions: tuple[tuple[Addition, ...], tuple[Addition, ...]]
    gain: float
    alone: float


def best_pairs(level: Level, stands: Stands, found: Sequence[GridPlace], count: int) -> list[PairLook]:
    """The best pairs of places of different suspects, at most ``count`` of them, one for each pair of suspects."""
    every = [p for p in found if p.columns and p.additions and 0 < p.width <= WIDEST]
    if len(every) < 2:
        return []
    stack = Stack.of(stands, every)
    shown = [i for i, (p, at) in enumerate(zip(stack.places, stack.slices, strict=True)) if stack.shows(p, at)]
    residuals = [r[:, None] for r in stands.fit.solution.residuals]
    score = stack.scores(residuals, stands.gradient[:, None])[:, 0]
    index, filled = _padded(stack, shown)
    labels = np.array([stack.places[i].label for i in shown])
    best: dict[tuple[str, str], tuple[float, int, int]] = {}
    for place, i in enumerate(shown):
        gains = _gains_beside(stack, score, stack.slices[i], index, filled)
        gains[: place + 1] = 0.0
        gains[labels == labels[place]] = 0.0
        for at in _first_of_each(labels, gains):
            pair = (str(labels[place]), str(labels[at]))
            if gains[at] > best.get(pair, (0.0,))[0]:
                best[pair] = (float(gains[at]), i, shown[at])
    ahead = sorted(best.values(), key=lambda one: -one[0])
    looks = (_look(level, stack, score, gain, i, j) for gain, i, j in ahead)
    return [look for look, _ in zip((one for one in looks if one is not None), range(count), strict=False)]


def _padded(stack: Stack, shown: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Columns of every place side by side, (places, widest), and which of them are its own."""
    widest = max(stack.places[i].width for i in shown)
    index = np.zeros((len(shown), widest), dtype=np.int64)
    filled = np.zeros((len(shown), widest), dtype=bool)
    for row, i in enumerate(shown):
        width = stack.places[i].width
        index[row, :width] = np.arange(stack.slices[i].start, stack.slices[i].stop)
        filled[row, :width] = True
    return index, filled


def _gains_beside(stack: Stack, score: Array, at: slice, index: np.ndarray, filled: np.ndarray) -> Array:
    """Gain of one place together with every other, (places,)."""
    own = scaled_inverse(stack.information[at, at], RCOND)
    alone = 0.5 * float(score[at] @ own @ score[at])
    across = stack.information[at][:, index] * filled  # (q, places, widest)
    slope = (score[index] - np.einsum("qpw,q->pw", across, own @ score[at])) * filled
    blocks = stack.information[index[:, :, None], index[:, None, :]] * (filled[:, :, None] & filled[:, None, :])
    left = blocks - np.einsum("qpw,qr,rpv->pwv", across, own, across)
    scale = 1.0 / np.sqrt(np.maximum(np.einsum("pww->pw", blocks), 1e-300))
    scale = np.where(filled, scale, 0.0)
    inverse = np.linalg.pinv(left * scale[:, :, None] * scale[:, None, :], rcond=RCOND, hermitian=True)
    told = np.max(np.einsum("pww->pw", left) * scale**2, axis=1) > SHOWN
    turned = slope * scale * told[:, None]
    return np.asarray(alone + 0.5 * np.einsum("pw,pwv,pv->p", turned, inverse, turned), dtype=np.float64)


def _first_of_each(labels: np.ndarray, gains: Array) -> list[int]:
    """Index of the largest gain of every label that has one."""
    order = np.argsort(-gains)
    _, first = np.unique(labels[order], return_index=True)
    return [int(order[i]) for i in first if gains[order[i]] > 0.0]


def _look(level: Level, stack: Stack, score: Array, gain: float, i: int, j: int) -> PairLook | None:
    """The pair where its joint step leads; None where that is against a sign."""
    both = np.concatenate([np.arange(stack.slices[n].start, stack.slices[n].stop) for n in (i, j)])
    step = -scaled_inverse(stack.information[np.ix_(both, both)], RCOND) @ score[both]
    cut = stack.places[i].width
    moved = []
    for place, mine in ((stack.places[i], step[:cut]), (stack.places[j], step[cut:])):
        signed = place.whole or any((a.takes or a.lower >= 0.0) and not a.inner for a in place.additions)
        if signed and np.max(mine) <= 0.0:
            return None
        moved.append(place.additions if place.whole else started(level, place.additions, mine))
    labels = stack.places[i].label, stack.places[j].label
    alone = max(p.gain for p in stack.places if p.label in labels)
    return PairLook(labels, (moved[0], moved[1]), gain, alone)
