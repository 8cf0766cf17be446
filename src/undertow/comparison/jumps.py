"""Where a body is let go, or one that rubs turns or stops, its acceleration jumps, and what a sample holds of it only
the logger knows.

Belongs here: the cells that are left out for it. Does not belong here: the joint fit (joint.py).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from undertow.comparison.level import Level, Member
from undertow.conditioning.motion import Motion
from undertow.likelihood.problem import Problem
from undertow.recording.recording import Array

SLOW = 0.3
"""Share of its last swing's top speed below which a body may be about to stop: a twentieth of a period before."""


RELEASE_WITHIN = 2.0
"""Standard errors of the release's instant within which it may be."""


def without_jumps(level: Level, problem: Problem) -> Problem:
    """The problem without an acceleration's cells in which a body is let go, or turns where its equation has dry
    friction; of a late accelerometer (``level.late_s``) those that show these instants."""
    motions = {m.name: (m, _rubs(member)) for member in level.members for m in member.motions}
    trials = []
    for trial in problem.trials:
        if any(c.quantity == "acceleration" for c in trial.channels):
            motion, rubs = motions[trial.name]
            seen = trial.t - level.late_s.get(trial.name, 0.0)
            jumps = released(motion, seen, trial.width_s)
            if rubs:
                jumps = jumps | turning(motion, seen, trial.width_s)
            trial = replace(
                trial,
                channels=tuple(replace(c, unsure=jumps) if c.quantity == "acceleration" else c for c in trial.channels),
            )
        trials.append(trial)
    return replace(problem, trials=tuple(trials))


def released(motion: Motion, cells: Array, width_s: float) -> np.ndarray:
    """Cells (n,), given by their centres, within a sample of which a body that was held may have been let go, (n,): the
    mean over samples of which some are before and some after is that of no instant in between."""
    near = 0.5 * width_s + motion.step_s + RELEASE_WITHIN * motion.window.release_stderr_s
    return np.asarray(motion.window.held & (cells <= near))


def _rubs(member: Member) -> bool:
    """Whether a group's equation has dry friction."""
    fixed = member.model.fixed
    return bool(fixed is not None and fixed.mu.value > 0.0) or any(c.slot == "fc" for c in member.model.coefficients)


def turning(motion: Motion, cells: Array, width_s: float) -> np.ndarray:
    """Cells (n,), given by their centres, within a sample of which the velocity changes its sign, and the last ones
    where it has become slow: there the body may turn or stop, and a smoothed velocity does not show when, (n,)."""
    sign = np.sign(motion.v)
    last = np.flatnonzero(sign[1:] * sign[:-1] <= 0.0)
    turns = 0.5 * (motion.t[last] + motion.t[last + 1])
    near = 0.5 * width_s + motion.step_s
    turns = turns[turns <= cells[-1] + near]
    if not turns.size:
        return np.zeros(cells.size, dtype=bool)
    after = np.searchsorted(turns, cells).clip(0, turns.size - 1)
    away = np.minimum(np.abs(turns[after] - cells), np.abs(turns[np.maximum(after - 1, 0)] - cells))
    return np.asarray((away <= near) | _slow_at_the_end(motion, cells, _last_well_before(turns, float(cells[-1]))))


def _last_well_before(turns: Array, end: float) -> float:
    """The last turn a quarter of a period before the end: a later one may be where the body stops for good."""
    quarter = 0.5 * float(np.median(np.diff(turns))) if turns.size > 1 else 0.0
    before = turns[turns <= end - quarter]
    return float(before[-1] if before.size else turns[0])


def _slow_at_the_end(motion: Motion, cells: Array, turn: float) -> np.ndarray:
    """Cells after the last turn and after the swing's top speed, at less than `SLOW` of that."""
    speed = np.abs(np.interp(cells, motion.t, motion.v))
    swing = np.flatnonzero(cells > turn)
    if not swing.size:
        return np.zeros(cells.size, dtype=bool)
    top = swing[int(np.argmax(speed[swing]))]
    return np.asarray((np.arange(cells.size) > top) & (speed < SLOW * speed[top]))
