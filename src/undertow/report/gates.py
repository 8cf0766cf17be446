"""What a condition behind a verdict asks for and what follows where it is not met, in words.

Belongs here: those words. Does not belong here: deciding (discrepancy/decision.py), tables (behind.py, explain.py).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

AT_LEAST = frozenset({
    "evidence", "free_run_closer", "posterior", "more_than_noise", "outweighed",
})  # fmt: skip
"""Conditions that ask for a value of at least their limit; the others ask for no more than it."""

OF_A_CANDIDATE: Mapping[str, str] = {
    "evidence": "not reached",
    "numbers": "excluded",
    "free_run_closer": "not reached",
    "rivals": "other names fit as well",
    "posterior": "shared with other candidates",
}
"""Lines about what is named or, where nothing is, about the strongest candidate, and what it means not to meet them.
They bar nothing (docs/discrepancy.md)."""

OF_THE_EQUATION: Mapping[str, str] = {
    "free_run": "misses more than repetitions",
    "left_above_noise": "more than noise is left",
}
"""Lines about what is left, and what it means not to meet them. They bar nothing either."""

CONDITIONS = frozenset({
    "channels_agree", "search_ended", "p_value", "more_than_noise", "structure_known", "scatter_known", "nothing_left",
    "plausible", "upper_bound", "comes_closer", "distinct", "outweighed", "described", "dry_trials_agree",
    "twice_the_scatter",
})  # fmt: skip
"""Conditions of a decay's verdict; every other line is a law that was tried on a driven body."""


def asked_words(gate: str, value: float, limit: float, passed: bool) -> str:
    """Whether a condition asks for "at least" or "at most" its limit. A ``p_value`` does what the answer needs: it lies
    above its limit where nothing is missing, below it for a name.

    >>> asked_words("evidence", 2.84, 4.6, False), asked_words("p_value", 0.22, 0.00143, True)
    ('at least', 'at least')
    """
    above = (value > limit) is passed if gate == "p_value" else gate in AT_LEAST
    return "at least" if above else "at most"


def outcome_words(gate: str, passed: bool, status: str, named: Collection[str]) -> str:
    """Whether a condition is met, and what follows for this answer where it is not.

    >>> outcome_words("evidence", False, "nothing_missing", [])
    'not reached: so it is not named'
    >>> outcome_words("structure_known", False, "explained", ["relaxation"])
    'not met: bars other answers, not this one'
    >>> outcome_words("upper_bound", False, "cannot_tell", [])
    'NOT met: bars an answer'
    """
    if passed:
        return "met"
    if gate in OF_A_CANDIDATE:
        return OF_A_CANDIDATE[gate] + ("" if set(named) - {"unknown"} else ": so it is not named")
    if gate in OF_THE_EQUATION:
        return OF_THE_EQUATION[gate]
    if gate not in CONDITIONS:
        return "not added"
    barred = status in ("cannot_tell", "unknown")
    return "NOT met: bars an answer" if barred else "not met: bars other answers, not this one"
