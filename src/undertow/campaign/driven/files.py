"""Files of a driven campaign, whether in time or of harmonic sets: a group's entry of verdict.json, tables.

Belongs here: their shape. Does not belong here: what stands in them (run.py, response/run.py).
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from io import StringIO
from typing import Any

from undertow.comparison.driven_folds import Tried
from undertow.recording.recording import Condition


def group_entry(
    key: Mapping[str, Condition],
    trials: Sequence[str],
    held_out: Sequence[str],
    status: str,
    named: Sequence[str],
    tried: Sequence[Tried],
    sentence: str,
    statistic: str,
    **more: Any,
) -> Mapping[str, Any]:
    """One group of verdict.json as the contract has it; what was not computed for a driven campaign is null. ``more``
    are values by their keys there."""
    return {
        "group": dict(key), "trials": list(trials), "held_out": list(held_out), "status": status,
        "verdict": list(named), "alternatives": [], "confidence": None, "because": "", "detectable": [],
        "p_value": None, "upper_bound": None, "not_testable": [],
        "decision": [
            {"gate": t.name, "statistic": statistic, "value": t.after, "limit": t.before, "passed": not t.because,
             "because": t.because}
            for t in tried
        ],
        "origin": "undetermined", "parameters": {}, "baseline": None, "augmented": None, "sensor_floor_nrmse": None,
        "repeatability_nrmse": None, "rejected": [{"name": t.name, "because": t.because} for t in tried if t.because],
        "physical_check": {"expected": None, "found": None, "agrees": None, "because": ""}, "next_test": "",
        "sentence": sentence, **more,
    }  # fmt: skip


def rows_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as CSV, the columns of all of them."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    stream = StringIO()
    writer = csv.DictWriter(stream, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()
