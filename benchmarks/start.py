"""The README's command from an empty compiler's cache and once more: seconds stage by stage.

    python -m benchmarks.start                       # configs/flume.yaml; writes benchmarks/start.json
    python -m benchmarks.start configs/eq15.yaml     # another campaign

Cold: numba's cache is an empty folder, so that everything is compiled. Warm: the same command with that cache. Stages
are those of the run's manifest (wall time); "start" is everything before and between them: Python, imports, compiling,
the run folder. Processor time is of the command with its workers and the processes that compile.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

RESULTS = Path(__file__).with_suffix(".json")


def measure(config: Path, out: Path, cache: Path) -> dict[str, float]:
    """One run of the command in a process of its own: wall seconds a stage, of all, and processor seconds."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    words = [sys.executable, "-m", "undertow", "run", str(config), "--out", str(out), "-q"]
    subprocess.run(words, env={**os.environ, "NUMBA_CACHE_DIR": str(cache)}, stdout=subprocess.DEVNULL, check=True)
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    stages: dict[str, float] = json.loads((out / "manifest.json").read_text())["wall_time_s"]
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"start": wall - sum(stages.values()), **stages, "all": wall, "processor": spent}


def main() -> int:
    """Measure cold and warm, print a row a stage and keep it."""
    parser = argparse.ArgumentParser(description="Cold and warm start, stage by stage.")
    parser.add_argument("config", nargs="?", type=Path, default=Path("configs/flume.yaml"))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder, found = Path(name), {}
        for start in ("cold", "warm"):
            found[start] = measure(options.config, folder / start, folder / "cache")
            print(start, {stage: round(seconds, 1) for stage, seconds in found[start].items()}, flush=True)
    RESULTS.write_text(json.dumps({"config": options.config.name, **found}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
