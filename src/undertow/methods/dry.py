"""The structure from its dry trials: k, c, mu with their scatter from trial to trial.

Belongs here: output error on dry trials, trial by trial, and what their spread says. Does not belong here: the
report's envelope fit (decay.py), water.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import chi2

from undertow.conditioning.motion import Motion
from undertow.equation.kernel import SLOT
from undertow.equation.term import Term
from undertow.errors import FAILURES, IdentificationError
from undertow.likelihood.fit import Specimen, Structure
from undertow.likelihood.group import Coefficient
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import GroupFit, fit_group, group_model
from undertow.quantities import Estimate
from undertow.recording.recording import Array
from undertow.uncertainty.confidence import widening
from undertow.uncertainty.hierarchy import ASSUMED_FREEDOM
from undertow.uncertainty.repeats import noise_of, scatter_between, scatter_of_two, weighted_mean

DEFAULT_SCATTER: Mapping[str, float] = {"k": 0.004, "c": 0.20, "mu": 0.10}
"""Relative scatter assumed where neither dry trials nor the config show any: what 7 and 12 repeated dry trials of one
rig gave (report Tables 1 and 2: k 0.4 and 0.4 %, c 25 and 20 %, mu 6 and 11 %)."""

RIGS_WITHIN = 2.0
"""Rigs differ in how much their trials scatter by this factor, to either side (a standard deviation of its logarithm):
all that is known where a scatter was assumed."""

PUBLISHED = 1.0
"""Degrees of freedom that know a scatter as well as that."""

TREND_CHANCE = 0.01
"""A trend of k, c or mu with amplitude that chance would show less often than this is no scatter."""

SCATTER_WITHIN = 9.0
"""How far, as a logarithm, a scatter is looked for around the usual one."""

UNEVEN = 3.0
"""A dry trial that is damped so many times more or less than the others is not one of them: trials of one rig differ by
a quarter."""

_NAMES = {"k": "k_N_per_m", "c": "c_Ns_per_m", "mu": "mu"}
_UNITS = {"k": "N/m", "c": "N s/m", "mu": "1"}


def dry_fits(
    motions: Sequence[Motion],
    terms: Sequence[Term],
    specimen: Specimen,
    options: TrialOptions,
    known: Mapping[str, float] | None = None,
    moved: Mapping[str, str] | None = None,
    about: Structure | None = None,
) -> dict[str, GroupFit]:
    """Each dry trial fitted alone: trial name -> its k, c, mu (kilograms from the known mass).

    ``known`` are slots of the integrator whose value stands (what the dry trials were found to need beside k, c, mu),
    ``moved`` slots whose coefficient stands in another (friction as the force at which bristles yield);
    ``about`` gives the search's start (None: from each trial itself).
    A trial that cannot be fitted has no place in it; the others' mean does without.
    """
    fits = {}
    specimen = replace(specimen, rotation=False)  # mu is what a structure holds: of a rotation moment over mass times g
    for motion in motions:
        try:
            model = group_model(terms, [motion], specimen, None, dry=True, anchored=True)
            base = model.base.copy()
            for slot, value in (known or {}).items():
                base[SLOT[slot]] += value
            placed = tuple(_placed(c, moved or {}, about) for c in model.coefficients)
            fit = fit_group(replace(model, base=base, coefficients=placed), [motion], options)
        except FAILURES:
            continue  # its own analysis says why and lists it as failed
        if not _feeds(fit):
            fits[motion.name] = fit
    return fits


def _placed(c: Coefficient, moved: Mapping[str, str], about: Structure | None) -> Coefficient:
    """A coefficient in its slot, starting from a structure's value where there is one."""
    known = {} if about is None else {_NAMES[symbol]: getattr(about, symbol).value for symbol in _NAMES}
    start = known.get(c.name, math.nan)
    return replace(c, slot=moved.get(c.slot, c.slot), start=start if math.isfinite(start) else c.start)


def _feeds(fit: GroupFit) -> bool:
    """Whether a fit's damping would feed energy into the motion: a search that went astray, no structure."""
    c = fit.estimates.get(_NAMES["c"])
    return c is not None and c.value < 0.0 and abs(c.value) > 3.0 * c.total_stderr


@dataclass(frozen=True)
class Scatter:
    """Relative standard deviation from trial to trial of k, c, mu (``values``), and the degrees of freedom it was seen
    with (inf: stated; 0: assumed)."""

    values: Mapping[str, float]
    freedom: float


def pooled_scatter(springs: Sequence[Mapping[str, GroupFit]]) -> Scatter:
    """Scatter of k, c and mu about their means, pooled over springs: the same rails and the same hands.

    Noise of the single estimates is taken out. Given is the scatter of which chi-squared at ``freedom`` has the same
    median as the scatter's posterior (without noise: the usual standard deviation). Without two dry trials of one
    spring `DEFAULT_SCATTER` is assumed.
    """
    freedom = sum(max(len(fits) - 1, 0) for fits in springs)
    if freedom == 0:
        return Scatter(DEFAULT_SCATTER, 0.0)
    groups = {
        symbol: without_trend(
            [(_amplitudes(fits), *_relative(fits, symbol)) for fits in springs if len(_values(fits, symbol)) > 1],
            DEFAULT_SCATTER[symbol],
        )
        for symbol in _NAMES
    }
    medians = {symbol: scatter_between(own).median if own else 0.0 for symbol, own in groups.items()}
    alike = [np.array([_correlation(f) for f in fits.values()]) for fits in springs if len(fits) > 1]
    if all([v.size for v, _ in groups[s]] == [one.size for one in alike] for s in ("c", "mu")):
        both = [
            (np.column_stack([c, mu]), np.column_stack([of_c, of_mu]), one)
            for (c, of_c), (mu, of_mu), one in zip(groups["c"], groups["mu"], alike, strict=True)
        ]
        medians["c"], medians["mu"] = (one.median for one in scatter_of_two(both))
    share = math.sqrt(float(chi2.ppf(0.5, freedom)) / freedom)
    return Scatter({symbol: share * middle for symbol, middle in medians.items()}, float(freedom))


def believed(scatter: Mapping[str, float], freedom: float, symbol: str) -> float:
    """Relative scatter of k, c or mu from trial to trial: a few trials can look more alike than the rig is, so that
    they count beside published rigs, which differ by `RIGS_WITHIN`. The most probable logarithm (chi-squared of what
    was seen, normal of what rigs have), no less than what was seen; as stated where ``freedom`` is inf.

    >>> round(believed({"k": 0.001}, 2.0, "k"), 4), believed({"k": 0.001}, math.inf, "k")
    (0.002, 0.001)
    """
    seen, usual = scatter.get(symbol, 0.0), DEFAULT_SCATTER[symbol]
    if not math.isfinite(freedom) or seen >= usual:
        return seen
    ratio, within = math.log(max(seen / usual, sys.float_info.min)), math.log(RIGS_WITHIN) ** 2

    def slope(log: float) -> float:
        return freedom * (1.0 - math.exp(2.0 * (ratio - log))) + log / within

    lowest = max(ratio, -freedom * within)  # without anything seen
    return max(seen, usual * math.exp(float(brentq(slope, lowest - 1e-9, 1e-9))))


def _amplitudes(fits: Mapping[str, GroupFit]) -> Array:
    """Logarithm of each trial's release, (n,)."""
    return np.log([max(abs(f.solution.value(f"x0_m[{name}]")), np.finfo(float).tiny) for name, f in fits.items()])


def without_trend(
    groups: Sequence[tuple[Array, Array, Array]], usual: float
) -> list[tuple[Array, Array]]:
    """(values, noise) of groups (log amplitude, values, noise), each (n,): less their line over log amplitude where
    that line is there beyond doubt (likelihood ratio over all groups, one chance in a hundred).

    What goes with amplitude in every spring is no scatter: a law is missing, and repetitions do not differ by it. Rigs
    scatter by ``usual``, within `RIGS_WITHIN`: three trials that lie on a line by chance are no trend where they differ
    by what rigs do. What is left is widened by the freedom that the lines took.
    """
    sloped = [values.size > 2 and float(np.ptp(amplitude)) > 0.0 for amplitude, values, _ in groups]
    trials, lines = sum(values.size for _, values, _ in groups), sum(sloped)
    left = trials - len(groups) - lines

    def fitted(log: float, slopes: Sequence[bool]) -> tuple[float, list[Array]]:
        """-2 log likelihood at a scatter, with what every group's line is."""
        total, found = ((log - math.log(usual)) / math.log(RIGS_WITHIN)) ** 2, []
        for (amplitude, values, noise), slope in zip(groups, slopes, strict=True):
            weight = 1.0 / np.hypot(noise, math.exp(log))
            columns = np.column_stack([np.ones(values.size), amplitude][: 1 + slope])
            line = columns @ np.linalg.lstsq(columns * weight[:, None], values * weight, rcond=None)[0]
            total += float(np.sum(((values - line) * weight) ** 2) - 2.0 * left / trials * np.sum(np.log(weight)))
            found.append(line)
        return total, found

    if lines and left > 0:
        around = (math.log(usual) - SCATTER_WITHIN, math.log(usual) + SCATTER_WITHIN)
        flat, line = (
            minimize_scalar(lambda log, own=own: fitted(log, own)[0], bounds=around, method="bounded")
            for own in ([False] * len(groups), sloped)
        )
        if chi2.sf(flat.fun - line.fun, lines) <= TREND_CHANCE:
            on = fitted(float(line.x), sloped)[1]
            return [
                (float(np.mean(v)) + (v - own) * math.sqrt((v.size - 1) / (v.size - 1 - slope)), noise)
                for (_, v, noise), own, slope in zip(groups, on, sloped, strict=True)
            ]
    return [(values, noise) for _, values, noise in groups]


def _relative(fits: Mapping[str, GroupFit], symbol: str) -> tuple[Array, Array]:
    """Values of one spring's trials and their noise, both over the mean: (n,), (n,)."""
    found = _values(fits, symbol)
    numbers, noise = np.array([e.value for e in found]), noise_of(found)
    size = abs(float(np.mean(numbers)))
    return numbers / size, noise / size


def uneven(fits: Mapping[str, GroupFit]) -> str:
    """Which of three or more dry trials is damped by `UNEVEN` times more or less than the others, in words; else empty.

    Damping is that of all laws together at one amplitude, half the mean release (friction by its equivalent dashpot),
    since a fit may take one for the other.
    """
    if len(fits) < 3:
        return ""
    half = 0.5 * math.exp(float(np.mean(_amplitudes(fits))))
    damping = {name: _equivalent(fit, half) for name, fit in fits.items()}
    for name, own in damping.items():
        others = float(np.median([value for other, value in damping.items() if other != name]))
        ratio = own / others if others > 0.0 and own > 0.0 else 1.0
        if not 1.0 / UNEVEN < ratio < UNEVEN:
            return (
                f"the dry trials are uneven: {name} is damped {ratio:.2g} times as much as the other {len(fits) - 1}, "
                "and their scatter says nothing of the rig"
            )
    return ""


def _equivalent(fit: GroupFit, amplitude_m: float) -> float:
    """Dashpot that takes as much energy a cycle as damping and friction together, over the mass, 1/s."""
    theta = fit.model.theta(fit.values)
    k, c, force, mass = (float(theta[SLOT[slot]]) for slot in ("k1", "c1", "fc", "mass"))
    if not (k > 0.0 and mass > 0.0):
        return math.nan
    return (c + 4.0 * force / (math.pi * math.sqrt(k / mass) * amplitude_m)) / mass


def structure_from(fits: Mapping[str, GroupFit], scatter: Scatter) -> Structure:
    """Means of k, c, mu over one spring's dry trials with standard errors of the means, and the scatter.

    IdentificationError where no dry trial was fitted.
    """
    if not fits:
        raise IdentificationError(f"structure: {len(fits)} dry trials were fitted; give k, c, mu in the config")
    means = {symbol: _mean(fits, symbol, scatter) for symbol in _NAMES}
    source = f"output error on {len(fits)} dry trials"
    if scatter.freedom == 0.0:
        source += "; scatter assumed, not seen"
    errors = {symbol: _error_if_believed(fits, symbol, scatter) for symbol in _NAMES}
    together = _c_with_mu(fits, scatter)
    return Structure(means["k"], means["c"], means["mu"], scatter.values, source, scatter.freedom, errors, together)


def _values(fits: Mapping[str, GroupFit], symbol: str) -> list[Estimate]:
    name = _NAMES[symbol]
    return [f.estimates[name] for f in fits.values() if name in f.estimates]


def _mean(fits: Mapping[str, GroupFit], symbol: str, scatter: Scatter) -> Estimate:
    """Mean over one spring's dry trials with the scatter pooled over springs, and as wide as its freedom asks."""
    found = [e for e in _values(fits, symbol) if math.isfinite(e.value)]
    if not found:
        return Estimate(0.0, 0.0, unit=_UNITS[symbol], source="not in the equation")
    numbers = np.array([e.value for e in found])
    between = scatter.values[symbol] * abs(float(np.mean(numbers)))
    mean, error = weighted_mean(numbers, noise_of(found), between)
    freedom = scatter.freedom if scatter.freedom > 0.0 else ASSUMED_FREEDOM
    said = f"mean of {len(found)} dry trials"
    return Estimate(mean, error * widening(freedom), unit=_UNITS[symbol], source=said, freedom=freedom)


def _variances(fits: Mapping[str, GroupFit], symbol: str, scatter: Scatter) -> Array:
    """How far each trial's value is from the mean of all such trials, by noise and the believed scatter, (n,)."""
    found = [e for e in _values(fits, symbol) if math.isfinite(e.value)]
    between = believed(scatter.values, scatter.freedom, symbol) * abs(float(np.mean([e.value for e in found] or [0.0])))
    return np.asarray(noise_of(found) ** 2 + between**2, dtype=np.float64)


def _error_if_believed(fits: Mapping[str, GroupFit], symbol: str, scatter: Scatter) -> float:
    """Standard error of a mean over dry trials if they scatter as is believed; 0 where no fit has the number."""
    variances = _variances(fits, symbol, scatter)
    return 1.0 / math.sqrt(float(np.sum(1.0 / variances))) if variances.size and np.all(variances > 0.0) else 0.0


def _c_with_mu(fits: Mapping[str, GroupFit], scatter: Scatter) -> float:
    """Correlation of the errors of c's and mu's means: noise moves both of a trial, scatter each by itself."""
    c, mu = (_variances(fits, symbol, scatter) for symbol in ("c", "mu"))
    if not len(fits) == c.size == mu.size or not (np.all(c > 0.0) and np.all(mu > 0.0)):
        return 0.0
    of_c, of_mu = (noise_of(_values(fits, symbol)) for symbol in ("c", "mu"))
    common = float(np.sum(of_c * of_mu * [_correlation(f) for f in fits.values()] / (c * mu)))
    return common / math.sqrt(float(np.sum(1.0 / c) * np.sum(1.0 / mu)))


def _correlation(fit: GroupFit) -> float:
    """Correlation of the errors of c and mu in one trial's fit; 0 where it has not both."""
    names = [c.name for c in fit.model.coefficients]
    if not {_NAMES["c"], _NAMES["mu"]} <= set(names):
        return 0.0
    at = [names.index(_NAMES["c"]), names.index(_NAMES["mu"])]
    own = fit.solution.covariance[np.ix_(at, at)]
    size = math.sqrt(float(own[0, 0] * own[1, 1]))
    return float(own[0, 1]) / size if size > 0.0 else 0.0


def structural_terms(terms: Sequence[Term]) -> tuple[Term, ...]:
    """Those of an equation's terms that a dry trial has: everything but water."""
    return tuple(t for t in terms if t.structural or t.name.endswith(("stiffness", "friction")))
