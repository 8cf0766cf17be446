"""The instant at which a held body was let go, from the hold and the first swing that follows.

Until it turns for the first time a body on a spring, with viscous and dry friction, moves as

    x = x0 - D (1 - exp(-z w s) (cos w s + z sin w s)),  s = t - t0,

dry friction only shifting the centre. x0, D, w, z and t0 are fitted to the recorded samples together, so that noise of
an eighth of the deflection moves t0 by a hundredth of a period.

Belongs here: that fit and its error. Does not belong here: which hold it is (release.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from undertow.recording.recording import Array

SWINGS_IN_RADIANS = (3.0, 2.0, 1.4, 1.0, 0.7)
"""How far into the first swing samples are used: to the first turn, where noise counts least; less of it where the
recording shows, by more than its noise, that the swing is not this one (drag, a spring that is not linear)."""

MISFIT_IN_NOISE = 1.1
"""What is left over noise above which less of the swing is used."""

LEAST_RELATIVE_W, MOST_RELATIVE_W = 0.5, 2.0
"""Frequencies found are between these multiples of the first guess: a release is no other motion."""

W_STD = 0.15
"""Prior of the frequency, relative to a guess from the whole record: it falls or rises with amplitude."""

DAMPING_STD = 0.1
"""Prior of the damping ratio."""

MOST_STEP = 0.3
"""Longest step of the search, in radians of the swing (and relative to w): half a swing further lies another one."""

MOST_ITERATIONS = 30
STOP_IN_RADIANS = 1e-6
"""The search ends when the release moves by less than this angle."""

LAW_SHARE = 0.25
"""Share of the damping ratio, in radians, that the damping's law leaves open: quadratic drag in the place of viscous
damping moves the release by 0.06 of it, water that sloshes by 0.3."""

BLOCKS = 16
"""Residuals are summed in so many blocks for the error, so that slow noise and misfit within a block count whole."""


@dataclass(frozen=True)
class FirstSwing:
    """Release ``t0`` (s) with its standard error (s), held position ``x0`` and deflection ``size`` in the channel's
    unit, ``spread`` the RMS of what is left."""

    t0: float
    stderr: float
    x0: float
    size: float
    spread: float


def fit_first_swing(
    time: Array, values: Array, noise: float, t0: float, x0: float, size: float, w: float
) -> FirstSwing | None:
    """The first swing through ``values`` (n,) at ``time`` (n,), from first guesses; None where there is none.

    ``time`` reaches from the hold to well beyond the first turn; ``noise`` is the standard deviation of ``values``.

    >>> t = np.arange(-0.5, 1.0, 0.01)
    >>> x = np.where(t > 0.123, 0.02 * np.cos(5.0 * (t - 0.123)), 0.02)
    >>> round(fit_first_swing(t, x, noise=1e-6, t0=0.15, x0=0.02, size=0.02, w=5.5).t0, 4)
    0.123
    """
    found = None
    for reach in SWINGS_IN_RADIANS:
        fit = _fitted(time, values, noise, np.array([t0, x0, size, w, 0.0]), reach)
        if fit is None:
            break
        # where less of the swing is another release, it is not known better than that
        moved = 0.0 if found is None else fit.t0 - found.t0
        found = replace(fit, stderr=math.hypot(fit.stderr, moved))
        if fit.spread <= MISFIT_IN_NOISE * noise:
            break
        t0, x0, size = fit.t0, fit.x0, fit.size
    return found


def _fitted(time: Array, values: Array, noise: float, first: Array, reach: float) -> FirstSwing | None:
    """The fit to samples up to ``reach`` radians after the release, from ``first`` (t0, x0, size, w, damping)."""
    numbers, w = first.copy(), float(first[3])
    prior = noise / np.array([np.inf, np.inf, np.inf, W_STD * w, DAMPING_STD])
    for _ in range(MOST_ITERATIONS):
        rows = time <= numbers[0] + reach / numbers[3]
        if np.count_nonzero(rows & (time > numbers[0])) <= numbers.size:
            return None
        predicted, columns = _swing(time[rows], numbers)
        table = np.vstack([columns, np.diag(prior)])
        response = np.concatenate([values[rows] - predicted, prior * (first - numbers)])
        step = np.linalg.lstsq(table, response, rcond=None)[0]
        step *= min(1.0, MOST_STEP / max(abs(step[0]) * numbers[3], abs(step[3]) / numbers[3], MOST_STEP))
        numbers = numbers + step
        within = LEAST_RELATIVE_W * w <= numbers[3] <= MOST_RELATIVE_W * w and abs(numbers[4]) < 1.0
        if not within or numbers[2] * first[2] <= 0.0:
            return None
        if abs(step[0]) * numbers[3] < STOP_IN_RADIANS:
            break
    rows = time <= numbers[0] + reach / numbers[3]
    predicted, columns = _swing(time[rows], numbers)
    return _with_error(numbers, columns, values[rows] - predicted, prior, noise)


def _swing(time: Array, numbers: Array) -> tuple[Array, Array]:
    """Positions (n,) and derivatives by t0, x0, size, w, damping (n, 5)."""
    t0, x0, size, w, damping = numbers
    late = np.maximum(time - t0, 0.0)
    angle = w * late
    fading = np.exp(-damping * angle)
    sine, cosine = fading * np.sin(angle), fading * np.cos(angle)
    shape = cosine + damping * sine
    rate = -(1.0 + damping**2) * sine  # by the angle
    columns = np.column_stack(
        [-size * w * rate, np.ones_like(time), shape - 1.0, size * late * rate, size * (sine - angle * shape)]
    )
    return x0 + size * (shape - 1.0), columns


def _with_error(
    numbers: Array, columns: Array, residual: Array, prior: Array, noise: float
) -> FirstSwing:
    """What is found, with the release's error: blocks of residuals as they are (sandwich), or white noise if more."""
    spread = math.sqrt(float(residual @ residual) / max(residual.size - numbers.size, 1))
    scale = np.linalg.norm(columns, axis=0)
    unit = columns / scale
    bread = np.linalg.pinv(unit.T @ unit + np.diag(prior / scale) ** 2, hermitian=True)
    edges = np.linspace(0, residual.size, BLOCKS + 1).astype(int)[:-1]
    scores = np.add.reduceat(unit * residual[:, None], edges, axis=0)
    sandwich = bread @ (scores.T @ scores) @ bread
    variance = max(float(sandwich[0, 0]), float(bread[0, 0]) * max(spread, noise) ** 2)
    t0, x0, size, w, damping = (float(number) for number in numbers)
    stderr = math.hypot(math.sqrt(variance) / float(scale[0]), LAW_SHARE * damping / w)
    return FirstSwing(t0, stderr, x0, size, spread)
