"""Laws that a driven body can have beside those of the registry: hysteresis with a shape, a constant force.

Belongs here: their rows, and where any law's parameters stand in the driven integrator. Does not belong here: laws that
decays can hold too (structure.py and its neighbours).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from undertow.equation import registry
from undertow.equation.term import Array, Term
from undertow.errors import ConfigError
from undertow.quantities import Parameter

THROUGH_WATER = {"mass": "mass", "c1": "wc", "q": "wq", "c3": "wc3"}
"""Slots of a law of the water on a base at rest, and on one that moves, where the body's velocity through the water is
not its velocity relative to the base."""


@dataclass(frozen=True)
class ConstantForce(Term):
    """A force that is always there, F = b: the drive's offset, a body that does not lie level.

    >>> ConstantForce().force(np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2))
    array([1., 1.])
    """

    name: ClassVar[str] = "constant_force"
    kind: ClassVar = "input"
    relative_to: ClassVar = "earth"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("force_N", "N", "b"),)
    slots: ClassVar[Mapping[str, str]] = {"force_N": "offset"}
    law: ClassVar[str] = "b"
    latex: ClassVar[str] = "b"
    source: ClassVar[str] = "offset of an amplifier, a slope"
    left_out: ClassVar[str] = "a body without a spring drifts away to one side; one with a spring rests elsewhere"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """1, dimensionless."""
        return np.ones(x.size)


@dataclass(frozen=True)
class AsymmetricDamping(Term):
    """Viscous friction that is not the same both ways, F = c_a |v|: c + c_a one way and c - c_a the other.

    >>> AsymmetricDamping().force(np.zeros(2), np.array([2.0, -2.0]), np.zeros(2), np.zeros(2))
    array([2., 2.])
    """

    name: ClassVar[str] = "asymmetric_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("c_Ns_per_m", "N s/m", "c_a"),)
    slots: ClassVar[Mapping[str, str]] = {"c_Ns_per_m": "ca"}
    law: ClassVar[str] = "c_a |v|"
    latex: ClassVar[str] = r"c_a|\dot x|"
    source: ClassVar[str] = "Armstrong-Helouvry et al. 1994, doi:10.1016/0005-1098(94)90209-7"
    left_out: ClassVar[str] = "the body lags its equation on the way out and leads it on the way back, more at speed"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """|v| in m/s."""
        return np.abs(v)


@dataclass(frozen=True)
class BoucWen(Term):
    """Bouc and Wen's hysteresis, F = z with z' = alpha v - G |v| |z|^(n-1) z - D v |z|^n.

    G is the literature's beta gamma, D its beta delta, n its nu; alpha is the stiffness of a small loop. |z| is counted
    in newtons. The law is linear in alpha only where G and D are given per alpha; as a column it is integrated along
    the motion with the row's own numbers and given per alpha.
    """

    loop: float = 1.0
    skew: float = 0.0
    exponent: float = 1.0
    alpha: float = 1.0
    name: ClassVar[str] = "bouc_wen"
    kind: ClassVar = "state"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("alpha_N_per_m", "N/m", r"\alpha"),
        Parameter("loop", "1/m", r"\beta\gamma"),
        Parameter("skew", "1/m", r"\beta\delta"),
        Parameter("exponent", "", r"\nu", lower=1.0, upper=8.0),
    )
    slots: ClassVar[Mapping[str, str]] = {"alpha_N_per_m": "bw_a", "loop": "bw_g", "skew": "bw_d", "exponent": "bw_n"}
    law: ClassVar[str] = "z, z' = alpha v - loop |v| |z|^(n-1) z - skew v |z|^n"
    latex: ClassVar[str] = (
        r"z,\ \dot z=\alpha\dot x-\beta\gamma|\dot x||z|^{\nu-1}z-\beta\delta\,\dot x|z|^{\nu}"
    )
    source: ClassVar[str] = "Wen 1976, doi:10.1061/JMCEA3.0002106; Noel and Schoukens 2016"
    left_out: ClassVar[str] = "loops in force against displacement whose width grows with amplitude, at any speed"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """z / alpha in m along the displacement from z = 0 at t[0], one straight step a sample."""
        z, out = 0.0, np.zeros(x.size)
        for i, move in enumerate(np.diff(x)):
            size = abs(z) ** self.exponent
            z += self.alpha * move - self.loop * abs(move) * size * np.sign(z) - self.skew * move * size
            out[i + 1] = z
        return out / self.alpha


_OWN: tuple[type[Term], ...] = (ConstantForce, AsymmetricDamping, BoucWen)


@dataclass(frozen=True)
class DrivenUnknown:
    """A parameter of a law in the driven integrator: its name, law.parameter, its row and the name of its slot."""

    name: str
    parameter: Parameter
    slot: str
    term: Term


def find_driven(name: str, **inner: float) -> Term:
    """The law of that name for a driven body: the registry's and those of this file.

    Raises ConfigError where there is none, or where its force has a clock of its own, which no driven trial fits.

    >>> find_driven("bouc_wen").name
    'bouc_wen'
    """
    for own in _OWN:
        if own.name == name:
            return own(**inner)
    term = registry.find(name, **inner)
    if term.kind in ("input", "delay"):
        raise ConfigError(f"equation term {name!r} beside a measured input is not fitted; leave it out")
    return term


def places(terms: Sequence[Term], moving: bool = False) -> tuple[DrivenUnknown, ...]:
    """Every parameter of the laws with its slot, in order; a second hidden oscillator's go to the second one's slots.

    ``moving`` says that the base moves, so that laws of the water have slots of their own. Raises ConfigError where the
    integrator does not hold a law, or not so many of it, or not beside a moving base.
    """
    seen: dict[str, int] = {}
    out = []
    for term in terms:
        seen[term.name] = count = seen.get(term.name, 0) + 1
        if not term.slots or count > (term.held_by_kernel or 1):
            raise ConfigError(f"equation term {term.name!r} number {count} has no place in the driven integrator")
        if moving and term.relative_to == "water" and not set(term.slots.values()) <= set(THROUGH_WATER):
            raise ConfigError(
                f"equation term {term.name!r} goes with the velocity through water, and on a moving base only "
                "quadratic_drag, linear_damping and cubic_damping of these are integrated; choose one of them"
            )
        many = sum(t.name == term.name for t in terms) > 1
        suffix = str(count) if term.held_by_kernel else ""
        label = f"{term.name}{count}" if many else term.name
        wet = THROUGH_WATER if moving and term.relative_to == "water" else {}
        for parameter in term.parameters:
            slot = term.slots[parameter.name]
            out.append(DrivenUnknown(f"{label}.{parameter.name}", parameter, wet.get(slot, slot) + suffix, term))
    return tuple(out)
