"""Which terms the motion itself asks for: subsets judged on simulated trajectories, coefficients polished on them.

Belongs here: the search for values, the linear problem around them, the walk from subset to subset. Does not belong
here: residuals and sensitivities (trajectories.py), the exact search (exact_subsets.py, subset.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.laws import Laws
from undertow.comparison.trajectories import Cells, Rows, trial_rows
from undertow.errors import IdentificationError
from undertow.likelihood.descent import Rule, descend

Array = NDArray[np.float64]

RULE = Rule(iterations=60, stop=1e-2)
"""Ends where no number moves by a hundredth of its own standard error: subsets differ by far more."""

RELEASE_STARTS_RADIANS = (0.0, 0.3, 0.6)
"""Releases seen late by so much of the motion's angle are tried, rad."""

POOR_FIT = 4.0
"""Mean squared residual in units of noise beyond which a doubtful start is tried on growing windows too."""

FIRST_WINDOW_PERIODS = 3.0
"""The first window of a growing fit, in periods; each next one is twice as long: a wrong start finds its phase."""


@dataclass(frozen=True)
class Polished:
    """Values of one subset at which the simulated motion lies closest to the recorded one.

    ``values`` (p,) the laws' numbers (0 for coefficients outside the subset), ``own`` the unknowns of each trial,
    ``cost`` squared residuals in units of noise plus priors, ``chi2`` without priors.
    """

    chosen: tuple[int, ...]
    values: Array
    own: tuple[Array, ...]
    cost: float
    chi2: float
    converged: bool


@dataclass(frozen=True)
class _NormalPoint:
    normal: Array
    gradient: Array
    cost: float
    chi2: float


def polish(
    trials: Sequence[Cells],
    book: Laws,
    chosen: Sequence[int],
    values: Array,
    own: Sequence[Array] | None = None,
    doubtful: bool = False,
) -> Polished:
    """Levenberg-Marquardt for the terms ``chosen`` and of each trial's own unknowns, from ``values`` (p,).

    A start that is ``doubtful`` and leads to a poor fit is tried again on three periods and on windows that double up
    to the whole, and the better of the two is taken. Raises IdentificationError where the start leaves every bound.
    """
    values = np.array(values)
    values[: len(book.terms)][[i for i in range(len(book.terms)) if i not in set(chosen)]] = 0.0
    places = book.columns(chosen)
    mine = [_settled(trial, book, values) for trial in trials] if own is None else [part.copy() for part in own]
    found = _search(trials, book, places, values, mine)
    rows = sum(seen.values.size for trial in trials for seen in trial.channels)
    if doubtful and (found.chi2 > POOR_FIT * rows or not found.converged):
        second = _search(trials, book, places, *_grown(trials, book, places, values, mine))
        found = min(found, second, key=lambda fit: fit.cost)
    return replace(found, chosen=tuple(chosen))


def _settled(trial: Cells, book: Laws, values: Array) -> Array:
    """A trial's own unknowns at the laws' first values: its release instant is tried at several places.

    A decay looks like one that was let go higher and a period earlier; a late start would lead there.
    """
    if "shift" not in trial.names:
        return trial.start.copy()
    fits = []
    for angle in RELEASE_STARTS_RADIANS:
        start = trial.start.copy()
        start[trial.names.index("shift")] = angle * trial.period_s / (2.0 * math.pi)
        try:
            fits.append(_search([trial], book, [], values, [start]))
        except IdentificationError:  # no motion from this start; the laws' own search says so where none has one
            continue
    return min(fits, key=lambda fit: fit.cost).own[0] if fits else trial.start.copy()


def _grown(
    trials: Sequence[Cells], book: Laws, places: Sequence[int], values: Array, own: Sequence[Array]
) -> tuple[Array, tuple[Array, ...]]:
    """Values after fits to windows that grow from three periods to just below the whole."""
    window = FIRST_WINDOW_PERIODS * max(trial.period_s for trial in trials)
    longest = max(float(trial.t[-1, 0] - trial.t[0, 0]) for trial in trials)
    mine = tuple(own)
    while window < longest:
        part = _search([trial.shortened(window) for trial in trials], book, places, values, mine)
        values, mine = part.values, part.own
        window *= 2.0
    return values, mine


def _search(
    trials: Sequence[Cells], book: Laws, places: Sequence[int], values: Array, own: Sequence[Array]
) -> Polished:
    """The search itself, all laws' numbers but those at ``places`` held."""
    held, count = np.array(values), len(places)
    free = sum(part.size for part in own)
    lower = np.append(book.lower[places], np.full(free, -np.inf))
    upper = np.append(book.upper[places], np.full(free, np.inf))
    ends = count + np.cumsum([part.size for part in own])

    def parts(numbers: Array) -> tuple[Array, list[Array]]:
        laws_numbers = held.copy()
        laws_numbers[places] = numbers[:count]
        return laws_numbers, [numbers[end - part.size : end] for part, end in zip(own, ends, strict=True)]

    def evaluate(numbers: Array, above: float) -> _NormalPoint | None:
        return _evaluate(trials, book, places, *parts(numbers), above)

    start = np.clip(np.concatenate([held[places], *own]), lower, upper)
    point = evaluate(start, math.inf)
    if point is None:
        raise IdentificationError(
            f"the motion of {', '.join(book.names[i] for i in places) or 'no terms'} leaves every bound on "
            f"{', '.join(trial.name for trial in trials[:3])}; give terms that hold the body together"
        )
    end = descend(evaluate, start, point, (lower, upper), RULE)
    found, mine = parts(end.values)
    return Polished((), found, tuple(mine), end.place.cost, end.place.chi2, end.converged)


def _evaluate(
    trials: Sequence[Cells], book: Laws, places: Sequence[int], values: Array, own: Sequence[Array], above: float
) -> _NormalPoint | None:
    """Normal matrix, gradient and cost of laws and trials' unknowns; None where a motion leaves every bound, or as soon
    as the cost is known to be ``above`` what stands."""
    count = len(places)
    size = count + sum(part.size for part in own)
    normal, gradient, chi2, prior_cost = np.zeros((size, size)), np.zeros(size), 0.0, 0.0
    first = count
    for trial, part in zip(trials, own, strict=True):
        rows = trial_rows(trial, book, values, part, places)
        if rows is None:
            return None
        jacobian = np.hstack([rows.shared, rows.own])
        index = np.r_[np.arange(count), np.arange(first, first + part.size)]
        normal[np.ix_(index, index)] += jacobian.T @ jacobian
        gradient[index] += jacobian.T @ rows.residual
        chi2 += float(rows.residual @ rows.residual)
        precision = 1.0 / trial.prior**2
        here = np.arange(first, first + part.size)
        normal[here, here] += precision
        gradient[here] += precision * (part - _centre(trial))
        prior_cost += float(precision @ (part - _centre(trial)) ** 2)
        first += part.size
        if chi2 + prior_cost > above:
            return None
    rows_believed, expected = book.believed()
    believed, away = rows_believed[:, places], rows_believed @ values - expected
    normal[:count, :count] += believed.T @ believed
    gradient[:count] += believed.T @ away
    prior_cost += float(away @ away)
    if not (np.all(np.isfinite(normal)) and np.all(np.isfinite(gradient)) and chi2 + prior_cost <= above):
        return None
    return _NormalPoint(normal, gradient, chi2 + prior_cost, chi2)


def _centre(trial: Cells) -> Array:
    """Centres of the priors: clocks, gains and shifts are expected to be 0."""
    return np.where(np.isfinite(trial.prior), 0.0, trial.start)


@dataclass(frozen=True)
class Linear:
    """The motion around one point as a regression: response = columns @ numbers + noise, in units of noise.

    ``columns`` (n, p) derivatives by every number of the laws, what each trial's own unknowns can imitate taken off;
    ``response`` (n,); ``lengths`` rows of each trial's channels, then of its priors, in order, then a row for each
    belief; ``at`` (p,) the numbers at which the columns were taken.
    """

    columns: Array
    response: Array
    lengths: tuple[int, ...]
    at: Array


def linearise(
    trials: Sequence[Cells],
    book: Laws,
    at: Polished,
    inner: Mapping[int, float] | None = None,
    only: int | None = None,
    before: Linear | None = None,
) -> Linear:
    """Every number of the laws as a column, around the values of ``at``.

    With ``inner`` (place -> value) an absent law's inner parameter, and with ``only`` and ``before`` that one column of
    ``before`` is made anew. Raises IdentificationError where the motion there leaves every bound.
    """
    values = at.values.copy()
    for place, value in (inner or {}).items():
        values[place] = value
    wanted = list(range(len(book.names))) if only is None else [only]
    columns, response, lengths = [], [], []
    for trial, part in zip(trials, at.own, strict=True):
        rows = trial_rows(trial, book, values, part, wanted)
        if rows is None:
            raise IdentificationError(
                f"trial {trial.name}: the motion of {', '.join(book.names)} leaves every bound; give terms that hold "
                "the body together"
            )
        shared, residual = _without_own(trial, rows, part)
        columns.append(shared)
        response.append(residual)
        cells = trial.t.shape[0]
        lengths += [cells] * len(trial.channels)
        lengths.append(shared.shape[0] - cells * len(trial.channels))
    believed, expected = book.believed()
    columns.append(believed[:, wanted])
    response.append(believed @ values - expected)
    lengths += [1] * expected.size
    stacked = np.vstack(columns)
    if only is not None and before is not None:
        one, stacked = stacked, before.columns.copy()
        stacked[:, [only]] = one
    # what is absent has the coefficient 0, so that its inner parameter moves nothing
    return Linear(stacked, stacked @ values - np.concatenate(response), tuple(lengths), values)


def _without_own(trial: Cells, rows: Rows, part: Array) -> tuple[Array, Array]:
    """Columns and residual with the trial's own unknowns (priors as further rows) projected out."""
    known = np.isfinite(trial.prior)
    basis = _own_basis(trial, rows)
    away = ((part - _centre(trial)) / trial.prior)[known]
    priors = np.column_stack([np.zeros((away.size, rows.shared.shape[1])), away])
    table = np.vstack([np.column_stack([rows.shared, rows.residual]), priors])
    left: Array = table - basis @ (basis.T @ table)
    return left[:, :-1], left[:, -1]


def _own_basis(trial: Cells, rows: Rows) -> Array:
    """Orthonormal columns of what the trial's own unknowns move, priors as further rows."""
    own = np.vstack([rows.own, np.diag(1.0 / trial.prior)[np.isfinite(trial.prior)]])
    scale = np.linalg.norm(own, axis=0)
    return np.asarray(np.linalg.qr(own / np.where(scale > 0.0, scale, 1.0))[0], dtype=np.float64)


def taken_up(trials: Sequence[Cells], book: Laws, at: Polished, columns: Array) -> list[Array]:
    """Orthonormal columns of what each trial takes up where it is fitted alone: its own unknowns and the laws'
    ``columns`` (n, p), rows as in `Linear`."""
    taken, first = [], 0
    for trial, part in zip(trials, at.own, strict=True):
        rows = trial_rows(trial, book, at.values, part, [])
        if rows is None:
            raise IdentificationError(f"trial {trial.name}: the motion of what was found leaves every bound")
        own = _own_basis(trial, rows)
        laws = columns[first : first + own.shape[0]]
        taken.append(np.hstack([own, np.linalg.qr(laws / np.linalg.norm(columns, axis=0))[0]]))
        first += own.shape[0]
    return taken
