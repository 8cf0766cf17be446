"""How often a fit from a blind start ends at the best optimum: 500 starts of each kind of fit.

    nice -n 10 python -m experiments efficiency.blind            # writes blind.csv and blind.md beside this file

Each start has its own noise. The best optimum is where a fit from the truth ends, or the blind fit where that is lower.
A fit has its cost when it is within 0.01 of it (a tenth of a standard error); it is in its valley when every unknown is
within two standard errors: where an acceleration is fitted, the cost steps by up to ten units whenever a reversal
passes a cell's centre, so that the valley has many bottoms.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from experiments.efficiency.cases import RANGES, Case, eq15, hidden
from experiments.eq15_campaign import tables
from experiments.files import table, write_rows
from undertow.likelihood import multistart as blind
from undertow.likelihood import output_error

IN_MINUTES = "--starts 4 --to {}"
HERE = Path(__file__).parent
NOISE_M = 2e-4
NEAR_COST = 0.01
NEAR_STDERR = 2.0
LEVELS = tuple((spring, depth) for spring in ("long", "short") for depth in tables.WET_DEPTHS_M)


def cases(kind: str) -> tuple[Case, ...]:
    """What a kind is fitted to: Eq. 15 at ten levels, or the body with a hidden oscillator."""
    if kind == "hidden":
        return (hidden(NOISE_M),)
    return tuple(eq15(spring, depth, int(kind), NOISE_M) for spring, depth in LEVELS)


def tried(kind: str, count: int, seed: int = 0) -> list[dict[str, float | str]]:
    """One row a start: the excess of its cost over the best, and where it started."""
    of_kind = cases(kind)
    rows: list[dict[str, float | str]] = []
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        case = of_kind[number % len(of_kind)]
        problem, start = case.noisy(rng), case.start(rng)
        best = output_error.fit(problem, case.truth, growing=False)
        began = time.process_time()
        end = blind.fit(problem, start)
        spent = time.process_time() - began
        away = float(np.max(np.abs(end.values - best.values) / np.sqrt(np.diag(best.covariance))))
        row: dict[str, float | str] = {"kind": kind, "start": number, "level": problem.trials[0].name}
        row |= {"excess": max(end.cost - best.cost, 0.0), "stderr_away": away, "cpu_ms": 1e3 * spent}
        rows.append(row | dict(zip(case.names, start.tolist(), strict=True)))
    return rows


def at_best(rows: Sequence[dict[str, float | str]]) -> int:
    """How many ends have the best cost."""
    return sum(float(row["excess"]) < NEAR_COST for row in rows)


def in_valley(rows: Sequence[dict[str, float | str]]) -> int:
    """How many ends have the best cost, or every unknown within `NEAR_STDERR` of the best."""
    return sum(float(row["excess"]) < NEAR_COST or float(row["stderr_away"]) < NEAR_STDERR for row in rows)


def summary(rows: Sequence[dict[str, float | str]]) -> str:
    """Markdown: share of starts that end at the best optimum, and the time a fit takes, a kind."""
    lines = []
    for kind in dict.fromkeys(str(row["kind"]) for row in rows):
        mine = [row for row in rows if row["kind"] == kind]
        shares = [f"{good} ({100.0 * good / len(mine):.1f} %)" for good in (at_best(mine), in_valley(mine))]
        spent = [float(row["cpu_ms"]) for row in mine]
        name = "hidden oscillator" if kind == "hidden" else f"{kind} unknowns"
        lines.append((name, len(mine), *shares, f"{np.median(spent):.2g}, {max(spent):.2g}"))
    head = ("fit", "starts", "at the best cost", "in its valley", "CPU a fit, ms (median, largest)")
    return table(head, lines)


def main() -> None:
    """Run, write the rows and the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--starts", type=int, default=500)
    parser.add_argument("--kinds", nargs="+", default=["2", "4", "5", "hidden"])
    parser.add_argument("--to", type=Path, default=HERE)
    given = parser.parse_args()
    rows = [row for kind in given.kinds for row in tried(kind, given.starts)]
    names = list(dict.fromkeys(name for row in rows for name in row))
    shown = [[f"{v:.4g}" if isinstance(v, float) else v for v in (row.get(n, "") for n in names)] for row in rows]
    write_rows(given.to / "blind.csv", names, shown)
    ranges = ", ".join(f"{name} {low:g} to {high:g}" for name, (low, high) in RANGES.items())
    text = f"# Blind starts\n\nStarts: {ranges} (units and law in cases.py).\n\n{summary(rows)}\n"
    (given.to / "blind.md").write_text(text)
    print(text)
