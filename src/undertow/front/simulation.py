"""`simulate`: where an equation takes a body, with the samples a sensor would have seen.

Belongs here: simulated motions as a user handles them. Does not belong here: integration (equation/simulate.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, DTypeLike

from undertow.equation.equation import Equation
from undertow.equation.registry import find
from undertow.equation.simulate import fastest_frequency, must_be_a_start
from undertow.equation.simulate import simulate as integrate
from undertow.equation.term import Array, Term
from undertow.errors import UndertowError, shown
from undertow.front.handover import HandOver
from undertow.recording.arrays import instants
from undertow.recording.recording import Condition, Coordinate, Recording
from undertow.report.trial_curves import Axes, Curve, draw_run, new_axes
from undertow.uncertainty.seeds import random_numbers

SAMPLES_PER_PERIOD = 60
"""Samples a period where neither times nor a rate are asked for."""

MOST_SAMPLES = 10_000_000
"""Samples of a motion at most: 80 MB a column."""

PERIODS = 20
"""Periods simulated where no duration is asked for."""


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(HandOver):
    """A motion from ``x0`` (m, rad): ``t`` (n,) s after the release, ``x``, ``v``, ``a`` (n,) in SI, ``hidden``
    (n, 2 n_hidden) displacement and velocity of each hidden oscillator relative to the body.

    As an array it is its states, (n, 2 + 2 n_hidden): x, v, then the hidden ones.

    >>> run = simulate({"stiffness": 400.0}, x0=0.1, mass_kg=4.0, duration_s=2.0, rate_hz=100.0)
    >>> run.shape, float(run[0, 0]), len(run)
    ((200, 2), 0.1, 200)
    """

    equation: Equation
    x0: float
    v0: float
    t: Array
    x: Array
    v: Array
    a: Array
    hidden: Array

    def __array__(self, dtype: DTypeLike = np.float64, copy: bool | None = None) -> Array:
        hidden = self.hidden.reshape(self.t.size, -1)
        return np.column_stack([self.x, self.v, hidden]).astype(dtype)

    def __getitem__(self, at: Any) -> Any:
        return np.asarray(self)[at]

    def __len__(self) -> int:
        return int(self.t.size)

    @property
    def shape(self) -> tuple[int, ...]:
        """Samples and states."""
        return np.asarray(self).shape

    @property
    def table(self) -> pd.DataFrame:
        """Columns t, x, v, a in s, m, m/s, m/s^2."""
        return pd.DataFrame({"t": self.t, "x": self.x, "v": self.v, "a": self.a})

    def recorded(
        self,
        noise_m: float = 0.0,
        hold_s: float = 0.5,
        seed: int = 0,
        name: str = "simulated",
        conditions: Mapping[str, Condition] | None = None,
        acceleration_noise: float | None = None,
        coordinate: Coordinate = "translation",
    ) -> Recording:
        """What sensors would record: a hold of ``hold_s`` seconds, the motion, white noise of ``noise_m`` (m, rad).

        With ``acceleration_noise`` (m/s^2) an accelerometer is recorded too. UndertowError where samples are uneven.

        >>> run = simulate({"stiffness": 400.0}, x0=0.1, mass_kg=4.0, duration_s=2.0, rate_hz=100.0)
        >>> run.recorded(noise_m=1e-4).time.size
        250
        """
        steps = np.diff(self.t)
        step = float(np.median(steps))
        if np.any(np.abs(steps - step) > 1e-6 * step):
            raise UndertowError(
                f"samples are {steps.min():g} to {steps.max():g} s apart; a recording needs even ones: give rate_hz"
            )
        for what, size in (("noise_m", noise_m), ("acceleration_noise", acceleration_noise), ("hold_s", hold_s)):
            if size is not None and not size >= 0.0:
                raise UndertowError(f"{what} is {size:g}; give 0 or more")
        rng = random_numbers(seed)
        held = round(hold_s / step)
        time = np.arange(held + self.t.size, dtype=np.float64) * step
        still = np.full(held, self.x0 if self.v0 == 0.0 else math.nan)
        if held and self.v0 != 0.0:
            raise UndertowError(f"v0 is {self.v0:g} m/s; a body that moves was not held: give hold_s=0")
        channels = {"displacement": np.concatenate([still, self.x]) + noise_m * rng.standard_normal(time.size)}
        if acceleration_noise is not None:
            moved = np.concatenate([np.zeros(held), self.a])
            channels["acceleration"] = moved + acceleration_noise * rng.standard_normal(time.size)
        return Recording(name, time, channels, conditions or {}, coordinate)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Displacement against time; returns the Axes."""
        none = np.zeros(0)
        curve = Curve(f"simulated from {self.x0:.3g} m", self.t, self.x, none, none, none)
        return draw_run(curve, new_axes() if axes is None else axes)

    def __repr__(self) -> str:
        return f"{self.equation}\nfrom x0 = {self.x0:.4g} m, {self.t[-1]:.4g} s in {self.t.size} samples"


def one_group(found: Any) -> Any:
    """The only group of a run or a diagnosis; anything else as it is. UndertowError where there are several.

    >>> one_group("a fit")
    'a fit'
    """
    groups = getattr(found, "groups", None)
    if not isinstance(groups, tuple):
        return found
    if len(groups) != 1:
        listed = ", ".join(repr(group.label) for group in groups)
        raise UndertowError(
            f"{type(found).__name__} has {len(groups)} groups ({listed}), each with an equation of its own; choose "
            "one, as in found[0] or by its label"
        )
    return groups[0]


def equation_of(equation: Any, mass_kg: float = math.nan) -> Equation:
    """An `Equation`: itself, a result's, or made of coefficients by the terms' names.

    A term with inner parameters is given as a mapping of all its numbers, as
    ``{"hidden_resonator": {"mass_kg": 300.0, "natural_frequency_rad_per_s": 10.0}}``. UndertowError for anything else.
    """
    equation = one_group(equation)
    if not isinstance(mass_kg, Real):
        raise UndertowError(f"mass_kg is {shown(mass_kg)}, of type {type(mass_kg).__name__}; give a number in kg")
    if not isinstance(equation, Mapping) and not math.isnan(mass_kg):
        raise UndertowError(
            f"mass_kg is {mass_kg:g}, but equation, of type {type(equation).__name__}, has a mass of its own; leave it "
            'out, or give coefficients by the terms\' names, as in {"stiffness": 109600.0}'
        )
    if isinstance(equation, Equation):
        return equation
    of_class = hasattr(type(equation), "equation")  # asked for itself: what is not fitted says so
    found = equation.equation if of_class else getattr(equation, "equation", None)
    if isinstance(found, Equation):
        return found
    if not isinstance(equation, Mapping):
        raise UndertowError(
            f"equation is of type {type(equation).__name__}; give an Equation, a fit, or coefficients by the terms' "
            'names, as {"stiffness": 109600.0}'
        )
    pairs = [pair for name, value in equation.items() for pair in _pairs(name, value)]
    if not math.isfinite(mass_kg):
        mass_kg = 1.0
    return Equation(tuple(term for term, _ in pairs), tuple(value for _, value in pairs), mass_kg=mass_kg)


def _pairs(name: str | Term, value: Any) -> list[tuple[Term, float]]:
    """A term and its coefficient from a number, a mapping of its parameters, or several such (two resonators)."""
    if isinstance(value, (list, tuple)):
        return [pair for one in value for pair in _pairs(name, one)]
    term = name if isinstance(name, Term) else find(name)
    if not isinstance(value, Mapping):
        return [(term, float(value))]
    leading = term.coefficient.name
    known = {parameter.name for parameter in term.parameters}
    wrong = [key for key in value if key not in known]
    if wrong or leading not in value:
        said = f"has no parameter {wrong[0]!r}" if wrong else f"lacks its {leading}"
        raise UndertowError(f"{term.name} {said}; it has {', '.join(p.name for p in term.parameters)}")
    inner = {key: float(number) for key, number in value.items() if key != leading}
    return [(type(term)(**{**term.inner, **inner}), float(value[leading]))]


def simulate(
    equation: Any,
    x0: float,
    times: ArrayLike | None = None,
    *,
    v0: float = 0.0,
    mass_kg: float = math.nan,
    duration_s: float | None = None,
    rate_hz: float | None = None,
) -> Simulation:
    """The motion of an equation from ``x0`` (m, rad) and ``v0`` (m/s, rad/s), exact at every stick and slip.

    Parameters
    ----------
    equation : an `Equation`, a fit, a diagnosis or an opened run with one group, or coefficients by the terms' names in
        SI units (`undertow terms` lists them); a term with several parameters has a mapping of them.
    times : instants (n,) in s, rising from 0; None: ``duration_s`` (20 periods) at ``rate_hz`` (60 a period).
    mass_kg : total mass where ``equation`` is a mapping; 1 where it is not given: coefficients are then over the mass.

    Raises UndertowError where times are not increasing, x0 or v0 is not finite, or the motion leaves every bound.

    >>> law = {"stiffness": 400.0, "coulomb_friction": 4.0}
    >>> run = simulate(law, x0=0.1, mass_kg=4.0, rate_hz=100.0, duration_s=1.0)
    >>> round(float(run.x[63]), 3)  # a period later: less by 4 F / k
    0.06
    >>> print(run)
    4 x'' + 400 x + 4 sign(v) = 0
    from x0 = 0.1 m, 0.99 s in 100 samples
    """
    law = equation_of(equation, mass_kg)
    must_be_a_start(x0, v0)
    if times is None:
        times = _even_times(law, x0, v0, duration_s, rate_hz)
    elif duration_s is not None or rate_hz is not None:
        raise UndertowError(
            f"times has {np.size(times)} instants and duration_s is {duration_s}, rate_hz {rate_hz}; give times alone"
        )
    moved = integrate(law, x0, instants(times, "times"), v0)
    return Simulation(law, float(x0), float(v0), moved.t, moved.x, moved.v, moved.a, moved.hidden)


def _even_times(law: Equation, x0: float, v0: float, duration_s: float | None, rate_hz: float | None) -> Array:
    period = 2.0 * math.pi / fastest_frequency(law.theta(x0, v0)) if law.compiled else math.nan
    if not math.isfinite(period) and (duration_s is None or rate_hz is None):
        raise UndertowError(
            f"duration_s is {duration_s} and rate_hz {rate_hz}; an equation with a law of your own needs both, or times"
        )
    length = PERIODS * period if duration_s is None else float(duration_s)
    rate = SAMPLES_PER_PERIOD / period if rate_hz is None else float(rate_hz)
    if not (length > 0.0 and rate > 0.0):
        raise UndertowError(f"duration_s is {length:g} s at {rate:g} Hz; both must be positive")
    if not length * rate <= MOST_SAMPLES:
        raise UndertowError(
            f"duration_s is {length:g} s at {rate:g} Hz, {length * rate:.3g} samples; at most {MOST_SAMPLES} are "
            "simulated: ask for a shorter motion, or fewer samples a second"
        )
    return np.arange(max(2, round(length * rate))) / rate
