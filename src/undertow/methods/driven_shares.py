"""What driven records and decays of the same body tell each of an equation's numbers.

Belongs here: standard errors from either alone. Does not belong here: the fit to all (driven.py), words.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from undertow.conditioning.driven import DrivenTrial
from undertow.methods.driven import DrivenFit
from undertow.recording.recording import Array

UNTOLD = 1e4
"""A standard error so many times that of all trials together is none: what these trials leave open."""


@dataclass(frozen=True)
class Told:
    """Standard errors of one number from all trials, from those that are driven and from decays alone (inf: open)."""

    together: float
    driven: float
    decays: float


def shares_of(trials: Sequence[DrivenTrial], fitted: DrivenFit) -> Mapping[str, Told]:
    """Number -> what each kind of trial says of it, at the equation that was found; empty without decays.

    Of a decay alone forces are known per mass: it tells all of them once one of them, or the mass, is held.
    """
    if not any(trial.free for trial in trials):
        return {}
    free = {trial.name for trial in trials if trial.free}
    fitted_trials = list(enumerate(fitted.solution.problem.trials))  # in the fit's own order
    parts = ([i for i, t in fitted_trials if t.name not in free], [i for i, t in fitted_trials if t.name in free])
    together = np.sqrt(np.maximum(np.diag(fitted.covariance), 0.0))
    alone = [_errors(fitted, part) for part in parts]
    return {
        name: Told(float(e), *(float(one[i]) if one[i] < UNTOLD * e else math.inf for one in alone))
        for i, (name, e) in enumerate(zip(fitted.names, together, strict=True))
    }


def _errors(fitted: DrivenFit, chosen: Sequence[int]) -> Array:
    """Standard errors of the shared numbers by some of the trials, widened as those of all."""
    solution = fitted.solution
    unknowns = solution.problem.unknowns
    own = [i for i, u in enumerate(unknowns) if u.name in fitted.names]
    information = np.diag([1.0 / u.prior_std**2 if math.isfinite(u.prior_std) else 0.0 for u in unknowns])
    for i in chosen:
        used, columns = solution.used[i], solution.jacobians[i]
        information[np.ix_(used, used)] += columns.T @ columns
    scale = 1.0 / np.sqrt(np.maximum(np.diag(solution.covariance), np.finfo(float).tiny))
    both = np.outer(scale, scale)
    values, vectors = np.linalg.eigh(information / both)
    floor = np.finfo(float).eps * float(values[-1]) * values.size
    variance = (vectors**2 @ (1.0 / np.maximum(values, floor))) / scale**2
    whole = np.maximum(np.diag(solution.covariance)[own], np.finfo(float).tiny)
    widening = np.diag(fitted.covariance) / whole
    return np.asarray(np.sqrt(variance[own] * widening), dtype=np.float64)
