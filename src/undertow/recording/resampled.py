"""Whether one recording was made from another at another rate or between its samples: resampled, averaged, filtered.

What was made so has other samples, but up to a half of the slower one's band it has the same noise, by a factor and a
delay at each frequency. So the phase between the two is the same in every stretch, and of two recordings it is not.

Belongs here: that comparison. Does not belong here: copies sample by sample (copies.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from undertow.recording.noise import noise
from undertow.recording.recording import Array

ORDER = 4
"""Differences of this order are compared: what is left of a motion is less than the noise."""

STRETCH = 64
"""Samples of the slower recording in a stretch."""

MOST, FEWEST = 64, 16
"""Stretches that are compared, the last ones first: there the motion has died; and of how many the phase counts."""

BAND = (0.1, 0.6)
"""Shares of half the slower rate between which noise is compared: what is above may be filtered or folded back."""

LOUD = 10.0
"""Of a stretch with so many times the power of noise at a frequency, or of what others have there, nothing is compared:
kinks of friction, a release and ringing are the same in repetitions."""

FORETOLD = 24
"""Samples before each that foretell hum: eleven lines, with a sample to spare for each end."""

COHERENT = 0.5
"""Squared mean of unit phases over stretches from which on two recordings are one: of two it is the inverse of their
number, 0.06 for the fewest and beyond 0.5 once in 3,000; and that in the middle of 16 frequencies."""


def resampled(slow: Array, slow_step_s: float, fast: Array, fast_step_s: float, late_s: float) -> bool:
    """Whether ``slow`` (n,) and ``fast`` (m,), in one unit or not, are one recording; ``late_s`` is by how much the
    first sample of ``slow`` is later than that of ``fast``, to within half of its step ``slow_step_s``.

    >>> rng = np.random.default_rng(1)
    >>> x = np.exp(-np.arange(8000) / 3000) * np.cos(np.arange(8000) / 40) + 1e-3 * rng.normal(size=8000)
    >>> thinner = x.reshape(-1, 4).mean(axis=1)
    >>> resampled(thinner, 4e-3, x, 1e-3, 1.5e-3), resampled(thinner, 4e-3, x + 1e-3 * rng.normal(size=8000), 1e-3, 0.0)
    (True, False)
    """
    instants = late_s + slow_step_s * np.arange(slow.size)
    inside = (instants >= 0.5 * slow_step_s) & (instants <= fast_step_s * (fast.size - 1) - 0.5 * slow_step_s)
    stretches = min(int(np.count_nonzero(inside)) // STRETCH, MOST)
    if stretches < FEWEST:
        return False
    used = np.flatnonzero(inside)[-stretches * STRETCH :]
    pair = (slow[used], _means(fast, fast_step_s, np.asarray(instants[used]), slow_step_s))
    plain = [np.diff(values, n=ORDER, append=values[-1:].repeat(ORDER)) for values in pair]
    if not _coherent(plain, None, stretches):  # the quick look: most pairs end here
        return False
    levels = [noise(values) for values in pair]
    return _coherent(plain, levels, stretches) and _coherent([_unforeseen(one) for one in plain], None, stretches)


def _coherent(pair: Sequence[Array], levels: Sequence[float] | None, stretches: int) -> bool:
    """Whether the noise of two series has one phase against each other in most stretches, at most frequencies;
    ``levels`` is that of the recordings whose differences they are (None: not asked)."""
    said = [math.nan, math.nan] if levels is None else levels
    own, other = (_noise_spectra(values, level, stretches) for values, level in zip(pair, said, strict=True))
    both = np.isfinite(own) & np.isfinite(other)
    enough = np.count_nonzero(both, axis=0) >= max(FEWEST, stretches // 2)
    if 2 * np.count_nonzero(enough) <= enough.size:
        return False
    phases = np.where(both, own * np.conj(other), 0.0)[:, enough]
    phases /= np.maximum(np.abs(phases), 1e-300)
    mean = np.sum(phases, axis=0) / np.count_nonzero(both[:, enough], axis=0)
    return float(np.median(np.abs(mean) ** 2)) > COHERENT


def _unforeseen(values: Array) -> Array:
    """What the samples before do not foretell of a series (n,): noise without hum and ringing that never ends."""
    rows = np.lib.stride_tricks.sliding_window_view(values, FORETOLD + 1)
    left = rows[:, -1] - rows[:, :-1] @ np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=None)[0]
    return np.concatenate([np.zeros(FORETOLD), left])


def _means(values: Array, step_s: float, instants: Array, width_s: float) -> Array:
    """Means of a recording over a width about each instant (n,) s, straight lines between its samples."""
    way = np.r_[0.0, np.cumsum(0.5 * (values[1:] + values[:-1]))] * step_s
    time = step_s * np.arange(values.size)
    upper, lower = (np.interp(instants + side * 0.5 * width_s, time, way) for side in (1.0, -1.0))
    return np.asarray((upper - lower) / width_s)


def _noise_spectra(values: Array, level: float, stretches: int) -> np.ndarray:
    """Spectra of the noise by stretch and frequency, (stretches, frequencies); NaN where there is more than noise."""
    window = np.hanning(STRETCH)
    spectra = np.fft.rfft(values.reshape(stretches, STRETCH) * window, axis=1)
    power = np.abs(spectra) ** 2
    at = np.arange(spectra.shape[1]) / (spectra.shape[1] - 1)
    white = level**2 * float(np.sum(window**2)) * (2.0 * np.sin(0.5 * math.pi * at)) ** (2 * ORDER)
    spectra[power > LOUD * np.fmin(white, np.median(power, axis=0))] = np.nan
    return spectra[:, (at >= BAND[0]) & (at <= BAND[1])]
