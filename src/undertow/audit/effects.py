"""Names of effects that a table's rivals add to Eq. 15, and of their unknowns, where a law of the registry is meant.

Belongs here: those names. Does not belong here: priors and ranges (rivals.py).
"""

from __future__ import annotations

from undertow.equation.hidden import HiddenResonator
from undertow.equation.hydrodynamics import LinearDamping
from undertow.equation.structure import CoulombFriction

LINEAR, FRICTION, RESONATOR = LinearDamping.name, CoulombFriction.name, HiddenResonator.name
"""Damping of the water's, friction beyond the structure's own, a mass of water that swings."""

DAMPING = f"{LINEAR}.{LinearDamping.parameters[0].name}"
FRICTION_FORCE = f"{FRICTION}.{CoulombFriction.parameters[0].name}"
RESONATOR_MASS, RESONATOR_FREQUENCY, RESONATOR_DAMPING_RATIO = (
    f"{RESONATOR}.{parameter.name}" for parameter in HiddenResonator.parameters[:3]
)
"""Their unknowns."""
