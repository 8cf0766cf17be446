"""docs/hidden_states.md from the study's tables.

Belongs here: the page's text and tables. Does not belong here: running anything (study.py, real.py).
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.hidden_states.campaigns import NULLS, PLANTED
from experiments.recovery.releases import NOISE
from undertow.comparison.hidden_relaxation import CRITICAL_GAIN
from undertow.comparison.hidden_search import CRITICAL_T

FOLDER = Path(__file__).resolve().parent
PAGE = FOLDER.parents[1] / "docs" / "hidden_states.md"
TAIL_SHARE = 0.2
"""Share of the calibration campaigns whose excess is taken as exponential."""

FREQUENCY_LIMIT_PERCENT = 0.2
MASS_LIMIT_PERCENT = {"300 kg": 5.0, "60 kg": 5.0, "20 kg": 12.0}
"""Largest median errors, set beforehand."""

DIGITS_PERCENT = 0.005
"""The tables hold five digits."""

Record = dict[str, str]


def read(path: Path) -> list[Record]:
    """Rows of one of the study's tables; none where it is not there."""
    if not path.exists():
        return []
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def numbers(record: Record, column: str) -> list[float]:
    """The numbers in a cell that may hold several."""
    return [float(word) for word in record[column].split()]


def errors(records: Sequence[Record], column: str, truth: Callable[[Any], float]) -> list[float]:
    """Errors in per cent of the planted oscillators' numbers, of all campaigns that found as many as there are."""
    found = []
    for record in records:
        planted = sorted(PLANTED[record["kind"]], key=lambda one: one.w)
        seen = numbers(record, column)
        if len(seen) == len(planted):
            found += [100.0 * abs(value / truth(one) - 1.0) for value, one in zip(seen, planted, strict=True)]
    return found


def spread(records: Sequence[Record], column: str, error: str, truth: Callable[[Any], float]) -> float:
    """Root mean square of error over standard error."""
    ratios = []
    for record in records:
        planted = sorted(PLANTED[record["kind"]], key=lambda one: one.w)
        seen, stderr = numbers(record, column), numbers(record, error)
        if len(seen) == len(planted):
            ratios += [(value - truth(one)) / s for value, s, one in zip(seen, stderr, planted, strict=True)]
    return float(np.sqrt(np.mean(np.square(ratios)))) if ratios else math.nan


def planted_table(records: Sequence[Record]) -> str:
    """A row a truth and noise: how many campaigns found exactly what is there, median errors, errors over stderr."""
    lines = [
        "| hidden | noise | right number | median error of w, % | of the mass, % | error / stderr (w, mass) | backed |",
        "|---|---|---|---|---|---|---|",
    ]
    for kind, planted in PLANTED.items():
        for noise in NOISE:
            own = [one for one in records if (one["kind"], one["noise"]) == (kind, noise)]
            if not own:
                continue
            right = [one for one in own if int(one["found"]) == len(planted)]
            w = errors(own, "w_rad_per_s", lambda one: one.w)
            mass = errors(own, "mass_kg", lambda one: one.mass_kg)
            ratios = ", ".join(
                f"{value:.1f}"
                for value in (
                    spread(own, "w_rad_per_s", "w_stderr", lambda one: one.w),
                    spread(own, "mass_kg", "mass_stderr", lambda one: one.mass_kg),
                )
            )
            backed = sum(int(one["backed"]) for one in own)
            lines.append(
                f"| {kind} | {noise} | {len(right)} of {len(own)} | {_percent(w)} | {_percent(mass)} | "
                f"{ratios} | {backed} of {len(own)} |"
            )
    return "\n".join(lines) + "\n"


def _percent(values: Sequence[float]) -> str:
    """A median as far as the table's five digits carry it."""
    median = float(np.median(values)) if values else math.nan
    return f"< {DIGITS_PERCENT:g}" if median < DIGITS_PERCENT else f"{median:.2g}"


def null_table(records: Sequence[Record]) -> str:
    """A row a kind: campaigns, false alarms, the largest statistic of a sound set."""
    lines = ["| instead of an oscillator | campaigns | found | largest t |", "|---|---|---|---|"]
    for kind in NULLS:
        own = [one for one in records if one["kind"] == kind]
        if own:
            alarms = sum(int(one["found"]) > 0 for one in own)
            lines.append(f"| {kind} | {len(own)} | {alarms} | {max(float(one['largest_t']) for one in own):.1f} |")
    alarms = sum(int(one["found"]) > 0 for one in records)
    largest = max((float(one["largest_t"]) for one in records), default=math.nan)
    lines.append(f"| **all** | {len(records)} | {alarms} | {largest:.1f} |")
    return "\n".join(lines) + "\n"


def relaxation_table(records: Sequence[Record]) -> str:
    """A row a noise: Maxwell elements found with the median errors of those, false alarms elsewhere, largest gain."""
    lines = [
        "| noise | Maxwell elements found | median error of k_r, % | of tau, % | found without one | largest gain |",
        "|---|---|---|---|---|---|",
    ]
    for noise in NOISE:
        own = [one for one in records if one["noise"] == noise]
        there = [one for one in own if float(one["true_share"]) > 0.0]
        none = [one for one in own if float(one["true_share"]) == 0.0]
        kept = [one for one in there if int(one["kept"])]
        medians = []
        for seen, true in (("share", "true_share"), ("time_s", "true_time_s")):
            away = [100.0 * abs(float(one[seen]) / float(one[true]) - 1.0) for one in kept]
            medians.append(f"{np.median(away):.2g}" if away else "-")
        alarms, largest = sum(int(one["kept"]) for one in none), max(float(one["gain"]) for one in none)
        found = f"{len(kept)} of {len(there)} | {' | '.join(medians)} | {alarms} of {len(none)}"
        lines.append(f"| {noise} | {found} | {largest:.0f} |")
    return "\n".join(lines) + "\n"


def false_alarm_rate(records: Sequence[Record], critical: float = CRITICAL_T) -> float:
    """Probability that a null campaign exceeds ``critical``: exponential tail of the largest fifth of the statistics.

    The tail's mean excess over its threshold says how fast it falls (peaks over threshold, Pickands 1975,
    doi:10.1214/aos/1176343003, of shape 0).
    """
    statistics = np.sort([float(one["largest_t"]) for one in records])
    start = statistics[-max(2, round(TAIL_SHARE * statistics.size)) - 1]
    above = statistics[statistics > start]
    return float(above.size / statistics.size * math.exp(-(critical - start) / float(np.mean(above - start))))


def write_page(folder: Path, page: Path = PAGE) -> None:
    """The page from the tables in ``folder``."""
    page.write_text(text(folder))


def text(folder: Path) -> str:
    """The page."""
    calibration, planted, nulls = (read(folder / f"{name}.csv") for name in ("calibration", "planted", "nulls"))
    real = json.loads((FOLDER / "real.json").read_text())
    template = (FOLDER / "page.md").read_text()
    return template.format(
        critical=f"{CRITICAL_T:g}",
        calibration=len(calibration),
        largest=f"{max(float(one['largest_t']) for one in calibration):.1f}",
        rate=f"{false_alarm_rate(calibration):.1g}",
        seeds=len({one["seed"] for one in planted}),
        planted=planted_table(planted),
        nulls=null_table(nulls),
        relaxations=relaxation_table(read(FOLDER / "relaxations.csv")),
        critical_gain=f"{CRITICAL_GAIN:g}",
        building=_building(real["building"]),
        pendulum=_structures(real["pendulum"]),
        ship=_structures(real["ship"]),
    )


def _building(runs: Sequence[dict[str, Any]]) -> str:
    lines = ["| equation | candidate | free numbers | nrmse | criterion less the best |", "|---|---|---|---|---|"]
    for run in runs:
        best = run["candidates"][0][3]
        for name, _, count, criterion in run["candidates"]:
            lines.append(
                f"| {', '.join(run['terms'])} | {name} | {count} | {run['nrmse'][name]:.3f} | {criterion - best:.0f} |"
            )
    return "\n".join(lines) + "\n"


def _structures(runs: Sequence[dict[str, Any]], rows: int = 5) -> str:
    lines = ["| trial | equation | rms, mrad | criterion less the best |", "|---|---|---|---|"]
    for run in runs:
        for names, difference, rms, outcome in run["candidates"]:
            if outcome == "ok" and rows > sum(line.startswith(f"| {run['trial']} ") for line in lines):
                lines.append(f"| {run['trial']} | {', '.join(names)} | {1e3 * rms:.3g} | {difference:.1f} |")
    return "\n".join(lines) + "\n"
