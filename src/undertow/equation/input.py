"""A measured input between its samples: pieces of polynomials that the integrator follows exactly.

    zero          u(t) = u_i from sample i to i + 1 (what a digital-to-analogue converter gives)
    first         the straight line between samples
    band_limited  the one signal without anything above half the sampling rate that passes through the samples, as
                  quintics through its value, slope and curvature at knots `REFINED` times as dense as the samples

A straight line loses (w dt)^2 / 12 of a component at the angular frequency w: 13 % at five samples a period.

Of a base or of water that moves the integrator takes the acceleration; velocity and displacement are known beside it as
far as they were recorded.

Belongs here: holds, and the extent of the motion that decides steps.
Does not belong here: gain, delay (slots of the integrator), files.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from undertow.equation.term import Array
from undertow.errors import UndertowError
from undertow.quantities import Hold, Mover

HOLDS: tuple[Hold, ...] = ("zero", "first", "band_limited")

EVEN_SHARE = 0.01
"""Time steps of a band-limited input may differ by this share of a step; its samples are then taken as even."""

REFINED = 2
"""Knots a sample of a band-limited input: quintics between them are right to 1e-6 at five samples a period."""

KNOTS_A_PERIOD = 32
"""Knots a period of a harmonic input: quintics between them are right to 2e-9 of its amplitude."""

END_SAMPLES = 512
"""Samples by which a record is continued beyond its ends, mirrored through its end points, before its spectrum is
taken: what the continuation gets wrong fades with the distance from the end in samples."""


@dataclass(frozen=True)
class Drive:
    """An input as the integrator takes it: on piece i, between ``knots`` i and i + 1 (s), u = sum_p pieces[i, p] r^p
    with r from 0 to 1. ``broken``: u jumps at knots. Before the first and beyond the last knot the end pieces go on.

    ``mover``: u is a force, or the acceleration of a base or of the water; ``velocity`` and ``displacement`` are the
    pieces of its motion (None: not known),
    ``drifts`` the standard error in m/s of the constant that a velocity from an integral lacks; ``absolute`` names the
    outputs that are recorded against the earth, not against the base.
    """

    knots: Array
    pieces: Array
    broken: bool = False
    hold: Hold = "first"
    mover: Mover = "force"
    velocity: Array | None = None
    displacement: Array | None = None
    drifts: float = 0.0
    absolute: tuple[str, ...] = ()

    def at(self, times: Array) -> Array:
        """u (m,) at ``times`` (m,), s.

        >>> drive_of(np.arange(3.0), np.array([0.0, 2.0, 0.0])).at(np.array([0.5, 1.5]))
        array([1., 1.])
        """
        return self._value(self.pieces, times)

    def velocity_at(self, times: Array) -> Array:
        """Velocity (m,) of what moves at ``times`` (m,), s; UndertowError where the input is a force."""
        if self.velocity is None:
            raise UndertowError(
                f"input: a force at {np.size(times)} instants has no velocity; give motion of a base or of water"
            )
        return self._value(self.velocity, times)

    def displacement_at(self, times: Array) -> Array:
        """The base's displacement (m,) at ``times`` (m,), s; UndertowError where it was not recorded."""
        if self.displacement is None:
            raise UndertowError(
                f"input: where the base is at {np.size(times)} instants was not recorded; map base_displacement"
            )
        return self._value(self.displacement, times)

    def _value(self, pieces: Array, times: Array) -> Array:
        index = np.clip(np.searchsorted(self.knots, times, side="right") - 1, 0, pieces.shape[0] - 1)
        r = (np.asarray(times) - self.knots[index]) / (self.knots[index + 1] - self.knots[index])
        value = np.zeros(r.shape)
        for p in range(pieces.shape[1] - 1, -1, -1):
            value = value * r + pieces[index, p]
        return value


@dataclass(frozen=True)
class MotionSize:
    """How far and how fast the body moves: largest displacement from rest and largest speed, SI."""

    size: float = 1.0
    speed: float = 1.0


def drive_of(t: Array, u: Array, hold: Hold = "first") -> Drive:
    """The input with samples ``u`` (n,) at ``t`` (n,), s, rising, under that hold.

    Raises UndertowError where lengths differ, there are under two samples, the hold has no such name, or a
    band-limited input is not evenly sampled.
    """
    t, u = np.array(t, dtype=np.float64), np.array(u, dtype=np.float64)
    if t.shape != u.shape or t.size < 2:
        raise UndertowError(
            f"input: {u.size} samples at {t.size} instants; give one a time stamp, and at least two of them"
        )
    if hold == "zero":
        knots = np.append(t, 2.0 * t[-1] - t[-2])
        return Drive(knots, np.ascontiguousarray(u[:, None]), True, hold)
    if hold == "first":
        return Drive(t, np.column_stack([u[:-1], np.diff(u)]), False, hold)
    if hold != "band_limited":
        raise UndertowError(f"input: hold {hold!r} is none of {', '.join(HOLDS)}; choose one")
    steps = np.diff(t)
    step = float(t[-1] - t[0]) / steps.size
    if float(np.max(np.abs(steps - step))) > EVEN_SHARE * step:
        raise UndertowError(
            f"input: time steps differ by {float(np.max(np.abs(steps - step))):.3g} s from {step:.3g} s; a "
            "band_limited hold needs even steps within 1 %: choose hold: first, or resample the input"
        )
    values, slopes, curves = _refined(u, step)
    knots = t[0] + np.arange(values.size) * (step / REFINED)
    return Drive(knots, _quintics(values, slopes, curves, step / REFINED), False, hold)


def harmonic(amplitude: float, rate: float, periods: int = 1, mover: Mover = "force") -> Drive:
    """The force amplitude cos(rate t), unit of the amplitude, over so many periods from t = 0; rate in rad/s. Of a
    base that moves (``mover``) it is the acceleration, m/s^2, and its velocity is known beside it.

    >>> bool(abs(harmonic(2.0, 3.0).at(np.array([0.25]))[0] - 2.0 * np.cos(0.75)) < 1e-8)
    True
    """
    step = 2.0 * math.pi / rate / KNOTS_A_PERIOD
    knots: Array = step * np.arange(periods * KNOTS_A_PERIOD + 1, dtype=np.float64)
    cosine, sine = amplitude * np.cos(rate * knots), amplitude * np.sin(rate * knots)
    pieces = _quintics(cosine, -rate * sine, -(rate**2) * cosine, step)
    velocity = None if mover == "force" else _quintics(sine / rate, cosine, -rate * sine, step)
    return Drive(knots, pieces, False, "band_limited", mover, velocity)


def _refined(u: Array, step: float) -> tuple[Array, Array, Array]:
    """Value, slope and curvature of the band-limited signal at `REFINED` knots a sample, from its spectrum."""
    more = min(END_SAMPLES, u.size - 1)
    before, after = 2.0 * u[0] - u[more:0:-1], 2.0 * u[-1] - u[-2 : -2 - more : -1]
    long = np.concatenate([before, u, after])
    n = long.size
    # ends meet at zero: a straight line and a taper of the continuation, which nothing of the record itself sees
    line = np.linspace(u[0], u[-1], u.size)
    trend = np.concatenate([np.full(more, u[0]), line, np.full(more, u[-1])])
    rise = np.sin(0.5 * np.pi * (np.arange(more) + 0.5) / more) ** 2
    taper = np.concatenate([rise, np.ones(u.size), rise[::-1]])
    spectrum = np.fft.rfft((long - trend) * taper)
    omega = 2.0 * np.pi * np.fft.rfftfreq(n, step)
    if n % 2 == 0:
        spectrum[-1] *= 0.5  # half of it belongs to the negative frequency once there are higher ones
    inside = slice(more * REFINED, (more + u.size - 1) * REFINED + 1)
    out = [np.fft.irfft(spectrum * (1j * omega) ** order, n * REFINED)[inside] * REFINED for order in range(3)]
    slope = (u[-1] - u[0]) / ((u.size - 1) * step)
    out[0] += np.linspace(u[0], u[-1], out[0].size)
    out[1] += slope
    return out[0], out[1], out[2]


def _quintics(f: Array, df: Array, ddf: Array, width: float) -> Array:
    """Coefficients (n - 1, 6) by powers of r of the quintics through value, slope and curvature at both ends."""
    a, b, c = f[:-1], df[:-1] * width, 0.5 * ddf[:-1] * width**2
    rest = f[1:] - a - b - c
    slope = df[1:] * width - b - 2.0 * c
    curve = ddf[1:] * width**2 - 2.0 * c
    return np.ascontiguousarray(
        np.column_stack(
            [
                a, b, c,
                10.0 * rest - 4.0 * slope + 0.5 * curve,
                -15.0 * rest + 7.0 * slope - curve,
                6.0 * rest - 3.0 * slope + 0.5 * curve,
            ]
        )
    )  # fmt: skip
