"""The page of a driven campaign, in time or of harmonic sets, in the style of the page of decays (html.py): what was
found and how sure it is, the record beside its free runs or the curves through measured points, the equation, tables.

Belongs here: that page, from finished parts. Does not belong here: what the parts hold (campaign/driven/page.py,
campaign/response/page.py), drawing (driven_figures.py), style and macros (templates/).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from markupsafe import Markup

from undertow.discrepancy.findings import FailedTrial
from undertow.discrepancy.verdict import Described, Verdict
from undertow.discrepancy.words import group_title, percent
from undertow.equation.driven_laws import find_driven
from undertow.equation.equation import Equation
from undertow.equation.term import Term
from undertow.quantities import Estimate, Mover, or_nan
from undertow.report import blocks
from undertow.report.before_after import errors_of
from undertow.report.behind import number_row
from undertow.report.expressions import is_per_mass, numeric_latex
from undertow.report.first_screen import place_of, verdict_clause
from undertow.report.group_figures import equation_svg
from undertow.report.html import ROWS_AT_MOST, SEPARATOR, Inliner, anchors
from undertow.report.style import page_style
from undertow.report.wording import STATUS_WORDS, ordered_parameters
from undertow.report.writing import rendered, write_text

IN_TIME: Mapping[Mover, str] = {"force": "F(t)", "base": r"-M\,\ddot{y}(t)", "water": "0"}
HARMONIC: Mapping[Mover, str] = {"force": r"F\,\cos\,\omega t", "base": r"-M\,\ddot{y}(t)", "water": "0"}
"""What an equation is equal to, by what drives, in LaTeX."""

CALLED = "as prescribed", "repaired"
"""What the two equations of a run are called."""

_WHERE: Mapping[Mover, str] = {
    "force": "",
    "base": " x is relative to the base at y, and laws of the water go by the motion of x + y.",
    "water": " Laws of the water go by the body's motion relative to the water's.",
}
"""What the symbols of an equation mean, by what drives."""


@dataclass(frozen=True)
class Picture:
    """A figure as SVG and what stands under it."""

    svg: str
    caption: str


@dataclass(frozen=True)
class PageTable:
    """A table: its heading, rows of texts (the first the header), what stands under it, whether it is folded."""

    heading: str
    rows: Sequence[Sequence[str]]
    note: str = ""
    folded: bool = True


@dataclass(frozen=True)
class WrittenEquation:
    """An equation with its numbers by name (held ones without an error), and what drives: LaTeX, and its mover."""

    terms: Sequence[Term]
    numbers: Mapping[str, Estimate]
    drive: str = IN_TIME["force"]
    mover: Mover = "force"

    @property
    def equation(self) -> Equation:
        """The same as `Equation`: inner numbers in their terms."""
        terms = tuple(find_driven(term.name, **self._inner(term)) for term in self.terms)
        coefficients = tuple(self._value(term, term.coefficient.name) or 0.0 for term in self.terms)
        return Equation(terms, coefficients, self.numbers["mass_kg"].value)

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors as an `Equation` asks for them: "mass", a term's name, or term.parameter."""
        renamed = {f"{t.name}.{t.coefficient.name}": t.name for t in self.terms} | {"mass_kg": "mass"}
        return {renamed.get(name, name): one.total_stderr for name, one in self.numbers.items()}

    def _inner(self, term: Term) -> dict[str, float]:
        """A law's numbers beside its coefficient."""
        every = ((p.name, self._value(term, p.name)) for p in term.parameters[1:])
        return {name: value for name, value in every if value is not None}

    def _value(self, term: Term, parameter: str) -> float | None:
        found = self.numbers.get(f"{term.name}.{parameter}")
        return None if found is None else found.value


@dataclass(frozen=True)
class PagePart:
    """What a page shows of one group.

    ``verdict`` (None: a comparison of two files, which has none) and the ``sentence`` that goes with it, ``sure`` how
    sure it is, ``doubts`` about the recordings, ``notes`` of its section; the ``equation`` as prescribed and
    ``repaired`` (None: nothing was added), and what both are ``called``; the ``numbers`` of the first screen (value,
    what it is, tone) and its picture ``first``; ``pictures`` under the heading ``measured``, and ``tables``.
    ``unseen``: on what errors were counted.
    """

    verdict: Verdict | None
    sentence: str
    sure: str
    equation: WrittenEquation
    repaired: WrittenEquation | None
    numbers: Sequence[tuple[str, str, str]]
    first: Picture | None
    pictures: Sequence[Picture]
    tables: Sequence[PageTable]
    measured: str = "Measured against the free run"
    unseen: str = "samples that no fit had seen"
    doubts: Sequence[str] = ()
    notes: Sequence[str] = ()
    rotation: bool = False
    called: tuple[str, str] = CALLED

    @property
    def title(self) -> str:
        """What its section is called."""
        return "Both equations" if self.verdict is None else group_title(self.verdict.group)

    def identity(self, anchor: str) -> dict[str, Any]:
        """What names it and its verdict wherever it stands."""
        if self.verdict is None:
            return {"title": self.title, "anchor": anchor, "status": "", "tone": "", "names": ""}
        return blocks.identity_of(self.verdict, self.title, anchor)


@dataclass(frozen=True)
class Made:
    """How a page's run was made: its manifest, its config as text, and trials that could not be used."""

    manifest: Mapping[str, Any] = field(default_factory=dict)
    config_text: str = ""
    failed: Sequence[FailedTrial] = ()


def verdict_of(entry: Mapping[str, Any]) -> Verdict:
    """The verdict in a group's entry of verdict.json (`group_entry`), as the page of decays takes it."""

    def described(one: Mapping[str, Any] | None) -> Described:
        said = one or {}
        return Described(or_nan(said.get("nrmse")), or_nan(said.get("held_out_nrmse")), said.get("parameters", {}))

    return Verdict(
        entry["group"], tuple(entry["trials"]), tuple(entry["held_out"]), entry["status"], tuple(entry["verdict"]),
        tuple(map(tuple, entry["alternatives"])), baseline=described(entry["baseline"]),
        augmented=None if entry["augmented"] is None else described(entry["augmented"]),
        sensor_floor_nrmse=or_nan(entry["sensor_floor_nrmse"]),
        repeatability_nrmse=or_nan(entry["repeatability_nrmse"]), because=entry["because"], sentence=entry["sentence"],
    )  # fmt: skip


def page_html(title: str, kind: str, groups: Sequence[PagePart], made: Made) -> str:
    """The page as HTML, group by group; ``kind`` says what was recorded."""
    names = anchors([one.title for one in groups])
    failed, more = blocks.first_of(made.failed, ROWS_AT_MOST)
    best = _most_gained(groups)
    with page_style():
        drawn = {f"{name}{SEPARATOR}{key}": svg for one, name in zip(groups, names, strict=True)
                 for key, svg in _equations(one).items()}  # fmt: skip
        inline = Inliner(drawn | _pictures(groups, names))
        parts = [_group(one, name, inline.part(name)) for one, name in zip(groups, names, strict=True)]
    return rendered(
        "driven.html.j2", name=title, kind=kind, first=_first_screen(groups, names, best),
        across=_lead(groups), doubts=[d.rstrip(".") for one in groups for d in one.doubts],
        figures={"first": inline.part(names[best])["first"]} if groups[best].first else {},
        errors_said=_errors_said(groups[best]) if groups[best].verdict else "", groups=parts,
        failed=failed, more_failed=more, notes=[], more_notes="",
        manifest=blocks.provenance(made.manifest) if made.manifest else [], methods=[],
        config_text=Markup.escape(made.config_text),
    )  # fmt: skip


def write_page(folder: Path, text: str, groups: Sequence[PagePart]) -> None:
    """Write report.html, and the figures as files beside it."""
    (folder / "figures").mkdir(exist_ok=True)
    names = anchors([one.title for one in groups])
    for name, svg in _pictures(groups, names).items():
        write_text(folder / "figures" / f"{name}.svg", svg)
    write_text(folder / "report.html", text)


def table_block(table: PageTable) -> blocks.Block:
    """A table for its macro: columns of numbers stand at the right, each with its heading."""
    head, *rows = table.rows
    columns = [
        {"words": words, "number": _is_of_numbers([row[i] for row in rows])} for i, words in enumerate(head)
    ]
    return {"heading": table.heading, "columns": columns, "rows": rows, "note": table.note, "folded": table.folded,
            "narrow": max(len(cell) for row in rows for cell in row) <= NARROW}  # fmt: skip


NARROW = 24
"""Letters in a cell up to which a table is not spread over the page."""

_NUMBER = re.compile(r"[-−]?\d|open$|not known$|more than \d|less than \d|[-–]?$")


def _is_of_numbers(cells: Sequence[str]) -> bool:
    """Whether a column holds numbers, or what stands in a number's place."""
    return any(cells) and all(_NUMBER.match(cell) for cell in cells)


def _pictures(groups: Sequence[PagePart], names: Sequence[str]) -> dict[str, str]:
    """Every figure by the name of its file but typeset equations."""
    drawn: dict[str, str] = {}
    for one, name in zip(groups, names, strict=True):
        drawn |= {f"{name}{SEPARATOR}run-{i + 1}": picture.svg for i, picture in enumerate(one.pictures)}
        if one.first is not None:
            drawn[f"{name}{SEPARATOR}first"] = one.first.svg
    return drawn


def _equations(one: PagePart) -> dict[str, str]:
    """Both equations typeset, for a desk and for a phone."""
    drawn: dict[str, str] = {}
    for key, driven in _written(one).items():
        for place, slim in ((key, False), (f"{key}-slim", True)):
            drawn[place] = equation_svg(driven.equation, driven.errors, slim, _drive(driven), one.rotation)
    return drawn


def _written(one: PagePart) -> dict[str, WrittenEquation]:
    both = {"equation": one.equation, "repaired": one.repaired}
    return {key: driven for key, driven in both.items() if driven is not None}


def _drive(driven: WrittenEquation) -> str:
    """What stands on the right of an equation; per unit mass a base's acceleration alone."""
    alone = is_per_mass(driven.equation, driven.errors)
    return driven.drive.replace(r"-M\,", "-") if alone else driven.drive


def _most_gained(groups: Sequence[PagePart]) -> int:
    """The group on the first screen: where what was found takes most of the error away, else the largest error."""

    def gained(one: PagePart) -> tuple[bool, float]:
        before, after = (math.nan, None) if one.verdict is None else _errors(one.verdict)
        return after is not None, before - (after or 0.0) if math.isfinite(before) else 0.0

    return max(range(len(groups)), key=lambda i: (groups[i].first is not None, *gained(groups[i])))


def _errors(verdict: Verdict) -> tuple[float, float | None]:
    """Error as prescribed and (None: nothing was added) repaired: on what was held back where it is known."""
    both = errors_of(verdict.baseline, verdict.augmented)
    if both is not None:
        return both[0], both[1]
    unseen = verdict.baseline.held_out_nrmse
    return (unseen if math.isfinite(unseen) else verdict.baseline.nrmse), None


def error_words(verdict: Verdict) -> str:
    """Errors before and after what was added."""
    before, after = _errors(verdict)
    return percent(before) if after is None else f"{percent(before)} → {percent(after)}"


def _errors_said(one: PagePart) -> str:
    """What an error is, for the text under the first screen."""
    driven = "under the input as it was measured" if "points" not in one.unseen else "at every point's own drive"
    return (
        f"Error: the equation is integrated {driven}, nothing of the motion is fed back; RMS error over RMS motion, "
        f"before → after what was found, on {one.unseen}."
    )


def _lead(groups: Sequence[PagePart]) -> str:
    """The first sentence of the page: of one group what was found, of several how many of which kind."""
    verdicts = [one.verdict for one in groups if one.verdict is not None]
    if not verdicts:
        return groups[0].sentence
    if len(groups) == 1:
        clause = verdict_clause(verdicts[0])
        return f"{clause[:1].upper()}{clause[1:]}."
    kinds: dict[str, int] = {}
    for verdict in verdicts:
        status = STATUS_WORDS[verdict.status].removesuffix(" with")
        kinds[status] = kinds.get(status, 0) + 1
    return f"{len(groups)} groups: {', '.join(f'{number} {status}' for status, number in kinds.items())}."


def _first_screen(groups: Sequence[PagePart], names: Sequence[str], best: int) -> blocks.Block:
    """Tag, sentences, picture with its numbers, and a link a group."""
    shown = groups[best]
    identities = [one.identity(name) for one, name in zip(groups, names, strict=True)]
    said = [{"title": "Proof" if len(groups) == 1 else i["title"], "text": one.sentence, "tone": i["tone"]}
            for one, i in zip(groups, identities, strict=True) if one.verdict is not None]  # fmt: skip
    sure = "How sure" if len(groups) == 1 else f"How sure ({shown.title})"
    said += [{"title": sure, "text": shown.sure, "tone": identities[best]["tone"]}] if shown.sure else []
    cells = [{**i, "error": error_words(one.verdict).replace(" %", f"{blocks.NO_BREAK}%"), "sure": ""}
             for one, i in zip(groups, identities, strict=True) if one.verdict is not None]  # fmt: skip
    numbers = [
        {"value": value.replace("more than ", "> "), "words": words, "tone": tone}
        for value, words, tone in shown.numbers
    ]
    boxes = {"columns": [], "rows": [{"head": "", "cells": cells}]}
    return {
        "tag": {"words": identities[0]["status"], "tone": identities[0]["tone"]} if len(groups) == 1 and said else {},
        "sentences": said, "more": "",
        "place": "" if not shown.first else "beside" if len(groups) == 1 else place_of(said, boxes),
        "shown": {"caption": shown.first.caption, "numbers": numbers} if shown.first else {},
        "grid": boxes,
    }  # fmt: skip


def _group(one: PagePart, name: str, figures: Mapping[str, Markup]) -> blocks.Block:
    """One group's section."""
    written = _written(one)
    latex = [numeric_latex(d.equation, d.errors, _drive(d), one.rotation) for d in written.values()]
    text = [d.equation.text(d.errors) for d in written.values()]
    names = ordered_parameters(n for d in written.values() for n in d.numbers)
    after = {} if one.repaired is None else one.repaired.numbers
    before = one.equation.numbers
    rows = [number_row(n, _turned(one, before.get(n)), _turned(one, after.get(n))) for n in names]
    return {
        **one.identity(name), "called": one.called,
        "sentence": one.sentence if one.verdict else "", "sure": one.sure, "notes": one.notes,
        "rows": rows if one.verdict else [],
        "equations": [
            {"figure": figures[key], "slim": figures[f"{key}-slim"], "caption": _caption(one, key, driven)}
            for key, driven in written.items()
        ],
        "believe": _believe(one),
        "latex": [*latex, *(t.replace(" = 0", " = what drives it", 1) for t in text)],
        "measured": one.measured,
        "pictures": [
            {"figure": figures[f"run-{i + 1}"], "caption": picture.caption} for i, picture in enumerate(one.pictures)
        ],
        "tables": [table_block(table) for table in one.tables],
    }  # fmt: skip


def _believe(one: PagePart) -> str:
    """Which of two numbers to believe; empty where there are not two, or more is missing."""
    if one.repaired is None or one.verdict is None or one.verdict.status == "unknown":
        return ""
    return (
        "Where both give a number, believe the repaired one: the prescribed equation bends its own parameters to make "
        "up for what it leaves out."
    )


def _turned(one: PagePart, number: Estimate | None) -> Estimate | None:
    """A number with the unit of a rotation where an angle is the coordinate."""
    return number if number is None or not one.rotation else number.in_rotation()


def _caption(one: PagePart, key: str, driven: WrittenEquation) -> Markup:
    """What stands under an equation."""
    size = "inertia" if one.rotation else "mass"
    per_mass = f"; per unit {size}: nothing anchors it" if is_per_mass(driven.equation, driven.errors) else ""
    turned = "; an angle in rad moves, so that mass means inertia and force means moment" if one.rotation else ""
    what = " with its numbers from all that was recorded, one standard error, SI units"
    if one.called != CALLED:
        said = one.called[key == "repaired"]
        return Markup(f"<b>{said[:1].upper()}{said[1:]}</b>:{what[5:]}{per_mass}{turned}.{_WHERE[driven.mover]}")
    if key == "repaired":
        return Markup("<b>Repaired</b>: with what was found missing, all its numbers fitted together.")
    told = "The" if one.repaired is None else "<b>As prescribed</b>: the"
    return Markup(f"{told} config's equation{what}{per_mass}{turned}.{_WHERE[driven.mover]}")
