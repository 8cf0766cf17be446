"""The page of a driven campaign, in time or of harmonic sets: the sentence, the free run on samples nobody fitted or
the curves through measured points, the equation, what was tried.

Belongs here: that page, self-contained. Does not belong here: what it shows (campaign/driven).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from undertow.conditioning.driven import UNITS_OF_MOTION, DrivenTrial
from undertow.recording.recording import Array
from undertow.report.style import new_figure, page_style, svg_text
from undertow.report.wording import plain_number, reason_words
from undertow.report.writing import write_text

SHOWN = 4000
"""Samples of a free run that a picture shows at most."""

_STYLE = (
    "body{font-family:sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;line-height:1.5}"
    "table{border-collapse:collapse;display:block;overflow-x:auto}td,th{padding:.2rem .8rem;text-align:left;"
    "border-bottom:1px solid #ddd}svg{max-width:100%;height:auto}"
)


@dataclass(frozen=True)
class PagePart:
    """One group of a page: its sentence, its figures (HTML), its equation, and tables: heading -> list of rows, the
    first the header."""

    sentence: str
    figures: Sequence[str]
    equation: str
    tables: Mapping[str, Any]


def page_html(title: str, groups: Sequence[PagePart]) -> str:
    """The page as HTML, group by group."""
    parts = [f"<h1>{escape(title)}</h1>", *(_group(one) for one in groups)]
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{_STYLE}</style></head>'
        f"<body>{''.join(parts)}</body></html>\n"
    )


def _group(one: PagePart) -> str:
    """One group of the page."""
    parts = [f"<p><strong>{escape(one.sentence)}</strong></p>", *one.figures]
    law, *numbers = one.equation.split("; ")
    lines = [law.replace("+-", "±"), *map(reason_words, numbers)]
    parts.append("<h2>Equation</h2><p>" + "<br>".join(map(escape, lines)) + "</p>")
    for heading, rows in one.tables.items():
        head = "".join(f"<th>{escape(str(cell))}</th>" for cell in rows[0])
        body = "".join("<tr>" + "".join(f"<td>{escape(str(c))}</td>" for c in row) + "</tr>" for row in rows[1:])
        parts.append(f"<h2>{escape(heading)}</h2><table><tr>{head}</tr>{body}</table>")
    return "".join(parts)


def run_picture(name: str, trial: DrivenTrial, run: Array) -> str:
    """A trial's motion and its free run ``run`` (n,), and their difference below, of the record's first part."""
    recorded, unit, away = trial.outputs[trial.main], UNITS_OF_MOTION[trial.main], run - trial.outputs[trial.main]
    t = trial.t[:SHOWN]
    with page_style():
        figure = new_figure(8.0, 4.0)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        above.plot(t, recorded[:SHOWN], color="0.6", lw=1.6, label="recorded", rasterized=True)
        above.plot(t, run[:SHOWN], lw=0.8, label="free run", rasterized=True)
        above.set_ylabel(f"motion ({unit})")
        figure.legend(loc="outside upper left", ncols=2)
        below.plot(t, away[:SHOWN], lw=0.8, rasterized=True)
        below.set(xlabel="time (s)", ylabel=f"free run minus\nrecorded ({unit})")
        rms = float(np.sqrt(np.mean(away**2)))
        said = f"{escape(name)}: free run minus recorded is {plain_number(rms, 3)} {unit} rms, of all samples"
        return f"<figure>{svg_text(figure)}<figcaption>{said}</figcaption></figure>"


def write_page(folder: Path, text: str) -> None:
    """Write report.html, and the folder of figures that every run has."""
    (folder / "figures").mkdir(exist_ok=True)
    write_text(folder / "report.html", text)


@dataclass(frozen=True)
class DrawnCurve:
    """Steady motions of an equation swept one way: ``frequency_Hz``, ``amplitude``, ``phase`` (deg), each (n,)."""

    label: str
    frequency_Hz: Array
    amplitude: Array
    phase: Array


@dataclass(frozen=True)
class DrawnSet:
    """One trial's points as recorded, phases in deg; ``rising`` and ``unseen`` (held out) are masks (n,)."""

    name: str
    unit: str
    frequency_Hz: Array
    amplitude: Array
    phase: Array
    rising: np.ndarray
    unseen: np.ndarray
    curves: Sequence[DrawnCurve]


def set_picture(drawn: DrawnSet) -> str:
    """Amplitude above, phase below: triangles are measured (up or down as the frequency went, hollow where nobody
    fitted them), lines are the equation's."""
    with page_style():
        figure = new_figure(8.0, 5.0)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        for curve, style in zip(drawn.curves, ("-", "--"), strict=False):
            line = above.plot(curve.frequency_Hz, curve.amplitude, style, lw=1.0, label=curve.label)[0]
            below.plot(curve.frequency_Hz, curve.phase, style, lw=1.0, color=line.get_color())
        for way, marker, word in ((True, "^", "upward"), (False, "v", "downward")):
            for apart in (False, True):
                here = (drawn.rising == way) & (drawn.unseen == apart)
                if not here.any():
                    continue
                look = {"ls": "none", "marker": marker, "ms": 4.0, "color": "0.4"}
                look |= {"mfc": "none"} if apart else {}
                label = f"measured {word}{', not fitted' if apart else ''}"
                above.plot(drawn.frequency_Hz[here], drawn.amplitude[here], label=label, **look)
                below.plot(drawn.frequency_Hz[here], drawn.phase[here], **look)
        above.set_ylabel(f"amplitude, {drawn.unit}")
        above.legend()
        below.set(xlabel="frequency, Hz", ylabel="phase, deg")
        said = f"{escape(drawn.name)}: {drawn.frequency_Hz.size} points"
        return f"<figure>{svg_text(figure)}<figcaption>{said}</figcaption></figure>"
