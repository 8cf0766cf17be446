"""The equation that a finished run found in decays, run free on a recording or from a start that nobody fitted.

Belongs here: equations.json back as equations, which group a recording belongs to, the table of a prediction. Does not
belong here: the free run and its band (prediction.py), driven trials (campaign/driven/predict.py).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.campaign.config import load as load_config
from undertow.campaign.driven.predict import START, Predicted, equations_of, met, predict_recording, predicted_csv
from undertow.campaign.driven.trials import recording_alone
from undertow.campaign.response.predict import PredictedSet, predict_response
from undertow.conditioning.motion import Motion
from undertow.discrepancy.words import group_title
from undertow.equation.equation import Equation
from undertow.equation.registry import find
from undertow.errors import ConfigError
from undertow.front.beside_prediction import among_fitted, mean_period, of_another_group, own_period_s, too_coarse
from undertow.front.prediction import PredictedRun, predict_whole
from undertow.front.reading import load
from undertow.recording.catalogue import Entry
from undertow.recording.conditions import same_condition
from undertow.recording.gather import listing
from undertow.recording.recording import Array, Condition
from undertow.report.which_group import group_meant
from undertow.report.writing import write_text

MOST_SAMPLES = 1_000_000
"""Samples of a decay that nobody recorded, at most: its band takes some hundred free runs of them."""


TABLES = (".csv",)
"""How the name of a predicted table may end."""

BEYOND = 1.1
"""Times the largest amplitude tested from which on a start is said to be beyond it: trials of one size differ too."""


@dataclass(frozen=True)
class StoredEquation:
    """A group's equation from equations.json, the repaired one where there is one; ``entry`` is the group's."""

    entry: Mapping[str, Any]

    @property
    def version(self) -> Mapping[str, Any]:
        """What the file says of the equation that is run."""
        versions: Mapping[str, Any] = self.entry["versions"]
        found: Mapping[str, Any] = versions.get("augmented") or versions["baseline"]
        return found

    @property
    def largest(self) -> float:
        """Largest amplitude tested, SI; 0 where the run was made before it was written."""
        return float(self.entry.get("largest", 0.0))

    @property
    def others(self) -> tuple[float, float, float]:
        """Noise and rest position's error, SI, and the share of the motion that the equation misses."""
        return float(self.entry["noise"]), float(self.entry["rest_std"]), float(self.version["missed_nrmse"])

    @property
    def equation(self) -> Equation:
        """The equation with its numbers."""
        return self._with(np.array([row["value"] for row in self.version["rows"]]), float(self.version["mass_kg"]))

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors of the laws' coefficients by their names; left out are those that have none, and those of a
        law that stands there more than once."""
        often = Counter((row["term"], row["parameter"]) for row in self.version["rows"])
        found = {}
        for row in self.version["rows"]:
            if row["stderr"] is not None and often[row["term"], row["parameter"]] == 1:
                if row["parameter"] == find(row["term"]).coefficient.name:
                    found[row["term"]] = float(row["stderr"])
                elif row["stderr"] > 0.0:  # what was held has none
                    found[f"{row['term']}.{row['parameter']}"] = float(row["stderr"])
        return found

    def _with(self, values: Array, mass_kg: float) -> Equation:
        terms, coefficients = [], []
        laws: dict[tuple[str, int], dict[str, float]] = {}
        for row, value in zip(self.version["rows"], values.tolist(), strict=True):
            laws.setdefault((row["term"], row["number"]), {})[row["parameter"]] = value
        for (name, _), numbers in laws.items():
            leading = find(name).coefficient.name
            terms.append(find(name, **{key: value for key, value in numbers.items() if key != leading}))
            coefficients.append(numbers[leading])
        return Equation(tuple(terms), tuple(coefficients), mass_kg, float(self.version["rest_m"]))

    def theta_draws(self, draws: int, rng: np.random.Generator) -> tuple[Array, Mapping[str, float], str]:
        """Parameter vectors (draws, slots) as the numbers' errors spread them, the scatter from trial to trial, and
        where it comes from."""
        values = np.array([row["value"] for row in self.version["rows"]])
        stderr = np.array([row["stderr"] for row in self.version["rows"]])
        mass, error = float(self.version["mass_kg"]), float(self.version["mass_stderr"])
        away = rng.standard_normal((draws, values.size))
        heavy = np.maximum(mass + error * rng.standard_normal(draws), 0.1 * mass)
        thetas = [self._with(values + stderr * z, m).theta() for z, m in zip(away, heavy, strict=True)]
        return np.array(thetas), self.entry["scatter"], "band: the numbers' errors and the scatter of the run's trials"


@dataclass(frozen=True, eq=False)
class RunPrediction:
    """One free run of a finished run's equation: ``run`` with its band, ``used`` (n,) samples of the start, the
    ``label`` of the group, the ``unit`` of the motion, the ``largest`` amplitude that the group was tested at (0: not
    known), the equation's own period ``period_s`` (nan: not looked for, or it does not swing) and ``notes`` on the
    recording."""

    run: PredictedRun
    used: Array
    label: str
    unit: str
    largest: float = 0.0
    period_s: float = math.nan
    notes: tuple[str, ...] = ()

    @property
    def messages(self) -> tuple[str, ...]:
        """What a reader must know beside the numbers, in sentences."""
        beyond = f"beyond what was tested: {self.beyond}" if self.beyond else ""
        coarse = f"too few samples: {self.too_coarse}" if self.too_coarse else ""
        return tuple(filter(None, (beyond, coarse, *(f"note: {one}" for one in self.notes))))

    @property
    def too_coarse(self) -> str:
        """That its samples lie too far apart to show the motion, in a sentence; empty where they do not."""
        t = self.run.t
        return too_coarse(self.period_s, 1.0 / float(t[1] - t[0])) if t.size > 1 else ""

    @property
    def beyond(self) -> str:
        """That it starts beyond what was tested, in a sentence; empty where it does not."""
        times = abs(self.run.x0) / self.largest if self.largest > 0.0 else 0.0
        if times <= BEYOND:
            return ""
        return (
            f"it starts at {self.run.x0:.4g} {self.unit}, {times:.3g} times the largest amplitude tested "
            f"({self.largest:.4g} {self.unit}): the band does not hold what the equation may lack there"
        )

    @property
    def rms(self) -> float:
        """RMS of measured less predicted after the start; nan without a recording."""
        after = self.used == 0.0
        return float(np.sqrt(np.mean((self.run.measured - self.run.predicted)[after] ** 2))) if self._seen else math.nan

    @property
    def missed(self) -> float:
        """The same over the RMS of the measured motion about its rest position; nan without a recording."""
        if not self._seen:
            return math.nan
        return self.rms / float(np.sqrt(np.mean((self.run.measured - self.run.rest)[self.used == 0.0] ** 2)))

    @property
    def covered(self) -> float:
        """Share of these samples inside the band; nan without a recording."""
        inside = (self.run.measured >= self.run.lower) & (self.run.measured <= self.run.upper) if self._seen else None
        return math.nan if inside is None else float(np.mean(inside[self.used == 0.0]))

    @property
    def _seen(self) -> bool:
        return self.run.measured.size > 0

    def __repr__(self) -> str:
        """How well a recording is met; without one peak, period, decay and band."""
        if self._seen:
            return met(self.rms, self.covered, self.unit, self.missed)
        t, x, unit = self.run.t, self.run.predicted - self.run.rest, self.unit
        period, periods = mean_period(t, x)
        lines = [f"peak {np.max(np.abs(x)):.4g} {unit}"]
        if self.too_coarse:
            lines.append(f"period {self.period_s:.4g} s by the equation: these samples are too few to show it")
        elif periods:
            late = float(np.max(np.abs(x[t >= t[-1] - period])))
            lines.append(f"period {period:.4g} s (mean of {periods}); last swing {late:.4g} {unit}")
        else:
            lines.append(f"no whole period within {t[-1]:.4g} s; at its end {x[-1]:.4g} {unit}")
        half = 0.5 * (self.run.upper - self.run.lower)
        if np.isfinite(half).all():
            lines.append(f"90 % band: +- {np.mean(half):.2g} {unit} on average, {np.max(half):.2g} {unit} at most")
        return "\n".join(lines)

    def csv(self) -> str:
        """time_s, measured, predicted, lower, upper, used: one row a sample; measured is empty without a recording."""
        r = self.run
        return predicted_csv(r.t, r.measured, r.predicted, r.lower, r.upper, self.used)


def predict_run(
    run: str | Path,
    recording: str | Path | None = None,
    *,
    x0: float = math.nan,
    duration_s: float = math.nan,
    rate_hz: float = math.nan,
    group: Mapping[str, Condition] | str | None = None,
    config: str | Path | None = None,
    out: str | Path | None = None,
) -> RunPrediction:
    """The equation that a run found, run free on a recording of a decay, or from ``x0`` (SI, about the rest position)
    for ``duration_s`` at ``rate_hz``.

    A recording's start is the mean of its hold, with no velocity; where nobody held it, its first instant. ``group``
    gives the conditions, or words that one group fits (none: the only group, or that of the conditions which the run's
    index or file names give the recording), ``config`` replaces the run's, ``out`` takes the table. Raises ConfigError
    where the run, the group or the start cannot be had.
    """
    folder = Path(run)
    _spare_recording(recording, out)
    groups = equations_of(folder)["groups"]
    settings = load_config(Path(config) if config else folder / "config.yaml")
    unit = "rad" if settings.equation.coordinate == "rotation" else "m"
    start = {"x0": x0, "duration": duration_s, "rate": rate_hz}
    if recording is None:
        _check_start(start)
        if duration_s * rate_hz > MOST_SAMPLES:
            raise ConfigError(
                f"a decay of {duration_s:g} s at {rate_hz:g} Hz has {duration_s * rate_hz:.3g} samples; at most "
                f"{MOST_SAMPLES} are predicted: ask for a shorter one, or fewer samples a second"
            )
        entry = _group(groups, group, {})
        times = np.arange(math.floor(duration_s * rate_hz) + 1) / rate_hz
        stored = StoredEquation(entry)
        made = predict_whole(stored, times, x0, stored.others)
        period = own_period_s(stored.equation, x0, duration_s)
        done = RunPrediction(made, np.zeros(times.size), entry["label"], unit, stored.largest, period)
    else:
        _no_start_beside(recording, start)
        file = Path(recording)
        if not file.exists():
            raise ConfigError(f"{file} is not there; give the path of a recording")
        alone, _ = recording_alone(settings, file)
        motion = load(alone)[0]
        listed = _listed(settings, file)
        own = {**motion.recording.conditions, **(listed[0].conditions if listed else {})}
        entry = _group(groups, group, own, str(file))
        of_run = listed if config is None else _listed(load_config(folder / "config.yaml"), file)
        notes = of_another_group(entry, own, str(file)), among_fitted(folder, entry, of_run)
        done = replace(_on(motion, entry, unit), notes=tuple(filter(None, notes)))
    if out is not None:
        write_text(Path(out), done.csv())
    return done


def predict_driven_run(
    run: str | Path,
    recording: str | Path | None,
    *,
    group: Mapping[str, Condition] | str | None = None,
    start: int = START,
    config: str | Path | None = None,
    out: str | Path | None = None,
) -> Predicted | PredictedSet:
    """The equation that a run found of a driven body, run free on a recording from its first ``start`` samples, or
    swept through a harmonic set as its config (``config`` replaces it) says. Raises ConfigError as `predict_run`."""
    folder = Path(run)
    _spare_recording(recording, out)
    if recording is None:
        raise ConfigError(f"--recording is {recording} and {run} holds a driven body; give its input's recording")
    file, own, table = Path(recording), Path(config) if config else None, Path(out) if out else None
    groups = equations_of(folder)["groups"]
    meant = _said(groups, group)["group"] if isinstance(group, str) else group
    if groups[0].get("harmonic"):
        made = predict_response(folder, file, meant, own, table)
        if made is not None:
            return made
    return predict_recording(folder, file, start, own, table)


def predict_any(
    run: Path,
    recording: Path | None,
    new: tuple[float, float, float],
    group: str,
    start: int,
    config: Path | None = None,
    out: Path | None = None,
) -> RunPrediction | Predicted | PredictedSet:
    """A prediction as the command line asks for it, of a run of decays or of driven trials: ``new`` is x0 (SI),
    duration (s) and rate (Hz) of a decay never tested, ``group`` conditions or words of one group, ``start`` the
    samples that a driven trial's start comes from. Raises ConfigError as `predict_run`, and where a driven run is given
    no recording."""
    said, (x0, duration, rate) = group or None, new
    if equations_of(run)["groups"][0]["driven"]:
        _no_start_beside(recording, {"x0": x0, "duration": duration, "rate": rate})
        return predict_driven_run(run, recording, group=said, start=start, config=config, out=out)
    return predict_run(run, recording, x0=x0, duration_s=duration, rate_hz=rate, group=said, config=config, out=out)


def _spare_recording(recording: str | Path | None, out: str | Path | None) -> None:
    """ConfigError where the table would take the place of the recording itself, or the name is none of a CSV table."""
    if out is not None and Path(out).suffix.lower() not in TABLES:
        raise ConfigError(
            f"--out is {out} and the table is written as CSV; give a name that ends in .csv, "
            f"as {Path(out).with_suffix('.csv').name}"
        )
    if recording is not None and out is not None and Path(recording).absolute() == Path(out).absolute():
        raise ConfigError(f"the table would replace the recording {recording}; give another file with --out")


def _on(motion: Motion, entry: Mapping[str, Any], unit: str) -> RunPrediction:
    """The free run on a recording, every sample of it: held before the release, free after it."""
    stored = StoredEquation(entry)
    made = predict_whole(stored, motion, math.nan, stored.others)
    return RunPrediction(made, (made.t < 0.0).astype(np.float64), entry["label"], unit, stored.largest)


def _check_start(said: Mapping[str, float]) -> None:
    """ConfigError where a decay without a recording lacks its start, duration or rate."""
    lacking = [f"--{name}" for name, value in said.items() if not math.isfinite(value)]
    if len(lacking) == len(said):
        raise ConfigError("neither a recording nor a start is given; give --recording, or --x0, --duration and --rate")
    if lacking:
        raise ConfigError(
            f"{' and '.join(lacking)} {'is' if len(lacking) == 1 else 'are'} not given, or no number; a decay from a "
            "start never tested needs all of --x0, --duration (s) and --rate (samples a second); in Python x0, "
            "duration_s and rate_hz"
        )
    low = next((name for name in ("duration", "rate") if said[name] <= 0.0), "")
    if low:
        raise ConfigError(f"--{low} is {said[low]:g} {'s' if low == 'duration' else 'Hz'}; give one above zero")


def _no_start_beside(recording: object, said: Mapping[str, float]) -> None:
    """ConfigError where a recording is given, which has a start and instants of its own, and others beside it."""
    given = " ".join(f"--{name} {value:g}" for name, value in said.items() if not math.isnan(value))
    if recording is not None and given:
        raise ConfigError(f"{given} beside the recording {recording}, which has its own; give one of the two")


def _listed(config: RunConfig, file: Path) -> list[Entry]:
    """The trials of a file in a run's own list of trials; none where it is not among them or the list is gone."""
    try:
        kept, left_out = listing(config.catalogue())
    except ConfigError:
        return []
    there = file.resolve()
    return [one for one in (*kept, *left_out) if one.path.name == file.name and one.path.resolve() == there]


def _group(
    groups: list[Mapping[str, Any]], said: Mapping[str, Condition] | str | None,
    conditions: Mapping[str, Condition], whose: str = "",
) -> Mapping[str, Any]:  # fmt: skip
    """The group that is meant: as said, else the only one, else that of the conditions of the recording ``whose``."""

    if isinstance(said, str):
        return _said(groups, said)
    if said is None and len(groups) == 1:
        return groups[0]
    wanted = conditions if said is None else said
    found = [
        entry for entry in groups
        if entry["group"] and all(same_condition(value, wanted.get(key)) for key, value in entry["group"].items())
    ]  # fmt: skip
    if len(found) != 1:
        have = "; ".join(",".join(f"{k}={v}" for k, v in entry["group"].items()) for entry in groups)
        if wanted:
            problem = f"{len(found)} groups of the run have {group_title(dict(wanted))}"
        else:
            none = f"its list of trials gives {whose} no conditions" if whose else "no conditions are given"
            problem = f"the run has {len(groups)} groups and {none}"
        which = f"say --group, one of: {have}" if have else "all its trials are one group, without a name"
        raise ConfigError(f"{problem}; {which}")
    return found[0]


def _said(groups: list[Mapping[str, Any]], words: str) -> Mapping[str, Any]:
    """The only group that these words fit."""
    return groups[group_meant(words, [entry["group"] for entry in groups])]
