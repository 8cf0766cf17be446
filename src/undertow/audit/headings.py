"""Headings: columns whose printed unit is off by a power of a thousand, found by an identity and mended.

Belongs here: units. Does not belong here: the identities and what else they find (identities.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from undertow.audit.identities import IDENTITIES, Identity, Oddity, dry_stiffness, identity_columns
from undertow.audit.recipes import Array
from undertow.audit.tables import WORDS, Constants, PublishedTable, same_conditions

POWER_OF_THOUSAND = 0.7
"""A ratio within this of a power of 1000, in decades, has a unit in it, and perhaps a constant factor besides."""


def correct_units(tables: Sequence[PublishedTable], constants: Constants) -> tuple[list[PublishedTable], list[Oddity]]:
    """Tables with units mended where an identity is off by a power of a thousand, and what was mended.

    Stiffness is judged first: other identities use it. The mended column is the identity's left side.
    """
    mended, found = list(tables), []
    for identity in IDENTITIES:
        for i, table in enumerate(mended):
            if identity.left not in table.columns:
                continue
            columns = identity_columns(table, mended, constants, identity) or _largest_release(
                table, mended, constants, identity
            )
            if columns is None:
                continue
            left = table.columns[identity.left]
            right = identity.law(columns)
            rows = np.arange(left.values.size) if right.size == left.values.size else [int(np.argmax(left.values))]
            ratio = float(np.median(left.values[rows] / right))
            power = math.log10(ratio) / 3.0 if ratio > 0.0 else 0.0
            if round(power) == 0 or abs(power - round(power)) * 3.0 > POWER_OF_THOUSAND:
                continue
            factor = 1000.0 ** -round(power)
            mended[i] = table.replaced(identity.left, left.times(factor))
            value, rule = float(left.values[rows][0]), float(right[0])
            found.append(Oddity(
                "unit", (table.name,), identity.left, value, rule, "",
                f"{table.title}: {WORDS[identity.left]} is headed {left.printed_unit}, but its numbers are "
                f"{ratio:.4g} times {identity.text} ({value:.5g} printed against {rule:.5g} by the rule, SI): "
                f"the unit is {1.0 / factor:g} times smaller; it is read so from here on.",
            ))  # fmt: skip
    return mended, found


def _largest_release(
    table: PublishedTable, tables: Sequence[PublishedTable], constants: Constants, identity: Identity
) -> dict[str, Array] | None:
    """Inputs for the largest energy alone, from the largest release that any table has under the same conditions."""
    if identity.left != "energy" or "release" in table.columns:
        return None
    known = dry_stiffness(table, tables, constants)
    keys = (constants.spring_key, constants.water_key)
    releases = [
        float(other.columns["release"].values[row])
        for other in tables
        if "release" in other.columns
        for row in range(other.rows)
        if same_conditions(table.at(0), other.at(row), keys)
    ]
    if known is None or not releases:
        return None
    return {"stiffness": known[:1], "release": np.array([max(releases)])}
