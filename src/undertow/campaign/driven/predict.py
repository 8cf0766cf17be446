"""The equation found in a run, run free on a recording nobody fitted: `undertow predict`.

Belongs here: from run folder and file to a table with a band. Does not belong here: the free run itself
(methods/driven_equations.py).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.config import load
from undertow.campaign.driven.trials import recording_alone, trial_of
from undertow.conditioning.driven import UNITS_OF_MOTION, DrivenTrial
from undertow.discrepancy.words import percent
from undertow.errors import ConfigError
from undertow.methods.driven_equations import DrivenPrediction, predict_driven, read_back
from undertow.recording.catalogue import read_trial
from undertow.recording.recording import Array
from undertow.report.verdict_file import CONTRACT, as_runs_write_them
from undertow.report.writing import write_text

START = 50
"""Samples that a driven trial's start state comes from where nothing else is said."""


@dataclass(frozen=True)
class Predicted:
    """A prediction beside its recording: rms over samples that the start did not use, in ``unit``."""

    trial: DrivenTrial
    prediction: DrivenPrediction
    unit: str

    @property
    def rms(self) -> float:
        """RMS of the free run against the recording after the start samples."""
        away = (self.prediction.values - self.trial.outputs[self.trial.main])[self.prediction.start :]
        return float(np.sqrt(np.mean(away**2)))

    @property
    def covered(self) -> float:
        """Share of these samples that lie in the 90 % band."""
        measured, after = self.trial.outputs[self.trial.main], slice(self.prediction.start, None)
        inside = (measured >= self.prediction.lower) & (measured <= self.prediction.upper)
        return float(np.mean(inside[after]))

    def __repr__(self) -> str:
        return met(self.rms, self.covered, self.unit)

    def csv(self) -> str:
        """time_s, measured, predicted, lower, upper, used: one row a sample."""
        p, measured = self.prediction, self.trial.outputs[self.trial.main]
        return predicted_csv(self.trial.t, measured, p.values, p.lower, p.upper, np.arange(measured.size) < p.start)


def met(rms: float, covered: float, unit: str, missed: float = math.nan) -> str:
    """How well a recording is met, in words: its share in the band, rms over its own where known, last rms in its unit.

    >>> print(met(0.00123, 0.915, "m", 0.05))
    in the 90 % band: 91.5 % of the samples
    rms over the motion's own rms: 5.0 %
    rms 0.00123 m
    """
    lines = [f"in the 90 % band: {100 * covered:.1f} % of the samples"]
    lines += [f"rms over the motion's own rms: {percent(missed)}"] if math.isfinite(missed) else []
    return "\n".join([*lines, f"rms {rms:.6g} {unit}"])


def predicted_csv(t: Array, measured: Array, predicted: Array, lower: Array, upper: Array, used: np.ndarray) -> str:
    """time_s, measured, predicted, lower, upper, used: one row a sample; ``measured`` is empty without a recording."""
    seen = [f"{value:.10g}" for value in measured] or [""] * t.size
    rows = zip(t, seen, predicted, lower, upper, used, strict=True)
    lines = [f"{time:.10g},{m},{y:.10g},{lo:.10g},{hi:.10g},{int(u)}" for time, m, y, lo, hi, u in rows]
    return "\n".join(["time_s,measured,predicted,lower,upper,used", *lines]) + "\n"


def equations_of(run: Path) -> Mapping[str, Any]:
    """equations.json of a run; ConfigError where there is none, or one of another contract."""
    path = run / "equations.json"
    if not path.exists():
        raise ConfigError(
            f"{run} has no equations.json, so that it holds no equation to run; give the folder of a finished run"
        )
    with as_runs_write_them([run], path.name):
        found: Mapping[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        if found.get("contract") != CONTRACT:
            raise ConfigError(f"{path} is of contract {found.get('contract')!r}, not {CONTRACT}; run the config again")
        if not found["groups"]:
            raise ConfigError(f"{path} holds {len(found['groups'])} groups; give the folder of a finished run")
    return found


def predict_recording(
    run: Path, recording: Path, start: int = START, config: Path | None = None, out: Path | None = None
) -> Predicted:
    """The run's equation, with what was added to it, free on that recording from its first ``start`` samples.

    ``config`` replaces the run's channels; ``out`` takes the table. Raises ConfigError where the run holds no driven
    equation or the start has under three samples, RecordingError where the file cannot be read.
    """
    group = equations_of(run)["groups"][0]
    versions = group["versions"]
    equation = read_back(versions.get("augmented", versions["baseline"]))
    if not recording.exists():
        raise ConfigError(f"{recording} is not there; give the path of a recording")
    settings, entry = recording_alone(load(config or run / "config.yaml"), recording)
    trial = trial_of(settings, entry, read_trial(entry, settings.catalogue()))
    if not 3 <= start < trial.t.size:
        raise ConfigError(f"--start is {start} of {trial.t.size} samples; give at least 3, and fewer than there are")
    said = getattr(settings.recordings.channels, trial.main).unit
    unit = said if said in ("V", "mV", "%") else UNITS_OF_MOTION[trial.main]
    made = Predicted(trial, predict_driven(trial, equation, start), unit)
    if out is not None:
        write_text(out, made.csv())
    return made
