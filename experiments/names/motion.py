"""The truth: one released body with every law that can be hidden, integrated in fine fixed steps.

M x'' + (structure) + (water) + (what is hidden) = 0, with sliding friction that can hold the body. Fourth-order
Runge-Kutta at 4 kHz; each velocity reversal is found inside its step, where the direction of friction changes and the
body may stick. Belongs here: laws and their integration. Does not belong here: how large anything is (rigs.py,
effects.py), what sensors make of it (recordings.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SLOTS = (
    *("M", "c", "k", "fc", "q"),  # inertia, viscous damping, stiffness, friction force, drag
    *("c3", "d", "p"),  # cubic damping; drag d |v|^p sign(v)
    *("k2", "k3", "k5", "ks"),  # springs: x^2, x^3, x^5, sin(x)
    *("fs", "vs", "fa", "n", "xb"),  # Stribeck force and speed, one-sided friction, normal force with |x|, presliding
    *("hm", "hw", "hz", "hb", "hg"),  # resonator: mass, rate, damping ratio, quadratic damping, cubic stiffness
    *("rk", "rt", "kh", "xh"),  # relaxation: stiffness, time; hysteresis: stiffness, yield displacement
    *("A", "om", "ph", "dec", "ge", "te"),  # outside force: amplitude, rate, phase, decay rate; echo: gain, delay
    *("rest", "ramp", "my", "ky", "cy"),  # anchor's place, seconds of the release; support: mass, stiffness, damping
)
"""Every number of the equation, SI units, in the order in which the integrator takes them."""

STEP_S = 2.5e-4
"""Longest step of the integration, s: 2000 a period of the stiffest spring."""

BISECTIONS = 40
"""Halvings with which a reversal is found in its step: to the last digit of the time."""

M, C, K, FC, Q, C3, D, P, K2, K3, K5, KS, FS, VS, FA, N, XB, HM, HW, HZ, HB, HG, RK, RT, KH, XH = range(26)
A, OM, PH, DEC, GE, TE, REST, RAMP, MY, KY, CY = range(26, 37)


@dataclass(frozen=True)
class Path:
    """A released motion on even steps: t (s from the release), x, v, a, spring force, each (n,); ``stopped_s`` is when
    the body came to rest for good (the last instant where it never did)."""

    t: Floats
    x: Floats
    v: Floats
    a: Floats
    spring: Floats
    stopped_s: float

    def at(self, times: Floats) -> tuple[Floats, Floats, Floats]:
        """x, a and spring force at ``times`` (m,), s from the release, by cubic and straight interpolation."""
        h = self.t[1]
        i = np.clip((times / h).astype(int), 0, self.t.size - 2)
        s = times / h - i
        x0, x1, v0, v1 = self.x[i], self.x[i + 1], h * self.v[i], h * self.v[i + 1]
        x = x0 + s * (v0 + s * (3 * (x1 - x0) - 2 * v0 - v1 + s * (2 * (x0 - x1) + v0 + v1)))
        return x, np.interp(times, self.t, self.a), np.interp(times, self.t, self.spring)


def release(numbers: Mapping[str, float], x0: float, duration_s: float, step_s: float = STEP_S) -> Path:
    """Motion after a release from rest at ``x0``; numbers by slot, 0 where not given (p: 1, times: 1 s).

    Raises KeyError for a number that the equation does not have.
    """
    unknown = set(numbers) - set(SLOTS)
    if unknown:
        raise KeyError(f"the equation has no number {sorted(unknown)[0]!r}; it has {', '.join(SLOTS)}")
    held = {"p": 1.0, "vs": 1.0, "rt": 1.0, "xh": 1.0, "te": 1.0, "hw": 1.0}
    theta = np.array([float(numbers.get(s, held.get(s, 0.0))) for s in SLOTS])
    count = int(np.ceil(duration_s / step_s))
    x, v, a, spring = _march(theta, x0, duration_s / count, count)
    moving = np.flatnonzero(v)
    t = np.arange(count + 1) * (duration_s / count)
    return Path(t, x, v, a, spring, float(t[moving[-1]]) if moving.size else 0.0)


@njit(cache=True)
def _spring(p, x, y):
    """Spring force on the body, N; springs are stretched by x - rest - y."""
    e = x - p[REST] - y
    return e * (p[K] + e * (p[K2] + e * (p[K3] + e * e * p[K5]))) + p[KS] * np.sin(e)


@njit(cache=True)
def _water(p, s, u):
    """Acceleration of the resonator by its own restoring and damping, m/s^2."""
    return 2.0 * p[HZ] * p[HW] * u + p[HW] ** 2 * s + p[HB] * u * abs(u) + p[HG] * s**3


@njit(cache=True)
def _without_friction(p, t, w, d, late, hold):
    """Every force on the left-hand side but sliding friction, N; d is the direction of motion."""
    x, v = w[0], w[1]
    force = _spring(p, x, w[7]) + p[C] * v + p[Q] * d * v * v + p[C3] * v**3
    if p[D] != 0.0:
        force += p[D] * d * abs(v) ** p[P]
    if p[XB] > 0.0:
        force += p[FC] * w[6] / p[XB]
    force += w[4] + w[5] + p[GE] * late + p[A] * np.exp(-p[DEC] * t) * np.cos(p[OM] * t + p[PH])
    if t < p[RAMP]:
        force -= hold * (1.0 - t / p[RAMP])
    return force - p[HM] * _water(p, w[2], w[3])


@njit(cache=True)
def _friction(p, x, v):
    """Size of the sliding friction, N, without what acts to one side."""
    sliding = 0.0 if p[XB] > 0.0 else p[FC]
    return sliding + p[FS] * np.exp(-((v / p[VS]) ** 2)) + p[N] * abs(x)


@njit(cache=True)
def _rates(p, t, w, d, late, hold, out):
    """Time derivative of the state w = x, v, s, s', relaxation, hysteresis, bristle, support y, y'; d = 0 is stuck."""
    a = 0.0
    if d != 0.0:
        a = -(_without_friction(p, t, w, d, late, hold) + d * _friction(p, w[0], w[1]) + p[FA]) / p[M]
    v = w[1] if d != 0.0 else 0.0
    out[0], out[1], out[2] = v, a, w[3]
    out[3] = -a - _water(p, w[2], w[3])
    out[4] = p[RK] * v - w[4] / p[RT]
    out[5] = v * (p[KH] - d * w[5] / p[XH])
    out[6] = v * (1.0 - d * w[6] / p[XB]) if p[XB] > 0.0 else 0.0
    out[7] = w[8]
    out[8] = (_spring(p, w[0], w[7]) - p[KY] * w[7] - p[CY] * w[8]) / p[MY] if p[MY] > 0.0 else 0.0


@njit(cache=True)
def _late(p, t, h, v, known):
    """Speed at t - te, m/s; 0 before the release."""
    place = (t - p[TE]) / h
    i = int(np.floor(place))
    if i < 0 or i + 1 > known:
        return 0.0
    return v[i] + (place - i) * (v[i + 1] - v[i])


@njit(cache=True)
def _step(p, t, dt, w, d, late, hold, work):
    """One Runge-Kutta step of dt from w into work[5]; late is the delayed speed at its start, middle and end."""
    k1, k2, k3, k4, mid, new = work[0], work[1], work[2], work[3], work[4], work[5]
    _rates(p, t, w, d, late[0], hold, k1)
    mid[:] = w + 0.5 * dt * k1
    _rates(p, t + 0.5 * dt, mid, d, late[1], hold, k2)
    mid[:] = w + 0.5 * dt * k2
    _rates(p, t + 0.5 * dt, mid, d, late[1], hold, k3)
    mid[:] = w + dt * k3
    _rates(p, t + dt, mid, d, late[2], hold, k4)
    new[:] = w + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


@njit(cache=True)
def _direction(p, t, w, late, hold):
    """Where a body at rest goes: +1, -1, or 0 where friction holds it."""
    drive = -_without_friction(p, t, w, 1.0, late, hold)
    most = _friction(p, w[0], 0.0)
    if drive > most + p[FA]:
        return 1.0
    return -1.0 if drive < p[FA] - most else 0.0


@njit(cache=True)
def _march(p, x0, h, count):
    """The whole record: x, v, a and spring force at every step."""
    x, v, a, spring = np.zeros(count + 1), np.zeros(count + 1), np.zeros(count + 1), np.zeros(count + 1)
    work, w, late = np.zeros((6, 9)), np.zeros(9), np.zeros(3)
    w[0] = x0
    if p[MY] > 0.0:  # the support gives way before the release: k (x0 - y) = ky y
        w[7] = p[K] * (x0 - p[REST]) / (p[K] + p[KY])
    hold = _spring(p, x0, w[7])
    if p[MY] > 0.0:
        w[7] = hold / p[KY]
    d = _direction(p, 0.0, w, 0.0, hold)
    for i in range(count + 1):
        t = i * h
        _rates(p, t, w, d, _late(p, t, h, v, i), hold, work[0])
        x[i], v[i], a[i], spring[i] = w[0], w[1], work[0, 1], _spring(p, w[0], w[7])
        left = h
        for _ in range(4):  # more reversals than that do not fit in a step
            start = t + h - left
            for j in range(3):
                late[j] = _late(p, start + 0.5 * j * left, h, v, i)
            if d == 0.0:
                d = _direction(p, start, w, late[0], hold)
            _step(p, start, left, w, d, late, hold, work)
            if d == 0.0 or work[5, 1] * d >= 0.0:
                w[:] = work[5]
                break
            low, high = 0.0, left
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                _step(p, start, middle, w, d, late, hold, work)
                if work[5, 1] * d >= 0.0:
                    low = middle
                else:
                    high = middle
            _step(p, start, high, w, d, late, hold, work)
            w[:] = work[5]
            w[1] = 0.0
            d = _direction(p, start + high, w, late[2], hold)
            left -= high
            if left <= 1e-12:
                break
    return x, v, a, spring
