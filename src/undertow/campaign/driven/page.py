"""What the page of a driven campaign shows: sentences, how sure they are, free runs, equations and tables.

Belongs here: those parts, from what was found. Does not belong here: the page's shape (report/driven_page.py), the run
(run.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from undertow.campaign.driven.beside import Beside, Floors, beside_output_error, strokes_sentence, strokes_table
from undertow.comparison.driven_folds import DEVIATIONS, Tried
from undertow.comparison.driven_search import DrivenFound
from undertow.conditioning.driven import DrivenTrial
from undertow.discrepancy.words import count, percent
from undertow.errors import IdentificationError
from undertow.methods.driven import DrivenFit, free_run
from undertow.methods.driven_begin import START_SAMPLES
from undertow.methods.driven_shares import shares_of
from undertow.quantities import Estimate, unit_in_rotation
from undertow.recording.recording import Array, Coordinate
from undertow.report.driven_figures import draw_held_back, draw_whole
from undertow.report.driven_page import IN_TIME, PagePart, PageTable, Picture, WrittenEquation, verdict_of
from undertow.report.explorer import CHANNEL_UNITS
from undertow.report.html import FIRST_IN
from undertow.report.numbers import plain_number, printed_unit
from undertow.report.style import new_figure, page_style, svg_text
from undertow.report.trial_figures import SWINGS_SHOWN, Response, Runs, drawn_as
from undertow.report.wording import parameter_words, reason_words

DRAWN_AT_MOST = 12
"""Trials that the page draws."""

WIDTH_IN, HEIGHT_IN = 11.0, 3.8
"""A figure over the whole page, inch."""

_PER_KNOWN = {"samples": "samples that no fit had seen", "trials": "trials that no fit had seen"}


def page_part(
    coordinate: Coordinate,
    trials: tuple[Sequence[DrivenTrial], Sequence[DrivenTrial]],
    found: DrivenFound,
    entry: Mapping[str, Any],
    said: tuple[str, str],
    beside: Beside,
) -> PagePart:
    """The page's part: ``trials`` are those that were fitted and those held out, ``entry`` the group of verdict.json,
    ``said`` the sentence and (empty: none) what to look for in the columns."""
    training, held_out = trials
    verdict, fit = verdict_of(entry), found.best
    adequate = verdict.status not in ("unknown", "not_identifiable")
    unseen = _PER_KNOWN["trials" if held_out else "samples"]
    notes = [reason_words(text.strip()) for text in (beside.not_tried, _strokes(fit, coordinate)) if text]
    doubts = [as_sentence(reason_words(one.sentence)) for one in beside.instruments.compared if one.sentence]
    with page_style():
        first = _first(coordinate, found, beside.floors, not held_out)
        pictures = [_whole(coordinate, trial, found, beside.floors, trial in held_out)
                    for trial in (*training, *held_out)[:DRAWN_AT_MOST]]  # fmt: skip
    return PagePart(
        verdict, said[0], sure_words(training, found, adequate, unseen), written(found.baseline, training[0]),
        None if found.augmented is None else written(found.augmented, training[0]),
        _numbers(found, entry, beside.floors, unseen), first, pictures, _tables(coordinate, training, found, beside),
        unseen=unseen, notes=notes, rotation=coordinate == "rotation",
        doubts=[*doubts, *([said[1].strip()] if said[1] else [])],
    )  # fmt: skip


def as_sentence(text: str) -> str:
    """A clause as the beginning of a sentence."""
    return text[:1].upper() + text[1:]


def _strokes(fit: DrivenFit, coordinate: Coordinate) -> str:
    return strokes_sentence(fit.strokes, coordinate) if fit.strokes else ""


def written(fit: DrivenFit, trial: DrivenTrial) -> WrittenEquation:
    """A fit's equation with its numbers, those that were held without an error."""
    units = fit.laws.units
    known = {place.name for place in fit.laws.places} | {"mass_kg"}
    held = {n: Estimate(v, 0.0, unit=units.get(n, "")) for n, v in fit.laws.fixed.items() if n in known}
    return WrittenEquation(fit.laws.terms, {**held, **fit.estimates}, IN_TIME[trial.mover], trial.mover)


def sure_words(training: Sequence[DrivenTrial], found: DrivenFound, adequate: bool, unseen: str) -> str:
    """How sure an answer is, by what the run computed: no probability, for none was."""
    start = "no probability and no p-value is computed for a driven body. "
    if not found.tried:
        return f"{start}No law was tried, so that nothing is claimed."
    times = max(found.best.rms[t.name] / t.noise()[t.main] for t in training)
    left = f"the free run leaves {plain_number(times, 2)} times the sensor's noise"
    laws = count(len({one.name for one in found.tried}), "law")
    if not found.added:
        end = left if adequate else f"{left}: something is missing"
        return f"{start}{laws} were tried, and none comes surely closer to {unseen}; {end}."
    folds = "" if found.members else (
        f", and surely closer to parts of the record left out in turn ({DEVIATIONS:g} standard errors are asked for)"
    )  # fmt: skip
    more = left if adequate else f"{left}, so that more is missing"
    return f"{start}What was added brings the free run closer to {unseen}{folds}; of {laws} tried; {more}."


def _numbers(
    found: DrivenFound, entry: Mapping[str, Any], floors: Floors, unseen: str
) -> list[tuple[str, str, str]]:
    """The numbers of the first screen."""
    before = entry["baseline"]["held_out_nrmse"]
    loud = "alarm" if found.added or entry["status"] == "unknown" else ""
    what = "error of the equation as prescribed" if found.added else "error of the equation"
    numbers = [(percent(before), f"{what}, on {unseen}", loud)]
    if found.added:
        numbers.append((percent(entry["augmented"]["held_out_nrmse"]), "error of the repaired equation, there", "good"))
    numbers.append((reason_words(percent(max(floors.sensor.values()))), "what the sensor's noise alone would give", ""))
    if floors.repeatability:
        words = f"what repeating the test would give, at most (known from {floors.because})"
        numbers.append((percent(max(floors.repeatability.values())), words, ""))
    return numbers


# ---------------------------------------------------------------- pictures
def drawn_channel(trial: DrivenTrial, coordinate: Coordinate) -> Response:
    """How a trial's main output is drawn."""
    if trial.main == "acceleration":
        words = "angular acceleration" if coordinate == "rotation" else "acceleration"
        return Response(words, CHANNEL_UNITS["acceleration"][coordinate == "rotation"], 1.0)
    return drawn_as(trial.main, coordinate)


def _run(trial: DrivenTrial, fit: DrivenFit) -> Array:
    """A free run from the trial's first samples; far outside every frame where it has no bounds."""
    try:
        return free_run(trial, fit, START_SAMPLES)
    except IdentificationError:
        return np.full(trial.t.size, 1e3 * (float(np.max(np.abs(trial.outputs[trial.main]))) or 1.0))


def _runs(coordinate: Coordinate, trial: DrivenTrial, before: DrivenFit, after: DrivenFit | None, band: float) -> Runs:
    repaired = None if after is None else _run(trial, after)
    measured = trial.outputs[trial.main]
    return Runs(trial.t, measured, _run(trial, before), repaired, drawn_channel(trial, coordinate), band, "time (s)")


def _band(trial: DrivenTrial, floors: Floors) -> float:
    """What repeatability allows of a trial, RMS in SI; nan where nobody knows."""
    return floors.repeatability.get(trial.name, math.nan) * float(np.std(trial.outputs[trial.main]))


def _first(coordinate: Coordinate, found: DrivenFound, floors: Floors, of_record: bool) -> Picture | None:
    """The record that was held back where what was found helps most, with both equations fitted to the others."""
    if found.proof is None:
        return None
    after = found.proof.after if found.added else None
    drawn = [(t, _runs(coordinate, t, found.proof.before, after, _band(t, floors))) for t in found.proof.unseen]

    def gained(runs: Runs) -> float:
        left = [float(np.std(runs.measured - run)) for run in (runs.simulated, runs.repaired) if run is not None]
        return (left[0] - left[-1] if len(left) > 1 else left[0]) / float(np.std(runs.measured))

    trial, runs = max(drawn, key=lambda one: gained(one[1]))
    part = "the part that was held back (its last fifth)" if of_record and not trial.free else "held out of every fit"
    figure = svg_text(draw_held_back(runs, new_figure(*FIRST_IN)))
    green = ", green the repaired one" if found.added else ""
    band = "the grey band is what repeatability allows (as an RMS)" if math.isfinite(runs.allowed) else (
        "how much trials of this body differ is not known, so that no band is drawn"
    )  # fmt: skip
    caption = (
        f"Trial {trial.name}, {part}, its first {SWINGS_SHOWN} swings at most. Measured is black (white on a dark "
        f"page), blue the equation as prescribed{green}, fitted to the rest alone and run free under the measured "
        f"input. Below: measured minus free run; {band}. Adjusted to this part: the start state, from its first "
        f"{START_SAMPLES} samples."
    )
    return Picture(figure, caption)


def _whole(coordinate: Coordinate, trial: DrivenTrial, found: DrivenFound, floors: Floors, held_out: bool) -> Picture:
    """A whole record beside the free runs of both equations with their final numbers."""
    after = found.augmented if found.added else None
    baseline = found.baseline
    runs = _runs(coordinate, trial, baseline, after, _band(trial, floors))
    held = [t for t in found.proof.unseen if t.name == trial.name] if found.proof and not held_out else []
    begin = float(held[0].t[0]) if held else None
    figure = svg_text(draw_whole(runs, begin, new_figure(WIDTH_IN, HEIGHT_IN)))
    shown, factor = runs.shown, runs.shown.factor
    left = [float(np.sqrt(np.mean((runs.measured - run) ** 2))) * factor
            for run in (runs.simulated, runs.repaired) if run is not None]  # fmt: skip
    size = " → ".join(f"{plain_number(one, 3)} {shown.unit}" for one in left)
    grey = "; grey: held back while laws were sought" if begin is not None else ""
    green = ", green the repaired one" if after is not None else ""
    band = "; grey band: what repeatability allows" if math.isfinite(runs.allowed) else ""
    band += "; what differs from stroke to stroke is not in the runs" if found.best.strokes else ""
    how = "held out of every fit" if held_out else "a decay, nothing drives it" if trial.free else "fitted as a whole"
    caption = (
        f"Trial {trial.name} ({how}): black measured, blue the free run of the equation as prescribed{green}, from the "
        f"first {START_SAMPLES} samples over the whole record{grey}. Below: measured minus free run, RMS {size}{band}."
    )
    return Picture(figure, caption)


# ---------------------------------------------------------------- tables
def _tables(
    coordinate: Coordinate, training: Sequence[DrivenTrial], found: DrivenFound, beside: Beside
) -> list[PageTable]:
    """The tables that say something, the first ones open."""
    fit = found.best
    tables = [PageTable("What is missed, and what may be", beside.floors.table(), _floors_note(beside.floors), False)]
    if by_target := beside.instruments.table(coordinate):
        tables.append(PageTable("Numbers by the instrument, beside output error", by_target, folded=False))
    if fit.strokes:
        heading = "Offset and friction by stroke, each pair there and back with its own"
        tables.append(PageTable(heading, strokes_table(fit.strokes, coordinate)))
    if by_sindy := beside_output_error(beside.regressed, found.baseline, coordinate):
        tables.append(PageTable("Numbers of the given equation by regression, beside output error", by_sindy))
    if shares := told_by(training, fit, coordinate):
        tables.append(PageTable("Standard errors by kind of record", shares))
    if found.tried:
        shown = drawn_channel(training[0], coordinate)
        rows = tried_rows(found.tried, shown.factor, shown.unit)
        note = (
            "RMS of measured minus free run, on samples that no fit had seen, without and with the law. Log evidence: "
            "natural logarithm of the odds by the likelihood alone; it decides nothing where residuals hang together. "
            "Numbers in a reason are in SI units."
        )
        tables.append(PageTable("What was tried, on samples nobody fitted", rows, note))
    return tables


def _floors_note(floors: Floors) -> str:
    return (
        "RMS of measured minus free run over that of the motion; what the sensor's noise alone would give; and what "
        f"trials of this body differ by: {'known from ' + floors.because if floors.repeatability else floors.because}."
    )


def tried_rows(tried: Sequence[Tried], factor: float, unit: str) -> list[tuple[str, ...]]:
    """A row a law, the first the header; evidence where it was computed.

    >>> tried_rows([Tried("quadratic_drag", 3.0, 0.004, 0.002)], 1e3, "mm")[1]
    ('quadratic drag', '4.00', '2.00', '3.0', 'added')
    """
    evidence = any(math.isfinite(one.evidence) for one in tried)
    head = ("law", f"without it ({unit})", f"with it ({unit})", *(("log evidence",) if evidence else ()), "outcome")
    rows = [
        (reason_words(one.name), _size(factor * one.before), _size(factor * one.after),
         *((f"{one.evidence:.1f}" if math.isfinite(one.evidence) else "-",) if evidence else ()),
         outcome_words(one))
        for one in tried
    ]  # fmt: skip
    return [head, *rows]


def _size(value: float) -> str:
    return plain_number(value, 3) if math.isfinite(value) else "-"


def outcome_words(one: Tried) -> str:
    """What became of a law; the numbers that stand beside it in the table are not said again.

    >>> outcome_words(Tried("stiffness", 0.0, 2.0, 3.0, "unseen samples come no closer: 3 after 2"))
    'unseen samples come no closer'
    """
    because = one.because.partition(":")[0] if one.because.startswith("unseen ") else one.because
    return reason_words(because) or "added"


def told_by(
    trials: Sequence[DrivenTrial], fitted: DrivenFit, coordinate: Coordinate
) -> list[tuple[str, ...]]:
    """What decays and driven records tell of each number, as a table for the page; empty without decays."""
    units = fitted.laws.units
    if coordinate == "rotation":
        units = {name: unit_in_rotation(unit) for name, unit in units.items()}
    rows = [
        (parameter_words(name), printed_unit(units.get(name, "")),
         *(plain_number(e, 2) if math.isfinite(e) else "open" for e in vars(one).values()))
        for name, one in shares_of(trials, fitted).items()
    ]  # fmt: skip
    return [("number", "unit", "all trials", "driven alone", "decays alone"), *rows] if rows else []
