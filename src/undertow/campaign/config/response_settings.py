"""The `recordings.response` section of a config: columns of a harmonic set, in place of channels in time.

Belongs here: keys, their types, their defaults. Does not belong here: what contradicts what (response_rules.py),
reading (recording/response_table.py).
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Tag

from undertow.campaign.config.settings import ColumnName, Quantity, Real, Section, by_kind

GivenAs = Literal["amplitude", "peak_to_peak", "rms"]

DRIVES = ("force", "base_displacement", "base_acceleration")
"""What may drive a harmonic set."""


class FrequencySettings(Section):
    """The frequencies at which the body was driven."""

    column: ColumnName = Field(description="Column: a name, or a number from 0 where there is no header.")
    unit: str = Field(description="Hz, kHz, rad/s, rpm, ...")


class AmplitudeSettings(Section):
    """Amplitudes of the motion's part at the drive's frequency."""

    column: ColumnName = Field(description="Column: a name, or a number from 0 where there is no header.")
    unit: str = Field(description="Unit of the displacement (mm, m, deg, ...).")
    given_as: GivenAs = Field(default="amplitude", description="What the column holds of the oscillation.")
    frame: Literal["absolute", "relative"] | None = Field(
        default=None, description="Against the earth or against the base; to be said where the base moves."
    )


class PhaseSettings(Section):
    """Phases of the motion before the drive: phase = sign (column - offset) unit; negative where the body lags."""

    column: ColumnName = Field(description="Column: a name, or a number from 0 where there is no header.")
    unit: str = Field(description="deg or rad.")
    sign: Literal[1, -1] = Field(default=1, description="-1 where a lag is written as a positive phase.")
    offset: Real = Field(default=0.0, description="Reading where motion and drive are in phase, in `unit`.")


class DriveSettings(Section):
    """Amplitude of what drives: a column, or one value (a number, or by a condition)."""

    column: ColumnName | None = Field(default=None, description="Column, where each point has its own.")
    value: Quantity | None = Field(default=None, description="The same at all points of a trial.")
    unit: str = Field(description="N, kN, N m; mm, m/s^2, g of a base; ...")
    given_as: GivenAs = Field(default="amplitude", description="What the number is of the oscillation.")


class ErrorSettings(Section):
    """Standard error of the amplitudes, from repetitions or the analyser's noise."""

    column: ColumnName | None = Field(default=None, description="Column, where each point has its own.")
    value: Quantity | None = Field(default=None, description="The same at all points of a trial.")
    unit: str = Field(description="Unit of the displacement.")


class SweepSettings(Section):
    """Where it is written whether the frequency rose or fell: a column (above or below zero), or a condition."""

    column: ColumnName | None = Field(default=None, description="Column that is above 0 upward, below 0 downward.")
    by: str | None = Field(default=None, description="Condition that is up or down.")


class ResponseSettings(Section):
    """A harmonic set: amplitude and phase by frequency under F cos(w t), or on a base that moves so."""

    frequency: FrequencySettings = Field(description="Frequencies.")
    amplitude: AmplitudeSettings = Field(description="Amplitudes.")
    phase: PhaseSettings = Field(description="Phases.")
    force: DriveSettings | None = Field(default=None, description="Amplitude of the force that drives the body.")
    base_displacement: DriveSettings | None = Field(default=None, description="Amplitude of the base's motion.")
    base_acceleration: DriveSettings | None = Field(default=None, description="Amplitude of the base's acceleration.")
    stderr: ErrorSettings | None = Field(
        default=None, description="Standard error of the amplitudes; absent: all alike, from what is left."
    )
    sweep: Annotated[
        Annotated[Literal["order", "up", "down"], Tag("word")] | Annotated[SweepSettings, Tag("table")],
        by_kind("word", "table"),
    ] = Field(
        default="order", description="Whether the frequency rose or fell; order: as the rows go."
    )

    @property
    def quantity(self) -> str:
        """The drive that is mapped; empty where none is."""
        return next((name for name in DRIVES if getattr(self, name) is not None), "")
