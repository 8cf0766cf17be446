"""Trials that differ by more than their errors: the error of what they give together grows until they agree.

A joint fit takes its unknowns to be the same in every trial. Where each trial fitted alone says something else, by more
than its noise, the joint value is a mean over trials that differ, and its error that of such a mean: random effects
(DerSimonian and Laird 1986, doi:10.1016/0197-2456(86)90046-2), with the scatter between trials summed over.

Belongs here: that test and the grown error. Does not belong here: means of single fits (repeats.py), quantities whose
scatter a fit already holds (hierarchy.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from undertow.quantities import OK, Estimate
from undertow.recording.recording import Array
from undertow.uncertainty.confidence import as_stderr, mixture_half_width
from undertow.uncertainty.repeats import scatter_between

ALIKE = 0.32
"""Trials at least as different as these must be this probable by chance, or errors grow: one standard deviation. A test
at 0.05 misses scatter as large as the errors: 90 % intervals then hold 77 to 83 %. Growing always makes them hold 99 to
100 % where trials are alike. With this 84 to 93 % in every row (experiments/coverage/between.md)."""

DIFFER = "trials differ"
"""How the source of an estimate ends whose error has grown."""

FEWEST = 2
"""Trials that can differ."""


@dataclass(frozen=True)
class Grown:
    """One parameter in several trials, each fitted alone: chi-squared of their values about the mean at ``freedom``
    degrees of freedom, how probable that is by chance, and how many times the joint standard error has grown."""

    parameter: str
    chi_squared: float
    freedom: int
    p_value: float
    grown: float


def grown(
    together: Mapping[str, Estimate], alone: Sequence[Mapping[str, Estimate]]
) -> tuple[dict[str, Estimate], tuple[Grown, ...]]:
    """Estimates of a joint fit with errors that hold how much its trials differ, and in what they do.

    ``alone`` is what each trial gives by itself, by the same names; what sits on a bound, has no error, or is held the
    same in all of them does not count. The systematic part is common to all trials and stays as it is.

    >>> joint = {"mass_kg": Estimate(10.0, 0.5, unit="kg")}
    >>> errors, found = grown(joint, [{"mass_kg": Estimate(v, 1.0, unit="kg")} for v in (4.0, 10.0, 10.0, 16.0)])
    >>> round(errors["mass_kg"].stderr, 1), found[0].parameter, round(found[0].chi_squared)
    (3.5, 'mass_kg', 72)
    >>> grown(joint, [{"mass_kg": Estimate(v, 1.0, unit="kg")} for v in (9.5, 10.0, 10.0, 10.5)])[1]
    ()
    """
    estimates, found = dict(together), []
    for name, joint in together.items():
        own = [one[name] for one in alone if name in one and _counts(one[name])]
        if len(own) < FEWEST or not joint.stderr > 0.0:
            continue
        values, noise = np.array([e.value for e in own]), np.array([e.stderr for e in own])
        weights = noise**-2.0
        mean = float(weights @ values / np.sum(weights))
        square, freedom = float(weights @ (values - mean) ** 2), len(own) - 1
        p_value = float(chi2.sf(square, freedom))
        if not p_value < ALIKE:
            continue
        estimates[name] = grown_whatever(joint, values, noise)
        found.append(Grown(name, square, freedom, p_value, estimates[name].stderr / joint.stderr))
    return estimates, tuple(found)


def grown_whatever(joint: Estimate, values: Array, noise: Array) -> Estimate:
    """A joint estimate with the scatter of single trials' values (n,) beyond their ``noise`` (n,) in its error.

    The joint value weighs trials by their noise; the scatter is summed over (`scatter_between`).
    """
    between, weights = scatter_between([(values, noise)]), noise**-2.0
    share = float(weights @ weights / np.sum(weights) ** 2)
    spreads = np.sqrt(joint.stderr**2 + share * between.values**2)
    error = as_stderr(mixture_half_width(0.0, np.zeros(spreads.size), spreads, between.weights))
    return replace(joint, stderr=error, source=f"{joint.source}; {DIFFER}".removeprefix("; "))


def _counts(estimate: Estimate) -> bool:
    return estimate.outcome == OK and math.isfinite(estimate.value) and 0.0 < estimate.stderr < math.inf


def grown_words(found: Sequence[Grown]) -> tuple[str, ...]:
    """What has grown and why, in one sentence; nothing where trials agree.

    >>> grown_words([Grown("added_mass_kg", 43.2, 3, 1e-9, 3.08)])[0].partition(":")[0]
    'trials fitted alone differ by more than their errors in added_mass_kg'
    """
    if not found:
        return ()
    names = ", ".join(one.parameter for one in found)
    sizes = "; ".join(
        f"{one.parameter} {one.grown:.2g} times, chi-squared {one.chi_squared:.3g} at {one.freedom}" for one in found
    )
    return (
        f"trials fitted alone differ by more than their errors in {names}: the standard errors printed for all trials "
        f"together have grown until they agree ({sizes} degrees of freedom)",
    )


OF_ONE_TRIAL = "one trial: every interval is of this trial, how much another would differ is not in it"
"""What is to be known of errors that no repetition stands behind."""
