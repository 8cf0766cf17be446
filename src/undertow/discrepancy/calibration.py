"""How often a verdict of a kind was right on sealed campaigns of known truth: the probability that is said with it.

The campaigns are drawn and judged by experiments/blind_challenge, which shares no code with the package; the counts are
made by `python -m experiments calibration` and stand in calibration.json with seeds and revisions. Every group counts
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
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from typing import Any

from undertow.comparison.limits import FAR_ABOVE_NOISE
from undertow.discrepancy.verdict import LEFT, Verdict
from undertow.quantities import or_nan

STANDS_OUT, HIDES = "p_value", "upper_bound"
"""The conditions that tell kinds apart beside how much over the noise what is named leaves: how often such a level with
nothing missing stands out as much; how much can still hide in it."""

NEARLY = 0.03
"""A level of which nothing is said that stands out more than that share of its replicas nearly stands out."""

LEANS = 0.3
"""One that stands out more than that share of them leans to standing out: of 580 campaigns (seeds 2106001, 2106501,
2107001) green held for 92 of 108 such levels, for 440 of 452 others (not seen sharply). Of the counts 896 of 943
held beside 3,392 of 3,497."""

BEYOND = 1e-5
"""Below it a level stands out beyond every replica; something small was there in 33 of 34 such levels, in 32 of 39
others."""

FEW = 10
"""Of fewer verdicts the count itself is said, not a percentage."""

NEARLY_NOISE = 1.3
"""An explanation that leaves more over the noise than that explains it nearly: of 126 such (thirteen seeds) 111
held, of 1,004 others 980."""

RATHER = 0.5
"""Names beside what is unknown that hold less often are not said: of 52 verdicts with several of them 11 held, of 246
with one 188."""

SHARP = 0.1
"""A level is seen sharply where no more than that share of what counts can hide."""


@dataclass(frozen=True)
class Record:
    """Of so many verdicts of a ``kind`` on sealed campaigns so many held (``right``)."""

    kind: str
    said: int
    right: int

    @property
    def probability(self) -> float:
        """The probability that one more is right: the mean of Jeffreys' posterior; nan where none was seen.

        >>> Record("unknown, not named", 9, 9).probability
        0.95
        """
        return (self.right + 0.5) / (self.said + 1.0) if self.said else math.nan

    @property
    def few(self) -> str:
        """Its counts in words where they are too few for a percentage; else empty.

        >>> Record("explained, more than noise is left", 5, 3).few, Record("nothing_missing", 44, 40).few
        ('3 of 5', '')
        """
        return f"{self.right} of {self.said}" if 0 < self.said < FEW else ""


def kind_of(status: str, names: Sequence[str], decision: Mapping[str, tuple[float, float]]) -> str:
    """The kind of a verdict: its status; of an explanation whether it has several effects, else how near it comes to
    the noise, of what is unknown how many names stand beside it, of one that nothing is missing whether the level
    nearly stands out, leans to it, is seen sharply, of something small without a name whether it stands out beyond
    every replica. Empty where nothing is said. ``decision`` has values and limits of conditions by name.

    >>> kind_of("explained", ("linear_damping",), {LEFT: (1.1, 2.5)})
    'explained, to the noise'
    >>> kind_of("nothing_missing", (), {STANDS_OUT: (0.02, 0.01), HIDES: (0.001, 0.04)})
    'nothing_missing, nearly stands out'
    """
    nothing = (math.nan, math.nan)
    p_value = decision.get(STANDS_OUT, nothing)[0]
    if status == "cannot_tell":
        return ""
    effects = sum(name != "unknown" for name in names)  # two resonators are two
    if status == "explained":
        return f"explained, {'several effects' if effects > 1 else _left(decision.get(LEFT, nothing)[0])}"
    if status == "unknown":
        return f"unknown, {('not named', 'beside a name', 'beside several names')[min(effects, 2)]}"
    if status == "present_but_small":
        if effects:
            return "present_but_small, named"
        return f"present_but_small, not named{', beyond every replica' if p_value < BEYOND else ''}"
    if status == "nothing_missing":
        hidden, limit = decision.get(HIDES, nothing)
        if p_value < NEARLY:
            return "nothing_missing, nearly stands out"
        sharp = "nothing_missing, seen sharply" if hidden < SHARP * limit else "nothing_missing"
        return f"{sharp}, leans to standing out" if p_value < LEANS else sharp
    return status


def _left(left: float) -> str:
    """How much an explanation leaves, in words; ``left`` is the mean squared residual over noise."""
    if left > FAR_ABOVE_NOISE:
        return "more than noise is left"
    return "nearly to the noise" if left > NEARLY_NOISE else "to the noise"


def conditions_of(decision: Sequence[Mapping[str, Any]]) -> dict[str, tuple[float, float]]:
    """Values and limits of a verdict's conditions as verdict.json has them, by name; what is not said is not a number.

    >>> conditions_of([{"gate": "p_value", "value": 0.2, "limit": 0.01}])
    {'p_value': (0.2, 0.01)}
    """
    return {one["gate"]: (or_nan(one.get("value")), or_nan(one.get("limit"))) for one in decision}


def record_of(verdict: Verdict) -> Record | None:
    """The record of verdicts like this one; None where nothing is said or none was seen."""
    decision = {gate.gate: (gate.value, gate.limit) for gate in verdict.decision}
    return record_for(verdict.status, verdict.verdict, decision)


def rather_right(verdict: Verdict) -> Verdict:
    """``unknown`` alone in place of names beside it that are wrong more often than right: they stay in its sentence,
    and what they describe stays with it."""
    record = record_of(verdict)
    if verdict.status != "unknown" or record is None or record.probability >= RATHER or verdict.verdict == ("unknown",):
        return verdict
    text = f"Of such answers with several names {record.right} of {record.said} held: none is said."
    return replace(verdict, verdict=("unknown",), alternatives=(), sentence=f"{verdict.sentence} {text}")


def record_for(status: str, names: Sequence[str], decision: Mapping[str, tuple[float, float]]) -> Record | None:
    """The record of verdicts of that kind (`kind_of`); None where nothing is said or none was seen."""
    return _records().get(kind_of(status, names, decision))


@cache
def _records() -> Mapping[str, Record]:
    text = files("undertow.discrepancy").joinpath("calibration.json").read_text(encoding="utf-8")
    return {row["kind"]: Record(row["kind"], row["said"], row["right"]) for row in json.loads(text)["records"]}
