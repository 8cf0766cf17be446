"""How close to the Cramer-Rao bound output error is: std over bound and bias over bound of every unknown.

    nice -n 10 python -m experiments efficiency.bound        # 1,000 realisations; writes efficiency.md and .csv here

The bound is the covariance at the truth from the exact sensitivities. Fits start up to three bounds from the truth:
that every blind start arrives at the same optimum is blind.py's business.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from experiments.efficiency.cases import Case, eq15, hidden
from experiments.files import write_rows
from undertow.likelihood import output_error

IN_MINUTES = "--realisations 4 --to {}"
HERE = Path(__file__).parent
LEVELS = (("long", 2.57), ("short", 2.36))
NOISES_M = (1e-4, 1e-3)
START_AWAY = 3.0
LIMITS = {"eq15": (0.92, 1.08, 0.12), "hidden": (0.92, 1.15, math.inf)}
"""Smallest and largest std over bound, largest |bias| over bound."""


def all_cases() -> list[tuple[str, Case, tuple[float, float, float]]]:
    """Every study: what it is, the case, its limits."""
    found = [
        (f"{spring} {depth:g} m, {count} unknowns, {1e3 * noise:g} mm", eq15(spring, depth, count, noise),
         LIMITS["eq15"])
        for spring, depth in LEVELS for count in (2, 4, 5) for noise in NOISES_M
    ]  # fmt: skip
    return found + [(f"hidden oscillator, {1e3 * noise:g} mm", hidden(noise), LIMITS["hidden"]) for noise in NOISES_M]


def efficiency(case: Case, count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Std over bound and bias over bound (p,) over ``count`` realisations of the noise."""
    exact = output_error.residuals(case.problem.trials[0], case.truth)
    if exact is None:
        raise ValueError(f"no motion at the truth {case.truth.tolist()}; the case is wrong")
    bound = np.sqrt(np.diag(np.linalg.inv(exact[1].T @ exact[1])))
    ends = []
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        problem = case.noisy(rng)
        start = case.truth + START_AWAY * bound * rng.uniform(-1.0, 1.0, case.truth.size)
        ends.append(output_error.fit(problem, start).values)
    errors = (np.array(ends) - case.truth) / bound
    return errors.std(axis=0, ddof=1), errors.mean(axis=0)


def rows(count: int, studies: Iterable[tuple[str, Case, tuple[float, float, float]]]) -> list[dict[str, object]]:
    """One row an unknown."""
    table: list[dict[str, object]] = []
    for name, case, (low, high, bias_limit) in studies:
        spread, bias = efficiency(case, count)
        for unknown, s, b in zip(case.names, spread, bias, strict=True):
            within = bool(low <= s <= high and abs(b) <= bias_limit)
            table.append({"fit": name, "unknown": unknown, "std": s, "bias": b, "within": within, "count": count})
    return table


def markdown(table: list[dict[str, object]]) -> str:
    """A row a fit: std / bound and bias / bound of every unknown; bold where it is outside the limits."""
    count = table[0]["count"]
    lines = [
        "# Efficiency of output error", "",
        f"{count} realisations of white noise; std over the Cramer-Rao bound (bias over it). Limits: 0.92 to 1.08 and",
        "0.12, hidden oscillator 0.92 to 1.15; bold: outside.", "", "| fit | std / bound (bias / bound) |", "|---|---|",
    ]  # fmt: skip
    for fit in dict.fromkeys(str(row["fit"]) for row in table):
        cells = []
        for row in table:
            if row["fit"] == fit:
                mark = "" if row["within"] else "**"
                cells.append(f"{row['unknown']} {mark}{row['std']:.3f} ({row['bias']:+.3f}){mark}")
        lines.append(f"| {fit} | {', '.join(cells)} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run, write table and page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--realisations", type=int, default=1000)
    parser.add_argument("--to", type=Path, default=HERE)
    given = parser.parse_args()
    table = rows(given.realisations, all_cases())
    shown = [[f"{v:.4g}" if isinstance(v, float) else v for v in row.values()] for row in table]
    write_rows(given.to / "efficiency.csv", table[0], shown)
    (given.to / "efficiency.md").write_text(markdown(table))
    print(markdown(table))
