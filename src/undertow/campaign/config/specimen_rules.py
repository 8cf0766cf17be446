"""What a specimen cannot be: no mass, a negative area, lighter than the water it displaces.

Belongs here: `unphysical` for the numbers a config has, `impossible` for what follows from them under the trials'
conditions, `check_level` for a level that a table leaves out. Does not belong here: names that match nothing
(matching.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from undertow.campaign.config.settings import Quantity, Table
from undertow.campaign.config.situations import Situation, listed
from undertow.campaign.config.source import Location, Wrong
from undertow.errors import ConfigError
from undertow.quantities import LARGEST_SCATTER
from undertow.recording.channels import LARGEST
from undertow.recording.conditions import number, same_condition, written
from undertow.recording.recording import Condition

if TYPE_CHECKING:
    from undertow.campaign.config.run_config import RunConfig

UNITS: Mapping[str, tuple[str, str]] = {
    "mass_kg": ("kg", "kg m^2"),
    "stiffness_N_per_m": ("N/m", "N m/rad"),
    "area_m2": ("m^2", "m^2"),
    "submerged_volume_m3": ("m^3", "m^3"),
    "cell.surface_width_m": ("m", "m"),
    "cell.depth_m": ("m", "m"),
    "cell.length_m": ("m", "m"),
}
"""Quantities that may go by a condition, with their units in translation and in rotation."""

PUBLISHED = "published."
"""How the names of published values begin: nothing follows from them, and they may have any size."""

MAY_BE_ZERO = frozenset({"area_m2", "submerged_volume_m3"})
"""What is 0 where there is no water; everything else is larger than 0."""

@dataclass(frozen=True)
class Constant:
    """A constant of the surroundings: its ``unit``, the ``usual`` span that raises no doubt (``usual_of``: of
    what), the ``possible`` one (and in words what lies ``outside``), the ``slip`` that is made with it, and what makes
    an unusual number right, ``unless``."""

    unit: str
    usual: tuple[float, float]
    usual_of: str
    possible: tuple[float, float]
    outside: str
    slip: str
    unless: str


CONSTANTS: Mapping[str, Constant] = {
    "gravity_m_per_s2": Constant(
        "m/s^2", (9.7, 9.9), "on Earth", (1.5, 2000.0), "less than the Moon's or more than a centrifuge's",
        "1 g is 9.81", "the rig is inclined, in a centrifuge or elsewhere",
    ),
    "water_density_kg_per_m3": Constant(
        "kg/m^3", (950.0, 1100.0), "in laboratories and at sea", (50.0, 20000.0), "no liquid's", "1 g/cm^3 is 1000",
        "it is another liquid",
    ),
}  # fmt: skip
"""Gravity from the equator on a mountain to the poles and somewhat more, at all from just below the Moon's 1.62 to
200 g; density from hot water to brine of the sea and somewhat more, at all from liquid hydrogen to beyond mercury."""

BY_LEVEL = ("mass_kg", "area_m2", "submerged_volume_m3")
"""Quantities without which a wet level cannot be identified as the others are, where a table gives it to those."""


def quantities(config: RunConfig) -> dict[str, Quantity]:
    """Every number or table of the specimen that the config has, by its name below ``specimen``."""
    known = config.specimen
    found: dict[str, Quantity | None] = {
        name: getattr(known.cell, name.removeprefix("cell."), None) if "." in name else getattr(known, name)
        for name in UNITS
    }
    found |= {f"{PUBLISHED}{name}": quantity for name, quantity in known.published.items()}
    return {name: quantity for name, quantity in found.items() if quantity is not None}


def tables(config: RunConfig) -> dict[str, Table]:
    """The tables among the specimen's quantities."""
    return {name: one for name, one in quantities(config).items() if isinstance(one, Table)}


def location(name: str, *below: str) -> Location:
    """Where a quantity (or a key of its table) stands in the config."""
    return ("specimen", *name.split("."), *below)


def unphysical(config: RunConfig) -> Iterator[Wrong]:
    """Where and what is wrong in the numbers of the specimen as they are written."""
    yield from _scattered(config)
    yield from _otherworldly(config)
    for name, quantity in quantities(config).items():
        if not isinstance(quantity, Table):
            if said := _refused(config, name, quantity, zero=False):
                yield location(name), said
            continue
        for key, value in quantity.values.items():
            if said := _refused(config, name, value, zero=True, where=f" for {quantity.by} {key}"):
                yield location(name, key), said
        for at, key in enumerate(quantity.values):
            for first in list(quantity.values)[:at]:
                if same_condition(first, key):
                    text = f"specimen.{name} has {first} and {key}, which are the same number; drop one"
                    yield location(name, key), text


def _scattered(config: RunConfig) -> Iterator[Wrong]:
    """A scatter from trial to trial that was meant in per cent."""
    for name, share in ({} if config.specimen.scatter is None else config.specimen.scatter.model_dump()).items():
        if share > LARGEST_SCATTER:
            yield location("scatter", name), (
                f"specimen.scatter.{name} is {share:g}, relative, and is {LARGEST_SCATTER:g} at most: {share:g} % is "
                f"{share / 100.0:g}"
            )


def _otherworldly(config: RunConfig) -> Iterator[Wrong]:
    """A gravity or density that no laboratory has, as one counted in g or in g/cm^3."""
    for name, known in CONSTANTS.items():
        value, (least, most) = getattr(config.specimen, name), known.possible
        if not least <= value <= most:
            yield location(name), (
                f"specimen.{name} is {value:g} {known.unit}, {known.outside} ({least:g} to {most:g}); {known.slip}: "
                "correct it, or leave it out"
            )


def strange_constants(config: RunConfig) -> tuple[str, ...]:
    """The doubts about a gravity that is not the Earth's and a density that is not water's, which some rigs have and
    most do not."""
    return tuple(
        f"specimen.{name} is {value:g} {known.unit}, and {known.usual[0]:g} to {known.usual[1]:g} {known.usual_of}: "
        f"correct it, unless {known.unless}"
        for name, known in CONSTANTS.items()
        if not known.usual[0] <= (value := getattr(config.specimen, name)) <= known.usual[1]
    )


def impossible(config: RunConfig, here: Iterable[Situation]) -> list[Wrong]:
    """Where and what is wrong with the specimen under conditions that occur (those that lack none), each key once."""
    wrong: dict[Location, str] = {}
    for one in here:
        for where, text in _of_conditions(config, one):
            wrong.setdefault(where, text)
    return list(wrong.items())


def check_level(config: RunConfig, conditions: Mapping[str, Condition]) -> None:
    """Refuse a wet level that a table leaves out: its group alone cannot be identified.

    Raises ConfigError with the table, the level, what the table has.
    """
    if config.is_dry(conditions):
        return
    for name, table in tables(config).items():
        if name not in BY_LEVEL or not table.values or table.by not in conditions:
            continue
        here = conditions[table.by]
        if table.key_of(here) is None:
            raise ConfigError(
                f"specimen.{name} has no value for {table.by} {written(here)}, it has {listed(list(table.values))}; "
                f"add it to the table ({config.place(location(name))}), or say in trials.dry that these trials are dry"
            )


def _of_conditions(config: RunConfig, one: Situation) -> Iterator[Wrong]:
    conditions, dry = one.conditions, config.is_dry(one.conditions)
    for name, table in tables(config).items():
        here = conditions[table.by]
        if table.values:
            key = table.key_of(here)
            if name == "area_m2" and not dry and key is not None and table.values[key] == 0.0:
                said = f"specimen.{name} is 0 m^2 for {one.at([table.by])}, which trials.dry does not call dry; "
                yield location(name, key), said + "give its area, or say that it is dry"
            if name == "submerged_volume_m3" and dry and key is not None and table.values[key] > 0.0:
                said = f"specimen.{name} is {table.values[key]:.6g} m^3 for {one.at([table.by])}, which trials.dry "
                yield location(name, key), said + "calls dry, and a dry body displaces no water; correct one of the two"
        elif (value := number(here)) is None:
            yield location(name), (
                f"specimen.{name} is the condition {table.by!r} itself, which is {here!r} in trial {one.trials[0]}, no "
                "number; correct the index"
            )
        elif said := _refused(config, name, value, zero=dry, where=f" in trial {one.trials[0]}"):
            yield location(name), said
    yield from _floats(config, one)


def _floats(config: RunConfig, one: Situation) -> Iterator[Wrong]:
    """That the water carries more than the body weighs. In a rotation the mass is an inertia, and nothing is said."""
    if config.equation.coordinate == "rotation":
        return
    known = config.specimen
    for name, table in tables(config).items():
        if name in ("mass_kg", "submerged_volume_m3") and not table.values and number(one.conditions[table.by]) is None:
            return
    specimen = config.specimen_for(one.conditions)
    gravity = specimen.gravity_m_per_s2
    weight = specimen.mass_kg * gravity
    buoyancy = specimen.submerged_volume_m3 * specimen.water_density_kg_per_m3 * gravity
    if not (math.isfinite(weight) and weight > 0.0 and buoyancy >= weight):
        return
    by = [q.by for q in (known.submerged_volume_m3, known.mass_kg) if isinstance(q, Table)]
    volume = known.submerged_volume_m3
    key = volume.key_of(one.conditions[volume.by]) if isinstance(volume, Table) else None
    where = f" for {one.at(by)}" if by else ""
    yield location("submerged_volume_m3", *([key] if key is not None else [])), (
        f"specimen.submerged_volume_m3 is {specimen.submerged_volume_m3:.6g} m^3{where}: its buoyancy of "
        f"{buoyancy:.6g} N must be smaller than the weight of {weight:.6g} N ({specimen.mass_kg:.6g} kg); correct "
        "volume, mass or density, or leave the volume out where nothing rests on rails"
    )


def _refused(config: RunConfig, name: str, value: float, zero: bool, where: str = "") -> str:
    """The sentence for a number that this quantity cannot have; empty where it can. ``zero``: it may be a dry one."""
    if name.startswith(PUBLISHED):
        return ""
    may_be_zero = name in MAY_BE_ZERO and (zero or name != "area_m2")
    if 1.0 / LARGEST < value < LARGEST or (value == 0.0 and may_be_zero):
        return ""
    unit = UNITS[name][config.equation.coordinate == "rotation"]
    if value > 0.0:
        return (
            f"specimen.{name} is {value:.6g} {unit}{where}, which nothing has; correct it, or leave it out where it is "
            "not known"
        )
    rule = "must not be negative" if may_be_zero else "must be larger than 0"
    advice = ": dry trials have 0 by themselves" if name == "area_m2" and value == 0.0 else " where it is not known"
    return f"specimen.{name} is {value:.6g} {unit}{where} but {rule}; correct it, or leave it out{advice}"
