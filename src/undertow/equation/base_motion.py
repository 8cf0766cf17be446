"""A base or water that moves as an input: from its recorded displacement, velocity or acceleration to the acceleration
between samples, and to what the motion relative to a base is against the earth.

Belongs here: derivatives and integrals of the input's pieces, outputs seen from the earth. Does not belong here: holds
(input.py), the equation (driven_forces.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from undertow.equation.driven_slots import DRIVEN_SLOT
from undertow.equation.input import Drive, drive_of
from undertow.equation.term import Array
from undertow.errors import UndertowError
from undertow.quantities import Hold, MovingQuantity, mover_of

ACCELERATES: dict[str, tuple[Hold, ...]] = {
    "displacement": ("band_limited",),
    "velocity": ("first", "band_limited"),
    "acceleration": ("zero", "first", "band_limited"),
}
"""Holds under which a recorded quantity has an acceleration between its samples."""


def must_accelerate(quantity: str, hold: Hold) -> None:
    """UndertowError where motion recorded as that quantity has no acceleration between its samples."""
    fit = ACCELERATES[quantity.partition("_")[2]]
    if hold not in fit:
        raise UndertowError(
            f"input: {quantity} held {hold!r} between samples has no acceleration; choose hold: {' or '.join(fit)}"
        )


def moving_drive(
    t: Array, values: Array, quantity: MovingQuantity, hold: Hold = "first", absolute: Sequence[str] = ()
) -> Drive:
    """The acceleration of a base or of water with samples of that ``quantity`` at ``t`` (n,), s; ``absolute`` names the
    outputs that are recorded against the earth where a base moves.

    A displacement is taken as band-limited, a velocity as straight lines or band-limited: other holds have no
    acceleration. The integral of an acceleration begins where its mean is zero. Raises UndertowError for another hold.

    >>> t = np.arange(200) * 0.01
    >>> drive = moving_drive(t, np.sin(5.0 * t), "base_velocity", "band_limited")
    >>> bool(abs(drive.at(np.array([1.0]))[0] - 5.0 * np.cos(5.0)) < 1e-3)
    True
    """
    must_accelerate(quantity, hold)
    recorded = quantity.partition("_")[2]
    given = replace(drive_of(t, values, hold), mover=mover_of(quantity), absolute=tuple(absolute))
    width = np.diff(given.knots)
    if recorded == "acceleration":
        velocity = _integral(given.pieces, width)
        inside = replace(given, pieces=velocity).at(np.asarray(t, dtype=np.float64))
        velocity[:, 0] -= float(np.mean(inside))
        place = replace(given, pieces=_integral(velocity, width)).at(np.asarray(t, dtype=np.float64))
        # what moves about one place: its mean velocity is at most its range over the record's length
        unknown = float(np.ptp(place)) / float(t[-1] - t[0])
        return replace(given, velocity=velocity, drifts=unknown)
    rate = _derivative(given.pieces, width)
    if recorded == "velocity":
        return replace(given, pieces=rate, broken=hold == "first", velocity=given.pieces)
    return replace(given, pieces=_derivative(rate, width), velocity=rate, displacement=given.pieces)


def _derivative(pieces: Array, width: Array) -> Array:
    """Pieces of the rate of change, of one power less."""
    powers = np.arange(1, pieces.shape[1])
    return np.ascontiguousarray(pieces[:, 1:] * powers / width[:, None])


def _integral(pieces: Array, width: Array) -> Array:
    """Pieces of the integral from the first knot on, of one power more."""
    risen = pieces / np.arange(1, pieces.shape[1] + 1) * width[:, None]
    begin = np.concatenate([[0.0], np.cumsum(np.sum(risen, axis=1))[:-1]])
    return np.ascontiguousarray(np.column_stack([begin, risen]))


def seen_from_earth(
    theta: Array, active: np.ndarray, drive: Drive, times: Array, motion: tuple[Array, Array, Array]
) -> tuple[Array, Array, Array]:
    """x, v, a, each (n, 1 + p), with the base's motion added where the output is recorded against the earth."""
    if not drive.absolute:
        return motion
    gain, delay = theta[DRIVEN_SLOT["gain"]], theta[DRIVEN_SLOT["delay"]]
    since = np.asarray(times) - delay
    parts = dict(zip(("displacement", "velocity", "acceleration"), motion, strict=True))
    moved = {"acceleration": drive.at, "velocity": drive.velocity_at, "displacement": drive.displacement_at}
    jerk = replace(drive, pieces=_derivative(drive.pieces, np.diff(drive.knots))) if drive.pieces.shape[1] > 1 else None
    rates = {"displacement": drive.velocity_at, "velocity": drive.at, "acceleration": jerk.at if jerk else None}
    for name in drive.absolute:
        out = parts[name]
        base = moved[name](since)
        out[:, 0] += gain * base
        if name == "velocity":
            out[:, 0] += theta[DRIVEN_SLOT["absolute_v0"]]
        for column, slot in enumerate(active, 1):
            rate = rates[name]
            if slot == DRIVEN_SLOT["gain"]:
                out[:, column] += base
            elif slot == DRIVEN_SLOT["delay"] and rate is not None:
                out[:, column] -= gain * rate(since)
            elif slot == DRIVEN_SLOT["absolute_v0"] and name == "velocity":
                out[:, column] += 1.0
    return parts["displacement"], parts["velocity"], parts["acceleration"]
