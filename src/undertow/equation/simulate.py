"""Where an equation takes the body: event-exact simulation.

Belongs here: one call from an Equation to a Trajectory, by the compiled integrator where it knows every term. Does not
belong here: the path for other laws (general.py), fitting.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from undertow.equation.columns import fading, stiffest
from undertow.equation.equation import Equation
from undertow.equation.term import Array, PlacedTerm, Term, force_of
from undertow.errors import IdentificationError, UndertowError

STEPS_PER_PERIOD = 60
"""Largest step of a simulation: this many a period of the fastest mode (error under 1e-5 of x0; see docs)."""

SPLIT_TOLERANCE = 1e-10
"""Relative tolerance of DOP853 for laws that the compiled integrator does not know."""

HIDDEN_SHARE, OUTSIDE_SHARE = 0.6, 0.4
"""Of a body's steps a period, those of a hidden oscillator, and of what acts from outside or fades: their errors reach
the body only through the force on it, and are smaller there (tests/unit/test_steps.py)."""

@dataclass(frozen=True)
class Trajectory:
    """Simulated motion: ``t`` (n,) s after the release, ``x``, ``v``, ``a`` (n,) in SI; ``hidden`` (n, 2 n_hidden)
    displacement and velocity of each hidden oscillator relative to the body; ``steps`` the integrator took."""

    t: Array
    x: Array
    v: Array
    a: Array
    hidden: Array
    steps: int


def fastest_frequency(theta: Array) -> float:
    """Fastest linear rate of a parameter vector, rad/s: body at its stiffest, the hardening terms at the initial
    displacement, on its bristles too, hidden oscillators, forcing."""
    own, on_bristles, hidden, outside = _rates(theta)
    return max(own, on_bristles, hidden, outside) or 1.0


def step_of_motion(theta: Array, steps_per_period: int) -> float:
    """Largest step of a parameter vector's motion, s: ``steps_per_period`` of the body's, and the share that what
    swings beside it or acts on it needs. (The integrator shortens steps itself where bristles bend.)"""
    own, _, hidden, outside = _rates(theta)
    rate = max(own, HIDDEN_SHARE * hidden, OUTSIDE_SHARE * outside) or 1.0
    return 2.0 * math.pi / (rate * steps_per_period)


def _rates(theta: Array) -> tuple[float, float, float, float]:
    """Fastest rates of the body, of the body on its bristles, hidden oscillators, what acts from outside or fades."""
    from undertow.equation.algebra import MAX_HIDDEN, SLOT

    numbers: list[float] = theta.tolist()  # floats are read ten times as fast, and every step of a search asks

    def at(slot: str) -> float:
        """Size of a slot's number."""
        return abs(numbers[SLOT[slot]])

    mass = numbers[SLOT["mass"]]
    size = abs(numbers[SLOT["x0"]] - numbers[SLOT["xe"]])
    stiff, hidden = stiffest(at, size), 0.0
    for i in range(1, MAX_HIDDEN + 1):
        share = max(numbers[SLOT[f"hm{i}"]], 0.0) / mass
        hidden = max(hidden, numbers[SLOT[f"hw{i}"]] * math.sqrt(1.0 + share))
    own, on_bristles = math.sqrt(max(stiff - at("kb"), 0.0) / mass), math.sqrt(stiff / mass)
    return own, on_bristles, hidden, max(numbers[SLOT["omega"]], *fading(at))


def simulate(
    equation: Equation, x0: float, times: Array, v0: float = 0.0, steps_per_period: int = STEPS_PER_PERIOD
) -> Trajectory:
    """Motion from x0 (m), v0 (m/s) at t = 0, at ``times`` (n,) in s, increasing, none negative.

    Sticks, slips and slips again exactly where friction says so. UndertowError where times are not increasing, x0 or v0
    is not finite, or the motion leaves every bound.

    >>> from undertow.equation.equation import equation_15
    >>> eq = equation_15(2637.4, 0.0, 0.0, 109600.0, 200.0, 0.0)
    >>> T = 2 * np.pi * (2637.4 / 109600.0) ** 0.5
    >>> drop = 0.05 - simulate(eq, 0.05, np.array([0.0, T])).x[1]  # 4 F_c / k a cycle
    >>> round(float(drop * 109600.0 / 200.0), 6)
    4.0
    """
    times = rising(times)
    must_be_a_start(x0, v0)
    if not equation.compiled:
        return _general(equation, x0, v0, times)
    from undertow.equation.kernel import integrate

    theta = equation.theta(x0, v0)
    h = 2.0 * math.pi / fastest_frequency(theta) / steps_per_period
    x, v, a, hidden, steps = integrate(theta, np.zeros(0, dtype=np.int64), times, h)
    if steps < 0:
        raise UndertowError(
            f"simulate: the motion from x0 = {x0:g} m left every bound after {-steps} steps; a coefficient has the "
            f"wrong sign: {equation}"
        )
    return Trajectory(times, x[:, 0], v[:, 0], a[:, 0], hidden, int(steps))


def rising(times: Array) -> Array:
    """Instants (n,) as the integrators take them; UndertowError where they are no list, negative or not increasing."""
    times = np.array(times, dtype=np.float64, order="C")  # a copy: what pandas hands out cannot be written to
    if times.ndim != 1:
        raise UndertowError(
            f"times has the shape {times.shape}; give instants (n,) in s that increase, as np.arange(0.0, 5.0, 0.01)"
        )
    if times.size == 0 or not (times[0] >= 0.0 and times[-1] < math.inf and np.all(np.diff(times) > 0.0)):
        ends = f", from {times[0]:g} to {times[-1]:g} s" if times.size else ""
        raise UndertowError(f"{times.size} times{ends}; they must be increasing and not negative, and finite")
    return times


def must_be_a_start(x0: float, v0: float) -> None:
    """UndertowError where a displacement or velocity at the release is no number, or not finite."""
    for name, value, unit in (("x0", x0, "m or rad"), ("v0", v0, "m/s or rad/s")):
        if np.ndim(value):
            raise UndertowError(f"simulate: {name} has the shape {np.shape(value)}; give one number, as x0=0.1, v0=0.0")
        try:
            finite = math.isfinite(value)
        except TypeError as error:
            kind = type(value).__name__
            raise UndertowError(f"simulate: {name} is {value!r}, of type {kind}; give a number in {unit}") from error
        if not finite:
            raise UndertowError(f"simulate: {name} is {value:g} {unit}, and must be finite; give a number")


def _general(equation: Equation, x0: float, v0: float, times: Array) -> Trajectory:
    """The path for a user's own algebraic law (general.py)."""
    from undertow.equation.general import OwnMotion, followed

    memory = [t.name for t in equation.terms if t.kind == "state"]
    if memory:
        raise UndertowError(
            f"simulate: {', '.join(memory)} beside a law without compiled slots cannot be integrated; give the law "
            "slots or take the hidden state out"
        )
    pairs = [(t, c) for t, c in zip(equation.terms, equation.coefficients, strict=True) if not t.is_inertia]
    _must_have_forces([term for term, _ in pairs], x0, v0, float(times[-1]))
    theta = replace(equation, terms=(), coefficients=(), mass_kg=equation.total_mass_kg).theta(x0, v0)
    laws = []
    for term, coefficient in pairs:
        laws.append(PlacedTerm(term, tuple(range(theta.size, theta.size + len(term.parameters)))))
        theta = np.concatenate([theta, [coefficient, *term.inner.values()]])
    size, speed, still, floor = _sizes(x0, v0, float(times[-1]))
    motion = OwnMotion(theta, tuple(laws), (), size, speed, still, SPLIT_TOLERANCE, floor)
    (x, v, a), steps = followed(motion, times)
    return Trajectory(times, x[:, 0], v[:, 0], a[:, 0], np.zeros((times.size, 0)), steps)


def _must_have_forces(laws: Sequence[Term], x0: float, v0: float, end: float) -> None:
    """A law without a finite number to either side of its rest has no motion that swings through it."""
    size, speed, *_ = _sizes(x0, v0, end)
    still = np.zeros(1)
    for law, x_share, v_share in product(laws, (1.0, 0.5, -0.5), (0.5, -0.5)):
        x, v = np.array([size * x_share]), np.array([(speed or 1.0) * v_share])
        with np.errstate(invalid="ignore", divide="ignore"):
            force = float(force_of(law, x, v, still, still)[0])
        if not math.isfinite(force):
            raise IdentificationError(
                f"{law.name}: its force is {force:g} at x = {x[0]:.3g}, v = {v[0]:.3g}; give a finite number to both "
                "sides of the rest position and in both directions, as with abs(x) in a logarithm or a root"
            )


def _sizes(x0: float, v0: float, end: float) -> tuple[float, float, float, Array]:
    """Size and speed of a motion, the speed that counts as standstill, and the absolute tolerances of x and v."""
    size = max(abs(x0), abs(v0) * end) or 1.0
    speed = max(abs(v0), size / end if end > 0.0 else 0.0)
    floor = 1e-12 * np.array([size, size / end if end > 0.0 else size])
    return size, speed, 1e-9 * speed or 1e-300, floor
