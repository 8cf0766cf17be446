"""What is said of a simulation against a recording: one sentence.

Belongs here: that sentence. Does not belong here: anything that it says (differ.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from undertow.discrepancy.difference import FAR, Difference
from undertow.discrepancy.naming import in_words
from undertow.discrepancy.words import either, least_sets, percent
from undertow.report.wording import parameter_name

LET_GO = "let go like the recording, its equation"
"""How the second half of the sentence begins."""

WORTH_A_LINE = 0.2
"""A line of the residual is spoken of from this share of it on."""


def sentence_of(difference: Difference) -> str:
    """How far the simulation's equation is from the recording, where, and what it lacks, in one sentence."""
    return f"The simulation {_what(difference)}: {_how_far(difference)}."


def _how_far(d: Difference) -> str:
    m = d.mismatch
    size, limit = percent(m.nrmse), percent(m.repeatability_nrmse)
    if not m.missing:
        return f"{LET_GO} stays within {size} of it (a repeated test: {limit})"
    thirds = {"first": m.share_early, "second": m.share_middle, "last": m.share_late}
    where = max(thirds, key=lambda part: thirds[part] if math.isfinite(thirds[part]) else -1.0)
    text = f"{LET_GO} misses {size} of it (a repeated test: {limit}), most in the {where} third"
    if math.isfinite(m.line_frequency_hz) and m.line_share > WORTH_A_LINE:
        text += f" and {percent(m.line_share)} of that in a line at {m.line_frequency_hz:.3g} Hz"
    cycles = d.cycles.sentence() if d.cycles is not None else ""
    return f"{text}; in the recording, {cycles}" if cycles else text


def listed_in_words(names: Sequence[str], more: Sequence[str] = ()) -> str:
    """Names in words; of those in ``more`` the simulation has some, but not enough."""
    said = (f"{'enough ' if n in more else ''}{in_words(n, alone=True)}" for n in names)
    return " and ".join(said)


def _what(d: Difference) -> str:
    """What the simulation lacks, and which numbers differ, in words."""
    names = [n for n in d.lacks if n != "unknown"]
    words = [listed_in_words([n], d.more) for n in names]
    if names and not d.by_equation and "unknown" in d.recording.verdict.verdict:
        words[-1] += " (the closest of what was tried: one recording does not prove it)"
    if "unknown" in d.lacks:
        words.append("something that no suspect explains")
    said = d.recording.verdict
    rivals = [listed_in_words(names) for names in least_sets((said.verdict, *said.alternatives))[1:]]
    if words:
        text = f"lacks {' and '.join(words)}"
        if rivals and names and not d.by_equation:
            text += f" (this recording cannot tell that from {either(rivals)})"
    else:
        text = "lacks no law that this recording shows"
    far = [parameter_name(r.name).words for r in d.rows if r.sigmas > FAR]
    if far and not words:
        text += f", but differs in {', '.join(far)}"
    if d.extra:
        text += f", and has {listed_in_words(d.extra)}, which the recording does not show"
    return text
