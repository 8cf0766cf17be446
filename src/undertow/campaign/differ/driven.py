"""A simulation of a driven body against its recording: laws that one of them lacks, numbers that differ, and how far
the simulation's equation, run free under the recording's input, is from what was recorded.

Both have inputs of their own. The config's equation is given to each, and each is searched for what it lacks as a
run does (comparison/driven_search.py); with the laws of both, both are fitted again and compared number by number.

Belongs here: that comparison, its sentence, its files. Does not belong here: decays (compare.py), the search, fits.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.campaign.driven.page import HEIGHT_IN, WIDTH_IN, drawn_channel, written
from undertow.campaign.driven.trials import driven_laws, must_drive, recording_alone, trial_of
from undertow.comparison.driven_search import discover_driven
from undertow.conditioning.driven import DrivenTrial
from undertow.discrepancy.difference import FAR, TermRow
from undertow.discrepancy.words import percent
from undertow.equation.driven_laws import find_driven
from undertow.errors import ConfigError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import DrivenFit, fit_driven, free_run
from undertow.methods.driven_begin import START_SAMPLES
from undertow.quantities import Estimate
from undertow.recording.catalogue import read_trial
from undertow.recording.recording import Array, Coordinate
from undertow.report.difference import listed_in_words
from undertow.report.driven_figures import draw_held_back, draw_whole
from undertow.report.driven_page import Made, PagePart, PageTable, Picture, page_html
from undertow.report.html import FIRST_IN
from undertow.report.numbers import plain_number
from undertow.report.style import new_figure, page_style, svg_text
from undertow.report.trial_figures import Runs
from undertow.report.verdict_file import plain
from undertow.report.wording import estimate_text, parameter_words
from undertow.report.writing import write_text

VERSION = 1
"""Version of differ.json's shape for driven bodies."""


@dataclass(frozen=True)
class DrivenDifference:
    """``lacks``: laws that the recording asks for and the simulation does not; ``extra``: the other way; ``rows``: the
    numbers of both with the laws of both; ``run`` (n,): the simulation's own equation under the recording's input, that
    misses ``missed`` of the motion (rms over rms) beyond its start, where the recording's own misses ``own``;
    ``coordinate``: of a rotation, numbers are moments and inertias."""

    simulation: DrivenFit
    recording: DrivenFit
    lacks: tuple[str, ...]
    extra: tuple[str, ...]
    rows: tuple[TermRow, ...]
    trial: DrivenTrial
    run: Array
    missed: float
    own: float
    coordinate: Coordinate = "translation"

    @property
    def far(self) -> tuple[str, ...]:
        """Names of the numbers that are more than `FAR` standard errors apart."""
        return tuple(row.name for row in self.rows if row.sigmas > FAR)

    @property
    def sentence(self) -> str:
        """What the simulation lacks, which numbers differ, how far its free run is away."""
        words = [f"lacks {listed_in_words(self.lacks)}" if self.lacks else "lacks no law that this recording shows"]
        if self.extra:
            words.append(f"has {listed_in_words(self.extra)}, which the recording does not show")
        said = [
            f"{parameter_words(row.name)} ({estimate_text(row.simulation)} there, {estimate_text(row.recording)} in "
            f"the recording, {plain_number(row.sigmas, 2)} standard errors apart)"
            for row in self.rows if row.simulation and row.recording and row.sigmas > FAR
        ]  # fmt: skip
        if said:
            words.append(f"differs in {', '.join(said)}")
        return (
            f"The simulation {', and '.join(words)}: under the recording's input its equation misses "
            f"{percent(self.missed)} of the motion, the recording's own {percent(self.own)}."
        )


def compare_driven(
    simulation: DrivenTrial,
    recording: DrivenTrial,
    laws: DrivenLaws,
    suspects: Sequence[str] | None = None,
    seed: int = 0,
    coordinate: Coordinate = "translation",
) -> DrivenDifference:
    """A driven simulation against a recording of the same body, whatever input either had.

    The simulation is given the recording's noise: what no recording could show is not looked for. Raises ConfigError
    where the two do not have the same input quantity and outputs, IdentificationError where a fit has no bounds.
    """
    both = simulation, recording
    if (simulation.quantity, *simulation.outputs) != (recording.quantity, *recording.outputs):
        have = [f"{one.quantity} and {', '.join(one.outputs)}" for one in both]
        raise ConfigError(f"the simulation has {have[0]}, the recording {have[1]}; give both the same columns")
    simulation = _as_noisy(simulation, recording.noise(), seed)
    found = [discover_driven([one], laws, suspects) for one in (simulation, recording)]
    mine, theirs = ([t.name for t in one.best.laws.terms] for one in found)
    lacks, extra = (tuple(n for n in one if n not in other) for one, other in ((theirs, mine), (mine, theirs)))
    first, second = (
        _with(one.best, trial, missing)
        for one, trial, missing in zip(found, (simulation, recording), (lacks, extra), strict=True)
    )
    run, rest = (free_run(recording, one.best, START_SAMPLES) for one in found)
    missed, left = (_missed(recording, one) for one in (run, rest))
    rows = _rows(*(_turned(one.estimates, coordinate) for one in (first, second)))
    return DrivenDifference(first, second, lacks, extra, rows, recording, run, missed, left, coordinate)


def _as_noisy(trial: DrivenTrial, noise: Mapping[str, float], seed: int) -> DrivenTrial:
    """The trial with white noise that brings its outputs to the standard deviations ``noise``."""
    rng, own = np.random.default_rng(seed), trial.noise()
    more = {name: math.sqrt(max(noise[name] ** 2 - own[name] ** 2, 0.0)) for name in trial.outputs}
    return replace(
        trial, outputs={name: x + more[name] * rng.standard_normal(x.size) for name, x in trial.outputs.items()}
    )


def _with(fitted: DrivenFit, trial: DrivenTrial, missing: Sequence[str]) -> DrivenFit:
    """The fit with the laws that the other file asks for beside its own, where these are laws of x and v; a law with
    a state of its own has no start there, and is left to one of the two."""
    terms = [term for term in map(find_driven, missing) if term.kind == "force"]
    if not terms:
        return fitted
    laws = fitted.started
    starts = {f"{term.name}.{term.coefficient.name}": max(0.0, term.coefficient.lower) for term in terms}
    return fit_driven([trial], replace(laws, terms=(*laws.terms, *terms), starts={**starts, **laws.starts}), windows=0)


def _turned(numbers: Mapping[str, Estimate], coordinate: Coordinate) -> Mapping[str, Estimate]:
    """Numbers with the units that they have in this coordinate."""
    return numbers if coordinate == "translation" else {name: one.in_rotation() for name, one in numbers.items()}


def _rows(mine: Mapping[str, Estimate], theirs: Mapping[str, Estimate]) -> tuple[TermRow, ...]:
    """Numbers of both fits, name by name."""
    rows = []
    for name in dict.fromkeys([*mine, *theirs]):
        one, other = mine.get(name), theirs.get(name)
        sigmas = math.nan
        if one is not None and other is not None:
            sigmas = abs(other.value - one.value) / math.hypot(one.stderr, other.stderr)
        rows.append(TermRow(name, one, other, sigmas))
    return tuple(rows)


def _missed(trial: DrivenTrial, run: Array) -> float:
    """RMS of what a free run misses beyond its start, over the motion's."""
    x = trial.outputs[trial.main][START_SAMPLES:]
    return float(np.sqrt(np.mean((run[START_SAMPLES:] - x) ** 2)) / np.std(x))


def differ_driven(simulation: Path, recording: Path, config: RunConfig) -> DrivenDifference:
    """Both files read by the config's mapping, its equation given to both; as `compare_driven`."""
    trials = []
    for what, path in (("simulation", simulation), ("recording", recording)):
        here, entry = recording_alone(config, path)
        trial = trial_of(here, entry, read_trial(entry, here.catalogue()))
        must_drive(trial.name, trial.quantity, trial.u)
        trials.append(replace(trial, name=what))
    suspects, coordinate = config.discrepancy.named, config.equation.coordinate
    return compare_driven(trials[0], trials[1], driven_laws(config), suspects, config.seed, coordinate)


def write_driven(found: DrivenDifference, folder: Path) -> None:
    """differ.json and differ.html."""
    said = plain({
        "version": VERSION, "driven": True, "sentence": found.sentence, "lacks": found.lacks,
        "extra": found.extra, "differs_in_number": found.far, "nrmse": found.missed,
        "nrmse_of_its_own_equation": found.own, "terms": [vars(row) for row in found.rows],
    })  # fmt: skip
    write_text(folder / "differ.json", json.dumps(said, indent=1, allow_nan=False, ensure_ascii=False))
    write_text(folder / "differ.html", page_html("Simulation against recording", "two records of a driven body",
               [_page_part(found)], Made()))  # fmt: skip


def _page_part(found: DrivenDifference) -> PagePart:
    """What the page shows: both equations, the simulation's under the recording's input, numbers beside each other."""
    table = [("number", "simulation", "recording", "standard errors apart")]
    for row in found.rows:
        shown = (estimate_text(one) if one is not None else "-" for one in (row.simulation, row.recording))
        sigmas = plain_number(row.sigmas, 2) if math.isfinite(row.sigmas) else ""
        table.append((parameter_words(row.name), *shown, sigmas))  # type: ignore[arg-type]
    trial = found.trial
    names = "simulation's equation", ""
    runs = Runs(trial.t, trial.outputs[trial.main], found.run, None, drawn_channel(trial, found.coordinate),
                clock="time (s)", called=names)  # fmt: skip
    with page_style():
        first = svg_text(draw_held_back(runs, new_figure(*FIRST_IN)))
        whole = svg_text(draw_whole(runs, None, new_figure(WIDTH_IN, HEIGHT_IN)))
    caption = (
        "Measured is black (white on a dark page), blue the simulation's own equation, run free under the recording's "
        f"input from a start state adjusted to its first {START_SAMPLES} samples. Below: measured minus free run."
    )
    loud = "alarm" if found.lacks or found.extra or found.far else ""
    numbers = [
        (percent(found.missed), "of the recording's motion missed by the simulation's equation", loud),
        (percent(found.own), "missed by the recording's own equation", "good"),
    ]
    return PagePart(
        None, found.sentence, "", written(found.simulation, trial), written(found.recording, trial), numbers,
        Picture(first, caption), [Picture(whole, "The same over the whole recording.")],
        [PageTable("Numbers, with the laws of both", table, folded=False)], called=("simulation", "recording"),
        rotation=found.coordinate == "rotation",
    )  # fmt: skip
