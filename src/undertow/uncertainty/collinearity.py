"""Which terms the trials cannot tell apart, in words and numbers.

Belongs here: what is read off a covariance of coefficients. Does not belong here: how it was estimated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SAID_CORRELATION = 0.9
"""Two coefficients correlated more than this are named: alone, each is known 2.3 times worse."""

HARD_CORRELATION = 0.98
"""Beyond this, five times worse, they are called hardly distinguishable."""

SAID_INFLATION = 25.0
"""Where the others inflate a term's variance more than this, the combination of three and more is named."""

SHARE_IN_A_COMBINATION = 0.2
"""A coefficient with at least this share of the weakest combination's length is part of its name."""


@dataclass(frozen=True)
class Collinearity:
    """What a covariance of coefficients says about telling terms apart.

    ``correlation`` (p, p) of the coefficients; ``inflation`` (p,) by how much the other terms widen each one's variance
    (1: not at all); ``weakest`` (p,) the least certain combination in units of each one's contribution, of length 1;
    ``sentences`` the same in words.
    """

    names: tuple[str, ...]
    correlation: Array
    inflation: Array
    weakest: Array
    sentences: tuple[str, ...]


def collinearity(names: Sequence[str], covariance: Array, sizes: Array) -> Collinearity:
    """Read from the coefficients' ``covariance`` (p, p) which of ``names`` (p,) the data hardly distinguish.

    ``sizes`` (p,) turn a coefficient into its share of the motion (the force's standard deviation per unit coefficient,
    m/s^2 kg per unit), so that a combination is not a matter of units.

    >>> result = collinearity(("c", "q"), np.array([[1.0, -0.99], [-0.99, 1.0]]), np.ones(2))
    >>> result.sentences[0].partition(": ")[0]
    'c and q are hardly distinguishable (correlation -0.990)'
    """
    errors = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(errors, errors)
    inflation = np.diag(np.linalg.pinv(correlation, hermitian=True))
    scaled = covariance * np.outer(sizes, sizes)
    _, vectors = np.linalg.eigh(scaled)
    weakest = vectors[:, -1] * np.sign(vectors[np.argmax(np.abs(vectors[:, -1])), -1])
    sentences = (*_pairs(names, correlation), *_combined(names, inflation, weakest))
    return Collinearity(tuple(names), correlation, inflation, weakest, sentences)


def _pairs(names: Sequence[str], correlation: Array) -> list[str]:
    said = []
    for one in range(len(names)):
        for other in range(one):
            size = float(correlation[one, other])
            if abs(size) < SAID_CORRELATION:
                continue
            how = "hardly distinguishable" if abs(size) > HARD_CORRELATION else "partly mixed"
            worse = 1.0 / np.sqrt(max(1.0 - size**2, np.finfo(float).eps))
            said.append(
                f"{names[other]} and {names[one]} are {how} (correlation {size:.3f}): alone each is known {worse:.1f} "
                "times worse than with the other held"
            )
    return said


def _combined(names: Sequence[str], inflation: Array, weakest: Array) -> list[str]:
    """The sentence for a combination of three and more terms, which pairs do not show."""
    part = [i for i in range(len(names)) if abs(weakest[i]) >= SHARE_IN_A_COMBINATION]
    worst = int(np.argmax(inflation))
    if len(part) < 3 or inflation[worst] < SAID_INFLATION:
        return []
    combination = " ".join(f"{weakest[i]:+.2f} {names[i]}" for i in part)
    return [
        f"the least certain combination is {combination} (in units of each one's force): the others widen the "
        f"standard error of {names[worst]} {np.sqrt(inflation[worst]):.1f} times"
    ]
