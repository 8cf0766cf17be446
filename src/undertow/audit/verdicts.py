"""What an audit says of a series of tables: names, alternatives, intervals, the test that would decide, a sentence.

A name is said when Eq. 15 with constant coefficients has at most one chance in ten; rivals within odds of 20 to 1
of the preferred one are named beside it. Where a rival without any water force is among them, the table carries no
information about the water.

Belongs here: probabilities into words. Does not belong here: probabilities (answer.py), files (campaign/audit.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain, product

from undertow.audit.answer import Answer, Weight, probabilities_under
from undertow.audit.effects import FRICTION, LINEAR, RESONATOR
from undertow.audit.recipes import Array
from undertow.audit.rivals import EXPONENTS
from undertow.audit.scatter import BELIEVED, CAPS

ODDS = 20.0
"""Rivals within these odds of the preferred one are its alternatives (docs/discrepancy.md)."""

DOUBT = 0.1
"""No name is said while Eq. 15 with constant coefficients has more than this probability. The false
positives are then the probability that it keeps where names are said, over simulated tables one in a hundred of
all it has (docs/published_tables.md). 0.02 would promise two in a hundred whatever the priors, and miss weak
effects.
"""

RULED_OUT = 0.02
"""Above this the sentence says what Eq. 15 keeps."""

TESTS: Mapping[frozenset[str], str] = {
    frozenset({LINEAR, FRICTION}): (
        "a release at a third of the smallest amplitude followed until it stops: friction stops it in a time "
        "proportional "
        "to the amplitude, at a rest position within mu N / k; linear damping takes the same share of every cycle"
    ),
    frozenset({LINEAR, "drag_exponent"}): (
        "releases over a tenfold range of amplitude on one spring: decrement against amplitude is flat for linear "
        "damping and a power below one for a falling drag"
    ),
    frozenset({FRICTION, "drag_exponent"}): (
        "the vertical load cells during the motion, or the same release with weights added over the bearings: friction "
        "follows the normal force, drag does not"
    ),
    frozenset({LINEAR, RESONATOR}): (
        "the whole record instead of two coefficients, or a second spring: a resonator makes a beat and its damping "
        "depends on the spring, linear damping does neither"
    ),
    frozenset({FRICTION, "rest_offset"}): (
        "the first turning points on both sides: an offset changes sign from one to the next, friction does not"
    ),
    frozenset({LINEAR, "rest_offset"}): (
        "the rest position after the motion, and turning points on both sides: an offset shows there, damping does not"
    ),
    frozenset({RESONATOR, "support_compliance"}): (
        "a third spring, or the dry period again with the wet set-up: compliance shifts every level alike, a resonator "
        "does not shift the dry period"
    ),
    frozenset({RESONATOR, "gain_error"}): (
        "the spring's stiffness again, by a weight and a ruler or by its dry period: a mis-stated one shifts every "
        "level alike, a resonator does not show there"
    ),
    frozenset({"support_compliance", "gain_error"}): (
        "a third spring: compliance takes from each in proportion to its stiffness, a mis-stated stiffness belongs to "
        "one spring"
    ),
}
"""The test that would decide between two effects."""

NEAR_LINEAR = 0.05
"""An exponent whose interval comes this close to its lower end would rather be linear damping."""

PARAMETER_WORDS: Mapping[str, str] = {
    "mass_kg": "mass", "natural_frequency_rad_per_s": "frequency", "damping_ratio": "damping ratio", "force_N": "force",
    "offset_m": "offset", "exponent": "exponent", "c_Ns_per_m": "c", "compliance_m_per_N": "compliance",
}  # fmt: skip
"""A parameter inside a sentence, its unit beside the number."""

OF_SPRING = "true over printed stiffness, less one, of spring "
"""What stands in a sentence for the beginning of a parameter that belongs to one spring."""

NO_WATER_TEST = "a dry release of the same amplitude through the same recipe: what it returns is the structure's share"


@dataclass(frozen=True)
class Range:
    """Median, 90 % interval and standard deviation of one parameter, in its unit."""

    value: float
    low: float
    high: float
    stderr: float
    unit: str


@dataclass(frozen=True)
class SeriesVerdict:
    """One series of cases judged. ``parameters``: one mapping a case, effect or "water" -> parameter -> Range, of the
    preferred rival; ``others`` the same of each alternative, by its label."""

    status: str
    verdict: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    confidence: float
    informs_about_water: bool
    parameters: tuple[Mapping[str, Mapping[str, Range]], ...]
    others: Mapping[str, tuple[Mapping[str, Mapping[str, Range]], ...]]
    next_test: str
    sentence: str
    equation_if: Mapping[float, float]
    """Probability of Eq. 15 with constant coefficients where rows may scatter by up to a share of the mass
    (`scatter.CAPS`)."""


def judge(found: Answer) -> SeriesVerdict:
    """The verdict on a series of cases."""
    base = sum(weight.probability for weight in found.weights if not weight.rival.effects)
    named = [weight for weight in found.weights if weight.rival.effects]
    silent = next(weight for weight in found.weights if not weight.rival.effects)
    informs = _informs(found)
    if base > DOUBT or not named:
        clear = base >= 0.5 or not named
        near = [] if clear else [w for w in named if w.probability * ODDS >= base]
        preferred, status = silent, "nothing_missing" if clear else "not_identifiable"
        confidence = base
    else:
        preferred = named[0]
        near = [w for w in named[1:] if w.probability * ODDS >= preferred.probability]
        status, confidence = ("not_identifiable" if near else "explained"), preferred.probability
    if not informs:
        status = "not_identifiable"
    others = {weight.rival.label: _parameters(weight) for weight in near}
    alternatives = tuple(weight.rival.effects for weight in near)
    equation_if = {cap: _equation(found, probabilities_under(found, cap)) for cap in CAPS}
    sentence = _sentence(preferred, near, base, informs)
    if informs and preferred.rival.effects:
        sentence += _rests_on(found.cases[0].mass_kg, equation_if)
    return SeriesVerdict(
        status, preferred.rival.effects, alternatives, float(confidence), informs, _parameters(preferred), others,
        next_test(preferred.rival.effects, alternatives, informs), sentence, equation_if,
    )  # fmt: skip


def _equation(found: Answer, probabilities: Array) -> float:
    """Probability of Eq. 15 with constant coefficients, with or without water."""
    pairs = zip(found.weights, probabilities.tolist(), strict=True)
    return float(sum(share for weight, share in pairs if not weight.rival.effects))


def _rests_on(mass_kg: float, equation_if: Mapping[float, float]) -> str:
    """What a verdict owes to the cap on the rows' scatter; "" where a higher one leaves it."""
    changed = [cap for cap in CAPS if equation_if[cap] > DOUBT]
    if not changed:
        return ""
    return (
        f" This rests on rows that scatter by no more than {100.0 * BELIEVED:.0f} % of the mass by themselves: where "
        f"{100.0 * changed[0]:.0f} % ({changed[0] * mass_kg:.0f} kg from row to row) are as likely as less, Eq. 15 "
        f"keeps a probability of {equation_if[changed[0]]:.2g}."
    )


def _informs(found: Answer) -> bool:
    """Whether every physics without water is behind the best with it by more than the odds."""
    dry, wet = found.dry, [weight for weight in found.weights if weight.rival.water]
    if dry is None or not wet:
        return bool(wet)
    return dry.log_evidence < max(weight.log_evidence for weight in wet) - math.log(ODDS)


def next_test(preferred: tuple[str, ...], alternatives: tuple[tuple[str, ...], ...], informs: bool) -> str:
    """The test that would decide between the named effects; "" where nothing is open.

    >>> next_test((LINEAR,), ((FRICTION,),), True)[:9]
    'a release'
    """
    if not informs:
        return NO_WATER_TEST
    singles = [effect for alternative in alternatives for effect in alternative if effect not in preferred]
    beside = (product(preferred, alternative) for alternative in alternatives)
    for one, other in chain(*beside, product(singles, singles)):
        test = TESTS.get(frozenset({one, other}))
        if test and one != other:
            return test
    return "recordings in place of coefficients: the whole decay tells these apart" if alternatives else ""


def _parameters(weight: Weight) -> tuple[Mapping[str, Mapping[str, Range]], ...]:
    found = []
    units = {unknown.name: unknown.unit for unknown in weight.rival.unknowns if not unknown.nuisance}
    for posterior in weight.posteriors:
        one: dict[str, dict[str, Range]] = {}
        for name, unit in units.items():
            effect, _, parameter = name.partition(".")
            if effect in ("added_mass_kg", "drag_coefficient"):
                effect, parameter = "water", name
            middle, low, high = posterior.interval(name)
            one.setdefault(effect, {})[parameter] = Range(middle, low, high, float(posterior.draws[name].std()), unit)
        found.append(one)
    return tuple(found)


def _sentence(preferred: Weight, near: list[Weight], base: float, informs: bool) -> str:
    if not informs:
        return (
            "A rival without any water force prints these numbers too (odds within 20 to 1): they carry no information "
            "about the water."
        )
    if not preferred.rival.effects:
        does = "prints these numbers" if base >= 0.5 else "is not ruled out"
        text = f"Eq. 15 with constant coefficients {does} (probability {likely(base)})"
        names = ", ".join(weight.rival.label for weight in near)
        return f"{text}; {names} {'are' if len(near) > 1 else 'is'} not ruled out." if near else f"{text}."
    kept = "does not print these numbers"
    if base > RULED_OUT:
        kept = f"hardly prints these numbers (probability {likely(base)})"
    text = f"Eq. 15 with constant coefficients {kept}; {_told(preferred)} does"
    if near:
        text += f", and so {'do' if len(near) > 1 else 'does'} {'; '.join(_told(weight) for weight in near)}"
        return f"{text}: these numbers cannot tell them apart."
    return f"{text} (probability {likely(preferred.probability)})."


def likely(probability: float) -> str:
    """A probability in words that never say it is certain.

    >>> likely(0.99997), likely(0.9584)
    ('above 0.999', '0.958')
    """
    return "above 0.999" if probability > 0.999 else f"{probability:.3g}"


def _on_bound(name: str, found: Range) -> str:
    """Said of an exponent that would rather be linear damping."""
    near = name == "exponent" and found.low < EXPONENTS[0] + NEAR_LINEAR
    return ", at its lower end next to linear damping" if near else ""


def rounded(value: float) -> str:
    """Three digits, and never a power of ten below a million.

    >>> rounded(1102.3), rounded(0.0006877)
    ('1102', '0.000688')
    """
    return f"{value:.0f}" if 1000.0 <= abs(value) < 1e6 else f"{value:.3g}"


def _told(weight: Weight) -> str:
    if len(weight.posteriors) > 1:
        return weight.rival.label
    ranges = [
        f"{PARAMETER_WORDS.get(name, name.replace('stiffness_', OF_SPRING))} "
        f"{rounded(r.low)} to {rounded(r.high)}{'' if r.unit == '1' else ' ' + r.unit}{_on_bound(name, r)}"
        for effect, group in _parameters(weight)[0].items()
        if effect != "water"
        for name, r in group.items()
    ]
    return f"{weight.rival.label} ({', '.join(ranges)})"
