"""The page's first screen: a sentence a water level, the trial that shows most, and a grid of springs by levels.

Belongs here: what stands there, as plain rows and texts. Does not belong here: the picture (trial_figures.py), the page
(html.py), everything of one group (blocks.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from undertow.discrepancy.findings import Findings, GroupFindings, TrialFindings
from undertow.discrepancy.naming import in_words
from undertow.discrepancy.repaired import named_laws
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import condition_words, either, least_sets, percent
from undertow.report.arrange import Span, spanning_conditions
from undertow.report.before_after import BEHIND, ON, errors_of
from undertow.report.behind import adjusted_words, allowed_words
from undertow.report.blocks import (
    NO_BREAK,
    Block,
    as_measured_words,
    few_words,
    identity,
    likelihood_words,
    sure_words,
)
from undertow.report.wording import confidence_words, unbroken

SENTENCES_AT_MOST = 8
"""Levels that have a sentence on the first screen: more would push the picture away."""

LINES_BESIDE, LINES_SPLIT = 12, 30
"""Lines of text that are as high as the picture without its numbers and caption, and with them, on a page of 1280
pixels."""

LETTERS_A_LINE, LINES_A_ROW = 58, 3
"""Letters of a sentence on half of the page, and lines that are as high as a row of boxes with its gap."""


@dataclass(frozen=True)
class Shown:
    """The trial on the first screen, its group, and the group's place among the findings'."""

    trial: TrialFindings
    group: GroupFindings
    place: int

    @property
    def repaired(self) -> bool:
        """Whether a free run of the repaired equation is drawn."""
        return self.trial.augmented is not None and bool(named_laws(self.group.verdict))

    @property
    def error(self) -> float:
        """Free-run error of the equation as prescribed."""
        return self.trial.mismatch.nrmse

    @property
    def gain(self) -> float:
        """By how much the repaired equation's free-run error is smaller."""
        after = math.nan if self.trial.augmented is None else self.trial.augmented.nrmse
        return self.error - after if math.isfinite(after) else -math.inf


def shown_trial(findings: Findings) -> Shown | None:
    """The held-out trial where what was found brings the free run closest; where nothing is named, the one with the
    largest error of the groups in which something is there, or of all. Only groups that hold none out show a trial that
    was fitted."""
    every = [Shown(t, g, i) for i, g in enumerate(findings.groups) for t in g.trials]
    every = [shown for shown in every if math.isfinite(shown.error)]
    unseen = [shown for shown in every if shown.trial.held_out]
    for some in ([s for s in unseen if s.repaired], [s for s in every if s.repaired]):
        if some:
            return max(some, key=lambda shown: shown.gain)
    there = [shown for shown in every if shown.group.verdict.verdict]
    seen = [s for s in unseen if s.group.verdict.verdict] or there or unseen or every
    return max(seen, key=lambda shown: shown.error, default=None)


def first_screen(findings: Findings, anchors: Sequence[str]) -> Block:
    """``sentences`` (with ``more`` of them), the trial that is ``shown`` with its numbers, the ``grid``, and
    the ``place`` of the sentences (`place_of`)."""
    said = level_sentences(findings)
    more = len(said) - SENTENCES_AT_MOST
    shown, boxes = shown_trial(findings), grid(findings, anchors)
    return {
        "tag": {},
        "sentences": said[:SENTENCES_AT_MOST],
        "more": f"{more} more in the table below" if more > 0 else "",
        "shown": {} if shown is None else trial_block(shown, anchors),
        "grid": boxes,
        "place": "" if shown is None else place_of(said[:SENTENCES_AT_MOST], boxes),
    }


def place_of(sentences: Sequence[Block], boxes: Block) -> str:
    """Where the boxes and sentences of a page stand: "beside" the picture, with its numbers and caption under them;
    "split", where numbers and caption keep to the picture, so that both sides are about as high; else (empty) the
    sentences stand under both, over the whole page.

    >>> boxes, said = [{"cells": [{}, {}]}], [{"title": "Depth 2 m", "text": "nothing is missing"}]
    >>> [place_of(many * said, {"columns": [], "rows": boxes}) for many in (1, 9, 40)]
    ['beside', 'split', '']
    """
    cells = [cell for row in boxes["rows"] for cell in row["cells"]]
    lines = sum(math.ceil(len(one["title"] + one["text"]) / LETTERS_A_LINE) + 0.5 for one in sentences)
    lines += LINES_A_ROW * len(boxes["columns"] or cells)  # a level is a row on a screen
    if len(cells) == 1 or lines <= LINES_BESIDE:
        return "beside"
    return "split" if lines <= LINES_SPLIT else ""


# ---------------------------------------------------------------- sentences
def level_sentences(findings: Findings) -> list[Block]:
    """One sentence a level (a group where levels do not tell groups apart): ``title``, ``text`` and ``tone``."""
    span = spanning_conditions(findings)
    if not _is_grid(findings, span):
        return [_sentence(group.label, [group], None) for group in findings.groups]
    levels: dict[float, list[GroupFindings]] = {}
    for group in findings.groups:
        levels.setdefault(span.level_of(group), []).append(group)
    titles = {level: unbroken(condition_words(span.level or "", level)) for level in levels}
    return [_sentence(titles[level], groups, span.series) for level, groups in sorted(levels.items())]


def _sentence(title: str, groups: Sequence[GroupFindings], series: str | None) -> Block:
    """What is said of a level's groups: those of which the same is said stand together."""
    alike: dict[str, list[GroupFindings]] = {}
    for group in groups:
        alike.setdefault(verdict_clause(group.verdict), []).append(group)
    parts = [f"{what} ({'; '.join(_size(g, series) for g in same)})" for what, same in alike.items()]
    tones = {identity(group, "")["tone"] for group in groups}
    loudest = next(tone for tone in ("open", "found", "unsure", "good") if tone in tones)
    return {"title": title[0].upper() + title[1:], "text": f"{'; '.join(parts)}.", "tone": loudest}


def verdict_clause(verdict: Verdict) -> str:
    """A verdict in one clause, without numbers."""
    names = " and ".join(_words(name, verdict) for name in named_laws(verdict))
    if verdict.status == "nothing_missing":
        return "nothing is missing"
    if verdict.status == "cannot_tell":
        return f"these data cannot tell whether anything is missing: {verdict.because.rstrip('.')}"
    if verdict.status == "present_but_small":
        if not names:
            return "something smaller than repetitions differ is there, and nothing that was tried explains it"
        return f"smaller than repetitions differ, the equation leaves out {names}"
    if not names:
        return "something is missing and nothing that was tried explains it"
    if verdict.status == "unknown":
        return f"nothing that was tried is proved to be all that is missing; what comes closest is {names}"
    if verdict.status == "not_identifiable":
        _, *others = least_sets((verdict.verdict, *verdict.alternatives))
        rivals = (" and ".join(_words(name, verdict) for name in rival) for rival in others)
        return f"the equation leaves out {either((names, *rivals))}; the data cannot tell which"
    if verdict.describes:
        return f"what the equation leaves out is described by {names}, not to the noise"
    return f"the equation leaves out {names}"


def _words(name: str, verdict: Verdict) -> str:
    """An effect in words, with what a second of its kind means; that it is water that oscillates is known only against
    dry trials."""
    rates = " at two rates" if verdict.verdict.count(name) > 1 else ""
    return in_words(name, of_water=verdict.origin == "water") + rates


def _size(group: GroupFindings, series: str | None) -> str:
    """How much is missing in a group, with what repeating the test would give."""
    verdict = group.verdict
    named = series is not None and series in group.key
    label = f"{condition_words(series or '', group.key[series or ''])}: " if named else ""
    allowed = percent(verdict.repeatability_nrmse)
    limit = "" if allowed == "-" else f", repeats within {allowed_words(verdict, verdict.repeatability_nrmse)}"
    if limit and is_no_gain(verdict):
        limit = f": no gain here, both within the {allowed} of repeats"
    return f"{label}{error_words(verdict)}{limit}".replace(" %", f"{NO_BREAK}%")


def is_no_gain(verdict: Verdict) -> bool:
    """Whether what is named does not lower the error on unseen trials of a group, and repeatability allows both: it was
    found on another spring of the same water."""
    if verdict.augmented is None:
        return False
    before, after = verdict.baseline.held_out_nrmse, verdict.augmented.held_out_nrmse
    return before < after <= verdict.repeatability_nrmse


def error_words(verdict: Verdict) -> str:
    """Free-run error of a group, before and after what is named, and on which trials.

    >>> from undertow.discrepancy.verdict import Described
    >>> error_words(Verdict({}, (), baseline=Described(0.4, 0.5), augmented=Described(0.02, 0.06)))
    'error 50 % → 6.0 % on unseen trials'
    """
    errors = errors_of(verdict.baseline, verdict.augmented)
    if errors is None:
        return f"error {percent(verdict.baseline.nrmse)}"
    before, after, seen = errors
    return f"error {percent(before)} → {percent(after)} on {ON[seen]}"


# ---------------------------------------------------------------- the trial that is shown
def trial_block(shown: Shown, anchors: Sequence[str]) -> Block:
    """The trial beside its picture: its name, group and ``numbers`` (value, and what it is)."""
    trial, verdict, found = shown.trial, shown.group.verdict, shown.trial.augmented if shown.repaired else None
    before = "error of the equation as prescribed" if found else "error of the equation"
    loud = "alarm" if trial.mismatch.missing else ""
    numbers = [{"value": percent(trial.mismatch.nrmse), "words": before, "tone": loud}]
    if found is not None:
        numbers.append({"value": percent(found.nrmse), "words": "error of the repaired equation", "tone": "good"})
    allowed, _, assumed = allowed_words(verdict, trial.mismatch.repeatability_nrmse).partition(", ")
    if allowed != "-":
        words = "what repeating the test would give in 95 % of trials, at most"
        words += f" ({assumed}, not measured)" if assumed else ""
        numbers.append({"value": allowed, "words": words, "tone": ""})
    if sure := how_sure(verdict):
        numbers.append({"value": sure, "words": likelihood_of(verdict), "tone": ""})
    for number in numbers:  # in large letters: short
        number["value"] = number["value"].replace("more than ", "> ")
    return {
        "name": trial.motion.name,
        "title": unbroken(shown.group.label),
        "anchor": anchors[shown.place],
        "held_out": trial.held_out,
        "repaired": shown.repaired,
        "colour": _colour_words(shown),
        "adjusted": adjusted_words(shown.group),
        "as_measured": as_measured_words(trial if shown.repaired else replace(trial, augmented=None)),
        "numbers": numbers,
    }


def _colour_words(shown: Shown) -> str:
    """Why a verdict is red beside an error that is inside the grey band; empty where it is not."""
    if shown.trial.mismatch.missing or identity(shown.group, "")["tone"] != "open":
        return ""
    return "The verdict is red although this trial is inside the band: what is missing is not known for certain"


def how_sure(verdict: Verdict) -> str:
    """How often such a verdict holds, of ``not_identifiable`` that of all its names together; "none" where nothing is
    said; empty where no such verdict was counted."""
    if verdict.status == "cannot_tell":
        return "none"
    together = verdict.status == "not_identifiable"
    return few_words(verdict) or (confidence_words(verdict.confidence) if together else likelihood_words(verdict))


def likelihood_of(verdict: Verdict) -> str:
    """Of what the probability that stands with a verdict is, or the counts where they are few."""
    if verdict.status == "cannot_tell":
        return "probability: these data do not tell, so nothing is claimed"
    if few_words(verdict):
        return "such answers held on sealed campaigns of known truth: too few for a percentage"
    whats = {"nothing_missing": "that nothing is missing", "not_identifiable": "that it is one of these"}
    what = whats.get(verdict.status, "of this answer")
    return f"probability {what}: as often as such verdicts held on sealed campaigns of known truth"


# ---------------------------------------------------------------- the grid
def grid(findings: Findings, anchors: Sequence[str]) -> Block:
    """Springs as rows, levels as columns, a cell a group: ``columns``, ``rows`` of ``head`` and ``cells`` (None where
    there is no group). One row of all groups, without columns, where springs and levels do not tell them apart."""
    span = spanning_conditions(findings)
    cells = [_cell(group, anchor) for group, anchor in zip(findings.groups, anchors, strict=True)]
    if not _is_grid(findings, span):
        return {"columns": [], "rows": [{"head": "", "cells": cells}]}
    places = {_place(group, span): cell for group, cell in zip(findings.groups, cells, strict=True)}
    levels = sorted({span.level_of(group) for group in findings.groups})
    series = dict.fromkeys(span.series_of(group) for group in findings.groups)
    head = span.series
    return {
        "columns": [unbroken(condition_words(span.level or "", level)) for level in levels],
        "rows": [
            {"head": "" if head is None else condition_words(head, one),
             "cells": [places.get((one, level)) for level in levels]}
            for one in series
        ],
    }  # fmt: skip


def _place(group: GroupFindings, span: Span) -> tuple[Any, float]:
    return span.series_of(group), span.level_of(group)


def _is_grid(findings: Findings, span: Span) -> bool:
    """Whether a spring and a level tell all groups apart, so that they can stand in rows and columns."""
    places = [_place(group, span) for group in findings.groups]
    return span.level is not None and len(set(places)) == len(places)


def _cell(group: GroupFindings, anchor: str) -> Block:
    """A group's cell: its name, tone and what is named (`identity`), its error as in its sentence, and how sure it is
    where such verdicts were counted."""
    short = error_words(group.verdict).removeprefix("error ")
    for seen, words in ON.items():
        short = short.replace(f" on {words}", f" ({BEHIND[seen]})" if BEHIND[seen] else "")
    short, sure = short.replace(" %", f"{NO_BREAK}%"), sure_words(group.verdict)
    return {**identity(group, anchor), "error": short, "sure": f"{sure} sure" if sure else ""}
