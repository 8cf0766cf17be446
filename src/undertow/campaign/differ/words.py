"""What is said of a simulation against a recording, on the terminal and in files: the page's first words and where.

Belongs here: those sentences. Does not belong here: anything that they say (compare.py), the page itself (report/).
"""

from __future__ import annotations

import math

from undertow.discrepancy.difference import Difference
from undertow.discrepancy.words import percent
from undertow.report.difference import lead_of, sure_of

WORTH_A_LINE = 0.2
"""A line of the residual is spoken of from this share of it on."""


def sentence_of(difference: Difference) -> str:
    """What the simulation lacks, how sure that is, how far its equation is from the recording and where."""
    said = [lead_of(difference).removesuffix("."), sure_of(difference), _how_far(difference)]
    if difference.cycles is not None and difference.mismatch.missing:
        cycles = difference.cycles.sentence()
        said.append(f"in the recording, {cycles}" if cycles else "")
    return " ".join(f"{text[0].upper()}{text[1:]}." for text in said if text)


def _how_far(d: Difference) -> str:
    m = d.mismatch
    text = f"a repeated test would miss {percent(m.repeatability_nrmse)}"
    if not m.missing:
        return text
    thirds = {"first": m.share_early, "second": m.share_middle, "last": m.share_late}
    where = max(thirds, key=lambda part: thirds[part] if math.isfinite(thirds[part]) else -1.0)
    own = f"its equation with its own numbers, let go like the recording, misses {percent(m.nrmse)}"
    text += f"; {own}, most in the {where} third"
    if math.isfinite(m.line_frequency_hz) and m.line_share > WORTH_A_LINE:
        text += f", {percent(m.line_share)} of that in a line at {m.line_frequency_hz:.3g} Hz"
    return text
