"""The rows of a regression with hidden oscillators, fast enough to refine frequencies on.

A regression's static columns are computed once; an oscillator's column anew for every frequency and damping that a
search looks at. Its response is that of `equation.hidden.HiddenResonator` in modal form, exact for an acceleration
that is straight between samples, and averaged by the same test functions.

Belongs here: columns of oscillators and their averages. Does not belong here: which are looked at (hidden_search.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from undertow.compiling import compiled
from undertow.conditioning.motion import Motion
from undertow.equation.hidden import even_step
from undertow.equation.term import Term
from undertow.methods.library import Design, build_design
from undertow.methods.sindy import MEMORY_PERIODS

Array = NDArray[np.float64]


def oscillator_responses(inner: Array, acceleration: Array, step_s: float) -> Array:
    """x'' + s'' (n, m) of oscillators (m, 2), w in rad/s and zeta < 1, driven by ``acceleration`` (n,) from rest.

    In modal form R = 2 Re(c q), q' = p q + x'', p = -zeta w + i w sqrt(1 - zeta^2), c = (2 zeta w p + w^2) / (p - p*).

    >>> float(oscillator_responses(np.array([[10.0, 0.0]]), np.ones(2), 1e-3)[1, 0].round(9))  # w^2 t^2 / 2
    5e-05
    """
    w, zeta = np.asarray(inner, dtype=np.float64).reshape(-1, 2).T
    pole = -zeta * w + 1j * w * np.sqrt(1.0 - zeta * zeta)
    share = (2.0 * zeta * w * pole + w * w) / (2j * pole.imag)
    turn = np.exp(pole * step_s)
    level = (turn - 1.0) / pole
    slope = (turn - 1.0 - pole * step_s) / (pole * pole * step_s)
    out = np.zeros((acceleration.size, w.size))
    _march(turn, level - slope, slope, 2.0 * share, np.ascontiguousarray(acceleration), out)
    return out


@compiled("void(c16[::1], c16[::1], c16[::1], c16[::1], f8[::1], f8[:,::1])")
def _march(turn: Array, before: Array, after: Array, share: Array, drive: Array, out: Array) -> None:
    """q' = p q + drive from q = 0 in steps that are exact for a straight drive; ``out`` takes Re(share q)."""
    for j in range(turn.size):
        state = 0.0j
        for i in range(1, drive.size):
            state = turn[j] * state + before[j] * drive[i - 1] + after[j] * drive[i]
            out[i, j] = (share[j] * state).real


@dataclass(frozen=True)
class _TrialDrive:
    """One trial's drive up to its last row, its step in s, and the matrix that averages samples into rows."""

    acceleration: Array
    step_s: float
    average: csr_matrix


@dataclass(frozen=True)
class HiddenRows:
    """The regression -a = columns @ coefficients + drift of several trials, ready for hidden oscillators.

    ``design`` holds the equation's own ``own`` columns first, then its rivals'. See `hidden_rows`.
    """

    design: Design
    own: int
    trials: tuple[_TrialDrive, ...]

    def hidden(self, inner: Array) -> Array:
        """Columns (n, m) of oscillators (m, 2): w in rad/s, damping ratio."""
        if not len(inner):
            return np.zeros((self.design.response.size, 0))
        parts = [
            trial.average @ oscillator_responses(inner, trial.acceleration, trial.step_s) for trial in self.trials
        ]
        return np.vstack(parts)

    def fixed(self, rivals: bool) -> Array:
        """Columns that are always there, each of norm one: terms, rivals where asked for, constants and drifts."""
        static = self.design.columns if rivals else self.design.columns[:, : self.own]
        every = np.hstack([static, self.design.nuisance])
        norms = np.linalg.norm(every, axis=0)
        scaled: Array = every[:, norms > 0.0] / norms[norms > 0.0]
        return scaled

    @property
    def memory(self) -> int:
        """Rows over which the residual may be correlated."""
        return max(2, round(MEMORY_PERIODS * self.design.period_s / self.design.step_s))


def hidden_rows(
    motions: Sequence[Motion], terms: Sequence[Term], rivals: Sequence[Term], periods: float, drift_order: int
) -> HiddenRows:
    """Rows of several trials with test functions ``periods`` long and drifts up to ``drift_order``.

    Raises IdentificationError as `build_design` does, UndertowError where a trial's time steps are uneven.
    """
    design = build_design(motions, (*terms, *rivals), periods, drift_order)
    trials = tuple(_trial(motion, design, place) for place, motion in enumerate(motions))
    return HiddenRows(design, len(terms), trials)


def _trial(motion: Motion, design: Design, place: int) -> _TrialDrive:
    """The averaging matrix of one trial, from the middles of the design's test functions."""
    step = even_step(motion.t, f"trial {motion.name}: time")
    weights = np.hanning(max(3, round(design.length_s / step) + 2))[1:-1]
    middles = design.time[design.trial == place]
    first = np.rint((middles - motion.t[0]) / step - 0.5 * (weights.size - 1)).astype(int)
    samples = int(first[-1]) + weights.size
    rows = np.repeat(np.arange(first.size), weights.size)
    columns = (first[:, None] + np.arange(weights.size)).ravel()
    values = np.tile(weights / weights.sum(), first.size)
    average = csr_matrix((values, (rows, columns)), shape=(first.size, samples))
    return _TrialDrive(np.array(motion.a[:samples]), step, average)
