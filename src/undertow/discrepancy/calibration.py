"""How often a verdict of a kind was right on sealed campaigns of known truth: the probability that is said with it.

The campaigns are drawn and judged by experiments/blind_challenge, which shares no code with the package; the counts are
made by `python -m experiments.calibration` and stand in calibration.json with seeds and revisions. Every group counts
that was given an answer, as it comes: campaigns of another kind may be easier or harder. A verdict holds where nothing
as large as what counts is missing, or something is, and every name is of an effect that is there or describes it; that
a further effect has no name does not count against it. The posterior among everything that was fitted stands beside
(`Verdict.posterior`): it knows only the models that were fitted.

Belongs here: kinds of verdicts and their counts. Does not belong here: what is said (judge.py, earned.py).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from undertow.comparison.explained import FAR_ABOVE_NOISE
from undertow.discrepancy.verdict import Verdict

LEFT = "left_above_noise"
"""The condition that tells whether what is named leaves no more than noise, or describes and leaves more."""


@dataclass(frozen=True)
class Record:
    """Of so many verdicts of a ``kind`` on sealed campaigns so many held (``right``)."""

    kind: str
    said: int
    right: int

    @property
    def probability(self) -> float:
        """The probability that one more is right: the mean of Jeffreys' posterior; nan where none was seen.

        >>> Record("unknown", 9, 9).probability
        0.95
        """
        return (self.right + 0.5) / (self.said + 1.0) if self.said else math.nan


def kind_of(status: str, names: Sequence[str], left: float) -> str:
    """The kind of a verdict: its status, and of one with a name whether that leaves more than noise (``left``, mean
    squared residual over noise; nan: not known); empty where nothing is said.

    >>> kind_of("explained", ("linear_damping",), 1.1), kind_of("unknown", ("linear_damping", "unknown"), 9.0)
    ('explained, to the noise', 'unknown')
    """
    if status == "cannot_tell":
        return ""
    if status == "explained":
        return f"explained, {'more than noise is left' if left > FAR_ABOVE_NOISE else 'to the noise'}"
    if status == "present_but_small":
        return f"present_but_small, {'named' if set(names) - {'unknown'} else 'not named'}"
    return status


def record_of(verdict: Verdict) -> Record | None:
    """The record of verdicts like this one; None where nothing is said or none was seen."""
    left = next((gate.value for gate in verdict.decision if gate.gate == LEFT), math.nan)
    return _records().get(kind_of(verdict.status, verdict.verdict, left))


@cache
def _records() -> Mapping[str, Record]:
    text = files("undertow.discrepancy").joinpath("calibration.json").read_text(encoding="utf-8")
    return {row["kind"]: Record(row["kind"], row["said"], row["right"]) for row in json.loads(text)["records"]}
