"""Harmonic sets as a config describes them, in the groups that share one equation.

Belongs here: from files and settings to `HarmonicSet`. Does not belong here: fits, the run
folder (run.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from undertow.campaign.config import GroupKey, RunConfig, look_up
from undertow.campaign.config.matching import planned
from undertow.campaign.config.response_settings import DriveSettings, ErrorSettings, ResponseSettings, SweepSettings
from undertow.campaign.config.settings import Table
from undertow.conditioning.harmonic import HarmonicSet, on_base
from undertow.errors import FAILURES, ConfigError, RecordingError, failure
from undertow.recording.catalogue import Entry
from undertow.recording.patterns import patterns_of
from undertow.recording.recording import Array, Condition, Coordinate
from undertow.recording.response_table import ResponseSpec, ResponseTable, SetColumn, read_response
from undertow.recording.units import factor_to_si, phase_factor, rate_factor

SIZES = {"amplitude": 1.0, "peak_to_peak": 0.5, "rms": 2.0**0.5}
"""Amplitude over what a laboratory gives of an oscillation."""


@dataclass(frozen=True)
class Sweeps:
    """Trials of one group: their tables as recorded, and all points as one set; ``trial`` (n,) counts the tables,
    ``unit`` is the amplitudes'. ``held_out`` names the trials that the config holds out."""

    key: Mapping[str, Condition]
    tables: tuple[ResponseTable, ...]
    measured: HarmonicSet
    trial: np.ndarray
    unit: str
    held_out: tuple[str, ...] = ()

    @property
    def size(self) -> float:
        """RMS of the measured cosines and sines, unit of the amplitude."""
        return float(np.sqrt(np.mean(self.measured.amplitude**2) / 2.0))

    @property
    def rising(self) -> np.ndarray:
        """Whether the frequency was going up at each point, (n,)."""
        return np.concatenate([table.rising for table in self.tables])

    @property
    def along(self) -> list[np.ndarray]:
        """Places of each sweep's points, by frequency."""
        ways = [(self.trial == i) & (self.rising == way) for i in range(len(self.tables)) for way in (True, False)]
        places = [np.flatnonzero(way) for way in ways if way.any()]
        return [here[np.argsort(self.measured.rate[here], kind="stable")] for here in places]

    @property
    def unseen(self) -> np.ndarray:
        """Mask (n,) of the points of trials that are held out."""
        names = np.array([table.name for table in self.tables])
        return np.asarray(np.isin(names[self.trial], self.held_out))


def spec_of(config: RunConfig, conditions: Mapping[str, Condition]) -> tuple[ResponseSpec, str]:
    """Where a trial's values stand, and the unit of its amplitudes; RecordingError where a condition is lacking."""
    said, coordinate = _response(config), config.equation.coordinate
    size, unit = factor_to_si(said.amplitude.unit, "displacement", coordinate)
    turn = phase_factor(said.phase.unit)
    sweep: SetColumn | str = said.sweep if isinstance(said.sweep, str) else _swept(said.sweep, conditions)
    return ResponseSpec(
        SetColumn(said.frequency.column, rate_factor(said.frequency.unit)),
        SetColumn(said.amplitude.column, size * SIZES[said.amplitude.given_as]),
        SetColumn(said.phase.column, said.phase.sign * turn, said.phase.offset),
        _amount(said.quantity, getattr(said, said.quantity), coordinate, conditions),
        said.quantity, said.amplitude.frame == "absolute",
        None if said.stderr is None else _amount("stderr", said.stderr, coordinate, conditions), sweep,
    ), unit  # fmt: skip


def _response(config: RunConfig) -> ResponseSettings:
    said = config.recordings.response
    if said is None:
        raise RecordingError("recordings.response is not there; give the columns of a harmonic set")
    return said


def _swept(said: SweepSettings, conditions: Mapping[str, Condition]) -> SetColumn | str:
    if said.column is not None:
        return SetColumn(said.column, 1.0)
    way = conditions.get(str(said.by))
    if way not in ("up", "down"):
        raise RecordingError(f"response.sweep goes by {said.by!r}, which is {way!r} in this trial; it is up or down")
    return str(way)


def _amount(
    name: str, one: DriveSettings | ErrorSettings, coordinate: Coordinate, conditions: Mapping[str, Condition]
) -> SetColumn | float:
    """A drive or an error: its column, or its number in SI under these conditions."""
    factor = factor_to_si(one.unit, "displacement" if name == "stderr" else name, coordinate)[0]
    factor *= SIZES[one.given_as] if isinstance(one, DriveSettings) else 1.0
    if one.column is not None:
        return SetColumn(one.column, factor)
    if isinstance(one.value, Table) and one.value.by not in conditions:
        have = ", ".join(conditions) or "none"
        raise RecordingError(f"response.{name} goes by {one.value.by!r}, but it has no such condition; it has {have}")
    value = look_up(f"response.{name}", one.value, conditions)
    if not value > 0.0:
        raise RecordingError(f"response.{name} is {value:g} {one.unit} in this trial; give it a value above zero")
    return factor * value


def sweeps(config: RunConfig) -> tuple[list[Sweeps], dict[str, str]]:
    """Every group's trials that can be used, and trial -> reason of those that cannot."""
    groups: dict[GroupKey, list[tuple[Entry, ResponseTable, HarmonicSet]]] = {}
    failed: dict[str, str] = {}
    unit = ""
    for entry in planned(config).entries:
        try:
            if entry.problem:
                raise RecordingError(f"trial {entry.name}: {entry.problem}")
            table, measured, unit = one_set(config, entry.name, entry.path, entry.conditions)
            must_take_power(table.name, measured)
        except ConfigError:
            raise
        except FAILURES as reason:
            failed[entry.name] = failure(reason)
            continue
        groups.setdefault(config.group_key(entry.conditions), []).append((entry, table, measured))
    return [_together(config, key, trials, unit) for key, trials in groups.items()], failed


def one_set(
    config: RunConfig, name: str, path: Path, conditions: Mapping[str, Condition]
) -> tuple[ResponseTable, HarmonicSet, str]:
    """One file as recorded, as a set relative to what it stands on, and the unit of its amplitudes."""
    try:
        spec, unit = spec_of(config, conditions)
    except RecordingError as error:
        raise RecordingError(f"trial {name}: {error}") from error
    table = read_response(name, path, config.catalogue().layout, spec)
    motion = table.amplitude, table.phase
    if spec.quantity == "force":
        return table, HarmonicSet(table.rate, table.drive, *motion, table.stderr), unit
    return table, on_base(table.rate, table.drive, spec.quantity, motion, table.stderr, spec.absolute), unit


def must_take_power(trial: str, measured: HarmonicSet) -> None:
    """RecordingError where the body gives power to what drives it, over all points: its phases have another sign."""
    way = 1.0 if measured.mover == "force" else -1.0
    power = way * measured.force * measured.rate * measured.sine  # twice the mean of F x'
    if float(np.sum(power)) < 0.0:
        raise RecordingError(
            f"trial {trial}: by its phases the body gives power to what drives it at {int(np.sum(power < 0.0))} of "
            f"{power.size} points; where a lag is written as a positive phase, set response.phase.sign: -1"
        )


def _together(
    config: RunConfig, key: GroupKey, trials: Sequence[tuple[Entry, ResponseTable, HarmonicSet]], unit: str
) -> Sweeps:
    """One group's trials as one set."""
    sets = [measured for _, _, measured in trials]

    def joined(name: str) -> Array:
        """One column of all trials."""
        return np.concatenate([getattr(one, name) for one in sets])

    whole = HarmonicSet(
        joined("rate"), joined("force"), joined("amplitude"), joined("phase"), joined("sigma"), sets[0].mover
    )  # fmt: skip
    rule = config.trials.hold_out
    listed = patterns_of(rule if isinstance(rule, tuple) else ())
    held = tuple(table.name for entry, table, _ in trials if listed.fit(entry.name, str(entry.file)))
    count = np.repeat(np.arange(len(sets)), [one.rate.size for one in sets])
    return Sweeps(dict(key), tuple(table for _, table, _ in trials), whole, count, unit, held)
