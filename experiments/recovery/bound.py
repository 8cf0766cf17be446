"""The Cramer-Rao bound of a recovery study: no unbiased estimate from the same samples does better.

Sensitivities are central differences of the exact motion. Unknown are m_a, c, mu, C_d together and, in each trial, the
release, the offset of both sensors and their slow drift (a straight line and a parabola); k is known.
"""

from __future__ import annotations

import numpy as np

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.motion import Floats, simulate
from experiments.recovery.releases import NOISE, RATE_HZ, RECORD_AFTER_RELEASE_S, Truth

RELATIVE_STEP = 1e-4
SPOILT_S = 0.0015
"""Samples so near to a reversal are left out of the acceleration: friction's step makes a difference quotient there."""

NORMAL_P90 = 1.6449
"""90 % of a normal distribution's draws lie within so many standard deviations."""


def sensitivities(truth: Truth, x0_m: float, times_s: Floats) -> tuple[Floats, Floats]:
    """d x / d p and d a / d p, (n, 6) each, for m_a, c, mu, C_d, x0 and the release time; zero once stuck."""
    columns_x, columns_a = [], []
    base = simulate(truth.body, x0_m, times_s)
    for index in range(5):
        # added mass may be 0: its step is a share of the whole mass
        size = RELATIVE_STEP * (truth.body.inertia_kg, *truth.unknowns[1:], x0_m)[index]
        pair = []
        for sign in (1.0, -1.0):
            values, start = truth.unknowns.copy(), x0_m
            if index < 4:
                values[index] += sign * size
            else:
                start += sign * size
            pair.append(simulate(truth.with_unknowns(values).body, start, times_s))
        columns_x.append((pair[0].x - pair[1].x) / (2.0 * size))
        columns_a.append((pair[0].a - pair[1].a) / (2.0 * size))
    columns_x.append(base.v)
    columns_a.append(np.gradient(base.a, times_s))
    a = np.column_stack(columns_a)
    for reversal in base.reversals_s:
        a[np.abs(times_s - reversal) < SPOILT_S] = 0.0
    return np.column_stack(columns_x), a


def bound(truth: Truth, noise: str) -> Floats:
    """Smallest p90 of |error| (4,): m_a in kg, c, mu and C_d in per cent."""
    information = np.zeros((4, 4))
    for x0 in tables.RELEASES_M[truth.spring]:
        times = np.arange(1, round(RECORD_AFTER_RELEASE_S * RATE_HZ)) / RATE_HZ
        stopped = simulate(truth.body, x0, times).stopped_s
        times = times[times < 0.995 * (stopped or times[-1])]
        unit = 2.0 * times / times[-1] - 1.0
        slow = np.polynomial.legendre.legvander(unit, 2)
        rows = []
        for sensor, columns in enumerate(sensitivities(truth, x0, times)):
            nuisance = [slow if other == sensor else np.zeros_like(slow) for other in (0, 1)]
            rows.append(np.hstack([columns, *nuisance]) / NOISE[noise][sensor])
        stacked = np.vstack(rows)
        scale = np.linalg.norm(stacked, axis=0)
        gram = (stacked / scale).T @ (stacked / scale)
        shared, own = gram[:4, :4], gram[4:, 4:]
        reduced = shared - gram[:4, 4:] @ np.linalg.solve(own, gram[4:, :4])
        information += reduced * np.outer(scale[:4], scale[:4])
    errors = np.sqrt(np.diag(np.linalg.inv(information)))
    return NORMAL_P90 * errors / np.array([1.0, *(truth.unknowns[1:] / 100.0)])
