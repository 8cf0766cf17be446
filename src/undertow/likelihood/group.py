"""Which unknowns an equation has in a group: names, units, starts, and where they stand in the integrator.

Belongs here: the frozen `GroupModel` and how it follows from terms, specimen and structure. Does not belong here: its
fit (baseline.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.equation import registry
from undertow.equation.general import placed_terms
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.structure import CoulombFriction
from undertow.equation.term import PlacedTerm, Term, force_of
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Specimen, Structure
from undertow.likelihood.scale import contract_name
from undertow.quantities import Estimate
from undertow.recording.recording import Array

SAMPLES_ASKED = 5
"""Samples that a law is asked for the force of before it is fitted."""


@dataclass(frozen=True)
class Coefficient:
    """One unknown of an equation: its contract name, unit, slot, and the factor from the unknown to the slot."""

    name: str
    unit: str
    slot: str
    factor: float
    start: float
    lower: float = -math.inf
    upper: float = math.inf
    scale: float = 1.0
    term: str = ""


@dataclass(frozen=True)
class GroupModel:
    """An equation as it is fitted in one group.

    ``base`` is the parameter vector of what is fixed (the same in all trials but for k), ``coefficients`` what is
    found; ``fixed`` the structure held, None where everything is free. ``laws`` holds all forces where one of them is
    not in the compiled integrator, ``places`` maps such a law's parameters, term.parameter, to places behind its own.
    """

    terms: tuple[Term, ...]
    specimen: Specimen
    base: Array
    coefficients: tuple[Coefficient, ...]
    fixed: Structure | None = None
    stiffness: Mapping[str, float] = field(default_factory=dict)
    anchored: bool = True
    laws: tuple[PlacedTerm, ...] = ()
    places: Mapping[str, int] = field(default_factory=dict)

    @property
    def weighed(self) -> bool:
        """Whether kilograms come from a known mass alone: the stiffness is then among what is found."""
        return self.anchored and self.fixed is None and any(c.slot == "k1" for c in self.coefficients)

    @property
    def scattering(self) -> tuple[str, ...]:
        """What of k, c and mu the equation has, and so may be each trial's own; where no weight is known "friction" in
        place of mu, which is a share of it."""
        ratio = self.anchored and contract_name(CoulombFriction.name, self.specimen)[0] == CoulombFriction.structural
        has = {term.structural for term in self.terms}
        return tuple("friction" if s == "mu" and not ratio else s for s in ("k", "c", "mu") if s in has)

    def unit(self, unit: str) -> str:
        """A unit as the fitted numbers have it: forces and masses are per kilogram of the total mass without an anchor,
        and newtons, kilograms and metres are moments, inertias and radians of a rotation."""
        whole = self.anchored or not unit.startswith(("N", "kg"))
        return self.specimen.unit(unit if whole else f"{unit} per kg")

    def place(self, slot: str) -> int:
        """Where a slot stands in the parameter vector: the compiled integrator's place, or an own law's behind them."""
        return self.places[slot] if slot in self.places else SLOT[slot]

    def trial_base(self, trial: str) -> Array:
        """Parameter vector of what is fixed in one trial: the group's, with the trial's own k where it has one."""
        base = self.base.copy()
        if trial in self.stiffness:
            base[SLOT["k1"]] = self.stiffness[trial]
        return base

    def theta(self, values: Mapping[str, float], trial: str = "") -> Array:
        """Parameter vector at values of the coefficients by name."""
        theta = self.trial_base(trial)
        for c in self.coefficients:
            theta[self.place(c.slot)] += c.factor * values[c.name]
        return theta


def group_model(
    terms: Sequence[Term],
    motions: Sequence[Motion],
    specimen: Specimen,
    structure: Structure | None,
    *,
    dry: bool,
    anchored: bool,
    stiffness: Mapping[str, float] | None = None,
) -> GroupModel:
    """The unknowns of ``terms`` in one group.

    With a ``structure`` its k, c, mu are fixed and the water's terms are unknown; without, all are. ``anchored`` says
    that k (or the mass, when dry) gives kilograms; else the total mass is 1 and every unknown is per mass.
    IdentificationError where two unknowns are one force: only their sum would be known.
    """
    period = float(np.median([dominant_period(m) for m in motions]))
    rate = 2.0 * math.pi / period
    known_mass = math.isfinite(specimen.mass_kg)
    known_k = structure is not None or math.isfinite(specimen.stiffness_N_per_m)
    anchored = anchored and (known_mass or known_k)
    kept = tuple(t for t in terms if not (dry and t.of_water) and (anchored or not t.is_inertia))
    base = np.zeros(N_SLOTS)
    mass = specimen.mass_kg if known_mass and anchored else 1.0
    coefficients: list[Coefficient] = []
    weighed = dry and known_mass  # then the mass gives kilograms, and k is found
    fixes_k = anchored and not weighed and (structure is not None or math.isfinite(specimen.stiffness_N_per_m))
    added = any(t.is_inertia for t in kept)
    if anchored and (not known_mass or (fixes_k and structure is None and not added)):
        k = structure.k.value if structure else specimen.stiffness_N_per_m
        mass = k / rate**2
        kept = tuple(t for t in kept if not t.is_inertia)
        unit = specimen.unit("kg")
        coefficients.append(Coefficient("total_mass_kg", unit, "mass", 1.0, mass, 1e-9 * mass, scale=mass))
    else:
        base[SLOT["mass"]] = mass
    speed = max(float(np.max(np.abs(m.v))) for m in motions)
    size = max(m.amplitude for m in motions)
    for term in kept:
        if structure is not None and term.structural:
            _fix(base, term, structure, specimen)
        elif term.structural == "k" and fixes_k:
            base[SLOT["k1"]] = specimen.stiffness_N_per_m
        else:
            coefficients += _unknowns(term, specimen, mass, rate, speed, size, anchored)
    _must_differ(coefficients)
    own = dict(stiffness or {}) if structure is not None else {}
    laws, places = placed_terms(kept)
    base = np.concatenate([base, np.zeros(len(places))])
    return GroupModel(kept, specimen, base, tuple(coefficients), structure, own, anchored, laws, places)


def _must_differ(coefficients: Sequence[Coefficient]) -> None:
    """IdentificationError where two laws have one place in the integrator and neither is held."""
    for at, one in enumerate(coefficients):
        for other in coefficients[:at]:
            if one.slot == other.slot and one.slot != "mass":
                raise IdentificationError(
                    f"{other.term} and {one.term} are the same force, and only their sum is known: take one of them "
                    f"out of the equation, or give dry trials, which show the structure's own"
                )


def _fix(base: Array, term: Term, structure: Structure, specimen: Specimen) -> None:
    """Hold a law of the structure at what its dry trials gave."""
    held: Estimate = getattr(structure, term.structural)
    per = term.published.per if term.published is not None else ""
    base[SLOT[term.slots[term.coefficient.name]]] = held.value * (getattr(specimen, per) if per else 1.0)


def _unknowns(
    term: Term, specimen: Specimen, mass: float, rate: float, speed: float, size: float, anchored: bool
) -> list[Coefficient]:
    """Unknowns of one term: contract name, start from the motion's own scale (5 % of critical in total), bounds."""
    suffix = "" if anchored else "_per_mass"
    label, unit, per_force = contract_name(term.name, specimen if anchored else Specimen(rotation=specimen.rotation))
    first = term.start(mass, rate, speed)
    if math.isfinite(first) and term.slots:
        start = first * per_force
        lower = -0.9 * mass if term.is_inertia else 0.0 if term.structural == "k" else -math.inf
        slot = term.slots[term.coefficient.name]
        per_kg = f" per {specimen.unit('kg')}" if suffix else ""
        return [_one(label, unit + per_kg, slot, start, start, term, suffix, 1.0 / per_force, (lower, math.inf))]
    return _general(term, mass * rate * speed / _typical(term, size, speed), suffix, specimen)


def _one(
    name: str, unit: str, slot: str, start: float, scale: float, term: Term, suffix: str,
    factor: float, bounds: tuple[float, float],
) -> Coefficient:  # fmt: skip
    return Coefficient(name + suffix, unit, slot, factor, start, *bounds, scale, term.name)


def _typical(term: Term, size: float, speed: float) -> float:
    """Force per unit coefficient at the motion's largest displacement and speed; IdentificationError where a law of
    one's own gives no array of them."""
    share = np.linspace(-1.0, 1.0, SAMPLES_ASKED)
    return abs(float(force_of(term, size * share, speed * share, share, share + 1.0)[-1])) or 1.0


def _general(term: Term, scale: float, suffix: str, specimen: Specimen) -> list[Coefficient]:
    """Unknowns of any other term, its inner parameters included: in the compiled integrator's slots, or, of a law
    without any, under its own name."""
    first, leading = 1e-3 * scale, term.coefficient
    per_kg = " per kg" if suffix else ""
    forces = (leading, *term.slot_parameters.values())
    if term.slots:
        of_slot = {term.slots[p.name]: p for p in reversed(term.parameters)}
        number = "1" if term.held_by_kernel else ""
        found = [
            (term.slot_parameters.get(slot, of_slot.get(slot, leading)), slot + number, value, abs(value) or scale)
            for slot, value in term.slot_values(first).items()
        ]
    else:
        found = [(leading, f"{term.name}.{leading.name}", first, scale)]
        inner = zip(term.parameters[1:], term.inner.values(), strict=True)
        found += [(p, f"{term.name}.{p.name}", value, max(abs(value), 1e-3)) for p, value in inner]
    return [
        _one(
            f"{term.name}_{p.name}", specimen.unit(p.unit + (per_kg if p in forces else "")), slot, value, size, term,
            suffix if p in forces else "", 1.0, (p.lower, p.upper),
        )
        for p, slot, value, size in found
    ]  # fmt: skip


def terms_by_name(names: Sequence[str]) -> tuple[Term, ...]:
    """Terms of the registry by their names, in order."""
    return tuple(registry.find(name) for name in names)
