"""The state in which a driven trial begins, by its first samples alone, and when a fit has to begin there.

A fit over a whole record may move the start state to make up for what the equation lacks: a carriage without a spring
never forgets where it began, and a few millimetres at the start spread an error over the record. The fitted motion then
contradicts the first samples, and is not the one that a prediction makes, which begins from them.

Belongs here: that state, its error, the decision. Does not belong here: fits of numbers (methods/driven.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_slots import DRIVEN_SLOT, DRIVEN_SLOTS
from undertow.equation.input import Drive
from undertow.likelihood.driven import DrivenLaws, driven_problem
from undertow.likelihood.output_error import Solution, fit, parameter_vector
from undertow.likelihood.problem import Problem
from undertow.recording.recording import Array

START_SAMPLES = 50
"""Samples from which the state at the start of a free run is found."""
CONTRADICTED = 3.0
"""A fitted motion contradicts the first samples where it misses them by so many times what a fit to them alone does."""
SURE_SHARE = 0.2
"""First samples are sure enough where the error of their state moves the run by under this share of what it misses
(4 % of its square)."""


REACH = 2.0
"""Extents of the motion over which a hysteresis may have been drawn before a record begins: from end to end."""


@dataclass(frozen=True)
class Begin:
    """A start state by slot, its covariance (q, q) in that order, and the rms by which it misses the first samples,
    in units of the noise."""

    state: Mapping[str, float]
    covariance: Array
    missed: float


def begin_of(
    trial: DrivenTrial,
    laws: DrivenLaws,
    numbers: Mapping[str, float],
    drive: Drive,
    samples: int = START_SAMPLES,
    noise: Mapping[str, float] | None = None,
) -> Begin:
    """The start state (x0, v0, what a hysteresis remembers, hidden motions) that the first ``samples`` say, with the
    equation's ``numbers`` held.

    Raises IdentificationError where the motion leaves every bound.
    """
    known = {trial.name: noise} if noise else None
    held = driven_problem([trial], replace(laws, fixed=dict(numbers)), 1, known, {trial.name: drive})
    piece = held.trials[0]
    few = replace(
        piece, t=piece.t[:samples], channels=tuple(replace(c, values=c.values[:samples]) for c in piece.channels)
    )
    found = fit(Problem(held.unknowns, (few,)), growing=False)
    order = [link.unknown for link in piece.links]
    state = {DRIVEN_SLOTS[link.slot]: float(found.values[link.unknown]) for link in piece.links}
    missed = float(np.sqrt(np.mean(found.residuals[0] ** 2)))
    return Begin(state, found.covariance[np.ix_(order, order)] * max(1.0, missed) ** 2, missed)


def begins_held(
    trials: Sequence[DrivenTrial],
    laws: DrivenLaws,
    numbers: Mapping[str, float],
    drives: Mapping[str, Drive],
    solution: Solution,
    noise: Mapping[str, Mapping[str, float]],
    begun: Mapping[str, Mapping[str, float]],
) -> dict[str, dict[str, float]]:
    """Start states that a fit of whole records has to keep, by trial and slot: those of trials whose fitted motion
    contradicts the first samples, where these are sure of their state, and of trials that were ``begun`` so before."""
    out = {}
    for trial, piece, r, jacobian, used in zip(
        trials, solution.problem.trials, solution.residuals, solution.jacobians, solution.used, strict=True
    ):
        begin = begin_of(trial, laws, numbers, drives[trial.name], noise=noise[trial.name])
        if trial.name in begun:
            out[trial.name] = dict(begin.state)
            continue
        n, index = trial.t.size, list(trial.outputs).index(trial.main)
        seen = slice(index * n, (index + 1) * n)
        first = float(np.sqrt(np.mean(r[seen][:START_SAMPLES] ** 2)))
        if not first > CONTRADICTED * max(begin.missed, 1.0):
            continue
        places = {link.slot: list(used).index(link.unknown) for link in piece.links}
        columns = [jacobian[seen, places[DRIVEN_SLOT[slot]]] for slot in begin.state]
        by_state = np.column_stack(columns)
        moved = float(np.sqrt(np.mean(np.einsum("ij,jk,ik->i", by_state, begin.covariance, by_state))))
        if moved < SURE_SHARE * float(np.sqrt(np.mean(r[seen] ** 2))):
            out[trial.name] = dict(begin.state)
    return out


def begun_beyond(problem: Problem, values: Array) -> str:
    """Why a hysteresis begins where no motion brings it: z0 above alpha times the way from end to end. It is then a
    force that fades, whatever the body does, and no law. Empty where it does not."""
    for trial in problem.trials:
        theta = parameter_vector(trial, values)
        reach = REACH * trial.extent.size * theta[DRIVEN_SLOT["bw_a"]]
        begun = abs(float(theta[DRIVEN_SLOT["bw_z0"]]))
        if begun > reach:
            return (
                f"trial {trial.name} begins with a hysteresis of {begun:.3g} N, and its motion reaches {reach:.3g} N"
            )
    return ""
