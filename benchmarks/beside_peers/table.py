"""The comparison's rows, its table and its page.

Belongs here: running every method on every set of recordings, and what is made of it. Does not belong here: data
(data.py) and methods (methods.py).
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.beside_peers.data import LARGEST_SCORE, Data, equation_15, hidden
from benchmarks.beside_peers.methods import METHODS, Found

NOISES = ("N1", "N3", "N4")
TRUTHS: dict[str, Callable[[str, int], Data]] = {"Eq. 15": equation_15, "hidden oscillator": hidden}
PERCENTS = ("stiffness_percent", "viscous_percent", "friction_percent", "drag_percent")
HEADER = ("truth", "noise", "seed", "method", "true_terms", "false_terms", *PERCENTS, "held_out_nrmse", "note")
NOTHING = (math.nan,) * len(PERCENTS)


@dataclass(frozen=True)
class Row:
    """One method on one set of recordings: true and false terms kept (nan where it has none), the four coefficients'
    errors in per cent (a term left out: 100), the held-out free run's error."""

    truth: str
    noise: str
    seed: int
    method: str
    true_terms: float
    false_terms: float
    percent: tuple[float, ...]
    held_out: float
    note: str

    def cells(self) -> list[str]:
        """The row as text."""
        numbers = [f"{value:.4g}" for value in (self.true_terms, self.false_terms, *self.percent, self.held_out)]
        return [self.truth, self.noise, str(self.seed), self.method, *numbers, self.note]


def judge(data: Data, method: str, found: Found) -> Row:
    """A method's answer beside the truth."""
    if not found.coefficients:
        return Row(
            data.name, data.noise, data.seed, method, math.nan, math.nan, NOTHING, found.held_out, found.note
        )
    true = sum(name in found.coefficients for name in data.truth)
    percent = tuple(100.0 * abs(found.coefficients.get(name, 0.0) / value - 1.0) for name, value in data.truth.items())
    false = len(found.coefficients) - true
    return Row(data.name, data.noise, data.seed, method, true, false, percent, found.held_out, found.note)


def run(truths: Sequence[str], noises: Sequence[str], seeds: int) -> list[Row]:
    """Every method on every set of recordings; a method that is not installed gets a row that says so."""
    rows = []
    for truth in truths:
        for noise in noises:
            for seed in range(seeds):
                data = TRUTHS[truth](noise, seed)
                rows += [_one(data, method, work) for method, work in METHODS.items()]
                print(truth, noise, seed, file=sys.stderr, flush=True)
    return rows


def _one(data: Data, method: str, work: Callable[[Data], Found]) -> Row:
    try:
        return judge(data, method, work(data))
    except ModuleNotFoundError as absent:
        note = f"not run: {absent.name} is not installed"
        return Row(data.name, data.noise, data.seed, method, math.nan, math.nan, NOTHING, math.nan, note)


def read_rows(path: Path) -> list[Row]:
    """What was kept with `HEADER`."""
    with path.open(newline="") as stream:
        return [
            Row(
                line["truth"], line["noise"], int(line["seed"]), line["method"], float(line["true_terms"]),
                float(line["false_terms"]), tuple(float(line[name]) for name in PERCENTS),
                float(line["held_out_nrmse"]), line["note"],
            )
            for line in csv.DictReader(stream)
        ]  # fmt: skip


def tabulate(rows: Sequence[Row], truth: str) -> str:
    """Markdown: a row a method and noise; the terms kept, the median errors and the free run."""
    lines = [
        "| noise | method | true / false terms | exact | k, c, F, D error, % | held-out nrmse |",
        "|---|---|---|---|---|---|",
    ]
    for noise in NOISES:
        for method in METHODS:
            own = [row for row in rows if (row.truth, row.noise, row.method) == (truth, noise, method)]
            if own:
                lines.append(f"| {noise} | {method} | " + " | ".join(_cells(own)) + " |")
    return "\n".join(lines) + "\n"


def _cells(rows: Sequence[Row]) -> list[str]:
    """Medians over the seeds; how often the support was exact where a method has one."""
    if all(math.isnan(row.held_out) for row in rows):
        return [rows[0].note, "", "", ""]
    error = float(np.median([row.held_out for row in rows]))
    score = "runs away" if error >= LARGEST_SCORE else f"{error:.3f}"
    if math.isnan(rows[0].true_terms):
        return [rows[0].note, "", "", score]
    true, false = (float(np.median([getattr(row, name) for row in rows])) for name in ("true_terms", "false_terms"))
    exact = sum(row.true_terms == len(PERCENTS) and row.false_terms == 0 for row in rows)
    percent = np.median([row.percent for row in rows], axis=0)
    errors = ", ".join(f"{value:.2g}" if value < 1000.0 else "> 1000" for value in percent)
    return [f"{true:.0f} / {false:.0f}", f"{exact} of {len(rows)}", errors, score]


PAGE = """# undertow beside its peers

Same recordings, same library of ten terms, one run, made by

    python -m benchmarks.beside_peers

Medians over {seeds} seeds. Short spring, 1 kHz, 14 bits, drift, offsets; noise on x and a: N1 0.05 mm, 0.02 m/s2; N3
0.2 mm, 0.1 m/s2; N4 1 mm, 0.1 m/s2. Everyone gets three releases, cut from the release to where the motion ends and
taken about the rest position, and is scored by a free run from where it was held on a fourth (24 mm) that nobody saw;
its release's lateness (up to 0.1 s), rest (2 mm) and x0 (2 %) are fitted for every method alike. nrmse is the RMS
error over the RMS displacement; the sensor's noise alone is 0.006, 0.024 and 0.12 of it. Errors are those of k, c,
friction and drag over mass; a term left out counts 100 %.

How each is run: pysindy 2.1 gets displacement, v by (smoothed) differences, and differences again for itself; weak form
with 200 test functions on the largest trial; STLSQ and SR3 with their defaults; the ensemble is 20 bags of STLSQ. *On
our signals*: the smoothed x, v, a that undertow regresses, STLSQ with its default threshold, and on columns scaled to
unit deviation with a threshold of 1 %. SysIdentPy 0.9.0 fits a polynomial NAR model of degree 3 to the largest trial at
50 Hz; it has no physical terms. undertow selects among the ten terms, by regression or on trajectories (`Discover`), or
takes Eq. 15's four and searches for what they leave out (`undertow.diagnose`, told that trials repeat, which every
method assumes).

## The truth is Eq. 15

{eq15}
## The truth has 300 kg of hidden water at 9.6 rad/s

Eq. 15's four terms are all there, and not enough.

{hidden}
## In one line each

{says}
"""


def write_page(rows: Sequence[Row], path: Path) -> None:
    """docs/peers.md from the rows."""
    tables = {name: tabulate(rows, truth) for name, truth in (("eq15", "Eq. 15"), ("hidden", "hidden oscillator"))}
    path.write_text(PAGE.format(seeds=len({row.seed for row in rows}), says=_says(rows), **tables))


def _says(rows: Sequence[Row]) -> str:
    """Ours beside the best peer on its own signals, on the held-out trial."""
    lines = []
    for truth in TRUTHS:
        for noise in NOISES:
            median = {}
            for method in METHODS:
                own = [r.held_out for r in rows if (r.truth, r.noise, r.method) == (truth, noise, method)]
                if own and not all(math.isnan(value) for value in own):
                    median[method] = float(np.median(own))
            if median:
                ours = min((m for m in median if m.startswith("undertow")), key=median.__getitem__)
                best = min((m for m in median if m.startswith(("pysindy,", "SysIdentPy"))), key=median.__getitem__)
                lines.append(
                    f"- {truth}, {noise}: {median[ours]:.3g} ({ours}); best peer on its own signals "
                    f"{median[best]:.3g} ({best})."
                )
    return "\n".join(lines)
