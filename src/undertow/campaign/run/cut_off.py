"""Trials that a sensor's range cut off: others that reach the same end of it, and what their group's verdict says.

Belongs here: those trials, that sentence and name. Does not belong here: how a cut is seen (recording/quality.py).
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


@dataclass(frozen=True)
class SeenEnd:
    """The end of a channel's range as a trial shows it."""

    trial: str
    channel: str
    end: RangeEnd


def reached(recording: Recording, ends: Sequence[SeenEnd]) -> str:
    """Why a trial cannot be used whose sensor comes to the end of its range as seen in another; empty where it does
    not, or goes beyond: then its range was another."""
    for seen in ends:
        values, end = recording.channels.get(seen.channel), seen.end
        if values is None:
            continue
        extreme = float(np.max(values) if end.upper else np.min(values))
        if abs(extreme - end.value) <= end.band:
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
