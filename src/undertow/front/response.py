"""`frequency_response`, `fit_response`: a body under F cos(w t), frequency by frequency.

Belongs here: arguments of users, tables and pictures of harmonic sets. Does not belong here: steady motions
(equation/steady_state.py), the fit (methods/harmonic_set.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from undertow.conditioning.driven import Frame, Quantity
from undertow.conditioning.harmonic import HarmonicSet, on_base
from undertow.equation.driven_laws import find_driven, places, without_memory
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.equation import Equation
from undertow.equation.input import MotionSize
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.steady_state import SteadyState, swept
from undertow.equation.term import Array, Term
from undertow.errors import UndertowError
from undertow.front.known import named_terms
from undertow.front.simulation import equation_of
from undertow.methods.harmonic_set import MASS, STARTS_AT_ONE, HarmonicFit, fit_harmonic_set
from undertow.quantities import OK, Estimate, Mover, mover_of
from undertow.recording.arrays import real_numbers
from undertow.report.trial_curves import Axes, new_axes

Sweep = Literal["up", "down"]


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Steady motions under F cos(w t): ``states`` in the order of the frequencies asked for, ``force`` (n,).

    Where the base moves, ``force`` is the amplitude of its acceleration, m/s^2, states are relative to it, and
    ``base`` (n,) is what its displacement adds to them (0 where motion relative to the base was asked for).
    """

    states: tuple[SteadyState, ...]
    force: Array
    base: Array = field(default_factory=lambda: np.zeros(1))

    @property
    def table(self) -> pd.DataFrame:
        """Columns frequency_Hz, force, amplitude and phase_rad (of x before the force: negative, x lags)."""
        sines = np.array([s.sine for s in self.states])
        cosines = np.array([s.cosine for s in self.states]) + self.base
        return pd.DataFrame(
            {
                "frequency_Hz": [s.rate / (2.0 * math.pi) for s in self.states], "force": self.force,
                "amplitude": np.hypot(cosines, sines), "phase_rad": np.arctan2(-sines, cosines),
            }
        )  # fmt: skip

    def plot(self, axes: Axes | None = None, label: str = "steady motion") -> Axes:
        """Amplitude against frequency; returns the Axes."""
        axes, table = new_axes() if axes is None else axes, self.table
        axes.plot(table["frequency_Hz"], table["amplitude"], ".-", label=label)
        axes.set(xlabel="frequency (Hz)", ylabel="amplitude (m or rad)")
        axes.legend()
        return axes


@dataclass(frozen=True, eq=False)
class ResponseFit:
    """Numbers from a harmonic set: ``numbers`` by mass_kg and law.parameter, ``rms`` of what the motion's cosine and
    sine miss (unit of the amplitude), ``response`` the steady motions at the measured points."""

    numbers: Mapping[str, Estimate]
    rms: float
    response: FrequencyResponse
    fit: HarmonicFit

    @property
    def equation(self) -> Equation:
        """The equation with its numbers (per mass where the base moved and no number was held)."""
        names = iter(places(self.fit.terms))
        terms, coefficients = [], []
        for term in self.fit.terms:
            values = {one.name: self.numbers[next(names).name].value for one in term.parameters}
            coefficients.append(values.pop(term.coefficient.name))
            terms.append(type(term)(**{**term.inner, **values}))
        return Equation(tuple(terms), tuple(coefficients), mass_kg=self.numbers[MASS].value)

    def __repr__(self) -> str:
        lines = [f"  {name} = {estimate}" for name, estimate in self.numbers.items()]
        said = "" if self.fit.outcome == OK else f"; {self.fit.outcome}"
        return "\n".join([f"{len(self.response.states)} points, rms {self.rms:.3g}{said}", *lines])


def frequency_response(
    equation: Any,
    frequency_Hz: ArrayLike,
    *,
    force: ArrayLike | None = None,
    base_displacement: ArrayLike | None = None,
    base_acceleration: ArrayLike | None = None,
    frame: Frame = "relative",
    sweep: Sweep = "up",
    mass_kg: float = math.nan,
) -> FrequencyResponse:
    """Where an equation's body settles under ``force`` cos(2 pi f t), or on a base that moves so, swept up or down.

        M x'' + sum of laws = F cos(w t)

    ``equation`` is an `Equation`, a fit, or coefficients by the terms' names with ``mass_kg``; ``frequency_Hz`` (n,);
    of ``force`` (N, N m of a rotation, m/s^2 of an equation over its mass), ``base_displacement`` (m) and
    ``base_acceleration`` (m/s^2) one, an amplitude or (n,). On a base ``frame`` says whether the motion is relative to
    it or absolute, and phases are before the quantity that is given. At every frequency the body goes on from where it
    was at the one before, so that a fold shows its upper branch one way and its lower branch the other. Raises
    UndertowError where frequencies are not above zero or a law keeps a state from one period to the next,
    IdentificationError where the body is drawn to no motion of the drive's period.

    >>> found = frequency_response({"stiffness": 50.0, "viscous_damping": 0.8}, [0.5, 0.8], force=1.0, mass_kg=2.0)
    >>> w = 2.0 * np.pi * 0.8
    >>> bool(abs(found.table["amplitude"][1] * abs(50.0 - 2.0 * w**2 + 0.8j * w) - 1.0) < 1e-6)
    True
    """
    found = equation_of(equation, mass_kg)
    without_memory(found.terms)
    if sweep not in ("up", "down"):
        raise UndertowError(f"sweep is {sweep!r}; it is 'up' or 'down'")
    rates = 2.0 * math.pi * np.atleast_1d(real_numbers(frequency_Hz, "frequency_Hz"))
    if rates.size == 0 or not np.all(np.isfinite(rates)) or np.any(rates <= 0.0):
        raise UndertowError(f"frequency_Hz: {rates.size} values, not all finite and above zero; give the force's own")
    quantity, given = _drive(force, base_displacement, base_acceleration, frame)
    if given.size != 1 and given.shape != rates.shape:
        raise UndertowError(f"{quantity} has the shape {given.shape}, frequency_Hz {rates.shape}; give one or as many")
    amplitudes = np.broadcast_to(given, rates.shape)
    if not np.all(np.isfinite(amplitudes)) or np.any(amplitudes == 0.0):
        raise UndertowError(f"{quantity}: amplitudes must be finite and not zero; without a {quantity} the body rests")
    mover = mover_of(quantity)
    drives = np.array(-(rates**2) * amplitudes if quantity == "base_displacement" else amplitudes)
    theta = _vector(found, mover)
    order = np.argsort(rates, kind="stable")[:: 1 if sweep == "up" else -1]
    stiffness = abs(float(theta[SLOT["k1"]])) or float(theta[SLOT["mass"]] * rates.min() ** 2)
    reach = float(np.max(np.abs(drives))) / stiffness * (1.0 if mover == "force" else float(theta[SLOT["mass"]]))
    states = swept(theta, drives[order], rates[order], MotionSize(reach, reach * float(rates.max())), mover)
    by_place = dict(zip(order.tolist(), states, strict=True))
    moved = -drives / rates**2 if frame == "absolute" else np.zeros(rates.size)
    return FrequencyResponse(tuple(by_place[i] for i in range(rates.size)), drives, moved)


def _drive(
    force: ArrayLike | None, base_displacement: ArrayLike | None, base_acceleration: ArrayLike | None, frame: str
) -> tuple[Quantity, Array]:
    """Which of the drives is given, and its amplitudes; UndertowError where not exactly one is."""
    every: dict[Quantity, ArrayLike | None] = {
        "force": force, "base_displacement": base_displacement, "base_acceleration": base_acceleration
    }  # fmt: skip
    given = [(name, real_numbers(value, name)) for name, value in every.items() if value is not None]
    if len(given) != 1:
        have = ", ".join(name for name, _ in given) or "none"
        raise UndertowError(f"of force, base_displacement and base_acceleration {have} is given; give exactly one")
    if frame not in ("relative", "absolute") or (frame == "absolute" and given[0][0] == "force"):
        raise UndertowError(f"frame is {frame!r}; on a base that moves it is 'relative' or 'absolute'")
    return given[0]


def _vector(found: Equation, mover: Mover) -> Array:
    """The driven integrator's vector, laws of the water where a body on that base feels them."""
    theta = np.zeros(N_DRIVEN)
    for slot, value in STARTS_AT_ONE.items():
        theta[DRIVEN_SLOT[slot]] = value
    theta[:N_SLOTS] = found.theta()
    for term, value in zip(found.terms, found.coefficients, strict=True):
        if mover != "force" and term.relative_to == "water":
            for place in places([term], mover):
                theta[DRIVEN_SLOT[term.slots[place.parameter.name]]] -= value
                theta[[DRIVEN_SLOT[slot] for slot in place.slots]] += value
    return theta


def fit_response(
    frequency_Hz: ArrayLike,
    amplitude: ArrayLike,
    phase_rad: ArrayLike,
    *,
    force: ArrayLike | None = None,
    base_displacement: ArrayLike | None = None,
    base_acceleration: ArrayLike | None = None,
    frame: Frame = "relative",
    equation: Sequence[str | Term] = ("stiffness", "viscous_damping"),
    sigma: ArrayLike | None = None,
    held: Mapping[str, float] | None = None,
    starts: Mapping[str, float] | None = None,
) -> ResponseFit:
    """Mass and laws from amplitudes and phases under ``force`` cos(2 pi f t), each point on its own branch.

    ``amplitude`` (n,) in m or rad, ``phase_rad`` (n,) of x before the drive (negative: x lags); the drive, one
    amplitude or (n,), is ``force`` in N, or ``base_displacement`` (m) or ``base_acceleration`` (m/s^2) of a base that
    moves, where ``frame`` says whether the amplitudes are relative to it or absolute and all forces are per mass unless
    a number is ``held``. ``sigma`` is the standard error of amplitudes (None: all alike, from what is left). Start
    values come from the balance of the fundamental; what a law has inside (an exponent) takes ``starts``, ``held`` what
    is known, both by mass_kg and law.parameter. Raises RecordingError where arrays do not fit together, ConfigError for
    laws with a memory, IdentificationError where points are too few or the equation has no steady motion near them.

    >>> f = np.linspace(0.5, 1.2, 20)
    >>> made = frequency_response({"stiffness": 50.0, "viscous_damping": 0.8}, f, force=1.0, mass_kg=2.0).table
    >>> found = fit_response(f, made["amplitude"], made["phase_rad"], force=1.0)
    >>> round(found.numbers["stiffness.k_N_per_m"].value, 4), round(found.numbers["mass_kg"].value, 4)
    (50.0, 2.0)
    """
    rates = 2.0 * math.pi * np.atleast_1d(real_numbers(frequency_Hz, "frequency_Hz"))
    quantity, given = _drive(force, base_displacement, base_acceleration, frame)
    drives = np.full(rates.size, float(given)) if given.ndim == 0 else given
    motion = real_numbers(amplitude, "amplitude"), real_numbers(phase_rad, "phase_rad")
    errors = _errors(sigma, rates.size)
    if quantity == "force":
        measured = HarmonicSet(rates, drives, *motion, errors)
    else:
        measured = on_base(rates, drives, quantity, motion, errors, frame == "absolute")
    terms = named_terms(equation, find_driven)
    found = fit_harmonic_set(measured, terms, {} if held is None else held, {} if starts is None else starts)
    states = tuple(s for s in found.states if s is not None)
    moved = -measured.force / rates**2 if frame == "absolute" else np.zeros(rates.size)
    return ResponseFit(found.numbers, found.rms, FrequencyResponse(states, measured.force, moved), found)


def _errors(sigma: ArrayLike | None, n: int) -> Array:
    if sigma is None:
        return np.zeros(0)
    given = real_numbers(sigma, "sigma")
    if not np.all(given > 0.0):
        wrong = int(np.sum(~(given > 0.0)))
        raise UndertowError(f"sigma: {wrong} of {given.size} errors are not above zero; leave it out")
    return np.full(n, float(given)) if given.ndim == 0 else given
