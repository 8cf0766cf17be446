"""`FoundEquation`: what every equation found from trials says, moves like, and is scored by, in every result alike.

Belongs here: the methods that `fit`, `Discover` and `diagnose` share. Does not belong here: how an equation was found
(fitting.py, discovering.py, diagnosing.py), programs for others (handover/).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from numbers import Integral
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from undertow.errors import IdentificationError, RecordingError, UndertowError, shown
from undertow.front.columns import Columns, Units
from undertow.front.handover import HandOver
from undertow.front.known import ReadSettings
from undertow.front.prediction import Prediction, predict
from undertow.front.reading import read
from undertow.front.simulation import Simulation, simulate
from undertow.front.tables import parameter_table
from undertow.front.to_arviz import to_arviz
from undertow.front.trials import Trials
from undertow.likelihood.free_run import FreeRun, equation_runs
from undertow.quantities import Estimate
from undertow.recording.arrays import real_numbers
from undertow.report.trial_curves import draw_pairs
from undertow.uncertainty.confidence import INTERVAL_LEVEL
from undertow.uncertainty.posterior import Draws

FAR = 10.0
"""A release so many times the largest that was fitted is no trial of the same campaign: a unit is wrong, or nobody
knows what the equation does there."""

STATES = 2
"""Displacement and velocity: what a motion begins with."""


class FoundEquation(HandOver):
    """An equation with its numbers: `equations`, `print`, `simulate` and `score`, as users of pysindy know them."""

    if TYPE_CHECKING:

        def _own_score(self) -> float:
            """The score on the trials it was found from."""

    def equations(self, precision: int | None = None) -> list[str]:
        """The equation in one line, each number with the digits that its error allows, or ``precision`` decimals; those
        of hidden states after a semicolon each.

        >>> import undertow
        >>> run = undertow.simulate({"stiffness": 400.0, "viscous_damping": 2.0}, x0=0.1, mass_kg=4.0, duration_s=6.0)
        >>> found = undertow.fit(run.recorded(noise_m=1e-3), ["stiffness", "viscous_damping"], mass_kg=4.0)
        >>> found.print()
        4 x'' + 400.05 x + 2.001 v = 0
        """
        must_be_decimals(precision)
        if precision is None:
            return [self.equation.text(self._errors())]
        step = 10.0 ** (1 - precision)  # an error is shown with two digits
        return [self.equation.text({"mass": step, **{term.name: step for term in self.equation.terms}})]

    def print(self, precision: int | None = None) -> None:
        """Print `equations`, one a line."""
        print(*self.equations(precision), sep="\n")

    def coefficients(self) -> NDArray[np.float64]:
        """The coefficients of the equation's terms (1, n_terms), in the order of `get_feature_names`."""
        return np.array([self.equation.coefficients])

    def get_feature_names(self) -> list[str]:
        """Names of the equation's terms."""
        return [term.name for term in self.equation.terms]

    def get_feature_names_out(self, input_features: object = None) -> NDArray[np.object_]:
        """The same as an array, as scikit-learn asks for them."""
        return np.array(self.get_feature_names(), dtype=object)

    def simulate(
        self, x0: ArrayLike, t: ArrayLike | None = None, *, v0: float | None = None, duration_s: float | None = None,
        rate_hz: float | None = None,
    ) -> Simulation:  # fmt: skip
        """The motion from ``x0`` (m, rad) at the instants ``t`` (n,) in s from 0; see `undertow.simulate`.

        ``x0`` may be the state [x0, v0], as pysindy writes it. Raises UndertowError where it is anything else.
        """
        begun, speed = start_state(x0, v0)
        return simulate(self.equation, begun, t, v0=speed, duration_s=duration_s, rate_hz=rate_hz)

    def free_runs(self, trials: Any) -> tuple[FreeRun, ...]:
        """The equation run free on each trial, given as `undertow.read` takes them: only x0, clock and rest
        position are adjusted to it."""
        return equation_runs(self.equation, every_trial(trials))

    def score(
        self, trials: Any = None, *, t: ArrayLike | Sequence[ArrayLike] | None = None, columns: Columns | None = None,
        units: Units | None = None,
    ) -> float:  # fmt: skip
        """1 less the mean free-run error (RMS over RMS displacement) of ``trials``, which are all that `undertow.read`
        takes; of its own trials where none are given. 1 is a perfect prediction of the whole decay."""
        if trials is None:
            return self._own_score()
        return mean_score(self.free_runs(every_trial(trials, columns, units, t=t)))


class FoundNumbers(FoundEquation):
    """An equation whose numbers have errors: `estimates` as a table, their intervals, their draws, free runs with a
    band."""

    if TYPE_CHECKING:
        @property
        def estimates(self) -> dict[str, Estimate]:
            """Every number with its errors."""

        def posterior(self, draws: int = 1000, seed: int = 0) -> Draws:
            """Draws of the numbers."""

    @property
    def parameters(self) -> pd.DataFrame:
        """One row a parameter: value, stderr, low and high of its 90 % interval, unit, note."""
        return parameter_table(self.estimates)

    def confidence_interval(self, level: float = INTERVAL_LEVEL) -> pd.DataFrame:
        """Columns low and high, one row a parameter."""
        return parameter_table(self.estimates, level)[["low", "high"]]

    def predict(self, trials: Any = None, **settings: Any) -> Prediction:
        """The equation run free on trials or from ``x0``, with a 90 % band; see `undertow.predict`."""
        return predict(self, trials, **settings)

    def plot_corner(self, draws: int = 1000, seed: int = 0) -> Any:
        """Pair plot of the numbers' draws: their widths and what moves together; returns the Axes."""
        return draw_pairs(self.posterior(draws, seed).values, {name: e.unit for name, e in self.estimates.items()})

    def to_arviz(self, draws: int = 250, seed: int = 0, chains: int = 4) -> Any:
        """The draws as ArviZ's InferenceData (the extra ``arviz``), ``chains`` times ``draws`` of them."""
        return to_arviz(self, draws, seed, chains)


def every_trial(
    source: Any, columns: Columns | None = None, units: Units | None = None, *,
    t: ArrayLike | Sequence[ArrayLike] | None = None, **reading: Unpack[ReadSettings],
) -> Trials:  # fmt: skip
    """What `read` makes of ``source``; RecordingError where one of its trials cannot be used: of results in order, one
    each, those behind it would belong to others. `Trials` say themselves what is not among them."""
    found = read(source, columns, units, t=t, **reading)
    if found.failed and not isinstance(source, Trials):
        raise RecordingError(
            f"{len(found.failed)} of {len(found) + len(found.failed)} trials cannot be used: {found.failed[0].reason}; "
            "leave it out, or give undertow.read(...), which says what is not among its trials"
        )
    return found


@contextmanager
def beside_what_was_fitted(trials: Trials, own: Trials) -> Iterator[None]:
    """Within the block an equation is run free on ``trials``: where it has no bounds, and one of them is released from
    far beyond what was fitted (``own``), IdentificationError says so."""
    try:
        yield
    except IdentificationError as error:
        fitted = max(motion.amplitude for motion in own)
        widest = max(trials, key=lambda motion: motion.amplitude)
        if widest.amplitude < FAR * fitted:
            raise
        unit = widest.recording.unit("displacement")
        raise IdentificationError(
            f"trial {widest.name} is released from {widest.amplitude:.3g} {unit}, {widest.amplitude / fitted:.0f} "
            f"times the largest that was fitted ({fitted:.3g} {unit}), and there the equation's motion leaves every "
            "bound: look at the unit of its displacement"
        ) from error


def mean_score(runs: Sequence[FreeRun]) -> float:
    """1 less the mean error of free runs."""
    return 1.0 - float(np.mean([run.nrmse for run in runs]))


def must_be_decimals(precision: Any) -> None:
    """UndertowError where ``precision`` is neither None nor a number of decimals."""
    if precision is not None and (not isinstance(precision, Integral) or precision < 0):
        raise UndertowError(f"precision is {shown(precision)}; give how many decimals, 0 or more, as 3")


def start_state(x0: ArrayLike, v0: float | None) -> tuple[float, float]:
    """x0 and v0 from a number and ``v0`` (0 where it is None), or from a state [x0, v0].

    >>> start_state([0.1, 0.2], None), start_state(0.1, None)
    ((0.1, 0.2), (0.1, 0.0))
    """
    state = real_numbers(x0, "x0").ravel()
    if state.size == 1:
        return float(state[0]), 0.0 if v0 is None else float(v0)
    if state.size != STATES:
        raise UndertowError(f"x0 has {state.size} numbers; give the displacement, or [displacement, velocity]")
    if v0 is not None:
        raise UndertowError(f"x0 is {state.tolist()} and v0 {v0:g}, two velocities; give one of the two")
    return float(state[0]), float(state[1])
