"""`python -m experiments driven.closed_loop`: output error beside an instrument, on carriages in closed loop.

The force of a controller answers to what pushes the carriage and is not recorded. Where nothing does, both estimates
are right; where much does, output error is drawn to one side, and the instrument (the controller's target) is not.

Belongs here: these cases, the table of docs/driven_measured.md. Does not belong here: bodies (bodies.py), the estimate
(methods/driven_instrument.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from experiments.driven.bodies import GIVEN, body, record
from experiments.driven.page import kept
from undertow.equation.driven_laws import find_driven
from undertow.errors import IdentificationError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import fit_driven
from undertow.methods.driven_instrument import APART, beside_instrument
from undertow.methods.driven_strokes import vary_by_stroke

RESULT = Path(__file__).with_name("closed_loop.csv")
HEADER = ("pushed_N", "seed", "number", "truth", "output_error", "stderr", "instrument", "instrument_stderr", "apart")
HEADER += ("by_stroke", "by_stroke_stderr")
PUSHES_N = (0.0, 5.0, 20.0)
"""Root mean square of the push that nobody records; friction is 12 to 32 N."""
SEEDS = range(4000, 4012)
"""Carriages. The estimate was set on the seeds 3000 to 3005; that errors hold what bumps of the next length say came of
the calm ones of these."""
SAMPLES = 20000
"""100 s: forty strokes."""


def rows(pushed_N: float, seed: int) -> list[tuple[str, ...]]:
    """One carriage's numbers, a line each."""
    one = body("carriage", seed)
    trial = record(one, 0.0, pushed_N, SAMPLES)
    fitted = fit_driven([trial], DrivenLaws(tuple(find_driven(name) for name in GIVEN["carriage"])))
    both = beside_instrument(trial, fitted)
    try:
        varying = vary_by_stroke([trial], fitted)
    except IdentificationError:
        varying = fitted
    own = dict(zip(varying.names, zip(varying.values, np.sqrt(np.diag(varying.covariance)), strict=True), strict=True))
    out = []
    for name, found in both.instrument.items():
        other = both.output_error[name]
        estimates = (other.value, other.stderr, found.value, found.stderr, both.apart[name], *own[name])
        numbers = (one.numbers[name], *estimates)
        out.append((f"{pushed_N:g}", str(seed), name, *(f"{number:.6g}" for number in numbers)))
    return out


def table(lines: Sequence[Sequence[str]]) -> str:
    """Markdown: by push and number, errors of the estimates, mean and root mean square, and how many are apart."""
    out = [
        "| push, N | number | output error: mean error, rms error, stated error | by the instrument | apart | output "
        "error by stroke |",
        "|---|---|---|---|---|---|",
    ]
    for push, name in dict.fromkeys((line[0], line[2]) for line in lines):
        own = np.array([line[3:] for line in lines if (line[0], line[2]) == (push, name)], dtype=np.float64)
        truth, shown = own[:, 0], []
        for value, stated in ((own[:, 1], own[:, 2]), (own[:, 3], own[:, 4]), (own[:, 6], own[:, 7])):
            away, size = value - truth, float(np.mean(np.abs(truth)))
            parts = (np.mean(away), np.sqrt(np.mean(away**2)), np.sqrt(np.mean(stated**2)))
            shown.append(", ".join(f"{100.0 * part / size:.2g} %" for part in parts))
        far = int(np.count_nonzero(own[:, 5] > APART))
        out.append(f"| {push} | {name} | {shown[0]} | {shown[1]} | {far} of {len(own)} | {shown[2]} |")
    return "\n".join(out)


def main() -> None:
    """Every case, the file and the page's table."""
    lines = []
    for push in PUSHES_N:
        for seed in SEEDS:
            lines += rows(push, seed)
            print(push, seed, flush=True)
    kept(RESULT, HEADER, lines, table, "closed loop")
