"""Parquet and Feather files as tables, through pyarrow.

Belongs here: columns of Arrow tables. Does not belong here: what a Feather file would unfold to (arrow_sizes.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.arrow_sizes import feather_bytes
from undertow.recording.foreign import library, parsing
from undertow.recording.layout import Column, FileFormat, pick
from undertow.recording.stamps import STAMPED
from undertow.recording.vectors import table

_ADVICE = "write it again"


def read_parquet(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The asked columns (all that hold numbers where None) of a Parquet file as float64; nulls are NaN, timestamps
    seconds since the first.

    Raises RecordingError where pyarrow is not installed, the file is damaged or too large, or a column is missing or
    holds no numbers.
    """
    parquet = library("pyarrow.parquet", "pyarrow", "parquet", path)
    with parsing(path, "Parquet file", _ADVICE), parquet.ParquetFile(path) as file:
        schema = file.schema_arrow
        chosen = _chosen(path, schema, layout, columns)
        layout.limits.allow_bytes(path, 8.0 * file.metadata.num_rows * len(chosen), "its columns")
        return _frame(path, file.read(columns=chosen, use_threads=False), chosen, columns)


def read_feather(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The same of a Feather file (version 2, which is Arrow's file format)."""
    arrow = library("pyarrow", "pyarrow", "parquet", path)
    with parsing(path, "Feather file of version 2", _ADVICE):
        layout.limits.allow_bytes(path, feather_bytes(path), "its record batches")
        with arrow.memory_map(str(path)) as source:
            with arrow.ipc.open_file(source) as file:
                schema = file.schema
            chosen = _chosen(path, schema, layout, columns)
            places = sorted({schema.get_field_index(name) for name in chosen})
            options = arrow.ipc.IpcReadOptions(included_fields=places, use_threads=False)
            with arrow.ipc.open_file(source, options=options) as file:
                return _frame(path, file.read_all(), chosen, columns)


def _chosen(path: Path, schema: Any, layout: FileFormat, columns: Sequence[Column] | None) -> list[str]:
    """Names of the asked columns; of those with numbers or times where None. A number counts columns from 0."""
    layout.limits.allow_columns(path, len(schema.names))
    names: list[Column] = list(schema.names)
    if columns is None:
        return [field.name for field in schema if _kind(field.type)]
    if not layout.header:
        names = list(range(len(names)))
    chosen = [schema.names[at] for at in pick(path, names, columns)]
    wrong = next((name for name in chosen if not _kind(schema.field(name).type)), None)
    if wrong is not None:
        raise RecordingError(f"{path}: column {wrong!r} holds {schema.field(wrong).type}, not numbers; map another")
    return chosen


def _kind(kind: Any) -> str:
    """number, time, or empty where a column holds neither."""
    import pyarrow

    types = pyarrow.types
    if types.is_floating(kind) or types.is_integer(kind) or types.is_decimal(kind):
        return "number"
    return "time" if types.is_timestamp(kind) or types.is_duration(kind) or types.is_time(kind) else ""


def _frame(path: Path, read: Any, chosen: Sequence[str], columns: Sequence[Column] | None) -> pd.DataFrame:
    import pyarrow

    vectors: dict[Column, Any] = {}
    for name, asked in zip(chosen, columns or chosen, strict=True):
        column = read.column(name)
        if _kind(column.type) == "time":
            tick = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}[getattr(column.type, "unit", "s")]
            ticks = column.cast(pyarrow.int32() if pyarrow.types.is_time32(column.type) else pyarrow.int64())
            values = np.asarray(ticks.to_pandas(), dtype=np.float64)
            values = (values - (values[0] if values.size else 0.0)) * tick
        else:
            values = np.asarray(column.cast(pyarrow.float64()).to_pandas(), dtype=np.float64)
        vectors[asked] = values
    units = {field.name: _unit(field) for field in read.schema}
    stamps = {name for name in chosen if _kind(read.column(name).type) == "time"}
    found = table(path, vectors, {one: units[name] for name, one in zip(chosen, columns or chosen, strict=True)})
    found.attrs[STAMPED] = tuple(one for name, one in zip(chosen, columns or chosen, strict=True) if name in stamps)
    return found


def _unit(field: Any) -> str:
    """The unit that a column's own metadata say; empty where they say none."""
    said = field.metadata or {}
    found = next((said[key] for key in (b"unit", b"units") if key in said), b"")
    return str(found.decode("utf-8", errors="replace"))
