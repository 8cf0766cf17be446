"""Suspects of the release: a speed that it gave, a hook that lets go slowly, a hold that fades in some way of its own.

Belongs here: these three. Does not belong here: all others (suspects.py), the hook's motion (equation/kernel.py).
"""

from __future__ import annotations

import math
from dataclasses import replace

from undertow.comparison.suspect import HOOK, Addition, Scales, Suspect

LONGEST, SHORTEST = 0.7, 1e-4
"""Periods in which a hook lets go at most, a decay being hardly one else, and at least."""

SHORT = 0.03
"""Periods in which a hook lets go from which a fit begins, near a sudden release: from a tenth of a period, beside a
resonator whose first fit had made good for the hook, it went elsewhere."""

STEEPEST = 6.0
"""Exponent of a hook's force at most: an exponential's first and largest part."""


def nothing(s: Scales, start: float) -> tuple[Addition, ...]:
    """No unknowns of its own."""
    return ()


def _speed(s: Scales, start: float) -> tuple[Addition, ...]:
    """Each trial's own speed at the release."""
    return (Addition("velocity_m_per_s", "m/s", "v0", 0.0, 0.02 * s.speed, scope="trial"),)


def _hook(s: Scales, start: float) -> tuple[Addition, ...]:
    """The time in which the hook lets go, in every trial its own."""
    period = 2.0 * math.pi / s.slowest
    least, most = SHORTEST * period, LONGEST * period
    return (Addition("release_time_s", "s", HOOK, start, 0.3 * start, least, most, scope="trial"),)


def _bent(s: Scales, start: float) -> tuple[Addition, ...]:
    """The same with an exponent of how it lets go, one for all trials: a magnet's force fades fast at first."""
    return (*_hook(s, SHORT * 2.0 * math.pi / s.rate), Addition("exponent", "1", "let_go_p", 1.5, 0.3, 1.0, STEEPEST))


_RELEASE = Suspect(
    "imperfect_release", "outside", _speed, words="a release that was not sudden or that a filter rounded",
    next_test="the load at the release, recorded at the full rate",
)  # fmt: skip

BAD_RELEASES: tuple[Suspect, ...] = (
    _RELEASE,
    replace(
        _RELEASE, additions=_hook, starts=lambda s: (SHORT * 2.0 * math.pi / s.rate,),
        variant="a hook that lets go slowly", wider=(_bent,),
    ),
    replace(_RELEASE, additions=nothing, variant="a hold that fades", late=1.0),
)  # fmt: skip
"""In the order in which they are tried: a hold that fades asks nothing of the first period."""
