"""The same quantity in several trials: its mean over all such trials, its scatter between them, and how sure both are.

Each trial gives a value with its own noise; beyond noise the trials differ, by how much is known from few of them.
Where a single estimate of that scatter is put in, chance agreement of three or four trials passes for precision; so it
is summed over.

Belongs here: the normal random-effects model of single numbers. Does not belong here: fits of several trials together
(hierarchy.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from undertow.errors import IdentificationError
from undertow.quantities import Estimate
from undertow.recording.recording import Array
from undertow.uncertainty.confidence import as_stderr, mixture_half_width

GRID = 300
"""Values of the scatter that are summed over, even in its logarithm: twice as many change a half width by 1e-3."""

GRID_OF_TWO = 60
"""The same for each of two scatters at once."""

SMALLEST, LARGEST = 1e-3, 1e3
"""Ends of that grid, relative to the values' own spread (noise and range): beyond, the posterior has nothing left."""


@dataclass(frozen=True)
class Between:
    """Posterior of the standard deviation between trials: ``values`` (m,) with ``weights`` (m,) that sum to 1."""

    values: Array
    weights: Array

    @property
    def median(self) -> float:
        """The scatter that is as likely too small as too large."""
        return float(np.interp(0.5, np.cumsum(self.weights) - 0.5 * self.weights, self.values))


def weighted_mean(values: Array, noise: Array, between: float) -> tuple[float, float]:
    """Mean of values (n,) that have ``noise`` (n,) and differ by a standard deviation ``between``, and its error.

    >>> mean, error = weighted_mean(np.array([1.0, 3.0]), np.array([0.0, 0.0]), 1.0)
    >>> mean, round(error, 4)
    (2.0, 0.7071)
    """
    variance = noise**2 + between**2
    exact = variance == 0.0
    if np.any(exact):
        return float(np.mean(values[exact])), 0.0
    weights = 1.0 / variance
    return float(weights @ values / np.sum(weights)), 1.0 / math.sqrt(float(np.sum(weights)))


def scatter_between(groups: Sequence[tuple[Array, Array]], usual: tuple[float, float] | None = None) -> Between:
    """Posterior of the scatter that groups of trials have in common, each about its own mean.

    ``groups`` holds (values (n,), noise (n,)) of two or more trials each. Likelihood with the means integrated out;
    prior sqrt(sum (s / (noise^2 + s^2))^2), the reference prior, with which the mean's intervals cover what they say
    (Bodnar et al. 2017, doi:10.1002/sim.7156); without noise it makes the mean Student's t at n - 1 degrees of freedom.
    With what is ``usual`` and the factor within which it is (a standard deviation of the logarithm) that is the prior:
    trials whose noise hides any scatter then say nothing, in place of that it may be as large as their noise.

    IdentificationError where no group has two trials.
    """
    seen = [(values, noise) for values, noise in groups if values.size > 1]
    if not seen:
        raise IdentificationError(
            f"scatter between trials: {len(groups)} groups, none with two trials; repeat a release"
        )
    size = max(math.hypot(float(np.ptp(values)), float(np.min(noise))) for values, noise in seen)
    if not size > 0.0:
        return Between(np.zeros(1), np.ones(1))
    low, high = (size * SMALLEST, size * LARGEST) if usual is None else (
        min(size, usual[0]) * SMALLEST, max(size, usual[0]) * LARGEST)
    grid = np.geomspace(low, high, GRID)
    log_weight = np.log(grid)  # the grid is even in the logarithm
    prior = np.zeros(GRID)
    for values, noise in seen:
        variance = noise[:, None] ** 2 + grid**2
        total = np.sum(1.0 / variance, axis=0)
        mean = values @ (1.0 / variance) / total
        log_weight += -0.5 * np.sum(np.log(variance) + (values[:, None] - mean) ** 2 / variance, axis=0)
        log_weight -= 0.5 * np.log(total)
        prior += np.sum((grid / variance) ** 2, axis=0)
    if usual is None:
        log_weight += 0.5 * np.log(prior)
    else:
        log_weight -= np.log(grid) + 0.5 * (np.log(grid / usual[0]) / math.log(usual[1])) ** 2
    weights = np.exp(log_weight - np.max(log_weight))
    return Between(grid, weights / np.sum(weights))


def scatter_of_two(groups: Sequence[tuple[Array, Array, Array]]) -> tuple[Between, Between]:
    """`scatter_between` of two numbers whose noise goes together, as that of viscous damping and friction: a trial that
    tells neither well can tell that both did not change.

    ``groups`` holds (values (n, 2), noise (n, 2), its correlation (n,)) of two or more trials each.
    """
    middle = [values - np.mean(values, axis=0) for values, _, _ in groups]
    sizes = [
        max(
            math.hypot(float(np.ptp(y[:, j])), float(np.min(noise[:, j])))
            for y, (_, noise, _) in zip(middle, groups, strict=True)
        )
        for j in (0, 1)
    ]
    if not min(sizes) > 0.0:
        one, other = (scatter_between([(v[:, j], noise[:, j]) for v, noise, _ in groups]) for j in (0, 1))
        return one, other
    axes = [size * np.geomspace(SMALLEST, LARGEST, GRID_OF_TWO) for size in sizes]
    grid = np.meshgrid(*axes, indexing="ij")
    log_weight = np.log(grid[0]) + np.log(grid[1])
    prior = np.zeros((2, GRID_OF_TWO, GRID_OF_TWO))
    for y, (_, noise, correlation) in zip(middle, groups, strict=True):
        total, pulled = np.zeros((3, GRID_OF_TWO, GRID_OF_TWO)), np.zeros((2, GRID_OF_TWO, GRID_OF_TWO))
        for (a, b), size, together in zip(y, noise, correlation, strict=True):
            common = together * size[0] * size[1]
            first, second = size[0] ** 2 + grid[0] ** 2, size[1] ** 2 + grid[1] ** 2
            determinant = first * second - common**2
            own = np.array([second, -common * np.ones_like(first), first]) / determinant
            total += own
            pulled += [own[0] * a + own[1] * b, own[1] * a + own[2] * b]
            log_weight -= 0.5 * (np.log(determinant) + own[0] * a * a + 2.0 * own[1] * a * b + own[2] * b * b)
            alone = 1.0 - together**2  # of either's variance, if the other was known
            prior += [(t / (alone * noise_size**2 + t**2)) ** 2 for t, noise_size in zip(grid, size, strict=True)]
        determinant = total[0] * total[2] - total[1] ** 2
        of_mean = total[2] * pulled[0] ** 2 - 2.0 * total[1] * pulled[0] * pulled[1] + total[0] * pulled[1] ** 2
        log_weight += 0.5 * (of_mean / determinant - np.log(determinant))
    log_weight += 0.5 * np.sum(np.log(prior), axis=0)
    weights = np.exp(log_weight - np.max(log_weight))
    weights /= np.sum(weights)
    return Between(axes[0], np.sum(weights, axis=1)), Between(axes[1], np.sum(weights, axis=0))


def mean_over(values: Array, noise: Array, between: Between) -> tuple[float, float]:
    """Mean of values (n,) with ``noise`` (n,) under a posterior of their scatter, and its standard error."""
    variance = noise[:, None] ** 2 + between.values**2
    if np.any(variance == 0.0):
        return weighted_mean(values, noise, 0.0)
    total = np.sum(1.0 / variance, axis=0)
    centres = values @ (1.0 / variance) / total
    mean = float(between.weights @ centres)
    return mean, as_stderr(mixture_half_width(mean, centres, 1.0 / np.sqrt(total), between.weights))


def mean_of_trials(estimates: Sequence[Estimate], unit: str, source: str) -> Estimate:
    """Mean over trials that differ by more than their noise, and how sure it is of the mean over all such trials.

    The scatter is summed over (`scatter_between`): with 3, 4 or 6 trials the standard error is up to 1.8 times the
    scatter over sqrt(n). One trial has no scatter to show: its own error. IdentificationError without a finite value.

    >>> from undertow.uncertainty.confidence import widening
    >>> three = [Estimate(value) for value in (9.0, 10.0, 11.0)]
    >>> mean = mean_of_trials(three, "kg", "three trials")
    >>> round(mean.stderr / (1.0 / 3**0.5), 2), round(widening(2.0), 2)
    (1.78, 1.78)
    """
    good = [e for e in estimates if math.isfinite(e.value)]
    if not good:
        raise IdentificationError(
            f"{source}: none of {len(estimates)} trials has a finite value; look at their outcomes"
        )
    values = np.array([e.value for e in good])
    noise = noise_of(good)
    if values.size == 1:
        return Estimate(float(values[0]), float(noise[0]) or math.nan, unit=unit, source=source)
    mean, error = mean_over(values, noise, scatter_between([(values, noise)]))
    return Estimate(mean, error, unit=unit, source=source, freedom=values.size - 1.0)


def noise_of(estimates: Sequence[Estimate]) -> Array:
    """Standard errors (n,) of single trials, 0 where there is none: their scatter then speaks alone."""
    return np.array([e.stderr if math.isfinite(e.stderr) else 0.0 for e in estimates])
