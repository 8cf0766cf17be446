"""A driven campaign from config to run folder: equation, what it lacks, proof on samples nobody fitted.

Belongs here: the order of that, and the files' content. Does not belong here: fits and search (methods/, comparison/),
the page's shape (report/driven_page.py).
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.campaign.config.driven_rules import unused
from undertow.campaign.driven.beside import (
    Beside,
    by_instruments,
    floors_of,
    regressed,
    strokes_plain,
    strokes_sentence,
)
from undertow.campaign.driven.files import (
    group_entry,
    manifest_of,
    numbers_of,
    numbers_row,
    rows_csv,
    write_answer,
    write_manifest,
)
from undertow.campaign.driven.page import as_sentence, page_part
from undertow.campaign.driven.trials import driven_laws, driven_trials
from undertow.campaign.run.workers import Progress, silent
from undertow.comparison.driven_search import DrivenFound, discover_driven, suspects_for
from undertow.comparison.response_search import ResponseFound
from undertow.conditioning.driven import DrivenTrial
from undertow.conditioning.scale import driven_out_of_scale
from undertow.discrepancy.findings import FailedTrial
from undertow.discrepancy.words import count
from undertow.equation.driven import compiled_integrator
from undertow.equation.driven_hysteresis import HYSTERESES
from undertow.errors import UndertowError
from undertow.methods.driven import DrivenFit
from undertow.methods.driven_equations import equation_text, written
from undertow.methods.driven_order import TAKES_ENERGY, power_given
from undertow.report.driven_page import Made, page_html, write_page
from undertow.report.numbers import short_number
from undertow.report.writing import write_text

UNCHECKED = "discrepancy.suspects names no law that can be tried on a driven body"
"""Why nothing can be said of what is missing."""

ADEQUATE = 1.5
"""Free-run error over white noise up to which nothing more is said to be missing."""

FAR = 0.5
"""Share of the motion from which on a run that misses it speaks of its columns."""


@dataclass(frozen=True)
class DrivenFinished:
    """What ``undertow run`` says of a driven campaign, in time or of harmonic sets, when it is done."""

    folder: Path
    sentence: str
    found: DrivenFound | tuple[ResponseFound, ...]
    failed: tuple[FailedTrial, ...] = ()
    contradicted: tuple[str, ...] = ()
    page: bool = True

    @property
    def told(self) -> Path:
        """The file that tells most: the page, or verdict.json where none was asked for."""
        return self.folder / ("report.html" if self.page else "verdict.json")

    @property
    def summary(self) -> str:
        """The sentence, and where the report is."""
        return f"{self.sentence}\nreport: {self.told}"


def run_driven(
    config: RunConfig,
    config_path: Path,
    folder: Path,
    text: str,
    overrides: Sequence[str] = (),
    progress: Progress = silent,
    page: bool = True,
) -> DrivenFinished:
    """Fit, search, prove, and write the files into ``folder`` (``text`` is the resolved config), with or without page.

    Raises UndertowError where no trial can be used.
    """
    begun = time.perf_counter()
    compiled_integrator()  # before any worker process would compile it for itself
    progress("read and condition", 0, 1)
    trials, reasons = driven_trials(config)
    failed = tuple(FailedTrial(name, reason) for name, reason in reasons.items())
    if not trials:
        raise UndertowError(f"none of {len(failed)} trials can be used: {'; '.join(list(reasons.values())[:3])}")
    progress("read and condition", 1, 1)
    said = config.trials.hold_out
    held = tuple(Path(name).name.split(".")[0] for name in said) if isinstance(said, tuple) else ()
    training, unseen = [t for t in trials if t.name not in held], [t for t in trials if t.name in held]
    suspects = config.discrepancy.named
    progress("identification", 0, 1)
    laws = driven_laws(config)
    if keys := unused(config, tuple(laws.fixed)):
        logging.getLogger("undertow").warning("a driven campaign does not use %s", ", ".join(keys))
    found = discover_driven(training, laws, suspects, unseen)
    by_sindy = tuple(regressed(t, found.baseline) for t in training) if "sindy" in config.methods else ()
    progress("identification", 1, 1)
    told = by_instruments(training, found.best)
    floors = floors_of(config, training, unseen, found.best)
    beside = Beside(told, by_sindy, floors, not_tried(training[0], found, suspects or ()))
    sized = "".join(f" {as_sentence(one)}." for one in driven_out_of_scale(training, config.equation.coordinate))
    sentence = sentence_of(config.name, training, found) + beside.sentences + sized
    sentence += strokes_sentence(found.best.strokes, config.equation.coordinate) if found.best.strokes else ""
    group = _write(folder, config, text, training, unseen, found, sentence, beside)
    made = manifest_of(config, config_path, overrides, failed, begun)
    if page:
        coordinate = config.equation.coordinate
        said = as_sentence(found_words(training, found)), far_away(training, found.validation[1] / _size(training))
        said = (said[0], said[1] + sized)
        part = page_part(coordinate, (training, unseen), found, group, said, beside)
        kind = f"{count(len(training) + len(unseen), 'trial')} of a driven body"
        write_page(folder, page_html(config.name, kind, [part], Made(made, text, failed)), [part])
    write_manifest(folder, made)
    return DrivenFinished(folder, sentence, found, failed, page=page)


def not_tried(trial: DrivenTrial, found: DrivenFound, suspects: Sequence[str]) -> tuple[str, ...]:
    """Names among the ``suspects`` that no search on this body tries: laws of another kind of body, or of decays."""
    may = {name for name, _ in suspects_for(trial, found.baseline)} | {law.name for law in HYSTERESES}
    given = {law.name for law in found.baseline.laws.terms}
    return tuple(name for name in suspects if name not in {*may, *given, *found.added})


def sentence_of(name: str, training: Sequence[DrivenTrial], found: DrivenFound) -> str:
    """What was found, in words, and what to look for in the columns."""
    return f"{name}: {found_words(training, found)}{far_away(training, found.validation[1] / _size(training))}"


def found_words(training: Sequence[DrivenTrial], found: DrivenFound) -> str:
    """What was found, in words."""
    size, unit = _size(training), "of the motion"
    before, after = (100.0 * rms / size for rms in found.validation)
    if not found.added:
        said = ", and no law that was tried helps" if found.tried else f"; nothing was checked: {UNCHECKED}"
        return f"the given equation misses {short_number(before)} % {unit} it never saw{said}."
    names = ", ".join(found.added).replace("_", " ")
    left = "" if _adequate(training, found.best) else "; more than noise is left"
    kept = found.augmented.laws.memory.split(".")[0] if found.augmented else ""
    alike = f" The record cannot tell {kept} from {' or '.join(found.rivals)}." if kept and found.rivals else ""
    missed = f"misses {short_number(before)} % {unit} it never saw; with {names} {short_number(after)} %"
    return f"the given equation {missed}{left}.{alike}"


def far_away(training: Sequence[DrivenTrial], missed: float) -> str:
    """What to look for where a free run misses so much of the motion that the columns may be wrong; else empty."""
    if not missed > FAR:
        return ""
    trial = next(t for t in training if not t.free)
    takes = trial.mover == "force" and "displacement" in trial.outputs and power_given(trial) < -TAKES_ENERGY
    energy = f" On average {trial.quantity} takes energy from the body instead of giving it." if takes else ""
    return (
        f"{energy} More than half of the motion is missed: look whether the columns of input and output are exchanged, "
        "and at the input's sign, unit, gain and delay."
    )


def _size(trials: Sequence[DrivenTrial]) -> float:
    return max(float(np.std(trial.outputs[trial.main])) for trial in trials)


def _adequate(trials: Sequence[DrivenTrial], fitted: DrivenFit) -> bool:
    return all(fitted.rms[t.name] <= ADEQUATE * t.noise()[t.main] for t in trials)


def _write(
    folder: Path,
    config: RunConfig,
    text: str,
    training: Sequence[DrivenTrial],
    unseen: Sequence[DrivenTrial],
    found: DrivenFound,
    sentence: str,
    beside: Beside,
) -> Mapping[str, Any]:
    """All files but the manifest and the page; the group of verdict.json."""
    size = _size(training)
    missed = max(found.validation[0], *found.baseline.rms.values())
    versions = {"baseline": written(found.baseline, missed, size, training[0])}
    if found.augmented is not None:
        versions["augmented"] = written(
            found.augmented, max(found.validation[1], *found.augmented.rms.values()), size, training[0]
        )
    best = versions.get("augmented", versions["baseline"])
    equation = equation_text(best)
    noise = {t.name: t.noise() for t in training}
    entry = {"group": {}, "trials": [t.name for t in training], "driven": True, "versions": versions, "noise": noise}
    group = _verdict(training, unseen, found, sentence, beside)
    across = {"verdict": group["verdict"], "sentence": sentence}
    write_answer(folder, text, config, [{**entry, "scatter": {}, "equation": equation}], [group], across)
    _tables(folder, training, found, beside)
    return group


def _verdict(
    training: Sequence[DrivenTrial],
    unseen: Sequence[DrivenTrial],
    found: DrivenFound,
    sentence: str,
    beside: Beside,
) -> Mapping[str, Any]:
    """The group of verdict.json as the contract has it; what was not computed for a driven campaign is null."""
    fit, size = found.best, _size(training)
    good = _adequate(training, fit)
    named = (*found.added, *(() if good else ("unknown",)))
    status = ("explained" if found.added else "nothing_missing") if good else "unknown"
    because = "" if good else "more than noise is left"
    if not found.tried:
        status, because, named = "cannot_tell", UNCHECKED, ()
    return group_entry(
        {}, [t.name for t in training], [t.name for t in unseen], status, named, found.tried, sentence,
        statistic="rms on unseen samples", because=because,
        parameters={name: numbers_of(fit.estimates, name) for name in found.added},
        baseline=_version(found.baseline, found.validation[0], size),
        augmented=None if found.augmented is None else _version(found.augmented, found.validation[1], size),
        sensor_floor_nrmse=max(beside.floors.sensor.values()), by_instrument=beside.instruments.plain(),
        by_stroke=strokes_plain(fit.strokes) if fit.strokes else None, not_testable=list(beside.untried),
        repeatability_nrmse=max(beside.floors.repeatability.values(), default=None),
        repeatability_because=beside.floors.because,
    )  # fmt: skip


def _version(fit: DrivenFit, validation: float, size: float) -> Mapping[str, Any]:
    return {
        "nrmse": math.sqrt(sum(r * r for r in fit.rms.values()) / len(fit.rms)) / size,
        "held_out_nrmse": validation / size,
        "parameters": fit.estimates,
    }


def _tables(folder: Path, training: Sequence[DrivenTrial], found: DrivenFound, beside: Beside) -> None:
    """trials.csv, levels.csv and mismatch.csv, a row a trial and version."""
    versions = {"baseline": found.baseline} | ({"augmented": found.augmented} if found.augmented else {})
    rows: list[dict[str, Any]] = []
    for version, fit in versions.items():
        numbers = numbers_row(fit.estimates)
        rows += [
            {"file": t.name, "method": f"output_error_{version}", **numbers,
             "nrmse": fit.rms[t.name] / float(np.std(t.outputs[t.main])), **beside.floors.scores(t.name),
             "outcome": fit.outcome}
            for t in training
        ]  # fmt: skip
    rows += [one.row() | beside.floors.scores(one.trial) for one in beside.regressed]
    for name in ("trials.csv", "levels.csv"):
        write_text(folder / name, rows_csv(rows))
    write_text(folder / "mismatch.csv", rows_csv(beside.floors.rows()))
