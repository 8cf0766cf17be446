"""Whether a run may take a folder: one run at a time, and none where files would be replaced that no run has written.

Belongs here: the lock, which ends with its process, what a process that was killed left half written, the refusal.
Does not belong here: the folder's files (folder.py).
"""

from __future__ import annotations

import os
import platform
import shutil
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from undertow.campaign.config import load
from undertow.campaign.config.source import read_source
from undertow.errors import ConfigError, UndertowError

LOCK = ".lock"
"""The file that is locked while a run is at work; it is gone afterwards, and of no consequence where it is left."""

CONFIG = "config.yaml"
"""The config as a run keeps it."""

STAGES = "stages"
"""The folder of a run's finished parts."""

NEW = ".new."
"""How the name of the folder begins in which a run's files wait until all of them are written."""


@contextmanager
def claimed(folder: Path) -> Iterator[None]:
    """The folder for this process alone; half-written files of processes that were killed in it are removed.

    Raises UndertowError where another run is at work in it.
    """
    path = folder / LOCK
    handle = _locked(path)
    try:
        os.truncate(handle, 0)
        os.write(handle, f"{os.getpid()} on {platform.node()}".encode())
        for left in (*folder.glob(".*.part"), *(folder / STAGES).glob(".*.part")):
            left.unlink(missing_ok=True)
        for unfinished in folder.glob(f"{NEW}*"):
            shutil.rmtree(unfinished, ignore_errors=True)
        yield
    finally:
        path.unlink(missing_ok=True)
        os.close(handle)


def _locked(path: Path) -> int:
    """An open and locked file of that name. A lock on a file that its owner has removed meanwhile is none."""
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            _lock(handle)
        except OSError as reason:
            owner = os.read(handle, 200).decode(errors="replace")
            os.close(handle)
            by = f" (process {owner})" if owner else ""
            raise UndertowError(
                f"run folder {path.parent} is in use by another run{by}; wait for it, or choose another with --out"
            ) from reason
        try:
            if os.fstat(handle).st_ino == os.stat(path).st_ino:
                return handle
        except FileNotFoundError:
            pass
        os.close(handle)


if sys.platform == "win32":  # pragma: no cover

    def _lock(handle: int) -> None:
        import msvcrt

        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)

else:

    def _lock(handle: int) -> None:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


def refuse_foreign_files(folder: Path, config_path: Path, names: Sequence[str], marks: Sequence[str]) -> None:
    """Nothing where ``folder`` is a run's own, which one of the ``marks`` in it says, or holds none of the ``names``
    that a run writes.

    Raises UndertowError with the files that would be replaced: a list of trials is often called trials.csv, and stands
    where somebody wants the results.
    """
    if any((folder / mark).exists() for mark in marks):
        return
    there = [name for name in names if (folder / name).exists()]
    kept = folder / CONFIG
    if kept.exists() and not kept.samefile(config_path) and not _of_a_run(kept):
        there.append(CONFIG)
    if there:
        raise UndertowError(
            f"run folder {folder} holds {', '.join(there)}, which no run has written and this one would replace; "
            "choose another folder with --out"
        )


def _of_a_run(config: Path) -> bool:
    """Whether a config is in the resolved form in which a run keeps it."""
    try:
        return bool(load(config).resolved() == read_source(config).data)
    except ConfigError:
        return False
