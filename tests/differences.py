"""Derivatives of a motion by central differences of two steps, extrapolated: their error is of the step's fourth power.

A step of 3e-5 of a number keeps both that error and the rounding of two motions below 1e-7 of the derivative; plain
differences of 1e-5 were themselves good to 5e-6 alone.
"""

from __future__ import annotations

SHARE, LEAST = 3e-5, 0.1
"""Step as a share of a number, and the size that a smaller number counts as."""


def slope(run, theta, slot):
    """Derivative (n,) of ``run(theta)`` (n,) by ``theta[slot]``."""

    def central(step):
        ends = []
        for sign in (1.0, -1.0):
            other = theta.copy()
            other[slot] += sign * step
            ends.append(run(other))
        return (ends[0] - ends[1]) / (2.0 * step)

    step = step_of(theta, slot)
    return (4.0 * central(step) - central(2.0 * step)) / 3.0


def step_of(theta, slot):
    """The smaller of the two steps."""
    return SHARE * max(abs(theta[slot]), LEAST)
