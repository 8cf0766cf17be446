"""Free runs over fifths of a record that were left out in turn: what a law is worth on samples that nobody fitted.

The likelihood of residuals counts samples, and what an equation lacks leaves residuals that hang together: of a body
without a spring they wander, and a record holds few independent samples of them; of a long record nearly any law is
beyond every limit of evidence. The equation is therefore fitted without each fifth of the record in turn and run free
there, anew from each quarter of it; two equations are compared by the ratio of their squared errors, each summed over
all these windows, with its standard error from the windows' scatter about it (the ratio estimator: Cochran 1977,
Sampling techniques, ch. 6).

Belongs here: those runs, that comparison, whether offset and friction vary by stroke. Does not belong here: which laws
are tried (driven_search.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from undertow.conditioning.driven import DrivenTrial
from undertow.errors import IdentificationError
from undertow.likelihood.driven import DrivenLaws
from undertow.likelihood.output_error import SearchEffort
from undertow.methods.driven import DrivenFit, fit_driven, free_run
from undertow.methods.driven_begin import START_SAMPLES
from undertow.methods.driven_strokes import vary_by_stroke
from undertow.recording.recording import Array

CLOSER = 0.02
"""Share by which the free run over unseen samples must come closer: below that nobody would miss the law."""
FOLDS = 5
WINDOWS_A_FOLD = 4
"""Free runs that a part left out is cut into: 20 windows show their scatter to a sixth of itself."""
SHORTEST_WINDOW = 4 * START_SAMPLES
"""Samples of a window: its start state is not scored, and must not be most of it."""
DEVIATIONS = 5.0
"""Standard errors by which the ratio of squared errors must be below 1. Set on cases that no longer count as proof: a
synthetic carriage that lacks nothing but whose drive wanders reached 4.6 with a relaxation (windows hang together, so
that 2.5 is no 1 %), EMPS' asymmetric damping 6.7, its other laws 1.3 at most. On fresh cases:
docs/driven_measured.md."""
FEWEST_WINDOWS = 5
"""Below so many windows their scatter says too little."""
TRYING = SearchEffort(12, 0.1)
"""Enough to tell what a suspect is worth; what is kept is fitted to the end."""
CLOSER_WINDOWS = 0.75
"""Share of the windows that must come closer, 15 of 20: a law that is there acts in all of them, and by chance 2 in 100
laws would. Set on synthetic carriages whose drive wanders, where a hysteresis brought 11 and 13 of 20 closer, a few of
these by so much that the sum fell by 5 and by 20 standard errors; proof on others: docs/driven_measured.md."""


@dataclass(frozen=True)
class Tried:
    """A suspect that was fitted: evidence (natural log of the Bayes factor by Schwarz 1978, which decides nothing), rms
    on unseen samples before and after."""

    name: str
    evidence: float
    before: float
    after: float
    because: str = ""


def fold_errors(training: Sequence[DrivenTrial], laws: DrivenLaws) -> Array:
    """Mean squared error (windows,) of free runs over parts of the longest driven trial, the equation fitted to all but
    the fifth that they are in; inf where a fit or a run has no bounds. Empty where the trial is too short for a window
    in each fifth."""
    longest = max(training, key=lambda trial: (not trial.free, trial.t.size))
    if longest.t.size < FOLDS * SHORTEST_WINDOW:
        return np.zeros(0)
    others = [trial for trial in training if trial is not longest]
    ends = np.linspace(0, longest.t.size, FOLDS + 1).astype(int).tolist()
    out: list[float] = []
    for begin, end in pairwise(ends):
        parts = [longest.part(a, b) for a, b in ((0, begin), (end, longest.t.size)) if b > a]
        named = [replace(part, name=f"{part.name}, part {i}") for i, part in enumerate(parts)]
        many = max(1, min(WINDOWS_A_FOLD, (end - begin) // SHORTEST_WINDOW))
        cuts = list(pairwise(np.linspace(begin, end, many + 1).astype(int).tolist()))
        try:
            fitted = fit_driven([*others, *named], laws, windows=0, effort=TRYING)
            windows = [longest.part(a, b) for a, b in cuts]
            away = [(free_run(w, fitted, START_SAMPLES) - w.outputs[w.main])[START_SAMPLES:] for w in windows]
        except IdentificationError:
            out += [math.inf] * len(cuts)
            continue
        out += [float(np.mean(one**2)) for one in away]
    return np.array(out)


def come_closer(before: Array, after: Array) -> str:
    """Why the windows' squared errors ``after`` (n,) are no sure gain over ``before`` (n,); empty where they are.

    >>> come_closer(np.full(20, 4.0), np.resize([1.0, 2.0], 20))
    ''
    """
    if before.size < FEWEST_WINDOWS:
        return (
            f"no record is long enough to leave parts of it out; give one of {FOLDS * SHORTEST_WINDOW} samples beside "
            "the part that is held back"
        )
    sums = [math.sqrt(float(np.mean(errors))) for errors in (before, after)]
    if not math.isfinite(sums[1]):
        return "a fit without a part of the record has no bounded motion"
    if not math.isfinite(sums[0]):
        return ""
    ratio, error = ratio_of(before, after)
    closer, wanted = int(np.count_nonzero(after < before)), math.ceil(CLOSER_WINDOWS * before.size)
    if closer < wanted:
        return (
            f"parts left out in turn: {closer} of {before.size} come closer, where {wanted} are asked for; what a law "
            "does shows in all of them"
        )
    if 1.0 - ratio > DEVIATIONS * error:
        return ""
    return (
        f"parts left out in turn come no surely closer: {sums[1]:.4g} after {sums[0]:.4g}, their squares "
        f"{ratio:.3g} +- {error:.2g} of what they were, where {DEVIATIONS:g} standard errors below 1 are asked for"
    )


def ratio_of(before: Array, after: Array) -> tuple[float, float]:
    """Ratio of the sums of squared errors ``after`` and ``before`` (n,), and its standard error from their scatter
    about it (Cochran 1977, ch. 6).

    >>> ratio_of(np.full(4, 2.0), np.ones(4))
    (0.5, 0.0)
    """
    ratio = float(np.sum(after) / np.sum(before))
    scatter = math.sqrt(before.size / (before.size - 1)) * float(np.linalg.norm(after - ratio * before))
    return ratio, scatter / float(np.sum(before))


def validation_rms(unseen: Sequence[DrivenTrial], fitted: DrivenFit) -> float:
    """RMS of the free run over trials that nobody fitted, from their first samples; inf where it has no bounds."""
    total, count = 0.0, 0
    for trial in unseen:
        try:
            away = (free_run(trial, fitted, START_SAMPLES) - trial.outputs[trial.main])[START_SAMPLES:]
        except IdentificationError:
            return math.inf
        total, count = total + float(away @ away), count + away.size
    return math.sqrt(total / count)


Parts = tuple[Sequence[DrivenTrial], Sequence[DrivenTrial], Sequence[DrivenTrial]]
"""All trials, what of them was fitted while laws were sought, and what was not."""


def by_stroke(whole: DrivenFit, parts: Parts, trained: DrivenFit, lowest: float) -> tuple[DrivenFit, float]:
    """The fit to all trials with deviations by stroke, and its rms on unseen samples, where both the part that was
    ``trained`` on and all trials ask for them, and the free run over unseen samples comes no further away than
    `CLOSER`; else ``whole`` and ``lowest`` as they are."""
    trials, training, unseen = parts
    try:
        after = validation_rms(unseen, vary_by_stroke(training, trained))
        if after > (1.0 + CLOSER) * lowest:
            return whole, lowest
        return vary_by_stroke(trials, whole), after
    except IdentificationError:
        return whole, lowest
