"""Every recording of a folder looked at, and those that are read alike put together.

Belongs here: which files there are and how each is read. Does not belong here: conditions (names.py), the config's text
(draft.py).
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from glob import escape
from pathlib import Path

from undertow.campaign.inspection import what_lacks
from undertow.campaign.starting.indexed import Indexed, find_index
from undertow.discrepancy.words import count
from undertow.errors import ConfigError, RecordingError
from undertow.recording.channels import ChannelSpec, TimeSpec
from undertow.recording.layout import FileFormat
from undertow.recording.links import refused
from undertow.recording.patterns import Patterns
from undertow.recording.propose import Proposal, strange_unit
from undertow.recording.propose_file import propose_file
from undertow.recording.propose_layout import NO_TABLE
from undertow.recording.propose_response import ResponseProposal
from undertow.recording.readers import READERS, never_read, suffix_of, trial_name
from undertow.recording.recording import Coordinate
from undertow.recording.run_files import is_of_a_run
from undertow.recording.stacked import stacked

Looked = Callable[[int, int], None]
"""Called with the files looked at and their number."""


@dataclass(frozen=True)
class Reading:
    """How files are read: layout, time, channels by name, coordinate."""

    layout: FileFormat
    time: TimeSpec
    channels: tuple[tuple[str, ChannelSpec], ...]
    coordinate: Coordinate


@dataclass(frozen=True)
class Alike:
    """Files that are read alike, as paths from the folder, and the pattern (or the names) that fits them alone."""

    reading: Reading
    files: tuple[str, ...]
    patterns: tuple[str, ...] = ()


@dataclass(frozen=True)
class Survey:
    """What a folder holds: groups of files that are read alike, the largest first; files that cannot be read or do not
    belong to the others, with the reason; what was guessed; harmonic sets, where it holds no recording in time; and of
    the guesses those without which every number may be wrong (``doubts``); the folder's own ``index``, where it has
    one: then no recording counts that this does not list; ``parts`` are those of the unread that hold a time and
    channels, and not where the body is (a trial's other sensors), with the doubts of each."""

    groups: tuple[Alike, ...]
    unread: tuple[tuple[str, str], ...]
    remarks: tuple[str, ...]
    sets: tuple[tuple[str, FileFormat, ResponseProposal], ...] = ()
    doubts: tuple[str, ...] = ()
    index: Indexed | None = None
    parts: Mapping[str, Reading] = field(default_factory=dict)
    doubts_of_parts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def files(self) -> tuple[str, ...]:
        """All that can be read, in order."""
        return tuple(sorted(name for group in self.groups for name in group.files))


def survey(folder: Path, looked: Looked = lambda done, of: None) -> Survey:
    """Look at every file of a folder and of those below it that has the suffix of a recording.

    Raises ConfigError where there is no such folder or none of its files can be read as a recording.
    """
    every = _files(folder)
    files = [name for name in every if suffix_of(Path(name)) in READERS]
    index = find_index(folder, files)
    found: dict[Reading, list[str]] = {}
    unread = [(name, why) for name in every if (why := never_read(Path(name)))]
    remarks: Counter[str] = Counter()
    doubts: Counter[str] = Counter()
    lacks: dict[str, str] = {}
    sets: list[tuple[str, FileFormat, ResponseProposal]] = []
    parts: dict[str, tuple[Reading, tuple[str, ...]]] = {}
    for done, name in enumerate(files):
        looked(done, len(files))
        if index is not None and name not in index.listed:
            unread += [(name, f"is not in the index {index.name}")] if name != index.name else []
            continue
        if index is not None and name in index.lacking:
            unread.append((name, index.lacking[name]))
            continue
        if link := refused(folder / name, folder):
            unread.append((name, f"is {link}"))
            continue
        try:
            seen = propose_file(folder / name)
        except RecordingError as error:
            unread.append((name, str(error).removeprefix(f"{folder / name}").lstrip(": ")))
            continue
        if seen.response is not None:
            sets.append((name, seen.layout, seen.response))
            continue
        if not seen.complete or seen.proposal.time is None:
            strange = strange_unit(seen.table)
            unread.append((name, strange or "no column is named like a displacement or velocity and one like time"))
            lacks[name] = "" if strange else what_lacks(folder / name, seen.table, seen.layout, seen.proposal)
            if seen.proposal.time is not None and seen.proposal.channels:
                parts[name] = _reading(seen.layout, seen.proposal.time, seen.proposal), seen.proposal.doubts
            continue
        clock = seen.proposal.time.column
        if clock is not None and (several := stacked(seen.table, clock)):
            unread.append((name, several))
            continue
        one = _reading(seen.layout, seen.proposal.time, seen.proposal)
        found.setdefault(one, []).append(name)
        remarks.update(seen.proposal.remarks)
        doubts.update(seen.proposal.doubts)
    looked(len(files), len(files))
    if not found and sets:
        return Survey((), tuple(unread), (), tuple(sets))
    unread += [(name, "is a harmonic set, and needs a config of its own (recordings.response)") for name, _, _ in sets]
    if not found:
        first = "; ".join(f"{name}: {why}" for name, why in _blamed(unread, lacks))
        if not every:
            raise ConfigError(f"{folder} holds no file with the suffix of a recording, as .csv, .txt, .mat, .xlsx")
        looked_at = f"{count(len(every), 'file')} looked at"
        raise ConfigError(f"no file in {folder} can be read as a recording ({looked_at}); {first}")
    return replace(
        _sorted_out(found, unread, tuple(remarks)), doubts=tuple(doubts), index=index,
        parts={name: reading for name, (reading, _) in parts.items()},
        doubts_of_parts={name: doubted for name, (_, doubted) in parts.items()},
    )  # fmt: skip


def _reading(layout: FileFormat, time: TimeSpec, proposal: Proposal) -> Reading:
    return Reading(layout, time, tuple(proposal.channels.items()), proposal.coordinate)


def _blamed(unread: Sequence[tuple[str, str]], lacks: Mapping[str, str]) -> list[tuple[str, str]]:
    """The file to begin with and why it is not read: one with a table where there is any, not a text without one."""
    first = sorted(unread, key=lambda one: (one[0] not in lacks, NO_TABLE in one[1]))[:1]
    return [(name, f"{why}; {lacks[name]}" if lacks.get(name) else why) for name, why in first]


def _files(folder: Path) -> list[str]:
    """Files with the suffix of a recording, or of what is never read, as paths from the folder; hidden ones and run
    folders left out."""
    if not folder.is_dir():
        raise ConfigError(f"{folder} is no folder; give the one that holds the recordings")
    names = []
    for above, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith(".") and name != "runs")
        names += [
            (Path(above) / name).relative_to(folder).as_posix()
            for name in sorted(files)
            if not name.startswith((".", "~$")) and (suffix_of(Path(name)) in READERS or never_read(Path(name)))
            and not is_of_a_run(str(Path(above) / name))
        ]
    return names


def _sorted_out(found: dict[Reading, list[str]], unread: Sequence[tuple[str, str]], remarks: tuple[str, ...]) -> Survey:
    """Groups with their patterns; those of another coordinate than most files are left out."""
    counts = Counter[Coordinate]()
    for reading, names in found.items():
        counts[reading.coordinate] += len(names)
    coordinate = counts.most_common(1)[0][0]
    others = [
        (name, f"it is a {reading.coordinate} and most files are a {coordinate}: it needs a config of its own")
        for reading, names in found.items()
        for name in names
        if reading.coordinate != coordinate
    ]
    kept = {reading: names for reading, names in found.items() if reading.coordinate == coordinate}
    everything = [name for names in kept.values() for name in names]
    groups = [Alike(reading, tuple(names), _patterns(names, everything)) for reading, names in kept.items()]
    groups.sort(key=lambda group: (-len(group.files), group.files))
    return Survey(tuple(groups), tuple(sorted([*unread, *others])), remarks)


def _patterns(names: Sequence[str], everything: Sequence[str]) -> tuple[str, ...]:
    """One pattern that fits these files alone, else each of them by its name."""
    bases = [name.rpartition("/")[2] for name in names]
    prefix = os.path.commonprefix(bases)  # noqa: RUF071 - of names, letter by letter
    suffixes, folders = {suffix_of(Path(base)) for base in bases}, {name.rpartition("/")[0] for name in names}
    candidates = [f"*{suffix}" for suffix in suffixes] if len(suffixes) == 1 else []
    candidates += [f"{escape(folder)}/*" for folder in folders] if len(folders) == 1 and "" not in folders else []
    if prefix and len(names) > 1:
        candidates += [f"{escape(prefix)}*", *(f"{escape(prefix)}*{suffix}" for suffix in sorted(suffixes)[:1])]
    for pattern in candidates:
        one = Patterns([pattern])
        if sorted(name for name in everything if one.fit(trial_name(Path(name)), name)) == sorted(names):
            return (pattern,)
    return tuple(escape(name) for name in names)
