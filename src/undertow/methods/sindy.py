"""The equation of motion by sparse regression: which terms, and their coefficients over the total mass.

    a + sum_i theta_i force_i(x, v) + constant of the trial = 0,    theta_i = coefficient_i / M

on the smoothed x, v, a of several trials together. Anchors and the laboratory's parameters are scale.py's business.

Belongs here: the regression, its covariance, the fixed and the selected form. Does not belong here: columns
(library.py), the search (subset.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.conditioning.motion import Motion
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Fit
from undertow.likelihood.noise import autocovariance, effective_samples, score_matrix
from undertow.methods.library import Design, build_design, label, motion_period
from undertow.methods.subset import BestSubset, project_out
from undertow.quantities import OK, Estimate
from undertow.uncertainty.robust import robust_covariance

Array = NDArray[np.float64]

MEMORY_PERIODS = 2.0
"""Residuals are taken as correlated over up to so many periods of the motion."""

SELECTION_PERIODS = 0.125
"""Length of the test functions by which terms are distinguished: short, so that harmonics speak too."""

ESTIMATION_PERIODS = (0.125, 0.25, 0.5)
"""Lengths of which that with the coefficients' smallest generalised variance is taken: noisy x asks for short ones."""

TEST_FUNCTIONS_PER_WINDOW = 4.0
"""The shortest window must hold so many test functions on end for a length to be tried."""

COLLINEAR_CORRELATION = 0.98
"""Two coefficients correlated more than this are told to the reader as hardly separable."""


@dataclass(frozen=True)
class SindyResult:
    """An equation over the total mass.

    ``names`` (p,) terms kept, ``coefficients`` (p,) theta in SI units over kg, ``covariance`` (p, p) statistical, with
    the residual's autocorrelation and the scatter between trials. ``constants`` (n_trials,) in m/s^2. ``terms`` are the
    terms kept; ``fit`` the same as a `Fit` named 'sindy', coefficients per mass.
    """

    names: tuple[str, ...]
    coefficients: Array
    covariance: Array
    constants: Array
    n_effective: float
    terms: tuple[Term, ...]
    fit: Fit


def discover(
    motions: Sequence[Motion], terms: Sequence[Term], known: Sequence[Term | str] = (), subset: bool = True
) -> SindyResult:
    """The equation of several trials together, a constant for each of them.

    ``terms`` is the library. With ``subset`` the best subset by BIC with effective samples is taken, ``known`` terms
    always in it; without, all of them (report Eq. 15). A term whose coefficient cannot be negative (drag, friction,
    viscous damping) is not selected with a negative one. `AddedMass` is part of the total mass and
    left out.

    Standard errors come from the residual (Newey and West 1987 over one period of the motion). From three trials on
    they are widened by what the trials scatter beyond it, and then as Student's t says for so few trials.

    Raises IdentificationError without trials or terms, for a known term that is not in ``terms``, and where the search
    leaves nothing.
    """
    library = tuple(term for term in terms if not term.is_inertia)
    names = tuple(label(term) for term in library)
    if not library:
        raise IdentificationError(f"{len(terms)} terms besides the mass; give at least one, e.g. Stiffness()")
    forced = [_place(entry, names) for entry in known]
    kept = tuple(range(len(library)))
    if subset:
        design = build_design(motions, library, SELECTION_PERIODS)
        kept = select_terms(design, library, forced).searches_[0].best.columns
        if not kept:
            raise IdentificationError(
                f"the best of all subsets of {', '.join(names)} is none of them; the motion is not explained by any: "
                "look at the window and the noise"
            )
    terms_kept = tuple(library[index] for index in kept)
    solutions = [solve_design(build_design(motions, terms_kept, periods)) for periods in _fitting_lengths(motions)]
    best = min(solutions, key=lambda solution: solution.generalised_variance)
    return _report(best, terms_kept)


def _place(entry: Term | str, names: tuple[str, ...]) -> int:
    name = entry if isinstance(entry, str) else label(entry)
    if name not in names:
        raise IdentificationError(f"known term {name!r} is not in the library {', '.join(names)}; add it to terms")
    return names.index(name)


def select_terms(design: Design, library: Sequence[Term], forced: Sequence[int] = (), signs: bool = True) -> BestSubset:
    """The best subset of a design's columns, constants and drifts of the trials as nuisance, as a fitted optimiser.

    ``library`` are the terms of the columns in their order, ``forced`` the indices of those known to be there; with
    ``signs`` a coefficient that cannot be negative is not, unless it is forced.
    """
    stacked = np.hstack([design.columns, design.nuisance])
    count = len(library)
    limits = {
        index: 1 for index, term in enumerate(library) if term.coefficient.lower >= 0.0 and index not in forced
    }
    optimizer = BestSubset(
        forced=tuple(forced),
        nuisance=tuple(range(count, stacked.shape[1])),
        signs=limits if signs else None,
        trial_lengths=design.lengths,
        memory=_memory(design),
    )
    optimizer.fit(stacked, design.response[:, None])
    return optimizer


def _fitting_lengths(motions: Sequence[Motion]) -> tuple[float, ...]:
    """Lengths of test functions, in periods, that the shortest window has room for; the shortest one always."""
    shortest = min(motion.windowed("t")[-1] - motion.windowed("t")[0] for motion in motions)
    most = shortest / float(np.median([motion_period(motion) for motion in motions])) / TEST_FUNCTIONS_PER_WINDOW
    return tuple(length for length in ESTIMATION_PERIODS if length <= max(most, ESTIMATION_PERIODS[0]))


def _memory(design: Design) -> int:
    """Rows over which the residual may be correlated."""
    return max(2, round(MEMORY_PERIODS * design.period_s / design.step_s))


@dataclass(frozen=True)
class LeastSquares:
    """Least squares of one design.

    ``values`` (p + r,) coefficients of terms, then of drifts; ``within`` (p, p) covariance of the terms' from the
    residual; ``widening`` (p,) by how much trials scatter beyond it; ``residual`` (n,) in m/s^2.
    """

    design: Design
    values: Array
    within: Array
    widening: Array
    residual: Array
    n_effective: float

    @property
    def generalised_variance(self) -> float:
        """Logarithm of the determinant of the coefficients' covariance."""
        return float(np.linalg.slogdet(self.within)[1])


def solve_design(design: Design) -> LeastSquares:
    """Least squares with drifts as nuisance.

    The variance of a coefficient is the larger of two estimates: moving sums of the scores (Newey and West 1987), and
    the residual's autocovariance seen through the columns. Each alone is on the small side for a few short trials.
    Raises IdentificationError where two terms are the same force along these motions.
    """
    stacked = np.hstack([design.columns, design.nuisance])
    found, _, rank, _ = np.linalg.lstsq(stacked, design.response, rcond=None)
    if rank < stacked.shape[1]:
        raise IdentificationError(
            f"{', '.join(design.names)} with {design.nuisance.shape[1]} constants and drifts have rank {rank} of "
            f"{stacked.shape[1]}; two of the terms are the same force along this motion: leave one out"
        )
    values: Array = np.asarray(found, dtype=np.float64)
    columns = project_out(design.nuisance, design.columns)
    residual = design.response - stacked @ values
    parts = [design.trial == index for index in range(len(design.trials))]
    moving, widening = robust_covariance(
        [columns[part] for part in parts], [residual[part] for part in parts], _memory(design), design.nuisance.shape[1]
    )
    noise = autocovariance(residual, design.lengths, _memory(design))
    scores = score_matrix(columns, noise, design.lengths)
    n_effective = effective_samples(columns, scores, max(float(noise[0]), np.finfo(float).tiny))
    bread = np.linalg.inv(columns.T @ columns)
    freedom = n_effective / max(n_effective - stacked.shape[1], 1.0)
    seen = np.diag(bread @ scores @ bread) * freedom
    stretch = np.sqrt(np.maximum(seen / np.diag(moving), 1.0))
    return LeastSquares(design, values, moving * np.outer(stretch, stretch), widening, residual, n_effective)


def _report(solution: LeastSquares, terms: tuple[Term, ...]) -> SindyResult:
    """The solution in words, units and standard errors."""
    design, count = solution.design, len(terms)
    covariance = solution.within * np.outer(solution.widening, solution.widening)
    values, errors = solution.values[:count], np.sqrt(np.diag(covariance))
    return SindyResult(
        names=design.names,
        coefficients=values,
        covariance=covariance,
        constants=solution.values[count : count + len(design.trials)],
        n_effective=solution.n_effective,
        terms=terms,
        fit=Fit(
            "sindy",
            design.trials,
            per_mass=_estimates(terms, design.names, values, errors),
            notes=_notes(design.names, covariance),
        ),
    )


def _estimates(
    terms: Sequence[Term], names: Sequence[str], values: Array, errors: Array
) -> dict[str, Estimate]:
    estimates = {}
    for term, name, value, error in zip(terms, names, values, errors, strict=True):
        outcome = OK
        if abs(value) < 2.0 * error:
            outcome = f"not distinct from 0: {value:.3g} with a standard error of {error:.2g}"
        elif term.coefficient.lower >= 0.0 and value < 0.0:
            outcome = f"{value:.3g} is below 0, which {term.name} cannot be: something else is missing or not separable"
        unit = f"{term.coefficient.unit} / kg"
        estimates[name] = Estimate(float(value), float(error), unit=unit, source="sindy", outcome=outcome)
    return estimates


def _notes(names: Sequence[str], covariance: Array) -> tuple[str, ...]:
    """Which pairs of coefficients the data hardly tell apart."""
    errors = np.sqrt(np.diag(covariance))
    notes = []
    for one in range(len(names)):
        for other in range(one):
            correlation = covariance[one, other] / (errors[one] * errors[other])
            if abs(correlation) > COLLINEAR_CORRELATION:
                notes.append(
                    f"{names[other]} and {names[one]} are hardly distinguishable by these trials (correlation of their "
                    f"coefficients {correlation:.3f})"
                )
    return tuple(notes)


