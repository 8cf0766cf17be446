"""Trials a second of ``undertow run`` on one and two workers, joblib's processes (loky) and a Dask cluster.

    python -m benchmarks.throughput 1000                  # light: output error, baseline, free runs; no search
    python -m benchmarks.throughput --search 100          # every method and every suspect
    python -m benchmarks.throughput --only loky:2 10000   # one engine

Campaigns are those of `campaign_scale`. Each row runs in a process of its own, after a campaign of 32 trials that goes
through the same workers (they have loaded or compiled their code), without the page. Wall time from config to tables,
processor time of the process and its workers, peak memory of the process and of its largest worker; results are kept
in benchmarks/throughput.json. With one worker loky is the process itself.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks import campaign_scale as scale
from experiments.revision import revision
from tests.local_cluster import local_cluster
from undertow.campaign.config import load
from undertow.campaign.run import run
from undertow.campaign.run.cluster import on_cluster
from undertow.campaign.run.folder import run_to_folder

RESULTS = Path(__file__).with_suffix(".json")
ENGINES = ("loky:1", "loky:2", "dask:1", "dask:2")


def measure_here(engine: str, folder: Path, kind: str) -> dict[str, float]:
    """One campaign in this process and its workers."""
    name, workers = engine.split(":")
    if name == "dask":
        with local_cluster(int(workers)) as cluster, on_cluster(cluster.address):
            return _counted(folder, kind, 0, cluster.workers)
    return _counted(folder, kind, int(workers), ())


def _counted(folder: Path, kind: str, jobs: int, others: tuple[int, ...]) -> dict[str, float]:
    """Wall and processor seconds, and peak memory in MB, ``others`` being workers that are no children."""
    run(load(scale.make(folder / "warm", scale.WARM, scale.CONFIGS[kind])), jobs=jobs)

    def cpu() -> float:
        return scale.cpu_s() + sum(scale.worker(one)[0] for one in others)

    before, began = cpu(), time.perf_counter()
    with scale.page_apart(False):
        finished = run_to_folder(folder / "campaign" / "config.yaml", out=folder / "out", jobs=jobs)
    peaks = [peak for _, peak in scale.workers()] + [scale.worker(one)[1] for one in others]
    wall, found = time.perf_counter() - began, float(finished.extent.trials)
    return {
        "found": found, "failed": float(len(finished.failed)), "wall_s": wall, "cpu_s": cpu() - before,
        "trials_a_second": found / wall, "peak_MB": scale.peak_mb(), "largest_worker_MB": max(peaks, default=0.0),
    }  # fmt: skip


def measure(engine: str, trials: int, kind: str) -> dict[str, Any]:
    """One row, in a process of its own, recordings in a temporary folder."""
    with tempfile.TemporaryDirectory() as name:
        scale.make(Path(name) / "campaign", trials, scale.CONFIGS[kind])
        words = [sys.executable, "-m", "benchmarks.throughput", "--here", engine, name, kind]
        said = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True)
    return {"kind": kind, "engine": engine, "trials": trials, **json.loads(said.stdout.splitlines()[-1])}


def main() -> int:
    """Measure what is asked for, print a line each and keep it."""
    parser = argparse.ArgumentParser(description="Trials a second by engine.")
    parser.add_argument("trials", nargs="*", type=int, default=[], help="numbers of trials, light configuration")
    parser.add_argument("--search", nargs="*", type=int, default=[], help="the same with every method and suspect")
    parser.add_argument("--only", choices=ENGINES, help="one engine")
    parser.add_argument("--here", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.here:
        engine, folder, kind = options.here
        print(json.dumps(measure_here(engine, Path(folder), kind)))
        return 0
    asked = [("light", n) for n in options.trials] + [("full", n) for n in options.search]
    for kind, trials in asked:
        for engine in (options.only,) if options.only else ENGINES:
            new = measure(engine, trials, kind) | {"revision": revision()}
            print(json.dumps(new), flush=True)
            older = json.loads(RESULTS.read_text()) if RESULTS.exists() else []
            same = ("kind", "engine", "trials", "revision")
            rows = [one for one in older if any(one[k] != new[k] for k in same)] + [new]
            RESULTS.write_text(json.dumps(sorted(rows, key=lambda r: [r[k] for k in same]), indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
