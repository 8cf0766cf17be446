"""The growing windows of a fit: a wrong start cannot lock on to a wrong phase while the record is one period long.

Belongs here: how long the windows are, and a problem cut to one. Does not belong here: the search (output_error.py).
"""

from __future__ import annotations

from dataclasses import replace

from undertow.likelihood.problem import Problem

FIRST_WINDOW_PERIODS = 1.0
"""The first window of a growing fit, in periods of the motion; each next one is twice as long."""


def growing_windows(problem: Problem) -> list[float]:
    """Windows in s, growing, all shorter than the longest trial."""
    longest = max(float(t.t[-1] - t.t[0]) for t in problem.trials)
    windows = [FIRST_WINDOW_PERIODS * max(t.period_s for t in problem.trials)]
    while windows[-1] < longest:
        windows.append(2.0 * windows[-1])
    return windows[:-1]


def shortened(problem: Problem, seconds: float) -> Problem:
    """The same problem on each trial's first ``seconds`` of motion."""
    trials = []
    for trial in problem.trials:
        keep = trial.t <= trial.t[0] + seconds
        channels = tuple(
            replace(c, values=c.values[keep], unsure=None if c.unsure is None else c.unsure[keep])
            for c in trial.channels
        )
        trials.append(replace(trial, t=trial.t[keep], channels=channels))
    return Problem(problem.unknowns, tuple(trials))
