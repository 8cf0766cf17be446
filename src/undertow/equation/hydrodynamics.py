"""Laws of the water that depend on the body's motion at the same instant.

Belongs here: added mass, drag and its rivals. Does not belong here: water with a motion of its own (hidden.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from undertow.equation.term import Array, Element, Published, Term
from undertow.quantities import Parameter


@dataclass(frozen=True)
class AddedMass(Term):
    """Water that moves with the body, F = m_a x'' (report Eq. 15; Morison et al. 1950)."""

    name: ClassVar[str] = "added_mass"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("mass_kg", "kg", "m_a"),)
    slots: ClassVar[Mapping[str, str]] = {"mass_kg": "mass"}
    law: ClassVar[str] = "m_a x''"
    latex: ClassVar[str] = r"m_a \ddot{x}"
    source: ClassVar[str] = "Morison et al. 1950, doi:10.2118/950149-G; report Eq. 15"
    left_out: ClassVar[str] = "wet trials slower than dry ones by the same ratio at every amplitude"
    is_inertia: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    of_water: ClassVar[bool] = True
    relative_to: ClassVar = "water"
    published: ClassVar[Published] = Published("added_mass_kg", "kg")
    words: ClassVar[str] = "water that moves with the body"
    words_alone: ClassVar[str] = "mass that moves with the body"
    element: ClassVar[Element] = "inertia"

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

    name: ClassVar[str] = "added_stiffness"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("N_per_m", "N/m", "k_w"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m": "k1"}
    law: ClassVar[str] = "k_w x"
    latex: ClassVar[str] = r"k_w x"
    smooth: ClassVar[str] = "N_per_m * x"
    source: ClassVar[str] = "hydrostatic restoring, e.g. Newman 1977 ch. 6"
    left_out: ClassVar[str] = "an added mass that depends on the spring: too small on the soft one"
    pulls_back: ClassVar[bool] = True
    of_water: ClassVar[bool] = True
    relative_to: ClassVar = "earth"
    words: ClassVar[str] = "stiffness that the water adds to the springs'"
    words_alone: ClassVar[str] = "stiffness beyond the springs'"
    next_test: ClassVar[str] = (
        "a slow push in this water, force and displacement recorded: a stiffness is there at rest, an added mass that "
        "depends on the frequency is not"
    )
    element: ClassVar[Element] = "elastic"


@dataclass(frozen=True)
class QuadraticDrag(Term):
    """Drag, F = q v|v| with q = rho A C_d / 2 (report Eq. 15)."""

    name: ClassVar[str] = "quadratic_drag"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("drag_Ns2_per_m2", "N s^2/m^2", "q", lower=0.0),)
    slots: ClassVar[Mapping[str, str]] = {"drag_Ns2_per_m2": "q"}
    law: ClassVar[str] = "q v |v|"
    latex: ClassVar[str] = r"q\,\dot{x}|\dot{x}|"
    smooth: ClassVar[str] = "drag_Ns2_per_m2 * (v**2 * d)"
    source: ClassVar[str] = "Morison et al. 1950; report Eq. 15"
    left_out: ClassVar[str] = "decrement rises with amplitude in proportion"
    dissipates: ClassVar[bool] = True
    of_water: ClassVar[bool] = True
    relative_to: ClassVar = "water"
    of_area: ClassVar[bool] = True
    published: ClassVar[Published] = Published(
        "drag_Ns2_per_m2", "N s^2/m^2", "drag_coefficient", "drag_N_per_unit_coefficient"
    )
    speed_power: ClassVar[float] = 2.0
    words: ClassVar[str] = "drag with the square of the speed"
    element: ClassVar[Element] = "dashpot"

    def start(self, mass: float, rate: float, speed: float) -> float:
        """Drag that makes a fiftieth of the inertia force at full speed."""
        return 0.02 * mass * rate / speed


@dataclass(frozen=True)
class LinearDamping(Term):
    """Linear damping beyond the structure's own, F = c_w v: waves radiated at the body's frequency, laminar shear."""

    name: ClassVar[str] = "linear_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("c_Ns_per_m", "N s/m", "c_w"),)
    slots: ClassVar[Mapping[str, str]] = {"c_Ns_per_m": "c1"}
    law: ClassVar[str] = "c_w v"
    latex: ClassVar[str] = r"c_w \dot{x}"
    smooth: ClassVar[str] = "c_Ns_per_m * v"
    source: ClassVar[str] = "radiation damping, e.g. Newman 1977 ch. 6"
    left_out: ClassVar[str] = (
        "decrement too small by the same amount at every amplitude; a fitted C_d that falls with amplitude"
    )
    dissipates: ClassVar[bool] = True
    of_water: ClassVar[bool] = True
    relative_to: ClassVar = "water"
    speed_power: ClassVar[float] = 1.0
    words: ClassVar[str] = "linear damping beyond the structure's own"
    words_alone: ClassVar[str] = "linear damping"
    next_test: ClassVar[str] = "a longer decay from a small release, where drag has faded and linear damping has not"
    element: ClassVar[Element] = "dashpot"


@dataclass(frozen=True)
class CubicDamping(Term):
    """F = c3 v^3."""

    name: ClassVar[str] = "cubic_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("Ns3_per_m3", "N s^3/m^3", "c_3"),)
    slots: ClassVar[Mapping[str, str]] = {"Ns3_per_m3": "c3"}
    law: ClassVar[str] = "c_3 v^3"
    latex: ClassVar[str] = r"c_3 \dot{x}^3"
    smooth: ClassVar[str] = "Ns3_per_m3 * v**3"
    source: ClassVar[str] = "Himeno 1981"
    left_out: ClassVar[str] = "decrement rises with the square of the amplitude"
    dissipates: ClassVar[bool] = True
    of_water: ClassVar[bool] = True
    relative_to: ClassVar = "water"
    speed_power: ClassVar[float] = 3.0
    words: ClassVar[str] = "damping with the cube of the speed"
    element: ClassVar[Element] = "dashpot"


@dataclass(frozen=True)
class DragExponent(Term):
    """Drag with another exponent, F = d |v|^p sign(v); p = 2 is quadratic drag, 1 linear, 0 friction.

    Below p = 1 the slope of the law is infinite at v = 0: the motion stays exact, its sensitivities are good to 3 %
    down to p = 0.5 and useless below.
    """

    exponent: float = 1.5
    name: ClassVar[str] = "drag_exponent"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("coefficient_N_sp_per_mp", "N (s/m)^p", "d", lower=0.0),
        Parameter("exponent", "1", "p", lower=0.5, upper=4.0),
    )
    slots: ClassVar[Mapping[str, str]] = {"coefficient_N_sp_per_mp": "cp", "exponent": "p"}
    law: ClassVar[str] = "d |v|^p sign(v)"
    latex: ClassVar[str] = r"d\,|\dot{x}|^{p}\,\mathrm{sgn}(\dot{x})"
    smooth: ClassVar[str] = "coefficient_N_sp_per_mp * Abs(v) ** exponent * d"
    source: ClassVar[str] = "power-law damping, e.g. Elliott et al. 2015, doi:10.1016/j.jsv.2015.05.003"
    left_out: ClassVar[str] = "a drag coefficient that follows a power of the amplitude"
    of_water: ClassVar[bool] = True
    relative_to: ClassVar = "water"
    words: ClassVar[str] = "drag with another power of the speed"
    element: ClassVar[Element] = "dashpot"

    def materials(self, coefficient: float, sticking: float) -> tuple[str, ...]:
        """A dashpot with an exponent."""
        return (f"'Viscous', TAG, {coefficient!r}, {self.exponent!r}",)
