"""Recorded channels through short windows about the motion's frequency, where any two of one motion are proportional.

A test function phi(t) = cos^4(pi s / L) exp(i w s), |s| < L / 2, ends with its first three derivatives at zero, so that

    int phi x'' dt = int phi'' x dt = -int phi' v dt

holds for every motion, free, driven, damped or hidden, without a derivative of noisy samples (weak form). Over L of
three periods a constant leaves nothing; over shorter windows it is an unknown. A complex factor between two channels is
then their gain and, as its angle, their clocks' difference.

Source: the modulating functions of Shinbrot 1957, doi:10.1115/1.4011457.

Belongs here: windows, what channels leave in them, the factor between two. Does not belong here: what a factor means
(agreement.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from undertow.conditioning.motion import Window
from undertow.conditioning.release import followed
from undertow.conditioning.swings import find_swings
from undertow.recording.noise import noise
from undertow.recording.recording import Array, Recording

Complex = NDArray[np.complex128]

ORDERS: Mapping[str, int] = {"displacement": 2, "velocity": 1, "acceleration": 0}
"""How often a channel is differentiated to be an acceleration."""

PERIODS_A_WINDOW = 3.0
"""Length of a window in periods: cos^4 over three periods has no constant at the motion's frequency."""

FEWEST_PERIODS = 1.0
"""Less motion than this compares nothing."""

SHARE_OF_SHORT = 0.8
"""A window's share of a motion that is shorter than four windows apart."""

STEPS_A_PERIOD = 2.0
"""Windows begin so many times a period."""

MOST_PERIODS = 30.0
"""Motion that is looked at, from its beginning, where it is largest."""

CELLS_PER_PERIOD = 48.0
"""Samples are averaged to about so many a period; all channels alike, so that no factor moves."""

FEWEST_SAMPLES_PER_PERIOD = 8.0
"""Fewer samples a period do not show its shape."""

EVEN = 0.005
"""Steps in time that vary by more than this share are interpolated to even ones (cubic spline)."""

LONGEST_GAP = 0.2
"""A gap of more than this share of a period is not interpolated: windows over it are left out."""

OVERLAP = 2.5
"""Windows that see the same samples are so many times fewer than they seem."""


@dataclass(frozen=True)
class Relation:
    """A channel over another one in the band: complex ``factor`` with the standard error of its size; over the size,
    that of its angle in rad.

    ``coherence`` is the share of the first channel's power, noise apart, that goes with the second; ``loudness`` the
    first channel's power in the band over that of its noise.
    """

    factor: complex
    stderr: float
    coherence: float
    loudness: float

    @property
    def size(self) -> float:
        """Absolute value of the factor."""
        return abs(self.factor)


@dataclass(frozen=True)
class Band:
    """One trial's channels (n,) on even steps (s) and the test functions (w, n) with their first two derivatives;
    ``noise`` is the standard deviation of each channel's values, ``period_s`` the motion's period."""

    step_s: float
    period_s: float
    channels: Mapping[str, Array]
    noise: Mapping[str, float]
    tests: tuple[Complex, Complex, Complex]

    def relation(self, first: str, second: str, orders: tuple[int, int] | None = None) -> Relation:
        """``first`` over ``second``, each differentiated so often (``orders``; None: to accelerations).

        The one that is recorded with less noise explains the other, so that noise flattens nothing.
        """
        high, low = orders or (ORDERS[first], ORDERS[second])
        y, y_weights = self._seen(first, high)
        x, x_weights = self._seen(second, low)
        constant = self.tests[0].sum(axis=1) * self.step_s * float(high == 0 or low == 0)
        y_noise = self._power(first, y_weights)
        x_noise = self._power(second, x_weights)
        loudness = _power_beside(y, constant) / y_noise
        if loudness >= _power_beside(x, constant) / x_noise:
            turned = _factor(x, y, constant, (x_weights, y_weights), (self.noise[second], self.noise[first]))
            if turned.size > 0.0:
                return Relation(1.0 / turned.factor, turned.stderr / turned.size**2, turned.coherence, loudness)
        found = _factor(y, x, constant, (y_weights, x_weights), (self.noise[first], self.noise[second]))
        return replace(found, loudness=loudness)

    def _seen(self, channel: str, order: int) -> tuple[Complex, Complex]:
        """What a channel's derivative of this order leaves in each window, (w,), and the weights of its samples."""
        weights = (-1.0) ** order * self.tests[order] * self.step_s
        return weights @ self.channels[channel], weights

    def _power(self, channel: str, weights: Complex) -> float:
        """Mean power of a channel's noise in the windows; never zero."""
        least = np.finfo(float).eps * float(np.max(np.abs(self.channels[channel])))
        return max(self.noise[channel], least, 1e-300) ** 2 * float(np.mean(np.sum(np.abs(weights) ** 2, axis=1)))


def band_of(recording: Recording, window: Window, levels: Mapping[str, float] | None = None) -> Band | None:
    """The trial's motion in its band; None where it shows less than a period, or under eight samples of it.

    ``levels`` is the noise of every channel, where it is known already.
    """
    rows = (recording.time >= window.start_s) & (recording.time <= window.end_s)
    time, channel = recording.time[rows], followed(recording)
    if time.size < FEWEST_SAMPLES_PER_PERIOD:
        return None
    levels = levels or {name: noise(values) for name, values in recording.channels.items()}
    swings = find_swings(time, recording.channels[channel][rows], levels[channel])
    if swings.count == 0:
        return None
    period = 2.0 * swings.half_period_s
    step = float(np.median(np.diff(time)))
    if time[-1] - time[0] < FEWEST_PERIODS * period or period < FEWEST_SAMPLES_PER_PERIOD * step:
        return None
    many = max(1, math.floor(period / step / CELLS_PER_PERIOD))
    used = np.flatnonzero(rows)[: math.ceil(MOST_PERIODS * period / step)]
    used = used[: used.size // many * many].reshape(-1, many)
    cells = recording.time[used].mean(axis=1)
    at, gaps = _even(cells, float(np.median(np.diff(cells))), period)
    channels = {}
    for name, values in recording.channels.items():
        means = values[used].mean(axis=1)
        channels[name] = means if at is cells else _between(cells, means, at)
    tests = _tests(at, period, gaps)
    if tests is None:
        return None
    sigma = {name: level / math.sqrt(many) for name, level in levels.items()}
    return Band(float(at[1] - at[0]), period, channels, sigma, tests)


def _between(cells: Array, means: Array, at: Array) -> Array:
    """A cubic spline through the means of cells, at even instants."""
    from scipy.interpolate import CubicSpline  # half a second that evenly sampled recordings need not wait for

    return np.asarray(CubicSpline(cells, means)(at), dtype=np.float64)


def _even(cells: Array, step: float, period: float) -> tuple[Array, list[tuple[float, float]]]:
    """Even instants from the first cell to the last (the cells themselves where they are even), and long gaps."""
    steps = np.diff(cells)
    long = np.flatnonzero(steps > max(LONGEST_GAP * period, 1.5 * step))
    if float(np.max(np.abs(steps - step))) <= EVEN * step:
        return cells, []
    count = math.floor((cells[-1] - cells[0]) / step * (1.0 + 1e-12)) + 1
    return cells[0] + step * np.arange(count), [(float(cells[i]), float(cells[i + 1])) for i in long]


def _tests(at: Array, period: float, gaps: list[tuple[float, float]]) -> tuple[Complex, Complex, Complex] | None:
    """Test functions and their first two derivatives, (w, n) each; None where no window is free of gaps."""
    span = float(at[-1] - at[0])
    length = min(PERIODS_A_WINDOW * period, SHARE_OF_SHORT * span)
    count = max(4, math.floor((span - length) * STEPS_A_PERIOD / period) + 1)
    centres = at[0] + 0.5 * length + np.linspace(0.0, span - length, count)
    free = [c for c in centres if not any(a < c + 0.5 * length and b > c - 0.5 * length for a, b in gaps)]
    if not free:
        return None
    s = at[None, :] - np.array(free)[:, None]
    q, w = math.pi / length, 2.0 * math.pi / period
    inside = np.abs(s) < 0.5 * length
    c, n = np.where(inside, np.cos(q * s), 0.0), np.sin(q * s)
    bell, slope = c**4, -4.0 * q * c**3 * n
    bend = 4.0 * q * q * (3.0 * c**2 * n**2 - c**4)
    wave = np.exp(1j * w * s)
    return bell * wave, (slope + 1j * w * bell) * wave, (bend + 2j * w * slope - w * w * bell) * wave


def _power_beside(seen: Complex, constant: Complex) -> float:
    """Mean power in the windows beside what a constant leaves there."""
    size = float(np.vdot(constant, constant).real)
    rest = seen - constant * (np.vdot(constant, seen).real / size) if size > 0.0 else seen
    return float(np.mean(np.abs(rest) ** 2))


def _factor(
    y: Complex, x: Complex, constant: Complex, weights: tuple[Complex, Complex], sigma: tuple[float, float]
) -> Relation:
    """y = factor x + a constant, by least squares over all windows; its error from noise, or from what is left."""
    columns = [np.concatenate([x.real, x.imag]), np.concatenate([-x.imag, x.real])]
    if np.any(constant):
        columns.append(np.concatenate([constant.real, constant.imag]))
    table, seen = np.column_stack(columns), np.concatenate([y.real, y.imag])
    scale = np.linalg.norm(table, axis=0) + 1e-300
    inverse = np.linalg.pinv(table / scale) / scale[:, None]
    solution = inverse @ seen
    rest = seen - table @ solution
    factor = complex(solution[0], solution[1])
    by_noise = 0.0
    for one, std in ((weights[0], sigma[0]), (factor * weights[1], sigma[1])):
        moved = inverse[:2] @ np.vstack([one.real, one.imag])
        by_noise += 0.5 * std**2 * float(np.sum(moved**2))
    freedom = max(seen.size - table.shape[1], 1)
    by_rest = OVERLAP * float(rest @ rest) / freedom * 0.5 * float(np.sum(inverse[:2] ** 2))
    expected = sigma[0] ** 2 * np.sum(np.abs(weights[0]) ** 2) + abs(factor) ** 2 * sigma[1] ** 2 * np.sum(
        np.abs(weights[1]) ** 2
    )
    power = _power_beside(y, constant) * y.size - sigma[0] ** 2 * float(np.sum(np.abs(weights[0]) ** 2))
    unexplained = max(float(rest @ rest) - float(expected), 0.0)
    coherence = 1.0 - min(unexplained / power, 1.0) if power > 0.0 else 0.0
    return Relation(factor, math.sqrt(max(by_noise, by_rest)), coherence, 0.0)
