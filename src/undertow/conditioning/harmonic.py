"""Harmonic sets: steady motions under a force F cos(w t), or on a base that moves so, by amplitude and phase.

Belongs here: such a set, its motion relative to a base. Does not belong here: its file (recording/response_table.py),
steady motions of an equation (equation/steady_state.py), fits (methods/harmonic_set.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from undertow.errors import RecordingError
from undertow.quantities import Mover
from undertow.recording.recording import Array


@dataclass(frozen=True)
class HarmonicSet:
    """``rate`` (n,) rad/s, ``force`` (n,) N, and of the motion under it ``amplitude`` (n,) m or rad and ``phase`` (n,)
    rad before the force's; ``sigma`` (n,) their standard error in the unit of the amplitude (0: all alike, unknown).

    Where the base moves (``mover``) ``force`` is the amplitude of its acceleration, m/s^2, and the motion is relative
    to it (`on_base` makes such a set).
    """

    rate: Array
    force: Array
    amplitude: Array
    phase: Array
    sigma: Array = field(default_factory=lambda: np.zeros(0))
    mover: Mover = "force"

    def __post_init__(self) -> None:
        sizes = {v.size for v in (self.rate, self.force, self.amplitude, self.phase)}
        if len(sizes) != 1 or self.sigma.size not in (0, self.rate.size):
            raise RecordingError(
                f"harmonic set: {self.rate.size} frequencies, {self.force.size} forces, {self.amplitude.size} "
                f"amplitudes, {self.phase.size} phases and {self.sigma.size} errors; give one of each a point"
            )
        every = np.concatenate([self.rate, self.force, self.amplitude, self.phase])
        if not np.all(np.isfinite(every)) or np.any(self.rate <= 0.0) or np.any(self.amplitude <= 0.0):
            raise RecordingError(
                "harmonic set: frequencies and amplitudes must be finite and above zero, forces and phases finite; got "
                f"frequencies from {self.rate.min(initial=math.inf) / (2.0 * math.pi):.3g} Hz, amplitudes from "
                f"{self.amplitude.min(initial=math.inf):.3g}; leave such points out"
            )
        if np.any(self.force == 0.0):
            still = int(np.sum(self.force == 0.0))
            what = "force is 0 N" if self.mover == "force" else "base stands still"
            raise RecordingError(f"harmonic set: the {what} at {still} points; leave them out")

    @property
    def cosine(self) -> Array:
        """Part of the motion with cos(w t), (n,)."""
        return np.asarray(self.amplitude * np.cos(self.phase))

    @property
    def sine(self) -> Array:
        """Part of the motion with sin(w t), (n,)."""
        return np.asarray(-self.amplitude * np.sin(self.phase))

    def part(self, chosen: np.ndarray) -> HarmonicSet:
        """The set of these points, by mask or place."""
        sigma = self.sigma[chosen] if self.sigma.size else self.sigma
        return HarmonicSet(
            self.rate[chosen], self.force[chosen], self.amplitude[chosen], self.phase[chosen], sigma, self.mover
        )


def on_base(
    rate: Array, base: Array, quantity: str, motion: tuple[Array, Array], sigma: Array, absolute: bool
) -> HarmonicSet:
    """The set of a body on a base that moves as ``base`` cos(w t) (m, or m/s^2 of its acceleration, by ``quantity``
    base_displacement or base_acceleration); ``motion`` is amplitude and phase before the base's ``quantity``, against
    the earth (``absolute``) or relative to the base.

        y'' = -w^2 Y cos(w t),   z = x - y
    """
    acceleration = -(rate**2) * base if quantity == "base_displacement" else base
    if not absolute:
        return HarmonicSet(rate, acceleration, *motion, sigma, "base")
    amplitude, phase = motion
    cosine, sine = amplitude * np.cos(phase) + acceleration / rate**2, -amplitude * np.sin(phase)
    return HarmonicSet(rate, acceleration, np.hypot(cosine, sine), np.arctan2(-sine, cosine), sigma, "base")
