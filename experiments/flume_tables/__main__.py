"""Method 1's m_a and C_d on the virtual flume by level and spring, beside the report's Tables 4, 5 and 6.

    python -m experiments flume_tables            # runs Method 1 on configs/flume.yaml first (about a minute)
    python -m experiments flume_tables --run DIR  # takes them from a finished run folder of that config

writes docs/flume_tables.json and docs/flume_tables.md. The flume's own answer stands beside as a third column; it is
read here and by no fit.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from experiments.files import read_rows
from experiments.flume_tables.page import Row, page
from undertow.campaign.run.folder import run_to_folder

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / "configs" / "flume.yaml"
DOCS = ROOT / "docs"
PUBLISHED = ROOT / "data" / "published"
TRUTH = ROOT / "data" / "virtual_flume" / "truth.json"
METHOD_1_ALONE = ("identify=[method1]", "discrepancy.suspects=[]")


def rows_of(trials: Sequence[dict[str, str]]) -> list[Row]:
    """Method 1's answers in a run's trials.csv, by spring, level and release.

    Raises ValueError where there are none.
    """
    found = [
        Row(
            r["trial"], r["spring"], float(r["water_depth_m"]), float(r["x0_target_m"]), float(r["added_mass_kg"]),
            float(r["added_mass_kg_stderr"] or "nan"), float(r["drag_coefficient"]),
            float(r["drag_coefficient_stderr"] or "nan"), "bound" in r["outcome"],
        )
        for r in trials
        if r["method"] == "method1" and r["added_mass_kg"]
    ]  # fmt: skip
    if not found:
        raise ValueError(
            f"trials.csv has {len(trials)} rows and none of method1 with an added mass; "
            "run configs/flume.yaml with method1 among its methods"
        )
    return sorted(found, key=lambda r: (r.spring, r.depth_m, r.x0_m))


def published() -> dict[str, list[dict[str, float]]]:
    """Tables 4, 5 and 6 as printed: name -> rows of numbers."""
    names = {
        "4": "table04_method1_long_by_level", "5": "table05_method1_long_full_submergence",
        "6": "table06_method1_short_by_level",
    }  # fmt: skip
    return {
        key: [{k: float(v) for k, v in row.items()} for row in read_rows(PUBLISHED / f"{name}.csv")]
        for key, name in names.items()
    }


def own_answer() -> dict[str, dict[str, dict[str, Any]]]:
    """The flume's own A, B and body frequencies: spring -> level ("2.36") -> numbers; and the drag area."""
    levels = json.loads(TRUTH.read_text(encoding="utf-8"))["levels"]
    return {
        spring: {
            depth: {
                **numbers["by_spring"][spring],
                "area_m2": numbers["area_m2"],
                "drag_coefficient": numbers["drag_coefficient"],
            }
            for depth, numbers in levels.items()
        }
        for spring in ("long", "short")
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Answers, tables, docs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, help="a finished run folder of configs/flume.yaml")
    folder = parser.parse_args(arguments).run
    with tempfile.TemporaryDirectory() as scratch:
        if folder is None:
            folder = run_to_folder(CONFIG, METHOD_1_ALONE, Path(scratch) / "flume").folder
        rows = rows_of(read_rows(folder / "trials.csv"))
    kept = ",\n".join(" " + json.dumps(asdict(row)) for row in rows)
    (DOCS / "flume_tables.json").write_text(f"[\n{kept}\n]\n".replace("NaN", "null"), encoding="utf-8")
    (DOCS / "flume_tables.md").write_text(page(rows, published(), own_answer()), encoding="utf-8")
