"""A verdict in one paragraph: what is missed, what explains it, what it was proved on, which rivals remain.

Belongs here: sentences. Does not belong here: words of names (naming.py), what is said (judge.py).
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence

from undertow.comparison.clock import changes
from undertow.comparison.level import Addend
from undertow.discrepancy.case import Case
from undertow.discrepancy.left_out import LeftOut
from undertow.discrepancy.naming import DESCRIBE, causes_words, drifts, in_words
from undertow.discrepancy.words import either, least_sets, percent, quantity_of, spelled
from undertow.equation import registry
from undertow.quantities import Estimate

EXPLAINS, DESCRIBES, CLOSEST = (
    (" explains it", " together explain it"), (" describes it", " together describe it"),
    (" comes closest", " together come closest"),
)  # fmt: skip
"""What is said of what is named, and of several names: of one that leaves more than noise, and of what is no answer."""

SAID = 1.5
"""Standard errors from zero from which a law's numbers are said: 8e10 +- 8e10 tells nothing."""

THREE_LAWS = (
    " Three laws at once are a description rather than the law: one that is in no catalogue can look so, and is "
    "likelier than that three are missing."
)
"""Of 2,300 campaigns whose truth was sealed (calibration) four ended so, and none of the sets of three was right."""

NOTHING_LATER = re.compile(r" After [\d.]+ periods? nothing is missing\.")
"""What `late_words` says, which something unknown contradicts."""


def sentence_of(
    case: Case,
    names: Sequence[str],
    rivals: Sequence[Sequence[str]],
    found: Mapping[str, Sequence[Mapping[str, Estimate]]],
    training: float,
    held: float,
    rest: bool,
    known: Sequence[str],
    own: bool = False,
    left: bool = False,
) -> str:
    """A group's verdict as an engineer would say it: what is missed, what explains it (``left``: describes it, for it
    leaves more than noise), what an unseen trial says (``own``: after a force of that trial's own size and phase was
    fitted to it)."""
    parts = [f"{case.label}: {_missed(case)}."]
    named = " and ".join(in_words(n, case.in_water) for n in dict.fromkeys(names))
    numbers = _numbers(found)
    verb = (CLOSEST if rest else DESCRIBES if left else EXPLAINS)[len(set(names)) > 1]
    alike = "" if rest else causes_words(names)
    parts.append(f"{named[0].upper()}{named[1:]}{verb}{': ' if numbers else ''}{numbers}.{alike}")
    if case.dry and any(term.of_water for term in map(registry.find, {*names} & {*registry.names()})):
        parts.append("A dry group is held to the structure's laws: those of the water in equation.terms are left out.")
    if known:
        said = " and ".join(spelled(n) for n in known)
        parts.append(f"The dry trials need {said} already: it belongs to the rig, not to the water.")
    if rivals:
        _, *others = least_sets([names, *rivals])
        said = either([" and ".join(in_words(n, case.in_water) for n in one) for one in others])
        parts.append(f"The data cannot tell it from {said}." if others else _more_beside(case, names, rivals))
    if math.isfinite(held) and math.isfinite(case.baseline.held_out_nrmse):
        number = len(case.held)
        fitted = ", with only that trial's size and phase of the force fitted," if own else ""
        fitted += ", with that trial's own drift of the sensor taken out," if drifts(names) else ""
        parts.append(
            f"On {number} trial{'s' if number > 1 else ''} it never saw{fitted} the error goes from "
            f"{percent(case.baseline.held_out_nrmse)} to {percent(held)}"
            + (", both within repeatability." if max(held, case.baseline.held_out_nrmse) <= case.allowed else ".")
        )
    else:
        parts.append(
            f"On the trials it was fitted to the error goes from {percent(case.baseline.nrmse)} to "
            f"{percent(training)}; not proved on an unseen trial."
        )
    if rest:
        parts.append("What is left is more than repetitions would differ: something else is missing too.")
    return " ".join(parts)


def _more_beside(case: Case, names: Sequence[str], rivals: Sequence[Sequence[str]]) -> str:
    """That all rivals hold what is named, and something beside it."""
    more = [Counter(one) - Counter(names) for one in rivals]
    beside = dict.fromkeys(" and ".join(in_words(n, case.in_water) for n in one.elements()) for one in more if one)
    return f"Whether {either(list(beside))} is there beside it the data do not say."


def _missed(case: Case) -> str:
    """What the prescribed equation misses, in how many trials. The error is the median's: it may be within
    repeatability though some trials are not."""
    size, allowed = percent(case.baseline.nrmse), case.repeats
    share = f"{case.missing} of {len(case.trials)} trials"
    if not case.missing and len(case.trials) == 1:
        return f"the error is no more than repetitions differ (error {size}, {allowed}), but what is left has a shape"
    if not case.missing:
        return f"no trial alone stands out (error {size}, {allowed}), but together they do"
    if case.baseline.nrmse <= case.allowed:
        return f"in {share} the equation misses more than repetitions differ (median error {size}, {allowed})"
    return f"the equation misses {size} of the motion in {share} ({allowed})"


def no_answer(label: str, sentence: str, because: str) -> str:
    """A group's sentence where what comes closest is not the answer, which it says first.

    >>> no_answer("dry", "dry: the equation misses 5 %. Friction explains it.", "the probability is 3 %")
    'dry: nothing that was tried is the answer, what is missing is unknown. The equation misses 5 %. Friction comes \
closest. It is not the answer: the probability is 3 %.'
    """
    said = NOTHING_LATER.sub("", sentence.removeprefix(f"{label}: "))
    said = re.sub(rf" ({'|'.join(DESCRIBE)}) [^.]* alike\.", "", said)
    for verb, closest in zip((*EXPLAINS, *DESCRIBES), (*CLOSEST, *CLOSEST), strict=True):
        said = said.replace(verb, closest, 1)
    first = f"{label}: nothing that was tried is the answer, what is missing is unknown."
    return f"{first} {said[0].upper()}{said[1:]} It is not the answer: {because}."


def not_all(sentence: str, because: str) -> str:
    """The sentence of an answer beside which there is something that nobody knows.

    >>> not_all("The release explains it. After 1 period nothing is missing.", "its probability is 3 %")
    'The release explains it. But this is not all: its probability is 3 %. What is beside it is unknown.'
    """
    return f"{NOTHING_LATER.sub('', sentence)} But this is not all: {because}. What is beside it is unknown."


def late_words(addends: Sequence[Addend]) -> str:
    """What is left out of the motion, in words."""
    periods = max((addend.late for addend in addends), default=0.0)
    return f" After {periods:g} period{'s' if periods != 1.0 else ''} nothing is missing." if periods else ""


def changing_words(addends: Sequence[Addend]) -> str:
    """That an outside force changes along the record, in words."""
    if not any(changes(addend) for addend in addends):
        return ""
    return " Its size and phase change along each record; the size is of its middle."


def transfer_words(moved: Mapping[str, float]) -> str:
    """What other springs alone predict, in words."""
    texts = [
        f"with the numbers that the other spring's trials ({label}) alone give, the error here is {percent(error)}"
        for label, error in moved.items() if math.isfinite(error)
    ]  # fmt: skip
    return f" W{'; '.join(texts)[1:]}." if texts else ""


def left_out_words(apart: LeftOut, trials: int, own: bool = False) -> str:
    """What fits without a trial miss of it, in words, where a group held none back (``own``: a force's size and phase
    were fitted to it).

    >>> left_out_words(LeftOut(0.2, 0.05), 2)
    ' Predicted by fits without it, each of its 2 trials is missed by 20 % as prescribed, by 5.0 % with what is named.'
    >>> left_out_words(LeftOut(), 2)
    ''
    """
    if not math.isfinite(apart.after):
        return ""
    fits = "a fit of other springs' trials, it" if trials == 1 else f"fits without it, each of its {trials} trials"
    fitted = ", with only that trial's size and phase of the force fitted," if own else ""
    return (
        f" Predicted by {fits}{fitted} is missed by {percent(apart.before)} as prescribed, by {percent(apart.after)} "
        "with what is named."
    )


def _numbers(found: Mapping[str, Sequence[Mapping[str, Estimate]]]) -> str:
    """The additions' numbers in words, a frequency in Hz; none of a law whose size is hardly more than its error."""
    texts = []
    for many in found.values():
        for one in many:
            size = next(iter(one.values()), None)
            if size is None or abs(size.value) < SAID * size.stderr:
                continue
            if "natural_frequency_rad_per_s" in one:
                hertz = one["natural_frequency_rad_per_s"].scaled(1.0 / (2.0 * math.pi), "Hz")
                ratio = f"damping {100 * one['damping_ratio'].value:.2g} % of critical"
                texts.append(f"a mass of {one['mass_kg']} at {hertz}, {ratio}")
                more = one.get("quadratic_damping_per_m")
                if more is not None and more.value > 2.0 * more.stderr:
                    texts[-1] += " and more with amplitude"
            elif "kernel_mass_kg" in one:
                texts.append(f"{one['c_Ns_per_m']} at this body's frequency; at other frequencies it differs")
            elif "release_time_s" in one:
                texts.append(f"it took {one['release_time_s']}")
            else:
                first, *inner = one.items()
                texts.append(", ".join([str(first[1]), *(f"{quantity_of(name)} {e}" for name, e in inner)]))
    return "; ".join(texts)
