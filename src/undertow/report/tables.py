"""trials.csv, levels.csv and mismatch.csv of a run folder.

Belongs here: tables from finished findings, and their writers. Does not belong here: verdict.json
(verdict_file.py), pages.
"""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from statistics import median

import pandas as pd

from undertow.discrepancy.findings import Findings, GroupFindings, TrialFindings
from undertow.discrepancy.mismatch import Mismatch
from undertow.identification.fit import Fit
from undertow.quantities import OK, Estimate
from undertow.report.expressions import method_equation, numeric_latex
from undertow.report.verdict_file import write_verdict
from undertow.report.wording import ordered_parameters
from undertow.report.writing import write_text

FLOAT_FORMAT = "%.9g"
"""Digits of a number in a CSV: more than any sensor gives, and the same on every machine."""

_SCORES = ("nrmse", "sensor_floor_nrmse", "repeatability_nrmse", "outcome")
_SHARES = tuple(f.name for f in dataclasses.fields(Mismatch) if f.name not in ("trial", *_SCORES))

Row = dict[str, object]


def trials_table(findings: Findings) -> pd.DataFrame:
    """One row a trial and method: file, trial, conditions, method, ``<parameter>`` and ``<parameter>_stderr``, scores.

    The standard error holds noise and what was held fixed, in quadrature. ``outcome`` is "ok" or sentences. A trial
    that failed has one row without a method; its outcome says why.
    """
    conditions = _condition_names(findings)
    parameters = ordered_parameters(
        name for _, trial in _trials(findings) for fit in trial.fits.values() for name in fit.parameters
    )
    rows: list[Row] = []
    for group, trial in _trials(findings):
        head = _head(findings, group, trial, conditions)
        for method, fit in trial.fits.items():
            scores = _scores(trial.nrmse.get(method, math.nan), trial.mismatch)
            rows.append({**head, "method": method, **_columns(fit.parameters), **scores, "outcome": outcome_of(fit)})
    for failed in findings.failed:
        named = {conditions[key]: value for key, value in failed.conditions.items() if key in conditions}
        rows.append({"file": failed.name, "trial": failed.name, **named, "outcome": f"failed: {failed.reason}"})
    columns = ["file", "trial", *conditions.values(), "method", *_with_errors(parameters), *_SCORES]
    return pd.DataFrame(rows, columns=pd.Index(columns))


def levels_table(findings: Findings) -> pd.DataFrame:
    """One row a group and method, fitted together: conditions, dry, trials, method, parameters, scores, the equation.

    The first row of a group, method "baseline", is the equation that the verdict is about, with its group scores.
    ``nrmse`` of the other methods is the median over trials of their free-run errors.
    """
    keys = _unclashed(dict.fromkeys(column for group in findings.groups for column in group.key))
    parameters = ordered_parameters(
        name
        for group in findings.groups
        for numbers in (group.verdict.baseline.parameters, *(fit.parameters for fit in group.fits.values()))
        for name in numbers
    )
    rows = [row for group in findings.groups for row in _level_rows(group, keys)]
    counts = ["dry", "trials", "held_out"]
    columns = [*keys.values(), *counts, "method", *_with_errors(parameters), *_SCORES, "equation", "equation_latex"]
    return pd.DataFrame(rows, columns=pd.Index(columns))


def mismatch_table(findings: Findings) -> pd.DataFrame:
    """One row a trial: file, trial, conditions, nrmse, both floors, missing, shares (empty: not computed), held_out."""
    conditions = _condition_names(findings)
    rows: list[Row] = []
    for group, trial in _trials(findings):
        shares = {name: getattr(trial.mismatch, name) for name in _SHARES}
        rows.append(
            {
                **_head(findings, group, trial, conditions),
                **_scores(trial.mismatch.nrmse, trial.mismatch),
                "missing": trial.mismatch.missing,
                **shares,
                "held_out": trial.held_out,
            }
        )
    columns = ["file", "trial", *conditions.values(), *_SCORES[:3], "missing", *_SHARES, "held_out"]
    return pd.DataFrame(rows, columns=pd.Index(columns))


def write_tables(findings: Findings, folder: Path) -> Mapping[str, Path]:
    """Write trials.csv, levels.csv, mismatch.csv and verdict.json into a run folder; each appears whole or not."""
    folder.mkdir(parents=True, exist_ok=True)
    tables = {
        "trials.csv": trials_table(findings),
        "levels.csv": levels_table(findings),
        "mismatch.csv": mismatch_table(findings),
    }
    paths = {name: write_text(folder / name, csv_text(table)) for name, table in tables.items()}
    return {**paths, "verdict.json": write_verdict(findings, folder / "verdict.json")}


def csv_text(table: pd.DataFrame) -> str:
    """A table as CSV: FLOAT_FORMAT, empty where there is no number, truth values as true and false."""
    shown = table.copy()
    for column in shown.columns:
        if shown[column].map(lambda value: isinstance(value, bool)).any():
            shown[column] = shown[column].map(lambda value: {True: "true", False: "false"}.get(value, value))
    text: str = shown.to_csv(index=False, float_format=FLOAT_FORMAT, lineterminator="\n")
    return text


def outcome_of(fit: Fit) -> str:
    """ "ok", or what is wrong with the fit and with each of its estimates."""
    said = [] if fit.outcome == OK else [fit.outcome]
    said += [f"{name}: {e.outcome}" for name, e in fit.parameters.items() if e.outcome not in (OK, fit.outcome)]
    return "; ".join(said) or OK


def _level_rows(group: GroupFindings, keys: Mapping[str, str]) -> Iterable[Row]:
    verdict = group.verdict
    held_out = sum(trial.held_out for trial in group.trials)
    head: Row = {keys[key]: value for key, value in group.key.items()}
    head |= {"dry": group.dry, "trials": len(group.trials), "held_out": held_out}
    floors: Row = {
        "sensor_floor_nrmse": verdict.sensor_floor_nrmse,
        "repeatability_nrmse": verdict.repeatability_nrmse,
    }
    numbers: list[tuple[str, Mapping[str, Estimate], float, str]] = [
        ("baseline", verdict.baseline.parameters, verdict.baseline.nrmse, OK)
    ]
    for method, fit in group.fits.items():
        errors = [trial.nrmse[method] for trial in group.trials if math.isfinite(trial.nrmse.get(method, math.nan))]
        numbers.append((method, fit.parameters, median(errors) if errors else math.nan, outcome_of(fit)))
    for method, parameters, nrmse, outcome in numbers:
        equation, stderr = method_equation(group, method)
        written = {"equation": equation.text(stderr), "equation_latex": numeric_latex(equation, stderr)}
        columns = _columns(parameters)
        yield {**head, "method": method, **columns, "nrmse": nrmse, **floors, "outcome": outcome, **written}


def _trials(findings: Findings) -> Iterable[tuple[GroupFindings, TrialFindings]]:
    return ((group, trial) for group in findings.groups for trial in group.trials)


def _head(
    findings: Findings, group: GroupFindings, trial: TrialFindings, conditions: Mapping[str, str]
) -> Row:  # fmt: skip
    recording = trial.motion.recording
    known = {**group.key, **recording.conditions}
    named = {conditions[key]: value for key, value in known.items() if key in conditions}
    return {"file": file_of(findings, trial), "trial": recording.name, **named}


def file_of(findings: Findings, trial: TrialFindings) -> str:
    """The trial's file without folders; its own name where several trials share a file, or none is known."""
    paths = Counter(other.motion.recording.path for _, other in _trials(findings))
    path = trial.motion.recording.path
    return Path(path).name if path and paths[path] == 1 else trial.motion.name


def _condition_names(findings: Findings) -> Mapping[str, str]:
    keys = [column for group in findings.groups for column in group.key]
    others = [column for _, trial in _trials(findings) for column in trial.motion.recording.conditions]
    return _unclashed(dict.fromkeys([*keys, *others]))


def _unclashed(conditions: Iterable[str]) -> Mapping[str, str]:
    """Condition -> column; a condition called like one of the table's own columns gets a prefix."""
    own = {"file", "trial", "method", "missing", "held_out", "dry", "trials", "equation", "equation_latex", *_SCORES}
    return {name: f"condition_{name}" if name in own or name in _SHARES else name for name in conditions}


def _columns(parameters: Mapping[str, Estimate]) -> Row:
    row: Row = {}
    for name, estimate in parameters.items():
        row[name] = estimate.value
        row[f"{name}_stderr"] = estimate.total_stderr
    return row


def _with_errors(parameters: Sequence[str]) -> list[str]:
    return [column for name in parameters for column in (name, f"{name}_stderr")]


def _scores(nrmse: float, mismatch: Mismatch) -> Row:
    return {
        "nrmse": nrmse,
        "sensor_floor_nrmse": mismatch.sensor_floor_nrmse,
        "repeatability_nrmse": mismatch.repeatability_nrmse,
    }
