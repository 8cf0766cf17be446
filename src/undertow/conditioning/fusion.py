"""x, v, a with their errors from whatever was recorded: a Kalman filter and RTS smoother.

State (x, v, a, b, d): displacement, velocity, acceleration, accelerometer bias, and the accelerometer's clock ahead
of the other channels'. The acceleration is driven by white jerk whose density is found by the innovations' likelihood,
the bias by a slow random walk; d is constant. Measured are x, v and a(t + d) + b = a + b + d a', whichever were
recorded; samples need not be even. Moving the noisy samples themselves would smooth them, and the likelihood would
take that for a better clock: so d is a state.

Source: Rauch, Tung and Striebel 1965, doi:10.2514/3.3166; Smyth and Wu 2007, doi:10.1016/j.ymssp.2006.03.005.

Belongs here: the smoother, its noise level, and the clock of one channel against another.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from scipy.optimize import minimize_scalar

from undertow.compiling import OPTIONS, compiled
from undertow.errors import RecordingError
from undertow.recording.recording import Array

BIAS_WALK = 1e-3
"""Random walk of the accelerometer's bias: standard deviation gained in one second, relative to the channel's noise
times sqrt(rate); a bias moves by a fraction of the noise over a record."""

JERK_DECADES = 3.0
"""The jerk's density is searched this many decades either side of what the motion's own size suggests."""

LIKELIHOOD_SAMPLES = 1500
"""At most this many samples decide the jerk's density; more sharpen it to no use."""

CLOCK_RADIANS = 0.03
"""Prior standard deviation of one channel's clock against another's, and of the release instant, as an angle of the
motion, rad: 5 ms at one hertz. Filters of one logger, chosen for the motion, differ by so much. Every fit uses this
one (likelihood/priors.py)."""

ROUNDING = 1e-9
"""Least noise of a channel, relative to its range."""

HELD_STILL = 1e-9
"""Prior of what is no unknown (a bias, a clock that nothing shows), relative to the motion."""


@dataclass(frozen=True)
class Smoothed:
    """x, v, a and their standard errors (n,) in SI at the instants given, and by how much the
    accelerometer's samples are of a later instant than their time stamp says (s, with standard error; nan where not
    both clocks are there)."""

    x: Array
    v: Array
    a: Array
    x_std: Array
    v_std: Array
    a_std: Array
    clock_s: float = math.nan
    clock_stderr_s: float = math.nan


@njit(**OPTIONS)
def _product(f, p, out):  # type: ignore[no-untyped-def]
    """out = f p. Loops: numpy's products, solutions and assignments of arrays take a minute to compile between them."""
    for i in range(5):
        for j in range(5):
            total = 0.0
            for m in range(5):
                total += f[i, m] * p[m, j]
            out[i, j] = total


@njit(**OPTIONS)
def _moved(f, p, half, out):  # type: ignore[no-untyped-def]
    """out = f p f^T; ``half`` becomes f p."""
    _product(f, p, half)
    for i in range(5):
        for j in range(5):
            total = 0.0
            for m in range(5):
                total += half[i, m] * f[j, m]
            out[i, j] = total


@njit(**OPTIONS)
def _divided(half, p, low, out):  # type: ignore[no-untyped-def]
    """out = half^T p^-1 by Cholesky, p symmetric and positive definite; ``low`` becomes its factor."""
    for j in range(5):
        for i in range(j, 5):
            total = p[i, j]
            for m in range(j):
                total -= low[i, m] * low[j, m]
            low[i, j] = math.sqrt(total) if i == j else total / low[j, j]
    for row in range(5):
        for i in range(5):
            total = half[i, row]
            for m in range(i):
                total -= low[i, m] * out[row, m]
            out[row, i] = total / low[i, i]
        for i in range(4, -1, -1):
            total = out[row, i]
            for m in range(i + 1, 5):
                total -= low[m, i] * out[row, m]
            out[row, i] = total / low[i, i]


@njit(**OPTIONS)
def _measured(m, p, ph, z, r, jerk):  # type: ignore[no-untyped-def]
    """Mean ``m`` and covariance ``p`` after what was measured at an instant; its log-likelihood."""
    loglik = 0.0
    for c in range(3):
        if r[c] < 0.0:
            continue
        hx = m[c]
        for j in range(5):
            ph[j] = p[j, c]
        if c == 2:
            hx += m[3] + jerk * m[4]
            for j in range(5):
                ph[j] += p[j, 3] + jerk * p[j, 4]
        s = ph[c] + r[c]
        if c == 2:
            s += ph[3] + jerk * ph[4]
        e = z[c] - hx
        loglik -= 0.5 * (math.log(s) + e * e / s)
        for j in range(5):
            m[j] += ph[j] / s * e
            for k in range(j + 1):
                p[j, k] = p[k, j] = 0.5 * (p[j, k] - ph[j] / s * ph[k] + (p[k, j] - ph[k] / s * ph[j]))
    return loglik


@njit(**OPTIONS)
def _earlier(i, f, half, low, g, mf, pf, mp, pp):  # type: ignore[no-untyped-def]
    """Filtered means and covariances of instant i become smoothed ones, those of i + 1 being so; pp is used up."""
    _product(f, pf[i], half)
    _divided(half, pp[i + 1], low, g)
    for j in range(5):
        for k in range(5):
            mf[i, j] += g[j, k] * (mf[i + 1, k] - mp[i + 1, k])
            pp[i + 1, j, k] = pf[i + 1, j, k] - pp[i + 1, j, k]
    _moved(g, pp[i + 1], half, low)
    for j in range(5):
        for k in range(5):
            pf[i, j, k] += low[j, k]


@compiled("Tuple((f8[:,::1], f8[:,:,::1], f8))(f8[::1], f8[:,::1], f8[::1], f8[::1], f8[::1], f8[:,::1], f8, f8, b1)")
def _smooth(t, z, jerk, r, m0, p0, q, qb, backward):  # type: ignore[no-untyped-def]
    """Forward filter and, where wanted, backward smoother; z (n, 3) measured x, v, a with variance r (3,), r < 0: not
    measured; jerk (n,) is what d multiplies."""
    n = t.size
    mf, mp = np.empty((n, 5)), np.empty((n, 5))
    pf, pp = np.empty((n, 5, 5)), np.empty((n, 5, 5))
    f, half, low, g = np.zeros((5, 5)), np.empty((5, 5)), np.empty((5, 5)), np.empty((5, 5))
    ph = np.empty(5)
    for j in range(5):
        f[j, j] = 1.0
    loglik = 0.0
    for i in range(n):
        m, p = mf[i], pf[i]
        d = t[i] - t[i - 1] if i > 0 else 0.0
        f[0, 1] = f[1, 2] = d
        f[0, 2] = 0.5 * d * d
        before, spread = (mf[i - 1], pf[i - 1]) if i > 0 else (m0, p0)
        _moved(f, spread, half, p)
        if i > 0:
            p[0, 0] += q * d**5 / 20.0
            p[0, 1] += q * d**4 / 8.0
            p[1, 0] += q * d**4 / 8.0
            p[0, 2] += q * d**3 / 6.0
            p[2, 0] += q * d**3 / 6.0
            p[1, 1] += q * d**3 / 3.0
            p[1, 2] += q * d * d / 2.0
            p[2, 1] += q * d * d / 2.0
            p[2, 2] += q * d
            p[3, 3] += qb * d
        m[0] = before[0] + d * before[1] + 0.5 * d * d * before[2]
        m[1] = before[1] + d * before[2]
        m[2], m[3], m[4] = before[2], before[3], before[4]
        for j in range(5):
            mp[i, j] = m[j]
            for k in range(5):
                pp[i, j, k] = p[j, k]
        loglik += _measured(m, p, ph, z[i], r, jerk[i])
    if backward:
        for i in range(n - 2, -1, -1):
            d = t[i + 1] - t[i]
            f[0, 1] = f[1, 2] = d
            f[0, 2] = 0.5 * d * d
            _earlier(i, f, half, low, g, mf, pf, mp, pp)
    return mf, pf, loglik


@dataclass(frozen=True)
class _Setting:
    """What is smoothed: instants, measured values (n, 3), jerk (n,), variances (3,), prior mean and covariance."""

    t: Array
    z: Array
    jerk: Array
    r: Array
    mean: Array
    covariance: Array
    bias_density: float

    def at(self, jerk_density: float) -> tuple[Array, Array]:
        """Smoothed means (n, 5) and covariances (n, 5, 5) at a jerk density."""
        return self._run(jerk_density, self.t.size, True)[:2]

    def log_likelihood(self, jerk_density: float) -> float:
        """Log-likelihood of the first samples at a jerk density."""
        return self._run(jerk_density, min(LIKELIHOOD_SAMPLES, self.t.size), False)[2]

    def _run(self, q: float, n: int, backward: bool) -> tuple[Array, Array, float]:
        means, covariances, loglik = _smooth(
            self.t[:n], self.z[:n], self.jerk[:n], self.r, self.mean, self.covariance, q, self.bias_density, backward
        )
        return means, covariances, float(loglik)


def fuse(
    t: Array, channels: Mapping[str, Array], noise: Mapping[str, float], bias: tuple[float, float] = (0.0, 0.0)
) -> Smoothed:
    """Smoothed motion at ``t`` (n,) s from ``channels``: displacement or velocity, and acceleration.

    ``noise`` is each channel's standard deviation; ``bias`` mean and standard deviation of the accelerometer's bias,
    as the hold shows it. With a velocity alone x is relative to its own mean.

    Raises RecordingError where no channel of motion is given, or an acceleration alone.
    """
    setting = _setting(t, channels, noise, bias)
    scale = _jerk_scale(t, channels)
    density = _best_density(setting, scale)
    if "acceleration" in channels and ("displacement" in channels or "velocity" in channels):
        first = setting.at(density)[0]
        setting = replace(setting, jerk=_oscillator_jerk(first))
        setting.covariance[4, 4] = (CLOCK_RADIANS / _angular_rate(t, channels)) ** 2
        density = _best_density(setting, scale)
    means, covariances = setting.at(density)
    errors = np.sqrt(np.maximum(np.einsum("nii->ni", covariances), 0.0))
    x, v, a = (np.ascontiguousarray(means[:, i]) for i in range(3))
    if "displacement" not in channels:
        x = x - float(np.mean(x))
    clock = (float(means[-1, 4]), float(errors[-1, 4])) if np.any(setting.jerk) else (math.nan, math.nan)
    return Smoothed(x, v, a, errors[:, 0], errors[:, 1], errors[:, 2], *clock)


def _best_density(setting: _Setting, scale: float) -> float:
    best = minimize_scalar(
        lambda e: -setting.log_likelihood(scale * 10.0**e),
        bounds=(-JERK_DECADES, JERK_DECADES), method="bounded", options={"xatol": 0.1},
    )  # fmt: skip
    return float(scale * 10.0 ** float(best.x))


def _oscillator_jerk(means: Array) -> Array:
    """a' (n,) of an oscillation with these v and a: -(mean a^2 / mean v^2) v, free of the noise of a derivative."""
    v, a = means[:, 1], means[:, 2]
    return -float(np.mean(a**2) / np.mean(v**2)) * v


def _setting(
    t: Array, channels: Mapping[str, Array], noise: Mapping[str, float], bias: tuple[float, float]
) -> _Setting:
    names = ("displacement", "velocity", "acceleration")
    have = ", ".join(channels) or "nothing"
    if "acceleration" in channels and "displacement" not in channels and "velocity" not in channels:
        raise RecordingError(
            f"channels recorded are {have}; an acceleration integrated twice drifts away from any displacement: map "
            "displacement or velocity beside it"
        )
    if not any(name in channels for name in names):
        raise RecordingError(
            f"channels recorded are {have}; motion needs displacement, velocity or acceleration: map one"
        )
    if t.size < 10:
        raise RecordingError(f"{t.size} samples after the release; smoothing needs 10: look at the window")
    z = np.zeros((t.size, 3))
    r = np.full(3, -1.0)
    mean = np.zeros(5)
    spread = np.zeros(5)
    for i, name in enumerate(names):
        if name in channels:
            z[:, i] = channels[name]
            r[i] = max(noise[name], ROUNDING * float(np.ptp(channels[name]))) ** 2
    first = z[:5].mean(axis=0)
    size = _sizes(t, channels)
    spread[3:] = HELD_STILL * size[2], HELD_STILL / _angular_rate(t, channels)
    for i in range(3):
        measured = r[i] >= 0.0
        mean[i] = first[i] - (bias[0] if i == 2 else 0.0) if measured else 0.0
        spread[i] = size[i] if size[i] > 0.0 else 1.0
    if "acceleration" in channels:
        mean[3], spread[3] = bias[0], bias[1] if bias[1] > 0.0 else size[2]
    sigma_a = noise.get("acceleration", 0.0)
    walk = (BIAS_WALK * sigma_a) ** 2 / float(np.median(np.diff(t)))
    return _Setting(np.array(t, dtype=np.float64), z, np.zeros(t.size), r, mean, np.diag(spread**2), walk)


def _sizes(t: Array, channels: Mapping[str, Array]) -> tuple[float, float, float]:
    """Largest displacement, velocity, acceleration that the record suggests: for a prior that is wide enough."""
    rate = _angular_rate(t, channels)
    for power, name in enumerate(("displacement", "velocity", "acceleration")):
        if name in channels:
            size = float(np.ptp(channels[name]))
            x = size / rate**power
            return x, x * rate, x * rate**2
    return 1.0, 1.0, 1.0


def _angular_rate(t: Array, channels: Mapping[str, Array]) -> float:
    """Angular frequency at which the record crosses its own middle, rad/s; noise damped by a short mean."""
    values = next(channels[n] for n in ("displacement", "velocity", "acceleration") if n in channels)
    low, high = np.quantile(values, [0.05, 0.95])
    middle, margin = 0.5 * (low + high), 0.2 * (high - low)
    side = np.where(values > middle + margin, 1, np.where(values < middle - margin, -1, 0))
    side = side[side != 0]
    crossings = max(int(np.count_nonzero(np.diff(side))), 1)
    return math.pi * crossings / float(t[-1] - t[0])


def _jerk_scale(t: Array, channels: Mapping[str, Array]) -> float:
    """Jerk density a steady oscillation of the record's size would need: (w a)^2 / w."""
    rate = _angular_rate(t, channels)
    return (_sizes(t, channels)[2] * rate) ** 2 / rate
