"""What is fitted together: the groups that stand in one water, and what is added to their equation.

Belongs here: members, levels, addends, the scales of their motion. Does not belong here: the fit (joint.py), the
suspects themselves (suspects.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from undertow.comparison.suspect import HOOK, Addition, Scales
from undertow.conditioning.agreement import accelerometer_late_s
from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.equation.kernel import SLOT
from undertow.errors import IdentificationError, RecordingError
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import GroupModel

EARLIER = (1.0, 0.75, 0.5)
"""Shares of the time asked for after which a motion that hardly swings is started."""


@dataclass(frozen=True)
class Member:
    """One group in a level: its spring's label, its model, its training trials, its options.

    ``allowed`` is the group's repeatability (nrmse): the unit in which its free runs' errors are counted; ``own_means``
    says that k, c, mu come from these very trials, so that their means belong to what is fitted. ``spread`` are the
    relative standard deviations of the slots k1, c1, fc from trial to trial where no dry trials of this spring give a
    structure, ``sizes`` what they are relative to, ``freedom`` the degrees of freedom they were seen with (inf: stated;
    0: assumed).
    """

    label: str
    model: GroupModel
    motions: tuple[Motion, ...]
    options: TrialOptions
    free_start: bool = False
    allowed: float = 1.0
    own_means: bool = False
    spread: Mapping[str, float] = field(default_factory=dict)
    sizes: Mapping[str, float] = field(default_factory=dict)
    freedom: float = math.inf

    @property
    def scatter_freedom(self) -> float:
        """Degrees of freedom with which it is known how much this group's trials differ."""
        return self.freedom if self.model.fixed is None else self.model.fixed.scatter_freedom

    @property
    def tells_its_scatter(self) -> bool:
        """Whether all that is known of how much trials differ comes from these very trials."""
        return self.own_means and math.isfinite(self.scatter_freedom)


@dataclass(frozen=True)
class Addend:
    """A suspect's unknowns as added, with a prefix that tells two of a kind apart, or the nuisance that it frees.

    A freed nuisance has a prior so much wider (`widening`), or, with ``centres``, its own width about what all trials
    have in common; a drift is a polynomial of time of that ``degree``, and has as many. With ``late`` nothing is asked
    of so many first periods of a trial.
    """

    prefix: str
    additions: tuple[Addition, ...]
    frees: str = ""
    centres: tuple[float, ...] = ()
    late: float = 0.0
    degree: int = 1

    def freed(self, names: Sequence[str]) -> dict[str, int]:
        """Those of a fit's unknowns that it frees, with their degrees."""
        degrees = {self.frees: 1, **{f"{self.frees}{degree}": degree for degree in range(2, self.degree + 1)}}
        kinds = {name: name.partition("[")[0] for name in names if self.frees and "[" in name}
        return {name: degrees[kind] for name, kind in kinds.items() if kind in degrees}

    @property
    def has_its_own_clock(self) -> bool:
        """Whether it acts whatever the body does, with a size and a phase of its own in every trial."""
        return any(a.of_its_own for a in self.additions)

    @property
    def hooked(self) -> bool:
        """Whether it says in what time a hook let go of each body that was held."""
        return any(a.slot == HOOK for a in self.additions)

    @property
    def replaced(self) -> frozenset[str]:
        """Slots whose coefficient in the equation it takes the place of."""
        return frozenset(a.replaces for a in self.additions if a.replaces)

    def moved(self, spring: str) -> Mapping[int, int]:
        """Slots of the integrator whose content stands in another beside it, on one spring."""
        here = [a for a in self.additions if not a.by_spring or spring in {label for label, _, _ in a.by_spring}]
        return {SLOT[a.moves[0]]: SLOT[a.moves[1]] for a in here if a.moves is not None}


@dataclass(frozen=True)
class Level:
    """Groups that stand in the same water, with the motion's scales.

    ``shared_water``: added mass and drag are one for all springs (as water is), or each spring's own (as a table of
    separate fits has them). ``standing`` is what the dry trials named already: it is in every model. ``late_s`` says by
    how much a trial's accelerometer is later than its displacement, as their swings show it.
    """

    members: tuple[Member, ...]
    scales: Scales
    shared_water: bool = True
    standing: tuple[Addend, ...] = ()
    late_s: Mapping[str, float] = field(default_factory=dict)

    def shares(self, names: Sequence[str]) -> bool:
        """Whether these unknowns are those of a fit with the level's own sharing of the water."""
        wanted = {c.name for m in self.members if m.model.fixed is not None for c in m.model.coefficients}
        return not self.shared_water or wanted <= set(names)

    @property
    def is_dry(self) -> bool:
        """Whether k, c, mu come from these very trials."""
        return all(m.own_means for m in self.members)

    @property
    def trials(self) -> int:
        """Number of training trials."""
        return sum(len(m.motions) for m in self.members)


def make_level(members: Sequence[Member], standing: Sequence[Addend] = ()) -> Level:
    """A level with the scales of its motion; IdentificationError without a trial."""
    motions = [m for member in members for m in member.motions]
    if not motions:
        raise IdentificationError(f"a level of {len(members)} groups has no trial to fit; hold out fewer")
    rates = [2.0 * math.pi / dominant_period(m) for m in motions]
    speeds = [float(np.max(np.abs(m.v))) for m in motions]
    loudest = int(np.argmax(speeds))
    first = members[0].model
    unknown = [c.start for c in first.coefficients if c.slot == "mass"]
    mass = float(first.base[SLOT["mass"]]) or next(iter(unknown), 1.0)
    rate = rates[loudest]
    record = max(float(m.windowed("t")[-1]) for m in motions)
    scales = Scales(mass, rate, speeds[loudest], motions[loudest].amplitude, min(rates), max(rates), record)
    late = {m.name: accelerometer_late_s(m) for m in motions if "acceleration" in m.recording.channels}
    return Level(tuple(members), scales, standing=tuple(standing), late_s=late)


def member_rate(member: Member) -> float:
    """Median angular rate at which a group's trials swing, rad/s."""
    return 2.0 * math.pi / float(np.median([dominant_period(m) for m in member.motions]))


def seen_by(addends: Sequence[Addend], motion: Motion) -> Motion:
    """A motion as far as a model with these addends follows it: all of it, or from later on, with a start of its own
    that is not at rest."""
    periods = max((addend.late for addend in addends), default=0.0)
    return from_later_on(motion, periods, held=False) if periods else motion


def from_later_on(motion: Motion, periods: float, held: bool) -> Motion:
    """A motion of which so many first periods are not asked for, from rest at the release (``held``) or from a start of
    its own. A motion that swings once or twice starts earlier: it must swing on."""
    for share in EARLIER:
        later = motion.inside & (motion.t > share * periods * dominant_period(motion))
        try:
            delayed = replace(motion, inside=later, window=replace(motion.window, held=held))
            dominant_period(delayed)
        except (IdentificationError, RecordingError):
            continue
        return delayed
    return motion


def full_name(prefix: str, a: Addition, spring: str, trial: str) -> str:
    """Name of an addition's unknown in a problem: shared, of one spring, or of one trial."""
    place = {"shared": "", "spring": f"@{spring}", "trial": f"[{trial}]"}[a.scope]
    return f"{prefix}.{a.name}{place}"
