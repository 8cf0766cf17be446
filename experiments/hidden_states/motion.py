"""A body with friction, drag and hidden states, integrated leg by leg: the truth behind the study's recordings.

    M x'' + c x' + k x + k3 x^3 + F(sign x') + D |x'|^p sign(x') + z = sum_i m_i (2 zeta_i w_i s_i' + w_i^2 s_i)
    s_i'' + 2 zeta_i w_i s_i' + w_i^2 s_i = -x'',        z' = k_r x' - z / tau

M is the inertia that moves with the body (structure and added mass, without the m_i). Friction may differ between the
two directions. Scipy alone integrates, so that nothing of undertow makes the truth; parameters, sensors and seeds stand
elsewhere (campaigns.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import OdeSolution, solve_ivp

Floats = NDArray[np.float64]
RELATIVE_TOLERANCE = 1e-9
ABSOLUTE_TOLERANCE = 1e-12
MAX_LEGS = 400
"""More legs than any of these decays has; beyond it the integration is caught in a loop."""


@dataclass(frozen=True)
class Oscillator:
    """A hidden mass: ``mass_kg``, ``w`` (rad/s, body held) and damping ratio ``zeta``."""

    mass_kg: float
    w: float
    zeta: float


@dataclass(frozen=True)
class Plant:
    """Parameters of one body; SI units. ``friction_N`` is the mean of both directions, ``asymmetry_N`` half their
    difference; ``drag`` belongs to |x'|^exponent; ``maxwell`` is (k_r in N/m, tau in s), k_r = 0 for none."""

    inertia_kg: float
    c: float
    k: float
    friction_N: float
    drag: float
    exponent: float = 2.0
    k3: float = 0.0
    asymmetry_N: float = 0.0
    maxwell: tuple[float, float] = (0.0, 1.0)
    hidden: tuple[Oscillator, ...] = ()

    def smooth_force(self, x: float, v: float, z: float, slosh: Floats) -> float:
        """Force on the left-hand side without friction and drag, N."""
        memory = sum(
            o.mass_kg * (2.0 * o.zeta * o.w * slosh[2 * i + 1] + o.w**2 * slosh[2 * i])
            for i, o in enumerate(self.hidden)
        )
        return self.c * v + self.k * x + self.k3 * x**3 + z - float(memory)

    def rates(self, state: Floats, direction: float) -> Floats:
        """d/dt of (x, v, z, s_1, s_1', ...); ``direction`` is the sign of x', 0 while the body sticks."""
        x, v, z, slosh = state[0], state[1], state[2], state[3:]
        a = 0.0
        if direction:
            resistance = direction * (self.friction_N + self.drag * abs(v) ** self.exponent) + self.asymmetry_N
            a = -(self.smooth_force(x, v, z, slosh) + resistance) / self.inertia_kg
        stiffness, time = self.maxwell
        out = np.empty_like(state)
        out[0], out[1], out[2] = v if direction else 0.0, a, stiffness * v - z / time
        for i, o in enumerate(self.hidden):
            out[3 + 2 * i] = slosh[2 * i + 1]
            out[4 + 2 * i] = -a - 2.0 * o.zeta * o.w * slosh[2 * i + 1] - o.w**2 * slosh[2 * i]
        return out

    def start_direction(self, state: Floats) -> float:
        """Where a body at rest goes: +1, -1, or 0 where friction holds it."""
        force = self.smooth_force(state[0], 0.0, state[2], state[3:])
        if -force > self.friction_N + self.asymmetry_N:
            return 1.0
        if -force < -self.friction_N + self.asymmetry_N:
            return -1.0
        return 0.0


def simulate(plant: Plant, x0_m: float, times_s: Floats) -> tuple[Floats, Floats]:
    """x (m) and x'' (m/s^2), (n,) each, after a release from rest at ``x0_m``; hidden states at rest too.

    RuntimeError where the integrator gives up or the legs do not end.
    """
    x, a = np.full(times_s.size, x0_m), np.zeros(times_s.size)
    state, start, end = np.zeros(3 + 2 * len(plant.hidden)), 0.0, float(times_s[-1])
    state[0] = x0_m
    loose = 0.0
    for _ in range(MAX_LEGS):
        state[1] = 0.0
        direction = loose or plant.start_direction(state)
        leg, until, last = _leg(plant, state, start, end, direction)
        inside = (times_s >= start) & (times_s <= until)
        if np.any(inside):
            seen = leg(times_s[inside])
            x[inside] = seen[0]
            a[inside] = [plant.rates(column, direction)[1] for column in seen.T]
        if until >= end:
            return x, a
        start, state = until, last
        pull = -plant.smooth_force(last[0], 0.0, last[2], last[3:]) - plant.asymmetry_N
        loose = 0.0 if direction else float(np.sign(pull))
    raise RuntimeError(f"{MAX_LEGS} legs end at {start:g} s of {end:g} s; the body chatters")


def _leg(
    plant: Plant, state: Floats, start: float, end: float, direction: float
) -> tuple[OdeSolution, float, Floats]:
    """From ``state`` to the next event: a reversal while it moves, breaking loose while it sticks."""

    def rates(_: float, y: Floats) -> Floats:
        return plant.rates(y, direction)

    def reversal(_: float, y: Floats) -> float:
        return float(y[1])

    def breaking_loose(_: float, y: Floats) -> float:
        pull = -plant.smooth_force(y[0], 0.0, y[2], y[3:]) - plant.asymmetry_N
        return abs(float(pull)) - plant.friction_N

    event: Callable[[float, Floats], float] = reversal if direction else breaking_loose
    event.terminal = True  # type: ignore[attr-defined]
    event.direction = -direction if direction else 1.0  # type: ignore[attr-defined]
    solution = solve_ivp(
        rates, (start, end), state, "DOP853", events=event, rtol=RELATIVE_TOLERANCE, atol=ABSOLUTE_TOLERANCE,
        dense_output=True,
    )  # fmt: skip
    if not solution.success:
        raise RuntimeError(f"DOP853 gave up on the leg from {start} s: {solution.message}")
    return solution.sol, float(solution.t[-1]), solution.y[:, -1].copy()
