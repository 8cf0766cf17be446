"""What a MATLAB file would unfold to, found without keeping any of it.

A variable of a few kB can unfold to gigabytes (v5), or state a size that no machine has (7.3).

Belongs here: names and sizes of top-level variables. Does not belong here: their content (matlab.py).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from undertow.errors import RecordingError
from undertow.recording.hdf5 import DEEPEST, OBJECTS_AT_MOST, allow_dataset, checked, walk
from undertow.recording.limits import Limits
from undertow.recording.mat_elements import COMPRESSED, MATRIX, Folded, Plain, Variable, name_of

HEADER_BYTES = 128
"""A v5 file's header; its last two bytes tell the byte order (MATLAB's MAT-file format, section 1)."""

_HDF5 = b"\x89HDF\r\n\x1a\n"
_HEAD = 4096  # unfolded bytes in which flags, dimensions and name of a variable stand


def allow(path: Path, limits: Limits, wanted: Collection[str] | None) -> None:
    """RecordingError where the wanted variables of a file (all where None) take more than the limit, in either format,
    and where elements of a v5 file are damaged; what else is damaged is left to the reader, which says so.
    """
    with path.open("rb") as stream:
        start = stream.read(512 + len(_HDF5))
    if _HDF5 in (start[: len(_HDF5)], start[512:]):
        _allow_v73(path, limits, wanted)
    else:
        _allow_v5(path, limits, wanted)


def _allow_v73(path: Path, limits: Limits, wanted: Collection[str] | None) -> None:
    """The same for 7.3, which is HDF5: cells are references, and one referred to twice is read twice."""
    with checked(path) as file:
        for _ in walk(path, file):  # refuses what leads out of the file
            pass
        count = _Count(path, file, limits)
        for name in file:
            if name != "#refs#" and (wanted is None or name in wanted):
                count.add(name, file[name])


class _Count:
    """Bytes and objects that reading would take, following references."""

    def __init__(self, path: Path, file: Any, limits: Limits) -> None:
        self._path, self._file, self._limits = path, file, limits
        self._bytes = self._objects = 0

    def add(self, name: str, node: Any, depth: int = 0) -> None:
        """One more object with all below it; RecordingError where it is too much."""
        import h5py

        self._objects += 1
        if self._objects > OBJECTS_AT_MOST or depth > DEEPEST:
            raise RecordingError(
                f"{self._path}: {name!r} leads to more than {OBJECTS_AT_MOST} objects or {DEEPEST} levels; save its "
                "trials apart"
            )
        if isinstance(node, h5py.Group):
            for key in node:
                if not isinstance(node.get(key, getlink=True), h5py.SoftLink):
                    self.add(name, node[key], depth + 1)
            return
        self._bytes += allow_dataset(self._path, name, node, self._limits)
        self._limits.allow_bytes(self._path, self._bytes, f"{name!r}")
        if node.dtype == h5py.ref_dtype:
            for reference in node[()].flat:
                if reference:
                    self.add(name, self._file[reference], depth + 1)


def _allow_v5(path: Path, limits: Limits, wanted: Collection[str] | None) -> None:
    """The same for v5, whose variables are packed one by one; RecordingError too where one is damaged."""
    whole = path.stat().st_size
    with path.open("rb") as stream:
        header = stream.read(HEADER_BYTES)
        order = {b"IM": "<", b"MI": ">"}.get(header[126:128])
        if order is None:
            limits.allow_bytes(path, whole, "its variables")
            return
        total = 0
        while len(tag := stream.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            start = stream.tell()
            there = min(size, whole - start)
            if kind == COMPRESSED:
                folded = Folded(stream, there, partial(limits.allow_unfolded, path, total))
                total += folded.total if _checked(path, folded, order, wanted) else 0
            elif kind == MATRIX:
                plain = Plain(stream, there)
                name = name_of(plain.peek(_HEAD), order)
                if wanted is None or name in wanted:
                    limits.allow_unfolded(path, total, size)
                    Variable(path, name or "", plain, order).check(size)
                    total += size
            stream.seek(start + size)


def _checked(path: Path, folded: Folded, order: str, wanted: Collection[str] | None) -> bool:
    """Whether a compressed variable is wanted; it is then unfolded to its end, where its checksum stands."""
    variable = Variable(path, "", folded, order)
    try:
        name = name_of(folded.peek(_HEAD + 8)[8:], order)
        if wanted is not None and name not in wanted:
            return False
        variable = replace(variable, name=name or "")
        kind, size = struct.unpack(f"{order}II", folded.peek(8).ljust(8, b"\0"))
        folded.skip(8)
        if kind != MATRIX:
            raise variable.damaged(f"has an element of kind {kind} where a matrix should be")
        variable.check(size)
        while folded.skip(_HEAD):
            pass
    except zlib.error as error:
        raise variable.damaged(f"does not unfold ({error})") from error
    return True
