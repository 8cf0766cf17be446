"""Draws the documentation's pictures.

    python -m experiments pictures laws [TERM ...]     docs/pictures/laws/TERM.svg, some seconds each
    python -m experiments pictures tour                docs/pictures/tour/: runs configs/flume.yaml
    python -m experiments pictures page RUN            docs/pictures/page/, by Chromium from a run's page (page.py)
    python -m experiments pictures rooms               docs/pictures/rooms.svg, from the imports (rooms.py)

A law's picture: two releases of a body with the law, the equation without it whose other numbers are fitted to both,
and what is left. Belongs here: cases and figures. Does not belong here: fits and laws (undertow).
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import undertow
from experiments.pictures import rooms
from experiments.pictures.page import six
from undertow.campaign.run.course import run as run_campaign
from undertow.campaign.run.folder import Finished
from undertow.discrepancy.findings import Findings, TrialFindings
from undertow.equation.equation import Equation
from undertow.equation.registry import find, names
from undertow.errors import UndertowError
from undertow.front.terminal.verdicts import run_text
from undertow.front.trials import Trials
from undertow.report.extent import extent_of
from undertow.report.first_screen import shown_trial
from undertow.report.style import BLUE, INK, NOT_EXPLAINED, PALE, page_style, svg_text
from undertow.report.trial_curves import draw_errors, draw_runs_before_and_after

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"
CONFIG = Path(__file__).resolve().parents[2] / "configs" / "flume.yaml"

MASS_KG, RELEASES_M, DURATION_S, RATE_HZ, HOLD_S, NOISE_M = 2987.0, (0.04, 0.015), 5.0, 60.0, 0.5, 1e-5
BASE = {"stiffness": 404000.0, "viscous_damping": 1200.0}
"""A body of the virtual flume's size on its short spring: 1.85 Hz, 1.7 % of critical damping."""

CASES: dict[str, tuple[float, dict[str, float]]] = {
    "stiffness": (404000.0, {}), "viscous_damping": (1200.0, {}), "coulomb_friction": (300.0, {}),
    "added_mass": (350.0, {}), "added_stiffness": (20000.0, {}),
    "quadratic_drag": (15000.0, {}), "linear_damping": (2400.0, {}),
    "cubic_damping": (40000.0, {}), "asymmetric_damping": (900.0, {}), "asymmetric_drag": (6000.0, {}),
    "drag_exponent": (6000.0, {"exponent": 1.5}), "cubic_stiffness": (6e7, {}),
    "quintic_stiffness": (6e10, {}), "asymmetric_stiffness": (3e6, {}),
    "stiffness_drift": (-40000.0, {"time_s": 2.0}), "quadratic_stiffness": (3e6, {}),
    "sine_restoring": (404000.0, {}), "position_damping": (1e5, {}), "van_der_pol_damping": (6e6, {}),
    "stribeck_friction": (300.0, {"velocity_m_per_s": 0.03}), "asymmetric_friction": (300.0, {}),
    "variable_normal_force": (15000.0, {}),
    "hidden_resonator": (300.0, {"natural_frequency_rad_per_s": 9.6, "damping_ratio": 0.02}),
    "relaxation": (40000.0, {"time_s": 0.3}), "hysteresis": (60000.0, {"yield_displacement_m": 0.006}),
    "external_forcing": (300.0, {"frequency_rad_per_s": 7.0, "phase_rad": 1.0}),
    "changing_force": (
        300.0, {"frequency_rad_per_s": 7.0, "phase_rad": 1.0, "change_per_s": 0.2, "change_phase_rad": 3.5},
    ),
    "delayed_echo": (-1500.0, {"delay_s": 1.7}),
}  # fmt: skip
"""Each law's coefficient and inner parameters, large enough to be seen with the eye."""

INSTEAD: dict[str, tuple[str, ...]] = {
    "stiffness": ("stiffness",), "sine_restoring": (), "viscous_damping": ("viscous_damping",),
    "linear_damping": ("viscous_damping",),
}  # fmt: skip
"""What of the base a law takes the place of."""

KEPT = ("stiffness", "added_mass", "added_stiffness", "linear_damping", "viscous_damping")
"""Without these the other numbers are kept: fitted anew they would hide what is missing, or nothing would move."""


ANGLES_RAD = (0.9, 0.3)
"""Releases of the pendulum: its law is one of an angle."""


def with_law(name: str) -> Equation:
    """The body with one law, and the base's terms that it does not stand in for."""
    coefficient, inner = CASES[name]
    kept = {term: value for term, value in BASE.items() if term not in INSTEAD.get(name, ())}
    if name == "sine_restoring":
        kept.pop("stiffness")
    return Equation((*map(find, kept), find(name, **inner)), (*kept.values(), coefficient), mass_kg=MASS_KG)


def without_law(name: str, whole: Equation, trials: Trials) -> Equation:
    """The same without the law; its other numbers fitted to the trials, unless nothing would be left to see."""
    terms = tuple(t for t in whole.terms if t.name != name)
    values = tuple(c for t, c in zip(whole.terms, whole.coefficients, strict=True) if t.name != name)
    if name not in KEPT:
        try:
            return undertow.fit(trials, list(BASE), mass_kg=MASS_KG).equation
        except UndertowError as reason:
            print(f"{name}: {reason}; other numbers kept")
    return Equation(terms, values, mass_kg=MASS_KG)


def draw_absence(name: str) -> Figure:
    """Left the large release with the law and without it, right what is left of both releases, over the release."""
    whole = with_law(name)
    releases, shown, unit = (ANGLES_RAD, 1.0, "rad") if name == "sine_restoring" else (RELEASES_M, 1000.0, "mm")
    runs = [undertow.simulate(whole, x0=x0, rate_hz=RATE_HZ, duration_s=DURATION_S) for x0 in releases]
    trials = undertow.read([run.recorded(NOISE_M, HOLD_S, i, f"r{i}") for i, run in enumerate(runs)])
    without = without_law(name, whole, trials)
    figure = Figure(figsize=(8.0, 2.3), layout="constrained")
    left, right = figure.subplots(1, 2)
    for run, x0, colour, style in zip(runs, releases, (NOT_EXPLAINED, BLUE), ("-", "--"), strict=True):
        other = undertow.simulate(without, x0=x0, times=run.t)
        if x0 == releases[0]:
            left.plot(run.t, shown * run.x, color=INK, lw=1.2, label="with the law")
            left.plot(run.t, shown * other.x, color=BLUE, lw=0.9, ls="--", label="without")
        label = f"released at {shown * x0:g} {unit}"
        right.plot(run.t, 100.0 * (run.x - other.x) / x0, style, color=colour, lw=0.9, label=label)
    left.set_ylabel(f"displacement ({unit})")
    right.set_ylabel("what is left (% of release)")
    for axes in (left, right):
        axes.set_xlabel("time after release (s)")
        axes.margins(x=0.0)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
    return figure


def laws(chosen: Sequence[str] = ()) -> None:
    """A picture of every law's absence."""
    folder = PICTURES / "laws"
    folder.mkdir(parents=True, exist_ok=True)
    for name in chosen or names():
        with page_style():
            text = svg_text(draw_absence(name))
        (folder / f"{name}.svg").write_text(text, encoding="utf-8")
        print(name, flush=True)


def tour(findings: Findings) -> None:
    """The tour's pictures and the terminal's text, of one finished campaign."""
    folder = PICTURES / "tour"
    folder.mkdir(parents=True, exist_ok=True)
    shown = shown_trial(findings)
    if shown is None:
        raise UndertowError(f"{findings.name}: none of {len(findings.groups)} groups has a trial; run another config")
    _before_and_after(shown.trial, shown.group.label, folder / "before_and_after.svg")
    rows = [
        (g.label, g.verdict.baseline.nrmse, g.verdict.augmented.nrmse if g.verdict.augmented else np.nan,
         g.verdict.repeatability_nrmse)
        for g in findings.groups
    ]  # fmt: skip
    with page_style():
        figure = Figure(figsize=(8.0, 4.0), layout="constrained")
        draw_errors(rows, figure.subplots())
        (folder / "errors.svg").write_text(svg_text(figure), encoding="utf-8")
    text = run_text(Finished(Path("runs") / findings.name, findings, extent_of(findings)))
    (folder / "terminal.txt").write_text(text + "\n", encoding="utf-8")


def _before_and_after(trial: TrialFindings, label: str, path: Path) -> None:
    with page_style():
        figure = Figure(figsize=(8.0, 3.2), layout="constrained")
        axes = draw_runs_before_and_after(trial, figure.subplots())
        axes.set_title(f"{label}: a held-out trial" if trial.held_out else label)
        path.write_text(svg_text(figure), encoding="utf-8")


def draw_rooms() -> None:
    """The rooms and what they import, and the counts of import statements on the terminal."""
    found = rooms.arrows()
    with page_style():
        figure = rooms.draw(found, rooms.lines_of(), Figure(figsize=(5.4, 8.2), layout="constrained"), INK, PALE)
        (PICTURES / "rooms.svg").write_text(svg_text(figure), encoding="utf-8")
    for (room, target), count in sorted(found.items()):
        print(f"{room:12} imports {target:12} {count:4}")


def main() -> None:
    """Draw what is asked for."""
    words = sys.argv[1:]
    if words[:1] == ["rooms"]:
        draw_rooms()
    elif words[:1] == ["page"]:
        six(Path(words[1]))
    elif words[:1] == ["tour"]:
        from undertow.campaign.config import load

        tour(run_campaign(load(CONFIG)))
    else:
        laws(words[1:])
