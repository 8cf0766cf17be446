"""Files of a run folder from whole findings: what runs write group by group, at once, and as tables to look into.

Belongs here: nothing that a run does; texts and rows are the package's own (report/).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from undertow.discrepancy.findings import Findings
from undertow.report.tables import Columns, RunTables, csv_pieces, level_rows, mismatch_rows, trial_rows
from undertow.report.verdict_file import CONTRACT, group_json, verdict_pieces
from undertow.report.writing import write_pieces


def verdict_json(findings: Findings) -> dict[str, Any]:
    """verdict.json as a dictionary: contract, groups in the findings' order, across_groups."""
    return {
        "contract": CONTRACT,
        "groups": [group_json(group.verdict) for group in findings.groups],
        "across_groups": {"verdict": _named_across(findings), "sentence": findings.across_groups},
    }


def _named_across(findings: Findings) -> list[str]:
    """Every effect that some group's verdict names, the one of most groups first."""
    names = Counter(
        name for group in findings.groups for name in group.verdict.verdict
        if group.verdict.status != "present_but_small"
    )
    return [name for name, _ in names.most_common()]


def write_verdict(findings: Findings, path: Path) -> Path:
    """Write verdict.json; it never holds NaN or infinity."""
    groups = (group_json(group.verdict) for group in findings.groups)
    return write_pieces(path, verdict_pieces(groups, findings.across_groups))


def write_tables(findings: Findings, folder: Path) -> Mapping[str, Path]:
    """Write trials.csv, levels.csv, mismatch.csv and verdict.json into a run folder; each appears whole or not."""
    with RunTables(folder) as tables:
        for i, group in enumerate(findings.groups):
            tables.add(group, (i,))
        return tables.write(findings.failed, findings.across_groups)


def trials_table(findings: Findings) -> pd.DataFrame:
    """One row a trial and method: file, trial, conditions, method, ``<parameter>`` and ``<parameter>_stderr``, scores.

    The standard error holds noise and what was held fixed, in quadrature. ``outcome`` is "ok" or sentences. A trial
    that failed has one row without a method; its outcome says why.
    """
    columns = columns_of(findings)
    found = [columns.named(row) for group in findings.groups for row in trial_rows(group)]
    found += [columns.failed(trial) for trial in findings.failed]
    return pd.DataFrame(found, columns=pd.Index(columns.trials))


def levels_table(findings: Findings) -> pd.DataFrame:
    """One row a group and method, fitted together: conditions, dry, trials, method, parameters, scores, the equation.

    The first row of a group, method "baseline", is the equation that the verdict is about, with its group scores.
    ``nrmse`` of the other methods is the median over trials of their free-run errors.
    """
    found = [row for group in findings.groups for row in level_rows(group)]
    return pd.DataFrame(found, columns=pd.Index(columns_of(findings).levels))


def mismatch_table(findings: Findings) -> pd.DataFrame:
    """One row a trial: file, trial, conditions, nrmse, both floors, missing, shares (empty: not computed), held_out."""
    columns = columns_of(findings)
    found = [columns.named(row) for group in findings.groups for row in mismatch_rows(group)]
    return pd.DataFrame(found, columns=pd.Index(columns.mismatch))


def columns_of(findings: Findings) -> Columns:
    """The columns of a finished campaign's tables."""
    columns = Columns()
    for group in findings.groups:
        columns.see(group)
    return columns


def csv_text(table: pd.DataFrame) -> str:
    """A table as CSV: FLOAT_FORMAT, empty where there is no number, truth values as true and false."""
    found = (dict(zip(table.columns, values, strict=True)) for values in table.itertuples(index=False, name=None))
    return "".join(csv_pieces([str(column) for column in table.columns], found))
