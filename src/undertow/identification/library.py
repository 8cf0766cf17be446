"""Terms of an equation as the columns of a regression.

The law of a term is written once, in `equation`. Here it becomes a column: the force it gives per unit coefficient
along a measured motion. `TermLibrary` serves it to pysindy, `build_design` to our own regressions over several trials.

Belongs here: columns and the rows they are evaluated on. Does not belong here: which columns are kept (subset.py) and
what their coefficients mean (sindy.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pysindy.feature_library.base import BaseFeatureLibrary
from pysindy.utils import AxesArray
from sklearn.utils.validation import check_is_fitted

from undertow.conditioning.motion import Motion
from undertow.equation.term import Term
from undertow.errors import IdentificationError

Array = NDArray[np.float64]

SLOW_SHARE = 0.05
"""Samples slower than this share of the trial's highest speed are left out: noise turns the sign of v there."""

CELL_RATE_HZ = 200.0
"""Cells of motion averaged into one row: 5 ms, some fifty rows a period of the fastest motion looked at (4 Hz)."""

DRIFT_ORDER = 2
"""Order of the polynomial of time taken off each trial: drift of the sensors within a decay, slower than the body."""

MIN_CELLS = 20
"""Rows that a trial must have to be worth a constant of its own."""


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

    def fit(self, x: Array | list[Array], y: object = None) -> TermLibrary:
        """Remember how many columns come in and go out; x is (n, 2) or (n, 3), or a list of such."""
        first = np.asarray(x[0] if isinstance(x, list) else x)
        if not len(self.terms):
            raise IdentificationError("TermLibrary has 0 terms; give it at least one, e.g. TermLibrary((Stiffness(),))")
        if first.ndim != 2 or first.shape[1] not in (2, 3):
            raise IdentificationError(
                f"TermLibrary got an input of shape {first.shape}; give columns x and v, and a as a third where needed"
            )
        self.n_features_in_ = first.shape[1]
        self.n_output_features_ = len(self.terms)
        return self

    def transform(self, x: Array | list[Array]) -> AxesArray | list[AxesArray]:
        """Columns (n, n_terms) of one trajectory, or of each trajectory in a list."""
        check_is_fitted(self, "n_output_features_")
        if isinstance(x, list):
            return [self._columns(part) for part in x]
        return self._columns(x)

    def _columns(self, states: Array) -> AxesArray:
        values = np.asarray(states, dtype=np.float64)
        nothing = np.full(values.shape[0], np.nan)
        acceleration = values[:, 2] if values.shape[1] > 2 else nothing
        forces = evaluate(self.terms, values[:, 0], values[:, 1], acceleration, nothing)
        return AxesArray(forces, {"ax_sample": 0, "ax_coord": 1})

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
    """Rows of a regression -a = columns @ coefficients + a constant for each trial.

    ``columns`` (n, p) and ``response`` (n,), the negative acceleration, are means over cells of ``cell_s`` seconds: the
    equation is linear in them, so that averaging loses no exactness. Rows outside the window or slower than the cut
    are all zero and False in ``used`` (n,), so that a trial keeps its length in time. ``trial`` (n,) numbers the
    trials, ``time`` (n,) is s after the release.
    """

    columns: Array
    response: Array
    used: NDArray[np.bool_]
    trial: NDArray[np.int64]
    time: Array
    names: tuple[str, ...]
    trials: tuple[str, ...]
    cell_s: float
    drift_order: int = DRIFT_ORDER

    @property
    def lengths(self) -> tuple[int, ...]:
        """Rows of each trial."""
        return tuple(np.bincount(self.trial, minlength=len(self.trials)).tolist())

    @property
    def nuisance(self) -> Array:
        """Constants and slow drift, (n, n_trials (drift_order + 1)), zero in rows that are not used.

        Legendre polynomials of time within each trial: all constants first, then all slopes, and so on.
        """
        blocks = np.zeros((self.used.size, self.drift_order + 1, len(self.trials)))
        for index in range(len(self.trials)):
            rows = np.flatnonzero((self.trial == index) & self.used)
            time = self.time[rows]
            unit = 2.0 * (time - time[0]) / (time[-1] - time[0]) - 1.0
            blocks[rows, :, index] = np.polynomial.legendre.legvander(unit, self.drift_order)
        return blocks.reshape(self.used.size, -1)


def build_design(
    motions: Sequence[Motion],
    terms: Sequence[Term],
    slow_share: float = SLOW_SHARE,
    cell_rate_hz: float = CELL_RATE_HZ,
    drift_order: int = DRIFT_ORDER,
) -> Design:
    """Columns of ``terms`` along the windows of several trials.

    Displacements are taken from `Motion.equilibrium`; what is wrong with it is a constant for a linear spring, which
    the trial's own constant takes up. Samples with |v| below ``slow_share`` of the trial's largest are left out. Rows
    are means over cells, so that 1 kHz costs no more than ``cell_rate_hz``; slower recordings keep their samples.

    Raises IdentificationError without motions, with trials recorded at rates more than twofold apart after averaging,
    or with a trial of fewer than 20 usable cells.
    """
    if not motions:
        raise IdentificationError("0 motions; give at least one trial")
    parts = [_trial_rows(motion, terms, slow_share, cell_rate_hz) for motion in motions]
    cells = np.array([part[4] for part in parts])
    if cells.max() > 2.0 * cells.min():
        slow, fast = motions[int(np.argmax(cells))], motions[int(np.argmin(cells))]
        raise IdentificationError(
            f"trial {slow.name} gives a row every {cells.max():.3g} s, {fast.name} every {cells.min():.3g} s; trials "
            "fitted together must not differ more than twofold: lower cell_rate_hz"
        )
    return Design(
        columns=np.vstack([part[0] for part in parts]),
        response=np.concatenate([part[1] for part in parts]),
        used=np.concatenate([part[2] for part in parts]),
        trial=np.repeat(np.arange(len(parts)), [part[2].size for part in parts]),
        time=np.concatenate([part[3] for part in parts]),
        names=tuple(label(term) for term in terms),
        trials=tuple(motion.name for motion in motions),
        cell_s=float(np.median(cells)),
        drift_order=drift_order,
    )


def _trial_rows(
    motion: Motion, terms: Sequence[Term], slow_share: float, cell_rate_hz: float
) -> tuple[Array, Array, NDArray[np.bool_], Array, float]:
    """Columns, response, use, time and cell length (s) of one trial, cells in order of time."""
    forces = evaluate(terms, motion.x - motion.equilibrium.value, motion.v, motion.a, motion.t)
    speed = np.abs(motion.v)
    usable = motion.inside & (speed >= slow_share * speed[motion.inside].max())
    step_s = float(np.median(np.diff(motion.t)))
    size = max(1, round(1.0 / (cell_rate_hz * step_s)))
    inside = np.flatnonzero(motion.inside)
    count = (inside[-1] + 1 - inside[0]) // size
    rows = slice(inside[0], inside[0] + count * size)
    used = usable[rows].reshape(count, size).all(axis=1)
    if np.count_nonzero(used) < MIN_CELLS:
        raise IdentificationError(
            f"trial {motion.name}: {np.count_nonzero(used)} cells of {size * step_s * 1e3:.3g} ms in the window from "
            f"{motion.window.start_s:g} to {motion.window.end_s:g} s; {MIN_CELLS} are needed: widen trials.window"
        )
    table = np.column_stack([forces, -motion.a, motion.t])[rows]
    means = table.reshape(count, size, -1).mean(axis=1)
    means[~used, :-1] = 0.0
    return means[:, :-2], means[:, -2], used, means[:, -1], size * step_s
