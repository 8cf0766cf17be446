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
    return np.asarray((away <= near) | _slow_at_the_end(motion, cells, *_last_swing(turns, float(cells[-1]) + near)))


def _last_swing(turns: Array, end: float) -> tuple[float, float]:
    """The last turn that a swing follows, and when it ends: at the next turn, or with the record. A swing lasts a
    quarter of a period or more, half of what most of the time is in: after a body has stopped, noise turns often."""
    lasts = np.diff(np.append(turns, end))
    ordered = np.sort(lasts)
    usual = float(ordered[np.searchsorted(np.cumsum(ordered), 0.5 * np.sum(ordered)).clip(0, ordered.size - 1)])
    swings = np.flatnonzero(lasts >= 0.5 * usual)
    last = int(swings[-1]) if swings.size else 0
    return float(turns[last]), float(turns[last] + lasts[last])


def _slow_at_the_end(motion: Motion, cells: Array, turn: float, end: float) -> np.ndarray:
    """Cells between the last swing's top speed and its end, at less than `SLOW` of that."""
    speed = np.abs(np.interp(cells, motion.t, motion.v))
    swing = np.flatnonzero((cells > turn) & (cells <= end))
    if not swing.size:
        return np.zeros(cells.size, dtype=bool)
    top = swing[int(np.argmax(speed[swing]))]
    return np.asarray((np.arange(cells.size) > top) & (cells <= end) & (speed < SLOW * speed[top]))
