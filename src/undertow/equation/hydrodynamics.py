"""Laws of the water that depend on the body's motion at the same instant.

Belongs here: added mass, drag and its rivals. Does not belong here: water with a motion of its own (hidden.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from undertow.equation.term import Array, Published, Term
from undertow.quantities import Parameter


@dataclass(frozen=True)
class AddedMass(Term):
    """Water that moves with the body, F = m_a x'' (report Eq. 15; Morison et al. 1950)."""

    name = "added_mass"
    parameters = (Parameter("mass_kg", "kg", "m_a"),)
    slots: ClassVar[Mapping[str, str]] = {"mass_kg": "mass"}
    law = "m_a x''"
    latex = r"m_a \ddot{x}"
    source = "Morison et al. 1950, doi:10.2118/950149-G; report Eq. 15"
    left_out = "wet trials slower than dry ones by the same ratio at every amplitude"
    causes = "water that moves along or mass that was not counted"
    is_inertia = True
    linear = True
    of_water = True
    relative_to = "water"
    published = Published("added_mass_kg", "kg")
    words = "water that moves with the body"
    words_alone = "mass that moves with the body"
    element = "inertia"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """a, in m/s^2."""
        return 1.0 * a

    def start(self, mass: float, rate: float, speed: float) -> float:
        """A tenth of the total mass."""
        return 0.1 * mass


@dataclass(frozen=True)
class AddedStiffness(Term):
    """Stiffness that the water adds to the springs', F = k_w x: hydrostatics of a body that pierces the surface.

    On one spring it cannot be told from an added mass: a decay knows their ratio alone. Two springs tell it from a
    constant one, but not from water that oscillates far above both.
    """

    name = "added_stiffness"
    parameters = (Parameter("N_per_m", "N/m", "k_w"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m": "k1"}
    law = "k_w x"
    latex = r"k_w x"
    smooth = "N_per_m * x"
    source = "hydrostatic restoring, e.g. Newman 1977 ch. 6"
    left_out = "an added mass that depends on the spring: too small on the soft one"
    pulls_back = True
    of_water = True
    relative_to = "earth"
    words = "stiffness that the water adds to the springs'"
    words_alone = "stiffness beyond the springs'"
    next_test = (
        "a slow push in this water, force and displacement recorded: a stiffness is there at rest, an added mass that "
        "depends on the frequency is not"
    )
    element = "elastic"


@dataclass(frozen=True)
class QuadraticDrag(Term):
    """Drag, F = q v|v| with q = rho A C_d / 2 (report Eq. 15)."""

    name = "quadratic_drag"
    parameters = (Parameter("drag_Ns2_per_m2", "N s^2/m^2", "q", lower=0.0),)
    slots: ClassVar[Mapping[str, str]] = {"drag_Ns2_per_m2": "q"}
    law = "q v |v|"
    latex = r"q\,\dot{x}|\dot{x}|"
    smooth = "drag_Ns2_per_m2 * (v**2 * d)"
    source = "Morison et al. 1950; report Eq. 15"
    left_out = "decrement rises with amplitude in proportion"
    causes = "flow that separates at edges, or orifices"
    dissipates = True
    of_water = True
    relative_to = "water"
    of_area = True
    published = Published(
        "drag_Ns2_per_m2", "N s^2/m^2", "drag_coefficient", "drag_N_per_unit_coefficient"
    )
    speed_power = 2.0
    words = "drag with the square of the speed"
    element = "dashpot"

    def start(self, mass: float, rate: float, speed: float) -> float:
        """Drag that makes a fiftieth of the inertia force at full speed."""
        return 0.02 * mass * rate / speed


@dataclass(frozen=True)
class LinearDamping(Term):
    """Linear damping beyond the structure's own, F = c_w v: waves radiated at the body's frequency, laminar shear."""

    name = "linear_damping"
    parameters = (Parameter("c_Ns_per_m", "N s/m", "c_w"),)
    slots: ClassVar[Mapping[str, str]] = {"c_Ns_per_m": "c1"}
    law = "c_w v"
    latex = r"c_w \dot{x}"
    smooth = "c_Ns_per_m * v"
    source = "radiation damping, e.g. Newman 1977 ch. 6"
    left_out = "decrement too small by the same amount at every amplitude; a fitted C_d that falls with amplitude"
    causes = "radiated waves, shear at walls, or any memory much shorter than a period"
    dissipates = True
    of_water = True
    relative_to = "water"
    speed_power = 1.0
    words = "linear damping beyond the structure's own"
    words_alone = "linear damping"
    next_test = "a longer decay from a small release, where drag has faded and linear damping has not"
    element = "dashpot"


@dataclass(frozen=True)
class CubicDamping(Term):
    """F = c3 v^3."""

    name = "cubic_damping"
    parameters = (Parameter("Ns3_per_m3", "N s^3/m^3", "c_3"),)
    slots: ClassVar[Mapping[str, str]] = {"Ns3_per_m3": "c3"}
    law = "c_3 v^3"
    latex = r"c_3 \dot{x}^3"
    smooth = "Ns3_per_m3 * v**3"
    source = "Himeno 1981"
    left_out = "decrement rises with the square of the amplitude"
    causes = "drag that grows faster than with the square of the speed, or friction that grows with the load"
    dissipates = True
    of_water = True
    relative_to = "water"
    speed_power = 3.0
    words = "damping with the cube of the speed"
    element = "dashpot"


@dataclass(frozen=True)
class AsymmetricDamping(Term):
    """F = c_a |v|: damping c + c_a moving one way, c - c_a the other; it takes no energy from a symmetric swing.

    Valves that open one way, and drag of a body that swings faster than the stream around it (of which it is the part
    that goes with the stream's speed).

    >>> import numpy as np
    >>> AsymmetricDamping().force(np.zeros(2), np.array([-0.2, 0.2]), np.zeros(2), np.zeros(2)).tolist()
    [0.2, 0.2]
    """

    name = "asymmetric_damping"
    parameters = (Parameter("c_Ns_per_m", "N s/m", "c_a"),)
    slots: ClassVar[Mapping[str, str]] = {"c_Ns_per_m": "cb"}
    law = "c_a |v|"
    latex = r"c_a\,|\dot{x}|"
    smooth = "c_Ns_per_m * (v * d)"
    source = "Armstrong-Helouvry et al. 1994, doi:10.1016/0005-1098(94)90209-7"
    left_out = "mean position moves with the amplitude; second harmonic"
    causes = "a valve that opens one way, or a current past the body"
    words = "damping that differs with the direction of motion"
    next_test = "releases to the other side: what differs with the direction changes sides"
    suspect_of = "water"


@dataclass(frozen=True)
class AsymmetricDrag(Term):
    """F = d_a v^2: drag d + d_a moving one way, d - d_a the other; it takes no energy from a symmetric swing."""

    name = "asymmetric_drag"
    parameters = (Parameter("drag_Ns2_per_m2", "N s^2/m^2", "d_a"),)
    slots: ClassVar[Mapping[str, str]] = {"drag_Ns2_per_m2": "qa"}
    law = "d_a v^2"
    latex = r"d_a \dot{x}^2"
    smooth = "drag_Ns2_per_m2 * v**2"
    source = "drag of bodies that are not alike fore and aft, e.g. Hoerner 1965, Fluid-Dynamic Drag, ch. 3"
    left_out = "mean position moves with the square of the amplitude; second harmonic"
    causes = "a body that is not alike fore and aft"
    relative_to = "water"
    words = "drag that differs with the direction of motion"
    next_test = "releases to the other side: what differs with the direction changes sides"
    suspect_of = "water"


@dataclass(frozen=True)
class DragExponent(Term):
    """Drag with another exponent, F = d |v|^p sign(v); p = 2 is quadratic drag, 1 linear, 0 friction.

    Below p = 1 the slope of the law is infinite at v = 0: the motion stays exact, its sensitivities are good to 3 %
    down to p = 0.5 and useless below.
    """

    exponent: float = 1.5
    name = "drag_exponent"
    parameters = (
        Parameter("coefficient_N_sp_per_mp", "N (s/m)^p", "d", lower=0.0),
        Parameter("exponent", "1", "p", lower=0.5, upper=4.0),
    )
    slots: ClassVar[Mapping[str, str]] = {"coefficient_N_sp_per_mp": "cp", "exponent": "p"}
    law = "d |v|^p sign(v)"
    latex = r"d\,|\dot{x}|^{p}\,\mathrm{sgn}(\dot{x})"
    smooth = "coefficient_N_sp_per_mp * Abs(v) ** exponent * d"
    source = "power-law damping, e.g. Elliott et al. 2015, doi:10.1016/j.jsv.2015.05.003"
    left_out = "a drag coefficient that follows a power of the amplitude"
    causes = "a flow between laminar and turbulent, or drag whose coefficient goes with the amplitude"
    of_water = True
    relative_to = "water"
    words = "drag with another power of the speed"
    element = "dashpot"

    def materials(self, coefficient: float, sticking: float) -> tuple[str, ...]:
        """A dashpot with an exponent."""
        return (f"'Viscous', TAG, {coefficient!r}, {self.exponent!r}",)
