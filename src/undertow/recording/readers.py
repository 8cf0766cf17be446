"""The door for files: a suffix leads to the function that reads it.

A new format is one function and one line in `READERS`, and one in `TABLES` where a file may hold several tables.
Belongs here: the choice of the reader. Does not belong here: what a format looks like inside (text.py, matlab.py,
excel.py, ...), what a column means (catalogue.py).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.arrow import read_feather, read_parquet
from undertow.recording.excel import EXCEL, excel_tables, read_excel
from undertow.recording.hdf5 import HDF5, hdf5_tables, read_hdf5
from undertow.recording.labview import read_lvm, read_tdms, tdms_tables
from undertow.recording.layout import Column, FileFormat
from undertow.recording.matlab import matlab_tables, read_cells, read_matlab
from undertow.recording.mdf import mdf_tables, read_mdf
from undertow.recording.text import read_text
from undertow.recording.universal_file import read_universal

Reader = Callable[[Path, FileFormat, Sequence[Column] | None], pd.DataFrame]

READERS: Mapping[str, Reader] = MappingProxyType(
    {
        **dict.fromkeys((".csv", ".txt", ".dat", ".tsv", ".asc"), read_text),
        **dict.fromkeys((".csv.gz", ".txt.gz", ".dat.gz", ".tsv.gz"), read_text),
        ".mat": read_matlab,
        **dict.fromkeys(HDF5, read_hdf5),
        **dict.fromkeys(EXCEL, read_excel),
        ".lvm": read_lvm,
        ".tdms": read_tdms,
        ".uff": read_universal,
        ".unv": read_universal,
        ".mf4": read_mdf,
        ".mdf": read_mdf,
        ".parquet": read_parquet,
        ".feather": read_feather,
    }
)
"""Suffix -> reader. Nothing that can carry code (pickles, object arrays) has a place here."""

TABLES: Mapping[str, Callable[[Path], tuple[str, ...]]] = MappingProxyType(
    {
        ".mat": matlab_tables,
        **dict.fromkeys(HDF5, hdf5_tables),
        **dict.fromkeys(EXCEL, excel_tables),
        ".tdms": tdms_tables,
        ".mf4": mdf_tables,
        ".mdf": mdf_tables,
    }
)
"""Suffix -> names of the tables in a file, as `FileFormat.variable` takes them, where there may be several."""

PLAIN = FileFormat()
"""Separator found, a header line, decimal points."""

_PACKED = (".zip", ".7z", ".rar", ".tar", ".tgz")
_PICKLED = (".pkl", ".pickle", ".npy", ".npz", ".joblib")
_SHEETS = (".xls", ".ods")
_ADVICE = {
    ".xls": "save it as .xlsx",
    ".ods": "save it as .xlsx or CSV",
    ".gz": "only text is read packed: unpack it",
    ".wav": "export it as CSV or MAT with its unit",
}


def suffix_of(path: Path) -> str:
    """A file's suffix, with what was compressed.

    >>> suffix_of(Path("r1.CSV.gz")), suffix_of(Path("m_14.9_0.2_3.csv"))
    ('.csv.gz', '.csv')
    """
    last = path.suffix.lower()
    return Path(path.stem).suffix.lower() + last if last == ".gz" else last


def trial_name(path: Path) -> str:
    """A file's name without its suffix.

    >>> trial_name(Path("a/r116a.csv.gz")), trial_name(Path("disc_0.2016_3.csv"))
    ('r116a', 'disc_0.2016_3')
    """
    return path.name[: -len(suffix_of(path))] if suffix_of(path) else path.name


def read_table(
    path: Path, layout: FileFormat = PLAIN, columns: Sequence[Column] | None = None, trial: int | None = None
) -> pd.DataFrame:
    """The asked columns of a file as float64; all where ``columns`` is None; other columns are never converted.

    ``trial`` chooses one of several trials in a file (``layout.cells``). NaN is passed on: who maps a column judges it.

    Raises RecordingError where the file is missing, unreadable, of an unknown kind or without a column.
    """
    reader = _reader(path)
    if layout.cells is None:
        return reader(path, layout, columns)
    tables = read_cells(path, layout.cells, layout.limits)
    at = 0 if trial is None else trial
    if not 0 <= at < len(tables):
        raise RecordingError(f"{path} has {len(tables)} trials; there is none with number {at}: count from 0")
    table = tables[at]
    missing = [column for column in columns or () if column not in table.columns]
    if missing:
        raise RecordingError(
            f"{path}: trial {at} has {table.shape[1]} cells; there is none with number {missing[0]}: count from 0"
        )
    return table if columns is None else table[list(columns)]


def tables_in(path: Path) -> tuple[str, ...]:
    """Names of the tables that a file holds; one without a name where its kind holds a single one.

    Raises RecordingError where the file is missing, unreadable or of an unknown kind.
    """
    _reader(path)
    names = TABLES.get(suffix_of(path))
    return ("",) if names is None else names(path)


def count_trials(path: Path, layout: FileFormat) -> int:
    """How many trials a file holds: 1 unless the layout speaks of cells."""
    if layout.cells is None:
        return 1
    _reader(path)
    return len(read_cells(path, layout.cells, layout.limits))


def never_read(path: Path) -> str:
    """Why a file of that name is never read, in words; empty where it is not one of those.

    >>> never_read(Path("run3.npz")), never_read(Path("run3.csv"))
    ('.npz can carry code and is never read; save it as CSV, MAT or HDF5', '')
    """
    suffix = suffix_of(path)
    if suffix in _PACKED:
        return "is an archive, and no archive is opened; unpack it"
    if suffix in _SHEETS:
        return f"no reader for {suffix!r}; {_ADVICE[suffix]}"
    return f"{suffix} can carry code and is never read; save it as CSV, MAT or HDF5" if suffix in _PICKLED else ""


def _reader(path: Path) -> Reader:
    suffix = suffix_of(path)
    if not os.path.isfile(path):
        if os.path.isdir(path):
            raise RecordingError(
                f"{path} is a folder; check the path: give one of its files, or write a config for all of them with "
                f"undertow init {path}"
            )
        raise RecordingError(f"{path} is not there; check the path (in a config or an index it begins at that file)")
    if why := never_read(path):
        raise RecordingError(f"{path}: {why}")
    if suffix not in READERS:
        advice = f"; {_ADVICE[path.suffix.lower()]}" if path.suffix.lower() in _ADVICE else ""
        raise RecordingError(
            f"{path}: no reader for {suffix or 'a name without suffix'!r}; known: {', '.join(READERS)}{advice}"
        )
    return READERS[suffix]
