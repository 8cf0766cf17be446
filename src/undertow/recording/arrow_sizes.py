"""What the record batches of an Arrow file (Feather version 2) would unfold to, found without unfolding them.

Each packed buffer states its own size; a few kB can state gigabytes, and the library takes them at their word. The
file's footer and messages are FlatBuffers: tables of offsets (Arrow columnar format, "Encapsulated message format").

Belongs here: those sizes. Does not belong here: reading (arrow.py).
"""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from pathlib import Path

MAGIC = b"ARROW1"
"""First and last bytes of an Arrow file."""

_DICTIONARY_BATCH, _RECORD_BATCH = 2, 3
_BLOCK, _BUFFER = 24, 16  # bytes of the structures Block and Buffer
_CONTINUED = 0xFFFFFFFF


def feather_bytes(path: Path) -> int:
    """Bytes that all record batches and dictionaries of an Arrow file take once they are unfolded; 0 where the file is
    none, which its reader says.

    Raises ValueError or struct.error where offsets lead nowhere.
    """
    if path.stat().st_size < 2 * len(MAGIC) + 6:
        return 0
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as file:
        if file[: len(MAGIC)] != MAGIC or file[-len(MAGIC) :] != MAGIC:
            return 0
        end = len(file) - len(MAGIC) - 4
        (length,) = struct.unpack_from("<i", file, end)
        if not 0 < length <= end:
            raise ValueError(f"its footer states {length} bytes")
        footer = _FlatTable.root(file, end - length)
        total = 0
        for slot in (2, 3):  # dictionaries, record batches
            for at in footer.items(slot, _BLOCK):
                offset, metadata = struct.unpack_from("<qi", file, at)
                total += _batch_bytes(file, offset, metadata)
        return total


def _batch_bytes(file: mmap.mmap, offset: int, metadata: int) -> int:
    """Bytes that one message's buffers unfold to."""
    if offset < 0 or metadata < 0 or offset + metadata > len(file):
        raise ValueError(f"a batch is stated to lie at byte {offset}")
    (first,) = struct.unpack_from("<I", file, offset)
    message = _FlatTable.root(file, offset + (8 if first == _CONTINUED else 4))
    kind, header = message.byte(1), message.table(2)
    if kind == _DICTIONARY_BATCH and header is not None:
        header = header.table(1)
    if header is None or kind not in (_DICTIONARY_BATCH, _RECORD_BATCH):
        return 0
    packed, body, total = header.table(3) is not None, offset + metadata, 0
    for at in header.items(2, _BUFFER):
        start, length = struct.unpack_from("<qq", file, at)
        stated = length
        if packed and length >= 8:
            (unfolded,) = struct.unpack_from("<q", file, body + start)
            stated = max(length, unfolded)
        total += max(stated, 0)
    return total


class _FlatTable:
    """A FlatBuffers table: fields are found through its list of offsets."""

    def __init__(self, file: mmap.mmap, at: int) -> None:
        self._file, self._at = file, at
        (back,) = struct.unpack_from("<i", file, at)
        self._offsets = at - back
        if not 0 <= self._offsets < len(file):
            raise ValueError(f"a table at byte {at} leads out of the file")
        (self._size,) = struct.unpack_from("<H", file, self._offsets)

    @classmethod
    def root(cls, file: mmap.mmap, at: int) -> _FlatTable:
        """The table that a buffer beginning at ``at`` holds."""
        (offset,) = struct.unpack_from("<I", file, at)
        return cls(file, at + offset)

    def _field(self, slot: int) -> int:
        """Where a field's value stands; 0 where the table has none."""
        entry = 4 + 2 * slot
        if entry >= self._size:
            return 0
        (offset,) = struct.unpack_from("<H", self._file, self._offsets + entry)
        return self._at + offset if offset else 0

    def byte(self, slot: int) -> int:
        """A field of one byte; 0 where there is none."""
        at = self._field(slot)
        return self._file[at] if at else 0

    def table(self, slot: int) -> _FlatTable | None:
        """A field that is a table."""
        at = self._field(slot)
        if not at:
            return None
        (offset,) = struct.unpack_from("<I", self._file, at)
        return _FlatTable(self._file, at + offset)

    def items(self, slot: int, size: int) -> Iterator[int]:
        """Where the structures of a vector stand, each of ``size`` bytes."""
        at = self._field(slot)
        if not at:
            return
        (offset,) = struct.unpack_from("<I", self._file, at)
        (count,) = struct.unpack_from("<I", self._file, at + offset)
        if count * size > len(self._file):
            raise ValueError(f"a list states {count} items")
        for number in range(count):
            yield at + offset + 4 + number * size
