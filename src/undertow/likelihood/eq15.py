"""A problem written on arrays for the compiled search of Eq. 15.

Belongs here: which problems the compiled search can do, and their arrays. Does not belong here: the search itself
(eq15_search.py) or what follows from it (output_error.py).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.taylor_series import LAWS
from undertow.likelihood import eq15_search as arc_search
from undertow.likelihood.channel_rows import QUANTITIES
from undertow.likelihood.observation_model import swell
from undertow.likelihood.problem import Problem
from undertow.recording.recording import Array

PLACES = np.array([SLOT[name] for name in LAWS], dtype=np.int64)
"""Where the laws of Eq. 15 stand in the integrator's parameter vector."""

_PLACE = {int(slot): place for place, slot in enumerate(PLACES)}
_OTHERS = np.setdiff1d(np.arange(N_SLOTS), PLACES)


class Found(NamedTuple):
    """Where the compiled search ended; ``residuals``, ``jacobians`` and ``used`` a trial as output_error has them.

    ``inverse`` is that of the normal equations ``normal`` (p, p), None where they are all but singular.
    """

    values: Array
    normal: Array
    inverse: Array | None
    cost: float
    chi2: float
    iterations: int
    converged: bool
    residuals: tuple[Array, ...]
    jacobians: tuple[Array, ...]
    used: tuple[np.ndarray, ...]


def is_plain(problem: Problem) -> bool:
    """Whether every trial's equation has no more than Eq. 15's laws, and its channels no more than the motion."""
    for trial in problem.trials:
        if trial.drive is not None or trial.base[_OTHERS].any() or not all(link.slot in _PLACE for link in trial.links):
            return False
        if trial.t.size < 3 or trial.laws:
            return False
        if any(c.quantity not in QUANTITIES or len(c.drift) > 1 for c in trial.channels):
            return False
    return True


def search(
    problem: Problem, start: Array, windows: Array, iterations: int, stop: float, damping: float
) -> Found | None:
    """Best values of a plain problem's unknowns from ``start`` (p,), over growing ``windows`` (w,) in s.

    ``stop`` is in standard errors, ``damping`` Levenberg-Marquardt's first. None where the compiled search cannot go
    on: a motion without bounds, a spring that does not pull back, normal equations that are singular.
    """
    sheet, columns, used = _sheet(problem)
    values, cost, chi2, spent, done, r, jac, normal, inverse = arc_search.search(
        sheet, columns, start, windows, iterations, stop, damping
    )
    if done < 0:
        return None
    begins = [*sheet[2][:, 7].tolist(), r.size]
    cuts = [slice(begin, end) for begin, end in pairwise(begins)]
    return Found(
        values, normal, inverse if inverse.size else None, cost, chi2, spent, done == 1,
        tuple([r[cut] for cut in cuts]),
        tuple([jac[: own.size, cut].T for cut, own in zip(cuts, used, strict=True)]),
        used,
    )  # fmt: skip


def misfit(problem: Problem) -> Callable[[Array], float]:
    """A function of a plain problem's values (p,): their sum of squared weighted residuals without priors; nan where
    the compiled integrator finds no motion."""
    sheet, columns, _ = _sheet(problem)
    whole = np.array([np.inf])

    def chi2(values: Array) -> float:
        found = arc_search.search(sheet, columns, np.ascontiguousarray(values), whole, 0, 1.0, 1e-6)
        return float(found[2]) if found[4] >= 0 else float("nan")

    return chi2


def _sheet(problem: Problem) -> tuple[tuple[Any, ...], np.ndarray, tuple[np.ndarray, ...]]:
    """The arrays that eq15_search.py reads, each unknown's column in each trial, and the unknowns of each trial."""
    trials, unknowns = problem.trials, problem.unknowns
    columns = []
    links: list[tuple[int, int]] = []
    channels: list[tuple[int, ...]] = []
    used, places, factors, sigmas, data = [], [], [], [], []
    cell = row = value = 0
    for trial in trials:
        n = trial.t.size
        own = trial.used.tolist()
        place = dict(zip(own, range(len(own)), strict=True))
        columns.append([place.get(j, -1) for j in range(len(unknowns))])
        used.append(trial.used)
        n_links, n_channels = len(links), len(channels)
        links += [(_PLACE[link.slot], link.unknown) for link in trial.links]
        factors += [link.factor for link in trial.links]
        for c in trial.channels:
            drift = c.drift[0] if c.drift else -1
            channels.append((QUANTITIES[c.quantity], c.offset, drift, c.shift, c.gain, value))
            sigmas.append(c.sigma)
            data.append(c.data)
            value += n
        places.append((cell, cell + n, n_links, len(links), n_channels, len(channels), trial.shift, row))
        cell += n
        row += n * len(trial.channels)
    box = np.array(
        [
            [u.lower for u in unknowns], [u.upper for u in unknowns], [u.start for u in unknowns],
            [1.0 / u.prior_std**2 for u in unknowns],
        ]
    )  # fmt: skip
    sheet = (
        np.concatenate([t.t for t in trials]),
        np.array([t.base[PLACES] for t in trials]),
        np.array(places, dtype=np.int64),
        np.array([(t.width_s, 0.0, t.averaged, swell(t)) for t in trials], dtype=np.float64),
        np.array(links, dtype=np.int64).reshape(-1, 2),
        np.array(factors, dtype=np.float64),
        np.array(channels, dtype=np.int64).reshape(-1, 6),
        np.array(sigmas),
        np.concatenate(data),
        box,
    )
    return sheet, np.array(columns, dtype=np.int64), tuple(used)
