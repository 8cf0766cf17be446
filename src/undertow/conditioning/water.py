"""Water whose velocity and acceleration are both recorded: the one motion that agrees best with the two records.

    sum (V_i - u_i)^2 / s_V^2 + sum (A_i - u'_i)^2 / s_A^2  ->  least

over cubic splines u through u_i at the samples, with s_V and s_A the records' own white noise: slow motion follows the
velocity, fast motion the acceleration, and an accelerometer's offset moves nothing.

Belongs here: that spline, the refusal of records that contradict each other. Does not belong here: what an input is
between its samples (equation/input.py).
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from undertow.conditioning.driven import white_noise
from undertow.errors import RecordingError
from undertow.recording.recording import Array

CONTRADICTED_SHARE = 0.3
"""A velocity contradicts an acceleration whose integral, up to a straight line, leaves this share of it (rms) beside
its noise: a wrong sign leaves 200 %, a factor of 1.3 between the two 30 %."""


def one_velocity(name: str, t: Array, velocity: Array, acceleration: Array) -> Array:
    """The water's velocity (n,), m/s, that agrees best with both records of trial ``name`` at ``t`` (n,), s.

    Raises RecordingError where the acceleration is not the rate of the velocity.

    >>> t = np.arange(300) * 0.02
    >>> u = one_velocity("r", t, np.sin(3.0 * t), 3.0 * np.cos(3.0 * t) + 0.1)
    >>> bool(np.max(np.abs(u - np.sin(3.0 * t))) < 0.1)
    True
    """
    left = _left_over(t, velocity, acceleration)
    if left > CONTRADICTED_SHARE:
        raise RecordingError(
            f"trial {name}: water_acceleration is not the rate of water_velocity: its integral leaves "
            f"{100.0 * left:.0f} % of the velocity, where {100.0 * CONTRADICTED_SHARE:.0f} % may be left; check their "
            "sign, unit and clock, or map one of them alone"
        )
    step = np.diff(t)
    n = t.size
    # a cubic spline's slopes s: s_{i-1} / h + 2 s_i (1 / h + 1 / k) + s_{i+1} / k = 3 (du / h^2 + dw / k^2)
    h, k = step[:-1], step[1:]
    rows = np.repeat(np.arange(n - 2), 3)
    columns = (np.arange(n - 2)[:, None] + np.arange(3)).ravel()
    slopes = sparse.csr_array((np.column_stack([1 / h, 2 / h + 2 / k, 1 / k]).ravel(), (rows, columns)), (n - 2, n))
    values = sparse.csr_array(
        (3.0 * np.column_stack([-1 / h**2, 1 / h**2 - 1 / k**2, 1 / k**2]).ravel(), (rows, columns)), (n - 2, n)
    )
    scale = white_noise(velocity) / white_noise(acceleration)
    one, other = sparse.identity(n, format="csr"), scale**2 * sparse.identity(n, format="csr")
    whole = sparse.block_array([[one, None, values.T], [None, other, -slopes.T], [values, -slopes, None]], format="csc")
    found = spsolve(whole, np.concatenate([velocity, scale**2 * acceleration, np.zeros(n - 2)]))
    return np.asarray(found[:n])


def _left_over(t: Array, velocity: Array, acceleration: Array) -> float:
    """Share (rms) of the velocity's motion that the acceleration's integral and a straight line leave beside noise."""
    moved = np.concatenate([[0.0], np.cumsum(0.5 * (acceleration[1:] + acceleration[:-1]) * np.diff(t))])
    line = np.column_stack([np.ones(t.size), t])
    away = velocity - moved
    away = away - line @ np.linalg.lstsq(line, away, rcond=None)[0]
    noise, size = white_noise(velocity), float(np.std(velocity))
    return float(np.sqrt(max(float(np.mean(away**2)) - noise**2, 0.0))) / size if size > 0.0 else 0.0
