"""Files of a driven campaign, whether in time or of harmonic sets: a group's entry of verdict.json, tables.

Belongs here: their shape. Does not belong here: what stands in them (run.py, response/run.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from undertow.comparison.driven_folds import Tried
from undertow.recording.recording import Condition
from undertow.report.tables import csv_pieces


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
    """One group of verdict.json: the keys of a decay's entry but ``posterior`` and ``transfer``; what else was not
    computed for a driven campaign is null. ``more`` are values by their keys there."""
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
    """Rows as CSV, the columns of all of them; written as the tables of decays are (`csv_pieces`).

    >>> rows_csv([{"file": "=1+1", "nrmse": 0.1}, {"k": 2.0}])
    "file,nrmse,k\\n'=1+1,0.1,\\n,,2\\n"
    """
    return "".join(csv_pieces(list(dict.fromkeys(key for row in rows for key in row)), rows))
