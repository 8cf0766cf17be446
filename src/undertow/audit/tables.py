"""Published tables as numbers with meanings: quantities, units as printed, conditions, the recipe that made them.

Belongs here: `Column`, `PublishedTable`, `Constants`, and how tables are matched. Does not belong here: reading files
(campaign/audit.py), judging them (checks*.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from undertow.audit.recipes import Array
from undertow.errors import UndertowError
from undertow.recording.recording import Condition

ADDED_MASS = "added_mass"
"""Column of a published added mass."""

QUANTITIES: Mapping[str, str] = {
    "release": "m", "load": "N", "energy": "J", "stiffness": "N/m", "damping": "N s/m", "damping_ratio": "1",
    "friction_coefficient": "1", ADDED_MASS: "kg", "drag_coefficient": "1", "mass": "kg", "acceleration": "m/s^2",
    "inertia_force": "N", "velocity": "m/s", "area": "m^2", "density": "kg/m^3", "drag_force": "N", "period": "s",
    "water_in_cells": "kg",
}  # fmt: skip
"""What a column can be, and its SI unit."""

WORDS: Mapping[str, str] = {
    "release": "release", "load": "initial load", "energy": "potential energy", "stiffness": "stiffness",
    "damping": "damping c", "damping_ratio": "damping ratio", "friction_coefficient": "friction coefficient",
    ADDED_MASS: "added mass", "drag_coefficient": "drag coefficient", "mass": "mass",
    "acceleration": "largest acceleration", "inertia_force": "inertia force", "velocity": "largest velocity",
    "area": "area", "density": "density", "drag_force": "drag force", "period": "period",
    "water_in_cells": "water in the cells",
}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """One printed quantity: ``values`` (n,) in SI as the printed unit says, half a unit of the last digit
    ``half_digits`` (n,), the unit ``printed_unit`` of the heading."""

    values: Array
    half_digits: Array
    printed_unit: str = ""

    def times(self, factor: float) -> Column:
        """The same column with its unit read otherwise."""
        return replace(self, values=self.values * factor, half_digits=self.half_digits * abs(factor))


@dataclass(frozen=True)
class PublishedTable:
    """A table: columns by quantity, conditions of the whole table and of each row, and the recipe that made it.

    ``recipe`` is "envelope", "method1", "method2", "method2_printed" or "" (read off, or not known).
    """

    name: str
    title: str
    columns: Mapping[str, Column]
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    row_conditions: Mapping[str, tuple[Condition, ...]] = field(default_factory=dict)
    recipe: str = ""

    def __post_init__(self) -> None:
        sizes = {name: column.values.size for name, column in self.columns.items()}
        if len(set(sizes.values())) > 1:
            raise UndertowError(f"table {self.name}: columns have {sizes} rows; give every column the same rows")

    @property
    def rows(self) -> int:
        """Number of rows."""
        return next((column.values.size for column in self.columns.values()), 0)

    def at(self, row: int) -> dict[str, Condition]:
        """Conditions of one row."""
        return {**self.conditions, **{name: values[row] for name, values in self.row_conditions.items()}}

    def replaced(self, quantity: str, column: Column) -> PublishedTable:
        """The table with one column exchanged."""
        return replace(self, columns={**self.columns, quantity: column})


@dataclass(frozen=True)
class Constants:
    """What the laboratory states for all tables: mass kg, gravity, density, area m^2, and the submerged volume (m^3),
    a range where it is not printed. ``spring_key`` and ``water_key`` name the conditions that choose structure and
    water,
    ``dry`` the value of the water's condition in which there is none.
    """

    mass_kg: float
    area_m2: float
    volume_range_m3: tuple[float, float]
    spring_key: str
    water_key: str
    dry: Condition
    density_kg_per_m3: float = 1000.0
    gravity_m_per_s2: float = 9.81


def same_conditions(one: Mapping[str, Condition], other: Mapping[str, Condition], keys: Sequence[str]) -> bool:
    """Whether two rows stand under the same conditions, numbers within 1e-6.

    >>> same_conditions({"depth": 2.22}, {"depth": 2.2200000001}, ["depth"])
    True
    """
    for key in keys:
        a, b = one.get(key), other.get(key)
        if isinstance(a, float) and isinstance(b, float):
            if abs(a - b) > 1e-6:
                return False
        elif a != b:
            return False
    return True


def paired_rows(one: PublishedTable, other: PublishedTable, keys: Sequence[str]) -> list[tuple[int, int]]:
    """Rows of two tables that stand under the same conditions and, where both say it, at the same release.

    Releases count as equal within half a unit of the coarser table's last digit and 2 %.
    """
    found = []
    for i in range(one.rows):
        for j in range(other.rows):
            if not same_conditions(one.at(i), other.at(j), keys):
                continue
            a, b = one.columns.get("release"), other.columns.get("release")
            if a is not None and b is not None:
                reach = a.half_digits[i] + b.half_digits[j] + 0.02 * a.values[i]
                if abs(a.values[i] - b.values[j]) > reach:
                    continue
            found.append((i, j))
    return found


def dry_value(tables: Sequence[PublishedTable], constants: Constants, spring: Condition, quantity: str) -> Array:
    """All values of a structural quantity in the dry tables of one spring, (n,)."""
    found = [
        table.columns[quantity].values[row]
        for table in tables
        if quantity in table.columns and table.recipe == "envelope"
        for row in range(table.rows)
        if same_conditions(
            table.at(row), {constants.spring_key: spring, constants.water_key: constants.dry},
            (constants.spring_key, constants.water_key),
        )
    ]  # fmt: skip
    return np.array(found)
