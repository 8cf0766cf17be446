"""What a harmonic set's keys cannot say together: two drives or none, units of something else, keys of channels.

Belongs here: rules of `recordings.response`. Does not belong here: rules of channels (rules.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from undertow.campaign.config.response_settings import DRIVES, ResponseSettings, SweepSettings
from undertow.campaign.config.settings import Table
from undertow.campaign.config.source import Location, Wrong
from undertow.errors import RecordingError
from undertow.recording.recording import Coordinate
from undertow.recording.units import factor_to_si, phase_factor, rate_factor

if TYPE_CHECKING:
    from undertow.campaign.config.run_config import RunConfig

PLACE: Location = ("recordings", "response")


def response_wrong(config: RunConfig) -> Iterator[Wrong]:
    """Where and what is wrong with `recordings.response` and beside it; nothing where there is none."""
    said = config.recordings
    if said.response is None:
        return
    if "channels" in said.model_fields_set:
        text = "recordings has channels and response; a harmonic set has no channels in time: give one of the two"
        yield ("recordings", "channels"), text
    idle = {
        ("recordings", "layouts"): said.layouts, ("recordings", "cells"): said.cells,
        ("recordings", "despike"): said.despike, ("recordings", "accept"): said.accept,
        ("recordings", "releases"): said.releases,
        ("trials", "window"): config.trials.window != "auto", ("trials", "dry"): config.trials.dry,
    }  # fmt: skip
    for where, value in idle.items():
        if value:
            yield where, f"{'.'.join(where)} has no effect on a harmonic set (recordings.response); take it out"
    rule = config.trials.hold_out
    if rule != "auto" and not isinstance(rule, tuple):
        text = "trials.hold_out goes by amplitudes of releases; of a harmonic set give auto or a list of files"
        yield ("trials", "hold_out"), text
    yield from _drive(said.response)
    yield from _units(said.response, config.equation.coordinate)
    yield from _numbers(said.response)


def _drive(said: ResponseSettings) -> Iterator[Wrong]:
    """Not exactly one drive, a base without the motion's frame, a sweep that is said twice or not at all."""
    given = [name for name in DRIVES if getattr(said, name) is not None]
    if len(given) != 1:
        yield PLACE, f"response has the drives {', '.join(given) or 'none'}; give exactly one of {', '.join(DRIVES)}"
        return
    if given[0] != "force" and said.amplitude.frame is None:
        yield (*PLACE, "amplitude", "frame"), (
            f"amplitude has no frame, and the base moves ({given[0]}); say frame: absolute (against the earth) or "
            "relative (against the base)"
        )
    if isinstance(said.sweep, SweepSettings) and (said.sweep.column is None) == (said.sweep.by is None):
        text = f"sweep has column {said.sweep.column!r} and by {said.sweep.by!r}; give exactly one of them"
        yield (*PLACE, "sweep"), text
    for name in (given[0], "stderr"):
        one = getattr(said, name)
        if one is not None and (one.column is None) == (one.value is None):
            text = f"{name} has column {one.column!r} and value {one.value!r}; give exactly one of them"
            yield (*PLACE, name), text


def _units(said: ResponseSettings, coordinate: Coordinate) -> Iterator[Wrong]:
    """Units that are not known, or of another quantity."""
    for name in ("frequency", "amplitude", "phase", *DRIVES, "stderr"):
        one = getattr(said, name)
        if one is None:
            continue
        try:
            if name == "frequency":
                rate_factor(one.unit)
            elif name == "phase":
                phase_factor(one.unit)
            else:
                factor_to_si(one.unit, name if name in DRIVES else "displacement", coordinate)
        except RecordingError as error:
            yield (*PLACE, name, "unit"), f"response.{name}: {error}"


def _numbers(said: ResponseSettings) -> Iterator[Wrong]:
    """Drives and errors that are stated as zero or less."""
    for name in (*DRIVES, "stderr"):
        one = getattr(said, name)
        if one is None or one.value is None:
            continue
        for value in one.value.values.values() if isinstance(one.value, Table) else (one.value,):
            if not value > 0.0:
                text = f"{name} is {value:g} {one.unit}; an amplitude and an error are above zero"
                yield (*PLACE, name, "value"), text
