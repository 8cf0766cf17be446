"""trials.csv, levels.csv and mismatch.csv of a run folder, written as a campaign's groups come.

A campaign may have more groups than memory: their rows wait in a file until all columns are known.

Belongs here: a group's rows, the files' columns, order and text. Does not belong here: verdict.json (verdict_file.py),
pages.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import itertools
import json
import math
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any, Self

import numpy as np

from undertow.discrepancy.findings import FailedTrial, GroupFindings, TrialFindings
from undertow.discrepancy.mismatch import Mismatch
from undertow.discrepancy.verdict import Verdict
from undertow.likelihood.fit import Fit
from undertow.quantities import OK, Estimate
from undertow.report.expressions import method_equation, numeric_latex
from undertow.report.verdict_file import group_json, verdict_pieces
from undertow.report.wording import ordered_parameters
from undertow.report.writing import write_pieces
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
    numbers: list[tuple[str, Mapping[str, Estimate], float, str]] = [
        ("baseline", verdict.baseline.parameters, verdict.baseline.nrmse, OK)
    ]
    for method, fit in group.fits.items():
        errors = [trial.nrmse[method] for trial in group.trials if math.isfinite(trial.nrmse.get(method, math.nan))]
        numbers.append((method, fit.parameters, median(errors) if errors else math.nan, outcome_of(fit)))
    for method, parameters, nrmse, outcome in numbers:
        grown = "; ".join(name for name, e in parameters.items() if e.source.endswith(DIFFER))
        equation, stderr = method_equation(group, method)
        latex = numeric_latex(equation, stderr, rotation=group.specimen.rotation)
        written = {DIFFERS: grown, "equation": equation.text(stderr), "equation_latex": latex}
        columns = _columns(parameters)
        yield {**head, "method": method, **columns, **_scores(nrmse, verdict), "outcome": outcome, **written}


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


def _scores(nrmse: float, of: Mismatch | Verdict) -> Row:
    return {
        "nrmse": nrmse, "sensor_floor_nrmse": of.sensor_floor_nrmse, "repeatability_nrmse": of.repeatability_nrmse,
    }  # fmt: skip


FLOAT_FORMAT = "%.9g"
"""Digits of a number in a CSV: more than any sensor gives, and the same on every machine."""

FORMULAS = ("=", "+", "-", "@", "\t")
"""What a cell begins with that a spreadsheet would calculate (OWASP, CSV injection)."""

ROWS_A_PIECE = 1000
"""Rows that are written at once."""

NOTES_AT_MOST = 1000
"""Notes that the manifest and the page can hold: of more, all stand in notes.txt."""

Place = tuple[Any, ...]
"""Where a group stands among the others: groups are written in the order of their places."""


class Columns:
    """Which conditions and parameters the rows of a campaign have, as they come."""

    def __init__(self) -> None:
        self._keys: dict[str, None] = {}
        self._others: dict[str, None] = {}
        self._of_trials: dict[str, None] = {}
        self._of_groups: dict[str, None] = {}
        self._paths: Counter[str] = Counter()

    def see(self, group: GroupFindings) -> None:
        """Take one more group's into account."""
        self._keys.update(dict.fromkeys(group.key))
        numbers = (group.verdict.baseline.parameters, *(fit.parameters for fit in group.fits.values()))
        self._of_groups.update(dict.fromkeys(name for found in numbers for name in found))
        for trial in group.trials:
            self._others.update(dict.fromkeys(trial.motion.recording.conditions))
            self._of_trials.update(dict.fromkeys(name for fit in trial.fits.values() for name in fit.parameters))
            self._paths[trial.motion.recording.path] += 1

    @property
    def conditions(self) -> Mapping[str, str]:
        """Every condition of a trial -> its column."""
        return {name: condition_column(name) for name in (*self._keys, *self._others)}

    @property
    def trials(self) -> list[str]:
        """Columns of trials.csv."""
        names = _with_errors(ordered_parameters(self._of_trials))
        return ["file", "trial", *self._conditions(), "method", *names, *SCORES]

    @property
    def levels(self) -> list[str]:
        """Columns of levels.csv."""
        keys = [condition_column(name) for name in self._keys]
        names = _with_errors(ordered_parameters(self._of_groups))
        counts = ["dry", "trials", "held_out"]
        return [*keys, *counts, "method", *names, *SCORES, DIFFERS, "equation", "equation_latex"]

    @property
    def mismatch(self) -> list[str]:
        """Columns of mismatch.csv."""
        return ["file", "trial", *self._conditions(), *SCORES[:3], "missing", *SHARES, "held_out"]

    def named(self, row: Row) -> Row:
        """A trial's row with its file, without folders; the trial's name where trials share one or none is known."""
        path = str(row.get(PATH, ""))
        file = Path(path).name if path and self._paths[path] == 1 else row["trial"]
        return {"file": file, **row}

    def failed(self, trial: FailedTrial) -> Row:
        """The row of a trial that could not be used."""
        known = self.conditions
        named = {known[key]: value for key, value in trial.conditions.items() if key in known}
        return {"file": trial.name, "trial": trial.name, **named, "outcome": f"failed: {trial.reason}"}

    def _conditions(self) -> list[str]:
        return list(dict.fromkeys(self.conditions.values()))


class RunTables:
    """The tables and verdict.json of a run, group by group; a context, after which the waiting rows are gone.

    Nothing appears in ``folder`` before `write`.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        self._columns = Columns()
        self._waiting = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 - closed by __exit__
        self._places: list[tuple[Place, int]] = []
        self._notes = tempfile.TemporaryFile("w+", dir=folder, encoding="utf-8")  # noqa: SIM115 - closed by __exit__
        self._noted = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._waiting.close()
        self._notes.close()

    def note(self, notes: Sequence[str]) -> None:
        """What reading and conditioning changed, a line each."""
        self._noted += len(notes)
        self._notes.writelines(" ".join(note.split()) + "\n" for note in notes)

    def add(self, group: GroupFindings, place: Place) -> None:
        """One more group; ``place`` is what groups are sorted by in the files."""
        self._columns.see(group)
        record = {
            "trials": list(trial_rows(group)),
            "levels": list(level_rows(group)),
            "mismatch": list(mismatch_rows(group)),
            "verdict": group_json(group.verdict),
        }
        self._places.append((place, self._waiting.seek(0, io.SEEK_END)))
        self._waiting.write(json.dumps(record, default=np.generic.item).encode() + b"\n")

    def write(self, failed: Sequence[FailedTrial], across: str) -> Mapping[str, Path]:
        """Write trials.csv, levels.csv, mismatch.csv and verdict.json; each appears whole or not.

        More than `NOTES_AT_MOST` notes stand in notes.txt.
        """
        said, to = self._columns, self._folder
        if self._noted > NOTES_AT_MOST:
            self._notes.seek(0)
            write_pieces(to / "notes.txt", self._notes)
        of_trials = (said.named(row) for record in self._records() for row in record["trials"])
        of_levels = (row for record in self._records() for row in record["levels"])
        of_mismatch = (said.named(row) for record in self._records() for row in record["mismatch"])
        every = itertools.chain(of_trials, (said.failed(trial) for trial in failed))
        verdicts = verdict_pieces((record["verdict"] for record in self._records()), across)
        return {
            "trials.csv": write_pieces(to / "trials.csv", csv_pieces(said.trials, every)),
            "levels.csv": write_pieces(to / "levels.csv", csv_pieces(said.levels, of_levels)),
            "mismatch.csv": write_pieces(to / "mismatch.csv", csv_pieces(said.mismatch, of_mismatch)),
            "verdict.json": write_pieces(to / "verdict.json", verdicts),
        }

    def _records(self) -> Iterator[dict[str, Any]]:
        for _, start in sorted(self._places):
            self._waiting.seek(start)
            record: dict[str, Any] = json.loads(self._waiting.readline())
            yield record


def csv_pieces(columns: Sequence[str], found: Iterable[Mapping[str, object]]) -> Iterator[str]:
    """The text of a CSV, `ROWS_A_PIECE` rows at a time; a column that a row has not is empty.

    >>> "".join(csv_pieces(["a", "b"], [{"a": 0.1 + 0.2, "b": True}, {"b": "x,y"}]))
    'a,b\\n0.3,true\\n,"x,y"\\n'
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([plain(column) for column in columns])
    for i, row in enumerate(found, 1):
        writer.writerow([_cell(row.get(column)) for column in columns])
        if i % ROWS_A_PIECE == 0:
            yield stream.getvalue()
            stream.seek(0)
            stream.truncate()
    yield stream.getvalue()


def _cell(value: object) -> str:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return "" if math.isnan(value) else FLOAT_FORMAT % value
    return plain(value) if isinstance(value, str) else "" if value is None else str(value)


def plain(text: str) -> str:
    """A text that no spreadsheet takes for a formula: an apostrophe before what begins like one (`as_written`).

    >>> plain("=1+1"), plain("long"), as_written("'=1+1"), as_written("'s"), plain("'=1")
    ("'=1+1", 'long', '=1+1', "'s", "''=1")
    """
    text = text.replace("\r", " ")  # alone it ends a row, but only for some readers
    return f"'{text}" if text.lstrip("'").startswith(FORMULAS) else text


def as_written(text: str) -> str:
    """A text of a CSV without the apostrophe that `plain` put before it."""
    return text[1:] if text.startswith("'") and text.lstrip("'").startswith(FORMULAS) else text


def _with_errors(parameters: Sequence[str]) -> list[str]:
    return [column for name in parameters for column in (name, f"{name}_stderr")]
