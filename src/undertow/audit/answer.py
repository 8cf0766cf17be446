"""All rivals on one series of cases: evidence, probabilities, posteriors.

A series is cases of one kind (the levels of two tables): each has its own water, all share one scatter and one error of
the set-up (compliance). A table alone is a series of one.

Prior: one half that Eq. 15 with constant coefficients is all (with or without water), the other half shared by the
single effects in equal parts; a second effect counts a hundredth of one.

Belongs here: the order of things. Does not belong here: any of them (surface.py, posterior.py), words (verdicts.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.audit.bending import bent_surface
from undertow.audit.case import PrintedCase
from undertow.audit.exploring import explored_surface
from undertow.audit.posterior import RivalPosterior, Weighed, posterior, weigh
from undertow.audit.recipes import Array
from undertow.audit.rivals import Rival, rivals
from undertow.audit.scatter import log_belief, log_sum
from undertow.audit.surface import Surface, build_surface
from undertow.errors import UndertowError

EQUATION_PRIOR = 0.5
FURTHER_EFFECT = 0.01
"""A second effect beside a first, as in the search on recordings (docs/discrepancy_rules.md)."""

FAR_BEHIND = 8.0
"""Rivals whose log evidence on flat sheets lies further behind the best one's stay flat: bending moves it by a few."""

EXPLORED_FROM = 0.5
"""A rival with at least this probability is explored through the recipes themselves (exploring.py): its intervals are
the verdict."""

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
    posteriors: tuple[RivalPosterior, ...]

    @property
    def log_evidence(self) -> float:
        """The scatter summed over by what is believed of it."""
        return log_sum(log_belief() + self.at_scatter)


@dataclass(frozen=True)
class Answer:
    """All rivals on one series of cases, the most probable first; ``failed`` says why a rival could not be tried."""

    cases: tuple[PrintedCase, ...]
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
    cases: Sequence[PrintedCase],
    nodes: int = 24,
    seed: int = 0,
    priors: Mapping[str, tuple[float, float]] | None = None,
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
    bent = []
    for _, surfaces, evidence in flat:
        near = evidence > best - FAR_BEHIND
        bent.append([bent_surface(c, s, seed) if near else s for c, s in zip(cases, surfaces, strict=True)])
    tried = [_on_series(cases, one[0], used, seed) for one, used in zip(flat, bent, strict=True)]
    if not tried:
        first = next(iter(failed.values()))
        raise UndertowError(f"audit of {cases[0].name}: 0 of {len(lists[0])} rivals can be tried; {first}")
    named = [given[0] for given, _, _ in flat]
    for i in np.flatnonzero(_shares(named, tried) >= EXPLORED_FROM):
        used = [explored_surface(case, surface, seed) for case, surface in zip(cases, bent[i], strict=True)]
        tried[i] = _on_series(cases, flat[i][0], used, seed)
    pairs = zip(named, tried, _shares(named, tried).tolist(), strict=True)
    weights = [Weight(rival, one[0], share, one[1]) for rival, one, share in pairs]
    return Answer(tuple(cases), tuple(sorted(weights, key=lambda w: -w.probability)), failed)


def probabilities_under(found: Answer, cap: float) -> Array:
    """Probabilities of the rivals, in the answer's order, where rows may scatter by up to ``cap`` of the mass."""
    logs = [log_sum(log_belief(cap) + one.at_scatter) for one in found.weights]
    return _probabilities([one.rival for one in found.weights], logs)


def _shares(found: Sequence[Rival], tried: Sequence[tuple[Array, tuple[RivalPosterior, ...]]]) -> Array:
    return _probabilities(found, [log_sum(log_belief() + at_scatter) for at_scatter, _ in tried])


def _probabilities(found: Sequence[Rival], evidences: Sequence[float]) -> Array:
    singles = sum(len(rival.effects) == 1 for rival in found)
    base = sum(not rival.effects for rival in found)
    single = (1.0 - EQUATION_PRIOR) / max(singles, 1)
    logs = []
    for rival, evidence in zip(found, evidences, strict=True):
        prior = EQUATION_PRIOR / base if not rival.effects else single * FURTHER_EFFECT ** (len(rival.effects) - 1)
        logs.append(math.log(prior) + evidence)
    share = np.exp(np.array(logs) - max(logs))
    return np.asarray(share / share.sum())


def _on_series(
    cases: Sequence[PrintedCase], same: Sequence[Rival], surfaces: Sequence[Surface], seed: int
) -> tuple[Array, tuple[RivalPosterior, ...]]:
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
