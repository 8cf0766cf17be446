"""Published tables read from CSV files as a config maps them.

Belongs here: files, columns, units of headings. Does not belong here: what the numbers mean (discrepancy/audit).
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from undertow.campaign.audit_settings import AuditConfig, ColumnSettings
from undertow.discrepancy.audit.tables import QUANTITIES, Column, PublishedTable
from undertow.errors import ConfigError
from undertow.recording.recording import Condition
from undertow.recording.units import spelled


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
            return float(said.unit)
        unit, wanted = (_registry().Quantity(1.0, spelled(one, quantity)) for one in (said.unit, target))
        return float((unit / wanted).to("dimensionless").magnitude)
    except (pint.PintError, AttributeError, TypeError, ValueError) as error:
        raise ConfigError(
            f"tables.{name}.columns.{quantity}: unit {said.unit!r} is no {quantity}; write one that converts to "
            f"{target}"
        ) from error


def read_table(config: AuditConfig, name: str) -> PublishedTable:
    """One table of a config in SI by its printed units.

    Raises ConfigError where the file cannot be read, a column is missing, or a cell is no number.
    """
    said = config.tables[name]
    path = config.folder / said.file
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
    except OSError as error:
        raise ConfigError(f"tables.{name}: {path} cannot be read: {error.strerror}; check the path") from error
    if said.key:
        rows = [{row[said.key]: row[said.value] for row in rows}]
    columns = {quantity: _column(name, quantity, one, rows) for quantity, one in said.columns.items()}
    conditions = {key: tuple(_condition(_cell(name, key, key, row)) for row in rows) for key in said.row_conditions}
    return PublishedTable(name, said.title, columns, dict(said.conditions), conditions, said.recipe)


def _cell(name: str, quantity: str, column: str, row: Mapping[str, str]) -> str:
    if column not in row or row[column] is None:
        raise ConfigError(
            f"tables.{name}.columns.{quantity}: there is no column {column!r}; the file has {', '.join(map(str, row))}"
        )
    return row[column].strip()


def _column(name: str, quantity: str, said: ColumnSettings, rows: Sequence[Mapping[str, str]]) -> Column:
    factor = _factor(name, quantity, said)
    texts = [_cell(name, quantity, said.column, row) for row in rows]
    try:
        values = np.array([float(text) for text in texts])
    except ValueError as error:
        raise ConfigError(
            f"tables.{name}.columns.{quantity}: {texts} holds something that is no number; correct the file"
        ) from error
    if not np.all(np.isfinite(values)):
        raise ConfigError(f"tables.{name}.columns.{quantity}: {texts} holds a value that is not finite; leave it out")
    half = np.array([0.5 * 10.0 ** -len(text.partition(".")[2]) for text in texts])
    return Column(values * factor, half * factor, said.unit)


def _condition(text: str) -> Condition:
    try:
        return float(text)
    except ValueError:
        return text
