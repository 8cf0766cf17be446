"""SINDy with a measured input: the numbers of a driven equation by regression, from one record.

    M <w'', x> + sum_i c_i <w, force_i(x, v)> = <w, u>

by least squares over bumps w, the length of which is the one that knows the numbers best (weak SINDy: Messenger and
Bortz 2021, doi:10.1016/j.jcp.2021.110525). Errors are those of blocks of the record, and hold what bumps of another
length say. Inner numbers of laws, gain and delay of the input are those of output error. Noise of x makes columns
larger than they are, so that numbers of a noisy record are drawn to 0.

Belongs here: that estimate. Does not belong here: the weak form (driven_start.py), output error (driven.py).
"""

from __future__ import annotations

from undertow.conditioning.driven import DrivenTrial
from undertow.errors import IdentificationError
from undertow.methods.driven import DrivenFit
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
    found = regressed(trial, fitted, with_inner_numbers(fitted), trial.outputs)
    if found is None:
        raise IdentificationError(
            f"trial {trial.name}: {1 + len(fitted.laws.terms)} numbers are not told apart by regression; give a longer "
            "record, with motion at several speeds"
        )
    return found
