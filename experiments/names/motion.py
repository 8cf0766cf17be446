"""The truth: one released body with every law that can be hidden.

M x'' + (structure) + (water) + (what is hidden) = 0, with sliding friction that can hold the body, moved by the blind
challenge's integrator. Belongs here: the equation's numbers as its laws. Does not belong here: how large anything is
(rigs.py, effects.py), what sensors make of it (recordings.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.motion import Body, Law, simulate

Floats = NDArray[np.float64]

SLOTS = (
    *("M", "c", "k", "fc", "q"),  # inertia, viscous damping, stiffness, friction force, drag
    *("c3", "d", "p", "ca", "qa"),  # cubic damping; drag d |v|^p sign(v); what differs with the direction: |v|, v^2
    *("k2", "k3", "k5", "ks"),  # springs: x^2, x^3, x^5, sin(x)
    *("fs", "vs", "fa", "n", "xb"),  # Stribeck force and speed, one-sided friction, normal force with |x|, presliding
    *("hm", "hw", "hz", "hb", "hg"),  # resonator: mass, rate, damping ratio, quadratic damping, cubic stiffness
    *("rk", "rt", "kh", "xh"),  # relaxation: stiffness, time; hysteresis: stiffness, yield displacement
    *("A", "om", "ph", "dec", "ge", "te"),  # outside force: amplitude, rate, phase, decay rate; echo: gain, delay
    *("rest", "ramp", "my", "ky", "cy"),  # anchor's place, seconds of the release; support: mass, stiffness, damping
)
"""Every number of the equation, SI units. The anchor's place is that of the straight spring, which alone a support
holds."""

HELD = {"p": 1.0, "vs": 1.0, "rt": 1.0, "xh": 1.0, "te": 1.0, "hw": 1.0}
"""Numbers that are not 0 where they are not given."""

STEP_S = 2.5e-4
"""Spacing of the instants that are kept, s: 2000 a period of the stiffest spring."""

TOLERANCE = 1e-12


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
    p = dict.fromkeys(SLOTS, 0.0) | HELD | {slot: float(value) for slot, value in numbers.items()}
    count = int(np.ceil(duration_s / step_s))
    sliding = 0.0 if p["xb"] > 0.0 else p["fc"]  # bristles stand for Coulomb's jump
    body = Body(p["M"], p["c"], p["k"], sliding, p["q"], p["rest"])
    held = x0 - p["rest"]
    if p["my"] > 0.0:  # the support gives way before the release: k (x0 - y) = ky y
        held *= p["ky"] / (p["k"] + p["ky"])
    motion = simulate(body, _laws(p, x0, _spring(p, held)), x0, count + 1, duration_s / count, tolerance=TOLERANCE)
    support = motion.hidden[:, 0] if p["my"] > 0.0 else 0.0
    moving = np.flatnonzero(motion.v)
    stopped = float(motion.time[moving[-1]]) if moving.size else 0.0
    spring = _spring(p, motion.x - p["rest"] - support)
    return Path(motion.time, motion.x, motion.v, motion.a, np.asarray(spring), stopped)


def _spring(p: Mapping[str, float], e: Floats | float) -> Floats | float:
    """Force of springs that are stretched by ``e``, N."""
    return e * (p["k"] + e * (p["k2"] + e * (p["k3"] + e * e * p["k5"]))) + p["ks"] * np.sin(e)


def _laws(p: Mapping[str, float], x0: float, hold: float) -> tuple[Law, ...]:
    """What is there beside Eq. 15, the support first; ``hold`` is the spring's force before the release."""
    size = abs(x0)
    speed = size * np.sqrt(p["k"] / p["M"])
    given = hold / (p["ky"] or 1.0)
    found = [
        (p["my"], Law(codes.SUPPORT, (p["k"], p["my"], p["cy"], p["ky"]), (given, 0.0), (size, speed))),
        (p["c3"], Law(codes.CUBIC, (p["c3"],))),
        (p["d"], Law(codes.POWER, (p["d"], p["p"]))),
        (p["ca"], Law(codes.EVEN, (p["ca"], 1.0))),
        (p["qa"], Law(codes.EVEN, (p["qa"], 2.0))),
        (p["k2"] or p["k3"] or p["k5"], Law(codes.STIFF, (0.0, p["k2"], p["k3"], p["k5"]))),
        (p["ks"], Law(codes.SINE, (p["ks"],))),
        (p["fs"], Law(codes.STRIBECK, (p["fs"], p["vs"]))),
        (p["fa"], Law(codes.ONEWAY, (p["fa"],))),
        (p["n"], Law(codes.NORMAL, (p["n"],))),
        (p["xb"], Law(codes.DAHL, (p["fc"] / (p["xb"] or 1.0), p["xb"]), (0.0,), (p["fc"],))),
        (p["kh"], Law(codes.DAHL, (p["kh"], p["xh"]), (0.0,), (p["kh"] * p["xh"],))),
        (p["hm"], Law(codes.RESONATOR, tuple(p[s] for s in ("hm", "hw", "hz", "hb", "hg")), (0.0, 0.0), (size, speed))),
        (p["rk"], Law(codes.RELAX, (p["rk"], p["rt"]), (0.0,), (p["rk"] * size,))),
        (p["A"], Law(codes.FADING, (-p["A"], p["om"], p["ph"], p["dec"]))),
        (p["ge"], Law(codes.ECHO, (0.0, p["ge"], p["te"]))),
        (p["ramp"], Law(codes.RAMP, (hold, p["ramp"]))),
    ]
    return tuple(law for there, law in found if there)
