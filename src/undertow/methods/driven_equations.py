"""A driven equation as plain values and back, and its free run with a band: what `predict` reads and gives.

Belongs here: equations.json's entry of one version, the band. Does not belong here: files, words.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_laws import find_driven
from undertow.equation.driven_slots import DRIVEN_SLOT
from undertow.equation.input import MotionSize
from undertow.likelihood.driven import DrivenLaws, drive_for, driven_problem, extent_of
from undertow.likelihood.driven_strokes import STATE, Reach, variance_by_stroke
from undertow.likelihood.output_error import fit, parameter_vector
from undertow.likelihood.problem import Problem
from undertow.methods.driven import DrivenFit
from undertow.quantities import format_number, mover_of
from undertow.recording.recording import Array

RIGHT_HAND_SIDE = {
    "force": "F(t)",
    "base": "-M y''(t), x relative to the base at y, laws of the water at x' + y'",
    "water": "0, laws of the water at x' - u(t), x'' - u'(t)",
}
"""What an equation is equal to, by what drives."""

BAND_90 = 1.645
"""Standard errors either side that hold 90 % of a Gaussian."""
GROWTH = 2.0
"""Power of the motion's size with which what a free run misses grows beyond training: that of a law of x^2 or v|v|;
friction's grows less, a cubic spring's more. Set on 32 bodies that lack a law (experiments.driven.bands --calibration):
with 1 their bands held 84 % at 1.5 times the force, with 2 90 %; on other bodies docs/driven_measured.md."""


@dataclass(frozen=True)
class DrivenEquation:
    """An equation with its numbers: laws (all numbers as starts), names, values, covariance; ``error`` the rms of its
    free run on samples that nobody fitted, at motions of the rms ``motion``; ``noise`` the main output's, ``extent``
    how far and fast the body moved, ``noises`` those of all outputs. ``spreads`` are the standard deviations of offset
    and friction from stroke to stroke, N, as wide as few strokes make them; ``error`` is then what is missed beyond
    them."""

    laws: DrivenLaws
    names: tuple[str, ...]
    values: Array
    covariance: Array
    error: float
    motion: float
    noise: float
    extent: MotionSize
    noises: Mapping[str, float] = field(default_factory=dict)
    spreads: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False, repr=False)
class DrivenPrediction:
    """The free run (n,), its standard error (n,), and how many samples its start was taken from."""

    values: Array
    stderr: Array
    start: int

    def __repr__(self) -> str:
        return (
            f"free run of {self.values.size} samples, started from the first {self.start}, with a 90 % band of "
            f"+- {BAND_90 * float(np.mean(self.stderr)):.3g} on average"
        )

    @property
    def lower(self) -> Array:
        """Lower end of the 90 % band."""
        return self.values - BAND_90 * self.stderr

    @property
    def upper(self) -> Array:
        """Upper end of the 90 % band."""
        return self.values + BAND_90 * self.stderr


def written(fitted: DrivenFit, error: float, motion: float, trial: DrivenTrial) -> dict[str, Any]:
    """One version of equations.json: law rows, values in full precision, covariance, error of the free run."""
    numbers, extent = fitted.numbers, extent_of(trial)
    errors = {name: one.stderr for name, one in fitted.estimates.items()}
    rows = [
        {
            "term": place.term.name, "law": place.term.law, "parameter": place.parameter.name, "name": place.name,
            "unit": place.parameter.unit, "value": numbers[place.name], "stderr": errors.get(place.name, 0.0),
            "held": place.name in fitted.laws.fixed, "relative_to": place.term.relative_to,
        }
        for place in fitted.laws.places
    ]  # fmt: skip
    varying = fitted.strokes
    return {
        "terms": [term.name for term in fitted.laws.terms], "mass_kg": numbers["mass_kg"], "rows": rows,
        "names": list(fitted.names), "values": fitted.values.tolist(), "covariance": fitted.covariance.tolist(),
        "fixed": dict(fitted.laws.fixed), "free_run_error": error, "motion_rms": motion, "outcome": fitted.outcome,
        "input": trial.quantity, "frames": dict(trial.frames), "noise": trial.noise()[trial.main],
        "noises": trial.noise(), "extent": [extent.size, extent.speed],
        "by_stroke": None if varying is None else {
            "offset_N": varying.offset_N, "friction_N": varying.friction_N, "spreads_N": list(varying.spreads),
            "free_run_error_beyond": varying.beyond,
        },
    }  # fmt: skip


def read_back(entry: Mapping[str, Any]) -> DrivenEquation:
    """The equation of a version of equations.json."""
    values = np.array(entry["values"], dtype=np.float64)
    terms = tuple(find_driven(name) for name in entry["terms"])
    names = tuple(entry["names"])
    starts = dict(zip(names, values.tolist(), strict=True))
    laws = DrivenLaws(terms, dict(entry["fixed"]), starts)
    covariance = np.array(entry["covariance"], dtype=np.float64).reshape(values.size, values.size)
    varying = entry.get("by_stroke")
    error = varying["free_run_error_beyond"] if varying else entry["free_run_error"]
    return DrivenEquation(
        laws, names, values, covariance, float(error), float(entry["motion_rms"]), float(entry["noise"]),
        MotionSize(*entry["extent"]), entry.get("noises", {}),
        tuple(varying["spreads_N"]) if varying else (0.0, 0.0),
    )  # fmt: skip


def predict_driven(trial: DrivenTrial, equation: DrivenEquation, start: int) -> DrivenPrediction:
    """The free run from the trial's first ``start`` samples, with its standard error.

    The error holds the numbers' covariance, the start state's, what offset and friction differ by from stroke to
    stroke, and what the free run missed on samples nobody fitted, enlarged where this trial moves further than those.
    Raises IdentificationError where the motion has no bounds.
    """
    from undertow.equation.driven import driven_motion

    held = replace(equation.laws, fixed={**equation.laws.fixed, **equation.laws.starts}, starts={})
    drives = {trial.name: drive_for(trial)}
    noise = {trial.name: {name: equation.noises.get(name, equation.noise) for name in trial.outputs}}
    extents = {trial.name: equation.extent}
    problem = driven_problem([trial], held, 1, noise, drives, extents)
    piece = problem.trials[0]
    few = replace(
        piece, t=piece.t[:start], channels=tuple(replace(c, values=c.values[:start]) for c in piece.channels)
    )
    found = fit(Problem(problem.unknowns, (few,)), growing=False)
    theta = parameter_vector(piece, found.values)
    own = driven_problem([trial], equation.laws, 1, noise, drives, extents)
    links = [link for link in own.trials[0].links if own.unknowns[link.unknown].name in equation.names]
    slots = np.array(sorted({link.slot for link in links} | {link.slot for link in piece.links}), dtype=np.int64)
    motion = driven_motion(theta, slots, drives[trial.name], piece.t, piece.extent)
    column = {"displacement": motion.x, "velocity": motion.v, "acceleration": motion.a}[trial.main]
    place = {int(slot): 1 + i for i, slot in enumerate(slots)}
    by_number = np.zeros((trial.t.size, len(equation.names)))
    for link in links:
        index = equation.names.index(own.unknowns[link.unknown].name)
        by_number[:, index] += link.factor * column[:, place[link.slot]]
    by_start = np.column_stack([column[:, place[link.slot]] for link in piece.links])
    order = [link.unknown for link in piece.links]
    variance = np.einsum("ij,jk,ik->i", by_number, equation.covariance, by_number)
    variance += np.einsum("ij,jk,ik->i", by_start, found.covariance[np.ix_(order, order)], by_start)
    if any(equation.spreads):
        state = np.array([theta[DRIVEN_SLOT[name]] for name in STATE])
        reach = Reach(trial, held, (), drives[trial.name])
        variance += variance_by_stroke(reach, held.fixed, state, equation.spreads)
    wider = max(1.0, float(np.std(column[:, 0])) / equation.motion) if equation.motion > 0.0 else 1.0
    white = min(equation.noise, equation.error) ** 2  # noise does not grow with the motion, what a law lacks does
    missed = (equation.error**2 - white) * wider ** (2.0 * GROWTH)
    stderr = np.sqrt(np.maximum(variance, 0.0) + white + missed)
    return DrivenPrediction(np.array(column[:, 0]), stderr, start)


def simulate_driven(trial: DrivenTrial, equation: DrivenEquation, x0: float, v0: float) -> Array:
    """Displacement (n,) under the trial's input from ``x0`` and ``v0`` (relative to a base that moves), in SI.

    Of the trial's outputs nothing is used. Raises IdentificationError where the motion has no bounds.
    """
    from undertow.equation.driven import driven_motion

    held = replace(equation.laws, fixed={**equation.laws.fixed, **equation.laws.starts}, starts={})
    drive = drive_for(trial)
    noise = {trial.name: dict.fromkeys(trial.outputs, equation.noise)}
    problem = driven_problem([trial], held, 1, noise, {trial.name: drive}, {trial.name: equation.extent})
    theta = parameter_vector(problem.trials[0], problem.believed[0])
    theta[[DRIVEN_SLOT[name] for name in STATE]] = x0, v0
    none = np.zeros(0, dtype=np.int64)
    return np.array(driven_motion(theta, none, drive, problem.trials[0].t, equation.extent).x[:, 0])


def equation_text(entry: Mapping[str, Any], precision: int | None = None) -> str:
    """The equation in one line with its numbers and standard errors, or its numbers with ``precision`` decimals.

    >>> equation_text({"mass_kg": 2.0, "names": [], "covariance": [], "rows": []})
    "M x'' = F(t), M = 2"
    """
    laws = list(dict.fromkeys(row["law"] for row in entry["rows"]))
    numbers = [
        f"{row['name']} = {_number(row['value'], row['stderr'], precision)} {row['unit']}".strip()
        for row in entry["rows"]
    ]
    said = f"{entry['mass_kg']:.6g}" if precision is None else f"{entry['mass_kg']:.{precision}f}"
    if "mass_kg" in entry["names"]:
        index = list(entry["names"]).index("mass_kg")
        said = _number(entry["mass_kg"], math.sqrt(entry["covariance"][index][index]), precision)
    left = " + ".join(["M x''", *laws]).replace("+ -", "- ")
    right = RIGHT_HAND_SIDE[mover_of(entry.get("input", "force"))]
    return "; ".join([f"{left} = {right}, M = {said}", *numbers])


def _number(value: float, error: float, precision: int | None) -> str:
    """A number with its standard error, digits as this allows; or with so many decimals, without it.

    >>> _number(0.000139691, 0.00064, None), _number(89995.5, 6.4, None), _number(89995.5, 6.4, 2)
    ('0.0001 +- 0.0006', '89996 +- 6', '89995.50')
    """
    if precision is not None:
        return f"{value:.{precision}f}"
    return f"{format_number(value, error)} +- {format_number(error, error)}"
