"""From per-mass numbers to kilograms: the anchor.

A free decay gives only ratios to the total mass: scaling m, c, k, F and q together leaves the motion unchanged. An
anchor is needed. Order: a known mass with dry trials of the same spring (k = m w_dry^2, so that
m_a = m ((w_dry / w_wet)^2 - 1) does not depend on any printed k), the stated stiffness, a known mass where the equation
has no added mass, load cells, none.

Belongs here: the anchor, its error and its sentence; per-mass coefficients in the report's parameters.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from undertow.equation import registry
from undertow.likelihood.fit import Specimen, Structure
from undertow.likelihood.priors import GAIN_STD
from undertow.quantities import Estimate, format_number
from undertow.recording.recording import Array

AnchorKind = Literal["mass", "stiffness", "load cells", "none"]

STIFFNESS_DISAGREEMENT = 0.01
"""Relative difference between two stiffnesses above which both are printed (CONTRACT: over 1 %)."""


@dataclass(frozen=True)
class Anchor:
    """What turns ratios into kilograms: a stiffness in N/m with its error (nan where a known mass is all that moves),
    where it comes from, and doubts about it."""

    kind: AnchorKind
    stiffness: Estimate
    sentence: str
    doubts: tuple[str, ...] = ()

    @property
    def known(self) -> bool:
        """Whether there is an anchor at all."""
        return self.kind != "none"


def choose_anchor(
    specimen: Specimen,
    structure: Structure | None,
    load_cells: Estimate | None = None,
    dry: bool = False,
    *,
    added_mass: bool = True,
) -> Anchor:
    """The anchor for one group, in the order of the module's text.

    ``structure`` is that of the dry trials with the same spring (its k is m w_dry^2); ``load_cells`` the group's mean
    slope of spring force on displacement. In a dry group the mass itself is the anchor, and so it is of an equation
    without ``added_mass``: beside added mass a mass alone gives no kilograms.

    >>> choose_anchor(Specimen(stiffness_N_per_m=1000.0), None).kind
    'stiffness'
    >>> choose_anchor(Specimen(mass_kg=4.0), None, added_mass=False).sentence
    'mass 4 kg, as given'
    """
    unit, of_mass = specimen.unit("N/m"), specimen.unit("kg")
    nothing = Estimate(math.nan, unit=unit)
    stated = specimen.stiffness_N_per_m
    if math.isfinite(specimen.mass_kg) and (structure is not None or dry):
        k = replace(structure.k, unit=unit) if structure is not None else nothing
        others = {"config": stated, "load cells": load_cells.value if load_cells else math.nan}
        doubts = _disagreements(k, "dry motion (m w^2)", others) if structure is not None else ()
        return Anchor("mass", k, f"mass {specimen.mass_kg:g} {of_mass} with the dry frequency", doubts)
    if math.isfinite(stated):
        k = Estimate(stated, 0.0, unit=unit, source="config")
        others = {"load cells": load_cells.value if load_cells else math.nan}
        doubts = _disagreements(k, "config", others)
        return Anchor("stiffness", k, f"stiffness {stated:g} {unit} from the config", doubts)
    if math.isfinite(specimen.mass_kg) and not added_mass:
        return Anchor("mass", nothing, f"mass {specimen.mass_kg:g} {of_mass}, as given")
    if load_cells is not None and load_cells.value > 0.0:
        anchor = with_gain(replace(load_cells, unit=unit))
        return Anchor("load cells", anchor, f"stiffness {anchor} from the load cells")
    return Anchor("none", nothing, "no anchor: coefficients are per total mass")


def with_gain(load_cells: Estimate) -> Estimate:
    """A stiffness that load cells alone give, as wrong as their gain.

    >>> round(with_gain(Estimate(1000.0, 1.0, unit="N/m")).systematic, 6)
    5.0
    """
    return replace(load_cells, systematic=math.hypot(load_cells.systematic, GAIN_STD * load_cells.value))


def on_load_cells(specimen: Specimen, anchor: Anchor) -> Specimen:
    """The specimen with the stiffness that load cells give and its error, where nothing else gives kilograms."""
    if anchor.kind != "load cells":
        return specimen
    k = anchor.stiffness
    return replace(specimen, stiffness_N_per_m=k.value, stiffness_error_N_per_m=k.total_stderr)


def with_scale_error(estimates: Mapping[str, Estimate], specimen: Specimen) -> dict[str, Estimate]:
    """The estimates by name with the error of what gives kilograms (stiffness or mass) in every mass and force, which
    go with it.

    >>> told = Specimen(stiffness_N_per_m=1000.0, stiffness_error_N_per_m=10.0)
    >>> with_scale_error({"c_Ns_per_m": Estimate(50.0, 0.1, unit="N s/m")}, told)["c_Ns_per_m"].systematic
    0.5
    >>> weighed = Specimen(mass_kg=4.0, mass_error_kg=0.04)
    >>> with_scale_error({"added_mass_kg": Estimate(2.0, 0.1, unit="kg")}, weighed)["added_mass_kg"].systematic
    0.02
    """
    by_spring = specimen.stiffness_error_N_per_m / specimen.stiffness_N_per_m
    by_spring = by_spring if specimen.stiffness_error_N_per_m > 0.0 else 0.0
    by_mass = specimen.mass_error_kg / specimen.mass_kg if specimen.mass_error_kg > 0.0 else 0.0
    if by_spring == by_mass == 0.0:
        return dict(estimates)
    out = {}
    for name, e in estimates.items():
        scales = e.unit.startswith(("kg", "N")) or name in ("mu", "drag_coefficient")
        of_body = specimen.mass_kg if name == "added_mass_kg" and math.isfinite(specimen.mass_kg) else 0.0
        away = math.hypot(by_spring * (abs(e.value) + of_body), by_mass * abs(e.value)) if scales else 0.0
        out[name] = replace(e, systematic=math.hypot(e.systematic, away))
    return out


def _disagreements(stiffness: Estimate, source: str, others: Mapping[str, float]) -> tuple[str, ...]:
    """Sentences for every other stiffness that differs by more than `STIFFNESS_DISAGREEMENT`."""
    said, value, unit = [], stiffness.value, stiffness.unit
    for name, other in others.items():
        if math.isfinite(other) and math.isfinite(value) and abs(other / value - 1.0) > STIFFNESS_DISAGREEMENT:
            said.append(
                f"stiffness from {source} is {value:.6g} {unit} but from {name} {other:.6g} {unit} "
                f"({100.0 * (other / value - 1.0):+.1f} %)"
            )
    return tuple(said)


def to_physical(
    names: Sequence[str], per_mass: Array, covariance: Array, anchor: Anchor, specimen: Specimen, dry: bool
) -> dict[str, Estimate]:
    """The contract's parameters from per-mass coefficients (p,) and their covariance (p, p), by term ``names``.

    total_mass_kg, added_mass_kg, k_N_per_m, c_Ns_per_m, mu, drag_coefficient (drag_Ns2_per_m2 without an area); other
    terms ``<name>`` times the mass. The anchor's error is the systematic part. Without an anchor: ``..._per_mass``.
    """
    index = {name: i for i, name in enumerate(names)}
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    if not anchor.known or "stiffness" not in index:
        return {
            f"{name}_per_mass": Estimate(float(per_mass[i]), float(errors[i]), unit=f"{unit} per {specimen.unit('kg')}")
            for n, i in index.items()
            for name, unit, _ in [contract_name(n, Specimen(rotation=specimen.rotation))]
        }
    kappa = float(per_mass[index["stiffness"]])
    k_error = anchor.stiffness.total_stderr / anchor.stiffness.value if anchor.stiffness.value > 0.0 else 0.0
    weighed = anchor.kind == "mass" and (dry or not math.isfinite(anchor.stiffness.value))
    k_error = specimen.mass_error_kg / specimen.mass_kg if weighed else k_error
    k_error = k_error if math.isfinite(k_error) else 0.0
    mass = specimen.mass_kg if weighed else anchor.stiffness.value / kappa
    found: dict[str, Estimate] = {}
    for name, i in index.items():
        key, unit, factor = contract_name(name, specimen)
        coefficient = float(per_mass[i])
        if name == "stiffness" and not weighed:
            found[key] = replace(anchor.stiffness, unit=unit)
            continue
        gradient = np.zeros(len(index))
        gradient[i] = mass
        if not weighed:
            gradient[index["stiffness"]] -= coefficient * mass / kappa
        noise = math.sqrt(max(float(gradient @ covariance @ gradient), 0.0))
        found[key] = Estimate(coefficient * mass, noise, abs(coefficient) * mass * k_error, unit).scaled(factor, unit)
    kappa_error = float(errors[index["stiffness"]]) / kappa
    mass_noise = 0.0 if weighed else mass * kappa_error
    whole = Estimate(mass, mass_noise, mass * k_error, specimen.unit("kg"), anchor.sentence)
    found["total_mass_kg"] = whole
    if math.isfinite(specimen.mass_kg) and not (dry or weighed):
        found["added_mass_kg"] = replace(whole, value=mass - specimen.mass_kg)
    return found


def contract_name(term: str, specimen: Specimen) -> tuple[str, str, float]:
    """Column name, unit and factor (from the term's force coefficient) of one term's parameter.

    Of a law that a report writes as a ratio (friction over weight, drag over area) it is that ratio, where the specimen
    has it, which no rotation has.

    >>> contract_name("cubic_stiffness", Specimen())[:2]
    ('cubic_stiffness_N_per_m3', 'N/m^3')
    >>> contract_name("coulomb_friction", Specimen(mass_kg=4.0))[0]
    'mu'
    >>> contract_name("coulomb_friction", Specimen(mass_kg=4.0, rotation=True))
    ('friction_N', 'N m', 1.0)
    """
    if term not in registry.names():
        return term, "", 1.0
    law = registry.find(term)
    if law.published is None:
        return f"{term}_{law.coefficient.name}", specimen.unit(law.coefficient.unit), 1.0
    whole = getattr(specimen, law.published.per) if law.published.per and not specimen.rotation else math.nan
    if math.isfinite(whole) and whole > 0.0:
        return law.published.ratio, "1", 1.0 / whole
    return law.published.column, specimen.unit(law.published.unit), 1.0


def structural_parameters(structure: Structure, specimen: Specimen) -> dict[str, Estimate]:
    """A structure's k, c and friction by the contract's names, in the specimen's units: friction as a coefficient, of a
    rotation as the moment that it stands for.

    >>> held = Structure(Estimate(20.0), Estimate(0.1), Estimate(0.5))
    >>> [*structural_parameters(held, Specimen(mass_kg=4.0))]
    ['k_N_per_m', 'c_Ns_per_m', 'mu']
    >>> turns = structural_parameters(held, Specimen(mass_kg=2.0, gravity_m_per_s2=10.0, rotation=True))
    >>> [(name, one.value, one.unit) for name, one in turns.items()]
    [('k_N_per_m', 20.0, 'N m/rad'), ('c_Ns_per_m', 0.1, 'N m s/rad'), ('friction_N', 10.0, 'N m')]
    """
    k, c, mu = structure.k, structure.c, structure.mu
    if not specimen.rotation:
        return {"k_N_per_m": k, "c_Ns_per_m": c, "mu": mu}
    moment = mu.scaled(specimen.normal_force_N, specimen.unit("N"))
    k, c = replace(k, unit=specimen.unit("N/m")), replace(c, unit=specimen.unit("N s/m"))
    return {"k_N_per_m": k, "c_Ns_per_m": c, "friction_N": moment}


def trial_stiffness(
    group: Estimate, slopes: Mapping[str, Estimate], dry_ratio: Estimate, scatter: float
) -> dict[str, Estimate]:
    """Stiffness of each trial from its own load cells, shrunk by how far they can be trusted.

    ``slopes`` are the trials' slopes of spring force on displacement; ``dry_ratio`` is slope over m w^2 in the dry
    trials (mean, and as stderr its spread from trial to trial, which is the load cells' and potentiometer's gain).
    With relative spread g of that ratio and ``scatter`` s of k itself,
    k_i = k (1 + s^2 / (s^2 + g^2) (slope_i / (ratio k) - 1)): as good as the mean where gains scatter as much as k.
    """
    gain = max(dry_ratio.stderr if math.isfinite(dry_ratio.stderr) else scatter, 1e-6)
    trust = scatter**2 / (scatter**2 + gain**2) if scatter > 0.0 else 0.0
    left = scatter * math.sqrt(1.0 - trust)
    out = {}
    for name, slope in slopes.items():
        away = slope.value / (dry_ratio.value * group.value) - 1.0
        k = group.value * (1.0 + trust * away)
        text = f"dry k with {format_number(100 * trust)} % of the load cells' deviation {100 * away:+.2f} %"
        out[name] = Estimate(k, left * group.value, group.total_stderr, "N/m", text)
    return out
