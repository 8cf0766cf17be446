"""A run folder that already holds files which no run has written: they are never replaced.

Belongs here: what is a run's own, and the refusal. Does not belong here: writing (folder.py), the lock (claim.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from undertow.campaign.config import load
from undertow.campaign.config.source import read_source
from undertow.errors import ConfigError, UndertowError

CONFIG = "config.yaml"


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


__all__ = ["refuse_foreign_files"]
