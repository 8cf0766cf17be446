"""`frequency_response`, `fit_response`: a body under F cos(w t), frequency by frequency.

Belongs here: arguments of users, tables and pictures of harmonic sets. Does not belong here: steady motions
(equation/steady_state.py), the fit (methods/harmonic_set.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from undertow.equation.driven_laws import find_driven
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.input import MotionSize
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.steady_state import SteadyState, swept
from undertow.equation.term import Array, Term
from undertow.errors import UndertowError
from undertow.front.simulation import equation_of
from undertow.methods.harmonic_set import STARTS_AT_ONE, HarmonicFit, HarmonicSet, fit_harmonic_set, without_memory
from undertow.quantities import Estimate
from undertow.report.trial_curves import Axes, new_axes

Sweep = Literal["up", "down"]


@dataclass(frozen=True)
class FrequencyResponse:
    """Steady motions under F cos(w t): ``states`` in the order of the frequencies asked for, ``force`` (n,)."""

    states: tuple[SteadyState, ...]
    force: Array

    @property
    def table(self) -> pd.DataFrame:
        """Columns frequency_Hz, force, amplitude and phase_rad (of x before the force: negative, x lags)."""
        pairs = zip(self.states, self.force, strict=True)
        rows = [(s.rate / (2.0 * math.pi), f, s.amplitude, s.phase) for s, f in pairs]
        return pd.DataFrame(rows, columns=["frequency_Hz", "force", "amplitude", "phase_rad"])

    def plot(self, axes: Axes | None = None, label: str = "steady motion") -> Axes:
        """Amplitude against frequency; returns the Axes."""
        axes, table = new_axes() if axes is None else axes, self.table
        axes.plot(table["frequency_Hz"], table["amplitude"], ".-", label=label)
        axes.set_xlabel("frequency (Hz)")
        axes.set_ylabel("amplitude (m or rad)")
        axes.legend()
        return axes


@dataclass(frozen=True)
class ResponseFit:
    """Numbers from a harmonic set: ``numbers`` by mass_kg and law.parameter, ``rms`` of what the motion's cosine and
    sine miss (unit of the amplitude), ``response`` the steady motions at the measured points."""

    numbers: Mapping[str, Estimate]
    rms: float
    response: FrequencyResponse
    fit: HarmonicFit

    def __repr__(self) -> str:
        lines = [f"  {name} = {estimate}" for name, estimate in self.numbers.items()]
        return "\n".join([f"{len(self.response.states)} points, rms {self.rms:.3g}", *lines])


def frequency_response(
    equation: Any, frequency_Hz: ArrayLike, *, force: ArrayLike, sweep: Sweep = "up", mass_kg: float = math.nan
) -> FrequencyResponse:
    """Where an equation's body settles under ``force`` cos(2 pi f t), swept up or down.

        M x'' + sum of laws = F cos(w t)

    ``equation`` is an `Equation`, a fit, or coefficients by the terms' names with ``mass_kg``; ``frequency_Hz`` (n,),
    ``force`` one amplitude or (n,), N (N m of a rotation, m/s^2 of an equation over its mass). At every frequency the
    body goes on from where it was at the one before, so that a fold shows its upper branch one way and its lower
    branch the other. Raises UndertowError where frequencies are not above zero or a law keeps a state from one period
    to the next, IdentificationError where the body is drawn to no motion of the force's period.

    >>> found = frequency_response({"stiffness": 50.0, "viscous_damping": 0.8}, [0.5, 0.8], force=1.0, mass_kg=2.0)
    >>> w = 2.0 * np.pi * 0.8
    >>> bool(abs(found.table["amplitude"][1] * abs(50.0 - 2.0 * w**2 + 0.8j * w) - 1.0) < 1e-6)
    True
    """
    found = equation_of(equation, mass_kg)
    without_memory(found.terms)
    if sweep not in ("up", "down"):
        raise UndertowError(f"sweep is {sweep!r}; it is 'up' or 'down'")
    rates = 2.0 * math.pi * np.atleast_1d(np.asarray(frequency_Hz, dtype=np.float64))
    if rates.size == 0 or not np.all(np.isfinite(rates)) or np.any(rates <= 0.0):
        raise UndertowError(f"frequency_Hz: {rates.size} values, not all finite and above zero; give the force's own")
    forces = np.broadcast_to(np.asarray(force, dtype=np.float64), rates.shape)
    if not np.all(np.isfinite(forces)) or np.any(forces == 0.0):
        raise UndertowError("force: amplitudes must be finite and not zero; without a force the body rests")
    theta = np.zeros(N_DRIVEN)
    for slot, value in STARTS_AT_ONE.items():
        theta[DRIVEN_SLOT[slot]] = value
    theta[:N_SLOTS] = found.theta()
    order = np.argsort(rates, kind="stable")[:: 1 if sweep == "up" else -1]
    stiffness = abs(float(theta[SLOT["k1"]])) or float(theta[SLOT["mass"]] * rates.min() ** 2)
    reach = float(np.max(np.abs(forces))) / stiffness
    states = swept(theta, forces[order], rates[order], MotionSize(reach, reach * float(rates.max())))
    by_place = dict(zip(order.tolist(), states, strict=True))
    return FrequencyResponse(tuple(by_place[i] for i in range(rates.size)), np.array(forces))


def fit_response(
    frequency_Hz: ArrayLike,
    amplitude: ArrayLike,
    phase_rad: ArrayLike,
    *,
    force: ArrayLike,
    equation: Sequence[str | Term] = ("stiffness", "viscous_damping"),
    sigma: ArrayLike | None = None,
    held: Mapping[str, float] | None = None,
    starts: Mapping[str, float] | None = None,
) -> ResponseFit:
    """Mass and laws from amplitudes and phases under ``force`` cos(2 pi f t), each point on its own branch.

    ``amplitude`` (n,) in m or rad, ``phase_rad`` (n,) of x before the force (negative: x lags), ``force`` one amplitude
    or (n,) in N, ``sigma`` the standard error of amplitudes (None: all alike, from what is left). Start values come
    from the balance of the fundamental; what a law has inside (an exponent) takes ``starts``, ``held`` what is known,
    both by mass_kg and law.parameter. Raises RecordingError where arrays do not fit together, ConfigError for laws with
    a memory, IdentificationError where points are too few or the equation has no steady motion near them.

    >>> f = np.linspace(0.5, 1.2, 20)
    >>> made = frequency_response({"stiffness": 50.0, "viscous_damping": 0.8}, f, force=1.0, mass_kg=2.0).table
    >>> found = fit_response(f, made["amplitude"], made["phase_rad"], force=1.0)
    >>> round(found.numbers["stiffness.k_N_per_m"].value, 4), round(found.numbers["mass_kg"].value, 4)
    (50.0, 2.0)
    """
    rates = 2.0 * math.pi * np.atleast_1d(np.asarray(frequency_Hz, dtype=np.float64))
    forces = np.asarray(force, dtype=np.float64)
    measured = HarmonicSet(
        rates, np.full(rates.size, float(forces)) if forces.ndim == 0 else forces,
        np.asarray(amplitude, dtype=np.float64), np.asarray(phase_rad, dtype=np.float64), _errors(sigma, rates.size),
    )  # fmt: skip
    terms = tuple(find_driven(term) if isinstance(term, str) else term for term in equation)
    found = fit_harmonic_set(measured, terms, dict(held or {}), dict(starts or {}))
    states = tuple(s for s in found.states if s is not None)
    return ResponseFit(found.numbers, found.rms, FrequencyResponse(states, measured.force), found)


def _errors(sigma: ArrayLike | None, n: int) -> Array:
    if sigma is None:
        return np.zeros(0)
    given = np.asarray(sigma, dtype=np.float64)
    if not np.all(given > 0.0):
        wrong = int(np.sum(~(given > 0.0)))
        raise UndertowError(f"sigma: {wrong} of {given.size} errors are not above zero; leave it out")
    return np.full(n, float(given)) if given.ndim == 0 else given
