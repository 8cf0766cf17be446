"""Trials that differ by more than their errors: the error of what they give together grows until they agree.

A joint fit takes its unknowns to be the same in every trial. Where each trial fitted alone says something else, by more
than its noise, the joint value is a mean over trials that differ, and its error that of such a mean: random effects
(DerSimonian and Laird 1986, doi:10.1016/0197-2456(86)90046-2), with the scatter between trials summed over.

Trials may also agree one by one and still differ in halves: those of small against those of large amplitude. And fits
of their own may differ in a number that they should share, as springs in one water or levels on one spring: errors then
grow by the scatter at which chi-squared is its degrees of freedom (Paule and Mandel 1982, doi:10.6028/jres.087.022).

Belongs here: these tests and the grown errors. Does not belong here: means of single fits (repeats.py), quantities
whose scatter a fit already holds (hierarchy.py), which groups share a number (campaign/run/differing.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2

from undertow.quantities import OK, Estimate
from undertow.recording.recording import Array
from undertow.uncertainty.confidence import as_stderr, mixture_half_width
from undertow.uncertainty.growth import HALVES, Grown
from undertow.uncertainty.repeats import scatter_between, weighted_mean

ALIKE = 0.32
"""Trials at least as different as these must be this probable by chance, or errors grow: one standard deviation. A test
at 0.05 misses scatter as large as the errors: 90 % intervals then hold 77 to 83 %. Growing always makes them hold 99 to
100 % where trials are alike. With this 84 to 93 % in every row (experiments/coverage/between.md)."""

DIFFER = "trials differ"
"""How the source of an estimate ends whose error has grown."""

FEWEST = 2
"""Trials that can differ."""

FEWEST_IN_HALVES = 4
"""Trials that have two halves of two or more."""


def grown(
    together: Mapping[str, Estimate], alone: Sequence[Mapping[str, Estimate]], amplitudes: Sequence[float] = ()
) -> tuple[dict[str, Estimate], tuple[Grown, ...]]:
    """Estimates of a joint fit with errors that hold how much its trials differ, and in what they do.

    ``alone`` is what each trial gives by itself, by the same names; what sits on a bound, has no error, or is held the
    same in all of them does not count. With ``amplitudes``, one a trial, the half with the smaller ones is compared
    with the other half; the larger error stays. The systematic part is common to all trials and stays as it is.

    >>> joint = {"mass_kg": Estimate(10.0, 0.5, unit="kg")}
    >>> errors, found = grown(joint, [{"mass_kg": Estimate(v, 1.0, unit="kg")} for v in (4.0, 10.0, 10.0, 16.0)])
    >>> round(errors["mass_kg"].stderr, 1), found[0].parameter, round(found[0].chi_squared)
    (3.5, 'mass_kg', 72)
    >>> alike = [{"mass_kg": Estimate(v, 1.0, unit="kg")} for v in (9.3, 9.3, 10.7, 10.7)]
    >>> grown(joint, alike)[1]
    ()
    >>> grown(joint, alike, (0.01, 0.02, 0.04, 0.08))[1][0].among
    'trials of small and of large amplitude'
    """
    estimates, found = dict(together), []
    for name, joint in together.items():
        counted = [i for i, one in enumerate(alone) if name in one and _counts(one[name])]
        if len(counted) < FEWEST or not joint.stderr > 0.0:
            continue
        values, noise = (np.array([getattr(alone[i][name], what) for i in counted]) for what in ("value", "stderr"))
        larger = [_of_trials(name, joint, values, noise)]
        if amplitudes and len(counted) >= FEWEST_IN_HALVES:
            order = np.argsort([amplitudes[i] for i in counted], kind="stable")
            larger.append(_of_halves(name, joint, values[order], noise[order]))
        apart = [one for one in larger if one is not None]
        if apart:
            estimates[name], why = max(apart, key=lambda one: one[0].stderr)
            found.append(why)
    return estimates, tuple(found)


def _of_trials(name: str, joint: Estimate, values: Array, noise: Array) -> tuple[Estimate, Grown] | None:
    """The joint estimate with the scatter of trials in its error, and how much they differ; None where they agree."""
    square, chance = differing(values, noise)
    if not chance < ALIKE:
        return None
    after = grown_whatever(joint, values, noise)
    return after, Grown(name, square, values.size - 1, chance, after.stderr / joint.stderr)


def _of_halves(name: str, joint: Estimate, values: Array, noise: Array) -> tuple[Estimate, Grown] | None:
    """The same for the two halves of trials that stand in the order of their amplitude."""
    half = values.size // 2
    means = [weighted_mean(values[part], noise[part], 0.0) for part in (slice(half), slice(values.size - half, None))]
    two, errors = (np.array(column) for column in zip(*means, strict=True))
    square, chance = differing(two, errors)
    if not chance < ALIKE:
        return None
    share = _share_of_squares(errors)
    after = with_scatter(joint, math.sqrt(share) * scatter_to_agree(two, errors))
    return after, Grown(name, square, 1, chance, after.stderr / joint.stderr, HALVES)


def differing(values: Array, noise: Array) -> tuple[float, float]:
    """Chi-squared of values (n,) with ``noise`` (n,) about their weighted mean, and how probable it is by chance."""
    weights = noise**-2.0
    square = float(weights @ (values - float(weights @ values / np.sum(weights))) ** 2)
    return square, float(chi2.sf(square, values.size - 1))


def scatter_to_agree(values: Array, noise: Array) -> float:
    """The standard deviation beyond ``noise`` (n,) with which chi-squared of values (n,) is its degrees of freedom.

    Unit of the values; 0 where they agree without.

    >>> round(scatter_to_agree(np.array([9.0, 11.0]), np.array([0.6, 0.8])) ** 2, 6)  # 2^2 = 0.6^2 + 0.8^2 + 2 s^2
    1.5
    """
    aim = values.size - 1

    def beyond(between: float) -> float:
        return differing(values, np.hypot(noise, between))[0] - aim

    if not beyond(0.0) > 0.0:
        return 0.0
    return float(brentq(beyond, 0.0, float(np.ptp(values)) * math.sqrt(values.size)))


def with_scatter(estimate: Estimate, between: float) -> Estimate:
    """An estimate whose standard error holds a scatter too (same unit), and says so; itself where there is none."""
    if not between > 0.0:
        return estimate
    source = estimate.source if estimate.source.endswith(DIFFER) else f"{estimate.source}; {DIFFER}".removeprefix("; ")
    return replace(estimate, stderr=math.hypot(estimate.stderr, between), source=source)


def grown_whatever(joint: Estimate, values: Array, noise: Array) -> Estimate:
    """A joint estimate with the scatter of single trials' values (n,) beyond their ``noise`` (n,) in its error.

    The joint value weighs trials by their noise; the scatter is summed over (`scatter_between`).
    """
    between, share = scatter_between([(values, noise)]), _share_of_squares(noise)
    spreads = np.sqrt(joint.stderr**2 + share * between.values**2)
    error = as_stderr(mixture_half_width(0.0, np.zeros(spreads.size), spreads, between.weights))
    return replace(joint, stderr=error, source=f"{joint.source}; {DIFFER}".removeprefix("; "))


def _share_of_squares(noise: Array) -> float:
    """What the variance of single values (n,) makes of that of their mean, each weighed by its ``noise``."""
    weights = (np.min(noise) / noise) ** 2
    return float(weights @ weights / np.sum(weights) ** 2)


def _counts(estimate: Estimate) -> bool:
    return estimate.outcome == OK and math.isfinite(estimate.value) and 0.0 < estimate.stderr < math.inf


OF_ONE_TRIAL = "one trial: every interval is of this trial, how much another would differ is not in it"
"""What is to be known of errors that no repetition stands behind."""


def of_one_trial(scatter: Mapping[str, float]) -> str:
    """The same where how much trials differ, relative and by symbol, is known from elsewhere.

    >>> of_one_trial({"k": 0.005, "mu": 0.1})
    'one trial: intervals hold that another would differ by 0.5 % in k, 10 % in mu'
    """
    parts = ", ".join(f"{100.0 * share:.2g} % in {symbol}" for symbol, share in scatter.items())
    return f"one trial: intervals hold that another would differ by {parts}" if parts else OF_ONE_TRIAL
