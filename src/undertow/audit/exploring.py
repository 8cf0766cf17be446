"""A surface of points: where answers bend, jump and have two minima, the recipes are run at every point of a cloud.

Near a resonance no quadratic through Method 1's answers holds: draws on it are draws of another posterior. The unknowns
in which answers bend so (frequency and damping ratio of a resonator) are drawn from a cloud
that follows the posterior in a few generations; at each of its points the recipes are run and their slopes taken in all
other unknowns, in which they are straight. Points weigh prior over the density they were drawn from, all generations
together (population Monte Carlo; Cappe et al., J. Comput. Graph. Stat. 13, 2004; Cornuet et al., Scand. J. Stat. 39,
2012). Of two minima the one at the print counts: searches start there.

Belongs here: the cloud. Does not belong here: slopes (surface.py), evidence and posteriors (posterior.py).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from undertow.audit.bending import bent_surface
from undertow.audit.case import PrintedCase
from undertow.audit.posterior import weigh
from undertow.audit.recipes import Array
from undertow.audit.rivals import EXPLORED, Rival
from undertow.audit.scatter import log_belief
from undertow.audit.surface import Sheet, Surface, build_surface, pinned_sheet
from undertow.errors import UndertowError

GENERATIONS = (3, 5)
"""Least and most generations; it ends when as many points as `DIFFERENT` count."""

POINTS = 40
"""Points of a generation."""

EVEN = 0.1
"""Share of them drawn evenly over the whole ranges: what the cloud does not see must not weigh without bound."""

ANEW = 3
"""At one point in so many slopes are taken anew."""

DIFFERENT = 20.0
"""Points that a cloud is drawn around weigh as much as at least this many equal ones: else weights are levelled."""

ROOTS = 1.5 ** np.arange(30)
"""Roots of the weights that are tried."""

WIDER = 1.3
"""Kernels are this much wider than Silverman's rule: a posterior's tails must not be missed."""

FIRST_WIDTH = 0.05
"""Least standard deviation of the first cloud over the range of each unknown: it must see more than the surface did."""

LEAST_WIDTH = 0.01
"""The same of every later cloud, in the logarithm of an unknown."""

Pinned = NDArray[np.intp]


def explored_surface(case: PrintedCase, surface: Surface, seed: int = 0) -> Surface:
    """A surface of pinned sheets, one a point of the cloud, from a surface of pieces; the same one where nothing of its
    rival is to be explored, where no row is of Method 1 (the others have one answer), or where no recipe can be run."""
    rival = surface.rival
    if not any(row.recipe == "method1" for row in case.rows):
        return surface
    at = np.flatnonzero([unknown.name in EXPLORED for unknown in rival.unknowns])
    if not at.size:
        return surface
    rng = np.random.default_rng(seed)
    parents = _drawn(case, surface, seed, rng)
    low, high = _ends(rival, at)
    clouds = [Cloud(parents[:, at], np.full(len(parents), 1.0 / len(parents)), FIRST_WIDTH * (high - low))]
    sheets: list[Sheet] = []
    logs = np.zeros(0)
    for generation in range(1, GENERATIONS[1] + 1):
        new = _generation(case, rival, clouds[-1], parents, sheets, at, rng)
        if not new:
            return surface
        try:
            logs = np.append(logs, _weights(case, Surface(rival, tuple(new)), seed))
        except UndertowError:  # none of them within the priors
            return surface
        sheets += new
        parents = np.array([sheet.centre for sheet in sheets])
        shares = _shares(rival, parents[:, at], clouds, at)
        counted = np.exp(logs + shares - np.max(logs + shares))
        if generation >= GENERATIONS[0] and np.sum(counted) ** 2 >= DIFFERENT * np.sum(counted**2):
            break
        clouds.append(Cloud(parents[:, at], _levelled(logs + shares), np.full(at.size, LEAST_WIDTH)))
    return Surface(rival, tuple(replace(one, log_share=share) for one, share in zip(sheets, shares, strict=True)))


def _generation(
    case: PrintedCase, rival: Rival, cloud: Cloud, parents: Array, sheets: list[Sheet], at: Pinned,
    rng: np.random.Generator,
) -> list[Sheet]:
    """Sheets of one generation; slopes anew at some of its points, those of the nearest such point at the others."""
    found: list[Sheet] = []
    low, high = _ends(rival, at)
    even = rng.uniform(size=POINTS) < EVEN
    drawn = np.where(even[:, None], rng.uniform(low, high, size=(POINTS, at.size)), cloud.draw(POINTS, rng))
    for i, point in enumerate(drawn):
        start = parents[_nearest(cloud, parents[:, at], point)].copy()
        start[at] = point
        if np.any((point < low) | (point > high)):
            continue
        known = None
        known_sheets = [*sheets, *found]
        if i % ANEW and known_sheets:
            near = known_sheets[_nearest(cloud, np.array([one.centre[at] for one in known_sheets]), point)]
            start, known = near.centre.copy(), near.slopes
            start[at] = point
        sheet = pinned_sheet(case, rival, start, tuple(at.tolist()), known)
        if sheet is not None:
            found.append(sheet)
    return found


def _nearest(cloud: Cloud, points: Array, point: Array) -> int:
    return int(np.argmin(np.sum(cloud.whitened(points - point) ** 2, axis=1)))


def fitted_surface(case: PrintedCase, rival: Rival, seed: int = 0) -> Surface:
    """The surface of one rival: bent where it matters, explored where that is not enough."""
    return explored_surface(case, bent_surface(case, build_surface(case, rival), seed), seed)


class Cloud:
    """Normal kernels of one width around weighed points (n, d)."""

    def __init__(self, points: Array, share: Array, least: Array) -> None:
        size = points.shape[1]
        middle = share @ points
        away = points - middle
        spread = (share[:, None] * away).T @ away
        width = WIDER * (4.0 / (size + 2.0) * np.sum(share**2)) ** (1.0 / (size + 4.0))
        self.points, self.share = points, share
        self.root = np.linalg.cholesky(width**2 * spread + np.diag(least**2))

    def whitened(self, away: Array) -> Array:
        """Differences (n, d) over the kernel's width."""
        return np.asarray(np.linalg.solve(self.root, away.T).T)

    def draw(self, count: int, rng: np.random.Generator) -> Array:
        """Points (count, d)."""
        chosen = self.points[rng.choice(len(self.points), count, p=self.share)]
        return np.asarray(chosen + rng.standard_normal(chosen.shape) @ self.root.T)

    def log_density(self, points: Array) -> Array:
        """(n,) at points (n, d)."""
        size = points.shape[1]
        away = self.whitened((points[:, None, :] - self.points[None]).reshape(-1, size))
        logs = -0.5 * np.sum(away.reshape(len(points), -1, size) ** 2, axis=2)
        top = -0.5 * size * math.log(2.0 * math.pi) - float(np.sum(np.log(np.diagonal(self.root))))
        with np.errstate(divide="ignore"):
            return np.asarray(top + np.logaddexp.reduce(logs + np.log(self.share), axis=1))


def _drawn(case: PrintedCase, surface: Surface, seed: int, rng: np.random.Generator) -> Array:
    """Draws (n, L) of the surface of pieces, their weights levelled until enough of them differ."""
    first = weigh(case, surface, seed)
    share = _levelled((first.logs + log_belief()[:, None, None]).ravel())
    chosen = rng.choice(share.size, 10 * POINTS, p=share)
    return np.asarray(first.points.reshape(-1, first.points.shape[-1])[chosen])


def _weights(case: PrintedCase, surface: Surface, seed: int) -> Array:
    """Logarithm of the posterior weight of every sheet."""
    first = weigh(case, surface, seed)
    return np.asarray(np.logaddexp.reduce(first.logs + log_belief()[:, None, None], axis=(0, 2)))


def _levelled(logs: Array) -> Array:
    """Weights that add up to one: a root of exp(logs) as low as lets `DIFFERENT` of them count."""
    share = np.zeros(logs.size)
    for root in ROOTS:
        share = np.exp((logs - np.max(logs)) / root)
        share /= share.sum()
        if min(DIFFERENT, 0.5 * logs.size) * np.sum(share**2) <= 1.0:
            break
    return share


def _ends(rival: Rival, at: Pinned) -> tuple[Array, Array]:
    return np.array([rival.unknowns[i].low for i in at]), np.array([rival.unknowns[i].high for i in at])


def _shares(rival: Rival, points: Array, clouds: list[Cloud], at: Pinned) -> list[float]:
    """What each point (n, d) stands for: its prior over the density that all generations drew it from, as logarithm."""
    low, high = _ends(rival, at)
    even = -float(np.sum(np.log(high - low)))
    mixed = [np.logaddexp(math.log1p(-EVEN) + cloud.log_density(points), math.log(EVEN) + even) for cloud in clouds]
    drawn = np.logaddexp.reduce(mixed, axis=0) + math.log(POINTS)
    found: list[float] = (even - drawn).tolist()
    return found
