"""`open`: a finished run's folder, read again.

Belongs here: verdict.json, the tables and the config of a run as a user handles them. Does not belong here: writing
them (report/, campaign/run/folder.py).
"""

from __future__ import annotations

import math
import webbrowser
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from undertow.campaign.config import RunConfig
from undertow.campaign.config import load as load_config
from undertow.campaign.driven.predict import Predicted, equations_of
from undertow.campaign.response.predict import PredictedSet
from undertow.discrepancy.words import group_title
from undertow.equation.equation import Equation
from undertow.errors import ConfigError, UndertowError
from undertow.front.found_equation import FoundEquation
from undertow.front.known import place_of
from undertow.front.prediction import Prediction, predict
from undertow.front.reading import load
from undertow.front.run_prediction import RunPrediction, StoredEquation, predict_driven_run, predict_run
from undertow.front.tables import parameter_table
from undertow.front.trials import Trials
from undertow.front.verdicts import Verdicts
from undertow.quantities import Estimate, or_nan
from undertow.recording.recording import Array, Condition
from undertow.report.tables import as_written
from undertow.report.verdict_file import as_runs_write_them, read_verdicts
from undertow.report.writing import PAGES


@dataclass(frozen=True, eq=False, repr=False)
class OpenedGroup(FoundEquation):
    """One group's entry of verdict.json in the run's ``folder``; ``data`` is the whole of it."""

    data: Mapping[str, Any] = field(repr=False)
    folder: Path = field(repr=False)

    @property
    def label(self) -> str:
        """The group's conditions in words."""
        return group_title(self.conditions)

    @property
    def conditions(self) -> Mapping[str, Condition]:
        """The group's conditions by name."""
        conditions: Mapping[str, Condition] = self.data["group"]
        return conditions

    @property
    def status(self) -> str:
        """explained, nothing_missing, present_but_small, unknown, not_identifiable or cannot_tell."""
        return str(self.data["status"])

    @property
    def names(self) -> tuple[str, ...]:
        """What is missing, the strongest first."""
        return tuple(self.data["verdict"])

    @property
    def sentence(self) -> str:
        """What was found, in plain words."""
        return str(self.data["sentence"])

    @property
    def prescribed(self) -> pd.DataFrame:
        """Parameters of the prescribed equation: value, stderr, low and high of the 90 % interval, unit, note."""
        return parameter_table(_estimates(self.data["baseline"]["parameters"]))

    @property
    def repaired(self) -> pd.DataFrame:
        """Parameters of the repaired equation, of the prescribed one where nothing is named."""
        return parameter_table(_estimates((self.data.get("augmented") or self.data["baseline"])["parameters"]))

    @property
    def parameters(self) -> pd.DataFrame:
        """The same, as a group of `undertow.diagnose` has it."""
        return self.repaired

    @cached_property
    def _stored(self) -> StoredEquation:
        found = [one for one in equations_of(self.folder)["groups"] if one["group"] == self.data["group"]]
        if not found or found[0]["driven"]:
            what = "is a driven body: take the run's predict" if found else "has no equation"
            raise UndertowError(f"{self.label} of {self.folder} {what}; its numbers are in `repaired`")
        return StoredEquation(found[0])

    @property
    def equation(self) -> Equation:
        """The repaired equation with its numbers; the prescribed one where nothing is named.

        Raises UndertowError where the group is of a driven body, or no equation could be fitted.
        """
        return self._stored.equation

    def predict(self, recording: Any = None, **settings: Any) -> RunPrediction | Prediction:
        """The equation run free on a recording nobody fitted, or from a start, with its band; see `predict_run`, and
        `undertow.predict` of trials that were read or are arrays."""
        if not (recording is None or isinstance(recording, str | Path)):
            return predict(self, recording, **settings)
        return predict_run(self.folder, recording, group=self.data["group"], **settings)

    def _errors(self) -> Mapping[str, float]:
        return self._stored.errors

    def theta_draws(self, draws: int, rng: np.random.Generator) -> tuple[Array, Mapping[str, float], str]:
        """Parameter vectors (draws, slots) as the numbers' errors spread them, the scatter from trial to trial, and
        where it comes from."""
        return self._stored.theta_draws(draws, rng)

    def _own_score(self) -> float:
        """The score on the trials that were held out, or left out in turn, on all where none was."""
        row = self.row
        keys = ("held_out_repaired", "held_out_error", "left_out_repaired", "error_repaired", "error")
        errors = (row[key] for key in keys)
        return 1.0 - next((error for error in errors if math.isfinite(error)), math.nan)

    @property
    def row(self) -> dict[str, Any]:
        """The group's row of a table of verdicts."""
        data, after = self.data, self.data.get("augmented") or {}
        return {
            "status": self.status, "missing": ", ".join(self.names), "confidence": or_nan(data["confidence"]),
            "error": or_nan(data["baseline"]["nrmse"]), "error_repaired": or_nan(after.get("nrmse")),
            "held_out_error": or_nan(data["baseline"]["held_out_nrmse"]),
            "held_out_repaired": or_nan(after.get("held_out_nrmse")),
            "left_out_error": or_nan(data["baseline"].get("cross_validated_nrmse")),
            "left_out_repaired": or_nan(after.get("cross_validated_nrmse")),
            "allowed": or_nan(data["repeatability_nrmse"]), "trials": len(data["trials"]), "sentence": self.sentence,
        }  # fmt: skip

    def __repr__(self) -> str:
        return self.sentence

    def _repr_html_(self) -> str:
        table = self.repaired.to_html(border=0, float_format=lambda value: f"{value:.5g}", na_rep="-")
        return f"<div><p>{escape(self.sentence)}</p>{table}</div>"


@dataclass(frozen=True, eq=False, repr=False)
class OpenedRun(Verdicts[OpenedGroup]):
    """A finished run: its ``folder``, and every group's verdict in the run's order."""

    folder: Path
    groups: tuple[OpenedGroup, ...]
    across_groups: str = ""

    @cached_property
    def trials(self) -> pd.DataFrame:
        """trials.csv: one row a trial and method."""
        return self._table("trials")

    @cached_property
    def levels(self) -> pd.DataFrame:
        """levels.csv: one row a group and method, with the equation."""
        return self._table("levels")

    @cached_property
    def mismatch(self) -> pd.DataFrame:
        """mismatch.csv: one row a trial, where it differs from its group's equation."""
        return self._table("mismatch")

    @cached_property
    def config(self) -> RunConfig:
        """The run's config as it was resolved."""
        return load_config(self._file("config.yaml"))

    def predict(
        self, recording: str | Path | None = None, **settings: Any
    ) -> RunPrediction | Predicted | PredictedSet:
        """A group's equation run free on a recording nobody fitted, or from a start; see `predict_run` (of a driven
        body `predict_driven_run`)."""
        if equations_of(self.folder)["groups"][0]["driven"]:
            return predict_driven_run(self.folder, recording, **settings)
        return predict_run(self.folder, recording, **settings)

    def recordings(self, jobs: int = 1) -> Trials:
        """The run's recordings, read and conditioned again from where its config names them."""
        return load(self.config, jobs=jobs)

    @property
    def report(self) -> Path:
        """The page, report.html."""
        return self._file("report.html")

    def _table(self, name: str) -> pd.DataFrame:
        path = self._file(f"{name}.csv")
        with as_runs_write_them([self.folder], path.name):
            table = pd.read_csv(path).rename(columns=as_written)
        return table.map(lambda value: as_written(value) if isinstance(value, str) else value)

    def _file(self, name: str) -> Path:
        path = self.folder / name
        if not path.is_file():
            raise UndertowError(f"run folder {self.folder} has no {name}; let `undertow run` finish, or copy it whole")
        return path

    def __repr__(self) -> str:
        lines = [group.sentence for group in self.groups]
        return "\n".join([f"run {self.folder}", *lines, *([self.across_groups] if self.across_groups else [])])


def open_run(folder: str | Path) -> OpenedRun:
    """A finished run's folder: verdicts, repaired parameters, tables, config, recordings.

    Raises UndertowError where it is no run folder, or was written under another contract.

    >>> import tempfile, undertow
    >>> from undertow.campaign.run.folder import run_to_folder
    >>> folder = tempfile.TemporaryDirectory()
    >>> place = Path(folder.name)
    >>> run = undertow.simulate({"stiffness": 400.0, "viscous_damping": 2.0}, x0=0.1, mass_kg=4.0, duration_s=6.0)
    >>> pd.DataFrame({"t": run.t, "x": run.x}).to_csv(place / "r1.csv", index=False)
    >>> _ = (place / "c.yaml").write_text("{name: c, recordings: {files: r*.csv, "
    ...     "channels: {time: {column: t, unit: s}, displacement: {column: x, unit: m}}}, "
    ...     "equation: {terms: [stiffness, viscous_damping]}, "
    ...     "identify: [output_error], discrepancy: {suspects: []}}")
    >>> _ = run_to_folder(place / "c.yaml", out=place / "run", jobs=1, page=False)  # or `undertow run c.yaml`
    >>> opened = open_run(place / "run")
    >>> opened[0].status, opened[0].repaired.value.round(2).tolist()
    ('cannot_tell', [100.0, 0.5])
    >>> opened[0].simulate(0.1, duration_s=1.0, rate_hz=4.0).x.round(4).tolist()  # its equation: print, to_python, ...
    [0.1, -0.0738, 0.0228, 0.0309]
    >>> folder.cleanup()
    >>> open_run("no_such_run")
    Traceback (most recent call last):
    undertow.errors.UndertowError: no_such_run is no run folder: it has no verdict.json; give what `undertow run` wrote
    """
    place = place_of(folder, "folder")
    path = place / "verdict.json"
    if not path.is_file():
        raise UndertowError(f"{place} is no run folder: it has no verdict.json; give what `undertow run` wrote")
    data = read_verdicts(place)
    groups = tuple(OpenedGroup(group, place) for group in data["groups"])
    return OpenedRun(place, groups, data["across_groups"]["sentence"])


def page_of(run: str | Path) -> Path:
    """The page of a run folder (of `undertow run`, `audit` or `differ`), or the page itself where one is given.

    Raises ConfigError where there is none.

    >>> try:
    ...     page_of("no_such_run")
    ... except UndertowError as said:
    ...     print(str(said).partition(";")[0])
    no_such_run has no page: neither report.html nor audit.html nor differ.html
    """
    place = Path(run)
    if place.is_file() and place.suffix == ".html":
        return place
    for name in PAGES:
        if (place / name).is_file():
            return place / name
    raise ConfigError(
        f"{place} has no page: neither {' nor '.join(PAGES)}; give the folder that `undertow run` printed in its last "
        "line"
    )


def show(run: str | Path) -> Path:
    """Open a run's page in the browser; returns the page.

    Raises UndertowError where there is no page, or no browser that can be started.
    """
    page = page_of(run).resolve()
    if not webbrowser.open(page.as_uri()):
        raise UndertowError(f"no browser can be started here; open {page} yourself, or copy it: it needs no other file")
    return page


def _estimates(parameters: Mapping[str, Mapping[str, Any]]) -> dict[str, Estimate]:
    return {
        name: Estimate(or_nan(one["value"]), or_nan(one["stderr"]), unit=one["unit"])
        for name, one in parameters.items()
    }
