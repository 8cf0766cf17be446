"""Laws that a driven body can have beside those of the registry: a constant force, what accelerated water does.

Belongs here: their rows, and where any law's parameters stand in the driven integrator. Does not belong here: laws that
decays can hold too (structure.py and its neighbours), hysteresis (driven_hysteresis.py).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, ClassVar

import numpy as np

from undertow.equation import registry
from undertow.equation.driven_hysteresis import HYSTERESES
from undertow.equation.term import Array, Term
from undertow.errors import ConfigError, IdentificationError, shown
from undertow.quantities import Mover, Parameter

THROUGH_WATER: Mapping[Mover, Mapping[str, tuple[str, ...]]] = {
    "force": {},
    "base": {"mass": ("mass",), "c1": ("wc",), "q": ("wq",), "c3": ("wc3",)},
    "water": {"mass": ("mass", "wave"), "c1": ("wc",), "q": ("wq",), "c3": ("wc3",), "wave": ("wave",)},
}
"""By what moves: slots of a law of the water in still water on a base at rest, and those it then has, where the body's
velocity through the water is not its velocity relative to the base."""


@dataclass(frozen=True)
class ConstantForce(Term):
    """A force that is always there, F = b: the drive's offset, a body that does not lie level.

    >>> ConstantForce().force(np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2))
    array([1., 1.])
    """

    name = "constant_force"
    kind = "input"
    relative_to = "earth"
    parameters = (Parameter("force_N", "N", "b"),)
    slots: ClassVar[Mapping[str, str]] = {"force_N": "offset"}
    law = "b"
    latex = "b"
    source = "offset of an amplifier, a slope"
    left_out = "a body without a spring drifts away to one side; one with a spring rests elsewhere"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """1, dimensionless."""
        return np.ones(x.size)


@dataclass(frozen=True)
class FroudeKrylov(Term):
    """The pressure of accelerated water on the volume that the body takes in it, F = -rho V u' (on the left-hand side).

    rho V is the mass of the displaced water. Beside it the added mass goes with x'' - u', so that Morison's inertia
    force is (rho V + m_a) u' = rho V C_m u'.
    """

    name = "froude_krylov"
    kind = "input"
    relative_to = "water"
    parameters = (Parameter("displaced_kg", "kg", r"\rho V", lower=0.0),)
    slots: ClassVar[Mapping[str, str]] = {"displaced_kg": "wave"}
    law = "-rho V u'"
    latex = r"-\rho V\dot u"
    source = "Morison et al. 1950, doi:10.2118/950149-G; Newman 1977 ch. 2"
    left_out = "a force in phase with the water's acceleration, as large as a part of the body's weight"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """-u' in m/s^2, with the water's acceleration u' in place of ``a``."""
        return -1.0 * a


DRIVEN_ALONE: tuple[type[Term], ...] = (ConstantForce, *HYSTERESES, FroudeKrylov)
"""Laws that no decay is fitted with."""


@dataclass(frozen=True)
class DrivenUnknown:
    """A parameter of a law in the driven integrator: its name, law.parameter, its row and the names of its slots."""

    name: str
    parameter: Parameter
    slots: tuple[str, ...]
    term: Term


def find_driven(name: str, **inner: float) -> Term:
    """The law of that name for a driven body: the registry's and those of this file.

    Raises ConfigError where there is none, or where its force has a clock of its own, which no driven trial fits.

    >>> find_driven("bouc_wen").name
    'bouc_wen'
    """
    for own in DRIVEN_ALONE:
        if own.name == name:
            return own(**inner)
    term = registry.find(name, **inner)
    if term.kind in ("input", "delay"):
        raise ConfigError(f"equation term {name!r} beside a measured input is not fitted; leave it out")
    return term


def places(terms: Sequence[Term], mover: Mover | None = None) -> tuple[DrivenUnknown, ...]:
    """Every parameter of the laws with its slot, in order; a second hidden oscillator's go to the second one's slots.

    ``mover`` says what the input is: where the base or the water moves, laws of the water have slots of their own
    (None: nobody asks, names alone are wanted). Raises ConfigError where the integrator does not hold a law, or not so
    many of it, or not beside that input.
    """
    others = THROUGH_WATER[mover or "force"]
    remembering = [term.name for term in terms if "bw_a" in term.slots.values()]
    if len(remembering) > 1:
        raise ConfigError(
            f"equation terms {' and '.join(map(repr, remembering))} are {len(remembering)} hystereses, and the driven "
            "integrator holds one; choose one"
        )
    seen: dict[str, int] = {}
    out = []
    for term in terms:
        seen[term.name] = count = seen.get(term.name, 0) + 1
        if not term.slots or count > (term.held_by_kernel or 1):
            raise ConfigError(f"equation term {term.name!r} number {count} has no place in the driven integrator")
        if mover is not None:
            _must_hold(term, mover)
        many = sum(t.name == term.name for t in terms) > 1
        suffix = str(count) if term.held_by_kernel else ""
        label = f"{term.name}{count}" if many else term.name
        for parameter in term.parameters:
            slot = term.slots[parameter.name]
            own = others.get(slot, (slot,)) if term.relative_to == "water" else (slot + suffix,)
            out.append(DrivenUnknown(f"{label}.{parameter.name}", parameter, own, term))
    return tuple(out)


def must_be_apart(slots: Mapping[str, object]) -> None:
    """IdentificationError where two of the numbers to be found stand in the same slots: only their sum is known.

    >>> must_be_apart({"stiffness.k_N_per_m": ("k1",), "viscous_damping.c_Ns_per_m": ("c1",)})
    """
    by_slots: dict[object, str] = {}
    for name, own in slots.items():
        other = by_slots.setdefault(own, name)
        if other != name:
            raise IdentificationError(
                f"{other} and {name} are the same force, and only their sum is known: take one of them out of the "
                "equation, or hold one"
            )


def numbers_to_find(
    names: Sequence[str], held: Any, starts: Any, asked: Sequence[str] = (), usual: Collection[str] = ()
) -> list[str]:
    """Which of an equation's numbers (``names``) are to be found: those that are not ``held``, also not as ``usual``;
    and of those that are found where a start is given alone (``asked``, an input's delay) those with one in ``starts``.

    Raises ConfigError where ``held`` or ``starts`` is no mapping of these names to numbers, IdentificationError where
    nothing is left to be found.

    >>> numbers_to_find(["mass_kg", "stiffness.k_N_per_m"], {"mass_kg": 4.0}, {})
    ['stiffness.k_N_per_m']
    """
    for argument, said in (("held", held), ("starts", starts)):
        if not isinstance(said, Mapping):
            raise ConfigError(f"{argument} is {shown(said)}; give numbers by name, as in {{{names[0]!r}: 4.0}}")
        for name, value in said.items():
            if name not in (*names, *asked):
                raise ConfigError(f"{name!r} is no number of this equation; it has {', '.join(names)}")
            if isinstance(value, bool) or not isinstance(value, Real) or not np.isfinite(float(value)):
                raise ConfigError(f"{argument} says that {name} is {shown(value)}; give a finite number")
    free = [name for name in (*names, *(one for one in asked if one in starts)) if name not in {*held, *usual}]
    if not free:
        raise IdentificationError(
            f"all {len(names)} numbers ({', '.join(names)}) are held, and nothing is left to be found; leave one out"
        )
    return free


def _must_hold(term: Term, mover: Mover) -> None:
    """ConfigError where a law of the water cannot be integrated beside that input."""
    if term.relative_to != "water":
        return
    slots = set(term.slots.values())
    if mover != "water" and "wave" in slots:
        raise ConfigError(
            f"equation term {term.name!r} goes with the acceleration of the water, and the input is the motion of "
            f"{'a base' if mover == 'base' else 'nothing (a force)'}; map water_velocity, or leave the term out"
        )
    if mover != "force" and not slots <= set(THROUGH_WATER[mover]):
        place = "on a moving base" if mover == "base" else "in waves"
        raise ConfigError(
            f"equation term {term.name!r} goes with the velocity through water, and {place} only "
            "quadratic_drag, linear_damping and cubic_damping of these are integrated; choose one of them"
        )


def without_memory(terms: Sequence[Term]) -> None:
    """ConfigError where a law carries a state from period to period, or acts by a clock of its own."""
    for term in terms:
        if term.kind != "force":
            raise ConfigError(
                f"equation term {term.name!r} keeps a state from one period to the next, and steady motions are sought "
                "for laws of x and v alone; leave it out, or give recordings in time"
            )


def felt(term: Term) -> bool:
    """Whether a law of the water sees water that moves: by its velocity or by its acceleration."""
    return term.relative_to == "water" and set(term.slots.values()) <= set(THROUGH_WATER["water"])
