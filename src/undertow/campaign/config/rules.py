"""What each key of a config alone cannot say: keys that exclude or need each other, names that nobody knows.

Belongs here: rules across keys. Does not belong here: types and ranges of one key (settings.py).
"""

from __future__ import annotations

import codecs
import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING

from undertow.campaign.config.described import for_pattern
from undertow.campaign.config.driven_rules import driven_wrong
from undertow.campaign.config.recording_settings import ChannelsSettings, RecordingsSettings, TimeSettings
from undertow.campaign.config.response_rules import response_wrong
from undertow.campaign.config.settings import WindowSettings
from undertow.campaign.config.source import Location, Wrong
from undertow.campaign.config.specimen_rules import unphysical
from undertow.comparison.driven_suspects import SUSPECTS_IN_TIME
from undertow.comparison.suspects import chosen
from undertow.equation import registry
from undertow.equation.base_motion import must_accelerate
from undertow.equation.driven_laws import find_driven, places, without_memory
from undertow.errors import ConfigError, RecordingError, UndertowError
from undertow.quantities import mover_of
from undertow.recording.channels import LARGEST
from undertow.recording.doubt_kinds import DOUBT_KINDS
from undertow.recording.expressions import found_in
from undertow.recording.index import SEPARATORS, is_separator
from undertow.recording.parts import ALONE
from undertow.recording.recording import BESIDE, CHANNELS, INPUTS, Coordinate
from undertow.recording.units import factor_to_si

if TYPE_CHECKING:
    from undertow.campaign.config.run_config import RunConfig


def contradictions(config: RunConfig) -> Iterator[Wrong]:
    """Where and what is wrong across keys, one pair a problem; nothing where the config can be run."""
    said, coordinate = config.recordings, config.equation.coordinate
    if (said.index is None) == (said.files is None):
        yield ("recordings",), f"recordings has index {said.index!r} and files {said.files!r}; give exactly one of them"
    yield from _without_effect(said)
    yield from response_wrong(config)
    yield from driven_wrong(config)
    if said.response is None:
        yield from _unusable_channels(said, ("recordings",), coordinate)
        for pattern in said.layouts:
            yield from _unusable_channels(for_pattern(said, pattern), ("recordings", "layouts", pattern), coordinate)
    yield from unphysical(config)
    yield from _driving(said.channels)
    if config.trials.decays and not said.channels.driven_by:
        text = "trials.decays is for decays beside driven trials, and no input is mapped: all are decays; leave it out"
        yield ("trials", "decays"), text
    yield from _terms(config)
    suspects = config.discrepancy.suspects
    for at, name in enumerate(() if suspects == "all" else suspects):
        try:
            if not (said.driven_by and name in SUSPECTS_IN_TIME):
                chosen((name,))
        except ConfigError as error:
            yield ("discrepancy", "suspects", at), str(error)
    for name, one in said.despike.items():
        if getattr(said.channels, name, None) is None or name == "time":
            yield ("recordings", "despike", name), f"despike names {name!r}, which is no mapped channel"
        if one.median % 2 == 0:
            yield ("recordings", "despike", name), f"median is {one.median} samples; give an odd number"
    yield from _spans(config)


def _terms(config: RunConfig) -> Iterator[Wrong]:
    """Terms that nobody knows, that stand twice, or that leave out what pulls the body back."""
    driver, harmonic, terms = config.recordings.driven_by, config.recordings.response is not None, config.equation.terms
    for at, name in enumerate(terms):
        try:
            places([find_driven(name)], mover_of(driver)) if driver else registry.find(name)
            if harmonic:
                without_memory([find_driven(name)])
        except ConfigError as error:
            yield ("equation", "terms", at), str(error)
        if name in terms[:at]:
            yield ("equation", "terms", at), f"equation.terms names {name!r} twice; take one of them out"
    pulled = any(law.pulls_back for law in registry.catalogue() if law.name in terms)
    if not pulled and (not driver or harmonic):
        yield ("equation", "terms"), (
            f"equation.terms has {', '.join(terms)} and nothing that pulls the body back, so that it "
            "cannot swing; add stiffness (or sine_restoring, for a pendulum)"
        )


def _spans(config: RunConfig) -> Iterator[Wrong]:
    """Windows and parts of a recording that end before they begin, and parts that share samples: their trials would be
    one motion counted twice."""
    windows = {} if config.trials.window == "auto" else config.trials.window
    said: list[tuple[Location, WindowSettings]] = [(("trials", "window", name), one) for name, one in windows.items()]
    for pattern, parts in config.recordings.releases.items():
        place: Location = ("recordings", "releases", pattern)
        said += [((*place, at), one) for at, one in enumerate(parts)]
        if not parts:
            yield place, f"releases has no part for {pattern!r}; give start_s and end_s of each release"
        for at, (one, following) in enumerate(itertools.pairwise(parts)):
            if one.end_s is None or following.start_s is None or not one.end_s < following.start_s:
                ends, starts = ("open" if s is None else f"{s:g} s" for s in (one.end_s, following.start_s))
                yield (*place, at + 1), (
                    f"part {at + 1} ends at {ends} and part {at + 2} starts at {starts}: parts of one recording share "
                    "no sample; give them in order, each to end before the next starts"
                )
    for where, one in said:
        if one.start_s is not None and one.end_s is not None and not one.start_s < one.end_s:
            yield where, f"the window starts at {one.start_s} s and ends at {one.end_s} s; it must end later"


def _driving(channels: ChannelsSettings) -> Iterator[Wrong]:
    """What is wrong with the inputs: a hold without an acceleration, outputs whose frame is not said, two records of
    one water that are not late by the same."""
    place: Location = ("recordings", "channels")
    driver = channels.driven_by
    if mover_of(driver) not in ("base", "water"):
        return
    try:
        must_accelerate(driver, getattr(channels, driver).hold)
    except UndertowError as error:
        yield (*place, driver, "hold"), str(error).removeprefix("input: ")
    if mover_of(driver) == "water":
        yield from _one_water(channels)
        return
    for name in ("displacement", "velocity", "acceleration"):
        one = getattr(channels, name)
        if one is not None and one.frame is None:
            yield (*place, name, "frame"), (
                f"{name} has no frame, and the base moves ({driver}); say frame: absolute (against the earth) or "
                "relative (against the base)"
            )
    moved = channels.displacement
    if moved is not None and moved.frame == "absolute" and driver != "base_displacement":
        yield (*place, "displacement", "frame"), (
            f"displacement has frame: absolute, but {driver} does not say where the base is; map base_displacement, or "
            "a displacement relative to the base"
        )


def _one_water(channels: ChannelsSettings) -> Iterator[Wrong]:
    """A delay or an unsure gain of an acceleration of the water beside its velocity: both are one input."""
    second = channels.water_acceleration
    if channels.water_velocity is None or second is None:
        return
    if second.delay_s is not None or (second.gain is not None and second.gain.stderr != 0.0):
        key = "delay_s" if second.delay_s is not None else "gain"
        yield ("recordings", "channels", "water_acceleration", key), (
            f"water_acceleration has a {key} of its own beside water_velocity, and the two are taken as one motion of "
            f"the water; give {key} to water_velocity, which holds for both, or map one of them alone"
        )


def _without_effect(said: RecordingsSettings) -> Iterator[Wrong]:
    """Keys of `recordings` that belong to the other way of naming files, or that can match nothing."""
    place: Location = ("recordings",)
    if said.index is not None and said.pattern is not None:
        text = "pattern belongs to files; with an index its columns are the conditions: take one of them out"
        yield (*place, "pattern"), text
    changed = {
        "file": said.file is not None, "index_column": said.index_column != "file",
        "index_separator": said.index_separator != "auto", "index_decimal": said.index_decimal != "auto",
    }  # fmt: skip
    for key, is_set in changed.items():
        if is_set and said.index is None and said.files is not None:
            yield (*place, key), f"{key} belongs to index, but recordings has files; take one of them out"
    if said.pattern is not None and said.index is None:
        try:
            if not found_in(said.pattern).groups:
                text = f"pattern {said.pattern!r} has no named group, so it gives no condition; write (?P<name>...)"
                yield (*place, "pattern"), text
        except ConfigError as error:
            yield (*place, "pattern"), str(error).removeprefix("recordings.")
    for pattern, kinds in said.accept.items():
        if not kinds:
            text = f"accept names no kind of doubt for {pattern!r}; give {', '.join(DOUBT_KINDS)}"
            yield (*place, "accept", pattern), text
    yield from _separator("index_separator", said.index_separator, place)


def _unusable_channels(said: RecordingsSettings, above: Location, coordinate: Coordinate) -> Iterator[Wrong]:
    """Channels without a column, with an unknown unit, or too few of them; a clock or an encoding that is none."""
    channels, cells = said.channels, said.cells
    place: Location = (*above, "channels")
    if channels.displacement is None and channels.velocity is None:
        alone = f" ({ALONE})" if channels.acceleration is not None else ""
        yield place, f"channels has neither displacement nor velocity; map one of them{alone}"
    yield from _clock(channels.time, (*place, "time"), coordinate, None if cells is None else cells.time)
    for name in (*CHANNELS, *INPUTS, *BESIDE):
        one = getattr(channels, name, None)
        if one is None:
            continue
        yield from _unit(one.unit, name, (*place, name, "unit"), coordinate)
        given = (one.column is not None) + bool(one.columns)
        cell = getattr(cells, name, None)
        if cell is not None and given:
            yield (*place, name), _in_a_cell(name, "column" if one.columns is None else "columns", cell)
        elif given + (cell is not None) != 1:
            text = f"{name} has column {one.column!r} and columns {one.columns!r}; give exactly one of them"
            yield (*place, name), text
        if one.time is not None:
            yield from _clock(one.time, (*place, name, "time"), coordinate)
    if said.encoding is not None:
        try:
            codecs.lookup(said.encoding)
        except (LookupError, ValueError):
            text = f"encoding {said.encoding!r} is not known; write utf-8, utf-16, cp1252, shift_jis, ..."
            yield (*above, "encoding"), text
    yield from _separator("separator", said.separator, above)


def _separator(key: str, text: str, above: Location) -> Iterator[Wrong]:
    """A separator that no table can have."""
    if text not in ("auto", *SEPARATORS) and not is_separator(text):
        yield (*above, key), f"{key} is {text!r}; give one character, {', '.join(SEPARATORS)} or auto"


def _clock(time: TimeSettings, place: Location, coordinate: Coordinate, cell: int | None = None) -> Iterator[Wrong]:
    """A clock that has no rate and no column, or both, or a unit that is none of time."""
    yield from _unit(time.unit, "time", (*place, "unit"), coordinate)
    given = [key for key in ("column", "rate_hz") if getattr(time, key) is not None]
    if cell is not None and given:
        yield place, _in_a_cell("time", given[0], cell)
    elif len(given) + (cell is not None) != 1:
        yield place, f"time has column {time.column!r} and rate_hz {time.rate_hz!r}; give exactly one of them"
    if time.rate_hz is not None and not 1.0 / LARGEST < time.rate_hz < LARGEST:
        text = f"rate_hz is {time.rate_hz:g} Hz, which no logger has; give the samples that it records in a second"
        yield (*place, "rate_hz"), text


def _in_a_cell(name: str, key: str, cell: int) -> str:
    """That a channel of a cell array lies in its cell and takes no column."""
    return f"{name} has {key}, and recordings.cells says that it is cell {cell} of a trial; remove one of the two"


def _unit(unit: str, name: str, place: Location, coordinate: Coordinate) -> Iterator[Wrong]:
    """A unit that is not known or that the quantity cannot have."""
    try:
        factor_to_si(unit, name, coordinate)
    except RecordingError as error:
        yield place, str(error)
