"""What a regression's coefficients would have been with other stretches of the same motions: a block bootstrap.

A pooled regression needs only X'X and X'y. Summed over blocks once, any resampling is a weighted sum of small matrices
and all resampled models are solved for in one call: a thousand models in milliseconds. Blocks are longer than the
residual's memory; trials, which differ by more than their noise, are drawn whole.

Belongs here: draws of coefficients and what follows from them. Does not belong here: the columns (library.py), the
stated errors of SINDy (robust.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from undertow.conditioning.motion import Motion
from undertow.equation.registry import find
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.methods.library import build_design
from undertow.methods.subset import project_out
from undertow.uncertainty.confidence import INTERVAL_LEVEL, widening

Array = NDArray[np.float64]

FEWEST_DRAWS = 50
"""Below that a 90 % interval's ends are single draws."""

FEWEST_BLOCKS = 4
"""A trial must fall into this many blocks: fewer do not show how they differ."""


@dataclass(frozen=True)
class BootstrapDraws:
    """Coefficients of all data ``values`` (p,) and of every resampling ``draws`` (m, p), in the columns' units;
    ``trials`` is how many trials were drawn from (0: blocks within fixed trials)."""

    names: tuple[str, ...]
    values: Array
    draws: Array
    trials: int

    @property
    def covariance(self) -> Array:
        """Covariance (p, p) of the draws; n / (n - 1) where n trials were drawn."""
        grown = self.trials / (self.trials - 1.0) if self.trials > 1 else 1.0
        return np.atleast_2d(np.cov(self.draws, rowvar=False)) * grown

    @property
    def stderr(self) -> Array:
        """Standard errors (p,), widened as Student's t says for few trials: a percentile of 3 trials' draws covers 63 %
        where 90 % is meant."""
        factor = widening(self.trials - 1.0) if self.trials > 1 else 1.0
        return np.asarray(np.sqrt(np.diag(self.covariance)) * factor, dtype=np.float64)

    def interval(self, level: float = INTERVAL_LEVEL) -> tuple[Array, Array]:
        """Percentile interval of the draws, two arrays (p,): for skewed coefficients of many blocks."""
        tail = 0.5 * (1.0 - level)
        low, high = np.quantile(self.draws, [tail, 1.0 - tail], axis=0)
        return np.asarray(low), np.asarray(high)


def block_bootstrap(
    columns: Array, response: Array, lengths: Sequence[int], block: int, draws: int = 1000, seed: int = 0,
    whole_trials: bool = True, names: Sequence[str] = (),
) -> BootstrapDraws:  # fmt: skip
    """Resampled least squares of ``response`` (n,) on ``columns`` (n, p), the rows of trials of ``lengths`` on end.

    ``whole_trials`` draws trials as they are, since trials differ by more than their noise; without it each trial keeps
    its place and its blocks of ``block`` rows are drawn (Carlstein 1986, doi:10.1214/aos/1176350057).

    Raises IdentificationError where lengths do not add up, there are too few trials or blocks, or draws are few.

    >>> rng = np.random.default_rng(0)
    >>> x = rng.standard_normal((4000, 1))
    >>> found = block_bootstrap(x, 2.0 * x[:, 0] + rng.standard_normal(4000), [4000], 10, whole_trials=False)
    >>> round(float(found.values[0]), 1), round(float(found.stderr[0]) * 4000**0.5, 1)
    (2.0, 1.0)
    """
    if sum(lengths) != response.size or columns.shape[0] != response.size:
        raise IdentificationError(
            f"bootstrap: trials of {sum(lengths)} rows, {columns.shape[0]} rows of columns, {response.size} of "
            "response; give the lengths of the trials in order"
        )
    if draws < FEWEST_DRAWS:
        raise IdentificationError(f"bootstrap: {draws} draws give no interval; draw at least {FEWEST_DRAWS}")
    counts = [1] * len(lengths) if whole_trials else [length // block for length in lengths]
    _check(lengths, counts, block, whole_trials)
    grams, moments = _sums(columns, response, lengths, counts)
    weights = _weights(counts, draws, np.random.default_rng(seed), whole_trials)
    gram = np.tensordot(weights, grams, axes=1)
    scale = 1.0 / np.sqrt(np.maximum(np.einsum("ii->i", np.sum(grams, axis=0)), np.finfo(float).tiny))
    right = (weights @ moments) * scale
    solved = np.linalg.solve(gram * np.outer(scale, scale), right[:, :, None])[:, :, 0] * scale
    whole = np.linalg.lstsq(columns, response, rcond=None)[0]
    labels = tuple(names) or tuple(f"column {i}" for i in range(columns.shape[1]))
    return BootstrapDraws(labels, np.asarray(whole), solved, len(counts) if whole_trials else 0)


def bootstrap_sindy(
    motions: Sequence[Motion], terms: Sequence[str | Term], draws: int = 1000, seed: int = 0, periods: float = 1.0
) -> BootstrapDraws:
    """Block bootstrap of the prescribed equation's coefficients over mass, several trials pooled as in SINDy; ``terms``
    are laws of the registry by name, or terms.

    A block is ``periods`` of the motion. With one trial its blocks are drawn, with more whole trials too.
    """
    named = [find(term) if isinstance(term, str) else term for term in terms]
    library = [term for term in named if not term.is_inertia]
    design = build_design(motions, library)
    block = max(2, round(periods * design.period_s / design.step_s))
    columns = project_out(design.nuisance, design.columns)
    response = project_out(design.nuisance, design.response[:, None])[:, 0]
    return block_bootstrap(
        columns, response, design.lengths, block, draws, seed, len(design.lengths) > 1, design.names
    )


def _check(lengths: Sequence[int], counts: Sequence[int], block: int, whole_trials: bool) -> None:
    if whole_trials and len(lengths) < 2:
        raise IdentificationError(
            f"bootstrap: {len(lengths)} trial cannot be drawn whole; draw its blocks with whole_trials=False"
        )
    for trial, (length, count) in enumerate(zip(lengths, counts, strict=True)):
        if not whole_trials and count < FEWEST_BLOCKS:
            raise IdentificationError(
                f"bootstrap: trial {trial} has {length} rows, {count} blocks of {block}; it needs {FEWEST_BLOCKS}: "
                "shorten the block or leave the trial out"
            )


def _sums(columns: Array, response: Array, lengths: Sequence[int], counts: Sequence[int]) -> tuple[Array, Array]:
    """X'X (b, p, p) and X'y (b, p) of every block; each trial of ``lengths`` falls into so many of ``counts``."""
    grams, moments = [], []
    start = 0
    for length, count in zip(lengths, counts, strict=True):
        edges = start + np.linspace(0, length, count + 1).astype(int)
        for low, high in pairwise(edges.tolist()):
            part = columns[low:high]
            grams.append(part.T @ part)
            moments.append(part.T @ response[low:high])
        start += length
    return np.array(grams), np.array(moments)


def _weights(counts: Sequence[int], draws: int, rng: np.random.Generator, whole_trials: bool) -> Array:
    """How often each block is in each resampling, (m, blocks)."""
    trials = len(counts)
    if whole_trials:
        taken = rng.multinomial(trials, np.full(trials, 1.0 / trials), size=draws)
        return np.repeat(taken, counts, axis=1).astype(np.float64)
    parts = [rng.multinomial(count, np.full(count, 1.0 / count), size=draws) for count in counts]
    return np.hstack(parts).astype(np.float64)
