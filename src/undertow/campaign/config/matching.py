"""A config held against its list of trials before anything is read: what it names must be there.

A name, pattern, condition or key that matches nothing, or of several things only some, stops the run with a sentence
each; a trial that lacks a condition it is needed by fails alone.

Belongs here: `planned`, `unmatched`, `contradicted_headers`. Does not belong here: keys against each other (rules.py),
numbers of the specimen (specimen_rules.py), recordings (course.py).
"""

from __future__ import annotations

import contextlib
import difflib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from undertow.campaign.config.recording_settings import ChannelSettings
from undertow.campaign.config.run_config import GroupKey, RunConfig
from undertow.campaign.config.settings import LargestSettings
from undertow.campaign.config.situations import CLOSE, Situation, listed, nearest, situations, values_of
from undertow.campaign.config.source import Location, Wrong
from undertow.campaign.config.specimen_rules import impossible, location, tables
from undertow.errors import ConfigError, RecordingError
from undertow.recording.catalogue import Entry
from undertow.recording.conditions import same_condition, written
from undertow.recording.gather import listing
from undertow.recording.patterns import Patterns, patterns_of
from undertow.recording.propose import name_and_unit
from undertow.recording.readers import trial_name
from undertow.recording.recording import COORDINATES, Condition
from undertow.recording.units import factor_to_si

SENTENCES_AT_MOST = 20
"""Problems said at once; a list of a thousand wrong files is one mistake."""

Entries = Sequence[Entry]


@dataclass(frozen=True)
class Plan:
    """The trials that a run goes through, those that cannot be placed with their ``problem``; notes for its page."""

    entries: tuple[Entry, ...]
    notes: tuple[str, ...] = ()


def planned(config: RunConfig) -> Plan:
    """The list of trials of a config, which matches all that the config names.

    Raises ConfigError with a sentence a problem.
    """
    try:
        entries, excluded = listing(config.catalogue())
    except ConfigError as error:
        raise ConfigError(f"{config.place(_key_of(str(error)))}: {error}") from error
    wrong = unmatched(config, entries, excluded)
    if wrong:
        more = len(wrong) - SENTENCES_AT_MOST
        raise ConfigError("\n".join(wrong[:SENTENCES_AT_MOST] + [f"and {more} more problems"] * (more > 0)))
    needed = _needed(config)
    return Plan(tuple(_placeable(entry, needed) for entry in entries), _notes(config, entries))


def unmatched(config: RunConfig, entries: Entries, excluded: Entries = ()) -> list[str]:
    """A sentence for everything in the config that the list of trials does not have, with the config's line.

    ``excluded`` are the trials that ``recordings.exclude`` leaves out. What groups and specimen look like is said once
    all names match.
    """
    wrong = [*_patterns(config, entries, excluded), *_names(config, entries)]
    used = [*config.trials.group_by, *(config.trials.dry or {}), *(table.by for table in tables(config).values())]
    here, beside = situations(entries, used), situations(excluded, used)
    if not wrong:
        wrong = [*_dry(config, here, beside), *_keys(config, [*here, *beside]), *_spellings(config, here)]
    if not wrong:
        needed = _needed(config)
        complete = [one for one in here if all(name in one.conditions for name in needed)]
        wrong = [*_groups(config, complete), *_fitted(config, entries), *impossible(config, complete)]
    return [f"{config.place(where)}: {text}" for where, text in dict.fromkeys(wrong)]


def _key_of(sentence: str) -> Location:
    """The key that a sentence about the list of trials begins with."""
    found = re.match(r"recordings\.(\w+)", sentence)
    return ("recordings", found.group(1)) if found else ("recordings",)


def _patterns(config: RunConfig, entries: Entries, excluded: Entries) -> Iterator[Wrong]:
    """File name patterns that fit no trial."""
    said, trials = config.recordings, config.trials
    exclude, held = said.exclude, trials.hold_out if isinstance(trials.hold_out, tuple) else ()
    by_key: dict[tuple[str, str], Iterable[str]] = {
        ("recordings", "accept"): said.accept,
        ("recordings", "layouts"): said.layouts,
        ("recordings", "releases"): said.releases,
        ("trials", "window"): trials.window if isinstance(trials.window, Mapping) else (),
        ("trials", "conditions"): trials.conditions,
        ("trials", "decays"): trials.decays,
    }
    everything = [*entries, *excluded]
    for at in _unfitting(exclude, excluded):
        yield ("recordings", "exclude", exclude.index(at)), _fits_none("recordings.exclude", at, everything)
    for (section, key), patterns in by_key.items():
        for pattern in _unfitting(patterns, everything):
            place = patterns.index(pattern) if isinstance(patterns, tuple) else pattern
            yield (section, key, place), _fits_none(f"{section}.{key}", pattern, everything)
    for one in (missing := _unfitting(held, entries)):
        where = ("trials", "hold_out", held.index(one))
        if one in _unfitting(missing, excluded):
            yield where, _fits_none("trials.hold_out", one, entries)
        else:
            text = f"trials.hold_out names {one!r}, which recordings.exclude leaves out; take it out of one of them"
            yield where, text


def _unfitting(patterns: Iterable[str], entries: Entries) -> list[str]:
    """Those of the patterns that fit none of the entries."""
    asked, left = Patterns(patterns), dict.fromkeys(patterns)
    for entry in entries:
        if not left:
            break
        for pattern in asked.fitting(entry.name, str(entry.file)):
            left.pop(pattern, None)
    return list(left)


def _fits_none(key: str, pattern: str, entries: Entries) -> str:
    files = list(dict.fromkeys(entry.path.name if entry.whole_file else entry.name for entry in entries))
    near = nearest_name(pattern, files)
    return f"{key} names {pattern!r}, which fits none of {len(entries)} trials: {listed(files)}{near}"


def nearest_name(pattern: str, files: Sequence[str]) -> str:
    """The file whose stem is most like a pattern's, as the end of a sentence; a suffix that all share is no likeness.

    >>> nearest_name("*r4935.csv.gz", ["r4936a.csv.gz", "r4835.csv.gz"]), nearest_name("x.csv.gz", ["y.csv.gz"])
    ('; did you mean r4835.csv.gz?', '')
    """
    plain = re.sub(r"[*?\[\]]", "", pattern.rpartition("/")[2])
    by_stem = {trial_name(Path(file)): file for file in files}
    near = difflib.get_close_matches(trial_name(Path(plain)), by_stem, n=1, cutoff=CLOSE)
    return f"; did you mean {by_stem[near[0]]}?" if near else ""


def _names(config: RunConfig, entries: Entries) -> Iterator[Wrong]:
    """Conditions that no trial has."""
    have = sorted({name for entry in entries for name in entry.conditions})
    asked: list[tuple[Location, str, str]] = [
        *((("trials", "group_by", i), "trials.group_by names", name) for i, name in enumerate(config.trials.group_by)),
        *((("trials", "dry", name), "trials.dry names", name) for name in config.trials.dry or {}),
        *((location(q, "by"), f"specimen.{q} goes by", table.by) for q, table in tables(config).items()),
    ]
    for where, says, name in asked:
        if name not in have:
            near = nearest(name, have)
            yield where, f"{says} {name!r}, but no trial has such a condition; they have {listed(have)}{near}"


def _dry(config: RunConfig, here: Sequence[Situation], beside: Sequence[Situation]) -> Iterator[Wrong]:
    """Values of ``trials.dry`` that no trial has, one by one or together."""
    dry = config.trials.dry or {}
    alone = [name for name, value in dry.items() if not _occurs(here, name, value)]
    for name in alone:
        value = dry[name]
        said = f"trials.dry says {name} {written(value)}, but no trial has it"
        if _occurs(beside, name, value):
            yield ("trials", "dry", name), f"{said} but those that recordings.exclude leaves out; say dry: none"
        else:
            values = values_of([*here, *beside], name)
            yield ("trials", "dry", name), f"{said}; they have {listed(values)}{nearest(value, values)}"
    if dry and not alone and not any(config.is_dry(one.conditions) for one in here):
        together = " and ".join(f"{name} {written(value)}" for name, value in dry.items())
        yield ("trials", "dry"), f"trials.dry says {together}, but no trial has them together; correct it or say none"


def _occurs(here: Iterable[Situation], name: str, value: Condition) -> bool:
    return any(same_condition(one.conditions.get(name), value) for one in here)


def _keys(config: RunConfig, here: Sequence[Situation]) -> Iterator[Wrong]:
    """Keys of the specimen's tables that are no trial's condition."""
    for name, table in tables(config).items():
        values = values_of(here, table.by)
        for key in table.values:
            if not any(same_condition(key, value) for value in values):
                near = nearest(key, values)
                text = f"specimen.{name} has {table.by} {key}, but no trial has it; they have {listed(values)}{near}"
                yield location(name, key), text


def _groups(config: RunConfig, here: Sequence[Situation]) -> Iterator[Wrong]:
    """Groups of trials that are not alike: dry and wet together, or of different specimens."""
    groups: dict[GroupKey, list[Situation]] = {}
    for one in here:
        groups.setdefault(config.group_key(one.conditions), []).append(one)
    where: Location = ("trials", "group_by")
    for key, members in groups.items():
        label = Situation(dict(key)).at(dict(key))
        dry = [one for one in members if config.is_dry(one.conditions)]
        wet = [one for one in members if not config.is_dry(one.conditions)]
        if dry and wet:
            names = listed([n for n in config.trials.dry or {} if n not in config.trials.group_by])
            yield where, (
                f"trials.group_by puts the dry trial {dry[0].trials[0]} and the wet trial {wet[0].trials[0]} into one "
                f"group ({label}); add {names} to it"
            )
            continue
        for name, table in tables(config).items():
            first = members[0].conditions[table.by]
            keys = {table.key_of(one.conditions[table.by]) for one in members} if table.values else set()
            other = next((c for one in members if not same_condition(c := one.conditions[table.by], first)), None)
            if other is not None and (len({table.values.get(k or "") for k in keys}) > 1 or not table.values):
                yield where, (
                    f"specimen.{name} goes by {table.by}, which is {written(first)} and {written(other)} in one group "
                    f"({label}); add {table.by} to trials.group_by"
                )


def _spellings(config: RunConfig, here: Sequence[Situation]) -> Iterator[Wrong]:
    """Conditions that differ by capital letters or spaces alone: one group would become two."""
    for name in config.trials.group_by:
        by_letters: dict[str, list[Condition]] = {}
        for value in values_of(here, name):
            if isinstance(value, str):
                by_letters.setdefault("".join(value.casefold().split()), []).append(value)
        for first, *others in (values for values in by_letters.values() if len(values) > 1):
            rare = others[-1]
            trials = [trial for one in here if one.conditions.get(name) == rare for trial in one.trials]
            yield ("trials", "group_by"), (
                f"the condition {name} is {first!r} in some trials and {rare!r} in others ({listed(trials)}), which "
                "would make two groups of one; spell it alike in the index"
            )


def _fitted(config: RunConfig, entries: Entries) -> Iterator[Wrong]:
    """Groups that ``hold_out`` leaves without a trial to be fitted."""
    rule = config.trials.hold_out
    for label, names, held in _held(config, entries):
        if isinstance(rule, LargestSettings) and rule.largest >= len(names):
            said = f"trials.hold_out holds out the {rule.largest} largest"
        elif held == len(names):
            said = "trials.hold_out holds out all"
        else:
            continue
        yield ("trials", "hold_out"), (
            f"{said} of {len(names)} trials of the group {label} ({listed(names)}), which leaves none to be fitted; "
            "hold out fewer"
        )


def _held(config: RunConfig, entries: Entries) -> list[tuple[str, list[Condition], int]]:
    """Each group in words, its trials, and how many of them a list holds out; none where ``hold_out`` is a rule of
    amplitude that always leaves some."""
    rule = config.trials.hold_out
    if not isinstance(rule, tuple | LargestSettings):
        return []
    listed_trials = patterns_of(rule) if isinstance(rule, tuple) else Patterns(())
    groups: dict[GroupKey, tuple[str, list[Condition], int]] = {}
    for entry in entries:
        if any(name not in entry.conditions for name in config.trials.group_by):
            continue
        key = config.group_key(entry.conditions)
        label, names, held = groups.get(key, (Situation(dict(key)).at(dict(key)), [], 0))
        names.append(entry.name)
        groups[key] = (label, names, held + listed_trials.fit(entry.name, str(entry.file)))
    return list(groups.values())


def _notes(config: RunConfig, entries: Entries) -> tuple[str, ...]:
    """That a list of held-out trials has none of some groups."""
    if not isinstance(config.trials.hold_out, tuple):
        return ()
    groups = _held(config, entries)
    without = [label for label, _, held in groups if not held]
    if not without or len(without) == len(groups):
        return ()
    return (
        f"trials.hold_out names no trial of {len(without)} of {len(groups)} groups ({'; '.join(without[:8])}"
        f"{'; ...' if len(without) > 8 else ''}): what is found in them is not proved on an unseen trial",
    )


def _needed(config: RunConfig) -> dict[str, str]:
    """Conditions that every trial must have, each with the key that needs it."""
    needed = {table.by: f"specimen.{name}" for name, table in tables(config).items()}
    return needed | dict.fromkeys(config.trials.group_by, "trials.group_by")


def _placeable(entry: Entry, needed: Mapping[str, str]) -> Entry:
    """The entry, with a problem where it lacks a condition that it is grouped or looked up by."""
    lacks = next((name for name in needed if name not in entry.conditions), None)
    if lacks is None or entry.problem:
        return entry
    return replace(entry, problem=(
        f"it has no condition {lacks!r}, by which {needed[lacks]} goes; it has {listed(list(entry.conditions))}: fill "
        "its cell in the index, or give it in trials.conditions"
    ))  # fmt: skip


def contradicted_headers(config: RunConfig) -> tuple[str, ...]:
    """The doubts about columns whose own name has another unit than the config says."""
    said = []
    for name, channel in config.recordings.channels:
        for column in (channel.column, *(channel.columns or ())) if isinstance(channel, ChannelSettings) else ():
            written_unit = name_and_unit(column)[1] if isinstance(column, str) else ""
            sizes = {unit: _size_of(unit, name) for unit in (written_unit, channel.unit)}
            if len(sizes) == 2 and None not in sizes.values() and len(set(sizes.values())) == 2:
                said.append(
                    f"recordings.channels.{name}.unit is {channel.unit}, and the name of column {column!r} says "
                    f"{written_unit}: correct the unit, unless the name is wrong"
                )
    return tuple(said)


def _size_of(unit: str, channel: str) -> float | None:
    """A unit in SI, in translation or rotation; None where it is none of this channel."""
    for coordinate in COORDINATES:
        with contextlib.suppress(RecordingError):
            return factor_to_si(unit, channel, coordinate)[0]
    return None
