"""What a mismatch between a simulation and a recording is: one trial's residual, measured.

Belongs here: the frozen `Mismatch`, and where residuals stand in words. Does not belong here: how it is located
(place.py) or explained.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from undertow.discrepancy.words import percent

LINE_SHARE = 0.2
"""Share of the residual's variance from which a line, a law or a memory is worth a word."""


@dataclass(frozen=True)
class Mismatch:
    """Free-run residual of one trial against its group's baseline equation.

    ``nrmse`` is RMS error over RMS displacement in the motion window; ``sensor_floor_nrmse`` what the sensors alone
    give; ``repeatability_nrmse`` the 95 % quantile when k, c, mu vary from trial to trial. Shares are fractions of the
    residual's variance above noise: by third of the window, in its strongest line that is not the body's own, in a
    function of (x, v) alone, in memory of the motion, in a clock of its own; nan where not computed.
    """

    trial: str
    nrmse: float
    sensor_floor_nrmse: float
    repeatability_nrmse: float
    share_early: float = math.nan
    share_middle: float = math.nan
    share_late: float = math.nan
    line_frequency_hz: float = math.nan
    line_share: float = math.nan
    amplitude_exponent: float = math.nan
    static_share: float = math.nan
    memory_share: float = math.nan
    clock_share: float = math.nan

    @property
    def missing(self) -> bool:
        """Whether the equation leaves out something that scatter from trial to trial would not make."""
        return self.nrmse > self.repeatability_nrmse


def place_words(mismatches: Sequence[Mismatch]) -> str:
    """Where residuals stand, in words: when, in which line, how much is a law of the motion (means over trials); empty
    where nothing was computed.

    >>> place_words([Mismatch("a", 0.4, 0.01, 0.05, share_early=0.7, line_frequency_hz=1.6, line_share=0.5)])
    '70 % in the first third, 50 % in a line at 1.6 Hz'
    """
    parts = []
    thirds = {"first": "share_early", "second": "share_middle", "last": "share_late"}
    shares = {word: _mean(mismatches, name) for word, name in thirds.items()}
    known = {word: share for word, share in shares.items() if math.isfinite(share)}
    if known:
        most = max(known, key=lambda word: known[word])
        parts.append(f"{percent(known[most])} in the {most} third")
    line = _mean(mismatches, "line_share")
    if line > LINE_SHARE:
        parts.append(f"{percent(line)} in a line at {_mean(mismatches, 'line_frequency_hz'):.3g} Hz")
    for name, words in (
        ("static_share", "as a function of displacement and speed"), ("memory_share", "as memory of the motion"),
        ("clock_share", "with a clock of its own"),
    ):  # fmt: skip
        share = _mean(mismatches, name)
        if share > LINE_SHARE:
            parts.append(f"{percent(share)} {words}")
    return ", ".join(parts)


def _mean(mismatches: Sequence[Mismatch], name: str) -> float:
    """Mean of a number over the trials in which it was computed; nan without one."""
    finite = [value for m in mismatches if math.isfinite(value := getattr(m, name))]
    return sum(finite) / len(finite) if finite else math.nan
