"""`Discover` as a user calls it: with Trials, tables, paths, recordings, or X with t as pysindy's users write them.

Belongs here: what `fit` may be given, tables, figures and hand-over of what it found. Does not belong here: the finding
(comparison/discover.py).
"""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from copy import deepcopy
from inspect import signature
from typing import Any, Self, Unpack, cast

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from undertow.campaign.driven.run import sentence_of
from undertow.comparison.discover import Discovery as Estimator
from undertow.comparison.structure_report import Outside
from undertow.conditioning.driven_records import Inputs
from undertow.conditioning.motion import Motion
from undertow.equation.equation import Equation
from undertow.equation.general import place_of, placed_equation, placed_terms
from undertow.equation.registry import catalogue
from undertow.errors import IdentificationError, RecordingError, UndertowError
from undertow.front.columns import Columns, Units
from undertow.front.diagnosing import diagnose
from undertow.front.discover_settings import must_be_settings, no_setting, with_names
from undertow.front.driving import Driven, must_be_displacements
from undertow.front.found_equation import FoundEquation, beside_what_was_fitted, every_trial, mean_score
from undertow.front.in_memory import are_arrays, one_clock
from undertow.front.known import ReadSettings
from undertow.front.prediction import Prediction, normal_thetas, predict, scatter_of
from undertow.front.reading import read
from undertow.front.tables import parameter_table
from undertow.front.to_arviz import to_arviz
from undertow.front.trials import Trials, in_pythons_words
from undertow.likelihood.free_run import FreeRun
from undertow.quantities import Hold
from undertow.recording.recording import Array
from undertow.report.trial_curves import (
    Axes,
    curve_of,
    draw_intervals,
    draw_pairs,
    draw_run,
    draw_run_residual,
    new_axes,
    noise_of_curve,
)
from undertow.uncertainty.confidence import INTERVAL_LEVEL, half_width
from undertow.uncertainty.posterior import Draws
from undertow.uncertainty.seeds import random_numbers

SCATTERED = {law.name: law.structural for law in catalogue() if law.structural}
"""What a campaign calls the coefficients that differ from trial to trial."""

OF_A_TABLE = ("rate_hz", "coordinate", "accept", "variable")
"""What `read` is told of every table, and not of a trial by its name or place."""

ADEQUATE = {"nothing_missing": True, "present_but_small": True, "cannot_tell": None}
"""What a verdict says of an equation; any other says that it is not adequate."""


class Discover(FoundEquation, Estimator):
    """Which terms of a library move a body, and their coefficients over its mass, from several free decays.

        x'' + sum_i theta_i force_i(x, v) = 0,    theta_i = coefficient_i / mass

    All subsets of the library are searched exactly; what is compared is the misfit of simulated trajectories to the
    recorded samples (docs/structure.md). Nobody chooses a threshold.

    Parameters
    ----------
    terms : names of the registry's forces of x and v (`undertow terms`), or their Term objects; None takes ten: x, v,
        sgn v, v|v|, x^2, x^3, x|x|, v^3, xv, x^2 v. A law of your own stands beside them where it is a formula of
        numpy's functions; one with memory is refused.
    known : names of terms that are certainly there.
    together : groups of names that enter all or none.
    exclusive : groups of names of which at most one enters.
    signs : whether a coefficient that cannot be negative (drag, friction, damping, stiffness) is kept from it.
    beliefs : what is known of coefficients beforehand (`undertow.comparison.beliefs.Belief`).
    scatter : term name -> relative standard deviation from trial to trial; None takes the trials as equal.
    rival_difference : subsets within this difference of the criterion are rivals; 6 is odds of 20 to 1. A larger subset
        takes the place of a smaller that it does not contain only beyond it.
    resamples : block resamples for the inclusion probabilities; 0 leaves them out.
    outside : whether what the equation found leaves out is searched for, as `undertow.diagnose` does on all the trials
        as one group; ``adequate_`` and ``outside_`` say what came of it. It takes longer than the rest.
    second_route : whether the coefficients are found a second time in weak form.
    random_state : seed of the resampling.

    Attributes
    ----------
    equation_, terms_, coefficients_, estimates_, inclusion_, rivals_, structure_, n_trials_in_ as the estimator's;
    ``trials_`` the `Trials` it was fitted to, ``failed_`` those that could not be used; ``adequate_`` whether nothing
    that matters is missing (None where these trials cannot tell), ``outside_`` with the sentence. Of a driven body
    (``fit`` with ``u``) ``driven_`` (what was added, both equations, errors on unseen samples), ``parameters``,
    `equations`, and `predict` and `score` with u.

    ``fit`` raises as `undertow.read`, and IdentificationError where a name is unknown, a term cannot be simulated or no
    subset of the library moves as the body.

    >>> import undertow
    >>> law = {"stiffness": 100.0, "viscous_damping": 0.5, "quadratic_drag": 2.0}
    >>> runs = [undertow.simulate(law, x0=x0, rate_hz=100.0, duration_s=8.0) for x0 in (0.05, 0.2)]
    >>> found = undertow.Discover(terms=["stiffness", "viscous_damping", "quadratic_drag", "cubic_stiffness"],
    ...                           resamples=0, outside=False, second_route=False)
    >>> X, t = [run.x * 1000.0 for run in runs], [run.t for run in runs]
    >>> found.fit(X, t=t, units={"x": "mm"}).get_feature_names_out().tolist()
    ['stiffness', 'viscous_damping', 'quadratic_drag']
    """

    __signature__ = signature(Estimator)

    def __new__(cls, *given: Any, **settings: Any) -> Self:
        """A new one; TypeError for a setting that it has not, with the nearest that it has."""
        known = list(signature(cls).parameters)
        if strange := [name for name in settings if name not in known]:
            raise TypeError(no_setting(cls.__name__, strange[0], known))
        made: Self = super().__new__(cls)
        return made

    @in_pythons_words
    def fit(
        self,
        trials: Any,
        y: object = None,
        *,
        t: ArrayLike | Sequence[ArrayLike] | None = None,
        u: Inputs | None = None,
        hold: Hold = "first",
        columns: Columns | None = None,
        units: Units | None = None,
        **reading: Unpack[ReadSettings],
    ) -> Discover:
        """Find the equation of ``trials``: anything that `undertow.read` takes, or X with ``t`` and ``units``; and what
        else it takes, as ``rate_hz=100.0``.

        ``y`` is there for scikit-learn alone. Raises as `undertow.read`, and IdentificationError where no subset of the
        library moves as the body.

        With ``u`` (n,) the body is driven, as pysindy's users write it: ``trials`` is then its displacement (n,), with
        its velocity beside it or not, ``t`` the times or the step (s), ``hold`` what u is between samples. Several
        records of the body are lists of these, with None as u of a decay, which nothing drives; ``units`` are those of
        x, t and u, as ``{"x": "mm", "u": "kN"}``, SI where they are not said. The
        search begins with ``known`` and gives ``driven_``: what was added, both equations, errors on unseen samples.
        """
        self.__dict__.pop("trials_", None)
        must_be_settings(self)
        if u is not None:
            for name, value in {"columns": columns, **reading}.items():
                if value is not None:
                    raise RecordingError(f"{name} is {value!r}, but with u x is an array; give x, t and u as arrays")
            must_be_displacements(trials, t)
            super().fit(trials, t=t, u=u, hold=hold, units=units)
            return self
        if strange := [name for name in reading if name not in ReadSettings.__annotations__]:
            takes = ", ".join(("t", "u", "hold", "columns", "units", *ReadSettings.__annotations__))
            raise RecordingError(f"{strange[0]} is no argument of fit; it takes {takes}")
        try:
            self.trials_: Trials = read(trials, columns, units, t=t, **reading)
        except RecordingError as error:
            if y is None or t is not None:
                raise
            raise RecordingError(
                f"the second argument is y, which stands there for scikit-learn and is not read: give times or a step "
                f"by name, as in t=0.01; without them {error}"
            ) from error
        kept = {name: value for name, value in reading.items() if name in OF_A_TABLE}
        self.failed_, self._given = self.trials_.failed, {"columns": columns, "units": units, "t": t, **kept}
        self._doubts = self.trials_.doubts
        try:
            super().fit(self.trials_)
        except IdentificationError as error:
            raise IdentificationError(with_names(str(error), self._library())) from error
        return self

    def _searched_outside(self) -> Outside:
        """The verdict of `diagnose` on the equation found: one comparison stands behind both."""
        scatter = {SCATTERED[name]: share for name, share in (self.scatter or {}).items() if name in SCATTERED}
        try:
            said = diagnose(self.trials_, self.terms_, group_by=(), scatter=scatter or None, seed=self.random_state)
        except UndertowError as error:
            sentence = f"what it leaves out could not be searched for: {error}"
            return Outside("cannot_tell", (), None, sentence)
        found = said[0]
        beside = [f"Doubt: {one}." for one in said.doubts if one.partition(": ")[2] not in found.sentence]
        sentence = " ".join([found.sentence, *beside])
        return Outside(found.status, found.names, ADEQUATE.get(found.status, False), sentence)

    @property
    def equation(self) -> Equation:
        """The equation found, per unit mass."""
        return self.equation_

    def _errors(self) -> Mapping[str, float]:
        return {term.name: self.estimates_[term.name].total_stderr for term in self.terms_}

    @property
    def parameters(self) -> pd.DataFrame:
        """One row a number: value over the mass (of a driven body itself), stderr, low and high of its 90 % interval,
        unit, note."""
        return parameter_table(self._driven().numbers if hasattr(self, "driven_") else self.estimates_)

    def _driven(self) -> Driven:
        """The driven equation with what was added; IdentificationError where no body was driven."""
        if not hasattr(self, "driven_"):
            raise IdentificationError(f"u is given, but this {type(self).__name__} was fitted without; leave u out")
        return Driven(self.driven_.best, self.driven_trials_)

    def _as_fitted(self, trials: Any, **said: Any) -> dict[str, Any]:
        """How trials that are not read yet are to be read: as ``said``, else as those that ``fit`` was given; of
        several arrays the times too, where these were one step or one axis.

        Raises RecordingError where each trial of ``fit`` had times of its own.
        """
        self._fitted()
        if said.get("columns") or said.get("units") or isinstance(trials, Trials):
            return said
        given = {**self._given}
        if said.get("t") is None and given["t"] is not None and are_arrays(trials):
            given["t"] = one_clock(given["t"])
        else:
            given["t"] = said.get("t")
        return given

    def equations(self, precision: int | None = None) -> list[str]:
        """The equation over the mass in one line, each number with the digits that its error allows, or ``precision``
        decimals."""
        if hasattr(self, "driven_"):
            return self._driven().equations(precision)
        return Estimator.equations(self) if precision is None else super().equations(precision)

    def simulate(
        self, x0: ArrayLike, t: ArrayLike | None = None, u: ArrayLike | None = None, *, v0: float | None = None,
        duration_s: float | None = None, rate_hz: float | None = None,
    ) -> Any:  # fmt: skip
        """The motion from ``x0`` (m, rad), or from the state [x0, v0], at the instants ``t``; see `undertow.simulate`.
        Of a driven body its displacement (n,) under the input ``u``; see `Driven.simulate`."""
        if u is not None:
            return self._driven().simulate(x0, cast(ArrayLike, t), u, v0=v0)
        return super().simulate(x0, t, v0=v0, duration_s=duration_s, rate_hz=rate_hz)

    def confidence_interval(self, level: float = INTERVAL_LEVEL) -> pd.DataFrame:
        """Columns low and high, one row a number."""
        return parameter_table(self.estimates_, level)[["low", "high"]]

    def free_runs(self, trials: Any) -> tuple[FreeRun, ...]:
        """Each trial's free run with x0, clock and rest position fitted to it."""
        given = every_trial(trials, **self._as_fitted(trials))
        with beside_what_was_fitted(given, getattr(self, "trials_", given)):
            return Estimator.free_runs(self, given)

    def predict(
        self, trials: Any, *, t: ArrayLike | Sequence[ArrayLike] | None = None, columns: Columns | None = None,
        units: Units | None = None, u: ArrayLike | None = None,
    ) -> list[Array]:  # fmt: skip
        """Displacement from rest (m) of each trial's free run at every sample of its motion window, (n_i,) each;
        ``trials`` as ``fit`` takes them, with its columns and units where none are said. With ``u`` the driven body's
        free run over one record x, begun from its first 50 samples."""
        if u is not None:
            return [self._driven().predict(trials, t=cast(ArrayLike, t), u=u, units=units).values]  # noqa: PD011
        return super().predict(every_trial(trials, **self._as_fitted(trials, columns=columns, units=units, t=t)))

    def prediction(self, trials: Any = None, **settings: Any) -> Prediction:
        """The equation run free with a 90 % band; see `undertow.predict`."""
        return predict(self, trials, **settings)

    def score(
        self, trials: Any = None, y: object = None, *, t: ArrayLike | Sequence[ArrayLike] | None = None,
        columns: Columns | None = None, units: Units | None = None, u: ArrayLike | None = None,
    ) -> float:  # fmt: skip
        """1 less the mean free-run error of ``trials``, best trials that ``fit`` has not seen; given as ``fit`` takes
        them, its own where none are given. With ``u`` that of one driven record."""
        if u is not None or (trials is None and hasattr(self, "driven_")):
            return self._driven().score(trials, t=cast(ArrayLike, t), u=u, units=units)
        if trials is None:
            return self._own_score()
        how = self._as_fitted(trials, columns=columns, units=units, t=t)
        return mean_score(self.free_runs(every_trial(trials, **how)))

    def _own_score(self) -> float:
        return mean_score(self.free_runs(self._own_trials()))

    def fit_report(self, trials: Any = ()) -> str:
        """Everything found as text: trials that were not used and doubts first; free-run errors of ``trials`` where
        some are given."""
        report = super().fit_report(read(trials) if len(trials) else ())
        unused = [f"not used: {one.reason}" for one in self.failed_]
        doubts = [] if self.outside_ is not None else [f"! {one}" for one in self._doubts]  # it says them too
        first, *rest = report.split("\n")
        return "\n".join([*unused, first, *doubts, *rest])

    def theta_draws(self, draws: int, rng: np.random.Generator) -> tuple[Array, Mapping[str, float], str]:
        """Parameter vectors (draws, slots) as the numbers' errors and correlations spread them."""
        theta, own = placed_equation(self.equation_)[0], placed_terms(self.terms_)[1]
        terms, places = {term.name: term for term in self.terms_}, []
        for name in self.estimates_:
            term, inner = terms[name.partition(".")[0]], name.partition(".")[2]
            places.append(place_of(term, inner or term.coefficient.name, own))
        spread = normal_thetas(theta, places, [1.0] * len(places), self.structure_.covariance, draws, rng)
        return spread, *scatter_of(None)

    def plot(self, axes: Axes | None = None, trial: int | str = 0) -> Axes:
        """Measured motion and free run of one trial it was fitted to; returns the Axes."""
        motion = self._one(trial)
        return draw_run(curve_of(motion, self.free_runs(motion)[0]), new_axes() if axes is None else axes)

    def plot_residual(self, axes: Axes | None = None, trial: int | str = 0) -> Axes:
        """Measured less free run of one trial it was fitted to; returns the Axes."""
        motion = self._one(trial)
        curve = curve_of(motion, self.free_runs(motion)[0])
        return draw_run_residual(curve, new_axes() if axes is None else axes, noise_of_curve(motion))

    def posterior(self, draws: int = 1000, seed: int = 0) -> Draws:
        """Draws of the numbers from the normal distribution of their errors and correlations (Laplace, no weights)."""
        self._fitted()
        numbers = self.structure_.numbers
        centre = np.array([e.value for e in numbers.values()])
        drawn = random_numbers(seed).multivariate_normal(
            centre, self.structure_.covariance, draws, method="eigh"
        )  # fmt: skip
        return Draws(dict(zip(numbers, drawn.T, strict=True)), float(draws), draws, "ok")

    def plot_corner(self, draws: int = 1000, seed: int = 0) -> Any:
        """Pair plot of the numbers' draws: their widths and what moves together; returns the Axes."""
        found = self.posterior(draws, seed)
        return draw_pairs(found.values, {name: e.unit for name, e in self.structure_.numbers.items()})

    def to_arviz(self, draws: int = 250, seed: int = 0, chains: int = 4) -> Any:
        """The draws as ArviZ's InferenceData (the extra ``arviz``), ``chains`` times ``draws`` of them."""
        return to_arviz(self, draws, seed, chains)

    def plot_intervals(self, axes: Axes | None = None) -> Axes:
        """Every number's 90 % interval over its value; returns the Axes."""
        half = half_width(1.0)
        rows = [
            (name, e.value - half * e.total_stderr, e.value, e.value + half * e.total_stderr)
            for name, e in self.estimates_.items()
        ]
        return draw_intervals(rows, new_axes() if axes is None else axes)

    def _one(self, trial: int | str) -> Motion:
        return self._own_trials()[trial]

    def _own_trials(self) -> Trials:
        """The trials it was fitted to; IdentificationError where it was read from a file, without them."""
        self._fitted()
        if not hasattr(self, "trials_"):
            raise IdentificationError(
                f"this {type(self).__name__} was read from a file, without its {self.n_trials_in_} trials; draw "
                "prediction(trials).plot(), ask score(trials)"
            )
        return self.trials_

    def __copy__(self) -> Discover:
        """A copy with its trials, which a pickle leaves out."""
        copied = type(self)()
        copied.__dict__.update(self.__dict__)
        return copied

    def __deepcopy__(self, memo: dict[int, Any]) -> Discover:
        copied = memo[id(self)] = type(self)()
        copied.__dict__.update(deepcopy(self.__dict__, memo))
        return copied

    def __getstate__(self) -> Any:
        """What a pickle holds: settings and what was found, not the recordings."""
        return {name: value for name, value in super().__getstate__().items() if name != "trials_"}

    def _html_repr(self) -> str:
        if hasattr(self, "driven_"):
            return f"<pre>{html.escape(str(self))}</pre>"
        failed = self.failed_ if hasattr(self, "structure_") else ()
        return "".join([super()._html_repr(), *(f"<p>not used: {html.escape(one.reason)}</p>" for one in failed)])

    def __str__(self) -> str:
        if hasattr(self, "driven_"):
            first, *rest = str(self._driven()).split("\n")
            return "\n".join([sentence_of("x", self.driven_trials_, self.driven_), f"  {first}", *rest])
        return self.fit_report() if self.__sklearn_is_fitted__() else repr(self)
