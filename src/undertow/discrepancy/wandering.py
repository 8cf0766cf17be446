"""Whether what an equation leaves wanders: then it is a slow sensor's or the ground's, and no physics of the motion.

What a law leaves out swings at the body's rate and its multiples. Noise that is correlated from sample to sample has
as much power or more at slower rates than at the body's, and many times what single samples scatter by.

Belongs here: that comparison, and how much of the motion is left. Does not belong here: what follows from it
(decision.py).
"""

from __future__ import annotations

import math

import numpy as np

from undertow.comparison.candidate import Candidate
from undertow.comparison.joint import JointFit
from undertow.comparison.replicas import FEWEST_CYCLES
from undertow.discrepancy.words import spelled

SLOWER = (0.05, 0.5)
OF_THE_BODY = (0.6, 1.6)
"""Rates over the body's, from and to: of what wanders, and of what swings with the body."""

FASTER, MOST = 3.0, 0.5
"""Rate over the body's from which on what is left is faster than the motion, and the share that makes it so."""

SWINGS = 4.0
"""By what physics of the motion leaves more power at the body's rate than at slower ones, at least: medians of ten
frequencies and of twenty differ as much by chance in one case of 140."""

FEWEST = 3
"""Frequencies that tell a density."""


def wanders(fit: JointFit) -> bool:
    """Whether the median power of what all trials leave, of their first channel, is at the body's rate not `SWINGS`
    times that at slower rates; False where records are too short to tell."""
    slower, swinging = list[float](), list[float]()
    for trial, r in zip(fit.solution.problem.trials, fit.solution.residuals, strict=True):
        n = trial.t.size
        power = np.abs(np.fft.rfft(r[:n] * np.hanning(n)))[1:] ** 2 / n
        rate = np.fft.rfftfreq(n, float(np.median(np.diff(trial.t))))[1:] * trial.period_s
        for found, (low, high) in ((slower, SLOWER), (swinging, OF_THE_BODY)):
            found += power[(rate >= low) & (rate <= high)].tolist()
    if min(len(slower), len(swinging)) < FEWEST:
        return False
    return bool(SWINGS * np.median(slower) >= np.median(swinging))


def no_physics(fit: JointFit) -> str:
    """What it is that wanders, in words: most of it slower than the motion, or at one faster rate."""
    rates, power = list[np.ndarray](), list[np.ndarray]()
    for trial, r in zip(fit.solution.problem.trials, fit.solution.residuals, strict=True):
        n = trial.t.size
        power.append(np.abs(np.fft.rfft(r[:n] * np.hanning(n)))[1:] ** 2)
        rates.append(np.fft.rfftfreq(n, float(np.median(np.diff(trial.t))))[1:])
    periods = [trial.period_s for trial in fit.solution.problem.trials]
    fast = [np.sum(one[rate * period > FASTER]) for one, rate, period in zip(power, rates, periods, strict=True)]
    if sum(fast) <= MOST * sum(float(np.sum(one)) for one in power):
        return "slower than the motion: a sensor that wanders, the ground, or a slow push (wind, a hand)"
    at = float(np.median([rate[int(np.argmax(one))] for one, rate in zip(power, rates, strict=True)]))
    return f"faster than the motion, at {at:.3g} Hz: hum of the mains, or a sensor or its mount that rings"


def left_share(fit: JointFit) -> float:
    """RMS of what the equation leaves of the displacement (a velocity where none is recorded), k, c, mu of each trial's
    own, over the RMS of the motion; of all trials together."""
    return math.sqrt(float(np.mean([share**2 for share in left_shares(fit).values()])))


def left_shares(fit: JointFit) -> dict[str, float]:
    """The same of every trial, by its name."""
    shares = {}
    for trial, r in zip(fit.solution.problem.trials, fit.solution.residuals, strict=True):
        quantities = [channel.quantity for channel in trial.channels]
        at = next((i for i, quantity in enumerate(quantities) if quantity in ("displacement", "velocity")), 0)
        channel, n = trial.channels[at], trial.t.size
        square = channel.sigma**2 * float(np.mean(r[at * n : (at + 1) * n] ** 2)) / float(np.var(channel.values))
        shares[trial.name] = math.sqrt(square)
    return shares


def as_what(best: Candidate) -> str:
    """What comes closest, in words, and that a sensor which wanders looks like it where it makes few cycles."""
    trials = best.fit.solution.problem.trials
    longest = max((float(trial.t[-1] - trial.t[0]) for trial in trials), default=math.inf)
    rates = [
        best.fit.values.get(f"{addend.prefix}.{a.name}", math.inf)
        for addend in best.fit.addends for a in addend.additions if a.inner and a.unit == "rad/s"
    ]  # fmt: skip
    names = " and ".join(spelled(name) for name in best.names)
    if min(rates, default=math.inf) * longest >= 2.0 * math.pi * FEWEST_CYCLES:
        return f" as {names}"
    return f" as {names}, which makes fewer than {FEWEST_CYCLES} cycles in a record, as a sensor that wanders may"
