"""By how much a trial's k, c, mu may differ from what dry trials or its group say: unknowns with priors.

Belongs here: those unknowns and what they move. Does not belong here: the fit that finds them (joint.py), how much
trials differ (methods/dry.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from undertow.comparison.level import Member
from undertow.equation.kernel import SLOT
from undertow.likelihood.group import Coefficient
from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Link, ProblemBuilder
from undertow.methods.dry import believed
from undertow.quantities import Estimate
from undertow.recording.recording import Array
from undertow.uncertainty.confidence import widening
from undertow.uncertainty.repeats import mean_over, scatter_between

FEWEST_OF_ITS_OWN, KNOWN_APART = 3, 0.3
"""Trials that show how much they differ, and the share of what they were believed to differ by within which each knows
its own number then."""

SLOTS: Mapping[str, str] = {"k": "k1", "c": "c1", "mu": "fc"}
"""Where k, c, mu stand in the parameter vector."""


def size_in(theta: Array, slot: str) -> float:
    """What a slot's scatter is a share of: the size of the number there, of the stiffness with a pendulum's own.

    >>> theta = np.zeros(len(SLOT))
    >>> theta[SLOT["ks"]] = 0.3
    >>> size_in(theta, "k1"), size_in(theta, "c1")
    (0.3, 0.0)
    """
    pendulum = abs(float(theta[SLOT["ks"]])) if slot == SLOTS["k"] else 0.0
    return abs(float(theta[SLOT[slot]])) + pendulum


@dataclass(frozen=True)
class MeanDeviation:
    """By how much a spring's dry means are off: an unknown's name, its prior's standard deviation, that of what it is
    believed to be, and what it moves: the symbols of k, c, mu with factors.

    The prior is wider: for few dry trials as an interval is, so that no fit leans on a scatter that may be larger, and
    where the fit is of these very trials, whose means it finds."""

    name: str
    prior_std: float
    believed_std: float
    moves: tuple[tuple[str, float], ...]


def of_the_means(member: Member) -> tuple[MeanDeviation, ...]:
    """Deviations of a spring's means of k, c, mu from what its dry trials say; none without such.

    What c is off moves mu along, by as much as their errors go together, and mu's own deviation is the rest: two
    independent numbers, fitted or drawn, have the covariance that the dry trials left.
    """
    structure = member.model.fixed
    if structure is None:
        return ()
    errors = {symbol: structure.error_of_mean(symbol) for symbol in _estimates(member)}
    errors = {symbol: error for symbol, error in errors.items() if error > 0.0 and math.isfinite(error)}
    together = structure.c_with_mu if {"c", "mu"} <= set(errors) else 0.0
    out = []
    for symbol, error in errors.items():
        along = (("mu", together * errors["mu"] / error),) if symbol == "c" and together else ()
        own = error * math.sqrt(1.0 - together**2) if symbol == "mu" else error
        estimate = _estimates(member)[symbol]
        prior = estimate.total_stderr if member.own_means else own * widening(estimate.freedom)
        if prior > 0.0 and math.isfinite(prior):
            out.append(MeanDeviation(f"{symbol}_mean@{member.label}", prior, own, ((symbol, 1.0), *along)))
    return tuple(out)


def learned_mean(member: Member, solution: Solution, symbol: str) -> Estimate | None:
    """A spring's mean of k, c or mu as its dry trials and a joint fit say, None where the fit did not ask."""
    estimate = _estimates(member).get(symbol)
    names = solution.problem.names
    weights = {
        names.index(mean.name): factor
        for mean in of_the_means(member) for moved, factor in mean.moves if moved == symbol and mean.name in names
    }  # fmt: skip
    if estimate is None or not weights:
        return None
    common = np.zeros(solution.values.size)
    common[list(weights)] = list(weights.values())
    error = math.sqrt(max(float(common @ solution.covariance @ common), 0.0))
    found = _of_its_trials(member, solution, symbol, common, 1.0) if member.own_means else None
    found = found or Estimate(float(common @ solution.values), error, source="joint fit")
    return replace(found, value=estimate.value + found.value, unit=estimate.unit)


def mean_of_own(member: Member, solution: Solution, coefficient: Coefficient, name: str) -> Estimate | None:
    """A group's own k, c or mu as `_of_its_trials` has it, None where that is not to be had."""
    symbol = next((s for s, slot in SLOTS.items() if slot == coefficient.slot), "")
    common = np.zeros(solution.values.size)
    common[solution.problem.names.index(name)] = 1.0
    found = _of_its_trials(member, solution, symbol, common, 1.0 / coefficient.factor)
    return None if found is None else replace(found, unit=coefficient.unit)


def _of_its_trials(
    member: Member, solution: Solution, symbol: str, common: Array, scale: float
) -> Estimate | None:
    """The mean of a number over trials that each know their own (``common`` (unknowns,) of them all, and ``scale``
    times the trial's deviation) far better than they were believed to differ: that belief may be of fits which lacked a
    law, and makes the joint fit's error, not the trials. None elsewhere, where it is no better, below three trials."""
    names = solution.problem.names
    own = [names.index(n) for motion in member.motions if (n := f"{symbol}[{motion.name}]") in names]
    if len(own) < FEWEST_OF_ITS_OWN:
        return None
    weights = np.tile(common, (len(own), 1))
    weights[np.arange(len(own)), own] += scale
    values, variance = weights @ solution.values, np.einsum("ip,pq,iq->i", weights, solution.covariance, weights)
    errors, believed_std = np.sqrt(np.maximum(variance, 0.0)), solution.problem.unknowns[own[0]].prior_std
    if not np.all((variance > 0.0) & (errors < KNOWN_APART * abs(scale) * believed_std)):
        return None
    mean, error = mean_over(values, errors, scatter_between([(values, errors)]))
    better = error < math.sqrt(max(float(common @ solution.covariance @ common), 0.0))
    return Estimate(mean, error, source="joint fit") if better else None


def structure_links(builder: ProblemBuilder, member: Member, trial: str) -> list[Link]:
    """Deviations of a spring's k, c, mu from its dry means, and of this trial from those; without dry trials of this
    trial from what its group fits."""
    structure = member.model.fixed
    if structure is None:
        return _own_links(builder, member, trial)
    links = []
    for mean in of_the_means(member):
        index = builder.unknown(mean.name, 0.0, prior_std=mean.prior_std, scale=mean.prior_std)
        links += [Link(SLOT[SLOTS[symbol]], index, factor * unit_of(member, symbol)) for symbol, factor in mean.moves]
    for symbol, estimate in _estimates(member).items():
        std = believed(structure.scatter, structure.scatter_freedom, symbol) * estimate.value
        if std > 0.0 and math.isfinite(std):
            index = builder.unknown(f"{symbol}[{trial}]", 0.0, prior_std=std, scale=std)
            links.append(Link(SLOT[SLOTS[symbol]], index, unit_of(member, symbol)))
    return links


def unit_of(member: Member, symbol: str) -> float:
    """What one unit of k, c or mu is in its slot: of mu the normal force, N; 0 where that is not known."""
    normal = member.model.specimen.normal_force_N
    return (normal if math.isfinite(normal) else 0.0) if symbol == "mu" else 1.0


def _estimates(member: Member) -> dict[str, Estimate]:
    """The structure's k, c, mu that can differ: those that the equation has."""
    structure = member.model.fixed
    found = {} if structure is None else {"k": structure.k, "c": structure.c, "mu": structure.mu}
    return {s: e for s, e in found.items() if math.isfinite(e.value) and e.value != 0.0 and unit_of(member, s) != 0.0}


def _own_links(builder: ProblemBuilder, member: Member, trial: str) -> list[Link]:
    """This trial's deviations from k, c, mu that its group fits itself; none of a lone trial, whose own they are."""
    if len(member.motions) < 2:
        return []
    return [
        Link(SLOT[slot], builder.unknown(f"{symbol}[{trial}]", 0.0, prior_std=std, scale=std))
        for symbol, slot in SLOTS.items()
        if (std := member.spread.get(slot, 0.0) * member.sizes.get(slot, 0.0)) > 0.0
    ]
