"""Eq. 15 of the flume report, integrated exactly: one smooth leg between two velocity reversals at a time.

The equation and its integration belong here; what the parameters are and how sensors see the motion does not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import OdeSolution, solve_ivp

Floats = NDArray[np.float64]
Value = TypeVar("Value", float, Floats)

RELATIVE_TOLERANCE = 1e-12
ABSOLUTE_TOLERANCE = 1e-14


@dataclass(frozen=True)
class Body:
    """Parameters of Eq. 15 for one trial.

    Attributes
    ----------
    inertia_kg : m + m_a, kg.
    c_Ns_per_m : viscous damping, N s/m.
    k_N_per_m : stiffness, N/m.
    friction_N : mu (m g - V rho g), N.
    drag_Ns2_per_m2 : 1/2 Cd rho A, N s2/m2.
    """

    inertia_kg: float
    c_Ns_per_m: float
    k_N_per_m: float
    friction_N: float
    drag_Ns2_per_m2: float

    def acceleration(self, x: Value, v: Value, direction: float) -> Value:
        """Acceleration x'' of Eq. 15, m/s2, while the body moves with sign(x') = `direction`.

        Within a leg x'|x'| is `direction` x'^2, which is smooth across the reversal that ends the leg,
        so that the integrator keeps its order on the step that straddles it.
        """
        drag = self.drag_Ns2_per_m2 * direction * v * v
        force = self.c_Ns_per_m * v + self.k_N_per_m * x + direction * self.friction_N + drag
        return -force / self.inertia_kg

    def sticks(self, x: float) -> bool:
        """Whether the body, at rest at x (m), stays there: |k x| <= friction force."""
        return abs(self.k_N_per_m * x) <= self.friction_N


@dataclass(frozen=True)
class Motion:
    """A released motion at the times asked for: x (m), v (m/s), a (m/s2), each of shape (n,).

    `reversals_s` and `reversals_m` are the instants and places of x' = 0, the release first;
    `stopped_s` is when the body came to rest for good, None when it still moved at the end.
    """

    x: Floats
    v: Floats
    a: Floats
    reversals_s: Floats
    reversals_m: Floats
    stopped_s: float | None


def simulate(body: Body, x0_m: float, times_s: Floats) -> Motion:
    """Motion after a release from rest at `x0_m`, at `times_s` (s after the release, increasing, shape (n,)).

    (m + m_a) x'' + c x' + k x + sign(x') mu (m g - V rho g) + 1/2 Cd rho A x'|x'| = 0   (report, Eq. 15)

    Integrated by DOP853 (rtol 1e-12, atol 1e-14) and split at velocity reversals, where sign(x') jumps: at a
    reversal the body stays if |k x| <= friction force, otherwise the next leg starts towards the centre.

    Raises
    ------
    ValueError
        When a time lies before the release.
    RuntimeError
        When the integrator gives up.
    """
    if times_s.size and times_s[0] < 0.0:
        raise ValueError(f"times_s starts at {times_s[0]} s; the motion starts at the release, 0 s")
    x, v, a = (np.zeros_like(times_s) for _ in range(3))
    end = float(times_s[-1])
    reversals: list[tuple[float, float]] = [(0.0, x0_m)]
    while True:
        start, place = reversals[-1]
        rest = times_s >= start
        if start >= end or body.sticks(place):
            x[rest] = place
            break
        direction = -1.0 if place > 0.0 else 1.0
        leg, reversal = _integrate_leg(body, start, place, direction, end)
        until = end if reversal is None else reversal[0]
        inside = rest & (times_s <= until)
        if np.any(inside):
            x[inside], v[inside] = leg(times_s[inside])
            a[inside] = body.acceleration(x[inside], v[inside], direction)
        if reversal is None:
            break
        reversals.append(reversal)
    stopped = reversals[-1][0] if body.sticks(reversals[-1][1]) else None
    instants, places = np.array(reversals).T
    return Motion(x, v, a, instants, places, stopped)


def hold_and_release(body: Body, x0_m: float, since_s: Floats) -> Motion:
    """The same at times (s since the release, increasing) before which the body may be held at `x0_m`."""
    free = since_s >= 0.0
    motion = simulate(body, x0_m, since_s[free])
    x, v, a = np.full_like(since_s, x0_m), np.zeros_like(since_s), np.zeros_like(since_s)
    x[free], v[free], a[free] = motion.x, motion.v, motion.a
    return replace(motion, x=x, v=v, a=a)


@dataclass
class _Reversal:
    """Event x' = 0 that ends a leg; `direction` is the sign with which x' crosses zero there."""

    direction: float
    terminal: bool = True

    def __call__(self, _: float, state: Floats) -> float:
        return float(state[1])


def _integrate_leg(
    body: Body, start_s: float, place_m: float, direction: float, end_s: float
) -> tuple[OdeSolution, tuple[float, float] | None]:
    """One leg from rest at `place_m` (m): its dense output, and instant (s) and place (m) of the reversal.

    The reversal is None where `end_s` comes before it.
    """

    def rates(_: float, state: Floats) -> Floats:
        return np.array([state[1], body.acceleration(state[0], state[1], direction)])

    solution = solve_ivp(
        rates,
        (start_s, end_s),
        (place_m, 0.0),
        method="DOP853",
        rtol=RELATIVE_TOLERANCE,
        atol=ABSOLUTE_TOLERANCE,
        events=_Reversal(-direction),
        dense_output=True,
    )
    if not solution.success:
        raise RuntimeError(f"DOP853 gave up on the leg from {start_s} s, {place_m} m: {solution.message}")
    if solution.status != 1:
        return solution.sol, None
    return solution.sol, (float(solution.t_events[0][0]), float(solution.y_events[0][0][0]))
