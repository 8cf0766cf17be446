"""Driven trials and laws as a config describes them.

Belongs here: from files and settings to `DrivenTrial` and `DrivenLaws`. Does not belong here: fits, the run folder.
"""

from __future__ import annotations

import glob
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.campaign.config.matching import planned
from undertow.campaign.config.recording_settings import InputSettings
from undertow.conditioning.driven import OUTPUTS, DrivenTrial
from undertow.conditioning.release import find_window
from undertow.conditioning.water import one_velocity
from undertow.equation.driven_laws import find_driven, places
from undertow.errors import FAILURES, ConfigError, RecordingError, failure
from undertow.likelihood.driven import DrivenLaws
from undertow.quantities import mover_of
from undertow.recording.catalogue import Entry, cut, read_trial
from undertow.recording.expressions import found_in
from undertow.recording.parts import UNCALIBRATED
from undertow.recording.patterns import patterns_of
from undertow.recording.recording import INPUTS, Array, Recording

SATURATED_SHARE = 0.05
"""Share of samples at an input's very largest or smallest value from which on it is said to be saturated."""


def is_driven(config: RunConfig) -> bool:
    """Whether the config maps an input."""
    return bool(config.recordings.channels.driven_by)


def input_settings(config: RunConfig) -> tuple[str, InputSettings]:
    """The input's quantity and settings; ConfigError where more than one is mapped (velocity and acceleration of the
    water are one)."""
    channels = config.recordings.channels
    mapped = [name for name in INPUTS if getattr(channels, name) is not None]
    if len(mapped) != 1 and mapped != ["water_velocity", "water_acceleration"]:
        have = ", ".join(mapped) or "none"
        raise ConfigError(
            f"channels has the inputs {have}; map exactly one of {', '.join(INPUTS)} (the last two may go together)"
        )
    return mapped[0], getattr(channels, mapped[0])


def driven_laws(config: RunConfig) -> DrivenLaws:
    """The config's terms, with the input's gain and delay where they are not exactly known, and the mass if it is.

    Where base or water moves, a known stiffness is held too, if no mass is known or an added mass is asked for; where
    the water moves, the mass of the displaced water is, if the specimen has its volume.
    """
    quantity, said = input_settings(config)
    priors: dict[str, tuple[float, float]] = {}
    fixed: dict[str, float] = {}
    if said.gain is not None and said.gain.stderr > 0.0:
        priors["input_gain"] = (1.0, said.gain.stderr / abs(said.gain.value))
    if said.delay_s is not None:
        if said.delay_s.stderr > 0.0:
            priors["input_delay_s"] = (said.delay_s.value, said.delay_s.stderr)
        else:
            fixed["input_delay_s"] = said.delay_s.value
    terms = tuple(find_driven(name) for name in config.equation.terms)
    mass, stiffness = config.specimen.mass_kg, config.specimen.stiffness_N_per_m
    if isinstance(mass, float | int):
        fixed["mass_kg"] = float(mass)
    spring = next((term for term in terms if term.is_spring), None)
    needed = "mass_kg" not in fixed or any(term.is_inertia for term in terms)
    if quantity != "force" and needed and spring is not None and isinstance(stiffness, float | int):
        fixed[f"{spring.name}.{spring.coefficient.name}"] = float(stiffness)
    volume = config.specimen.submerged_volume_m3
    if isinstance(volume, float | int):
        density = config.specimen.water_density_kg_per_m3
        held = (place for place in places(terms, mover_of(quantity)) if place.slots == ("wave",))
        fixed |= {place.name: density * float(volume) for place in held}
    return DrivenLaws(terms, fixed, {}, priors)


def driven_trials(config: RunConfig) -> tuple[tuple[DrivenTrial, ...], dict[str, str]]:
    """Every trial of the config that can be used, and trial -> reason of those that cannot."""
    catalogue, out, failed = config.catalogue(), list[DrivenTrial](), dict[str, str]()
    for entry in planned(config).entries:
        try:
            trial = trial_of(config, entry, cut(read_trial(entry, catalogue), entry.window))
            if not trial.free:
                must_drive(trial.name, trial.quantity, trial.u)
            out.append(trial)
        except ConfigError:
            raise
        except FAILURES as reason:
            failed[entry.name] = failure(reason)
    return tuple(out), failed


def trial_of(config: RunConfig, entry: Entry, recording: Recording) -> DrivenTrial:
    """One recording as a driven trial, or as a decay where the config says so; RecordingError where it is neither."""
    decays = patterns_of(config.trials.decays).fit(entry.name, str(entry.file))
    return (free_trial if decays else driven_trial)(config, recording)


def driven_trial(config: RunConfig, recording: Recording) -> DrivenTrial:
    """One recording as a driven trial: its input times the gain, what moved beside it.

    Raises RecordingError where the input is missing or never moves.
    """
    name, said = input_settings(config)
    lost = next((note for note in recording.notes if note.startswith(f"{name} ") and UNCALIBRATED not in note), "")
    if lost:
        raise RecordingError(
            f"trial {recording.name}: the input and the motion do not belong to the same instants: {lost}; give both "
            "one clock (channels.time, or one of the input's own), end trials.window where the input ends, or list a "
            "trial that nothing drives in trials.decays"
        )
    if name not in recording.channels:
        raise RecordingError(
            f"trial {recording.name}: the input {name} is not in its file; map its column, or list the trial in "
            "trials.decays if nothing drives it"
        )
    u = recording.channels[name] * (said.gain.value if said.gain is not None else 1.0)
    second = config.recordings.channels.water_acceleration
    if second is not None and name != "water_acceleration" and "water_acceleration" in recording.channels:
        rate = recording.channels["water_acceleration"] * (second.gain.value if second.gain is not None else 1.0)
        u = one_velocity(recording.name, recording.time, u, rate)
    outputs = {output: recording.channels[output] for output in OUTPUTS if output in recording.channels}
    return DrivenTrial(
        recording.name, recording.time, u, outputs, name, said.hold, recording.conditions,  # type: ignore[arg-type]
        _frames(config, outputs), recording.channels.get("instrument"),
    )  # fmt: skip


def free_trial(config: RunConfig, recording: Recording) -> DrivenTrial:
    """A decay of the same body from its release on, until it comes to rest: nothing drives it, whatever its file has
    for the input.

    Raises RecordingError where nothing is released.
    """
    name, said = input_settings(config)
    window = find_window(recording)
    inside = (recording.time >= window.start_s) & (recording.time <= window.end_s)
    outputs = {output: recording.channels[output][inside] for output in OUTPUTS if output in recording.channels}
    time = recording.time[inside]
    return DrivenTrial(
        recording.name, time, np.zeros(time.size), outputs, name, said.hold, recording.conditions,  # type: ignore[arg-type]
        _frames(config, outputs), free=True,
    )  # fmt: skip


def _frames(config: RunConfig, outputs: Iterable[str]) -> dict[str, Any]:
    """What the outputs are recorded against, where the config says it."""
    frames = {output: getattr(config.recordings.channels, output).frame for output in outputs}
    return {output: frame for output, frame in frames.items() if frame is not None}


def must_drive(trial: str, name: str, u: Array) -> None:
    """RecordingError where an input stays at one end of its range for long: saturated."""
    if np.unique(u[: min(u.size, 2000)]).size < 20:
        return  # a stepped input stays at its levels by design
    for value, end in ((float(np.max(u)), "largest"), (float(np.min(u)), "smallest")):
        share = float(np.mean(u == value))
        if share > SATURATED_SHARE:
            raise RecordingError(
                f"trial {trial}: {name} stands at its {end} value {value:g} in {100 * share:.0f} % of the samples; a "
                "saturated input does not show what drove the body: cut the window, or take the trial out"
            )


def recording_alone(config: RunConfig, file: Path) -> tuple[RunConfig, Entry]:
    """The config with this file in place of its recordings, and the file's entry. A name that is not made like those of
    the campaign has no conditions."""
    pattern = config.recordings.pattern
    if pattern is not None and found_in(pattern, (file.name,)).by_name == (None,):
        pattern = None
    one = config.recordings.model_copy(
        update={
            "files": glob.escape(str(file.absolute())), "index": None, "file": None, "index_column": "file",
            "exclude": (), "pattern": pattern, "releases": {},
        }
    )  # fmt: skip
    channels = one.channels.model_copy(update={"instrument": None})  # a free run asks for none
    one = one.model_copy(update={"channels": channels})
    trials = config.trials.model_copy(
        update={
            "window": "auto", "hold_out": "auto", "conditions": {}, "group_by": (), "dry": None,
            "decays": ("*",) if patterns_of(config.trials.decays).fit(file.stem, str(file)) else (),
        }
    )  # fmt: skip
    specimen = type(config.specimen)()  # what goes by conditions would match nothing here
    here = config.model_copy(update={"recordings": one, "trials": trials, "specimen": specimen})
    entries = planned(here).entries
    if len(entries) != 1:
        raise ConfigError(f"{file} holds {len(entries)} trials; give one recording")
    return here, entries[0]
