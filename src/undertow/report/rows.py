"""One group's rows of trials.csv, levels.csv and mismatch.csv: what stands in which column.

Belongs here: rows from finished findings. Does not belong here: which columns a whole campaign has, files (tables.py).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from statistics import median

from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.discrepancy.mismatch import Mismatch
from undertow.likelihood.fit import Fit
from undertow.quantities import OK, Estimate
from undertow.report.expressions import method_equation, numeric_latex
from undertow.uncertainty.disagreement import DIFFER

SCORES = ("nrmse", "sensor_floor_nrmse", "repeatability_nrmse", "outcome")
"""Columns that every table ends with."""

SHARES = tuple(f.name for f in dataclasses.fields(Mismatch) if f.name not in ("trial", *SCORES))
"""Columns of mismatch.csv that say where a mismatch is."""

DIFFERS = "trials_differ"
"""Column of levels.csv: the parameters whose standard errors have grown because trials differ by more than theirs."""

PATH = " path"
"""Where a row keeps its recording's path until the file's name is known; no column is called so."""

_OWN = {
    "file", "trial", "method", "missing", "held_out", "dry", "trials", "equation", "equation_latex", DIFFERS, *SCORES,
    *SHARES,
}  # fmt: skip

Row = dict[str, object]


def trial_rows(group: GroupFindings) -> Iterator[Row]:
    """One row a trial and method."""
    for trial in group.trials:
        head = _head(group, trial)
        for method, fit in trial.fits.items():
            scores = _scores(trial.nrmse.get(method, math.nan), trial.mismatch)
            yield {**head, "method": method, **_columns(fit.parameters), **scores, "outcome": outcome_of(fit)}


def mismatch_rows(group: GroupFindings) -> Iterator[Row]:
    """One row a trial."""
    for trial in group.trials:
        shares = {name: getattr(trial.mismatch, name) for name in SHARES}
        scores = _scores(trial.mismatch.nrmse, trial.mismatch)
        missing = {"missing": trial.mismatch.missing}
        yield {**_head(group, trial), **scores, **missing, **shares, "held_out": trial.held_out}


def level_rows(group: GroupFindings) -> Iterator[Row]:
    """One row a method: the baseline first, then what each method found for the group together."""
    verdict = group.verdict
    held_out = sum(trial.held_out for trial in group.trials)
    head: Row = {condition_column(key): value for key, value in group.key.items()}
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
        grown = "; ".join(name for name, e in parameters.items() if e.source.endswith(DIFFER))
        equation, stderr = method_equation(group, method)
        written = {DIFFERS: grown, "equation": equation.text(stderr), "equation_latex": numeric_latex(equation, stderr)}
        columns = _columns(parameters)
        yield {**head, "method": method, **columns, "nrmse": nrmse, **floors, "outcome": outcome, **written}


def outcome_of(fit: Fit) -> str:
    """ "ok", or what is wrong with the fit and with each of its estimates."""
    said = [] if fit.outcome == OK else [fit.outcome]
    said += [f"{name}: {e.outcome}" for name, e in fit.parameters.items() if e.outcome not in (OK, fit.outcome)]
    return "; ".join(said) or OK


def condition_column(name: str) -> str:
    """The column of a condition: its name; one called like a table's own column gets a prefix.

    >>> condition_column("spring"), condition_column("method")
    ('spring', 'condition_method')
    """
    return f"condition_{name}" if name in _OWN else name


def _head(group: GroupFindings, trial: TrialFindings) -> Row:
    recording = trial.motion.recording
    named = {condition_column(key): value for key, value in {**group.key, **recording.conditions}.items()}
    return {PATH: recording.path, "trial": recording.name, **named}


def _columns(parameters: Mapping[str, Estimate]) -> Row:
    row: Row = {}
    for name, estimate in parameters.items():
        row[name] = estimate.value
        row[f"{name}_stderr"] = estimate.total_stderr
    return row


def _scores(nrmse: float, mismatch: Mismatch) -> Row:
    return {
        "nrmse": nrmse,
        "sensor_floor_nrmse": mismatch.sensor_floor_nrmse,
        "repeatability_nrmse": mismatch.repeatability_nrmse,
    }
