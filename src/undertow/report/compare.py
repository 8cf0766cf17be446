"""Runs side by side, from their run folders.

Belongs here: joining levels.csv of several runs. Does not belong here: running anything.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment

from undertow.errors import UndertowError

_PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>undertow: runs side by side</title>
<style>body{font:14px sans-serif;margin:30px}table{border-collapse:collapse}
th,td{padding:4px 10px;border-bottom:1px solid #ccc;text-align:right}
th:first-child,td:first-child{text-align:left}</style></head><body><h1>Runs side by side</h1>
<table><tr>{% for c in columns %}<th>{{ c }}</th>{% endfor %}</tr>
{% for row in rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>{% endfor %}</table></body></html>"""


def compare_runs(folders: Sequence[Path]) -> pd.DataFrame:
    """One row a group: each run's baseline error, verdict and parameters, a column a run.

    Columns are ``group`` and ``<run>: <quantity>``. Raises UndertowError where a folder holds no finished run.
    """
    tables = [_one_run(folder) for folder in folders]
    joined = tables[0]
    for table in tables[1:]:
        joined = joined.merge(table, on="group", how="outer")
    return joined


def comparison_html(folders: Sequence[Path]) -> str:
    """The comparison as a page; all texts escaped."""
    table = compare_runs(folders)
    rows = [["" if pd.isna(cell) else cell for cell in row] for row in table.itertuples(index=False)]
    return Environment(autoescape=True).from_string(_PAGE).render(columns=list(table.columns), rows=rows)


def _one_run(folder: Path) -> pd.DataFrame:
    path = folder / "verdict.json"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        rows = [_row(entry, folder.name) for entry in content["groups"]]
    except (OSError, ValueError, KeyError, TypeError) as reason:
        raise UndertowError(
            f"run folder {folder}: {path.name} cannot be read ({type(reason).__name__}); give a folder that "
            "`undertow run` made"
        ) from reason
    return pd.DataFrame(rows)


def _row(entry: dict[str, Any], run: str) -> dict[str, Any]:
    words = ", ".join(f"{key} {value}" for key, value in entry["group"].items()) or "all trials"
    baseline = entry["baseline"]
    row: dict[str, Any] = {"group": words, f"{run}: verdict": ", ".join(entry["verdict"]) or entry["status"]}
    row[f"{run}: error"] = baseline["nrmse"]
    for name, estimate in baseline["parameters"].items():
        if isinstance(estimate, dict) and estimate.get("value") is not None:
            row[f"{run}: {name}"] = f"{estimate['value']:.5g}"
    return row
