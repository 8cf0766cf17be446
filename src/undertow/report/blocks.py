"""What the page says, as plain rows and texts for its template.

Belongs here: which of the findings' numbers stand in which row, in words. Does not belong here: the page itself and its
figures (html.py), names and digits (wording.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from undertow.discrepancy.calibration import record_of
from undertow.discrepancy.findings import Findings, GroupFindings, TrialFindings
from undertow.discrepancy.mismatch import place_words
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import count, either, group_title, least_sets, percent, spelled
from undertow.quantities import OK, Estimate, format_number
from undertow.report import behind, wording
from undertow.report.arrange import agreement, spanning_conditions
from undertow.report.before_after import errors_of
from undertow.report.expressions import is_per_mass, numeric_latex
from undertow.report.extent import Extent, extent_of
from undertow.report.figures import amplitude_scale
from undertow.report.numbers import printed_unit, short_number

NO_BREAK = "\u00a0"
"""A space at which no line ends."""

COLUMNS_AT_MOST = 6
"""Parameters beside each other in the table of all groups."""

Block = Mapping[str, Any]


def counts(findings: Findings, extent: Extent | None = None) -> Mapping[str, str]:
    """How many trials and groups there are, in words; ``failed`` and ``missing`` are empty where there are none."""
    whole = extent or extent_of(findings)
    return {
        "trials": count(whole.trials, "trial"),
        "groups": count(whole.groups, "group"),
        "failed": str(len(findings.failed)) if findings.failed else "",
        "missing": f"{whole.missing} of {count(whole.trials, 'trial')}" if whole.missing else "",
    }


def shown_of(findings: Findings, extent: Extent) -> str:
    """Which groups a page leaves out, and what all verdicts are; empty where it shows all."""
    if len(findings.groups) == extent.groups:
        return ""
    said = ", ".join(f"{wording.STATUS_WORDS[status]} {number}" for status, number in extent.statuses.items())
    return (
        f"Of {extent.groups} groups ({said}) this page shows {len(findings.groups)}: dry ones, and those whose trials "
        "lie furthest from their equation. Every group stands in levels.csv and verdict.json, every trial in "
        "trials.csv and mismatch.csv."
    )


def first_of(items: Sequence[Any], at_most: int) -> tuple[Sequence[Any], str]:
    """At most so many of a list, and how many more there are, in words (empty: none).

    >>> first_of([1, 2, 3], 2), first_of([1], 2)
    (([1, 2], '1 more'), ([1], ''))
    """
    more = len(items) - at_most
    return items[:at_most], f"{more} more" if more > 0 else ""


def named_effects(verdict: Verdict) -> str:
    """The effects that a verdict names, with "unknown" after them where more is missing."""
    return "" if set(verdict.verdict) == {"unknown"} else wording.effects_words(verdict.verdict)


def rival_words(verdict: Verdict) -> tuple[str, ...]:
    """Sets of effects that the data cannot tell from the verdict's, without those that hold a smaller one; none where
    it can."""
    if verdict.status != "not_identifiable":
        return ()
    _, *others = least_sets((verdict.verdict, *verdict.alternatives))
    return tuple(wording.effects_words(names) for names in others)


def status_words(verdict: Verdict) -> str:
    """The status with the effects that are named: "explained with hidden resonator"."""
    named = named_effects(verdict).removesuffix(" + unknown")
    if verdict.status == "unknown":
        return f"{named} + unknown" if named else wording.STATUS_WORDS["unknown"]
    if verdict.describes and verdict.status == "explained":
        return f"described by {named}"
    if verdict.status == "not_identifiable" and named:
        return f"{wording.STATUS_WORDS[verdict.status]}: {either((named, *rival_words(verdict)))}"
    return f"{wording.STATUS_WORDS[verdict.status]} {named}".strip() if named else wording.STATUS_WORDS[verdict.status]


def tone(verdict: Verdict) -> str:
    """How loud a status is shown: "good" (nothing missing alone), "found" (explained by an addition, or there but
    small), "unsure" (nobody can tell), "open"."""
    tones = {"nothing_missing": "good", "explained": "found", "present_but_small": "found", "cannot_tell": "unsure"}
    return tones.get(verdict.status, "open")


def unit_of(estimates: Sequence[Estimate]) -> str:
    """The unit that all estimates share; empty where they do not, or for a pure number."""
    units = {estimate.unit for estimate in estimates}
    only = units.pop() if len(units) == 1 else ""
    return "" if only == "1" else only


def column_heading(parameter: str, unit: str) -> str:
    """Words of a parameter with its unit.

    >>> column_heading("k_N_per_m", "N/m"), column_heading("mu", "")
    ('stiffness (N/m)', 'friction coefficient')
    """
    words = wording.parameter_name(parameter).words
    return f"{words} ({printed_unit(unit).replace(' ', NO_BREAK)})" if unit else words


def overview(findings: Findings, anchors: Sequence[str], extent: Extent | None = None) -> Block:
    """The table of all groups: ``columns``; ``rows`` of what stands for each, its error and what is allowed."""
    whole = extent or extent_of(findings)
    numbers = [behind.believed_numbers(group) for group in findings.groups]
    parameters = [p for p in wording.ordered_parameters(n for found in numbers for n in found) if p != "total_mass_kg"]
    parameters = parameters[:COLUMNS_AT_MOST]
    units = {p: unit_of([found[p] for found in numbers if p in found]) for p in parameters}
    rows = [
        identity(group, anchor)
        | {
            "cells": [behind.number_words(group, found[p], not units[p]) if p in found else "" for p in parameters],
            "nrmse": percent(group.verdict.baseline.nrmse),
            "limit": behind.allowed_words(group.verdict, group.verdict.repeatability_nrmse),
            "unseen": unseen_words(group.verdict),
            "missing": "{1} of {0}".format(*whole.size_of(group)),
        }
        for group, anchor, found in zip(findings.groups, anchors, numbers, strict=True)
    ]
    return {"columns": [column_heading(p, units[p]) for p in parameters], "rows": rows}


def unseen_words(verdict: Verdict) -> str:
    """Free-run error on trials that no fit has seen, before and after what is named; empty without such a proof."""
    errors = errors_of(verdict.baseline, verdict.augmented)
    return f"{percent(errors[0])} → {percent(errors[1])}" if errors is not None and errors[2] == "unseen" else ""


def identity(group: GroupFindings, anchor: str) -> dict[str, Any]:
    """What names a group and its verdict wherever it stands."""
    return identity_of(group.verdict, group.label, anchor, group.dry)


def identity_of(verdict: Verdict, label: str, anchor: str, dry: bool = False) -> dict[str, Any]:
    """The same of a verdict under its group's label."""
    return {
        "title": wording.unbroken(label),
        "anchor": anchor,
        "dry": dry,
        "status": status_words(verdict),
        "names": either((named_effects(verdict), *rival_words(verdict))) if named_effects(verdict)
        else status_words(verdict),
        "tone": tone(verdict),
    }


def group_block(
    findings: Findings, group: GroupFindings, anchor: str, figures: Mapping[str, str], extent: Extent | None = None
) -> Block:
    """Everything of one group's section."""
    published = dict(group.specimen.published)
    parameters = wording.ordered_parameters((*(p for fit in group.fits.values() for p in fit.parameters), *published))
    units = {
        p: unit_of([fit.parameters[p] for fit in group.fits.values() if p in fit.parameters]) for p in parameters
    }
    (factor, unit), turns = amplitude_scale(findings), group.specimen.rotation
    return identity(group, anchor) | {
        "verdict": verdict_block(group.verdict),
        "columns": [column_heading(p, units[p]) for p in parameters],
        "methods": [_method_row(group, method, units) for method in group.fits],
        "published": [short_number(published[p], 5) if p in published else "" for p in parameters] if published else [],
        "agreement": agreement_texts(group, [p for p in parameters if p != "total_mass_kg"]),
        "gates": behind.gate_rows(group.verdict),
        "seen": behind.seen_rows(group.verdict),
        "not_testable": [spelled(name) for name in group.verdict.not_testable],
        "repaired": behind.repaired_block(group),
        "no_gain": no_gain_words(findings, group),
        "adjusted": behind.adjusted_words(group),
        "latex": [group.equation.to_latex(), numeric_latex(group.equation, group.equation_errors, rotation=turns)],
        "text": group.equation.text(group.equation_errors),
        "per_mass": is_per_mass(group.equation, group.equation_errors),
        "rotation": turns,
        "figures": figures,
        "as_measured": any(math.isfinite(trial.as_measured) for trial in group.trials),
        "augmented": any(trial.augmented for trial in group.trials),
        "amplitude_unit": unit,
        "trials": [_trial_row(trial, factor) for trial in group.trials],
        "notes": [wording.unbroken(wording.in_plain_words(note.rstrip("."))) for note in group.remarks],
        "held_out": [t.motion.name for t in group.trials if t.held_out],
        "of_trials": (extent or extent_of(findings)).size_of(group)[0],
    }


def no_gain_words(findings: Findings, group: GroupFindings) -> str:
    """Why a repaired equation may leave more of this group's motion than the prescribed one; empty where it does not.

    The springs of one water are judged together: what is named can be needed on one spring and be no gain on the other.
    """
    verdict, errors = group.verdict, errors_of(group.verdict.baseline, group.verdict.augmented)
    if errors is None or not errors[1] > errors[0]:
        return ""
    span = spanning_conditions(findings)
    together = [g for g in findings.groups if g is not group and span.level_of(g) == span.level_of(group)]
    alike = [
        (g, found) for g in together if g.verdict.verdict == verdict.verdict
        and (found := errors_of(g.verdict.baseline, g.verdict.augmented)) is not None and found[1] < found[0]
    ]  # fmt: skip
    text = f"In this group the free-run error does not fall ({percent(errors[0])} as prescribed, {percent(errors[1])} "
    text += f"repaired, on {errors[2]} trials"
    if max(errors[:2]) <= verdict.repeatability_nrmse:
        text += f", both within repeatability, {percent(verdict.repeatability_nrmse)}"
    if not together:
        return text + ")"
    text += "): the prescribed equation was fitted to this group alone"
    if not alike:
        return f"{text}, the repaired one to several groups together"
    falls = "; ".join(f"{wording.unbroken(g.label)}, {percent(found[0])} → {percent(found[1])}" for g, found in alike)
    return f"{text}, the repaired one to all groups of this water together. What is named is needed there ({falls})"


def verdict_block(verdict: Verdict) -> Block:
    """The sentence, and what stands behind it: how probable it is, its check, what was ruled out, the next test."""
    check = verdict.physical_check
    return {
        "sentence": wording.sentence_words(verdict.sentence, group_title(verdict.group)),
        "confidence": "" if few_words(verdict) else likelihood_words(verdict),
        "record": record_words(verdict),
        "posterior": behind.posterior_words(verdict),
        "named": named_effects(verdict),
        "rivals": either(rival_words(verdict)),
        "rivals_said": "cannot tell it from" in verdict.sentence,
        "origin": "" if verdict.origin == "undetermined" else verdict.origin,
        "check": check.because if math.isfinite(check.expected) or check.agrees is not None else "",
        "agrees": check.agrees,
        "rejected": [
            {"name": spelled(one.name), "because": wording.rejected_words(one.name, one.because)}
            for one in verdict.rejected
        ],
        "next_test": verdict.next_test,
    }


def likelihood_words(verdict: Verdict) -> str:
    """How often such a verdict holds; empty where the data cannot tell names apart (one of them alone has no
    probability worth printing), or nothing was found out. Where few such verdicts were counted, the counts.

    >>> likelihood_words(Verdict({}, (), status="explained", posterior=0.99, confidence=0.72))
    '72 %'
    """
    if verdict.status not in ("explained", "nothing_missing", "unknown"):
        return ""
    return few_words(verdict) or wording.confidence_words(verdict.confidence)


def few_words(verdict: Verdict) -> str:
    """Of how many such verdicts how many held, where they are too few for a percentage; else empty."""
    record = record_of(verdict)
    return record.few if record is not None else ""


def record_words(verdict: Verdict) -> str:
    """Of how many such verdicts on sealed campaigns how many held; empty where none were counted."""
    record = record_of(verdict)
    if record is None or not record.said or not math.isfinite(verdict.confidence):
        return ""
    kind, sure = behind.kind_words(record.kind), sure_words(verdict)
    said = f"of {record.said} such verdicts ({kind}) on sealed campaigns of known truth {record.right} held"
    return f"{said}, which makes {sure}" if sure else said


def sure_words(verdict: Verdict) -> str:
    """How often what is said holds, where enough such verdicts were counted; else empty, as of ``cannot_tell``, which
    claims nothing.

    >>> sure_words(Verdict({}, (), status="not_identifiable", confidence=0.82))
    '82 %'
    """
    record = record_of(verdict)
    if record is None or record.few:
        return ""
    return wording.confidence_words(verdict.confidence)


def agreement_texts(group: GroupFindings, parameters: Sequence[str]) -> list[str]:
    """On which parameters the methods agree, and on which they differ by how much; where two have error bars."""
    agreed, differing = [], []
    for parameter in parameters:
        found = agreement(group, parameter)
        words = wording.parameter_name(parameter).words
        if found is None:
            continue
        if found.agrees:
            agreed.append(words)
            continue
        first, second = (wording.method_label(method) for method in found.pair)
        size = wording.estimate_text(Estimate(float(f"{found.difference:.2g}"), 0.0, unit=found.unit))
        times = format_number(float(f"{found.distance:.2g}"))
        differing.append(f"{words} ({first} and {second} by {size}, {times} standard errors apart)")
    said = [("The methods agree within two combined standard errors on", ", ".join(agreed))]
    said.append(("They differ on", ", ".join(differing)))
    return [f"{start} {what}" for start, what in said if what]


def _method_row(group: GroupFindings, method: str, units: Mapping[str, str]) -> Block:
    fit = group.fits[method]
    cells = []
    for parameter, unit in units.items():
        estimate = fit.parameters.get(parameter)
        cells.append(
            {"text": "", "parts": "", "problem": ""}
            if estimate is None
            else {
                "text": wording.estimate_text(estimate, not unit),
                "parts": wording.error_parts(estimate),
                "problem": "" if wording.problem_of(estimate) == "no error bar" else wording.problem_of(estimate),
            }
        )
    return {
        "label": wording.method_label(method),
        "cells": cells,
        "outcome": "" if fit.outcome == OK else wording.in_plain_words(fit.outcome),
        "notes": [wording.reason_words(n) for n in fit.notes if n],
        "as_printed": wording.is_as_printed(method),
    }


def _trial_row(trial: TrialFindings, factor: float) -> Block:
    m = trial.mismatch
    return {
        "name": trial.motion.name,
        "amplitude": short_number(trial.motion.amplitude * factor),
        "held_out": trial.held_out,
        "nrmse": percent(m.nrmse),
        "as_measured": as_measured_words(trial),
        "floor": percent(m.sensor_floor_nrmse),
        "limit": percent(m.repeatability_nrmse),
        "missing": m.missing,
        "where": where_words(trial),
        "scores": [
            {"label": wording.method_label(name), "text": percent(score)}
            for name, score in trial.nrmse.items()
            if name != "baseline" and not wording.is_as_printed(name)
        ],
    }


def as_measured_words(trial: TrialFindings) -> str:
    """Free-run error with nothing adjusted to the trial, before and after what is named.

    >>> from types import SimpleNamespace
    >>> as_measured_words(SimpleNamespace(as_measured=0.71, augmented=SimpleNamespace(as_measured=0.05)))
    '71 % → 5.0 %'
    >>> as_measured_words(SimpleNamespace(as_measured=math.nan, augmented=SimpleNamespace(as_measured=0.05)))
    'without bounds → 5.0 %'
    """
    after = math.nan if trial.augmented is None else trial.augmented.as_measured
    if not (math.isfinite(trial.as_measured) or math.isfinite(after)):
        return ""
    said = [trial.as_measured] if trial.augmented is None else [trial.as_measured, after]
    return " → ".join(percent(value) if math.isfinite(value) else "without bounds" for value in said)


def where_words(trial: TrialFindings) -> str:
    """Where an unexplained trial's residual is; empty for an explained one."""
    return place_words([trial.mismatch]) if trial.mismatch.missing else ""


def method_notes(findings: Findings) -> list[Block]:
    """What each method that ran does, a line each."""
    ran = dict.fromkeys(method for group in findings.groups for method in group.fits)
    notes = wording.METHOD_NOTES
    return [{"label": wording.method_label(m), "note": notes[m]} for m in ran if m in notes]


def provenance(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Versions, config, seed and times of a manifest, as rows."""
    keys = ("undertow", "git_revision", "python", "platform", "config", "seed")
    rows = [(key.replace("_", " "), str(manifest[key])) for key in keys if key in manifest]
    if manifest.get("overrides"):
        rows.append(("overrides", ", ".join(str(text) for text in manifest["overrides"])))
    packages = manifest.get("packages", {})
    rows.append(("packages", ", ".join(f"{name} {version}" for name, version in packages.items())))
    times = manifest.get("wall_time_s", {})
    rows.append(("wall time", ", ".join(f"{stage} {seconds:.3g} s" for stage, seconds in times.items())))
    return [(key, value) for key, value in rows if value]
