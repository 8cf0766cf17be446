"""One group as the judge sees it.

Belongs here: that record. Does not belong here: how it is judged (judge.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from undertow.comparison.level import Member
from undertow.conditioning.motion import Motion
from undertow.discrepancy.verdict import Described
from undertow.discrepancy.words import percent
from undertow.likelihood.fit import Specimen


@dataclass(frozen=True)
class Case:
    """One group as the judge sees it: its member in the level (training trials), held-out trials, what is allowed;
    ``place`` where the equation's residual stands, in words, ``own`` which of the structure's numbers may be each
    trial's own.

    What forbids a green verdict, each in words and empty where it does not: ``contradiction`` of the channels,
    ``no_dry`` (the config names dry trials, this spring has none), ``assumed`` (nobody measured or stated how much
    trials differ). ``dry_unknown``: what the dry trials of this spring lack and nobody knows, in words; ``dry_rivals``
    are sets of names that they cannot tell from what they need: nor can water, where it shows no more of it.
    """

    key: Mapping[str, str | float]
    label: str
    member: Member
    held: tuple[Motion, ...]
    baseline: Described
    floor: float
    allowed: float
    missing: int
    dry: bool
    has_dry: bool
    cell: Mapping[str, float] = field(default_factory=dict)
    place: str = ""
    contradiction: str = ""
    no_dry: str = ""
    assumed: str = ""
    dry_unknown: str = ""
    dry_rivals: tuple[tuple[str, ...], ...] = ()
    own: str = "k, c and mu"

    @property
    def specimen(self) -> Specimen:
        """What the laboratory knows, with how far the spring of a lone trial in water may be from the stated one: as
        far as trials differ, which no other trial tells."""
        told, member = self.member.model.specimen, self.member
        if self.dry or len(member.motions) != 1:
            return told
        differs = member.spread.get("k1", 0.0) * told.stiffness_N_per_m
        return replace(told, stiffness_error_N_per_m=math.hypot(told.stiffness_error_N_per_m, differs))

    @property
    def repeats(self) -> str:
        """What repetitions differ by, in words, and that it was assumed where nobody measured or stated it."""
        return f"repeatability {percent(self.allowed)}{', assumed' if self.assumed else ''}"

    @property
    def in_water(self) -> bool:
        """Whether the group is known to be in water: others were taken without it."""
        return self.has_dry and not self.dry

    @property
    def trials(self) -> tuple[str, ...]:
        """Names of all trials, training first."""
        return tuple(m.name for m in (*self.member.motions, *self.held))
