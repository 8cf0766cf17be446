"""The `recordings` section of a config: files, columns, units.

Belongs here: keys, their types, their defaults. Does not belong here: the other sections (settings.py).
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from undertow.campaign.config.settings import ColumnName, Positive, Real, Section, Whole
from undertow.recording.doubt_kinds import DoubtKind


class TimeSettings(Section):
    """Time stamps: a column, or a constant rate."""

    column: ColumnName | None = Field(
        default=None, description="Column of the time stamps: a name, or a number from 0."
    )
    unit: str = Field(default="s", description="Unit of the column.")
    rate_hz: Positive | None = Field(default=None, description="Sampling rate where no column holds the time, Hz.")


class ChannelSettings(Section):
    """One physical quantity: SI value = sign (sum of columns - offset) unit."""

    column: ColumnName | None = Field(
        default=None, description="Column: a name, or a number from 0 where there is no header."
    )
    columns: tuple[ColumnName, ...] | None = Field(default=None, description="Several columns, summed (load cells).")
    unit: str = Field(description="Unit as the laboratory writes it: mm, m/s^2, g, kN, deg, ...")
    sign: Literal[1, -1] = Field(default=1, description="-1 where the sensor counts the other way.")
    offset: Real = Field(default=0.0, description="Reading at zero, in `unit`; subtracted before the sign.")


class ChannelsSettings(Section):
    """Which columns hold which physical quantity. A column that is not mapped is never read."""

    time: TimeSettings = Field(default_factory=TimeSettings, description="Time stamps.")
    displacement: ChannelSettings | None = Field(default=None, description="Displacement (m) or angle (rad).")
    velocity: ChannelSettings | None = Field(default=None, description="Velocity; a rate gyro alone is enough.")
    acceleration: ChannelSettings | None = Field(default=None, description="Acceleration of the body.")
    spring_force: ChannelSettings | None = Field(default=None, description="Force in the springs, + with displacement.")
    normal_force: ChannelSettings | None = Field(default=None, description="Vertical force on the rails.")


class DespikeSettings(Section):
    """How spikes of a channel are found."""

    median: Annotated[int, Field(strict=True, ge=5)] = Field(description="Width of the running median, samples, odd.")


class CellsSettings(Section):
    """Several trials in one MATLAB file: a cell array with a trial a row (or a column)."""

    variable: str = Field(description="Name of the cell array.")
    trial: Literal["row", "column"] = Field(default="row", description="What one trial is.")
    time: Whole | None = Field(default=None, description="Cell of a trial that holds the time, from 0.")
    displacement: Whole | None = Field(default=None, description="Cell of the displacement.")
    velocity: Whole | None = Field(default=None, description="Cell of the velocity.")
    acceleration: Whole | None = Field(default=None, description="Cell of the acceleration.")
    spring_force: Whole | None = Field(default=None, description="Cell of the spring force.")
    normal_force: Whole | None = Field(default=None, description="Cell of the normal force.")


class RecordingsSettings(Section):
    """Where the recordings are and how they are read; paths are relative to the config."""

    index: str | None = Field(
        default=None, description="Table with one row a trial; its columns are the trial's conditions."
    )
    index_column: str = Field(default="file", description="Column of the index that names the file.")
    file: str | None = Field(default=None, description="File name made from the index's columns: test_{id}.csv.")
    index_separator: Annotated[str, Field(min_length=1)] = Field(
        default="auto", description="Between the index's columns: a character, tab, space; auto: found."
    )
    index_decimal: Literal["auto", ".", ","] = Field(
        default="auto", description="Decimal mark of the index's numbers; auto: found column by column."
    )
    files: str | None = Field(default=None, description="Glob of the files, where there is no index.")
    pattern: str | None = Field(
        default=None, description="Regular expression on file names; named groups are conditions."
    )
    exclude: tuple[str, ...] = Field(default=(), description="File name patterns of trials to be left out.")
    accept: dict[str, tuple[DoubtKind, ...]] = Field(
        default={}, description="File name pattern -> kinds of doubt about these trials that are known and accepted."
    )
    skip_rows: Whole = Field(default=0, description="Lines above the header.")
    header: Literal["first", "none"] = Field(default="first", description="none: columns are numbers from 0.")
    unit_row: bool = Field(default=False, description="Whether a line of units stands below the header.")
    separator: Annotated[str, Field(min_length=1)] = Field(default="auto", description="Between columns; auto: found.")
    decimal: Literal[".", ","] = Field(default=".", description="Decimal mark.")
    variable: str | None = Field(
        default=None, description="Array or structure in a MATLAB file (dots lead into structures)."
    )
    cells: CellsSettings | None = Field(default=None, description="Several trials in one file.")
    channels: ChannelsSettings = Field(description="Physical quantity -> column(s), unit, sign, offset.")
    despike: dict[str, DespikeSettings] = Field(default={}, description="Channel -> how its spikes are replaced.")
