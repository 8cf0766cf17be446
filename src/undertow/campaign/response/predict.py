"""The equation that a run found in a harmonic set, swept through another set that nobody fitted: `undertow predict`.

Belongs here: from run folder and file to a table with a band. Does not belong here: steady motions
(equation/steady_state.py), recordings in time (driven/predict.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.config import load
from undertow.campaign.driven.predict import equations_of, met
from undertow.campaign.driven.trials import recording_alone
from undertow.campaign.response.curves import seen
from undertow.campaign.response.sets import Sweeps, one_set
from undertow.equation.driven_laws import places
from undertow.equation.steady_state import closed_orbit, swept
from undertow.equation.term import Array
from undertow.errors import ConfigError
from undertow.methods.driven_equations import BAND_90, DrivenEquation, read_back
from undertow.methods.harmonic_set import harmonic_theta, slots_of
from undertow.recording.conditions import same_condition
from undertow.recording.recording import Condition
from undertow.recording.response_table import ResponseTable
from undertow.report.writing import write_text


@dataclass(frozen=True)
class PredictedSet:
    """Amplitudes and phases of the equation swept as ``table`` was measured, each (n,), and the amplitudes' standard
    error; ``unit`` is the amplitudes'."""

    table: ResponseTable
    amplitude: Array
    phase: Array
    stderr: Array
    unit: str

    @property
    def rms(self) -> float:
        """RMS of predicted less measured amplitudes."""
        return float(np.sqrt(np.mean((self.amplitude - self.table.amplitude) ** 2)))

    @property
    def covered(self) -> float:
        """Share of the measured amplitudes in the 90 % band."""
        return float(np.mean(np.abs(self.amplitude - self.table.amplitude) <= BAND_90 * self.stderr))

    def __repr__(self) -> str:
        return met(self.rms, self.covered, self.unit)

    def csv(self) -> str:
        """frequency_Hz, measured, predicted, lower, upper, used (amplitudes; used is 0: nothing measured was used),
        measured_phase_rad, predicted_phase_rad: one row a point."""
        half = BAND_90 * self.stderr
        columns = (
            self.table.rate / (2.0 * math.pi), self.table.amplitude, self.amplitude, self.amplitude - half,
            self.amplitude + half, np.zeros(half.size), self.table.phase, self.phase,
        )  # fmt: skip
        header = "frequency_Hz,measured,predicted,lower,upper,used,measured_phase_rad,predicted_phase_rad"
        lines = [",".join(f"{value:.10g}" for value in row) for row in zip(*columns, strict=True)]
        return "\n".join([header, *lines]) + "\n"


def predict_response(
    run: Path,
    recording: Path,
    group: Mapping[str, Condition] | None = None,
    config: Path | None = None,
    out: Path | None = None,
) -> PredictedSet | None:
    """The run's equation, with what was added to it, swept through the frequencies of another set in its order.

    None where ``config`` (it replaces the run's) describes recordings in time. Raises ConfigError where the file or
    its group is not there, RecordingError where it cannot be read, IdentificationError where the body is drawn to no
    motion of the drive's period.
    """
    settings = load(config or run / "config.yaml")
    if settings.recordings.response is None:
        return None
    if not recording.exists():
        raise ConfigError(f"{recording} is not there; give the path of a harmonic set")
    settings, entry = recording_alone(settings, recording)
    version = _version(equations_of(run)["groups"], entry.conditions if group is None else group)
    table, measured, unit = one_set(settings, entry.name, entry.path, entry.conditions)
    one = Sweeps({}, (table,), measured, np.zeros(table.rate.size, dtype=np.int64), unit)
    absolute = version["frames"].get("displacement") == "absolute"
    made = PredictedSet(table, *_swept(read_back(version), one, absolute), unit)
    if out is not None:
        write_text(out, made.csv())
    return made


def _version(groups: Sequence[Mapping[str, Any]], wanted: Mapping[str, Condition]) -> Mapping[str, Any]:
    """The equation of the only group, or of the one with these conditions."""
    fitting = [
        entry for entry in groups
        if all(same_condition(wanted.get(key), value) for key, value in entry["group"].items())
    ]  # fmt: skip
    found = groups if len(groups) == 1 else fitting
    if len(found) != 1:
        have = "; ".join(", ".join(f"{k}={v}" for k, v in entry["group"].items()) for entry in groups)
        raise ConfigError(f"{len(found)} groups of the run are meant; give --group, one of: {have}")
    versions: Mapping[str, Any] = found[0]["versions"]
    chosen: Mapping[str, Any] = versions.get("augmented", versions["baseline"])
    return chosen


def _swept(equation: DrivenEquation, one: Sweeps, absolute: bool) -> tuple[Array, Array, Array]:
    """Amplitude, phase and the amplitude's standard error (n,), each sweep from rest in the order it was measured in.

    The error holds the numbers' covariance and what was missed at points nobody fitted, enlarged where this set moves
    further than those.
    """
    measured = one.measured
    unknowns = places(equation.laws.terms, measured.mover)
    values = {**equation.laws.starts, **equation.laws.fixed}
    theta, (active, gather) = harmonic_theta(values, unknowns), slots_of(equation.names, unknowns)
    n = measured.rate.size
    cosine, sine, variance = np.zeros(n), np.zeros(n), np.zeros(n)
    for sweep in one.along:
        here = sweep if one.rising[sweep[0]] else sweep[::-1]
        rate, force = measured.rate[here], measured.force[here]
        states = swept(theta, force, rate, equation.extent, measured.mover)
        cosine[here], sine[here] = seen(states, force, absolute)
        for i, f, state in zip(here, force, states, strict=True):
            found = closed_orbit(theta, float(f), state.rate, state.state, equation.extent, active, measured.mover)
            slopes = (np.zeros((2, active.size)) if found is None else found.slopes) @ gather
            toward = np.array([cosine[i], sine[i]]) / max(math.hypot(cosine[i], sine[i]), 1e-300)
            variance[i] = toward @ slopes @ equation.covariance @ slopes.T @ toward
    amplitude = np.hypot(cosine, sine)
    wider = max(1.0, one.size / equation.motion) if equation.motion > 0.0 else 1.0
    white = min(equation.noise, equation.error) ** 2
    stderr = np.sqrt(variance + white + (equation.error**2 - white) * wider**2)
    return amplitude, np.arctan2(-sine, cosine), stderr
