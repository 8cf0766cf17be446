"""Frequency and damping cycle by cycle: of one trial with their errors, beside its free runs or a simulation's.

Belongs here: these numbers, the sentence on where they part, sidebands of the residual. Does not belong here: the
shares of time and frequency (place.py), figures (report/).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import periodogram

from undertow.conditioning.cycles import Cycles, find_cycles
from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.discrepancy.findings import TrialFindings
from undertow.discrepancy.place import BODY_BAND, strongest_line
from undertow.errors import UndertowError
from undertow.likelihood.free_run import FreeRun, scored_channel
from undertow.recording.recording import Array

CLEAR = 10.0
"""Half swings below this many times the noise say nothing of frequency or damping."""

FAINT = 0.03
"""Half swings under this share of the first are left out too: there friction is about to hold the body."""

NOISE_TURNS = 3.0
"""A cycle shorter than the body's period by more than this factor is turned by noise; no law here makes one."""

STILL = 1e-3
"""A half swing under this share of the first is rest: what is left of an integrator's digits."""

SAID_FREQUENCY, SAID_DAMPING = 0.003, 0.003
"""Differences are put in words from 0.3 % of the frequency and from a damping ratio of 0.003 on."""


@dataclass(frozen=True)
class CycleComparison:
    """Full cycles of one trial beside those of a simulation at the same instants, (n,) each.

    ``time`` s after the release, ``amplitude`` m (rad), frequencies in Hz, damping ratios (decrement / 2 pi); nan where
    the simulation has come to rest.
    """

    time: Array
    amplitude: Array
    frequency_hz: Array
    frequency_hz_simulated: Array
    damping_ratio: Array
    damping_ratio_simulated: Array

    def sentence(self) -> str:
        """Where frequency and damping part, at large and at small amplitude; empty where they do not or no cycle is
        clear. Cycles after the simulation has come to rest have no counterpart and are counted in words."""
        both = np.flatnonzero(np.isfinite(self.damping_ratio_simulated))
        if both.size < 2:
            return ""
        parts = []
        half = both.size // 2
        for word, at in (("large", both[:half]), ("small", both[half:])):
            away = float(np.median(self.frequency_hz[at] / self.frequency_hz_simulated[at])) - 1.0
            damped = float(np.median(self.damping_ratio[at] - self.damping_ratio_simulated[at]))
            said = []
            if abs(away) >= SAID_FREQUENCY:
                said.append(f"the frequency is {100.0 * abs(away):.2g} % {'higher' if away > 0.0 else 'lower'}")
            if abs(damped) >= SAID_DAMPING:
                own = float(np.median(self.damping_ratio[at]))
                said.append(f"the damping is {100.0 * own:.2g} % of critical, not {100.0 * (own - damped):.2g} %")
            if said:
                parts.append(f"at {word} amplitude {' and '.join(said)}")
        if stopped := self.time.size - both.size:
            cycles = f"{stopped} cycle{'s' if stopped > 1 else ''} more"
            parts.append(f"it swings {cycles} after the simulation's equation has come to rest")
        return "; ".join(parts)


@dataclass(frozen=True)
class Sidebands:
    """Lines of a residual beside the body's own: ``spacing_hz`` of the strongest from the body, and the shares of the
    residual's power at the body's frequency minus and plus that spacing.

    One side alone is a beat with something that oscillates by itself; both together are a motion whose size or
    frequency changes with that rhythm.
    """

    spacing_hz: float
    lower_share: float
    upper_share: float


def compare_cycles(motion: Motion, run: FreeRun) -> CycleComparison:
    """Cycles of the smoothed motion inside its window beside those of its free run.

    Raises RecordingError where either turns fewer than three times.
    """
    noise, mine = motion.noise.get(scored_channel(motion), 0.0), _cycles_of(motion)
    slope = np.gradient(run.simulated, run.t)
    with np.errstate(divide="ignore"):  # a simulation that has come to rest turns by nothing; see _at
        theirs = find_cycles(run.t, run.simulated, slope, np.zeros(run.t.size))
    clear = mine.amplitude > max(CLEAR * noise, FAINT * float(mine.amplitude[0]))
    count = min(mine.decrement.size, int(np.argmin(clear)) if not clear.all() else clear.size)
    time = mine.time[1 : count + 1]
    frequency, damping = _at(theirs, time)
    return CycleComparison(
        time,
        mine.amplitude[:count],
        0.5 * (mine.frequency_hz[:count] + mine.frequency_hz[1 : count + 1]),
        frequency,
        mine.decrement[:count] / (2.0 * math.pi),
        damping,
    )


def _cycles_of(motion: Motion) -> Cycles:
    """A motion's turning points inside its window: of the velocity where that is what was recorded."""
    names = ("v", "a", "v_std") if scored_channel(motion) == "velocity" else ("x", "v", "x_std")
    return find_cycles(*(motion.windowed(name) for name in ("t", *names)))


def _at(cycles: Cycles, time: Array) -> tuple[Array, Array]:
    """Frequency (Hz) and damping ratio of full cycles at the instants ``time`` (n,) of their middle turning points."""
    swings = cycles.amplitude[1:] > STILL * cycles.amplitude[0]  # a body that has come to rest has no cycles
    middle = cycles.time[1 : cycles.decrement.size + 1][swings]
    frequency = 0.5 * (cycles.frequency_hz[:-1] + cycles.frequency_hz[1:])[swings]
    damping = cycles.decrement[swings] / (2.0 * math.pi)
    if not middle.size:
        none = np.full(time.size, math.nan)
        return none, none
    rests = time > middle[-1] + 1.0 / frequency[-1]
    found = np.interp(time, middle, frequency), np.interp(time, middle, damping)
    return np.where(rests, math.nan, found[0]), np.where(rests, math.nan, found[1])


def sidebands(motion: Motion, run: FreeRun) -> Sidebands:
    """The residual's strongest line as sidebands of the body's motion; nan where it has none."""
    body = 1.0 / dominant_period(motion)
    line, _ = strongest_line(run.t, run.residual, body, motion.noise.get(scored_channel(motion), 0.0))
    if not math.isfinite(line):
        return Sidebands(math.nan, math.nan, math.nan)
    spacing = abs(line - body)
    step = float(np.median(np.diff(run.t)))
    even = np.interp(np.arange(run.t[0], run.t[-1], step), run.t, run.residual)
    frequency, power = periodogram(even, 1.0 / step, "hann", detrend="linear")
    width = frequency[1] - frequency[0]

    def share(at: float) -> float:
        near = np.abs(frequency - at) <= 1.5 * width
        return float(np.sum(power[near]) / np.sum(power)) if at > BODY_BAND * body else 0.0

    return Sidebands(spacing, share(body - spacing), share(body + spacing))


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
    cycles, t, slope = _cycles_of(motion), motion.windowed("t"), motion.windowed("a")
    rate = scored_channel(motion) == "velocity"
    turning = np.abs(np.interp(cycles.time, t, np.gradient(slope, t) if rate else slope))
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
