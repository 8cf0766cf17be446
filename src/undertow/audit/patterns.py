"""Consistency within one column: what should be constant, what should scatter, what stands on a bound.

A structural constant printed trial by trial may be one mean, two groups, or a drift with the release; the three are
compared by BIC. A measured coefficient that follows a power of the release more closely than its digits and any
repetition allow was computed, not measured.

Belongs here: patterns of single columns. Does not belong here: identities (identities.py), other tables
(comparisons.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from undertow.audit.identities import Oddity
from undertow.audit.recipes import Array
from undertow.audit.tables import ADDED_MASS, QUANTITIES, WORDS, Constants, PublishedTable

STRUCTURAL = ("stiffness", "damping", "friction_coefficient")
"""Columns that belong to the structure alone: one number, scattering."""

STRONG = 10.0
"""Difference of BIC that counts as very strong (Kass and Raftery 1995, doi:10.1080/01621459.1995.10476572)."""

FEWEST_ROWS = 6
"""Rows below which no pattern is read into a column."""

SMOOTH = 0.015
"""Root-mean-square departure from a power law below which a column is no measurement: releases repeat within 2-3 %."""

RANGE = 2.0
"""A power law is only judged over at least this ratio of releases."""


@dataclass(frozen=True)
class PowerLaw:
    """``value = scale * release ** exponent``: exponent with its standard error and 95 % half-width, departure (rms of
    the logarithm), number of rows."""

    exponent: float
    stderr: float
    half_width_95: float
    departure: float
    rows: int


def power_law(release: Array, values: Array) -> PowerLaw:
    """Least squares of ln(values) on ln(release), both (n,) and positive.

    >>> law = power_law(np.array([1.0, 2.0, 4.0]), np.array([8.0, 4.0, 2.0]))
    >>> round(law.exponent, 6), law.departure < 1e-12
    (-1.0, True)
    """
    x = np.log(release) - np.mean(np.log(release))
    y = np.log(values) - np.mean(np.log(values))
    slope = float(x @ y / (x @ x))
    residual = y - slope * x
    spare = max(x.size - 2, 1)
    error = math.sqrt(float(residual @ residual) / spare / float(x @ x))
    width = float(student.ppf(0.975, spare)) * error
    return PowerLaw(slope, error, width, math.sqrt(float(residual @ residual) / x.size), int(x.size))


def check_patterns(tables: Sequence[PublishedTable], constants: Constants) -> list[Oddity]:
    """Groups and drifts of structural columns, computed-looking columns, bounds."""
    found = []
    for table in tables:
        release = table.columns.get("release")
        for name in STRUCTURAL:
            if release is not None and name in table.columns and table.rows >= FEWEST_ROWS:
                oddity = _constant(table, name, release.values)
                found += [oddity] if oddity else []
        if "drag_coefficient" in table.columns and release is not None:
            oddity = _too_smooth(table, release.values)
            found += [oddity] if oddity else []
        found += _on_bound(table, constants)
    return found


def _constant(table: PublishedTable, name: str, release: Array) -> Oddity | None:
    order = np.argsort(release)
    x, y = release[order], table.columns[name].values[order]
    n = y.size
    one = n * math.log(float(np.sum((y - y.mean()) ** 2)))
    splits = {
        i: float(np.sum((y[:i] - y[:i].mean()) ** 2) + np.sum((y[i:] - y[i:].mean()) ** 2)) for i in range(2, n - 1)
    }
    at = min(splits, key=splits.__getitem__)
    # two means and the place of the split against one mean
    two = n * math.log(splits[at]) + 2.0 * math.log(n)
    line = np.polyfit(x, y, 1)
    drift = n * math.log(float(np.sum((y - np.polyval(line, x)) ** 2))) + math.log(n)
    if one - min(two, drift) < STRONG:
        return None
    unit = QUANTITIES[name]
    if two < drift:
        low, high = float(y[:at].mean()), float(y[at:].mean())
        return Oddity(
            "two groups", (table.name,), name, high, low, unit,
            f"{table.title}: {WORDS[name]} is two groups, {low:.4g} {unit} up to a release of {x[at - 1]:.4g} m and "
            f"{high:.4g} {unit} from {x[at]:.4g} m on, not scatter about {y.mean():.4g} {unit} (BIC {one - two:.0f}).",
        )  # fmt: skip
    ends = np.polyval(line, x[[0, -1]])
    beside = _flat_load(table, x[0], x[-1])
    return Oddity(
        "drift", (table.name,), name, float(ends[1]), float(ends[0]), unit,
        f"{table.title}: {WORDS[name]} rises with the release from {ends[0]:.6g} to {ends[1]:.6g} {unit} "
        f"({100.0 * (y[-1] / y[0] - 1.0):+.1f} % from the smallest to the largest release; BIC "
        f"{one - drift:.0f}).{beside}"
        if ends[1] > ends[0] else
        f"{table.title}: {WORDS[name]} falls with the release from {ends[0]:.6g} to {ends[1]:.6g} {unit} "
        f"(BIC {one - drift:.0f}).{beside}",
    )  # fmt: skip


def _flat_load(table: PublishedTable, smallest: float, largest: float) -> str:
    if "load" not in table.columns:
        return ""
    static = table.columns["load"].values / table.columns["release"].values
    return (
        f" Load over release is {static.mean():.6g} +- {static.std(ddof=1):.2g} N/m between {smallest:.3g} and "
        f"{largest:.3g} m, so that it is not the spring."
    )


def _too_smooth(table: PublishedTable, release: Array) -> Oddity | None:
    values = table.columns["drag_coefficient"].values
    if values.size < FEWEST_ROWS or np.any(values <= 0.0) or release.max() / release.min() < RANGE:
        return None
    law = power_law(release, values)
    if law.departure > SMOOTH:
        return None
    speed = ""
    if "velocity" in table.columns and "drag_force" in table.columns:
        force = power_law(table.columns["velocity"].values, table.columns["drag_force"].values)
        speed = f" The drag force of the same table goes with the velocity to the power {force.exponent:.3f}."
    return Oddity(
        "too smooth", (table.name,), "drag_coefficient", law.departure, SMOOTH, "1",
        f"{table.title}: drag coefficient follows the release to the power {law.exponent:.2f} within "
        f"{100.0 * law.departure:.2g} % (measurements depart by more than {100.0 * SMOOTH:.2g} %): it looks computed "
        f"from a curve, not measured.{speed}",
    )  # fmt: skip


def _on_bound(table: PublishedTable, constants: Constants) -> list[Oddity]:
    if ADDED_MASS not in table.columns or table.recipe != "method1":
        return []
    return [
        Oddity(
            "on its bound", (table.name,), ADDED_MASS, 0.0, math.nan, "kg",
            f"{table.title}: added mass is exactly 0 kg at {constants.water_key} = "
            f"{table.at(int(row)).get(constants.water_key)}: "
            "the search was stopped there, the print is an upper limit of what it wanted.",
        )
        for row in np.flatnonzero(table.columns[ADDED_MASS].values == 0.0)
    ]  # fmt: skip
