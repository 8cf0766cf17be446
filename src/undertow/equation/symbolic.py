"""What a law adds to an equation in symbols, and in elements of OpenSees: what it is handed over as.

Belongs here: the symbols that a law may use and the shape of its share. Does not belong here: the laws, programs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Expression = Any
"""A SymPy expression."""

Element = Literal["", "elastic", "dashpot", "slider", "oscillator", "maxwell", "bristles", "drive", "inertia"]
"""What stands for a law between two nodes: a part of the table of elastic forces, a dashpot, what slides, a second
mass, a spring and dashpot in line, bristles; a load that drives the body, a part of its mass; or nothing known."""


@dataclass(frozen=True)
class SymbolPlace:
    """The symbols that a law may use: displacement from rest, velocity, direction, acceleration, time, v(t - tau)."""

    x: Expression
    v: Expression
    d: Expression
    a: Expression
    t: Expression
    echo: Expression


@dataclass(frozen=True)
class Share:
    """What one term adds: a smooth force, a size of friction, hidden states (name, rate of change), the name of the
    delay after which it comes back."""

    smooth: Expression = 0
    friction: Expression = 0
    states: tuple[tuple[str, Expression], ...] = ()
    delay: str = ""
