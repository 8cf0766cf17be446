"""Whether any subset of a library is good enough, or a law outside it does better.

A fit is never compared with perfection: every rig leaves more than its sensors' noise. A library is called inadequate
where a law from the shelf that it does not hold is the more probable one, its further numbers paid for. Prior: one half
that the library holds the laws, the other half shared equally by the laws outside.

Belongs here: that comparison and the size of what is left. Does not belong here: naming what is missing between trials
and levels (the discrepancy room).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.laws import Laws, laws, why_not_simulated
from undertow.comparison.stepwise_selection import Found, Rules, walk_on
from undertow.equation.registry import catalogue
from undertow.equation.term import Term
from undertow.methods.library import label

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Outsider:
    """A law outside the library beside the best subset within it.

    ``gain`` is the criterion of the best subset of the library less that of the best one with the law, less
    2 ln(laws outside) for the prior: above 0 the law is the more probable one (odds exp(gain / 2)). ``chosen`` names
    that equation's terms, ``inner`` the law's refined inner parameters.
    """

    law: str
    gain: float
    chosen: tuple[str, ...]
    inner: tuple[tuple[str, float], ...]

    def __str__(self) -> str:
        inner = ", ".join(f"{name} = {value:.3g}" for name, value in self.inner)
        return f"{self.law} ({inner})" if inner else self.law


def outsiders(terms: Sequence[Term]) -> tuple[Term, ...]:
    """Laws on the shelf whose motion can be simulated beside ``terms`` and that are none of them.

    >>> from undertow.equation.structure import SineRestoring, Stiffness
    >>> [law.name for law in outsiders((Stiffness(), SineRestoring()))][:3]
    ['viscous_damping', 'coulomb_friction', 'quadratic_drag']
    """
    taken = {term.slots[term.coefficient.name] for term in terms if term.slots}
    found = []
    for law in (kind() for kind in catalogue()):
        if law.name == "added_mass" or not law.slots or law.slots[law.coefficient.name] in taken:
            continue
        if not why_not_simulated((*terms, law)):
            taken.add(law.slots[law.coefficient.name])
            found.append(law)
    return tuple(found)


def compare_outsiders(found: Found, rules: Rules) -> tuple[Outsider, ...]:
    """Every law of `outsiders` that a walk from the best subset takes in, the most probable first."""
    laws_outside = outsiders(found.book.terms)
    prior = 2.0 * math.log(max(len(laws_outside), 1))
    taken = [_with_law(found, law, rules, prior) for law in laws_outside]
    return tuple(sorted((one for one in taken if one is not None), key=lambda one: -one.gain))


def _with_law(found: Found, law: Term, rules: Rules, prior: float) -> Outsider | None:
    terms = (*found.book.terms, law)
    book = laws(terms, rules.signs, rules.beliefs)
    values = _carried(found.book, book, found.polished.values)
    start = replace(found.polished, values=values)
    larger = walk_on(found.trials, book, start, rules)
    if len(terms) - 1 not in larger.chosen:
        return None
    inner = [place for place in range(len(terms), len(book.names)) if int(book.owner[place]) == len(terms) - 1]
    return Outsider(
        label(law) if not inner else law.name,
        larger.visited[0][1] - larger.criterion - prior,
        tuple(terms[index].name for index in larger.chosen),
        tuple((book.names[place].split(".")[1], float(larger.polished.values[place])) for place in inner),
    )


def _carried(smaller: Laws, larger: Laws, values: Array) -> Array:
    """Values of the smaller library's numbers in the larger one's order; new numbers at their start."""
    carried = larger.start.copy()
    for place, name in enumerate(smaller.names):
        carried[larger.names.index(name)] = values[place]
    return carried


def left_over(found: Found) -> float:
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
