"""A motion and its simulation cycle by cycle: frequency and damping at each amplitude; sidebands of the residual.

Belongs here: those comparisons and their sentences. Does not belong here: the shares of time and frequency (place.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import periodogram

from undertow.conditioning.cycles import Cycles, find_cycles
from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.discrepancy.place import BODY_BAND, strongest_line
from undertow.likelihood.free_run import FreeRun, scored_channel
from undertow.recording.recording import Array

CLEAR = 10.0
"""Half swings below this many times the noise say nothing of frequency or damping."""

FAINT = 0.03
"""Half swings under this share of the first are left out too: there friction is about to hold the body."""

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
    rate = scored_channel(motion) == "velocity"
    position, speed, error = ("v", "a", "v_std") if rate else ("x", "v", "x_std")
    noise = motion.noise.get(scored_channel(motion), 0.0)
    mine = find_cycles(motion.windowed("t"), motion.windowed(position), motion.windowed(speed), motion.windowed(error))
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
