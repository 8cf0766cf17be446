"""The registry in words, for whoever asks which laws there are.

Belongs here: their text, and that of what verdicts name beside them. Does not belong here: the laws (equation/).
"""

from __future__ import annotations

from collections.abc import Sequence

from undertow.comparison.suspects import SUSPECTS
from undertow.discrepancy.naming import FOUND_ELSEWHERE, next_test
from undertow.equation.driven_laws import DRIVEN_ALONE
from undertow.equation.registry import catalogue, find
from undertow.equation.term import Term


def describe_terms(names: Sequence[str] = ()) -> str:
    """Terms (the registry's where ``names`` is empty): law, parameters with units, source, a residual without it; what
    else a verdict can name in words, with the test that shows it.

    Raises ConfigError for a name that is neither, with the nearest one of the registry.

    >>> print(describe_terms(["stiffness"]))
    stiffness
      law        k x
      parameters k_N_per_m [N/m]
      source     Hooke; report Eq. 1
      left out   nothing oscillates without it
    """
    return "\n".join(_named(name) for name in names) if names else "\n".join(map(_described, catalogue()))


def _named(name: str) -> str:
    driven = {law.name: law for law in DRIVEN_ALONE}
    said = {**{s.name: s.words for s in SUSPECTS if s.words}, **FOUND_ELSEWHERE}
    if name not in said or name in driven:
        return _described(driven.get(name) or type(find(name)))
    lines = [name, f"  is         {said[name]}; no term of an equation, but verdicts name it"]
    return "\n".join([*lines, *([f"  shown by   {next_test(name)}"] if next_test(name) else [])])


def _described(term: type[Term]) -> str:
    units = ", ".join(f"{p.name} [{p.unit}]" for p in term.parameters)
    return (
        f"{term.name}\n  law        {term.law}\n  parameters {units}\n  source     {term.source}\n"
        f"  left out   {term.left_out}" + (f"\n  may be     {term.causes}" if term.causes else "")
    )
