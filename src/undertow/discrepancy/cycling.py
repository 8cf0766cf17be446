"""Frequency and damping of every full cycle of one trial with their errors, and those of its free runs.

Belongs here: these numbers for a figure. Does not belong here: what of a difference is worth a sentence
(cycle_by_cycle.py), the figure (report/).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from undertow.conditioning.cycles import Cycles, find_cycles
from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.discrepancy.findings import TrialFindings
from undertow.errors import UndertowError
from undertow.likelihood.free_run import scored_channel
from undertow.recording.recording import Array

CLEAR = 10.0
"""Half swings below this many times the noise say nothing of frequency or damping."""

NOISE_TURNS = 3.0
"""A cycle shorter than the body's period by more than this factor is turned by noise; no law here makes one."""

FAINT = 0.03
"""Half swings under this share of the first are left out too: there friction is about to hold the body."""


@dataclass(frozen=True)
class Cycled:
    """Full cycles of one motion, (n,) each: ``time`` s after the release of their middle, ``frequency`` Hz, ``damping``
    ratio (decrement / 2 pi)."""

    time: Array
    frequency: Array
    damping: Array


@dataclass(frozen=True)
class Cycling:
    """A trial's measured cycles with one standard error of each, and its free runs': ``before`` as prescribed,
    ``after`` with what was found (None: nothing was)."""

    time: Array
    frequency: Array
    frequency_error: Array
    damping: Array
    damping_error: Array
    before: Cycled | None = None
    after: Cycled | None = None


def cycling(trial: TrialFindings) -> Cycling | None:
    """The cycles of one trial, without those that noise makes (`NOISE_TURNS`); None where it turns fewer than three
    times above its noise.

    A turning point's instant is known to (error of v) / |a|, its place to the error of x, both the smoothed motion's.
    """
    motion = trial.motion
    try:
        cycles, rise = _measured(motion)
        body = dominant_period(motion)
    except UndertowError:
        return None
    noise = motion.noise.get(scored_channel(motion), 0.0)
    count = _clear(cycles, noise)
    if count < 2:
        return None
    period = cycles.time[2 : count + 2] - cycles.time[:count]
    instants, places = rise[: count + 2], cycles.position_std[: count + 2] / math.sqrt(2.0)
    late = np.hypot(instants[2:], instants[:-2]) / period**2
    away = np.hypot(places[:-2] / cycles.amplitude[:count], places[2:] / cycles.amplitude[1 : count + 1])
    real = period > body / NOISE_TURNS
    after = None
    if trial.augmented is not None:
        after = _run(trial.t, trial.measured - trial.augmented.residual, count)
    return Cycling(
        cycles.time[1 : count + 1][real], 1.0 / period[real], late[real],
        cycles.decrement[:count][real] / (2.0 * math.pi), away[real] / math.pi,
        _run(trial.t, trial.simulated, count), after,
    )  # fmt: skip


def _measured(motion: Motion) -> tuple[Cycles, Array]:
    """A motion's turning points inside its window, and the standard error of their instants, s."""
    rate = scored_channel(motion) == "velocity"
    position, speed, std = ("v", "a", "v_std") if rate else ("x", "v", "x_std")
    t, slope = motion.windowed("t"), motion.windowed("a")
    cycles = find_cycles(t, motion.windowed(position), motion.windowed(speed), motion.windowed(std))
    turning = np.abs(np.interp(cycles.time, t, np.gradient(motion.windowed(speed), t) if rate else slope))
    error = np.interp(cycles.time, t, motion.windowed("a_std" if rate else "v_std"))
    return cycles, error / np.maximum(turning, 1e-300)


def _clear(cycles: Cycles, noise: float) -> int:
    """How many full cycles there are up to the last clear one: a beat may pass through nothing and come back, and there
    the errors say how little is known."""
    clear = np.flatnonzero(cycles.amplitude > max(CLEAR * noise, FAINT * float(cycles.amplitude[0])))
    return min(cycles.decrement.size, int(clear[-1]) + 1 if clear.size else 0)


def _run(t: Array, simulated: Array, count: int) -> Cycled | None:
    """A free run's first cycles; None where it hardly turns."""
    finite = np.isfinite(simulated)
    t, x = t[finite], simulated[finite]
    if t.size < 3:
        return None
    try:
        with np.errstate(divide="ignore", invalid="ignore"):
            cycles = find_cycles(t, x, np.gradient(x, t), np.zeros(t.size))
    except UndertowError:
        return None
    count = min(count, _clear(cycles, 0.0))
    if count < 1:
        return None
    period = cycles.time[2 : count + 2] - cycles.time[:count]
    return Cycled(cycles.time[1 : count + 1], 1.0 / period, cycles.decrement[:count] / (2.0 * math.pi))
