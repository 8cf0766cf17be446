"""Whether what is found beside a slow hook shows after the release too.

How a hook lets go nobody knows exactly: what it leaves of the first period may pass for another effect. A law that is
missing is missing in every cycle.

Belongs here: that check. Does not belong here: the hook (bad_release.py), the search (search.py).
"""

from __future__ import annotations

import math
from dataclasses import replace

from undertow.comparison.candidate import Candidate
from undertow.comparison.joint import fit_joint
from undertow.comparison.level import Level, from_later_on
from undertow.errors import IdentificationError

SHOWN = 4.0
"""By so much every number of an effect must lower -2 ln L where nothing is asked of the first period: two standard
errors."""


def shows_later(level: Level, candidate: Candidate) -> bool:
    """Whether the last effect beside a hook is worth its numbers where nothing is asked of the first period: the motion
    still begins at the release. True without a hook, and where too little is left to tell."""
    fit = candidate.fit
    others = [d for d in fit.addends if not d.hooked and d not in level.standing]
    if not others or not any(d.hooked for d in fit.addends):
        return True
    without = tuple(d for d in fit.addends if d is not others[-1])
    members = tuple(
        replace(m, motions=tuple(from_later_on(one, 1.0, one.window.held) for one in m.motions)) for m in level.members
    )
    later = replace(level, members=members, shared_water=fit.shared_water)
    try:
        one, other = (
            fit_joint(later, addends, fit.memory, fit.values, fit.misfit, growing=False)
            for addends in (fit.addends, without)
        )
    except IdentificationError:
        return True
    samples, more = one.solution.n_data / one.memory, len(one.values) - len(other.values)
    return other.criterion - one.criterion + more * math.log(max(samples, 2.0)) > SHOWN * more
