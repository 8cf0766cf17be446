"""How methods and parameters are called, and with which digits they are printed.

Belongs here: names, symbols and units in words. Does not belong here: groups in words (discrepancy/words.py), tables
(tables.py), pages (html.py), figures.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from undertow.comparison.limits import LEAST_P
from undertow.discrepancy.words import UNIT_AT_END, quantity_of, spelled, with_names
from undertow.quantities import OK, Estimate, format_estimate, unit_in_rotation
from undertow.report.numbers import PLAIN_BELOW, plain_number, power_of_ten, printed_unit, with_powers_raised

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

STATUS_WORDS: Mapping[str, str] = {
    "explained": "explained with",
    "nothing_missing": "nothing missing",
    "unknown": "not explained",
    "not_identifiable": "not identifiable",
    "present_but_small": "something small",
    "cannot_tell": "cannot tell",
}
"""What the reader calls each status."""

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

_UNIT_ALONE, _OF_A_LAW = re.compile(r"(?:Ns?\d?)?"), ("friction force", "viscous damping")
"""What is left of the name of a law's only parameter, as N_per_m3; or what it is called in another law."""


def parameter_name(parameter: str) -> Name:
    """Words and symbol of a parameter of the contract; an unknown one is spelled out.

    >>> parameter_name("added_mass_kg"), parameter_name("natural_frequency_rad_per_s").words
    (Name(words='added mass', symbol='m_a'), 'natural frequency')
    >>> parameter_name("k_N_per_m_per_mass").symbol, parameter_name("sine_restoring_N_per_mass").words
    ('k/M', 'sine restoring per mass')
    """
    if parameter in _NAMES:
        return _NAMES[parameter]
    base, separator, _ = parameter.partition("_per_mass")
    if separator:
        known = parameter_name(base)
        return Name(f"{known.words} per mass", f"{known.symbol}/M" if known.symbol else "")
    return Name(quantity_of(parameter).replace(".", ": ").replace("kernel ", "waves' "))


def ordered_parameters(names: Iterable[str]) -> list[str]:
    """Names once each: masses first, then drag, then the structure's, then all others as they came.

    >>> ordered_parameters(["mu", "exponent", "added_mass_kg", "mu"])
    ['added_mass_kg', 'mu', 'exponent']
    """
    unique = list(dict.fromkeys(names))
    return sorted(unique, key=lambda name: _ORDER.index(name) if name in _ORDER else len(_ORDER))


def parameter_words(name: str) -> str:
    """A repaired equation's parameter in words, without its unit.

    >>> parameter_words("hidden_resonator#2.natural_frequency_rad_per_s"), parameter_words("added_mass_kg")
    ('hidden resonator 2: natural frequency', 'added mass')
    >>> parameter_words("constant_force.force_N"), parameter_words("asymmetric_damping.c_Ns_per_m")
    ('constant force', 'asymmetric damping')
    """
    effect, dot, parameter = name.partition(".")
    if not dot:
        return parameter_name(name).words
    law, words = spelled(effect).replace("#", " "), parameter_name(parameter).words
    return f"{law}: {words}" if words not in (law, *_OF_A_LAW) and not _UNIT_ALONE.fullmatch(words) else law


def quantity_words(effect: str, parameter: str) -> str:
    """What a number of an effect is called beside the effect's name; empty where the effect has this one alone.

    >>> quantity_words("hidden_resonator", "mass_kg"), quantity_words("cubic_stiffness", "N_per_m3")
    ('mass', '')
    """
    return parameter_words(f"{effect}.{parameter}").partition(": ")[2]


def effects_words(names: Iterable[str]) -> str:
    """Effects that are named together, several of one kind counted.

    >>> effects_words(["hidden_resonator", "linear_damping", "hidden_resonator"])
    '2 hidden resonators + linear damping'
    """
    counted = Counter(spelled(name) for name in names)
    return " + ".join(name if number == 1 else f"{number} {name}s" for name, number in counted.items())


def values_in_words(values: Mapping[str, float], beside: str = "") -> str:
    """Numbers by their names in the contract, in words with their units; empty where there are none.

    ``beside`` is the unit of the number that they belong to: that of a moment or an inertia says that an angle is the
    coordinate.

    >>> values_in_words({"frequency_rad_per_s": 5.234, "damping_ratio": 0.02})
    'frequency 5.2 rad/s, damping ratio 0.020'
    >>> values_in_words({"velocity_m_per_s": 1.55}, "N m per kg m^2")
    'velocity 1.6 rad/s'
    """
    turns = beside.startswith(("N m", "kg m^2"))

    def unit(name: str) -> str:
        """The unit at the end of a name, as it is printed."""
        said = _unit_in(name)
        return printed_unit(unit_in_rotation(said) if turns and "rad" not in said else said)

    return ", ".join(
        f"{parameter_name(name).words} {plain_number(value, 2)} {unit(name)}".strip() for name, value in values.items()
    )


def _unit_in(name: str) -> str:
    """The unit at the end of a parameter's name; empty where there is none."""
    found = UNIT_AT_END.search(name)
    return found.group()[1:].replace("_per_", "/") if found else ""


def method_label(method: str) -> str:
    """What the reader calls a method.

    >>> method_label("method1"), method_label("my_own")
    ('Method 1', 'my own')
    """
    return METHOD_LABELS.get(method, method.replace("_", " "))


_PLAIN_WORDS = ("decay", "baseline")  # words of the language too: they are methods after "by" alone
_CONTRACT_NAME = re.compile(
    rf"(?<!\bby )\b(?:{'|'.join(_PLAIN_WORDS)})\b"
    rf"|\b({'|'.join(sorted((*_NAMES, *METHOD_LABELS), key=len, reverse=True))})(_per_mass)?\b"
)
_LAW_S = re.compile(r"\b[a-z]+(?:_[a-z]+)*_Ns?\d?(?:_\w+)?\b")


def in_plain_words(text: str) -> str:
    """A note with parameters and methods as the reader calls them.

    >>> in_plain_words("added_mass_kg by output_error differs"), in_plain_words("k_N_per_m_per_mass (16)")
    ('added mass by output error differs', 'stiffness per mass (16)')
    >>> in_plain_words("exclude what is no decay; the others by decay")
    'exclude what is no decay; the others by decay envelope'
    >>> in_plain_words("stiffness (3), cubic_stiffness_N_per_m3 (1.2)")
    'stiffness (3), cubic stiffness (1.2)'
    """
    def words(found: re.Match[str]) -> str:
        name = found.group(1)
        if name is None:  # a word, and no method
            return found.group()
        if name in METHOD_LABELS:
            return METHOD_LABELS[name].lower().replace("sindy", "SINDy")
        return f"{_NAMES[name].words}{' per mass' if found.group(2) else ''}"

    return _LAW_S.sub(lambda found: parameter_name(found.group()).words, _CONTRACT_NAME.sub(words, text))


_TRIAL_S_NAME = r"(?:(?<=\btrial )|(?<=\btrials ))[\w.-]+(?:, [\w.-]*\d[\w.-]*)*"
_AS_WRITTEN = re.compile(rf"\b((?:recordings|trials|specimen|equation|discrepancy)(?:\.\w+)+|{_TRIAL_S_NAME})")
_ONE_OF_A_LAW = re.compile(r"\b([a-z]+(?:_[a-z]+)*)\.([A-Za-z]\w+)")
_IDENTIFIER = re.compile(r"\b[a-z]+(?:_[A-Za-z0-9]+)+\b")
_BARE = re.compile(r"\bNs?\d?_per_\w+\b")
_OF_ALL, _OF_SPRING = re.compile(r"@all\b"), re.compile(r"@([^\s,;=]+)")
_NO_UNIT = re.compile(r"(?<== )(\S+(?: \+- \S+)?) 1(?= )")
_SIZE_OF = re.compile(r"\b([a-z]+(?:_[A-Za-z0-9]+)+) of ([\d.e+-]+)(?= (?!rad\b))")
_EXPONENT = re.compile(r"(?<![\w.-])(-?\d+(?:\.\d+)?)e([+-]?\d+)\b")

PLAIN_ABOVE = 8
"""Power of ten from which on an estimate with its error is written with one."""


def reason_words(text: str) -> str:
    """A reason of the search for a reader: laws and parameters in words, powers raised.

    >>> reason_words("odds of 10^151 to 1 against it beside hidden_resonator + linear_damping")
    'odds of 10¹⁵¹ to 1 against it beside hidden resonator + linear damping'
    >>> reason_words("cubic_damping.Ns3_per_m3 = -3.099e+04 N s^3/m^3 would feed energy into the motion")
    'cubic damping = -30990 N s³/m³ would feed energy into the motion'
    >>> reason_words("N_per_m3 is 0.1 +- 0.2 N/m^3, within 2 standard errors of 0")
    'its coefficient is 0.1 ± 0.2 N/m³, within 2 standard errors of 0'
    >>> reason_words("c_Ns_per_m@all = -0.9 +- 0.2 N s/m"), reason_words("drag_exponent.exponent = 1.5 +- 16 1 could")
    ('viscous damping = -0.9 ± 0.2 N s/m', 'drag exponent: exponent = 1.5 ± 16 could')
    >>> reason_words("drift_m of 3.8e-06 is no more than"), reason_words("drag_exponent.exponent = 4 1 sits")
    ('drift of 3.8 × 10⁻⁶ m is no more than', 'drag exponent: exponent = 4 sits')
    >>> reason_words("drift_m of 3.8e-06 rad is no more than")
    'drift of 3.8 × 10⁻⁶ rad is no more than'
    >>> reason_words("a mass of 1e+04 kg"), reason_words("an error of (7.3e-05)")
    ('a mass of 10000 kg', 'an error of (0.000073)')
    >>> reason_words("from trial pull_03 on, beside run-2e3"), reason_words("trials a_1, b_2 of sensor_drift")
    ('from trial pull_03 on, beside run-2e3', 'trials a_1, b_2 of sensor drift')

    A key of a config and a trial's name stay as they are written there:

    >>> reason_words("cubic_damping is unsure: state specimen.mass_kg, or set trials.window")
    'cubic damping is unsure: state specimen.mass_kg, or set trials.window'
    """
    pieces = _AS_WRITTEN.split(text)
    return "".join(piece if at % 2 else _reason_words(piece) for at, piece in enumerate(pieces))


def _reason_words(text: str) -> str:
    """`reason_words` of a text without keys of a config."""
    text = _OF_SPRING.sub(r" (\1)", _OF_ALL.sub("", text))
    text = _SIZE_OF.sub(lambda found: f"{found.group()} {_unit_in(found.group(1))}".rstrip(), text)
    text = _NO_UNIT.sub(r"\1", text).replace(" +- ", " ± ")
    text = _ONE_OF_A_LAW.sub(lambda found: parameter_words(found.group()), text)
    text = _BARE.sub("its coefficient", text)
    text = _IDENTIFIER.sub(lambda found: parameter_name(found.group()).words, in_plain_words(text))
    text = _EXPONENT.sub(lambda found: plain_number(float(found.group()), len(re.sub(r"\D", "", found[1]))), text)
    return with_names(with_powers_raised(text))


def rejected_words(name: str, because: str) -> str:
    """Why a law is not the answer, beside its name.

    >>> rejected_words("relaxation", "relaxation.time_s = 1.008 s sits on its bound")
    'time = 1.008 s sits on its bound'
    """
    return reason_words(because).removeprefix(f"{spelled(name)}: ")


def sentence_words(sentence: str, title: str) -> str:
    """A group's sentence as `reason_words` has a reason; the group's own ``title`` stays as it is.

    >>> sentence_words("spring very_soft: unknown, because drag_exponent.exponent is 2", "spring very_soft")
    'spring very_soft: unknown, because drag exponent: exponent is 2'
    """
    start = f"{title}: " if sentence.startswith(f"{title}: ") else ""
    return start + reason_words(sentence.removeprefix(start))


_UNIT_BEHIND = re.compile(r"(?<=\d) (?=[^\W\d_]\w{0,3}(?:[,;:)]|$))")
"""The space between a number and a unit that ends a condition."""


def unbroken(title: str) -> str:
    """A title in which no line ends between a number and its unit.

    >>> unbroken("spring long, water depth 2.36 m")
    'spring long, water depth 2.36\\xa0m'
    """
    return _UNIT_BEHIND.sub("\u00a0", title)


def is_as_printed(method: str) -> bool:
    """Whether a method is the report's recipe as printed, shown but never compared with the others."""
    return "printed" in method


def estimate_text(estimate: Estimate, with_unit: bool = True) -> str:
    """Value and total standard error, digits as the error allows; says so where there is no error.

    >>> estimate_text(Estimate(1271.43, 12.2, 8.0, unit="kg"))
    '1271 ± 15 kg'
    >>> estimate_text(Estimate(8.1, unit="1"))
    '8.1, no error bar'
    >>> estimate_text(Estimate(2.4513e10, 3e7, unit="kg m^2")), estimate_text(Estimate(5.3754e-6, 6e-10, unit="kg"))
    ('(2.451 ± 0.003) × 10¹⁰ kg m²', '(5.3754 ± 0.0006) × 10⁻⁶ kg')
    >>> estimate_text(Estimate(-2.5e9, unit="N/m"))
    '-2.5 × 10⁹ N/m, no error bar'
    """
    unit = printed_unit(estimate.unit) if with_unit else ""
    total = estimate.total_stderr
    if power := _power_apart(estimate.value, total):
        text, comma, said = estimate_text(estimate.scaled(10.0**-power, "1")).partition(",")
        number = f"{f'({text})' if '±' in text else text} × {power_of_ten(power)} {unit}".rstrip()
        return number + comma + said
    if not math.isfinite(estimate.value):
        return "not found"
    if not math.isfinite(total):
        return format_estimate(replace(estimate, stderr=math.nan, systematic=0.0, unit=unit)) + ", no error bar"
    if total == 0.0:
        return format_estimate(replace(estimate, stderr=math.nan, systematic=0.0, unit=unit))
    return format_estimate(replace(estimate, stderr=total, systematic=0.0, unit=unit))


def _power_apart(value: float, error: float) -> int:
    """The power of ten that is written apart: 0 where all digits of a number with this error are read at a glance."""
    size = max(abs(value), error if math.isfinite(error) else 0.0)
    power = math.floor(math.log10(size)) if math.isfinite(size) and size > 0.0 else 0
    return power if power < -PLAIN_BELOW or power >= PLAIN_ABOVE else 0


def confidence_words(confidence: float) -> str:
    """A probability in whole per cent, never as certain; empty where there is none.

    >>> confidence_words(0.98), confidence_words(0.9999), confidence_words(1e-20)
    ('98 %', 'over 99 %', 'under 1 %')
    """
    if not math.isfinite(confidence):
        return ""
    if confidence < 0.01:
        return "under 1 %"
    return "over 99 %" if confidence > 0.99 else f"{100.0 * confidence:.0f} %"


def p_words(p_value: float) -> str:
    """A p-value in words: where no simulation knows it further, what it is at most.

    >>> p_words(0.032), p_words(1e-6)
    ('p = 0.032', 'p at most 1 × 10⁻⁶')
    """
    return f"p {'at most' if p_value <= LEAST_P else '='} {plain_number(p_value, 2)}"


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


def problem_of(estimate: Estimate) -> str:
    """What a reader must know before using an estimate: on a bound, no error bar; empty where nothing.

    >>> problem_of(Estimate(0.0, outcome="added_mass_kg on its bound 0 kg"))
    'added mass on its bound 0 kg'
    """
    if estimate.outcome != OK:
        return reason_words(estimate.outcome)
    return "" if math.isfinite(estimate.total_stderr) else "no error bar"
