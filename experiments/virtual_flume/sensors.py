"""What instruments make of the truth: gain, offset, slow drift, noise, quantisation. No physics here."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.virtual_flume.trials import Plan, Trial

Array = np.ndarray


@dataclass(frozen=True)
class Sensor:
    """One channel. All but `bits` and `gain_scatter` are in the channel's unit.

    `noise`: white, one sigma a sample. `offset`: largest, uniform, one draw a trial. `drift`: one sigma of a
    smooth wander over the record. `full_scale`: the converter spans +- this with `bits` bits.
    `gain_scatter`: relative, one sigma, one draw an instrument for the whole campaign. `decimals`: printed.
    """

    column: str
    unit: str
    noise: float
    offset: float
    drift: float
    full_scale: float
    bits: int
    decimals: int
    gain_scatter: float = 0.003

    @property
    def quantum(self) -> float:
        """Least step of the converter, in the channel's unit."""
        return 2.0 * self.full_scale / 2**self.bits


SENSORS = (
    Sensor("disp_m", "m", 2.5e-5, 1.5e-4, 2.0e-5, 0.2, 14, 6),
    Sensor("accel_mps2", "m/s^2", 0.012, 0.025, 0.003, 20.0, 16, 4),
    Sensor("loadcell1_N", "N", 3.0, 8.0, 2.0, 12_500.0, 14, 1),
    Sensor("loadcell2_N", "N", 3.0, 8.0, 2.0, 12_500.0, 14, 1),
    Sensor("vload1_N", "N", 5.0, 20.0, 4.0, 25_000.0, 14, 1),
    Sensor("vload2_N", "N", 5.0, 20.0, 4.0, 25_000.0, 14, 1),
)


def smooth_wander(rng: np.random.Generator, samples: int) -> Array:
    """A drift of unit size: three half-waves over the record with random weights, (samples,)."""
    t = np.linspace(0.0, 1.0, samples)
    weights = rng.standard_normal(3) / np.array([1.0, 2.0, 3.0])
    return sum(w * np.cos(np.pi * (i + 1) * t) for i, w in enumerate(weights)) / np.sqrt(49.0 / 36.0)


def record(sensor: Sensor, truth: Array, gain: float, rng: np.random.Generator) -> Array:
    """The channel as stored, (samples,), in its unit; clipped at full scale."""
    offset = rng.uniform(-sensor.offset, sensor.offset)
    drift = sensor.drift * smooth_wander(rng, truth.size)
    noisy = gain * truth + offset + drift + sensor.noise * rng.standard_normal(truth.size)
    clipped = np.clip(noisy, -sensor.full_scale, sensor.full_scale)
    return sensor.quantum * np.round(clipped / sensor.quantum)


def instrument_gains(rng: np.random.Generator) -> dict[str, float]:
    """One gain an instrument, the same in every trial."""
    return {s.column: 1.0 + s.gain_scatter * float(rng.standard_normal()) for s in SENSORS}


def recording(plan: Plan, trial: Trial, chosen: Sequence[Sensor], truths: Sequence[Array], decimals: int) -> bytes:
    """A trial's file before compression: what sensors make of these quantities, as CSV with a header line;
    ``decimals`` are those of the time."""
    gains = instrument_gains(np.random.default_rng([plan.seed, 10_000]))
    rng = np.random.default_rng([plan.seed, trial.number, 1])
    columns = [record(s, y, gains[s.column], rng) for s, y in zip(chosen, truths, strict=True)]
    out = io.StringIO()
    out.write(",".join(["time_s", *[s.column for s in chosen]]) + "\n")
    for i, row in enumerate(zip(*columns, strict=True)):
        cells = [f"{value + 0.0:.{s.decimals}f}" for s, value in zip(chosen, row, strict=True)]
        out.write(f"{i / plan.rate_hz:.{decimals}f}," + ",".join(cells) + "\n")
    return out.getvalue().encode()
