"""Consistency of printed maxima and forces with the equation they are printed for, and of recipes with their formulas.

Belongs here: what Eq. 15 and the structure alone make of a printed row. Does not belong here: rivals (rivals.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from undertow.audit.case import DryStructure, known_of
from undertow.audit.identities import NOTICEABLE, Oddity
from undertow.audit.recipes import Array, Known, method2_returns, trajectory
from undertow.audit.tables import ADDED_MASS, Constants, PublishedTable
from undertow.errors import UndertowError

DRAWS = 4000
"""Draws of c, mu and V for an interval of what the structure alone gives."""

MAXIMA_AGREE = 0.05
"""Printed maxima within 5 % of the equation's pass: filters and instants cost a few per cent."""


@dataclass(frozen=True)
class WaterShare:
    """How much of a table's drag coefficients any water is needed for, row by row (90 % intervals, (n,)).

    ``printed`` C_d; ``dry_low``, ``dry_high`` what 2 (mu N + c U) / (rho A U^2) of the dry structure gives at the
    printed velocities; ``share_low``, ``share_high`` the share of C_d beyond it.
    """

    table: str
    release_m: Array
    printed: Array
    dry_low: Array
    dry_high: Array
    share_low: Array
    share_high: Array
    sentence: str


def water_share(
    table: PublishedTable, structure: DryStructure, constants: Constants, seed: int = 0
) -> WaterShare | None:
    """The share of a table's C_d that its dry structure does not already give; None without a column of velocities.

    c and mu are drawn from trial to trial as the dry tables scatter, V evenly over its range.
    """
    if not {"velocity", "drag_coefficient", "release"} <= set(table.columns):
        return None
    rng = np.random.default_rng(seed)
    speed, printed = table.columns["velocity"].values, table.columns["drag_coefficient"].values
    c = structure.c + structure.c_scatter * rng.standard_normal((DRAWS, 1))
    mu = structure.mu + structure.mu_scatter * rng.standard_normal((DRAWS, 1))
    volume = rng.uniform(*constants.volume_range_m3, (DRAWS, 1))
    normal = (constants.mass_kg - constants.density_kg_per_m3 * volume) * constants.gravity_m_per_s2
    dry = 2.0 * (mu * normal + c * speed) / (constants.density_kg_per_m3 * constants.area_m2 * speed**2)
    share = 1.0 - dry / printed
    low, middle, high = np.quantile(dry, [0.05, 0.5, 0.95], axis=0)
    share_low, share_high = np.quantile(share, [0.05, 0.95], axis=0)
    covered = int(np.sum((printed >= low) & (printed <= high) | (printed < low)))
    sentence = (
        f"{table.title}: friction and viscous damping of the dry structure alone, put into Eq. 21 at the printed "
        f"velocities, give C_d of {middle[0]:.3g} ({low[0]:.3g} to {high[0]:.3g}) at the first row, {printed[0]:.3g} "
        f"printed, and {middle[-1]:.3g} ({low[-1]:.3g} to {high[-1]:.3g}) at the last, {printed[-1]:.3g} printed. "
        f"In {covered} of {table.rows} rows the printed value lies within or below that interval: those rows carry no "
        f"information about the water. At most {100.0 * max(0.0, float(share_high.max())):.0f} % of a row's C_d "
        f"needs water."
    )
    release = table.columns["release"].values
    return WaterShare(table.name, release, printed, low, high, share_low, share_high, sentence)


def check_forces(
    tables: Sequence[PublishedTable], structures: Mapping[str, DryStructure], constants: Constants
) -> list[Oddity]:
    """Printed maxima against the equation, formulas that cannot give what is printed, inputs that are not printed."""
    found = []
    for table in tables:
        structure = structures.get(str(table.conditions.get(constants.spring_key)))
        if structure is None:
            continue
        if {"acceleration", ADDED_MASS, "release"} <= set(table.columns):
            found += _maxima(table, structure, constants)
        if table.recipe.startswith("method2") and "drag_coefficient" in table.columns:
            found += _recipe(table, structure, constants)
    return found + _not_printed(tables, structures, constants)


def _maxima(table: PublishedTable, structure: DryStructure, constants: Constants) -> list[Oddity]:
    columns = table.columns
    total = constants.mass_kg + columns[ADDED_MASS].values
    acceleration, release = columns["acceleration"].values, columns["release"].values
    known = [known_of(structure, constants, volume) for volume in constants.volume_range_m3]
    friction = max(one.friction_N for one in known)
    # friction brakes before the turning point and at the release it drives the other way: both sides are allowed
    masses = np.array([(structure.k * release + side * friction) / acceleration for side in (-1.0, 1.0)])
    found = []
    reach = columns["acceleration"].half_digits / acceleration + columns["release"].half_digits / release + NOTICEABLE
    outside = (total < masses[0] * (1.0 - reach)) | (total > masses[1] * (1.0 + reach))
    if outside.any():
        worst = int(np.argmax(np.abs(np.log(masses[0] / total)) * outside))
        found.append(Oddity(
            "largest acceleration", (table.name,), "acceleration", float(total[worst]), float(masses[0][worst]), "kg",
            f"{table.title}: k x0 less friction over the printed acceleration gives a moving mass of "
            f"{masses[0].min():.4g} to {masses[0].max():.4g} kg, m + m_a is printed as {total[worst]:.5g} kg "
            f"({int(outside.sum())} of {table.rows} rows disagree beyond digits and friction).",
        ))  # fmt: skip
    if {"velocity", "drag_coefficient"} <= set(columns):
        found += _largest_velocity(table, known[0])
    return found


def _largest_velocity(table: PublishedTable, known: Known) -> list[Oddity]:
    """The velocity that Eq. 15 reaches with the printed coefficients, against the printed one."""
    columns, ratios, reached = table.columns, [], []
    for row in range(table.rows):
        added, drag, release = (columns[name].values[row] for name in (ADDED_MASS, "drag_coefficient", "release"))
        theta = known.equation_15(known.mass_kg + added, known.drag_unit * drag, release)
        half = math.pi * math.sqrt((known.mass_kg + added) / known.k_N_per_m)
        _, v, _ = trajectory(theta, np.linspace(0.0, half, 200), half / 60.0)
        reached.append(float(np.max(np.abs(v))))
        ratios.append(columns["velocity"].values[row] / reached[-1])
    off = np.abs(np.log(ratios)) > MAXIMA_AGREE
    if not off.any():
        return []
    worst = int(np.argmax(np.abs(np.log(ratios))))
    printed = float(columns["velocity"].values[worst])
    return [Oddity(
        "largest velocity", (table.name,), "velocity", printed, reached[worst], "m/s",
        f"{table.title}: Eq. 15 with the printed coefficients reaches {reached[worst]:.3g} m/s from "
        f"{columns['release'].values[worst]:.4g} m, {printed:.3g} m/s is printed ({int(off.sum())} of {table.rows} "
        f"rows differ by more than {100.0 * MAXIMA_AGREE:.0f} %, ratios {min(ratios):.2f} to {max(ratios):.2f}).",
    )]  # fmt: skip


def _recipe(table: PublishedTable, structure: DryStructure, constants: Constants) -> list[Oddity]:
    """Eq. 21 as printed leaves out the inertia: its C_d is negative whatever the water does. Eq. 19 leaves out
    friction."""
    if "release" not in table.columns:
        return []
    known = known_of(structure, constants, constants.volume_range_m3[0])
    releases = table.columns["release"].values
    row = int(np.argmax(releases))
    release = float(releases[row])
    added = float(table.columns[ADDED_MASS].values[row]) if ADDED_MASS in table.columns else 0.0
    printed = float(table.columns["drag_coefficient"].values[row])
    theta = known.equation_15(constants.mass_kg + added, known.drag_unit * max(printed, 0.0), release)
    try:
        returned = method2_returns(theta, known, keep_inertia=False)
    except UndertowError:
        return []  # with the printed coefficients the largest release sticks at once: nothing to hold the formulas to
    acceleration = known.k_N_per_m * release / (constants.mass_kg + added)
    smallest = acceleration * float(releases.min()) / release
    return [
        Oddity(
            "formula", (table.name,), "drag_coefficient", printed, returned.bounded_drag, "1",
            f"{table.title}: Eq. 21 as printed leaves out (m + m_a) x'', which balances the forces at x = 0: on a "
            f"motion with the printed coefficients it gives C_d = {returned.bounded_drag:.3g}, and a negative one on "
            f"every decay, where {printed:.3g} is printed.",
        ),
        Oddity(
            "formula", (table.name,), ADDED_MASS, added, added - known.friction_N / acceleration, "kg",
            f"{table.title}: Eqs. 18-19 leave friction out, which at a turning point is up to mu N / x'' = "
            f"{known.friction_N / acceleration:.3g} kg of added mass at the largest release and "
            f"{known.friction_N / smallest:.3g} kg at the smallest.",
        ),
    ]  # fmt: skip


def _not_printed(
    tables: Sequence[PublishedTable], structures: Mapping[str, DryStructure], constants: Constants
) -> list[Oddity]:
    low, high = constants.volume_range_m3
    fitted = [table for table in tables if "drag_coefficient" in table.columns]
    if not high > low or not structures or not fitted:
        return []
    mu = max(structure.mu for structure in structures.values())
    moved = mu * constants.density_kg_per_m3 * constants.gravity_m_per_s2 * (high - low)
    return [Oddity(
        "not printed", tuple(table.name for table in fitted), "friction_coefficient", math.nan, moved, "N",
        f"The submerged volume V is printed nowhere, and the friction mu (m g - V rho g) needs it: between {low:g} and "
        f"{high:g} m^3 it moves the friction by {moved:.3g} N of "
        f"{mu * constants.mass_kg * constants.gravity_m_per_s2:.3g} N.",
    )]  # fmt: skip
