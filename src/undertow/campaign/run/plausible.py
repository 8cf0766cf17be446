"""Whether the numbers that were identified can be a body's: friction, drag, damping, added mass, stiffness.

A mistake in a unit that no second channel shows (a displacement alone, in metres and labelled mm) leaves the motion's
shape as it is and makes a friction of a millionth or a drag coefficient of hundreds of it.

Belongs here: doubts about a group. Does not belong here: the ranges (ranges.py), what the channels say (checking.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from undertow.campaign.run.judgement import contradicted_verdict
from undertow.campaign.run.one_body import not_one_body
from undertow.campaign.run.ranges import ERRORS, STIFFNESS_OFF, damped, out_of_range, stiffness_off
from undertow.campaign.run.strange_trial import BETWEEN_TRIALS, in_one_trial, strange_trial
from undertow.campaign.run.tasks import slope_of_cells
from undertow.campaign.run.trial_scale import scaled_trial
from undertow.comparison.suspects import SUSPECTS
from undertow.conditioning.scale import out_of_scale
from undertow.discrepancy.drifts import no_scatter, nothing_said
from undertow.discrepancy.earned import NEXT
from undertow.discrepancy.findings import GroupFindings
from undertow.discrepancy.verdict import Gate
from undertow.discrepancy.words import percent
from undertow.equation.structure import CoulombFriction
from undertow.quantities import Estimate, format_number
from undertow.report.arrange import group_numbers
from undertow.uncertainty.repeats import mean_of_trials

CELLS_ARE_WRONG = 0.3
"""Relative difference between the load cells' stiffness and the identified one that no calibration explains: trials of
another spring, a column that is missing."""

AGREE = 0.02
"""Load cells and a stated stiffness that differ by no more agree."""

NOTED = 0.03
"""Relative difference between load cells and motion, and between what moves and the stated mass, that a note says."""

STRANGE = frozenset({"conditions", "clock", "gaps", "spikes", "period"})
"""Kinds of doubt that, accepted for a trial, say that it may be unlike the others."""

LACKING = ("unknown", "not_identifiable")
"""Statuses that say that the equation lacks something without repairing it."""

LIGHTER = 0.02
"""Share of the stated mass by which an added mass below zero is doubted."""


def with_doubts(
    groups: Sequence[GroupFindings],
    accepted: Mapping[str, Sequence[str]] = MappingProxyType({}),
    order: Sequence[str] = (),
) -> tuple[list[GroupFindings], tuple[str, ...]]:
    """The groups with their doubts among their notes, and all doubts with the groups' labels.

    ``accepted`` is trial -> kinds of doubt that are known; a kind that all of a group's trials have is a note alone;
    ``order`` the trials as the index has them.
    """
    out, said, lone, ordered = [], [], in_one_trial(groups, _strange(accepted)), no_scatter(groups, order)
    for group, of_one in zip(groups, lone, strict=True):
        known = [set(accepted.get(t.motion.name, ())) for t in group.trials]
        kinds = set.intersection(*known) if known else set()
        doubts = implausible(group, accepted)
        notes = [f"accepted ({kind}): {text}" if kind in kinds else text for kind, text in doubts]
        notes += [] if notes else _noted(group)
        if notes:
            group = replace(group, notes=(*group.notes, *notes))
        numbers = group_numbers(group)
        noted = (_stiffness(group, numbers, NOTED, "noted"), _cells(group, numbers, NOTED, "noted"))
        mild = (*noted, _lighter(group, numbers), _other_level(group, groups)) if not doubts else ()
        said += [f"{group.label}: {text}" for text in mild if text]
        unknown = [text for kind, text in doubts if kind not in kinds]
        wrong = "" if "conditions" in kinds else _no_group(group, _strange(accepted))
        of_one = of_one or (ordered if nothing_said(group.verdict) and not unknown else "")
        if of_one and of_one not in unknown and not wrong:
            group, unknown = replace(group, notes=(*group.notes, of_one)), [of_one]
            said += [] if any(text.endswith(of_one) for text in said) else [f"{group.label}: {of_one}"]
        if wrong:
            group = replace(group, verdict=contradicted_verdict(group, wrong))
        out.append(_not_green(group, unknown[0], ordered) if unknown else group)
        said += [f"{group.label}: {text}" for kind, text in doubts if kind not in kinds]
    return out, tuple(said)


def _strange(accepted: Mapping[str, Sequence[str]]) -> list[str]:
    """Trials that are known to be unlike the others."""
    return [name for name, kinds in accepted.items() if STRANGE & set(kinds)]


def _not_green(group: GroupFindings, text: str, ordered: str) -> GroupFindings:
    """A group of which nothing is missing, or what one trial alone shows, but a number or a trial that no body has:
    nobody can tell; nor where trials differ in their order (``ordered``), which says why they differ."""
    verdict = group.verdict
    bars = verdict.status == "nothing_missing" or (text == ordered and nothing_said(verdict))
    if not bars and not BETWEEN_TRIALS & set(verdict.verdict):
        return group
    said = f"{group.label}: cannot tell, because {text}."
    gate = Gate("plausible", "doubts about the group's numbers and trials", 1.0, 0.0, False, text)
    changed = replace(
        verdict, status="cannot_tell", sentence=said, because=text,
        next_test=NEXT["ordered" if text == ordered else "conditions"], confidence=math.nan,
        decision=(*verdict.decision, gate), verdict=(), alternatives=(), parameters={}, augmented=None,
        origin="undetermined", transfer={},
    )  # fmt: skip
    return replace(group, verdict=changed)


def _no_group(group: GroupFindings, strange: Sequence[str]) -> str:
    """Why nothing can be said of a group's trials together, in words; empty where nothing speaks against it."""
    return impossible(group) or not_one_body(group) or scaled_trial(group, strange)


def impossible(group: GroupFindings) -> str:
    """What no body and no calibration can be, in words; empty where nothing is."""
    return _floats(group) or _cells(group, group_numbers(group), CELLS_ARE_WRONG)


def implausible(
    group: GroupFindings, accepted: Mapping[str, Sequence[str]] = MappingProxyType({})
) -> tuple[tuple[str, str], ...]:
    """Numbers of a group that no body has, and trials that are none of its own: the kind of doubt (conditions, damping,
    unit) and a sentence for each, of an explained group those of the repaired equation. ``accepted`` is trial -> kinds
    of doubt that are known: such a trial may be strange.
    """
    numbers, mended = group_numbers(group), group.verdict.augmented
    if group.verdict.status == "explained" and mended is not None:
        numbers = {name: mended.parameters.get(name, number) for name, number in numbers.items()}
    lacks = group.verdict.status in LACKING
    found = out_of_range(numbers, group.specimen, [t.motion for t in group.trials], lacks)
    found.append(_weighed_wrong(group, numbers))
    found += [_stiffness(group, numbers), _cells(group, numbers, STIFFNESS_OFF), _floats(group), _unloaded(group)]
    found.append(not_one_body(group) or strange_trial(group, _strange(accepted)))
    doubts = [("conditions", text) for text in found if text]
    if strong := damped(numbers):
        doubts.append(("damping", strong))
    return (*doubts, *(("unit", text) for text in out_of_scale([t.motion for t in group.trials])))


def _noted(group: GroupFindings) -> list[str]:
    """What is no doubt yet: load cells that surely show another stiffness than the motion, and a mass that is surely
    another than the stated one, though within what springs and fixtures add."""
    stated, numbers = group.specimen.mass_kg, group_numbers(group)
    if cells := _cells(group, numbers, NOTED, "noted"):
        return [cells]
    found = None if "added_mass_kg" in numbers else numbers.get("total_mass_kg")
    if found is None or not stated > 0.0 or not math.isfinite(found.total_stderr):
        return []
    off, unit = found.value / stated - 1.0, group.specimen.unit("kg")
    if abs(off) - ERRORS * found.total_stderr / stated <= NOTED:
        return []
    return [
        f"what moves is {format_number(found.value, found.total_stderr)} {unit}, {percent(abs(off))} "
        f"{'above' if off > 0.0 else 'below'} the stated {format_number(stated)} {unit}: springs and fixtures may move "
        "along; else look at specimen.mass_kg, specimen.stiffness_N_per_m and the unit of time"
    ]


def _stiffness(
    group: GroupFindings, numbers: Mapping[str, Estimate], limit: float = STIFFNESS_OFF, verb: str = "doubted"
) -> str:
    """That the identified stiffness is surely another one than the stated one, by more than a share."""
    found = group.structure.k if group.structure is not None else numbers.get("k_N_per_m")
    return stiffness_off(found, group.specimen, limit, verb)


def _weighed_wrong(group: GroupFindings, numbers: Mapping[str, Estimate]) -> str:
    """That the load cells and the stated stiffness agree, and only the motion of the stated mass surely shows another:
    of the three the mass is then wrong."""
    stated, mass = group.specimen.stiffness_N_per_m, group.specimen.mass_kg
    cells = _cells_of(group)
    if cells is None or not stated > 0.0 or not mass > 0.0 or abs(cells.value / stated - 1.0) > AGREE:
        return ""
    if not (_stiffness(group, numbers, NOTED) and _cells(group, numbers, NOTED)):
        return ""
    found = group.structure.k if group.structure is not None else numbers["k_N_per_m"]
    unit, of_mass = group.specimen.unit("N/m"), group.specimen.unit("kg")
    return (
        f"the load cells show {format_number(cells.value, cells.total_stderr)} {unit}, as specimen.stiffness_N_per_m "
        f"says; the motion of specimen.mass_kg {format_number(mass)} shows {format_number(found.value)} {unit}: a body "
        f"of {format_number(mass * stated / found.value)} {of_mass} would swing so; look at specimen.mass_kg"
    )


def _cells_of(group: GroupFindings) -> Estimate | None:
    """The stiffness that the load cells show; None without them."""
    slopes = [slope for t in group.trials if (slope := slope_of_cells(t.motion)) is not None]
    return mean_of_trials(slopes, "N/m", "load cells") if slopes else None


def _cells(group: GroupFindings, numbers: Mapping[str, Estimate], limit: float, verb: str = "doubted") -> str:
    """That the load cells surely show another stiffness than mass and frequency, by more than a share."""
    found = group.structure.k if group.structure is not None else numbers.get("k_N_per_m")
    cells = _cells_of(group)
    if found is None or not found.value > 0.0 or cells is None:
        return ""
    off = cells.value / found.value - 1.0
    error = math.hypot(cells.total_stderr, found.total_stderr) / found.value
    surely = abs(off) - (ERRORS * error if math.isfinite(error) else 0.0)
    if surely <= limit:
        return ""
    return (
        f"the load cells' stiffness is at least {percent(surely)} {'above' if off > 0.0 else 'below'} the one that the "
        f"motion shows, and more than {100.0 * limit:.0f} % is {verb}: look at the cells' columns and calibration, at "
        "specimen.mass_kg, and at which spring these trials had"
    )


def _lighter(group: GroupFindings, numbers: Mapping[str, Estimate]) -> str:
    """That a body is surely lighter in water than in air, where no water that swings by itself is named."""
    found, mass, unit = numbers.get("added_mass_kg"), group.specimen.mass_kg, group.specimen.unit("kg")
    swings = set(group.verdict.verdict) & {s.name for s in SUSPECTS if s.swings}
    if found is None or swings or not mass > 0.0 or not found.total_stderr < math.inf:
        return ""
    repaired = group.verdict.augmented.parameters.get("added_mass_kg") if group.verdict.augmented else None
    if group.verdict.status == "explained" and isinstance(repaired, Estimate) and repaired.value >= 0.0:
        return ""  # what the equation lacks had stood in the mass
    if not found.value + ERRORS * found.total_stderr < -LIGHTER * mass:
        return ""
    return (
        f"the added mass {format_number(found.value, found.total_stderr)} {unit} is negative: look at whether dry and "
        "wet trials are exchanged (trials.dry), at the springs, and at water that swings slower than the body"
    )


def _floats(group: GroupFindings) -> str:
    """That the body, whose mass was not stated but follows from its spring, is lighter than the water it displaces."""
    body = group.specimen
    water = body.water_density_kg_per_m3 * body.submerged_volume_m3
    turns = any(t.motion.recording.coordinate == "rotation" for t in group.trials)
    error = body.mass_error_kg if math.isfinite(body.mass_error_kg) else 0.0
    if turns or not body.mass_kg + ERRORS * error < water:
        return ""
    return (
        f"the body's mass of {format_number(body.mass_kg)} kg is less than the {format_number(water)} kg of water that "
        "specimen.submerged_volume_m3 displaces: look at the volume, at specimen.stiffness_N_per_m and at the load "
        "cells' unit"
    )


def _dry_friction(group: GroupFindings) -> float:
    """The dry trials' friction coefficient; 0 where nobody knows one: an equation without friction knows no weight."""
    return 0.0 if group.structure is None else group.structure.mu.value


def _unloaded(group: GroupFindings) -> str:
    """That friction is less in water than in air, where nobody said how much weight the water takes off."""
    named = group.verdict.parameters.get(CoulombFriction.name)
    force = named.get(CoulombFriction.parameters[0].name) if isinstance(named, dict) else None
    body = group.specimen
    mu = _dry_friction(group)
    if not (mu > 0.0 and body.volume_assumed and isinstance(force, Estimate) and force.value < 0.0):
        return ""
    lacking, weight = -force.value, body.water_density_kg_per_m3 * body.gravity_m_per_s2
    volume = lacking / (mu * weight)
    return (
        f"friction is {format_number(lacking, force.total_stderr)} {force.unit} less than in air, and "
        f"specimen.submerged_volume_m3 is not stated: {volume:.2g} m^3 of displaced water would take that much weight "
        "off; state the volume"
    )


def _other_level(group: GroupFindings, groups: Sequence[GroupFindings]) -> str:
    """That friction named in water is what another level's displaced volume gives: levels may be exchanged."""
    named, body = group.verdict.parameters.get(CoulombFriction.name), group.specimen
    force = named.get(CoulombFriction.parameters[0].name) if isinstance(named, dict) else None
    weight = body.water_density_kg_per_m3 * body.gravity_m_per_s2
    lift = _dry_friction(group) * weight
    if not (lift > 0.0 and isinstance(force, Estimate) and force.total_stderr < abs(force.value) / ERRORS):
        return ""
    volume, error = body.submerged_volume_m3 - force.value / lift, ERRORS * force.total_stderr / lift
    for other in (g for g in groups if not g.dry and not g.specimen.volume_assumed):
        theirs = other.specimen.submerged_volume_m3
        if abs(theirs - volume) < error < abs(body.submerged_volume_m3 - volume):
            return (
                f"friction of {format_number(force.value, force.total_stderr)} {force.unit} beside the dry trials' is "
                f"what a displaced volume of {volume:.2g} m^3 gives, as stated of {other.label}: look whether levels "
                "are exchanged in the index, or volumes in specimen.submerged_volume_m3"
            )
    return ""
