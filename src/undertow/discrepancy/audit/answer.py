"""All rivals on one series of cases: evidence, probabilities, posteriors.

A series is cases of one kind (the levels of two tables): each has its own water, all share one scatter and one error of
the set-up (compliance). A table alone is a series of one.

Prior: one half that Eq. 15 with constant coefficients is all (with or without water), the other half shared by the
single effects in equal parts (a falling drag has less: rivals.py); a second effect counts a hundredth of one.

Belongs here: the order of things. Does not belong here: any of them (surface.py, posterior.py), words (verdicts.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from undertow.discrepancy.audit.bending import bend, coefficients
from undertow.discrepancy.audit.case import Case
from undertow.discrepancy.audit.posterior import Posterior, Weighed, posterior, weigh
from undertow.discrepancy.audit.recipes import Array
from undertow.discrepancy.audit.rivals import Rival, rivals
from undertow.discrepancy.audit.scatter import log_belief, log_sum
from undertow.discrepancy.audit.surface import Sheet, Surface, build_surface, fitted_sheets
from undertow.errors import UndertowError

EQUATION_PRIOR = 0.5
FURTHER_EFFECT = 0.01
"""A second effect beside a first, as in the search on recordings (docs/discrepancy.md)."""

BENT_FROM = 1.6
"""Draws through which a surface is bent, for each coefficient of the quadratic."""

BENT_LEAST = 0.05
"""Least width of those draws over an unknown's scale."""

BENT_SHARE = 0.1
"""Sheets with less of the posterior than this stay flat."""

BENT_WIDER = 1.4
"""The draws are spread by this much around their mean, so that the quadratic holds beyond them."""

PREFERRED = 0.02
"""Pieces with more of the posterior than this are cut in three, ..."""

MOST_PREFERRED = 3
"""... unless there are more of them than this: then the answers hardly bend with what is split."""

FAR_BEHIND = 8.0
"""Rivals whose log evidence on flat sheets lies further behind the best one's stay flat: bending moves it by a few."""

SHARED = ("support_compliance", "gain_error")
"""What belongs to the set-up and is one number for a whole series."""

SHARED_POINTS = np.linspace(-2.5, 2.5, 11)
"""Standard deviations of its prior, from its mean, at which a series is evaluated."""

SHARED_WIDTH = 0.25
"""Width of each point, in the same standard deviations: half their distance."""


@dataclass(frozen=True)
class Weight:
    """One rival on a series: log evidence at each scatter of the rows, (S,), posterior probability, and its posterior
    on every case."""

    rival: Rival
    at_scatter: Array
    probability: float
    posteriors: tuple[Posterior, ...]

    @property
    def log_evidence(self) -> float:
        """The scatter summed over by what is believed of it."""
        return log_sum(log_belief() + self.at_scatter)


@dataclass(frozen=True)
class Answer:
    """All rivals on one series of cases, the most probable first; ``failed`` says why a rival could not be tried."""

    cases: tuple[Case, ...]
    weights: tuple[Weight, ...]
    failed: Mapping[str, str]

    def of(self, *effects: str) -> Weight | None:
        """The rival with exactly these effects and water; None where it was not tried."""
        return next((w for w in self.weights if w.rival.effects == effects and w.rival.water), None)

    @property
    def dry(self) -> Weight | None:
        """The rival without any water force."""
        return next((w for w in self.weights if not w.rival.water), None)


def answer(
    cases: Sequence[Case], nodes: int = 24, seed: int = 0, priors: Mapping[str, tuple[float, float]] | None = None
) -> Answer:
    """Every rival on a series of cases; ``nodes`` pieces of a resonator's range, ``priors`` as in `Rival.given`.

    UndertowError where no rival can be tried at all.
    """
    lists = [rivals(case, nodes) for case in cases]
    flat, failed = [], {}
    for same in zip(*lists, strict=True):
        try:
            given = [rival.given(priors or {}) for rival in same]
            surfaces = [build_surface(case, rival) for case, rival in zip(cases, given, strict=True)]
            run = [weigh(case, surface, seed) for case, surface in zip(cases, surfaces, strict=True)]
            flat.append((given, surfaces, log_sum(log_belief() + _summed(run))))
        except UndertowError as reason:
            failed[same[0].label] = str(reason)
    best = max((evidence for _, _, evidence in flat), default=0.0)
    tried = []
    for given, surfaces, evidence in flat:
        near = evidence > best - FAR_BEHIND
        used = [bent_surface(c, s, seed) if near else s for c, s in zip(cases, surfaces, strict=True)]
        tried.append((given[0], *_on_series(cases, given, used, seed)))
    if not tried:
        first = next(iter(failed.values()))
        raise UndertowError(f"audit of {cases[0].name}: 0 of {len(lists[0])} rivals can be tried; {first}")
    shares = _probabilities([one[0] for one in tried], [log_sum(log_belief() + one[1]) for one in tried])
    weights = [Weight(one[0], one[1], share, one[2]) for one, share in zip(tried, shares.tolist(), strict=True)]
    return Answer(tuple(cases), tuple(sorted(weights, key=lambda w: -w.probability)), failed)


def probabilities_under(found: Answer, cap: float) -> Array:
    """Probabilities of the rivals, in the answer's order, where rows may scatter by up to ``cap`` of the mass."""
    logs = [log_sum(log_belief(cap) + one.at_scatter) for one in found.weights]
    return _probabilities([one.rival for one in found.weights], logs)


def _probabilities(found: Sequence[Rival], evidences: Sequence[float]) -> Array:
    singles = sum(rival.prior for rival in found if len(rival.effects) == 1)
    base = sum(not rival.effects for rival in found)
    logs = []
    for rival, evidence in zip(found, evidences, strict=True):
        single = (1.0 - EQUATION_PRIOR) / max(singles, 1.0) * rival.prior
        prior = EQUATION_PRIOR / base if not rival.effects else single * FURTHER_EFFECT ** (len(rival.effects) - 1)
        logs.append(math.log(prior) + evidence)
    share = np.exp(np.array(logs) - max(logs))
    return np.asarray(share / share.sum())


def _on_series(
    cases: Sequence[Case], same: Sequence[Rival], surfaces: Sequence[Surface], seed: int
) -> tuple[Array, tuple[Posterior, ...]]:
    """Log evidence at each scatter, (S,), and the posterior of every case."""
    settings, heights = _settings(same[0], len(cases))
    runs = [
        [
            weigh(case, replace(surface, rival=surface.rival.given(setting)), seed)
            for case, surface in zip(cases, surfaces, strict=True)
        ]
        for setting in settings
    ]
    at_scatter = np.array([height + _summed(run) for height, run in zip(heights, runs, strict=True)])
    best = runs[int(np.argmax([log_sum(log_belief() + one) for one in at_scatter]))]
    everywhere = _summed(best)
    found = tuple(posterior(one, seed, _elsewhere(one, everywhere)) for one in best)
    return np.logaddexp.reduce(at_scatter, axis=0), found


def _settings(rival: Rival, cases: int) -> tuple[list[Mapping[str, tuple[float, float]]], Array]:
    """Narrow priors of what a series shares, and the logarithm of what each stands for; one empty one without it."""
    shared = [one for one in rival.unknowns if one.name.split(".")[0] in SHARED]
    if cases == 1 or not shared:
        return [{}], np.zeros(1)
    one = shared[0]
    points = SHARED_POINTS[one.mean + SHARED_POINTS * one.deviation >= one.low]
    heights = -0.5 * points**2
    return (
        [{one.name: (one.mean + p * one.deviation, SHARED_WIDTH * one.deviation)} for p in points],
        heights - log_sum(heights),
    )  # fmt: skip


def _elsewhere(one: Weighed, everywhere: Array) -> Array:
    """What the other cases of a series say about the scatter: log evidence at each, (S,)."""
    possible = np.isfinite(one.log_evidences)
    rest = np.full(everywhere.shape, -np.inf)
    rest[possible] = everywhere[possible] - one.log_evidences[possible]
    return rest


def _summed(run: Sequence[Weighed]) -> Array:
    return np.asarray(np.sum([one.log_evidences for one in run], axis=0))


def fitted_surface(case: Case, rival: Rival, seed: int = 0) -> Surface:
    """The surface of one rival, bent where it matters."""
    return bent_surface(case, build_surface(case, rival), seed)


def bent_surface(case: Case, surface: Surface, seed: int = 0) -> Surface:
    """A surface whose preferred sheets are bent through the recipes at draws of its own first posterior."""
    rival = surface.rival
    if rival.split:
        surface = _finer(case, surface, seed)
    first = posterior(weigh(case, surface, seed), seed)
    sheets = []
    for j, sheet in enumerate(surface.sheets):
        own = np.flatnonzero(first.sheets == j)
        if own.size < BENT_SHARE * first.sheets.size:
            sheets.append(sheet)
            continue
        inside = rival.within(sheet.cell)
        sheets.append(bend(case, inside, sheet, _around(inside, first.points[own], seed)))
    return replace(surface, sheets=tuple(sheets))


def _around(rival: Rival, draws: Array, seed: int) -> Array:
    """Points (n, L) spread as ``draws`` of a posterior are, a little wider, within the ranges."""
    scale = np.array([max(unknown.scale, 1e-30) for unknown in rival.unknowns])
    spread = np.cov(draws / scale, rowvar=False) + BENT_LEAST**2 * np.eye(scale.size)
    normal_draws = np.random.default_rng(seed).standard_normal((int(BENT_FROM * coefficients(rival)), scale.size))
    points = draws.mean(axis=0) + BENT_WIDER * scale * (normal_draws @ np.linalg.cholesky(spread).T)
    low, high = (np.array([getattr(unknown, end) for unknown in rival.unknowns]) for end in ("low", "high"))
    return np.asarray(np.clip(points, low, high), dtype=np.float64)


def _finer(case: Case, surface: Surface, seed: int) -> Surface:
    """Where the table prefers few pieces they are cut in three; every sheet then knows its share of the prior."""
    rival = surface.rival
    first = weigh(case, surface, seed)
    share = np.array([log_sum((log_belief()[:, None] + first.logs[:, j]).ravel()) for j in range(len(surface.sheets))])
    preferred = np.exp(share - log_sum(share)) > PREFERRED
    sheets: list[Sheet] = []
    for sheet, cut in zip(surface.sheets, preferred.tolist(), strict=True):
        if not cut or preferred.sum() > MOST_PREFERRED or sheet.cell is None:
            sheets.append(sheet)
            continue
        edges = np.linspace(*sheet.cell, 4).tolist()
        try:
            sheets += fitted_sheets(case, rival, list(pairwise(edges)), sheet.centre)
        except UndertowError:
            sheets.append(sheet)
    whole = float(rival.edges[-1] - rival.edges[0])
    return Surface(rival, tuple(
        replace(sheet, log_share=math.log((sheet.cell[1] - sheet.cell[0]) / whole)) if sheet.cell else sheet
        for sheet in sheets
    ))  # fmt: skip
