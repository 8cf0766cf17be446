"""200 simulated tables: physics known, recipes run, scatter added, audited as if printed.

    python -m experiments.audit.simulated run      # appends to simulated.jsonl, goes on where it stopped
    python -m experiments.audit.simulated page     # writes the section of docs/published_tables.md

Three designs on the structure of Tables 1 and 2: Method 1 on one spring at nine releases, Method 2 on two springs at
four releases each, Method 1 on two springs at two releases each. Truths in turn: Eq. 15, linear damping, friction
mis-set, a drag that falls with amplitude, a displacement offset, a hidden resonator, a compliant support. In every
table k, c, mu scatter from row to row as the dry tables say, the dry means are in error by their standard errors, V
is anywhere in its range, and printed values scatter by a share drawn per table. Belongs here: that study. Nothing
here is imported by undertow.
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.audit import constants_of, dry_structures
from undertow.campaign.audit_settings import load_audit
from undertow.campaign.audit_tables import read_table
from undertow.discrepancy.audit.answer import answer
from undertow.discrepancy.audit.case import Case, Row, Structure, row_returns
from undertow.discrepancy.audit.headings import correct_units
from undertow.discrepancy.audit.verdicts import judge
from undertow.errors import UndertowError

HERE = Path(__file__).resolve().parent
CONFIG = HERE.parents[1] / "configs" / "published.yaml"
RESULTS = HERE / "simulated.jsonl"
PAGE = HERE.parents[1] / "docs" / "published_tables.md"
MARKS = ("<!-- simulated tables -->", "<!-- end of simulated tables -->")
TABLES = 200
SEED = 1000

CLASSES = {
    "": "nothing", "linear_damping": "dissipation", "coulomb_friction": "dissipation", "drag_exponent": "dissipation",
    "hidden_resonator": "memory", "rest_offset": "set-up", "support_compliance": "set-up",
}  # fmt: skip

TURNS: tuple[tuple[str, str], ...] = (
    ("method1", ""), ("method2", "linear_damping"), ("springs", "hidden_resonator"), ("method2", ""),
    ("method1", "linear_damping"), ("method2", "coulomb_friction"), ("springs", ""), ("method1", "drag_exponent"),
    ("method2", "rest_offset"), ("springs", "hidden_resonator"), ("method1", "coulomb_friction"), ("method2", ""),
    ("springs", "support_compliance"), ("method2", "linear_damping"), ("springs", "hidden_resonator"),
    ("method2", "drag_exponent"), ("method1", ""), ("method2", "linear_damping"), ("springs", ""),
    ("method2", "rest_offset"),
)  # fmt: skip
"""Design and truth of the tables in turn; ten rounds are 200."""

NODES = 12
"""Frequencies of a resonator tried, as in the audit of the report."""


@dataclass(frozen=True)
class Simulated:
    """One simulated table: the case as printed, and the physics behind it."""

    case: Case
    design: str
    truth: str
    values: dict[str, float]


def structures() -> dict[str, Structure]:
    """The dry springs of Tables 1 and 2."""
    config = load_audit(CONFIG)
    constants = constants_of(config)
    tables, _ = correct_units([read_table(config, name) for name in config.tables], constants)
    return dry_structures(tables, constants)


def design(name: str, dry: dict[str, Structure]) -> Case:
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
            for s in four for x0 in four[s][2:]
        ]  # fmt: skip
    return Case(f"simulated {name}", tuple(rows), dry, 2637.4, 0.97, (0.0, 1.1))


def physics(truth: str, case: Case, rng: np.random.Generator) -> dict[str, float]:
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
        values["drag_exponent.exponent"] = rng.uniform(1.1, 1.5)
    elif truth == "rest_offset":
        values["rest_offset.offset_m"] = rng.choice([-1.0, 1.0]) * rng.uniform(0.008, 0.025) * largest
    elif truth == "support_compliance":
        values["support_compliance.compliance_m_per_N"] = rng.uniform(0.05, 0.12) / 402e3
    elif truth == "hidden_resonator":
        slow, fast = min(case.frequencies), max(case.frequencies)
        values["hidden_resonator.mass_kg"] = case.mass_kg * np.exp(rng.uniform(np.log(0.06), np.log(0.4)))
        values["hidden_resonator.natural_frequency_rad_per_s"] = np.exp(rng.uniform(np.log(slow), np.log(1.2 * fast)))
        values["hidden_resonator.damping_ratio"] = np.exp(rng.uniform(np.log(0.005), np.log(0.1)))
        values["added_mass_kg"] = rng.uniform(50.0, 900.0)
    return values


def simulate_table(number: int, dry: dict[str, Structure]) -> Simulated:
    """The numbered table; draws again where a body sticks before its recipe can be run."""
    kind, truth = TURNS[number % len(TURNS)]
    empty = design(kind, dry)
    for attempt in range(20):
        rng = np.random.default_rng([SEED, number, attempt])
        values = physics(truth, empty, rng)
        mass_scatter, drag_scatter = rng.uniform(0.002, 0.015) * empty.mass_kg, rng.uniform(0.01, 0.06)
        try:
            printed = [_printed(empty, row, values, rng) for row in empty.rows]
        except UndertowError:
            continue
        noisy = np.array(printed)
        noisy[:, 0] += mass_scatter * rng.standard_normal(noisy.shape[0])
        noisy[:, 1] *= 1.0 + drag_scatter * rng.standard_normal(noisy.shape[0])
        noisy[:, 0] = np.where(
            np.array([row.recipe == "method1" for row in empty.rows]), np.maximum(noisy[:, 0], 0.0), noisy[:, 0]
        )
        case = empty.with_printed(np.column_stack([noisy[:, 0].round(0), noisy[:, 1].round(1)]), f"simulated {number}")
        return Simulated(case, kind, truth, values)
    raise UndertowError(f"simulated table {number}: 20 draws of {truth or 'Eq. 15'} stick at once; narrow its ranges")


def _printed(case: Case, row: Row, values: dict[str, float], rng: np.random.Generator) -> tuple[float, float]:
    """One row as its recipe prints it, with this trial's own k, c, mu."""
    dry = case.structures[row.spring]
    own = dict(values)
    for short, scatter in (("k", dry.k_scatter), ("c", dry.c_scatter), ("mu", dry.mu_scatter)):
        own[f"{short}.{row.spring}"] += scatter * rng.standard_normal()
    return row_returns(case, row, own).bounded if row.recipe == "method1" else _both(row_returns(case, row, own))


def _both(returned: Any) -> tuple[float, float]:
    return returned.added_mass_kg, returned.drag_coefficient


def audit_table(number: int, dry: dict[str, Structure]) -> dict[str, Any]:
    """What the audit says of one simulated table, beside the truth."""
    table = simulate_table(number, dry)
    started = time.process_time()
    found = answer([table.case], NODES, seed=number)
    verdict = judge(found)
    intervals = {}
    for effect, name in (("linear_damping", "c_Ns_per_m"), ("hidden_resonator", "mass_kg")):
        weight = found.of(effect)
        if table.truth == effect and weight is not None:
            intervals[f"{effect}.{name}"] = list(weight.posteriors[0].interval(f"{effect}.{name}"))
    base = sum(weight.probability for weight in found.weights if not weight.rival.effects)
    return {
        "number": number, "design": table.design, "truth": table.truth, "values": table.values,
        "verdict": list(verdict.verdict), "alternatives": [list(one) for one in verdict.alternatives],
        "status": verdict.status, "confidence": verdict.confidence, "equation_15": base, "intervals": intervals,
        "cpu_s": time.process_time() - started,
    }  # fmt: skip


def summary(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Shares of right names and classes, false accusations, coverage of 90 % intervals."""
    named = [one for one in results if one["truth"]]
    null = [one for one in results if not one["truth"]]

    def classes(one: dict[str, Any]) -> set[str]:
        return {CLASSES[name] for name in one["verdict"]} or {"nothing"}

    def said(one: dict[str, Any]) -> bool:
        return any(one["truth"] in names for names in [one["verdict"], *one["alternatives"]])

    by_truth = {}
    for truth in sorted({one["truth"] for one in results}):
        those = [one for one in results if one["truth"] == truth]
        by_truth[truth or "equation 15"] = {
            "tables": len(those),
            "preferred": sum(one["verdict"] == ([truth] if truth else []) for one in those),
            "class": sum(CLASSES[truth] in classes(one) for one in those),
            "named": sum(said(one) if truth else not one["verdict"] for one in those),
        }
    coverage = {}
    for key in ("linear_damping.c_Ns_per_m", "hidden_resonator.mass_kg"):
        those = [one for one in results if key in one["intervals"]]
        inside = [one["intervals"][key][1] <= one["values"][key] <= one["intervals"][key][2] for one in those]
        coverage[key] = {"tables": len(those), "inside": int(sum(inside))}
    return {
        "tables": len(results),
        "with_an_effect": len(named),
        "preferred": sum(one["verdict"] == [one["truth"]] for one in named),
        "class": sum(CLASSES[one["truth"]] in classes(one) for one in named),
        "named": sum(said(one) for one in named),
        "eq15": len(null),
        "accused": sum(bool(one["verdict"]) for one in null),
        "coverage": coverage,
        "by_truth": by_truth,
        "cpu_s": sum(one["cpu_s"] for one in results),
    }


def read_results(path: Path = RESULTS) -> list[dict[str, Any]]:
    """Results so far in the order of their numbers; of a number that stands there twice the first."""
    if not path.exists():
        return []
    found: dict[int, dict[str, Any]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        one = json.loads(line)
        found.setdefault(one["number"], one)
    return [found[number] for number in sorted(found)]


def section(found: dict[str, Any]) -> str:
    """The section of docs/published_tables.md: counts, coverage, a table by truth."""
    linear, mass = (found["coverage"][key] for key in ("linear_damping.c_Ns_per_m", "hidden_resonator.mass_kg"))
    lines = [
        f"| {truth.replace('_', ' ')} | {one['tables']} | {one['preferred']} | {one['class']} | {one['named']} |"
        for truth, one in found["by_truth"].items()
    ]
    return "\n".join([
        f"{found['tables']} simulated tables of the {TABLES} planned were reached (`python -m "
        f"experiments.audit.simulated run` "
        "goes on where it stopped).",
        f"With an effect planted the right name is the verdict or among its alternatives in {found['named']} of "
        f"{found['with_an_effect']}, it is the preferred one in {found['preferred']}, and its class "
        f"(dissipation, memory, "
        f"set-up) is the preferred one's in {found['class']}.",
        f"Where Eq. 15 is true somebody is accused in {found['accused']} of {found['eq15']}.",
        f"90 % intervals hold the planted linear damping in {linear['inside']} of {linear['tables']} and the "
        f"resonator's mass "
        f"in {mass['inside']} of {mass['tables']}.",
        "",
        "| truth | tables | preferred | class | named |",
        "|---|---|---|---|---|",
        *lines,
    ])  # fmt: skip


def write_page() -> None:
    """Put the section between its marks in docs/published_tables.md."""
    text = PAGE.read_text(encoding="utf-8")
    before, after = text.split(MARKS[0])[0], text.split(MARKS[1])[1]
    new = section(summary(read_results()))
    PAGE.write_text(f"{before}{MARKS[0]}\n{new}\n{MARKS[1]}{after}", encoding="utf-8")


def main(arguments: list[str]) -> int:
    """Run what is missing, or write the page's section."""
    if arguments[:1] == ["page"]:
        write_page()
        return 0
    dry = structures()
    done = {one["number"] for one in read_results()}
    last = int(arguments[1]) if len(arguments) > 1 else TABLES
    for number in range(last):
        if number not in done:
            with RESULTS.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(audit_table(number, dry)) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
