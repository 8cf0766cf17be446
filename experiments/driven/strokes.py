"""`python -m experiments driven.strokes [--emps]`: carriages whose offset and friction vary from stroke to stroke.

Each is fitted to one record of 25 s (ten strokes) by output error, and beside that with deviations by stroke where the
record asks for them; both are run free on fresh records of the same carriage. With --emps EMPS' training record stands
in their place: parts of it are left out in turn, and run free from their first samples.

Belongs here: these cases, the tables of docs/driven_measured.md. Does not belong here: bodies (bodies.py), the fit
(methods/driven_strokes.py).
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.beside_peers.driven_sets import load
from experiments.driven.bands import motion_of
from experiments.driven.bodies import GIVEN, body, record
from experiments.driven.page import kept, put
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_laws import find_driven
from undertow.errors import IdentificationError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import DrivenFit, fit_driven
from undertow.methods.driven_begin import START_SAMPLES
from undertow.methods.driven_equations import predict_driven, read_back, written
from undertow.methods.driven_strokes import vary_by_stroke

RESULT = Path(__file__).with_name("strokes.csv")
HEADER = (
    "case", "seed", "taken", "offset_N", "friction_N", "away", "away_by_stroke", "missed_m", "missed_by_stroke_m",
    "covered", "covered_by_stroke",
)  # fmt: skip
CASES = {
    "nothing varies": (0.0, (0.0, 0.0)),
    "offset 0.3 N": (0.0, (0.3, 0.0)),
    "friction 0.3 N": (0.0, (0.0, 0.3)),
    "offset 1 N, friction 0.5 N": (0.0, (1.0, 0.5)),
    "drive wanders 0.1 N in a second": (0.1, (0.0, 0.0)),
}
"""What the drive wanders by, and what offset and friction vary by, N."""
SEEDS = range(9000, 9012)
"""Carriages that no rule was set on: rules are EMPS' and of the seeds 3000 to 3005."""
FRESH = 2
EMPS_LAWS = (*GIVEN["carriage"], "asymmetric_damping")
PARTS, LENGTHS_S, FEWEST_SAMPLES = 6, (5.0, 8.0), 300
"""Parts of EMPS' record that are left out in turn, how long they are (of longer ones fewer than six strokes are left),
and what else is too short to be fitted."""


def line_of(case: str, seed: int) -> tuple[str, ...]:
    """One carriage: standard deviations that were found, rms of errors over stated errors, and on fresh records the
    error of the free run and the share of samples in its band; without deviations by stroke and with them."""
    wanders, varies = CASES[case]
    one = body("carriage", seed)
    trial, *fresh = (record(one, wanders, again=i, varies_N=varies) for i in range(1 + FRESH))
    fitted = fit_driven([trial], DrivenLaws(tuple(find_driven(name) for name in GIVEN["carriage"])))
    try:
        varying, taken = vary_by_stroke([trial], fitted), "yes"
    except IdentificationError:
        varying, taken = fitted, "no"
    spreads = (0.0, 0.0) if varying.strokes is None else (varying.strokes.offset_N, varying.strokes.friction_N)
    both = [(away_of(fit, one.numbers), *on_fresh(fit, trial, fresh)) for fit in (fitted, varying)]
    numbers = (*spreads, *(both[i][j] for j in range(3) for i in range(2)))
    return (case, str(seed), taken, *(f"{number:.4g}" for number in numbers))


def away_of(fit: DrivenFit, truth: Mapping[str, float]) -> float:
    """Root mean square of the numbers' errors over their stated errors."""
    errors = np.sqrt(np.diag(fit.covariance))
    return float(np.sqrt(np.mean(((fit.values - np.array([truth[name] for name in fit.names])) / errors) ** 2)))


def on_fresh(fit: DrivenFit, trial: DrivenTrial, fresh: Sequence[DrivenTrial]) -> tuple[float, float]:
    """Error of the free run on fresh records, m, and the share of their samples in the 90 % band."""
    equation = read_back(written(fit, fit.rms[trial.name], motion_of(trial), trial))
    squares, inside = [], []
    for other in fresh:
        made, after = predict_driven(other, equation, START_SAMPLES), slice(START_SAMPLES, None)
        seen = other.outputs["displacement"][after]
        squares.append(np.mean((seen - made.values[after]) ** 2))
        inside.append(np.mean((seen >= made.lower[after]) & (seen <= made.upper[after])))
    return float(np.sqrt(np.mean(squares))), float(np.mean(inside))


def table(lines: Sequence[Sequence[str]]) -> str:
    """Markdown: by case, what was found, how sure it is, and fresh records."""
    out = [
        "| carriages | asked for | offset, friction found, N | errors over stated: without, with | "
        "missed, mm: without, with | in the band: without, with |",
        "|---|---|---|---|---|---|",
    ]
    for case in dict.fromkeys(line[0] for line in lines):
        own = [dict(zip(HEADER, line, strict=True)) for line in lines if line[0] == case]
        taken = [one for one in own if one["taken"] == "yes"]

        def mean(key: str, rows: list[dict[str, str]], root: bool = True) -> float:
            """Root mean square of a column, or its mean."""
            values = np.array([float(one[key]) for one in rows])
            return float(np.sqrt(np.mean(values**2)) if root else np.mean(values))

        found = "-" if not taken else f"{mean('offset_N', taken):.2f}, {mean('friction_N', taken):.2f}"
        away = f"{mean('away', own):.2g}, {mean('away_by_stroke', own):.2g}"
        missed = f"{1e3 * mean('missed_m', own):.2g}, {1e3 * mean('missed_by_stroke_m', own):.2g}"
        inside = f"{100 * mean('covered', own, False):.0f} %, {100 * mean('covered_by_stroke', own, False):.0f} %"
        out.append(f"| {len(own)}: {case} | {len(taken)} | {found} | {away} | {missed} | {inside} |")
    return "\n".join(out)


def emps_line(seconds: float) -> str:
    """One row of the page: parts of that length left out of EMPS' record, each run free by what the rest says."""
    data = load("emps")
    whole = DrivenTrial("emps", data.step * np.arange(data.x.size), data.u, {"displacement": data.x})
    length = int(seconds * whole.rate_hz)
    laws = DrivenLaws(tuple(find_driven(name) for name in EMPS_LAWS))
    missed, inside, taken = [], [], 0
    for begin in np.linspace(0, whole.t.size - length, PARTS).astype(int).tolist():
        spans = [(a, b) for a, b in ((0, begin), (begin + length, whole.t.size)) if b - a >= FEWEST_SAMPLES]
        rest = [replace(whole.part(a, b), name=f"part {i}") for i, (a, b) in enumerate(spans)]
        out, fitted = whole.part(begin, begin + length), fit_driven(rest, laws)
        try:
            varying = vary_by_stroke(rest, fitted)
        except IdentificationError:
            varying = fitted
        taken += varying is not fitted
        both = [on_fresh(fit, rest[0], [out]) for fit in (fitted, varying)]
        missed.append([one[0] for one in both])
        inside.append([one[1] for one in both])
    rms, shares = 1e3 * np.sqrt(np.mean(np.square(missed), axis=0)), 100.0 * np.mean(inside, axis=0)
    closer = sum(one[1] < one[0] for one in missed)
    return (
        f"| {PARTS} of {seconds:g} s | {taken} | {rms[0]:.2f}, {rms[1]:.2f} | {closer} | {shares[0]:.0f} %, "
        f"{shares[1]:.0f} % |"
    )


def emps() -> None:
    """The page's table of EMPS."""
    lines = [
        "| parts left out | asked for | missed, mm: without, with | closer | in the band: without, with |",
        "|---|---|---|---|---|",
        *(emps_line(seconds) for seconds in LENGTHS_S),
    ]
    print("\n".join(lines))
    put("\n".join(lines), "emps strokes")


def main() -> None:
    """Every case, the file and the page's table; or the page's table of EMPS."""
    if "--emps" in sys.argv:
        return emps()
    lines = []
    for case in CASES:
        for seed in SEEDS:
            lines.append(line_of(case, seed))
            print(*lines[-1], flush=True)
    kept(RESULT, HEADER, lines, table, "strokes")
