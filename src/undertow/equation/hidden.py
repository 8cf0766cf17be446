"""Terms with a state of their own: water that oscillates, memory that relaxes, bristles that creep.

Belongs here: hidden-state terms; as a column each is the response of its own ODE, driven by the measured motion,
at rest before the release. Does not belong here: forces with a clock of their own (forcing.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from undertow.equation.term import Array, Expression, Share, SymbolPlace, Term
from undertow.errors import UndertowError
from undertow.quantities import Parameter


def even_step(t: Array, quantity: str) -> float:
    """The time step of evenly spaced instants, s; UndertowError where steps differ by over 1 %.

    >>> even_step(np.array([0.0, 0.1, 0.2]), "x")
    0.1
    """
    steps = np.diff(t)
    step = float(np.median(steps))
    worst = float(np.max(np.abs(steps - step)))
    if worst > 0.01 * step:
        raise UndertowError(
            f"{quantity}: time steps differ by {worst:.3g} s from their median {step:.3g} s; a hidden state needs even "
            "steps within 1 %: resample the motion first"
        )
    return step


def linear_response(numerator: list[float], denominator: list[float], drive: Array, step: float) -> Array:
    """Response (n,) of a strictly proper filter b(s)/a(s), of order one or two, to ``drive`` (n,), step in s.

    Exact for a drive that is straight between samples. The filter is at rest at the first sample even where the drive
    starts with a jump, as the acceleration of a release does (a plain digital filter would have it rise from zero in
    the step before).

    >>> linear_response([1.0], [1.0, 0.0], np.ones(3), 0.1)  # an integrator
    array([0. , 0.1, 0.2])
    """
    from scipy.signal import cont2discrete, lfilter  # half a second that commands without a filter need not wait

    numerator = list(np.trim_zeros(numerator, "f"))
    b, a, _ = cont2discrete((numerator, denominator), step, method="foh")
    b, a = np.ravel(b), np.ravel(a)
    start = np.zeros(a.size - 1)
    start[0] = -b[0]
    if start.size > 1:
        held, _, _ = cont2discrete((numerator, denominator), step, method="zoh")
        start[1] = np.ravel(held)[1] - b[0] - b[1]
    response: Array = lfilter(b, a, drive, zi=start * drive[0])[0]
    return response


@dataclass(frozen=True)
class HiddenResonator(Term):
    """A mass m_s of water that oscillates relative to the body: F = m_s (x'' + s''),

    s'' + 2 zeta w s' + w^2 s + b s'|s'| + g s^3 = -x''. Frequency ``natural_frequency_rad_per_s`` is with the body
    held, for small motion; b (1/m) and g (1/m^2/s^2) make it depend on its amplitude.

    >>> HiddenResonator(10.0, 0.01).inner["damping_ratio"]
    0.01
    """

    natural_frequency_rad_per_s: float = 10.0
    damping_ratio: float = 0.02
    quadratic_damping_per_m: float = 0.0
    cubic_stiffness_per_m2_s2: float = 0.0
    name = "hidden_resonator"
    kind = "state"
    relative_to = "earth"
    parameters = (
        Parameter("mass_kg", "kg", "m_s", lower=0.0),
        Parameter("natural_frequency_rad_per_s", "rad/s", r"\omega_s", lower=0.05),
        Parameter("damping_ratio", "1", r"\zeta_s", lower=0.0, upper=1.5),
        Parameter("quadratic_damping_per_m", "1/m", "b_s", lower=0.0),
        Parameter("cubic_stiffness_per_m2_s2", "1/m^2/s^2", "g_s"),
    )
    slots: ClassVar[Mapping[str, str]] = {
        "mass_kg": "hm",
        "natural_frequency_rad_per_s": "hw",
        "damping_ratio": "hz",
        "quadratic_damping_per_m": "hb",
        "cubic_stiffness_per_m2_s2": "hg",
    }
    law = "m_s (x'' + s''), s'' + 2 zeta_s omega_s s' + omega_s^2 s + b_s s' |s'| + g_s s^3 = -x''"
    latex = (
        r"m_s(\ddot{x}+\ddot{s}),\ \ddot{s}+2\,\zeta_s\,\omega_s\,\dot{s}+\omega_s^2\,s"
        r"+b_s\,\dot{s}|\dot{s}|+g_s\,s^3=-\ddot{x}"
    )
    source = "Graham and Rodriguez 1952, doi:10.1115/1.4010494; Ibrahim 2005, Liquid Sloshing Dynamics"
    left_out = "beats in every trial with the release's phase; an added mass that depends on the spring"
    causes = "water that sloshes, a load that swings or another mode of the body"
    held_by_kernel = 3
    present_by = "natural_frequency_rad_per_s"
    held_unless_asked = ("quadratic_damping_per_m", "cubic_stiffness_per_m2_s2")
    words = "water that oscillates by itself"
    words_unplaced = "something that was not recorded and oscillates by itself"
    next_test = "a sensor where something may oscillate unseen (in water a wave gauge), or another stiffness"
    element = "oscillator"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """x'' + s'' in m/s^2, the response to the measured acceleration from rest at t[0]; t evenly spaced."""
        step = even_step(t, self.name)
        w, z = self.natural_frequency_rad_per_s, self.damping_ratio
        b, g = self.quadratic_damping_per_m, self.cubic_stiffness_per_m2_s2
        if b == 0.0 and g == 0.0:
            return linear_response([2.0 * z * w, w * w], [1.0, 2.0 * z * w, w * w], a, step)
        return _amplitude_dependent_response(a, step, w, z, b, g)

    def share(self, p: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """What pulls at the body, and the water's own motion."""
        import sympy as sp

        s, u = sp.Symbol(f"s{number}", real=True), sp.Symbol(f"u{number}", real=True)
        w, z = p["natural_frequency_rad_per_s"], p["damping_ratio"]
        pull = 2 * z * w * u + w**2 * s
        pull += p["quadratic_damping_per_m"] * u * sp.Abs(u) + p["cubic_stiffness_per_m2_s2"] * s**3
        return Share(smooth=-p["mass_kg"] * pull, states=((s.name, u), (u.name, -q.a - pull)))


def _amplitude_dependent_response(a: Array, step: float, w: float, z: float, b: float, g: float) -> Array:
    """x'' + s'' of a resonator with quadratic damping and cubic stiffness, by RK4 with the drive interpolated."""

    def restoring(s: float, u: float) -> float:
        return 2.0 * z * w * u + w * w * s + b * u * abs(u) + g * s**3

    out = np.zeros_like(a)
    s = u = 0.0
    for i in range(a.size - 1):
        middle = 0.5 * (a[i] + a[i + 1])
        k1s, k1u = u, -a[i] - restoring(s, u)
        k2s, k2u = u + 0.5 * step * k1u, -middle - restoring(s + 0.5 * step * k1s, u + 0.5 * step * k1u)
        k3s, k3u = u + 0.5 * step * k2u, -middle - restoring(s + 0.5 * step * k2s, u + 0.5 * step * k2u)
        k4s, k4u = u + step * k3u, -a[i + 1] - restoring(s + step * k3s, u + step * k3u)
        s += step / 6.0 * (k1s + 2.0 * k2s + 2.0 * k3s + k4s)
        u += step / 6.0 * (k1u + 2.0 * k2u + 2.0 * k3u + k4u)
        out[i + 1] = -restoring(s, u)
    return out


@dataclass(frozen=True)
class Relaxation(Term):
    """Fluid memory or a Maxwell element, F = z with z' = k_r x' - z / tau."""

    time_s: float = 0.5
    name = "relaxation"
    kind = "state"
    parameters = (
        Parameter("stiffness_N_per_m", "N/m", "k_r"),
        Parameter("time_s", "s", r"\tau", lower=1e-3),
    )
    slots: ClassVar[Mapping[str, str]] = {"stiffness_N_per_m": "rk", "time_s": "rt"}
    law = "z, z' = k_r v - z / tau"
    latex = r"z,\ \dot{z}=k_r\,\dot{x}-z/\tau"
    source = "Maxwell 1867; Cummins 1962 (fluid memory)"
    left_out = "stiffness and damping that depend on frequency: two springs disagree, one spring does not show it"
    causes = "waves that the body radiates, water that flows through openings or material that creeps"
    held_by_kernel = 2
    present_by = "time_s"
    words = "memory that relaxes"
    next_test = "the same releases on another spring: memory depends on frequency, damping does not"
    element = "maxwell"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """z / k_r in m, the response to the velocity from rest at t[0]; t evenly spaced."""
        return linear_response([1.0], [1.0, 1.0 / self.time_s], v, even_step(t, self.name))

    def share(self, p: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """A force with its own rate."""
        import sympy as sp

        z = sp.Symbol(f"z{number}", real=True)
        return Share(smooth=z, states=((z.name, p["stiffness_N_per_m"] * q.v - z / p["time_s"]),))

    def materials(self, coefficient: float, sticking: float) -> tuple[str, ...]:
        """A Maxwell element."""
        return (f"'Maxwell', TAG, {coefficient!r}, {coefficient * self.time_s!r}, 1.0, 1.0",)


@dataclass(frozen=True)
class Hysteresis(Term):
    """Bouc-Wen element of exponent one, F = r with r' = k_h v (1 - sign(v) r / F_y): yields at F_y.

    Linear in ``stiffness_N_per_m`` at a fixed yield displacement F_y / k_h (``yield_displacement_m``).
    """

    yield_displacement_m: float = 0.005
    name = "hysteresis"
    kind = "state"
    parameters = (
        Parameter("stiffness_N_per_m", "N/m", "k_h"),
        Parameter("yield_displacement_m", "m", "x_y", lower=1e-6),
    )
    slots: ClassVar[Mapping[str, str]] = {"stiffness_N_per_m": "kb", "yield_displacement_m": "fb"}
    slot_parameters: ClassVar[Mapping[str, Parameter]] = {"fb": Parameter("yield_force_N", "N", "F_y", lower=1e-9)}
    law = "r, r' = k_h v (1 - sign(v) r / (k_h x_y))"
    latex = r"r,\ \dot{r}=k_h\,\dot{x}\,(1-\mathrm{sgn}(\dot{x})\,r/(k_h\,x_y))"
    source = "Wen 1976, doi:10.1061/JMCEA3.0002106; Dahl 1968"
    left_out = "loops in force against displacement that do not depend on speed"
    causes = "joints that slip one after another, rubber, ropes or soil"
    present_by = "yield_displacement_m"
    words = "hysteresis"
    element = "bristles"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """r / k_h in m, integrated along the displacement from r = 0 at t[0]."""
        moves = np.diff(x)
        limits = (self.yield_displacement_m * np.sign(moves)).tolist()
        shares = np.exp(-np.abs(moves) / self.yield_displacement_m).tolist()
        out, here = [0.0], 0.0
        for limit, share in zip(limits, shares, strict=True):
            here = limit + (here - limit) * share  # a body that does not move keeps its share of 1 and limit of 0
            out.append(here)
        return np.array(out)

    def slot_values(self, coefficient: float) -> dict[str, float]:
        """Stiffness, and the force at which it yields."""
        return {"kb": coefficient, "fb": abs(coefficient) * self.yield_displacement_m}

    @classmethod
    def of_slots(cls, slots: Mapping[str, float]) -> dict[str, float]:
        """The displacement at which it yields."""
        return {"yield_displacement_m": slots["fb"] / abs(slots["kb"])} if slots["kb"] else {}

    def share(self, p: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """A force with its own rate, which falls where it yields."""
        import sympy as sp

        r = sp.Symbol(f"r{number}", real=True)
        k, width = p["stiffness_N_per_m"], p["yield_displacement_m"]
        return Share(smooth=r, states=((r.name, k * q.v * (1 - q.d * r / (sp.Abs(k) * width))),))

    def by_slots(self, s: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """The same with the force at which it yields."""
        import sympy as sp

        r = sp.Symbol(f"r{number}", real=True)
        return Share(smooth=r, states=((r.name, s["kb"] * q.v * (1 - q.d * r / s["fb"])),))

    def materials(self, coefficient: float, sticking: float) -> tuple[str, ...]:
        """A Bouc-Wen element."""
        width = self.yield_displacement_m
        return (f"'BoucWen', TAG, 0.0, {coefficient!r}, 1.0, 0.0, {1.0 / width!r}, 1.0, 0.0, 0.0, 0.0",)
