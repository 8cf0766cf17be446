"""Processor time of the search for what is missing, of one revision beside another: of each level, of the command.

    python -m benchmarks.search_speed CONFIG                                    this revision
    python -m benchmarks.search_speed CONFIG --beside PYTHON --config OLD       and another environment's after it

One process, one BLAS thread; ``diagnose`` is timed where the judge calls it. Ratios are of two runs one after the
other.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

TIMED = """
import sys, time
import undertow.discrepancy.judge as judge
search, spent = judge.diagnose, []
def timed(*args, **kwargs):
    before = time.process_time()
    try:
        return search(*args, **kwargs)
    finally:
        spent.append(time.process_time() - before)
judge.diagnose = timed
from undertow.cli import main
sys.argv = ["undertow", "run", sys.argv[1], "--out", sys.argv[2], "--jobs", "1"]
try:
    main()
finally:
    print("TIMES", time.process_time(), *spent)
"""


COMPILED = "import undertow.equation.kernel"


def times(python: str, config: Path) -> list[float]:
    """Processor time of the whole command and of each level's search, s, of one environment, compiled before."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MPLBACKEND": "Agg"}
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([python, "-c", COMPILED], capture_output=True, env=environment, check=True)
        command = [python, "-c", TIMED, str(config.resolve()), str(Path(folder) / "run")]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False, cwd=folder)
    lines = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("TIMES")]
    if not lines:
        raise SystemExit(f"{python}: {config} ended with {done.returncode}: {done.stderr[-300:]}")
    return [float(value) for value in lines[-1]]


def main() -> None:
    """Print this revision's times, and another's beside them with their ratio."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("config", type=Path)
    parser.add_argument("--beside", help="another environment's python")
    parser.add_argument("--config", dest="other", type=Path, help="the config there, where another")
    given = parser.parse_args()
    mine = times(sys.executable, given.config)
    print(f"search {sum(mine[1:]):.1f} s, whole command {mine[0]:.1f} s; levels", *(f"{t:.1f}" for t in mine[1:]))
    if given.beside:
        theirs = times(given.beside, given.other or given.config)
        print(f"beside {sum(theirs[1:]):.1f} s, {theirs[0]:.1f} s; levels", *(f"{t:.1f}" for t in theirs[1:]))
        print(f"ratio of the search {sum(mine[1:]) / sum(theirs[1:]):.2f}, of the command {mine[0] / theirs[0]:.2f}")


if __name__ == "__main__":
    main()
