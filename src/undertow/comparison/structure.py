"""The equation of motion that a group of trials asks for: its terms, its numbers, and everything said against it.

    forces along the smoothed motion -> a first subset -> simulated trajectories -> the subset

Belongs here: the order of work and the frozen result. Does not belong here: the work
(stepwise_selection.py, inclusion.py, adequacy.py, collinearity.py, weak_form.py), the scikit-learn face (discover.py),
words (structure_report.py).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from undertow.comparison.inclusion import inclusion
from undertow.comparison.laws import laws
from undertow.comparison.polish import taken_up
from undertow.comparison.stepwise_selection import MEMORY_CELLS, Rules, Selected, walk
from undertow.comparison.trajectories import in_cells
from undertow.conditioning.motion import Motion
from undertow.equation.equation import Equation
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood.noise import autocovariance, score_matrix
from undertow.methods.library import build_design, evaluate, label
from undertow.methods.sindy import SELECTION_PERIODS, select_terms
from undertow.methods.weak_form import Route, second_route
from undertow.quantities import LARGEST_SCATTER, OK, Estimate
from undertow.uncertainty.collinearity import Collinearity, collinearity
from undertow.uncertainty.robust import scatter_factor

Array = NDArray[np.float64]


LEAST_KEPT = 0.25
"""Of white noise a fit leaves at least so much where its numbers are seen: less is no residual to tell noise from."""


@dataclass(frozen=True)
class RivalSubset:
    """Another subset that the data hardly tell from the best: its terms and how much worse its criterion is."""

    terms: tuple[str, ...]
    difference: float


@dataclass(frozen=True, eq=False)
class FoundStructure:
    """An equation over the total mass, and what was considered besides.

    ``terms`` are those kept, inner parameters refined; ``numbers`` their coefficients (units over kg) and, as
    ``term.inner``, their inner parameters, each an Estimate; ``covariance`` (p, p) in the order of ``numbers``.
    ``considered`` names the whole library, ``evidence`` and ``inclusion`` speak of it: by how much the criterion rises
    without a term (negative: falls), and how often resampled blocks keep it (empty where not asked for). ``rivals`` are
    the subsets within the uncertainty. ``route`` is the second route, None where not asked for. ``left`` is the RMS of
    what remains over noise, ``forbidden`` the terms whose coefficient would be negative and leave less, did the signs
    not keep it from that.
    """

    trials: tuple[str, ...]
    considered: tuple[str, ...]
    terms: tuple[Term, ...]
    numbers: Mapping[str, Estimate]
    covariance: Array
    evidence: Mapping[str, float]
    inclusion: Mapping[str, float]
    rivals: tuple[RivalSubset, ...]
    collinear: Collinearity
    route: Route | None
    route_outcome: str
    left: float
    found: Selected = field(repr=False)
    forbidden: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the terms kept."""
        return tuple(term.name for term in self.terms)

    @property
    def coefficients(self) -> Array:
        """Coefficients over mass of the terms kept, (n_terms,)."""
        return np.array([self.numbers[term.name].value for term in self.terms])

    @property
    def equation(self) -> Equation:
        """The equation per unit mass."""
        return Equation(self.terms, tuple(self.coefficients), mass_kg=1.0)


@dataclass(frozen=True)
class Effort:
    """What is done besides finding the equation: so many resamples (0: none), the second route."""

    resamples: int = 100
    second_route: bool = True
    seed: int = 0


def find_structure(
    motions: Sequence[Motion],
    terms: Sequence[Term],
    rules: Rules | None = None,
    scatter: Mapping[str, float] | None = None,
    effort: Effort | None = None,
) -> FoundStructure:
    """The terms of a library that several trials ask for together, with their coefficients over mass.

    ``rules`` speak of the terms by their index; `AddedMass` must not be among them, it is part of the mass. ``scatter``
    maps term names to the relative standard deviation by which a coefficient differs from trial to trial.

    Raises IdentificationError without trials or terms, for terms that cannot be simulated, and where no subset moves as
    the body did.
    """
    rules, effort = rules or Rules(), effort or Effort()
    if not motions or not terms:
        raise IdentificationError(f"{len(motions)} trials and {len(terms)} terms; give at least one of each")
    book = laws(terms, rules.signs, rules.beliefs)
    trials = [in_cells(motion, _slots(scatter or {}, terms)) for motion in motions]
    chosen, start = first_subset(motions, terms, rules)
    values = book.start.copy()
    values[list(chosen)] = start
    return _told(motions, walk(trials, book, chosen, values, rules), rules, effort)


def first_subset(motions: Sequence[Motion], terms: Sequence[Term], rules: Rules) -> tuple[tuple[int, ...], Array]:
    """Indices and coefficients of the best subset on forces along the smoothed motion: where the walk starts.

    Terms with an inner parameter are left to the walk unless they are known to be there.
    """
    offered = [i for i, term in enumerate(terms) if not term.inner or i in rules.known]
    if not offered:
        offered = list(range(len(terms)))
    design = build_design(motions, [terms[i] for i in offered], SELECTION_PERIODS)
    forced = [offered.index(i) for i in rules.known]
    optimizer = select_terms(design, [terms[i] for i in offered], forced, rules.signs)
    kept = optimizer.searches_[0].best.columns
    if not kept:
        kept = tuple(range(len(offered)))
    return tuple(offered[i] for i in kept), np.asarray(optimizer.coef_[0][list(kept)], dtype=np.float64)


def _slots(scatter: Mapping[str, float], terms: Sequence[Term]) -> dict[str, float]:
    """Places of the integrator for the terms that differ from trial to trial."""
    slots = {}
    for name, share in scatter.items():
        own = [term for term in terms if term.name == name]
        if not own or not share > 0.0:
            have = ", ".join(term.name for term in terms)
            raise IdentificationError(f"scatter of {name!r} is {share:g}; give a share above 0 of one of {have}")
        if share > LARGEST_SCATTER:
            raise IdentificationError(
                f"scatter of {name!r} is {share:g}, relative, and is {LARGEST_SCATTER:g} at most: {share:g} % is "
                f"{share / 100.0:g}"
            )
        if not own[0].slots:
            raise IdentificationError(
                f"scatter of {name!r} is {share:g}, but your own law is alike in all trials; leave it out of scatter"
            )
        slots[own[0].slots[own[0].coefficient.name]] = float(share)
    return slots


def _told(motions: Sequence[Motion], found: Selected, rules: Rules, effort: Effort) -> FoundStructure:
    """Errors, rivals, resampling and the second route around a subset."""
    terms = _refined(found)
    covariance, widening = number_covariance(found)
    rivals = _rivals(found, rules)
    alone = covariance * np.outer(widening, widening)  # were this the true subset
    total = alone + _between_rivals(found, rivals, rules)
    numbers = _estimates(found, terms, total)
    names = tuple(label(term) if _twice(term, found.book.terms) else term.name for term in found.book.terms)
    shares = inclusion(found, effort.resamples, effort.seed) if effort.resamples else ()
    count = len(terms)
    route, outcome = _route(motions, found, terms, alone[:count, :count]) if effort.second_route else (None, "")
    return FoundStructure(
        trials=tuple(motion.name for motion in motions),
        considered=names,
        terms=terms,
        numbers=numbers,
        covariance=total,
        evidence={name: found.search.evidence[i] for i, name in enumerate(names)},
        inclusion=dict(zip(names, shares, strict=False)),
        rivals=tuple(RivalSubset(tuple(names[i] for i in terms), difference) for terms, difference in rivals),
        collinear=collinearity([term.name for term in terms], alone[:count, :count], _sizes(motions, terms)),
        route=route,
        route_outcome=outcome,
        left=left_over(found),
        found=found,
        forbidden=tuple(names[i] for i in forbidden_by_signs(found)),
    )


def _twice(term: Term, terms: Sequence[Term]) -> bool:
    return sum(other.name == term.name for other in terms) > 1


def _refined(found: Selected) -> tuple[Term, ...]:
    """The terms kept, with the inner parameters at which the walk ended."""
    refined = []
    for index in found.chosen:
        term = found.book.terms[index]
        inner = {
            found.book.names[place].split(".")[1]: float(found.polished.values[place])
            for place in range(len(found.book.terms), len(found.book.names))
            if int(found.book.owner[place]) == index
        }
        refined.append(replace(term, **inner) if inner else term)
    return tuple(refined)


def number_covariance(found: Selected) -> tuple[Array, Array]:
    """Covariance (p, p) of the numbers kept, coefficients first, and the factor (p,) by which trials scatter beyond.

    From the autocovariance of what each trial leaves where it is fitted alone, seen through the sensitivities; the
    factor is `scatter_factor`. Just where the numbers are seen such a fit takes noise up, so that its residual has less
    there: errors are wider by what white noise would have lost.
    """
    places, lengths = found.book.columns(found.chosen), found.linear.lengths
    scale = np.linalg.norm(found.linear.columns[:, places], axis=0)
    columns = found.linear.columns[:, places] / scale
    residual = found.linear.response - found.linear.columns @ found.polished.values
    bread = np.linalg.pinv(columns.T @ columns, hermitian=True)
    left, lost, owns, first, part = residual.copy(), np.zeros(MEMORY_CELLS), [], 0, 0
    for trial, taken in zip(found.trials, taken_up(found.trials, found.book, found.polished, columns), strict=True):
        own = slice(first, first + taken.shape[0])
        inside = lengths[part : part + len(trial.channels) + 1]
        left[own] -= taken @ (taken.T @ left[own])
        lost += autocovariance(taken, inside, MEMORY_CELLS) * taken.shape[0] / residual.size
        owns.append((own, inside))
        first, part = own.stop, part + len(inside)
    noise = autocovariance(left, lengths, MEMORY_CELLS)
    covariance = bread @ score_matrix(columns, noise, lengths) @ bread
    kept = 1.0 - np.diag(bread @ score_matrix(columns, lost, lengths) @ bread) / np.diag(bread)
    widening = np.ones(len(places))
    if len(owns) > 1:
        grams = [columns[own].T @ columns[own] for own, _ in owns]
        rest = [sum(grams) - gram for gram in grams]
        if all(np.linalg.cond(gram) < 1.0 / np.finfo(float).eps for gram in rest):
            scores = [score_matrix(columns[own], noise, inside) for own, inside in owns]
            widening = scatter_factor(grams, scores, [columns[own].T @ residual[own] for own, _ in owns])
    scale = scale * np.sqrt(np.clip(kept, LEAST_KEPT, 1.0))
    return covariance / np.outer(scale, scale), widening


def _estimates(found: Selected, terms: Sequence[Term], covariance: Array) -> dict[str, Estimate]:
    """Coefficients in their units over kg, then inner parameters in their own."""
    places = found.book.columns(found.chosen)
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    estimates = {}
    for place, error in zip(places, errors, strict=True):
        name, value = found.book.names[place], float(found.polished.values[place])
        term = terms[found.chosen.index(int(found.book.owner[place]))]
        if "." in name:
            unit = next(p.unit for p in term.parameters if p.name == name.split(".")[1])
        else:
            unit = f"{term.coefficient.unit} / kg"
        outcome = OK
        if value <= found.book.lower[place] or value >= found.book.upper[place]:
            outcome = f"on its bound {value:.4g} {unit}: the law does not fit these trials"
        elif abs(value) < 2.0 * error and "." not in name:
            outcome = f"not distinct from 0: {value:.3g} with a standard error of {error:.2g}"
        estimates[name] = Estimate(value, float(error), unit=unit, source="structure", outcome=outcome)
    return estimates


def _rivals(found: Selected, rules: Rules) -> list[tuple[tuple[int, ...], float]]:
    """Subsets of terms within the rival difference of the one chosen, with it, by full trajectories where simulated."""
    exact = {chosen: criterion - found.criterion for chosen, criterion in found.visited}
    candidates = {found.terms_of(one): one.criterion for one in reversed((found.search.best, *found.search.rivals))}
    own = candidates.pop(found.chosen, found.search.best.criterion)
    differences = {terms: exact.get(terms, criterion - own) for terms, criterion in candidates.items()}
    return [pair for pair in sorted(differences.items(), key=lambda pair: pair[1]) if pair[1] <= rules.rival_difference]


def _between_rivals(found: Selected, rivals: Sequence[tuple[tuple[int, ...], float]], rules: Rules) -> Array:
    """Covariance (p, p) of the numbers kept because another subset may be the true one: how far they lie in rivals that
    have them, in the linear picture, each rival by its odds; of each term more than one that it has beyond those kept
    by those of a rival once more, as in the walk."""
    places = found.book.columns(found.chosen)
    squares, weights = np.zeros((len(places), len(places))), np.ones(len(places))
    for terms, difference in rivals:
        others = [place for place in found.book.columns(terms) if place in found.offered]
        there = dict(zip(others, _least_squares(found, others), strict=True))
        away = np.array([there.get(place, found.polished.values[place]) for place in places])
        away = away - found.polished.values[places]
        further = max(len(terms) - len(found.chosen) - 1, 0)
        odds = math.exp(-0.5 * (difference + rules.rival_difference * further))
        squares += odds * np.outer(away, away)
        weights += odds * np.isin(places, others)
    return squares / np.sqrt(np.outer(weights, weights))


def _least_squares(found: Selected, places: Sequence[int]) -> Array:
    """Numbers at those places in the linear picture."""
    columns = found.linear.columns[:, list(places)]
    return np.asarray(np.linalg.lstsq(columns, found.linear.response, rcond=None)[0], dtype=np.float64)


def _sizes(motions: Sequence[Motion], terms: Sequence[Term]) -> Array:
    """Standard deviation of each term's force per unit coefficient along the motion, (n_terms,)."""
    forces = [
        evaluate(terms, motion.x - motion.equilibrium.value, motion.v, motion.a, motion.t)[motion.inside]
        for motion in motions
    ]
    return np.asarray(np.std(np.vstack(forces), axis=0), dtype=np.float64)


def _route(
    motions: Sequence[Motion], found: Selected, terms: Sequence[Term], covariance: Array
) -> tuple[Route | None, str]:
    """The second route, or why there is none."""
    clocks = {
        trial.name: float(own[trial.names.index("clock")])
        for trial, own in zip(found.trials, found.polished.own, strict=True)
        if "clock" in trial.names
    }
    values = found.polished.values[list(found.chosen)]
    try:
        route = second_route(motions, terms, values, covariance, clocks)
    except IdentificationError as reason:
        return None, f"no second route: {reason}"
    return route, route.sentence


def forbidden_by_signs(found: Selected) -> tuple[int, ...]:
    """Indices of the terms that the linear picture around the last subset would give a coefficient below their bound:
    the fewest of them, each of which lowers the criterion by more than a free number costs. (With all bounds gone at
    once terms that look alike share the coefficient of one.)"""
    places = list(found.offered)
    columns, response = found.linear.columns[:, places], found.linear.response
    lower, count = found.book.lower[places], len(found.book.terms)
    lower = np.where(np.arange(lower.size) < count, lower, -math.inf)  # inner numbers have no sign

    def cost(released: Collection[int]) -> float:
        bounds = np.where(np.isin(np.arange(lower.size), list(released)), -math.inf, lower)
        return float(2.0 * lsq_linear(columns, response, (bounds, np.full(lower.size, math.inf))).cost)

    released: list[int] = []
    kept = cost(released)
    bounded = {i for i in range(count) if math.isfinite(lower[i])}
    while bounded - {*released}:
        least, best = min((cost([*released, i]), i) for i in bounded - {*released})
        if (kept - least) / found.widening <= found.penalty:
            break
        kept = least
        released.append(best)
    return tuple(sorted(released))


def left_over(found: Selected) -> float:
    """RMS of what the best subset leaves over what the sensors' noise alone would; about 1 for a complete equation."""
    residual = found.linear.response - found.linear.columns @ found.polished.values
    total, rows, first, part = 0.0, 0, 0, 0
    for trial in found.trials:
        for seen in trial.channels:
            count = found.linear.lengths[part]
            total += seen.factor**2 * float(np.sum(residual[first : first + count] ** 2))
            rows, first, part = rows + count, first + count, part + 1
        first, part = first + found.linear.lengths[part], part + 1  # the priors' rows
    return float(np.sqrt(total / rows))
