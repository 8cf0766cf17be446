"""200 simulated tables: physics known, recipes run, scatter added, audited as if printed.

    python -m experiments audit.simulated run      # appends to simulated.jsonl, goes on where it stopped
    python -m experiments audit.simulated page     # writes the section of docs/published_tables.md

Three designs on the structure of Tables 1 and 2: Method 1 on one spring at nine releases, Methods 1 and 2 on two
springs at four releases each. Truths in turn: Eq. 15, linear damping, friction mis-set, a drag that falls with
amplitude, a displacement offset, a hidden resonator, a compliant support, a mis-stated stiffness. In every table k, c,
mu scatter from row to row as the dry tables say, the dry means are in error by their standard errors, V is anywhere in
its range, and printed values scatter by a share drawn per table. The numbers from 200 on are for the coverage of
intervals alone: only the true rival is fitted. Belongs here: that study. Its counts are in scores.py. Nothing here is
imported by undertow.
"""

from __future__ import annotations

import functools
import json
import math
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from undertow.audit.answer import Answer, answer
from undertow.audit.case import DryStructure, PrintedCase, Row, row_returns
from undertow.audit.exploring import fitted_surface
from undertow.audit.headings import correct_units
from undertow.audit.posterior import RivalPosterior, posterior, weigh
from undertow.audit.recipes import Array, Returned
from undertow.audit.rivals import rivals
from undertow.audit.scatter import DRAG_SHARES, MASS_SHARES, log_sum
from undertow.audit.verdicts import judge
from undertow.campaign.audit.published import constants_of, dry_structures
from undertow.campaign.audit.settings import load_audit
from undertow.campaign.audit.tables import read_table
from undertow.errors import UndertowError

HERE = Path(__file__).resolve().parent
CONFIG = HERE.parents[1] / "configs" / "published.yaml"
RESULTS = HERE / "simulated.jsonl"
TABLES = 200
COVERAGE_TABLES = 120
SEED = 3000
"""Tables of 2000 were looked at while the audit was mended; nothing was chosen on these."""

TURNS: tuple[tuple[str, str], ...] = (
    ("method1", ""), ("method2", "linear_damping"), ("springs", "hidden_resonator"), ("method2", ""),
    ("method1", "linear_damping"), ("method2", "coulomb_friction"), ("springs", ""), ("method1", "drag_exponent"),
    ("method2", "rest_offset"), ("springs", "gain_error"), ("method1", "coulomb_friction"), ("method2", ""),
    ("springs", "support_compliance"), ("method2", "linear_damping"), ("springs", "hidden_resonator"),
    ("method2", "drag_exponent"), ("method1", ""), ("method2", "linear_damping"), ("springs", ""),
    ("method2", "rest_offset"),
)  # fmt: skip
"""Design and truth of the tables in turn; ten rounds are 200."""

COVERED: tuple[tuple[str, str], ...] = (
    ("method1", "linear_damping"), ("springs", "hidden_resonator"), ("method2", "linear_damping"),
    ("springs", "hidden_resonator"),
)  # fmt: skip
"""The same of the tables that are for coverage alone."""

INTERVALS = (("linear_damping", "c_Ns_per_m"), ("hidden_resonator", "mass_kg"))
"""Effects and parameters whose 90 % intervals are counted."""

MASS_SCATTER = (0.002, 0.015)
DRAG_SCATTER = (0.01, 0.06)
"""Scatter of printed values: m_a over the mass, C_d over its value; even within."""

NODES = 8
"""Frequencies of a resonator tried, as in the audit of the report."""


@dataclass(frozen=True)
class Simulated:
    """One simulated table: the case as printed, and the physics behind it."""

    case: PrintedCase
    design: str
    truth: str
    values: dict[str, float]


def structures() -> dict[str, DryStructure]:
    """The dry springs of Tables 1 and 2."""
    config = load_audit(CONFIG)
    constants = constants_of(config)
    tables, _ = correct_units([read_table(config, name) for name in config.tables], constants)
    return dry_structures(tables, constants)


def design(name: str, dry: dict[str, DryStructure]) -> PrintedCase:
    """An empty table of one design (printed numbers are 0)."""
    nine = (0.018, 0.026, 0.030, 0.032, 0.036, 0.044, 0.055, 0.064, 0.109)
    four = {"long": (0.018, 0.032, 0.055, 0.107), "short": (0.010, 0.016, 0.024, 0.033)}
    if name == "method1":
        rows = [Row("simulated", "long", x0, "method1", 1.0, 1.0) for x0 in nine]
    elif name == "method2":
        rows = [Row("simulated", s, x0, "method2", 1.0, 1.0) for s in four for x0 in four[s]]
    else:
        rows = [
            Row("simulated", s, x0, "method1", 1.0, 1.0, window_s=8.0 if s == "long" else 4.0)
            for s in four for x0 in four[s]
        ]  # fmt: skip
    alone = {spring: replace(one, k_other=math.nan) for spring, one in dry.items()}  # no second dry number is printed
    return PrintedCase(f"simulated {name}", tuple(rows), alone, 2637.4, 0.97, (0.0, 1.1))


def physics(truth: str, case: PrintedCase, rng: np.random.Generator) -> dict[str, float]:
    """Parameters of one truth, and what nobody knew."""
    values = {"added_mass_kg": rng.uniform(200.0, 1400.0), "drag_coefficient": rng.uniform(2.0, 12.0)}
    values["volume_m3"] = rng.uniform(*case.volume_range_m3)
    if case.two_instants:
        values["turn_share"] = rng.uniform(-1.0, 1.0)
    for name in case.springs:
        dry = case.structures[name]
        for short, error in (("k", dry.k_error), ("c", dry.c_error), ("mu", dry.mu_error)):
            values[f"{short}.{name}"] = error * rng.standard_normal()
    largest = max(row.release_m for row in case.rows)
    if truth == "linear_damping":
        values["linear_damping.c_Ns_per_m"] = rng.uniform(500.0, 2500.0)
    elif truth == "coulomb_friction":
        values["coulomb_friction.force_N"] = rng.choice([-1.0, 1.0]) * rng.uniform(50.0, 120.0)
    elif truth == "drag_exponent":
        values["drag_exponent.exponent"] = rng.uniform(1.2, 1.6)
    elif truth == "rest_offset":
        values["rest_offset.offset_m"] = rng.choice([-1.0, 1.0]) * rng.uniform(0.008, 0.025) * largest
    elif truth == "support_compliance":
        values["support_compliance.compliance_m_per_N"] = rng.uniform(0.05, 0.12) / 402e3
    elif truth == "gain_error":
        values["gain_error.stiffness_short"] = rng.choice([-1.0, 1.0]) * rng.uniform(0.04, 0.08)
    elif truth == "hidden_resonator":
        slow, fast = min(case.frequencies), max(case.frequencies)
        values["hidden_resonator.mass_kg"] = case.mass_kg * np.exp(rng.uniform(np.log(0.06), np.log(0.4)))
        values["hidden_resonator.natural_frequency_rad_per_s"] = np.exp(rng.uniform(np.log(slow), np.log(1.2 * fast)))
        values["hidden_resonator.damping_ratio"] = np.exp(rng.uniform(np.log(0.005), np.log(0.1)))
        values["added_mass_kg"] = rng.uniform(50.0, 900.0)
    return values


def simulate_table(number: int, dry: dict[str, DryStructure]) -> Simulated:
    """The numbered table; draws again where a body sticks before its recipe can be run."""
    turns = TURNS if number < TABLES else COVERED
    kind, truth = turns[number % len(turns)]
    empty = design(kind, dry)
    for attempt in range(20):
        rng = np.random.default_rng([SEED, number, attempt])
        values = physics(truth, empty, rng)
        mass_scatter, drag_scatter = rng.uniform(*MASS_SCATTER) * empty.mass_kg, rng.uniform(*DRAG_SCATTER)
        try:
            found = [_returned(empty, row, values, rng) for row in empty.rows]
        except UndertowError:
            continue
        errors = rng.standard_normal((2, len(found)))
        printed = [
            printed_row(row, one, mass_scatter * to_mass, 1.0 + drag_scatter * to_drag)
            for row, one, to_mass, to_drag in zip(empty.rows, found, *errors.tolist(), strict=True)
        ]
        digits = np.array([[round(mass), round(drag, 1)] for mass, drag in printed])
        case = empty.with_printed(digits, f"simulated {number}")
        return Simulated(case, kind, truth, values)
    raise UndertowError(f"simulated table {number}: 20 draws of {truth or 'Eq. 15'} stick at once; narrow its ranges")


def _returned(case: PrintedCase, row: Row, values: dict[str, float], rng: np.random.Generator) -> Returned:
    """What its recipe returns for one row, with this trial's own k, c, mu."""
    dry = case.structures[row.spring]
    own = dict(values)
    for short, scatter in (("k", dry.k_scatter), ("c", dry.c_scatter), ("mu", dry.mu_scatter)):
        own[f"{short}.{row.spring}"] += scatter * rng.standard_normal()
    return row_returns(case, row, own)


def printed_row(row: Row, returned: Returned, to_mass_kg: float, drag_factor: float) -> tuple[float, float]:
    """One row as printed: what a recording does to the minimum comes before the bound of Method 1."""
    moved = replace(returned, added_mass_kg=returned.added_mass_kg + to_mass_kg)
    mass, drag = moved.bounded if row.recipe == "method1" else (moved.added_mass_kg, moved.drag_coefficient)
    return mass, drag * drag_factor


def audit_table(number: int, dry: dict[str, DryStructure]) -> dict[str, Any]:
    """What the audit says of one simulated table, beside the truth."""
    table = simulate_table(number, dry)
    started = time.process_time()
    found = answer([table.case], NODES, seed=number)
    verdict = judge(found)
    intervals, ranks = {}, {}
    for effect, name in INTERVALS:
        weight, key = found.of(effect), f"{effect}.{name}"
        if table.truth == effect and weight is not None:
            intervals[key] = list(weight.posteriors[0].interval(key))
            ranks[key] = _rank(weight.posteriors[0], key, table)
    base = sum(weight.probability for weight in found.weights if not weight.rival.effects)
    return {
        "number": number, "design": table.design, "truth": table.truth, "values": table.values,
        "verdict": list(verdict.verdict), "alternatives": [list(one) for one in verdict.alternatives],
        "status": verdict.status, "confidence": verdict.confidence, "equation_15": base, "intervals": intervals,
        "ranks": ranks, "told_scatter": told_scatter(found), "revision": revision(),
        "equation_if": [[cap, share] for cap, share in verdict.equation_if.items()],
        "cpu_s": time.process_time() - started,
    }  # fmt: skip


@functools.cache
def revision() -> str:
    """The commit that makes the rows, marked where the audit or this study was edited since."""
    commit, edited = (
        subprocess.run(["git", *arguments], cwd=HERE, capture_output=True, text=True, check=True).stdout.strip()
        for arguments in (
            ("rev-parse", "--short=7", "HEAD"),
            ("status", "--porcelain", "--", "../../src/undertow", "simulated.py"),
        )
    )
    return commit + ("+edited" if edited else "")


def _rank(found: RivalPosterior, name: str, table: Simulated) -> float:
    """Share of the draws below what was planted: even between 0 and 1 where posteriors are right."""
    return float(np.mean(found.draws[name] < table.values[name]))


def told_scatter(found: Answer) -> dict[str, float]:
    """Log evidence of every rival for an auditor who was told how far rows of these tables scatter, by label."""
    belief = _log_share(MASS_SHARES, MASS_SCATTER)[:, None] + _log_share(DRAG_SHARES, DRAG_SCATTER)[None, :]
    logs = {one.rival.label: log_sum(belief.ravel() + one.at_scatter) for one in found.weights}
    return {label: round(log, 3) for label, log in logs.items() if math.isfinite(log)}


def _log_share(nodes: tuple[float, ...], limits: tuple[float, float]) -> Array:
    """Logarithm of the share of an even range that lies nearest (in the logarithm) to each node of a grid."""
    edges = np.concatenate([[0.0], np.sqrt(np.array(nodes[1:]) * np.array(nodes[:-1])), [np.inf]])
    with np.errstate(divide="ignore"):
        found: Array = np.log(np.diff(np.clip(edges, *limits)) / (limits[1] - limits[0]))
    return found


def cover_table(number: int, dry: dict[str, DryStructure]) -> dict[str, Any]:
    """The interval of one planted parameter, from the true rival alone."""
    table = simulate_table(number, dry)
    started = time.process_time()
    rival = next(one for one in rivals(table.case, NODES) if one.effects == (table.truth,))
    found = posterior(weigh(table.case, fitted_surface(table.case, rival, number), number), number)
    name = f"{table.truth}.{dict(INTERVALS)[table.truth]}"
    return {
        "number": number, "design": table.design, "truth": table.truth, "values": table.values,
        "intervals": {name: list(found.interval(name))}, "ranks": {name: _rank(found, name, table)},
        "revision": revision(), "cpu_s": time.process_time() - started,
    }  # fmt: skip


def read_results(path: Path = RESULTS) -> list[dict[str, Any]]:
    """Results so far in the order of their numbers; of a number that stands there twice the first."""
    if not path.exists():
        return []
    found: dict[int, dict[str, Any]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        one = json.loads(line)
        found.setdefault(one["number"], one)
    return [found[number] for number in sorted(found)]


def _turn(number: int) -> float:
    """Audited tables and those for coverage take turns: a run that is cut short leaves some of all."""
    return number / TABLES if number < TABLES else (number - TABLES) / COVERAGE_TABLES


def main(arguments: list[str] | None = None) -> int:
    """Run what is missing (up to a number, from a number), or write the page's section."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if arguments[:1] == ["page"]:
        from experiments.audit.scores import write_page

        write_page(read_results())
        return 0
    dry = structures()
    done = {one["number"] for one in read_results()}
    last = int(arguments[1]) if len(arguments) > 1 else TABLES + COVERAGE_TABLES
    first = int(arguments[2]) if len(arguments) > 2 else 0
    for number in sorted(range(first, last), key=_turn):
        if number not in done:
            found = audit_table(number, dry) if number < TABLES else cover_table(number, dry)
            with RESULTS.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(found) + "\n")
    return 0
