"""The parts of a campaign's configuration, one model a section; every key says what it means.

Belongs here: keys, their types, their defaults. Does not belong here: recordings (recording_settings.py),
reading YAML (source.py), the whole and what follows from it (run_config.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator

from undertow.equation.registry import EQUATION_15
from undertow.recording.conditions import same_condition
from undertow.recording.recording import Condition

Real = Annotated[float, Field(strict=True)]
Positive = Annotated[float, Field(strict=True, gt=0.0)]
NotNegative = Annotated[float, Field(strict=True, ge=0.0)]
Whole = Annotated[int, Field(strict=True, ge=0)]
ColumnName = Annotated[str, Field(strict=True, min_length=1)] | Whole
Value = Annotated[str, Field(strict=True)] | Real


def by_kind(*kinds: str) -> Discriminator:
    """A discriminator by the YAML kind of a value, so that an error speaks of the kind that was meant."""

    def choose(value: Any) -> str:
        if isinstance(value, Mapping | BaseModel) and "table" in kinds:
            return "table"
        if isinstance(value, list | tuple) and "list" in kinds:
            return "list"
        return kinds[0]

    return Discriminator(choose)


class Section(BaseModel):
    """Base of every section: unknown keys are errors, nothing changes after loading, no NaN."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Table(BaseModel):
    """A value by a condition: ``{by: spring, long: 109592, short: 402036}``; keys are the condition's values (numbers,
    with a point or a comma, are equal within 1e-6 of them). With ``by`` alone the value is the condition's own number.
    """

    model_config = ConfigDict(extra="allow", frozen=True, allow_inf_nan=False)
    __pydantic_extra__: dict[str, Real] = Field(init=False)

    by: str = Field(description="Condition (column of the index, named group of the file name) that decides.")

    @model_validator(mode="before")
    @classmethod
    def _keys_are_texts(cls, data: Any) -> Any:
        return {str(key): value for key, value in data.items()} if isinstance(data, Mapping) else data

    @property
    def values(self) -> Mapping[str, float]:
        """Value of each key, as written."""
        return dict(self.__pydantic_extra__)

    def key_of(self, here: Condition | None) -> str | None:
        """The key that is this value of the condition; None where the table has none."""
        return next((key for key in self.__pydantic_extra__ if same_condition(key, here)), None)


Quantity = Annotated[Annotated[Real, Tag("number")] | Annotated[Table, Tag("table")], by_kind("number", "table")]
"""A number, or a table of numbers by a condition."""


class WindowSettings(Section):
    """The part of a recording to be used, in its own time."""

    start_s: Real | None = Field(default=None, description="First instant used, s.")
    end_s: Real | None = Field(default=None, description="Last instant used, s.")


class EverySettings(Section):
    """Hold out every n-th trial of a group, ordered by release amplitude."""

    every: Annotated[int, Field(strict=True, ge=2)] = Field(description="Every n-th trial, from the second on.")


class LargestSettings(Section):
    """Hold out the trials of the largest releases."""

    largest: Annotated[int, Field(strict=True, ge=1)] = Field(description="How many of the largest releases.")


def _holding(value: Any) -> str:
    if isinstance(value, Mapping):
        return "largest" if "largest" in value else "every"
    return value.__class__.__name__.lower().removesuffix("settings") if isinstance(value, BaseModel) else (
        "list" if isinstance(value, list | tuple) else "auto")  # fmt: skip


HoldOut = Annotated[
    Annotated[Literal["auto"], Tag("auto")]
    | Annotated[tuple[str, ...], Tag("list")]
    | Annotated[EverySettings, Tag("every")]
    | Annotated[LargestSettings, Tag("largest")],
    Discriminator(_holding),
]


def _none_is_null(value: Any) -> Any:
    return None if value == "none" else value


class TrialsSettings(Section):
    """Which trials belong together, which are dry, which are held out, which part of them is used."""

    group_by: tuple[str, ...] = Field(
        default=(), description="Conditions that a group shares; empty: all trials together."
    )
    dry: Annotated[dict[str, Value] | None, BeforeValidator(_none_is_null)] = Field(
        default=None, description="Conditions of the trials without water; none: nothing is known beforehand."
    )
    hold_out: HoldOut = Field(
        default="auto",
        description="Trials never fitted: auto, a list of files (as in the index, paths, stems, trials' names), every: "
        "n, largest: n.",
    )
    window: Annotated[
        Annotated[Literal["auto"], Tag("auto")] | Annotated[dict[str, WindowSettings], Tag("table")],
        by_kind("auto", "table"),
    ] = Field(default="auto", description="auto, or the part to be used by file name pattern; the last that fits wins.")
    conditions: dict[str, dict[str, Value]] = Field(default={}, description="Conditions by file name pattern.")
    decays: tuple[str, ...] = Field(
        default=(),
        description="Beside driven trials: those that nothing drives after their release, by file name pattern.",
    )
    hidden_at_release: Literal["rest", "free"] = Field(
        default="rest", description="State of hidden water at the release."
    )


class ScatterSettings(Section):
    """Trial-to-trial scatter: one standard deviation over the value, without a unit."""

    k: NotNegative = Field(default=0.0, description="Stiffness, 1 sigma over its value: 0.004 is 0.4 %.")
    c: NotNegative = Field(default=0.0, description="Viscous damping, 1 sigma over its value.")
    mu: NotNegative = Field(default=0.0, description="Friction coefficient, 1 sigma over its value.")


class CellSettings(Section):
    """Geometry of the water that may oscillate by itself, for the physical check of a hidden resonator."""

    surface_width_m: Quantity | None = Field(default=None, description="Width of the free surface along the motion, m.")
    depth_m: Quantity | None = Field(default=None, description="Depth of the water in a cell, m.")
    length_m: Quantity | None = Field(default=None, description="Length of all cells together, across the motion, m.")


class SpecimenSettings(Section):
    """What the laboratory knows. Every entry is optional: what is missing is identified, or stays per unit mass."""

    mass_kg: Quantity | None = Field(default=None, description="All that moves when dry, kg (kg m^2 in rotation).")
    stiffness_N_per_m: Quantity | None = Field(default=None, description="Stated spring, N/m (N m in rotation).")
    area_m2: Quantity | None = Field(default=None, description="Drag area, m^2; a level without one has 0 when dry.")
    water_density_kg_per_m3: Positive = Field(default=1000.0, description="Density of the water, kg/m^3.")
    gravity_m_per_s2: Positive = Field(default=9.81, description="Gravity, m/s^2, for the normal force.")
    submerged_volume_m3: Quantity | None = Field(
        default=None, description="Displaced water, m^3; absent means 0 when dry."
    )
    scatter: ScatterSettings | None = Field(
        default=None, description="Trial-to-trial scatter of k, c and mu, relative; absent: from the dry trials."
    )
    cell: CellSettings | None = Field(default=None, description="Cells whose water may slosh.")
    published: dict[str, Quantity] = Field(
        default={}, description="Published or expected values of parameters by their names in levels.csv "
        "(drag_coefficient ...), shown beside what is found; nothing is fitted to them.",
    )  # fmt: skip


class EquationSettings(Section):
    """The prescribed equation."""

    terms: tuple[str, ...] = Field(
        default=EQUATION_15,
        min_length=1,
        description="Terms beside the inertia, by their names in the registry (`undertow terms`).",
    )
    coordinate: Literal["translation", "rotation"] = Field(
        default="translation", description="m and N, or rad and N m."
    )


class DiscrepancySettings(Section):
    """What is looked for where the equation leaves something unexplained."""

    suspects: Annotated[
        Annotated[Literal["all"], Tag("all")] | Annotated[tuple[str, ...], Tag("list")], by_kind("all", "list")
    ] = Field(default="all", description="all, or the names to be tried.")
    budget: Positive = Field(
        default=1.0, description="How much a search may do, in multiples of the default (counted in integrator steps)."
    )

    @property
    def named(self) -> tuple[str, ...] | None:
        """The suspects that are named; None where all are tried."""
        return None if self.suspects == "all" else self.suspects
