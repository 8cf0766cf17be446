"""What a reader must know beside a prediction: that its rate is too low to show the motion, that its recording is of
another group, or that the run fitted this very recording.

Belongs here: those sentences and the equation's own period. Does not belong here: the free run (run_prediction.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from undertow.discrepancy.words import condition_words
from undertow.equation.equation import Equation
from undertow.equation.simulate import fastest_frequency, simulate
from undertow.errors import UndertowError
from undertow.recording.catalogue import Entry
from undertow.recording.conditions import same_condition
from undertow.recording.recording import Array, Condition
from undertow.report.verdict_file import read_verdicts

RESOLVED = 8.0
"""Samples a period from which on a table shows its motion: its largest sample is then within 8 % of the peak."""

FINE = 16.0
"""Samples in the shortest period of the equation at which its own period is looked for."""

MOST_FINE = 20_000
"""Such samples at most: what begins a decay shows its period."""


def mean_period(t: Array, x: Array) -> tuple[float, int]:
    """Mean time (s) between upward crossings of zero, and how many there are of them; nan without one.

    >>> t = np.arange(0.0, 3.2, 0.01)
    >>> period, periods = mean_period(t, np.cos(2.0 * np.pi * t))
    >>> round(period, 3), periods
    (1.0, 2)
    """
    up = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    if up.size < 2:
        return math.nan, 0
    crossings = t[up] - x[up] * (t[up + 1] - t[up]) / (x[up + 1] - x[up])
    return float(np.mean(np.diff(crossings))), int(up.size) - 1


def own_period_s(equation: Equation, x0: float, duration_s: float) -> float:
    """Period (s) of the equation's own free motion from ``x0`` (SI) within ``duration_s``, finely sampled; nan where it
    does not swing twice, or a law is a reader's own."""
    if not equation.compiled:
        return math.nan
    step = 2.0 * math.pi / fastest_frequency(equation.theta(x0)) / FINE
    t: Array = step * np.arange(min(math.floor(duration_s / step), MOST_FINE) + 1, dtype=np.float64)
    try:
        return mean_period(t, simulate(equation, x0, t).x)[0]
    except UndertowError:  # it leaves every bound: the prediction itself says so
        return math.nan


def too_coarse(period_s: float, rate_hz: float) -> str:
    """That a rate (Hz) is too low for a period, with the rate that is needed, in a sentence; empty where it is not.

    >>> too_coarse(0.7, 20.0)
    ''
    >>> too_coarse(0.7, 2.0)[:70]
    '2 samples a second are 1.4 a period of 0.7 s; a motion is shown from 8'
    """
    if not period_s * rate_hz < RESOLVED:
        return ""
    needed = math.ceil(10.0 * RESOLVED / period_s) / 10.0
    return (
        f"{rate_hz:g} samples a second are {period_s * rate_hz:.2g} a period of {period_s:.4g} s; a motion is shown "
        f"from {RESOLVED:g} on: give --rate {needed:g} or more"
    )


def of_another_group(entry: Mapping[str, Any], conditions: Mapping[str, Condition], whose: str) -> str:
    """That the recording ``whose`` has other conditions than the group whose equation is run, in a sentence; empty
    where none of those that both have differs."""
    apart = [
        (name, value, conditions[name])
        for name, value in entry["group"].items()
        if name in conditions and not same_condition(str(conditions[name]), value)
    ]
    if not apart:
        return ""
    own = ", ".join(condition_words(name, there) for name, _, there in apart)
    said = ", ".join(condition_words(name, value) for name, value, _ in apart)
    return (
        f"{whose} is of {own} by its name or the list of trials, and it is predicted by the equation of {said}, as the "
        "group says; without --group its own group's equation is taken"
    )


def among_fitted(folder: Path, group: Mapping[str, Any], entries: Sequence[Entry]) -> str:
    """That a recording (its ``entries`` in the run's list of trials) is among the trials that a group's equation was
    fitted to, in a sentence; empty where it is not, or was held out."""
    held = set()
    if (folder / "verdict.json").exists():
        held = {name for one in read_verdicts(folder)["groups"] for name in one["held_out"]}
    mine = [entry.name for entry in entries if entry.name in group["trials"] and entry.name not in held]
    if not mine:
        return ""
    return (
        f"{mine[0]} is one of the trials that this equation was fitted to: how well it is met proves nothing about new "
        "ones; take a held-out trial or another recording for that"
    )
