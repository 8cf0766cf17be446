"""Everything a campaign found, as the report shows it: trials, groups, and the campaign as a whole.

Belongs here: frozen results. Does not belong here: how they were found (campaign/run.py) or are shown (report/).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from undertow.conditioning.motion import Motion
from undertow.discrepancy.mismatch import Mismatch
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import group_title
from undertow.equation.equation import Equation
from undertow.likelihood.fit import Fit, Specimen, Structure
from undertow.recording.recording import Array, Condition
from undertow.uncertainty.growth import Grown, grown_words


@dataclass(frozen=True)
class FailedTrial:
    """A trial that could not be used, and why, in one sentence; ``clipped`` where a sensor is cut off in it,
    ``misnamed`` where the config names what its file does not have."""

    name: str
    reason: str
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    clipped: bool = False
    misnamed: bool = False


@dataclass(frozen=True)
class AugmentedRun:
    """One trial's free run with what was found missing: its nrmse, and measured minus simulated, (n,) m at the trial's
    ``t`` (each run has a rest position of its own); ``as_measured`` is its nrmse with nothing adjusted to the trial."""

    nrmse: float
    residual: Array
    as_measured: float = math.nan


@dataclass(frozen=True)
class TrialFindings:
    """One trial: its motion, what each method found on it alone (``fits``: method -> Fit), free-run errors
    (``nrmse``: method -> value, "baseline" is the group's equation) and the mismatch with the group's baseline.

    ``t`` (n,) s after release, ``measured`` and ``simulated`` (n,) m about the rest position: the baseline's free run
    inside the motion window. ``augmented`` is the free run with what the verdict names (None: nothing, or no motion).
    ``as_measured`` is the baseline's nrmse with nothing adjusted: x0, clock and rest position as measured.
    """

    motion: Motion
    fits: Mapping[str, Fit]
    nrmse: Mapping[str, float]
    mismatch: Mismatch
    t: Array
    measured: Array
    simulated: Array
    held_out: bool = False
    augmented: AugmentedRun | None = None
    as_measured: float = math.nan


@dataclass(frozen=True)
class GroupFindings:
    """Trials that share one set of parameters (same spring, same water).

    ``fits`` holds what each method found for the group together; ``equation`` is the baseline with its numbers,
    ``equation_errors`` standard errors by term name ("mass" for the total mass). ``grown`` says of which parameters the
    errors are larger than the fit's own, since trials or groups differ by more.
    """

    key: Mapping[str, Condition]
    dry: bool
    trials: tuple[TrialFindings, ...]
    specimen: Specimen
    structure: Structure | None
    fits: Mapping[str, Fit]
    equation: Equation
    equation_errors: Mapping[str, float]
    verdict: Verdict
    notes: tuple[str, ...] = ()
    grown: tuple[Grown, ...] = ()

    @property
    def remarks(self) -> tuple[str, ...]:
        """The notes, and in one sentence why standard errors are larger than the fit's own."""
        return (*self.notes, *grown_words(self.grown))

    @property
    def label(self) -> str:
        """The group's conditions in words, as in "spring short, water depth 2.36 m"."""
        return group_title(self.key)


@dataclass(frozen=True)
class Findings:
    """One campaign: groups in order (dry first), failed trials, methods run, wall time a stage in s, notes, doubts.

    A doubt is about the recordings or what the config says of them, with its group and trial.
    """

    name: str
    groups: tuple[GroupFindings, ...]
    failed: tuple[FailedTrial, ...]
    methods: tuple[str, ...]
    coordinate: str
    seconds: Mapping[str, float]
    across_groups: str = ""
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
