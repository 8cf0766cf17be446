"""Whether a variable of a MATLAB 5 file is made of elements that the format knows, each inside the one that holds it.

The library that reads them takes kinds and sizes as they stand: a damaged one ends the process or fills the memory. So
every element is looked at first, in the order in which it will be read (MATLAB's MAT-file format, section 1).

Belongs here: elements, their kinds and lengths. Does not belong here: sizes of variables (mat_sizes.py), values.
"""

from __future__ import annotations

import io
import math
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from undertow.errors import RecordingError

MATRIX, COMPRESSED = 14, 15
_FLAGS, _DIMENSIONS = frozenset({6}), frozenset({5, 6})
_TEXTS, _NUMBERS = frozenset({1, 2, 4, 16, 17, 18}), frozenset({1, 2, 3, 4, 5, 6, 7, 9, 12, 13})
_CELL, _STRUCT, _OBJECT, _SPARSE, _FUNCTION, _OPAQUE = 1, 2, 3, 5, 16, 17
_DENSE = (4, *range(6, 16))
_COMPLEX = 1 << 11
_FIRST = 256
DEEPEST = 64
"""Levels of structures and cells in each other."""
LONGEST_NAME = 63
"""Characters of a MATLAB name."""
_CHUNK = 1 << 20


class Plain:
    """Bytes of a variable as they lie in a file: read in order, passed over by seeking."""

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self._stream, self._left = stream, size

    def peek(self, size: int) -> bytes:
        """The next bytes, fewer at the end; they stay the next ones."""
        part = self._stream.read(min(size, self._left))
        self._stream.seek(-len(part), 1)
        return part

    def skip(self, size: int) -> int:
        """Pass over so many bytes; how many there were."""
        there = min(size, self._left)
        self._stream.seek(there, 1)
        self._left -= there
        return there


class Folded:
    """Bytes of a compressed variable, unfolded as they are passed over; ``allow`` is told how many there were so far.

    Raises zlib.error where they are damaged, which their checksum tells at the end.
    """

    def __init__(self, stream: BinaryIO, size: int, allow: Callable[[int], None]) -> None:
        self._stream, self._left, self._folded, self._allow = stream, size, zlib.decompressobj(), allow
        self._ready, self.total = b"", 0

    def peek(self, size: int) -> bytes:
        """The next bytes, fewer at the end; they stay the next ones."""
        while len(self._ready) < size and self._unfold(size):
            pass
        return self._ready[:size]

    def skip(self, size: int) -> int:
        """Unfold and drop so many bytes; how many there were."""
        left = size
        while left > 0 and (self._ready or self._unfold()):
            dropped = min(left, len(self._ready))
            self._ready = self._ready[dropped:]
            left -= dropped
        return size - left

    def _unfold(self, most: int = _CHUNK) -> bool:
        """One more piece, of a bomb no more than ``most`` bytes at once."""
        part = b""
        while not part and not self._folded.eof:
            chunk = self._folded.unconsumed_tail or self._stream.read(min(self._left, _CHUNK))
            self._left -= 0 if self._folded.unconsumed_tail else len(chunk)
            if not chunk:
                break
            part = self._folded.decompress(chunk, most)
        self._ready += part
        self.total += len(part)
        self._allow(self.total)
        return bool(part)


@dataclass(frozen=True)
class Variable:
    """The bytes of one variable, passed over element by element; ``order`` is struct's mark of the byte order."""

    path: Path
    name: str
    content: Plain | Folded
    order: str

    def check(self, size: int, depth: int = 0) -> None:
        """A matrix in the next ``size`` bytes: flags, dimensions, name, and what its class asks for.

        Raises RecordingError where it is none or one of its elements is longer than what holds it; zlib.error where
        compressed bytes are damaged.
        """
        if depth > DEEPEST:
            raise self.damaged(f"holds more than {DEEPEST} levels of structures")
        if size == 0:
            return  # an empty one has no flags either
        left, bits, values, _ = self.heading(size)
        kind, parts = bits & 0xFF, 2 if bits & _COMPLEX else 1
        if kind in _DENSE and values > left:
            raise self.damaged(f"is said to hold {values} values in {left} bytes")
        if kind in (_CELL, _STRUCT, _OBJECT):
            left = self._inner(left, kind, values, depth)
        elif kind == _FUNCTION:
            left = self._matrix(left, depth)
        elif kind == _OPAQUE:
            for _ in range(2):
                left, _ = self._element(left, _TEXTS)
            left = self._matrix(left, depth)
        elif kind in (_SPARSE, *_DENSE):
            for kinds in [_DIMENSIONS] * (2 if kind == _SPARSE else 0) + [_TEXTS | _NUMBERS] * parts:
                left, _ = self._element(left, kinds)
        else:
            raise self.damaged(f"is of class {kind}, which MATLAB does not write")
        self.content.skip(left)

    def heading(self, size: int) -> tuple[int, int, int, bytes]:
        """What every matrix begins with: how many of its bytes are left after that, its flags, how many values its
        dimensions make (0 where its class has none), its name."""
        left, flags = self._element(size, _FLAGS)
        (bits,) = struct.unpack(f"{self.order}I", flags[:4].ljust(4, b"\0"))
        values = 0
        if bits & 0xFF != _OPAQUE:
            left, dims = self._element(left, _DIMENSIONS)
            if len(dims) < 8 or len(dims) % 4:
                raise self.damaged(f"has {len(dims)} bytes of dimensions")
            values = math.prod(struct.unpack(f"{self.order}{len(dims) // 4}I", dims))
        left, name = self._element(left, _TEXTS)
        return left, bits, values, name

    def damaged(self, how: str) -> RecordingError:
        """What a user is told of a variable that is no longer what MATLAB wrote."""
        named = f"variable {self.name[:LONGEST_NAME]!r}" if self.name else "a variable"
        return RecordingError(
            f"{self.path} is damaged: {named} {how}; copy the file again, or save it again with -v7"
        )

    def _inner(self, left: int, kind: int, values: int, depth: int) -> int:
        """The matrices of a cell array or a structure; how many bytes are left after them."""
        if kind == _OBJECT:
            left, _ = self._element(left, _TEXTS)
        if kind != _CELL:
            left, width = self._element(left, _DIMENSIONS)
            left, names = self._element(left, _TEXTS, all_of_it=True)
            (longest,) = struct.unpack(f"{self.order}I", width[:4].ljust(4, b"\0"))
            values *= len(names) // longest if longest else 0
        if 8 * values > left:
            raise self.damaged(f"is said to hold {values} parts in {left} bytes")
        for _ in range(values):
            left = self._matrix(left, depth)
        return left

    def _matrix(self, left: int, depth: int) -> int:
        """One matrix with its tag; how many bytes are left after it."""
        kind, length = map(int, struct.unpack(f"{self.order}II", self.content.peek(8).ljust(8, b"\0")))
        self.content.skip(8)
        if kind != MATRIX or length > left - 8:
            raise self.damaged(f"has an element of kind {kind} and {length} bytes where a matrix should be")
        self.check(length, depth + 1)
        return left - 8 - length

    def _element(self, left: int, kinds: frozenset[int], all_of_it: bool = False) -> tuple[int, bytes]:
        """One element that is no matrix: how many bytes are left after it, and its first ones."""
        (word,) = struct.unpack(f"{self.order}I", self.content.peek(4).ljust(4, b"\0"))
        kind, small = word & 0xFFFF, word >> 16
        length = small
        if not small:
            (length,) = struct.unpack(f"{self.order}I", self.content.peek(8).ljust(8, b"\0")[4:])
        room = left - (4 if small else 8)
        if kind not in kinds or length > room or small > 4:
            raise self.damaged(f"has an element of kind {word} and {length} bytes where it should not")
        self.content.skip(4 if small else 8)
        first = self.content.peek(length if all_of_it else min(length, _FIRST))
        size = 4 if small else length + min(-length % 8, room - length)
        if self.content.skip(size) < length:
            raise self.damaged("ends early")
        return room - size, first


def name_of(head: bytes, order: str) -> str | None:
    """The name of a variable from its first bytes after its tag; None where they hold none."""
    try:
        return Variable(Path(), "", Plain(io.BytesIO(head), len(head)), order).heading(len(head))[-1].decode("latin-1")
    except RecordingError:
        return None
