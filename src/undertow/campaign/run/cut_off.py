"""Trials that a sensor's range cut off, said in their group's verdict.

Belongs here: that sentence and name. Does not belong here: how a cut is seen (recording/quality.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from undertow.campaign.config import RunConfig
from undertow.discrepancy.findings import FailedTrial, GroupFindings
from undertow.discrepancy.words import count


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
            next_test="the same releases with the sensor's range widened",
        )  # fmt: skip
    return replace(group, verdict=verdict)
