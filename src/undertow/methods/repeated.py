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
from undertow.methods.dry import DEFAULT_SCATTER, Scatter, believed
from undertow.uncertainty.repeats import noise_of, scatter_between

FEWEST = 3
"""So many trials show how much trials differ: two say it within a factor of six only (chi-squared, 90 %)."""

WITHIN = 1.1
"""Largest over smallest release of trials that repeat each other."""

RIGS = 4.0
"""Rigs' scatter is within this factor of what is usual, for all that repetitions take for granted: so wide that three
trials that tell decide, and trials whose noise is many times any rig's scatter leave what is usual."""

NAMES: Mapping[str, tuple[str, ...]] = {
    "k": ("k_N_per_m", "total_mass_kg", "k_N_per_m_per_mass"),
    "c": ("c_Ns_per_m", "c_Ns_per_m_per_mass"),
    "mu": ("mu", "friction_N", "friction_N_per_mass"),
}
"""What a single fit calls stiffness (or the mass that goes with it), damping and friction."""


def repetitions(motions: Sequence[Motion]) -> tuple[tuple[Motion, ...], ...]:
    """Sets of two trials or more whose releases are within a tenth of each other, the largest set first; no trial is in
    two of them."""
    left, out = sorted(motions, key=lambda m: m.amplitude), list[tuple[Motion, ...]]()
    while True:
        ends = [sum(m.amplitude <= WITHIN * first.amplitude for m in left) for first in left]
        size, at = max(((end - at, -at) for at, end in enumerate(ends)), default=(0, 0))
        if size < 2:
            return tuple(out)
        out.append(tuple(left[-at : size - at]))
        del left[-at : size - at]


def scatter_of_repetitions(sets: Sequence[Sequence[Fit]], known: float = 0.0) -> Scatter | None:
    """Relative scatter of k, c, mu that sets of repetitions have in common, from a fit of each trial alone.

    A number that no fit could find (it was held) has no place in it. None where there are no sets, or fewer than
    `FEWEST` - 1 degrees of freedom with those that are ``known`` otherwise: a set has one less than it has trials.
    """
    sets = [fits for fits in sets if len(fits) > 1]
    freedom = sum(len(fits) - 1 for fits in sets)
    if not sets or freedom + known < FEWEST - 1:
        return None
    seen = {symbol: _relative(sets, names, DEFAULT_SCATTER[symbol]) for symbol, names in NAMES.items()}
    return Scatter({symbol: value for symbol, value in seen.items() if value is not None}, float(freedom))


def pooled(one: Scatter, other: Scatter) -> Scatter:
    """Two sights of one scatter, each counted by its degrees of freedom; what the second did not see is `believed` as
    by the first alone, for the freedom that is said of all holds it too.

    >>> from undertow.methods.dry import Scatter
    >>> both = pooled(Scatter({"k": 0.01, "c": 0.1}, 1.0), Scatter({"k": 0.02}, 3.0))
    >>> round(both.values["k"], 4), round(both.values["c"], 4), both.freedom
    (0.018, 0.1522, 4.0)
    """
    freedom = one.freedom + other.freedom
    values = {symbol: believed(one.values, one.freedom, symbol) for symbol in one.values}
    for symbol, value in other.values.items():
        square = one.freedom * one.values.get(symbol, 0.0) ** 2 + other.freedom * value**2
        values[symbol] = math.sqrt(square / freedom)
    return Scatter(values, freedom)


def _relative(sets: Sequence[Sequence[Fit]], names: Sequence[str], usual: float) -> float | None:
    """Scatter of one quantity over its means, believed beside what is ``usual``; 0 where no equation has it, None where
    it was held."""
    held = False
    for name in names:
        groups = []
        for fits in sets:
            found = [f.parameters[name] for f in fits if name in f.parameters]
            good = [e for e in found if math.isfinite(e.value) and e.stderr > 0.0]
            fixed = bool(found) and len({e.value for e in found}) == 1
            held = held or fixed
            size = abs(float(np.mean([e.value for e in good]))) if good else 0.0
            if len(good) > 1 and not fixed and size > 0.0:
                groups.append((np.array([e.value for e in good]) / size, noise_of(good) / size))
        if groups:
            return scatter_between(groups, (usual, RIGS)).median
    return None if held else 0.0
