"""Words of what can be missing, and the test that would show it plainly.

A law says its own in its class, an effect that is no law in its record among the suspects. Belongs here: looking them
up. Does not belong here: sentences (sentence.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from undertow.comparison.suspect import DRIFT
from undertow.comparison.suspects import SUSPECTS
from undertow.discrepancy.words import spelled
from undertow.equation.registry import row
from undertow.likelihood.group import Coefficient

FOUND_ELSEWHERE: Mapping[str, str] = {
    "clipping": "a sensor cut off at the end of its range", "unknown": "something that nobody knows",
    "rest_offset": "a rest position that is not where the sensor says zero",
    "support_compliance": "a support of the springs that gives way",
}  # fmt: skip
"""Words of what a verdict can name, or call not testable, without a search for it."""


DESCRIBE = ("This law describes", "These laws describe")
"""What is said of the laws that are named, of one and of several."""

_OF_THE_STRUCTURE: Mapping[str, str] = {"k": "stiffness", "c": "viscous damping", "mu": "friction"}


def in_words(name: str, of_water: bool = True, alone: bool = False) -> str:
    """An effect in words. Where no water was taken away nobody knows that the water does it (not ``of_water``); a pair
    of files ``alone`` has neither dry trials nor water.

    >>> in_words("hidden_resonator", of_water=False)
    'something that was not recorded and oscillates by itself'
    """
    said = FOUND_ELSEWHERE.get(name, "") or next((s.words for s in SUSPECTS if s.name == name), "")
    law = row(name)
    if law is not None:
        said = law.words
        if not of_water or alone:
            said = law.words_unplaced or said
        if alone:
            said = law.words_alone or said
    return said or spelled(name)


def number_words(name: str, coefficients: Iterable[Coefficient] = ()) -> str:
    """A number of an equation that a fit found, a spring's or a mean of dry trials, by the law that has it.

    >>> number_words("mu_mean@short"), number_words("exponent@short")
    ('friction', 'exponent')
    """
    number = name.partition("@")[0]
    law = next((c.term for c in coefficients if c.name == number), "")
    return spelled(law) or _OF_THE_STRUCTURE.get(number.removesuffix("_mean"), spelled(number))


def other_sets(names: Sequence[str], sets: Iterable[Sequence[str]]) -> tuple[tuple[str, ...], ...]:
    """Sets that say something else than ``names``, each once, with each of its names once: what dry trials cannot tell
    apart may stand beside the very law that water shows.

    >>> other_sets(["sine", "cubic"], [["cubic", "cubic"], ["cubic", "sine"], ["cubic"]])
    (('cubic',),)
    """
    return tuple(dict.fromkeys(tuple(dict.fromkeys(one)) for one in sets if set(one) != set(names)))


def next_test(name: str) -> str:
    """The test that would show an effect plainly; empty where none is known."""
    law = row(name)
    return law.next_test if law is not None else next((s.next_test for s in SUSPECTS if s.name == name), "")


def causes_words(names: Iterable[str]) -> str:
    """What of the physics moves by the laws that are named, in words: a law is found, not what obeys it.

    >>> causes_words(["hidden_resonator"])
    ' This law describes water that sloshes, a load that swings or another mode of the body alike.'
    """
    laws = [law for law in map(row, dict.fromkeys(names)) if law is not None and law.causes]
    said = [f"{law.causes} ({spelled(law.name)})" if len(laws) > 1 else law.causes for law in laws]
    return f" {DESCRIBE[len(said) > 1]} {' and '.join(said)} alike." if said else ""


def drifts(names: Iterable[str]) -> bool:
    """Whether a displacement sensor that drifts is among what is named: free runs are then measured without its drift.

    >>> drifts(["linear_damping", "sensor_drift"]), drifts(["gain_error"])
    (True, False)
    """
    return not {s.name for s in SUSPECTS if s.frees == DRIFT}.isdisjoint(names)


def deciding_test(names: Sequence[str], rivals: Iterable[Sequence[str]]) -> str:
    """The test that would show the first name plainly; of rivals those that tell apart what they differ in.

    >>> deciding_test(["linear_damping"], [["relaxation"]]).partition("; and ")[2]
    'the same releases on another spring: memory depends on frequency, damping does not'
    """
    sets = [names, *rivals]
    apart = [n for n in dict.fromkeys(name for one in sets for name in one) if not all(n in one for one in sets)]
    tests = dict.fromkeys(test for name in apart or names[:1] if (test := next_test(name)))
    return "; and ".join([*tests][:2])
