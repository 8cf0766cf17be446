"""What a suspect is: an effect that an equation may lack, with the unknowns that it brings.

Belongs here: the records, and what the search asks of them. Does not belong here: any particular suspect (suspects.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

Scope = Literal["shared", "spring", "trial"]
Origin = Literal["water", "structure", "outside", "instrument", "undetermined"]

EACH_SPRING = "each spring's own"
"""Variant of a suspect that a level with one spring cannot tell from the shared one."""

COMMON = frozenset({"acceleration_shift_s", "acceleration_gain"})
"""Errors that a sensor has in all trials alike."""

DRIFT = "drift_m"
"""A displacement sensor's error that grows within a trial."""

WIDER = 20.0
DRIFTS = 100.0
"""How much wider than a sensor's prior its shift or gain may be where the sensor is suspected, and its drift: a third
of the release."""

HOOK = "let_go"
"""The integrator's slot for the time in which a hook lets go of the body."""


def widening(frees: str) -> float:
    """How much wider than what sensors usually err a nuisance may be where its sensor is suspected.

    >>> widening("acceleration_gain"), widening("drift_m")
    (20.0, 100.0)
    """
    return DRIFTS if frees == DRIFT else WIDER


@dataclass(frozen=True)
class Scales:
    """Sizes of one level's motion: mass (kg), angular rate (rad/s), speed (m/s), displacement (m), slowest and
    fastest body rate over the springs (rad/s), and the longest record (s)."""

    mass: float
    rate: float
    speed: float
    size: float
    slowest: float
    fastest: float
    record: float = 1.0

    @property
    def force(self) -> float:
        """Inertia force at full motion, N."""
        return self.mass * self.rate * self.speed


@dataclass(frozen=True)
class Addition:
    """One unknown of a suspect: contract name, unit, slot, start, bounds, and whether all trials share it.

    ``inner`` marks what has no effect where the coefficient beside it is zero (a frequency, a time), ``takes`` what
    would feed energy into the motion if it were negative, though no bound says so. ``replaces`` is
    the slot of a coefficient of the equation that is left out beside it; ``also`` slots that it moves too, with their
    factors (a sine instead of a line); ``by_spring`` (label, value, standard error) what each spring's dry trials say;
    ``moves`` says that everything in the first slot, scatter included, stands in the second instead (dry friction
    becomes the yield force of bristles); ``endless`` what has a shape of its own at its upper bound and beyond (a
    change so slow that it is a straight line): there its size alone says whether it is there.
    """

    name: str
    unit: str
    slot: str
    start: float
    scale: float
    lower: float = -math.inf
    upper: float = math.inf
    scope: Scope = "shared"
    prior_std: float = math.inf
    inner: bool = False
    takes: bool = False
    replaces: str = ""
    also: tuple[tuple[str, float], ...] = ()
    by_spring: tuple[tuple[str, float, float], ...] = ()
    moves: tuple[str, str] | None = None
    endless: bool = False

    @property
    def slots(self) -> tuple[tuple[str, float], ...]:
        """All slots that it moves, with their factors."""
        return ((self.slot, 1.0), *self.also)

    @property
    def differs(self) -> bool:
        """Whether what it says is how trials differ: their own numbers about what all share, held by a prior."""
        return self.scope == "trial" and math.isfinite(self.prior_std)

    @property
    def told_by_springs(self) -> bool:
        """Whether springs beside each other tell it alone: on one a shared stiffness is an added mass, and on two one
        of each spring's own."""
        return self.scope == "shared" and self.slot == "k1"

    @property
    def of_its_own(self) -> bool:
        """Whether every trial has its own and nothing is known of it beforehand: size and phase of an outside force.
        (A speed at the release is adjusted in every free run.)"""
        return self.scope == "trial" and not math.isfinite(self.prior_std) and self.slot not in ("v0", HOOK)


@dataclass(frozen=True)
class Suspect:
    """A suspect: its name in the contract, where it comes from when found wet but not dry, and its unknowns.

    ``additions`` gives the unknowns at one start; ``starts`` are alternative first values of the searched parameter
    (frequency, time), ``fine`` the steps in which a small one is looked for, ``look`` its unknowns there, where one
    goes with another's size (a small hysteresis yields at a small force): its fits begin at ``starts`` all the same;
    ``memory`` tells whether it remembers.
    ``frees`` names a nuisance of every trial (a sensor's clock, gain, drift) whose prior is widened instead: what it
    says is in the instrument, and no free run of the displacement shows it unless it drifts. ``on_a_line`` says that a
    fit finds it from a start within its line only (a clock). ``late`` asks nothing of so many first periods: what is
    wrong with the release shows there and nowhere else.

    ``wider`` gives the same unknowns, and further ones, of wider forms of the law (a force that changes along the
    record) about what it has inside as fitted, each tried from where the one before it ended if that leaves more than
    noise; nothing where there is no such form. A number is the degree of a sensor's drift in time.

    ``swings`` by itself, so that several may stand in one equation, and where it is damped strongly it cannot be told
    from what ``overdamped_as`` names; on the lower and on the upper bound of what it has inside it ``becomes`` a law
    that is simpler, each named where there is one;
    ``fades``: a memory that rings in nothing; ``recurs``: half a period later, turned, it looks much alike; ``plain``:
    damping, which is what such a memory amounts to at one frequency. ``like`` names what no decay tells it from;
    ``without_sliding`` what it is called where no friction slides beside it; ``often_beside`` another effect of the
    same water or another power of the same spring, so that it is tried there without evidence of its own;
    ``of_angles``: an angle is its coordinate.
    ``words`` and ``next_test`` are those of an effect that is no law of the registry.
    """

    name: str
    origin: Origin
    additions: Callable[[Scales, float], tuple[Addition, ...]]
    starts: Callable[[Scales], tuple[float, ...]] = lambda scales: (0.0,)
    memory: bool = False
    variant: str = ""
    fine: Callable[[Scales], tuple[float, ...]] | None = None
    look: Callable[[Scales, float], tuple[Addition, ...]] | None = None
    frees: str = ""
    on_a_line: bool = False
    late: float = 0.0
    swings: bool = False
    fades: bool = False
    recurs: bool = False
    plain: bool = False
    often_beside: bool = False
    overdamped_as: str = ""
    becomes: tuple[str, str] = ("", "")
    like: tuple[str, ...] = ()
    without_sliding: str = ""
    of_angles: bool = False
    wider: tuple[Callable[[Scales, float], tuple[Addition, ...]] | int, ...] = ()
    words: str = ""
    next_test: str = ""

    @property
    def has_no_zero(self) -> bool:
        """Whether no small value of it is as if it were not there (bristles: infinitely stiff ones are)."""
        return self.late > 0.0 or self.moves

    @property
    def moves(self) -> bool:
        """Whether it takes the place of a law that stands (bristles that of sliding friction)."""
        return any(a.moves for a in self.additions(UNIT, 1.0))

    @property
    def is_scatter(self) -> bool:
        """Whether all it says is how trials differ."""
        additions = self.additions(UNIT, 1.0)
        return bool(additions) and all(a.differs for a in additions)

    @property
    def of_the_release(self) -> bool:
        """Whether it says what was wrong with the release, and nothing of what moves."""
        return self.late > 0.0 or any(a.slot in ("v0", HOOK) for a in self.additions(UNIT, 1.0))

    @property
    def at_the_beginning(self) -> bool:
        """Whether it is seen in the first cycle of a body that was held, in full or not at all: no step shows it."""
        return self.late > 0.0 or any(a.slot == HOOK for a in self.additions(UNIT, 1.0))

    @property
    def has_its_own_clock(self) -> bool:
        """Whether it acts on the body whatever that does, with a size and a phase of its own in every trial."""
        return any(a.of_its_own for a in self.additions(UNIT, 1.0))

    @property
    def told_by_springs(self) -> bool:
        """Whether springs beside each other tell it alone, each against an added mass of its own."""
        return any(a.told_by_springs for a in self.additions(UNIT, 1.0))

    @property
    def of_the_body(self) -> bool:
        """Whether it is a law of the body and its water: no sensor, no release, nothing of every trial's own."""
        own = any(a.scope == "trial" for a in self.additions(UNIT, 1.0))
        return not (self.frees or self.of_the_release or own)

    @property
    def shown_by_free_run(self) -> bool:
        """Whether what it adds can bring a free run of the displacement closer (x0, v0 are adjusted anyway)."""
        return self.frees in ("", DRIFT) and not self.of_the_release

    def grid(self, scales: Scales) -> tuple[tuple[Addition, ...], ...]:
        """The additions at every place where a small effect is looked for."""
        places = (self.fine or self.starts)(scales)
        return tuple((self.look or self.additions)(scales, start) for start in places)

    @property
    def label(self) -> str:
        """Name with its variant, for tables of rivals."""
        return f"{self.name} ({self.variant})" if self.variant else self.name


UNIT = Scales(1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
"""Scales of one, to ask a suspect what it is made of."""
