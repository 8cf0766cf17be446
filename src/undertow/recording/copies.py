"""Recordings that are one and the same under several names: copied, exported again in other digits, turned round,
scaled, thinned out, or resampled.

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
from undertow.recording.resampled import resampled

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

NOISE_SEEN = 1e-6
"""Noise under this share of the range is what a number format rounds of a simulation: one of a linear body is another
times a factor. Of such recordings only those that are equal are the same."""

THINNED = 20
"""Recordings that keep at most every so many-th sample are compared with those that keep all."""

FITS = 0.1
"""Correlation of differences under which nothing is compared further: half a recording's noise makes it 0.3 and more,
that of two recordings hardly any."""

BANDS = 16
"""Bands of frequency in most of which a scaled or thinned copy has the same noise: hum and ringing, which repetitions
share, fill few of them."""


@dataclass(frozen=True)
class Copy:
    """What a recording is a copy of: the ``original``'s index, and ``how`` in words, with {} for its name."""

    original: int
    how: str


SAME_RECORDING = "the same recording as {}, sample by sample"
RESAMPLED = "the recording {} resampled: their noise is the same"


@dataclass(frozen=True)
class _Seen:
    """What is compared of a recording: its channel, samples (n,), the range of all, noise, step in s, the spectrum of
    differences, the root of their sum of squares, and the time of its first sample, s."""

    channel: tuple[str, str]
    values: Array
    size: float
    noise: float
    step_s: float
    spectrum: np.ndarray
    strength: float
    start_s: float


def copies(recordings: Sequence[Recording]) -> dict[int, Copy]:
    """Which recordings are the same as an earlier one, and how, by index.

    Every channel is equal, or the first of displacement, velocity and acceleration has the same noise sample by sample,
    wherever it was cut and however it was rounded, up to 1.5 times the noise; an offset does not count. So it is of one
    that was turned round or scaled, and of one that keeps every second, third, ... sample; one at another rate has the
    same noise in its band (resampled.py). Repetitions of a release have each their own, however alike they are.

    >>> rng = np.random.default_rng(1); t = np.arange(2000) / 200
    >>> x = np.exp(-0.3 * t) * np.cos(6 * t) + rng.normal(0, 1e-3, t.size)
    >>> again = Recording("again", t[15:] - t[15], {"displacement": np.round(x[15:], 3)})
    >>> other = Recording("other", t, {"displacement": x + rng.normal(0, 1e-3, t.size)})
    >>> turned = Recording("turned", t, {"displacement": -x})
    >>> found = copies([Recording("first", t, {"displacement": x}), other, again, turned])
    >>> {at: one.how.format("first") for at, one in found.items()}
    {2: 'the same recording as first, sample by sample', 3: 'the recording first times -1'}
    """
    longest = max((min(one.time.size, SEEN) for one in recordings), default=0)
    length = next_fast_len(2 * longest, real=True)
    first: dict[bytes, int] = {}
    before: deque[tuple[int, _Seen]] = deque(maxlen=LOOKED_BACK)
    found: dict[int, Copy] = {}
    for at, recording in enumerate(recordings):
        original, how = first.setdefault(_digest(recording), at), SAME_RECORDING
        seen = _seen(recording, length) if original == at else None
        if seen is not None:
            compared = ((index, _how(seen, other, length)) for index, other in before)
            original, how = next(((index, said) for index, said in compared if said), (at, ""))
            before.append((at, seen))
        if original != at:
            found[at] = Copy(original, how)
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
    differences = np.diff(seen, n=ORDER)
    return _Seen(
        (name, recording.unit(name)), seen, float(np.ptp(values)), level, 1.0 / recording.rate_hz,
        rfft(differences, length), float(np.linalg.norm(differences)), float(recording.time[0]),
    )  # fmt: skip


def _how(one: _Seen, other: _Seen, length: int) -> str:
    """How a recording is the same as another, with {} for the other's name; empty where it is not."""
    if one.channel != other.channel:
        return ""
    steps = one.step_s / other.step_s
    if abs(one.step_s - other.step_s) <= STEP_OFF * one.step_s:
        return _as_often(one, other, length)
    thin, full = (one, other) if steps > 1.0 else (other, one)
    if not _tells(one) or not _tells(other):
        return ""
    every = round(max(steps, 1.0 / steps))
    whole = every <= THINNED and abs(thin.step_s - every * full.step_s) <= STEP_OFF * thin.step_s
    factor = _thinned(thin, full, every) if whole else None
    if factor is None:
        return RESAMPLED if _made_again(thin, full) else ""
    which = f"every {every}{_ORDINAL.get(every, 'th')} sample of"
    times = f",{_times(factor)}" if _times(factor) else ""
    return f"{which} {{}}{times}" if thin is one else f"the recording that {{}} is {which}{times}"


_ORDINAL = {2: "nd", 3: "rd"}


def _times(factor: float) -> str:
    said = f"{factor:.4g}"
    return "" if said == "1" else f" times {said}"


def _as_often(one: _Seen, other: _Seen, length: int) -> str:
    """The same of two recordings with one sampling step, where they, or one and the other turned round, fit best."""
    fit = irfft(one.spectrum * np.conj(other.spectrum), length)
    for at, lag in enumerate((int(np.argmax(fit)), int(np.argmin(fit)))):
        lag = lag - length if lag > length // 2 else lag
        a, b = one.values[max(lag, 0) :], other.values[max(-lag, 0) :]
        common = min(a.size, b.size)
        a, b = a[:common], b[:common]
        if common <= OVERLAP * min(one.values.size, other.values.size):
            continue
        if at == 0 and _equal(a, b, one, other):
            return SAME_RECORDING
        if abs(fit[lag]) < FITS * one.strength * other.strength:
            continue
        if not _tells(one) or not _tells(other):
            return ""
        factor = _scaled(a, b, one, other)
        if factor is not None:
            return f"the recording {{}}{_times(factor)}" if _times(factor) else SAME_RECORDING
    return ""


def _tells(one: _Seen) -> bool:
    """Whether what is seen as noise is a sensor's, not a number format's."""
    return one.noise > NOISE_SEEN * one.size


def _equal(a: Array, b: Array, one: _Seen, other: _Seen) -> bool:
    """Whether aligned samples are the same but for rounding and an offset."""
    if min(np.ptp(a), np.ptp(b)) <= OVERLAP * max(one.size, other.size):
        return False
    return float(np.std(a - b)) < SAME * max(one.noise, other.noise)


def _scaled(a: Array, b: Array, one: _Seen, other: _Seen) -> float | None:
    """The factor by which aligned samples of one are those of the other, noise and all; None where they are not."""
    if np.ptp(a) <= OVERLAP * one.size or np.ptp(b) <= OVERLAP * other.size:
        return None
    away = b - np.mean(b)
    factor = float(np.dot(a, away) / np.dot(away, away))
    left = a - factor * b
    if float(np.std(left)) >= SAME * min(one.noise, abs(factor) * other.noise):
        return None
    own, rest = (np.abs(rfft(np.diff(values, n=ORDER))) ** 2 for values in (a, left))
    shares = [np.sum(r) / max(np.sum(o), 1e-300) for r, o in zip(*(np.array_split(x, BANDS) for x in (rest, own)),
                                                                strict=True)]  # fmt: skip
    return factor if float(np.median(shares)) < SAME**2 else None


def _thinned(thin: _Seen, full: _Seen, every: int) -> float | None:
    """The factor by which a recording is every so many-th sample of another, from its first samples on or by both
    clocks; None where it is not."""
    late = round((thin.start_s - full.start_s) / full.step_s)
    for skipped in dict.fromkeys((*range(every), late)):
        before = max(-(skipped // every), 0)  # samples of the thin one before the other begins
        a, b = thin.values[before:], full.values[skipped + before * every :: every]
        common = min(a.size, b.size)
        if common > max(OVERLAP * min(thin.values.size, full.values.size / every), 2 * ORDER):
            factor = _scaled(a[:common], b[:common], thin, full)
            if factor is not None:
                return factor
    return None


def _made_again(slow: _Seen, fast: _Seen) -> bool:
    """Whether a recording is another between its samples or at a lower rate, from its first samples on or by both
    clocks."""
    for late in dict.fromkeys((0.0, slow.start_s - fast.start_s)):
        instants = late + slow.step_s * np.arange(slow.values.size)
        inside = (instants >= 0.0) & (instants <= fast.step_s * (fast.values.size - 1))
        if np.count_nonzero(inside) <= 2 * ORDER:
            continue
        lines = np.interp(instants[inside], fast.step_s * np.arange(fast.values.size), fast.values)
        if _scaled(slow.values[inside], lines, slow, fast) is not None:
            return True
        if resampled(slow.values, slow.step_s, fast.values, fast.step_s, late):
            return True
    return False
