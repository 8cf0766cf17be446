"""One trial of a driven body: what moved, what drove it, how noisy.

Belongs here: the frozen `DrivenTrial`, its parts, its noise. Does not belong here: what an input is between its samples
(equation/input.py), fits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

import numpy as np

from undertow.errors import RecordingError
from undertow.quantities import Hold, Mover, MovingQuantity, mover_of
from undertow.recording.recording import Array, Condition, read_only

Quantity = Literal["force"] | MovingQuantity
Frame = Literal["absolute", "relative"]
UNITS_OF_MOTION = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}
OUTPUTS = tuple(UNITS_OF_MOTION)
FEWEST_SAMPLES = 200
"""A driven trial of fewer samples is refused: a start state and a handful of numbers want more."""

HOLE_STEPS = 5.0
"""Time steps from which on samples are missing: between them a body may have been driven by anything."""

MOVES = 0.9999
"""Share of a motion's power in what it does; the rest may be noise."""

ROUNDING = 1e-9
"""Least noise of a channel, relative to its range."""


@dataclass(frozen=True, eq=False)
class DrivenTrial:
    """Time ``t`` (n,) s, rising; ``u`` (n,) the input; ``outputs`` quantity -> (n,); all in SI or the file's own unit.

    ``quantity`` says what the input is (`Quantity`), ``hold`` what it is between samples: zero, first, band_limited.
    Where a base moves, ``frames`` says of each output whether it is recorded against the earth (absolute) or against
    the base (relative). ``instrument`` (n,) is a signal that moves the body and that no noise of it reaches (the target
    of a controller), where there is one. ``free`` says that nothing drives it: a decay of the
    same body, whose input is 0. Raises RecordingError where lengths differ, a value is not finite, time does
    not rise, nothing that moved is there, input or instrument never change, or a frame is not said or cannot be had
    from what was recorded.
    """

    name: str
    t: Array
    u: Array
    outputs: Mapping[str, Array]
    quantity: Quantity = "force"
    hold: Hold = "first"
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    frames: Mapping[str, Frame] = field(default_factory=dict)
    instrument: Array | None = None
    free: bool = False

    def __post_init__(self) -> None:
        if self.instrument is not None:
            object.__setattr__(self, "instrument", read_only(self.instrument))
        object.__setattr__(self, "t", read_only(self.t))
        object.__setattr__(self, "u", read_only(self.u))
        object.__setattr__(
            self, "outputs", MappingProxyType({name: read_only(values) for name, values in self.outputs.items()})
        )
        self._check()

    def _check(self) -> None:
        n = self.t.size
        if not self.outputs or any(name not in OUTPUTS for name in self.outputs):
            have = ", ".join(self.outputs) or "nothing"
            raise RecordingError(
                f"trial {self.name}: {have} is recorded of the motion; a fit needs {OUTPUTS[0]}: map it"
            )
        beside = {} if self.instrument is None else {"instrument": self.instrument}
        for name, values in {self.quantity: self.u, **self.outputs, **beside}.items():
            if values.size != n:
                raise RecordingError(
                    f"trial {self.name}: {name} has {values.size} samples but time has {n}; give every channel one "
                    "value a time stamp"
                )
            if not np.all(np.isfinite(values)):
                bad = int(np.count_nonzero(~np.isfinite(values)))
                raise RecordingError(
                    f"trial {self.name}: {name} has {bad} values that are not finite; repair the file or cut the window"
                )
        if n < FEWEST_SAMPLES:
            raise RecordingError(
                f"trial {self.name}: {n} samples; a driven trial needs {FEWEST_SAMPLES}: give a longer record"
            )
        if np.any(np.diff(self.t) <= 0.0):
            index = int(np.flatnonzero(np.diff(self.t) <= 0.0)[0])
            raise RecordingError(
                f"trial {self.name}: time goes from {self.t[index]:g} s to {self.t[index + 1]:g} s at sample "
                f"{index + 1}; time must rise"
            )
        steps = np.diff(self.t)
        longest = int(np.argmax(steps))
        if steps[longest] > HOLE_STEPS * float(np.median(steps)):
            raise RecordingError(
                f"trial {self.name}: no sample between {self.t[longest]:g} s and {self.t[longest + 1]:g} s, so that "
                f"nobody knows the input there (other steps are {float(np.median(steps)):.3g} s); cut the record "
                "(trials.window) on one side"
            )
        self._check_frames()
        if self.free and np.any(self.u):
            most = float(np.max(np.abs(self.u)))
            raise RecordingError(
                f"trial {self.name}: its input {self.quantity} is up to {most:.3g} in a decay, "
                "which nothing drives; cut the window to what follows the release, or take it for a driven trial"
            )
        if not self.free and _stands(self.u):
            raise RecordingError(
                f"trial {self.name}: the input {self.quantity} stays at {self.u[0]:g}; an input that never moves shows "
                "nothing of the equation: map the column that does, or leave the input out"
            )
        if self.instrument is not None and _stands(self.instrument):
            raise RecordingError(
                f"trial {self.name}: the instrument stays at {self.instrument[0]:g} and moves nothing; map the "
                "controller's target, or leave the instrument out"
            )

    def _check_frames(self) -> None:
        if self.mover != "base":
            return
        silent = [name for name in self.outputs if name not in self.frames]
        if silent:
            raise RecordingError(
                f"trial {self.name}: the base moves ({self.quantity}), and {silent[0]} has no frame; say frame: "
                "absolute (against the earth, as an accelerometer on the body) or relative (against the base)"
            )
        if "displacement" in self.absolute and self.quantity != "base_displacement":
            raise RecordingError(
                f"trial {self.name}: displacement is absolute, but {self.quantity} does not say where the base is; map "
                "base_displacement, or a displacement relative to the base"
            )

    @property
    def mover(self) -> Mover:
        """Whether the input is a force, or motion of the base or of the water."""
        return mover_of(self.quantity)

    @property
    def absolute(self) -> tuple[str, ...]:
        """Outputs that are recorded against the earth while the base moves."""
        return tuple(name for name in self.outputs if self.mover == "base" and self.frames.get(name) == "absolute")

    @property
    def rate_hz(self) -> float:
        """Median sampling rate, Hz."""
        return 1.0 / float(np.median(np.diff(self.t)))

    @property
    def main(self) -> str:
        """The output that scores are of: displacement where there is one, else velocity, else acceleration."""
        return next(name for name in OUTPUTS if name in self.outputs)

    def part(self, begin: int, end: int) -> DrivenTrial:
        """Samples ``begin`` to ``end`` (exclusive) as a trial of their own; its input is that of these samples."""
        cut = slice(begin, end)
        outputs = {name: values[cut] for name, values in self.outputs.items()}
        instrument = None if self.instrument is None else self.instrument[cut]
        return replace(self, t=self.t[cut], u=self.u[cut], outputs=outputs, instrument=instrument)

    def thinned(self, steps: int) -> DrivenTrial:
        """Every ``steps``-th sample of the motion, driven by the mean of the input in between."""
        n = self.t.size // steps * steps
        outputs = {name: values[:n:steps] for name, values in self.outputs.items()}
        instrument = None if self.instrument is None else self.instrument[:n:steps]
        mean = self.u[:n].reshape(-1, steps).mean(axis=1)
        return replace(self, t=self.t[:n:steps], u=mean, outputs=outputs, hold="zero", instrument=instrument)

    def slowness(self, samples: int) -> int:
        """How many steps between samples still leave so many ``samples`` a cycle of the fastest part of the motion, and
        a trial's fewest at least: of the main output without its line from end to end, `MOVES` of its power is slower.
        """
        values = self.outputs[self.main]
        moved = (values - np.linspace(values[0], values[-1], values.size)) * np.hanning(values.size)
        power = np.cumsum(np.abs(np.fft.rfft(moved)) ** 2)
        cycles = int(np.searchsorted(power, MOVES * power[-1])) + 1
        return max(1, min(values.size // (samples * cycles), values.size // (2 * FEWEST_SAMPLES)))

    def noise(self) -> dict[str, float]:
        """White noise of each output, 1 sigma, from sixth differences, which a motion sampled well does not have."""
        return {name: white_noise(values) for name, values in self.outputs.items()}


def _stands(values: Array) -> bool:
    """Whether a signal never moves, but for rounding."""
    return bool(np.ptp(values) <= ROUNDING * float(np.max(np.abs(values))))


def white_noise(values: Array) -> float:
    """White noise of samples (n,), 1 sigma, from sixth differences; at least `ROUNDING` of their range.

    >>> 0.9 < white_noise(np.random.default_rng(0).normal(size=5000)) < 1.1
    True
    """
    weights = [float(math.comb(6, i)) * (-1.0) ** i for i in range(7)]
    size = math.sqrt(sum(w * w for w in weights))
    seen = np.convolve(values, weights, "valid") / size
    rounding = ROUNDING * float(np.ptp(values)) or float(np.finfo(float).tiny)
    return max(float(np.median(np.abs(seen))) / 0.6745, rounding)
