"""A harmonic set as recorded: frequencies, amplitudes and phases of a motion, and what drove it, in SI.

Belongs here: reading one, and what no such set can hold. Does not belong here: which columns they are (the config),
where the equation's body would move (methods/harmonic_set.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from undertow.errors import RecordingError
from undertow.recording.layout import Column, FileFormat
from undertow.recording.readers import read_table
from undertow.recording.recording import Array


@dataclass(frozen=True)
class SetColumn:
    """A column: SI value = factor (column - offset)."""

    column: Column
    factor: float
    offset: float = 0.0


@dataclass(frozen=True)
class ResponseSpec:
    """Where a set's values stand: columns, or a number (SI) for all points. ``sweep`` is a column (above 0: the
    frequency rose), up, down, or order: as the rows go. ``absolute``: the motion is against the earth, not the base."""

    frequency: SetColumn
    amplitude: SetColumn
    phase: SetColumn
    drive: SetColumn | float
    quantity: str = "force"
    absolute: bool = False
    stderr: SetColumn | float | None = None
    sweep: SetColumn | str = "order"


@dataclass(frozen=True)
class ResponseTable:
    """A set's points (n,): ``rate`` rad/s, ``amplitude`` m or rad, ``phase`` rad before the drive, ``drive`` N, m or
    m/s^2, ``stderr`` of the amplitudes (0: not known), ``rising`` whether the frequency was going up."""

    name: str
    rate: Array
    amplitude: Array
    phase: Array
    drive: Array
    stderr: Array
    rising: np.ndarray


def read_response(name: str, path: Path, layout: FileFormat, spec: ResponseSpec) -> ResponseTable:
    """The points of one file; rows that hold nothing are left out.

    Raises RecordingError where a column is missing, a value is not finite, a frequency, amplitude, drive or error is
    not above zero.
    """
    parts: dict[str, SetColumn | float | str | None] = {
        "frequency": spec.frequency, "amplitude": spec.amplitude, "phase": spec.phase, spec.quantity: spec.drive,
        "stderr": spec.stderr, "sweep": spec.sweep,
    }  # fmt: skip
    columns = {key: one for key, one in parts.items() if isinstance(one, SetColumn)}
    try:
        table = read_table(path, layout, tuple(dict.fromkeys(one.column for one in columns.values())))
        table = table[np.isfinite(table.to_numpy(dtype=np.float64)).any(axis=1)]
        if not len(table):
            raise RecordingError(f"{path} has no rows of numbers; give a frequency, an amplitude and a phase a row")
        values = {key: _values(key, one, table[one.column].to_numpy(dtype=np.float64)) for key, one in columns.items()}
    except RecordingError as error:
        said = str(error).replace("recordings.channels", "recordings.response")
        raise type(error)(f"trial {name}: {said}") from error
    n = len(table)
    drive = values.get(spec.quantity, np.full(n, spec.drive if isinstance(spec.drive, float) else np.nan))
    stated = np.full(n, spec.stderr) if isinstance(spec.stderr, float) else np.zeros(0)
    rate = values["frequency"]
    rising = values["sweep"] > 0.0 if "sweep" in values else _rising(rate, str(spec.sweep))
    return ResponseTable(
        name, rate, values["amplitude"], values["phase"], drive, values.get("stderr", stated), rising
    )  # fmt: skip


def _values(key: str, one: SetColumn, read: Array) -> Array:
    """One column in SI; RecordingError for what it cannot hold."""
    bad = np.flatnonzero(~np.isfinite(read))
    if bad.size:
        raise RecordingError(
            f"column {one.column!r} ({key}) has {bad.size} values that are not finite, the first in row {bad[0] + 1} "
            f"of {read.size}; repair the file, or take the points out"
        )
    bad = np.flatnonzero(~(read > 0.0))
    if key not in ("phase", "sweep") and bad.size:
        why = {
            "frequency": "a body at rest has no response; take such points out",
            "stderr": "an error is above zero; take such points out, or leave stderr away",
        }.get(key, "an amplitude has no sign, and at 0 nothing moves: a half turn belongs to the phase (its offset)")
        raise RecordingError(
            f"column {one.column!r} ({key}) is {read[bad[0]]:g} in row {bad[0] + 1} of {read.size}, not above zero; "
            f"{why}"
        )
    return np.asarray(one.factor * (read - one.offset))


def _rising(rate: Array, sweep: str) -> np.ndarray:
    """Whether each point was reached from below: as said, or as the rows go (at a turn as the point before)."""
    if sweep != "order" or rate.size < 2:
        return np.full(rate.size, sweep != "down")
    step = np.sign(np.diff(rate))
    step = np.append(step[:1], step)
    for i in range(1, step.size):
        step[i] = step[i] or step[i - 1]
    return np.asarray(step >= 0.0)
