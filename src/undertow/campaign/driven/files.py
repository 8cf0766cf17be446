"""Files of a driven campaign, whether in time or of harmonic sets: a group's entry of verdict.json, tables.

Belongs here: their shape. Does not belong here: what stands in them (run.py, response/run.py).
"""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from undertow.campaign.config import RunConfig
from undertow.campaign.run.manifest import manifest
from undertow.comparison.driven_folds import Tried
from undertow.discrepancy.findings import FailedTrial, Findings
from undertow.quantities import Estimate
from undertow.recording.recording import Condition
from undertow.report.tables import csv_pieces
from undertow.report.verdict_file import CONTRACT, plain
from undertow.report.writing import write_text


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


def numbers_of(estimates: Mapping[str, Estimate], law: str = "") -> dict[str, Estimate]:
    """The numbers of a law by the names of its parameters (of all laws, by their own names, where empty)."""
    if not law:
        return dict(estimates)
    return {name.removeprefix(f"{law}."): one for name, one in estimates.items() if name.startswith(f"{law}.")}


def numbers_row(estimates: Mapping[str, Estimate]) -> dict[str, Any]:
    """Values and standard errors as a row of a table has them."""
    pairs = (((name, one.value), (f"{name}_stderr", one.stderr)) for name, one in estimates.items())
    return dict(chain.from_iterable(pairs))


def write_answer(
    folder: Path, text: str, config: RunConfig, entries: Sequence[Any], verdicts: Sequence[Any],
    across: Mapping[str, Any],
) -> None:  # fmt: skip
    """config.yaml (``text``), equations.json of the groups' ``entries``, verdict.json of their ``verdicts``."""
    equations = {
        "contract": CONTRACT, "coordinate": config.equation.coordinate, "anchor": "measured input",
        "seed": config.seed, "groups": entries,
    }  # fmt: skip
    verdict = {"contract": CONTRACT, "groups": verdicts, "across_groups": across}
    write_text(folder / "config.yaml", text)
    write_text(folder / "equations.json", json.dumps(plain(equations), indent=1))
    write_text(folder / "verdict.json", json.dumps(plain(verdict), indent=1))


def manifest_of(
    config: RunConfig, config_path: Path, overrides: Sequence[str], failed: tuple[FailedTrial, ...], begun: float
) -> dict[str, Any]:  # fmt: skip
    """The manifest of a run whose identification began at ``begun`` (`time.perf_counter`)."""
    seconds = {"identification": time.perf_counter() - begun}
    findings = Findings(config.name, (), failed, config.methods, config.equation.coordinate, seconds)
    return manifest(findings, config, config_path, overrides)


def write_manifest(folder: Path, made: Mapping[str, Any]) -> None:
    """manifest.json, the last file of a run."""
    write_text(folder / "manifest.json", json.dumps(plain(made), indent=1))


def rows_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as CSV, the columns of all of them; written as the tables of decays are (`csv_pieces`).

    >>> rows_csv([{"file": "=1+1", "nrmse": 0.1}, {"k": 2.0}])
    "file,nrmse,k\\n'=1+1,0.1,\\n,,2\\n"
    """
    return "".join(csv_pieces(list(dict.fromkeys(key for row in rows for key in row)), rows))
