"""How the laws are compiled: no error on a division by zero, and a cache that knows every source file."""

import zlib
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from numba import njit

F = TypeVar("F")

kernel = njit(error_model="numpy")
summed = njit(error_model="numpy", fastmath={"reassoc", "contract"})  # sums in any order: several at a time


def kept_kernel(signature: object) -> Callable[[F], F]:
    """Compile for one signature, from the cache where it holds the function already."""
    return njit(signature, error_model="numpy", cache=True)


def source_stamp() -> int:
    """A number that changes with any source file of this folder; numba itself looks at one file alone."""
    stamp = 1
    for path in sorted(Path(__file__).parent.glob("*.py")):
        stamp = zlib.crc32(path.read_bytes(), stamp)
    return stamp or 1
