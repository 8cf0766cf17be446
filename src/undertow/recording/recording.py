"""What the sensors of one trial said, in SI units, with the trial's conditions.

Belongs here: the frozen `Recording` and the names of channels. Does not belong here: files (readers.py),
units (units.py), judgement of quality (quality.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from undertow.errors import RecordingError
from undertow.quantities import read_only_mapping

Array = NDArray[np.float64]
Condition = str | float
Coordinate = Literal["translation", "rotation"]
LEFT_OUT = "left out in this trial"
"""Words of a note that one of a recording's channels could not be used."""

COORDINATES: tuple[Coordinate, ...] = get_args(Coordinate)

CHANNELS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "displacement": ("m", "rad"),
        "velocity": ("m/s", "rad/s"),
        "acceleration": ("m/s^2", "rad/s^2"),
        "spring_force": ("N", "N m"),
        "normal_force": ("N", "N"),
    }
)
"""Physical quantities a channel can hold: SI unit in translation and in rotation."""

INPUTS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "force": ("N", "N m"),
        "base_displacement": ("m", "rad"),
        "base_velocity": ("m/s", "rad/s"),
        "base_acceleration": ("m/s^2", "rad/s^2"),
        "water_velocity": ("m/s", "rad/s"),
        "water_acceleration": ("m/s^2", "rad/s^2"),
    }
)
"""What may drive a body from outside, measured: SI unit in translation and in rotation."""

BESIDE: Mapping[str, tuple[str, str]] = MappingProxyType({"instrument": ("1", "1")})
"""What stands beside them: a signal that moves the body and that no noise of it reaches (the target of a controller).
Its shape alone is used, so that any unit is kept as it is."""


def read_only(values: object) -> Array:
    """A float64 copy that cannot be written to."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class Recording:
    """One trial as recorded: ``time`` (n,) in s, strictly increasing; ``channels`` name -> (n,) in SI units.

    ``conditions`` are the trial's columns of the index or named groups of its file name. ``notes`` say what
    reading changed (spikes replaced, samples dropped), so that nothing is silent.

    Raises RecordingError where lengths differ, a value is not finite or time does not increase.

    >>> r = Recording("r1", [0, 1, 2], {"displacement": [0.1, 0.0, -0.1]}, {"spring": "long"})
    >>> r.rate_hz, r.duration_s
    (1.0, 2.0)
    """

    name: str
    time: Array
    channels: Mapping[str, Array]
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    coordinate: Coordinate = "translation"
    path: str = ""
    sha256: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        time = read_only(self.time)
        object.__setattr__(self, "time", time)
        channels = {name: read_only(values) for name, values in self.channels.items()}
        object.__setattr__(self, "channels", read_only_mapping(channels))
        object.__setattr__(self, "conditions", read_only_mapping(self.conditions))
        self._check()

    def _check(self) -> None:
        for name, values in self.channels.items():
            if name not in CHANNELS and name not in INPUTS and name not in BESIDE:
                known = ", ".join((*CHANNELS, *INPUTS, *BESIDE))
                raise RecordingError(f"trial {self.name}: channel {name!r} is none of {known}; rename it")
            if values.shape != self.time.shape:
                raise RecordingError(
                    f"trial {self.name}: {name} has {values.size} samples but time has {self.time.size}; "
                    "give every channel one value a time stamp"
                )
            bad = int(np.count_nonzero(~np.isfinite(values)))
            if bad:
                first = float(self.time[np.flatnonzero(~np.isfinite(values))[0]])
                raise RecordingError(
                    f"trial {self.name}: {name} has {bad} values that are not finite, the first at {first:g} s; "
                    "cut the window before them or repair the file"
                )
        steps = np.diff(self.time)
        if steps.size and not np.all(steps > 0.0):
            index = int(np.flatnonzero(~(steps > 0.0))[0])
            raise RecordingError(
                f"trial {self.name}: time goes from {self.time[index]:g} s to {self.time[index + 1]:g} s at sample "
                f"{index + 1}; time must increase: remove duplicated or swapped rows"
            )

    @property
    def rate_hz(self) -> float:
        """Median sampling rate in Hz."""
        return 1.0 / float(np.median(np.diff(self.time)))

    @property
    def duration_s(self) -> float:
        """Time from the first to the last sample, s."""
        return float(self.time[-1] - self.time[0])

    def unit(self, channel: str) -> str:
        """SI unit of a channel: of translation or of rotation, as the recording's coordinate says."""
        return {**CHANNELS, **INPUTS, **BESIDE}[channel][1 if self.coordinate == "rotation" else 0]
