"""docs/hidden_states.md from the study's tables.

Belongs here: the page's text and tables. Does not belong here: running anything (study.py, real.py).
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.files import read_rows
from experiments.hidden_states.campaigns import NULLS, PLANTED
from experiments.hidden_states.motion import Oscillator
from experiments.hidden_states.study import OSCILLATOR, RELAXATION, Row
from experiments.recovery.releases import NOISE
from undertow.comparison.candidate import OVERDAMPED

FOLDER = Path(__file__).resolve().parent
PAGE = FOLDER.parents[1] / "docs" / "hidden_states.md"

FREQUENCY_LIMIT_PERCENT = 0.2
MASS_LIMIT_PERCENT = {"300 kg": 5.0, "60 kg": 5.0, "20 kg": 12.0}
"""Largest median errors, set beforehand."""

DIGITS_PERCENT = 0.005
"""Errors below are not resolved: the tables hold six digits."""

TRUE_NAMES = {
    "nothing": "", "cubic stiffness": "cubic_stiffness", "Maxwell element": RELAXATION, "drift": "sensor_drift",
    "friction asymmetry": "asymmetric_friction", "drag exponent": "drag_exponent",
}  # fmt: skip
"""What a null campaign of each kind has instead of an oscillator, as a verdict names it."""


def names(row: Row) -> list[str]:
    """Effects that a row names, as often as it names them; "unknown" is none."""
    return [name for name in row["named"].split("+") if name and name != "unknown"]


def right_number(row: Row) -> bool:
    """Whether as many oscillators are named as were planted, and no other effect."""
    return names(row) == [OSCILLATOR] * len(PLANTED[row["kind"]])


def false_names(row: Row) -> set[str]:
    """Effects that a row of a null campaign names and that are not there."""
    return set(names(row)) - {TRUE_NAMES[row["kind"]]}


def numbers(row: Row, column: str) -> list[float]:
    """The numbers in a cell that may hold several."""
    return [float(word) for word in row[column].split()]


def errors(rows: Sequence[Row], column: str, truth: Callable[[Oscillator], float]) -> list[float]:
    """Errors in per cent of the planted oscillators' numbers, of all campaigns that found as many as there are."""
    found = []
    for row in rows:
        planted = sorted(PLANTED[row["kind"]], key=lambda one: one.w)
        if right_number(row):
            seen = numbers(row, column)
            found += [100.0 * abs(value / truth(one) - 1.0) for value, one in zip(seen, planted, strict=True)]
    return found


def spread(rows: Sequence[Row], column: str, truth: Callable[[Oscillator], float]) -> float:
    """Root mean square of error over standard error."""
    ratios = []
    for row in rows:
        planted = sorted(PLANTED[row["kind"]], key=lambda one: one.w)
        if right_number(row):
            pairs = zip(numbers(row, column), numbers(row, f"{column}_stderr"), planted, strict=True)
            ratios += [(value - truth(one)) / stderr for value, stderr, one in pairs]
    return float(np.sqrt(np.mean(np.square(ratios)))) if ratios else math.nan


def planted_table(rows: Sequence[Row]) -> str:
    """A row a truth and noise: how many campaigns named exactly what is there, median errors, errors over stderr."""
    lines = [
        "| hidden | noise | right number | other verdicts | median error of w, % | of the mass, % | "
        "error / stderr (w, mass) |",
        "|---|---|---|---|---|---|---|",
    ]
    for kind in PLANTED:
        for noise in NOISE:
            own = [one for one in rows if (one["kind"], one["noise"]) == (kind, noise)]
            if own:
                right = sum(right_number(one) for one in own)
                w, mass = errors(own, "w_rad_per_s", lambda one: one.w), errors(own, "mass_kg", lambda one: one.mass_kg)
                ratios = (
                    spread(own, "w_rad_per_s", lambda one: one.w), spread(own, "mass_kg", lambda one: one.mass_kg)
                )  # fmt: skip
                lines.append(
                    f"| {kind} | {noise} | {right} of {len(own)} | {_others(own)} | {_percent(w)} | {_percent(mass)} | "
                    f"{', '.join(f'{value:.1f}' for value in ratios)} |"
                )
    return "\n".join(lines) + "\n"


def _others(rows: Sequence[Row]) -> str:
    """What is said of the campaigns without the right number, each with how often."""
    said = [" + ".join(one["named"].split("+")) or one["status"] for one in rows if not right_number(one)]
    return ", ".join(f"{said.count(one)} {one.replace('_', ' ')}" for one in sorted(set(said))) or "none"


def _percent(values: Sequence[float]) -> str:
    """A median as far as the table's six digits carry it."""
    if not values:
        return "-"
    median = float(np.median(values))
    return f"< {DIGITS_PERCENT:g}" if median < DIGITS_PERCENT else f"{median:.2g}"


def null_table(rows: Sequence[Row]) -> str:
    """A row a kind: what is named, right or not, and what is left open."""
    lines = [
        "| instead of an oscillator | campaigns | what is there is named | an oscillator | a relaxation that is not "
        "there | another effect that is not there | unknown | nothing said |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for kind in NULLS:
        own = [one for one in rows if one["kind"] == kind]
        if own:
            lines.append(f"| {kind} | {' | '.join(str(value) for value in _counts(own))} |")
    lines.append(f"| **all** | {' | '.join(str(value) for value in _counts(rows))} |")
    return "\n".join(lines) + "\n"


def _counts(rows: Sequence[Row]) -> tuple[int, ...]:
    wrong = [false_names(one) for one in rows]
    return (
        len(rows),
        sum(TRUE_NAMES[one["kind"]] in names(one) for one in rows),
        sum(OSCILLATOR in one for one in wrong),
        sum(RELAXATION in one for one in wrong),
        sum(bool(one - {OSCILLATOR, RELAXATION}) for one in wrong),
        sum("unknown" in one["named"] for one in rows),
        sum(not one["named"] for one in rows),
    )


def relaxation_table(rows: Sequence[Row]) -> str:
    """A row a noise: Maxwell elements named, with the median errors of those and their errors over stderr; one that is
    too small to count has a name without numbers."""
    lines = [
        "| noise | Maxwell elements named | median error of k_r, % | of tau, % | error / stderr (k_r, tau) |",
        "|---|---|---|---|---|",
    ]
    for noise in NOISE:
        own = [one for one in rows if one["noise"] == noise and one["true_tau_s"]]
        kept = [one for one in own if names(one) == [RELAXATION]]
        told = [one for one in kept if one["k_r_N_per_m"]]
        percent, ratios = [], []
        for column in ("k_r_N_per_m", "tau_s"):
            true = [float(one[f"true_{column}"]) for one in told]
            away = [float(one[column]) - value for one, value in zip(told, true, strict=True)]
            percent.append(_percent([100.0 * abs(d / value) for d, value in zip(away, true, strict=True)]))
            units = [d / float(one[f"{column}_stderr"]) for one, d in zip(told, away, strict=True)]
            ratios.append(f"{np.sqrt(np.mean(np.square(units))):.1f}" if units else "-")
        lines.append(f"| {noise} | {len(kept)} of {len(own)} | {' | '.join(percent)} | {', '.join(ratios)} |")
    return "\n".join(lines) + "\n"


def building_table(runs: Sequence[dict[str, Any]]) -> str:
    """A row an equation of the building: what is named, its numbers, the two modes, the free run's error."""
    lines = [
        "| equation | named | mass over the building's | frequency, Hz | damping ratio | modes, Hz | error before, "
        "after |",
        "|---|---|---|---|---|---|---|",
    ]
    for run in runs:
        mass, w, zeta = (run["numbers"][name] for name in ("mass", "w", "zeta"))
        modes = ", ".join(f"{mode:.3f}" for mode in run["modes_hz"])
        lines.append(
            f"| {', '.join(run['terms'])} | {' + '.join(run['names']).replace('_', ' ')} | {_pair(mass)} | "
            f"{_pair([value / (2.0 * math.pi) for value in w])} | {_pair(zeta)} | "
            f"{modes} | {run['error']:.3f}, {run['error_repaired']:.3f} |"
        )
    return "\n".join(lines) + "\n"


def _pair(number: Sequence[float]) -> str:
    """Value and standard error, as many digits as the error allows."""
    value, error = number
    digits = max(1 - math.floor(math.log10(error)), 0) if error > 0.0 else 3
    return f"{value:.{digits}f} ± {error:.{digits}f}"


def write_page(folder: Path, page: Path = PAGE) -> None:
    """The page from the tables in ``folder``."""
    page.write_text(text(folder))


def text(folder: Path) -> str:
    """The page."""
    planted, nulls = read_rows(folder / "planted.csv"), read_rows(folder / "nulls.csv")
    false = sum(bool(false_names(one)) for one in nulls)
    seconds = [float(one["cpu_s"]) for one in planted]
    return (FOLDER / "page.md").read_text().format(
        first=min(int(one["seed"]) for one in planted),
        last=max(int(one["seed"]) for one in planted),
        nulls_last=max(int(one["seed"]) for one in nulls),
        overdamped=OVERDAMPED,
        seeds=len({one["seed"] for one in planted}),
        seconds=f"{np.median(seconds):.0f}",
        planted=planted_table(planted),
        nulls=null_table(nulls),
        false=f"{false} of {len(nulls)}",
        relaxations=relaxation_table(nulls),
        building=building_table(json.loads((FOLDER / "real.json").read_text())),
    )  # fmt: skip
