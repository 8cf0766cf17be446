"""A guess at which columns of a table are a harmonic set: frequencies, amplitudes, phases, and what drove.

Belongs here: names that laboratories give. Does not belong here: recordings in time (propose.py), anything that a run
relies on.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.layout import Column
from undertow.recording.propose import LONGEST_NAME, looks_harmonic, name_and_unit, reads
from undertow.recording.recording import Coordinate
from undertow.recording.units import phase_factor, rate_factor

_BASE = r"base|shak\w*table|table|ground|floor|foundation|support"
_NAMES = {
    "frequency": r"freq|^f$|^hz$|^omega$",
    "phase": r"phase|^phi$|lag",
    "stderr": r"^(std|sigma|err|stderr|uncert)|(std|sigma|err|stderr)$",
    "base_acceleration": rf"({_BASE}).*(acc|a\d*$)|acc\w*[ _-]?({_BASE})",
    "base_displacement": rf"({_BASE})",
    "force": r"force|torque|moment|^f_?0$|excit|drive|input",
    "sweep": r"sweep|direction|branch",
    "amplitude": r"ampl|gain|magnitude|response|disp|^x\d*$|^a$",
}
_SPLIT = re.compile(r"^(?P<stem>.+?)[\s_]*[\[(]?(?P<unit>[A-Za-z°/]+)[\])]?$")


@dataclass(frozen=True)
class ResponseProposal:
    """Columns with their units by what they hold (frequency, amplitude, phase, a drive, stderr, sweep); ``lag`` where
    a lag is written as a positive phase; ``remarks`` say what was guessed or left out."""

    columns: Mapping[str, tuple[Column, str]]
    lag: bool
    coordinate: Coordinate
    remarks: tuple[str, ...] = ()

    @property
    def drive(self) -> str:
        """The drive that was found; empty where none was."""
        return next((name for name in self.columns if name.startswith("base_") or name == "force"), "")


def propose_response(table: pd.DataFrame, units: Mapping[Column, str] | None = None) -> ResponseProposal | None:
    """Which columns are a harmonic set's; None where the table is none (`looks_harmonic`).

    Raises RecordingError where nothing in it looks like a phase.
    """
    if not looks_harmonic(table):
        return None
    columns: dict[str, tuple[Column, str]] = {}
    remarks: list[str] = []
    for column in table.columns:
        if not np.isfinite(table[column].to_numpy(dtype=np.float64)).any():
            continue
        stem, unit = _parted(column, (units or {}).get(column, ""))
        names = (name for name, pattern in _NAMES.items() if re.search(pattern, stem, re.IGNORECASE))
        name = next((name for name in names if not unit or name == "sweep" or _reads(unit, name)), None)
        if name is None or name in columns:
            remarks.append(f"column {column!r} is not mapped")
        else:
            columns[name] = column, unit
    if "phase" not in columns or "amplitude" not in columns or "frequency" not in columns:
        lacking = ", ".join(name for name in ("frequency", "amplitude", "phase") if name not in columns)
        raise RecordingError(
            f"columns {', '.join(map(repr, table.columns))} are a harmonic set, amplitudes by frequency, in which "
            f"nothing looks like {lacking}; a run needs amplitude and phase (docs/harmonic_sets.md)"
        )
    turns = columns["amplitude"][1] and _reads(columns["amplitude"][1], "phase")
    coordinate: Coordinate = "rotation" if turns else "translation"
    columns, more = _with_units(columns, coordinate)
    drives = [name for name in columns if name.startswith("base_") or name == "force"]
    for name in drives[1:]:
        more.append(f"column {columns.pop(name)[0]!r} may also be what drives")
    if not drives:
        more.append("no column looks like what drives: 1 N at every point is taken; correct response.force")
    lag = "lag" in str(columns["phase"][0]).lower() or _gives_power(table, columns)
    if lag:
        more.append(f"column {columns['phase'][0]!r} is taken as a lag (sign: -1)")
    return ResponseProposal(columns, lag, coordinate, tuple([*remarks, *more]))


def _parted(column: Column, said: str) -> tuple[str, str]:
    """A column's name and unit: as the unit row says, as recordings write it, or a unit of frequency at its end."""
    stem, unit = name_and_unit(column)
    found = _SPLIT.match(str(column)) if len(str(column)) <= LONGEST_NAME else None
    if not unit and found is not None and (_reads(found["unit"], "frequency") or _reads(found["unit"], "force")):
        stem, unit = found["stem"], found["unit"]
    return stem, said or unit


def _reads(unit: str, name: str) -> bool:
    """Whether a unit fits what a column holds."""
    if name not in ("frequency", "phase"):
        return reads(unit, name if name.startswith("base_") or name == "force" else "displacement")
    try:
        rate_factor(unit) if name == "frequency" else phase_factor(unit)
    except RecordingError:
        return False
    return True


def _with_units(
    columns: Mapping[str, tuple[Column, str]], coordinate: Coordinate
) -> tuple[dict[str, tuple[Column, str]], list[str]]:
    """The columns with SI where they say no unit, and that this was assumed."""
    length = "rad" if coordinate == "rotation" else "m"
    usual = {"frequency": "Hz", "phase": "deg", "amplitude": length, "stderr": length, "base_displacement": length,
             "base_acceleration": f"{length}/s^2", "force": "N m" if length == "rad" else "N"}  # fmt: skip
    said = [
        f"{name}: column {column!r} says no unit; {usual[name]} is assumed"
        for name, (column, unit) in columns.items() if not unit and name in usual
    ]  # fmt: skip
    return {name: (column, unit or usual.get(name, "")) for name, (column, unit) in columns.items()}, said


def _gives_power(table: pd.DataFrame, columns: Mapping[str, tuple[Column, str]]) -> bool:
    """Whether the body would give power to what drives it, over all points, by its phases as they are written."""
    rate, amplitude, phase = (
        table[columns[name][0]].to_numpy(dtype=np.float64) for name in ("frequency", "amplitude", "phase")
    )
    turn = phase_factor(columns["phase"][1])
    drive = next((name for name in columns if name.startswith("base_") or name == "force"), "")
    force = table[columns[drive][0]].to_numpy(dtype=np.float64) if drive else np.ones(rate.size)
    way = 1.0 if drive == "base_acceleration" else -1.0
    power = float(np.nansum(way * force * rate * amplitude * np.sin(turn * phase)))
    return math.isfinite(power) and power < 0.0
