"""HDF5 files as tables: a group of datasets, a matrix, or a dataset with named fields.

Whatever leads out of the file (external links and storage, virtual datasets) is refused, and sizes are checked before
anything is read: a file of a few kB can state 10^12 values.

Belongs here: groups, datasets, links. Does not belong here: MATLAB's own use of them (matlab.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from undertow.errors import MisnamedError, RecordingError
from undertow.recording.file_guard import HDF5_GUARD
from undertow.recording.foreign import parsing
from undertow.recording.layout import Column, FileFormat, pick
from undertow.recording.limits import Limits
from undertow.recording.vectors import alike, chosen_table, matrix_columns, table

HDF5 = (".h5", ".hdf5", ".hdf")
"""Suffixes of these files."""

OBJECTS_AT_MOST = 100_000
"""Groups and datasets looked at in one file: 10,000 trials of ten channels; more take minutes to walk through."""

DEEPEST = 32
"""Groups within groups: a file that goes deeper leads back to itself."""

_ADVICE = "copy it again"


def read_hdf5(path: Path, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The asked columns (all where None) as float64.

    ``layout.variable`` is the path of a group (its vectors are the columns, by name), of a matrix (columns 0, 1, ...;
    the longer side is time) or of a dataset with fields; None: the file's own vectors, or its only table.

    Raises RecordingError where the file is damaged or too large, the table is missing, or a column holds no numbers.
    """
    with parsing(path, "HDF5 file", _ADVICE), checked(path) as file:
        return _table_at(path, _found(path, file, layout.variable), layout, columns)


def hdf5_tables(path: Path) -> tuple[str, ...]:
    """Paths of everything in a file that can be read as a table; "" is the file's own vectors."""
    with parsing(path, "HDF5 file", _ADVICE), checked(path) as file:
        return _tables(path, file)


def checked(path: Path) -> Any:
    """The file, open for reading, after another process looked at it (hdf5_guard.py)."""
    import h5py

    HDF5_GUARD.check(path)
    return h5py.File(path, "r")


def walk(path: Path, group: Any, above: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Every group and dataset below ``group`` with its path; links out of the file are refused, as are endless ones."""
    import h5py

    seen = 0
    for name in group:
        at = f"{above}{name}"
        if isinstance(_link(path, group, name, at), h5py.SoftLink):
            continue
        node = group[name]
        yield at, node
        seen += 1
        if isinstance(node, h5py.Group):
            if depth >= DEEPEST:
                raise RecordingError(f"{path}: {at!r} lies more than {DEEPEST} groups deep; is it damaged?")
            for one in walk(path, node, f"{at}/", depth + 1):
                yield one
                seen += 1
        if seen > OBJECTS_AT_MOST:
            raise RecordingError(f"{path} has more than {OBJECTS_AT_MOST} objects; split it")


def allow_dataset(path: Path, name: str, dataset: Any, limits: Limits) -> int:
    """Bytes that a dataset takes; RecordingError where they are too many or lie in another file."""
    if dataset.external or dataset.is_virtual:
        raise RecordingError(f"{path}: {name!r} has its values in another file; only what lies in the file is read")
    size = int(dataset.size or 0) * max(int(dataset.dtype.itemsize), 8)
    chunk = int(np.prod(dataset.chunks or (0,), dtype=np.float64)) * dataset.dtype.itemsize
    limits.allow_bytes(path, max(size, chunk), f"{name!r}")
    return size


def _tables(path: Path, file: Any) -> tuple[str, ...]:
    import h5py

    own = any(_is_column(node) for node in file.values() if isinstance(node, h5py.Dataset))
    found = [""] if own else []
    for name, node in walk(path, file):
        if isinstance(node, h5py.Group):
            if any(isinstance(node.get(key, getlink=True), h5py.HardLink) and _is_column(node[key]) for key in node):
                found.append(name)
        elif isinstance(node, h5py.Dataset) and (node.dtype.names or (node.ndim == 2 and node.dtype.kind in "fiu")):
            found.append(name)
    return tuple(found)


def _found(path: Path, file: Any, variable: str | None) -> Any:
    """The group or dataset that is the table, checked link by link."""
    name = variable
    if name is None:
        have = _tables(path, file)
        name = "" if "" in have else chosen_table(path, have, None, "table")
    node = file
    for part in (one for one in name.split("/") if one):
        if not hasattr(node, "keys") or part not in node:
            have = _tables(path, file)
            listed = ", ".join(repr(one) for one in have) or "none"
            raise MisnamedError(f"{path} has no table {name!r}; it has {listed}: correct recordings.variable")
        _link(path, node, part, part)
        node = node[part]
    return node


def _link(path: Path, group: Any, name: str, shown: str) -> Any:
    """How a group holds an object; RecordingError where that lies in another file."""
    import h5py

    link = group.get(name, getlink=True)
    if isinstance(link, h5py.ExternalLink):
        raise RecordingError(
            f"{path}: {shown!r} links to the file {link.filename!r}; only what lies in the file itself is read"
        )
    return link


def _table_at(path: Path, node: Any, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    import h5py

    if isinstance(node, h5py.Dataset):
        size = allow_dataset(path, node.name, node, layout.limits)
        if node.dtype.names:
            layout.limits.allow_columns(path, len(node.dtype.names))
            content = node[()]
            names: list[Column] = list(node.dtype.names)
            if columns is None:
                names = [name for name in names if node.dtype[name].kind in "fiu"]
            return table(path, {names[at]: content[names[at]] for at in pick(path, names, columns)})
        layout.limits.allow_bytes(path, size, f"{node.name!r}")
        vectors = matrix_columns(path, node.name, node[()], layout.limits)
        return table(path, {at: vectors[at] for at in pick(path, list(vectors), columns)})
    return _group_table(path, node, layout, columns)


def _group_table(path: Path, group: Any, layout: FileFormat, columns: Sequence[Column] | None) -> pd.DataFrame:
    """The vectors of a group; columns may name datasets in groups below it by their path."""
    import h5py

    names: list[Column] = []
    for name, node in walk(path, group):
        if isinstance(node, h5py.Dataset) and _is_column(node):
            names.append(name)
    if columns is None:
        names = [name for name in names if "/" not in str(name)]
    layout.limits.allow_columns(path, len(names) if columns is None else len(columns))
    vectors, units, total = {}, {}, 0
    for at in pick(path, names, columns):
        dataset = group[names[at]]
        total += allow_dataset(path, str(names[at]), dataset, layout.limits)
        layout.limits.allow_bytes(path, total, "its datasets")
        vectors[names[at]] = np.atleast_1d(np.squeeze(dataset[()]))
        units[names[at]] = _unit(dataset)
    return table(path, alike(vectors) if columns is None else vectors, units)


def _is_column(node: Any) -> bool:
    """Whether an object is a dataset of numbers with one side longer than 1."""
    sides = [side for side in getattr(node, "shape", None) or () if side != 1]
    return len(sides) == 1 and node.dtype.kind in "fiu" and not node.dtype.names


def _unit(dataset: Any) -> str:
    """The unit that a dataset's attributes say; empty where they say none."""
    for key in ("unit", "units", "Unit", "Units"):
        said = dataset.attrs.get(key)
        if isinstance(said, bytes):
            return said.decode("utf-8", errors="replace")
        if isinstance(said, str):
            return said
    return ""
