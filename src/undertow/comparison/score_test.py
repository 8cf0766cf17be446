"""What a suspect could gain at most, seen from where the fit stands: one linear step instead of a search.

Where the equation already explains the motion nearly as well as repetitions would, an addition can only be small. Its
gain is then that of one Gauss-Newton step in its coefficients (a score test), over a fine grid of what it has inside
(frequency, damping, time); only what could matter is fitted. The best places of the grid are the fit's starts.

Belongs here: that step. Does not belong here: fits (joint.py), the search (search.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.comparison.joint import JointFit
from undertow.comparison.level import Level, full_name
from undertow.comparison.suspect import Addition, Suspect
from undertow.equation.kernel import SLOT
from undertow.likelihood import output_error
from undertow.likelihood.problem import Link, TrialProblem
from undertow.recording.recording import Array

TINY = 1e-6
"""Share of its scale at which a coefficient stands that the integrator would skip at zero."""

SKIPPED_AT_ZERO = frozenset({"ge"})
"""Slots without whose value the integrator leaves out the whole law, its sensitivity too."""


@dataclass(frozen=True)
class Prospect:
    """One place of a suspect's grid: its additions starting there, and by how much the log evidence could rise."""

    additions: tuple[Addition, ...]
    gain: float


def prospects(
    level: Level, fit: JointFit, suspect: Suspect, grid: Sequence[tuple[Addition, ...]]
) -> tuple[Prospect, ...]:
    """The peaks of a suspect's possible gain over its ``grid`` of additions, the best first; gain before any penalty.

    ``fit`` is what stands; a place where the motion leaves every bound counts nothing.
    """
    stands = _Stands.of(fit)
    if suspect.frees:
        return (Prospect((), stands.gain_without_prior(f"{suspect.frees}[")),)
    found = [_prospect(level, stands, place) for place in grid]
    gains = [p.gain for p in found]
    peaks = [p for i, p in enumerate(found) if p.gain >= max(gains[max(0, i - 1) : i + 2])]
    return tuple(sorted(peaks, key=lambda p: -p.gain))


@dataclass(frozen=True)
class _Stands:
    """The fit that stands: its trials, each trial's parameter vector and Jacobian, the inverse of its normal matrix."""

    fit: JointFit
    normal: Array
    inverse: Array
    gradient: Array

    def gain_without_prior(self, prefix: str) -> float:
        """By how much the log evidence could rise if the unknowns of that prefix had no prior to hold them."""
        unknowns = self.fit.solution.problem.unknowns
        freed = np.array([u.prior_std**-2 if u.name.startswith(prefix) else 0.0 for u in unknowns])
        away = self.fit.solution.values - np.array([u.start for u in unknowns])
        gradient = self.gradient - freed * away
        normal = self.normal - np.diag(freed)
        scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
        inverse = np.linalg.pinv(normal * np.outer(scale, scale), rcond=1e-12, hermitian=True)
        slope = scale * gradient
        return 0.5 * float(freed @ away**2) + max(0.5 * float(slope @ inverse @ slope), 0.0)

    @classmethod
    def of(cls, fit: JointFit) -> _Stands:
        """From a fit's Jacobians and residuals, priors included."""
        solution = fit.solution
        unknowns = solution.problem.unknowns
        precision = np.array([1.0 / u.prior_std**2 for u in unknowns])
        normal = np.diag(precision)
        gradient = precision * (solution.values - np.array([u.start for u in unknowns]))
        for jac, r, used in zip(solution.jacobians, solution.residuals, solution.used, strict=True):
            normal[np.ix_(used, used)] += jac.T @ jac
            gradient[used] += jac.T @ r
        scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
        inverse = np.linalg.pinv(normal * np.outer(scale, scale), rcond=1e-12, hermitian=True)
        return cls(fit, normal, inverse * np.outer(scale, scale), gradient)


def _prospect(level: Level, stands: _Stands, additions: tuple[Addition, ...]) -> Prospect:
    """One Gauss-Newton step in the coefficients of one place, everything that stands moving along."""
    solution = stands.fit.solution
    names = _coefficient_names(level, additions)
    old = len(solution.values)
    cross, own, slope = np.zeros((old, len(names))), np.zeros((len(names), len(names))), np.zeros(len(names))
    for place, trial in enumerate(solution.problem.trials):
        reduced = _reduced(level, trial, solution.values, additions, names)
        got = output_error.residuals(reduced, np.zeros(len(names)))
        if got is None or not np.all(np.isfinite(got[1])):
            return Prospect(additions, 0.0)
        _, columns, used = got
        cross[np.ix_(solution.used[place], used)] += solution.jacobians[place].T @ columns
        own[np.ix_(used, used)] += columns.T @ columns
        slope[used] += columns.T @ solution.residuals[place]
    schur = own - cross.T @ stands.inverse @ cross
    slope = slope - cross.T @ stands.inverse @ stands.gradient
    scale = 1.0 / np.sqrt(np.maximum(np.diag(own), 1e-300))
    step = -scale * (np.linalg.pinv(schur * np.outer(scale, scale), rcond=1e-6, hermitian=True) @ (scale * slope))
    started = tuple(a if a.inner else replace(a, start=_start(a, names, step)) for a in additions)
    return Prospect(started, max(-0.5 * float(slope @ step), 0.0))


def _coefficient_names(level: Level, additions: tuple[Addition, ...]) -> list[str]:
    """Names of a place's coefficients: shared ones, each spring's, each trial's."""
    found: dict[str, None] = {}
    for member in level.members:
        for motion in member.motions:
            for a in additions:
                if not a.inner:
                    found[full_name("", a, member.label, motion.name)] = None
    return list(found)


def _reduced(
    level: Level, trial: TrialProblem, values: Array, additions: tuple[Addition, ...], names: list[str]
) -> TrialProblem:
    """A trial where it stands, with the place's coefficients as its only unknowns."""
    member = next(m for m in level.members if any(motion.name == trial.name for motion in m.motions))
    theta = output_error.parameter_vector(trial, values)
    links = []
    for a in additions:
        if a.inner:
            theta[SLOT[a.slot]] = a.start
        else:
            theta[SLOT[a.slot]] += TINY * a.scale if a.slot in SKIPPED_AT_ZERO else 0.0
            index = names.index(full_name("", a, member.label, trial.name))
            links.append(Link(SLOT[a.slot], index))
            if a.also is not None:
                links.append(Link(SLOT[a.also[0]], index, a.also[1]))
    late = values[trial.shift] if trial.shift >= 0 else 0.0
    channels = tuple(replace(c, offset=-1, drift=-1, shift=-1, gain=-1) for c in trial.channels)
    return replace(trial, t=trial.t + late, base=theta, links=tuple(links), channels=channels, shift=-1)


def _start(a: Addition, names: list[str], step: Array) -> float:
    """Where the step leads a coefficient (the largest of a spring's or a trial's own), inside its bounds."""
    steps = [s for name, s in zip(names, step, strict=True) if name.split("@")[0].split("[")[0] == f".{a.name}"]
    largest = max(steps, key=abs, default=a.start)
    low = a.lower if a.lower != 0.0 else 1e-3 * a.scale
    return float(min(max(largest, low), a.upper))
