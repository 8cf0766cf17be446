"""How conditions, methods and parameters are called, and with which digits they are printed.

Belongs here: names, symbols and units in words. Does not belong here: tables (tables.py), pages (html.py), figures.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from undertow.quantities import OK, Estimate, format_estimate
from undertow.recording.recording import Condition

METHOD_LABELS: Mapping[str, str] = {
    "decay": "Decay envelope",
    "sindy": "SINDy",
    "method1": "Method 1",
    "method2": "Method 2",
    "method2_printed": "Method 2 as printed",
    "output_error": "Output error",
    "baseline": "Group's equation",
}
"""What the reader calls each method; a method that is not here is shown by its own name."""

METHOD_NOTES: Mapping[str, str] = {
    "decay": "the envelope of the peaks of a dry decay",
    "sindy": "regression of the measured acceleration on a library of laws, the smallest set that explains it",
    "method1": "the simulated motion closest to the measured one, by simplex search, added mass held at or above zero",
    "method2": "the force balance at the first acceleration peak and at the first zero crossing, inertia kept",
    "method2_printed": "the force balance at the zero crossing as printed, without the inertia that balances the "
    "forces there: its drag coefficient is negative on any decay, whatever the water does; shown for comparison only",
    "output_error": "the simulated motion closest to every sensor at once, by least squares weighted with the noise",
}
"""What each method does, in one line."""

REFERENCE_ORDER = ("output_error", "method1", "sindy", "method2", "decay")
"""Whose numbers stand for a group where its verdict holds none: the statistically most efficient method first."""


@dataclass(frozen=True)
class Name:
    """How a parameter is shown: in words, and its symbol in LaTeX (empty where it has none)."""

    words: str
    symbol: str = ""


_NAMES: Mapping[str, Name] = {
    "total_mass_kg": Name("total mass", "M"),
    "added_mass_kg": Name("added mass", "m_a"),
    "drag_coefficient": Name("drag coefficient", "C_d"),
    "drag_Ns2_per_m2": Name("quadratic drag", "q"),
    "k_N_per_m": Name("stiffness", "k"),
    "c_Ns_per_m": Name("viscous damping", "c"),
    "mu": Name("friction coefficient", r"\mu"),
    "force_N": Name("friction force", "F_c"),
    "friction_N": Name("friction force", "F_c"),
}
_ORDER = tuple(_NAMES)

_UNIT_SUFFIXES = {unit.lower(): unit for unit in ("m", "mm", "cm", "s", "Hz", "deg", "kg", "N", "rad")}


def parameter_name(parameter: str) -> Name:
    """Words and symbol of a parameter of the contract; an unknown one is spelled out.

    >>> parameter_name("added_mass_kg"), parameter_name("stiffness_per_mass").words
    (Name(words='added mass', symbol='m_a'), 'stiffness per mass')
    """
    if parameter in _NAMES:
        return _NAMES[parameter]
    base, separator, _ = parameter.partition("_per_mass")
    if separator and base in _NAMES:
        known = _NAMES[base]
        return Name(f"{known.words} per mass", f"{known.symbol}/M")
    return Name(parameter.replace("_", " ").replace(".", ": "))


def ordered_parameters(names: Iterable[str]) -> list[str]:
    """Names once each: masses first, then drag, then the structure's, then all others as they came.

    >>> ordered_parameters(["mu", "exponent", "added_mass_kg", "mu"])
    ['added_mass_kg', 'mu', 'exponent']
    """
    unique = list(dict.fromkeys(names))
    return sorted(unique, key=lambda name: _ORDER.index(name) if name in _ORDER else len(_ORDER))


def method_label(method: str) -> str:
    """What the reader calls a method.

    >>> method_label("method1"), method_label("my_own")
    ('Method 1', 'my own')
    """
    return METHOD_LABELS.get(method, method.replace("_", " "))


def is_as_printed(method: str) -> bool:
    """Whether a method is the report's recipe as printed, shown but never compared with the others."""
    return "printed" in method


def split_unit(column: str) -> tuple[str, str]:
    """A condition's name in words and the unit at its end, if it has one.

    >>> split_unit("water_depth_m"), split_unit("spring")
    (('water depth', 'm'), ('spring', ''))
    """
    words, _, last = column.rpartition("_")
    if words and last.lower() in _UNIT_SUFFIXES:
        return words.replace("_", " "), _UNIT_SUFFIXES[last.lower()]
    return column.replace("_", " "), ""


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


def estimate_text(estimate: Estimate, with_unit: bool = True) -> str:
    """Value and total standard error, digits as the error allows; says so where there is no error.

    >>> estimate_text(Estimate(1271.43, 12.2, 8.0, unit="kg"))
    '1271 ± 15 kg'
    >>> estimate_text(Estimate(8.1, unit="1"))
    '8.1, no error bar'
    """
    unit = estimate.unit if with_unit and estimate.unit != "1" else ""
    total = estimate.total_stderr
    if not math.isfinite(estimate.value):
        return "not found"
    if not math.isfinite(total):
        return format_estimate(replace(estimate, stderr=math.nan, systematic=0.0, unit=unit)) + ", no error bar"
    if total == 0.0:
        return format_estimate(replace(estimate, stderr=math.nan, systematic=0.0, unit=unit))
    return format_estimate(replace(estimate, stderr=total, systematic=0.0, unit=unit))


def error_parts(estimate: Estimate) -> str:
    """Where a total error comes from, when it has two sources; else empty.

    >>> error_parts(Estimate(1271.43, 12.2, 8.0, unit="kg"))
    'noise 12, held fixed 8'
    """
    if not (math.isfinite(estimate.stderr) and estimate.stderr > 0.0 and estimate.systematic > 0.0):
        return ""
    noise = format_estimate(Estimate(estimate.stderr, estimate.stderr)).split(" ± ")[0]
    fixed = format_estimate(Estimate(estimate.systematic, estimate.systematic)).split(" ± ")[0]
    return f"noise {noise}, held fixed {fixed}"


def percent(share: float) -> str:
    """A share as per cent with two digits below ten per cent, whole above; "-" where there is none.

    >>> percent(0.4012), percent(0.0436), percent(0.0031)
    ('40 %', '4.4 %', '0.31 %')
    """
    if not math.isfinite(share):
        return "-"
    value = 100.0 * share
    if value >= 10.0 or value == 0.0:
        return f"{value:.0f} %"
    return f"{value:.1f} %" if value >= 1.0 else f"{value:.2g} %"


def problem_of(estimate: Estimate) -> str:
    """What a reader must know before using an estimate: on a bound, no error bar; empty where nothing."""
    if estimate.outcome != OK:
        return estimate.outcome
    return "" if math.isfinite(estimate.total_stderr) else "no error bar"


def count(number: int, singular: str) -> str:
    """A number and its noun.

    >>> count(1, "trial"), count(4, "trial")
    ('1 trial', '4 trials')
    """
    return f"{number} {singular}" if number == 1 else f"{number} {singular}s"


def safe_anchor(text: str) -> str:
    """A text as an anchor of a page: lower case letters, digits and dashes.

    >>> safe_anchor("spring short, water depth 2.36 m")
    'spring-short-water-depth-2-36-m'
    """
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "group"
