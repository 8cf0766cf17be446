"""What stands under the figures of a group's section, and its rows on the recordings' quality.

Belongs here: those texts. Does not belong here: the figures (group_figures.py), all other rows (blocks.py).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from undertow.conditioning.period import dominant_period
from undertow.discrepancy.energy import EnergyBudget
from undertow.discrepancy.findings import Findings, GroupFindings, TrialFindings
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import own_words
from undertow.errors import UndertowError
from undertow.quantities import Estimate, format_estimate
from undertow.recording.recording import Coordinate
from undertow.report.behind import is_repaired
from undertow.report.explorer import CHANNEL_UNITS
from undertow.report.expressions import is_per_mass
from undertow.report.fit_figures import TIGHT, friction_panels, hold_of, odds_beside
from undertow.report.group_figures import budget_of, one_trial
from undertow.report.mismatch_figures import CYCLES_AT_MOST
from undertow.report.numbers import plain_number, short_number
from undertow.report.style import DRAWN
from undertow.report.trial_figures import with_words
from undertow.report.wording import in_plain_words, p_words

NOTES_AT_MOST = 3
"""Notes of one recording in the table of data quality; all stand in manifest.json."""


def captions(findings: Findings, group: GroupFindings) -> Mapping[str, Any]:
    """Texts under the figures that not every group has: energy, where, suspects, noise, pairs, null, friction; what
    is in a free run that has ``more`` than the equation; and rows on the recordings' ``quality``."""
    trial = one_trial(findings, group)
    named = "" if trial is None else _named(trial)
    believed = "repaired" if is_repaired(group.verdict) else "prescribed"
    closest = trial is not None and trial.augmented is not None and not is_repaired(group.verdict)
    left = f"the equation {with_words(group.verdict)}" if closest else f"the {believed} equation"
    return {
        "more": with_words(group.verdict),
        "energy": "" if trial is None else _energy(group, trial),
        "where": f"Where the prescribed equation misses trial {named}. Top left: the residual (measured less free run) "
        "by time and frequency; a spot that lies on no black line is a motion that the body alone does not have. "
        "Top right: the force that the equation leaves over, mean of all trials at each displacement and "
        "speed, orange positive, blue negative: a pattern means a missing force of displacement or speed; what differs "
        "from swing to swing at the same place averages out and stays pale. Below: frequency and damping of every full "
        "cycle with one standard error, without those that noise makes: black points off the blue line are what the "
        f"equation misses{f', the green line is {left}' if closest or is_repaired(group.verdict) else ''}; what lies "
        "far off is not in the frame.",
        "suspects": f"Green diamond: {odds_beside(group.verdict)}. Bars: odds of every other suspect beside it, "
        "logarithm to base 10, the cost of its numbers included. Orange: more evidence than the diamond, but excluded "
        "for the reason below.",
        "noise": f"What {left} leaves of trial {named}: its autocorrelation (grey: 95 % of white "
        "noise), and its quantiles beside those of the sensor's noise. Correlated residuals count as fewer samples.",
        "pairs": "How far the repaired equation's numbers can be told from each other: a round ellipse is two numbers "
        "that are known independently, a thin one two of which the data know a combination better than each alone "
        f"(correlation beyond {TIGHT:g}: orange). Each cell is to the scale of the two standard errors at its sides.",
        "null": _null(group.verdict),
        "friction": _friction(group),
        "quality": quality_rows(group),
    }  # fmt: skip


def scattering_words(findings: Findings) -> str:
    """Which numbers of the structure vary from trial to trial where a repetition is simulated: those that an equation
    of the campaign has."""
    has = {term.structural for group in findings.groups for term in group.equation.terms}
    weighed = all(group.specimen.normal_force_N > 0.0 and not group.specimen.rotation for group in findings.groups)
    words = {"k": "k", "c": "c", "mu": "\N{GREEK SMALL LETTER MU}" if weighed else "friction"}
    return own_words([said for symbol, said in words.items() if symbol in has])


def _named(trial: TrialFindings) -> str:
    return f"{trial.motion.name}{' (held out)' if trial.held_out else ''}"


def _energy(group: GroupFindings, trial: TrialFindings) -> str:
    budget = budget_of(group, trial)
    if budget is None:
        return ""
    over = "/(kg m²)" if group.specimen.rotation else "/kg"
    unit = f"J{over}" if is_per_mass(group.equation, group.equation_errors) else "J"
    believed = "repaired" if is_repaired(group.verdict) else "prescribed"
    more = budget.time.size - CYCLES_AT_MOST
    left = f"; of {budget.time.size} cycles the first {CYCLES_AT_MOST} are drawn" if more > 0 else ""
    memory = (
        " A bar below zero gives energy back: what oscillates takes it in one cycle and returns it in another."
        if any((values < 0.0).any() for values in budget.taken.values()) else ""
    )  # fmt: skip
    return (
        f"Trial {_named(trial)}: {_first_cycle(budget, unit)}. What every law of the {believed} equation takes of it "
        f"along the measured motion; diamonds: what is lost, with one standard error{left}.{memory}"
    )


def _first_cycle(budget: EnergyBudget, unit: str) -> str:
    """What the first cycle holds and loses, with as many digits as the error allows."""
    error = float(budget.error[0])
    lost = Estimate(float(budget.lost[0]), error if error > 0.0 else math.nan, unit=unit)
    words = format_estimate(lost) if error > 0.0 else f"{short_number(lost.value)} {unit}"
    return f"the first cycle begins with {short_number(float(budget.stored[0]))} {unit} and loses {words}"


def _null(verdict: Verdict) -> str:
    if verdict.null is None or not math.isfinite(verdict.p_value):
        return ""
    beyond = verdict.null.own > verdict.null.limit
    said = "it is not one of them, something is missing" if beyond else "it could be one of them"
    return (
        f"{sum(verdict.null.counts)} simulated replicas of this level in which nothing is missing, with its own "
        "releases, scatter and noise: of each the largest score among all suspects. The level itself has "
        f"{p_words(verdict.p_value)}: {said}. Springs judged together share this test."
    )


def _friction(group: GroupFindings) -> str:
    words = {
        "hold": "friction against the hold before the release",
        "rest": "where the body came to rest: a point outside the grey band (friction force over stiffness, "
        "each way) was not held there by this friction (a rest position that is poorly known does not widen the frame)",
        "damping": "friction against viscous damping of the same trial",
        "drag": "friction against drag of the same trial",
    }
    said = "; ".join(words[panel] for panel in friction_panels(group))
    slope = " Trials on a slope: the two numbers take each other's place." if "same trial" in said else ""
    return f"One point a trial. {said[:1].upper()}{said[1:]}.{slope}" if said else ""


def quality_rows(group: GroupFindings) -> list[Mapping[str, Any]]:
    """A row a trial on its recording: ``name``, ``rate``, ``hold``, ``motion``, ``swings``, ``noise``, ``notes``."""
    return [_quality(trial) for trial in group.trials]


def _quality(trial: TrialFindings) -> Mapping[str, Any]:
    motion, window = trial.motion, trial.motion.window
    span = window.end_s - window.start_s
    try:
        swings = f"{span / dominant_period(motion):.1f}"
    except UndertowError:
        swings = "-"
    hold, notes = hold_of(trial), (*motion.recording.notes, *motion.notes)
    more = f"; {len(notes) - NOTES_AT_MOST} more" if len(notes) > NOTES_AT_MOST else ""
    noise = ", ".join(_noise(name, value, motion.recording.coordinate) for name, value in motion.noise.items())
    return {
        "name": motion.name,
        "rate": short_number(motion.recording.rate_hz, 4),
        "hold": f"{hold:.2f}" if math.isfinite(hold) else "none seen",
        "motion": short_number(span),
        "swings": swings,
        "noise": noise or "-",
        "notes": ("; ".join(_note(note) for note in notes[:NOTES_AT_MOST]) + more) or "-",
    }



def _note(note: str) -> str:
    """A note of a recording with channels and parameters in words; files and columns keep their names."""
    for channel in CHANNEL_UNITS:
        note = re.sub(rf"\b{channel}\b", channel.replace("_", " "), note)
    return in_plain_words(note.rstrip("."))


def _noise(channel: str, value: float, coordinate: Coordinate) -> str:
    """One channel's noise with its unit."""
    factor, unit = DRAWN[coordinate] if channel == "displacement" else (1.0, "SI units")
    if channel in CHANNEL_UNITS:
        unit = CHANNEL_UNITS[channel][coordinate == "rotation"]
    return f"{channel.replace('_', ' ')} {plain_number(factor * value, 2)} {unit}"
