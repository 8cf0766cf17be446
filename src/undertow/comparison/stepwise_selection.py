"""From subset to subset until the motion itself asks for no other one.

At a subset the simulated motions are made linear in every coefficient of the library; the exact search says which
subset that linear picture prefers; that one is polished on the full trajectories, and so on. What is compared at the
end are misfits of full trajectories, never of their linear picture.

Belongs here: the walk, its rules, inner parameters (an exponent, a Stribeck velocity). Does not belong here:
trajectories (trajectories.py), values (polish.py), the search over subsets (exact_subsets.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.beliefs import Belief
from undertow.comparison.laws import Laws
from undertow.comparison.polish import FIRST_WINDOW_PERIODS, POOR_FIT, Linear, Polished, linearise, polish
from undertow.comparison.trajectories import Cells
from undertow.errors import IdentificationError
from undertow.methods.exact_subsets import Subset, SubsetSearch, search_subsets
from undertow.methods.subset import BestSubset

Array = NDArray[np.float64]
Kind = TypeVar("Kind")

MOST_VISITS = 8
"""Subsets polished at most; walks seen so far end after one to three."""

INNER_VALUES = 9
"""Values of an inner parameter at which a law that is not in the equation is offered; the best is then refined."""

INNER_SHARES = (0.02, 0.5)
"""Where an inner parameter has no upper bound: from and to these shares of the largest speed or displacement."""


LIGHT = 0.01
"""Damping ratio of that oscillator."""

MEMORY_CELLS = 100
"""Residuals are taken as correlated over up to so many cells: two periods of the motion."""


@dataclass(frozen=True)
class Rules:
    """What subsets are allowed, in indices of the library's terms.

    ``known`` are always in; ``together`` enter all or none; of ``exclusive`` at most one; with ``signs`` a coefficient
    that cannot be negative is not. Subsets within ``rival_difference`` of the best criterion are rivals, and a larger
    one stands in place of a smaller that it does not contain only beyond it. ``beliefs`` are what is known of
    coefficients beforehand.
    """

    known: tuple[int, ...] = ()
    together: tuple[tuple[int, ...], ...] = ()
    exclusive: tuple[tuple[int, ...], ...] = ()
    signs: bool = True
    rival_difference: float = 6.0
    beliefs: tuple[Belief, ...] = ()


@dataclass(frozen=True)
class Selected:
    """The subset at which the walk ended.

    ``offered`` (q,) are the places among the laws' numbers that ``optimizer`` judged; ``search`` speaks of these
    places' positions. ``criterion`` is the misfit of the full trajectories over ``widening`` (by how much correlation
    widens variances) plus the penalty of every free number; ``visited`` the criteria of all subsets polished.
    """

    book: Laws
    trials: tuple[Cells, ...]
    polished: Polished
    linear: Linear
    offered: tuple[int, ...]
    optimizer: BestSubset
    criterion: float
    widening: float
    penalty: float
    visited: tuple[tuple[tuple[int, ...], float], ...]

    @property
    def chosen(self) -> tuple[int, ...]:
        """Indices of the terms in the equation."""
        return self.polished.chosen

    @property
    def search(self) -> SubsetSearch:
        """The exact search around the last subset."""
        search: SubsetSearch = self.optimizer.searches_[0]
        return search

    def terms_of(self, candidate: Subset) -> tuple[int, ...]:
        """Indices of the terms of a candidate of `search`."""
        return tuple(sorted({int(self.book.owner[self.offered[column]]) for column in candidate.columns}))


@dataclass(frozen=True, eq=False)
class _Visit:
    polished: Polished
    linear: Linear
    offered: tuple[int, ...]
    optimizer: BestSubset


def walk(trials: Sequence[Cells], book: Laws, chosen: Sequence[int], values: Array, rules: Rules) -> Selected:
    """The subset of the library that the recorded motion asks for, starting from ``chosen`` at ``values`` (p,).

    Where the start leads nowhere near the motion, the walk begins on three periods and goes on to longer windows.
    Channels in which the full library leaves more than their noise are weighed down to what it leaves, once, before any
    subset is compared. Raises IdentificationError where the start's motion leaves every bound.
    """
    try:
        first = polish(trials, book, sorted({*chosen, *rules.known}), values, doubtful=True)
    except IdentificationError:
        chosen, values = _as_a_line(trials, book, rules)
        first = polish(trials, book, chosen, values, doubtful=True)
    rows = sum(seen.values.size for trial in trials for seen in trial.channels)
    if first.chi2 > POOR_FIT * rows:
        first = min(first, _grown(trials, book, first.chosen, values, rules), key=lambda fit: fit.cost)
    weighed = _reweighted(trials, linearise(trials, book, first))
    here = first if weighed == tuple(trials) else polish(weighed, book, first.chosen, first.values, first.own)
    return walk_on(weighed, book, here, rules)


def _as_a_line(trials: Sequence[Cells], book: Laws, rules: Rules) -> tuple[tuple[int, ...], Array]:
    """The linear oscillator of the motion's own period within the library: a start that always has a motion.

    IdentificationError where the library holds nothing that pulls a body back.
    """
    pulls = sorted((term.instead_of != (), at) for at, term in enumerate(book.terms) if term.is_spring)
    loses = [at for at, term in enumerate(book.terms) if term.structural == "c"]
    if not pulls:
        names = ", ".join(term.name for term in book.terms)
        raise IdentificationError(
            f"none of {names} pulls the body back as this motion asks; add stiffness to the library"
        )
    rate = 2.0 * math.pi / float(np.median([trial.period_s for trial in trials]))
    values = book.start.copy()
    spring = pulls[0][1]
    values[spring] = rate**2
    for at in loses:
        values[at] = 2.0 * LIGHT * rate
    chosen = {spring, *loses, *rules.known}
    return tuple(sorted(chosen)), values


def _grown(trials: Sequence[Cells], book: Laws, chosen: Sequence[int], values: Array, rules: Rules) -> Polished:
    """The subset and values at the end of walks on windows that grow from three periods to the whole."""
    window = FIRST_WINDOW_PERIODS * max(trial.period_s for trial in trials)
    longest = max(float(trial.t[-1, 0] - trial.t[0, 0]) for trial in trials)
    own = None
    while window < longest:
        short = [trial.shortened(window) for trial in trials]
        here = walk_on(short, book, polish(short, book, chosen, values, own), rules).polished
        chosen, values, own = here.chosen, here.values, here.own
        window *= 2.0
    return polish(trials, book, chosen, values, own)


def walk_on(trials: Sequence[Cells], book: Laws, here: Polished, rules: Rules) -> Selected:
    """`walk` from a subset that is polished already, with the trials' weights as they are."""
    visits: list[_Visit] = []
    while True:
        visit = _look_around(trials, book, here, rules)
        visits.append(visit)
        search: SubsetSearch = visit.optimizer.searches_[0]
        subset = _simplest([(set(one.columns), one.criterion, one) for one in (search.best, *search.rivals)], rules)
        places = [visit.offered[column] for column in subset.columns]
        wanted = tuple(sorted({int(book.owner[place]) for place in places}))
        if len(visits) == MOST_VISITS or any(wanted == seen.polished.chosen for seen in visits) or not wanted:
            break
        values = visit.polished.values.copy()
        values[places] = np.linalg.lstsq(visit.linear.columns[:, places], visit.linear.response, rcond=None)[0]
        start = _inside(book, _with_inner(book, visit, values), visit.polished.values)
        try:
            here = polish(trials, book, wanted, start, here.own)
        except IdentificationError:  # the linear picture led out of every motion: stay with what was seen
            break
    return _best_of(trials, book, visits, rules)


def _inside(book: Laws, values: Array, before: Array) -> Array:
    """``values`` with inner parameters that the linear picture moved out of their bounds put back."""
    count = len(book.terms)
    outside = (values[count:] < book.lower[count:]) | (values[count:] > book.upper[count:])
    values[count:] = np.where(outside, before[count:], values[count:])
    return values


def _with_inner(book: Laws, visit: _Visit, values: Array) -> Array:
    """``values`` with the inner parameters at which absent laws were offered."""
    absent = [p for p in range(len(book.terms), values.size) if int(book.owner[p]) not in visit.polished.chosen]
    values[absent] = visit.linear.at[absent]
    return values


def _best_of(trials: Sequence[Cells], book: Laws, visits: Sequence[_Visit], rules: Rules) -> Selected:
    rows = sum(seen.values.size for trial in trials for seen in trial.channels)
    allowed = [visit for visit in visits if _obeys(visit.polished.chosen, rules)]
    if not allowed:
        seen = [tuple(book.terms[index].name for index in visit.polished.chosen) for visit in visits]
        raise IdentificationError(
            f"none of the {len(visits)} subsets visited obeys the groups together {rules.together} and exclusive "
            f"{rules.exclusive}: {seen}; loosen a group"
        )
    fullest = min(visits, key=lambda visit: visit.polished.cost)
    n_effective = float(fullest.optimizer.n_effective_[0])
    widening, penalty = rows / n_effective, penalty_of(n_effective, len(book.terms))
    criteria = [
        visit.polished.cost / widening + penalty * len(book.columns(visit.polished.chosen)) for visit in visits
    ]
    best = _simplest(
        [(set(visit.polished.chosen), criteria[visits.index(visit)], visit) for visit in allowed], rules
    )
    return Selected(
        book, tuple(trials), best.polished, best.linear, best.offered, best.optimizer,
        float(criteria[visits.index(best)]), widening, penalty,
        tuple((visit.polished.chosen, value) for visit, value in zip(visits, criteria, strict=True)),
    )  # fmt: skip


def _simplest(subsets: Sequence[tuple[set[int], float, Kind]], rules: Rules) -> Kind:
    """The best of subsets with their criteria; a smaller one before it that it does not contain and that is within the
    rival difference: several terms that together take a true one's place draw more from the noise than one term does.
    """
    members, least, best = min(subsets, key=lambda one: one[1])
    smaller = [
        one for one in subsets
        if len(one[0]) < len(members) and not one[0] < members and one[1] - least <= rules.rival_difference
    ]  # fmt: skip
    return min(smaller, key=lambda one: (len(one[0]), one[1]))[2] if smaller else best


def _obeys(chosen: Sequence[int], rules: Rules) -> bool:
    inside = set(chosen)
    whole = all(len(inside & set(group)) in (0, len(set(group))) for group in rules.together)
    return whole and all(len(inside & set(group)) <= 1 for group in rules.exclusive)


def penalty_of(n_effective: float, columns: int) -> float:
    """What one more free number costs: ln(n_eff) + ln(q), the extended BIC of `search_subsets`."""
    return math.log(n_effective) + math.log(max(columns, 1))


def _reweighted(trials: Sequence[Cells], linear: Linear) -> tuple[Cells, ...]:
    """Trials whose channels' noise is at least what the whole library leaves in such channels of all trials: were each
    weighed by what it leaves itself, trials that differ would yield to the one that the mean happens to fit."""
    residual = linear.response - linear.columns @ np.linalg.lstsq(linear.columns, linear.response, rcond=None)[0]
    squares: dict[str, list[float]] = {}
    first, part = 0, 0
    for trial in trials:
        for seen in trial.channels:
            own = residual[first : first + linear.lengths[part]]
            squares.setdefault(seen.quantity, []).append(float(np.mean(own**2)))
            first, part = first + own.size, part + 1
        first, part = first + linear.lengths[part], part + 1  # the priors' rows
    factors = {quantity: max(1.0, math.sqrt(float(np.mean(own)))) for quantity, own in squares.items()}
    return tuple(trial.reweighted([factors[seen.quantity] for seen in trial.channels]) for trial in trials)


def _look_around(trials: Sequence[Cells], book: Laws, here: Polished, rules: Rules) -> _Visit:
    """The linear picture at a subset and the exact search in it."""
    count = len(book.terms)
    linear = linearise(trials, book, here)
    inner = [place for place in range(count, len(book.names)) if int(book.owner[place]) in here.chosen]
    for place in range(count, len(book.names)):
        if place not in inner:
            linear = _offered_at_its_best(trials, book, here, linear, place, [*range(count), *inner])
    offered = (*range(count), *inner)
    optimizer = BestSubset(
        forced=tuple(position for position, place in enumerate(offered) if int(book.owner[place]) in rules.known),
        signs={i: 1 for i in range(count) if book.lower[i] >= 0.0 and i not in rules.known} if rules.signs else None,
        trial_lengths=linear.lengths,
        rival_difference=rules.rival_difference,
        memory=MEMORY_CELLS,
        together=_kept_together(book, offered, rules),
        exclusive=rules.exclusive,
    )
    optimizer.fit(linear.columns[:, list(offered)], linear.response[:, None])
    return _Visit(here, linear, offered, optimizer)


def _kept_together(book: Laws, offered: Sequence[int], rules: Rules) -> tuple[tuple[int, ...], ...]:
    """Positions that enter all or none: groups of terms, and each law with its inner parameters."""
    count = len(book.terms)
    laws = [
        (int(book.owner[place]), position) for position, place in enumerate(offered) if place >= count
    ]
    return (*rules.together, *laws)


def _offered_at_its_best(
    trials: Sequence[Cells], book: Laws, here: Polished, linear: Linear, place: int, others: Sequence[int]
) -> Linear:
    """The linear picture with an absent law's column at the inner value that explains most."""
    law = int(book.owner[place])
    best, least = linear, math.inf
    for value in inner_values(trials, book, place):
        tried = linearise(trials, book, here, {place: value}, law, linear)
        columns = tried.columns[:, list(others)]
        gram, moments = columns.T @ columns, columns.T @ tried.response
        search = search_subsets(gram, moments, range(len(others)), tried.response.size, forced=(law,))
        if search.best.criterion < least:
            best, least = tried, search.best.criterion
    return best


def inner_values(trials: Sequence[Cells], book: Laws, place: int) -> Array:
    """Values (n,) at which an inner parameter is tried: evenly within its bounds, else in proportion to the motion."""
    lower, upper = float(book.lower[place]), float(book.upper[place])
    if math.isfinite(upper):
        return np.linspace(lower, upper, INNER_VALUES + 2)[1:-1]
    law = book.terms[int(book.owner[place])]
    unit = {parameter.name: parameter.unit for parameter in law.parameters}[book.names[place].split(".")[1]]
    size = max(abs(float(trial.start[0])) for trial in trials)
    if unit.endswith("/s"):
        size *= 2.0 * math.pi / float(np.median([trial.period_s for trial in trials]))
    values: Array = np.geomspace(INNER_SHARES[0] * size, INNER_SHARES[1] * size, INNER_VALUES)
    return np.maximum(values, lower)
