"""The shelf: every term by its name. A new law is one line here.

Belongs here: the list and look-ups. Does not belong here: the laws.
"""

from __future__ import annotations

import difflib

from undertow.equation.forcing import DelayedEcho, ExternalForcing
from undertow.equation.hidden import HiddenResonator, Hysteresis, Relaxation
from undertow.equation.hydrodynamics import AddedMass, CubicDamping, DragExponent, LinearDamping, QuadraticDrag
from undertow.equation.structure import (
    AsymmetricFriction,
    AsymmetricStiffness,
    CoulombFriction,
    CubicStiffness,
    PositionDamping,
    QuadraticStiffness,
    QuinticStiffness,
    SineRestoring,
    Stiffness,
    StribeckFriction,
    VanDerPolDamping,
    VariableNormalForce,
    ViscousDamping,
)
from undertow.equation.term import Term
from undertow.errors import ConfigError

_SHELF: tuple[type[Term], ...] = (
    Stiffness,
    ViscousDamping,
    CoulombFriction,
    AddedMass,
    QuadraticDrag,
    LinearDamping,
    CubicDamping,
    DragExponent,
    CubicStiffness,
    QuinticStiffness,
    AsymmetricStiffness,
    QuadraticStiffness,
    SineRestoring,
    PositionDamping,
    VanDerPolDamping,
    StribeckFriction,
    AsymmetricFriction,
    VariableNormalForce,
    HiddenResonator,
    Relaxation,
    Hysteresis,
    ExternalForcing,
    DelayedEcho,
)


def names() -> tuple[str, ...]:
    """Names of all terms, in the shelf's order.

    >>> names()[:2]
    ('stiffness', 'viscous_damping')
    """
    return tuple(cls.name for cls in _SHELF)


def find(name: str, **inner: float) -> Term:
    """The term of that name, with the inner parameters given; ConfigError naming the nearest one if there is none.

    >>> find("drag_exponent", exponent=1.5).inner
    {'exponent': 1.5}
    """
    for cls in _SHELF:
        if cls.name == name:
            return cls(**inner)
    near = difflib.get_close_matches(name, names(), n=1)
    hint = f"did you mean {near[0]!r}?" if near else "`undertow terms` lists all"
    raise ConfigError(f"equation term {name!r} is not on the shelf; {hint}")


def catalogue() -> tuple[type[Term], ...]:
    """All term classes in the shelf's order, for what describes them."""
    return _SHELF
