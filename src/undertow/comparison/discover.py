"""`Discovery`: the structure of an equation of motion as a scikit-learn estimator.

Belongs here: settings, fitted attributes, prediction and score. Does not belong here: the finding (structure.py), the
words (structure_report.py).
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral, Real
from typing import Any, Self, cast

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator
from sklearn.exceptions import NotFittedError as UnfittedEstimator

from undertow.comparison.beliefs import Belief
from undertow.comparison.driven_search import DrivenFound, discover_driven
from undertow.comparison.stepwise_selection import Rules
from undertow.comparison.structure import Effort, FoundStructure, find_structure
from undertow.comparison.structure_report import Outside, as_html, as_text, equation_text
from undertow.conditioning.condition import condition
from undertow.conditioning.driven_records import Inputs, Records, Times, UnitsSaid, driven_records
from undertow.conditioning.motion import Motion
from undertow.equation import registry
from undertow.equation.driven_laws import find_driven
from undertow.equation.equation import Equation
from undertow.equation.term import Term
from undertow.errors import IdentificationError, NotFittedError, shown
from undertow.likelihood.driven import DrivenLaws
from undertow.likelihood.free_run import FreeRun, equation_runs
from undertow.methods.library import label
from undertow.quantities import Estimate, Hold
from undertow.recording.recording import Recording

Array = NDArray[np.float64]
Trial = Recording | Motion


class NotDiscoveredError(NotFittedError, UnfittedEstimator):  # type: ignore[misc]
    """A result was asked of a `Discovery` that has not been fitted; scikit-learn's own error too."""


class Discovery(BaseEstimator):  # type: ignore[misc]
    """Which terms of a library move a body, and their coefficients over its mass, from several free decays.

        x'' + sum_i theta_i force_i(x, v) = 0,    theta_i = coefficient_i / mass

    All subsets of the library are searched exactly; what is compared is the misfit of simulated trajectories to the
    recorded samples (docs/structure.md). Nobody chooses a threshold.

    The settings are those of `undertow.Discover`, which says of each what it is.

    Attributes
    ----------
    structure_ : the `FoundStructure` with everything found.
    equation_ : `Equation` per unit mass.
    terms_, coefficients_ : terms kept and their coefficients over mass (SI over kg).
    estimates_ : name -> Estimate with standard error, inner parameters as ``term.inner``.
    inclusion_ : name -> share of resamples that keep it.
    rivals_ : subsets that the data hardly tell from the best.
    outside_ : what that search says, an `Outside`; None where it was not asked for.
    n_trials_in_ : number of trials.

    Raises
    ------
    IdentificationError
        Unknown names, no trials, terms that cannot be simulated, a library none of whose subsets moves as the body.
    NotDiscoveredError
        Where a result is asked for before ``fit``.

    >>> Discovery(known=("stiffness",), resamples=0)
    Discovery(known=('stiffness',), resamples=0)
    """

    def __init__(
        self,
        terms: Sequence[str | Term] | None = None,
        known: Sequence[str] = (),
        together: Sequence[Sequence[str]] = (),
        exclusive: Sequence[Sequence[str]] = (),
        signs: bool = True,
        beliefs: Sequence[Belief] = (),
        scatter: Mapping[str, float] | None = None,
        rival_difference: float = 6.0,
        resamples: int = 100,
        outside: bool = True,
        second_route: bool = True,
        random_state: int = 0,
    ) -> None:
        self.terms = terms
        self.known = known
        self.together = together
        self.exclusive = exclusive
        self.signs = signs
        self.beliefs = beliefs
        self.scatter = scatter
        self.rival_difference = rival_difference
        self.resamples = resamples
        self.outside = outside
        self.second_route = second_route
        self.random_state = random_state

    def set_params(self, **params: Any) -> Self:
        """Set parameters by name, as scikit-learn does. Raises IdentificationError where one has no such name."""
        valid = self._get_param_names()
        for name, value in params.items():
            if name not in valid:
                near = difflib.get_close_matches(name, valid, n=1)
                raise IdentificationError(
                    f"{name} is set to {value!r}, but {type(self).__name__} has no parameter {name!r}"
                    f"{f' (did you mean {near[0]!r}?)' if near else ''}; it has {', '.join(valid)}"
                )
        found: Self = super().set_params(**params)
        return found

    def fit(
        self,
        trials: Sequence[Trial] | Array,
        y: object = None,
        *,
        t: Times | None = None,
        u: Inputs | None = None,
        hold: Hold = "first",
        units: UnitsSaid | None = None,
    ) -> Discovery:
        """Find the equation of ``trials``, recordings or conditioned motions; ``y`` is there for scikit-learn alone.

        With ``u`` (n,) the body is driven: ``trials`` is then its displacement (n,), ``t`` the times (n,) s or the
        step, ``hold`` what u is between samples, or lists of these, with None as u of a decay; ``units`` are those of
        x, t and u where they are not SI. The search begins with
        ``known`` (stiffness and viscous damping where that is empty) and adds laws of the library; the result is
        ``driven_`` (driven_search.py), not ``structure_``.
        """
        self._must_be_numbers()
        for name in ("driven_", "driven_trials_", "structure_", "outside_", "n_trials_in_"):
            self.__dict__.pop(name, None)
        if u is not None:
            self.driven_: DrivenFound = self._fit_driven(cast(Records, trials), t, u, hold, units)
            return self
        trials = cast(Sequence[Trial], trials)
        library = self._library()
        names = [label(term) if sum(o.name == term.name for o in library) > 1 else term.name for term in library]
        rules = Rules(
            known=self._places("known", self.known, names),
            together=tuple(self._places("together", group, names) for group in self.together),
            exclusive=tuple(self._places("exclusive", group, names) for group in self.exclusive),
            signs=self.signs,
            rival_difference=self.rival_difference,
            beliefs=tuple(self.beliefs),
        )
        effort = Effort(self.resamples, self.second_route, self.random_state)
        self.structure_: FoundStructure = find_structure(motions_of(trials), library, rules, self.scatter, effort)
        self.n_trials_in_ = len(trials)
        self.outside_: Outside | None = self._searched_outside() if self.outside else None
        return self

    def _searched_outside(self) -> Outside | None:
        """What the equation found leaves out; None here, where no campaign's course stands behind the estimator."""
        return None

    @property
    def adequate_(self) -> bool | None:
        """Whether nothing that matters is missing in the equation found; None where that is not known."""
        self._fitted()
        return None if self.outside_ is None else self.outside_.adequate

    def _fit_driven(
        self, x: Records, t: Times | None, u: Inputs, hold: Hold, units: UnitsSaid | None
    ) -> DrivenFound:
        """The search on driven records, decays beside them or not; IdentificationError without times."""
        if t is None:
            samples = sum(map(np.size, x)) if isinstance(x, list | tuple) else np.size(cast(Any, x))
            raise IdentificationError(f"u has {samples} samples but t is None; give the times, or the step in s")
        trials = self.driven_trials_ = driven_records(x, t, u, hold, units=units)
        begin = tuple(self.known) or ("stiffness", "viscous_damping")
        library = [term.name for term in self._library() if term.name not in begin]
        suspects = None if self.terms is None else library
        return discover_driven(trials, DrivenLaws(tuple(find_driven(name) for name in begin)), suspects)

    def _library(self) -> tuple[Term, ...]:
        given = registry.TEN_TERMS if self.terms is None else self.terms
        listed = isinstance(given, Iterable) and not isinstance(given, str)
        library: tuple[Any, ...] = tuple(given) if listed else (given,)
        library = tuple(registry.find(term) if listed and isinstance(term, str) else term for term in library)
        for term in library:
            if not isinstance(term, Term):
                raise IdentificationError(
                    f"terms holds {shown(term)}, of type {type(term).__name__}; give names of laws, as in "
                    "['stiffness', 'cubic_stiffness'], or Term objects of such laws"
                )
        if doubled := registry.twice(library):
            raise IdentificationError(f"terms names {doubled!r} twice; take one of them out, or rename your own")
        return tuple(term for term in library if not term.is_inertia)

    def _must_be_numbers(self) -> None:
        """IdentificationError where a setting is no number, or one that its rule does not allow."""
        if not (isinstance(self.rival_difference, Real) and self.rival_difference >= 0.0):
            raise IdentificationError(
                f"rival_difference is {self.rival_difference!r}; give a difference of the criterion, 0 or more, as 6.0"
            )
        if not (isinstance(self.resamples, Integral) and self.resamples >= 0):
            raise IdentificationError(
                f"resamples is {self.resamples!r}; give how many resamples are drawn, 0 or more, as 100"
            )

    @staticmethod
    def _places(setting: str, wanted: Sequence[str], names: Sequence[str]) -> tuple[int, ...]:
        if isinstance(wanted, str):
            raise IdentificationError(f"{setting} is the text {wanted!r}; give a sequence of names, e.g. ({wanted!r},)")
        for name in wanted:
            if name not in names:
                raise IdentificationError(f"{setting} names {name!r}, which is not in the library {', '.join(names)}")
        return tuple(names.index(name) for name in wanted)

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "structure_") or hasattr(self, "driven_")

    def _fitted(self) -> FoundStructure:
        if hasattr(self, "driven_"):
            raise NotDiscoveredError(
                f"this {type(self).__name__} was fitted to a driven body (u was given), which has no subsets of a "
                "library; it has equations(), parameters, driven_.added, driven_.validation, and predict and score "
                "with t and u"
            )
        if not self.__sklearn_is_fitted__():
            raise NotDiscoveredError(f"this {type(self).__name__} has seen 0 trials; call fit(trials) first")
        return self.structure_

    @property
    def equation_(self) -> Equation:
        """The equation per unit mass."""
        return self._fitted().equation

    @property
    def terms_(self) -> tuple[Term, ...]:
        """The terms kept, inner parameters refined."""
        return self._fitted().terms

    @property
    def coefficients_(self) -> Array:
        """Coefficients over mass (n_terms,), in each term's unit over kg."""
        return self._fitted().coefficients

    @property
    def estimates_(self) -> Mapping[str, Estimate]:
        """Every number with its standard error, by term name (``term.inner`` for inner parameters)."""
        return self._fitted().numbers

    @property
    def inclusion_(self) -> Mapping[str, float]:
        """Share of block resamples whose best subset holds each term of the library."""
        return self._fitted().inclusion

    @property
    def rivals_(self) -> tuple[tuple[str, ...], ...]:
        """Terms of the subsets that the data hardly tell from the best."""
        return tuple(rival.terms for rival in self._fitted().rivals)

    def free_runs(self, trials: Sequence[Trial]) -> tuple[FreeRun, ...]:
        """The equation run from each trial's release, its x0, clock and rest position fitted to the trial."""
        return equation_runs(self._fitted().equation, motions_of(trials))

    def predict(self, trials: Sequence[Trial]) -> list[Array]:
        """Displacement from rest (m) of each trial's free run at every sample of its motion window, (n_i,) each."""
        return [run.simulated for run in self.free_runs(trials)]

    def score(self, trials: Sequence[Trial], y: object = None) -> float:
        """1 less the mean free-run error of ``trials``, best trials that ``fit`` has not seen.

        The error is RMS over RMS displacement in the motion window: 1 is a perfect prediction of the whole decay, 0 no
        better than a body that stays at rest.
        """
        return 1.0 - float(np.mean([run.nrmse for run in self.free_runs(trials)]))

    def equations(self) -> list[str]:
        """The equation in one line, each number with the digits that its error allows."""
        return [equation_text(self._fitted())]

    def fit_report(self, trials: Sequence[Trial] = ()) -> str:
        """Everything found as text: doubts first; free-run errors of ``trials`` where some are given."""
        structure = self._fitted()
        motions = motions_of(trials) if trials else []
        runs = self.free_runs(motions) if motions else ()
        errors = [(motion.name, run.nrmse) for motion, run in zip(motions, runs, strict=True)]
        return as_text(structure, errors, self.outside_)

    def _html_repr(self) -> str:
        if hasattr(self, "structure_"):
            return as_html(self.structure_, self.outside_)
        unfitted: str = super()._html_repr()
        return unfitted


def motions_of(trials: Sequence[Trial]) -> list[Motion]:
    """Trials as conditioned motions; recordings are conditioned. IdentificationError for anything else, or none."""
    if isinstance(trials, (Recording, Motion)) or not len(trials):
        what = type(trials).__name__ if isinstance(trials, (Recording, Motion)) else "0 trials"
        raise IdentificationError(f"trials is {what}; give a list of recordings or motions")
    motions = []
    for trial in trials:
        if isinstance(trial, Motion):
            motions.append(trial)
        elif isinstance(trial, Recording):
            motions.append(condition(trial))
        else:
            raise IdentificationError(f"a trial is of type {type(trial).__name__}; give Recording or Motion objects")
    return motions
