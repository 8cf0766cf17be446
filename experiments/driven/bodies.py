"""Synthetic driven bodies with known laws: a carriage in closed loop, a sprung body under a random or a swept force.

Belongs here: their numbers, their records. Does not belong here: what the search makes of them (additions.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven import driven_motion
from undertow.equation.driven_laws import find_driven, places
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.input import MotionSize, drive_of
from undertow.equation.term import Term
from undertow.quantities import Mover
from undertow.recording.recording import Array

NOTHING = np.zeros(0, dtype=np.int64)
CARRIAGE_RATE_HZ, CARRIAGE_SAMPLES, CARRIAGE_NOISE_M = 200.0, 5000, 1e-5
SPRUNG_RATE_HZ, SPRUNG_SAMPLES, SPRUNG_NOISE_M = 100.0, 4000, 1e-4
STROKE_M, STROKE_S = 0.2, 2.5
"""Way and time of one stroke of a carriage; the way differs from stroke to stroke by the factors of SPEEDS, and the
carriage moves in that share of the time."""
SPEEDS, MOVING_SHARE = (0.35, 0.7, 1.0), 0.8
PUSHED_S = 0.3
"""Time in which a random push fades to 1/e."""
GIVEN = {
    "carriage": ("viscous_damping", "coulomb_friction", "constant_force"),
    "random": ("stiffness", "viscous_damping", "coulomb_friction"),
    "swept": ("stiffness", "viscous_damping", "coulomb_friction"),
}
"""Equation that the search begins with, by the kind of body."""


@dataclass(frozen=True)
class Body:
    """A body of a ``kind`` of GIVEN: its numbers by law.parameter and ``mass_kg``, and the law that GIVEN lacks (empty:
    none), whose numbers are among them."""

    kind: str
    seed: int
    missing: str
    numbers: Mapping[str, float]

    def theta(self, state: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Array:
        """The integrator's vector from a state x, v, z (m, m/s, N)."""
        laws = [find_driven(name) for name in (*GIVEN[self.kind], *([self.missing] if self.missing else []))]
        return theta_of(laws, self.numbers, dict(zip(("x0", "v0", "bw_z0"), state, strict=True)))


def slots_of(laws: Sequence[Term], mover: Mover | None = None) -> dict[str, str]:
    """The integrator's slot of each number, by law.parameter, ``mass_kg`` and ``input_delay_s``."""
    own = {place.name: place.slots[0] for place in places(laws, mover)}
    return own | {"mass_kg": "mass", "input_delay_s": "delay"}


def theta_of(
    laws: Sequence[Term], numbers: Mapping[str, float], more: Mapping[str, float], mover: Mover | None = None
) -> Array:
    """The integrator's vector of a body with these numbers, by their names of `slots_of`, and ``more`` by slot."""
    slots = slots_of(laws, mover)
    values = {"gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0} | dict(more)
    for law in laws:
        values |= law.constants
    theta = np.zeros(N_DRIVEN)
    for slot, value in (values | {slots[name]: value for name, value in numbers.items()}).items():
        theta[DRIVEN_SLOT[slot]] = value
    return theta


def body(kind: str, seed: int, missing: str = "") -> Body:
    """A body of that kind with numbers drawn from ``seed``, and the law it has beyond GIVEN."""
    rng = np.random.default_rng([seed, sorted(GIVEN).index(kind)])
    sign = float(rng.choice([-1.0, 1.0]))
    if kind == "carriage":
        mass = 95.0 * rng.uniform(0.6, 1.6)
        numbers = {
            "mass_kg": mass, "viscous_damping.c_Ns_per_m": 200.0 * rng.uniform(0.6, 1.6),
            "coulomb_friction.force_N": 20.0 * rng.uniform(0.6, 1.6), "constant_force.force_N": rng.uniform(-5.0, 5.0),
        }  # fmt: skip
        more = {
            "asymmetric_damping": (sign * 40.0,), "position_damping": (sign * 400.0,),
            "stribeck_friction": (10.0, 0.02), "bouc_wen": (2e4, 2e3, 0.0, 1.0, 1.0), "cubic_stiffness": (3000.0,),
        }  # fmt: skip
    else:
        mass = 4.0 * rng.uniform(0.6, 1.6)
        stiffness = 100.0 * rng.uniform(0.6, 1.6)
        numbers = {
            "mass_kg": mass, "stiffness.k_N_per_m": stiffness,
            "viscous_damping.c_Ns_per_m": 3.0 * rng.uniform(0.6, 1.6),
            "coulomb_friction.force_N": 3.0 * rng.uniform(0.6, 1.6),
        }  # fmt: skip
        more = {
            "asymmetric_damping": (sign,), "position_damping": (2.0 * sign,), "stribeck_friction": (2.0, 0.1),
            "bouc_wen": (0.5 * stiffness, 4.0, 0.0, 1.0, 1.0), "cubic_stiffness": (30.0,), "quadratic_drag": (4.0,),
            "hidden_resonator": (0.2 * mass, 1.6 * np.sqrt(stiffness / mass), 0.04, 0.0, 0.0),
        }  # fmt: skip
    if missing:
        own = places([find_driven(missing)])
        numbers |= {place.name: value for place, value in zip(own, more[missing], strict=True)}
    return Body(kind, seed, missing, numbers)


def record(
    one: Body,
    wanders_N: float = 0.0,
    pushed_N: float = 0.0,
    samples: int = CARRIAGE_SAMPLES,
    force: float = 1.0,
    again: int = 0,
    varies_N: tuple[float, float] = (0.0, 0.0),
) -> DrivenTrial:
    """The body's record with white noise. A carriage's drive may wander: a random walk of that size in a second, which
    the recorded force does not hold; or it is pushed by a random force of the rms ``pushed_N`` that fades over
    PUSHED_S and is not recorded either, so that the controller answers to it. ``samples`` is a carriage's length.
    A carriage's offset and friction vary from one pair of strokes, there and back, to the next by ``varies_N`` (1
    sigma). A sprung body's force is so many times as large by ``force``; ``again`` counts fresh records of a body."""
    rng = np.random.default_rng([one.seed, 99 + again])
    if one.kind == "carriage":
        return _carriage(one, rng, wanders_N, pushed_N, samples, varies_N)
    t = np.arange(SPRUNG_SAMPLES) / SPRUNG_RATE_HZ
    u = np.convolve(rng.normal(size=t.size + 30), np.hanning(30), "same")[: t.size] * 12.0
    if one.kind == "swept":
        u = 25.0 * np.sin(2.0 * np.pi * (0.2 * t + 0.5 * 1.6 / t[-1] * t**2))
    u = force * u
    x = driven_motion(one.theta(), NOTHING, drive_of(t, u, "first"), t, MotionSize(), 60).x[:, 0]
    return DrivenTrial(one.kind, t, u, {"displacement": x + SPRUNG_NOISE_M * rng.normal(size=t.size)}, hold="first")


def target_m(t: Array) -> Array:
    """Where a carriage is told to be: strokes there and back with smooth ends, at the speeds of SPEEDS in turn."""
    number = np.floor(t / STROKE_S).astype(int)
    speed = np.array(SPEEDS)[(number // 2) % len(SPEEDS)]
    way = np.clip((t / STROKE_S - number) / MOVING_SHARE, 0.0, 1.0)
    smooth = way**3 * (10.0 - 15.0 * way + 6.0 * way**2)
    return np.asarray(STROKE_M * speed * np.where(number % 2 == 0, smooth, 1.0 - smooth))


def by_stroke_N(t: Array, varies_N: tuple[float, float], rng: np.random.Generator) -> Array:
    """Force (n,) against a carriage that offset and friction beyond their means give, those of each pair of strokes."""
    stroke = np.floor(t / STROKE_S).astype(int)
    drawn = rng.normal(size=(2, int(stroke[-1]) // 2 + 1)) * np.array(varies_N)[:, None]
    return np.asarray(drawn[0][stroke // 2] + np.where(stroke % 2 == 0, 1.0, -1.0) * drawn[1][stroke // 2])


def _carriage(
    one: Body,
    rng: np.random.Generator,
    wanders_N: float,
    pushed_N: float,
    samples: int,
    varies_N: tuple[float, float],
) -> DrivenTrial:
    """A carriage whose force a controller makes of the recorded position, a step of the logger at a time."""
    step = 1.0 / CARRIAGE_RATE_HZ
    t = np.arange(samples) * step
    wanted, mass = target_m(t), one.numbers["mass_kg"]
    noise = CARRIAGE_NOISE_M * rng.normal(size=t.size)
    lost = wanders_N * np.sqrt(step) * np.cumsum(rng.normal(size=t.size))
    if pushed_N:
        kept = np.exp(-step / PUSHED_S)
        fresh = np.sqrt(1.0 - kept**2) * rng.normal(size=t.size)
        lost = lost + pushed_N * lfilter([1.0], [1.0, -kept], fresh)
    if any(varies_N):
        lost = lost - by_stroke_N(t, varies_N, rng)
    stiff, damped = mass * 30.0**2, mass * 2.0 * 30.0
    state, u, x = (0.0, 0.0, 0.0), np.zeros(t.size), np.zeros(t.size)
    before = wanted[0]
    for i in range(t.size):
        x[i] = state[0] + noise[i]
        rate = (wanted[i] - wanted[max(i - 1, 0)] - (x[i] - before)) / step if i else 0.0
        before = x[i]
        u[i] = stiff * (wanted[i] - x[i]) + damped * rate
        force = drive_of(np.array([0.0, step]), np.full(2, u[i] + lost[i]), "zero")
        moved = driven_motion(one.theta(state), NOTHING, force, np.array([0.0, step]), MotionSize(), 60)
        z = float(moved.hidden[-1, 0]) if moved.hidden.size else 0.0
        state = (float(moved.x[-1, 0]), float(moved.v[-1, 0]), z)
    return DrivenTrial("carriage", t, u, {"displacement": x}, hold="zero", instrument=wanted)
