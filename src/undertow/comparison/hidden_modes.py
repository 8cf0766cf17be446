"""The modes of a short window by the singular values of its Hankel matrix, and those that an equation would have.

A body with a hidden oscillator has two coupled modes, a body alone has one. Over a few periods damping and friction
change little, so that the window is nearly a sum of damped waves; the Hankel matrix of its samples then has two
singular values a wave. Strong static nonlinearity raises singular values too: the count alone proves nothing. It gives
starts to the search, and backs its answer where the modes lie where the found oscillators put them.

Source: Kung 1978 and Roy and Kailath 1989 (ESPRIT), doi:10.1109/29.32276; threshold: Gavish and Donoho 2014,
doi:10.1109/TIT.2014.2323359.

Belongs here: modes of a window and of an equation. Does not belong here: the search (hidden_search.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.hidden_library import Oscillator
from undertow.conditioning.motion import Motion
from undertow.errors import IdentificationError
from undertow.methods.library import motion_period

Array = NDArray[np.float64]

WINDOW_PERIODS = 9.0
"""Periods of the window: waves a tenth apart turn against each other once within it."""

SAMPLES_PER_PERIOD = 20
SQUARE_THRESHOLD = 2.858
"""Gavish and Donoho's hard threshold for a square matrix of unknown noise, in medians of its singular values."""

MOST_ORDER = 8
"""Highest order looked at: the body, two oscillators, and a pair for what is not linear."""

MODE_RANGE = (0.2, 2.5)
"""Frequencies over the body's that are called modes; beyond are drift and harmonics."""

MODE_DAMPING = 0.3
"""Damping ratio up to which a pole is called a mode."""

SEED_DAMPING = (0.01, 0.15)
"""A short window's damping is a rough one: starts keep within the search's own grid."""

AGREEMENT = 0.05
"""Modes within this share of an expected one agree: the window's own resolution is some 10 %."""


@dataclass(frozen=True)
class Mode:
    """A damped wave: ``w`` in rad/s, damping ratio ``zeta``, ``amplitude`` at the window's start in m/s^2."""

    w: float
    zeta: float
    amplitude: float


@dataclass(frozen=True)
class HankelModes:
    """Modes of one window, the largest first; ``order`` singular values above noise; ``singular_values`` all of them,
    relative to the largest."""

    modes: tuple[Mode, ...]
    order: int
    singular_values: Array

    def agree_with(self, expected: Sequence[Oscillator]) -> bool:
        """Whether every expected (w, zeta) has a mode within `AGREEMENT` of its frequency."""
        return all(any(abs(mode.w / w - 1.0) < AGREEMENT for mode in self.modes) for w, _ in expected)


def hankel_modes(motion: Motion, periods: float = WINDOW_PERIODS) -> HankelModes:
    """Modes of the acceleration (less its mean) over the window's first ``periods``.

    The window is cut short where the motion is. IdentificationError where less than three periods are there.
    """
    period = motion_period(motion)
    t, a = motion.windowed("t"), motion.windowed("a")
    length = min(periods * period, float(t[-1] - t[0]))
    if length < 3.0 * period:
        raise IdentificationError(
            f"trial {motion.name}: {length / period:.2g} periods in the window; modes need 3: widen trials.window"
        )
    step = period / SAMPLES_PER_PERIOD
    edges = t[0] + step * np.arange(int(length / step) + 1)
    place = np.searchsorted(t, edges)
    if np.any(np.diff(place) < 1):
        samples = np.interp(edges[:-1] + 0.5 * step, t, a)
    else:
        samples = np.add.reduceat(a, place[:-1])[: place.size - 1] / np.diff(np.append(place[:-1], place[-1]))
    return _esprit(samples - samples.mean(), step, 2.0 * math.pi / period)


def _esprit(samples: Array, step: float, body: float) -> HankelModes:
    """Poles of evenly spaced samples: rotational invariance of the signal subspace."""
    half = samples.size // 2
    hankel = np.lib.stride_tricks.sliding_window_view(samples, samples.size - half).T
    left, values, _ = np.linalg.svd(hankel, full_matrices=False)
    order = int(np.count_nonzero(values > SQUARE_THRESHOLD * np.median(values)))
    used = min(max(order + order % 2, 2), MOST_ORDER)
    basis = left[:, :used]
    poles = np.linalg.eigvals(np.linalg.lstsq(basis[:-1], basis[1:], rcond=None)[0])
    rates = np.log(poles[np.abs(poles) > 0.0].astype(complex)) / step
    waves = np.exp(np.outer(np.arange(samples.size) * step, rates))
    largest = np.max(np.abs(waves), axis=0)
    amplitudes = np.linalg.lstsq(waves / largest, samples.astype(complex), rcond=None)[0] / largest
    modes = [
        Mode(float(abs(rate)), float(-rate.real / abs(rate)), float(2.0 * abs(size)))
        for rate, size in zip(rates, amplitudes, strict=True)
        if rate.imag > 0.0 and MODE_RANGE[0] < abs(rate) / body < MODE_RANGE[1] and _waves(rate)
    ]
    relative: Array = values / values[0]
    return HankelModes(tuple(sorted(modes, key=lambda mode: -mode.amplitude)), order, relative)


def _waves(rate: complex) -> bool:
    """Whether a pole is a wave that decays slowly: one that grows or dies at once makes up for what is not linear."""
    return -0.1 * MODE_DAMPING < -rate.real / abs(rate) < MODE_DAMPING


def coupled_modes(body_w: float, oscillators: Sequence[tuple[float, float, float]]) -> tuple[Oscillator, ...]:
    """Modes (w, zeta), rising, of a body (w^2 = k / M) with hidden oscillators (w, zeta, mass ratio).

    The eigenvalues of (1 + sum r) x'' + sum r s'' + w_0^2 x = 0, s'' + 2 zeta w s' + w^2 s = -x''.
    IdentificationError for a body's frequency that is none.

    >>> [round(w, 3) for w, _ in coupled_modes(11.0, [(9.0, 0.0, 0.1)])]
    [8.361, 11.84]
    >>> round(8.361 * 11.84 / 9.0, 2)  # the product of the two is w_0 w
    11.0
    """
    if not body_w > 0.0:
        raise IdentificationError(f"the body's frequency is {body_w:g} rad/s; it must be above 0")
    size = 1 + len(oscillators)
    mass, damping, stiffness = np.eye(size), np.zeros((size, size)), np.zeros((size, size))
    mass[0, 0] += sum(ratio for _, _, ratio in oscillators)
    stiffness[0, 0] = body_w**2
    for i, (w, zeta, ratio) in enumerate(oscillators, start=1):
        mass[0, i], mass[i, 0] = ratio, 1.0
        damping[i, i], stiffness[i, i] = 2.0 * zeta * w, w * w
    inverse = np.linalg.inv(mass)
    system = np.block([[np.zeros((size, size)), np.eye(size)], [-inverse @ stiffness, -inverse @ damping]])
    rates = [rate for rate in np.linalg.eigvals(system) if rate.imag > 0.0]
    return tuple(sorted((float(abs(rate)), float(-rate.real / abs(rate))) for rate in rates))


def seeds_from_modes(modes: HankelModes) -> tuple[Oscillator, ...]:
    """Starts for hidden oscillators: every mode but the largest, which is the body's; (w in rad/s, zeta) each."""
    return tuple((mode.w, float(np.clip(mode.zeta, *SEED_DAMPING))) for mode in modes.modes[1:])
