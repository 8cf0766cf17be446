"""What is said of a group of trials: the frozen `Verdict`; verdict.json has most of it.

Belongs here: the verdict's shape and its sentence. Does not belong here: the search for what is missing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from undertow.quantities import Estimate

if TYPE_CHECKING:  # the search: reading and checking files, which hold verdicts' names alone, does not wait for it
    from undertow.comparison.detectable import Detectable
    from undertow.comparison.suspect import Origin
    from undertow.comparison.tail import Histogram

LEFT = "left_above_noise"
"""The condition that nothing but noise is left."""

Status = Literal["explained", "nothing_missing", "present_but_small", "unknown", "not_identifiable", "cannot_tell"]


@dataclass(frozen=True)
class Described:
    """Scores and parameters of one equation in one group: the baseline, or the augmented one.

    ``cross_validated_nrmse`` is the median error of trials that were each left out of a fit, where none was held back
    (left_out.py). ``correlations`` are those of the parameters fitted together: name -> name -> correlation (empty: not
    kept).
    """

    nrmse: float = math.nan
    held_out_nrmse: float = math.nan
    parameters: Mapping[str, Estimate] = field(default_factory=dict)
    correlations: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    cross_validated_nrmse: float = math.nan


@dataclass(frozen=True)
class Rejected:
    """A suspect and why it is not the answer; ``log_odds`` beside what is said, natural logarithm (at most that, where
    the suspect was screened out; nan: not tried to the end)."""

    name: str
    because: str
    log_odds: float = math.nan


@dataclass(frozen=True)
class PhysicalCheck:
    """A found parameter against what physics allows; ``agrees`` None where no bound applies."""

    expected: float = math.nan
    found: float = math.nan
    agrees: bool | None = None
    because: str = ""


@dataclass(frozen=True)
class Gate:
    """One condition behind a verdict: a statistic in words, its value, the limit, whether it is passed.

    ``because`` says in words what follows where it is not; ``lacking`` what would mend it (a key of `earned.NEXT`);
    ``bars`` holds the statuses that are not said then.
    """

    gate: str
    statistic: str
    value: float
    limit: float
    passed: bool
    because: str = ""
    lacking: str = ""
    bars: tuple[str, ...] = ()


@dataclass(frozen=True)
class Verdict:
    """What is said of one group; its entry of verdict.json (contract 2) is made of it, without ``contradicted`` and
    ``null``, without log odds of what is `Rejected` and correlations of what is `Described`.

    ``because``: what is lacking for an answer where the status is ``cannot_tell``, else empty. ``contradicted``: that
    the channels of its recordings contradict each other.
    ``confidence``: how often verdicts of this kind were right on sealed campaigns (calibration.py; nan: none said);
    ``posterior``: probability of what is said among everything that was fitted, excluded candidates included;
    ``decision``: every condition behind the status.
    ``p_value``: how often a level like this one, with nothing missing, stands out as much; ``upper_bound``: the largest
    free-run error (nrmse) that an effect all trials share can still hide, at 95 %; ``detectable``: the smallest effects
    that would have been seen; ``not_testable``: what no free decay shows; ``null``: its score and its replicas'.
    ``transfer``: nrmse of this group's trials as what another spring alone says of the water predicts them, by that
    spring's label.
    """

    group: Mapping[str, str | float]
    trials: tuple[str, ...]
    held_out: tuple[str, ...] = ()
    status: Status = "unknown"
    verdict: tuple[str, ...] = ()
    alternatives: tuple[tuple[str, ...], ...] = ()
    confidence: float = math.nan
    origin: Origin = "undetermined"
    parameters: Mapping[str, object] = field(default_factory=dict)
    baseline: Described = field(default_factory=Described)
    augmented: Described | None = None
    sensor_floor_nrmse: float = math.nan
    repeatability_nrmse: float = math.nan
    rejected: tuple[Rejected, ...] = ()
    physical_check: PhysicalCheck = field(default_factory=PhysicalCheck)
    next_test: str = ""
    sentence: str = ""
    transfer: Mapping[str, float] = field(default_factory=dict)
    because: str = ""
    contradicted: bool = False
    posterior: float = math.nan
    decision: tuple[Gate, ...] = ()
    p_value: float = math.nan
    upper_bound: float = math.nan
    detectable: tuple[Detectable, ...] = ()
    not_testable: tuple[str, ...] = ()
    null: Histogram | None = None

    @property
    def describes(self) -> bool:
        """Whether what is named is a description: it leaves more than noise."""
        return is_description(self.status, {gate.gate: gate.passed for gate in self.decision})


def is_description(status: str, passed: Mapping[str, bool]) -> bool:
    """Whether a verdict with names says that they explain what is missing, though they leave more than noise.

    >>> is_description("explained", {LEFT: False}), is_description("unknown", {LEFT: False})
    (True, False)
    """
    return status in ("explained", "not_identifiable") and not passed.get(LEFT, True)
