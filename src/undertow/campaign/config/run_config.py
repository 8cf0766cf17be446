"""The configuration of a campaign: loading it, judging it, and what follows from it for a trial.

Belongs here: `RunConfig`, `load`, the schema for editors. Does not belong here: sections (settings.py,
recording_settings.py), what contradicts what (rules.py), YAML (source.py), running (course.py).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, PrivateAttr

from undertow.campaign.config.described import ByPattern, described
from undertow.campaign.config.driven_rules import methods_of
from undertow.campaign.config.recording_settings import RecordingsSettings
from undertow.campaign.config.rules import contradictions
from undertow.campaign.config.settings import (
    DiscrepancySettings,
    EquationSettings,
    Quantity,
    Section,
    SpecimenSettings,
    Table,
    TrialsSettings,
    WindowSettings,
)
from undertow.campaign.config.source import Location, Source, read_source, validated
from undertow.errors import ConfigError
from undertow.likelihood.fit import Specimen
from undertow.recording.catalogue import Catalogue, TimeWindow
from undertow.recording.conditions import condition, same_condition
from undertow.recording.recording import Condition

Method = Literal["decay", "sindy", "method1", "method2", "output_error"]
GroupKey = tuple[tuple[str, Condition], ...]


class RunConfig(Section):
    """A whole campaign, as `load` read it. Paths are relative to `folder`."""

    name: str = Field(min_length=1, description="Name of the campaign; the run folder is called after it.")
    recordings: RecordingsSettings = Field(description="Where the recordings are and how they are read.")
    trials: TrialsSettings = Field(default=TrialsSettings(), description="Groups, dry trials, windows.")
    specimen: SpecimenSettings = Field(default=SpecimenSettings(), description="What the laboratory knows.")
    equation: EquationSettings = Field(
        default=EquationSettings(), description="Terms and coordinate of the prescribed equation."
    )
    identify: tuple[Method, ...] = Field(
        default=("decay", "sindy", "method1", "method2", "output_error"),
        min_length=1,
        description="Identifiers that are run; of driven bodies sindy and output_error, of harmonic sets output_error.",
    )
    discrepancy: DiscrepancySettings = Field(
        default=DiscrepancySettings(), description="What is looked for where something is unexplained."
    )
    seed: int = Field(default=0, strict=True, ge=0, description="Seed of everything random.")
    _folder: Path = PrivateAttr(default=Path("."))
    _source: Source | None = PrivateAttr(default=None)
    _mass_error_kg: float = PrivateAttr(default=0.0)

    @property
    def folder(self) -> Path:
        """Folder of the config's file, which its paths are relative to."""
        return self._folder

    @property
    def methods(self) -> tuple[str, ...]:
        """Identifiers that a run uses: those named, else all that apply to its trials."""
        return methods_of(self)

    def place(self, location: Location) -> str:
        """Where a key was written: ``config.yaml line 12``, ``--set seed=x``; ``config`` where it came from no file."""
        return "config" if self._source is None else self._source.place(location)

    def catalogue(self) -> Catalogue:
        """The recordings as the recording package describes them."""
        said, trials = self.recordings, self.trials
        files = described(said)
        windows = {} if trials.window == "auto" else trials.window
        conditions = {
            pattern: {name: condition(value) if isinstance(value, str) else value for name, value in more.items()}
            for pattern, more in trials.conditions.items()
        }
        return Catalogue(
            self.folder, files.channels, files.time, said.index, said.index_column, said.file, said.files, said.pattern,
            said.exclude, files.layout, files.despike, conditions,
            {pattern: _limits(one) for pattern, one in windows.items()}, self.equation.coordinate,
            said.index_separator, said.index_decimal, said.accept, ByPattern(said) if said.layouts else None,
            {pattern: tuple(map(_limits, parts)) for pattern, parts in said.releases.items()},
        )  # fmt: skip

    def is_dry(self, conditions: Mapping[str, Condition]) -> bool:
        """Whether a trial has every condition of ``trials.dry``; False where the config has none."""
        dry = self.trials.dry
        return bool(dry) and all(same_condition(conditions.get(key), value) for key, value in (dry or {}).items())

    def group_key(self, conditions: Mapping[str, Condition]) -> GroupKey:
        """A trial's group: its ``group_by`` conditions in their order. ConfigError where it lacks one."""
        for column in self.trials.group_by:
            if column not in conditions:
                have = ", ".join(conditions) or "none"
                raise ConfigError(f"trials.group_by: a trial has no condition {column!r}; it has {have}")
        return tuple((column, conditions[column]) for column in self.trials.group_by)

    def with_mass(self, mass_kg: float, error_kg: float) -> RunConfig:
        """The same config with a mass that was found, and its standard error, kg."""
        known = self.model_copy(update={"specimen": self.specimen.model_copy(update={"mass_kg": mass_kg})})
        known._mass_error_kg = error_kg
        return known

    def specimen_for(self, conditions: Mapping[str, Condition]) -> Specimen:
        """What is known of the specimen under these conditions; nan where nothing is.

        A dry trial has area and volume 0 unless a table gives it another value. Without any ``submerged_volume_m3``
        the buoyancy is taken as 0; a wet level that is missing from a table of volumes has nan.

        Raises ConfigError where a table goes by a condition that the trial does not have.
        """
        known = self.specimen
        dry = self.is_dry(conditions)
        area, volume = (
            None if dry and not isinstance(quantity, Table) else quantity
            for quantity in (known.area_m2, known.submerged_volume_m3)
        )
        when_missing = 0.0 if dry else math.nan
        no_table = 0.0 if known.submerged_volume_m3 is None else when_missing
        return Specimen(
            look_up("mass_kg", known.mass_kg, conditions),
            look_up("stiffness_N_per_m", known.stiffness_N_per_m, conditions),
            look_up("area_m2", area, conditions, when_missing),
            known.water_density_kg_per_m3,
            look_up("submerged_volume_m3", volume, conditions, no_table),
            known.gravity_m_per_s2,
            mass_error_kg=self._mass_error_kg,
            published=self._published(conditions),
            volume_assumed=not dry and known.submerged_volume_m3 is None,
            rotation=self.equation.coordinate == "rotation",
        )

    def _published(self, conditions: Mapping[str, Condition]) -> tuple[tuple[str, float], ...]:
        """Published values under these conditions, where there are any."""
        values = {
            name: look_up(f"published.{name}", quantity, conditions)
            for name, quantity in self.specimen.published.items()
        }
        return tuple((name, value) for name, value in values.items() if math.isfinite(value))

    def cell_for(self, conditions: Mapping[str, Condition]) -> Mapping[str, float]:
        """Geometry of the cells under these conditions: surface_width_m, depth_m, length_m; nan where not known."""
        cell = self.specimen.cell
        names = ("surface_width_m", "depth_m", "length_m")
        return {name: look_up(f"cell.{name}", getattr(cell, name, None), conditions) for name in names}

    def resolved(self) -> dict[str, Any]:
        """The whole config with defaults, as plain values; paths are absolute, so that it can be run from anywhere."""
        plain: dict[str, Any] = self.model_dump(mode="json", exclude_none=True)
        recordings = plain["recordings"]
        if self.recordings.driven_by:
            plain["identify"] = list(self.methods)
            plain["trials"]["hidden_at_release"] = "free"
        if "response" in recordings:
            del recordings["channels"]
        if "index" in recordings:
            recordings["index"] = str((self.folder / recordings["index"]).absolute())
        if "files" in recordings:
            given = self.recordings.files
            globs = [given] if isinstance(given, str) else list(given or ())
            absolute = [str((self.folder / one).absolute()) for one in globs]
            recordings["files"] = absolute[0] if isinstance(given, str) else absolute
        return plain


def _limits(said: WindowSettings) -> TimeWindow:
    return TimeWindow(said.start_s, said.end_s)


def look_up(
    name: str, quantity: float | Table | None, conditions: Mapping[str, Condition], missing: float = math.nan
) -> float:
    """A specimen's quantity for a trial; ``missing`` where the config says nothing for it.

    >>> look_up("area_m2", Table.model_validate({"by": "depth_m", 2.36: 0.97}), {"depth_m": 2.36})
    0.97
    """
    if quantity is None:
        return missing
    if not isinstance(quantity, Table):
        return float(quantity)
    if quantity.by not in conditions:
        have = ", ".join(conditions) or "none"
        raise ConfigError(f"specimen.{name} goes by {quantity.by!r}, but a trial has no such condition; it has {have}")
    here = conditions[quantity.by]
    if not quantity.values:
        if not isinstance(here, float):
            raise ConfigError(f"specimen.{name} is the condition {quantity.by!r} itself, which is {here!r}, no number")
        return here
    key = quantity.key_of(here)
    return missing if key is None else quantity.values[key]


def load(path: str | Path, overrides: Sequence[str] = ()) -> RunConfig:
    """A config file with ``a.b=value`` overrides, checked as a whole.

    Raises ConfigError with one line a problem: the file's line, the key, what was written, what it should be.
    """
    source = read_source(Path(path), overrides)
    if {"tables", "laboratory"} & source.data.keys() and "recordings" not in source.data:
        raise ConfigError(f"{path} is a config of published tables, for undertow audit; a run's has recordings")
    config = validated(RunConfig, source)
    config._folder, config._source = Path(path).absolute().parent, source
    wrong = [f"{source.place(location)}: {text}" for location, text in contradictions(config)]
    if wrong:
        raise ConfigError("\n".join(wrong))
    return config


def write_schema(path: str | Path) -> None:
    """The JSON schema of a config, for editors; it documents every key."""
    Path(path).write_text(schema_text(), encoding="utf-8")


def schema_text() -> str:
    """The JSON schema as it is committed (configs/run.schema.json)."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **RunConfig.model_json_schema()}
    return json.dumps(schema, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


__all__ = ["GroupKey", "Quantity", "RunConfig", "Source", "load", "look_up", "schema_text", "write_schema"]
