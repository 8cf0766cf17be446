"""The `recordings` section of a config: files, columns, units.

Belongs here: keys, their types, their defaults. Does not belong here: the other sections (settings.py).
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from undertow.campaign.config.response_settings import ResponseSettings
from undertow.campaign.config.settings import ColumnName, NotNegative, Positive, Real, Section, Whole, WindowSettings
from undertow.recording.doubt_kinds import DoubtKind
from undertow.recording.limits import COLUMNS, MEGABYTES
from undertow.recording.recording import INPUTS


class TimeSettings(Section):
    """Time stamps: a column, or a constant rate."""

    column: ColumnName | None = Field(
        default=None, description="Column of the time stamps: a name, or a number from 0."
    )
    unit: str = Field(default="s", description="Unit of the column.")
    rate_hz: Positive | None = Field(default=None, description="Sampling rate where no column holds the time, Hz.")
    start_s: Real = Field(default=0.0, description="What this clock reads zero at, on the displacement's clock, s.")


class ChannelSettings(Section):
    """One physical quantity: SI value = sign (sum of columns - offset) unit."""

    column: ColumnName | None = Field(
        default=None, description="Column: a name, or a number from 0 where there is no header."
    )
    columns: tuple[ColumnName, ...] | None = Field(default=None, description="Several columns, summed (load cells).")
    unit: str = Field(description="Unit as the laboratory writes it: mm, m/s^2, g, kN, deg, ...")
    sign: Literal[1, -1] = Field(default=1, description="-1 where the sensor counts the other way.")
    offset: Real = Field(default=0.0, description="Reading at zero, in `unit`; subtracted before the sign.")
    file: str | None = Field(
        default=None,
        description="File it lies in where that is not the trial's own, beside it; conditions and {stem} in braces.",
    )
    variable: str | None = Field(default=None, description="Table in that file (see recordings.variable).")
    time: TimeSettings | None = Field(default=None, description="Its own clock, where it has one.")
    frame: Literal["absolute", "relative"] | None = Field(
        default=None,
        description="Against the earth or against the base; to be said where the input is motion of the base.",
    )


class GainSettings(Section):
    """A number of an input that is known, with its standard error; 0: exactly known."""

    value: Real = Field(description="Value.")
    stderr: NotNegative = Field(default=0.0, description="Standard error of the value.")


class InputSettings(ChannelSettings):
    """A measured input: force or motion of base or water, with gain, delay and what it is between samples."""

    gain: GainSettings | None = Field(
        default=None, description="N per unit of the column; absent: the unit itself stands for newtons."
    )
    delay_s: GainSettings | None = Field(default=None, description="By how much the body feels it later, s.")
    hold: Literal["zero", "first", "band_limited"] = Field(
        default="first", description="Between samples: steps, straight lines, or nothing above half the rate."
    )


class ChannelsSettings(Section):
    """Which columns hold which physical quantity. A column that is not mapped is never read."""

    time: TimeSettings = Field(default_factory=TimeSettings, description="Time stamps.")
    displacement: ChannelSettings | None = Field(default=None, description="Displacement (m) or angle (rad).")
    velocity: ChannelSettings | None = Field(default=None, description="Velocity; a rate gyro alone is enough.")
    acceleration: ChannelSettings | None = Field(default=None, description="Acceleration of the body.")
    spring_force: ChannelSettings | None = Field(default=None, description="Force in the springs, + with displacement.")
    normal_force: ChannelSettings | None = Field(default=None, description="Vertical force on the rails.")
    force: InputSettings | None = Field(default=None, description="Measured force that drives the body.")
    base_displacement: InputSettings | None = Field(default=None, description="Measured motion of the base.")
    base_velocity: InputSettings | None = Field(default=None, description="Measured velocity of the base.")
    base_acceleration: InputSettings | None = Field(default=None, description="Measured acceleration of the base.")
    water_velocity: InputSettings | None = Field(default=None, description="Measured velocity of the water.")
    water_acceleration: InputSettings | None = Field(default=None, description="Measured acceleration of the water.")
    instrument: ChannelSettings | None = Field(
        default=None,
        description="What moves the body and no noise of it reaches: a controller's target. Its shape alone is used.",
    )

    @property
    def driven_by(self) -> str:
        """The first input that is mapped; empty for decays."""
        return next((name for name in INPUTS if getattr(self, name) is not None), "")


def _none_is_null(value: Any) -> Any:
    return None if value == "none" else value


Unmapped = Annotated[ChannelSettings | None, BeforeValidator(_none_is_null)]
"""A channel, or the word none: these files do not have it."""


class LayoutChannelsSettings(Section):
    """Channels of the files of one layout, in place of those of `recordings.channels`; none: they do not have it."""

    time: TimeSettings = Field(default_factory=TimeSettings, description="Time stamps.")
    displacement: Unmapped = Field(default=None, description="Displacement (m) or angle (rad).")
    velocity: Unmapped = Field(default=None, description="Velocity; a rate gyro alone is enough.")
    acceleration: Unmapped = Field(default=None, description="Acceleration of the body.")
    spring_force: Unmapped = Field(default=None, description="Force in the springs, + with displacement.")
    normal_force: Unmapped = Field(default=None, description="Vertical force on the rails.")


class LimitsSettings(Section):
    """How much one recording may take; what asks for more is refused before it is read."""

    megabytes: Positive = Field(default=MEGABYTES, description="What is asked of a file may unfold to, 10^6 bytes.")
    columns: Annotated[int, Field(strict=True, ge=1)] = Field(default=COLUMNS, description="Columns of one table.")


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


class FileSettings(Section):
    """How a file is laid out."""

    skip_rows: Whole = Field(default=0, description="Lines above the header.")
    header: Literal["first", "none"] = Field(default="first", description="none: columns are numbers from 0.")
    unit_row: bool = Field(default=False, description="Whether a line of units stands below the header.")
    separator: Annotated[str, Field(min_length=1)] = Field(default="auto", description="Between columns; auto: found.")
    decimal: Literal[".", ","] = Field(default=".", description="Decimal mark.")
    encoding: str | None = Field(
        default=None,
        description="Encoding of texts: cp1252, shift_jis, ...; else UTF-8, marked UTF-16 or Latin-1.",
    )
    variable: str | None = Field(
        default=None,
        description="Table in a file that may hold several: array or structure of a MATLAB file (dots lead into it), "
        "HDF5 group or dataset, sheet, TDMS group, MDF channel group.",
    )
    cells: CellsSettings | None = Field(default=None, description="Several trials in one file.")
    despike: dict[str, DespikeSettings] = Field(default={}, description="Channel -> how its spikes are replaced.")


class LayoutSettings(FileSettings):
    """What differs in the files that a pattern fits; what is not given is as in `recordings`."""

    channels: LayoutChannelsSettings | None = Field(default=None, description="Channels that differ.")


class RecordingsSettings(FileSettings):
    """Where the recordings are and how they are read; paths are relative to the config."""

    index: str | None = Field(
        default=None, description="Table (text or .xlsx) with one row a trial; its columns are the trial's conditions."
    )
    index_column: str = Field(default="file", description="Column of the index that names the file.")
    file: str | None = Field(default=None, description="File name made from the index's columns: test_{id}.csv.")
    index_separator: Annotated[str, Field(min_length=1)] = Field(
        default="auto", description="Between the index's columns: a character, tab, space; auto: found."
    )
    index_decimal: Literal["auto", ".", ","] = Field(
        default="auto", description="Decimal mark of the index's numbers; auto: found column by column."
    )
    files: str | tuple[str, ...] | None = Field(
        default=None, description="Glob of the files, or several, where there is no index."
    )
    pattern: str | None = Field(
        default=None, description="Regular expression on file names; named groups are conditions."
    )
    exclude: tuple[str, ...] = Field(default=(), description="File name patterns of trials to be left out.")
    accept: dict[str, tuple[DoubtKind, ...]] = Field(
        default={}, description="File name pattern -> kinds of doubt about these trials that are known and accepted."
    )
    channels: ChannelsSettings = Field(
        default_factory=ChannelsSettings, description="Physical quantity -> column(s), unit, sign, offset."
    )
    response: ResponseSettings | None = Field(
        default=None, description="In place of channels: amplitude and phase by frequency (a harmonic set)."
    )
    layouts: dict[str, LayoutSettings] = Field(
        default={}, description="File name pattern -> what differs in these files; the last that fits wins."
    )
    releases: dict[str, tuple[WindowSettings, ...]] = Field(
        default={},
        description="Several releases on one clock in one recording: file name pattern -> the part of each, in the "
        "recording's time; every part, its hold included, is a trial (file_1, file_2, ... with the condition release).",
    )
    limits: LimitsSettings = Field(default=LimitsSettings(), description="How much one recording may take.")

    @property
    def driven_by(self) -> str:
        """What drives the body, in time or harmonically; empty for decays."""
        return self.channels.driven_by if self.response is None else self.response.quantity
