"""All rivals on one series of cases: evidence, probabilities, posteriors.

A series is cases of one kind (the levels of two tables): each has its own water, all share one scatter and one error of
the set-up (compliance). A table alone is a series of one.

Prior: one half that Eq. 15 with constant coefficients is all (with or without water), the other half shared equally by
the single effects; a second effect counts a hundredth of one.

Belongs here: the order of things. Does not belong here: any of them (surface.py, posterior.py), words (verdicts.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.discrepancy.audit.bending import bend, coefficients
from undertow.discrepancy.audit.case import Case
from undertow.discrepancy.audit.posterior import Posterior, Weighed, log_mean, posterior, weigh
from undertow.discrepancy.audit.recipes import Array
from undertow.discrepancy.audit.rivals import Rival, rivals
from undertow.discrepancy.audit.surface import Surface, build_surface
from undertow.errors import UndertowError

EQUATION_PRIOR = 0.5
FURTHER_EFFECT = 0.01
"""A second effect beside a first, as in the search on recordings (docs/discrepancy.md)."""

BENT_FROM = 2
"""Draws through which a surface is bent, for each coefficient of the quadratic."""

BENT_SHARE = 0.05
"""Nodes with less of the posterior than this stay flat."""

BENT_WIDER = 1.4
"""The draws are spread by this much around their mean, so that the quadratic holds beyond them."""

PREFERRED = 1e-3
"""Nodes whose best draw weighs more than this share of the best one's get neighbours."""

SHARED = "support_compliance.compliance_m_per_N"
"""What belongs to the set-up and is one number for a whole series."""

SHARED_POINTS = np.linspace(0.0, 2.5, 6)
"""Standard deviations of its prior at which a series is evaluated."""

SHARED_WIDTH = 0.25
"""Width of each point, in the same standard deviations: half their distance."""


@dataclass(frozen=True)
class Weight:
    """One rival on a series: log evidence, posterior probability, and its posterior on every case."""

    rival: Rival
    log_evidence: float
    probability: float
    posteriors: tuple[Posterior, ...]


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
    """Every rival on a series of cases; ``nodes`` frequencies of a resonator, ``priors`` as in `Rival.given`.

    UndertowError where no rival can be tried at all.
    """
    lists = [rivals(case, nodes) for case in cases]
    tried, failed = [], {}
    for same in zip(*lists, strict=True):
        try:
            given = [rival.given(priors or {}) for rival in same]
            tried.append((given[0], *_on_series(cases, given, seed)))
        except UndertowError as reason:
            failed[same[0].label] = str(reason)
    if not tried:
        first = next(iter(failed.values()))
        raise UndertowError(f"audit of {cases[0].name}: 0 of {len(lists[0])} rivals can be tried; {first}")
    probabilities = _probabilities([one[0] for one in tried], [one[1] for one in tried])
    weights = [Weight(one[0], one[1], share, one[2]) for one, share in zip(tried, probabilities, strict=True)]
    return Answer(tuple(cases), tuple(sorted(weights, key=lambda w: -w.probability)), failed)


def _probabilities(found: Sequence[Rival], evidences: Sequence[float]) -> Array:
    singles = sum(len(rival.effects) == 1 for rival in found)
    base = sum(not rival.effects for rival in found)
    logs = []
    for rival, evidence in zip(found, evidences, strict=True):
        single = (1.0 - EQUATION_PRIOR) / max(singles, 1)
        prior = EQUATION_PRIOR / base if not rival.effects else single * FURTHER_EFFECT ** (len(rival.effects) - 1)
        logs.append(math.log(prior) + evidence)
    share = np.exp(np.array(logs) - max(logs))
    return np.asarray(share / share.sum())


def _on_series(cases: Sequence[Case], same: Sequence[Rival], seed: int) -> tuple[float, tuple[Posterior, ...]]:
    surfaces = [fitted_surface(case, rival, seed) for case, rival in zip(cases, same, strict=True)]
    shared = any(unknown.name == SHARED for unknown in same[0].unknowns) and len(cases) > 1
    settings: list[Mapping[str, tuple[float, float]]] = [{}]
    if shared:
        deviation = next(unknown.deviation for unknown in same[0].unknowns if unknown.name == SHARED)
        settings = [{SHARED: (p * deviation, SHARED_WIDTH * deviation)} for p in SHARED_POINTS]
    runs = [
        [
            weigh(case, replace(surface, rival=surface.rival.given(setting)), seed)
            for case, surface in zip(cases, surfaces, strict=True)
        ]
        for setting in settings
    ]
    heights = -0.5 * SHARED_POINTS**2 if shared else np.zeros(1)
    heights = heights - math.log(float(np.sum(np.exp(heights))))
    totals = [float(height) + log_mean(_summed(run)) for height, run in zip(heights, runs, strict=True)]
    evidence = log_mean(np.array(totals)) + math.log(len(totals))
    best = runs[int(np.argmax(totals))]
    everywhere = _summed(best)
    found = tuple(posterior(one, seed, _elsewhere(one, everywhere)) for one in best)
    return evidence, found


def _elsewhere(one: Weighed, everywhere: Array) -> Array:
    """What the other cases of a series say about the scatter: log evidence at each, (S,)."""
    possible = np.isfinite(one.log_evidences)
    rest = np.full(everywhere.shape, -np.inf)
    rest[possible] = everywhere[possible] - one.log_evidences[possible]
    return rest


def _summed(run: Sequence[Weighed]) -> Array:
    return np.asarray(np.sum([one.log_evidences for one in run], axis=0))


def fitted_surface(case: Case, rival: Rival, seed: int = 0) -> Surface:
    """The surface of one rival, bent where it matters: through the recipes at draws of its own first posterior."""
    surface = build_surface(case, rival)
    if rival.log_ranges is not None:
        surface = _finer(case, surface, seed)
    first = posterior(weigh(case, surface, seed), seed)
    sheets = []
    for j, sheet in enumerate(surface.sheets):
        own = np.flatnonzero(first.sheets == j)
        if own.size < BENT_SHARE * first.sheets.size:
            sheets.append(sheet)
            continue
        points = np.column_stack([first.draws[unknown.name][own] for unknown in rival.unknowns])
        wanted = BENT_FROM * coefficients(rival)
        chosen = points[np.linspace(0, own.size - 1, min(wanted, own.size)).astype(int)]
        wider = points.mean(axis=0) + BENT_WIDER * (chosen - points.mean(axis=0))
        low, high = (np.array([getattr(unknown, end) for unknown in rival.unknowns]) for end in ("low", "high"))
        sheets.append(bend(case, rival, sheet, np.clip(wider, low, high)))
    return replace(surface, sheets=tuple(sheets))


def _finer(case: Case, surface: Surface, seed: int) -> Surface:
    """Two more nodes beside each that the table prefers; every node stands for the stretch that is nearest to it."""
    rival, ranges = surface.rival, surface.rival.log_ranges
    if ranges is None:
        return surface
    first = weigh(case, surface, seed)
    share = np.exp(np.max(first.logs, axis=(0, 2)) - np.max(first.logs))
    width, step = float(ranges[0, 1] - ranges[0, 0]), 1.0 / surface.tried
    name = rival.node_names[0]
    preferred = [sheet.node[name] for sheet, part in zip(surface.sheets, share, strict=True) if part > PREFERRED]
    between = np.exp([[math.log(value) + side * step / 3.0 * width] for value in preferred for side in (-1.0, 1.0)])
    more = build_surface(case, replace(rival, nodes=between))
    every = np.sort(np.log(np.concatenate([rival.nodes, between]))[:, 0])
    edges = np.concatenate([[ranges[0, 0]], 0.5 * (every[1:] + every[:-1]), [ranges[0, 1]]])
    stretch = dict(zip(np.round(every, 9).tolist(), np.diff(edges) / width, strict=True))
    kept = tuple(
        replace(sheet, log_weight=math.log(stretch[round(math.log(sheet.node[name]), 9)] * every.size))
        for sheet in (*surface.sheets, *more.sheets)
    )
    return Surface(rival, kept, every.size)
