"""One case of an audit: rows of published tables that share one body of water, and what is known of the structure.

Belongs here: `Row`, `DryStructure`, `PrintedCase`, and what a recipe would print for a row under given physics. Does
not belong here: which physics are tried (rivals.py), how well they do (surface.py, posterior.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from undertow.audit.effects import DAMPING, FRICTION_FORCE, RESONATOR_DAMPING_RATIO, RESONATOR_FREQUENCY, RESONATOR_MASS
from undertow.audit.recipes import ITERATIONS, Array, Known, Returned, method1_returns, method2_returns
from undertow.audit.tables import Constants
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.errors import UndertowError

Recipe = Literal["method1", "method2", "method2_printed"]
"""Method 1; Method 2 with the inertia kept at the crossing; Method 2 as printed (Eq. 21), in magnitude."""

TYPICAL_SPEED = 0.75
"""Speed over x0 w at which a power law of velocity has the force of its C_d: a damped first quarter cycle."""


@dataclass(frozen=True)
class DryStructure:
    """A spring's dry values as the recipe uses them, their standard errors and their scatter from trial to trial.

    ``k`` N/m, ``c`` N s/m, ``mu``; ``k_error`` and ``k_scatter`` relative, the others in their unit.
    """

    k: float
    c: float
    mu: float
    k_error: float
    c_error: float
    mu_error: float
    k_scatter: float
    c_scatter: float
    mu_scatter: float
    k_other: float = math.nan
    """Stiffness by another dry route, N/m: the printed period and the mass; nan where there is none."""


@dataclass(frozen=True)
class Row:
    """One printed row: where it stands, its release (m, as recorded), the recipe and what it printed.

    ``added_mass_kg`` and ``drag_coefficient`` are nan where not printed; ``*_half_digit`` half a unit of the last
    digit.
    """

    table: str
    spring: str
    release_m: float
    recipe: Recipe
    added_mass_kg: float
    drag_coefficient: float
    mass_half_digit: float = 0.5
    drag_half_digit: float = 0.05
    window_s: float = 10.0

    @property
    def on_bound(self) -> bool:
        """Whether Method 1 was stopped by m_a >= 0."""
        return self.recipe == "method1" and self.added_mass_kg == 0.0


@dataclass(frozen=True)
class PrintedCase:
    """Rows that share the water, the structure by spring, mass (kg), area (m^2) and the possible submerged volumes
    (m^3)."""

    name: str
    rows: tuple[Row, ...]
    structures: Mapping[str, DryStructure]
    mass_kg: float
    area_m2: float
    volume_range_m3: tuple[float, float] = (0.0, 0.0)
    density_kg_per_m3: float = 1000.0
    gravity_m_per_s2: float = 9.81
    own_added_mass: bool = False
    """Whether each spring may have an added mass of its own (water answers by frequency)."""

    def __post_init__(self) -> None:
        if not self.rows:
            raise UndertowError(f"audit case {self.name}: 0 rows; name a table with added_mass or drag_coefficient")
        for row in self.rows:
            if row.spring not in self.structures:
                have = ", ".join(self.structures) or "none"
                raise UndertowError(f"audit case {self.name}: no structure {row.spring!r}, known are {have}; add it")
            if not row.release_m > 0.0:
                raise UndertowError(
                    f"audit case {self.name}: a row of {row.table} has release {row.release_m:g} m; it must be positive"
                )

    @property
    def springs(self) -> tuple[str, ...]:
        """Springs of the rows, each once, in their order."""
        return tuple(dict.fromkeys(row.spring for row in self.rows))

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Dry natural frequency of each spring, rad/s."""
        return tuple(math.sqrt(self.structures[name].k / self.mass_kg) for name in self.springs)

    @property
    def two_instants(self) -> bool:
        """Whether a row was made by Method 2."""
        return any(row.recipe != "method1" for row in self.rows)

    @property
    def speed_m_per_s(self) -> float:
        """A typical speed of the rows: median of 0.75 x0 w."""
        rates = [math.sqrt(self.structures[row.spring].k / self.mass_kg) * row.release_m for row in self.rows]
        return TYPICAL_SPEED * float(np.median(rates))

    def with_printed(self, printed: Array, name: str = "") -> PrintedCase:
        """The same case with other printed numbers (rows, 2): simulated tables."""
        rows = tuple(
            replace(row, added_mass_kg=float(mass), drag_coefficient=float(drag))
            for row, (mass, drag) in zip(self.rows, printed, strict=True)
        )
        return replace(self, rows=rows, name=name or self.name)


def known_of(dry: DryStructure, of: PrintedCase | Constants, volume_m3: float) -> Known:
    """What a recipe held fixed of a spring, at one submerged volume."""
    return Known(of.mass_kg, dry.k, dry.c, dry.mu, of.area_m2, volume_m3, of.density_kg_per_m3, of.gravity_m_per_s2)


def physics_of(case: PrintedCase, row: Row, values: Mapping[str, float], known: Known) -> Array:
    """Parameter vector of the compiled integrator for one row under physics ``values`` (names as in rivals.py).

    ``added_mass_kg`` may be ``added_mass_kg.<spring>``; ``k.<spring>`` and ``gain_error.stiffness_<spring>`` are
    relative errors of the stiffness, ``c.<spring>`` N s/m, ``mu.<spring>`` absolute.
    """
    get, spring = values.get, row.spring
    theta = np.zeros(N_SLOTS)
    k = known.k_N_per_m * (1.0 + get(f"k.{spring}", 0.0) + get(f"gain_error.stiffness_{spring}", 0.0))
    normal = (known.mass_kg - known.volume_m3 * known.density_kg_per_m3) * known.gravity_m_per_s2
    friction = (known.mu + get(f"mu.{spring}", 0.0)) * normal + get(FRICTION_FORCE, 0.0)
    theta[SLOT["mass"]] = known.mass_kg + get(f"added_mass_kg.{spring}", get("added_mass_kg", 0.0))
    theta[SLOT["k1"]] = k / (1.0 + k * get("support_compliance.compliance_m_per_N", 0.0))
    theta[SLOT["c1"]] = known.c_Ns_per_m + get(f"c.{spring}", 0.0) + get(DAMPING, 0.0)
    theta[SLOT["fc"]] = max(friction, 0.0)
    drag = known.drag_unit * get("drag_coefficient", 0.0)
    exponent = get("drag_exponent.exponent", 2.0)
    if exponent == 2.0:
        theta[SLOT["q"]] = drag
    else:
        theta[SLOT["cp"]], theta[SLOT["p"]] = drag * case.speed_m_per_s ** (2.0 - exponent), exponent
    theta[SLOT["hm1"]] = get(RESONATOR_MASS, 0.0)
    theta[SLOT["hw1"]] = get(RESONATOR_FREQUENCY, 0.0)
    theta[SLOT["hz1"]] = get(RESONATOR_DAMPING_RATIO, 0.0)
    theta[SLOT["x0"]] = row.release_m - get("rest_offset.offset_m", 0.0)
    return theta


def row_returns(
    case: PrintedCase, row: Row, values: Mapping[str, float], start: Returned | None = None, steps: int = ITERATIONS
) -> Returned:
    """What the row's own recipe returns under physics ``values``; ``start`` an answer near by, at most ``steps`` away
    (Method 1)."""
    known = known_of(case.structures[row.spring], case, values.get("volume_m3", case.volume_range_m3[0]))
    theta = physics_of(case, row, values, known)
    offset = values.get("rest_offset.offset_m", 0.0)
    if row.recipe == "method1":
        return method1_returns(theta, known, row.window_s, offset, start, row.on_bound, steps)
    share = values.get("turn_share", 0.0)
    return method2_returns(theta, known, offset, share, keep_inertia=row.recipe == "method2")


def case_returns(
    case: PrintedCase, values: Mapping[str, float], starts: tuple[Returned, ...] | None = None
) -> tuple[Returned, ...]:
    """What the recipes print for every row under one set of physics."""
    near = starts if starts is not None else (None,) * len(case.rows)
    return tuple(row_returns(case, row, values, start) for row, start in zip(case.rows, near, strict=True))
