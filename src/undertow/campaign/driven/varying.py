"""What offset and friction of a driven body differ by from stroke to stroke: values for verdict.json, a table, words.

Belongs here: these three. Does not belong here: the fit (methods/driven_strokes.py), whether it is taken
(comparison/driven_varying.py).
"""

from __future__ import annotations

from typing import Any

from undertow.methods.driven import DrivenFit


def strokes_plain(fitted: DrivenFit) -> dict[str, Any] | None:
    """Both standard deviations in N, the odds, and the deviations of every pair of strokes by trial; None where the
    fit has one offset and one friction."""
    varying = fitted.strokes
    if varying is None:
        return None
    return {
        "offset_N": varying.offset_N, "friction_N": varying.friction_N, "ln_odds": varying.evidence,
        "trials": {
            name: {"offset_N": own[:, 0].tolist(), "friction_N": own[:, 1].tolist(), "left_m": varying.left[name]}
            for name, own in varying.deviations.items()
        },
    }  # fmt: skip


def strokes_sentence(fitted: DrivenFit) -> str:
    """What is to be said, with a space before it; empty where nothing varies by stroke."""
    varying = fitted.strokes
    if varying is None:
        return ""
    return (
        f" From one pair of strokes to the next the offset differs by {varying.offset_N:.2g} N and the friction by "
        f"{varying.friction_N:.2g} N (1 sigma); the numbers' errors and the bands of predictions hold that."
    )


def strokes_table(fitted: DrivenFit) -> list[tuple[str, ...]]:
    """Rows of the page, the first the header; empty where nothing varies by stroke."""
    varying = fitted.strokes
    if varying is None:
        return []
    rows = [
        (name, str(2 * i + 1), f"{offset:.3g}", f"{friction:.3g}")
        for name, own in varying.deviations.items() for i, (offset, friction) in enumerate(own.tolist())
    ]  # fmt: skip
    return [("trial", "from stroke", "offset beyond its mean, N", "friction beyond its mean, N"), *rows]
