"""A guess at what a file's columns mean, from their names and units, for a person to confirm.

Belongs here: names that laboratories give. Does not belong here: anything that a run relies on.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.channels import ChannelSpec, TimeSpec
from undertow.recording.layout import Column
from undertow.recording.recording import BESIDE, CHANNELS, COORDINATES, INPUTS, Coordinate
from undertow.recording.units import factor_to_si, is_unit_of, si_unit

_BASE = r"^(base|shak\w*table|table|ground|floor|foundation|support)"
_WATER = r"^(water|wave(?![ _-]?maker)|fluid|orbital|particle)"
_NAMES: Mapping[str, str] = MappingProxyType(
    {
        "time": r"^(time|zeit|elapsed|x_value)|^t$",
        "instrument": r"^(target|set[ _-]?point|desired|demand)",
        "base_displacement": _BASE + r".*(disp|pos|[xy]\d*$)",
        "base_velocity": _BASE + r".*(veloc|speed|v\d*$)",
        "base_acceleration": _BASE + r".*(acc|a\d*$)|^(acc\w*|a)[ _-]?(base|table|ground|floor)",
        "water_velocity": _WATER + r".*(veloc|speed|[uv]\d*$)",
        "water_acceleration": _WATER + r".*(acc|a\d*$)",
        "normal_force": r"vertical|normal",
        "force": r"^(input|drive|driving|excit|command|shaker|actuator)|^u\d*$",
        "spring_force": r"load|force|cell|moment|torque|^f\d*$",
        "acceleration": r"acc|^a\d*$",
        "velocity": r"^vel|veloc|gyro|rate|speed|omega|^v\d*$",
        "displacement": r"disp|pos|output|angle|roll|phi|theta|weg|pot|laser|sensor|heave|surge|sway|pitch|^[xy]\d*$",
    }
)
SPRING_FOLLOWS = 0.7
"""Correlation with the displacement from which on a force is a spring's; dampers and inertia leave it above that."""

SLOW_S = 1.0
"""Step of a clock whose unit nobody says from which on it may be of milliseconds, or of rows."""

UNSAID_CLOCK = "says no unit; s is assumed"
"""Said of such a clock."""

LONGEST_NAME = 400
"""Characters of a column's name in which a unit is looked for; the search takes the square of them."""

FEWEST_ROWS, UNEVEN = 20, 3.0
"""Rows from which on a column that rises may be a clock, and by how much its longest step may exceed the usual one."""

_UNIT_IN_NAME = re.compile(r"^(?P<stem>.*?)\s*(?:[\[(]\s*(?P<bracket>[^\])]*)\s*[\])]|_(?P<tail>[A-Za-z°%/^0-9]+))\s*$")
AS_FAR = 0.9
"""Columns that move by this share of the one that moves furthest move as far: which does is the noise's."""

_ROTATION = re.compile(r"angle|angular|roll|phi|theta|pitch|gyro|omega", re.IGNORECASE)


_FREQUENCY = re.compile(r"freq|^f$|^hz$", re.IGNORECASE)
_AMPLITUDE = re.compile(r"ampl|^(gain|magnitude|response)", re.IGNORECASE)


@dataclass(frozen=True)
class Proposal:
    """A proposed mapping: ``time`` (None where no column looks like it), ``channels``, ``coordinate``, and ``remarks``
    that say what was left out or guessed. ``doubts`` are those of them without which every number may be wrong: an
    assumed unit, columns that may be other trials; ``alike`` are these columns by channel, the one taken first.
    """

    time: TimeSpec | None
    channels: Mapping[str, ChannelSpec]
    coordinate: Coordinate = "translation"
    remarks: tuple[str, ...] = field(default_factory=tuple)
    doubts: tuple[str, ...] = ()
    alike: Mapping[str, tuple[Column, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "channels", MappingProxyType(dict(self.channels)))


def name_and_unit(column: Column) -> tuple[str, str]:
    """A column's name and the unit in it, empty where it has none.

    >>> name_and_unit("Time[s]"), name_and_unit("accel_mps2"), name_and_unit("angular_velocity")
    (('Time', 's'), ('accel', 'mps2'), ('angular_velocity', ''))
    """
    match = _UNIT_IN_NAME.match(str(column)) if len(str(column)) <= LONGEST_NAME else None
    if match is None:
        return str(column), ""
    unit = match["bracket"] if match["bracket"] is not None else match["tail"]
    if match["bracket"] is None and not is_unit(unit):
        return str(column), ""
    return match["stem"], unit


def speaks_of_time(column: Column) -> bool:
    """Whether a column's name says that it is the time.

    >>> speaks_of_time("Time[s]"), speaks_of_time("trial")
    (True, False)
    """
    return re.search(_NAMES["time"], name_and_unit(column)[0].strip(), re.IGNORECASE) is not None


def looks_harmonic(table: pd.DataFrame) -> bool:
    """Whether a table is a harmonic set: amplitudes by frequency, and no column of times."""
    stems = [name_and_unit(column)[0] for column in table.columns]
    return (
        any(_FREQUENCY.search(stem) for stem in stems)
        and any(_AMPLITUDE.search(stem) for stem in stems)
        and not any(speaks_of_time(stem) for stem in stems)
    )


def propose_mapping(table: pd.DataFrame, units: Mapping[Column, str] | None = None) -> Proposal:
    """Which columns may be time and which channels; ``units`` from a unit row win over those in the names.

    Load cells are summed; of several displacements the one with the widest range is taken and the others are named. A
    velocity or acceleration beside a displacement without a unit of its own is taken as SI, and said. Raises
    RecordingError where the columns are amplitudes over frequencies: those are no recording in time.
    """
    if looks_harmonic(table):
        raise RecordingError(
            f"columns {', '.join(map(repr, table.columns))} are amplitudes by frequency, a harmonic set, and no "
            "recording in time; `undertow inspect` proposes a config of its file, undertow.fit_response takes arrays "
            "(docs/harmonic_sets.md)"
        )
    said = units or {}
    found: dict[str, list[tuple[Column, str]]] = {}
    remarks: list[str] = []
    for column in table.columns:
        stem, unit = name_and_unit(column)
        unit = said.get(column, unit)
        if not np.isfinite(table[column].to_numpy(dtype=np.float64)).any():
            remarks.append(f"column {column!r} has no values")
            continue
        if not str(column).strip():
            remarks.append("a column without a name is not mapped; name it in the header if it is needed")
            continue
        quantity = _quantity(stem, unit, column, table)
        if quantity is None:
            remarks.append(f"column {column!r} is not mapped")
        else:
            found.setdefault(quantity, []).append((column, unit))
    remarks += _told_from_springs(found, table)
    driver = next((name for name in INPUTS if name.startswith("base_") and name in found), "")
    if driver:
        remarks.append(
            f"column {found[driver][0][0]!r} is motion of the base: displacement and velocity are taken as relative to "
            "it, acceleration as absolute; correct their frame where that is wrong"
        )
    wet = next((name for name in INPUTS if name.startswith("water_") and name in found), "")
    if wet and not driver:
        remarks.append(
            f"column {found[wet][0][0]!r} is motion of the water: laws of the water go with x' - u, froude_krylov with "
            "its acceleration; what the body does is taken as recorded against the earth"
        )
    remarks += _instruments_without_input(found)
    coordinate = _coordinate(found)
    time, more = _clock(found.get("time", []), table)
    remarks += more
    channels, alike = {}, {}
    doubts: list[str] = []
    for channel in (*CHANNELS, *INPUTS, *BESIDE):
        if channel in found:
            channels[channel], others, more = _spec(channel, found[channel], table, coordinate)
            doubts += more
            if others:
                alike[channel] = (*channels[channel].columns, *others)
    remarks += doubts
    clock, told = time.column if time is not None else None, dict(found.get("time", []))
    if clock is not None and not told[clock] and (doubted := clock_in_doubt(clock, table[clock])):
        doubts.append(doubted)
        remarks.append(doubted)
    return Proposal(time, channels, coordinate, tuple(remarks), tuple(doubts), alike)


def two_without_names(table: pd.DataFrame, channel: str = "displacement") -> Proposal | None:
    """Time and displacement (or another ``channel``), in SI and with a doubt that says so, of a table of two columns
    without names of which the first rises evenly and does not count rows; None of another table.

    >>> table = pd.DataFrame({0: np.arange(20) * 0.01, 1: np.zeros(20)})
    >>> two_without_names(table).channels["displacement"].columns
    (1,)
    """
    if table.shape[1] != 2 or len(table) < FEWEST_ROWS or not all(isinstance(name, int) for name in table.columns):
        return None
    steps = np.diff(table.iloc[:, 0].to_numpy(dtype=np.float64))
    if not np.isfinite(steps).all() or not steps.min() > 0.0 or steps.max() > UNEVEN * float(np.median(steps)):
        return None
    if counts_rows(table.iloc[:, 0]):
        return None
    clock, where = table.columns
    unit = si_unit(channel, "translation")
    said = (
        f"columns have no names: {clock}, which rises evenly, is taken as the time in s and {where} as {channel} in "
        f"{unit}; correct both under recordings.channels where they are something else"
    )
    channels = {channel: ChannelSpec((where,), unit)}
    return Proposal(TimeSpec(clock, "s"), channels, remarks=(said,), doubts=(said,))


def strange_unit(table: pd.DataFrame) -> str:
    """That a column named like a displacement has a unit in brackets that no quantity has, in a sentence; empty where
    none has.

    >>> strange_unit(pd.DataFrame({"x [foo]": [0.0]})).partition(";")[0]
    "displacement: unit 'foo' is not known"
    """
    for column in table.columns:
        stem, unit = name_and_unit(column)
        if unit and not is_unit(unit) and re.search(_NAMES["displacement"], stem.strip(), re.IGNORECASE):
            try:
                factor_to_si(unit, "displacement")
            except RecordingError as error:
                return f"{error} (column {column!r})"
    return ""


def counts_rows(column: pd.Series) -> bool:
    """Whether a column (n,) rises by one from row to row.

    >>> counts_rows(pd.Series([3.0, 4.0, 5.0])), counts_rows(pd.Series([0.0, 0.01]))
    (True, False)
    """
    return bool(np.all(np.diff(column.to_numpy(dtype=np.float64)) == 1.0))


def clock_in_doubt(column: Column, times: pd.Series) -> str:
    """That a column of times (n,) without a unit may not be in seconds (`step_in_doubt`), in a sentence; empty where
    nothing speaks against it.

    >>> clock_in_doubt("t", pd.Series([0.0, 10.0, 20.0]))
    "time: column 't' says no unit; s is assumed, a sample every 10 s: is it ms?"
    """
    step = step_in_doubt(times)
    return f"time: column {column!r} {UNSAID_CLOCK}, a sample every {step:g} s: is it ms?" if step else ""


def step_in_doubt(times: pd.Series) -> float:
    """The step of times (n,) whose unit nobody says, where it would be `SLOW_S` or more: they may be milliseconds, or
    rows' numbers. 0 where it is shorter.

    >>> step_in_doubt(pd.Series([0.0, 20.0, 40.0])), step_in_doubt(pd.Series([0.0, 0.02, 0.04]))
    (20.0, 0.0)
    """
    steps = np.diff(times.to_numpy(dtype=np.float64))
    steps = steps[np.isfinite(steps)]
    step = float(np.median(steps)) if steps.size else 0.0
    return step if step >= SLOW_S else 0.0


def _clock(found: Sequence[tuple[Column, str]], table: pd.DataFrame) -> tuple[TimeSpec | None, list[str]]:
    """The column whose name speaks of time; else one that only rises, but for one that counts rows."""
    if not found:
        return None, ["no column looks like time; give channels.time: {rate_hz: ...}"]
    named = [one for one in found if speaks_of_time(one[0])]
    column, unit = (named or found)[0]
    if not named and not unit and counts_rows(table[column]):
        return None, [f"column {column!r} counts rows and is no time; give channels.time: {{rate_hz: ...}}"]
    return TimeSpec(column, unit or "s"), [f"column {one!r} is not mapped" for one, _ in found if one != column]


def _told_from_springs(found: dict[str, list[tuple[Column, str]]], table: pd.DataFrame) -> list[str]:
    """A column named force that does not follow the displacement drives the body: moved to the inputs, and said."""
    forces, moved = found.get("spring_force", []), found.get("displacement", [])
    if "force" in found or len(forces) != 1 or not moved or not re.search("force", str(forces[0][0]), re.IGNORECASE):
        return []
    pair = table[[forces[0][0], moved[0][0]]].to_numpy(dtype=np.float64)
    pair = pair[np.isfinite(pair).all(axis=1)]
    if pair.shape[0] < 3 or not np.all(np.ptp(pair, axis=0) > 0.0):
        return []
    follows = abs(float(np.corrcoef(pair.T)[0, 1]))
    if follows >= SPRING_FOLLOWS:
        return []
    found["force"] = found.pop("spring_force")
    return [f"column {forces[0][0]!r} does not follow {moved[0][0]!r} (correlation {follows:.2f}): taken as an input"]


def _instruments_without_input(found: dict[str, list[tuple[Column, str]]]) -> list[str]:
    """A controller's target serves a driven body alone: elsewhere it is not mapped, and that is said."""
    if "force" in found or "instrument" not in found:
        return []
    return [f"column {column!r} is not mapped" for column, _ in found.pop("instrument")]


def _quantity(stem: str, unit: str, column: Column, table: pd.DataFrame) -> str | None:
    """The quantity that a name speaks of and its unit allows; by the unit alone where the name says nothing."""
    for quantity, pattern in _NAMES.items():
        if re.search(pattern, stem.strip(), re.IGNORECASE) and (not unit or reads(unit, quantity)):
            return quantity
    candidates = ("acceleration", "displacement", "spring_force") if unit else ()
    by_unit = [quantity for quantity in candidates if reads(unit, quantity)]
    if by_unit:
        return by_unit[0]
    first = table.columns[0] == column
    values = table[column].to_numpy(dtype=np.float64)
    values = values[np.isfinite(values)]
    rising = values.size > 2 and bool(np.all(np.diff(values) > 0.0))
    return "time" if first and rising else None


def is_unit(text: str) -> bool:
    """Whether a text is a unit of time or of a channel.

    >>> is_unit("[mm]"), is_unit("sensor1")
    (True, False)
    """
    return any(reads(text, quantity) for quantity in ("time", *CHANNELS))


def reads(unit: str, quantity: str) -> bool:
    """Whether a unit fits a quantity in translation or rotation."""
    return any(is_unit_of(unit, quantity, coordinate) for coordinate in COORDINATES)


def _coordinate(found: Mapping[str, Sequence[tuple[Column, str]]]) -> Coordinate:
    for channel in ("displacement", "velocity"):
        for column, unit in found.get(channel, ()):
            turns = not is_unit_of(unit, channel, "translation") if unit else _ROTATION.search(str(column))
            if turns:
                return "rotation"
    return "translation"


def _extent(column: pd.Series) -> float:
    """How far a column moves."""
    values = column.to_numpy(dtype=np.float64)
    return float(np.nanmax(values) - np.nanmin(values))


def _spec(
    channel: str, columns: Sequence[tuple[Column, str]], table: pd.DataFrame, coordinate: Coordinate
) -> tuple[ChannelSpec, list[Column], list[str]]:
    """A channel's columns (forces of one unit are summed, otherwise the one with the widest range), those that look
    like it as well, and what is to be said of them. Of two that move about as far it is the first in every file."""
    remarks: list[str] = []
    others: list[Column] = []
    if channel.endswith("force") and len({unit for _, unit in columns}) == 1:
        chosen = tuple(column for column, _ in columns)
        unit = columns[0][1]
    else:
        turning = [one for one in columns if _ROTATION.search(str(one[0]))] if coordinate == "rotation" else []
        extents = {one[0]: _extent(table[one[0]]) for one in turning or columns}
        alike = [one for one in turning or columns if extents[one[0]] >= AS_FAR * max(extents.values())]
        widest, why = alike[0], "which moves furthest" if len(alike) == 1 else "the first of those that move furthest"
        chosen, unit = (widest[0],), widest[1]
        others = [column for column, _ in turning or columns if column != widest[0]]
        left = [column for column, _ in columns if column not in (*chosen, *others)]
        remarks += [f"{channel} may also be column {column!r}" for column in left]
        if others:
            remarks.append(
                f"{channel}: column {widest[0]!r} is taken, {why}; {', '.join(map(repr, others))} "
                f"{'look' if len(others) > 1 else 'looks'} like it: name another in channels, and if each is a trial, "
                "save each with the time as a file of its own"
            )
    if not unit:
        unit = si_unit(channel, coordinate)
        remarks.append(f"{channel}: column {chosen[0]!r} says no unit; {unit} is assumed")
    return ChannelSpec(chosen, unit), others, remarks
