"""Single wrong samples: found, counted, replaced.

Belongs here: spikes of a few samples (a motion sensor's lost echo). Does not belong here: noise (noise.py).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from undertow.errors import RecordingError
from undertow.recording.recording import Array

Mask = NDArray[np.bool_]

MOST_SPIKES = 0.05
"""Largest share of samples that may be replaced: from 15 % on spikes hide in the scatter they are judged by."""

SPIKE_SIGMAS = 8.0
"""A sample is a spike where it is this many standard deviations off; white noise does that once in 10^15 samples."""

SPIKE_QUANTA = 4.0
"""... and at least this many of the channel's finest steps off: rounding alone moves the test by 2.6 steps."""

MAD_TO_SIGMA = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation, 1 / 0.6745."""


def find_spikes(values: Array, width: int = 7) -> Mask:
    """Mask (n,) of samples that stand alone: shorter than half of ``width`` samples, odd, at least 5.

    A spike must differ from the running median over ``width`` *and* from the cubic through the two samples on either
    side that lie beyond half the width. The median alone would flag every sharp peak, the cubic alone every release:
    a snap bends the cubic but is monotone, so that the median follows it. The first and last samples are never flagged.

    >>> x = np.sin(np.linspace(0.0, 20.0, 400)); x[100] += 0.5
    >>> np.flatnonzero(find_spikes(x)).tolist()
    [100]
    """
    if width < 5 or width % 2 == 0:
        raise RecordingError(f"a despiking width of {width} samples is not usable; give an odd number from 5 on")
    near, far = width // 2, width // 2 + 1
    mask = np.zeros(values.size, dtype=bool)
    if values.size < 2 * far + 1:
        return mask
    inner = slice(far, values.size - far)
    pair_near = values[far - near : values.size - far - near] + values[far + near : values.size - far + near]
    pair_far = values[: values.size - 2 * far] + values[2 * far :]
    # even cubic through (+-near, +-far), evaluated in the middle: exact for polynomials up to third degree
    cubic = 0.5 * (far**2 * pair_near - near**2 * pair_far) / (far**2 - near**2)
    off_cubic = values[inner] - cubic
    sigma = MAD_TO_SIGMA * float(np.median(np.abs(off_cubic - np.median(off_cubic))))
    steps = np.abs(np.diff(values))
    finest = float(np.min(steps[steps > 0.0], initial=np.inf))
    scale = float(np.ptp(values))
    threshold = max(SPIKE_SIGMAS * sigma, SPIKE_QUANTA * min(finest, 1e-3 * scale), 1e-9 * scale)
    off = np.flatnonzero(np.abs(off_cubic) > threshold) + far
    medians = np.median(values[off[:, None] + np.arange(-near, near + 1)], axis=1)
    mask[off] = np.abs(values[off] - medians) > threshold
    return mask & (np.abs(values - _bridged(values, mask)) > threshold)  # acquits neighbours that a spike has bent


def despike(values: Array, width: int) -> tuple[Array, int]:
    """Values (n,) with spikes replaced by a cubic spline through the samples that are none, and how many were replaced.

    Raises RecordingError where more samples than `MOST_SPIKES` are spikes: then they are the signal.
    """
    mask = find_spikes(values, width)
    count = int(np.count_nonzero(mask))
    if count == 0:
        return np.array(values), 0
    if count > MOST_SPIKES * values.size:
        raise RecordingError(
            f"{count} of {values.size} samples are spikes by a running median of {width}; "
            "that is the signal itself: despike with a narrower median or not at all"
        )
    return _bridged(values, mask), count


def _bridged(values: Array, mask: Mask) -> Array:
    """Values with the masked ones on a cubic spline through the others."""
    index = np.arange(values.size, dtype=np.float64)
    bridged = np.array(values)
    if mask.any() and np.count_nonzero(~mask) >= 2:
        from scipy.interpolate import CubicSpline

        bridged[mask] = CubicSpline(index[~mask], values[~mask])(index[mask])
    return bridged
