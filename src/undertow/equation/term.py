"""What a term of an equation of motion is.

A law is written once, as the force it gives per unit coefficient, on the left-hand side of

    M x'' + sum_i coefficient_i force_i(x, v, a, t) = 0.

SINDy uses that as a column, output error and Method 1 as a force, Method 2 as a balance at an instant, diagnosis as
a suspect. The compiled integrator (kernel.py) holds the same laws; a contract test holds every term against it.

Belongs here: the base classes. Does not belong here: any particular law.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from undertow.quantities import Parameter

Array = NDArray[np.float64]
Kind = Literal["algebraic", "memory", "outside", "setup", "instrument"]


@dataclass(frozen=True)
class Term(ABC):
    """One law. Class attributes say what it is; the fields of a subclass are its inner parameters.

    ``parameters[0]`` is the coefficient (the law is linear in it); further ones are inner parameters, each a field
    of the subclass with the same name. ``slots`` names, for each parameter, its place in the compiled integrator;
    empty for a user's own law, which then takes the slower general path. ``left_out`` says what a residual looks
    like when this law is missing.
    """

    name: ClassVar[str]
    kind: ClassVar[Kind] = "algebraic"
    parameters: ClassVar[tuple[Parameter, ...]]
    slots: ClassVar[Mapping[str, str]] = {}
    law: ClassVar[str]
    latex: ClassVar[str]
    source: ClassVar[str]
    left_out: ClassVar[str]

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


def restoring(symbol: str, unit: str, name: str) -> tuple[Parameter, ...]:
    """A single coefficient without bounds, as restoring laws have."""
    return (Parameter(name, unit, symbol),)
