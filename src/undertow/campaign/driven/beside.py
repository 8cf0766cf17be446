"""What stands beside output error in a driven campaign: numbers by an instrument and by regression, what a trial may
miss although nothing is missing, what offset and friction differ by from stroke to stroke.

Belongs here: their values for the files, their tables for the page, their words. Does not belong here: how the numbers
are found (methods/).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.campaign.driven.files import numbers_row
from undertow.conditioning.driven import DrivenTrial, white_noise
from undertow.discrepancy.words import percent
from undertow.errors import IdentificationError
from undertow.likelihood.driven_strokes import Strokes
from undertow.methods.driven import DrivenFit, free_run
from undertow.methods.driven_begin import START_SAMPLES
from undertow.methods.driven_instrument import BesideInstrument, beside_instrument, by_regression
from undertow.methods.driven_repeatability import repeatability_by_repeats, repeatability_by_scatter, scattered
from undertow.quantities import OK, Estimate
from undertow.recording.recording import Coordinate
from undertow.report.numbers import plain_number, short_number
from undertow.report.wording import estimate_text, parameter_words, reason_words


@dataclass(frozen=True)
class ByInstruments:
    """Comparisons of the trials that have an instrument, and trial -> reason where none could be made."""

    compared: tuple[BesideInstrument, ...] = ()
    reasons: Mapping[str, str] | None = None

    @property
    def sentences(self) -> str:
        """What is to be said, each with a space before it; empty where nothing is."""
        said = [one.sentence for one in self.compared if one.sentence]
        return "".join(f" {one[0].upper()}{one[1:]}." for one in said)

    def plain(self) -> list[Mapping[str, Any]]:
        """Values for verdict.json: a trial each."""
        out: list[Mapping[str, Any]] = []
        for one in self.compared:
            numbers = {
                name: {
                    "output_error": one.output_error[name].value, "output_error_stderr": one.output_error[name].stderr,
                    "instrument": found.value, "instrument_stderr": found.stderr, "unit": found.unit,
                    "standard_errors_apart": one.apart[name],
                }
                for name, found in one.instrument.items()
            }  # fmt: skip
            out.append({"trial": one.trial, "share_of_velocity": one.strength, "numbers": numbers, "because": ""})
        out += [
            {"trial": name, "share_of_velocity": None, "numbers": {}, "because": reason}
            for name, reason in (self.reasons or {}).items()
        ]
        return out

    def table(self, coordinate: Coordinate) -> list[tuple[str, ...]]:
        """Rows of the page, the first the header; empty where nothing was compared."""
        rows = [
            (one.trial, parameter_words(name), number_text(one.output_error[name], coordinate),
             number_text(found, coordinate), plain_number(one.apart[name], 2))
            for one in self.compared for name, found in one.instrument.items()
        ]  # fmt: skip
        rows += [(name, "", "", reason, "") for name, reason in (self.reasons or {}).items()]
        header = ("trial", "number", "output error", "by the instrument", "standard errors apart")
        return [header, *rows] if rows else []


def by_instruments(trials: Sequence[DrivenTrial], fitted: DrivenFit) -> ByInstruments:
    """Every trial that has an instrument compared, or the reason why not."""
    compared, reasons = list[BesideInstrument](), dict[str, str]()
    for trial in trials:
        if trial.instrument is None:
            continue
        try:
            compared.append(beside_instrument(trial, fitted))
        except IdentificationError as reason:
            reasons[trial.name] = str(reason)
    return ByInstruments(tuple(compared), reasons)


@dataclass(frozen=True)
class Regressed:
    """One trial's numbers by regression (none where it could not be made), how much of the motion a free run with them
    misses, and ``ok`` or the reason."""

    trial: str
    numbers: Mapping[str, Estimate]
    nrmse: float
    outcome: str

    def row(self) -> dict[str, Any]:
        """The trial's row of trials.csv."""
        missed = {"nrmse": self.nrmse} if math.isfinite(self.nrmse) else {}
        return {"file": self.trial, "method": "sindy", **numbers_row(self.numbers), **missed, "outcome": self.outcome}


def regressed(trial: DrivenTrial, given: DrivenFit) -> Regressed:
    """A trial by regression, with the laws of the ``given`` equation."""
    numbers: Mapping[str, Estimate] = {}
    try:
        numbers = by_regression(trial, given)
        values = [numbers[n].value if n in numbers else v for n, v in zip(given.names, given.values, strict=True)]
        run = free_run(trial, replace(given, values=np.array(values)), START_SAMPLES)
    except IdentificationError as reason:
        return Regressed(trial.name, numbers, math.nan, str(reason))
    measured = trial.outputs[trial.main]
    return Regressed(trial.name, numbers, float(np.sqrt(np.mean((run - measured) ** 2)) / np.std(measured)), OK)


def number_text(number: Estimate, coordinate: Coordinate) -> str:
    """A number with its error and the unit that it has in this coordinate.

    >>> number_text(Estimate(2.0, 0.1, unit="N s/m"), "rotation")
    '2.00 ± 0.10 N m s/rad'
    """
    return estimate_text(number.in_rotation() if coordinate == "rotation" else number)


def beside_output_error(
    found: Sequence[Regressed], given: DrivenFit, coordinate: Coordinate
) -> list[tuple[str, ...]]:
    """Rows of the page, the first the header; empty where no regression was made."""
    known = given.estimates
    rows: list[tuple[str, ...]] = []
    for one in found:
        rows += [
            (one.trial, parameter_words(name), number_text(known[name], coordinate), number_text(value, coordinate))
            for name, value in one.numbers.items()
        ]
        if one.outcome != OK:
            rows.append((one.trial, "", "", one.outcome))
    return [("trial", "number", "output error", "SINDy"), *rows] if rows else []


UNKNOWN = (
    "nobody knows by how much trials of this body differ: specimen.scatter says nothing of its laws, and no two trials "
    "had the same input"
)


@dataclass(frozen=True)
class Floors:
    """By trial: nrmse, the sensor's floor, repeatability (only where it is known); ``because`` says where from, or why
    it is not known."""

    nrmse: Mapping[str, float]
    sensor: Mapping[str, float]
    repeatability: Mapping[str, float]
    because: str

    def scores(self, trial: str) -> dict[str, Any]:
        """Both floors of a trial for trials.csv; what is not known is left out."""
        known = {"repeatability_nrmse": self.repeatability[trial]} if trial in self.repeatability else {}
        return {"sensor_floor_nrmse": self.sensor[trial], **known}

    def rows(self) -> list[dict[str, Any]]:
        """Rows of mismatch.csv; ``missing`` is empty where repeatability is not known."""
        return [
            {"file": name, "nrmse": nrmse, "sensor_floor_nrmse": self.sensor[name],
             "repeatability_nrmse": self.repeatability.get(name, ""),
             "missing": nrmse > self.repeatability[name] if name in self.repeatability else ""}
            for name, nrmse in self.nrmse.items()
        ]  # fmt: skip

    def table(self) -> list[tuple[str, ...]]:
        """Rows of the page, the first the header."""
        rows = [
            (name, percent(nrmse), reason_words(percent(self.sensor[name])),
             percent(self.repeatability[name]) if name in self.repeatability else "not known")
            for name, nrmse in self.nrmse.items()
        ]  # fmt: skip
        return [("trial", "missed of the motion", "by the sensor's noise alone", "between trials"), *rows]


def sensor_noise(trial: DrivenTrial, fitted: DrivenFit) -> float:
    """White noise of the main output, 1 sigma: of the record, or of what the free run leaves of it where that is less.

    A motion with few samples a cycle looks like noise in the record; what is left of it does not.
    """
    left = trial.outputs[trial.main] - free_run(trial, fitted, START_SAMPLES)
    return min(trial.noise()[trial.main], white_noise(left))


def floors_of(
    config: RunConfig, trials: Sequence[DrivenTrial], unseen: Sequence[DrivenTrial], fitted: DrivenFit
) -> Floors:
    """Both floors of every trial that was fitted: repeatability by the stated scatter, else by trials of one input,
    held-out ones too."""
    size = {t.name: float(np.std(t.outputs[t.main])) for t in trials}
    nrmse = {t.name: fitted.rms[t.name] / size[t.name] for t in trials}
    sensor = {t.name: sensor_noise(t, fitted) / size[t.name] for t in trials}
    stated = {} if config.specimen.scatter is None else dict(config.specimen.scatter)
    if scattered(fitted, stated):
        drawn = {t.name: repeatability_by_scatter(t, fitted, stated, sensor[t.name], config.seed) for t in trials}
        return Floors(nrmse, sensor, drawn, "specimen.scatter")
    every = repeatability_by_repeats([*trials, *unseen])
    seen = {name: value for name, value in every.items() if name in nrmse}
    return Floors(nrmse, sensor, seen, "trials of the same input" if seen else UNKNOWN)


@dataclass(frozen=True)
class Beside:
    """What stands beside output error: numbers by instruments and by regression, floors, suspects that no search here
    tries."""

    instruments: ByInstruments
    regressed: tuple[Regressed, ...]
    floors: Floors
    untried: tuple[str, ...]

    @property
    def not_tried(self) -> str:
        """Which suspects no search here tries, with a space before it; empty where all are tried."""
        names = ", ".join(self.untried)
        return f" Not tried on this body, because its search knows no such law: {names}." if names else ""

    @property
    def sentences(self) -> str:
        """What is to be said of it, each with a space before it."""
        return self.instruments.sentences + self.not_tried


def strokes_plain(varying: Strokes) -> dict[str, Any]:
    """Both standard deviations in N, the odds, and the deviations of every pair of strokes by trial."""
    return {
        "offset_N": varying.offset_N, "friction_N": varying.friction_N, "ln_odds": varying.evidence,
        "trials": {
            name: {"offset_N": own[:, 0].tolist(), "friction_N": own[:, 1].tolist(), "left_m": varying.left[name]}
            for name, own in varying.deviations.items()
        },
    }  # fmt: skip


def strokes_sentence(varying: Strokes, coordinate: Coordinate) -> str:
    """What is to be said, with a space before it."""
    unit = _unit_of_force(coordinate)
    offset, friction = (f"{short_number(size, 2)} {unit}" for size in (varying.offset_N, varying.friction_N))
    return (
        f" From one pair of strokes to the next the offset differs by {offset} and the friction by {friction} (1 "
        "sigma); the numbers' errors and the bands of predictions hold that."
    )


def _unit_of_force(coordinate: Coordinate) -> str:
    return "N m" if coordinate == "rotation" else "N"


def strokes_table(varying: Strokes, coordinate: Coordinate) -> list[tuple[str, ...]]:
    """Rows of the page, the first the header."""
    rows = [
        (name, str(2 * i + 1), plain_number(offset, 3), plain_number(friction, 3))
        for name, own in varying.deviations.items() for i, (offset, friction) in enumerate(own.tolist())
    ]  # fmt: skip
    unit = _unit_of_force(coordinate)
    return [("trial", "from stroke", f"offset beyond its mean ({unit})", f"friction beyond its mean ({unit})"), *rows]
