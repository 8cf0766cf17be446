"""Free decays in closed form, of any size and speed, as a logger would record them; and mistakes planted in them.

A body on a spring with viscous damping and dry friction, and what it carries along: each half swing is a damped cosine
about a centre that friction shifts, so that x, v and a are exact. A second mode (water that sloshes) adds to it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.recording.recording import Recording

Array = NDArray[np.float64]
Channels = dict[str, Array]

STIFFNESS_N_PER_M = 4e5


@dataclass(frozen=True)
class Decay:
    """A release: frequency, samples a period, release (m), damping ratio, friction's half width and a second mode's
    share of the release, noise of every channel relative to its largest value, periods held and recorded."""

    frequency_hz: float = 1.0
    samples: float = 50.0
    size_m: float = 0.05
    damping: float = 0.02
    friction: float = 0.0
    second: float = 0.0
    noise: float = 1e-3
    held: float = 1.0
    periods: float = 15.0
    uneven: float = 0.0
    seed: int = 0

    @property
    def rate(self) -> float:
        """Angular frequency, rad/s."""
        return 2.0 * np.pi * self.frequency_hz

    @property
    def mass_kg(self) -> float:
        """What moves, from the stiffness of the load cells."""
        return STIFFNESS_N_PER_M / self.rate**2


def any_decay(rng: np.random.Generator) -> Decay:
    """A decay of any body between 0.05 and 300 Hz, a micrometre and 10 m, with noise of 1e-4 to 3e-2."""

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    return Decay(
        between(0.05, 300.0), between(12.0, 200.0), between(1e-6, 10.0), between(0.003, 0.08),
        float(rng.choice([0.0, between(0.003, 0.03)])), float(rng.choice([0.0, rng.uniform(0.05, 0.4)])),
        between(1e-4, 3e-2), between(0.6, 3.0), between(8.0, 40.0), float(rng.choice([0.0, 0.2])),
        int(rng.integers(1 << 30)),
    )  # fmt: skip


def exact(decay: Decay) -> tuple[Array, Channels]:
    """Instants (n,) and the exact channels (n,): displacement, velocity, acceleration, spring_force."""
    rng = np.random.default_rng(decay.seed)
    step = 1.0 / (decay.frequency_hz * decay.samples)
    n = round((decay.held + decay.periods) * decay.samples)
    time = step * (np.arange(n) + decay.uneven * (rng.random(n) - 0.5))
    since = time - decay.held / decay.frequency_hz
    x, v, a = _body(decay, since)
    if decay.second:
        other = Decay(1.23 * decay.frequency_hz, size_m=decay.second * decay.size_m, damping=decay.damping)
        x, v, a = (one + more for one, more in zip((x, v, a), _body(other, since), strict=True))
    return time, {"displacement": x, "velocity": v, "acceleration": a, "spring_force": STIFFNESS_N_PER_M * x}


def _body(decay: Decay, since: Array) -> tuple[Array, Array, Array]:
    """x, v, a of one mode: held before 0, half swing after half swing from there on."""
    w, z = decay.rate, decay.damping
    fast, width = w * np.sqrt(1.0 - z * z), decay.friction * abs(decay.size_m)
    x, v, a = np.full(since.size, decay.size_m), np.zeros(since.size), np.zeros(since.size)
    turn, sign, start, half = decay.size_m, np.sign(decay.size_m), 0.0, np.pi / fast
    while start < since[-1]:
        rows = (since >= start) & (since < start + half)
        if abs(turn) <= width:
            x[since >= start] = turn
            break
        centre, u = sign * width, since[rows] - start
        reach, fading = turn - centre, np.exp(-z * w * u)
        x[rows] = centre + reach * fading * (np.cos(fast * u) + z * w / fast * np.sin(fast * u))
        v[rows] = -reach * fading * w * w / fast * np.sin(fast * u)
        a[rows] = -reach * fading * w * w / fast * (fast * np.cos(fast * u) - z * w * np.sin(fast * u))
        turn, sign, start = centre - reach * np.exp(-z * w * half), -sign, start + half
    return x, v, a


Mistake = Callable[[Decay, Array, Channels], tuple[Array, Channels]]
"""What a mistake makes of instants and channels."""


def recorded(decay: Decay, names: tuple[str, ...] = ("displacement", "acceleration"), mistake: Mistake | None = None,
             offsets: float = 0.02) -> Recording:  # fmt: skip
    """A decay as recorded: noise and offsets of the sensors, then the mistake; ``names`` are the channels mapped."""
    time, channels = exact(decay)
    rng = np.random.default_rng(decay.seed + 1)
    noisy = {}
    for name, values in channels.items():
        largest = float(np.max(np.abs(values)))
        noisy[name] = values + largest * (decay.noise * rng.standard_normal(values.size) + offsets * rng.uniform(-1, 1))
    if mistake is not None:
        time, noisy = mistake(decay, time, noisy)
    return Recording("r1", time, {name: noisy[name] for name in names})


def times(**factors: float) -> Mistake:
    """Channels (or ``time``) multiplied: another unit, a turned sign, a gain."""

    def apply(decay: Decay, time: Array, channels: Channels) -> tuple[Array, Channels]:
        return factors.get("time", 1.0) * time, {n: factors.get(n, 1.0) * c for n, c in channels.items()}

    return apply


def replaced(**sources: Callable[[Decay, Array, Mapping[str, Array]], Array]) -> Mistake:
    """Channels that hold something else."""

    def apply(decay: Decay, time: Array, channels: Channels) -> tuple[Array, Channels]:
        return time, channels | {name: source(decay, time, channels) for name, source in sources.items()}

    return apply
