"""Recordings of a level in which nothing is missing, as many as one likes: its replicas, linear about its fit.

A replica's residual is noise with the spectrum of what the closest model leaves (its phases drawn anew), and what k, c,
mu of every trial, sensors' gains, clocks and drift do when they are drawn from what is believed of them; scatter seen
in few dry trials is itself drawn.

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
from undertow.likelihood.problem import Problem
from undertow.recording.recording import Array

OF_THE_MOTION = 4.0
"""Up to so many times the body's rate laws of motion leave something: beyond is noise."""

FEWEST_FAST = 10
"""Frequencies beyond, fewer than which do not show the noise: it is taken as stated."""

ONE_SIDED = 1.645
"""Standard deviations of a one-sided 95 % bound."""

ASSUMED_WITHIN = 2.0
"""A scatter that was assumed, not seen, may be wrong by this factor, to either side."""


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
        factor = np.repeat(
            [ours.sigma / theirs.sigma for ours, theirs in zip(trial.channels, channels, strict=True)], trial.t.size
        )
        trials.append(replace(trial, channels=channels))
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
        factors = [theirs.sigma / ours.sigma for ours, theirs in zip(trial.channels, other.channels, strict=True)]
        out.append(own * np.repeat(factors, trial.t.size))
    return tuple(out)


def surely_wrong(solution: Solution, left: Sequence[Array]) -> float:
    """Sum of squares that a model surely leaves (95 %) at the rates of the motion above what it leaves at all others:
    its own error, not the sensors'. ``left`` as in `left_by`."""
    excess = variance = 0.0
    for trial, r in zip(solution.problem.trials, left, strict=True):
        n = trial.t.size
        rate = np.fft.rfftfreq(n, float(np.median(np.diff(trial.t))))[1:]
        slow = rate <= OF_THE_MOTION / trial.period_s
        for i in range(len(trial.channels)):
            power = 2.0 / n * np.abs(np.fft.rfft(r[i * n : (i + 1) * n])[1:]) ** 2
            floor = float(np.median(power[~slow])) / math.log(2.0) if np.count_nonzero(~slow) > FEWEST_FAST else 2.0
            excess += float(np.sum(power[slow] - floor))
            variance += np.count_nonzero(slow) * floor**2
    return max(excess - ONE_SIDED * math.sqrt(variance), 0.0)


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
    for trial, r, jac, used in zip(solution.problem.trials, noise, solution.jacobians, solution.used, strict=True):
        n = trial.t.size
        drawn = [_phases(r[i * n : (i + 1) * n], draws, rng) for i in range(len(trial.channels))]
        out.append(np.vstack(drawn) + jac @ moved[used])
    return out


def _scatter_factors(level: Level, draws: int, rng: np.random.Generator) -> dict[str, Array]:
    """By what the true scatter of k, c, mu exceeds the believed one, (draws,) each: chi-squared with the degrees of
    freedom it was seen with, or within `ASSUMED_WITHIN` where it was assumed."""
    freedom = min((m.scatter_freedom for m in level.members), default=math.inf)
    if not math.isfinite(freedom):
        return {}
    if freedom <= 0.0:
        wide = math.log(ASSUMED_WITHIN)
        return {symbol: np.exp(rng.uniform(-wide, wide, draws)) for symbol in ("k", "c", "mu")}
    return {symbol: np.sqrt(freedom / rng.chisquare(freedom, draws)) for symbol in ("k", "c", "mu")}


def _phases(series: Array, draws: int, rng: np.random.Generator) -> Array:
    """Series with the spectrum of one (n,) and phases of their own, (n, draws)."""
    spectrum = np.abs(np.fft.rfft(series))
    angle = rng.uniform(0.0, 2.0 * math.pi, (spectrum.size, draws))
    turned = spectrum[:, None] * np.exp(1j * angle)
    turned[0] = spectrum[0] * np.sign(np.cos(angle[0]))
    if series.size % 2 == 0:
        turned[-1] = spectrum[-1] * math.sqrt(2.0) * np.cos(angle[-1])
    return np.asarray(np.fft.irfft(turned, series.size, axis=0), dtype=np.float64)
