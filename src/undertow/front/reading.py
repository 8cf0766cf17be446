"""`read` and `load`: files, tables, arrays or a campaign's config as `Trials`.

Belongs here: what can be read, and what each trial is called. Does not belong here: which column means what
(columns.py), conditioning (conditioning/), formats (recording/).
"""

from __future__ import annotations

import glob
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from os import PathLike, fspath
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from undertow.campaign.config import RunConfig
from undertow.campaign.config import load as load_config
from undertow.campaign.run import read_and_condition
from undertow.campaign.run.checking import Checked, Checker, each_once
from undertow.conditioning.motion import Motion
from undertow.discrepancy.findings import FailedTrial
from undertow.discrepancy.words import count
from undertow.errors import IdentificationError, RecordingError, shown
from undertow.front.columns import Columns, Mapped, Units, mapped, numbers_of
from undertow.front.file_layout import layout_of
from undertow.front.in_memory import by_name, frame_of, is_timed, must_be_the_rate, table_of, timed
from undertow.front.known import checked, place_of
from undertow.front.trials import Trials, first_reasons, in_arguments
from undertow.recording.catalogue import Entry, TimeWindow
from undertow.recording.doubt_kinds import DOUBT_KINDS, DoubtKind
from undertow.recording.gather import by_release
from undertow.recording.layout import FileFormat
from undertow.recording.readers import read_table, trial_name
from undertow.recording.recording import Condition, Coordinate, Recording
from undertow.recording.stated_rate import other_rate

Conditions = Mapping[str, Condition]
Path_ = str | PathLike[str]
Window: TypeAlias = tuple[float | None, float | None]
Source: TypeAlias = (
    Path_ | pd.DataFrame | pd.Series | Recording | Motion | Trials | tuple[ArrayLike, ArrayLike]
    | Sequence[Path_] | Sequence[pd.DataFrame] | Sequence[pd.Series] | Sequence[Recording] | Sequence[Motion]
    | Mapping[str, Any]
)  # fmt: skip
"""What `read` takes: a path, glob or several; a DataFrame or several, also by name; columns by name; (X, t); recordings
or motions."""


@dataclass(frozen=True)
class _Asked:
    """How the sources are to be read."""

    columns: Columns | None
    units: Units | None
    rate_hz: float | None
    coordinate: Coordinate | None
    accept: tuple[DoubtKind, ...]
    variable: str | None = None

    def __post_init__(self) -> None:
        if self.rate_hz is not None and not isinstance(self.rate_hz, Real):
            raise RecordingError(f"rate_hz is {shown(self.rate_hz)}; give samples in a second, as in rate_hz=100.0")


def read(
    source: Source,
    columns: Columns | None = None,
    units: Units | None = None,
    conditions: Conditions | Sequence[Conditions] | Mapping[str, Conditions] | None = None,
    *,
    t: ArrayLike | Sequence[ArrayLike] | None = None,
    rate_hz: float | None = None,
    coordinate: Coordinate | None = None,
    window: Window | Mapping[str, Window] | None = None,
    releases: Sequence[Window] | Mapping[str, Sequence[Window]] | None = None,
    names: Sequence[str] | None = None,
    accept: Sequence[DoubtKind] = (),
    variable: str | None = None,
) -> Trials:
    """Recordings of free decays as `Trials`: read, brought to SI units, cut to their motion.

    Parameters
    ----------
    source : a path or glob, several paths, a DataFrame or Series or several, also by name, as ``{"r1": table}``;
        columns by name; ``(X, t)`` with X (n,) or (n, k) and t (n,) or a time step; or recordings. NaN, and what a mask
        hides, is missing: these instants are left out as those of a file are (docs/formats.md). A text file's
        separator, decimal comma, header and unit row are found. An index that is the time needs no column; dates and
        times of day are seconds since the first.
    columns : quantity -> column, as ``{"time": "t", "displacement": "pot", "spring_force": ["lc1", "lc2"]}``; several
        columns are summed. Without it columns are recognised by their names. An array's are x, v and a.
    units : column or quantity -> unit, as ``{"x": "mm"}``; may be left out where the table says its units itself
        (``x [mm]``, ``x_mm``, a row of units). Time is in seconds unless said.
    conditions : of all trials, one mapping a trial, or trial name -> conditions, as ``{"spring": "long"}``.
    t : time of an array ``source``, (n,) in s, or its step.
    rate_hz : sampling rate where no column holds the time.
    coordinate : translation or rotation; found from the units.
    window : (first, last) instant used, s, None for as recorded; or trial name -> that.
    releases : of a source with several releases on one clock, (first, last) instant of each, s, its hold included:
        every one is a trial ``name_1``, ``name_2``, ... with the condition ``release``; or source's name -> that.
    names : of the trials, where they do not come from files.
    accept : kinds of doubt that are known and no reason to stop, as ``recordings.accept`` of a config
        (docs/channel_checks.md).
    variable : the table in files that hold several, as ``recordings.variable`` of a config: an array or structure of a
        MATLAB file (dots lead into structures), an HDF5 group or dataset, a sheet, a TDMS group, an MDF channel group.

    `Trials` stay as they are. Raises RecordingError where a file or column is missing, a unit is not said, no trial can
    be used, or what is read already is to be read otherwise; trials that
    cannot be used, whose channels contradict each other, or that are copies of an earlier one are listed in ``failed``
    beside others that can be used.

    >>> import numpy as np, undertow
    >>> times = np.arange(0.0, 6.0, 0.01)
    >>> X = 100.0 * np.exp(-0.2 * times) * np.cos(10.0 * times)
    >>> trials = undertow.read((X, times), units={"x": "mm"})
    >>> round(trials[0].amplitude, 2)
    0.1
    """
    if isinstance(source, Trials):
        said = {
            "columns": columns, "units": units, "conditions": conditions, "t": t, "rate_hz": rate_hz, "window": window,
            "coordinate": coordinate, "releases": releases, "names": names, "accept": accept or None,
            "variable": variable,
        }  # fmt: skip
        late = ", ".join(name for name, value in said.items() if value is not None)
        if late:
            raise RecordingError(f"{late} is given, but these trials are read; give it to the read that made them")
        if not len(source):
            raise RecordingError(f"source holds {len(source)} trials; choose one at least")
        return source
    if t is None and isinstance(source, Mapping):
        source, named = by_name(source)
        names = names or named
    if isinstance(accept, str):
        raise RecordingError(f"accept is the text {accept!r}; give a list, as in accept=[{accept!r}]")
    if wrong := [one for one in accept if one not in DOUBT_KINDS]:
        raise RecordingError(f"accept names {wrong[0]!r}; give a list of {', '.join(DOUBT_KINDS)}")
    asked = _Asked(columns, units, rate_hz, coordinate, tuple(accept), variable)
    sources = _sources(source) if t is None else timed(source, t)
    checked, config = _read_all(sources, asked, _Said(conditions, window, names, releases))
    motions = tuple(one.motion for one in checked if one.motion is not None and not one.contradiction)
    failed = tuple(_why_not(one) for one in checked if one.motion is None or one.contradiction)
    if not motions:
        raise RecordingError(first_reasons(failed) or "source holds 0 trials")
    turned = {m.recording.coordinate for m in motions}
    if len(turned) > 1:
        raise RecordingError(f"{count(len(motions), 'trial')} are in translation and in rotation; read them apart")
    known = {m.name: asked.accept for m in motions} if asked.accept else {}
    return Trials(motions, config, failed, known, {one.name: one.found for one in checked if one.found})


def _why_not(one: Checked) -> FailedTrial:
    """Why a trial is not used."""
    why = one.failed or FailedTrial(one.name, f"trial {one.name}: {one.contradiction}", one.conditions)
    return replace(why, reason=in_arguments(why.reason))


def load(config: str | Path | RunConfig, overrides: Sequence[str] = (), jobs: int = 1) -> Trials:
    """The trials of a campaign's config, with everything it knows of the rig, its groups and its dry trials.

    ``overrides`` are ``a.b=value`` as on the command line, ``jobs`` processes that read (0: one a core).
    ``undertow.diagnose(undertow.load("configs/flume.yaml"))`` does what ``undertow run`` does.

    Raises ConfigError where the config is wrong, RecordingError where no trial can be used.

    >>> import tempfile, undertow
    >>> from pathlib import Path
    >>> folder = tempfile.TemporaryDirectory()
    >>> place = Path(folder.name)
    >>> run = undertow.simulate({"stiffness": 400.0, "viscous_damping": 2.0}, x0=0.1, mass_kg=4.0, duration_s=6.0)
    >>> pd.DataFrame({"t": run.t, "x": run.x}).to_csv(place / "r1.csv", index=False)
    >>> _ = (place / "c.yaml").write_text("{name: c, recordings: {files: r*.csv, "
    ...     "channels: {time: {column: t, unit: s}, displacement: {column: x, unit: m}}}, "
    ...     "equation: {terms: [stiffness, viscous_damping]}}")
    >>> trials = undertow.load(place / "c.yaml")
    >>> folder.cleanup()
    >>> len(trials), trials.config.equation.terms
    (1, ('stiffness', 'viscous_damping'))
    >>> undertow.load("no_such_config.yaml")
    Traceback (most recent call last):
    undertow.errors.ConfigError: config no_such_config.yaml cannot be read: No such file or directory; check the path
    """
    known = config if isinstance(config, RunConfig) else load_config(place_of(config, "config"), overrides)
    found = read_and_condition(known, jobs)
    if not found.motions:
        raise RecordingError(f"none of {count(len(found.failed), 'trial')} can be used: {first_reasons(found.failed)}")
    return Trials(found.motions, known, found.failed, found.accepted, found.found)


def agreeing(trials: Trials, config: RunConfig) -> Trials:
    """The trials whose channels agree with what ``config`` says of the rig; the others stand in ``failed``.

    Raises IdentificationError where none does.
    """
    checker = Checker(config, config.catalogue())
    checked = [
        checker.again(motion, trials.accepted.get(motion.name, ()), trials.found.get(motion.name, ()))
        for motion in trials
    ]
    wrong = tuple(_why_not(one) for one in checked if one.contradiction)
    kept = tuple(one.motion for one in checked if one.motion is not None and not one.contradiction)
    if not kept:
        raise IdentificationError(
            f"none of {count(len(trials), 'trial')} agrees with what is known of the rig: {wrong[0].reason}"
        )
    return replace(trials, motions=kept, failed=(*trials.failed, *wrong), config=config)


class _Said:
    """What is said of each trial: its name, its conditions, its window, its releases."""

    def __init__(self, conditions: Any, window: Any, names: Sequence[str] | None, releases: Any = None) -> None:
        self._conditions, self._window, self._names, self._releases = conditions, window, names, releases
        if names is not None and (twice := [name for name, many in Counter(names).items() if many > 1]):
            raise RecordingError(f"names has {twice[0]!r} {list(names).count(twice[0])} times; give each trial its own")

    def name(self, at: int, own: str = "") -> str:
        """Name of the trial at this place."""
        if self._names is None:
            return own or f"trial_{at + 1}"
        if isinstance(self._names, str) or at >= len(self._names):
            raise RecordingError(f"names is {self._names!r}, which names no trial {at + 1}; give one name a trial")
        if not isinstance(self._names[at], str):
            raise RecordingError(f"names has {shown(self._names[at])} for trial {at + 1}; give a text, as in \"r1\"")
        return self._names[at]

    def conditions(self, at: int, name: str) -> Conditions:
        """Conditions of the trial."""
        said = self._conditions
        if said is None:
            return {}
        if not isinstance(said, Mapping | Sequence | np.ndarray) or isinstance(said, str):
            raise RecordingError(f"conditions is {shown(said)}; give a mapping, as in {{\"spring\": \"long\"}}")
        if not isinstance(said, Mapping):
            if at >= len(said):
                raise RecordingError(f"conditions has {len(said)} entries but there is a trial {at + 1}; give one each")
            return dict(said[at])
        if said and all(isinstance(value, Mapping) for value in said.values()):
            if name not in said:
                raise RecordingError(f"conditions names {', '.join(map(str, said))} but no trial {name!r}; add it")
            return dict(said[name])
        return dict(said)

    def window(self, name: str) -> TimeWindow:
        """The part of the trial that is used."""
        said = self._window
        if isinstance(said, Mapping):
            said = said.get(name)
        if said is None:
            return TimeWindow()
        ends = list(said) if isinstance(said, (tuple, list, np.ndarray)) else []
        if len(ends) != 2 or not all(end is None or isinstance(end, (int, float, np.number)) for end in ends):
            raise RecordingError(f"window is {shown(said)}; give (start_s, end_s) in s; None: as recorded")
        return TimeWindow(*ends)

    def trials(self, entry: Entry) -> list[Entry]:
        """The source itself, or one entry a release where its releases are said."""
        said = self._releases
        if isinstance(said, Mapping):
            said = said.get(entry.name)
        if said is None:
            return [entry]
        if not len(said) or any(np.ndim(one) != 1 or len(one) != 2 for one in said):
            raise RecordingError(f"releases is {said!r}; give (start_s, end_s) of each, as in [(0, 9.5), (9.5, 20)]")
        parts = by_release(entry, [TimeWindow(*one) for one in said])
        return [replace(one, window=self.window(one.name)) for one in parts]


def _sources(source: Any) -> list[Any]:
    """One item a trial: a path, a table, (X, t), a recording or a motion."""
    if isinstance(source, (str, PathLike)):
        text = fspath(source)
        if any(mark in text for mark in "*?["):
            found = sorted(glob.glob(text, recursive=True))
            if not found:
                raise RecordingError(f"the glob {text!r} fits no file; correct it, it is relative to {Path.cwd()}")
            return [Path(one) for one in found]
        return [Path(text)]
    if isinstance(source, (pd.DataFrame, pd.Series, Recording, Motion)):
        return [source]
    if isinstance(source, tuple) and len(source) == 2 and is_timed(*source):
        return timed(*source)
    if isinstance(source, np.ndarray) or not isinstance(source, Sequence):
        kind = type(source).__name__
        raise RecordingError(
            f"source is of type {kind}; give paths, DataFrames, recordings, or X together with t, as in t=0.01, "
            'units={"x": "mm"}'
        )
    return [one for part in source for one in _sources(part)]


def _read_all(sources: Sequence[Any], asked: _Asked, said: _Said) -> tuple[list[Checked], RunConfig]:
    """Every trial read and checked, each recording once, and what is known so far as a config says it."""
    checked: list[Checked] = []
    config: RunConfig | None = None
    for at, one in enumerate(sources):
        if isinstance(one, Motion):
            checked.append(Checked(one.name, one.recording.conditions, one))
            continue
        if isinstance(one, Path):
            found, config = _from_file(one, at, asked, said)
        else:
            found, config = _from_memory(one, at, asked, said, config)
        checked += found
    turned = [one.motion.recording.coordinate for one in checked if one.motion is not None]
    return each_once(checked), config or _config("", None, turned[0] if turned else "translation")


def _from_file(path: Path, at: int, asked: _Asked, said: _Said) -> tuple[list[Checked], RunConfig]:
    name = said.name(at, trial_name(path))
    layout = layout_of(path, asked.variable)
    means = _mapped_file(path, layout, asked)
    config = _config(path.name, means, means.coordinate)
    catalogue = replace(config.catalogue(), folder=path.parent, layout=layout)
    entry = Entry(name, path, said.conditions(at, name), said.window(name), accepted=asked.accept)
    return [Checker(config, catalogue)(each) for each in said.trials(entry)], config


def _from_memory(
    one: Any, at: int, asked: _Asked, said: _Said, before: RunConfig | None
) -> tuple[list[Checked], RunConfig]:
    """A table, an array or a recording, checked as a file's trial is."""
    if isinstance(one, Recording):
        config = before or _config("", None, one.coordinate)
        entry = Entry(one.name, one.name, one.conditions, said.window(one.name), accepted=asked.accept)
        if said.trials(entry) != [entry]:
            raise RecordingError(f"releases is said of {one.name}, which was read already; read its file with releases")
        return [Checker(config, config.catalogue()).recorded(one, entry)], config
    if asked.variable is not None:
        raise RecordingError(f"variable is {asked.variable!r}, but trial {at + 1} is no file; leave variable out")
    framed = isinstance(one, pd.DataFrame | pd.Series)
    units = asked.units
    if framed:
        table, rate_hz = frame_of(one), asked.rate_hz
        if rate_hz is not None and "clock" not in asked.accept and (other := other_rate(table, rate_hz)):
            raise RecordingError(in_arguments(other))
    else:
        X, t = one
        table, rate_hz, units = table_of(X, t, units)
        if asked.rate_hz is not None:
            must_be_the_rate(asked.rate_hz, table, rate_hz, units)
    means = mapped(table, asked.columns, units, rate_hz, asked.coordinate)
    numbers, name = numbers_of(table, means), said.name(at)
    config = _config("", means, means.coordinate)
    entry = Entry(name, name, said.conditions(at, name), said.window(name), accepted=asked.accept)
    return [Checker(config, config.catalogue())(each, numbers) for each in said.trials(entry)], config


def _mapped_file(path: Path, layout: FileFormat, asked: _Asked) -> Mapped:
    table = read_table(path, layout)
    try:
        return mapped(table, asked.columns, asked.units, asked.rate_hz, asked.coordinate)
    except RecordingError as error:
        raise type(error)(f"{path}: {error}") from error


def _config(file: str, means: Mapped | None, coordinate: str) -> RunConfig:
    """What is known so far, as a campaign's config says it."""
    channels: dict[str, Any] = {"time": {"column": "t"}, "displacement": {"column": "x", "unit": "m"}}
    if coordinate == "rotation":
        channels["displacement"]["unit"] = "rad"
    if means is not None:
        time = means.time
        channels = {name: {"columns": list(s.columns), "unit": s.unit} for name, s in means.channels.items()}
        stamped = {"column": time.column, "unit": time.unit}
        channels["time"] = {"rate_hz": time.rate_hz} if time.column is None else stamped
    return checked(
        {
            "name": "trials",
            "recordings": {"files": file or "in_memory", "channels": channels},
            "equation": {"coordinate": coordinate},
        }
    )
