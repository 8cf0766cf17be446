"""The structure from its dry trials: k, c, mu with their scatter from trial to trial.

Belongs here: output error on dry trials, trial by trial, and what their spread says. Does not belong here: the
report's envelope fit (decay.py), water.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.identification.baseline import STRUCTURAL, GroupFit, fit_group, group_model
from undertow.identification.fit import Specimen, Structure
from undertow.identification.intervals import mean_of_trials
from undertow.identification.problem import TrialOptions
from undertow.quantities import Estimate

DEFAULT_SCATTER: Mapping[str, float] = {"k": 0.004, "c": 0.20, "mu": 0.10}
"""Relative scatter assumed where neither dry trials nor the config show any: what 7 and 12 repeated dry trials of one
rig gave (report Tables 1 and 2: k 0.4 and 0.4 %, c 25 and 20 %, mu 6 and 11 %)."""

_NAMES = {"k": "k_N_per_m", "c": "c_Ns_per_m", "mu": "mu"}
_UNITS = {"k": "N/m", "c": "N s/m", "mu": "1"}


def dry_fits(
    motions: Sequence[Motion], terms: Sequence[Term], specimen: Specimen, options: TrialOptions
) -> dict[str, GroupFit]:
    """Each dry trial fitted alone: trial name -> its k, c, mu (kilograms from the known mass)."""
    fits = {}
    for motion in motions:
        model = group_model(terms, [motion], specimen, None, dry=True, anchored=True)
        fits[motion.name] = fit_group(model, [motion], options)
    return fits


@dataclass(frozen=True)
class Scatter:
    """Relative standard deviation from trial to trial of k, c, mu (``values``), and the degrees of freedom it was seen
    with (inf: stated; 0: assumed)."""

    values: Mapping[str, float]
    freedom: float


def pooled_scatter(springs: Sequence[Mapping[str, GroupFit]]) -> Scatter:
    """Scatter of k, c and mu about their means, pooled over springs: the same rails and the same hands.

    Noise of the single estimates is taken out. Without two dry trials of one spring `DEFAULT_SCATTER` is assumed.
    """
    freedom = sum(max(len(fits) - 1, 0) for fits in springs)
    if freedom == 0:
        return Scatter(DEFAULT_SCATTER, 0.0)
    values = {}
    for symbol in _NAMES:
        total = 0.0
        for fits in springs:
            found = _values(fits, symbol)
            if len(found) < 2:
                continue
            numbers = np.array([e.value for e in found])
            noise = np.array([e.stderr if math.isfinite(e.stderr) else 0.0 for e in found])
            between = max(float(np.var(numbers, ddof=1)) - float(np.mean(noise**2)), 0.0)
            total += (len(found) - 1) * between / float(np.mean(numbers)) ** 2
        values[symbol] = math.sqrt(total / freedom)
    return Scatter(values, float(freedom))


def structure_from(fits: Mapping[str, GroupFit], scatter: Scatter) -> Structure:
    """Means of k, c, mu over one spring's dry trials with standard errors of the means, and the scatter.

    IdentificationError where no dry trial was fitted.
    """
    if not fits:
        raise IdentificationError(f"structure: {len(fits)} dry trials were fitted; give k, c, mu in the config")
    means = {symbol: _mean(fits, symbol, scatter.values[symbol]) for symbol in _NAMES}
    source = f"output error on {len(fits)} dry trials"
    if scatter.freedom == 0.0:
        source += "; scatter assumed, not seen"
    return Structure(means["k"], means["c"], means["mu"], scatter.values, source, scatter.freedom)


def _values(fits: Mapping[str, GroupFit], symbol: str) -> list[Estimate]:
    name = _NAMES[symbol]
    return [f.estimates[name] for f in fits.values() if name in f.estimates]


def _mean(fits: Mapping[str, GroupFit], symbol: str, scatter: float) -> Estimate:
    found = _values(fits, symbol)
    if not found:
        return Estimate(0.0, 0.0, unit=_UNITS[symbol], source="not in the equation")
    mean = mean_of_trials(found, _UNITS[symbol], "dry trials")
    floor = scatter * abs(mean.value) / math.sqrt(len(found))
    stderr = max(mean.stderr, floor) if math.isfinite(mean.stderr) else floor
    return Estimate(mean.value, stderr, unit=_UNITS[symbol], source=f"mean of {len(found)} dry trials")


def structural_terms(terms: Sequence[Term]) -> tuple[Term, ...]:
    """Those of an equation's terms that a dry trial has: everything but water."""
    return tuple(t for t in terms if t.name in STRUCTURAL or t.name.endswith(("stiffness", "friction")))
