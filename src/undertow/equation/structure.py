"""Laws of the structure itself: springs, dampers, friction.

Belongs here: algebraic laws of x and v. Does not belong here: water (hydrodynamics.py), memory (hidden.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from undertow.equation.hydrodynamics import LinearDamping
from undertow.equation.term import Published, Term
from undertow.quantities import Parameter


@dataclass(frozen=True)
class Stiffness(Term):
    """Linear spring, F = k x (report Eq. 1).

    >>> import numpy as np
    >>> Stiffness().force(np.array([0.1]), np.zeros(1), np.zeros(1), np.zeros(1))
    array([0.1])
    """

    name = "stiffness"
    parameters = (Parameter("k_N_per_m", "N/m", "k", lower=0.0),)
    slots: ClassVar[Mapping[str, str]] = {"k_N_per_m": "k1"}
    law = "k x"
    latex = r"k x"
    smooth = "k_N_per_m * x"
    source = "Hooke; report Eq. 1"
    left_out = "nothing oscillates without it"
    pulls_back = True
    is_spring = True
    linear = True
    structural = "k"
    published = Published("k_N_per_m", "N/m")
    sprung = True
    element = "elastic"

    def start(self, mass: float, rate: float, speed: float) -> float:
        """What swings the whole mass at its rate."""
        return mass * rate**2


@dataclass(frozen=True)
class ViscousDamping(Term):
    """Linear viscous damping of the structure, F = c v (report Eq. 1)."""

    name = "viscous_damping"
    parameters = (Parameter("c_Ns_per_m", "N s/m", "c", lower=0.0),)
    slots: ClassVar[Mapping[str, str]] = {"c_Ns_per_m": "c1"}
    law = "c v"
    latex = r"c \dot{x}"
    smooth = "c_Ns_per_m * v"
    source = "report Eq. 1"
    left_out = "the logarithm of the amplitude falls too slowly by the same amount every cycle"
    dissipates = True
    linear = True
    structural = "c"
    published = Published("c_Ns_per_m", "N s/m")
    speed_power = 1.0
    missing_as = LinearDamping.name
    element = "dashpot"

    def start(self, mass: float, rate: float, speed: float) -> float:
        """One per cent of critical damping."""
        return 0.02 * mass * rate


@dataclass(frozen=True)
class CoulombFriction(Term):
    """Dry friction of constant size, F = F_c sign(v); F_c = mu (m g - V rho g) on rails (report Eqs. 1 and 15)."""

    name = "coulomb_friction"
    parameters = (Parameter("force_N", "N", "F_c", lower=0.0),)
    slots: ClassVar[Mapping[str, str]] = {"force_N": "fc"}
    law = "F_c sign(v)"
    latex = r"F_c\,\mathrm{sgn}(\dot{x})"
    friction = "force_N"
    source = "Coulomb; report Eq. 15"
    left_out = "peaks fall by a constant step a cycle; strongest in the small-amplitude tail"
    causes = "dry friction of rails, bearings and seals"
    dissipates = True
    structural = "mu"
    published = Published("friction_N", "N", "mu", "normal_force_N")
    words = "dry friction beyond what the equation has"
    words_alone = "dry friction"
    element = "slider"

    def start(self, mass: float, rate: float, speed: float) -> float:
        """A five hundredth of the inertia force at full motion."""
        return 2e-3 * (mass * rate * speed)

    def materials(self, coefficient: float, sticking: float) -> tuple[str, ...]:
        """A stiff spring that yields, and starts where the body is held."""
        gives = coefficient / sticking
        slack = f"float(np.clip(pull, -{coefficient!r}, {coefficient!r})) / {sticking!r}"
        return (f"'ElasticPP', TAG, {sticking!r}, {gives!r}, -{gives!r}, {slack}",)


@dataclass(frozen=True)
class CubicStiffness(Term):
    """Hardening (k3 > 0) or softening (k3 < 0) spring, F = k3 x^3 (Duffing)."""

    name = "cubic_stiffness"
    parameters = (Parameter("N_per_m3", "N/m^3", "k_3"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m3": "k3"}
    law = "k_3 x^3"
    latex = r"k_3 x^3"
    smooth = "N_per_m3 * x**3"
    source = "Duffing 1918"
    left_out = "frequency shifts with the square of the amplitude; third harmonic"
    causes = "springs that harden or soften, a support that bends, geometry or buoyancy that changes with displacement"
    pulls_back = True
    words = "stiffness with the cube of the displacement"
    looks_like = "added mass that goes with the amplitude"
    sprung = True
    element = "elastic"


@dataclass(frozen=True)
class QuinticStiffness(Term):
    """F = k5 x^5."""

    name = "quintic_stiffness"
    parameters = (Parameter("N_per_m5", "N/m^5", "k_5"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m5": "k5"}
    law = "k_5 x^5"
    latex = r"k_5 x^5"
    smooth = "N_per_m5 * x**5"
    source = "roll restoring arm, e.g. Himeno 1981"
    left_out = "frequency shifts with the fourth power of the amplitude, at the largest only"
    causes = "a restoring force that changes at the largest displacements, as stops and sloping sides do"
    pulls_back = True
    words = "stiffness with the fifth power of the displacement"
    looks_like = "added mass that goes with the amplitude"
    sprung = True
    element = "elastic"


@dataclass(frozen=True)
class AsymmetricStiffness(Term):
    """F = k2 x^2: stiffer to one side."""

    name = "asymmetric_stiffness"
    parameters = (Parameter("N_per_m2", "N/m^2", "k_2"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m2": "k2"}
    law = "k_2 x^2"
    latex = r"k_2 x^2"
    smooth = "N_per_m2 * x**2"
    source = "Helmholtz oscillator"
    left_out = "mean position moves with the square of the amplitude; second harmonic"
    causes = "a spring slack to one side, a contact, or buoyancy that differs from side to side"
    words = "a spring stiffer to one side"
    sprung = True
    element = "elastic"


@dataclass(frozen=True)
class StiffnessDrift(Term):
    """Stiffness that changes with the time since the release, F = k_d x (1 - exp(-t / tau_d)).

    A spring that warms up or settles does this; a body that loses or takes on mass shifts its frequency alike, and no
    decay tells the two apart: a decay knows k / M alone.

    >>> import numpy as np
    >>> moved = StiffnessDrift(time_s=2.0).force(np.ones(2), np.zeros(2), np.zeros(2), np.array([0.0, 2.0]))
    >>> moved.round(3).tolist()
    [0.0, 0.632]
    """

    time_s: float = 10.0
    name = "stiffness_drift"
    kind = "input"
    parameters = (
        Parameter("N_per_m", "N/m", "k_d"),
        Parameter("time_s", "s", r"\tau_d", lower=1e-3),
    )
    slots: ClassVar[Mapping[str, str]] = {"N_per_m": "kd", "time_s": "td"}
    law = "k_d x (1 - exp(-t / tau_d))"
    latex = r"k_d x\,(1-e^{-t/\tau_d})"
    smooth = "N_per_m * x * (1 - exp(-t / time_s))"
    source = "a first-order change towards a new stiffness"
    left_out = "frequency shifts with the time since the release, alike in large and small releases"
    words = "a stiffness or a mass that changes during each trial"
    next_test = "a small release as soon after a large one as can be, and one after a long rest"
    several_causes = True


@dataclass(frozen=True)
class QuadraticStiffness(Term):
    """F = ka x|x|: symmetric, between linear and cubic."""

    name = "quadratic_stiffness"
    parameters = (Parameter("N_per_m2", "N/m^2", "k_a"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m2": "ka"}
    law = "k_a x |x|"
    latex = r"k_a x|x|"
    smooth = "N_per_m2 * (x * Abs(x))"
    source = "geometric slack of cables"
    left_out = "frequency shifts in proportion to the amplitude"
    pulls_back = True
    missing_as = CubicStiffness.name
    sprung = True
    element = "elastic"


@dataclass(frozen=True)
class SineRestoring(Term):
    """Pendulum, M = ks sin(x), x in rad (coordinate: rotation)."""

    name = "sine_restoring"
    parameters = (Parameter("N", "N", "k_s"),)
    slots: ClassVar[Mapping[str, str]] = {"N": "ks"}
    law = "k_s sin(x)"
    latex = r"k_s \sin x"
    smooth = "N * sin(x)"
    source = "Huygens 1673"
    left_out = "period grows with amplitude as a pendulum's: softening at every amplitude"
    pulls_back = True
    is_spring = True
    linear = True
    instead_of = (Stiffness.name, CubicStiffness.name, QuinticStiffness.name)
    words = "a restoring force like the sine of the angle"
    element = "elastic"

    def start(self, mass: float, rate: float, speed: float) -> float:
        """What swings the whole mass at its rate."""
        return mass * rate**2


@dataclass(frozen=True)
class PositionDamping(Term):
    """F = c_x x v: damping that differs from side to side."""

    name = "position_damping"
    parameters = (Parameter("Ns_per_m2", "N s/m^2", "c_x"),)
    slots: ClassVar[Mapping[str, str]] = {"Ns_per_m2": "xv"}
    law = "c_x x v"
    latex = r"c_x x\dot{x}"
    smooth = "Ns_per_m2 * (x * v)"
    source = "polynomial library"
    left_out = "mean position moves; second harmonic in quadrature"


@dataclass(frozen=True)
class VanDerPolDamping(Term):
    """F = c_xx x^2 v: damping that grows with the square of the displacement (van der Pol)."""

    name = "van_der_pol_damping"
    parameters = (Parameter("Ns_per_m3", "N s/m^3", "c_{xx}"),)
    slots: ClassVar[Mapping[str, str]] = {"Ns_per_m3": "xxv"}
    law = "c_xx x^2 v"
    latex = r"c_{xx} x^2\dot{x}"
    smooth = "Ns_per_m3 * (x**2 * v)"
    source = "van der Pol 1926"
    left_out = "decrement falls with the square of the amplitude"


@dataclass(frozen=True)
class StribeckFriction(Term):
    """Extra friction at low speed, F = F_s exp(-(v/v_s)^2) sign(v), on top of the Coulomb force.

    ``static_force_N`` is what sticking holds beyond the Coulomb force; ``velocity_m_per_s`` where it has faded.
    """

    velocity_m_per_s: float = 0.01
    name = "stribeck_friction"
    parameters = (
        Parameter("static_force_N", "N", "F_s"),
        Parameter("velocity_m_per_s", "m/s", "v_s", lower=1e-5),
    )
    slots: ClassVar[Mapping[str, str]] = {"static_force_N": "fs", "velocity_m_per_s": "vs"}
    law = "F_s exp(-(v / v_s)^2) sign(v)"
    latex = r"F_s e^{-(\dot{x}/v_s)^2}\mathrm{sgn}(\dot{x})"
    friction = "static_force_N * exp(-((v / velocity_m_per_s) ** 2))"
    source = "Armstrong-Helouvry et al. 1994, doi:10.1016/0005-1098(94)90209-7"
    left_out = "residual only around the turning points; motion stops earlier than predicted"
    causes = "seals, lubricated bearings, or rails that stick"
    words = "friction that is larger at low speed"


@dataclass(frozen=True)
class AsymmetricFriction(Term):
    """F = F_a |sign(v)|: friction F_c + F_a moving one way, F_c - F_a the other.

    In a free decay that is a rest offset of -F_a / k: the band in which friction holds the body moves along.
    """

    name = "asymmetric_friction"
    parameters = (Parameter("force_N", "N", "F_a"),)
    slots: ClassVar[Mapping[str, str]] = {"force_N": "fa"}
    law = "F_a |sign(v)|"
    latex = r"F_a\,|\mathrm{sgn}(\dot{x})|"
    friction = "force_N * d"
    source = "direction-dependent rails"
    left_out = "oscillation centred away from where the springs are at rest, as by a rest offset"


@dataclass(frozen=True)
class VariableNormalForce(Term):
    """F = n |x| sign(v): friction whose normal force grows with displacement (or amplitude-proportional hysteresis)."""

    name = "variable_normal_force"
    parameters = (Parameter("N_per_m", "N/m", "n"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m": "fn"}
    law = "n |x| sign(v)"
    latex = r"n|x|\,\mathrm{sgn}(\dot{x})"
    friction = "N_per_m * Abs(x)"
    source = "Anderson and Ferri 1990, doi:10.1115/1.2896046"
    left_out = "decrement independent of amplitude, with force kinks at turning points growing with amplitude"
    causes = "rails that press harder off centre, or hysteresis in proportion to the amplitude"
    words = "friction that grows with displacement"
