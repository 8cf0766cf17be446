"""The configuration of an audit: what a laboratory states, tables with mapped columns, which of them are audited
together.

Belongs here: sections and their checks. Does not belong here: reading tables, running (audit.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PrivateAttr, model_validator

from undertow.audit.tables import QUANTITIES
from undertow.campaign.config.settings import Section
from undertow.campaign.config.source import read_source, validated
from undertow.errors import ConfigError
from undertow.recording.recording import Condition

Nodes = Annotated[int, Field(strict=True, ge=8)]
Positive = Annotated[float, Field(gt=0.0)]


class WallSettings(Section):
    """Still water between walls, by water: for the prediction without any fit."""

    water_depth_m: tuple[float, ...] = Field(description="Values of the water's condition.")
    surface_width_m: tuple[Positive, ...] = Field(description="Width of one cell's surface, m.")
    depth_m: tuple[Positive, ...] = Field(description="Depth of the water in a cell, m.")
    length_m: Positive = Field(description="Length of all cells together, m.")

    @model_validator(mode="after")
    def _same_length(self) -> WallSettings:
        if not len(self.water_depth_m) == len(self.surface_width_m) == len(self.depth_m):
            raise ValueError(
                f"water_depth_m, surface_width_m, depth_m must have one value a level, got {len(self.water_depth_m)}, "
                f"{len(self.surface_width_m)}, {len(self.depth_m)}"
            )
        return self


class LaboratorySettings(Section):
    """What is stated for all tables."""

    mass_kg: Positive = Field(description="Moving mass in air, kg.")
    area_m2: Positive = Field(description="Area of the drag coefficients, m^2.")
    submerged_volume_m3: tuple[float, float] = Field(
        default=(0.0, 0.0), description="Submerged volume, m^3: smallest and largest possible."
    )
    spring: str = Field(default="spring", description="Condition that chooses the structure.")
    water: str = Field(default="water_depth_m", description="Condition that chooses the water.")
    dry: Condition = Field(description="Its value in which there is no water.")
    density_kg_per_m3: Positive = Field(default=1000.0, description="Water's density.")
    gravity_m_per_s2: Positive = Field(default=9.81, description="Gravity.")
    cell: WallSettings | None = Field(default=None, description="Cells of standing water.")


class ColumnSettings(Section):
    """Where a quantity stands and in which unit its heading says."""

    column: str = Field(description="Column of the file, or the key of its row.")
    unit: str = Field(description="Unit of the printed heading.")


class TableSettings(Section):
    """One published table."""

    title: str = Field(description="What it is called in sentences.")
    file: str = Field(description="CSV file, relative to the config.")
    recipe: Literal["", "envelope", "method1", "method2", "method2_printed"] = Field(
        default="", description="What made the coefficients: the decay's envelope, Method 1, Method 2."
    )
    window_s: Positive = Field(default=10.0, description="Longest history that Method 1 fitted, s.")
    conditions: Mapping[str, Condition] = Field(default={}, description="Conditions of the whole table.")
    row_conditions: tuple[str, ...] = Field(default=(), description="Columns that are conditions.")
    key: str = Field(default="", description="Column of names where the table has one quantity a row.")
    value: str = Field(default="", description="Column of values then.")
    columns: Mapping[str, ColumnSettings] = Field(description="Quantity -> column and unit.")

    @model_validator(mode="after")
    def _known_quantities(self) -> TableSettings:
        for name in self.columns:
            if name not in QUANTITIES:
                raise ValueError(f"quantity {name!r} is not known; a column may be {', '.join(QUANTITIES)}")
        return self


class AuditSettings(Section):
    """Tables that are audited together."""

    name: str = Field(min_length=1, description="What it is called.")
    tables: tuple[str, ...] = Field(min_length=1, description="Names of tables.")
    group_by: tuple[str, ...] = Field(default=(), description="Rows that agree in these share one water.")
    own_added_mass: bool = Field(default=False, description="Each spring has an added mass of its own.")
    nodes: Nodes | None = Field(default=None, description="Pieces of a resonator's range of frequencies.")
    what_if: Mapping[str, Mapping[str, Positive]] = Field(
        default={}, description="Name -> stiffness by spring (N/m): the audit is repeated with it."
    )


class AuditConfig(Section):
    """A whole audit, as `load_audit` read it."""

    name: str = Field(min_length=1, description="Name; the folder is called after it.")
    laboratory: LaboratorySettings = Field(description="What is stated for all tables.")
    tables: Mapping[str, TableSettings] = Field(min_length=1, description="The tables.")
    audits: tuple[AuditSettings, ...] = Field(default=(), description="Which tables are audited against rivals.")
    nodes: Nodes = Field(default=16, description="The same, by default.")
    seed: Annotated[int, Field(strict=True, ge=0)] = Field(default=0, description="Seed of every draw.")
    _folder: Path = PrivateAttr(default=Path("."))

    @model_validator(mode="after")
    def _tables_exist(self) -> AuditConfig:
        for audit in self.audits:
            for name in audit.tables:
                if name not in self.tables:
                    raise ValueError(f"audit {audit.name!r} names table {name!r}; there are {', '.join(self.tables)}")
        return self

    @property
    def folder(self) -> Path:
        """Folder of the config's file, which its paths are relative to."""
        return self._folder

    def resolved(self) -> dict[str, Any]:
        """The whole config with defaults, as plain values; files are absolute."""
        plain: dict[str, Any] = self.model_dump(mode="json", exclude_none=True)
        for table in plain["tables"].values():
            table["file"] = str((self.folder / table["file"]).absolute())
        return plain


def load_audit(path: str | Path, overrides: Sequence[str] = ()) -> AuditConfig:
    """An audit's config file, checked as a whole.

    Raises ConfigError with one line a problem: the file's line, the key, what was written, what it should be.
    """
    source = read_source(Path(path), overrides)
    if "recordings" in source.data:
        raise ConfigError(f"{path} is a config of recordings, for undertow run; an audit's has laboratory and tables")
    config = validated(AuditConfig, source)
    config._folder = Path(path).absolute().parent
    return config
