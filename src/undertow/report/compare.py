"""Runs side by side, from their run folders.

Belongs here: joining verdict.json of several runs. Does not belong here: running anything.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment

from undertow.discrepancy.words import group_title, percent
from undertow.errors import UndertowError
from undertow.quantities import Estimate
from undertow.report.wording import estimate_text

_PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>undertow: runs side by side</title>
<style>body{font:14px sans-serif;margin:30px}table{border-collapse:collapse}
th,td{padding:4px 10px;border-bottom:1px solid #ccc;text-align:left}</style></head><body><h1>Runs side by side</h1>
<table><tr>{% for c in columns %}<th>{{ c }}</th>{% endfor %}</tr>
{% for row in rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>{% endfor %}</table></body></html>"""

Entry = dict[str, str]
"""What a run says of one group: quantity -> text."""


def compare_runs(folders: Sequence[Path]) -> pd.DataFrame:
    """One row a group and quantity (verdict, errors, the baseline's parameters), one column a run, all as text.

    Groups and quantities stand in the order of the runs; an empty cell is what a run does not have. Runs of one name
    are told apart by their paths. Raises UndertowError where a folder holds no finished run.
    """
    names = _labels(folders)
    runs = [_one_run(folder) for folder in folders]
    groups = list(dict.fromkeys(group for run in runs for group in run))
    rows = []
    for group in groups:
        entries = [run.get(group, {}) for run in runs]
        for quantity in dict.fromkeys(q for entry in entries for q in entry):
            cells = {name: entry.get(quantity, "") for name, entry in zip(names, entries, strict=True)}
            rows.append({"group": group, "quantity": quantity, **cells})
    return pd.DataFrame(rows, columns=pd.Index(["group", "quantity", *names]))


def comparison_text(folders: Sequence[Path]) -> str:
    """The comparison for a terminal: a group's name once, its quantities below, columns aligned."""
    table = compare_runs(folders)
    widths = [max(len(str(cell)) for cell in [name, *table[name]]) for name in table.columns[1:]]

    def line(cells: Sequence[str]) -> str:
        return "  " + "  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True)).rstrip()

    lines = [line(list(table.columns[1:]))]
    for group, rows in table.groupby("group", sort=False):
        lines.append(str(group))
        lines += [line([str(cell) for cell in row]) for row in rows.iloc[:, 1:].itertuples(index=False)]
    return "\n".join(lines)


def comparison_html(folders: Sequence[Path]) -> str:
    """The comparison as a page; all texts escaped."""
    table = compare_runs(folders)
    rows = [list(row) for row in table.itertuples(index=False)]
    return Environment(autoescape=True).from_string(_PAGE).render(columns=list(table.columns), rows=rows)


def _labels(folders: Sequence[Path]) -> list[str]:
    """A name a run: its folder's, its path where two folders have one name, numbered where a path is given twice."""
    short = Counter(folder.resolve().name for folder in folders)
    names = [f.resolve().name if short[f.resolve().name] == 1 else str(f) for f in folders]
    seen: Counter[str] = Counter()
    out = []
    for name in names:
        seen[name] += 1
        out.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return out


def _one_run(folder: Path) -> dict[str, Entry]:
    path = folder / "verdict.json"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return {group_title(entry["group"]): _entry(entry) for entry in content["groups"]}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as reason:
        why = getattr(reason, "strerror", None) or f"it is not a run's verdict ({type(reason).__name__})"
        raise UndertowError(
            f"run folder {folder}: {path.name} cannot be read: {why}; give a folder that `undertow run` finished"
        ) from reason


def _entry(entry: Mapping[str, Any]) -> Entry:
    baseline = entry["baseline"]
    found: Entry = {
        "verdict": ", ".join(entry["verdict"]) or entry["status"],
        "free-run error": percent(_number(baseline["nrmse"])),
        "held-out error": percent(_number(baseline["held_out_nrmse"])),
        "repeatability": percent(_number(entry["repeatability_nrmse"])),
    }
    for name, estimate in baseline["parameters"].items():
        if isinstance(estimate, dict) and estimate.get("value") is not None:
            value, error = float(estimate["value"]), _number(estimate.get("stderr"))
            found[name] = estimate_text(Estimate(value, error, unit=str(estimate.get("unit", ""))))
    return found


def _number(value: Any) -> float:
    return math.nan if value is None else float(value)
