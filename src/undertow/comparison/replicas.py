"""Recordings of a level in which nothing is missing, as many as one likes: its replicas, linear about its fit.

A replica's residual is Gaussian noise with the spectrum of what the closest model leaves, and what k, c, mu of every
trial, sensors' gains, clocks and drift do when they are drawn from what is believed of them; scatter seen in few dry
trials is itself drawn.

Belongs here: those residuals. Does not belong here: what is made of them (null_test.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from undertow.comparison.joint import JointFit
from undertow.comparison.level import Level
from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Problem, TrialProblem, Unknown
from undertow.recording.recording import Array

OF_THE_MOTION = 4.0
"""Up to so many times the body's rate laws of motion leave something: beyond is noise."""

WANDERING = 0.5
"""Up to so many times the body's rate sensors wander."""

FEWEST_CYCLES = 4
"""In a record, from so many on a slow line is told from a wandering sensor: it stands out of its neighbours."""

BEYOND = 10.0
"""A replica whose residual is so many times the recorded motion is none: where the equation's numbers let swings grow,
what differs from trial to trial grows without end, and nothing linear holds."""

FEWEST_FAST = 10
"""Frequencies beyond, fewer than which do not show the noise: it is taken as stated."""

SMOOTHED = 0.25
"""Share of a frequency to either side over which a spectrum is smoothed."""

FEWEST_SMOOTHED = 2
"""The same in frequencies, at least."""

NEAR = 3
"""The same where a line is told from what lies beside it."""

ONE_SIDED = 1.645
"""Standard deviations of a one-sided 95 % bound."""

QUARTERS = 4
"""Parts of a trial's time in which what a model leaves is compared."""

QUIETER = 7.8
"""By so many standard deviations of a quarter all four together exceed four times the quietest one, at most (95 %),
where all are alike: of four standard normal numbers, from two million draws. Slow noise has few frequencies and is less
alike: a quarter to a half of such residuals (first-order, .9 and .97 a sample) exceed it, by under a third of their
squares."""

SCATTERS = ("k", "c", "mu")
"""What each trial has of its own in the equation."""

RIGS_WITHIN = 2.0
"""Rigs differ in how much their trials scatter by this factor, to either side (a standard deviation of its logarithm):
all that is known where a scatter was assumed."""


def at_noise_of(null: JointFit, closest: JointFit) -> JointFit:
    """The null as fitted, weighed by the noise that the closest model leaves: at its own, which holds all that it
    misses, numbers of single trials would hardly move from what is believed of them."""
    old = null.solution
    trials, residuals, jacobians = [], [], []
    for trial, other, r, jac in zip(
        old.problem.trials, closest.solution.problem.trials, old.residuals, old.jacobians, strict=True
    ):
        own = {c.quantity: c.sigma for c in other.channels}
        channels = tuple(replace(c, sigma=own.get(c.quantity, c.sigma)) for c in trial.channels)
        trials.append(replace(trial, channels=channels))
        factor = noise_over(trial, trials[-1])
        residuals.append(r * factor)
        jacobians.append(jac * factor[:, None])
    chi2 = sum(float(r @ r) for r in residuals)
    solution = replace(
        old, problem=Problem(old.problem.unknowns, tuple(trials)), residuals=tuple(residuals),
        jacobians=tuple(jacobians), chi2=chi2, cost=old.cost - old.chi2 + chi2,
    )  # fmt: skip
    return replace(null, solution=solution)


def left_by(null: JointFit, closest: JointFit) -> tuple[Array, ...]:
    """Residuals of every trial that the closest model leaves, in units of the noise by which ``null`` is weighed; the
    null's own where they are of other samples."""
    out = []
    for trial, other, r, own in zip(
        null.solution.problem.trials, closest.solution.problem.trials, null.solution.residuals,
        closest.solution.residuals, strict=True,
    ):  # fmt: skip
        if r.size != own.size:
            return tuple(null.solution.residuals)
        out.append(own * noise_over(other, trial))
    return tuple(out)


def noise_over(one: TrialProblem, other: TrialProblem) -> Array:
    """The noise by which a trial's channels are weighed over that of the same channels in another problem, (rows,)."""
    ratios = [mine.sigma / theirs.sigma for mine, theirs in zip(one.channels, other.channels, strict=True)]
    return np.repeat(ratios, one.t.size)


def surely_wrong(solution: Solution, left: Sequence[Array]) -> float:
    """Sum of squares that a model surely leaves (95 % where noise is white) at the rates of the motion, above what it
    leaves at all others and in the quietest quarter of the time: its own error swells and dies with the motion, a
    sensor's goes on. ``left`` as in `left_by`."""
    excess = variance = 0.0
    energy, spread = np.zeros(QUARTERS), np.zeros(QUARTERS)
    for trial, r in zip(solution.problem.trials, left, strict=True):
        for series in np.split(r, len(trial.channels)):
            _, more, deviation = _above_noise(_power(series), _rate(trial))
            excess += 2.0 / series.size * more
            variance += (2.0 / series.size * deviation) ** 2
            for i, part in enumerate(np.array_split(series, QUARTERS)):
                rate = _rate(trial, part.size)
                lines = 2.0 / part.size * _power(part)[(rate > WANDERING) & (rate <= OF_THE_MOTION)]
                energy[i] += float(np.sum(lines))
                spread[i] += 0.5 * float(lines @ lines)  # of noise, whose mean square is twice its variance
    quietest = int(np.argmin(energy))
    above_others = excess - ONE_SIDED * math.sqrt(variance)
    above_quiet = float(np.sum(energy)) - QUARTERS * energy[quietest] - QUIETER * math.sqrt(spread[quietest])
    return max(min(above_others, float(above_quiet)), 0.0)


def _power(series: Array) -> Array:
    """Power of a series (n,) at every frequency of its transform but zero: n on average for white noise of one."""
    return np.asarray(np.abs(np.fft.rfft(series)[1:]) ** 2, dtype=np.float64)


def _above_noise(power: Array, rate: Array) -> tuple[float, float, float]:
    """The power of noise, what all frequencies of the motion have above it, and that sum's standard deviation; the
    noise is that of faster ones, or as stated where there are few. ``rate``: frequencies over the body's."""
    slow = rate <= OF_THE_MOTION
    stated = 2.0 * rate.size  # a residual is in units of the stated noise, and has twice as many samples
    floor = float(np.median(power[~slow])) / math.log(2.0) if np.count_nonzero(~slow) > FEWEST_FAST else stated
    return floor, float(np.sum(power[slow] - floor)), floor * math.sqrt(int(np.count_nonzero(slow)))


def replicas(
    level: Level, solution: Solution, noise: Sequence[Array], draws: int, rng: np.random.Generator
) -> list[Array]:
    """Residuals of every trial in every replica, each (rows, draws), weighed as the fit's."""
    unknowns = solution.problem.unknowns
    width = np.array([u.prior_std if math.isfinite(u.prior_std) else 0.0 for u in unknowns])
    moved = width[:, None] * rng.standard_normal((width.size, draws))
    for symbol, factor in _scatter_factors(level, draws, rng).items():
        mine = [i for i, u in enumerate(unknowns) if u.name.startswith(f"{symbol}[")]
        moved[mine] *= factor
    out = []
    for trial, r, own, jac, used in zip(
        solution.problem.trials, noise, solution.residuals, solution.jacobians, solution.used, strict=True
    ):
        n, rate = trial.t.size, _rate(trial)
        cuts = [slice(i * n, (i + 1) * n) for i in range(len(trial.channels))]
        drawn = [_drawn(r[cut], rate, own[cut], draws, rng) for cut in cuts]
        out.append(np.vstack(drawn) + jac @ moved[used])
    return out


def within_reason(solution: Solution, drawn: Sequence[Array]) -> bool:
    """Whether replicas are motions at all: half of them leave less than `BEYOND` times the motion."""
    trials = solution.problem.trials
    motion = sum(float(c.values @ c.values) / c.sigma**2 for trial in trials for c in trial.channels)
    return float(np.median(sum(np.sum(r * r, axis=0) for r in drawn))) < BEYOND**2 * motion


def _scatter_factors(level: Level, draws: int, rng: np.random.Generator) -> dict[str, Array]:
    """By what the true scatter of k, c, mu exceeds the believed one, (draws,) each: what the trials that showed it
    leave open (chi-squared with their degrees of freedom), no further off than rigs differ (`RIGS_WITHIN`)."""
    freedom = min((m.scatter_freedom for m in level.members), default=math.inf)
    if not math.isfinite(freedom):
        return {}
    logs = math.log(RIGS_WITHIN) * np.linspace(-6.0, 6.0, 1201)
    density = -freedom * (logs + 0.5 * np.exp(-2.0 * logs)) - 0.5 * (logs / math.log(RIGS_WITHIN)) ** 2
    chance = np.cumsum(np.exp(density - np.max(density)))
    return {
        symbol: np.exp(np.interp(rng.uniform(0.0, chance[-1], draws), chance, logs)) for symbol in SCATTERS
    }


def is_of_instrument(unknown: Unknown) -> bool:
    """Whether an unknown is what a trial's sensors, clock, release or rest may be off by, as is believed of them."""
    kind, of_a_trial, _ = unknown.name.partition("[")
    return bool(of_a_trial) and "." not in kind and kind not in SCATTERS and math.isfinite(unknown.prior_std)


def spectrum_of(series: Array, rate: Array, plain: Array) -> Array:
    """Power of a series (n,) at every frequency of its transform, smoothed over a quarter of the frequency to either
    side; ``rate`` are the frequencies but zero over the body's.

    Where the motion is, fits take noise up: there it is that of all faster frequencies, unless there is surely more;
    then it is no less than at any faster one, as sensors' noise falls with frequency. Below the motion sensors wander:
    there it is no less than what the ``plain`` equation leaves, (n,), and where there are cycles enough to tell a line,
    than the median of its neighbours: a line is no wander.
    """
    power = _power(series)
    count = power.size
    if not count:
        return np.zeros(1)
    at = np.arange(count)
    half = np.maximum(FEWEST_SMOOTHED, (SMOOTHED * (at + 1)).astype(int))
    below, above = np.maximum(at - half, 0), np.minimum(at + half + 1, count)
    total = np.concatenate([[0.0], np.cumsum(power)])
    smooth = (total[above] - total[below]) / (above - below)
    floor, excess, deviation = _above_noise(power, rate)
    falling = np.maximum.accumulate(np.maximum(smooth, floor)[::-1])[::-1]
    moving = falling if excess > ONE_SIDED * deviation else floor
    slow = int(np.count_nonzero(rate <= WANDERING))
    found = np.where(rate <= OF_THE_MOTION, moving, smooth)
    found[:slow] = np.maximum(_wandering(_power(plain), slow), floor)
    return np.concatenate([found[:1], found])


def _wandering(power: Array, count: int) -> Array:
    """The power (count,) of what wanders at the slowest frequencies of a transform without zero: the power itself, and
    from `FEWEST_CYCLES` on the median of those near it, which a line does not lift."""
    found = power[:count].copy()
    for i in range(FEWEST_CYCLES - 1, count):
        half = max(NEAR, int(SMOOTHED * (i + 1)))
        found[i] = np.median(power[max(i - half, 0) : i + half + 1]) / math.log(2.0)
    return found


def _drawn(series: Array, rate: Array, plain: Array, draws: int, rng: np.random.Generator) -> Array:
    """Gaussian noise with the smoothed spectrum of a series (n,), (n, draws)."""
    power = spectrum_of(series, rate, plain)
    parts = rng.standard_normal((2, power.size, draws))
    parts[0, 0] *= math.sqrt(2.0)  # frequency zero, and of an even number the highest, are real
    if series.size % 2 == 0:
        parts[0, -1] *= math.sqrt(2.0)
    turned = np.sqrt(0.5 * power)[:, None] * (parts[0] + 1j * parts[1])
    return np.asarray(np.fft.irfft(turned, series.size, axis=0), dtype=np.float64)


def _rate(trial: TrialProblem, samples: int = 0) -> Array:
    """Frequencies of a trial's transform, without zero, over the body's; of so many of its samples."""
    step = float(np.median(np.diff(trial.t)))
    return np.asarray(np.fft.rfftfreq(samples or trial.t.size, step)[1:] * trial.period_s, dtype=np.float64)
