"""Consistency between tables: the same quantity printed twice, the same water on another spring, releases stated twice.

Belongs here: comparisons of columns of different tables. Does not belong here: laws (identities.py, forces.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from undertow.audit.identities import NOTICEABLE, Oddity
from undertow.audit.tables import ADDED_MASS, QUANTITIES, WORDS, Constants, PublishedTable, paired_rows, same_conditions

COEFFICIENTS = (ADDED_MASS, "drag_coefficient")
REPEATED = 0.15
"""Coefficients of the same trial by two recipes differ by less than this where nothing is wrong: Method 2 on Eq. 15 is
5 to 16 % off in added mass (docs/methods.md)."""


def check_comparisons(tables: Sequence[PublishedTable], constants: Constants) -> list[Oddity]:
    """Every pair of tables: same conditions, same water on other springs, releases of the same trials."""
    found = []
    for one, other in combinations(tables, 2):
        for name in COEFFICIENTS:
            if name in one.columns and name in other.columns:
                found += _same_quantity(one, other, name, constants)
        if ADDED_MASS in one.columns and ADDED_MASS in other.columns:
            found += _other_spring(one, other, constants)
        found += _releases(one, other, constants)
    return found


def _same_quantity(one: PublishedTable, other: PublishedTable, name: str, constants: Constants) -> list[Oddity]:
    keys = (constants.spring_key, constants.water_key)
    pairs = paired_rows(one, other, keys)
    lacking = [table for table in (one, other) if "release" not in table.columns]
    if not pairs or any(table.rows > 1 for table in lacking):  # rows without releases are no single trials
        return []
    odd = []
    for i, j in pairs:
        a, b = float(one.columns[name].values[i]), float(other.columns[name].values[j])
        if a <= 0.0 or b <= 0.0:
            continue
        digits = one.columns[name].half_digits[i] / a + other.columns[name].half_digits[j] / b
        if abs(math.log(a / b)) > REPEATED + digits:
            odd.append((abs(math.log(a / b)), a, b))
    if not odd:
        return []
    _, a, b = max(odd)
    unit = "" if QUANTITIES[name] == "1" else f" {QUANTITIES[name]}"
    return [Oddity(
        "same quantity", (one.name, other.name), name, b, a, QUANTITIES[name],
        f"{one.title} and {other.title}: the same {WORDS[name]} is {a:.5g}{unit} in one and {b:.5g}{unit} in the other "
        f"({len(odd)} of {len(pairs)} common rows differ by more than {100.0 * REPEATED:.0f} %; this one the most).",
    )]  # fmt: skip


def _other_spring(one: PublishedTable, other: PublishedTable, constants: Constants) -> list[Oddity]:
    """One water cannot have two rigid added masses: rows of one recipe that differ in the spring alone."""
    if one.recipe != other.recipe or one.recipe != "method1":
        return []
    differing = []
    for i, j in paired_rows_of_water(one, other, constants):
        a, b = float(one.columns[ADDED_MASS].values[i]), float(other.columns[ADDED_MASS].values[j])
        if abs(a - b) > REPEATED * max(a, b):
            differing.append(f"{a:.4g} and {b:.4g} kg at {constants.water_key} = {one.at(i)[constants.water_key]}")
    if not differing:
        return []
    i, j = paired_rows_of_water(one, other, constants)[0]
    return [Oddity(
        "same water", (one.name, other.name), ADDED_MASS, float(other.columns[ADDED_MASS].values[j]),
        float(one.columns[ADDED_MASS].values[i]), "kg",
        f"{one.title} and {other.title}: the same water has added masses of {'; '.join(differing)} on the two springs: "
        "no one rigid added mass.",
    )]  # fmt: skip


def paired_rows_of_water(one: PublishedTable, other: PublishedTable, constants: Constants) -> list[tuple[int, int]]:
    """Rows of two tables in the same water and on different springs, where both tables go by water."""
    spring, water = constants.spring_key, constants.water_key
    if water not in one.row_conditions or water not in other.row_conditions:
        return []
    return [
        (i, j)
        for i in range(one.rows)
        for j in range(other.rows)
        if same_conditions(one.at(i), other.at(j), (water,)) and one.at(i).get(spring) != other.at(j).get(spring)
    ]


def _releases(one: PublishedTable, other: PublishedTable, constants: Constants) -> list[Oddity]:
    """A list of releases alone (figure captions) against the largest releases of a table of the same conditions."""
    for table, full in ((one, other), (other, one)):
        if set(table.columns) != {"release"} or len(full.columns) < 2 or "release" not in full.columns:
            continue
        if table.rows > full.rows or full.row_conditions:
            continue
        if not same_conditions(table.at(0), full.at(0), (constants.spring_key, constants.water_key)):
            continue
        said, known = _aligned(table.columns["release"].values, np.sort(full.columns["release"].values))
        return _judge_releases(table, full, said, known)
    return []


def _aligned(said: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The run of known releases, in order, that lies closest to those said (slips of the point put right)."""
    best = (math.inf, known[: said.size])
    for start in range(known.size - said.size + 1):
        part = known[start : start + said.size]
        ratio = np.log10(said / part)
        misfit = float(np.sum(np.abs(ratio - np.round(ratio))))
        if misfit < best[0]:
            best = (misfit, part)
    return said, best[1]


def _judge_releases(table: PublishedTable, full: PublishedTable, said: np.ndarray, known: np.ndarray) -> list[Oddity]:
    found = []
    decades = np.round(np.log10(said / known))
    for i in np.flatnonzero(decades):
        found.append(Oddity(
            "slip of the point", (table.name, full.name), "release", float(said[i]), float(known[i]), "m",
            f"{table.title}: a release of {said[i]:.4g} m stands where {full.title} has {known[i]:.4g} m: a slip of "
            f"the decimal point ({said[i] / 10.0 ** decades[i]:.4g} m is meant).",
        ))  # fmt: skip
    ratio = said / 10.0**decades / known
    middle = float(np.median(ratio))
    if abs(middle - 1.0) > NOTICEABLE and float(np.std(ratio)) < NOTICEABLE:
        implied = ""
        if "stiffness" in full.columns and "load" in full.columns:
            order = np.argsort(full.columns["release"].values)[-said.size :]
            load = full.columns["load"].values[order]
            stiffness = float(np.median(load / (said / 10.0**decades)))
            printed = float(np.mean(full.columns["stiffness"].values))
            implied = (
                f" With these releases load over release is {stiffness:.4g} N/m, not the {printed:.4g} N/m printed."
            )
        found.append(Oddity(
            "releases stated twice", (table.name, full.name), "release", float(said[-1]), float(known[-1]), "m",
            f"{table.title}: releases are {middle:.3f} times those of {full.title} throughout "
            f"({said[-1] / 10.0 ** decades[-1]:.4g} m against {known[-1]:.4g} m).{implied}",
        ))  # fmt: skip
    return found
