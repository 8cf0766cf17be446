"""Channels with clocks of their own, brought to the instants of the displacement.

An evenly sampled channel is interpolated as if band-limited (a sinc over 32 samples under a Kaiser window, exact to
`BAND_LIMITED_ERROR` for motions below `BAND_SHARE` of its rate): that leaves its noise white and of the same size. A
channel with uneven steps is interpolated linearly where the error of that is below its noise. A channel that is slower
than the displacement is left out: values between its samples would count as measured.

Belongs here: instants and interpolation. Does not belong here: missing values (gaps.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from undertow.recording.noise import noise
from undertow.recording.quality import GAP_STEPS
from undertow.recording.recording import LEFT_OUT, Array

HALF_WIDTH = 16
"""Samples either side of an instant that it is interpolated from: wider gains nothing below `BAND_SHARE`."""

KAISER_SHAPE = 8.0
"""Shape of the window: its own side lobes are 1e-4 of the main one (Kaiser 1974)."""

BAND_SHARE = 0.4
"""Motions below this share of a channel's rate are interpolated to `BAND_LIMITED_ERROR` of their amplitude."""

BAND_LIMITED_ERROR = 2e-4
"""Largest error of an interpolated sine below `BAND_SHARE`, as a part of its amplitude (measured in the tests)."""

SAME_INSTANTS = 1e-3
"""Instants that agree within this part of a step are the same: a motion of ten samples a period moves by 0.06 % of its
amplitude in that."""

EVEN_WITHIN = 0.02
"""Time stamps within this part of a step of an even clock belong to one, besides those that rounding moved."""

AS_FAST = 0.99
"""A channel with this part of the displacement's rate is as fast: clocks differ by parts in 10^4."""

_CHUNK = 1 << 15  # instants interpolated at once


@dataclass(frozen=True)
class Placed:
    """A channel at other instants, NaN where it has none; ``note`` says how. None: it was left out."""

    samples: Array | None
    note: str


def placed(name: str, time: Array, values: Array, at: Array, of: str) -> Placed:
    """The channel ``name`` with its samples (n,) at ``time`` (n,) s, at the instants ``at`` (m,) s of the channel
    ``of``; missing samples are NaN and stay so.
    """
    known = np.isfinite(values) & np.isfinite(time)
    time, values = time[known], values[known]
    if time.size < 2 or not np.all(np.diff(time) > 0.0):
        why = "has no values" if time.size < 2 else "has a time that does not increase"
        return Placed(None, f"{name} {why}: {LEFT_OUT}")
    step, usual = float(np.median(np.diff(time))), float(np.median(np.diff(at)))
    nearest = np.clip(np.searchsorted(time, at - 0.5 * step), 0, time.size - 1)
    if np.all(np.abs(time[nearest] - at) <= SAME_INSTANTS * step):
        return Placed(values[nearest], "")
    if usual < AS_FAST * step:
        return Placed(None, (
            f"{name} was recorded at {1.0 / step:.5g} Hz and {of} at {1.0 / usual:.5g} Hz: {LEFT_OUT}, "
            f"because values between its samples would count as measured; thin out {of} if it is needed"
        ))  # fmt: skip
    out = np.full(at.size, np.nan)
    ends = np.flatnonzero(np.diff(time) > GAP_STEPS * step)
    linear = 0.0
    for start, end in zip([0, *(ends + 1)], [*(ends + 1), time.size], strict=True):
        here = np.flatnonzero((at >= time[start] - SAME_INSTANTS * step) & (at <= time[end - 1] + SAME_INSTANTS * step))
        if end - start < 2:
            continue
        even = _even(time[start:end])
        if even is None:
            linear = max(linear, _linear_error(values[start:end]))
            out[here] = np.interp(at[here], time[start:end], values[start:end])
        else:
            out[here] = band_limited(values[start:end], (at[here] - even[0]) / even[1])
    if linear > noise(values):
        return Placed(None, (
            f"{name} has uneven time steps, between which it may differ by {linear:.2g} from a straight line, more "
            f"than its noise of {noise(values):.2g} (SI): {LEFT_OUT}"
        ))  # fmt: skip
    how = (
        f"linearly, to {linear:.2g} (SI)" if linear
        else f"as band-limited, to {BAND_LIMITED_ERROR:g} of its motion below {BAND_SHARE:g} of its rate"
    )  # fmt: skip
    rates = f"{1.0 / step:.5g} Hz, interpolated at the instants of {of} ({1.0 / usual:.5g} Hz)"
    return Placed(out, f"{name}: {rates} {how}")


def band_limited(values: Array, places: Array) -> Array:
    """Values (n,) at places (m,) counted in samples from the first, by a windowed sinc whose weights sum to one.

    >>> n = np.arange(200.0)
    >>> float(np.max(np.abs(band_limited(np.sin(0.6 * n), n[40:160] + 0.3) - np.sin(0.6 * (n[40:160] + 0.3))))) < 2e-4
    True
    """
    out = np.empty(places.size)
    offsets = np.arange(1 - HALF_WIDTH, HALF_WIDTH + 1)
    for first in range(0, places.size, _CHUNK):
        part = slice(first, first + _CHUNK)
        base = np.floor(places[part]).astype(np.int64)
        index = base[:, None] + offsets
        away = places[part, None] - index
        inside = np.clip(1.0 - (away / HALF_WIDTH) ** 2, 0.0, None)
        weights = np.sinc(away) * np.i0(KAISER_SHAPE * np.sqrt(inside)) * (np.abs(away) <= HALF_WIDTH)
        weights *= (index >= 0) & (index < values.size)
        weights /= weights.sum(axis=1, keepdims=True)
        out[part] = np.einsum("ij,ij->i", weights, values[np.clip(index, 0, values.size - 1)])
    return out


def _even(time: Array) -> tuple[float, float] | None:
    """Start and step of the even clock that time stamps (n,) belong to but for rounding; None where there is none."""
    count = np.arange(time.size)
    step = float(time[-1] - time[0]) / (time.size - 1)
    off = time - time[0] - step * count
    shift = 0.5 * float(np.max(off) + np.min(off))
    if float(np.ptp(off)) <= 2.0 * max(EVEN_WITHIN * step, 0.51 * _decimal_step(time)):
        return float(time[0]) + shift, step
    return None


def _decimal_step(time: Array) -> float:
    """The power of ten that time stamps were rounded to, where it is shorter than their step; 0: none seen."""
    step = float(np.median(np.diff(time)))
    for decimals in range(10):
        rounded = 10.0**-decimals
        if rounded < step and np.all(np.abs(time / rounded - np.round(time / rounded)) < 1e-4):
            return rounded
    return 0.0


def _linear_error(values: Array) -> float:
    """How far a straight line between neighbours may be off: an eighth of the second differences that noise does not
    make (it makes the square root of six of its own size)."""
    bends = np.diff(values, n=2)
    if not bends.size:
        return 0.0
    size = float(np.sqrt(np.mean(bends**2)))
    return float(np.sqrt(max(size**2 - 6.0 * noise(values) ** 2, 0.0))) / 8.0
