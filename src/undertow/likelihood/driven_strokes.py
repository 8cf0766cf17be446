"""The motion of a driven body whose offset and friction differ from stroke to stroke, with its sensitivities.

A stroke is the way from one reversal to the next. In a stroke the body goes one way, so that what its offset and what
its friction differ by from their means is one force; a stroke there and the next one back tell the two apart:

    force there = offset + friction        force back = offset - friction

so that each such pair has one deviation of either. The record is integrated stroke by stroke, each from where the last
one ended; sensitivities go on by the chain rule over the state at a reversal.

Belongs here: where strokes end, that motion. Does not belong here: how large the deviations are
(methods/driven_strokes.py), the integrator.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.stats import t as student

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven import driven_motion
from undertow.equation.driven_slots import DRIVEN_SLOT
from undertow.equation.input import Drive
from undertow.likelihood.driven import DrivenLaws, driven_problem, extent_of
from undertow.likelihood.output_error import parameter_vector
from undertow.likelihood.problem import Problem
from undertow.recording.recording import Array

MOVING_SHARE = 0.05
"""A body moves one way from this share of its largest speed on; it turns between two such parts of unlike direction."""
SMOOTHED_SHARE = 0.002
"""Part of a record over which its velocity is averaged, so that noise turns no body round."""

STATE = ("x0", "v0")
OFFSET = "offset"


@dataclass(frozen=True)
class Strokes:
    """What differs from stroke to stroke: standard deviations of the offset and of the friction between pairs of
    strokes, N; the deviations of every pair by trial, each (pairs, 2); the rms that is ``left`` where each pair has
    its own, by trial; that of one free run ``beyond`` what such deviations do to it, the largest of all trials; and the
    ``evidence``, natural logarithm of the odds against one offset and one friction."""

    offset_N: float
    friction_N: float
    deviations: Mapping[str, Array]
    left: Mapping[str, float]
    beyond: float
    evidence: float

    @property
    def spreads(self) -> tuple[float, float]:
        """Both standard deviations for a motion to come, N: wider, because few pairs of strokes know them."""
        few = widened(sum(len(own) for own in self.deviations.values()))
        return few * self.offset_N, few * self.friction_N


def widened(pairs: int) -> float:
    """By how many times a 90 % interval is wider whose standard deviation so many ``pairs`` show.

    >>> round(widened(5), 2), round(widened(100), 2)
    (1.3, 1.01)
    """
    return float(student.ppf(0.95, max(pairs - 1, 1)) / student.ppf(0.95, math.inf))


@dataclass(frozen=True)
class StrokeCourse:
    """Strokes of one motion: samples at which one ends and the next begins (s - 1,), and the direction of each (s,)."""

    turns: tuple[int, ...]
    ways: tuple[int, ...]

    @property
    def forces(self) -> Array:
        """How each stroke's force (s, 2 pairs) is made of the offsets and frictions of the pairs, two columns each."""
        count = len(self.ways)
        out = np.zeros((count, 2 * ((count + 1) // 2)))
        for stroke, way in enumerate(self.ways):
            out[stroke, 2 * (stroke // 2) : 2 * (stroke // 2) + 2] = (1.0, way)
        return out


def course_of(t: Array, x: Array) -> StrokeCourse:
    """The strokes of a displacement x (n,) at times t (n,): it turns half way between two parts in which it moves.

    >>> t = np.linspace(0.0, 3.0, 3001)
    >>> course_of(t, np.sin(np.pi * t)).turns
    (500, 1500, 2500)
    """
    width = max(3, int(SMOOTHED_SHARE * x.size)) | 1
    v = uniform_filter1d(np.gradient(x, t), width, mode="nearest")
    slow = MOVING_SHARE * float(np.max(np.abs(v)))
    moving = np.flatnonzero(np.abs(v) > slow)
    way = np.sign(v[moving]).astype(int)
    changes = np.flatnonzero(np.diff(way))
    turns = tuple(int(moving[i] + moving[i + 1]) // 2 for i in changes)
    return StrokeCourse(turns, (int(way[0]), *(int(way[i + 1]) for i in changes)))


@dataclass(frozen=True)
class StrokeMotion:
    """Displacement (n,) and its derivatives by the equation's numbers (n, p), by x0 and v0 (n, 2), and by every pair's
    offset and friction (n, 2 pairs)."""

    x: Array
    by_number: Array
    by_state: Array
    by_pair: Array


@dataclass(frozen=True)
class Reach:
    """An equation on a trial, ready to be integrated: the numbers whose derivatives are wanted, by ``names``."""

    trial: DrivenTrial
    laws: DrivenLaws
    names: tuple[str, ...]
    drive: Drive

    def strokes(
        self, numbers: Mapping[str, float], state: Array, course: StrokeCourse, forces: Array
    ) -> Iterator[tuple[slice, Array]]:
        """Samples of each stroke, and x and v there (2, n, 1 + p + 3) with their derivatives by the numbers, by x0 and
        v0 at its beginning, and by a force of this stroke alone; it begins where the last one ended."""
        problem = self._problem(numbers)
        piece = problem.trials[0]
        start = {one.name: numbers.get(one.name, one.start) for one in problem.unknowns}
        theta = parameter_vector(piece, np.array([start[name] for name in problem.names]))
        by_name = [[one for one in piece.links if problem.names[one.unknown] == name] for name in self.names]
        last = [DRIVEN_SLOT[name] for name in (*STATE, OFFSET)]
        slots = sorted({one.slot for links in by_name for one in links} | {*last})
        place = {slot: 1 + i for i, slot in enumerate(slots)}
        active, p = np.array(slots, dtype=np.int64), len(self.names)
        for force, (a, b) in zip(forces, pairwise((0, *course.turns, self.trial.t.size - 1)), strict=True):
            own = theta.copy()
            own[last[:2]] = state
            own[last[2]] += force
            made = driven_motion(own, active, self.drive, np.array(self.trial.t[a : b + 1]), piece.extent)
            out = np.zeros((2, b + 1 - a, 1 + p + 3))
            for row, column in enumerate((made.x, made.v)):
                out[row][:, 0] = column[:, 0]
                for i, links in enumerate(by_name):
                    out[row][:, 1 + i] = sum((one.factor * column[:, place[one.slot]] for one in links), 0.0)
                out[row][:, 1 + p :] = column[:, [place[slot] for slot in last]]
            yield slice(a, b + 1), out
            state = out[:, -1, 0]

    def _problem(self, numbers: Mapping[str, float]) -> Problem:
        """The trial with the wanted numbers as unknowns."""
        fixed = {name: value for name, value in self.laws.fixed.items() if name not in self.names}
        free = replace(self.laws, starts=dict(numbers), fixed=fixed)
        name = self.trial.name
        return driven_problem([self.trial], free, 1, None, {name: self.drive}, {name: extent_of(self.trial)})


def motion_by_stroke(
    reach: Reach, numbers: Mapping[str, float], state: Array, course: StrokeCourse, deviations: Array
) -> StrokeMotion:
    """The motion from ``state`` (x0, v0), each pair of strokes with its own ``deviations`` (2 pairs,), N.

    Raises IdentificationError where the motion leaves every bound.
    """
    p, count = len(reach.names), len(course.ways)
    x = np.zeros(reach.trial.t.size)
    slopes = np.zeros((x.size, p + 2 + count))
    before = np.zeros((2, p + 2 + count))
    before[:, p : p + 2] = np.eye(2)
    strokes = reach.strokes(numbers, state, course, course.forces @ deviations)
    for stroke, (inside, columns) in enumerate(strokes):
        both = columns[:, :, 1 + p : 3 + p] @ before
        both[:, :, :p] += columns[:, :, 1 : 1 + p]
        both[:, :, p + 2 + stroke] += columns[:, :, 3 + p]
        x[inside], slopes[inside], before = columns[0, :, 0], both[0], both[:, -1]
    return StrokeMotion(x, slopes[:, :p], slopes[:, p : p + 2], slopes[:, p + 2 :] @ course.forces)


def variance_by_stroke(
    reach: Reach, numbers: Mapping[str, float], state: Array, spreads: tuple[float, float]
) -> Array:
    """Variance (n,) of the motion from ``state`` when every pair of its strokes has an offset and a friction of its
    own, with those standard deviations (``spreads``), N."""
    x = motion_from_state(reach, numbers, state)
    course = course_of(reach.trial.t, x)
    out, carried = np.zeros(x.size), np.zeros((4, 4))
    strokes = reach.strokes(numbers, state, course, np.zeros(len(course.ways)))
    for stroke, (inside, columns) in enumerate(strokes):
        if stroke % 2 == 0:  # x and v go on, offset and friction are drawn anew
            carried[2:], carried[:, 2:] = 0.0, 0.0
            carried[[2, 3], [2, 3]] = np.square(spreads)
        last = columns[:, :, -3:]
        rows = np.concatenate([last, course.ways[stroke] * last[:, :, 2:]], axis=2)
        out[inside] = np.einsum("ni,ij,nj->n", rows[0], carried, rows[0])
        go_on = np.vstack([rows[:, -1], np.eye(4)[2:]])
        carried = go_on @ carried @ go_on.T
    return out


def motion_from_state(reach: Reach, numbers: Mapping[str, float], state: Array) -> Array:
    """Displacement (n,) from ``state`` (x0, v0), all strokes alike."""
    alone = replace(reach, names=())
    ((_, columns),) = alone.strokes(numbers, state, StrokeCourse((), (1,)), np.zeros(1))
    return np.array(columns[0, :, 0])
