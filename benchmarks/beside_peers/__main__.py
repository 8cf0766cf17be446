"""undertow beside its peers on the same recordings: support, coefficients, free run on a trial nobody saw.

    python -m benchmarks.beside_peers                          # all methods, two truths, three noises, three seeds
    SYSIDENTPY_FOLDER=... python -m benchmarks.beside_peers    # SysIdentPy from a folder of its own
    python -m benchmarks.beside_peers --seeds 1 --noises N3 --out somewhere
    python -m benchmarks.beside_peers driven                   # three public driven benchmarks, three rounds

writes results.csv (a row a method, truth, noise and seed) and docs/peers.md; ``driven`` writes driven.csv and its table
in docs/driven_measured.md. SysIdentPy is installed apart from our own environment, ``pip install --no-deps --target
FOLDER sysidentpy==0.9.0``, or, for ``driven``, with jax-sysid in an environment of their own; without them their rows
say so.

Belongs here: the command. Does not belong here: data (data.py, driven_sets.py), methods (methods.py,
driven_methods.py), tables (table.py, driven_table.py).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.beside_peers import driven_table
from benchmarks.beside_peers.driven_sets import NAMES
from benchmarks.beside_peers.kept import write_rows
from benchmarks.beside_peers.table import HEADER, NOISES, TRUTHS, read_rows, run, write_page
from experiments.driven.page import put

FOLDER = Path(__file__).resolve().parent
DOCS = FOLDER.parents[1] / "docs"
SEEDS = 3
ROUNDS = 3


def main(arguments: list[str] | None = None) -> int:
    """Run the comparison and write its rows and its page."""
    parser = argparse.ArgumentParser(description="undertow beside its peers.")
    parser.add_argument("what", nargs="?", choices=("decays", "driven"), default="decays")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="driven: fits of each method, in turns")
    parser.add_argument("--sets", nargs="+", choices=NAMES, default=NAMES, help="driven: benchmarks")
    parser.add_argument("--seeds", type=int, default=SEEDS)
    parser.add_argument("--noises", nargs="+", choices=NOISES, default=NOISES)
    parser.add_argument("--out", type=Path, help="folder for both files; by default this one and docs/")
    options = parser.parse_args(arguments)
    if options.what == "driven":
        return _driven(options.sets, options.rounds, options.out)
    results = (options.out or FOLDER) / "results.csv"
    write_rows(run(tuple(TRUTHS), options.noises, options.seeds), HEADER, results)
    write_page(read_rows(results), (options.out or DOCS) / "peers.md")
    return 0


def _driven(names: Sequence[str], rounds: int, out: Path | None) -> int:
    """Driven rows, and the table in docs/driven_measured.md; with a folder of one's own both go there."""
    results = (out or FOLDER) / "driven.csv"
    write_rows(driven_table.run(names, rounds), driven_table.HEADER, results)
    table = driven_table.tabulate(driven_table.read_rows(results))
    if out:
        (out / "driven.md").write_text(table + "\n", encoding="utf-8")
    else:
        put(table, "peers")
    return 0


if __name__ == "__main__":
    sys.exit(main())
