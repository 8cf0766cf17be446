"""The release in time: surface and body together, split exactly where the body reverses or sticks.

State y = [x, v, eta (n), p (n)]. Between events the right-hand side is smooth and classical Runge-Kutta of fourth
order is used. A change of the velocity's sign ends a step there (secant rule on the step's length); the body then
sticks or goes on. A body at rest is asked at every step whether friction still holds it. Sway force of the water:
-A_inf x'' + rho' c . p' with p' = -g eta - n p, so the step is explicit.

Linear water about the rest position; laplace.py and frequency.py have the operators.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve

from experiments.virtual_flume.frequency import GRAVITY, Water
from experiments.virtual_flume.structure import Structure

Array = np.ndarray

LONGEST_STEP_S = 0.002
REST_SPEED = 1e-12  # m/s; a reversal is found to this


@dataclass(frozen=True)
class Motion:
    """Motion at `time` (s): `x` (m), `v` (m/s), `a` (m/s2), the water's `moment` about the rail line (N m).

    All (t,). `eta` (t, n) surface elevation (m) and `potential` (t, n) (m2/s), kept where asked for, else (0, n).
    """

    time: Array
    x: Array
    v: Array
    a: Array
    moment: Array
    eta: Array
    potential: Array


class Flume:
    """The coupled right-hand side for one water and one structure; `water` None is a dry body."""

    def __init__(self, structure: Structure, water: Water | None) -> None:
        self.structure = structure
        if water is None:
            self.n, self.inertia = 0, structure.mass
            return
        o = water.operators
        self.n = o.x.size
        self.inertia = structure.mass + water.added_mass_at_once_kg
        self.loss = water.loss
        both = solve(o.mass, np.column_stack([o.stiffness, o.coupling]), assume_a="pos")
        self.to_flow, self.from_sway = np.ascontiguousarray(both[:, :-1]), both[:, -1].copy()
        self.force_row = water.scale_kg_per_m2 * o.coupling
        self.moment_row = water.scale_kg_per_m2 * o.moment_coupling
        self.moment_inertia = water.scale_kg_per_m2 * o.added_moment

    def free_force(self, y: Array) -> float:
        """All forces on the body but friction and the instantaneous added mass; N."""
        s = self.structure
        force = -s.stiffness * y[0] - s.damping * y[1] - s.drag * y[1] * abs(y[1])
        if self.n:
            force += self.force_row @ self.potential_rate(y)
        return float(force)

    def potential_rate(self, y: Array) -> Array:
        """p' (n,) m2/s2 on the surface."""
        eta, p = y[2 : 2 + self.n], y[2 + self.n :]
        return -GRAVITY * eta - self.loss * p

    def rate(self, y: Array, direction: float) -> Array:
        """y' for a body moving in a direction (+1, -1), or held by friction (0)."""
        out = np.empty_like(y)
        s = self.structure
        force = (
            -s.stiffness * y[0] - s.damping * y[1] - s.drag * y[1] * abs(y[1]) - direction * s.friction_force
        )
        if self.n:
            eta, p = y[2 : 2 + self.n], y[2 + self.n :]
            p_rate = -GRAVITY * eta - self.loss * p
            out[2 : 2 + self.n] = self.to_flow @ p + self.from_sway * y[1] - self.loss * eta
            out[2 + self.n :] = p_rate
            force += self.force_row @ p_rate
        out[0] = y[1]
        out[1] = force / self.inertia if direction else 0.0
        return out

    def step(self, y: Array, h: float, direction: float) -> Array:
        """One Runge-Kutta step of length h, s."""
        k1 = self.rate(y, direction)
        k2 = self.rate(y + 0.5 * h * k1, direction)
        k3 = self.rate(y + 0.5 * h * k2, direction)
        k4 = self.rate(y + h * k3, direction)
        return y + (h / 6.0) * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def direction_at_rest(self, y: Array) -> float:
        """Where the body starts to go from rest: 0 where friction holds it."""
        force = self.free_force(y)
        return float(np.sign(force)) if abs(force) > self.structure.friction_force else 0.0

    def advance(self, y: Array, direction: float, duration: float) -> tuple[Array, float]:
        """State and direction after a duration (s), through every reversal and every stop on the way."""
        left = duration
        while left > 1e-14:
            if direction == 0.0:
                direction = self.direction_at_rest(y)
            h = min(left, LONGEST_STEP_S)
            new = self.step(y, h, direction)
            if direction != 0.0 and new[1] * direction < -REST_SPEED and h > 1e-12:
                h, new = self._to_rest(y, h, direction, new)
                new[1] = 0.0
                y, left = new, left - h
                direction = self.direction_at_rest(y)
                continue
            y, left = new, left - h
        return y, direction

    def _to_rest(self, y: Array, h: float, direction: float, new: Array) -> tuple[float, Array]:
        """Length (s) of the step that ends at zero velocity, and the state there (Illinois secant)."""
        low, f_low, high, f_high = 0.0, y[1], h, new[1]
        for _ in range(60):
            if abs(new[1]) <= REST_SPEED:
                break
            middle = (
                high - f_high * (high - low) / (f_high - f_low) if f_low != f_high else 0.5 * (low + high)
            )
            if not low < middle < high:
                middle = 0.5 * (low + high)
            new = self.step(y, middle, direction)
            if new[1] * direction > 0.0:
                low, f_low, f_high = middle, new[1], 0.5 * f_high
            else:
                high, f_high, f_low = middle, new[1], 0.5 * f_low
            h = middle
        return h, new

    def release(self, x0: float, release_s: float, time: Array, keep_surface: bool = False) -> Motion:
        """Motion at increasing times (s) of a body held at x0 (m) in still water and let go at release_s."""
        y = np.zeros(2 + 2 * self.n)
        y[0] = x0
        rows, eta, potential, now, direction = [], [], [], release_s, 0.0
        for t in time:
            if t > now:
                y, direction = self.advance(y, direction, t - now)
                now = t
            held = t < release_s
            rows.append(self._sample(y, 0.0 if held else direction))
            if keep_surface:
                eta.append(y[2 : 2 + self.n].copy())
                potential.append(y[2 + self.n :].copy())
        x, v, a, moment = np.array(rows).T
        shape = (len(eta), self.n)
        return Motion(time, x, v, a, moment, np.reshape(eta, shape), np.reshape(potential, shape))

    def _sample(self, y: Array, direction: float) -> tuple[float, float, float, float]:
        """x, v, a and the water's moment about the rail line at a state."""
        force = self.free_force(y) - direction * self.structure.friction_force
        a = force / self.inertia if direction else 0.0
        moment = 0.0
        if self.n:
            moment = float(self.moment_row @ self.potential_rate(y)) - self.moment_inertia * a
        return float(y[0]), float(y[1]), a, moment


def energy(water: Water, structure: Structure, motion: Motion) -> Array:
    """Energy of spring, body and water at every kept sample; J, (t,). Constant where nothing is lost."""
    o, scale = water.operators, water.scale_kg_per_m2
    kinetic = np.einsum("ti,ij,tj->t", motion.potential, o.stiffness, motion.potential)
    level = np.einsum("ti,ij,tj->t", motion.eta, o.mass, motion.eta)
    body = (structure.mass + water.added_mass_at_once_kg) * motion.v**2 + structure.stiffness * motion.x**2
    return 0.5 * (body + scale * (kinetic + GRAVITY * level))
