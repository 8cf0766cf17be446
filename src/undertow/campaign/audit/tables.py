"""Published tables read from CSV files as a config maps them.

Belongs here: files, columns, units of headings. Does not belong here: what the numbers mean (audit).
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from undertow.audit.tables import ADDED_MASS, QUANTITIES, Column, PublishedTable
from undertow.campaign.audit.settings import AuditConfig, ColumnSettings
from undertow.errors import ConfigError
from undertow.recording.recording import Condition
from undertow.recording.units import spelled

LARGEST = 1e12
"""Largest value of any quantity in its SI unit that is read: a stiffness of 1e12 N/m is a mountain's."""

ANY_SIGN = (
    ADDED_MASS, "drag_coefficient", "damping", "damping_ratio", "friction_coefficient", "drag_force", "inertia_force",
    "water_in_cells",
)  # fmt: skip
"""Quantities that may be zero or negative in print; releases, stiffnesses, masses, energies and the like may not."""


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


def _factor(name: str, quantity: str, said: ColumnSettings) -> float:
    """What one printed unit is in SI; ConfigError where it is not known or has another dimension."""
    import pint

    target = QUANTITIES[quantity]
    try:
        if target == "1":
            factor = float(said.unit)
        else:
            unit, wanted = (_registry().Quantity(1.0, spelled(one, quantity)) for one in (said.unit, target))
            factor = float((unit / wanted).to("dimensionless").magnitude)
        if not 0.0 < factor < LARGEST:
            raise ValueError(factor)
        return factor
    except (pint.PintError, AttributeError, TypeError, ValueError) as error:
        raise ConfigError(
            f"tables.{name}.columns.{quantity}: unit {said.unit!r} is no {quantity}; write one that converts to "
            f"{target}"
        ) from error


def read_table(config: AuditConfig, name: str) -> PublishedTable:
    """One table of a config in SI by its printed units.

    Raises ConfigError where the file cannot be read, has no rows, a column is missing, or a cell is no number that the
    quantity can have.
    """
    said = config.tables[name]
    rows = _rows(config.folder / said.file, name)
    if said.key:
        rows = [{_cell(name, "key", said.key, row): _cell(name, "value", said.value, row) for row in rows}]
    columns = {quantity: _column(name, quantity, one, rows) for quantity, one in said.columns.items()}
    conditions = {key: tuple(_condition(_cell(name, key, key, row)) for row in rows) for key in said.row_conditions}
    return PublishedTable(name, said.title, columns, dict(said.conditions), conditions, said.recipe)


def _rows(path: Path, name: str) -> list[dict[str, str]]:
    """Rows of a CSV file by the names of its columns, all of them as long as its header."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            lines = [line for line in csv.reader(stream) if line]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no CSV in UTF-8"
        raise ConfigError(f"tables.{name}: {path} cannot be read: {reason}; check the path") from error
    if len(lines) < 2:
        raise ConfigError(
            f"tables.{name}: {path} has {max(len(lines) - 1, 0)} rows below its header; a table needs one"
        )
    header = [one.strip() for one in lines[0]]
    for number, line in enumerate(lines[1:], start=1):
        if len(line) != len(header):
            raise ConfigError(
                f"tables.{name}: row {number} of {path.name} has {len(line)} cells and its header {len(header)}; "
                "give each row one cell a column"
            )
    if len(set(header)) < len(header):
        raise ConfigError(f"tables.{name}: the header of {path.name} repeats a name: {', '.join(header)}; rename one")
    return [dict(zip(header, line, strict=True)) for line in lines[1:]]


def _cell(name: str, quantity: str, column: str, row: Mapping[str, str]) -> str:
    if column not in row:
        raise ConfigError(
            f"tables.{name}.columns.{quantity}: there is no column {column!r}; the file has {', '.join(row)}"
        )
    return row[column].strip()


def _column(name: str, quantity: str, said: ColumnSettings, rows: Sequence[Mapping[str, str]]) -> Column:
    factor = _factor(name, quantity, said)
    texts = [_cell(name, quantity, said.column, row) for row in rows]
    for number, text in enumerate(texts, start=1):
        try:
            value = float(text)
        except ValueError as error:
            raise ConfigError(
                f"tables.{name}.columns.{quantity}: row {number} holds {text!r}, which is no number; correct the file"
            ) from error
        if not abs(value * factor) <= LARGEST:
            raise ConfigError(
                f"tables.{name}.columns.{quantity}: row {number} holds {text!r}, which is not finite or beyond "
                f"{LARGEST:g} {QUANTITIES[quantity]}; leave the row out"
            )
        if quantity not in ANY_SIGN and not value * factor > 0.0:
            raise ConfigError(
                f"tables.{name}.columns.{quantity}: row {number} is {text} {said.unit}; it must be positive, leave the "
                "row out or correct it"
            )
    half = np.array([0.5 * 10.0 ** -len(text.partition(".")[2]) for text in texts])
    return Column(np.array([float(text) for text in texts]) * factor, half * abs(factor), said.unit)


def _condition(text: str) -> Condition:
    try:
        return float(text)
    except ValueError:
        return text
