"""The physics that may stand behind a table: each rival's effects, what is unknown in it, and how far it may go.

Every rival shares the nuisances: errors of k, c, mu of each spring, the submerged volume, and for Method 2 the side of
friction's jump on which the acceleration was read. A prior is a range (even) or a normal with its standard deviation;
its scale comes from the laboratory's own numbers, never from the printed coefficients.

Belongs here: rivals and priors. Does not belong here: their consequences (case.py), their weights (posterior.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from undertow.discrepancy.audit.case import Case
from undertow.discrepancy.audit.recipes import Array

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

EXPONENTS = (1.1, 1.9)
"""Exponents of a drag whose C_d truly falls with amplitude: 2 is quadratic drag, 1 linear damping, 0 friction."""


@dataclass(frozen=True)
class Unknown:
    """One unknown: even between ``low`` and ``high``, or normal about ``mean`` with ``deviation`` where that is
    given."""

    name: str
    low: float
    high: float
    deviation: float = math.nan
    unit: str = "1"
    nuisance: bool = False
    mean: float = 0.0
    logarithmic: bool = False
    """Even in its logarithm between the same ends."""

    @property
    def normal(self) -> bool:
        """Whether the prior is a normal."""
        return math.isfinite(self.deviation)

    @property
    def centre(self) -> float:
        """Where a search starts: the mean of a normal, the middle of a logarithm, the first quarter of a range."""
        if self.logarithmic:
            return math.sqrt(self.low * self.high)
        return self.mean if self.normal else self.low + 0.25 * (self.high - self.low)

    @property
    def scale(self) -> float:
        """A step over which an answer changes noticeably."""
        return self.deviation if self.normal else 0.1 * (self.high - self.low)


@dataclass(frozen=True)
class Rival:
    """Physics behind a table: the effects' names (none: Eq. 15 with constant coefficients), unknowns, and nodes.

    ``unknowns`` enter almost linearly; ``node_names`` and ``nodes`` (n, d) are values of the others, spread evenly over
    their prior, at each of which the unknowns are fitted. ``log_ranges`` (d, 2) are the ranges of their logarithms
    where more nodes may be drawn between them.
    """

    effects: tuple[str, ...]
    unknowns: tuple[Unknown, ...]
    node_names: tuple[str, ...] = ()
    nodes: Array = field(default_factory=lambda: np.zeros((1, 0)))
    log_ranges: Array | None = None
    water: bool = True

    @property
    def label(self) -> str:
        """Name in words."""
        if not self.water:
            return "no water force"
        return " + ".join(self.effects) or "equation 15"

    def given(self, priors: Mapping[str, tuple[float, float]]) -> Rival:
        """The rival with the prior of some unknowns replaced by a normal (mean, deviation): "what if k were
        another"."""
        return replace(self, unknowns=tuple(
            replace(one, low=-math.inf, high=math.inf, mean=priors[one.name][0], deviation=priors[one.name][1])
            if one.name in priors else one
            for one in self.unknowns
        ))  # fmt: skip


def nuisances(case: Case) -> tuple[Unknown, ...]:
    """What no recipe knew exactly: k, c, mu of every spring, the submerged volume, the instant of Method 2."""
    found = []
    for name in case.springs:
        dry = case.structures[name]
        found.append(Unknown(f"k.{name}", -1.0, 1.0, dry.k_error, "1", True))
        found.append(Unknown(f"c.{name}", -math.inf, math.inf, dry.c_error, "N s/m", True))
        found.append(Unknown(f"mu.{name}", -math.inf, math.inf, dry.mu_error, "1", True))
    low, high = case.volume_range_m3
    if high > low:
        found.append(Unknown("volume_m3", low, high, unit="m^3", nuisance=True))
    if case.two_instants:
        found.append(Unknown("turn_share", -1.0, 1.0, unit="1", nuisance=True))
    return tuple(found)


def rivals(case: Case, nodes: int = 24) -> tuple[Rival, ...]:
    """Every rival of a case; ``nodes`` frequencies of a resonator."""
    base = nuisances(case)
    masses = [f"added_mass_kg.{name}" for name in case.springs] if case.own_added_mass else ["added_mass_kg"]
    water = (
        *(Unknown(name, 0.0, ADDED_MASS_SHARE * case.mass_kg, unit="kg") for name in masses),
        Unknown("drag_coefficient", 0.0, DRAG_AT_MOST, unit="1"),
    )
    linear, friction, offset, compliance = (one(case) for one in (_linear, _friction, _offset, _compliance))
    found = [
        Rival((), (*water, *base)),
        Rival((), base, water=False),
        Rival(("linear_damping",), (*water, linear, *base)),
        Rival(("coulomb_friction",), (*water, friction, *base)),
        Rival(("linear_damping", "coulomb_friction"), (*water, linear, friction, *base)),
        Rival(
            ("drag_exponent",), (*water, *base), ("drag_exponent.exponent",),
            np.linspace(*EXPONENTS, 5).reshape(-1, 1),
        ),
        Rival(("hidden_resonator",), (*water, *_resonator(case), *base), *_frequencies(case, nodes)),
    ]  # fmt: skip
    if case.two_instants:
        found.append(Rival(("rest_offset",), (*water, offset, *base)))
        found.append(Rival(("linear_damping", "rest_offset"), (*water, linear, offset, *base)))
    if len(case.springs) > 1:
        found.append(Rival(("support_compliance",), (*water, compliance, *base)))
    return tuple(found)


def _linear(case: Case) -> Unknown:
    softest = min(case.structures[name].k for name in case.springs)
    critical = 2.0 * math.sqrt(softest * case.mass_kg)
    return Unknown("linear_damping.c_Ns_per_m", 0.0, DAMPING_RATIO_AT_MOST * critical, unit="N s/m")


def _friction(case: Case) -> Unknown:
    force = max(case.structures[name].mu for name in case.springs) * case.mass_kg * case.gravity_m_per_s2
    return Unknown("coulomb_friction.force_N", -force, 3.0 * force, FRICTION_ERROR_SHARE * force, "N")


def _offset(case: Case) -> Unknown:
    largest = max(row.release_m for row in case.rows)
    return Unknown("rest_offset.offset_m", -largest, largest, OFFSET_SHARE * largest, "m")


def _compliance(case: Case) -> Unknown:
    stiffest = max(case.structures[name].k for name in case.springs)
    deviation = COMPLIANCE_SHARE / stiffest
    return Unknown("support_compliance.compliance_m_per_N", 0.0, 0.5 / stiffest, deviation, "m/N")


def _resonator(case: Case) -> tuple[Unknown, Unknown]:
    low, high = (case.mass_kg * share for share in RESONATOR_MASS_SHARES)
    return (
        Unknown("hidden_resonator.mass_kg", low, high, unit="kg", logarithmic=True),
        Unknown("hidden_resonator.damping_ratio", *RESONATOR_DAMPING, logarithmic=True),
    )


def _frequencies(case: Case, nodes: int) -> tuple[tuple[str, ...], Array, Array]:
    """Name, points (nodes, 1) and range of the logarithm of a resonator's frequency: what the answers bend most
    with."""
    slow = RESONATOR_FREQUENCY_SHARES[0] * min(case.frequencies)
    fast = RESONATOR_FREQUENCY_SHARES[1] * max(case.frequencies)
    share = (np.arange(nodes) + 0.5) / nodes
    points = slow * (fast / slow) ** share
    return ("hidden_resonator.natural_frequency_rad_per_s",), points.reshape(-1, 1), np.log([[slow, fast]])
