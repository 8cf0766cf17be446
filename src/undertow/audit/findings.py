"""Everything an audit found, as its files and page show it: frozen results.

Belongs here: results and audit.json's shape. Does not belong here: how they were found (campaign/audit.py), drawing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from undertow.audit.answer import Answer
from undertow.audit.forces import WaterShare
from undertow.audit.identities import Oddity
from undertow.audit.patterns import PowerLaw
from undertow.audit.tables import QUANTITIES, PublishedTable
from undertow.audit.verdicts import Range, SeriesVerdict
from undertow.equation.cells import CellModes
from undertow.recording.recording import Condition

CONTRACT = 1
"""Version of audit.json."""


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
