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


ENVELOPE: tuple[str, ...] = ("", "_t", "_tt", *(f"_t{n}" for n in range(3, 7)))
"""Ends of the slots that hold what goes with the powers of time in a force whose size and phase change."""

_GROWING = ("change_per_s", "bend_per_s2", *(f"bend{n}_per_s{n}" for n in range(3, len(ENVELOPE))))
_TURNING = ("change_phase_rad", "bend_phase_rad", *(f"bend{n}_phase_rad" for n in range(3, len(ENVELOPE))))

_POWERS = (f"g_{n} t{f'^{n}' if n > 1 else ''} cos(Omega t + psi_{n})" for n in range(1, len(ENVELOPE)))
_LATEX_POWERS = (rf"g_{n} t^{n}\cos(\Omega t+\psi_{n})" for n in range(1, len(ENVELOPE)))
_IN_LATEX = rf"A\,(\cos(\Omega t+\varphi)+{'+'.join(_LATEX_POWERS)})"
_WITH_POWERS = f"A (cos(Omega t + varphi) + {' + '.join(_POWERS)})"


@dataclass(frozen=True)
class ChangingForce(ExternalForcing):
    """A force of one frequency whose size and phase change in the course of a record, as a narrow band's do, or a
    seiche's that dies out: F = A (cos(W t + phase) + sum_n g_n t^n cos(W t + psi_n)), n = 1 ... 6."""

    change_per_s: float = 0.0
    change_phase_rad: float = 0.0
    bend_per_s2: float = 0.0
    bend_phase_rad: float = 0.0
    bend3_per_s3: float = 0.0
    bend3_phase_rad: float = 0.0
    bend4_per_s4: float = 0.0
    bend4_phase_rad: float = 0.0
    bend5_per_s5: float = 0.0
    bend5_phase_rad: float = 0.0
    bend6_per_s6: float = 0.0
    bend6_phase_rad: float = 0.0
    name = "changing_force"
    parameters = (
        *ExternalForcing.parameters,
        *(
            parameter
            for n, (grows, turns) in enumerate(zip(_GROWING, _TURNING, strict=True), start=1)
            for parameter in (
                Parameter(grows, "1/s" if n == 1 else f"1/s^{n}", f"g_{n}"),
                Parameter(turns, "rad", rf"\psi_{n}"),
            )
        ),
    )
    slots: ClassVar[Mapping[str, str]] = {
        "amplitude_N": "gcos", "frequency_rad_per_s": "gomega", "phase_rad": "gsin",
        **{grows: f"gcos{end}" for grows, end in zip(_GROWING, ENVELOPE[1:], strict=True)},
        **{turns: f"gsin{end}" for turns, end in zip(_TURNING, ENVELOPE[1:], strict=True)},
    }  # fmt: skip
    law = _WITH_POWERS
    latex = _IN_LATEX
    source = "the envelope of narrow-band noise, Rice 1945, as far as t^6; a seiche that dies out"
    left_out = "a line of some width, with another phase in each trial; it does not go with the motion"
    causes = "a seiche that dies out, waves or wind"
    missing_as = ExternalForcing.name
    words = "a force with a clock of its own that changes along the record"
    element = ""

    @property
    def _sizes(self) -> tuple[tuple[float, float], ...]:
        """Size and phase of what goes with each power of time, from the one that stays on."""
        many = zip(_GROWING, _TURNING, strict=True)
        return ((1.0, self.phase_rad), *((getattr(self, size), getattr(self, phase)) for size, phase in many))

    def slot_values(self, coefficient: float) -> dict[str, float]:
        """Cosine and sine parts, those that go with a power of t too, and the frequency."""
        found = {"gomega": self.frequency_rad_per_s}
        for end, (size, phase) in zip(ENVELOPE, self._sizes, strict=True):
            found[f"gcos{end}"] = coefficient * size * float(np.cos(phase))
            found[f"gsin{end}"] = -coefficient * size * float(np.sin(phase))
        return found

    def share(self, p: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """A force of the time alone."""
        import sympy as sp

        turn = p["frequency_rad_per_s"] * q.t
        many = enumerate(zip(_GROWING, _TURNING, strict=True), start=1)
        grown = sum(p[size] * q.t**n * sp.cos(turn + p[phase]) for n, (size, phase) in many)
        return Share(smooth=p["amplitude_N"] * (sp.cos(turn + p["phase_rad"]) + grown))

    def by_slots(self, s: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """The same with cosine and sine parts."""
        import sympy as sp

        cosine, sine = (sum(s[f"{part}{end}"] * q.t**n for n, end in enumerate(ENVELOPE)) for part in ("gcos", "gsin"))
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
