"""A process that opens HDF5 or MDF files before the reader does, for their libraries can end or hang on a damaged one.

Started as a script with the kind of file, so that it imports nothing but h5py or asammdf: a file's path a line on its
input, as JSON; a line on its output when everything in that file was looked at. What the library says of a file does
not matter here.

Belongs here: that look. Does not belong here: who asks (file_guard.py), what is read (hdf5.py, matlab.py, mdf.py).
"""

from __future__ import annotations

import contextlib
import importlib
import json
import logging
import os
import sys
from collections.abc import Iterator
from typing import Any

OBJECTS_AT_MOST, DEEPEST = 100_000, 32
"""As in hdf5.py, which a script that imports nothing else cannot ask."""
WHOLE_BYTES = 4_000_000
"""A dataset up to this size is read whole, a larger one at its ends; of a larger channel group the first record."""

CHANNELS_AT_MOST = 4096
"""As recordings.limits.columns."""

SECONDS, BYTES_A_SECOND = 5.0, 1e6
"""Processor time that a file may take: this, and its size at this rate."""

MEMORY = 2_000_000_000
"""Bytes that the process may take beyond what it has when it starts."""


def limit_memory() -> None:
    """No more than `MEMORY` beyond what there is, where the system knows how much that is."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        with open("/proc/self/statm") as stream:
            has = int(stream.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (has + MEMORY, has + MEMORY))


def limit_time(size: int) -> None:
    """End this process where the next file of so many bytes takes too much of a processor's time."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        spent = resource.getrusage(resource.RUSAGE_SELF)
        end = spent.ru_utime + spent.ru_stime + SECONDS + size / BYTES_A_SECOND
        resource.setrlimit(resource.RLIMIT_CPU, (int(end) + 1, resource.getrlimit(resource.RLIMIT_CPU)[1]))


def look_at_mdf(path: str) -> None:
    """Every clock and channel of every channel group; a file that unfolds to more than `MEMORY` ends the process."""
    asammdf = importlib.import_module("asammdf")
    try:
        with asammdf.MDF(path) as file:
            seen, groups = 0, file.groups
            for number, group in enumerate(groups):
                head = group.channel_group
                count = None if head.cycles_nr * head.samples_byte_nr <= WHOLE_BYTES else 1
                with _or_memory():
                    file.get_master(number, record_offset=0, record_count=count)
                for at, channel in enumerate(group.channels):
                    seen += 1
                    if seen <= CHANNELS_AT_MOST:
                        with _or_memory():
                            file.get(channel.name, group=number, index=at, record_offset=0, record_count=count)
    except MemoryError:
        os._exit(1)


@contextlib.contextmanager
def _or_memory() -> Iterator[None]:
    """A block whose errors do not matter, but for a lack of memory."""
    try:
        yield
    except MemoryError:
        raise
    except Exception:  # noqa: BLE001 - whatever a parser says of damaged bytes
        pass


def look_at_hdf5(path: str) -> None:
    """Everything that a reader may touch: groups, attributes, shapes, and values of datasets."""
    import h5py

    with h5py.File(path, "r") as file:
        _attributes(file)
        for node in _below(file):
            _attributes(node)
            if isinstance(node, h5py.Dataset):
                with contextlib.suppress(Exception):
                    _values(node)


def _below(file: Any) -> Iterator[Any]:
    import h5py

    left, seen = [(file, 0)], 0
    while left:
        group, depth = left.pop()
        for name in group:
            seen += 1
            if seen > OBJECTS_AT_MOST:
                return
            with contextlib.suppress(Exception):
                if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                    continue
                node = group[name]
                yield node
                if isinstance(node, h5py.Group) and depth < DEEPEST:
                    left.append((node, depth + 1))


def _attributes(node: Any) -> None:
    with contextlib.suppress(Exception):
        for name in node.attrs:
            with contextlib.suppress(Exception):
                node.attrs[name]


def _values(node: Any) -> None:
    if node.external or node.is_virtual or node.dtype.kind == "O":
        return
    chunk = node.dtype.itemsize
    for side in node.chunks or ():
        chunk *= side
    if chunk > MEMORY:
        return
    if node.size * node.dtype.itemsize <= WHOLE_BYTES:
        node[()]
    else:
        node[tuple(0 for _ in node.shape)]
        node[tuple(side - 1 for side in node.shape)]


def main() -> None:
    """Say that it can look, then look at files of the kind that is named until the input ends."""
    look = {"HDF5": look_at_hdf5, "MDF": look_at_mdf}[sys.argv[1]]
    importlib.import_module({"HDF5": "h5py", "MDF": "asammdf"}[sys.argv[1]])  # before memory is limited
    limit_memory()
    logging.disable(logging.CRITICAL)
    print("ready", flush=True)
    for line in sys.stdin:
        path = json.loads(line)
        with contextlib.suppress(Exception):
            limit_time(os.path.getsize(path))
            look(path)
        print("seen", flush=True)


if __name__ == "__main__":
    main()
