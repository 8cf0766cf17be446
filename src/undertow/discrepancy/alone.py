"""The one trial of a group whose own motion the group's equation does not follow: a file that is not what it seems.

With k, c, mu of its own a trial of the same rig is followed down to its sensors' noise; one that was filtered, lost
samples or was knocked is not, and may still be as close to its group as repetitions are.

Belongs here: that trial. Does not belong here: trials of another period or scale (campaign/run/), what all trials leave
(wandering.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from undertow.comparison.joint import JointFit, fit_joint
from undertow.comparison.level import make_level
from undertow.comparison.limits import FAR_ABOVE_NOISE
from undertow.discrepancy.case import Case
from undertow.discrepancy.wandering import left_shares
from undertow.discrepancy.words import percent
from undertow.errors import IdentificationError

STANDS_OUT = 4.0
"""Twice as far above the sensors' noise as the next trial is (in variance four times) stands out."""

FEWEST = 3
"""Trials of which one can stand out."""

LARGEST = 1.05
"""Times the next release by which one is the largest: what it meets that no other does may be physics (a stop)."""


@dataclass(frozen=True)
class Alone:
    """A trial's ``name``, the ``share`` of its motion that is left, what is left over its noise, in variance, and
    whether it is the ``largest`` release of its group; ``own`` says which numbers were its own."""

    name: str
    share: float
    misfit: float
    largest: bool = False
    own: str = "k, c and mu"

    @property
    def words(self) -> str:
        """The same as a reason, with what to do."""
        meets = "; being the largest release it may meet what no other does, as a stop" if self.largest else ""
        return (
            f"{self.own} of its own leave {percent(self.share)} of the motion of trial {self.name}, "
            f"{math.sqrt(self.misfit):.3g} times its sensors' noise, and far less of the others: look at its file "
            f"(filtered, samples lost, a knock), or leave it out (recordings.exclude){meets}"
        )


def one_alone(case: Case, null: JointFit) -> Alone | None:
    """The trial of a group, fitted or held out, of which the equation leaves more than noise with k, c, mu of the
    trial's own, and far more than of any other; None where there is none."""
    mine = {motion.name for motion in case.member.motions}
    own = [Alone(n, share, null.misfits[n]) for n, share in left_shares(null).items() if n in mine]
    own += _held(case, null)
    if len(own) < FEWEST:
        return None
    first, second, *_ = sorted(own, key=lambda one: -one.misfit)
    if first.misfit <= max(FAR_ABOVE_NOISE, STANDS_OUT * second.misfit):
        return None
    sizes = {motion.name: motion.amplitude for motion in (*case.member.motions, *case.held)}
    return replace(first, own=case.own, largest=sizes.pop(first.name) > LARGEST * max(sizes.values()))


def _held(case: Case, null: JointFit) -> list[Alone]:
    """The held-out trials as fitted beside the group's equation; none where they give no motion."""
    if not case.held:
        return []
    level = make_level([replace(case.member, motions=case.held)], null.addends)
    try:
        fit = fit_joint(level, null.addends, null.memory, null.values, null.misfit, growing=False)
    except IdentificationError:
        return []
    return [Alone(name, share, fit.misfits[name]) for name, share in left_shares(fit).items()]
