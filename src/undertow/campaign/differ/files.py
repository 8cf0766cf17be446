"""A simulation's file against a recording's file: both read alike, compared, written to a folder.

Belongs here: which columns are what, the specimen that a config knows, the folder. Does not belong here: the comparison
(differ.py) or its page (report/difference.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from undertow.campaign.config import RunConfig, load
from undertow.campaign.differ.compare import compare_motions, released_to_opposite_sides
from undertow.campaign.differ.driven import DrivenDifference, differ_driven, write_driven
from undertow.campaign.differ.lacking import UNKNOWN
from undertow.campaign.inspection import inspect
from undertow.campaign.run.folder import safe_name
from undertow.conditioning.agreement import disagreements
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.discrepancy.difference import Difference
from undertow.errors import ConfigError, IdentificationError, RecordingError, UndertowError
from undertow.likelihood.fit import Specimen
from undertow.recording.catalogue import Catalogue, Entry, TimeWindow, read_trial
from undertow.recording.gather import gather
from undertow.recording.patterns import patterns_of
from undertow.recording.recording import INPUTS, Condition
from undertow.report.difference import write_difference

MOTION_CHANNELS = ("displacement", "velocity", "acceleration")
"""What of a config's mapping both files must have: a simulation has no load cells."""

FEWEST_SAMPLES = 20
"""Samples that a motion window needs; a file with fewer is no release."""


FARTHEST = 5.0
"""One file's release is at most so many times the other's: beyond, a unit is more likely than another release."""

SLOWEST = 3.0
"""One file's period is at most so many times the other's: beyond, a unit of time is more likely than another body (ms
and s are 1000 apart, s and min 60)."""

BY_CONFIG = "say with --config which column drives it, in which unit, and which equation it begins from"
"""What a driven body needs beside two files."""


@dataclass(frozen=True)
class FilePair:
    """Both motions, what a config says beside them (laws, specimen, the rig's scatter, seed), and what was assumed of
    the two files (``assumed``), in sentences."""

    simulation: Motion
    recording: Motion
    terms: tuple[str, ...] = ()
    specimen: Specimen = UNKNOWN
    scatter: Mapping[str, float] = field(default_factory=dict)
    seed: int = 0
    assumed: tuple[str, ...] = ()


@dataclass(frozen=True)
class Compared:
    """What ``undertow differ`` says when it is done: the folder, the difference in it, and what its numbers rest on:
    assumed units, releases to opposite sides (``remarks``)."""

    folder: Path
    difference: Difference | DrivenDifference
    remarks: tuple[str, ...] = ()

    @property
    def summary(self) -> str:
        """The sentence, remarks, and where the page is."""
        lines = [self.difference.sentence, *(f"note: {one}" for one in self.remarks)]
        return "\n".join([*lines, f"report: {self.folder / 'differ.html'}"])


def differ(simulation: Path, recording: Path, config_path: Path | None = None, out: Path | None = None) -> Compared:
    """Compare two files and write ``differ.json`` and ``differ.html`` into a folder (default ``runs/differ_...``).

    With a config both files are read with its mapping of columns, and its terms, specimen and scatter count; without,
    the mapping is guessed from each file's column names, as ``undertow inspect`` shows it. A body that is driven needs
    a config.

    Raises ConfigError where a path or the config is wrong, RecordingError where a file cannot be used, UndertowError
    where no equation can be found or the folder cannot be written.
    """
    for what, path in (("simulation", simulation), ("recording", recording)):
        if not path.is_file():
            raise ConfigError(f"--{what} {path} is no file; give the path of one trial's table")
    found: Difference | DrivenDifference
    remarks: tuple[str, ...] = ()
    if config_path is not None and _are_driven(config_path, recording):
        found = differ_driven(simulation, recording, load(config_path))
    else:
        both = simulation, recording
        pair = _guessed(*both) if config_path is None else _configured(*both, config_path)
        _of_one_size(pair)
        _of_one_pace(pair)
        made = compare_motions(
            pair.simulation, pair.recording, pair.terms, pair.specimen, dict(pair.scatter) or None, pair.seed
        )
        found = replace(made, notes=(*pair.assumed, *made.notes))
        turned = released_to_opposite_sides(pair.simulation, pair.recording)
        remarks = (*pair.assumed, *([turned] if turned else []))
    folder = out or Path("runs") / safe_name(f"differ_{simulation.stem}_{recording.stem}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if isinstance(found, DrivenDifference):
            write_driven(found, folder)
        else:
            write_difference(found, folder)
    except OSError as reason:
        what = f"{reason.strerror or reason} ({reason.filename or folder})"
        raise UndertowError(f"folder {folder} cannot be written: {what}; choose another with --out") from reason
    return Compared(folder, found, remarks)


def _of_one_size(pair: FilePair) -> None:
    """RecordingError where the two releases are so far apart that a unit must be wrong."""
    sizes = pair.simulation.amplitude, pair.recording.amplitude
    if max(sizes) <= FARTHEST * min(sizes):
        return
    unit = pair.recording.recording.unit("displacement")
    raise RecordingError(
        f"the simulation is released from {sizes[0]:.3g} {unit} and the recording from {sizes[1]:.3g} {unit}, "
        f"{sizes[0] / sizes[1]:.3g} times as far, and more than {FARTHEST:g} times is taken for another unit: give "
        "both in one unit (with --config both are read in the config's), or compare a release of about the same size"
    )


def _of_one_pace(pair: FilePair) -> None:
    """RecordingError where the two periods are so far apart that a unit of time must be wrong."""
    try:
        periods = dominant_period(pair.simulation), dominant_period(pair.recording)
    except IdentificationError:  # one of them does not swing: no periods to compare
        return
    if max(periods) <= SLOWEST * min(periods):
        return
    raise RecordingError(
        f"the simulation's period is {periods[0]:.3g} s and the recording's {periods[1]:.3g} s, "
        f"{periods[0] / periods[1]:.3g} times as long, and more than {SLOWEST:g} times is taken for another unit of "
        "time: correct the unit in the name of the time column of the file that is wrong, as 't [ms]' (with --config "
        "both are read in recordings.channels.time.unit), or compare a simulation of this body"
    )


def _are_driven(config_path: Path, recording: Path) -> bool:
    """Whether the config describes a body that is driven, and the recording is none of its decays."""
    config = load(config_path)
    if config.recordings.response is not None:
        raise ConfigError(f"{config_path} describes harmonic sets (response); undertow differ takes records in time")
    decays = patterns_of(config.trials.decays).fit(recording.stem, str(recording))
    return bool(config.recordings.driven_by) and not decays


def _guessed(simulation: Path, recording: Path) -> FilePair:
    """Both motions with the mapping that each file's own names suggest."""
    motions: list[Motion] = []
    assumed: list[str] = []
    for what, path in (("simulation", simulation), ("recording", recording)):
        seen = inspect(path)
        driver = next((name for name in INPUTS if name in seen.proposal.channels), "")
        if driver:
            raise RecordingError(f"{what} {path} is driven ({driver}); {BY_CONFIG}")
        if seen.motion is None:
            raise RecordingError(f"{what} {path}: {seen.reason}")
        _units_hold(f"{what} {path}", seen.motion, seen.proposal.doubts)
        motions.append(_named(seen.motion, what))
        assumed += [f"{what}: {doubt}: say units in column names, or in a config" for doubt in seen.proposal.doubts]
    first, second = motions
    if first.recording.coordinate != second.recording.coordinate:
        raise RecordingError(
            f"the simulation's coordinate looks like a {first.recording.coordinate}, the recording's like a "
            f"{second.recording.coordinate}; say with --config which columns are what"
        )
    return FilePair(first, second, assumed=tuple(assumed))


def _units_hold(whose: str, motion: Motion, guessed: Sequence[str]) -> None:
    """RecordingError where channels contradict each other of which a unit was ``guessed``."""
    found = disagreements(motion.recording, motion.window, None, motion.noise) if guessed else ()
    wrong = next((one.sentence for one in found if one.certain), "")
    if wrong:
        raise RecordingError(f"{whose}: {wrong}. Guessed: {'; '.join(guessed)}: say units in a config, with --config")


def _configured(simulation: Path, recording: Path, config_path: Path) -> FilePair:
    """Both motions with a config's mapping; the recording's conditions and window where the config knows it."""
    config = load(config_path)
    catalogue = config.catalogue()
    entry = _entry(catalogue, recording)
    driver = config.recordings.driven_by
    if driver and not patterns_of(config.trials.decays).fit(entry.name, str(entry.file)):
        raise ConfigError(f"{config_path} describes a body that is driven ({driver}); {BY_CONFIG}")
    channels = {name: spec for name, spec in catalogue.channels.items() if name in MOTION_CHANNELS}
    motion_only = replace(catalogue, channels=channels)
    made = replace(entry, name=simulation.name, file=simulation, window=TimeWindow())
    motions = []
    for what, one in (("simulation", made), ("recording", entry)):
        try:
            read = read_trial(one, motion_only)
            if read.time.size < FEWEST_SAMPLES:
                raise RecordingError(f"{read.time.size} samples; a release and its decay need {FEWEST_SAMPLES}")
            motion = condition(read, start_s=one.window.start_s, end_s=one.window.end_s)
        except RecordingError as reason:
            raise RecordingError(f"{what} {one.path}: {reason}") from reason
        motions.append(_named(motion, what))
    specimen, scatter = _specimen(config, entry.conditions), config.specimen.scatter
    spread = {"k": scatter.k, "c": scatter.c, "mu": scatter.mu} if scatter else {}
    return FilePair(motions[0], motions[1], config.equation.terms, specimen, spread, config.seed)


def _entry(catalogue: Catalogue, recording: Path) -> Entry:
    """The config's entry for this file, or a plain one where it names other files."""
    for entry in gather(catalogue):
        if not entry.problem and entry.path.resolve() == recording.resolve():
            return entry
    return Entry(recording.name, recording)


def _specimen(config: RunConfig, conditions: Mapping[str, Condition]) -> Specimen:
    """What the config knows of the specimen under the recording's conditions; nothing where it goes by conditions that
    this file has not (it is then compared per mass)."""
    try:
        return config.specimen_for(conditions)
    except ConfigError:
        return UNKNOWN


def _named(motion: Motion, name: str) -> Motion:
    """The motion under the name it has in the comparison: two files may be called alike."""
    return replace(motion, recording=replace(motion.recording, name=name))
