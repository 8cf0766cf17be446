"""What stands behind a group's verdict: its conditions with their numbers, and the repaired equation's numbers.

Belongs here: those rows in words. Does not belong here: deciding (discrepancy/decision.py), the repaired equation
itself (discrepancy/repaired.py), the rest of a group's section (blocks.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from undertow.discrepancy.calibration import LEANS, NEARLY
from undertow.discrepancy.decision import NAMED
from undertow.discrepancy.findings import GroupFindings
from undertow.discrepancy.naming import drifts
from undertow.discrepancy.repaired import named_laws, repaired_equation, repaired_errors
from undertow.discrepancy.verdict import Gate, Verdict
from undertow.discrepancy.words import percent, spelled
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.errors import IdentificationError
from undertow.quantities import Estimate
from undertow.report import wording
from undertow.report.arrange import group_numbers
from undertow.report.expressions import numeric_latex
from undertow.report.gates import asked_words, outcome_words
from undertow.report.numbers import plain_number, printed_unit, short_number

PROBABILITY_GATE = "posterior"
"""The condition whose numbers are probabilities: they are printed as the others on the page."""


_KINDS: Mapping[str, str] = {
    "to the noise": "only noise is left",
    "nearly to the noise": "a little more than noise is left",
    "seen sharply": "little could hide",
    "leans to standing out": f"p below {LEANS:g}",
    "nearly stands out": f"p below {NEARLY:g}",
    "beyond every replica": "further out than every replica",
}
"""Kinds of verdicts whose counts make a percentage, as a reader of one page understands them."""


def kind_words(kind: str) -> str:
    """A kind of verdict (docs/calibration.md) in words that need no other page.

    >>> kind_words("nothing_missing, seen sharply, leans to standing out"), kind_words("unknown, not named")
    ('nothing missing, little could hide, p below 0.3', 'unknown, not named')
    """
    return ", ".join(_KINDS.get(part, part.replace("_", " ")) for part in kind.split(", "))


def gate_rows(verdict: Verdict) -> list[Mapping[str, Any]]:
    """Every condition behind a verdict, in words: ``gate``, ``statistic``, ``value``, ``limit`` (what is asked for),
    ``passed``, ``outcome``, ``because``."""
    return [
        {
            "gate": gate.gate.replace("_", " "),
            "statistic": spelled(wording.in_plain_words(gate.statistic)),
            "value": _number(gate, gate.value),
            "limit": f"{asked_words(gate.gate, gate.value, gate.limit, gate.passed)} {_number(gate, gate.limit)}",
            "passed": gate.passed,
            "outcome": outcome_words(gate.gate, gate.passed, verdict.status, verdict.verdict),
            "because": "" if gate.passed else wording.reason_words(gate.because),
        }
        for gate in verdict.decision
    ]


def allowed_words(verdict: Verdict, share: float) -> str:
    """What repeatability allows in a group, in words: "assumed" where nobody measured or stated how much trials differ.

    >>> allowed_words(Verdict({}, (), decision=(Gate("scatter_known", "reasons", 1.0, 0.0, False),)), 0.16)
    '16 %, assumed'
    """
    unknown = any(gate.gate == "scatter_known" and not gate.passed for gate in verdict.decision)
    assumed = unknown or ", assumed" in verdict.sentence  # a group that was never searched has no conditions
    return f"{percent(share)}, assumed" if assumed and math.isfinite(share) else percent(share)


def posterior_words(verdict: Verdict) -> str:
    """How probable exactly what is named is among all that was fitted, and it with more laws beside it where that was
    computed; empty where nothing is explained."""
    if verdict.status != "explained" or not math.isfinite(verdict.posterior):
        return ""
    held = [gate.value for gate in verdict.decision if gate.gate == "outweighed" and gate.lacking != "beside"]
    more = f", and all sets that hold these {wording.confidence_words(held[0])}" if held else ""
    return (
        "Of all sets of laws that were fitted here, those excluded by the conditions below included, exactly this one "
        f"has a posterior probability of {wording.confidence_words(verdict.posterior)}{more}"
    )


def seen_rows(verdict: Verdict) -> list[Mapping[str, str]]:
    """What would have been seen in a group, the least share of the motion first: ``effect``, ``seen``, ``share``,
    ``named``, all in words."""
    return [
        {
            "effect": ", ".join(filter(None, (spelled(one.name), wording.values_in_words(one.at, one.unit)))),
            "seen": f"{wording.quantity_words(one.name, one.parameter)} {plain_number(one.value, 2)} "
            f"{printed_unit(one.unit)}".strip(),
            "share": f"{short_number(100.0 * one.share_of_motion, 2)} %",
            "named": "-" if math.isnan(one.named_value)
            else f"{plain_number(one.named_value, 2)} {printed_unit(one.unit)}".strip(),
        }
        for one in sorted(verdict.detectable, key=lambda d: d.share_of_motion)
    ]


def _number(gate: Gate, value: float) -> str:
    if not math.isfinite(value):
        return "-"
    if gate.gate == PROBABILITY_GATE:
        return f"{100.0 * value:.0f} %" if value <= 0.99 else wording.confidence_words(value)
    return short_number(value)


def repaired_of(group: GroupFindings) -> tuple[Equation, Mapping[str, float]] | None:
    """The repaired equation and its errors by term name; None where nothing is named, or what is named is no law of the
    body's motion (a clock, a gain, a release)."""
    if not is_repaired(group.verdict):
        return None
    try:
        equation = repaired_equation(group.equation, group.verdict, group.specimen)
    except IdentificationError:
        return None
    return equation, repaired_errors(group.equation, group.equation_errors, group.verdict, group.specimen)


def is_repaired(verdict: Verdict) -> bool:
    """Whether a verdict names something and has the numbers that go with it."""
    return verdict.augmented is not None and bool(named_laws(verdict))


def believed_numbers(group: GroupFindings) -> Mapping[str, Estimate]:
    """The numbers that stand for a group: where something is named the repaired equation's, which what is missing does
    not bend."""
    numbers, after = group_numbers(group), group.verdict.augmented
    if after is None or group.verdict.status not in NAMED or not is_repaired(group.verdict):
        return numbers
    return {name: after.parameters.get(name, one) for name, one in numbers.items()}


def number_words(group: GroupFindings, number: Estimate, with_unit: bool) -> str:
    """A number, in brackets where something is missing that nobody knows: it bends the number."""
    text = wording.estimate_text(number, with_unit)
    return f"({text})" if group.verdict.status == "unknown" else text


def repaired_block(group: GroupFindings) -> Mapping[str, Any]:
    """The repaired equation beside the prescribed one: ``rows`` of ``name``, ``before``, ``after``, ``published``,
    ``problem``; where what is ``held`` comes from; ``latex`` and ``text`` (empty where it cannot be written); whether
    what is named is an answer and both give a number (``both``); and whether a damping in it is what waves carry away
    (``of_waves``). Empty where nothing is named."""
    verdict = group.verdict
    if verdict.augmented is None or not is_repaired(verdict):
        return {}
    before, after = verdict.baseline.parameters, verdict.augmented.parameters
    written, published = repaired_of(group), dict(group.specimen.published)
    names = wording.ordered_parameters((*before, *after))
    return {
        "rows": [number_row(name, before.get(name), after.get(name), published.get(name)) for name in names],
        "published": any(name in published for name in names),
        "held": held_words(group),
        "both": verdict.status != "unknown" and any(name in after for name in before),
        "latex": "" if written is None else numeric_latex(*written, rotation=group.specimen.rotation),
        "text": "" if written is None else written[0].text(written[1]),
        "of_waves": any("kernel_mass_kg" in name for name in after),
    }


def held_words(group: GroupFindings) -> str:
    """Where the parameters that were held come from, in words."""
    cells = group.specimen.stiffness_error_N_per_m > 0.0
    said = ["the stiffness, from the load cells"] if cells else []
    if group.structure is not None or not said:
        said.append("those of the structure, from the dry trials or the config")
    return "; ".join(said)


def number_row(
    name: str, before: Estimate | None, after: Estimate | None, published: float | None = None
) -> Mapping[str, str]:
    """A number of both equations in words: ``name``, ``before``, ``after``, ``problem``, ``published``."""
    problem = "" if after is None else wording.problem_of(after)
    return {
        "name": wording.parameter_words(name),
        "before": "" if before is None else wording.estimate_text(before),
        "after": "not in it" if after is None else wording.estimate_text(after),
        "problem": "" if problem == "no error bar" else problem,
        "published": "" if published is None else short_number(published, 5),
    }


def adjusted_words(group: GroupFindings) -> str:
    """What every free run of a group's trials was adjusted to, in words; the equation's numbers never are."""
    speed = "" if all(trial.motion.window.held for trial in group.trials) else ", the release speed"
    text = f"the release position x0{speed}, the clock and the rest position"
    named = [registry.row(name) for name in group.verdict.verdict]
    if any(law is not None and law.own_clock for law in named):
        text += ", and with what was found the outside force's own size and phase"
    if drifts(group.verdict.verdict):
        text += ", and with what was found the sensor's own drift, which is taken out of what it measured"
    return text
