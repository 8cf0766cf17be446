"""How groups and shares are called in a sentence: on the page, in verdict.json and in the terminal alike.

Belongs here: conditions, shares and counts in words. Does not belong here: what is said of them (judge.py), methods and
parameters (report/wording.py).
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence

from undertow.recording.recording import Condition

_UNIT_SUFFIXES = {unit.lower(): unit for unit in ("m", "mm", "cm", "s", "Hz", "deg", "kg", "N", "rad", "rpm")} | {
    "m_s": "m/s", "m_per_s": "m/s", "mps": "m/s", "km_h": "km/h", "percent": "%", "pct": "%", "degc": "°C",
}
"""Units that a condition's name may end in, as in water_depth_m and wind_m_s."""


SAID_AT_MOST = 10.0
"""A share of the motion beyond which the number says no more: that free run has left the recording."""

SAID_AT_LEAST = 1e-6
"""Per cent under which no number is said: probabilities go to e^-1000."""


_PEOPLE: Mapping[str, str] = {
    "bouc wen": "Bouc-Wen", "coulomb": "Coulomb", "iwan": "Iwan", "lugre": "LuGre", "stribeck": "Stribeck",
    "van der pol": "van der Pol",
}  # fmt: skip
"""Names of people in laws' names, as they are written."""

_A_PERSON_S = re.compile(rf"\b(?:{'|'.join(_PEOPLE)})\b")


def with_names(text: str) -> str:
    """A text with the names of people as they are written; identifiers stay.

    >>> with_names("stribeck friction beside bouc wen and coulomb_friction")
    'Stribeck friction beside Bouc-Wen and coulomb_friction'
    """
    return _A_PERSON_S.sub(lambda found: _PEOPLE[found.group()], text)


def spelled(identifier: str) -> str:
    """A law's or an effect's identifier in words.

    >>> spelled("coulomb_friction"), spelled("linear_damping")
    ('Coulomb friction', 'linear damping')
    """
    return with_names(identifier.replace("_", " "))


_PER = r"_per_(?:rad|m|s|kg)\d?(?:_s\d)?"
UNIT_AT_END = re.compile(rf"(?<=[a-z\d])_(?:rad|Hz|kg|N|Ns|Ns2|Ns3|m|s)\d?(?:{_PER})?$|{_PER}$|_N_sp_per_mp$")
"""A unit at the end of a parameter's name: it stands beside the number instead."""


def quantity_of(parameter: str) -> str:
    """What a parameter of the contract is, without the unit in its name.

    >>> quantity_of("yield_displacement_m"), quantity_of("frequency_rad_per_s"), quantity_of("exponent")
    ('yield displacement', 'frequency', 'exponent')
    """
    return spelled(UNIT_AT_END.sub("", parameter))


def split_unit(column: str) -> tuple[str, str]:
    """A condition's name in words and the unit at its end, if it has one.

    >>> split_unit("water_depth_m"), split_unit("wind_m_s"), split_unit("spring")
    (('water depth', 'm'), ('wind', 'm/s'), ('spring', ''))
    """
    words = column.split("_")
    for first in range(1, len(words)):  # the longest ending that is a unit
        unit = _UNIT_SUFFIXES.get("_".join(words[first:]).lower())
        if unit is not None and any(words[:first]):
            return " ".join(words[:first]), unit
    return " ".join(words), ""


def condition_words(column: str, value: Condition) -> str:
    """One condition in words, with its unit.

    >>> condition_words("water_depth_m", 2.36), condition_words("spring", "short")
    ('water depth 2.36 m', 'spring short')
    """
    words, unit = split_unit(column)
    text = f"{value:g}" if isinstance(value, (int, float)) else str(value)
    return f"{words} {text} {unit}".rstrip()


def group_title(key: Mapping[str, Condition]) -> str:
    """A group's conditions in words; "all trials" where trials are not grouped.

    >>> group_title({"spring": "short", "water_depth_m": 2.36})
    'spring short, water depth 2.36 m'
    """
    return ", ".join(condition_words(column, value) for column, value in key.items()) or "all trials"


def rarely(p_value: float) -> str:
    """A small probability as a share of so many simulated ones as there are: beyond a thousand it is not counted.

    >>> rarely(0.0042), rarely(1e-6)
    ('only 0.42 %', 'fewer than one in a thousand')
    """
    return f"only {percent(p_value)}" if p_value >= 1e-3 else "fewer than one in a thousand"


def percent(share: float) -> str:
    """A share as per cent with two digits below ten per cent, whole above; "-" where there is none, and no
    number beyond `SAID_AT_MOST`.

    >>> percent(0.4012), percent(0.0436), percent(0.0031), percent(2.2e6), percent(3e-37)
    ('40 %', '4.4 %', '0.31 %', 'more than 1000 %', 'less than 0.000001 %')
    """
    if not math.isfinite(share):
        return "-"
    if share > SAID_AT_MOST:
        return f"more than {100.0 * SAID_AT_MOST:.0f} %"
    value = 100.0 * share
    if 0.0 < value < SAID_AT_LEAST:
        return f"less than {SAID_AT_LEAST:f} %"
    if value >= 10.0 or value == 0.0:
        return f"{value:.0f} %"
    return f"{value:.1f} %" if value >= 1.0 else f"{value:.2g} %"


def count(number: int, singular: str) -> str:
    """A number and its noun.

    >>> count(1, "trial"), count(4, "trial")
    ('1 trial', '4 trials')
    """
    return f"{number} {singular}" if number == 1 else f"{number} {singular}s"


def all_of(names: Sequence[str]) -> str:
    """Names that hold together.

    >>> all_of(["k"]), all_of(["k", "c"]), all_of(["k", "c", "mu"])
    ('k', 'k and c', 'k, c and mu')
    """
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def own_words(symbols: Sequence[str]) -> str:
    """Which of a structure's numbers may be each trial's own.

    >>> own_words(("k", "c")), own_words(())
    ('k and c', 'numbers')
    """
    return all_of(symbols) or "numbers"


def least_sets(sets: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """Sets of names of which the data cannot tell which: the first, and of the others, short ones first, those that
    hold no smaller one.

    What may be there beside a rival that is enough by itself is no other answer; all of them stand in verdict.json.

    >>> least_sets([["drag"], ["echo", "memory"], ["sag", "echo"], ["memory"], ["drag", "echo"]])
    [['drag'], ['memory'], ['sag', 'echo']]
    >>> least_sets([[], ["echo"]])  # where nothing is named
    [[], ['echo']]
    """
    first, *others = sets
    least = (one for one in others if not any(Counter(less) < Counter(one) for less in sets if less))
    return [first, *sorted(least, key=len)]


def either(answers: Sequence[str]) -> str:
    """Answers of which one holds, each of which may have an "and" of its own.

    >>> either(["drag"]), either(["drag", "echo"]), either(["drag", "echo", "memory and echo"])
    ('drag', 'drag or echo', 'drag, echo, or memory and echo')
    """
    if len(answers) < 3:
        return " or ".join(answers)
    return f"{', '.join(answers[:-1])}, or {answers[-1]}"
