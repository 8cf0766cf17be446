"""Trials that a sensor's range cut off: others that reach the same end of it, and what their group's verdict says.

Belongs here: those trials, that sentence and name. Does not belong here: how a cut is seen (recording/clipping.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.discrepancy.findings import FailedTrial, GroupFindings
from undertow.discrepancy.words import count
from undertow.errors import RangeEnd
from undertow.recording.recording import Recording

SHORT_OF = 0.25
"""An extreme that is further short of an end than this share of the end's band, two standard deviations of the noise,
was not cut there: a swing that is comes to the level with many samples."""


@dataclass(frozen=True)
class SeenEnd:
    """The end of a channel's range as a trial shows it."""

    trial: str
    channel: str
    end: RangeEnd

    def beyond(self, recording: Recording) -> float:
        """How far a trial's extreme lies beyond this end, in its band; NaN without the channel."""
        values = recording.channels.get(self.channel)
        if values is None:
            return math.nan
        sign = 1.0 if self.end.upper else -1.0
        return (sign * float(np.max(sign * values)) - self.end.value) * sign / self.end.band


def common(ends: Sequence[SeenEnd], recordings: Sequence[Recording]) -> tuple[SeenEnd, ...]:
    """The ends beyond which no trial goes: where one does, the range was another, or slow noise looked like a level."""
    return tuple(seen for seen in ends if not any(seen.beyond(one) > 1.0 for one in recordings))


def reached(recording: Recording, ends: Sequence[SeenEnd]) -> str:
    """Why a trial cannot be used whose sensor comes to the end of its range as seen in another; empty where it does
    not, or goes beyond: then its range was another."""
    for seen in ends:
        if -SHORT_OF <= (beyond := seen.beyond(recording)) <= 1.0:
            extreme = seen.end.value + (beyond if seen.end.upper else -beyond) * seen.end.band
            return (
                f"trial {recording.name}: {seen.channel} comes to {extreme:.6g} {recording.unit(seen.channel)}, where "
                f"it is clipped in trial {seen.trial}; widen the sensor's range, or list clipping in recordings.accept"
            )
    return ""


def with_clipped(config: RunConfig, group: GroupFindings, failed: Sequence[FailedTrial]) -> GroupFindings:
    """A group whose verdict says which further trials could not be used because a sensor was cut off in them.

    ``clipping`` is the verdict where nothing else is missing in the trials that are left; beside another name it is
    only said: what is named is in trials that nothing cut.
    """
    mine = [f.name for f in failed if f.clipped and config.group_key(f.conditions) == tuple(group.key.items())]
    if not mine:
        return group
    verdict = group.verdict
    rest = verdict.sentence.replace("; nothing is missing.", ".")
    said = (
        f"{rest} In {count(len(mine), 'further trial')} ({', '.join(mine)}) a sensor is cut off at the end "
        "of its range: not used."
    )
    verdict = replace(verdict, sentence=said)
    if verdict.status == "nothing_missing":
        verdict = replace(
            verdict, status="explained", verdict=("clipping",), origin="instrument", parameters={"clipping": {}},
            confidence=math.nan,
            next_test="the same releases with the sensor's range widened",
        )  # fmt: skip
    return replace(group, verdict=verdict)
