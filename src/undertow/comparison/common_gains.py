"""Errors of numbers where one sensor recorded all trials: its gain is off by the same in each.

A fit believes each trial's gain to be right within `GAIN_STD` by itself, so that many trials seem to average it out.
A laboratory that calibrated a sensor once has one error in all of them: a force that is .3 % too small is so in each.

Belongs here: that covariance. Does not belong here: the fit (joint.py), errors of descriptions (by_trials.py).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from undertow.comparison.joint import JointFit

GAINS = ("displacement_gain[", "acceleration_gain[")
"""Begin the names of what a sensor's gain may be off by in a trial."""


def with_common_gains(fit: JointFit) -> JointFit:
    """The fit with the covariance of its numbers where each sensor's gain errs by the same in all trials.

    With C the covariance that takes gains as independent and s their standard deviation, a number moves by C / s^2 with
    the centre of one gain's prior: S = C[:, gains] / s is what their errors add, C = ... + S S', and with one error for
    all of them it is the square of the sum. A gain that is suspected, with a prior as wide as an error, is measured and
    not believed: nothing is added.
    """
    solution = fit.solution
    unknowns, covariance = solution.problem.unknowns, solution.covariance
    freed = {f"{addend.frees}[" for addend in fit.addends if addend.frees}
    more = np.zeros_like(covariance)
    for kind in (k for k in GAINS if k not in freed):
        mine = [i for i, u in enumerate(unknowns) if u.name.startswith(kind) and math.isfinite(u.prior_std)]
        moved = covariance[:, mine] / np.array([unknowns[i].prior_std for i in mine])
        together = np.sum(moved, axis=1)
        more += np.outer(together, together) - moved @ moved.T
    return replace(fit, solution=replace(solution, covariance=covariance + more))
