"""What every identifier returns, and what it is told about the specimen.

Belongs here: the frozen `Fit`, `Specimen` and `Structure`. Does not belong here: any identification.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from undertow.equation.cells import GRAVITY_M_PER_S2
from undertow.quantities import OK, Estimate, unit_in_rotation


@dataclass(frozen=True)
class Specimen:
    """What the laboratory knows of the specimen in one group of trials; nan where it does not.

    ``mass_kg`` is all that moves when dry, ``stiffness_N_per_m`` the stated spring, ``area_m2`` the drag area (0 when
    dry), ``submerged_volume_m3`` reduces the normal force: N = m g - V rho g (report Eq. 15), and is ``volume_assumed``
    where a body stands in water and nobody said how much of it that displaces. ``area_error_m2`` and
    ``volume_error_m3`` are their standard errors, which go into the systematic part of what depends on them, and so is
    ``stiffness_error_N_per_m``, where load cells gave the stiffness, and ``mass_error_kg``, where they gave the mass.
    ``published`` holds values of parameters that others gave, by name: shown beside what is found, used for nothing.
    In a ``rotation`` the mass is an inertia (kg m^2), the stiffness a moment a radian, and no number is a share of the
    weight or of the area.
    """

    mass_kg: float = math.nan
    stiffness_N_per_m: float = math.nan
    area_m2: float = math.nan
    water_density_kg_per_m3: float = 1000.0
    submerged_volume_m3: float = 0.0
    gravity_m_per_s2: float = GRAVITY_M_PER_S2
    area_error_m2: float = 0.0
    volume_error_m3: float = 0.0
    stiffness_error_N_per_m: float = 0.0
    mass_error_kg: float = 0.0
    published: tuple[tuple[str, float], ...] = ()
    volume_assumed: bool = False
    rotation: bool = False

    def unit(self, unit: str) -> str:
        """A law's or a parameter's unit as this specimen's numbers have it.

        >>> Specimen().unit("N s/m"), Specimen(rotation=True).unit("N s/m")
        ('N s/m', 'N m s/rad')
        """
        return unit_in_rotation(unit) if self.rotation else unit

    @property
    def normal_force_N(self) -> float:
        """m g - V rho g in N; nan without a mass."""
        buoyancy = self.submerged_volume_m3 * self.water_density_kg_per_m3
        return (self.mass_kg - buoyancy) * self.gravity_m_per_s2

    @property
    def normal_force_error_N(self) -> float:
        """Standard error of the normal force from the volume's, N."""
        return self.volume_error_m3 * self.water_density_kg_per_m3 * self.gravity_m_per_s2

    @property
    def drag_N_per_unit_coefficient(self) -> float:
        """rho A / 2 in N s^2/m^2: drag force per C_d and squared velocity; nan without an area."""
        return 0.5 * self.water_density_kg_per_m3 * self.area_m2


@dataclass(frozen=True)
class Structure:
    """The structure's own parameters, from dry trials or a config: k (N/m), c (N s/m), mu (1), each an Estimate.

    ``scatter`` is the relative standard deviation (1 sigma) from trial to trial of ``k``, ``c`` and ``mu``;
    ``scatter_freedom`` the degrees of freedom it was seen with (inf where it was stated). ``mean_errors`` are standard
    errors of the means if the scatter was as it is believed, not widened for few trials (empty: those of the
    estimates); ``c_with_mu`` is the correlation of those of c and mu: a decay tells what both take together far better
    than either.
    """

    k: Estimate
    c: Estimate
    mu: Estimate
    scatter: Mapping[str, float] = field(default_factory=lambda: {"k": 0.0, "c": 0.0, "mu": 0.0})
    source: str = ""
    scatter_freedom: float = math.inf
    mean_errors: Mapping[str, float] = field(default_factory=dict)
    c_with_mu: float = 0.0

    def error_of_mean(self, symbol: str) -> float:
        """Standard error of the mean of k, c or mu if the scatter was as it is believed."""
        estimate: Estimate = getattr(self, symbol)
        return self.mean_errors.get(symbol, estimate.total_stderr)


@dataclass(frozen=True)
class Fit:
    """One identification of one trial or of one group's trials together.

    ``per_mass`` holds term name -> coefficient over total mass (and ``term.inner`` for inner parameters);
    ``parameters`` the same in the contract's names after an anchor (total_mass_kg, added_mass_kg, c_Ns_per_m, mu,
    drag_coefficient, k_N_per_m ...) or ``..._per_mass`` where there is none. ``outcome`` is "ok" or a sentence;
    ``notes`` say what a reader should know before using the numbers.
    """

    method: str
    trials: tuple[str, ...]
    per_mass: Mapping[str, Estimate] = field(default_factory=dict)
    parameters: Mapping[str, Estimate] = field(default_factory=dict)
    outcome: str = OK
    notes: tuple[str, ...] = ()
    anchor: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "per_mass", MappingProxyType(dict(self.per_mass)))
        object.__setattr__(self, "parameters", MappingProxyType(dict(self.parameters)))
