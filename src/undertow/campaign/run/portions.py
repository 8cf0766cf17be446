"""Which trials are read, analysed and judged at a time: a portion is what a run holds in memory at once.

Groups of one water are judged together, so that a portion holds whole waters; only a water of more than
`TRIALS_AT_ONCE` trials is divided, between its groups. Dry trials come first: what they say is needed by all others.

Belongs here: that division, from names and conditions alone. Does not belong here: reading (course.py).
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from undertow.campaign.config import GroupKey, RunConfig
from undertow.recording.catalogue import Entry
from undertow.recording.recording import Condition

TRIALS_AT_ONCE = 256
"""Trials of a portion: enough to keep some processes busy, and 50 MB of motions of 500 samples."""

BYTES_AT_ONCE = 64 * 2**20
"""Size of a portion's files: motions take some ten times what their recordings take on disk."""


@dataclass(frozen=True)
class Portion:
    """Trials that are read, analysed and judged together, and how many groups and waters they are.

    ``divided`` is the number of groups of the water of which this portion is only a part, else 0.
    """

    entries: tuple[Entry, ...]
    groups: int
    waters: int
    divided: int = 0

    @property
    def size(self) -> int:
        """How many trials."""
        return len(self.entries)


Groups = Mapping[GroupKey, Sequence[Entry]]


def group_order(key: Iterable[tuple[str, Condition]], dry: bool) -> tuple[object, ...]:
    """What groups are sorted by: dry ones first, then numbers before texts, condition by condition.

    >>> sorted([2.36, "long", 1.63], key=lambda value: group_order([("level", value)], False))
    [1.63, 2.36, 'long']
    """
    return (not dry, *((isinstance(v, str), str(v) if isinstance(v, str) else f"{v:020.6f}") for _, v in key))


def portions(config: RunConfig, entries: Sequence[Entry], at_once: int = TRIALS_AT_ONCE) -> tuple[Portion, ...]:
    """The trials in portions of at most ``at_once`` (and `BYTES_AT_ONCE`), unless one group has more.

    The first holds the dry trials and those whose group is not known; a campaign that fits is one, in its own order.
    """
    groups, unplaced = _by_group(config, entries)
    dry = {key for key, members in groups.items() if any(config.is_dry(e.conditions) for e in members)}
    ordered = sorted(groups, key=lambda key: group_order(key, key in dry))
    waters: dict[tuple[Condition, ...], list[GroupKey]] = {}
    for key in ordered:
        if key not in dry:
            waters.setdefault(_water(config, key), []).append(key)
    if len(entries) <= at_once and _bytes(entries) <= BYTES_AT_ONCE:
        return (Portion(tuple(entries), len(groups), len(waters)),)
    first = [*unplaced, *(e for key in ordered if key in dry for e in groups[key])]
    out = [Portion(tuple(first), len(dry), 0)] if first else []
    pieces = [piece for keys in waters.values() for piece in _pieces(keys, groups, at_once)]
    return (*out, *_filled(pieces, at_once))


def _by_group(config: RunConfig, entries: Sequence[Entry]) -> tuple[dict[GroupKey, list[Entry]], list[Entry]]:
    """Entries by group, and those that lack a condition to be grouped by (reading them says what is wrong)."""
    groups: dict[GroupKey, list[Entry]] = {}
    unplaced = []
    for entry in entries:
        if all(column in entry.conditions for column in config.trials.group_by):
            groups.setdefault(config.group_key(entry.conditions), []).append(entry)
        else:
            unplaced.append(entry)
    return groups, unplaced


def _water(config: RunConfig, key: GroupKey) -> tuple[Condition, ...]:
    """What groups that may be judged together share; a group for itself where the config knows no dry trials."""
    fixed = config.trials.dry or {}
    return tuple(value for name, value in key if name in fixed or not fixed)


def _pieces(keys: Sequence[GroupKey], groups: Groups, at_once: int) -> list[Portion]:
    """One water, whole where it fits, else in runs of its groups."""
    if sum(len(groups[key]) for key in keys) <= at_once:
        return [Portion(tuple(e for key in keys for e in groups[key]), len(keys), 1)]
    divided = len(keys) if len(keys) > 1 else 0
    runs: list[list[GroupKey]] = []
    held = 0
    for key in keys:
        if not runs or held + len(groups[key]) > at_once:
            runs.append([])
            held = 0
        runs[-1].append(key)
        held += len(groups[key])
    return [Portion(tuple(e for key in run for e in groups[key]), len(run), 1, divided) for run in runs]


def _filled(pieces: Sequence[Portion], at_once: int) -> list[Portion]:
    """Neighbouring pieces together, as many as a portion holds; a part of a divided water stays by itself."""
    out: list[Portion] = []
    held = 0
    for piece in pieces:
        size = _bytes(piece.entries)
        last = out[-1] if out else None
        fits = last is not None and last.size + piece.size <= at_once and held + size <= BYTES_AT_ONCE
        if last is not None and fits and not last.divided and not piece.divided:
            entries = (*last.entries, *piece.entries)
            out[-1] = Portion(entries, last.groups + piece.groups, last.waters + piece.waters)
            held += size
        else:
            out.append(piece)
            held = size
    return out


def _bytes(entries: Iterable[Entry]) -> int:
    """Size of the entries' files on disk; a file that is not there has none."""
    total = 0
    for entry in entries:
        try:
            total += os.stat(entry.file).st_size
        except OSError:
            continue  # reading it says why
    return total
