"""How large an effect is, in units of the smallest one that counts.

An effect counts when it moves the free run by half of what repeating the test does, or a reported number by two of its
standard errors: a dashpot can hide in the motion and double c.

Belongs here: that measure, for a direction in which the equation may be wrong. Does not belong here: whether an effect
is there (null_test.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from undertow.comparison.level import Level
from undertow.comparison.score_test import GridPlace, Stands
from undertow.likelihood.problem import TrialProblem
from undertow.recording.recording import Array

COUNTS_IN_REPEATABILITY = 0.5
"""Free-run error, in units of repeatability, from which on an effect counts."""

COUNTS_IN_STDERR = 2.0
"""The same of a reported number, in its standard errors."""

OWN = ("x0_m[", "v0_m_per_s[", "shift_s[", "rest_m[")
"""Begin the names of what a free run adjusts to its trial."""


@dataclass(frozen=True)
class Measure:
    """How large effects at one place are, for coefficients (width,): ``form`` (width, width) gives the squared
    free-run error in units of repeatability, ``shifts`` (numbers, width) what every reported number moves by, in units
    of what counts."""

    form: Array
    shifts: Array

    def of(self, coefficients: Array) -> Array:
        """Sizes of effects, coefficients (width, n) -> (n,); 1 is the smallest that counts."""
        moved = np.max(np.abs(self.shifts @ coefficients), axis=0, initial=0.0)
        return np.asarray(np.maximum(self.of_free_run(coefficients) / COUNTS_IN_REPEATABILITY, moved))

    def of_free_run(self, coefficients: Array) -> Array:
        """Free-run errors, in units of repeatability, of coefficients (width, n) -> (n,)."""
        square = np.einsum("wn,wv,vn->n", coefficients, self.form, coefficients)
        return np.asarray(np.sqrt(np.maximum(square, 0.0)))

    def bound(self, found: Array, spread: Array, deviations: float) -> float:
        """The largest free-run error, in units of what counts, that so many standard deviations leave about ``found``
        (width,) with covariance ``spread``."""
        width = math.sqrt(max(float(np.max(np.linalg.eigvals(self.form @ spread).real, initial=0.0)), 0.0))
        return (float(self.of_free_run(found[:, None])[0]) + deviations * width) / COUNTS_IN_REPEATABILITY


@dataclass(frozen=True)
class _Shown:
    """One trial as its free run is scored: the rows, an orthonormal basis of what is the trial's own there, the
    derivatives by what all trials share beside it, and the weight that turns a square into nrmse over repeatability."""

    rows: slice
    own: Array
    shared: Array
    weight: float


@dataclass(frozen=True)
class Sizes:
    """The measure on one level: repeatability a trial (nrmse), the standard error of every reported number by the name
    of its unknown in the level's fit, and the level's mean repeatability."""

    stands: Stands
    reported: Mapping[str, float]
    allowed: float
    shown: tuple[_Shown, ...]

    @classmethod
    def on(cls, level: Level, stands: Stands, reported: Mapping[str, float]) -> Sizes:
        """From a level, its fit and the standard errors of the numbers it reports (``name`` or ``name@spring``)."""
        allowed = {m.name: member.allowed for member in level.members for m in member.motions}
        solution = stands.fit.solution
        shown = tuple(
            _shown(trial, jac, used, solution.problem.names, reported, allowed[trial.name])
            for trial, jac, used in zip(solution.problem.trials, solution.jacobians, solution.used, strict=True)
        )
        mean = math.sqrt(float(np.mean([a**2 for a in allowed.values()])))
        return cls(stands, reported, mean, shown)

    def measure(self, place: GridPlace) -> Measure:
        """Sizes of the effects at one place: numbers that all trials share move as they do in the fit that lacks it,
        each trial's release, clock and rest as they do in its free run."""
        refit = self.stands.inverse @ place.cross
        form = np.zeros((place.width, place.width))
        for (columns, where), one in zip(place.columns, self.shown, strict=True):
            left = np.zeros((one.shared.shape[0], place.width))
            mine = columns[one.rows]
            left[:, where] = mine - one.own @ (one.own.T @ mine)
            left -= one.shared @ refit
            form += one.weight * (left.T @ left)
        return Measure(form / len(self.shown), self._shifts(refit))

    def _shifts(self, refit: Array) -> Array:
        names = self.stands.fit.solution.problem.names
        index = [i for i, name in enumerate(names) if self.reported.get(name, 0.0) > 0.0]
        errors = np.array([self.reported[names[i]] for i in index])
        moved = refit[index]
        return np.asarray(moved / (COUNTS_IN_STDERR * errors[:, None]), dtype=np.float64) if index else moved


def _shown(
    trial: TrialProblem, jac: Array, used: np.ndarray, names: Sequence[str], reported: Mapping[str, float],
    allowed: float,
) -> _Shown:  # fmt: skip
    n = trial.t.size
    channel = next((i for i, c in enumerate(trial.channels) if c.quantity in ("displacement", "velocity")), 0)
    rows = slice(channel * n, (channel + 1) * n)
    own = [c for c, j in enumerate(used.tolist()) if names[j].startswith(OWN)]
    wanted = [c for c, j in enumerate(used.tolist()) if names[j] in reported]
    basis = _basis(jac[rows][:, own])
    shared = np.zeros((n, len(names)))
    shared[:, used[wanted]] = jac[rows][:, wanted]
    seen = trial.channels[channel]
    size = float(np.mean((seen.values - np.mean(seen.values)) ** 2))
    weight = seen.sigma**2 / (n * size * allowed**2)
    return _Shown(rows, basis, shared - basis @ (basis.T @ shared), weight)


def _basis(columns: Array) -> Array:
    """Orthonormal columns with the same span."""
    scale = np.linalg.norm(columns, axis=0)
    left, values, _ = np.linalg.svd(columns[:, scale > 0.0] / scale[scale > 0.0], full_matrices=False)
    return np.asarray(left[:, values > 1e-9 * np.max(values, initial=0.0)])

