"""One audit from config to audit.json and audit.html: tables read, checked, held against rivals.

Belongs here: cases from tables, the order of an audit. Does not belong here: reading tables (tables.py), checks
and rivals (audit), what the files look like (report/).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from undertow.audit.answer import answer
from undertow.audit.case import DryStructure, PrintedCase, Recipe, Row
from undertow.audit.comparisons import check_comparisons
from undertow.audit.findings import AuditFindings, CellFinding, SeriesFindings, Trend, WhatIf
from undertow.audit.forces import check_forces, water_share
from undertow.audit.headings import correct_units
from undertow.audit.identities import check_identities, with_releases
from undertow.audit.patterns import check_patterns, power_law
from undertow.audit.tables import ADDED_MASS, Constants, PublishedTable, dry_value, same_conditions
from undertow.audit.verdicts import judge
from undertow.campaign.audit.settings import AuditConfig, AuditSettings, TableSettings, load_audit
from undertow.campaign.audit.tables import read_table
from undertow.campaign.run.folder import safe_name
from undertow.campaign.run.workers import Progress
from undertow.equation.cells import closed_cell
from undertow.errors import ConfigError
from undertow.recording.recording import Condition
from undertow.report.audit_page import write_audit

MEASURED_STIFFNESS_ERROR = 0.003
"""Relative error of a stiffness that is put in place of a printed one: a period of three digits."""

LEAST_SCATTER = 1e-4
"""Relative scatter of a dry value below which its printed digits say nothing of it."""


def audit_to_folder(
    path: str | Path, out: str | Path | None = None, overrides: Sequence[str] = (), progress: Progress | None = None
) -> tuple[AuditFindings, Path]:
    """The audit of a config, written to ``out`` (default runs/<name>); the findings and the folder.

    Raises ConfigError where the config or a table is wrong, UndertowError where no rival can be tried.
    """
    config = load_audit(path, overrides)
    folder = Path(out) if out is not None else Path("runs") / safe_name(config.name)
    folder.mkdir(parents=True, exist_ok=True)
    findings = audit(config, progress)
    write_audit(findings, folder, config.resolved())
    return findings, folder


def audit(config: AuditConfig, progress: Progress | None = None) -> AuditFindings:
    """Everything that the tables of a config betray."""
    said, constants = config.laboratory, constants_of(config)
    tables, units = correct_units([read_table(config, name) for name in config.tables], constants)
    structures = dry_structures(tables, constants)
    said_so = check_identities(tables, constants)
    tables = with_releases(tables, constants)
    checks = [
        *units, *said_so, *check_patterns(tables, constants),
        *check_comparisons(tables, constants), *check_forces(tables, structures, constants),
    ]  # fmt: skip
    shares = [
        share
        for table in tables
        if table.recipe == "method2_printed" and (structure := structures.get(str(table.conditions.get(said.spring))))
        if (share := water_share(table, structure, constants, config.seed)) is not None
    ]
    series = []
    for i, one in enumerate(config.audits):
        if progress is not None:
            progress("audits", i, len(config.audits))
        series.append(_series(config, one, tables, structures, constants))
    if progress is not None:
        progress("audits", len(config.audits), len(config.audits))
    return AuditFindings(
        config.name,
        tuple(tables),
        tuple(checks),
        trends(tables),
        tuple(shares),
        tuple(series),
        _cells(config),
    )


def constants_of(config: AuditConfig) -> Constants:
    """What the laboratory states, as the checks and the cases take it."""
    said = config.laboratory
    return Constants(
        said.mass_kg, said.area_m2, said.submerged_volume_m3, said.spring, said.water, said.dry, said.density_kg_per_m3,
        said.gravity_m_per_s2,
    )  # fmt: skip


def dry_structures(tables: Sequence[PublishedTable], constants: Constants) -> dict[str, DryStructure]:
    """Each spring's k, c, mu from its dry table: mean, standard error, scatter from trial to trial."""
    springs = {
        str(table.conditions[constants.spring_key]) for table in tables if constants.spring_key in table.conditions
    }
    found = {}
    for spring in sorted(springs):
        values = [
            dry_value(tables, constants, spring, name) for name in ("stiffness", "damping", "friction_coefficient")
        ]
        if any(one.size < 2 for one in values):
            continue
        k, c, mu = values
        spread = [max(float(one.std(ddof=1)), LEAST_SCATTER * float(abs(one.mean()))) for one in values]
        root = math.sqrt(k.size)
        found[spring] = DryStructure(
            float(k.mean()), float(c.mean()), float(mu.mean()), spread[0] / float(k.mean()) / root, spread[1] / root,
            spread[2] / root, spread[0] / float(k.mean()), spread[1], spread[2],
            _by_period(tables, constants, spring),
        )  # fmt: skip
    return found


def _by_period(tables: Sequence[PublishedTable], constants: Constants, spring: str) -> float:
    """Stiffness by a spring's printed dry period and the mass, N/m; nan where no period is printed."""
    dry = {constants.spring_key: spring, constants.water_key: constants.dry}
    periods = [
        table.columns["period"].values[row]
        for table in tables
        if "period" in table.columns
        for row in range(table.rows)
        if same_conditions(table.at(row), dry, (constants.spring_key, constants.water_key))
    ]
    return constants.mass_kg * (2.0 * math.pi / float(np.mean(periods))) ** 2 if periods else math.nan


def cases_of(
    config: AuditConfig, said: AuditSettings, tables: Sequence[PublishedTable], structures: Mapping[str, DryStructure],
    constants: Constants,
) -> list[tuple[dict[str, Condition], PrintedCase]]:  # fmt: skip
    """The cases of one audit: rows that agree in ``group_by``, with the conditions they share.

    Raises ConfigError where a table has no recipe or no releases.
    """
    named = {table.name: table for table in tables}
    groups: dict[tuple[Condition, ...], list[Row]] = {}
    for name in said.tables:
        table = named[name]
        if table.recipe not in ("method1", "method2", "method2_printed"):
            raise ConfigError(
                f"audit {said.name!r}: table {name} has recipe {table.recipe!r}; state method1 or method2"
            )
        if "release" not in table.columns:
            raise ConfigError(f"audit {said.name!r}: table {name} has neither release nor energy; map one of them")
        release = table.columns["release"].values
        for i in range(table.rows):
            conditions = table.at(i)
            key = tuple(conditions.get(one, "") for one in said.group_by)
            groups.setdefault(key, []).append(
                _row(table, i, release[i], str(conditions.get(constants.spring_key)), config.tables[name])
            )
    return [
        (
            dict(zip(said.group_by, key, strict=True)),
            PrintedCase(
                _case_name(said.name, key), tuple(rows), structures,
                constants.mass_kg, constants.area_m2, constants.volume_range_m3, constants.density_kg_per_m3,
                constants.gravity_m_per_s2, said.own_added_mass,
            ),
        )
        for key, rows in groups.items()
    ]  # fmt: skip


def _case_name(name: str, key: tuple[Condition, ...]) -> str:
    return " ".join([name, *(f"{value:g}" if isinstance(value, float) else str(value) for value in key)])


def _row(table: PublishedTable, row: int, release: float, spring: str, said: TableSettings) -> Row:
    def cell(quantity: str) -> tuple[float, float]:
        column = table.columns.get(quantity)
        return (math.nan, 0.0) if column is None else (float(column.values[row]), float(column.half_digits[row]))

    (mass, mass_half), (drag, drag_half) = cell(ADDED_MASS), cell("drag_coefficient")
    recipe: Recipe = said.recipe  # type: ignore[assignment]
    return Row(table.title, spring, release, recipe, mass, drag, mass_half, drag_half, said.window_s)


def _series(
    config: AuditConfig, said: AuditSettings, tables: Sequence[PublishedTable], structures: Mapping[str, DryStructure],
    constants: Constants,
) -> SeriesFindings:  # fmt: skip
    pairs = cases_of(config, said, tables, structures, constants)
    cases, nodes = [case for _, case in pairs], said.nodes or config.nodes
    found = answer(cases, nodes, config.seed)
    others = []
    for name, stiffness in said.what_if.items():
        priors = {
            f"k.{spring}": (value / structures[spring].k - 1.0, MEASURED_STIFFNESS_ERROR)
            for spring, value in stiffness.items()
        }
        again = answer(cases, nodes, config.seed, priors)
        others.append(WhatIf(name, again, judge(again)))
    return SeriesFindings(
        said.name, said.tables, tuple(group for group, _ in pairs), found, judge(found), tuple(others)
    )


def trends(tables: Sequence[PublishedTable]) -> tuple[Trend, ...]:
    """How drag coefficient and added mass go with the release in every table that varies it."""
    found = []
    for table in tables:
        if "release" not in table.columns:
            continue
        size = table.columns["release"].values
        for quantity in ("drag_coefficient", ADDED_MASS):
            column = table.columns.get(quantity)
            if column is None or table.rows < 4 or np.any(column.values <= 0.0) or size.max() < 1.5 * size.min():
                continue
            if np.ptp(column.values) > 0.0:
                found.append(Trend(table.name, table.title, quantity, power_law(size, column.values)))
    return tuple(found)


def _cells(config: AuditConfig) -> tuple[CellFinding, ...]:
    cell = config.laboratory.cell
    if cell is None:
        return ()
    return tuple(
        CellFinding(level, closed_cell(width, depth, cell.length_m, config.laboratory.density_kg_per_m3))
        for level, width, depth in zip(cell.water_depth_m, cell.surface_width_m, cell.depth_m, strict=True)
    )
