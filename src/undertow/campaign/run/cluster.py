"""A run's work on a user's Dask cluster: any work on processes inside goes to its workers, through joblib.

Workers read recordings, and write finished parts, by the paths that this process names, so that both must see the same
folders; they must have the same undertow. A worker that dies is replaced, and what it had is done again.

Belongs here: the connection. Does not belong here: the work (workers.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, cast

import joblib

from undertow.campaign.run.manifest import package_versions, source_digest
from undertow.errors import ConfigError, UndertowError

PATIENCE_S = 30.0
"""How long a scheduler is waited for: one on this machine answers within a second."""


@contextmanager
def on_cluster(address: str) -> Iterator[None]:
    """Inside, joblib's work goes to the workers of the scheduler at ``address``; nowhere else where that is empty.

    Raises ConfigError where Dask is not installed, the scheduler cannot be reached, has no workers, or one of them has
    another undertow; UndertowError where a piece of work ended one worker after the other.
    """
    if not address:
        yield
        return
    try:
        from distributed import Client, KilledWorker
    except ImportError as reason:
        raise ConfigError("--scheduler needs Dask, which is not installed; pip install 'undertow[dask]'") from reason
    try:
        client: Any = cast(Any, Client)(address, timeout=PATIENCE_S)
    except (OSError, ValueError, TypeError, AssertionError) as reason:  # the last: its own loop did not start in time
        why = str(reason) or type(reason).__name__
        raise ConfigError(
            f"--scheduler {address!r} cannot be reached ({why}); give the address that the scheduler printed, such as "
            "tcp://host:8786"
        ) from reason
    with client:
        _alike(client.run(made_by), address)
        with joblib.parallel_config("dask", client=client):
            try:
                yield
            except KilledWorker as reason:
                raise UndertowError(
                    f"{reason.task} ended worker after worker of {address} (memory, most often); give workers more of "
                    "it, then run again with --resume"
                ) from reason


def made_by() -> tuple[str, dict[str, str]]:
    """What decides a number where it is calculated: this code, and the packages that calculate."""
    return source_digest(), dict(package_versions())


def _alike(workers: dict[str, tuple[str, dict[str, str]]], address: str) -> None:
    """ConfigError where there is no worker, or one would give other numbers than this process."""
    if not workers:
        raise ConfigError(f"--scheduler {address!r} has no workers; start some, with: dask worker {address}")
    code, packages = made_by()
    for worker, (theirs, installed) in workers.items():
        others = [f"{name} {installed.get(name)} (here {own})" for name, own in packages.items()
                  if installed.get(name) != own]  # fmt: skip
        if theirs != code or others:
            what = ", ".join(others) or "other sources of undertow"
            raise ConfigError(f"worker {worker} of {address} has {what}; install the same there as here")
