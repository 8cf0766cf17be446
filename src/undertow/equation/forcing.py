"""Forces with a clock of their own.

Belongs here: what acts on the body without the body's doing (forcing) or comes back late (echo).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from undertow.equation.term import Array, Element, Expression, Share, SymbolPlace, Term
from undertow.quantities import Parameter


@dataclass(frozen=True)
class ExternalForcing(Term):
    """A harmonic force whose phase is not tied to the release, F = A cos(W t + phase), phase free in each trial."""

    frequency_rad_per_s: float = 5.0
    phase_rad: float = 0.0
    name = "external_forcing"
    kind = "input"
    relative_to = "earth"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude_N", "N", "A", lower=0.0),
        Parameter("frequency_rad_per_s", "rad/s", r"\Omega", lower=0.05),
        Parameter("phase_rad", "rad", r"\varphi"),
    )
    slots: ClassVar[Mapping[str, str]] = {"amplitude_N": "fcos", "frequency_rad_per_s": "omega", "phase_rad": "fsin"}
    law = "A cos(Omega t + varphi)"
    latex = r"A\cos(\Omega t+\varphi)"
    smooth = "amplitude_N * cos(frequency_rad_per_s * t + phase_rad)"
    source = "wave, seiche or machine"
    left_out = "a line at one frequency in all trials, with another phase in each; it does not decay"
    causes = "a seiche, waves, wind or a machine"
    own_clock = True
    words = "a force with a clock of its own"
    next_test = "a record of the body at rest, nothing else changed"
    element: ClassVar[Element] = "drive"

    def slot_values(self, coefficient: float) -> dict[str, float]:
        """Cosine and sine parts, and the frequency."""
        return {
            "fcos": coefficient * float(np.cos(self.phase_rad)),
            "fsin": -coefficient * float(np.sin(self.phase_rad)),
            "omega": self.frequency_rad_per_s,
        }

    def by_slots(self, s: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """The same with a cosine and a sine part."""
        import sympy as sp

        return Share(smooth=s["fcos"] * sp.cos(s["omega"] * q.t) + s["fsin"] * sp.sin(s["omega"] * q.t))


@dataclass(frozen=True)
class ChangingForce(ExternalForcing):
    """A force of one frequency whose size and phase change in the course of a record, as a narrow band's do, or a
    seiche's that dies out: F = A (cos(W t + phase) + g t cos(W t + psi) + h t^2 cos(W t + chi))."""

    change_per_s: float = 0.0
    change_phase_rad: float = 0.0
    bend_per_s2: float = 0.0
    bend_phase_rad: float = 0.0
    name = "changing_force"
    parameters = (
        *ExternalForcing.parameters,
        Parameter("change_per_s", "1/s", "g"),
        Parameter("change_phase_rad", "rad", r"\psi"),
        Parameter("bend_per_s2", "1/s^2", "h"),
        Parameter("bend_phase_rad", "rad", r"\chi"),
    )
    slots: ClassVar[Mapping[str, str]] = {
        "amplitude_N": "gcos", "frequency_rad_per_s": "gomega", "phase_rad": "gsin", "change_per_s": "gcos_t",
        "change_phase_rad": "gsin_t", "bend_per_s2": "gcos_tt", "bend_phase_rad": "gsin_tt",
    }  # fmt: skip
    law = "A (cos(Omega t + varphi) + g t cos(Omega t + psi) + h t^2 cos(Omega t + chi))"
    latex = r"A\,(\cos(\Omega t+\varphi)+g\,t\cos(\Omega t+\psi)+h\,t^2\cos(\Omega t+\chi))"
    source = "the envelope of narrow-band noise, Rice 1945, as far as t^2; a seiche that dies out"
    left_out = "a line of some width, with another phase in each trial; it does not go with the motion"
    causes = "a seiche that dies out, waves or wind"
    missing_as = ExternalForcing.name
    words = "a force with a clock of its own that changes along the record"
    element = ""

    def slot_values(self, coefficient: float) -> dict[str, float]:
        """Cosine and sine parts, what both gain with t and with t^2, and the frequency."""
        sizes = {"": (1.0, self.phase_rad), "_t": (self.change_per_s, self.change_phase_rad),
                 "_tt": (self.bend_per_s2, self.bend_phase_rad)}  # fmt: skip
        found = {"gomega": self.frequency_rad_per_s}
        for order, (size, phase) in sizes.items():
            found[f"gcos{order}"] = coefficient * size * float(np.cos(phase))
            found[f"gsin{order}"] = -coefficient * size * float(np.sin(phase))
        return found

    def share(self, p: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """A force of the time alone."""
        import sympy as sp

        turn = p["frequency_rad_per_s"] * q.t
        change = p["change_per_s"] * q.t * sp.cos(turn + p["change_phase_rad"])
        bend = p["bend_per_s2"] * q.t**2 * sp.cos(turn + p["bend_phase_rad"])
        return Share(smooth=p["amplitude_N"] * (sp.cos(turn + p["phase_rad"]) + change + bend))

    def by_slots(self, s: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """The same with cosine and sine parts."""
        import sympy as sp

        cosine = s["gcos"] + s["gcos_t"] * q.t + s["gcos_tt"] * q.t**2
        sine = s["gsin"] + s["gsin_t"] * q.t + s["gsin_tt"] * q.t**2
        return Share(smooth=cosine * sp.cos(s["gomega"] * q.t) + sine * sp.sin(s["gomega"] * q.t))


@dataclass(frozen=True)
class DelayedEcho(Term):
    """What the body radiated comes back after a delay, F = gain v(t - delay); nothing before the release."""

    delay_s: float = 1.0
    name = "delayed_echo"
    kind = "delay"
    relative_to = "earth"
    parameters = (
        Parameter("gain", "N s/m", "G"),
        Parameter("delay_s", "s", r"\tau_e", lower=1e-3),
    )
    slots: ClassVar[Mapping[str, str]] = {"gain": "ge", "delay_s": "tau_e"}
    law = "G v(t - tau_e)"
    latex = r"G\,\dot{x}(t-\tau_e)"
    source = "reflection at the flume's ends"
    left_out = "nothing until the delay has passed, then a disturbance that repeats the motion"
    causes = "waves that come back from a wall, or water that the body set moving and meets again"
    words = "an echo of the motion that comes back late"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """v(t - delay) in m/s, zero before the first sample."""
        return np.interp(t - self.delay_s, t, v, left=0.0)

    def share(self, p: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """The velocity of a while ago."""
        return Share(smooth=p["gain"] * q.echo, delay=p["delay_s"].name)
