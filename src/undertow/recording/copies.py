"""Recordings that are one and the same under several names: copied, or exported again in other digits.

Belongs here: how that is seen. Does not belong here: what follows (campaign/run/checking.py).
"""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from undertow.recording.noise import noise, quantum
from undertow.recording.recording import Array, Recording

SAME = 0.5
"""Aligned samples of one recording differ by what was rounded: by less than this share of the noise. Those of two
recordings differ by 1.4 times the noise at least."""

ROUNDED = 0.4
"""Noise under this share of the sensor's finest step is hidden by it (rounding alone is 0.29 of it): repetitions of one
release then look alike sample by sample, and only recordings that are equal throughout are the same."""

ORDER = 4
"""Two recordings are aligned by differences of this order: what is left of a motion is less than the noise."""

SEEN = 32_768
"""Samples of a recording that are compared, from its first one on: more cost seconds in a campaign of sixty."""

LOOKED_BACK = 64
"""Recordings before it that each one is compared with: copies are saved beside each other, and all pairs of a large
campaign would take hours."""

OVERLAP = 0.5
"""Share of the shorter recording, and of how far either moves, that they have in common at least: rests are alike."""

STEP_OFF = 1e-3
"""Relative difference of two sampling steps that printing makes."""


@dataclass(frozen=True)
class _Seen:
    """What is compared of a recording: its channel, samples (n,), the range of all, noise, step in s, and the spectrum
    of differences."""

    channel: tuple[str, str]
    values: Array
    size: float
    noise: float
    step_s: float
    spectrum: np.ndarray


def copies(recordings: Sequence[Recording]) -> dict[int, int]:
    """Which recordings are the same as an earlier one: index -> index of the first.

    Every channel is equal, or the first of displacement, velocity and acceleration has the same noise sample by sample,
    wherever it was cut and however it was rounded, up to 1.5 times the noise; an offset does not count.

    >>> rng = np.random.default_rng(1); t = np.arange(2000) / 200
    >>> x = np.exp(-0.3 * t) * np.cos(6 * t) + rng.normal(0, 1e-3, t.size)
    >>> again = Recording("again", t[15:] - t[15], {"displacement": np.round(x[15:], 3)})
    >>> other = Recording("other", t, {"displacement": x + rng.normal(0, 1e-3, t.size)})
    >>> copies([Recording("first", t, {"displacement": x}), other, again])
    {2: 0}
    """
    longest = max((min(one.time.size, SEEN) for one in recordings), default=0)
    length = next_fast_len(2 * longest, real=True)
    first: dict[bytes, int] = {}
    before: deque[tuple[int, _Seen]] = deque(maxlen=LOOKED_BACK)
    found: dict[int, int] = {}
    for at, recording in enumerate(recordings):
        original = first.setdefault(_digest(recording), at)
        seen = _seen(recording, length) if original == at else None
        if seen is not None:
            original = next((index for index, other in before if _same(seen, other, length)), at)
            before.append((at, seen))
        if original != at:
            found[at] = found.get(original, original)
    return found


def _digest(recording: Recording) -> bytes:
    mark = hashlib.sha256(recording.coordinate.encode() + recording.time.tobytes())
    for values in recording.channels.values():
        mark.update(values.tobytes())
    return mark.digest()


def _seen(recording: Recording, length: int) -> _Seen | None:
    """What is compared; None without a channel of the motion, or where noise cannot be seen in it."""
    name = next((one for one in ("displacement", "velocity", "acceleration") if one in recording.channels), None)
    if name is None or recording.time.size <= 2 * ORDER:
        return None
    values = recording.channels[name]
    seen, level = values[:SEEN], noise(values)
    if level <= ROUNDED * quantum(values):
        return None
    return _Seen(
        (name, recording.unit(name)), seen, float(np.ptp(values)), level, 1.0 / recording.rate_hz,
        rfft(np.diff(seen, n=ORDER), length),
    )  # fmt: skip


def _same(one: _Seen, other: _Seen, length: int) -> bool:
    """Whether samples are the same but for rounding where the two fit each other best."""
    if one.channel != other.channel or abs(one.step_s - other.step_s) > STEP_OFF * one.step_s:
        return False
    lag = int(np.argmax(irfft(one.spectrum * np.conj(other.spectrum), length)))
    lag = lag - length if lag > length // 2 else lag
    a, b = one.values[max(lag, 0) :], other.values[max(-lag, 0) :]
    common = min(a.size, b.size)
    a, b = a[:common], b[:common]
    if common <= OVERLAP * min(one.values.size, other.values.size):
        return False
    if min(np.ptp(a), np.ptp(b)) <= OVERLAP * max(one.size, other.size):
        return False
    return float(np.std(a - b)) < SAME * max(one.noise, other.noise)
