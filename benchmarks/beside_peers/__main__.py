"""undertow beside its peers on the same recordings: support, coefficients, free run on a trial nobody saw.

    python -m benchmarks.beside_peers                          # all methods, two truths, three noises, three seeds
    SYSIDENTPY_FOLDER=... python -m benchmarks.beside_peers    # SysIdentPy from a folder of its own
    python -m benchmarks.beside_peers --seeds 1 --noises N3 --out somewhere

writes results.csv (a row a method, truth, noise and seed) and docs/peers.md. SysIdentPy is installed apart from our own
environment, ``pip install --no-deps --target FOLDER sysidentpy==0.9.0``; without it its row says so.

Belongs here: the command. Does not belong here: data (data.py), methods (methods.py), the table (table.py).
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from benchmarks.beside_peers.table import NOISES, TRUTHS, read_rows, run, write_page, write_rows

FOLDER = Path(__file__).resolve().parent
DOCS = FOLDER.parents[1] / "docs"
SEEDS = 3


def main(arguments: list[str] | None = None) -> int:
    """Run the comparison and write its rows and its page."""
    parser = argparse.ArgumentParser(description="undertow beside its peers.")
    parser.add_argument("--seeds", type=int, default=SEEDS)
    parser.add_argument("--noises", nargs="+", choices=NOISES, default=NOISES)
    parser.add_argument("--out", type=Path, help="folder for both files; by default this one and docs/")
    options = parser.parse_args(arguments)
    results = (options.out or FOLDER) / "results.csv"
    write_rows(run(tuple(TRUTHS), options.noises, options.seeds), results)
    write_page(read_rows(results), (options.out or DOCS) / "peers.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
