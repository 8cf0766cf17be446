"""What is known of a rig, as keyword arguments, turned into the config that a campaign runs with.

Belongs here: that translation and its errors. Does not belong here: what the keys mean (campaign/config).
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from os import PathLike, fspath
from pathlib import Path
from typing import Any, TypedDict

from pydantic import ValidationError

from undertow.campaign.config import RunConfig
from undertow.campaign.config.rules import contradictions
from undertow.campaign.config.source import OF_SEVERAL, kinds, listed_keys, properties
from undertow.equation.equation import Equation
from undertow.equation.registry import find, twice
from undertow.equation.term import Term
from undertow.errors import ConfigError, UndertowError, shown
from undertow.recording.doubt_kinds import DoubtKind
from undertow.recording.recording import Coordinate

SCATTER = ("specimen", "scatter")
"""Where a config has the scatter from trial to trial."""

DRIVEN = "a body that an input drives is fitted by undertow.fit_driven(x, t=..., u=...)"
"""Where an input belongs."""

Known = float | Mapping[str, str | float]
"""A number, or a table by a condition as configs have them: {"by": "water_depth_m", "2.36": 0.97}."""


class Rig(TypedDict, total=False):
    """What the laboratory knows of its rig; every entry is optional, in the unit that its name ends in.

    ``mass_kg`` all that moves when dry; ``stiffness_N_per_m`` the stated spring; ``area_m2`` the drag area, for C_d;
    ``submerged_volume_m3`` for the normal force that friction goes with; ``water_density_kg_per_m3`` (1000) and
    ``gravity_m_per_s2`` (9.81). In rotation a mass is an inertia (kg m^2) and a stiffness a moment a radian.
    """

    mass_kg: Known
    stiffness_N_per_m: Known
    area_m2: Known
    submerged_volume_m3: Known
    water_density_kg_per_m3: float
    gravity_m_per_s2: float


class ReadSettings(TypedDict, total=False):
    """What `undertow.read` takes beside columns, units and t; it says there what each is."""

    conditions: Any
    rate_hz: float | None
    coordinate: Coordinate | None
    window: Any
    releases: Any
    names: Sequence[str] | None
    accept: Sequence[DoubtKind]
    variable: str | None


class RigAndRead(Rig, ReadSettings):
    """What is known of a rig, and how its recordings are read."""


def parted(given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """What belongs to `ReadSettings`, and the rest, which is the rig's.

    >>> parted({"mass_kg": 4.0, "rate_hz": 100.0})
    ({'rate_hz': 100.0}, {'mass_kg': 4.0})
    """
    reading = {key: value for key, value in given.items() if key in ReadSettings.__annotations__}
    return reading, {key: value for key, value in given.items() if key not in reading}


def terms_of(equation: Sequence[str | Term] | Equation) -> tuple[Term, ...]:
    """The terms of an equation given by names, terms or an `Equation`; ConfigError for an unknown name, one that
    stands there twice, or none.

    >>> [term.name for term in terms_of(["stiffness", "viscous_damping"])]
    ['stiffness', 'viscous_damping']
    """
    terms = named_terms(equation, find)
    if doubled := twice(terms):
        raise ConfigError(f"equation names {doubled!r} twice; take one of them out, or rename your own")
    if not terms:
        raise ConfigError(f"equation has {len(terms)} terms; name some, as in ['stiffness', 'viscous_damping']")
    return terms


def named_terms(equation: Sequence[str | Term] | Equation, look_up: Callable[[str], Term]) -> tuple[Term, ...]:
    """The terms of an equation by names, terms or an `Equation`, found by ``look_up``; ConfigError where it is none of
    these."""
    if isinstance(equation, Equation):
        return equation.terms
    if isinstance(equation, Mapping):
        names = [one if isinstance(one, str) else type(one).__name__ for one in equation]
        raise ConfigError(
            f"equation gives numbers of {', '.join(names)}, and a fit finds them; give the names alone, as in {names}"
        )
    if isinstance(equation, (str, Term)) or not isinstance(equation, Iterable):
        raise ConfigError(f"equation is the single {shown(equation)}; give a list of names, as in ['stiffness', ...]")
    terms = tuple(look_up(one) if isinstance(one, str) else one for one in equation)
    for one in terms:
        if not isinstance(one, Term):
            raise ConfigError(
                f"equation holds {shown(one)}, of type {type(one).__name__}; a law is a name, or an object of a class "
                "of your own that is a Term (docs/python_front.md)"
            )
    return terms


def place_of(said: object, what: str) -> Path:
    """A path that was given as ``what``; ConfigError where it is none."""
    if isinstance(said, (str, PathLike)):
        return Path(fspath(said))
    raise ConfigError(f"{what} is {shown(said)}, of type {type(said).__name__}; give a path, as in 'runs/flume'")


def with_settings(config: RunConfig, changes: Mapping[str, Mapping[str, Any]], seed: Any = None) -> RunConfig:
    """The config with keys of its sections, and its seed, replaced (None: left as they are), checked as a whole.

    Raises ConfigError with one sentence a problem.
    """
    data = config.model_dump(mode="json", exclude_none=True)
    for section, keys in changes.items():
        said = {key: _plain(value) for key, value in keys.items() if value is not None}
        data[section] = {**data.get(section, {}), **said}
    data |= {} if seed is None else {"seed": _plain(seed)}
    return checked(data, config)


def checked(data: Mapping[str, Any], origin: RunConfig | None = None) -> RunConfig:
    """A config from plain values; its folder and file are those of ``origin``."""
    try:
        config = RunConfig.model_validate(data)
    except ValidationError as error:
        raise ConfigError("\n".join(_sentence(one) for one in error.errors(include_url=False))) from error
    if origin is not None:
        config._folder = origin.folder
    wrong = [text for _, text in contradictions(config)]
    if wrong:
        raise ConfigError("\n".join(wrong))
    return config


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple, set)):
        return [_plain(one) for one in value]
    return value


def _of_scatter(error: Any) -> str:
    """What ``scatter`` may have, where that is wrong; empty where another setting is."""
    location = tuple(map(str, error["loc"]))
    if location[:2] != SCATTER or error["type"] not in ("extra_forbidden", "model_type", "dict_type"):
        return ""
    keys = listed_keys(properties(RunConfig.model_json_schema(), SCATTER))
    wrong = f"names {location[2]!r}" if len(location) > len(SCATTER) else f"is {shown(error['input'])}"
    return f"scatter {wrong}; give a mapping, as in {{\"k\": 0.004}}, which may have {keys}"


def _sentence(error: Any) -> str:
    if said := _of_scatter(error):
        return said
    if error["type"] == "extra_forbidden":
        key = str(error["loc"][-1])
        near = difflib.get_close_matches(key, Rig.__annotations__, n=1, cutoff=0.4)
        hint = f"did you mean {near[0]!r}?" if near else f"of a rig may be said {', '.join(Rig.__annotations__)}"
        hint = DRIVEN if key == "u" else hint
        return f"{key} is {shown(error['input'])}, but nothing is called so; {hint}"
    names = [str(part) for part in error["loc"] if part not in ("number", "table", "auto", "list", "all")]
    rule = error["msg"].removeprefix("Value error, ").removeprefix("Input ")
    if error["type"] in OF_SEVERAL and (allowed := kinds(RunConfig.model_json_schema(), tuple(names))):
        rule = f"should be {allowed}"
    what = ".".join(names[1:] or names) or "the settings"
    return f"{what} is {shown(error['input'])} but {rule}"


def group_specimen(config: RunConfig, conditions: Sequence[Mapping[str, Any]]) -> Any:
    """The one specimen of trials with these conditions; UndertowError where they differ in what is known of them."""
    found = [config.specimen_for(one) for one in conditions]
    different = [one for one in found if repr(one) != repr(found[0])]
    if different:
        pairs = zip(asdict(found[0]).items(), asdict(different[0]).values(), strict=True)
        said = ", ".join(f"{name} {one} and {other}" for (name, one), other in pairs if repr(one) != repr(other))
        raise UndertowError(
            f"what is known of the rig differs between the {len(found)} trials ({said}); fit trials of one water and "
            "spring at a time: trials.where(...)"
        )
    return found[0]
