"""What `Discover` may be told: settings that are none, and values that a setting cannot have.

Belongs here: these checks and their sentences. Does not belong here: what the settings do (discovering.py,
comparison/discover.py).
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np

from undertow.comparison.beliefs import Belief
from undertow.equation.term import Term
from undertow.errors import IdentificationError, shown
from undertow.front.known import ReadSettings
from undertow.uncertainty.seeds import must_be_seed

PYSINDY = {"feature_library": "terms", "library": "terms", "equation": "terms", "seed": "random_state"}
"""Settings by what they are called elsewhere."""

SWITCHES = ("signs", "outside", "second_route")
"""Settings that are on or off."""


def no_setting(called: str, name: str, known: Sequence[str]) -> str:
    """That there is no such setting, and where it belongs or which was meant."""
    of_fit = ("t", "u", "hold", "columns", "units", *ReadSettings.__annotations__)
    if name in of_fit:
        return f"{called} has no setting {name!r}: say it in fit, as in {called}().fit(trials, {name}=...)"
    near = PYSINDY.get(name) or next(iter(difflib.get_close_matches(name, known, n=1)), "")
    meant = f"did you mean {near!r}? " if near else ""
    return f"{called} has no setting {name!r}; {meant}it has {', '.join(known)}"


def must_be_settings(given: Any) -> None:
    """IdentificationError where a switch is neither on nor off, a belief is none or a share of scatter no number;
    UndertowError where ``random_state`` is no seed."""
    for name in SWITCHES:
        value = getattr(given, name)
        if not isinstance(value, bool | np.bool_):
            raise IdentificationError(f"{name} is {shown(value)}; give True or False")
    listed = given.beliefs if isinstance(given.beliefs, list | tuple) else [given.beliefs]
    for one in listed:
        if not isinstance(one, Belief):
            raise IdentificationError(
                f"beliefs holds {shown(one)}, of type {type(one).__name__}; give a list of "
                'undertow.comparison.beliefs.Belief, as in [Belief({"stiffness": 1.0}, value=100.0, stderr=1.0)]'
            )
    if listed is not given.beliefs:
        raise IdentificationError("beliefs is one Belief; give a list of them, as in [belief]")
    shares = {} if given.scatter is None else given.scatter
    if not isinstance(shares, Mapping) or not all(isinstance(one, Real) for one in shares.values()):
        raise IdentificationError(f"scatter is {shown(shares)}; give shares by term, as in {{'stiffness': 0.004}}")
    must_be_seed(given.random_state, "random_state")


def with_names(sentence: str, library: Sequence[Term]) -> str:
    """A sentence of the search, which numbers columns, with the names of the terms that they are.

    >>> from undertow.equation.registry import find
    >>> with_names("forced columns [0, 1] are alike", [find("stiffness"), find("viscous_damping")])
    'known terms stiffness, viscous_damping are alike'
    """
    found = re.search(r"forced columns \[([\d, ]+)\]", sentence)
    if found is None or any(len(term.parameters) > 1 for term in library):  # such a term has several columns
        return sentence
    names = ", ".join(library[int(at)].name for at in found[1].split(","))
    return sentence.replace(found[0], f"known terms {names}").replace("force fewer", "name fewer")
