"""What a MATLAB file would unfold to, found without keeping any of it.

A variable of a few kB can unfold to gigabytes (v5), or state a size that no machine has (7.3).

Belongs here: names and sizes of top-level variables. Does not belong here: their content (matlab.py).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection
from pathlib import Path
from typing import Any, BinaryIO

from undertow.errors import RecordingError
from undertow.recording.hdf5 import DEEPEST, OBJECTS_AT_MOST, allow_dataset, walk
from undertow.recording.limits import Limits

HEADER_BYTES = 128
"""A v5 file's header; its last two bytes tell the byte order (MATLAB's MAT-file format, section 1)."""

_COMPRESSED, _MATRIX = 15, 14
_HDF5 = b"\x89HDF\r\n\x1a\n"
_HEAD = 4096  # unfolded bytes in which flags, dimensions and name of a variable stand
_CHUNK = 1 << 20


def allow(path: Path, limits: Limits, wanted: Collection[str] | None) -> None:
    """RecordingError where the wanted variables of a file (all where None) take more than the limit, in either format.

    What is damaged is left to the reader, which says so.
    """
    with path.open("rb") as stream:
        start = stream.read(512 + len(_HDF5))
    if _HDF5 in (start[: len(_HDF5)], start[512:]):
        _allow_v73(path, limits, wanted)
    else:
        _allow_v5(path, limits, wanted)


def _allow_v73(path: Path, limits: Limits, wanted: Collection[str] | None) -> None:
    """The same for 7.3, which is HDF5: cells are references, and one referred to twice is read twice."""
    import h5py

    with h5py.File(path, "r") as file:
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
    """The same for v5, whose variables are packed one by one."""
    with path.open("rb") as stream:
        header = stream.read(HEADER_BYTES)
        order = {b"IM": "<", b"MI": ">"}.get(header[126:128])
        if order is None:
            limits.allow_bytes(path, path.stat().st_size, "its variables")
            return
        total = 0
        while len(tag := stream.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            start = stream.tell()
            if kind == _COMPRESSED:
                total += _unfolded(stream, size, order, limits.bytes - total, wanted)
            elif kind == _MATRIX and (wanted is None or _name(stream.read(min(size, _HEAD)), order) in wanted):
                total += size
            if total > limits.bytes:
                raise RecordingError(
                    f"{path} unfolds to more than the {limits.megabytes:g} MB that recordings.limits.megabytes allows; "
                    "is it the right file? raise the limit if it is"
                )
            stream.seek(start + size)


def _unfolded(stream: BinaryIO, size: int, order: str, most: int, wanted: Collection[str] | None) -> int:
    """Bytes that a compressed variable unfolds to, counted until there are more than ``most``; 0 if not wanted."""
    folded = zlib.decompressobj()
    left, total, first = size, 0, b""
    try:
        while left > 0 and (chunk := stream.read(min(left, _CHUNK))):
            left -= len(chunk)
            while chunk and total <= most:
                part = folded.decompress(chunk, _CHUNK)
                total += len(part)
                first = first or part
                chunk = folded.unconsumed_tail
            if total > most or (wanted is not None and _name(first[8 : _HEAD + 8], order) not in wanted):
                break
    except zlib.error:
        return total
    return total if wanted is None or _name(first[8 : _HEAD + 8], order) in wanted else 0


def _name(matrix: bytes, order: str) -> str | None:
    """The name of a matrix element from the bytes after its tag; None where they hold none."""
    try:
        at = 16  # array flags: a tag and 8 bytes
        (size,) = struct.unpack_from(f"{order}I", matrix, at + 4)
        at += 8 + size + (-size) % 8
        (word,) = struct.unpack_from(f"{order}I", matrix, at)
        if word >> 16:  # a small element: kind and size in one word, its bytes in the next
            return matrix[at + 4 : at + 4 + (word >> 16)].decode("latin-1")
        (size,) = struct.unpack_from(f"{order}I", matrix, at + 4)
        return matrix[at + 8 : at + 8 + size].decode("latin-1")
    except struct.error:
        return None
