"""A structure in words: as text for a terminal, as HTML for a notebook.

Belongs here: sentences and tables of a finished `FoundStructure`. Does not belong here: any figure, file or page of a
campaign (the report room), any computation.
"""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass

from undertow.comparison.structure import FoundStructure
from undertow.quantities import OK

ADEQUATE = 2.0
"""What is left over the sensors' noise, rms, from which a reader is told first; that of a fit is a little below."""

ODDS_MOST = 1e6
"""Odds are written out up to this number."""


@dataclass(frozen=True)
class Outside:
    """What an equation leaves out, as the search of `undertow run` says it.

    ``status`` and ``names`` are those of a verdict; ``adequate`` is None where the recordings cannot tell.
    """

    status: str
    names: tuple[str, ...]
    adequate: bool | None
    sentence: str


def equation_text(structure: FoundStructure) -> str:
    """The equation per unit mass in one line, each number with the digits its error allows."""
    errors = {term.name: structure.numbers[term.name].stderr for term in structure.terms}
    written = structure.equation.text(errors)
    return written.removeprefix("1 ")


def as_text(
    structure: FoundStructure, errors: Sequence[tuple[str, float]] = (), outside: Outside | None = None
) -> str:
    """The report of a fit: what is doubtful first, then equation, numbers, terms left out, rivals, routes.

    ``errors`` are free-run errors by trial, ``outside`` what the equation leaves out.
    """
    lines = [f"structure of {len(structure.trials)} trials: {', '.join(structure.trials)}"]
    lines += [f"! {sentence}" for sentence in doubts(structure, outside)]
    lines += ["", f"  {equation_text(structure)}", "", *_table(number_rows(structure)), ""]
    lines += [f"- {sentence}" for sentence in left_out(structure)]
    lines += [f"- {sentence}" for sentence in findings(structure, outside)]
    if errors:
        shown = ", ".join(f"{name} {value:.3g}" for name, value in errors)
        lines.append(f"- free-run error (RMS over RMS displacement): {shown}")
    return "\n".join(lines)


def doubts(structure: FoundStructure, outside: Outside | None = None) -> tuple[str, ...]:
    """What a reader must know before using a number."""
    said = [outside.sentence] if outside is not None and not outside.adequate else []
    if structure.left > ADEQUATE and (outside is None or not outside.adequate):
        said.append(f"what is left is {structure.left:.3g} times the sensors' noise: the equation lacks something")
        said += [
            f"{name} would leave less with a coefficient below 0, from which signs=True keeps it: a body that gains "
            "energy (self-excited) or a spring that pushes away needs signs=False"
            for name in structure.forbidden
        ]
    if structure.route is not None and not structure.route.agrees:
        said.append(structure.route.sentence)
    said += [f"{name}: {e.outcome}" for name, e in structure.numbers.items() if e.outcome != OK]
    if not structure.found.polished.converged:
        said.append("the search for the numbers did not converge")
    return tuple(said)


def odds(difference: float) -> str:
    """Odds that a difference of criteria stands for, as 'n to 1'.

    >>> odds(6.0)
    '20 to 1'
    """
    ratio = math.exp(min(0.5 * abs(difference), math.log(ODDS_MOST)))
    over = "over " if ratio > 0.999 * ODDS_MOST else ""
    return f"{over}{ratio:.0f} to 1" if ratio >= 10.0 else f"{ratio:.2g} to 1"


def number_rows(structure: FoundStructure) -> tuple[tuple[str, str, str, str], ...]:
    """Rows of term, value with error and unit, what leaving it out costs, and how often it is found again."""
    rows = [("term", "value", "criterion without it", "found again")]
    for name, estimate in structure.numbers.items():
        term = name.split(".")[0]
        key = next((label for label in structure.considered if label.split("(")[0] == term), term)
        cost, share = structure.evidence.get(key, math.nan), structure.inclusion.get(key, math.nan)
        known = math.isinf(cost)
        inner = "." in name
        rows.append(
            (
                name,
                str(estimate),
                "" if inner else ("known to be there" if known else f"{cost:+.0f}"),
                "" if inner or math.isnan(share) else f"{100.0 * share:.0f} %",
            )
        )
    return tuple(rows)


def left_out(structure: FoundStructure) -> tuple[str, ...]:
    """A sentence for each term of the library that is not in the equation."""
    kept = {label for label in structure.considered if label.split("(")[0] in structure.names}
    said = []
    for name in structure.considered:
        if name in kept:
            continue
        cost, share = -structure.evidence[name], structure.inclusion.get(name, math.nan)
        word = "refused by the signs or groups" if math.isinf(cost) else f"with it the criterion rises by {cost:.1f}"
        again = "" if math.isnan(share) else f", taken in by {100.0 * share:.0f} % of resamples"
        said.append(f"without {name}: {word}{again}".replace("rises by -", "falls by "))
    return tuple(said)


def findings(structure: FoundStructure, outside: Outside | None = None) -> tuple[str, ...]:
    """Rivals, what cannot be distinguished, the second route and what is left."""
    said = []
    for rival in structure.rivals:
        added = [name for name in rival.terms if name.split("(")[0] not in structure.names]
        gone = [name for name in structure.names if name not in {term.split("(")[0] for term in rival.terms}]
        change = " and ".join(
            part for part in (f"with {', '.join(added)}" if added else "", f"without {', '.join(gone)}" if gone else "")
            if part
        )
        more = "against it" if rival.difference >= 0.0 else "for it, too few for the larger of the two"
        said.append(f"rival {change}: odds {odds(rival.difference)} {more}")
    for source in dict.fromkeys(belief.source for belief in structure.found.book.beliefs):
        about = {name for one in structure.found.book.beliefs if one.source == source for name in one.weights}
        said.append(f"known beforehand ({source}): {', '.join(sorted(about))}")
    said += list(structure.collinear.sentences)
    if outside is not None and outside.adequate:
        said.append(outside.sentence)
    if structure.route_outcome and (structure.route is None or structure.route.agrees):
        said.append(structure.route_outcome)
    said.append(f"what is left is {structure.left:.3g} times the sensors' noise")
    return tuple(said)


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    padded = ([cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in rows)
    return [f"  {'  '.join(cells)}".rstrip() for cells in padded]


def as_html(structure: FoundStructure, outside: Outside | None = None) -> str:
    """The same as a fragment of HTML, every text escaped."""
    head, *body = number_rows(structure)
    cells = "".join(f"<th>{html.escape(cell)}</th>" for cell in head)
    rows = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in body)
    warned = "".join(f"<p><strong>{html.escape(sentence)}</strong></p>" for sentence in doubts(structure, outside))
    said = "".join(f"<li>{html.escape(s)}</li>" for s in (*left_out(structure), *findings(structure, outside)))
    equation = html.escape(equation_text(structure))
    return (
        f"<div><p><code>{equation}</code></p>{warned}<table><thead><tr>{cells}</tr></thead><tbody>{rows}</tbody>"
        f"</table><ul>{said}</ul></div>"
    )
