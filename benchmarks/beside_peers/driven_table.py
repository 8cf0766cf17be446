"""Rounds of the driven comparison, its csv and its table in docs/driven_measured.md.

    python -m benchmarks.beside_peers driven                     # three rounds, all sets, all methods
    python -m benchmarks.beside_peers driven --rounds 1 --sets emps --out somewhere

Methods take turns, so that a busy machine counts alike for all; the time is CPU time of one fit, warm, median over the
rounds. A fit that takes more than `ONCE_S` is not repeated, one that takes `LIMIT_S` is ended and has no result.

Belongs here: time limit, order, rows, table. Does not belong here: methods (driven_methods.py), data (driven_sets.py).
"""

from __future__ import annotations

import csv
import math
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import numpy as np

from benchmarks.beside_peers.driven_methods import METHODS, Method
from benchmarks.beside_peers.driven_sets import NAMES, DrivenSet, load, score

LIMIT_S = 300.0
ONCE_S = 5.0
HEADER = ("set", "method", "unit", "error", "median_s", "ratio", "fits", "note")
OURS = next(iter(METHODS))
"""The method whose time the others are compared with."""


@dataclass(frozen=True)
class DrivenRow:
    """One method on one set: free-run error in the set's unit (inf: ran away, nan: no result), median CPU seconds of a
    fit, ratio to `OURS`, number of fits, and a note where there is no result."""

    name: str
    method: str
    unit: str
    error: float
    median_s: float
    ratio: float
    fits: int
    note: str = ""

    def cells(self) -> list[str]:
        """The row as text."""
        numbers = [f"{value:.4g}" for value in (self.error, self.median_s, self.ratio)]
        return [self.name, self.method, self.unit, *numbers, str(self.fits), self.note]


class _TooLongError(Exception):
    """A fit took its limit."""


def _stop(_number: int, _frame: FrameType | None) -> None:
    raise _TooLongError


def timed(method: Method, data: DrivenSet, limit: float = LIMIT_S) -> tuple[float, float, str]:
    """CPU seconds of one fit, the free run's error and a note where there is none."""
    before = signal.signal(signal.SIGPROF, _stop)
    signal.setitimer(signal.ITIMER_PROF, limit)
    began = time.process_time()
    try:
        run = method(data)
        spent = time.process_time() - began
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        return spent, score(data, *run()), ""
    except _TooLongError:
        return math.nan, math.nan, f"ended after {limit:g} s"
    except ModuleNotFoundError as absent:
        return math.nan, math.nan, f"not run: {absent.name} is not installed"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def compare(data: DrivenSet, rounds: int, limit: float = LIMIT_S) -> list[DrivenRow]:
    """A row a method on one set."""
    METHODS[OURS](data)  # what is compiled is on disk, and loaded
    times: dict[str, list[float]] = {name: [] for name in METHODS}
    results: dict[str, tuple[float, str]] = {}
    for turn in range(rounds):
        for name, method in METHODS.items():
            if turn and not times[name][0] < ONCE_S:
                continue
            spent, error, note = timed(method, data, limit)
            times[name].append(spent)
            results.setdefault(name, (error, note))
            print(f"{data.name}: {name}: {error:.4g} {data.unit}, {spent:.3g} s {note}", file=sys.stderr, flush=True)
    own = float(np.median(times[OURS]))
    return [
        DrivenRow(
            data.name, name, data.unit, results[name][0], float(np.median(spent)), float(np.median(spent)) / own,
            len(spent), results[name][1],
        )
        for name, spent in times.items()
    ]  # fmt: skip


def read_rows(path: Path) -> list[DrivenRow]:
    """What was kept with `HEADER`."""
    with path.open(newline="") as stream:
        return [
            DrivenRow(
                line["set"], line["method"], line["unit"], float(line["error"]), float(line["median_s"]),
                float(line["ratio"]), int(line["fits"]), line["note"],
            )
            for line in csv.DictReader(stream)
        ]  # fmt: skip


def tabulate(rows: Sequence[DrivenRow]) -> str:
    """Markdown: a line a method, error and time of every set beside each other."""
    names = [name for name in NAMES if any(row.name == name for row in rows)]
    units = {row.name: row.unit for row in rows}
    heads = [f"{name}, {units[name]} | s | ratio" for name in names]
    lines = ["| method | " + " | ".join(heads) + " |", "|---" * (1 + 3 * len(names)) + "|"]
    for method in dict.fromkeys(row.method for row in rows):
        cells = [_cells(next(row for row in rows if (row.name, row.method) == (name, method))) for name in names]
        lines.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _cells(row: DrivenRow) -> str:
    if row.note:
        return f"{row.note} | | "
    error = f"{row.error:.3g}" if math.isfinite(row.error) else "runs away"
    return f"{error} | {row.median_s:.2g} | {row.ratio:.2g}"


def run(names: Sequence[str], rounds: int) -> list[DrivenRow]:
    """Every method on every set."""
    return [row for name in names for row in compare(load(name), rounds)]
