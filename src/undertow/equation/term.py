"""What a term of an equation of motion is.

A law is written once, as the force it gives per unit coefficient, on the left-hand side of

    M x'' + sum_i coefficient_i force_i(x, v, a, t) = 0.

SINDy uses that as a column, output error and Method 1 as a force, Method 2 as a balance at an instant, diagnosis as
a suspect. The compiled integrator (kernel.py) holds the same laws; a contract test holds every term against it.

Belongs here: the base classes. Does not belong here: any particular law.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from undertow.equation.symbolic import Element, Expression, Share, SymbolPlace
from undertow.quantities import Parameter

Array = NDArray[np.float64]
Kind = Literal["algebraic", "memory", "outside", "setup", "instrument"]
Against = Literal["base", "earth", "water"]
"""What the motion in a law is relative to, where the base moves."""


@dataclass(frozen=True)
class Published:
    """How a report writes a law's coefficient: its column and unit; or, where the specimen is known, per what of it.

    ``per`` names the quantity of the specimen by which the coefficient is divided (friction by the normal force), and
    ``ratio`` the dimensionless number that this gives.
    """

    column: str
    unit: str
    ratio: str = ""
    per: str = ""


SAID_ANEW = (
    "is_inertia", "own_clock", "dissipates", "pulls_back", "is_spring", "instead_of", "linear", "of_water", "of_area",
    "relative_to", "structural", "published", "speed_power", "held_by_kernel", "missing_as", "words", "words_unplaced",
    "words_alone", "next_test", "suspect_of", "element", "slot_values", "share", "materials", "start",
)  # fmt: skip
"""What a law does not take over from the law that it is derived from."""


@dataclass(frozen=True)
class Term(ABC):
    """One law. Class attributes say what it is; the fields of a subclass are its inner parameters.

    ``parameters[0]`` is the coefficient (the law is linear in it); further ones are inner parameters, each a field
    of the subclass with the same name. ``slots`` names, for each parameter, its place in the compiled integrator;
    empty for a user's own law, which then takes the general path (general.py), compiled where ``force`` is a formula of
    numpy's functions, without look-ups and decisions by a value. ``left_out`` says what a residual looks
    like when this law is missing.

    What other packages ask of a law, in place of its name: whether it ``is_inertia`` (acts with the acceleration: its
    coefficient is a part of the total mass), has its ``own_clock`` (acts whatever the body does, with a size and a
    phase of each trial's own), ``dissipates`` (can only take energy), ``pulls_back`` (a restoring force to either
    side), ``is_spring`` (the linear one, or what stands for it; ``instead_of`` names the laws that it makes needless),
    is ``linear`` (small motion of a linear oscillator has it), ``of_water`` (a dry trial does not have it), or grows
    with the specimen's drag area (``of_area``); and what its motion is ``relative_to``, where the base moves.

    ``structural`` is the number of a structure that holds its coefficient, ``published`` how a report writes it,
    ``speed_power`` the power of the speed that it goes with (0: another law), ``held_by_kernel`` how many of it the
    compiled integrator tells apart (0: it adds them up), ``missing_as`` the law whose name missing physics bears
    instead of this one's.

    ``words`` are what a sentence says where it is missing; ``words_unplaced`` where nobody knows that the water does
    it, ``words_alone`` where there are neither dry trials nor water; ``next_test`` what would show it plainly.
    ``suspect_of`` says where the effect belongs when it is looked for without a record of its own among the suspects
    (empty: it is not looked for), ``element`` what stands for it in OpenSees.
    """

    name: ClassVar[str]
    kind: ClassVar[Kind] = "algebraic"
    parameters: ClassVar[tuple[Parameter, ...]]
    slots: ClassVar[Mapping[str, str]] = {}
    law: ClassVar[str]
    latex: ClassVar[str]
    source: ClassVar[str]
    left_out: ClassVar[str]

    is_inertia: ClassVar[bool] = False
    own_clock: ClassVar[bool] = False
    dissipates: ClassVar[bool] = False
    pulls_back: ClassVar[bool] = False
    is_spring: ClassVar[bool] = False
    instead_of: ClassVar[tuple[str, ...]] = ()
    linear: ClassVar[bool] = False
    of_water: ClassVar[bool] = False
    of_area: ClassVar[bool] = False
    relative_to: ClassVar[Against] = "base"
    structural: ClassVar[str] = ""
    published: ClassVar[Published | None] = None
    speed_power: ClassVar[float] = 0.0
    held_by_kernel: ClassVar[int] = 0
    missing_as: ClassVar[str] = ""
    words: ClassVar[str] = ""
    words_unplaced: ClassVar[str] = ""
    words_alone: ClassVar[str] = ""
    next_test: ClassVar[str] = ""
    suspect_of: ClassVar[Literal["", "water", "structure", "outside"]] = ""
    element: ClassVar[Element] = ""

    def __init_subclass__(cls) -> None:
        """A law derived from another under a name of its own is another law: it says anew what others ask of it."""
        super().__init_subclass__()
        if "name" in cls.__dict__:
            for one in SAID_ANEW:
                if one not in cls.__dict__:
                    setattr(cls, one, Term.__dict__[one])

    @abstractmethod
    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """Force per unit coefficient, (n,), at displacement x from rest (m), velocity v, acceleration a, time t (s).

        Hidden-state terms need the whole record from the release on, at rest before it; algebraic ones do not.
        """

    @property
    def coefficient(self) -> Parameter:
        """The parameter the law is linear in."""
        return self.parameters[0]

    @property
    def inner(self) -> Mapping[str, float]:
        """Values of the inner parameters, by name."""
        return {p.name: float(getattr(self, p.name)) for p in self.parameters[1:]}

    def slot_values(self, coefficient: float) -> dict[str, float]:
        """What the law writes into the compiled integrator's slots: as it stands, where the law says nothing else."""
        values = {self.slots[self.coefficient.name]: coefficient}
        for name, number in self.inner.items():
            values[self.slots[name]] = number
        return values

    def share(self, p: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share | None:
        """What the law adds to an equation in symbols: ``p`` its parameters' symbols by name, ``q`` the symbols of the
        motion, ``number`` what tells it from others of its name. None where it is code alone."""
        return None

    def materials(self, coefficient: float, sticking: float) -> tuple[str, ...]:
        """Materials of OpenSees between the ground and the body, TAG for their number; ``sticking`` is the stiffness
        (N/m) of a spring that stands for what sticks. Empty where the law's `element` is no material."""
        if self.speed_power:
            return (f"'Viscous', TAG, {coefficient!r}, {self.speed_power!r}",)
        return ()

    def start(self, mass: float, rate: float, speed: float) -> float:
        """First value of the coefficient for a body of this mass (kg), rate (rad/s) and largest speed (m/s); nan where
        the law has no size of its own that fits start from."""
        return math.nan


def restoring(symbol: str, unit: str, name: str) -> tuple[Parameter, ...]:
    """A single coefficient without bounds, as restoring laws have."""
    return (Parameter(name, unit, symbol),)
