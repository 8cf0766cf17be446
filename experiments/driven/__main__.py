"""`python -m experiments driven [FOLDER]`: runs configs/driven where FOLDER lacks a run; for docs/driven_measured.md.

Belongs here: that table and its picture. Does not belong here: any number of it (verdict.json of the runs).
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from experiments.driven.page import put

ROOT = Path(__file__).resolve().parents[2]
SETS = {"emps": ("mm", 1e3), "silverbox": ("mV", 1e3), "bouc_wen": ("1e-6 m", 1e6)}
"""Run -> unit of its errors and what they are multiplied by."""


def row(name: str, folder: Path) -> str:
    """One line of the table from a run's equations.json and verdict.json."""
    unit, factor = SETS[name]
    verdict = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))["groups"][0]
    versions = json.loads((folder / "equations.json").read_text(encoding="utf-8"))["groups"][0]["versions"]
    size = versions["baseline"]["motion_rms"]
    errors = [verdict["baseline"]["held_out_nrmse"]]
    if verdict["augmented"]:
        errors.append(verdict["augmented"]["held_out_nrmse"])
    shown = [f"{error * size * factor:.3g} {unit}" for error in errors]
    given = ", ".join(versions["baseline"]["terms"])
    added = ", ".join(n for n in verdict["verdict"] if n != "unknown") or "nothing"
    return f"| {name} | {given} | {shown[0]} | {added} | {shown[-1]} |"


def main() -> None:
    """Make the runs that are not there, and write the table."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "runs"
    lines = ["| set | equation given | free run, unseen | added | free run, unseen |", "|---|---|---|---|---|"]
    for name in SETS:
        if not (folder / name / "verdict.json").exists():
            config = ROOT / "configs" / "driven" / f"{name}.yaml"
            subprocess.run(
                [sys.executable, "-m", "undertow", "run", str(config), "--out", str(folder / name)], check=True
            )
        lines.append(row(name, folder / name))
    put("\n".join(lines), "table")
