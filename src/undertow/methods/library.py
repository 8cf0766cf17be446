"""Terms of an equation as the columns of a regression.

The law of a term is written once, in `equation`. Here it becomes a column: the force it gives per unit coefficient
along a measured motion. `TermLibrary` serves it to pysindy, `build_design` to our own regressions over several trials.

Belongs here: columns and the rows they are evaluated on. Does not belong here: which columns are kept (subset.py) and
what their coefficients mean (sindy.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pysindy.feature_library.base import BaseFeatureLibrary
from pysindy.utils import AxesArray
from scipy.signal import fftconvolve
from sklearn.utils.validation import check_is_fitted

from undertow.conditioning.motion import Motion
from undertow.equation.term import Term
from undertow.errors import IdentificationError

Array = NDArray[np.float64]

TEST_FUNCTION_PERIODS = 0.5
"""Length of the test function in periods of the motion: half a period passes the motion and little else."""

ROWS_PER_TEST_FUNCTION = 5
"""Test functions start a fifth of their length apart: a Hann window passes nothing above half that rate."""

DRIFT_ORDER = 2
"""Order of the polynomial of time taken off each trial: drift of the sensors within a decay, slower than the body."""

MIN_ROWS = 10
"""Rows that a trial must have to be worth a constant and a drift of its own: three test functions on end."""


class TermLibrary(BaseFeatureLibrary):  # type: ignore[misc]
    """Terms as a pysindy feature library over the states x and v.

    Input columns: displacement from rest (m or rad), velocity, and, where a term needs it, the measured acceleration
    as a third column (pysindy: the control ``u``). Output: one column a term, its force per unit coefficient.

    Parameters
    ----------
    terms : the terms, in the order of the columns.

    Raises
    ------
    IdentificationError
        Without terms, with fewer than two or more than three input columns, or where a column is not finite.

    >>> from undertow.equation.structure import CoulombFriction, Stiffness
    >>> library = TermLibrary((Stiffness(), CoulombFriction()))
    >>> library.fit_transform(np.array([[0.1, -2.0], [0.2, 3.0]])).tolist()
    [[0.1, -1.0], [0.2, 1.0]]
    >>> library.get_feature_names()
    ['stiffness', 'coulomb_friction']
    """

    def __init__(self, terms: Sequence[Term] = ()) -> None:
        self.terms = terms

    def fit(self, x: Array | Sequence[Array], y: object = None) -> TermLibrary:
        """Remember how many columns come in and go out; x is (n, 2) or (n, 3), or a sequence of such."""
        first = np.asarray(x if isinstance(x, np.ndarray) else x[0])
        if not len(self.terms):
            raise IdentificationError("TermLibrary has 0 terms; give it at least one, e.g. TermLibrary((Stiffness(),))")
        if first.ndim != 2 or first.shape[1] not in (2, 3):
            raise IdentificationError(
                f"TermLibrary got an input of shape {first.shape}; give columns x and v, and a as a third where needed"
            )
        self.n_features_in_ = first.shape[1]
        self.n_output_features_ = len(self.terms)
        return self

    def transform(self, x: Array | Sequence[Array]) -> AxesArray | list[AxesArray]:
        """Columns (n, n_terms) of one trajectory, or of each trajectory in a sequence."""
        check_is_fitted(self, "n_output_features_")
        if isinstance(x, np.ndarray):
            return self._columns(x)
        return [self._columns(part) for part in x]

    def _columns(self, states: Array) -> AxesArray:
        values = np.asarray(states, dtype=np.float64)
        nothing = np.full(values.shape[0], np.nan)
        acceleration = values[:, 2] if values.shape[1] > 2 else nothing
        forces = evaluate(self.terms, values[:, 0], values[:, 1], acceleration, nothing)
        # the input's own axes, so that pysindy can set these columns beside another library's
        return AxesArray(forces, getattr(states, "axes", {"ax_time": 0, "ax_coord": 1}))

    def get_feature_names(self, input_features: Sequence[str] | None = None) -> list[str]:
        """The terms' names; those of the states are not used."""
        return [label(term) for term in self.terms]


def label(term: Term) -> str:
    """A term's name, with its inner parameters where it has some, so that two of a kind stay apart.

    >>> from undertow.equation.hydrodynamics import DragExponent
    >>> label(DragExponent(1.5))
    'drag_exponent(exponent=1.5)'
    """
    inner = ", ".join(f"{name}={value:.6g}" for name, value in term.inner.items())
    return f"{term.name}({inner})" if inner else term.name


def evaluate(terms: Sequence[Term], x: Array, v: Array, a: Array, t: Array) -> Array:
    """Forces per unit coefficient, (n, n_terms), at displacements x, velocities v, accelerations a and times t, (n,).

    Raises IdentificationError where a force is not finite, naming the term.
    """
    columns = np.empty((x.size, len(terms)))
    for index, term in enumerate(terms):
        columns[:, index] = term.force(x, v, a, t)
        bad = int(np.count_nonzero(~np.isfinite(columns[:, index])))
        if bad:
            raise IdentificationError(
                f"{label(term)} is not finite at {bad} of {x.size} samples; give the acceleration (or the time) if it "
                "needs one, and samples without NaN"
            )
    return columns


@dataclass(frozen=True)
class Design:
    """Rows of a regression -a = columns @ coefficients + slow drift of each trial, in weak form.

    ``columns`` (n, p) and ``response`` (n,), the negative acceleration, are means weighted by a test function
    ``length_s`` seconds long and ``step_s`` seconds on from row to row. ``trial`` (n,) numbers the trials, ``time``
    (n,) is the test function's middle in s after the release. ``period_s`` is that of the motion.
    """

    columns: Array
    response: Array
    trial: NDArray[np.int64]
    time: Array
    names: tuple[str, ...]
    trials: tuple[str, ...]
    length_s: float
    step_s: float
    period_s: float

    @classmethod
    def of(
        cls, parts: Sequence[Array], terms: Sequence[Term], motions: Sequence[Motion],
        lengths_s: tuple[float, float, float],
    ) -> Design:  # fmt: skip
        """From the rows of every trial: columns, response, time (n, p + 2); ``lengths_s`` are those of a test function,
        of a step and of a period."""
        every = np.vstack(parts)
        return cls(
            every[:, :-2], every[:, -2], np.repeat(np.arange(len(parts)), [len(part) for part in parts]), every[:, -1],
            tuple(label(term) for term in terms), tuple(motion.name for motion in motions), *lengths_s,
        )  # fmt: skip

    @property
    def lengths(self) -> tuple[int, ...]:
        """Rows of each trial."""
        return tuple(np.bincount(self.trial, minlength=len(self.trials)).tolist())

    @property
    def nuisance(self) -> Array:
        """Constants and slow drift, (n, n_trials (`DRIFT_ORDER` + 1)).

        Legendre polynomials of time within each trial: all constants first, then all slopes, and so on. The mean of a
        polynomial over a moving test function is a polynomial of the same order.
        """
        blocks = np.zeros((self.response.size, DRIFT_ORDER + 1, len(self.trials)))
        for index in range(len(self.trials)):
            rows = np.flatnonzero(self.trial == index)
            time = self.time[rows]
            unit = 2.0 * (time - time[0]) / (time[-1] - time[0]) - 1.0
            blocks[rows, :, index] = np.polynomial.legendre.legvander(unit, DRIFT_ORDER)
        return blocks.reshape(self.response.size, -1)


def motion_period(motion: Motion) -> float:
    """Period of the motion in its window within some 10 %, s: 2 pi sqrt(<v^2> / <a^2>)."""
    v, a = motion.windowed("v"), motion.windowed("a")
    return 2.0 * math.pi * math.sqrt(float(np.mean(v**2)) / float(np.mean(a**2)))


def build_design(
    motions: Sequence[Motion], terms: Sequence[Term], periods: float = TEST_FUNCTION_PERIODS
) -> Design:
    """The equation of motion of several trials, averaged by moving test functions over their windows.

    Every row is the equation multiplied by a Hann window and summed over the samples: linear, and therefore as exact
    as the equation itself, whatever the sampling rate. Most of the noise, which grows with frequency, is left behind,
    and so is what smoothing does to friction's step at a velocity reversal: no slow samples have to be dropped.
    ``periods`` is the test function's length in (median) periods of the motion.

    Displacements are taken from `Motion.equilibrium`; what is wrong with it is a constant for a linear spring, which
    the trial's own constant takes up.

    Raises IdentificationError without motions, or with a window too short for 10 rows (three test functions).
    """
    if not motions:
        raise IdentificationError("0 motions; give at least one trial")
    period_s = float(np.median([motion_period(motion) for motion in motions]))
    length_s = periods * period_s
    step_s = length_s / ROWS_PER_TEST_FUNCTION
    parts = [_trial_rows(motion, terms, length_s, step_s) for motion in motions]
    return Design.of(parts, terms, motions, (length_s, step_s, period_s))


def _trial_rows(motion: Motion, terms: Sequence[Term], length_s: float, step_s: float) -> Array:
    """Columns, response and time (n, p + 2) of one trial: Hann-weighted means, a row every ``step_s``."""
    forces = evaluate(terms, motion.x - motion.equilibrium.value, motion.v, motion.a, motion.t)
    table = np.column_stack([forces, -motion.a, motion.t])[motion.inside]
    sample_s = motion.step_s
    weights = np.hanning(max(3, round(length_s / sample_s) + 2))[1:-1]
    count = max(table.shape[0] - weights.size + 1, 0)
    starts = np.unique(np.round(np.arange(0.0, count, max(step_s / sample_s, 1.0))).astype(int))
    starts = starts[starts < count]
    if starts.size < MIN_ROWS:
        raise IdentificationError(
            f"trial {motion.name}: {starts.size} rows in the window from {motion.window.start_s:g} to "
            f"{motion.window.end_s:g} s with test functions of {length_s:.3g} s; {MIN_ROWS} are needed: "
            "widen trials.window or leave the trial out"
        )
    means: Array = fftconvolve(table, (weights / weights.sum())[:, None], mode="valid", axes=0)[starts]
    return means
