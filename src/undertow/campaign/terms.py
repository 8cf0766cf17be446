"""The registry in words, for whoever asks which laws there are.

Belongs here: their text. Does not belong here: the laws (equation/).
"""

from __future__ import annotations

from collections.abc import Sequence

from undertow.equation.registry import catalogue, find
from undertow.equation.term import Term


def describe_terms(names: Sequence[str] = ()) -> str:
    """Terms in the registry (all where ``names`` is empty): law, parameters with units, source, a residual without it.

    Raises ConfigError for a name that is not in the registry, with the nearest one.

    >>> print(describe_terms(["stiffness"]))
    stiffness
      law        k x
      parameters k_N_per_m [N/m]
      source     Hooke; report Eq. 1
      left out   nothing oscillates without it
    """
    asked = [type(find(name)) for name in names] or catalogue()
    return "\n".join(_described(term) for term in asked)


def _described(term: type[Term]) -> str:
    units = ", ".join(f"{p.name} [{p.unit}]" for p in term.parameters)
    return (
        f"{term.name}\n  law        {term.law}\n  parameters {units}\n  source     {term.source}\n"
        f"  left out   {term.left_out}"
    )
