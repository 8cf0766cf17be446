"""Offset and friction that vary from stroke to stroke of a driven body: how much, and the numbers beside that.

A body without a spring adds up what its equation lacks: half a newton more in one stroke moves it for good, and the
residual of one free run over the record is a walk that says little of the numbers. Here every pair of strokes (there
and back) has an offset and a friction of its own, normal about the equation's, as k, c and mu of decays are from trial
to trial (baseline.py). Their standard deviations are those that make the record most likely (restricted maximum
likelihood by EM, Laird and Ware 1982, doi:10.2307/2529876).

Belongs here: that fit, and whether the record asks for it. Does not belong here: the motion itself
(likelihood/driven_strokes.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.conditioning.driven import DrivenTrial
from undertow.errors import IdentificationError
from undertow.likelihood.driven import MASS, drive_for, extent_of
from undertow.likelihood.driven_strokes import (
    Reach,
    StrokeCourse,
    StrokeMotion,
    Strokes,
    course_of,
    motion_by_stroke,
    variance_by_stroke,
)
from undertow.methods.driven import DrivenFit, memory_samples
from undertow.methods.driven_begin import begin_of
from undertow.methods.driven_instrument import jumps
from undertow.recording.recording import Array

FEWEST_STROKES = 6
"""Strokes of all trials below which their scatter is not known."""
MOST_STROKES = 100
"""Strokes beyond which nothing is asked: deviations of so many are a noise of the input."""
AT_NOISE = 1.5
"""Free-run error over white noise up to which nothing is left to vary."""
SURE = 3.0
"""Natural logarithm of the odds (20 to 1) from which on a record asks for deviations by stroke."""
FIRST_SHARE = 0.2
"""Where the search for both standard deviations begins, as a share of the input's: from above, because small deviations
that leave a residual with a long memory look as if they were none."""
ROUNDS = 60
SETTLED = 0.01
"""The search ends where neither standard deviation moves by this share of the larger one."""
STEPS = 6
HALVINGS = 8

Numbers = Mapping[str, float]


@dataclass(frozen=True)
class _Record:
    """One trial of the fit: how it is integrated, its strokes, and whether its start state is held."""

    reach: Reach
    course: StrokeCourse
    held: bool

    @property
    def measured(self) -> Array:
        """The recorded displacement (n,)."""
        return self.reach.trial.outputs["displacement"]


@dataclass(frozen=True)
class _Values:
    """The equation's numbers (p,), and by trial the start state (2,) and the deviations of its pairs (2 pairs,)."""

    numbers: Array
    states: tuple[Array, ...]
    deviations: tuple[Array, ...]


@dataclass(frozen=True)
class _StrokePoint:
    """Where a search stands: values, residuals (m - x) by trial, the normal matrix without and the precision of priors,
    its gradient, the cost."""

    values: _Values
    residuals: tuple[Array, ...]
    normal: Array
    prior: Array
    gradient: Array
    cost: float


def vary_by_stroke(trials: Sequence[DrivenTrial], fitted: DrivenFit) -> DrivenFit:
    """The fit with what its offset and friction differ by from stroke to stroke, its numbers and errors beside that.

    Raises IdentificationError, with the reason, where trials or laws do not lend themselves, or where the record does
    not ask for it.
    """
    _must_stroke(trials, fitted)
    records = tuple(_record(trial, fitted) for trial in trials)
    strokes = sum(len(one.course.ways) for one in records)
    if not FEWEST_STROKES <= strokes <= MOST_STROKES:
        raise IdentificationError(
            f"{strokes} strokes: by how much they differ is asked of {FEWEST_STROKES} to {MOST_STROKES}"
        )
    numbers = fitted.numbers
    states = tuple(_begun(one, fitted) for one in records)
    nothing = tuple(np.zeros(one.course.forces.shape[1]) for one in records)
    values = _Values(np.array([numbers[name] for name in fitted.names]), states, nothing)
    first = FIRST_SHARE * max(float(np.std(one.reach.trial.u)) for one in records)
    found, spreads = _likeliest(records, fitted, values, np.full(2, first))
    outside = _outside(fitted, found.values.numbers)
    if outside:
        raise IdentificationError(f"with offsets and frictions that differ by stroke {outside} leaves its bounds")
    evidence = _evidence(records, fitted, values, found)
    if not evidence > SURE:
        raise IdentificationError(
            f"the odds for offsets and frictions that differ by stroke are exp({evidence:.2g}), under exp({SURE:g})"
        )
    return _with_deviations(records, fitted, found, spreads, evidence)


def _outside(fitted: DrivenFit, values: Array) -> str:
    """Names of numbers that a search without bounds took beyond them."""
    bounds = {place.name: (place.parameter.lower, place.parameter.upper) for place in fitted.laws.places}
    bounds |= {MASS: (0.0, math.inf)}
    pairs = zip(fitted.names, values.tolist(), strict=True)
    free = (-math.inf, math.inf)
    return ", ".join(n for n, value in pairs if not bounds.get(n, free)[0] <= value <= bounds.get(n, free)[1])


def _with_deviations(
    records: Sequence[_Record], fitted: DrivenFit, found: _StrokePoint, spreads: Array, evidence: float
) -> DrivenFit:
    """The fit with the numbers, errors and deviations that were found."""
    covariance = _inverse(found.normal + np.diag(found.prior))[: len(fitted.names), : len(fitted.names)]
    names = [one.reach.trial.name for one in records]
    alike = replace(found.values, deviations=tuple(0.0 * own for own in found.values.deviations))
    missed = [one.measured - _motion(one, fitted, alike, i).x for i, one in enumerate(records)]
    rms, left = (
        {name: float(np.sqrt(np.mean(r**2))) for name, r in zip(names, away, strict=True)}
        for away in (missed, found.residuals)
    )
    pairs = {name: own.reshape(-1, 2) for name, own in zip(names, found.values.deviations, strict=True)}
    beyond = max(_beyond(one, fitted, alike, i, spreads, left, rms) for i, one in enumerate(records))
    varying = Strokes(float(spreads[0]), float(spreads[1]), pairs, left, beyond, evidence)
    return replace(fitted, values=found.values.numbers, covariance=covariance, rms=rms, strokes=varying)


def _must_stroke(trials: Sequence[DrivenTrial], fitted: DrivenFit) -> None:
    """IdentificationError where strokes mean nothing to these trials or laws."""
    kinds = [term.name for term in fitted.laws.terms if term.kind not in ("force", "input")]
    if kinds:
        raise IdentificationError(f"{', '.join(kinds)} remembers earlier strokes, so that these are not apart")
    for trial in trials:
        if trial.free or trial.mover != "force" or list(trial.outputs) != ["displacement"]:
            raise IdentificationError(
                f"trial {trial.name} has {trial.quantity} and {', '.join(trial.outputs)}; strokes are asked of a force "
                "and a displacement alone"
            )
    if all(fitted.rms[trial.name] <= AT_NOISE * trial.noise()["displacement"] for trial in trials):
        raise IdentificationError(
            f"one free run misses no trial by more than {AT_NOISE:g} times the sensor's noise: nothing varies by stroke"
        )
    extent = extent_of(trials[0])
    if not any(jumps(term, extent.size, extent.speed) for term in fitted.laws.terms):
        raise IdentificationError("no law of the equation changes at once with the direction of motion")


def _record(trial: DrivenTrial, fitted: DrivenFit) -> _Record:
    reach = Reach(trial, fitted.laws, fitted.names, drive_for(trial))
    return _Record(reach, course_of(trial.t, trial.outputs["displacement"]), trial.name in fitted.begun)


def _begun(one: _Record, fitted: DrivenFit) -> Array:
    """Where a trial's motion starts: by its first samples where the fit began so, else where the fit's ended."""
    name = one.reach.trial.name
    if one.held:
        state = begin_of(one.reach.trial, fitted.laws, fitted.numbers, one.reach.drive).state
        return np.array([state["x0"], state["v0"]])
    return np.array([fitted.solution.value(f"{what}[{name}]") for what in ("x0_m", "v0_m_per_s")])


def _likeliest(
    records: Sequence[_Record], fitted: DrivenFit, values: _Values, spreads: Array
) -> tuple[_StrokePoint, Array]:
    """Values and both spreads (2,) that make the records most likely, every trial's noise widened for its memory."""
    noise = _noise(tuple(one.measured - _motion(one, fitted, values, i).x for i, one in enumerate(records)))
    for _ in range(ROUNDS):
        point = _searched(records, fitted, values, spreads, noise)
        values, noise = point.values, _noise(point.residuals)
        spread = np.diag(_inverse(point.normal + np.diag(point.prior)))
        own = np.concatenate(point.values.deviations)
        uncertain = spread[spread.size - own.size :]
        before, spreads = spreads, np.sqrt(np.mean((own**2 + uncertain).reshape(-1, 2), axis=0))
        if np.max(np.abs(spreads - before)) < SETTLED * np.max(spreads):
            break
    return _searched(records, fitted, values, spreads, noise), spreads


def _noise(residuals: Sequence[Array]) -> tuple[float, ...]:
    """Standard deviation that white residuals would have to have to say as little as these."""
    return tuple(math.sqrt(float(np.mean(r**2)) * memory_samples(r)) for r in residuals)


def _motion(one: _Record, fitted: DrivenFit, values: _Values, index: int) -> StrokeMotion:
    numbers = {**fitted.numbers, **dict(zip(fitted.names, values.numbers.tolist(), strict=True))}
    return motion_by_stroke(one.reach, numbers, values.states[index], one.course, values.deviations[index])


def _searched(
    records: Sequence[_Record], fitted: DrivenFit, values: _Values, spreads: Array, noise: Sequence[float]
) -> _StrokePoint:
    """Gauss-Newton's end with spreads and noise as they are, steps halved where the cost does not fall."""
    point = _at(records, fitted, values, spreads, noise)
    for _ in range(STEPS):
        step = _inverse(point.normal + np.diag(point.prior)) @ point.gradient
        for halving in range(HALVINGS):
            try:
                tried = _at(records, fitted, _moved(point.values, 0.5**halving * step, records), spreads, noise)
            except IdentificationError:
                continue
            if tried.cost < point.cost:
                break
        else:
            return point
        gained, point = point.cost - tried.cost, tried
        if gained < SETTLED:
            break
    return point


def _moved(values: _Values, step: Array, records: Sequence[_Record]) -> _Values:
    """Values a step (p + 2 trials that are free + 2 pairs each,) on."""
    p = values.numbers.size
    states, deviations = list(values.states), list(values.deviations)
    at = p
    for i, one in enumerate(records):
        if not one.held:
            states[i] = states[i] + step[at : at + 2]
            at += 2
    for i, own in enumerate(deviations):
        deviations[i] = own + step[at : at + own.size]
        at += own.size
    return _Values(values.numbers + step[:p], tuple(states), tuple(deviations))


def _at(
    records: Sequence[_Record], fitted: DrivenFit, values: _Values, spreads: Array, noise: Sequence[float]
) -> _StrokePoint:
    """Cost, residuals and normal equations of all trials at these values."""
    p, states = values.numbers.size, 2 * sum(not one.held for one in records)
    size = p + states + sum(own.size for own in values.deviations)
    normal, gradient, residuals, cost = np.zeros((size, size)), np.zeros(size), [], 0.0
    at_state, at_pair = p, p + states
    for i, one in enumerate(records):
        motion = _motion(one, fitted, values, i)
        columns, where = [motion.by_number], [*range(p)]
        if not one.held:
            columns.append(motion.by_state)
            where += [at_state, at_state + 1]
            at_state += 2
        columns.append(motion.by_pair)
        where += [*range(at_pair, at_pair + motion.by_pair.shape[1])]
        at_pair += motion.by_pair.shape[1]
        slopes = np.column_stack(columns) / noise[i]
        away = one.measured - motion.x
        normal[np.ix_(where, where)] += slopes.T @ slopes
        gradient[where] += slopes.T @ (away / noise[i])
        cost += float(away @ away) / noise[i] ** 2
        residuals.append(away)
    own = np.concatenate(values.deviations)
    precision = np.tile(1.0 / spreads**2, own.size // 2)
    gradient[size - own.size :] -= precision * own
    prior = np.concatenate([np.zeros(size - own.size), precision])
    return _StrokePoint(values, tuple(residuals), normal, prior, gradient, cost + float(precision @ own**2))


def _beyond(
    one: _Record, fitted: DrivenFit, alike: _Values, index: int, spreads: Array, left: Numbers, rms: Numbers
) -> float:
    """RMS by which a trial's free run misses it beyond what deviations of such ``spreads`` do to it; at least what is
    ``left`` where each pair has its own."""
    name = one.reach.trial.name
    numbers = {**fitted.numbers, **dict(zip(fitted.names, alike.numbers.tolist(), strict=True))}
    both = (float(spreads[0]), float(spreads[1]))
    varies = float(np.mean(variance_by_stroke(one.reach, numbers, alike.states[index], both)))
    return math.sqrt(max(left[name] ** 2, rms[name] ** 2 - varies))


def _inverse(normal: Array) -> Array:
    """Inverse of a normal matrix whose unknowns have different units."""
    size = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    return np.asarray(np.linalg.pinv(normal / np.outer(size, size), hermitian=True) / np.outer(size, size))


def _evidence(records: Sequence[_Record], fitted: DrivenFit, values: _Values, found: _StrokePoint) -> float:
    """Natural logarithm of the odds for deviations by stroke: what they take from the slow part of the residuals, less
    what so many free deviations cost (Laplace's approximation)."""
    gained = 0.0
    for i, (one, after) in enumerate(zip(records, found.residuals, strict=True)):
        before = one.measured - _motion(one, fitted, values, i).x
        gained += slow_gain(before, after, len(one.course.ways))
    own = np.concatenate(found.values.deviations)
    first = found.prior.size - own.size
    precision = found.prior[first:]
    size = np.sqrt(np.maximum(np.diag(found.normal), np.finfo(float).tiny))
    scaled = found.normal / np.outer(size, size)
    whole = np.linalg.slogdet(scaled + np.diag(found.prior / size**2))[1]
    without = np.linalg.slogdet(scaled[:first, :first])[1]
    cost = whole - without + float(np.sum(np.log(size[first:] ** 2 / precision)))
    return float(gained - 0.5 * cost - 0.5 * float(precision @ own**2))


def slow_gain(before: Array, after: Array, strokes: int) -> float:
    """Natural logarithm of the likelihood ratio of two residuals (n,), by their first ``strokes`` frequencies
    (Whittle's likelihood, powers averaged over octaves). Forces that differ by stroke make no faster residual, and one
    that wanders says as little as it has slow frequencies, however many its samples.

    >>> t = np.linspace(0.0, 1.0, 400)
    >>> round(slow_gain(np.cos(6.0 * t), 0.1 * np.cos(6.0 * t), 8) / (8.0 * math.log(100.0)), 6)
    1.0
    """
    power = [np.abs(np.fft.rfft(one - np.mean(one))[1 : strokes + 1]) ** 2 for one in (before, after)]
    octaves = [2**i - 1 for i in range(strokes.bit_length())]
    many = np.diff([*octaves, strokes])
    means = [np.add.reduceat(one, octaves) / many for one in power]
    return float(np.sum(many * np.log(means[0] / means[1])))
