"""Recordings of a level in which nothing is missing, as many as one likes: its replicas, linear about its fit.

A replica's residual is Gaussian noise with the spectrum of what the closest model leaves, and what k, c, mu of every
trial, sensors' gains, clocks and drift do when they are drawn from what is believed of them; scatter seen in few dry
trials is itself drawn.

Belongs here: those residuals. Does not belong here: what is made of them (null_test.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import gammaincinv

from undertow.comparison.deviations import of_the_means
from undertow.comparison.joint import JointFit
from undertow.comparison.level import Level
from undertow.comparison.suspect import Addition
from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Problem, TrialProblem, Unknown
from undertow.methods.dry import RIGS_WITHIN
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

SURELY = 0.95
"""Probability with which noise is less than what is held to be more than noise."""

ONE_SIDED = 1.645
"""Standard deviations of that one-sided bound."""

QUARTERS = 4
"""Parts of a trial's time in which what a model leaves is compared."""

QUIETER = 7.8
"""By so many standard deviations of a quarter all four together exceed four times the quietest one, at most (95 %),
where all are alike: of four standard normal numbers, from two million draws. Slow noise has few frequencies and is less
alike: a quarter to a half of such residuals (first-order, .9 and .97 a sample) exceed it, by under a third of their
squares."""

OF_ONE_SENSOR = ("displacement_gain", "acceleration_gain", "acceleration_shift_s")
"""What a laboratory has in all trials alike where one sensor recorded them: its calibration, its filter's delay."""

ALIKE = 0.5
"""Share of replicas in which it is so; in the others each trial's is its own."""

SCATTERS = ("k", "c", "mu")
"""What each trial has of its own in the equation."""


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


def wanders_as(solution: Solution, additions: Sequence[Addition]) -> bool:
    """Whether what has a frequency of its own is as slow as sensors wander by, in some trial: no size of it is seen,
    for replicas wander as much."""
    slow = WANDERING * max(2.0 * np.pi / trial.period_s for trial in solution.problem.trials)
    return any(a.inner and a.unit == "rad/s" and a.start <= slow for a in additions)


def not_slow(solution: Solution, left: Sequence[Array]) -> float:
    """Share of squares (rows,) of every trial that is no slower than what sensors wander by."""
    fast = every = 0.0
    for trial, r in zip(solution.problem.trials, left, strict=True):
        for series in np.split(r, len(trial.channels)):
            lines = _power(series)
            fast, every = fast + float(np.sum(lines[_rate(trial) > WANDERING])), every + float(np.sum(lines))
    return fast / every if every > 0.0 else 1.0


def _power(series: Array) -> Array:
    """Power of a series (n,) at every frequency of its transform but zero: n on average for white noise of one."""
    return np.asarray(np.abs(np.fft.rfft(series)[1:]) ** 2, dtype=np.float64)


def _above_noise(power: Array, rate: Array) -> tuple[float, float, float]:
    """The power of noise, what all frequencies of the motion have above it, and that sum's standard deviation; the
    noise is that of faster ones, or as stated where there are few. ``rate``: frequencies over the body's."""
    slow = rate <= OF_THE_MOTION
    stated = 2.0 * rate.size  # a residual is in units of the stated noise, and has twice as many samples
    lines, fast = int(np.count_nonzero(slow)), int(np.count_nonzero(~slow))
    if fast <= FEWEST_FAST:
        return stated, float(np.sum(power[slow] - stated)), stated * math.sqrt(lines)
    floor = float(np.median(power[~slow])) / math.log(2.0)
    unsure = lines / (math.log(2.0) * math.sqrt(fast))  # a median's standard error, over what it is of
    return floor, float(np.sum(power[slow] - floor)), floor * math.hypot(math.sqrt(lines), unsure)


def replicas(
    level: Level, solution: Solution, noise: Sequence[Array], draws: int, rng: np.random.Generator
) -> list[Array]:
    """Residuals of every trial in every replica, each (rows, draws), weighed as the fit's."""
    unknowns = solution.problem.unknowns
    width = believed_widths(level, solution)
    moved = width[:, None] * rng.standard_normal((width.size, draws))
    for symbol, factor in _scatter_factors(level, draws, rng).items():
        mine = [i for i, u in enumerate(unknowns) if u.name.startswith((f"{symbol}[", f"{symbol}_mean@"))]
        moved[mine] *= factor
    for mine in of_one_sensor(unknowns):
        moved[mine] = np.where(rng.random(draws) < ALIKE, width[mine, None] * rng.standard_normal(draws), moved[mine])
    spectra = _spectra(solution, noise)
    out = []
    for trial, own, jac, used in zip(
        solution.problem.trials, spectra, solution.jacobians, solution.used, strict=True
    ):
        drawn = [_drawn(power, trial.t.size, draws, rng) for power in own]
        out.append(np.vstack(drawn) + jac @ moved[used])
    return out


def _spectra(solution: Solution, noise: Sequence[Array]) -> list[list[Array]]:
    """`spectrum_of` what is left of every channel in every trial; whether a sensor's noise rises towards slower
    frequencies, and whether it wanders, is told from all trials that have it."""
    trials, cut = solution.problem.trials, []
    for trial, *both in zip(trials, noise, solution.residuals, strict=True):
        rows = (np.split(each, len(trial.channels)) for each in both)
        cut.append([LeftBy(closest, plain, _rate(trial)) for closest, plain in zip(*rows, strict=True)])
    together: dict[str, list[LeftBy]] = {}
    for trial, own in zip(trials, cut, strict=True):
        for channel, left in zip(trial.channels, own, strict=True):
            together.setdefault(channel.quantity, []).append(left)
    rises = {quantity: (_rises(left), _wanders(left)) for quantity, left in together.items()}
    return [
        [spectrum_of(left, *rises[channel.quantity]) for channel, left in zip(trial.channels, own, strict=True)]
        for trial, own in zip(trials, cut, strict=True)
    ]


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


def believed_widths(level: Level, solution: Solution) -> Array:
    """Standard deviation of every unknown's deviation in replicas, (p,): 0 of what has no prior.

    Of a spring's means what its dry trials left; of what trials' instruments are off by no more than all trials of the
    level show together with one that is as the prior says: a prior is wide enough for any laboratory, and what it holds
    possible is no noise of this one. What no trial tells stays as the prior says.
    """
    unknowns = solution.problem.unknowns
    means = {mean.name: mean.believed_std for member in level.members for mean in of_the_means(member)}
    prior = np.array([means.get(u.name, u.prior_std) for u in unknowns])
    width = np.where(np.isfinite(prior), prior, 0.0)
    away = solution.values - np.array([u.start for u in unknowns])
    square = away**2 + np.diag(solution.covariance)
    kinds: dict[str, list[int]] = {}
    for i in (i for i, u in enumerate(unknowns) if is_of_instrument(u) and width[i] > 0.0):
        kinds.setdefault(unknowns[i].name.partition("[")[0], []).append(i)
    for mine in kinds.values():
        ratio = (1.0 + float(np.sum(square[mine] / width[mine] ** 2))) / (1.0 + len(mine))
        width[mine] *= math.sqrt(min(ratio, 1.0))
    return np.asarray(width, dtype=np.float64)


def of_one_sensor(unknowns: Sequence[Unknown]) -> list[list[int]]:
    """Unknowns that are off alike in all trials where one sensor recorded them, those of each of `OF_ONE_SENSOR`."""
    kinds = ([i for i, u in enumerate(unknowns) if u.name.startswith(f"{kind}[")] for kind in OF_ONE_SENSOR)
    return [mine for mine in kinds if mine]


def is_of_instrument(unknown: Unknown) -> bool:
    """Whether an unknown is what a trial's sensors, clock, release or rest may be off by, as is believed of them."""
    kind, of_a_trial, _ = unknown.name.partition("[")
    return bool(of_a_trial) and "." not in kind and kind not in SCATTERS and math.isfinite(unknown.prior_std)


@dataclass(frozen=True)
class LeftBy:
    """What the closest model and the ``plain`` equation leave of one channel of a trial, (n,) each, and frequencies of
    its transform, without zero, over the body's."""

    closest: Array
    plain: Array
    rate: Array


def _rises(left: Sequence[LeftBy]) -> bool:
    """Whether a sensor surely has more noise at the rates of the motion than at faster ones."""
    found = [_above_noise(_power(one.closest), one.rate) for one in left if one.rate.size]
    more = sum(excess / floor for floor, excess, _ in found if floor > 0.0)
    return more > ONE_SIDED * math.sqrt(sum((deviation / floor) ** 2 for floor, _, deviation in found if floor > 0.0))


def _wanders(left: Sequence[LeftBy]) -> bool:
    """Whether a sensor surely has more than noise below the motion: sums of lines of noise are of gamma's law."""
    more, lines = 0.0, 0
    for one in left:
        floor, *_ = _above_noise(_power(one.closest), one.rate) if one.rate.size else (0.0,)
        slow = _power(one.plain)[one.rate <= WANDERING]
        if floor > 0.0:
            more, lines = more + float(np.sum(slow)) / floor, lines + slow.size
    return lines > 0 and more > float(gammaincinv(lines, SURELY))


def spectrum_of(left: LeftBy, rises: bool, wanders: bool) -> Array:
    """Power of what is left of a channel at every frequency of its transform, smoothed over a quarter of the frequency
    to either side.

    Where the motion is, fits take noise up: there it is that of all faster frequencies, unless the sensor's noise
    ``rises``; then it is no less than at any faster one, as sensors' noise falls with frequency. Below the motion
    sensors may wander. The slowest lines, too few cycles to tell a line, are no less than what the plain equation
    leaves: sensors drift. Of the others that holds where the sensor surely ``wanders``, and of a line's neighbours
    then, for a line is no wander; elsewhere they are noise alone, for the larger of two numbers that both scatter about
    it lifts replicas above their recording.
    """
    power = _power(left.closest)
    count = power.size
    if not count:
        return np.zeros(1)
    at = np.arange(count)
    half = np.maximum(FEWEST_SMOOTHED, (SMOOTHED * (at + 1)).astype(int))
    below, above = np.maximum(at - half, 0), np.minimum(at + half + 1, count)
    total = np.concatenate([[0.0], np.cumsum(power)])
    smooth = (total[above] - total[below]) / (above - below)
    floor, *_ = _above_noise(power, left.rate)
    moving = np.maximum.accumulate(np.maximum(smooth, floor)[::-1])[::-1] if rises else floor
    slow = int(np.count_nonzero(left.rate <= WANDERING))
    found = np.where(left.rate <= OF_THE_MOTION, moving, smooth)
    drift = slow if wanders else min(slow, FEWEST_CYCLES - 1)
    found[:slow] = floor
    found[:drift] = np.maximum(_wandering(_power(left.plain), drift), floor)
    return np.concatenate([found[:1], found])


def _wandering(power: Array, count: int) -> Array:
    """The power (count,) of what wanders at the slowest frequencies of a transform without zero: the power itself, and
    from `FEWEST_CYCLES` on the median of those near it, which a line does not lift."""
    found = power[:count].copy()
    for i in range(FEWEST_CYCLES - 1, count):
        half = max(NEAR, int(SMOOTHED * (i + 1)))
        found[i] = np.median(power[max(i - half, 0) : i + half + 1]) / math.log(2.0)
    return found


def _drawn(power: Array, samples: int, draws: int, rng: np.random.Generator) -> Array:
    """Gaussian noise of that power at every frequency of the transform of so many samples, (samples, draws)."""
    parts = rng.standard_normal((2, power.size, draws))
    parts[0, 0] *= math.sqrt(2.0)  # frequency zero, and of an even number the highest, are real
    if samples % 2 == 0:
        parts[0, -1] *= math.sqrt(2.0)
    turned = np.sqrt(0.5 * power)[:, None] * (parts[0] + 1j * parts[1])
    return np.asarray(np.fft.irfft(turned, samples, axis=0), dtype=np.float64)


def _rate(trial: TrialProblem, samples: int = 0) -> Array:
    """Frequencies of a trial's transform, without zero, over the body's; of so many of its samples."""
    step = float(np.median(np.diff(trial.t)))
    return np.asarray(np.fft.rfftfreq(samples or trial.t.size, step)[1:] * trial.period_s, dtype=np.float64)
