"""What a channel and its time are made of, in plain words: columns, units, where they stand.

Belongs here: `ChannelSpec`, `TimeSpec`, `TimeWindow`. Does not belong here: reading them (parts.py), a campaign
(catalogue.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from undertow.errors import RecordingError
from undertow.recording.layout import Column
from undertow.recording.recording import Array
from undertow.recording.spikes import Mask

LARGEST = 1e60
"""Values, rates and times in SI beyond this, or below one over it, are no measurements: the fifth power of it is the
largest number that doubles hold, and equations go to the fifth power."""


@dataclass(frozen=True)
class TimeSpec:
    """Time from a column in ``unit``, or from a constant rate; exactly one of the two. ``start_s`` is added: the
    instant at which this clock reads zero, on the clock of the trial's displacement.
    """

    column: Column | None = None
    unit: str = "s"
    rate_hz: float | None = None
    start_s: float = 0.0

    def __post_init__(self) -> None:
        if (self.column is None) == (self.rate_hz is None):
            raise RecordingError(
                f"time has column {self.column!r} and rate {self.rate_hz!r} Hz; give one of them, not both or none"
            )
        if self.rate_hz is not None and not 1.0 / LARGEST < self.rate_hz < LARGEST:
            raise RecordingError(
                f"rate_hz is {self.rate_hz:g} Hz, which no logger has; give the samples that it records in a second"
            )


@dataclass(frozen=True)
class ChannelSpec:
    """What a channel is made of: SI value = sign (sum of columns - offset) unit.

    ``offset`` is the reading at zero, in ``unit``. Several columns are summed (the load cells of one support).
    ``file`` is the file it lies in where that is not the trial's own, beside it, with conditions in braces
    (``u_{id}.csv``; ``{stem}`` is the trial's own file without suffix); ``variable`` the table there; ``time`` its own
    clock, where it has one.
    """

    columns: tuple[Column, ...]
    unit: str
    sign: float = 1.0
    offset: float = 0.0
    file: str | None = None
    variable: str | None = None
    time: TimeSpec | None = None


@dataclass(frozen=True)
class TimeWindow:
    """The part of a recording to be used, in its own time, s; None: as far as it goes."""

    start_s: float | None = None
    end_s: float | None = None

    def contains(self, time: Array) -> Mask:
        """Mask (n,) of the times (s) inside."""
        start = -np.inf if self.start_s is None else self.start_s
        end = np.inf if self.end_s is None else self.end_s
        return (time >= start) & (time <= end)
