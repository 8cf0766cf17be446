"""The physics that may stand behind a table: each rival's effects, what is unknown in it, and how far it may go.

Every rival shares the nuisances: errors of k, c, mu of each spring, the submerged volume, and for Method 2 the side of
friction's jump on which the acceleration was read. A prior is a range (even) or a normal with its standard deviation;
its scale comes from the laboratory's own numbers, never from the printed coefficients.

Belongs here: rivals and priors. Does not belong here: their consequences (case.py), their weights (posterior.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from undertow.audit.case import PrintedCase
from undertow.audit.effects import (
    DAMPING,
    FRICTION,
    FRICTION_FORCE,
    LINEAR,
    RESONATOR,
    RESONATOR_DAMPING_RATIO,
    RESONATOR_FREQUENCY,
)
from undertow.audit.recipes import Array

ADDED_MASS_SHARE = 1.0
"""Largest added mass over the structure's: the water that a section of that size drags along is less."""

DRAG_AT_MOST = 60.0
"""Largest C_d tried: thirty times a flat plate's in a steady stream."""

DAMPING_RATIO_AT_MOST = 0.1
"""Linear damping of the water, over critical of the softest spring: beyond it a decay has no cycles to fit."""

FRICTION_ERROR_SHARE = 0.5
"""Standard deviation of a mis-set friction over the friction: half of it."""

OFFSET_SHARE = 0.02
"""Standard deviation of a displacement offset over the largest release."""

COMPLIANCE_SHARE = 0.05
"""Standard deviation of what compliance takes from the stiffest spring's k; it takes, it never adds."""

RESONATOR_MASS_SHARES = (0.02, 0.5)
"""Participating mass over the structure's, even in its logarithm."""

RESONATOR_FREQUENCY_SHARES = (0.6, 1.8)
"""Resonator's frequency over the slowest and the fastest dry spring's: above, it is added mass; below, nothing."""

RESONATOR_DAMPING = (0.005, 0.25)
"""Damping ratio, even in its logarithm."""

EXPLORED = (RESONATOR_FREQUENCY, RESONATOR_DAMPING_RATIO)
"""In these answers bend so much that no quadratic holds: they are explored point by point (exploring.py)."""

EXPONENTS = (1.2, 1.8)
"""Exponents of a drag whose C_d truly falls with amplitude, as a law of its own. 2 is quadratic drag, 1 linear damping,
0 friction: what lies within 0.2 of those is one of them in disguise, not a law."""

STIFFNESS_SHARE = 0.04
"""Standard deviation of a mis-stated stiffness over the printed one where no other dry number is at hand."""

STIFFNESS_FLOOR = 0.005
"""The same where another dry number agrees: that one is not known better."""


@dataclass(frozen=True)
class RivalUnknown:
    """One unknown: its coordinate is even between ``low`` and ``high``, or normal about ``mean`` with ``deviation``
    where that is given; the coordinate is the value itself, or its natural logarithm where ``logarithmic``."""

    name: str
    low: float
    high: float
    deviation: float = math.nan
    unit: str = "1"
    nuisance: bool = False
    mean: float = 0.0
    logarithmic: bool = False

    @property
    def normal(self) -> bool:
        """Whether the prior is a normal."""
        return math.isfinite(self.deviation)

    @property
    def bends(self) -> bool:
        """Whether answers may bend with it over its prior; a nuisance that is known within a normal is too narrow."""
        return not (self.nuisance and self.normal)

    @property
    def centre(self) -> float:
        """Where a search starts: the mean of a normal, the middle of a logarithm, the first quarter of a range."""
        share = 0.5 if self.logarithmic else 0.25
        return self.mean if self.normal else self.low + share * (self.high - self.low)

    @property
    def scale(self) -> float:
        """A step over which an answer changes noticeably."""
        return self.deviation if self.normal else 0.1 * (self.high - self.low)


@dataclass(frozen=True)
class Rival:
    """Physics behind a table: the effects' names (none: Eq. 15 with constant coefficients) and unknowns.

    Unknowns enter almost linearly. The one with which the answers bend most, ``split``, has its range cut into
    ``cells`` equal pieces, in each of which all are fitted anew.
    """

    effects: tuple[str, ...]
    unknowns: tuple[RivalUnknown, ...]
    split: str = ""
    cells: int = 1
    water: bool = True

    @property
    def label(self) -> str:
        """Name in words."""
        if not self.water:
            return "no water force"
        return " + ".join(self.effects) or "equation 15"

    def values(self, point: Array) -> dict[str, float]:
        """Physical values by name at a point (L,) of coordinates."""
        pairs = zip(self.unknowns, point.tolist(), strict=True)
        return {one.name: math.exp(x) if one.logarithmic else x for one, x in pairs}

    @property
    def edges(self) -> Array:
        """Edges (cells + 1,) of the pieces, as coordinates; empty where nothing is split."""
        found = [np.linspace(one.low, one.high, self.cells + 1) for one in self.unknowns if one.name == self.split]
        return np.asarray(found[0] if found else np.zeros(0))

    def within(self, cell: tuple[float, float] | None) -> Rival:
        """The rival with the split unknown confined to one piece of its range."""
        if cell is None:
            return self
        low, high = cell
        return replace(self, unknowns=tuple(
            replace(one, low=low, high=high) if one.name == self.split else one for one in self.unknowns
        ))  # fmt: skip

    def given(self, priors: Mapping[str, tuple[float, float]]) -> Rival:
        """The rival with the prior of some unknowns replaced by a normal (mean, deviation): "what if k were
        another". A stiffness that is given so is not mis-stated beyond `STIFFNESS_FLOOR`."""
        known = {f"gain_error.stiffness_{name[2:]}": (0.0, STIFFNESS_FLOOR) for name in priors if name.startswith("k.")}
        every = {**known, **priors}
        return replace(self, unknowns=tuple(
            replace(one, low=-math.inf, high=math.inf, mean=every[one.name][0], deviation=every[one.name][1])
            if one.name in every else one
            for one in self.unknowns
        ))  # fmt: skip


def nuisances(case: PrintedCase) -> tuple[RivalUnknown, ...]:
    """What no recipe knew exactly: k, c, mu of every spring, the submerged volume, the instant of Method 2."""
    found = []
    for name in case.springs:
        dry = case.structures[name]
        found.append(RivalUnknown(f"k.{name}", -1.0, 1.0, dry.k_error, "1", True))
        found.append(RivalUnknown(f"c.{name}", -math.inf, math.inf, dry.c_error, "N s/m", True))
        found.append(RivalUnknown(f"mu.{name}", -math.inf, math.inf, dry.mu_error, "1", True))
    low, high = case.volume_range_m3
    if high > low:
        found.append(RivalUnknown("volume_m3", low, high, unit="m^3", nuisance=True))
    if case.two_instants:
        found.append(RivalUnknown("turn_share", -1.0, 1.0, unit="1", nuisance=True))
    return tuple(found)


def rivals(case: PrintedCase, nodes: int = 24) -> tuple[Rival, ...]:
    """Every rival of a case; ``nodes`` pieces of a resonator's range of frequencies."""
    base = nuisances(case)
    masses = [f"added_mass_kg.{name}" for name in case.springs] if case.own_added_mass else ["added_mass_kg"]
    water = (
        *(RivalUnknown(name, 0.0, ADDED_MASS_SHARE * case.mass_kg, unit="kg") for name in masses),
        RivalUnknown("drag_coefficient", 0.0, DRAG_AT_MOST, unit="1"),
    )
    linear, friction, offset = (one(case) for one in (_linear, _friction, _offset))
    exponent = RivalUnknown("drag_exponent.exponent", *EXPONENTS)
    found = [
        Rival((), (*water, *base)),
        Rival((), base, water=False),
        Rival((LINEAR,), (*water, linear, *base)),
        Rival((FRICTION,), (*water, friction, *base)),
        Rival((LINEAR, FRICTION), (*water, linear, friction, *base)),
        Rival(("drag_exponent",), (*water, exponent, *base)),
        Rival((RESONATOR,), (*water, *_resonator(case), *base), RESONATOR_FREQUENCY, nodes),
    ]  # fmt: skip
    if case.two_instants:
        found.append(Rival(("rest_offset",), (*water, offset, *base)))
        found.append(Rival((LINEAR, "rest_offset"), (*water, linear, offset, *base)))
    if len(case.springs) > 1:
        found.append(Rival(("support_compliance",), (*water, _compliance(case), *base)))
        found.append(Rival(("gain_error",), (*water, _stiffness(case), *base)))
    return tuple(found)


def _linear(case: PrintedCase) -> RivalUnknown:
    softest = min(case.structures[name].k for name in case.springs)
    critical = 2.0 * math.sqrt(softest * case.mass_kg)
    return RivalUnknown(DAMPING, 0.0, DAMPING_RATIO_AT_MOST * critical, unit="N s/m")


def _friction(case: PrintedCase) -> RivalUnknown:
    force = max(case.structures[name].mu for name in case.springs) * case.mass_kg * case.gravity_m_per_s2
    return RivalUnknown(FRICTION_FORCE, -force, 3.0 * force, FRICTION_ERROR_SHARE * force, "N")


def _offset(case: PrintedCase) -> RivalUnknown:
    largest = max(row.release_m for row in case.rows)
    return RivalUnknown("rest_offset.offset_m", -largest, largest, OFFSET_SHARE * largest, "m")


def _compliance(case: PrintedCase) -> RivalUnknown:
    stiffest = max(case.structures[name].k for name in case.springs)
    deviation = COMPLIANCE_SHARE / stiffest
    return RivalUnknown("support_compliance.compliance_m_per_N", 0.0, 0.5 / stiffest, deviation, "m/N")


def _stiffness(case: PrintedCase) -> RivalUnknown:
    """True over printed stiffness, less one, of the spring whose dry numbers agree least (the stiffest where there are
    none): between the printed number and the other one, either wrong by as much, or beyond."""
    gaps = {name: case.structures[name].k_other / case.structures[name].k - 1.0 for name in case.springs}
    known = {name: gap for name, gap in gaps.items() if math.isfinite(gap)}
    if known:
        spring = max(known, key=lambda name: abs(known[name]))
        middle, deviation = 0.5 * known[spring], max(0.5 * abs(known[spring]), STIFFNESS_FLOOR)
    else:
        spring = max(case.springs, key=lambda name: case.structures[name].k)
        middle, deviation = 0.0, STIFFNESS_SHARE
    return RivalUnknown(f"gain_error.stiffness_{spring}", -0.5, 0.5, deviation, mean=middle)


def _resonator(case: PrintedCase) -> tuple[RivalUnknown, ...]:
    def even(name: str, low: float, high: float, unit: str) -> RivalUnknown:
        return RivalUnknown(f"{RESONATOR}.{name}", math.log(low), math.log(high), unit=unit, logarithmic=True)

    light, heavy = (case.mass_kg * share for share in RESONATOR_MASS_SHARES)
    slow = RESONATOR_FREQUENCY_SHARES[0] * min(case.frequencies)
    fast = RESONATOR_FREQUENCY_SHARES[1] * max(case.frequencies)
    return (
        even("mass_kg", light, heavy, "kg"),
        even("natural_frequency_rad_per_s", slow, fast, "rad/s"),
        even("damping_ratio", *RESONATOR_DAMPING, "1"),
    )
