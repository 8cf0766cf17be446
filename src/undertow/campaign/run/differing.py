"""Numbers with errors that hold how much those differ that should be one: of a group's trials, each fitted alone, of
halves of the amplitude, of the springs of one water, of the levels of one spring.

Belongs here: which fits are compared with which. Does not belong here: the tests and the errors
(uncertainty/disagreement.py), the sentence on numbers that differ between groups (discrepancy/drifts.py).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.discrepancy.drifts import METHOD, STRUCTURE, WATER, own_number
from undertow.discrepancy.findings import GroupFindings
from undertow.equation.kernel import SLOT
from undertow.likelihood.fit import Fit
from undertow.methods.baseline import GroupFit
from undertow.quantities import Estimate
from undertow.recording.recording import Condition
from undertow.uncertainty.disagreement import ALIKE, FEWEST, differing, grown, scatter_to_agree, with_scatter
from undertow.uncertainty.growth import LEVELS, SPRINGS, Grown

JOINT = ("output_error", "sindy")
"""Methods that take a group's trials together."""

MEAN = "mean over trials"
"""How the note of a fit begins whose numbers are means of single fits: scatter is in their errors already."""

SCATTERING = {"k1": "k", "c1": "c", "fc": "mu"}
"""Slot -> symbol of what differs from trial to trial on any rig."""

Singles = Mapping[str, Mapping[str, Fit]]
"""Trial -> method -> its fit of that trial alone."""


def with_grown_errors(
    fits: Mapping[str, Fit], singles: Singles, amplitudes: Mapping[str, float] | None = None
) -> tuple[dict[str, Fit], tuple[Grown, ...]]:
    """The methods' fits of all trials together, errors grown where trials differ by more, and in what they do.

    ``amplitudes`` are the trials' own (m or rad), by name: where given, halves of them are compared too.
    """
    pairs = {name: _grown(fit, singles, amplitudes) for name, fit in fits.items()}
    return {name: fit for name, (fit, _) in pairs.items()}, tuple(one for _, found in pairs.values() for one in found)


def _grown(fit: Fit, singles: Singles, amplitudes: Mapping[str, float] | None) -> tuple[Fit, tuple[Grown, ...]]:
    if fit.method not in JOINT or any(note.startswith(MEAN) for note in fit.notes):
        return fit, ()
    names = [name for name in fit.trials if fit.method in singles[name]]
    alone = [singles[name][fit.method].parameters for name in names]
    parameters, found = grown(fit.parameters, alone, [amplitudes[name] for name in names] if amplitudes else ())
    return replace(fit, parameters=parameters), found


def baseline_grown(
    baseline: GroupFit, motions: Sequence[Motion], singles: Singles
) -> tuple[GroupFit, tuple[Grown, ...]]:
    """The baseline with errors that hold how much its trials differ, and in what they do; one trial cannot."""
    if len(motions) == 1:
        return baseline, ()
    compared = [m for m in motions if METHOD in singles[m.name]]
    alone = [singles[m.name][METHOD].parameters for m in compared]
    estimates, found = grown(baseline.estimates, alone, [m.amplitude for m in compared])
    return replace(baseline, estimates=estimates), found


def of_any_trial(fit: GroupFit, scatter: Mapping[str, float]) -> GroupFit:
    """The fit of a single trial with errors that hold how much another would differ: ``scatter`` of k, c, mu in
    themselves, and that of k in the mass where k is held."""
    estimates = dict(fit.estimates)
    whole = fit.model.theta({name: e.value for name, e in estimates.items()})
    for c in fit.model.coefficients:
        held = c.slot == "mass" and not fit.model.weighed
        relative = scatter.get("k" if held else SCATTERING.get(c.slot, ""), 0.0)
        size = float(whole[SLOT["mass"]]) if held else estimates[c.name].value
        estimates[c.name] = with_scatter(estimates[c.name], relative * abs(size))
    return replace(fit, estimates=estimates)


def grown_between(groups: Sequence[GroupFindings], water: Collection[str]) -> list[GroupFindings]:
    """The groups with errors that hold how much springs of one water and levels of one spring differ.

    ``water`` names the conditions that are the water's; without any nobody knows what groups share. What belongs to the
    water is compared between groups of one water, what belongs to the structure between groups of one spring, where it
    is not held; numbers of groups that differ get the scatter with which they agree into their errors.
    """
    out = list(groups)
    for names, shared, among in ((WATER, True, SPRINGS), (STRUCTURE, False, LEVELS)) if water else ():
        families: dict[frozenset[tuple[str, Condition]], list[int]] = {}
        for i, group in enumerate(groups):
            if not group.dry:
                mark = frozenset((k, v) for k, v in group.key.items() if (k in water) == shared)
                families.setdefault(mark, []).append(i)
        for family, name, method in itertools.product(families.values(), names, JOINT):
            known = {i: e for i in family if (e := own_number(groups[i], name, method)) is not None}
            if len(known) < FEWEST:
                continue
            values, errors = (np.array([getattr(e, w) for e in known.values()]) for w in ("value", "total_stderr"))
            square, chance = differing(values, errors)
            if chance < ALIKE:
                between = scatter_to_agree(values, errors)
                for i, estimate in known.items():
                    before, after = estimate.stderr, with_scatter(estimate, between).stderr
                    grew = after / before if before > 0.0 else math.inf
                    found = Grown(name, square, values.size - 1, chance, grew, among)
                    out[i] = _with_scatter(out[i], name, method, estimate, between, found)
    return out


def _with_scatter(
    group: GroupFindings, name: str, method: str, estimate: Estimate, between: float, found: Grown
) -> GroupFindings:
    """The group with a scatter (unit of the number) in the number's error, and in those of the prescribed equation."""
    fit = group.fits[method]
    parameters = {**fit.parameters, name: with_scatter(estimate, between)}
    fits = {**group.fits, method: replace(fit, parameters=parameters)}
    errors = dict(group.equation_errors)
    for term, value in zip(group.equation.terms, group.equation.coefficients, strict=True):
        names = () if term.published is None else (term.published.column, term.published.ratio)
        if method == METHOD and name in names and term.name in errors and estimate.value:
            errors[term.name] = math.hypot(errors[term.name], abs(value / estimate.value) * between)
    verdict, baseline = group.verdict, group.verdict.baseline
    if method == METHOD and name in baseline.parameters:
        numbers = {**baseline.parameters, name: with_scatter(baseline.parameters[name], between)}
        verdict = replace(verdict, baseline=replace(baseline, parameters=numbers))
    return replace(group, fits=fits, verdict=verdict, equation_errors=errors, grown=(*group.grown, found))
