"""What a simulation made elsewhere and a recording are to each other, as the page and the JSON show it.

Belongs here: frozen results. Does not belong here: how they are found (campaign/differ.py) or shown (report/).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from undertow.conditioning.motion import Motion
from undertow.discrepancy.cycle_by_cycle import CycleComparison, Sidebands
from undertow.discrepancy.mismatch import Mismatch
from undertow.discrepancy.verdict import Verdict
from undertow.equation.term import Term
from undertow.likelihood.free_run import FreeRun
from undertow.methods.baseline import GroupFit
from undertow.quantities import Estimate

FAR = 3.0
"""Standard errors from which two numbers are said to differ."""


@dataclass(frozen=True)
class TermRow:
    """One number in both equations; None where evidence does not keep the term. ``sigmas`` is how many standard errors
    they lie apart (nan where one is missing)."""

    name: str
    simulation: Estimate | None
    recording: Estimate | None
    sigmas: float


@dataclass(frozen=True)
class Side:
    """One of the two: its motion, the equation that evidence keeps, its free run on itself, what it needs beside the
    simulation's form of equation."""

    motion: Motion
    terms: tuple[Term, ...]
    fit: GroupFit
    run: FreeRun
    verdict: Verdict


@dataclass(frozen=True)
class Difference:
    """The comparison. ``lacks`` holds names of what the recording has and the simulation lacks, ``extra`` of what
    the simulation has and the recording does not show, ``more`` those of ``lacks`` that differ in number only;
    ``by_equation`` tells whether they come from the recording's own equation or from the search; ``run`` is the
    simulation's equation with release, clock and rest adjusted to the recording, ``mismatch`` where it parts from the
    recording and ``bands`` how; ``released`` the same equation let go just where the recording was (None: ``run``),
    ``cycles`` its cycles beside the recording's."""

    simulation: Side
    recording: Side
    rows: tuple[TermRow, ...]
    run: FreeRun
    mismatch: Mismatch
    cycles: CycleComparison | None
    bands: Sidebands
    lacks: tuple[str, ...]
    extra: tuple[str, ...]
    more: tuple[str, ...]
    by_equation: bool
    sentence: str
    notes: tuple[str, ...] = ()
    scatter: Mapping[str, float] = field(default_factory=dict)
    released: FreeRun | None = None
