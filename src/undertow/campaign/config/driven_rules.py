"""What the keys of a driven campaign cannot ask for, which methods apply to it, and what it knows without using it.

Belongs here: rules of configs that map an input, or a harmonic set, beyond those of single channels. Does not belong
here: rules of channels (rules.py), of a harmonic set's own keys (response_rules.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from undertow.campaign.config.settings import Table
from undertow.campaign.config.source import Wrong

if TYPE_CHECKING:
    from undertow.campaign.config.run_config import RunConfig

IN_TIME = ("sindy", "output_error")
"""Methods that take a measured input."""
HARMONIC = ("output_error",)
"""Methods that take amplitudes and phases."""
FORCES = ("spring_force", "normal_force")


def methods_of(config: RunConfig) -> tuple[str, ...]:
    """Methods that a run uses: those that are named; where none are, all that apply to its trials."""
    said = config.recordings
    if not said.driven_by or "identify" in config.model_fields_set:
        return config.identify
    return IN_TIME if said.response is None else HARMONIC


def driven_wrong(config: RunConfig) -> Iterator[Wrong]:
    """Where and what a driven campaign is asked for that it does not do; nothing for decays."""
    said = config.recordings
    if not said.driven_by:
        return
    harmonic = said.response is not None
    kind, allowed = ("a harmonic set", HARMONIC) if harmonic else ("a driven body", IN_TIME)
    for at, name in enumerate(methods_of(config)):
        if name not in allowed:
            advice = f"give {', '.join(allowed)}, or leave identify out"
            yield ("identify", at), f"{name} does not apply to {kind}; {advice}"
    if config.discrepancy.budget != 1.0:
        text = f"discrepancy.budget has no effect on {kind}, whose search has no budget; take it out"
        yield ("discrepancy", "budget"), text
    if not harmonic:
        yield from _of_trials(config)
        yield from _by_condition(config)


def _of_trials(config: RunConfig) -> Iterator[Wrong]:
    """Groups, dry trials and rules for releases: all trials of a driven campaign are one fit."""
    together = "all trials of a driven campaign are fitted together, by one equation"
    if config.trials.group_by:
        text = f"trials.group_by is {', '.join(config.trials.group_by)}, but {together}; give each group a config"
        yield ("trials", "group_by"), text
    if config.trials.dry:
        text = f"trials.dry has no effect: {together}; take it out, and give a config each to dry and wet trials"
        yield ("trials", "dry"), text
    rule = config.trials.hold_out
    if rule != "auto" and not isinstance(rule, tuple):
        yield ("trials", "hold_out"), (
            "trials.hold_out goes by amplitudes of releases; of driven trials give auto (the last fifth of each) or a "
            "list of files"
        )


def _by_condition(config: RunConfig) -> Iterator[Wrong]:
    """Quantities of the specimen that differ from trial to trial."""
    for name in ("mass_kg", "stiffness_N_per_m", "submerged_volume_m3"):
        if isinstance(value := getattr(config.specimen, name), Table):
            rule = "but all trials of a driven campaign are one body; give a number"
            yield ("specimen", name), f"{name} goes by {value.by!r}, {rule}"


def unused(config: RunConfig, held: tuple[str, ...]) -> tuple[str, ...]:
    """Keys that say what is known or measured and that a driven run does not use; ``held`` are the numbers of the
    equation that the config fixes (`driven_laws`)."""
    known, channels = config.specimen, config.recordings.channels
    keys = [f"recordings.channels.{name}" for name in FORCES if getattr(channels, name) is not None]
    keys += [f"specimen.{name}" for name in ("area_m2", "cell") if getattr(known, name) is not None]
    if known.published:
        keys.append("specimen.published")
    if known.stiffness_N_per_m is not None and not any(name.startswith("stiffness.") for name in held):
        keys.append("specimen.stiffness_N_per_m")
    if known.submerged_volume_m3 is not None and not any(name.startswith("froude_krylov.") for name in held):
        keys.append("specimen.submerged_volume_m3")
    trials = config.trials
    if "hidden_at_release" in trials.model_fields_set and trials.hidden_at_release == "rest":
        keys.append("trials.hidden_at_release (the start of a hidden motion is fitted)")
    return tuple(keys)
