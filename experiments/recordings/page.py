"""docs/recordings.md from what make.py gathered: its tables.

Belongs here: tables and their order. Does not belong here: words (sections.py), runs, comparisons.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from experiments.recordings.sections import HEAD, SECTIONS, Section
from undertow.quantities import format_number

SYMBOLS = {
    "k_N_per_m_per_mass": ("k1", "1/s²"),
    "sine_restoring_N_per_mass": ("ks", "1/s²"),
    "c_Ns_per_m_per_mass": ("c1", "1/s"),
    "drag_Ns2_per_m2_per_mass": ("c2", "1/{m}"),
    "cubic_damping_Ns3_per_m3_per_mass": ("c3", "s/{m}²"),
    "friction_N_per_mass": ("c0", "{m}/s²"),
    "cubic_stiffness_N_per_m3_per_mass": ("k3", "1/(s² {m}²)"),
    "quintic_stiffness_N_per_m5_per_mass": ("k5", "1/(s² {m}⁴)"),
    "total_mass_kg": ("M", "kg"),
    "c_Ns_per_m": ("c", "N s/m"),
    "drag_Ns2_per_m2": ("q", "N s²/m²"),
    "mu": ("mu", ""),
}
"""Symbol and unit of a parameter on the page; {m} is the recording's own unit of displacement."""


def page(made: Mapping[str, Any]) -> str:
    """The whole page in Markdown."""
    parts = [HEAD.format(command=made["made_by"], commit=made["commit"][:12]), _judged(made["comparisons"])]
    studies = {study["study"]: study for study in made["studies"]}
    for section in SECTIONS:
        rows = [row for row in made["comparisons"] if row["study"] in section.studies]
        parts += [
            f"## {section.title}",
            section.about,
            _runs(section, [studies[name] for name in section.studies]),
            "Published, stated or checked independently, and ours:",
            _comparison(rows),
            section.conclusion,
        ]
    return "\n\n".join(parts) + "\n"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _with_error(value: float | None, error: float | None) -> str:
    if value is None:
        return ""
    if error is None:
        return f"{value:.5g}"
    return f"{format_number(value, error)} ± {format_number(error, error)}"


def _judged(rows: Sequence[Mapping[str, Any]]) -> str:
    """The limits set beforehand and whether they are met."""
    cells = [
        (
            row["study"], _where(row), f"{row['quantity']}, {row['unit']}", f"{row['published']:g}",
            _with_error(row["ours"], row["stderr"]), _percent(row["difference_percent"]), f"{row['limit_percent']:g}",
            "met" if row["met"] else "**not met**",
        )
        for row in rows
        if row["met"] is not None
    ]  # fmt: skip
    head = ("run", "trial", "quantity", "published", "ours", "difference, %", "limit, %", "")
    return "Limits that were set beforehand:\n\n" + _table(head, cells)


def _where(row: Mapping[str, Any]) -> str:
    words = [f"{k} {v:g}" if isinstance(v, float) else f"{k} {v}" for k, v in row["group"].items()]
    return ", ".join(part for part in (*words, row["trial"]) if part) or "all"


def _percent(value: float) -> str:
    """A difference in per cent with two digits, its sign and no power of ten."""
    return f"{value:+.0f}" if abs(value) >= 10.0 else f"{value:+.2g}"


def _comparison(rows: Sequence[Mapping[str, Any]]) -> str:
    sources = list(dict.fromkeys(row["source"] for row in rows))
    cells = [
        (
            row["study"], _where(row), f"{row['quantity']}, {row['unit']}", f"{row['published']:g}",
            f"[{sources.index(row['source']) + 1}]", _with_error(row["ours"], row["stderr"]),
            _percent(row["difference_percent"]), _with_error(row["sindy"], row["sindy_stderr"]),
        )
        for row in rows
    ]  # fmt: skip
    head = ("run", "trial", "quantity", "published", "source", "output error", "difference, %", "SINDy")
    notes = "  \n".join(f"[{i}] {source}" for i, source in enumerate(sources, 1))
    return f"{_table(head, cells)}\n\n{notes}"


def _runs(section: Section, studies: Sequence[Mapping[str, Any]]) -> str:
    """One row a run and group: coefficients by output error, and the free run's error beside its floors."""
    cells = []
    for study in studies:
        for group in study["groups"]:
            fit, trials = group["methods"]["output_error"], group["trials"]
            outcome = "" if fit["outcome"] == "ok" else f"; {fit['outcome']}"
            cells.append(
                (
                    study["study"],
                    _where({"group": group["group"], "trial": ""}),
                    _coefficients(fit["parameters"], section.unit) + outcome,
                    _range([1e3 * trial["rms"] if section.milli else trial["rms"] for trial in trials]),
                    _range([trial["nrmse"] for trial in trials]),
                    _range([trial["sensor_floor_nrmse"] for trial in trials]),
                    _range([trial["repeatability_nrmse"] for trial in trials]),
                    group["status"].replace("_", " "),
                )
            )
    unit = ("m" if section.milli else "") + section.scored
    found = ("coefficients (output error)", f"rms, {unit}", "nrmse", "sensors", "repeatability", "verdict")
    head = ("run", "group", *found)
    return _table(head, cells)


def _coefficients(parameters: Mapping[str, Any], unit: str) -> str:
    shown = []
    for name, (symbol, its_unit) in SYMBOLS.items():
        if name in parameters:
            one = parameters[name]
            shown.append(f"{symbol} {_with_error(one['value'], one['stderr'])} {its_unit.format(m=unit)}".strip())
    return "; ".join(shown)


def _range(values: Sequence[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:.3g}" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g} to {high:.3g}"
