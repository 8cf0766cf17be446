"""Every figure of one group's section, as SVG text by what it shows.

Belongs here: which figures a group has, and their sizes. Does not belong here: drawing (figures.py, trial_figures.py,
mismatch_figures.py, fit_figures.py), the page (html.py), captions (captions.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from undertow.conditioning.period import dominant_period
from undertow.discrepancy.cycle_by_cycle import cycling
from undertow.discrepancy.energy import EnergyBudget, energy_budget
from undertow.discrepancy.findings import Findings, GroupFindings, TrialFindings
from undertow.discrepancy.repaired import named_laws, refitted_equation
from undertow.discrepancy.words import spelled
from undertow.equation.equation import Equation
from undertow.errors import IdentificationError, UndertowError
from undertow.report import figures, fit_figures, mismatch_figures, small_multiples, trial_figures
from undertow.report.behind import is_repaired, repaired_of
from undertow.report.expressions import LATEX_LINE, numeric_lines
from undertow.report.first_screen import shown_trial
from undertow.report.style import new_figure, svg_text

WIDTH_IN = 11.0
"""Width of a figure over the whole page, inch."""

SLIM_TERMS = 2
"""Terms in a line of an equation on a phone."""


def group_figures(findings: Findings, group: GroupFindings, parameters: Sequence[str]) -> dict[str, str]:
    """A group's figures by what they show; only those that say something of it."""
    turns = group.specimen.rotation
    shown = min(len(group.trials), small_multiples.PANELS_AT_MOST)
    runs = new_figure(WIDTH_IN, small_multiples.ROW_IN * small_multiples.panel_grid(shown)[1] + 0.3)
    found = [p for p in parameters if figures.compared_methods([group], p)]
    drawn = {
        "equation": equation_svg(group.equation, group.equation_errors, rotation=turns),
        "equation-slim": equation_svg(group.equation, group.equation_errors, slim=True, rotation=turns),
        "runs": svg_text(small_multiples.draw_free_runs(group, runs)),
        "summary": _summary(findings, group, found if len(group.trials) > 1 else []),
    }
    if written := repaired_of(group):
        broad, slim = (equation_svg(*written, slim=one, rotation=turns) for one in (False, True))
        drawn |= {"repaired": broad, "repaired_slim": slim}
    if found:
        agreement = new_figure(WIDTH_IN, 2.0)
        for parameter, place in zip(found, row_of(agreement, len(found)), strict=True):
            figures.draw_agreement(group, parameter, place)
        drawn["agreement"] = svg_text(agreement)
    return drawn | _of_one_trial(findings, group) | _of_the_answer(group)


def one_trial(findings: Findings, group: GroupFindings) -> TrialFindings | None:
    """The trial of a group that stands for it where one is drawn large: chosen as on the first screen."""
    shown = shown_trial(replace(findings, groups=(group,)))
    return None if shown is None else shown.trial


def budget_of(group: GroupFindings, trial: TrialFindings) -> EnergyBudget | None:
    """Energy of one trial under the equation that is believed: the repaired one where something is named."""
    try:
        named = is_repaired(group.verdict)
        believed = refitted_equation(group.equation, group.verdict, group.specimen) if named else group.equation
    except IdentificationError:  # a law without a number of its own
        believed = group.equation
    return energy_budget(trial.motion, believed)


def marked_lines(group: GroupFindings, trial: TrialFindings) -> dict[str, float]:
    """Frequencies in Hz that are marked in a map of the residual: the body's, and what was found, by what they are."""
    try:
        lines = {"body": 1.0 / dominant_period(trial.motion)}
    except UndertowError:
        lines = {}
    numbers = {} if group.verdict.augmented is None else group.verdict.augmented.parameters
    for name, estimate in numbers.items():
        if name.endswith("frequency_rad_per_s"):
            words = spelled(name.split(".")[0]).replace("#", " ") + "'s waves" * (".kernel_" in name)
            lines[words] = estimate.value / (2.0 * math.pi)
    if not numbers and math.isfinite(trial.mismatch.line_frequency_hz):
        lines["strongest line of the residual"] = trial.mismatch.line_frequency_hz
    return lines


def _of_one_trial(findings: Findings, group: GroupFindings) -> dict[str, str]:
    """Figures of the trial that stands for the group: energy, where the mismatch is, residual against noise."""
    trial = one_trial(findings, group)
    if trial is None:
        return {}
    drawn: dict[str, str] = {}
    if budget := budget_of(group, trial):
        drawn["energy"] = svg_text(
            mismatch_figures.draw_energy(budget, named_laws(group.verdict), new_figure(WIDTH_IN, 2.3))
        )
    lines, cycles = marked_lines(group, trial), cycling(trial)
    if cycles is not None and (named_laws(group.verdict) or any(t.mismatch.missing for t in group.trials)):
        paper = new_figure(WIDTH_IN, 5.0 if cycles.time.size else 3.0)
        drawn["where"] = svg_text(mismatch_figures.draw_where(group, trial, cycles, lines, paper))
    if lines and float(trial.measured.std()) > 0.0 and not trial_figures.leaves(trial):
        period = 1.0 / next(iter(lines.values()))
        drawn["noise"] = svg_text(fit_figures.draw_noise(trial, period, new_figure(WIDTH_IN, 2.4)))
    return drawn


def _of_the_answer(group: GroupFindings) -> dict[str, str]:
    """Figures of the answer: suspects, replicas, correlations, friction."""
    drawn: dict[str, str] = {}
    verdict = group.verdict
    if any(math.isfinite(r.log_odds) for r in verdict.rejected):
        said = fit_figures.odds_beside(verdict)
        rows = min(len(verdict.rejected), fit_figures.SUSPECTS_AT_MOST) + 1
        drawn["suspects"] = svg_text(
            fit_figures.draw_suspects(said, verdict.rejected, new_figure(WIDTH_IN, 0.9 + 0.2 * rows))
        )
    if verdict.null is not None and math.isfinite(verdict.p_value):
        drawn["null"] = svg_text(fit_figures.draw_null(verdict.null, verdict.p_value, new_figure(WIDTH_IN, 2.3)))
    if verdict.augmented is not None and (size := len(fit_figures.pair_names(verdict.augmented))) > 1:
        pairs = new_figure(min(1.0 + 1.5 * size, WIDTH_IN), 0.5 + 0.85 * size)
        fit_figures.draw_pairs(verdict.augmented, pairs.subplots())
        drawn["pairs"] = svg_text(pairs)
    if panels := fit_figures.friction_panels(group):
        friction = new_figure(WIDTH_IN, 2.6)
        drawn["friction"] = svg_text(fit_figures.draw_friction(group, panels, friction))
    return drawn


def row_of(figure: Figure, number: int) -> Sequence[Axes]:
    """A row of so many Axes."""
    return list(figure.subplots(1, number, squeeze=False)[0])


def _summary(findings: Findings, group: GroupFindings, parameters: Sequence[str]) -> str:
    """Mismatch, decay, and each parameter against amplitude, side by side under one legend."""
    summary = new_figure(WIDTH_IN, 3.4)
    axes = row_of(summary, 2 + len(parameters))
    figures.draw_mismatch(findings, group, axes[0])
    trial_figures.draw_decay(group, axes[1])
    for parameter, place in zip(parameters, axes[2:], strict=True):
        figures.draw_against_amplitude(findings, [group], parameter, place)
    figures.group_legend(group, parameters, summary)
    return svg_text(summary)


def equation_svg(
    equation: Equation, errors: Mapping[str, float], slim: bool = False, drive: str = "0", rotation: bool = False
) -> str:
    """The equation with its numbers, typeset, as SVG; ``slim`` for a phone, ``drive`` what stands on its right,
    ``rotation`` where an angle moves."""
    lines = numeric_lines(equation, errors, SLIM_TERMS if slim else LATEX_LINE, drive, rotation)
    figure = new_figure(WIDTH_IN, 0.34 * len(lines) + 0.1)
    written = [
        figure.text(0.0, 1.0 - (i + 0.55) / len(lines), f"${line}$", fontsize=11 if slim else 12, va="center")
        for i, line in enumerate(lines)
    ]
    draw: Any = FigureCanvasAgg(figure)
    wide = max(text.get_window_extent(draw.get_renderer()).width for text in written)
    figure.set_figwidth(wide / figure.dpi + 0.1)
    return svg_text(figure, outlines=True)
