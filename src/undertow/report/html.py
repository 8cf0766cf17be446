"""The page: one self-contained report.html from finished findings, and the figures as files beside it.

Belongs here: what stands where on the page. Does not belong here: numbers' wording (wording.py, arrange.py), figures
(figures.py, trial_figures.py), any computation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from undertow.discrepancy.findings import Findings, GroupFindings, TrialFindings
from undertow.equation.equation import Equation
from undertow.report import figures, trial_figures
from undertow.report.arrange import excess, spanning_conditions, title, unexplained
from undertow.report.expressions import numeric_lines
from undertow.report.style import new_figure, page_style, svg_text
from undertow.report.wording import (
    error_parts,
    estimate_text,
    is_as_printed,
    method_label,
    ordered_parameters,
    parameter_name,
    percent,
    problem_of,
    safe_anchor,
)
from undertow.report.writing import write_text

LEVEL_PARAMETERS = ("added_mass_kg", "drag_coefficient")
"""Parameters drawn against level and amplitude where they were found: those the water has."""

WIDTH_IN = 11.0
"""Width of a figure over the whole page, inch."""

ROW_IN = 2.7
"""Height of one row of small multiples, inch."""

STATUS_WORDS: Mapping[str, str] = {
    "explained": "explained with an addition",
    "nothing_missing": "nothing missing",
    "unknown": "not explained",
    "not_identifiable": "not identifiable",
}

Block = Mapping[str, Any]


def write_report(findings: Findings, folder: Path, manifest: Mapping[str, Any]) -> Path:
    """Write ``report.html`` and ``figures/*.svg`` into the run folder; the page's path.

    ``manifest`` is the run's provenance; its ``config_text`` is shown escaped. Every text that came from files or the
    config is escaped by the template.
    """
    with page_style():
        drawn = page_figures(findings)
    (folder / "figures").mkdir(exist_ok=True)
    for name, svg in drawn.items():
        write_text(folder / "figures" / f"{name}.svg", svg)
    return write_text(folder / "report.html", page(findings, drawn, manifest))


def page(findings: Findings, drawn: Mapping[str, str], manifest: Mapping[str, Any]) -> str:
    """The page as text, from finished figures (name -> SVG)."""
    environment = Environment(
        loader=PackageLoader("undertow.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    template = environment.get_template("report.html.j2")
    inline = {name: Markup(_inline(svg)) for name, svg in drawn.items()}
    return template.render(
        name=findings.name,
        across=findings.across_groups,
        groups=[_group(findings, group, inline) for group in findings.groups],
        overview=_overview(findings),
        figures={name: svg for name, svg in inline.items() if name.startswith("all-")},
        failed=findings.failed,
        notes=findings.notes,
        manifest=_provenance(manifest),
        config_text=manifest.get("config_text", ""),
        counts=_counts(findings),
    )


def page_figures(findings: Findings) -> dict[str, str]:
    """Every figure of the page as SVG text, by name: ``all-...`` for the campaign, else the group's anchor first."""
    drawn = {}
    parameters = [p for p in LEVEL_PARAMETERS if figures.compared_methods(findings.groups, p)]
    if spanning_conditions(findings).level is not None and parameters and len(findings.groups) > 1:
        figure = new_figure(WIDTH_IN, 3.6)
        for parameter, axes in zip(parameters, _row(figure, len(parameters)), strict=True):
            figures.draw_against_level(findings, parameter, axes)
        figures.method_legend(findings, parameters, figure)
        drawn["all-levels"] = svg_text(figure)
    for group in findings.groups:
        drawn |= _group_figures(findings, group, parameters)
    return drawn


def _row(figure: Figure, number: int) -> Sequence[Any]:
    axes = figure.subplots(1, number, squeeze=False)
    return list(axes[0])


def _group_figures(findings: Findings, group: GroupFindings, parameters: Sequence[str]) -> dict[str, str]:
    anchor = safe_anchor(title(group))
    drawn = {}
    shown = min(len(group.trials), trial_figures.PANELS_AT_MOST)
    runs = new_figure(WIDTH_IN, ROW_IN * trial_figures.panel_grid(shown)[1])
    drawn[f"{anchor}-runs"] = svg_text(trial_figures.draw_free_runs(group, runs))
    found = [p for p in parameters if figures.compared_methods([group], p)]
    several = found if len(group.trials) > 1 else []
    summary = new_figure(WIDTH_IN, 3.2)
    axes = _row(summary, 2 + len(several))
    figures.draw_mismatch(findings, group, axes[0])
    trial_figures.draw_decay(group, axes[1])
    for parameter, place in zip(several, axes[2:], strict=True):
        figures.draw_against_amplitude(findings, [group], parameter, place)
    drawn[f"{anchor}-summary"] = svg_text(summary)
    if found:
        agreement = new_figure(WIDTH_IN, 2.2)
        for parameter, place in zip(found, _row(agreement, len(found)), strict=True):
            figures.draw_agreement(group, parameter, place)
        drawn[f"{anchor}-agreement"] = svg_text(agreement)
    open_trials = sorted(unexplained(group), key=excess, reverse=True)[:3]
    if open_trials:
        residuals = new_figure(WIDTH_IN, 2.0 * len(open_trials))
        drawn[f"{anchor}-residuals"] = svg_text(trial_figures.draw_residuals(open_trials, residuals))
    drawn[f"{anchor}-equation"] = equation_svg(group.equation, group.equation_errors)
    return drawn


def equation_svg(equation: Equation, errors: Mapping[str, float]) -> str:
    """The equation with its numbers, typeset, as SVG."""
    lines = numeric_lines(equation, errors)
    figure = new_figure(WIDTH_IN, 0.34 * len(lines) + 0.1)
    for i, line in enumerate(lines):
        figure.text(0.0, 1.0 - (i + 0.55) / len(lines), f"${line}$", fontsize=12, va="center")
    return svg_text(figure, outlines=True)


def _inline(svg: str) -> str:
    """The SVG element without its XML declaration and document type, for use inside HTML."""
    return svg[svg.index("<svg") :]


def _counts(findings: Findings) -> Mapping[str, int]:
    trials = [t for g in findings.groups for t in g.trials]
    return {
        "trials": len(trials),
        "groups": len(findings.groups),
        "failed": len(findings.failed),
        "missing": sum(t.mismatch.missing for t in trials),
        "open_groups": sum(g.verdict.status not in ("nothing_missing", "explained") for g in findings.groups),
    }


def _overview(findings: Findings) -> list[Block]:
    """One row a group: what stands for it, its error and what is allowed."""
    rows: list[Block] = []
    for group in findings.groups:
        fit = group.fits.get("output_error") or next(iter(group.fits.values()), None)
        shown = [p for p in ordered_parameters(fit.parameters if fit else ()) if p != "total_mass_kg"][:5]
        rows.append(
            {
                "title": title(group),
                "anchor": safe_anchor(title(group)),
                "dry": group.dry,
                "numbers": [
                    {"name": parameter_name(p).words, "text": estimate_text(fit.parameters[p])} for p in shown if fit
                ],
                "nrmse": percent(group.verdict.baseline.nrmse),
                "limit": percent(group.verdict.repeatability_nrmse),
                "missing": len(unexplained(group)),
                "trials": len(group.trials),
                "status": STATUS_WORDS[group.verdict.status],
                "open": group.verdict.status not in ("nothing_missing", "explained"),
            }
        )
    return rows


def _group(findings: Findings, group: GroupFindings, drawn: Mapping[str, Markup]) -> Block:
    anchor = safe_anchor(title(group))
    parameters = ordered_parameters(p for fit in group.fits.values() for p in fit.parameters)
    return {
        "title": title(group),
        "anchor": anchor,
        "dry": group.dry,
        "sentence": group.verdict.sentence,
        "status": STATUS_WORDS[group.verdict.status],
        "open": group.verdict.status not in ("nothing_missing", "explained"),
        "columns": [parameter_name(p).words for p in parameters],
        "methods": [_method_row(group, method, parameters) for method in group.fits],
        "latex": group.equation.to_latex(),
        "text": str(group.equation),
        "figures": {n.removeprefix(f"{anchor}-"): svg for n, svg in drawn.items() if n.startswith(f"{anchor}-")},
        "trials": [_trial_row(trial) for trial in group.trials],
        "notes": group.notes,
        "held_out": [t.motion.name for t in group.trials if t.held_out],
    }


def _method_row(group: GroupFindings, method: str, parameters: Sequence[str]) -> Block:
    fit = group.fits[method]
    cells = []
    for parameter in parameters:
        estimate = fit.parameters.get(parameter)
        cells.append(
            {"text": "", "parts": "", "problem": ""}
            if estimate is None
            else {"text": estimate_text(estimate), "parts": error_parts(estimate), "problem": problem_of(estimate)}
        )
    return {
        "label": method_label(method),
        "cells": cells,
        "outcome": "" if fit.outcome == "ok" else fit.outcome,
        "notes": [n for n in fit.notes if n],
        "as_printed": is_as_printed(method),
    }


def _trial_row(trial: TrialFindings) -> Block:
    m = trial.mismatch
    return {
        "name": trial.motion.name,
        "amplitude": f"{trial.motion.amplitude:.4g}",
        "held_out": trial.held_out,
        "nrmse": percent(m.nrmse),
        "floor": percent(m.sensor_floor_nrmse),
        "limit": percent(m.repeatability_nrmse),
        "missing": m.missing,
        "where": _where(trial),
        "scores": [
            {"label": method_label(name), "text": percent(score)}
            for name, score in trial.nrmse.items()
            if name != "baseline" and not is_as_printed(name)
        ],
    }


def _where(trial: TrialFindings) -> str:
    """In words where an unexplained trial's residual is; empty for an explained one."""
    m = trial.mismatch
    if not m.missing:
        return ""
    shares = {"first": m.share_early, "second": m.share_middle, "last": m.share_late}
    where = max(shares, key=lambda part: shares[part] if shares[part] == shares[part] else -1.0)
    text = f"{percent(shares[where])} in the {where} third"
    if m.line_share == m.line_share and m.line_share > 0.2:
        text += f", {percent(m.line_share)} in a line at {m.line_frequency_hz:.2f} Hz"
    return text


def _provenance(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    keys = ("undertow", "git_revision", "python", "platform", "config", "seed")
    rows = [(key, str(manifest[key])) for key in keys if key in manifest]
    packages = manifest.get("packages", {})
    rows.append(("packages", ", ".join(f"{name} {version}" for name, version in packages.items())))
    times = manifest.get("wall_time_s", {})
    rows.append(("wall time", ", ".join(f"{stage} {seconds:.3g} s" for stage, seconds in times.items())))
    return rows
