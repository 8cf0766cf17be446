"""What `fit` found: an equation with its numbers, how sure they are, and what they predict.

Belongs here: the frozen result. Does not belong here: the fit (fitting.py), draws (uncertainty/posterior.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from undertow.campaign.run.ranges import damped, out_of_range, stiffness_off
from undertow.discrepancy.words import count, percent
from undertow.equation.equation import Equation
from undertow.equation.kernel import SLOT
from undertow.errors import IdentificationError
from undertow.front.found_equation import FoundNumbers, beside_what_was_fitted, every_trial, mean_score
from undertow.front.prediction import normal_thetas, scatter_of
from undertow.front.tables import html_page, parameter_lines
from undertow.front.trials import Trials, in_arguments
from undertow.likelihood.fit import Structure
from undertow.likelihood.free_run import FreeRun, free_run
from undertow.likelihood.scale import Anchor, structural_parameters
from undertow.methods.baseline import GroupFit
from undertow.quantities import OK, Estimate
from undertow.report.trial_curves import Axes, curve_of, draw_run, draw_run_residual, new_axes, noise_of_curve
from undertow.uncertainty.confidence import INTERVAL_LEVEL
from undertow.uncertainty.hierarchy import Effect
from undertow.uncertainty.posterior import Draws, posterior_draws
from undertow.uncertainty.profile import profile

ADEQUATE = 2.0
"""Mean squared residual over the sensors' noise from which something is left in the residual."""

GREW = 3.0
"""A number within one standard error of 0 is not identified where trials that differ have made that error so many times
the fit's own."""


@dataclass(frozen=True, eq=False, repr=False)
class Fitted(FoundNumbers):
    """An equation fitted to trials by output error: all trials together, every one simulated from its release.

    ``group`` is the search's own result; ``anchor`` says what gives kilograms; ``structure`` what dry trials gave;
    ``notes`` what a reader should know before using the numbers.
    """

    trials: Trials
    group: GroupFit
    anchor: Anchor
    structure: Structure | None = None
    notes: tuple[str, ...] = ()

    @cached_property
    def equation(self) -> Equation:
        """The equation with its numbers: in kilograms and newtons, or over the mass where nothing anchors it."""
        return self.group.equation()

    def _errors(self) -> Mapping[str, float]:
        return self.group.equation_errors()

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Every number with its errors, by the contract's name; those of the dry trials beside them."""
        found = dict(self.group.estimates)
        if self.structure is not None:
            found |= structural_parameters(self.structure, self.group.model.specimen)
        return found

    @cached_property
    def runs(self) -> tuple[FreeRun, ...]:
        """The free run of every trial it was fitted to."""
        return self.free_runs(self.trials)

    def free_runs(self, trials: Any) -> tuple[FreeRun, ...]:
        """The equation run free on each trial, given as `undertow.read` takes them: only x0, clock and rest position
        are adjusted to it."""
        group, model = self.group, self.group.model
        trials = every_trial(trials)
        own_k = [m.name if m.name in model.stiffness else "" for m in trials]
        with beside_what_was_fitted(trials, self.trials):
            return tuple(
                free_run(m, model.theta(group.values, name), self._rest(m), laws=model.laws)
                for m, name in zip(trials, own_k, strict=True)
            )

    def _rest(self, motion: Any) -> float:
        """Half width within which friction lets the body rest, m, or the rest position's own error."""
        theta = self.group.model.theta(self.group.values)
        k, held = float(theta[SLOT["k1"]]), max(float(theta[SLOT["fc"]]), 0.0)
        return float(np.hypot(held / k if k > 0.0 else 0.0, motion.equilibrium.total_stderr))

    def _own_score(self) -> float:
        return mean_score(self.runs)

    def theta_draws(
        self, draws: int, rng: np.random.Generator
    ) -> tuple[NDArray[np.float64], Mapping[str, float], str]:
        """Parameter vectors (draws, slots) as the numbers' errors spread them, the scatter from trial to trial, and
        where that comes from in words: what a band of `predict` is made of."""
        model, size = self.group.model, len(self.group.model.coefficients)
        inner = self.group.solution.covariance[:size, :size]
        root = np.sqrt(np.maximum(np.diag(inner), np.finfo(float).tiny))
        errors = np.array([np.nan_to_num(self.group.estimates[c.name].total_stderr) for c in model.coefficients])
        covariance = inner / np.outer(root, root) * np.outer(errors, errors)
        places, factors = [model.place(c.slot) for c in model.coefficients], [c.factor for c in model.coefficients]
        thetas = normal_thetas(model.theta(self.group.values), places, factors, covariance, draws, rng)
        return thetas, *scatter_of(self.structure)

    def confidence_interval(
        self, level: float = INTERVAL_LEVEL, method: Literal["normal", "profile"] = "normal"
    ) -> pd.DataFrame:
        """Columns low and high, one row a parameter.

        "normal": value plus and minus its standard error's multiple, with what was held fixed; "profile": as far as
        the likelihood allows with all others fitted anew (noise alone), right where the misfit is no parabola.
        """
        if method == "profile":
            ends = {c.name: profile(self.group.solution, c.name, level) for c in self.group.model.coefficients}
            rows: Mapping[str, Sequence[float]] = {name: (p.lower, p.upper) for name, p in ends.items()}
            return pd.DataFrame.from_dict(rows, orient="index", columns=["low", "high"]).rename_axis("parameter")
        if method != "normal":
            raise IdentificationError(f"method is {method!r}; an interval is 'normal' or 'profile'")
        return super().confidence_interval(level)

    def posterior(self, draws: int = 1000, seed: int = 0) -> Draws:
        """Draws of the parameters given the trials: of the Laplace approximation, weighed by the true likelihood."""
        effects = []
        if self.structure is not None:
            effects = [Effect(symbol, self.structure.scatter_freedom) for symbol in ("k", "c", "mu")]
        names = [c.name for c in self.group.model.coefficients]
        return posterior_draws(self.group.solution, draws, seed, effects, names)

    def plot(self, axes: Axes | None = None, trial: int | str = 0) -> Axes:
        """Measured motion and free run of one trial; returns the Axes."""
        motion, run = self._one(trial)
        return draw_run(curve_of(motion, run), new_axes() if axes is None else axes)

    def plot_residual(self, axes: Axes | None = None, trial: int | str = 0) -> Axes:
        """Measured less free run of one trial, with the sensor's noise in grey; returns the Axes."""
        motion, run = self._one(trial)
        return draw_run_residual(curve_of(motion, run), new_axes() if axes is None else axes, noise_of_curve(motion))

    def _one(self, trial: int | str) -> tuple[Any, FreeRun]:
        at = self.trials.names.index(self.trials[trial].name)
        return self.trials[at], self.runs[at]

    @property
    def doubts(self) -> tuple[str, ...]:
        """What a reader must know first: of the trials, a search that failed, a bound, a residual beyond noise."""
        said = [*(f"not used: {one.reason}" for one in self.trials.failed), *self.trials.doubts]
        said += [] if self.group.outcome == OK else [self.group.outcome]
        solution = self.group.solution
        left = solution.chi2 / max(solution.n_data, 1)
        if left > ADEQUATE:
            said.append(
                f"what is left is {np.sqrt(left):.2g} times the sensors' noise: the equation lacks something, or "
                "trials differ; undertow.diagnose says which"
            )
        lost = [
            f"{name} (together {e.value:.3g}, error {e.total_stderr:.2g} {e.unit})"
            for name, e in self.group.estimates.items()
            if name in solution.problem.names and abs(e.value) < e.total_stderr
            and e.total_stderr > GREW * solution.stderr(name)
        ]  # fmt: skip
        if lost:
            said.append(
                f"not identified from these trials, of which each alone gives another number: {'; '.join(lost)}; a law "
                "of another form may be behind it"
            )
        return (*said, *self._of_numbers(), *self.anchor.doubts)

    def _of_numbers(self) -> list[str]:
        """Numbers that no body has, or that are others than stated: the doubts of `undertow.diagnose`."""
        numbers, specimen = self.estimates, self.group.model.specimen
        spring = None if self.structure is None else self.structure.k
        said = out_of_range(numbers, specimen, self.trials.motions)
        said += [stiffness_off(spring or numbers.get("k_N_per_m"), specimen), damped(numbers)]
        return [in_arguments(text) for text in said if text]

    @property
    def summary(self) -> str:
        """What was found, in one sentence."""
        error = 1.0 - self.score()
        return (
            f"output error on {count(len(self.trials), 'trial')} together: the free run misses {percent(error)} of the "
            f"motion; {self.anchor.sentence}"
        )

    def __repr__(self) -> str:
        lines = [self.summary, f"  {self.equation.text(self._errors())}"]
        lines += [f"! {one}" for one in self.doubts]
        lines += parameter_lines(self.estimates)
        return "\n".join([*lines, *(f"- {one}" for one in self.notes)])

    def _repr_html_(self) -> str:
        return html_page(self.summary, self.equation.text(self._errors()), self.doubts, self.parameters, self.notes)
