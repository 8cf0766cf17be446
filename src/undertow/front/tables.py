"""Numbers as a reader gets them: tables of parameters with intervals, and their HTML.

Belongs here: estimates as rows. Does not belong here: where they come from.
"""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence

import pandas as pd

from undertow.quantities import OK, Estimate, format_estimate
from undertow.uncertainty.confidence import INTERVAL_LEVEL, half_width

COLUMNS = ("value", "stderr", "low", "high", "unit", "note")
"""Of a table of parameters; low and high are the ends of the 90 % interval."""


def parameter_table(estimates: Mapping[str, Estimate], level: float = INTERVAL_LEVEL) -> pd.DataFrame:
    """One row a parameter: value, standard error (noise and what was held fixed), interval, unit, note.

    >>> parameter_table({"mass_kg": Estimate(10.0, 1.0, unit="kg")}).round(2).loc["mass_kg", ["low", "high"]].to_list()
    [8.36, 11.64]
    """
    half = half_width(1.0, level)
    rows = [
        (e.value, e.total_stderr, e.value - half * e.total_stderr, e.value + half * e.total_stderr, e.unit, note_of(e))
        for e in estimates.values()
    ]
    return pd.DataFrame(rows, index=pd.Index(estimates, name="parameter"), columns=list(COLUMNS))


def note_of(estimate: Estimate) -> str:
    """What a reader must know of a number: that it stands on a bound, else where it comes from."""
    return estimate.outcome if estimate.outcome != OK else estimate.source


def parameter_lines(estimates: Mapping[str, Estimate]) -> list[str]:
    """The same as text, one line a parameter."""
    width = max((len(name) for name in estimates), default=0)
    lines = []
    for name, e in estimates.items():
        doubt = f"  ({e.outcome})" if e.outcome != OK else ""
        lines.append(f"  {name.ljust(width)}  {format_estimate(e)}{doubt}")
    return lines


def html_page(
    title: str, equation: str, doubts: Sequence[str], table: pd.DataFrame | None, said: Sequence[str]
) -> str:
    """A result as a fragment of HTML, every text escaped: sentence, equation, doubts, table, remarks."""
    warned = "".join(f"<p><strong>{html.escape(one)}</strong></p>" for one in doubts)
    shown = "" if table is None else str(table.to_html(border=0, float_format=_short, na_rep="-"))
    remarks = "".join(f"<li>{html.escape(one)}</li>" for one in said)
    law = f"<p><code>{html.escape(equation)}</code></p>" if equation else ""
    return f"<div><p>{html.escape(title)}</p>{law}{warned}{shown}<ul>{remarks}</ul></div>"


def _short(value: float) -> str:
    return f"{value:.5g}" if math.isfinite(value) else "-"
