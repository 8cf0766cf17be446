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
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.term import Term
from undertow.errors import IdentificationError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Laws:
    """A library as the integrator sees it: every number the motion may depend on, coefficients first.

    ``names`` (p,) are the coefficients (a term each), then ``term.inner`` for every inner parameter; ``slots`` (p,)
    their places in the integrator; ``owner`` (p,) the index of the term; ``lower``, ``upper`` (p,) bounds; ``beliefs``
    what is known of coefficients beforehand.
    """

    terms: tuple[Term, ...]
    names: tuple[str, ...]
    slots: NDArray[np.int64]
    owner: NDArray[np.int64]
    start: Array
    lower: Array
    upper: Array
    beliefs: tuple[Belief, ...] = ()

    def vector(self, values: Array) -> Array:
        """Parameter vector of the integrator, per unit mass, at ``values`` (p,)."""
        theta = np.zeros(N_SLOTS)
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
    """Why the compiled integrator cannot judge this library; empty where it can."""
    lost = [term.name for term in terms if term.kind != "force" or not term.slots]
    if lost:
        return f"{', '.join(lost)} {'has' if len(lost) == 1 else 'have'} no compiled force of x and v alone"
    inner: list[str] = []
    for term in terms:
        inner += [term.slots[parameter.name] for parameter in term.parameters[1:]]
        inner += [term.slots[term.coefficient.name]] if term.inner else []
    twice = sorted({slot for slot in inner if inner.count(slot) > 1})
    return f"two terms share the inner parameter {', '.join(twice)}" if twice else ""


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
    rows = [
        (term.name, term.slots[term.coefficient.name], index, 0.0,
         term.coefficient.lower if signs else -math.inf, math.inf)
        for index, term in enumerate(terms)
    ]  # fmt: skip
    for index, term in enumerate(terms):
        for parameter in term.parameters[1:]:
            rows.append(
                (f"{term.name}.{parameter.name}", term.slots[parameter.name], index, term.inner[parameter.name],
                 parameter.lower, parameter.upper)
            )  # fmt: skip
    names, slots, owner, start, lower, upper = zip(*rows, strict=True)
    return Laws(
        tuple(terms), tuple(names), np.array([SLOT[slot] for slot in slots]), np.array(owner),
        np.array(start), np.array(lower), np.array(upper), tuple(beliefs),
    )  # fmt: skip
