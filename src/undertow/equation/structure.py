"""Laws of the structure itself: springs, dampers, friction.

Belongs here: algebraic laws of x and v. Does not belong here: water (hydrodynamics.py), memory (hidden.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from undertow.equation.hydrodynamics import LinearDamping
from undertow.equation.term import Element, Published, Term
from undertow.quantities import Parameter


@dataclass(frozen=True)
class Stiffness(Term):
    """Linear spring, F = k x (report Eq. 1).

    >>> import numpy as np
    >>> Stiffness().force(np.array([0.1]), np.zeros(1), np.zeros(1), np.zeros(1))
    array([0.1])
    """

    name: ClassVar[str] = "stiffness"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("k_N_per_m", "N/m", "k", lower=0.0),)
    slots: ClassVar[Mapping[str, str]] = {"k_N_per_m": "k1"}
    law: ClassVar[str] = "k x"
    latex: ClassVar[str] = r"k x"
    smooth: ClassVar[str] = "k_N_per_m * x"
    source: ClassVar[str] = "Hooke; report Eq. 1"
    left_out: ClassVar[str] = "nothing oscillates without it"
    pulls_back: ClassVar[bool] = True
    is_spring: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    structural: ClassVar[str] = "k"
    published: ClassVar[Published] = Published("k_N_per_m", "N/m")
    sprung: ClassVar[bool] = True
    element: ClassVar[Element] = "elastic"

    def start(self, mass: float, rate: float, speed: float) -> float:
        """What swings the whole mass at its rate."""
        return mass * rate**2


@dataclass(frozen=True)
class ViscousDamping(Term):
    """Linear viscous damping of the structure, F = c v (report Eq. 1)."""

    name: ClassVar[str] = "viscous_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("c_Ns_per_m", "N s/m", "c", lower=0.0),)
    slots: ClassVar[Mapping[str, str]] = {"c_Ns_per_m": "c1"}
    law: ClassVar[str] = "c v"
    latex: ClassVar[str] = r"c \dot{x}"
    smooth: ClassVar[str] = "c_Ns_per_m * v"
    source: ClassVar[str] = "report Eq. 1"
    left_out: ClassVar[str] = "the logarithm of the amplitude falls too slowly by the same amount every cycle"
    dissipates: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    structural: ClassVar[str] = "c"
    published: ClassVar[Published] = Published("c_Ns_per_m", "N s/m")
    speed_power: ClassVar[float] = 1.0
    missing_as: ClassVar[str] = LinearDamping.name
    element: ClassVar[Element] = "dashpot"

    def start(self, mass: float, rate: float, speed: float) -> float:
        """One per cent of critical damping."""
        return 0.02 * mass * rate


@dataclass(frozen=True)
class CoulombFriction(Term):
    """Dry friction of constant size, F = F_c sign(v); F_c = mu (m g - V rho g) on rails (report Eqs. 1 and 15)."""

    name: ClassVar[str] = "coulomb_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("force_N", "N", "F_c", lower=0.0),)
    slots: ClassVar[Mapping[str, str]] = {"force_N": "fc"}
    law: ClassVar[str] = "F_c sign(v)"
    latex: ClassVar[str] = r"F_c\,\mathrm{sgn}(\dot{x})"
    friction: ClassVar[str] = "force_N"
    source: ClassVar[str] = "Coulomb; report Eq. 15"
    left_out: ClassVar[str] = "peaks fall by a constant step a cycle; strongest in the small-amplitude tail"
    dissipates: ClassVar[bool] = True
    structural: ClassVar[str] = "mu"
    published: ClassVar[Published] = Published("friction_N", "N", "mu", "normal_force_N")
    words: ClassVar[str] = "dry friction beyond what the equation has"
    words_alone: ClassVar[str] = "dry friction"
    element: ClassVar[Element] = "slider"

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

    name: ClassVar[str] = "cubic_stiffness"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("N_per_m3", "N/m^3", "k_3"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m3": "k3"}
    law: ClassVar[str] = "k_3 x^3"
    latex: ClassVar[str] = r"k_3 x^3"
    smooth: ClassVar[str] = "N_per_m3 * x**3"
    source: ClassVar[str] = "Duffing 1918"
    left_out: ClassVar[str] = "frequency shifts with the square of the amplitude; third harmonic"
    pulls_back: ClassVar[bool] = True
    words: ClassVar[str] = "stiffness with the cube of the displacement"
    sprung: ClassVar[bool] = True
    element: ClassVar[Element] = "elastic"


@dataclass(frozen=True)
class QuinticStiffness(Term):
    """F = k5 x^5."""

    name: ClassVar[str] = "quintic_stiffness"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("N_per_m5", "N/m^5", "k_5"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m5": "k5"}
    law: ClassVar[str] = "k_5 x^5"
    latex: ClassVar[str] = r"k_5 x^5"
    smooth: ClassVar[str] = "N_per_m5 * x**5"
    source: ClassVar[str] = "roll restoring arm, e.g. Himeno 1981"
    left_out: ClassVar[str] = "frequency shifts with the fourth power of the amplitude, at the largest only"
    pulls_back: ClassVar[bool] = True
    words: ClassVar[str] = "stiffness with the fifth power of the displacement"
    sprung: ClassVar[bool] = True
    element: ClassVar[Element] = "elastic"


@dataclass(frozen=True)
class AsymmetricStiffness(Term):
    """F = k2 x^2: stiffer to one side."""

    name: ClassVar[str] = "asymmetric_stiffness"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("N_per_m2", "N/m^2", "k_2"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m2": "k2"}
    law: ClassVar[str] = "k_2 x^2"
    latex: ClassVar[str] = r"k_2 x^2"
    smooth: ClassVar[str] = "N_per_m2 * x**2"
    source: ClassVar[str] = "Helmholtz oscillator"
    left_out: ClassVar[str] = "mean position moves with the square of the amplitude; second harmonic"
    words: ClassVar[str] = "a spring stiffer to one side"
    sprung: ClassVar[bool] = True
    element: ClassVar[Element] = "elastic"


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
    name: ClassVar[str] = "stiffness_drift"
    kind: ClassVar = "input"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("N_per_m", "N/m", "k_d"),
        Parameter("time_s", "s", r"\tau_d", lower=1e-3),
    )
    slots: ClassVar[Mapping[str, str]] = {"N_per_m": "kd", "time_s": "td"}
    law: ClassVar[str] = "k_d x (1 - exp(-t / tau_d))"
    latex: ClassVar[str] = r"k_d x\,(1-e^{-t/\tau_d})"
    smooth: ClassVar[str] = "N_per_m * x * (1 - exp(-t / time_s))"
    source: ClassVar[str] = "a first-order change towards a new stiffness"
    left_out: ClassVar[str] = "frequency shifts with the time since the release, alike in large and small releases"
    words: ClassVar[str] = "a stiffness or a mass that changes during each trial"
    next_test: ClassVar[str] = "a small release as soon after a large one as can be, and one after a long rest"
    several_causes: ClassVar[bool] = True


@dataclass(frozen=True)
class QuadraticStiffness(Term):
    """F = ka x|x|: symmetric, between linear and cubic."""

    name: ClassVar[str] = "quadratic_stiffness"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("N_per_m2", "N/m^2", "k_a"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m2": "ka"}
    law: ClassVar[str] = "k_a x |x|"
    latex: ClassVar[str] = r"k_a x|x|"
    smooth: ClassVar[str] = "N_per_m2 * (x * Abs(x))"
    source: ClassVar[str] = "geometric slack of cables"
    left_out: ClassVar[str] = "frequency shifts in proportion to the amplitude"
    pulls_back: ClassVar[bool] = True
    missing_as: ClassVar[str] = AsymmetricStiffness.name
    sprung: ClassVar[bool] = True
    element: ClassVar[Element] = "elastic"


@dataclass(frozen=True)
class SineRestoring(Term):
    """Pendulum, M = ks sin(x), x in rad (coordinate: rotation)."""

    name: ClassVar[str] = "sine_restoring"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("N", "N", "k_s"),)
    slots: ClassVar[Mapping[str, str]] = {"N": "ks"}
    law: ClassVar[str] = "k_s sin(x)"
    latex: ClassVar[str] = r"k_s \sin x"
    smooth: ClassVar[str] = "N * sin(x)"
    source: ClassVar[str] = "Huygens 1673"
    left_out: ClassVar[str] = "period grows with amplitude as a pendulum's: softening at every amplitude"
    pulls_back: ClassVar[bool] = True
    is_spring: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    instead_of: ClassVar[tuple[str, ...]] = (Stiffness.name, CubicStiffness.name, QuinticStiffness.name)
    words: ClassVar[str] = "a restoring force like the sine of the angle"
    element: ClassVar[Element] = "elastic"

    def start(self, mass: float, rate: float, speed: float) -> float:
        """What swings the whole mass at its rate."""
        return mass * rate**2


@dataclass(frozen=True)
class PositionDamping(Term):
    """F = c_x x v: damping that differs from side to side."""

    name: ClassVar[str] = "position_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("Ns_per_m2", "N s/m^2", "c_x"),)
    slots: ClassVar[Mapping[str, str]] = {"Ns_per_m2": "xv"}
    law: ClassVar[str] = "c_x x v"
    latex: ClassVar[str] = r"c_x x\dot{x}"
    smooth: ClassVar[str] = "Ns_per_m2 * (x * v)"
    source: ClassVar[str] = "polynomial library"
    left_out: ClassVar[str] = "mean position moves; second harmonic in quadrature"


@dataclass(frozen=True)
class VanDerPolDamping(Term):
    """F = c_xx x^2 v: damping that grows with the square of the displacement (van der Pol)."""

    name: ClassVar[str] = "van_der_pol_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("Ns_per_m3", "N s/m^3", "c_{xx}"),)
    slots: ClassVar[Mapping[str, str]] = {"Ns_per_m3": "xxv"}
    law: ClassVar[str] = "c_xx x^2 v"
    latex: ClassVar[str] = r"c_{xx} x^2\dot{x}"
    smooth: ClassVar[str] = "Ns_per_m3 * (x**2 * v)"
    source: ClassVar[str] = "van der Pol 1926"
    left_out: ClassVar[str] = "decrement falls with the square of the amplitude"


@dataclass(frozen=True)
class StribeckFriction(Term):
    """Extra friction at low speed, F = F_s exp(-(v/v_s)^2) sign(v), on top of the Coulomb force.

    ``static_force_N`` is what sticking holds beyond the Coulomb force; ``velocity_m_per_s`` where it has faded.
    """

    velocity_m_per_s: float = 0.01
    name: ClassVar[str] = "stribeck_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("static_force_N", "N", "F_s"),
        Parameter("velocity_m_per_s", "m/s", "v_s", lower=1e-5),
    )
    slots: ClassVar[Mapping[str, str]] = {"static_force_N": "fs", "velocity_m_per_s": "vs"}
    law: ClassVar[str] = "F_s exp(-(v / v_s)^2) sign(v)"
    latex: ClassVar[str] = r"F_s e^{-(\dot{x}/v_s)^2}\mathrm{sgn}(\dot{x})"
    friction: ClassVar[str] = "static_force_N * exp(-((v / velocity_m_per_s) ** 2))"
    source: ClassVar[str] = "Armstrong-Helouvry et al. 1994, doi:10.1016/0005-1098(94)90209-7"
    left_out: ClassVar[str] = "residual only around the turning points; motion stops earlier than predicted"
    words: ClassVar[str] = "friction that is larger at low speed"


@dataclass(frozen=True)
class AsymmetricFriction(Term):
    """F = F_a |sign(v)|: friction F_c + F_a moving one way, F_c - F_a the other.

    In a free decay that is a rest offset of -F_a / k: the band in which friction holds the body moves along.
    """

    name: ClassVar[str] = "asymmetric_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("force_N", "N", "F_a"),)
    slots: ClassVar[Mapping[str, str]] = {"force_N": "fa"}
    law: ClassVar[str] = "F_a |sign(v)|"
    latex: ClassVar[str] = r"F_a\,|\mathrm{sgn}(\dot{x})|"
    friction: ClassVar[str] = "force_N * d"
    source: ClassVar[str] = "direction-dependent rails"
    left_out: ClassVar[str] = "oscillation centred away from where the springs are at rest, as by a rest offset"


@dataclass(frozen=True)
class VariableNormalForce(Term):
    """F = n |x| sign(v): friction whose normal force grows with displacement (or amplitude-proportional hysteresis)."""

    name: ClassVar[str] = "variable_normal_force"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("N_per_m", "N/m", "n"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m": "fn"}
    law: ClassVar[str] = "n |x| sign(v)"
    latex: ClassVar[str] = r"n|x|\,\mathrm{sgn}(\dot{x})"
    friction: ClassVar[str] = "N_per_m * Abs(x)"
    source: ClassVar[str] = "Anderson and Ferri 1990, doi:10.1115/1.2896046"
    left_out: ClassVar[str] = (
        "decrement independent of amplitude, with force kinks at turning points growing with amplitude"
    )
    words: ClassVar[str] = "friction that grows with displacement"
