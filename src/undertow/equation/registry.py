"""The registry: every term by its name. A new law is a class in one of four files, and nothing here.

Belongs here: the list and look-ups. Does not belong here: the laws.
"""

from __future__ import annotations

import difflib
from collections.abc import Sequence

from undertow.equation import forcing, hidden, hydrodynamics, structure
from undertow.equation.hydrodynamics import AddedMass, CubicDamping, QuadraticDrag
from undertow.equation.structure import (
    AsymmetricStiffness,
    CoulombFriction,
    CubicStiffness,
    PositionDamping,
    QuadraticStiffness,
    SineRestoring,
    Stiffness,
    VanDerPolDamping,
    ViscousDamping,
)
from undertow.equation.term import Term
from undertow.errors import ConfigError

_FIRST: tuple[type[Term], ...] = (Stiffness, ViscousDamping, CoulombFriction, AddedMass, QuadraticDrag)


def _rows() -> tuple[type[Term], ...]:
    """Eq. 15's laws, and every other row of the four files in the order in which it is written."""
    found = [
        row for file in (hydrodynamics, structure, hidden, forcing) for row in vars(file).values()
        if isinstance(row, type) and issubclass(row, Term) and row.__module__ == file.__name__
    ]  # fmt: skip
    return (*_FIRST, *(row for row in found if row not in _FIRST))


_LAWS: tuple[type[Term], ...] = _rows()


def _named(*laws: type[Term]) -> tuple[str, ...]:
    return tuple(law.name for law in laws)


EQUATION_15 = _named(*_FIRST)
"""Names of the terms of the report's Eq. 15, taken where no equation is given."""

ORDINARY = _named(Stiffness, SineRestoring, ViscousDamping, CoulombFriction, QuadraticDrag)
"""Restoring force and losses that every rig has."""

TEN_TERMS = _named(
    Stiffness, ViscousDamping, CoulombFriction, QuadraticDrag, AsymmetricStiffness, CubicStiffness,
    QuadraticStiffness, CubicDamping, PositionDamping, VanDerPolDamping,
)  # fmt: skip
"""A library to discover an equation from: x, v, sgn v, v|v|, x^2, x^3, x|x|, v^3, xv, x^2 v."""

SEVEN_TERMS = _named(
    Stiffness, ViscousDamping, CoulombFriction, QuadraticDrag, CubicStiffness, QuadraticStiffness, CubicDamping,
)  # fmt: skip
"""The library for a pair of motions: laws that one record can distinguish."""


def names() -> tuple[str, ...]:
    """Names of all terms, in the registry's order.

    >>> names()[:2]
    ('stiffness', 'viscous_damping')
    """
    return _named(*_LAWS)


def twice(terms: Sequence[Term]) -> str:
    """Name of the first law that stands among ``terms`` twice, or that a law of one's own has too; empty where none
    does. Two of one law with other inner parameters are two laws, where the compiled integrator holds them.

    >>> twice([find("stiffness"), find("drag_exponent"), find("drag_exponent", exponent=3.0)])
    ''
    """
    for at, one in enumerate(terms):
        for other in terms[:at]:
            if one == other or (one.name == other.name and (type(one) is not type(other) or not one.slots)):
                return one.name
    return ""


def register(law: type[Term]) -> None:
    """Add a law of one's own to the registry, behind all others: configs, suspects and reports then know its name.

    ConfigError where another law has that name.
    """
    global _LAWS
    if law.name in names():
        raise ConfigError(f"equation term {law.name!r} is in the registry already; give the law a name of its own")
    _LAWS = (*_LAWS, law)


def row(name: str) -> type[Term] | None:
    """The law of that name, for what describes it; None where there is none."""
    return next((cls for cls in _LAWS if cls.name == name), None)


def find(name: str, **inner: float) -> Term:
    """The term of that name, with the inner parameters given; ConfigError naming those like it if there is none.

    >>> find("drag_exponent", exponent=1.5).inner
    {'exponent': 1.5}
    """
    law = row(name)
    if law is not None:
        return law(**inner)
    word = name.lower()
    near = [one for one in names() if len(word) > 2 and word in one] or difflib.get_close_matches(word, names(), n=1)
    hint = f"did you mean {' or '.join(map(repr, near))}?" if near else "`undertow terms` lists all"
    raise ConfigError(f"equation term {name!r} is not in the registry; {hint}")


def catalogue() -> tuple[type[Term], ...]:
    """All term classes in the registry's order, for what describes them."""
    return _LAWS
