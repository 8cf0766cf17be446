"""Which column of a table holds which quantity, and in which unit: as said, or as the table's own names say.

Belongs here: columns and units of one table. Does not belong here: files (reading.py), guesses from names
(recording/propose.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from undertow.errors import RecordingError, shown
from undertow.recording.catalogue import ChannelSpec, TimeSpec
from undertow.recording.layout import Column
from undertow.recording.propose import (
    counts_rows,
    name_and_unit,
    propose_mapping,
    step_in_doubt,
    strange_unit,
    two_without_names,
)
from undertow.recording.recording import CHANNELS, Array, Coordinate
from undertow.recording.stacked import stacked
from undertow.recording.stamps import is_stamp
from undertow.recording.text import is_number
from undertow.recording.units import KNOWN, factor_to_si, is_unit_of, si_unit

Columns = Mapping[str, Column | Sequence[Column]]
"""Quantity (displacement, acceleration, spring_force, ..., time) -> its column, or several that are summed."""

Units = Mapping[str, str]
"""Column or quantity -> its unit as the laboratory writes it."""

COLUMNS_SHOWN = 12
"""Columns named in a message at most."""


@dataclass(frozen=True)
class Mapped:
    """What a table's columns mean: ``time``, ``channels`` and the coordinate that their units speak of."""

    time: TimeSpec
    channels: Mapping[str, ChannelSpec]
    coordinate: Coordinate


def mapped(
    table: pd.DataFrame,
    columns: Columns | None,
    units: Units | None,
    rate_hz: float | None = None,
    coordinate: Coordinate | None = None,
) -> Mapped:
    """Columns and units of a table, as said in ``columns`` and ``units`` or as its own names and unit row say.

    Time is in seconds where nobody says otherwise and that is at least one sample a second; every other unit must be
    said, in ``units`` or in the table.

    Raises RecordingError where a named column is missing, no column or several look like a channel, or a unit is not
    said.

    >>> table = pd.DataFrame({"t": [0.0, 0.1], "x": [1.0, 0.9]})
    >>> mapped(table, None, {"x": "mm"}).channels["displacement"].unit
    'mm'
    """
    if isinstance(table.columns, pd.MultiIndex):
        raise RecordingError(
            f"the table has {table.columns.nlevels} rows of names, as {table.columns[-1]!r}; make one of them, as in "
            'table.columns = [f"{name} [{unit}]" for name, unit in table.columns]'
        )
    if not table.columns.is_unique:
        twice = table.columns[table.columns.duplicated()][0]
        raise RecordingError(f"the table has {(table.columns == twice).sum()} columns {twice!r}; rename all but one")
    _must_map("columns", columns, '{"time": "t", "displacement": "x"}')
    _must_map("units", units, '{"x": "mm"}')
    for name, unit in (units or {}).items():
        if not (unit is None or isinstance(unit, str)):
            raise RecordingError(f"units says that {name!r} is in {shown(unit)}; give the unit's name, as in \"mm\"")
    said = _said(table, units or {})
    if columns is None:
        chosen, time = _guessed(table, said, rate_hz)
    else:
        chosen, time = _named(table, columns, rate_hz)
    if time is not None and rate_hz is None and (several := stacked(table, time, in_python=True)):
        raise RecordingError(f"the table {several}")
    wanted = {quantity: _unit(quantity, names, said, units or {}) for quantity, names in chosen.items()}
    turned = coordinate or _coordinate(wanted)
    if columns is None:
        for quantity, names in _hollow(table, said, chosen).items():
            chosen[quantity] = names
            wanted[quantity] = (units or {}).get(quantity) or said.get(names[0]) or si_unit(quantity, turned)
    for quantity, unit in wanted.items():
        factor_to_si(unit, quantity, turned)
    channels = {quantity: ChannelSpec(names, wanted[quantity]) for quantity, names in chosen.items()}
    if rate_hz is not None:
        return Mapped(TimeSpec(rate_hz=rate_hz), channels, turned)
    unit = (units or {}).get("time", said.get(time, "") if time is not None else "")
    if time is not None and not unit and (step := step_in_doubt(pd.Series(_numbers(table, time)))):
        raise RecordingError(
            f"time (column {time!r}) has no unit, and in seconds there would be a sample every {step:g} s; say it, as "
            f"in units={{{str(time)!r}: \"ms\"}} or \"s\""
        )
    return Mapped(TimeSpec(time, unit or "s"), channels, turned)


def numbers_of(table: pd.DataFrame, means: Mapped) -> pd.DataFrame:
    """The columns that hold time and channels, as numbers, NaN where a value is missing.

    Raises RecordingError where one holds what is no number.
    """
    timed = () if means.time.column is None else (means.time.column,)
    wanted = dict.fromkeys((*timed, *(column for spec in means.channels.values() for column in spec.columns)))
    found = pd.DataFrame({column: _numbers(table, column) for column in wanted})
    found.attrs = table.attrs
    return found


def _must_map(name: str, given: object, example: str) -> None:
    """RecordingError where what is said of columns is no mapping."""
    if not (given is None or isinstance(given, Mapping)):
        raise RecordingError(f"{name} is {given!r}; give a mapping, as in {name}={example}")


def _numbers(table: pd.DataFrame, column: Column) -> Array:
    """A column's values; RecordingError with the first that is none and its row."""
    if pd.api.types.is_bool_dtype(table[column]):
        raise RecordingError(f"column {column!r} holds truth values, and no numbers; give what the sensor said")
    if np.iscomplexobj(table[column]):
        raise RecordingError(f"column {column!r} holds complex numbers; give real part, absolute value or angle")
    try:
        values: Array = table[column].to_numpy(dtype=np.float64, na_value=np.nan)
    except (TypeError, ValueError) as error:
        raise RecordingError(f"column {column!r} holds what is no number, {_first_text(table[column])}") from error
    return values


def _first_text(cells: pd.Series) -> str:
    """The first cell that is no number, its row, and what to do."""
    wrong = (_converted(cells).isna() & cells.notna()).to_numpy()
    at = int(wrong.argmax())
    cell = cells.iloc[at]
    comma = isinstance(cell, str) and is_number(cell.strip(), ",") and not is_stamp(cell)
    advice = (
        "numbers have a decimal comma: read the file with decimal=',', or give undertow.read its path" if comma
        else "write None or NaN where a value is missing, and leave out rows that are none of the recording"
    )  # fmt: skip
    label = "" if cells.index[at] == at else f" (index {cells.index[at]!r})"
    return f"{shown(cell)} in row {at} from 0{label}; {advice}"


def _converted(cells: pd.Series) -> pd.Series:
    """Cells as numbers, NaN where one is none."""
    return pd.to_numeric(cells.map(lambda cell: cell if np.ndim(cell) == 0 else None), errors="coerce")


def _of_numbers(table: pd.DataFrame) -> pd.DataFrame:
    """The columns of numbers, also of those that are held as texts or objects: most of their cells are numbers."""
    found = {}
    for column in table.columns:
        cells = table[column]
        if cells.dtype.kind in "OTU" or isinstance(cells.dtype, pd.StringDtype):
            texts = cells.map(lambda cell: cell.replace(",", ".", 1) if isinstance(cell, str) else cell)
            numbers = _converted(texts)
            if 2 * int(numbers.notna().sum()) > int(cells.notna().sum()):
                found[column] = numbers.astype(np.float64)
        elif pd.api.types.is_numeric_dtype(cells) and not pd.api.types.is_bool_dtype(cells):
            found[column] = cells.map(np.real) if np.iscomplexobj(cells) else cells
    return pd.DataFrame(found, index=table.index)


def _said(table: pd.DataFrame, units: Units) -> dict[Column, str]:
    """Unit of each column: as given, else from the unit row, else from its name."""
    row = table.attrs.get("units", {})
    found: dict[Column, str] = {}
    for column in table.columns:
        unit = units.get(str(column), "") or row.get(column, "") or name_and_unit(column)[1]
        if unit:
            found[column] = unit
    unknown = [name for name in units if name not in {*map(str, table.columns), *CHANNELS, "time"}]
    if unknown and all(isinstance(name, int) for name in table.columns):
        raise RecordingError(
            f"units names {unknown[0]!r}, but X has {len(table.columns)} columns without names: one trial has x, or x "
            "and v, or x, v and a. Give several trials as a list of arrays, one a trial"
        )
    if unknown:
        raise RecordingError(
            f"units names {unknown[0]!r}, which is neither a column ({_shown(table)}) nor a quantity "
            f"({', '.join(CHANNELS)}); correct the name"
        )
    return found


def _guessed(
    table: pd.DataFrame, said: Mapping[Column, str], rate_hz: float | None
) -> tuple[dict[str, tuple[Column, ...]], Column | None]:
    """Channels and time by the columns' names, as `undertow inspect` proposes them."""
    numbers = _of_numbers(table)
    proposal = propose_mapping(numbers, said)
    for quantity, alike in proposal.alike.items():
        clock = f'"time": {proposal.time.column!r}, ' if proposal.time is not None else ""
        raise RecordingError(
            f"columns {', '.join(map(repr, alike[:COLUMNS_SHOWN]))} all look like {quantity}; say which, as in "
            f'columns={{{clock}"{quantity}": {alike[0]!r}}}; if each is a trial, give undertow.read a list of tables, '
            "each with the time and one of them"
        )
    if not proposal.channels and rate_hz is None and len(numbers.columns) == len(table.columns):
        proposal = two_without_names(numbers) or proposal
    chosen = {quantity: spec.columns for quantity, spec in proposal.channels.items()}
    if not chosen:
        if not len(table.columns):
            raise RecordingError("it holds no column of numbers; is it a recording? name a matrix as variable=...")
        if strange := strange_unit(numbers):
            raise RecordingError(strange)
        for quantity, spec in propose_mapping(numbers).channels.items():  # a unit that fits no channel hides its own
            for unit in (said[column] for column in spec.columns if column in said):
                factor_to_si(unit, quantity)
        if empty := [column for column in table.columns if table[column].isna().all()]:
            raise RecordingError(
                f"column {empty[0]!r} holds no number: all {len(table)} values are missing; leave this trial out"
            )
        if len(numbers.columns) > 1 and counts_rows(numbers[numbers.columns[0]]):
            raise RecordingError(
                f"column {numbers.columns[0]!r} counts rows and is no time; say rate_hz=... and what the others hold, "
                f'as in columns={{"displacement": {numbers.columns[-1]!r}}}'
            )
        raise RecordingError(
            f"none of the columns {_shown(table)} is named like a channel and holds numbers; say which, as in "
            f'columns={{"time": {table.columns[0]!r}, "displacement": {table.columns[-1]!r}}}'
        )
    time = proposal.time.column if proposal.time is not None else None
    if time is None and rate_hz is None:
        raise RecordingError(
            f'none of the columns {_shown(table)} looks like time; say columns={{"time": ...}} or rate_hz=...'
        )
    return chosen, time


def _named(
    table: pd.DataFrame, columns: Columns, rate_hz: float | None
) -> tuple[dict[str, tuple[Column, ...]], Column | None]:
    """Channels and time as said."""
    chosen: dict[str, tuple[Column, ...]] = {}
    for quantity, where in columns.items():
        if quantity not in {*CHANNELS, "time"}:
            raise RecordingError(
                f"columns names the quantity {quantity!r}; it may be time, {', '.join(CHANNELS)}: correct it"
            )
        alone = isinstance(where, (str, int)) or not isinstance(where, Sequence)
        names: tuple[Column, ...] = (where,) if alone else tuple(where)  # type: ignore[assignment,arg-type]
        for name in names:
            if name not in table.columns:
                raise RecordingError(f"columns says that {quantity} is in {name!r}; the table has {_shown(table)}")
        chosen[quantity] = names
    time = chosen.pop("time", None)
    if not chosen:
        raise RecordingError(f"columns names no channel beside time; add one of {', '.join(CHANNELS)}")
    if time is None and rate_hz is None:
        raise RecordingError(f"columns names {', '.join(chosen)} but no time; add its column or give rate_hz=...")
    return chosen, time[0] if time else None


def _hollow(
    table: pd.DataFrame, said: Mapping[Column, str], chosen: Mapping[str, tuple[Column, ...]]
) -> dict[str, tuple[Column, ...]]:
    """Channels beside those ``chosen`` whose columns by their names would be one and hold no value: they are read, so
    that it is said that nothing is there."""
    empty = [column for column in table.columns if table[column].isna().all()]
    if not empty or not len(table):
        return {}
    swings = np.sin(np.arange(len(table)))  # any numbers: the names and units alone are to decide
    found = propose_mapping(pd.DataFrame({column: swings for column in empty}), said).channels
    return {name: spec.columns[:1] for name, spec in found.items() if name in CHANNELS and name not in chosen}


def _unit(quantity: str, names: Sequence[Column], said: Mapping[Column, str], units: Units) -> str:
    """The unit of a channel; units are always said."""
    found = {said.get(name, "") for name in names} if quantity not in units else {units[quantity]}
    if len(found) > 1 or "" in found:
        one = next((name for name in names if not said.get(name)), names[0])
        raise RecordingError(
            f"{quantity} (column {', '.join(map(repr, names))}) has no unit; say it, as in "
            f'units={{{str(one)!r}: "{KNOWN[quantity][1]}"}}'
        )
    return found.pop()


def _coordinate(units: Mapping[str, str]) -> Coordinate:
    """Rotation where a displacement or velocity has an angle's unit."""
    moved = [one for one in ("displacement", "velocity") if one in units]
    return "translation" if all(is_unit_of(units[one], one, "translation") for one in moved) else "rotation"


def _shown(table: pd.DataFrame) -> str:
    names = [repr(name) for name in table.columns]
    more = f" and {len(names) - COLUMNS_SHOWN} more" if len(names) > COLUMNS_SHOWN else ""
    return ", ".join(names[:COLUMNS_SHOWN]) + more
