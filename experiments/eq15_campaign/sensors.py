"""What the laboratory's sensors make of a motion: gain, offset, drift, noise and a 14-bit converter.

One string potentiometer, one accelerometer and two load cells that share the spring force. The choices are
ordinary for such instruments; none of them is printed in the report.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

GAIN_ERROR = 0.002
"""One standard deviation of a sensor's relative gain error, constant over the campaign."""

CONVERTER_BITS = 14
DRIFT_PERIODS_S = (15.0, 40.0)
"""Periods of the drift: one wave or less in a 15 s record, far slower than the body (below 1.2 s)."""


@dataclass(frozen=True)
class Sensor:
    """One channel, in its own unit.

    Attributes
    ----------
    column : name of its column in a recording, unit included.
    noise : standard deviation of white noise.
    offset : largest offset of a record (uniform between - and +).
    drift : largest departure by drift within a record.
    full_scale : range of the converter, - to +.
    decimals : digits printed.
    """

    column: str
    noise: float
    offset: float
    drift: float
    full_scale: float
    decimals: int

    @property
    def step(self) -> float:
        """One converter step: full range / 2^14."""
        return 2.0 * self.full_scale / 2**CONVERTER_BITS


SENSORS = (
    Sensor("disp_m", noise=5e-5, offset=1.5e-4, drift=2e-4, full_scale=0.15, decimals=6),
    Sensor("accel_mps2", noise=0.05, offset=0.025, drift=0.02, full_scale=20.0, decimals=4),
    Sensor("loadcell1_N", noise=3.0, offset=10.0, drift=0.0, full_scale=25_000.0, decimals=1),
    Sensor("loadcell2_N", noise=3.0, offset=10.0, drift=0.0, full_scale=25_000.0, decimals=1),
)

LOAD_SHARES = (0.49, 0.51)
"""Parts of the spring force k x that the two load cells carry."""


def draw_gains(rng: np.random.Generator) -> dict[str, float]:
    """Gain of each sensor (-), the same in every recording of a campaign: 1 + 0.2 % normal."""
    return {sensor.column: round(1.0 + GAIN_ERROR * rng.standard_normal(), 6) for sensor in SENSORS}


def drift(rng: np.random.Generator, times_s: Floats, largest: float) -> Floats:
    """Smooth drift at `times_s` (s, shape (n,)), zero at the first sample, never beyond `largest`.

    d(t) = D/2 [sin(2 pi t / T + phase) - sin(phase)] with D in +-`largest` and T between 15 and 40 s.
    """
    size = rng.uniform(-largest, largest)
    period_s = rng.uniform(*DRIFT_PERIODS_S)
    phase = rng.uniform(0.0, 2.0 * np.pi)
    return 0.5 * size * (np.sin(2.0 * np.pi * times_s / period_s + phase) - np.sin(phase))


def read(
    rng: np.random.Generator, sensor: Sensor, gain: float, times_s: Floats, quantity: Floats
) -> tuple[Floats, float]:
    """Reading of `quantity` (shape (n,), the sensor's unit) and the record's offset.

    reading = quantise(gain * quantity + offset + drift + noise), held within the converter's range.
    """
    offset = round(rng.uniform(-sensor.offset, sensor.offset), sensor.decimals + 1)
    slow = drift(rng, times_s, sensor.drift)
    noise = sensor.noise * rng.standard_normal(times_s.size)
    steps = np.rint((gain * quantity + offset + slow + noise) / sensor.step)
    top = 2 ** (CONVERTER_BITS - 1)
    return np.clip(steps, -top, top - 1) * sensor.step + 0.0, offset
