"""Consistency within one table: quantities that a law ties to each other, row by row.

Each identity predicts one printed column from others. A ratio that is one power of a thousand is a unit; a constant
other ratio is a wrong constant (and another spring's stiffness, where it is that); a ratio that drifts with the
release, or rows that disagree by more than their digits, are said with both numbers.

Belongs here: identities and units. Does not belong here: comparisons between tables (comparisons.py), columns
(patterns.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from undertow.audit.recipes import Array
from undertow.audit.tables import ADDED_MASS, WORDS, Column, Constants, PublishedTable, dry_value, same_conditions

NOTICEABLE = 0.01
"""Identities that hold within 1 % beyond the printed digits pass: constants are printed to three digits."""


@dataclass(frozen=True)
class Oddity:
    """Something that does not fit: the rule, the tables, what is printed and what the rule gives, in ``unit``."""

    rule: str
    tables: tuple[str, ...]
    quantity: str
    printed: float
    expected: float
    unit: str
    sentence: str


@dataclass(frozen=True)
class Identity:
    """``left`` should equal ``law(columns)``; ``needs`` are the columns of the law, ``powers`` their exponents."""

    left: str
    needs: Mapping[str, float]
    law: Callable[[Mapping[str, Array]], Array]
    text: str


IDENTITIES: tuple[Identity, ...] = (
    Identity("stiffness", {"load": 1.0, "release": -1.0}, lambda c: c["load"] / c["release"], "load / release"),
    Identity(
        "energy", {"stiffness": 1.0, "release": 2.0}, lambda c: 0.5 * c["stiffness"] * c["release"] ** 2, "k x0^2 / 2"
    ),
    Identity(
        "damping", {"damping_ratio": 1.0, "stiffness": 0.5, "mass": 0.5},
        lambda c: 2.0 * c["damping_ratio"] * np.sqrt(c["stiffness"] * c["mass"]), "2 zeta sqrt(k m)",
    ),
    Identity(
        "stiffness", {"mass": 1.0, "period": -2.0},
        lambda c: c["mass"] * (2.0 * math.pi / c["period"]) ** 2, "m (2 pi / T)^2",
    ),
    Identity(
        "inertia_force", {"mass": 1.0, ADDED_MASS: 1.0, "acceleration": 1.0},
        lambda c: (c["mass"] + c[ADDED_MASS]) * c["acceleration"], "(m + m_a) a",
    ),
    Identity(
        "drag_force", {"density": 1.0, "area": 1.0, "drag_coefficient": 1.0, "velocity": 2.0},
        lambda c: 0.5 * c["density"] * c["area"] * c["drag_coefficient"] * c["velocity"] ** 2, "rho A C_d U^2 / 2",
    ),
)  # fmt: skip
"""The identities that are tried wherever a table (with the constants) has their columns."""


def identity_columns(
    table: PublishedTable, tables: Sequence[PublishedTable], constants: Constants, identity: Identity
) -> dict[str, Array] | None:
    """The law's inputs (n,), filled from the constants, the dry stiffness and, for a release, a table row by row beside
    it; None where one is missing."""
    columns = {}
    for name in identity.needs:
        if name in table.columns:
            columns[name] = table.columns[name].values
        elif name == "mass" and "period" not in table.columns and identity.left != "damping":
            return None
        elif name == "mass":
            columns[name] = np.full(table.rows, constants.mass_kg)
        elif name == "stiffness":
            known = dry_stiffness(table, tables, constants)
            if known is None:
                return None
            columns[name] = known
        elif name == "release":
            partner = release_partner(table, tables, constants)
            if partner is None:
                return None
            columns[name] = partner[1].values
        else:
            return None
    return columns


def dry_stiffness(table: PublishedTable, tables: Sequence[PublishedTable], constants: Constants) -> Array | None:
    """Mean dry stiffness of each row's spring, (n,) N/m; None where a spring has no dry table."""
    springs = [table.at(row).get(constants.spring_key, "") for row in range(table.rows)]
    values = [dry_value(tables, constants, spring, "stiffness") for spring in springs]
    if any(not one.size for one in values):
        return None
    return np.array([float(one.mean()) for one in values])


def release_partner(
    table: PublishedTable, tables: Sequence[PublishedTable], constants: Constants
) -> tuple[PublishedTable, Column] | None:
    """A table of the same trials that prints the releases this one lacks: same conditions, same number of rows, and an
    energy that goes with the square of the release most evenly; a single release of the same conditions else."""
    if "energy" not in table.columns:
        return None
    keys = (constants.spring_key, constants.water_key)
    best: tuple[float, PublishedTable, Column] | None = None
    for other in tables:
        if other is table or "release" not in other.columns or not other.rows:
            continue
        if other.rows == table.rows and same_conditions(table.at(0), other.at(0), keys) and not other.row_conditions:
            column = other.columns["release"]
            spread = float(np.std(np.log(table.columns["energy"].values / column.values**2)))
            if best is None or spread < best[0]:
                best = (spread, other, column)
    return None if best is None else (best[1], best[2])


def _other_partners(
    table: PublishedTable, tables: Sequence[PublishedTable], constants: Constants,
    partner: tuple[PublishedTable, Column] | None,
) -> list[PublishedTable]:  # fmt: skip
    if partner is None:
        return []
    keys = (constants.spring_key, constants.water_key)
    return [
        other
        for other in tables
        if other is not partner[0] and other is not table and "release" in other.columns and not other.row_conditions
        and other.rows == table.rows and same_conditions(table.at(0), other.at(0), keys)
    ]  # fmt: skip


def with_releases(tables: Sequence[PublishedTable], constants: Constants) -> list[PublishedTable]:
    """Tables that lack releases with those of a table of the same trials, else with sqrt(2 E / k) of their energies."""
    found = []
    for table in tables:
        partner = release_partner(table, tables, constants) if "release" not in table.columns else None
        if partner is not None:
            table = table.replaced("release", partner[1])
        elif "release" not in table.columns and "energy" in table.columns:
            stiffness = dry_stiffness(table, tables, constants)
            if stiffness is not None:
                energy = table.columns["energy"]
                release = np.sqrt(2.0 * energy.values / stiffness)
                half = 0.5 * release * energy.half_digits / energy.values
                table = table.replaced("release", Column(release, half, "m"))
        found.append(table)
    return found


def check_identities(tables: Sequence[PublishedTable], constants: Constants) -> list[Oddity]:
    """Every identity on every table (units mended): a constant factor, or rows that disagree."""
    found = []
    for identity in IDENTITIES:
        for table in tables:
            if identity.left not in table.columns:
                continue
            columns = identity_columns(table, tables, constants, identity)
            if columns is None:
                continue
            oddity = _judge(table, tables, constants, identity, columns)
            if oddity is not None:
                found.append(oddity)
    return found


def _judge(
    table: PublishedTable, tables: Sequence[PublishedTable], constants: Constants, identity: Identity,
    columns: Mapping[str, Array],
) -> Oddity | None:  # fmt: skip
    left = table.columns[identity.left]
    right = identity.law(columns)
    ratio = left.values / right
    reach = left.half_digits / np.abs(left.values) + NOTICEABLE
    for name, power in identity.needs.items():
        if name in table.columns:
            reach = reach + abs(power) * table.columns[name].half_digits / np.abs(table.columns[name].values)
    off = np.abs(np.log(ratio)) > reach
    if not off.any():
        return None
    worst = int(np.argmax(np.abs(np.log(ratio)) - reach))
    middle, spread = float(np.median(ratio)), float(np.std(np.log(ratio)))
    where = f"in {int(off.sum())} of {table.rows} rows" if not off.all() else "in every row"
    said = middle if off.all() else float(ratio[worst])
    explained = ""
    if identity.left == "energy" and off.all() and spread < NOTICEABLE:
        explained = _other_stiffness(table, tables, constants, columns["release"])
    if identity.left == "damping" and spread < NOTICEABLE:
        explained = (
            f" The stiffness behind this damping is {float(np.median(columns['stiffness'] * ratio**2)):.4g} N/m."
        )
    partner = release_partner(table, tables, constants) if "release" not in table.columns else None
    beside = f" with the releases of {partner[0].title}" if partner is not None else ""
    for other in _other_partners(table, tables, constants, partner):
        also = float(np.median(left.values / (right * (other.columns["release"].values / columns["release"]) ** 2)))
        explained += f" With those of {other.title} it is {also:.3g} times."
    return Oddity(
        "identity", (table.name, *((partner[0].name,) if partner else ())), identity.left,
        float(left.values[worst]), float(right[worst]), "",
        f"{table.title}: {WORDS[identity.left]} is {said:.3g} times {identity.text}{beside} {where} "
        f"(printed {left.values[worst]:.5g}, the rule gives {right[worst]:.5g}, SI).{explained}",
    )  # fmt: skip


def _other_stiffness(
    table: PublishedTable, tables: Sequence[PublishedTable], constants: Constants, release: Array
) -> str:
    """Says whose stiffness a constant energy factor is, if one of the laboratory's springs has it."""
    implied = float(np.median(2.0 * table.columns["energy"].values / release**2))
    springs = {one.at(row).get(constants.spring_key) for one in tables for row in range(one.rows)}
    for spring in sorted(str(name) for name in springs if name is not None):
        values = dry_value(tables, constants, spring, "stiffness")
        if values.size and abs(implied / float(values.mean()) - 1.0) < NOTICEABLE:
            return (
                f" The stiffness behind these energies is {implied:.4g} N/m: that of the {spring} spring "
                f"({float(values.mean()):.4g} N/m)."
            )
    return f" The stiffness behind these energies is {implied:.4g} N/m."
