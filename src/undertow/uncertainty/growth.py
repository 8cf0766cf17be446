"""Which standard errors are larger than their fit's own, by how much and why: what is kept of it, and in words.

Belongs here: that record and its sentence. Does not belong here: how errors grow (disagreement.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

TRIALS, HALVES = "trials fitted alone", "trials of small and of large amplitude"
SPRINGS, LEVELS = "groups in the same water", "groups on the same spring"
"""What differs, in words."""


WORTH_SAYING = 1.05
"""A standard error that grew by less is printed as it was: "(1)" would say so."""


@dataclass(frozen=True)
class Grown:
    """One parameter in several trials, each fitted alone: chi-squared of their values about the mean at ``freedom``
    degrees of freedom, how probable that is by chance, and how many times the joint standard error has grown; ``among``
    says what differs, in words."""

    parameter: str
    chi_squared: float
    freedom: int
    p_value: float
    grown: float
    among: str = TRIALS


def grown_words(found: Sequence[Grown]) -> tuple[str, ...]:
    """Why standard errors are larger than a fit's own, in one sentence; nothing where all agree, or differ by less than
    two digits show.

    A parameter that several methods give stands once, with the largest growth.

    >>> found = [Grown("mu", 43.2, 3, 1e-9, 123.0), Grown("k_N_per_m", 4.0, 1, 0.05, 1.52, HALVES)]
    >>> grown_words(found)[0].split(": ")[1]
    'mu (120) between trials fitted alone; k_N_per_m (1.5) between trials of small and of large amplitude'
    >>> grown_words([Grown("mu", 5.2, 3, 0.04, 1.04)])
    ()
    """
    largest: dict[tuple[str, str], float] = {}
    for one in found:
        place = (one.among, one.parameter)
        if one.grown >= WORTH_SAYING:
            largest[place] = max(one.grown, largest.get(place, 0.0))
    said = []
    for among in (TRIALS, HALVES, SPRINGS, LEVELS):
        those = [f"{name} ({float(f'{times:.2g}'):g})" for (what, name), times in largest.items() if what == among]
        said += [f"{', '.join(those)} between {among}"] if those else []
    if not said:
        return ()
    return (
        "standard errors are larger than those of the fit (by how many times, in brackets), because its numbers differ "
        f"by more than the fit's own: {'; '.join(said)}",
    )
