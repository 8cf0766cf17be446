"""A library of terms as the integrator sees it: every number that a motion may depend on, and its bounds.

Belongs here: places, starts and bounds of coefficients and inner parameters. Does not belong here: the laws themselves
(the equation room), trials and sensitivities (trajectories.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.beliefs import Belief
from undertow.equation.general import place_of, placed_terms
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.term import PlacedTerm, Term
from undertow.equation.tracing import formula_of
from undertow.errors import IdentificationError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Laws:
    """A library as the integrator sees it: every number the motion may depend on, coefficients first.

    ``names`` (p,) are the coefficients (a term each), then ``term.inner`` for every inner parameter; ``slots`` (p,)
    their places in the integrator, behind its own those of laws that it does not know; ``owner`` (p,) the index of the
    term; ``lower``, ``upper`` (p,) bounds; ``beliefs`` what is known of coefficients beforehand; ``placed`` all forces
    with their places, where one is such a law.
    """

    terms: tuple[Term, ...]
    names: tuple[str, ...]
    slots: NDArray[np.int64]
    owner: NDArray[np.int64]
    start: Array
    lower: Array
    upper: Array
    beliefs: tuple[Belief, ...] = ()
    placed: tuple[PlacedTerm, ...] = ()

    def vector(self, values: Array) -> Array:
        """Parameter vector of the integrator, per unit mass, at ``values`` (p,)."""
        theta = np.zeros(max(N_SLOTS, 1 + int(self.slots.max())))
        theta[SLOT["mass"]] = 1.0
        np.add.at(theta, self.slots, values)
        return theta

    def believed(self) -> tuple[Array, Array]:
        """Beliefs as rows (b, p) and values (b,): rows @ numbers = values, each with a standard error of 1."""
        rows = np.zeros((len(self.beliefs), len(self.names)))
        for row, belief in zip(rows, self.beliefs, strict=True):
            for name, weight in belief.weights.items():
                row[self.names.index(name)] = weight / belief.stderr
        return rows, np.array([belief.value / belief.stderr for belief in self.beliefs])

    def columns(self, chosen: Sequence[int]) -> list[int]:
        """Places of the numbers that belong to the terms of these indices."""
        return [place for place, owner in enumerate(self.owner) if int(owner) in set(chosen)]


def why_not_simulated(terms: Sequence[Term]) -> str:
    """Why compiled code cannot judge this library on simulated motion; empty where it can."""
    lost = [term.name for term in terms if term.kind != "force"]
    if lost:
        return f"{', '.join(lost)} {'is' if len(lost) == 1 else 'are'} no force of x and v alone"
    own = [term for term in terms if not term.slots]
    if slow := [term.name for term in own if not _is_a_formula(term)]:
        return f"{', '.join(slow)} {'is' if len(slow) == 1 else 'are'} no formula of numpy's functions"
    inner: list[str] = []
    for term in (term for term in terms if term.slots):
        inner += [term.slots[parameter.name] for parameter in term.parameters[1:]]
        inner += [term.slots[term.coefficient.name]] if term.inner else []
    twice = sorted({slot for slot in inner if inner.count(slot) > 1})
    return f"two terms share the inner parameter {', '.join(twice)}" if twice else ""


def _is_a_formula(term: Term) -> bool:
    """Whether a law of one's own is read once and then calculated by compiled code."""
    numbers = np.array([1.0, *term.inner.values()])
    return formula_of([(term, tuple(range(numbers.size)))], numbers, 1.0, 1.0, 1.0) is not None


def laws(terms: Sequence[Term], signs: bool = True, beliefs: Sequence[Belief] = ()) -> Laws:
    """The library's numbers; with ``signs`` a coefficient that cannot be negative has the bound 0.

    Raises IdentificationError for a library that `why_not_simulated` refuses, and for a belief about a term that the
    library does not hold.
    """
    refusal = why_not_simulated(terms)
    if refusal:
        raise IdentificationError(
            f"{refusal}, so that a library with it cannot be judged on simulated motion; leave it out of the "
            f"{len(terms)} terms, and compare undertow.fit(...).score(unseen) with it and without"
        )
    have = [term.name for term in terms]
    for name in (name for belief in beliefs for name in belief.weights if name not in have):
        raise IdentificationError(f"a belief names {name!r}, which is not in the library {', '.join(have)}")
    placed, own = placed_terms(terms)
    rows = [
        (term.name, place_of(term, term.coefficient.name, own), index, 0.0,
         term.coefficient.lower if signs else -math.inf, math.inf)
        for index, term in enumerate(terms)
    ]  # fmt: skip
    for index, term in enumerate(terms):
        for parameter in term.parameters[1:]:
            rows.append(
                (f"{term.name}.{parameter.name}", place_of(term, parameter.name, own), index,
                 term.inner[parameter.name], parameter.lower, parameter.upper)
            )  # fmt: skip
    names, slots, owner, start, lower, upper = zip(*rows, strict=True)
    return Laws(
        tuple(terms), tuple(names), np.array(slots), np.array(owner),
        np.array(start), np.array(lower), np.array(upper), tuple(beliefs), placed,
    )  # fmt: skip
