"""A problem written on arrays for the compiled search of Eq. 15.

Belongs here: which problems the compiled search can do, and their arrays. Does not belong here: the search itself
(arc_search.py) or what follows from it (output_error.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from undertow.equation.arcs import LAWS, MOST_STEPS, ORDER
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.identification import arc_search
from undertow.identification.channels import instants, swell
from undertow.identification.problem import Problem, TrialProblem
from undertow.recording.recording import Array

PLACES = np.array([SLOT[name] for name in LAWS], dtype=np.int64)
"""Where the laws of Eq. 15 stand in the integrator's parameter vector."""

_PLACE = {int(slot): place for place, slot in enumerate(PLACES)}
_OTHERS = np.setdiff1d(np.arange(N_SLOTS), PLACES)
_QUANTITIES = {"displacement": 0, "velocity": 1, "acceleration": 2}
_STEPS_A_RADIAN = 3.0
"""Steps that `march` may store a radian of the start's motion: it takes about one."""


@dataclass(frozen=True)
class Found:
    """Where the compiled search ended; ``residuals``, ``jacobians`` and ``used`` a trial as output_error has them."""

    values: Array
    normal: Array
    gradient: Array
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
        if trial.base[_OTHERS].any() or not all(link.slot in _PLACE for link in trial.links):
            return False
        if trial.t.size < 3 or trial.laws or any(c.quantity not in _QUANTITIES for c in trial.channels):
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
    places = sheet[2]
    rows = int(places[-1, 7] + (places[-1, 1] - places[-1, 0]) * (places[-1, 5] - places[-1, 4]))
    widest = max(u.size for u in used)
    size = len(problem.unknowns)
    one, two = (
        (np.empty(rows), np.empty((widest, rows)), np.empty((size, size)), np.empty(size)) for _ in range(2)
    )
    room = _room(problem, start)
    values, cost, chi2, spent, done, at = arc_search.search(
        sheet, columns, start, windows, iterations, stop, damping, room, one, two
    )
    if done < 0:
        return None
    r, jac, normal, gradient = one if at == 1 else two
    ends = [*places[1:, 7].tolist(), rows]
    cuts = [slice(begin, end) for begin, end in zip(places[:, 7].tolist(), ends, strict=True)]
    return Found(
        values, normal, gradient, cost, chi2, spent, done == 1,
        tuple(r[cut] for cut in cuts),
        tuple(jac[: own.size, cut].T for cut, own in zip(cuts, used, strict=True)),
        used,
    )  # fmt: skip


def _room(problem: Problem, start: Array) -> tuple[Any, ...]:
    """What `march` and the samples need: series of every step, instants, signals, levels, rates, parameters."""
    steps, cells, columns = 64, 0, 0
    for trial in problem.trials:
        p = trial.base[PLACES]
        for link in trial.links:
            p[_PLACE[link.slot]] += link.factor * start[link.unknown]
        rate = math.sqrt(max(p[1], 0.0) / p[0]) if p[0] > 0.0 else 0.0
        steps = max(steps, 64 + int(_STEPS_A_RADIAN * rate * float(trial.t[-1])))
        cells = max(cells, trial.t.size)
        columns = max(columns, len(trial.links))
    width = 4 * math.ceil((1 + min(columns, len(LAWS))) / 4)
    shape = (min(steps, MOST_STEPS), ORDER + 1, width)
    edges = 2 * cells
    return (
        np.empty(shape), np.empty(shape), np.empty(shape[0] + 1), np.empty(shape), np.empty((5, width)),
        np.empty(edges), np.empty((edges, width)), np.empty(edges), np.empty(len(LAWS)),
        np.empty(len(LAWS), dtype=np.int64),
    )  # fmt: skip


def _sheet(problem: Problem) -> tuple[tuple[Any, ...], np.ndarray, tuple[np.ndarray, ...]]:
    """The arrays that arc_search.py reads, each unknown's column in each trial, and the unknowns of each trial."""
    trials, unknowns = problem.trials, problem.unknowns
    columns = np.full((len(trials), len(unknowns)), -1, dtype=np.int64)
    links: list[tuple[int, int]] = []
    channels: list[tuple[int, ...]] = []
    used, places, factors, sigmas, data = [], [], [], [], []
    cell = row = value = 0
    for i, trial in enumerate(trials):
        n = trial.t.size
        own = unknowns_of(trial)
        columns[i, own] = np.arange(own.size)
        used.append(own)
        n_links, n_channels = len(links), len(channels)
        links += [(_PLACE[link.slot], link.unknown) for link in trial.links]
        factors += [link.factor for link in trial.links]
        for c in trial.channels:
            channels.append((_QUANTITIES[c.quantity], c.offset, c.drift, c.shift, c.gain, value))
            sigmas.append(c.sigma)
            data.append(c.values)
            value += n
        places.append((cell, cell + n, n_links, len(links), n_channels, len(channels), trial.shift, row))
        cell += n
        row += n * len(trial.channels)
    box = np.array([(u.lower, u.upper, u.start, 1.0 / u.prior_std**2) for u in unknowns]).T.copy()
    sheet = (
        np.concatenate([t.t for t in trials]),
        np.array([t.base[PLACES] for t in trials]),
        np.array(places, dtype=np.int64),
        np.array([(t.width_s, instants(t)[1], t.averaged, swell(t)) for t in trials], dtype=np.float64),
        np.array(links, dtype=np.int64).reshape(-1, 2),
        np.array(factors, dtype=np.float64),
        np.array(channels, dtype=np.int64).reshape(-1, 6),
        np.array(sigmas),
        np.concatenate(data),
        box,
    )
    return sheet, columns, tuple(used)


def unknowns_of(trial: TrialProblem) -> np.ndarray:
    """Indices (k,) of the unknowns that a trial's residuals depend on, rising."""
    wanted = {link.unknown for link in trial.links}
    for channel in trial.channels:
        wanted |= {channel.offset, channel.drift, channel.shift, channel.gain}
    wanted.add(trial.shift)
    return np.array(sorted(wanted - {-1}), dtype=np.int64)
