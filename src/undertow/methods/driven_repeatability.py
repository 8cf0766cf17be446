"""How much driven trials of one body differ although nothing is wrong: by a stated scatter of its numbers, or as seen
in trials that the same input drove.

Belongs here: both. Does not belong here: which of them a campaign uses (campaign/driven/beside.py), decays
(likelihood/free_run.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from undertow.conditioning.driven import DrivenTrial
from undertow.errors import IdentificationError
from undertow.likelihood.driven import drive_for
from undertow.likelihood.free_run import DRAWS, REPEATABILITY_QUANTILE
from undertow.methods.driven import DrivenFit, motion_from
from undertow.methods.driven_begin import START_SAMPLES, begin_of
from undertow.recording.recording import Array

SCATTERED = {"viscous_damping": "c", "coulomb_friction": "mu"}
"""Law -> entry of ``specimen.scatter`` that is of it; that of k is of every spring."""
SAME_INPUT = 0.02
"""Inputs of two trials are the same where they differ by no more than this share of their size (rms): noise of a load
cell, not another signal."""


def scattered(fitted: DrivenFit, scatter: Mapping[str, float]) -> dict[str, float]:
    """Relative standard deviations, by the names of the numbers that a ``scatter`` of k, c and mu is of."""
    out = {}
    for term in fitted.laws.terms:
        share = scatter.get("k" if term.is_spring else SCATTERED.get(term.name, ""), 0.0)
        if share > 0.0:
            out[f"{term.name}.{term.coefficient.name}"] = share
    return out


def repeatability_by_scatter(
    trial: DrivenTrial, fitted: DrivenFit, scatter: Mapping[str, float], floor: float, seed: int
) -> float:
    """95 % quantile of nrmse for the same equation, input and start when its numbers vary as ``scatter`` says.

    ``floor`` is the sensor's, added in quadrature. Draws whose motion leaves every bound are left out.
    """
    spread, usual_numbers = scattered(fitted, scatter), fitted.numbers
    if not spread:
        return floor
    generator, drive = np.random.default_rng(seed), drive_for(trial)
    begin = begin_of(trial, fitted.laws, usual_numbers, drive, START_SAMPLES)
    usual = motion_from(trial, fitted.laws, usual_numbers, begin.state, drive)
    size = float(np.std(trial.outputs[trial.main]))
    errors = []
    for _ in range(DRAWS):
        factors = {name: max(1.0 + share * generator.standard_normal(), 0.0) for name, share in spread.items()}
        moved = {name: factor * usual_numbers[name] for name, factor in factors.items()}
        try:
            other = motion_from(trial, fitted.laws, {**usual_numbers, **moved}, begin.state, drive)
        except IdentificationError:
            continue
        errors.append(_rms(other - usual) / size)
    return math.hypot(float(np.quantile(errors, REPEATABILITY_QUANTILE)), floor) if errors else floor


def repeatability_by_repeats(trials: Sequence[DrivenTrial]) -> dict[str, float]:
    """By trial: how far it is from the others that the same input drove, as nrmse of a motion in the middle of each two
    of them (their difference over the root of 2), the largest. Trials whose input nobody repeated have none.
    """
    out: dict[str, float] = {}
    for trial in trials:
        x = trial.outputs[trial.main]
        others = [other.outputs[trial.main] for other in trials if _same_input(trial, other)]
        apart = [_rms(x - other) / math.sqrt(2.0) for other in others]
        if apart:
            out[trial.name] = max(apart) / float(np.std(x))
    return out


def _same_input(one: DrivenTrial, other: DrivenTrial) -> bool:
    """Whether two driven trials had the same input, sample by sample, and the same output was recorded."""
    if one is other or one.free or other.free or one.main != other.main or one.t.size != other.t.size:
        return False
    if not math.isclose(one.rate_hz, other.rate_hz, rel_tol=1e-6):
        return False
    return _rms(one.u - other.u) <= SAME_INPUT * _rms(one.u)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
