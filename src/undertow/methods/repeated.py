"""Scatter from trial to trial as repetitions of one release show it, where no dry trials do.

A ladder of amplitudes is no repetition: a law that is missing makes k, c, mu go with amplitude, and would pass for
scatter.

Belongs here: which trials repeat each other, and what their single fits say. Does not belong here: dry trials (dry.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.likelihood.fit import Fit
from undertow.methods.dry import Scatter
from undertow.quantities import Estimate
from undertow.uncertainty.repeats import noise_of, scatter_between

FEWEST = 3
"""So many trials show how much trials differ: two say it within a factor of six only (chi-squared, 90 %)."""

WITHIN = 1.1
"""Largest over smallest release of trials that repeat each other."""

NAMES: Mapping[str, tuple[str, ...]] = {
    "k": ("k_N_per_m", "total_mass_kg", "k_N_per_m_per_mass"),
    "c": ("c_Ns_per_m", "c_Ns_per_m_per_mass"),
    "mu": ("mu", "friction_N", "friction_N_per_mass"),
}
"""What a single fit calls stiffness (or the mass that goes with it), damping and friction."""


def repetitions(motions: Sequence[Motion]) -> tuple[Motion, ...]:
    """The largest number of trials whose releases are within a tenth of each other; empty with fewer than `FEWEST`."""
    ordered = sorted(motions, key=lambda m: m.amplitude)
    best: list[Motion] = []
    for first, motion in enumerate(ordered):
        near = [m for m in ordered[first:] if m.amplitude <= WITHIN * motion.amplitude]
        best = near if len(near) > len(best) else best
    return tuple(best) if len(best) >= FEWEST else ()


def scatter_of_repetitions(motions: Sequence[Motion], singles: Mapping[str, Fit]) -> Scatter | None:
    """Relative scatter of k, c, mu among repetitions, from fits to each trial alone (trial name -> Fit); None where no
    release was repeated often enough, or too few could be fitted."""
    fits = [singles[m.name] for m in repetitions(motions) if m.name in singles and singles[m.name].parameters]
    if len(fits) < FEWEST:
        return None
    values = {symbol: _relative(fits, names) for symbol, names in NAMES.items()}
    return Scatter(values, len(fits) - 1.0)


def _relative(fits: Sequence[Fit], names: Sequence[str]) -> float:
    """Scatter of one quantity over its mean; 0 where no fit has it or its errors explain all."""
    for name in names:
        found = [f.parameters[name] for f in fits if name in f.parameters]
        good = [e for e in found if math.isfinite(e.value) and e.stderr > 0.0]
        if len(good) >= FEWEST and not _held(good):
            numbers, noise = np.array([e.value for e in good]), noise_of(good)
            size = abs(float(np.mean(numbers)))
            return scatter_between([(numbers / size, noise / size)]).median if size > 0.0 else 0.0
    return 0.0


def _held(estimates: Sequence[Estimate]) -> bool:
    """Whether a number was held fixed in every trial: it says nothing of scatter."""
    return len({e.value for e in estimates}) == 1
