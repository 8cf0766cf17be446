"""A Dask cluster on this machine for tests: a scheduler and workers in processes of their own.

As a program it prints the scheduler's address and then the workers' process ids, and ends with its standard input.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass


@dataclass(frozen=True)
class Cluster:
    """Where the scheduler answers, and its workers' processes."""

    address: str
    workers: tuple[int, ...]


@contextmanager
def local_cluster(workers: int) -> Iterator[Cluster]:
    """A cluster of so many workers of one thread each."""
    words = [sys.executable, "-m", "tests.local_cluster", str(workers)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        address, *pids = process.stdout.readline().split()
        try:
            yield Cluster(address, tuple(map(int, pids)))
        finally:
            process.stdin.close()


def main() -> None:
    """Serve until standard input ends."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=int(sys.argv[1]), threads_per_worker=1, dashboard_address=None, silence_logs="CRITICAL"
    ) as cluster, cluster.get_client() as client:  # fmt: skip
        import os

        pids = client.run(os.getpid).values()
        print(cluster.scheduler_address, *pids, flush=True)
        sys.stdin.read()


if __name__ == "__main__":
    main()
