"""Everything an audit found, as its files and page show it: frozen results.

Belongs here: results and audit.json's shape. Does not belong here: how they were found (campaign/audit.py), drawing.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from undertow.audit.answer import Answer
from undertow.audit.comparisons import REPEATED
from undertow.audit.forces import WaterShare
from undertow.audit.identities import Oddity
from undertow.audit.patterns import PowerLaw
from undertow.audit.tables import QUANTITIES, WORDS, PublishedTable
from undertow.audit.verdicts import Range, SeriesVerdict
from undertow.equation.cells import CellModes
from undertow.recording.recording import Condition

CONTRACT = 1
"""Version of audit.json."""

TWICE = "same quantity"
"""The rule of a quantity that two tables print differently."""

_COMMON = re.compile(r"\((\d+ of \d+) common rows")
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


@dataclass(frozen=True)
class Trend:
    """How one quantity of a table goes with the release."""

    table: str
    title: str
    quantity: str
    law: PowerLaw

    @property
    def sentence(self) -> str:
        """In words, with the 95 % interval, beside what Eq. 15 with constant coefficients would have."""
        name = "C_d" if self.quantity == "drag_coefficient" else "m_a"
        return (
            f"{self.title}: {name} goes with the release to the power {self.law.exponent:.2f} +- "
            f"{self.law.half_width_95:.2f} (95 %, {self.law.rows} rows); Eq. 15 with constant coefficients has 0."
        )


@dataclass(frozen=True)
class CellFinding:
    """The closed cell's modes at one water."""

    water: float
    modes: CellModes


@dataclass(frozen=True)
class WhatIf:
    """An audit repeated with another stiffness."""

    name: str
    answer: Answer
    verdict: SeriesVerdict


@dataclass(frozen=True)
class SeriesFindings:
    """One audit: tables, the conditions of each case, all rivals, the verdict, the same under other assumptions."""

    name: str
    tables: tuple[str, ...]
    groups: tuple[Mapping[str, Condition], ...]
    answer: Answer
    verdict: SeriesVerdict
    what_if: tuple[WhatIf, ...] = ()


@dataclass(frozen=True)
class AuditFindings:
    """A whole audit."""

    name: str
    tables: tuple[PublishedTable, ...]
    checks: tuple[Oddity, ...]
    trends: tuple[Trend, ...]
    shares: tuple[WaterShare, ...]
    series: tuple[SeriesFindings, ...]
    cells: tuple[CellFinding, ...]

    @property
    def lead(self) -> str:
        """What the tables contradict, and what follows for their numbers, in two sentences."""
        often = Counter(check.rule for check in self.checks).most_common(1)
        text = "No two numbers of these tables contradict each other."
        if often:
            rule, times = often[0]
            most = "where one quantity is printed twice with different values" if rule == TWICE else f"by {rule}"
            text = (
                f"These tables contradict themselves, each other or the equation in {len(self.checks)} places, most "
                f"often ({times}) {most}."
            )
        tried, bent = len(self.series), [one for one in self.series if one.verdict.verdict]
        if not bent:
            return f"{text} Eq. 15 with constant coefficients stands in every table that was tried." if tried else text
        named = sum(one.verdict.status == "explained" for one in bent)
        left = f", and open for {len(bent) - named}" if named < len(bent) else ""
        return (
            f"{text} Their added masses and drag coefficients are no constants of the water: Eq. 15 alone prints "
            f"{tried - len(bent)} of {tried} tables or pairs of tables that were tried; what prints them is named for "
            f"{named}{left}."
        )

    def together(self) -> list[tuple[str, list[str]]]:
        """Rule and sentences of the checks, those that say the same of several tables or levels as one."""
        titles = {table.name: table.title for table in self.tables}
        alike: dict[tuple[str, ...], list[Oddity]] = {}
        for one in self.checks:
            rest = () if one.rule == TWICE else (_NUMBER.sub("#", one.sentence),)
            alike.setdefault((one.rule, one.quantity, *rest), []).append(one)
        return [
            (rule, _printed_twice(same, titles) if rule == TWICE else [merged([one.sentence for one in same])])
            for (rule, *_), same in alike.items()
        ]

    def plain(self) -> dict[str, Any]:
        """The contents of audit.json: numbers, names of the contract, sentences; nan is null."""
        return {
            "contract": CONTRACT,
            "name": self.name,
            "checks": [_oddity(one) for one in self.checks],
            "trends": [
                {
                    "table": one.table, "quantity": one.quantity, "exponent": one.law.exponent,
                    "stderr": one.law.stderr, "half_width_95": one.law.half_width_95, "rows": one.law.rows,
                    "sentence": one.sentence,
                }
                for one in self.trends
            ],
            "water_share": [
                {
                    "table": one.table, "release_m": one.release_m.tolist(), "printed": one.printed.tolist(),
                    "dry_low": one.dry_low.tolist(), "dry_high": one.dry_high.tolist(),
                    "share_low": one.share_low.tolist(), "share_high": one.share_high.tolist(),
                    "sentence": one.sentence,
                }
                for one in self.shares
            ],
            "cells": [
                {
                    "water": one.water, "natural_frequency_rad_per_s": float(one.modes.frequencies_rad_per_s[0]),
                    "mass_kg": float(one.modes.masses_kg[0]), "rigid_mass_kg": one.modes.rigid_mass_kg,
                    "water_kg": one.modes.water_kg,
                }
                for one in self.cells
            ],
            "tables": [_series(one) for one in self.series],
        }  # fmt: skip


def merged(sentences: Sequence[str]) -> str:
    """Sentences that differ in numbers alone as one, each number that differs with all its values.

    >>> merged(["Table 5: c is 3 of 9 rows.", "Table 7: c is 4 of 9 rows."])
    'Tables 5 and 7: c is 3 and 4 of 9 rows.'
    """
    words = _NUMBER.split(sentences[0])
    all_numbers = zip(*map(_NUMBER.findall, sentences), strict=True)
    numbers = [each if len(set(each)) > 1 else each[:1] for each in all_numbers]
    said = [f"{', '.join(each[:-1])} and {each[-1]}" if len(each) > 1 else each[0] for each in numbers]
    text = "".join(word + number for word, number in zip(words, [*said, ""], strict=True))
    return re.sub(r"^Table (?=\d+(?:, \d+)* and \d)", "Tables ", text)


def _printed_twice(same: Sequence[Oddity], titles: Mapping[str, str]) -> list[str]:
    """One quantity in several pairs of tables: what it is, then a line a pair."""
    if len(same) == 1:
        return [same[0].sentence]
    unit = "" if same[0].unit == "1" else f" {same[0].unit}"
    limit = f"more than {100.0 * REPEATED:.0f} %"
    lines = [f"The same {WORDS[same[0].quantity]} differs by {limit} between two tables (the worst row of each pair):"]
    for one in same:
        common = _COMMON.search(one.sentence)
        rows = f", {common[1]} common rows" if common else ""
        pair = " and ".join(titles.get(name, name) for name in one.tables)
        lines.append(f"{pair}: {one.expected:.5g} and {one.printed:.5g}{unit}{rows}")
    return lines


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _oddity(one: Oddity) -> dict[str, Any]:
    return {
        "rule": one.rule, "tables": list(one.tables), "quantity": one.quantity, "printed": _number(one.printed),
        "expected": _number(one.expected), "unit": one.unit or QUANTITIES.get(one.quantity, ""),
        "sentence": one.sentence,
    }  # fmt: skip


def _ranges(groups: Mapping[str, Mapping[str, Range]]) -> dict[str, Any]:
    return {
        effect: {
            name: {"value": r.value, "stderr": r.stderr, "low": r.low, "high": r.high, "unit": r.unit}
            for name, r in group.items()
        }
        for effect, group in groups.items()
    }


def _verdict(one: SeriesVerdict, answer: Answer, groups: tuple[Mapping[str, Condition], ...]) -> dict[str, Any]:
    return {
        "status": one.status,
        "verdict": list(one.verdict),
        "alternatives": [list(names) for names in one.alternatives],
        "confidence": one.confidence,
        "informs_about_water": one.informs_about_water,
        "groups": [
            {"group": dict(group), "parameters": _ranges(parameters)}
            for group, parameters in zip(groups, one.parameters, strict=True)
        ],
        "alternative_parameters": {
            label: [_ranges(parameters) for parameters in each] for label, each in one.others.items()
        },
        "rivals": [
            {
                "names": list(weight.rival.effects), "water": weight.rival.water, "probability": weight.probability,
                "log_evidence": weight.log_evidence,
                "scatter_kg": [posterior.mass_scatter_kg for posterior in weight.posteriors],
                "scatter_drag": [posterior.drag_scatter for posterior in weight.posteriors],
            }
            for weight in answer.weights
        ],
        "not_tried": dict(answer.failed),
        "equation_15_probability": [
            {"rows_scatter_at_most_of_mass": cap, "probability": share} for cap, share in one.equation_if.items()
        ],
        "next_test": one.next_test,
        "sentence": one.sentence,
    }  # fmt: skip


def _series(one: SeriesFindings) -> dict[str, Any]:
    return {
        "name": one.name,
        "tables": list(one.tables),
        **_verdict(one.verdict, one.answer, one.groups),
        "what_if": {again.name: _verdict(again.verdict, again.answer, one.groups) for again in one.what_if},
    }
