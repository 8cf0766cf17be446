"""SINDy with a measured input: the numbers of a driven equation by regression, from one record.

    M <w'', x> + sum_i c_i <w, force_i(x, v)> = <w, u>

by least squares over bumps w (weak SINDy: Messenger and Bortz 2021, doi:10.1016/j.jcp.2021.110525), of the length
whose numbers follow the record best in free runs over windows. Errors are those of blocks of the record, and hold what
bumps of another length say. Inner numbers of laws, gain and delay of the input are those of output error. Noise of x
makes columns larger than they are, so that numbers of a noisy record are drawn to 0.

Belongs here: that estimate. Does not belong here: the weak form (driven_start.py), output error (driven.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from undertow.conditioning.driven import DrivenTrial
from undertow.errors import IdentificationError
from undertow.likelihood.driven import MASS, drive_for
from undertow.methods.driven import FIRST_SAMPLES, DrivenFit, window_cost
from undertow.methods.driven_instrument import regressed, with_inner_numbers
from undertow.quantities import Estimate


def by_regression(trial: DrivenTrial, fitted: DrivenFit) -> dict[str, Estimate]:
    """The mass and each law's coefficient, by the names of the fit, of which it takes what is held.

    Raises IdentificationError where the trial is a decay or was recorded as acceleration alone, a law has a state of
    its own, or the record does not tell the numbers apart.
    """
    if trial.free:
        raise IdentificationError(
            f"trial {trial.name}: nothing drives it; regression with an input needs one, output error takes both"
        )
    if trial.main == "acceleration":
        raise IdentificationError(
            f"trial {trial.name}: acceleration alone is recorded; regression needs displacement or velocity: map one"
        )
    states = [term.name for term in fitted.laws.terms if term.kind in ("state", "delay")]
    if states:
        raise IdentificationError(
            f"trial {trial.name}: {', '.join(states)} has a state of its own, which no column shows; take the numbers "
            "of output error"
        )
    short = trial.part(0, min(trial.t.size, FIRST_SAMPLES))
    drives = {trial.name: drive_for(trial)}

    def missed(numbers: Mapping[str, float]) -> float:
        """By how much free runs over windows miss the record with these numbers; inf where they are no body's."""
        tried = {**fitted.laws.starts, **fitted.numbers, **numbers}
        if not tried[MASS] > 0.0:
            return math.inf
        try:
            return window_cost(short, replace(fitted.laws, starts=tried), drives)
        except IdentificationError:
            return math.inf

    found = regressed(trial, fitted, with_inner_numbers(fitted), trial.outputs, missed)
    if found is None:
        raise IdentificationError(
            f"trial {trial.name}: {1 + len(fitted.laws.terms)} numbers are not told apart by regression; give a longer "
            "record, with motion at several speeds"
        )
    return found
