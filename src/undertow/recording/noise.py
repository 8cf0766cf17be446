"""Noise and finest step of a channel.

Belongs here: those two numbers. Does not belong here: what follows from them (quality.py, clipping.py).
"""

from __future__ import annotations

import math

import numpy as np

from undertow.recording.recording import Array
from undertow.recording.spikes import MAD_TO_SIGMA

_ORDERS = range(2, 9)  # differences of these orders: each removes the motion better than the one before


def quantum(values: Array) -> float:
    """Finest step of a channel in its unit; 0 where values lie on no grid that can be seen.

    >>> round(quantum(np.round(np.sin(np.linspace(0.0, 9.0, 500)) / 0.01) * 0.01), 6)
    0.01
    """
    levels = np.unique(values)
    steps = np.diff(levels)
    steps = steps[steps > 1e-9 * max(float(np.ptp(values)), 1e-300)]
    if steps.size < 2:
        return float(steps[0]) if steps.size else 0.0
    finest = float(np.median(steps[steps < 1.5 * np.min(steps)]))
    near = steps[steps < 5.5 * finest] / finest
    # printing rounds a grid to decimals, which moves steps of a few quanta by at most a fifth of one
    on_grid = float(np.mean(np.abs(near - np.round(near)) < 0.2))
    if on_grid > 0.95 and levels.size < 0.9 * values.size:
        return finest
    return float(np.median(steps)) if levels.size < values.size / 20 else 0.0  # an uneven grid, visited often


def noise(values: Array) -> float:
    """Standard deviation of what is no motion (n,), rounding included, in the values' unit.

    White noise of variance s^2 has a d-th difference of variance C(2d, d) s^2, while a smooth motion's shrinks with
    every order: the smallest estimate among orders 2 to 8 is taken, by the median of absolute differences, so that
    spikes and the release do not count. A channel rounded to steps q has at least q / sqrt(12).

    >>> rng = np.random.default_rng(1); t = np.arange(4000) / 250
    >>> round(noise(0.1 * np.cos(6 * t) + rng.normal(0, 1e-3, t.size)), 4)
    0.001
    """
    floor = quantum(values) / math.sqrt(12.0)
    sizes = []
    for order in _ORDERS:
        differences = np.diff(values, n=order)
        if differences.size:
            size = MAD_TO_SIGMA * float(np.median(np.abs(differences)))
            sizes.append(size / math.sqrt(math.comb(2 * order, order)))
    return max(min(sizes, default=0.0), floor)
