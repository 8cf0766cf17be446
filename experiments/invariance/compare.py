"""Two runs of one campaign in different units: the same statuses and names, and numbers that scale as their units say.

Belongs here: that comparison. Does not belong here: campaigns (campaigns.py), how they are rescaled (rescale.py).
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pint

from experiments.invariance.rescale import Scale

ALLOWED = 0.1
"""Largest difference of a number, in its standard errors."""

UNITS = pint.UnitRegistry()


@dataclass(frozen=True)
class Difference:
    """What differs between the campaign and its rescaled copy in one group."""

    group: str
    what: str


def powers(unit: str) -> tuple[float, float, float] | None:
    """Powers of time, length and mass in a unit; None for one that no registry knows (N (s/m)^p).

    >>> powers("N s^2/m^2"), powers("kg per kg"), powers("rad/s")
    ((0.0, -1.0, 1.0), (0.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    """
    try:
        found = UNITS.parse_units(unit.replace(" per ", "/").replace(" ", "*")).dimensionality
    except (pint.UndefinedUnitError, pint.DefinitionSyntaxError, ValueError, AttributeError, TypeError):
        return None
    return tuple(float(found.get(f"[{name}]", 0.0)) for name in ("time", "length", "mass"))  # type: ignore[return-value]


def differences(first: Path, second: Path, scale: Scale) -> list[Difference]:
    """What two run folders' verdict.json do not agree on, ``second`` in units larger by ``scale``."""
    groups = [json.loads((run / "verdict.json").read_text(encoding="utf-8"))["groups"] for run in (first, second)]
    ones, others = ({json.dumps(g["group"], sort_keys=True): g for g in found} for found in groups)
    out = [Difference(key, "is in one run only") for key in ones.keys() ^ others.keys()]
    for key in ones.keys() & others.keys():
        out += [Difference(key, what) for what in _of_group(ones[key], others[key], scale)]
    return out


def _of_group(one: Mapping[str, Any], other: Mapping[str, Any], scale: Scale) -> Iterator[str]:
    for name in ("status", "verdict", "alternatives"):
        if one[name] != other[name]:
            yield f"{name}: {one[name]} and {other[name]}"
            return
    for where, numbers, scaled in _numbers(one, other):
        far = _away(numbers, scaled, scale)
        if far > ALLOWED:
            said = f"{numbers['value']:.6g} and {scaled['value']:.6g} {numbers['unit']}"
            yield f"{where}: {far:.2g} standard errors ({said})"


def largest(first: Path, second: Path, scale: Scale) -> float:
    """The largest difference of a number between two runs, in its standard errors."""
    groups = [json.loads((run / "verdict.json").read_text(encoding="utf-8"))["groups"] for run in (first, second)]
    pairs = zip(*groups, strict=True)
    return max((_away(a, b, scale) for one, other in pairs for _, a, b in _numbers(one, other)), default=0.0)


def _numbers(one: Any, other: Any, where: str = "") -> Iterator[tuple[str, Mapping[str, Any], Mapping[str, Any]]]:
    """Every estimate that both hold at the same place."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        if {"value", "stderr", "unit"} <= one.keys():
            yield where, one, other
            return
        for key in one.keys() & other.keys() - {"group"}:
            yield from _numbers(one[key], other[key], f"{where}.{key}".lstrip("."))
    elif isinstance(one, list) and isinstance(other, list):
        for at, (a, b) in enumerate(zip(one, other, strict=False)):
            yield from _numbers(a, b, f"{where}[{at}]")


def _away(one: Mapping[str, Any], other: Mapping[str, Any], scale: Scale) -> float:
    """Difference in standard errors; 0 where a number has none, or a unit that cannot be scaled."""
    by = powers(one["unit"])
    known = by is not None and None not in (one["value"], other["value"], one["stderr"])
    if not known or not one["stderr"] > 0.0:
        return 0.0
    away = abs(other["value"] / scale.factor(by) - one["value"]) / one["stderr"]
    return away if math.isfinite(away) else math.inf
