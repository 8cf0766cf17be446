"""A campaign of harmonic sets from config to run folder: equation, what it lacks, proof on points nobody fitted.

Belongs here: the order of that, and the files' content. Does not belong here: reading (sets.py), the search
(comparison/response_search.py), curves (curves.py), the page's shape (report/).
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.campaign.driven.files import (
    group_entry,
    manifest_of,
    numbers_of,
    numbers_row,
    rows_csv,
    write_answer,
    write_manifest,
)
from undertow.campaign.driven.page import as_sentence
from undertow.campaign.driven.run import DrivenFinished
from undertow.campaign.response.page import page_part
from undertow.campaign.response.sets import Sweeps, sweeps
from undertow.campaign.run.workers import Progress, silent
from undertow.comparison.response_search import UNSEEN_LAWS, ResponseFound, discover_response
from undertow.discrepancy.findings import FailedTrial
from undertow.discrepancy.words import count, group_title, percent
from undertow.equation.driven_laws import find_driven, places
from undertow.equation.term import Term
from undertow.errors import UndertowError
from undertow.methods.driven_equations import equation_text
from undertow.methods.harmonic_set import MASS, HarmonicFit
from undertow.quantities import OK
from undertow.recording.recording import Condition
from undertow.report.driven_page import Made, page_html, write_page
from undertow.report.writing import write_text


def run_response(
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
    progress("read", 0, 1)
    groups, reasons = sweeps(config)
    if not groups:
        raise UndertowError(f"none of {len(reasons)} trials can be used: {'; '.join(list(reasons.values())[:3])}")
    failed = tuple(FailedTrial(name, reason) for name, reason in reasons.items())
    progress("read", 1, 1)
    found: list[ResponseFound] = []
    for done, group in enumerate(groups):
        progress("identification", done, len(groups))
        terms, held = known(config, group.key)
        unseen = None if config.trials.hold_out == "auto" else group.unseen
        suspects = config.discrepancy.named
        found.append(discover_response(group.measured, group.along, terms, held, suspects, unseen, config.seed))
    progress("identification", len(groups), len(groups))
    pairs = list(zip(groups, found, strict=True))
    titles = [f"{config.name}, {group_title(group.key)}" if group.key else config.name for group in groups]
    sentences = [sentence_of(title, *pair) for title, pair in zip(titles, pairs, strict=True)]
    verdicts = _write(folder, config, text, pairs, sentences)
    made = manifest_of(config, config_path, overrides, failed, begun)
    if page:
        parts = [
            page_part(config, *pair, entry, as_sentence(said.removeprefix(f"{title}: ")))
            for pair, entry, said, title in zip(pairs, verdicts, sentences, titles, strict=True)
        ]
        kind = f"{count(sum(len(group.tables) for group in groups), 'harmonic set')} in {count(len(groups), 'group')}"
        write_page(folder, page_html(config.name, kind, parts, Made(made, text, failed)), parts)
    write_manifest(folder, made)
    return DrivenFinished(folder, "\n".join(sentences), tuple(found), failed, page=page)


def known(config: RunConfig, conditions: Mapping[str, Condition]) -> tuple[tuple[Term, ...], dict[str, float]]:
    """The config's terms, and what the specimen says of their numbers: the mass; on a base without a known mass, the
    stiffness."""
    terms = tuple(find_driven(name) for name in config.equation.terms)
    specimen, held = config.specimen_for(conditions), dict[str, float]()
    if np.isfinite(specimen.mass_kg):
        held[MASS] = specimen.mass_kg
    spring = next((term for term in terms if term.is_spring), None)
    based = config.recordings.driven_by != "force"
    wanted = (based and MASS not in held) or any(term.is_inertia for term in terms)
    if wanted and spring is not None and np.isfinite(specimen.stiffness_N_per_m):
        held[f"{spring.name}.{spring.coefficient.name}"] = specimen.stiffness_N_per_m
    return terms, held


def sentence_of(title: str, group: Sweeps, found: ResponseFound) -> str:
    """What was found, in words."""
    size, best = group.size, found.best
    before, after = (percent(rms / size) for rms in found.validation)
    n = int(np.sum(found.unseen))
    first = f"{title}: the given equation misses {before} of the motion at {n} points it never saw"
    if not n:
        first = f"{title}: the given equation misses {percent(found.baseline.rms / size)} of the motion"
    if found.unchecked:
        said = f"; nothing was checked: {found.unchecked}"
    elif not found.added:
        said = ", and no law that was tried helps"
    else:
        said = f"; with {', '.join(found.added).replace('_', ' ')} {after}"
    for name in dict.fromkeys(name for name, _ in found.alternatives):
        rivals = ", ".join(rival for of, rival in found.alternatives if of == name)
        said += f"; these points cannot tell {name} from {rivals}".replace("_", " ")
    left = "" if found.adequate else "; more than noise is left"
    return f"{first}{said}{left}." + ("" if best.outcome == OK else f" The fit: {best.outcome}.")


def _write(
    folder: Path,
    config: RunConfig,
    text: str,
    pairs: Sequence[tuple[Sweeps, ResponseFound]],
    sentences: Sequence[str],
) -> list[Mapping[str, Any]]:
    """All files but the manifest and the page; the groups of verdict.json."""
    entries = [_equations(config, group, one) for group, one in pairs]
    verdicts = [_verdict(group, one, said) for (group, one), said in zip(pairs, sentences, strict=True)]
    named = list(dict.fromkeys(name for entry in verdicts for name in entry["verdict"]))
    write_answer(folder, text, config, entries, verdicts, {"verdict": named, "sentence": " ".join(sentences)})
    _tables(folder, pairs)
    return verdicts


def _equations(config: RunConfig, group: Sweeps, found: ResponseFound) -> dict[str, Any]:
    """One group of equations.json, as that of a body driven in time has it."""
    versions = {"baseline": _version(config, group, found.baseline, found.validation[0])}
    if found.augmented is not None:
        versions["augmented"] = _version(config, group, found.augmented, found.validation[1])
    best = versions.get("augmented", versions["baseline"])
    names = [table.name for table in group.tables]
    return {
        "group": dict(group.key), "trials": names, "driven": True, "harmonic": True, "versions": versions,
        "noise": {name: {"displacement": best["noise"]} for name in names}, "scatter": {}, "unit": group.unit,
        "equation": equation_text(best),
    }  # fmt: skip


def _version(config: RunConfig, group: Sweeps, fit: HarmonicFit, unseen: float) -> dict[str, Any]:
    """One version: law rows, values in full precision, covariance."""
    measured = group.measured
    rows = [
        {
            "term": place.term.name, "law": place.term.law, "parameter": place.parameter.name, "name": place.name,
            "unit": place.parameter.unit, "value": fit.numbers[place.name].value,
            "stderr": fit.numbers[place.name].stderr, "held": place.name in fit.held,
            "relative_to": place.term.relative_to,
        }
        for place in places(fit.terms, measured.mover)
    ]  # fmt: skip
    response = config.recordings.response
    frame = response.amplitude.frame if response is not None else None
    reach = float(np.max(measured.amplitude))
    return {
        "terms": [term.name for term in fit.terms], "mass_kg": fit.numbers["mass_kg"].value, "rows": rows,
        "names": list(fit.free), "values": [fit.values[name] for name in fit.free],
        "covariance": fit.covariance.tolist(), "fixed": dict(fit.held),
        "free_run_error": unseen if np.isfinite(unseen) else fit.rms, "motion_rms": group.size,
        "outcome": fit.outcome,
        "input": config.recordings.driven_by,
        "frames": {"displacement": frame} if frame else {}, "noise": fit.rms, "noises": {"displacement": fit.rms},
        "extent": [reach, reach * float(np.max(measured.rate))],
    }  # fmt: skip


def _verdict(group: Sweeps, found: ResponseFound, sentence: str) -> Mapping[str, Any]:
    """One group of verdict.json."""
    size = group.size
    status, because, named = "nothing_missing", "", found.added
    if found.unchecked:
        status, because = "cannot_tell", found.unchecked
    elif not found.adequate:
        status, because, named = "unknown", "more than noise is left", (*found.added, "unknown")
    elif found.added:
        status = "not_identifiable" if found.alternatives else "explained"
    others = [[rival if name == of else name for name in found.added] for of, rival in found.alternatives]

    def described(fit: HarmonicFit, unseen: float) -> Mapping[str, Any]:
        """One version's errors and numbers."""
        held = unseen / size if np.isfinite(unseen) else None
        return {"nrmse": fit.rms / size, "held_out_nrmse": held, "parameters": fit.numbers}

    return group_entry(
        group.key, [table.name for table in group.tables], group.held_out, status, named, found.tried, sentence,
        statistic="rms on unseen points", because=because, alternatives=others, p_value=found.p_value,
        not_testable=list(UNSEEN_LAWS), parameters={name: numbers_of(found.best.numbers, name) for name in found.added},
        baseline=described(found.baseline, found.validation[0]),
        augmented=None if found.augmented is None else described(found.augmented, found.validation[1]),
        unseen_points=int(np.sum(found.unseen)),
    )  # fmt: skip


def _tables(folder: Path, pairs: Sequence[tuple[Sweeps, ResponseFound]]) -> None:
    """trials.csv, levels.csv and mismatch.csv, a row a trial (a group) and version."""
    trials, levels, mismatch = list[dict[str, Any]](), list[dict[str, Any]](), list[dict[str, Any]]()
    for group, found in pairs:
        versions = {"baseline": found.baseline} | ({"augmented": found.augmented} if found.augmented else {})
        for version, fit in versions.items():
            said = {**group.key, "method": f"harmonic_set_{version}", **numbers_row(fit.numbers)}
            levels.append({**said, "nrmse": fit.rms / group.size, "outcome": fit.outcome})
            trials += [
                {"file": table.name, **said, "nrmse": missed, "outcome": fit.outcome}
                for table, missed in zip(group.tables, _missed(group, fit), strict=True)
            ]
        mismatch += [
            {"file": table.name, "nrmse": missed}
            for table, missed in zip(group.tables, _missed(group, found.best), strict=True)
        ]
    for name, rows in (("trials", trials), ("levels", levels), ("mismatch", mismatch)):
        write_text(folder / f"{name}.csv", rows_csv(rows))


def _missed(group: Sweeps, fit: HarmonicFit) -> list[float]:
    """What each trial's points miss, over what they move."""
    squared, moved = np.sum(fit.missed**2, axis=0), group.measured.amplitude**2
    return [
        float(np.sqrt(np.sum(squared[group.trial == i]) / np.sum(moved[group.trial == i])))
        for i in range(len(group.tables))
    ]
