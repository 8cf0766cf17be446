"""Hidden linear states as the columns of a regression: a pysindy feature library.

What carries an oscillator or a memory along feels its force; the state itself is in no recording, but it is driven by
the body's acceleration, which is. `HiddenStateLibrary` computes what such states give back, at rest before the
release, so that a plain ``pysindy.SINDy(feature_library=PolynomialLibrary() + HiddenStateLibrary(...))`` finds them
among other terms. The laws are those of `equation.hidden`, written once.

Belongs here: the columns and their grid. Does not belong here: the iteration that refines frequencies
(variable_projection.py), how many states a motion asks for (comparison/search.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pysindy.feature_library.base import BaseFeatureLibrary
from pysindy.utils import AxesArray
from sklearn.utils.validation import check_is_fitted

from undertow.equation.hidden import HiddenResonator, Relaxation
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.methods.variable_projection import INNER_BOUNDS, refine_inner

Array = NDArray[np.float64]
REFINING_ROUNDS = 4
"""Rounds in which oscillators and relaxations are refined in turn; each round is a Gauss-Newton of its own."""

REACH = 5.0
"""A refinement ends within this factor of the lowest and highest start."""

Oscillator = tuple[float, float]
"""Natural frequency with the body held, rad/s, and damping ratio."""

GRID_DAMPING = (0.01, 0.04, 0.15)
"""Damping ratios of a grid: a factor of four apart, refinement bridges the rest."""


def oscillator_grid(
    lowest: float, highest: float, count: int = 30, damping: Sequence[float] = GRID_DAMPING
) -> tuple[Oscillator, ...]:
    """Frequencies evenly spaced in their logarithm, each with every damping ratio.

    ``lowest`` and ``highest`` in rad/s. IdentificationError unless 0 < lowest < highest.

    >>> [(round(w, 2), z) for w, z in oscillator_grid(5.0, 20.0, 3, (0.02,))]
    [(5.0, 0.02), (10.0, 0.02), (20.0, 0.02)]
    """
    if not 0.0 < lowest < highest:
        raise IdentificationError(
            f"a grid of frequencies from {lowest:g} to {highest:g} rad/s; give 0 < lowest < highest, e.g. a third and "
            "twice the body's own"
        )
    return tuple((float(w), float(z)) for w in np.geomspace(lowest, highest, count) for z in damping)


class HiddenStateLibrary(BaseFeatureLibrary):  # type: ignore[misc]
    """Responses of hidden oscillators and relaxations to the measured motion, and slow drift, as a pysindy library.

    Oscillator (w, zeta): x'' + s'' with s'' + 2 zeta w s' + w^2 s = -x''; the coefficient in the equation for -x'' is
    the hidden mass over the inertia that moves with the body. Relaxation tau: z with z' = x' - z / tau. Each is at rest
    at a trajectory's first sample, so that trajectories begin at the release (or anywhere at rest before it), at the
    same even ``step_s``, and may have different lengths.

    Responses need the record: on a single row, as ``SINDy.simulate`` asks for, they are 0, those of the first sample.

    Parameters
    ----------
    step_s : time between samples, s.
    oscillators : (natural frequency in rad/s, damping ratio) of each; see `oscillator_grid`.
    relaxation_times_s : tau of each relaxation, s.
    drift_order : Legendre polynomials of time up to this order for each trajectory of ``fit``; None for none. Other
        trajectories get zeros there, since nobody knows their drift.
    velocity, acceleration : which input columns are x' and x''; with states (x, v) and ``u=a`` 1 and -1.

    Raises
    ------
    IdentificationError
        Without any column to give, with a step, frequency, damping or time that is none, or input that is not finite.

    >>> library = HiddenStateLibrary(step_s=0.1, oscillators=[(9.6, 0.02)])
    >>> states = np.array([[1.0, 0.0, -9.0], [0.96, -0.9, -8.8], [0.82, -1.7, -7.5]])
    >>> library.fit_transform(states).shape, library.get_feature_names()
    ((3, 1), ['hidden(w=9.6, z=0.02)'])
    """

    def __init__(
        self,
        step_s: float,
        oscillators: Sequence[Oscillator] = (),
        relaxation_times_s: Sequence[float] = (),
        drift_order: int | None = None,
        velocity: int = 1,
        acceleration: int = -1,
    ) -> None:
        self.step_s = step_s
        self.oscillators = oscillators
        self.relaxation_times_s = relaxation_times_s
        self.drift_order = drift_order
        self.velocity = velocity
        self.acceleration = acceleration

    def fit(self, x: Array | list[Array], y: object = None) -> HiddenStateLibrary:
        """Remember the columns; x is (n, p) or a list of (n_i, p), one a trajectory."""
        parts = x if isinstance(x, list) else [x]
        first = np.asarray(parts[0])
        self._check()
        needed = max(self.velocity, self.acceleration) + 1
        if first.ndim != 2 or first.shape[1] < max(needed, 2):
            raise IdentificationError(
                f"HiddenStateLibrary got an input of shape {first.shape}; give columns x, v and, as u or a third "
                "column, the measured acceleration"
            )
        self.n_features_in_ = first.shape[1]
        self.n_trajectories_ = len(parts)
        orders = 0 if self.drift_order is None else self.drift_order + 1
        self.n_output_features_ = len(self.terms) + orders * len(parts)
        return self

    def _check(self) -> None:
        """The parameters, at the boundary."""
        if not (math.isfinite(self.step_s) and self.step_s > 0.0):
            raise IdentificationError(f"step_s is {self.step_s!r} s; give the time between samples, above 0")
        for w, z in self.oscillators:
            if not (w > 0.0 and 0.0 <= z < 1.0):
                raise IdentificationError(
                    f"an oscillator of {w:g} rad/s and damping ratio {z:g}; frequencies are above 0, damping ratios "
                    "from 0 to below 1 (beyond it, give a relaxation time)"
                )
        for time in self.relaxation_times_s:
            if not time > 0.0:
                raise IdentificationError(f"a relaxation time of {time:g} s; give times above 0")
        if not self.terms and self.drift_order is None:
            raise IdentificationError(
                "HiddenStateLibrary has 0 columns; give oscillators, e.g. oscillator_grid(4.0, 20.0), relaxation "
                "times or a drift_order"
            )

    @property
    def terms(self) -> tuple[Term, ...]:
        """The hidden states as terms, oscillators first."""
        oscillators = [HiddenResonator(float(w), float(z)) for w, z in self.oscillators]
        return (*oscillators, *(Relaxation(float(time)) for time in self.relaxation_times_s))

    def transform(self, x: Array | list[Array]) -> AxesArray | list[AxesArray]:
        """Columns (n, n_columns) of one trajectory, or of each trajectory in a list."""
        check_is_fitted(self, "n_output_features_")
        if isinstance(x, list):
            known = len(x) == self.n_trajectories_
            return [self._columns(part, place if known else None) for place, part in enumerate(x)]
        return self._columns(x, 0 if self.n_trajectories_ == 1 else None)

    def _columns(self, states: Array, place: int | None) -> AxesArray:
        values = np.asarray(states, dtype=np.float64)
        bad = int(np.count_nonzero(~np.isfinite(values)))
        if bad:
            raise IdentificationError(f"{bad} of {values.size} input values are not finite; a response needs them all")
        out = np.zeros((values.shape[0], self.n_output_features_))
        v, a = values[:, self.velocity], values[:, self.acceleration]
        time = np.arange(max(values.shape[0], 2)) * self.step_s
        for index, term in enumerate(self.terms):
            if values.shape[0] > 1:
                out[:, index] = term.force(v, v, a, time)
        if self.drift_order is not None and place is not None and values.shape[0] > 1:
            unit = np.linspace(-1.0, 1.0, values.shape[0])
            polynomials = np.polynomial.legendre.legvander(unit, self.drift_order)
            out[:, len(self.terms) + place :: self.n_trajectories_] = polynomials
        return AxesArray(out, getattr(states, "axes", {"ax_time": 0, "ax_coord": 1}))

    def get_feature_names(self, input_features: Sequence[str] | None = None) -> list[str]:
        """Names of the columns; those of the states are not used."""
        check_is_fitted(self, "n_output_features_")
        names = [f"hidden(w={w:.6g}, z={z:.6g})" for w, z in self.oscillators]
        names += [f"relaxation(tau={time:.6g})" for time in self.relaxation_times_s]
        if self.drift_order is not None:
            trajectories = range(self.n_trajectories_)
            names += [f"drift{order}[{i}]" for order in range(self.drift_order + 1) for i in trajectories]
        return names

    def refined(
        self, x: list[Array], response: list[Array], beside: BaseFeatureLibrary | None = None
    ) -> HiddenStateLibrary:
        """A library with the same states at the frequencies, dampings and times that explain ``response`` best.

        Variable projection: least squares of ``response`` (a list of (n_i,), e.g. -x'') on the columns of ``beside``
        (fitted or not), the states and the drift, with Gauss-Newton on the oscillators' w and zeta and on the
        relaxations' tau in turn. Start from few states near the truth, such as a sparse regression kept of a grid.

        Raises IdentificationError without states, or where lists differ in length.
        """
        if not self.terms or len(x) != len(response):
            raise IdentificationError(
                f"refined got {len(self.terms)} hidden states, {len(x)} trajectories and {len(response)} responses;"
                " give at least one state and a response for every trajectory"
            )
        target = np.concatenate([np.ravel(part) for part in response])
        others = np.zeros((target.size, 0))
        if beside is not None:
            others = np.vstack([np.asarray(part) for part in beside.fit(x).transform(x)])
        library = self
        for _ in range(REFINING_ROUNDS if self.oscillators and len(self.relaxation_times_s) else 1):
            for block in ("oscillators", "relaxation_times_s"):
                if len(getattr(library, block)):
                    library = library._refined_block(block, x, target, others)
        return library

    def _refined_block(self, block: str, x: list[Array], target: Array, others: Array) -> HiddenStateLibrary:
        """The same library with its oscillators, or its relaxation times, where they explain ``target`` best."""
        rest = self._with(**{block: ()})
        fixed = [others]
        if rest.terms or rest.drift_order is not None:
            fixed.append(np.vstack([np.asarray(part) for part in rest.fit(x).transform(x)]))
        start = np.array([np.atleast_1d(one) for one in getattr(self, block)], dtype=np.float64)
        lower = np.array([start[:, 0].min() / REACH, INNER_BOUNDS[0][1]])[: start.shape[1]]
        upper = np.array([start[:, 0].max() * REACH, INNER_BOUNDS[1][1]])[: start.shape[1]]

        def columns(inner: Array) -> Array:
            values = inner[:, 0] if block == "relaxation_times_s" else inner
            library = self._with(oscillators=(), relaxation_times_s=(), drift_order=None)._with(**{block: values})
            return np.vstack([np.asarray(part) for part in library.fit(x).transform(x)])

        held = np.hstack(fixed) if sum(part.shape[1] for part in fixed) else np.zeros((target.size, 1))
        found = refine_inner(columns, held, target, np.maximum(start, lower), (lower, upper)).inner
        if block == "oscillators":
            return self._with(oscillators=tuple((float(w), float(zeta)) for w, zeta in found))
        return self._with(relaxation_times_s=tuple(float(time) for time in found[:, 0]))

    def _with(self, **changed: object) -> HiddenStateLibrary:
        """A library like this one but for some parameters."""
        return HiddenStateLibrary(**{**self.get_params(deep=False), **changed})
