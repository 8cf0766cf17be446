"""A group's free-run error before and after what is named, and on which trials.

Belongs here: which of its errors is shown, and the words for the trials it is of. Does not belong here: the errors
themselves (discrepancy/), where they stand (blocks.py, the terminal).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

from undertow.discrepancy.verdict import Described

Seen = Literal["unseen", "left-out", "fitted"]
"""Trials that an error is of: held back, left out of a fit each in turn, or those that were fitted."""

ON: Mapping[Seen, str] = {
    "unseen": "unseen trials", "left-out": "trials left out in turn", "fitted": "the trials it was fitted to",
}  # fmt: skip
"""Of which trials an error is, in a sentence."""

BEHIND: Mapping[Seen, str] = {"unseen": "", "left-out": "left out", "fitted": "fitted"}
"""The same in a word or two."""


def errors_of(before: Described, after: Described | None) -> tuple[float, float, Seen] | None:
    """Free-run error of a group as prescribed and repaired, and on which trials: the first that both equations have;
    None without a repaired equation."""
    if after is None:
        return None
    unseen = before.held_out_nrmse, after.held_out_nrmse
    if all(map(math.isfinite, unseen)):
        return (*unseen, "unseen")
    apart = before.cross_validated_nrmse, after.cross_validated_nrmse
    return (*apart, "left-out") if all(map(math.isfinite, apart)) else (before.nrmse, after.nrmse, "fitted")
